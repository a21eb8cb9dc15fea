"""The server answers its own pages only."""

import re

import httpx2
import pytest
from starlette.responses import PlainTextResponse
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

from app_server import start_server, stop_server
from latolato.app.answers import MOST_BODY
from latolato.app.guard import Guard
from latolato.app.pages import STATIC
from latolato.app.serve import serve
from latolato.app.server import Settings, make_app
from latolato.core.errors import InputError

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


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1:9999", "", "127.0.0.1"])
def test_another_name_of_the_server_is_refused(client, host):
    assert client.get("/", headers={"host": host}).status_code == 403


@pytest.mark.parametrize(
    "headers", [{"origin": "http://evil.example"}, {"sec-fetch-site": "cross-site"}]
)
def test_a_page_of_another_site_is_refused(client, headers):
    answer = client.post("/api/run", json={"scenario": "zeno"}, headers=headers)
    assert answer.status_code == 403


COOKIE = "latolato_token_8000"


@pytest.fixture
def shared():
    """A server that asks for its token, as a browser without cookies meets it."""
    settings = Settings(host="0.0.0.0", token="secret", names=("Lab.example", "gate.example:81"))
    with TestClient(make_app(settings), base_url=HOME) as found:
        yield found


def test_the_token_is_needed_and_then_kept_in_a_cookie(shared):
    assert shared.get("/").status_code == 403
    assert shared.get("/?token=guess").status_code == 403
    assert not shared.cookies
    assert shared.get("/?token=secret").status_code == 200
    assert shared.cookies[COOKIE] == "secret"
    assert shared.get("/registry.json").status_code == 200


@pytest.mark.parametrize(
    "query", ["token=guess", "token=", "token=a%3B%20Domain%3Dx", "token=a%0d%0aX:y", "token=%ff"]
)
def test_a_wrong_token_neither_sets_nor_clears_the_cookie(shared, query):
    headers = {"cookie": f"{COOKIE}=secret"}
    answer = shared.get(f"/?{query}", headers=headers)
    assert answer.status_code == 200
    assert "set-cookie" not in answer.headers


def test_only_the_token_of_the_server_itself_enters_the_cookie(shared):
    answer = shared.get("/?token=guess&token=secret&token=a%3B+Domain%3Dx")
    assert answer.headers.get_list("set-cookie") == [
        f"{COOKIE}=secret; HttpOnly; SameSite=Strict; Path=/"
    ]


def test_cookies_of_other_servers_of_the_machine_do_not_hide_the_token(shared):
    cookie = f'x={{"a": [1, "b"]}}; latolato_token_9000=other; é; =; {COOKIE}=secret'
    assert shared.get("/", headers={"cookie": cookie.encode()}).status_code == 200


@pytest.mark.parametrize(
    "host", ["lab.example:8000", "LAB.example", "gate.example:81", "localhost:8000"]
)
def test_names_of_the_command_line_are_known(shared, host):
    headers = {"host": host, "origin": f"https://{host.lower()}"}
    assert shared.get("/?token=secret", headers=headers).status_code == 200


@pytest.mark.parametrize(
    "host",
    [
        "gate.example",
        "gate.example:8000",
        "lab.example.:8000",
        "evil.lab.example:8000",
        "lab.example:81",
        "lab.example:8000@evil.example",
        "user@127.0.0.1:8000",
        "127.0.0.1:08000",
        "127.1:8000",
        "0.0.0.0:8000",
        "127.0.0.1.:8000",
        "[::1%25eth0]:8000",
        "[::ffff:127.0.0.1]:8000",
        "127.0.0.1:8000,evil.example",
    ],
)
def test_no_trick_makes_another_name_known(shared, host):
    answer = shared.get("/?token=secret", headers={"host": host})
    assert answer.status_code == 403
    assert "--name HOST" in answer.text


