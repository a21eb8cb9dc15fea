"""Pages of Experiment without a browser: uploads, jobs and what a server answers to them."""

import contextlib
import json
import time

from starlette.testclient import TestClient

from latolato.app.blocks import unpack
from latolato.app.experiment.store import MOST_BYTES
from latolato.app.server import Settings, make_app

HOME = "http://127.0.0.1:8000"
HEADERS = {"origin": HOME, "host": "127.0.0.1:8000"}


class Page:
    """What an open page does."""

    def __init__(self, client, socket):
        self.client, self.socket = client, socket
        self.desk = socket.receive_json()["desk"]

    def upload(self, content, name="swing.mp4", desk=None):
        return self.client.post(
            f"/api/experiment?desk={desk or self.desk}", content=content, headers={"x-name": name}
        )

    def clip(self, content, name="swing.mp4"):
        answer = self.upload(content, name)
        assert answer.status_code == 200, answer.text
        return answer.json()["clip"]

    @contextlib.contextmanager
    def begin(self, **what):
        """A job whose frames are not read yet; in the end its socket closes."""
        with self.client.websocket_connect("/ws/experiment", headers=HEADERS) as socket:
            socket.send_json({"desk": self.desk, **what})
            yield socket

    def do(self, **what):
        """The result of a job, with its arrays, or the refusal."""
        with self.begin(**what) as socket:
            return end_of(socket)

    def remove(self, clip):
        answer = self.client.post("/api/experiment/remove", json={"clip": clip})
        assert answer.status_code == 200, answer.text
        return answer.json()["trials"]

    def file(self, clip, name):
        return self.client.get(f"/api/experiment/{clip}/{name}")


def end_of(socket):
    """The last frame of a job."""
    while True:
        message = socket.receive()
        if "bytes" in message:
            about, arrays = unpack(message["bytes"])
            return {"done": about, **arrays}
        frame = json.loads(message["text"])
        if "state" not in frame:
            return frame


@contextlib.contextmanager
def opened(most_bytes=MOST_BYTES):
    """A page of a server, and the server's clips."""
    app = make_app(Settings(most_bytes=most_bytes))
    with TestClient(app, base_url=HOME) as client:
        with client.websocket_connect("/ws/experiment/desk", headers=HEADERS) as socket:
            yield Page(client, socket), app.state.clips
        deadline = time.monotonic() + 10.0
        while app.state.clips.desks and time.monotonic() < deadline:
            time.sleep(0.02)


def one_line(message):
    """The refusal in a message, which must be one line without a path of the server."""
    assert "error" in message, message
    text = message["error"]
    assert 0 < len(text) < 400
    assert not [part for part in ("\n", "/tmp", "latolato-clips", "Traceback") if part in text]
    return text
