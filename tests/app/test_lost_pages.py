"""A page that is lost at any moment ends its work and leaves no error on the server's terminal."""

import json
import threading
import time

import pytest
from starlette.testclient import TestClient

from latolato.app.server import Settings, make_app

HOME = "http://127.0.0.1:8000"
FIRST = {
    "/ws/analyse": {
        "analysis": "basins",
        "scenario": "fig02",
        "settings": {"transient_periods": "8000"},
    },
    "/ws/run/file": {"kind": "nc", "scenario": "fig02", "options": {"duration": "170 s"}},
    "/ws/map/file": {
        "kind": "nc",
        "observable": "mean_energy",
        "options": {
            "system": "pendulum",
            "length": 1.0,
            "mass": 0.8,
            "initial_angle": 0.1,
            "drive": "harmonic",
            "drive_amplitude": 0.1,
            "drive_frequency": 6.0,
            "duration": 300.0,
        },
        "sweep": {
            "axes": {
                "drive_amplitude": [0.001 * i for i in range(200)],
                "drive_frequency": [0.1 * i for i in range(200)],
            },
            "observables": [{"kind": "mean_energy"}],
        },
    },
}
JOBS = ("/ws/analyse", "/ws/map/file")


class Losing:
    """An app whose pages receive some frames and are then lost."""

    def __init__(self, app, received):
        self.app, self.received = app, received
        self.failed = threading.Event()

    async def __call__(self, scope, receive, send):
        sent = 0

        async def send_some(message):
            nonlocal sent
            if message["type"] in ("websocket.send", "websocket.close"):
                sent += 1
                if sent > self.received:
                    self.failed.set()
                    raise OSError("the page has gone")  # what uvicorn raises
            await send(message)

        await self.app(scope, receive, send_some)


@pytest.fixture
def app():
    return make_app(Settings())


def lose(app, path, frame):
    """Send the first frame, wait until one to the page is lost; raise what the app raises."""
    client = TestClient(app, base_url=HOME, headers={"origin": HOME})
    with client, client.websocket_connect(f"ws://127.0.0.1:8000{path}") as socket:
        if frame is not None:
            socket.send_text(frame if isinstance(frame, str) else json.dumps(frame))
        assert app.failed.wait(timeout=60)
        yield


@pytest.mark.parametrize("path", list(FIRST))
def test_a_page_that_is_lost_before_the_first_answer_is_no_fault(app, path):
    for _ in lose(Losing(app, 0), path, FIRST[path]):
        pass


@pytest.mark.parametrize("path", JOBS)
def test_work_ends_when_its_page_is_lost(app, path, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    for _ in lose(Losing(app, 2), path, FIRST[path]):
        end = time.monotonic() + 20
        # The folder of a job goes with it.
        while len(list(tmp_path.glob("latolato-*"))) > 1 and time.monotonic() < end:
            time.sleep(0.02)
        assert [each.name[:15] for each in tmp_path.glob("latolato-*")] == ["latolato-clips-"]


@pytest.mark.parametrize("path", ["/ws/analyse", "/ws/map/file"])
@pytest.mark.parametrize("frame", ["{", "[3]", "{}"])
def test_a_page_that_is_lost_before_its_refusal_is_no_fault(app, path, frame):
    for _ in lose(Losing(app, 0), path, frame):
        pass


def test_a_desk_of_clips_whose_page_is_lost_at_once_is_no_fault(app):
    for _ in lose(Losing(app, 0), "/ws/experiment/desk", None):
        pass
    assert not app.state.clips.desks
