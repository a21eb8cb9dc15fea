"""Live: a toy that runs in real time, its socket, and the page that steers it."""

from __future__ import annotations

import json
import math
import struct

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

import latolato as ll
from latolato.app import live
from latolato.app.blocks import unpack
from latolato.app.given import RunRequest
from latolato.app.live import MOST_ERRORS, parsed
from latolato.app.recording import SAME, keep
from latolato.app.server import Settings, make_app
from latolato.app.session import FRAME, MOST_UNSEEN, Session
from latolato.app.steering import cosine_of, limits_of
from latolato.app.toy import SHORTEST_CHANGE, Toy
from latolato.core.errors import InputError
from latolato.physics.contacts import CONTACT_KINDS
from latolato.physics.drives.stretch import acceleration_bound
from latolato.scenario.scenario import scenarios

LEDGER = ("drive_work", "damping_loss", "impact_loss", "capture_loss", "noise_work")
HOME = "http://127.0.0.1:8000"


def toy_of(scenario="fig12", **options):
    return Toy(RunRequest(scenario, options).to_scenario())


def run_on(toy, seconds):
    for _ in range(round(60 * seconds)):
        toy.advance()


class TestToy:
    @pytest.mark.parametrize("name", ["fig12", "fig04b_push", "fig02", "ballpair_asymmetric"])
    def test_many_ticks_are_one_run(self, name):
        seconds = 3 if name == "ballpair_asymmetric" else 12  # that one is chaotic
        toy = toy_of(name)
        toy.record()
        run_on(toy, seconds)
        recording = toy.finish()
        found = recording.to_dataset()
        run = ll.simulate(
            recording.system, recording.drive(), times=found["time"].values.copy(), **recording.run
        )
        # Both aim at 1e-10; the motion is regular or short.
        np.testing.assert_allclose(found["angle"], run["angle"], rtol=0, atol=1e-7)
        assert list(found["contact_kind"].values) == list(run["contact_kind"].values)
        np.testing.assert_allclose(found["contact_time"], run["contact_time"], rtol=0, atol=1e-7)
        scale = float(run["total_energy"].max())
        for part in ("drive_work", "damping_loss", "impact_loss", "capture_loss"):
            np.testing.assert_allclose(found[part], run[part], rtol=0, atol=1e-6 * scale)

    def test_rest_on_the_wall_lasts_and_ends_as_in_one_run(self):
        # Weak shaking leaves the balls at rest, strong shaking lifts them off again and again.
        for amplitude, rests in (("5 mm", True), ("40 mm", False)):
            toy = toy_of("fig12", drive="harmonic", drive_amplitude=amplitude,
                         drive_frequency="19.8 rad/s", restitution="0")  # fmt: skip
            toy.record()
            run_on(toy, 2)
            found = toy.finish().to_dataset()
            still = np.abs(found["angle"] - toy.walls[0]) == 0.0
            assert bool(still.all()) == rests
            kinds = list(found["contact_kind"].values)
            assert (min(kinds.count("release"), kinds.count("rest")) > 3) != rests

    @pytest.mark.parametrize(
        "changes",
        [
            {"drive_frequency": 15.1},
            {"drive_amplitude": 0.04},
            {"drive_amplitude": 0.0},
            {"drive_amplitude": 0.04, "drive_frequency": 30.0},
        ],
    )
    def test_the_pivot_never_jumps(self, changes):
        toy = toy_of()
        run_on(toy, 0.5)
        heights, speeds = [], []
        for k in range(60):
            if k in (5, 6, 20):  # again before the first change has ended
                toy.set(changes if k != 6 else {"drive_amplitude": 0.01})
            toy.advance()
            heights.append(toy.pivot[0])
            speeds.append(toy.pivot[1])
            stage = toy.stages[0]
            assert abs(toy.pivot[2]) <= acceleration_bound(stage, 1.0) + 1e-9
        bound = max(acceleration_bound(s, 1.0) for s in toy.stages) + 60.0
        assert np.abs(np.diff(speeds)).max() < bound / 60.0
        # The mean of the speeds at both ends of a tick, up to its curvature, is the way.
        way = np.diff(heights) - np.add(speeds[1:], speeds[:-1]) / 120.0
        assert np.abs(way).max() < bound * 30.0 / 60.0**3

    def test_a_small_change_is_done_within_the_least_time(self):
        toy = toy_of()
        toy.set({"drive_amplitude": toy.controls["drive_amplitude"] + 1e-3})
        assert toy.stages[1].start - toy.stages[0].start == pytest.approx(SHORTEST_CHANGE)
        run_on(toy, 0.1)
        assert toy.stages[0].c0 == toy.controls["drive_amplitude"]

    @pytest.mark.parametrize("name", [n for n, s in scenarios().items() if not s.varied])
    def test_every_scenario_lies_within_what_may_be_set(self, name):
        scenario = scenarios()[name]
        amplitude, frequency, _ = cosine_of(scenario.drive, scenario.system)
        limits = limits_of(scenario.system)
        assert amplitude <= limits["drive_amplitude"][1]
        assert frequency <= limits["drive_frequency"][1]
        assert all(b.damping <= limits["damping"][1] for b in scenario.system.balls)

    def test_a_push_gives_the_energy_of_its_speed(self):
        toy = toy_of("fig02", drive="harmonic", drive_amplitude="0 m", drive_frequency="6 rad/s",
                     initial_angle="0 deg", damping="0 kg m/s")  # fmt: skip
        toy.push(2.0)
        run_on(toy, 1)
        ball = toy.system.balls[0]
        energy = 0.5 * ball.mass * (2.0 * ball.length) ** 2
        assert toy.kinetic + toy.potential == pytest.approx(energy, rel=1e-9)

    @pytest.mark.parametrize("name,ball", [("fig12", 0), ("fig02", 0), ("ballpair_asymmetric", 1)])
    def test_a_held_ball_goes_where_the_hand_goes(self, name, ball):
        toy = toy_of(name, drive="harmonic", drive_amplitude="0 m", drive_frequency="6 rad/s")
        target = -1.0 if ball else 1.2
        toy.hold(ball, target)
        run_on(toy, 1.5)
        # The hand corrects sixty times a second, and for the fall in between.
        assert toy.angles[ball] == pytest.approx(target, abs=2e-3)
        toy.release()
        run_on(toy, 0.5)
        assert abs(toy.angles[ball] - target) > 0.05

    def test_a_ball_that_is_pressed_on_the_wall_rests_there(self):
        toy = toy_of("fig12", drive="harmonic", drive_amplitude="0 m", drive_frequency="6 rad/s")
        toy.hold(0, 1.0)
        run_on(toy, 1)
        toy.hold(0, -3.0)
        run_on(toy, 2)
        before = toy.contacts
        run_on(toy, 1)
        assert toy.contacts == before
        assert toy.angles[0] == toy.walls[0]

    def test_a_held_ball_does_not_pass_through_the_other(self):
        toy = toy_of("ballpair_asymmetric")
        for angle in (-2.0, 2.0, 8.0, -8.0):
            toy.hold(0, angle)
            for _ in range(90):
                toy.advance()
                gap = toy.angles[0] - toy.angles[1]
                assert toy.walls[0] - 1e-9 <= gap <= toy.walls[1] + 1e-9

    def test_a_toy_goes_on_from_its_state(self):
        one = toy_of()
        run_on(one, 7)
        other = Toy(RunRequest("fig12", {}).to_scenario(), json.loads(json.dumps(one.state())))
        assert other.time == one.time
        run_on(one, 1)
        run_on(other, 1)
        assert other.angles == pytest.approx(one.angles, abs=1e-9)
        assert other.pivot == pytest.approx(one.pivot, abs=1e-9)

    @pytest.mark.parametrize(
        "values,rule",
        [
            ({"drive_frequency": 1e8}, r"drive_frequency must lie in \[0, 25"),
            ({"drive_amplitude": math.nan}, "drive_amplitude must be finite"),
            ({"drive_amplitude": -0.01}, "drive_amplitude must lie"),
            ({"damping": math.inf}, "damping must be finite"),
            ({"restitution": 1.01}, "restitution must lie"),
            ({"restitution": True}, "restitution must be a number"),
            ({"restitution": "0.5"}, "restitution must be a number"),
            ({"mass": 1.0}, "unknown control 'mass'"),
        ],
    )
    def test_values_beyond_the_limits_are_refused_whole(self, values, rule):
        toy = toy_of()
        before = dict(toy.controls)
        with pytest.raises(InputError, match=rule):
            toy.set({"drive_amplitude": 0.01, **values})
        assert toy.controls == before

    @settings(max_examples=30, deadline=None)
    @given(
        st.sampled_from(["fig12", "ballpair_asymmetric"]),
        st.lists(
            st.tuples(
                st.sampled_from(["drive_amplitude", "drive_frequency", "damping", "restitution"]),
                st.floats(0.0, 1.0),
                st.sampled_from(["", "push", "hold", "release"]),
            ),
            max_size=8,
        ),
    )
    def test_whatever_is_done_the_balls_stay_between_their_contacts(self, name, actions):
        toy = toy_of(name)
        for control, share, more in actions:
            low, high = toy.limits[control]
            toy.set({control: low + share * (high - low)})
            if more == "push":
                toy.push(20.0 * (2.0 * share - 1.0))
            elif more == "hold":
                toy.hold(0, 7.0 * (2.0 * share - 1.0))
            elif more == "release":
                toy.release()
            run_on(toy, 0.2)
            gap = toy.angles[0] - (toy.angles[1] if len(toy.angles) > 1 else 0.0)
            assert toy.walls[0] - 1e-9 <= gap <= toy.walls[1] + 1e-9


