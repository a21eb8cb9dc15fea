"""Answers of the server and of workers to refused input and to faults of the program."""

import json
from pathlib import Path

import pytest
from starlette.routing import Route, WebSocketRoute
from starlette.testclient import TestClient

from app_server import frames_of
from latolato.app import forms, worker
from latolato.app.server import Settings, make_app
from latolato.core.errors import InputError


@pytest.fixture
def client():
    app, home = make_app(Settings()), "http://127.0.0.1"
    with TestClient(app, base_url=home, raise_server_exceptions=False) as client:
        yield client


def fail(*_, **__):
    raise ValueError("of a library")


def test_a_fault_is_a_500_with_one_sentence_and_its_traceback_in_a_file(client, monkeypatch):
    monkeypatch.setattr(forms, "registry", fail)
    answer = client.get("/registry.json")
    assert answer.status_code == 500
    message = answer.json()
    assert message["field"] is None
    assert message["error"].startswith("internal error (ValueError)")
    path = Path(message["error"].split("'")[1])
    try:
        assert "ValueError: of a library" in path.read_text()
    finally:
        path.unlink()


def test_a_refusal_names_the_field_and_its_rule(client):
    options = {"drive": "harmonic", "drive_amplitude": "x", "drive_frequency": "6"}
    answer = client.post("/api/run", json={"scenario": "fig02", "options": options})
    assert answer.status_code == 422
    message = answer.json()
    assert message["field"] == "drive_amplitude"
    assert message["error"].startswith("drive_amplitude must be given in m")
    # From which the page makes a sentence in its own words.
    assert message["parts"]["rule"]["name"] == "quantity_of_unit"


ROUTES = make_app(Settings()).routes
POSTS = [r.path for r in ROUTES if isinstance(r, Route) and "POST" in (r.methods or ())]
# An upload is no JSON, and the socket of a desk gets none.
POSTS.remove("/api/experiment")
SOCKETS = [f"ws://127.0.0.1{r.path}" for r in ROUTES if isinstance(r, WebSocketRoute)]
SOCKETS.remove("ws://127.0.0.1/ws/experiment/desk")
MALFORMED = ["", "{", "[" * 100_000, "[]", "3", "null"]


@pytest.mark.parametrize("path", POSTS)
def test_a_malformed_request_is_a_400(client, path):
    for body in MALFORMED:
        answer = client.post(path, content=body)
        assert answer.status_code == 400, body
        assert "request" in answer.json()["error"]
    assert client.post(path, content="{}").status_code in (400, 422)


@pytest.mark.parametrize("path", SOCKETS)
def test_a_malformed_request_for_a_job_is_refused(client, path):
    for body in MALFORMED:
        refused, _ = frames_of(client, path, body)
        assert "request" in json.loads(refused["text"])["error"], body
    *_, refused, _ = frames_of(client, path, "{}")
    assert json.loads(refused["text"])["error"].startswith("a request like this needs")


@pytest.mark.parametrize(
    "error, begin",
    [
        (InputError("must be less", parameter="length"), "length must be less"),
        (FileNotFoundError(2, "No such file", "x.nc"), "No such file: x.nc"),
        (MemoryError(), "not enough memory"),
        (ValueError("of a library"), "internal error (ValueError)"),
        (RecursionError("deep"), "internal error (RecursionError)"),
    ],
)
def test_a_job_distinguishes_refusals_from_faults(error, begin, tmp_path):
    def compute(*_):
        raise error

    with pytest.raises(InputError) as caught:
        worker.run(compute, {}, tmp_path)
    assert str(caught.value).startswith(begin)
    if "internal" in begin:
        Path(str(caught.value).split("'")[1]).unlink()