@pytest.mark.parametrize(
    "arrived, host, status",
    [
        (("192.0.2.2", 8000), "192.0.2.2:8000", 200),
        (("192.0.2.2", 8000), "192.0.2.3:8000", 403),
        (("192.0.2.2", 8000), "192.0.2.2", 403),
        (("192.0.2.2", 80), "192.0.2.2", 200),
        (("::ffff:192.0.2.2", 8000), "192.0.2.2:8000", 200),
        (("fe80::1%eth0", 8000), "[fe80::1]:8000", 200),
        (("fd00::2", 8000), "[FD00::2]:8000", 200),
        (("evil.example", 8000), "evil.example:8000", 403),
        (None, "192.0.2.2:8000", 403),
    ],
)
def test_the_address_of_the_socket_is_known(arrived, host, status):
    async def app(scope, receive, send):
        await PlainTextResponse("in")(scope, receive, send)

    async def at_the_socket(scope, receive, send):
        await guard({**scope, "server": arrived}, receive, send)

    guard = Guard(app, frozenset(), None, COOKIE)
    client = TestClient(at_the_socket, base_url=HOME)
    assert client.get("/", headers={"host": host}).status_code == status


@pytest.mark.parametrize(
    "origin",
    ["http://[", "null", "", "http://127.0.0.1:8000.evil.example", "http://localhost:8000",
     "http://127.0.0.1:8000/", "http://user@127.0.0.1:8000", "ftp://127.0.0.1:8000"],
)  # fmt: skip
def test_any_other_origin_is_refused(client, origin):
    assert client.get("/", headers={"origin": origin}).status_code == 403
    with (
        pytest.raises(WebSocketDisconnect),
        client.websocket_connect("/ws/map/file", headers={"origin": origin}),
    ):
        pass


def test_a_link_with_the_token_may_stand_on_another_site(shared):
    headers = {"sec-fetch-site": "cross-site"}
    assert shared.get("/?token=guess", headers=headers).status_code == 403
    assert shared.get("/?token=secret", headers=headers).status_code == 200
    assert shared.get("/", headers=headers).status_code == 403


@pytest.mark.parametrize("names", [(), ("lab.example",)])
def test_an_address_that_others_reach_needs_a_flag(names):
    with pytest.raises(InputError, match="--allow-others"):
        serve("127.0.0.1" if names else "0.0.0.0", 0, browser=False, names=names)


@pytest.mark.parametrize(
    "name", ["", "http://lab.example", "a b", "lab.example/x", "a\r\nb", "a@b"]
)
def test_a_name_that_is_none_is_refused(name):
    with pytest.raises(InputError, match="HOST:PORT"):
        serve(port=0, browser=False, allow_others=True, names=(name,))


def test_printed_links_work_for_this_machine_and_for_others():
    server = start_server("--host", "0.0.0.0", "--allow-others")
    try:
        second = server.process.stdout.readline()
        assert second.startswith("Others reach it at http://")
        for link in (server.address, second.split(" at ")[1].strip()):
            assert "0.0.0.0" not in link
            assert httpx2.get(link).status_code == 200
        assert httpx2.get(server.address.partition("?")[0]).status_code == 403
    finally:
        stop_server(server)


@pytest.mark.parametrize("path", ["/../server.py", "/%2e%2e/server.py", "/..%2fserver.py", "/x"])
def test_nothing_but_the_pages_is_served(client, path):
    assert client.get(path).status_code == 404


@pytest.mark.parametrize("path", ["//etc/passwd", "/js", "/%00"])
def test_no_other_path_leads_to_a_file(client, path):
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
        (b"", 400),
        (b"{", 400),
        (b"[" * 100_000, 400),
        (b"[]", 422),
        (b'{"scenario": 3}', 422),
        (b'{"options": []}', 422),
        (b'{"options": {"length": {}}}', 422),
        (b'{"scenario": "zeno", "most_samples": "many"}', 422),
        (b'{"scenario": "zeno", "most_samples": 1000000000}', 413),
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