class TestRecording:
    def test_changes_of_the_drive_are_a_run_that_anyone_can_repeat(self):
        toy = toy_of()
        run_on(toy, 5)
        toy.record()
        run_on(toy, 1)
        toy.set({"drive_frequency": 15.1})
        run_on(toy, 1)
        toy.set({"drive_amplitude": 0.028})
        run_on(toy, 2)
        kept = keep(toy.finish())
        assert kept.about["reproduces"]
        assert kept.about["gap"] < SAME
        assert kept.about["options"]["drive"] == "staged_harmonic"
        names: dict = {}
        exec(kept.about["python"], names)
        last = float(names["run"]["angle"][-1])
        assert last == pytest.approx(toy.angles[0], abs=1e-6)
        again = RunRequest(None, kept.about["options"]).to_scenario().simulate()
        assert float(again["angle"][-1]) == pytest.approx(last, abs=1e-12)

    @pytest.mark.parametrize(
        "act",
        [lambda t: t.push(1.0), lambda t: t.hold(0, 1.0), lambda t: t.set({"damping": 0.01})],
        ids=["push", "drag", "damping"],
    )
    def test_what_a_hand_did_is_kept_as_samples_with_a_note(self, act):
        toy = toy_of()
        run_on(toy, 3)
        toy.record()
        run_on(toy, 0.5)
        act(toy)
        run_on(toy, 1)
        kept = keep(toy.finish())
        assert not kept.about["reproduces"]
        assert "hand" in kept.run.attrs["note"]
        assert "scenario" not in kept.run.attrs
        assert float(kept.run["angle"][-1]) == toy.angles[0]
        about, arrays = unpack(kept.block())
        assert arrays["time"][-1] == pytest.approx(1.5)
        assert about["python"] == ""
        # What came in, the hand's work too, is what went out and what is left.
        end = {name: float(kept.run[name][-1]) for name in kept.run if name in LEDGER}
        came = end["drive_work"] + end.get("noise_work", 0.0)
        gone = end["damping_loss"] + end["impact_loss"] + end["capture_loss"]
        total = kept.run["total_energy"].values
        assert total[-1] - total[0] == pytest.approx(came - gone, abs=1e-6 * total.max())

    def test_a_chaotic_motion_is_kept_as_it_was_seen(self):
        toy = toy_of("chaos")
        toy.record()
        run_on(toy, 60)
        kept = keep(toy.finish())
        assert kept.about["gap"] > SAME
        assert not kept.about["reproduces"]
        assert "chaotic" in kept.run.attrs["note"]
        assert float(kept.run["angle"][-1]) == toy.angles[0]

    def test_a_recording_waits_for_a_steady_drive(self):
        toy = toy_of()
        toy.set({"drive_amplitude": 0.06})
        toy.record()
        toy.advance()
        assert toy.is_recording
        assert toy.recording is None
        run_on(toy, 0.5)
        assert toy.recording is not None

    def test_contacts_are_kept_at_their_instants(self):
        toy = toy_of(drive="harmonic", drive_amplitude="40 mm", drive_frequency="19.8 rad/s")
        toy.record()
        run_on(toy, 6)
        kept = keep(toy.finish())
        kinds = set(map(str, kept.run["contact_kind"].values))
        assert kinds <= set(CONTACT_KINDS)
        assert "bottom" in kinds
        assert np.all(np.diff(kept.run["contact_time"].values) >= 0.0)


