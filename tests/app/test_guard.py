"""The server answers its own pages only."""

import re

import httpx2
import pytest
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from latolato.app.answers import MOST_BODY
from latolato.app.pages import STATIC
from latolato.app.server import Settings, make_app

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
    assert "unsafe" not in policy.replace("'wasm-unsafe-eval'", "")
    assert "<script>" not in answer.text
    assert not re.search(r"\son\w+=", answer.text)


@pytest.mark.parametrize(
    "headers", [{"origin": "http://evil.example"}, {"sec-fetch-site": "cross-site"}]
)
def test_a_page_of_another_site_is_refused(client, headers):
    answer = client.post("/api/run", json={"scenario": "zeno"}, headers=headers)
    assert answer.status_code == 403


@pytest.mark.parametrize("host", ["127.0.0.1", "LocalHost:8000"])
def test_names_of_this_machine_are_known(client, host):
    headers = {"host": host, "origin": f"http://{host}"}
    assert client.get("/", headers=headers).status_code == 200


UNKNOWN = [
    *({"host": host} for host in (
        "", "evil.example", "evil.localhost:8000", "localhost:8000@evil.example"
    )),
    *({"origin": origin} for origin in ("null", "http://127.0.0.1:8000.evil.example")),
]  # fmt: skip


@pytest.mark.parametrize("headers", UNKNOWN)
def test_no_other_host_or_origin_is_known(client, headers):
    status = 400 if "host" in headers else 403
    assert client.get("/", headers=headers).status_code == status
    with (
        pytest.raises(WebSocketDisconnect),
        client.websocket_connect("/ws/map/file", headers=headers),
    ):
        pass


def test_the_printed_link_works(server):
    assert httpx2.get(server.address, timeout=60).status_code == 200


@pytest.mark.parametrize("path", ["/../server.py", "/..%2fserver.py", "//etc/passwd", "/js", "/x"])
def test_nothing_but_the_pages_is_served(client, path):
    assert client.get(path).status_code == 404


def test_every_file_of_the_pages_is_served_with_its_type(client):
    types = {".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml"}
    paths = [p for p in STATIC.rglob("*") if p.is_file()]
    assert len(paths) > 50
    for path in paths:
        answer = client.get(f"/{path.relative_to(STATIC).as_posix()}")
        assert answer.content == path.read_bytes()
        if path.suffix in types:
            assert answer.headers["content-type"].split(";")[0] == types[path.suffix]


def test_what_a_page_has_already_is_not_sent_again(client):
    first = client.get("/app.css")
    again = client.get("/app.css", headers={"if-none-match": first.headers["etag"]})
    assert (again.status_code, again.content) == (304, b"")
    other = client.get("/icon.svg", headers={"if-none-match": first.headers["etag"]})
    assert other.status_code == 200


@pytest.mark.parametrize(
    "body, status",
    [
        (b'{"options": {"length": {}}}', 422),
        (b'{"scenario": "fig05"}', 422),
        (b"x" * (MOST_BODY + 1), 413),
    ],
)
def test_a_bad_request_is_refused_with_one_line(client, body, status):
    answer = client.post("/api/run", content=body)
    assert answer.status_code == status
    assert answer.json()["error"]
    assert "\n" not in answer.json()["error"]
