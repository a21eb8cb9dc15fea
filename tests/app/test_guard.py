"""The server answers its own pages only."""

import re

import pytest
from numba.core import event
from starlette.testclient import TestClient

from latolato.app.files import STATIC
from latolato.app.serve import serve
from latolato.app.server import MOST_BODY, Settings, make_app

HOME = "http://127.0.0.1:8000"


@pytest.fixture
def client():
    with TestClient(make_app(Settings()), base_url=HOME) as found:
        yield found


def test_the_page_comes_with_a_strict_policy(client):
    answer = client.get("/")
    assert answer.status_code == 200
    policy = answer.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    assert "<script>" not in answer.text
    assert not re.search(r"\son\w+=", answer.text)


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1:9999", "", "127.0.0.1"])
def test_another_name_of_the_server_is_refused(client, host):
    assert client.get("/", headers={"host": host}).status_code == 403


@pytest.mark.parametrize(
    "headers", [{"origin": "http://evil.example"}, {"sec-fetch-site": "cross-site"}]
)
def test_a_page_of_another_site_is_refused(client, headers):
    answer = client.post("/api/run", json={"scenario": "zeno"}, headers=headers)
    assert answer.status_code == 403


def test_the_token_is_needed_and_then_kept_in_a_cookie():
    app = make_app(Settings(token="secret"))
    with TestClient(app, base_url=HOME) as client:
        assert client.get("/").status_code == 403
        assert client.get("/?token=guess").status_code == 403
        assert client.get("/?token=secret").status_code == 200
        assert client.get("/api/registry").status_code == 200


def test_an_address_that_others_reach_needs_a_flag():
    with pytest.raises(ValueError, match="--allow-others"):
        serve("0.0.0.0", 0, browser=False)


@pytest.mark.parametrize(
    "path", ["/static/../server.py", "/static/%2e%2e/server.py", "/static/..%2fserver.py", "/x"]
)
def test_nothing_but_the_pages_is_served(client, path):
    assert client.get(path).status_code == 404


@pytest.mark.parametrize("path", ["/static/", "/static//etc/passwd", "/static/js", "/static/%00"])
def test_no_other_path_leads_to_a_file(client, path):
    assert client.get(path).status_code == 404


def test_every_file_of_the_pages_is_served_with_its_type(client):
    types = {".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}
    paths = [p for p in STATIC.rglob("*") if p.is_file()]
    assert len(paths) > 50
    for path in paths:
        answer = client.get(f"/static/{path.relative_to(STATIC).as_posix()}")
        assert answer.content == path.read_bytes()
        if path.suffix in types:
            assert answer.headers["content-type"].split(";")[0] == types[path.suffix]


def test_what_a_page_has_already_is_not_sent_again(client):
    first = client.get("/static/app.css")
    again = client.get("/static/app.css", headers={"if-none-match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    other = client.get("/static/icon.svg", headers={"if-none-match": first.headers["etag"]})
    assert other.status_code == 200


@pytest.mark.parametrize(
    "body, status",
    [
        (b"", 400),
        (b"{", 400),
        (b"[" * 100_000, 400),
        (b"[]", 422),
        (b'{"scenario": 3}', 422),
        (b'{"options": []}', 422),
        (b'{"options": {"length": {}}}', 422),
        (b'{"scenario": "zeno", "columns": [1]}', 422),
        (b'{"scenario": "zeno", "columns": ["mass"]}', 422),
        (b'{"scenario": "zeno", "samples": "many"}', 422),
        (b'{"scenario": "zeno", "samples": 1000000000}', 413),
        (b'{"scenario": "fig05"}', 422),
        (b"x" * (MOST_BODY + 1), 413),
    ],
)
def test_a_bad_request_is_refused_with_one_line(client, body, status):
    answer = client.post("/api/run", content=body)
    assert answer.status_code == status
    assert answer.json()["error"]
    assert "\n" not in answer.json()["error"]


def test_a_message_names_the_field_that_it_is_about(client):
    answer = client.post("/api/run", json={"scenario": "zeno", "options": {"radius": "2 m"}})
    assert answer.status_code == 422
    assert answer.json()["field"] == "radius"


def test_the_server_says_while_a_kernel_is_compiled(client):
    def told():
        return client.get("/api/compiling").json()

    assert told() == {"compiling": False}
    with event.trigger_event("numba:compile"), event.trigger_event("numba:compile"):
        assert told() == {"compiling": True}
    assert told() == {"compiling": False}