@pytest.fixture
def client():
    with TestClient(make_app(Settings()), base_url=HOME) as found:
        yield found


def connect(client, origin=HOME):
    return client.websocket_connect(
        "/ws/live", headers={"origin": origin, "host": "127.0.0.1:8000"}
    )


def greet(socket, **hello):
    socket.send_text(json.dumps({"hello": {"scenario": "fig12", **hello}}))
    return json.loads(socket.receive_text())


def frame_of(socket):
    data = socket.receive_bytes()
    return dict(zip(FRAME, struct.unpack(f"<{len(FRAME)}d", data), strict=True))


def frames_until(socket, fits, most=300):
    """The frames up to the first that fits, each acknowledged."""
    found = []
    for _ in range(most):
        found.append(frame_of(socket))
        socket.send_text(json.dumps({"ack": int(found[-1]["number"])}))
        if fits(found[-1]):
            return found
    raise AssertionError(f"no frame fits; the last was {found[-1]}")


def told_by(socket):
    """The next text among the frames."""
    for _ in range(MOST_UNSEEN + 5):
        message = socket.receive()
        if message.get("text"):
            return json.loads(message["text"])
    raise AssertionError("the server told nothing")


class TestSocket:
    def test_a_frame_with_the_number_of_a_message_shows_what_it_asked_for(self, client):
        with connect(client) as socket:
            ready = greet(socket)["ready"]
            assert ready["controls"]["drive_amplitude"] == 0.03
            before = frames_until(socket, lambda f: f["number"] >= 3)[-1]
            assert before["seq"] == 0.0
            assert before["drive_amplitude"] == 0.03
            socket.send_text(json.dumps({"seq": 7, "set": {"drive_amplitude": 0.035}}))
            first = frames_until(socket, lambda f: f["seq"] == 7)[-1]
            assert 0.03 < first["drive_amplitude"] <= 0.035
            settled = frames_until(socket, lambda f: f["drive_amplitude"] == 0.035)[-1]
            assert settled["seq"] == 7

    def test_time_goes_on_by_ticks_and_stands_still_in_a_pause(self, client):
        with connect(client) as socket:
            greet(socket)
            times = [f["time"] for f in frames_until(socket, lambda f: f["number"] == 8)]
            ticks = np.diff(times) * 60
            np.testing.assert_allclose(ticks, np.round(ticks), atol=1e-9)
            assert ticks.min() >= 1 - 1e-9
            socket.send_text('{"pause": true}')
            held = frames_until(socket, lambda f: f["flags"] == 1)[-1]
            later = frames_until(socket, lambda f: f["number"] >= held["number"] + 5)[-1]
            assert later["time"] == held["time"]

    def test_frames_are_left_out_for_a_page_that_does_not_follow(self, client):
        session = Session()
        session.begin({"scenario": "fig12"})
        sent = [session.frame() for _ in range(MOST_UNSEEN + 5)]
        assert sent.count(None) == 5
        session.apply({"ack": 10})
        assert session.frame() is not None

    def test_a_page_whose_server_was_restarted_goes_on_where_it_was(self, client):
        state = {
            "time": 41.0, "phase": 1.0, "drive_amplitude": 0.02, "drive_frequency": 15.0,
            "angles": [0.6], "velocities": [-1.0],
        }  # fmt: skip
        controls = {"drive_amplitude": 0.02, "drive_frequency": 15.0, "restitution": 0.5}
        with connect(client) as socket:
            ready = greet(socket, state=state, controls=controls)["ready"]
            assert ready["controls"]["restitution"] == 0.5
            first = frame_of(socket)
            assert 41.0 <= first["time"] < 41.5
            assert 0.3 < first["angle_1"] < 0.65

    def test_a_recording_is_told_and_can_be_fetched(self, client, tmp_path):
        with connect(client) as socket:
            greet(socket)
            socket.send_text('{"record": true}')
            frames_until(socket, lambda f: f["recorded"] > 0.3)
            socket.send_text('{"record": false, "seq": 3}')
            told = told_by(socket)["recorded"]
            assert told["reproduces"]
            about, arrays = unpack(client.get(f"/api/recording/{told['name']}.block").content)
            assert about["duration"] == arrays["time"][-1] == told["duration"]
            path = tmp_path / "live.nc"
            path.write_bytes(client.get(f"/api/recording/{told['name']}.nc").content)
            assert ll.load(path).sizes["time"] == len(arrays["time"])
            text = client.get(f"/api/recording/{told['name']}.csv").text
            assert "angle" in text
            assert client.get(f"/api/recording/{told['name']}.exe").status_code == 404
        assert client.get("/api/recording/none.nc").status_code == 404

    def test_a_page_of_another_site_gets_no_toy(self, client):
        with pytest.raises(WebSocketDisconnect), connect(client, "http://evil.example"):
            pass

    @pytest.mark.parametrize(
        "hello",
        [
            {"scenario": "fig05"},
            {"scenario": "../x"},
            {"options": {"length": "-1 m"}},
            {"options": {"drive": "harmonic", "drive_frequency": "1e8 rad/s"}},
            {"state": {"time": "x"}},
            {"state": 3},
            {"controls": [1]},
            {"controls": {"drive_amplitude": 1e9}},
        ],
    )
    def test_a_bad_hello_is_refused_with_one_line_and_a_good_one_may_follow(self, client, hello):
        with connect(client) as socket:
            told = greet(socket, **hello)
            assert "\n" not in told["error"]
            assert "ready" in greet(socket)

    @pytest.mark.parametrize(
        "more", ["x" * 1_000_000, '{"seq": 1}' + " " * 20_000, "[" * 9_000, '{"a":', "", "NaN"]
    )
    def test_a_frame_that_makes_no_sense_is_told_and_the_toy_goes_on(self, client, more):
        with connect(client) as socket:
            greet(socket)
            socket.send_text(more)
            assert told_by(socket)["error"]
            assert frame_of(socket)["number"] > 0

    def test_bytes_are_refused(self, client):
        with connect(client) as socket:
            greet(socket)
            socket.send_bytes(b"\x00\xff" * 100)
            assert "must be text" in told_by(socket)["error"]

    def test_a_page_that_sends_nothing_but_nonsense_is_cut_off(self, client):
        with connect(client) as socket:
            greet(socket)
            for _ in range(MOST_ERRORS):
                socket.send_text("?")
            while (message := socket.receive())["type"] != "websocket.close":
                pass
            assert message["code"] == 1008

    def test_only_so_many_toys_move_at_once(self, client, monkeypatch):
        monkeypatch.setattr(live, "MOST_SESSIONS", 1)
        with connect(client) as socket:
            greet(socket)
            with pytest.raises(WebSocketDisconnect) as caught, connect(client) as second:
                second.receive()
            assert caught.value.code == 1013


