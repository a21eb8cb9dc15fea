"""Pages of Experiment without a browser: uploads, jobs and what a server answers to them."""

import contextlib
import json
import re
import time

from starlette.testclient import TestClient

from latolato.app import STATIC
from latolato.app.experiment.store import MOST_BYTES
from latolato.app.server import Settings, make_app
from page_blocks import unpack

HOME = "http://127.0.0.1:8000"
HEADERS = {"origin": HOME, "host": "127.0.0.1:8000"}


# Texts that are born as data, of which a language has each.
TEXTS = json.loads((STATIC / "languages" / "id.json").read_text("utf-8"))["texts"]


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
            assert not (prose := prose_in(about)), prose
            return {"done": about, **arrays}
        frame = json.loads(message["text"])
        if "state" not in frame:
            return frame


def english(said):
    """The English text of a sentence, or of a refusal without its way out."""
    if not isinstance(said, dict):
        return said
    if "rule" in said:
        return english(said["rule"])
    values = {name: english(each) for name, each in said["values"].items()}
    return said["text"].format(**values)


def prose_in(about):
    """What a page shows of a result as it came, and so in English only."""
    cards = list(about.get("fits", {"one": about}).values())
    shown = [*about.get("finding", []), *about.get("warnings", []), about.get("no_trial")]
    shown += [card.get(part) for card in cards for part in ("verdict", "error", "doubt")]
    shown += [row["note"] for row in about.get("trials", [])]
    labels = [{"word": each["label"]} for card in cards for each in card.get("values", {}).values()]
    return [text for each in [*shown, *labels] for text in _texts_in(each)]


def _texts_in(said):
    """The texts in a sentence, and in those in its gaps, that no language has by their names."""
    if isinstance(said, str):
        return [said] if re.search("[a-z]{3,}[,.;:]? [a-z]{2,}", said) else []
    if not isinstance(said, dict):
        return []
    if "word" in said:
        word = said["word"]
        # One that begins a sentence has a capital.
        return [] if {word, word[:1].lower() + word[1:]} & set(TEXTS) else [word]
    parts = said["values"] if "values" in said else {k: v for k, v in said.items() if k != "value"}
    return [text for each in parts.values() for text in _texts_in(each)]


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
