"""Connections that ask for nothing are ended, and one address cannot take them all."""

import contextlib
import socket
import threading
import time

import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from latolato.app.connections import ConnectionLimits
from latolato.app.serve import make_server
from latolato.app.server import Settings

# Longest wait for what must happen; the limits under test are far shorter.
PATIENCE = 60.0
HEADER = "{} {} HTTP/1.1\r\nHost: 127.0.0.1:{}\r\n"
SHORT = ConnectionLimits(header_time=0.5, first_frame_time=0.5, body_time=0.5)


@contextlib.contextmanager
def serving(limits):
    """The port of a server in a thread of its own."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
        server = make_server(Settings(port=port, connections=limits))
        thread = threading.Thread(target=server.run, kwargs={"sockets": [listener]})
        thread.start()
        try:
            yield port
        finally:
            server.should_exit = True
            thread.join()


def opened(port):
    return socket.create_connection(("127.0.0.1", port), timeout=PATIENCE)


def begun(port, *lines, method="GET", path="/manifest.json"):
    """A connection that has sent the beginning of a request."""
    found = opened(port)
    found.sendall((HEADER.format(method, path, port) + "".join(lines)).encode())
    return found


def rest(connection):
    """What comes until the server closes."""
    parts = []
    with connection, contextlib.suppress(ConnectionResetError):
        while part := connection.recv(65536):
            parts.append(part)
    return b"".join(parts).decode()


def answer(port):
    """The answer to a whole request on a connection of its own."""
    return rest(begun(port, "Connection: close\r\n\r\n"))


def heard(found):
    """The next frame of a WebSocket, None once it is closed."""
    try:
        return found.recv(timeout=PATIENCE)
    except ConnectionClosed:
        return None


def test_a_connection_that_says_nothing_is_closed_without_an_answer():
    with serving(SHORT) as port:
        assert rest(opened(port)) == ""


def test_a_header_that_is_never_complete_is_refused():
    with serving(SHORT) as port:
        found = rest(begun(port))
    assert found.startswith("HTTP/1.1 408 ")
    assert "the header was not complete within 0.5 s" in found


def test_a_header_that_comes_in_drips_is_refused():
    with serving(SHORT) as port, begun(port, "X-Drip: ") as connection:
        deadline = time.monotonic() + PATIENCE
        with contextlib.suppress(ConnectionError):  # the server has closed
            while time.monotonic() < deadline:
                connection.sendall(b"x")
                time.sleep(0.05)
        assert time.monotonic() < deadline


def test_the_header_after_an_answer_is_limited_too():
    with serving(SHORT) as port, begun(port, "\r\n") as connection:
        connection.recv(65536)
        connection.sendall(b"GET / HTTP/1.1\r\n")
        assert "HTTP/1.1 408 " in rest(connection)


def test_an_endless_header_is_refused():
    limits = ConnectionLimits(header_size=10_000)
    with serving(limits) as port:
        assert rest(begun(port, "X: ", "x" * 10_000)).startswith("HTTP/1.1 431 ")
        assert answer(port).startswith("HTTP/1.1 200 ")


def test_a_body_that_never_comes_is_refused():
    with serving(SHORT) as port:
        found = rest(begun(port, "Content-Length: 9\r\n\r\n{", method="POST", path="/api/run"))
    assert found.startswith("HTTP/1.1 408 ")
    assert "a request must arrive within 0.5 s" in found


def test_a_body_that_nobody_reads_does_not_keep_a_connection():
    with serving(SHORT) as port, begun(port, "Content-Length: 1000000\r\n\r\n") as connection:
        assert connection.recv(65536).startswith(b"HTTP/1.1 200 ")
        deadline = time.monotonic() + PATIENCE
        with contextlib.suppress(ConnectionError):
            while time.monotonic() < deadline:
                connection.sendall(b"x")
                time.sleep(0.05)
        assert time.monotonic() < deadline


@pytest.mark.parametrize("path", ["/ws/experiment/desk", "/ws/map/file", "/ws/analyse"])
def test_a_socket_that_sends_no_frame_is_closed_with_a_reason(path):
    with serving(SHORT) as port:
        home = f"127.0.0.1:{port}"
        with connect(f"ws://{home}{path}", origin=f"http://{home}") as found:
            list(iter(lambda: heard(found), None))
        assert (found.close_code, found.close_reason) == (1008, "no frame came within 0.5 s")


def test_a_socket_that_has_sent_a_frame_stays_open():
    with serving(SHORT) as port:
        home = f"127.0.0.1:{port}"
        with connect(f"ws://{home}/ws/experiment/desk", origin=f"http://{home}") as found:
            found.send('{"hello": true}')
            assert "desk" in found.recv(timeout=PATIENCE)
            with pytest.raises(TimeoutError):
                found.recv(timeout=4 * SHORT.first_frame_time)
            found.ping().wait(PATIENCE)


def test_idle_connections_of_an_address_make_room_for_requests():
    limits = ConnectionLimits(per_address=5, header_time=PATIENCE)
    with serving(limits) as port, contextlib.ExitStack() as held:
        idle = [held.enter_context(opened(port)) for _ in range(15)]
        assert answer(port).startswith("HTTP/1.1 200 ")
        for connection in idle[:10]:
            assert connection.recv(1) == b""
        for connection in idle[12:]:
            connection.setblocking(False)
            with pytest.raises(BlockingIOError):
                connection.recv(1)


def test_an_address_whose_connections_are_all_busy_gets_no_more():
    limits = ConnectionLimits(per_address=5)
    with serving(limits) as port, contextlib.ExitStack() as held:
        home = f"127.0.0.1:{port}"
        for _ in range(5):
            busy = connect(f"ws://{home}/ws/experiment/desk", origin=f"http://{home}")
            held.enter_context(busy).send('{"hello": true}')
            busy.recv(timeout=PATIENCE)
        found = rest(opened(port))
        assert found.startswith("HTTP/1.1 503 ")
        assert "your address has 5 connections; close some of them" in found
        # Another address is another user; not every system has a second one of its own.
        with contextlib.suppress(OSError):
            other = socket.create_connection(
                ("127.0.0.1", port), timeout=PATIENCE, source_address=("127.0.0.2", 0)
            )
            other.sendall((HEADER.format("GET", "/", port) + "Connection: close\r\n\r\n").encode())
            assert rest(other).startswith("HTTP/1.1 200 ")