NUMBERS = st.floats(allow_nan=True) | st.integers(-(2**70), 2**70)
VALUES = st.recursive(
    st.none() | st.booleans() | NUMBERS | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner),
    max_leaves=6,
)
KEYS = st.sampled_from(["seq", "ack", "set", "push", "drag", "pause", "record", "reset", "x"])
NAMES = st.sampled_from(["drive_amplitude", "drive_frequency", "damping", "ball", "angle"])
MESSAGES = st.one_of(
    st.text(max_size=40),
    st.binary(max_size=40).map(lambda b: b.decode("latin-1")),
    st.dictionaries(KEYS, VALUES | st.dictionaries(NAMES, VALUES), max_size=4).map(json.dumps),
)


@pytest.fixture(scope="module")
def session():
    found = Session()
    found.begin({"scenario": "fig12"})
    return found


@settings(
    max_examples=300, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(MESSAGES)
def test_no_message_breaks_a_session(session, text):
    try:
        session.apply(parsed(text))
    except InputError as error:
        answer = json.loads(live.told(error))
        assert answer["error"]
        assert "\n" not in answer["error"]
    session.paused = False
    session.advance(1)
    session.number = session.acked = 0
    assert len(session.frame()) == 8 * len(FRAME)
    assert all(map(math.isfinite, struct.unpack(f"<{len(FRAME)}d", session.frame())))
