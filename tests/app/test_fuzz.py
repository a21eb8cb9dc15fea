"""Whatever is sent, the server answers with one of its own answers and goes on.

Requests are made by schemathesis from a description of the server's interface, which lives here:
pages are the only clients, so the server publishes none.
"""

from __future__ import annotations

import hypothesis
import pytest
import schemathesis
from starlette.testclient import TestClient

from latolato.app.server import Settings, make_app

ASKED = {
    "type": "object",
    "properties": {
        "scenario": {"type": ["string", "null"], "enum": ["zeno", "fig12", "fig05", "no", None]},
        "options": {
            "type": "object",
            "properties": {
                "system": {"enum": ["pendulum", "latolato", "ballpair", "mathieu", "x", 3]},
                "drive": {
                    "enum": ["harmonic", "fixed_pivot", "frequency_schedule", "crank_slider"]
                },
                "duration": {"enum": ["0.2 s", "-1 s", "1e99 s", "nan", "", 0.1, None]},
                "length": {"type": ["string", "number", "array", "null"]},
                "radius": {"enum": ["2 cm", "-1", "inf", "9 kg"]},
                "drive_times": {"type": ["string", "array"]},
                "drive_frequency": {"enum": ["1e308", "2 Hz", "Hz", "1e9 rad/s"]},
                "samples": {"type": ["integer", "string"]},
            },
            "additionalProperties": True,
        },
        "most_samples": {"type": ["integer", "null"]},
    },
}
ANSWERS = {str(code): {"description": "known"} for code in (200, 400, 404, 405, 413, 422)}
SCHEMA = {
    "openapi": "3.1.0",
    "info": {"title": "latolato", "version": "1"},
    "paths": {
        "/api/run": {
            "post": {
                "requestBody": {
                    "required": True,
                    "content": {"application/json": {"schema": ASKED}},
                },
                "responses": ANSWERS,
            }
        },
        "/registry.json": {"get": {"responses": ANSWERS}},
        "/api/compiling": {"get": {"responses": ANSWERS}},
    },
}
HOME = "http://127.0.0.1:8000"

schema = schemathesis.openapi.from_dict(SCHEMA)


@pytest.fixture(scope="module")
def client():
    with TestClient(make_app(Settings()), base_url=HOME) as found:
        yield found


@schema.parametrize()
@hypothesis.settings(
    max_examples=60,
    deadline=None,
    derandomize=True,
    suppress_health_check=list(hypothesis.HealthCheck),
)
def test_no_request_makes_the_server_stumble(case, client):
    given = case.as_transport_kwargs(base_url=HOME)
    given = {k: v for k, v in given.items() if k in ("method", "url", "headers", "json", "data")}
    if "data" in given:
        given["content"] = given.pop("data")
    given["headers"] = {k: v for k, v in (given.get("headers") or {}).items() if v is not None}
    answer = client.request(**given)
    assert str(answer.status_code) in ANSWERS
    if answer.status_code != 200:
        assert "\n" not in answer.json()["error"]


@hypothesis.given(body=hypothesis.strategies.binary(max_size=300))
@hypothesis.settings(max_examples=100, deadline=None)
def test_no_bytes_make_the_server_stumble(body, client):
    assert client.post("/api/run", content=body).status_code in (400, 422)


PATHS = hypothesis.strategies.text(
    hypothesis.strategies.sampled_from("ab/.%2fe\\:?#&=0\u00e9 ~-"), max_size=40
)


@hypothesis.given(path=PATHS)
@hypothesis.settings(max_examples=150, deadline=None)
def test_no_address_makes_the_server_stumble(path, client):
    from urllib.parse import quote

    answer = client.get(f"{HOME}/{quote(path, safe='/%?=&.:')}")
    assert answer.status_code in (200, 404, 405)
    if answer.status_code == 200:
        assert answer.headers["content-security-policy"]
