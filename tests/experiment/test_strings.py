"""Pivots where strings meet, and what moves on as a ball does."""

import warnings
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

import latolato as ll
from latolato.experiment.calibration.orbit import circle
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.synthetic.synthesise import synthesise_video
from latolato.experiment.tracking.detect import Copies
from latolato.experiment.tracking.link import Trajectory, are_alike
from latolato.experiment.tracking.propose import _followed, _share_circle
from latolato.experiment.tracking.strings import Lines
from latolato.experiment.video import Frame

PIVOT = np.array([90.0, 20.0])


def drawn(width, squeezed=1.0, pivot=PIVOT, length=80.0, swing=0.6):
    """Return pictures of a ball on a string, which is not drawn for no width, and its places."""
    angles = swing * np.cos(np.arange(80) / 5.0)
    away = length * np.column_stack([squeezed * np.sin(angles), np.cos(angles)])
    pictures = np.full((len(angles), 140, 180, 3), 128, np.uint8)
    pictures += np.random.default_rng(0).integers(0, 4, pictures.shape, np.uint8)
    for picture, place in zip(pictures, pivot + away, strict=True):
        ends = [tuple(np.rint(16.0 * at).astype(int).tolist()) for at in (pivot, place)]
        if width:
            cv2.line(picture, *ends, (60, 128, 128), width, cv2.LINE_AA, 4)
        cv2.circle(picture, ends[1], 16 * 6, (200, 128, 128), -1, cv2.LINE_AA, 4)
    return Copies(pictures, 1, (np.zeros(2), np.array([180, 140]))), pivot + away


@pytest.mark.parametrize("squeezed", [1.0, 0.6])
@pytest.mark.parametrize("width", [1, 3])
def test_strings_meet_at_the_pivot_of_a_circle_and_of_an_oval(width, squeezed):
    copies, places = drawn(width, squeezed)
    lines = Lines(copies, places, 6.0)
    meeting = lines.meeting()
    assert np.hypot(*(meeting - PIVOT)) < 2.0  # about the width of a string
    assert lines.share_at(meeting) > 2.0 * lines.share_at(PIVOT + 20.0)


def test_strings_that_are_not_seen_meet_nowhere_and_others_out_of_the_picture():
    copies, places = drawn(0)
    assert Lines(copies, places, 6.0).meeting() is None
    above = np.array([90.0, -40.0])
    meeting = Lines(*drawn(1, pivot=above, length=140.0), 6.0).meeting()
    assert np.hypot(*(meeting - above)) < 3.0


@pytest.mark.parametrize("swing", [0.1, 0.2])
def test_strings_of_a_ball_that_hardly_leaves_its_place_meet_at_the_pivot(swing):
    meeting = Lines(*drawn(2, swing=swing), 6.0).meeting()
    assert abs(meeting[0] - PIVOT[0]) < 1.0
    assert abs(meeting[1] - PIVOT[1]) < 4.0  # a twentieth of the arm
    assert Lines(*drawn(0, swing=swing), 6.0).meeting() is None


def trajectory(places):
    count = len(places)
    return Trajectory(places, np.full(count, 5.0), np.full(count, 5.0), np.zeros((count, 3)))


def about(pivot, arm, angles):
    return pivot + arm * np.column_stack([np.sin(angles), np.cos(angles)])


# Ways of things that move beside a ball, by its places; it hangs 80 pixels below the pivot.
BESIDE = {
    "other ball": lambda ball, turns: 2.0 * PIVOT * [1, 0] + ball * [-1, 1],
    "shadow": lambda ball, turns: ball + np.array([14.0, 6.0]),
    "large shadow": lambda ball, turns: PIVOT + 1.6 * (ball - PIVOT),
    "weight above": lambda ball, turns: 2.0 * PIVOT - ball,
    "dot that spins": lambda ball, turns: (
        PIVOT
        + np.array([120.0, 40.0])
        + 40.0 * np.column_stack([np.cos(2.0 * turns), np.sin(2.0 * turns)])
    ),
    "hand on an arc": lambda ball, turns: (
        PIVOT
        + np.array([60.0, 90.0])
        + 50.0 * np.column_stack([np.sin(0.7 * turns), np.cos(0.7 * turns)])
    ),
    "up and down": lambda ball, turns: np.column_stack(
        [np.full_like(turns, 150.0), 80.0 + 40.0 * np.sin(turns)]
    ),
}


@pytest.mark.parametrize("name", BESIDE)
def test_only_a_ball_swings_about_the_pivot_at_a_distance_that_varies(name):
    turns = np.arange(120) / 5.0
    angles = 0.4 + 0.35 * np.cos(turns)
    ball = about(PIVOT, 80.0, angles)
    first, other = trajectory(ball), trajectory(BESIDE[name](ball, turns))
    other.colours[:] = [200.0, 60.0, 90.0]
    sample = SimpleNamespace(times=np.arange(120) / 30.0, interval=1.0 / 30.0)
    assert not are_alike(first, other)
    assert _share_circle(first, other, sample) == (name == "other ball")


def test_what_crosses_the_picture_has_no_pivot_to_follow():
    places = np.column_stack([np.linspace(10.0, 310.0, 60), np.full(60, 120.0)])
    first = circle([place[None] for place in places], np.zeros((60, 2)))
    assert first.arm > 1e5
    plane = np.zeros((240, 320), np.uint8)
    frames = [Frame(k, k / 30.0, plane, plane[::2, ::2], plane[::2, ::2]) for k in range(60)]
    video = SimpleNamespace(width=320, height=240)
    groups = [place[None] for place in places]
    assert _followed(video, frames, groups, 8.0, first, None) is first


def test_a_swing_is_as_rough_as_its_frames_are_few_and_flicker_is_rougher():
    for count in (8, 30):
        turns = 2.0 * np.pi * np.arange(240) / count
        swing = trajectory(np.column_stack([100.0 * np.cos(turns), np.zeros(240)]))
        # Of a swing on a line only the mean over its phases is that of a circle.
        assert swing.roughness == pytest.approx(2.0 * np.sin(np.pi / count), rel=0.25)
    places = np.random.default_rng(0).choice([[0.0, 0.0], [90.0, 0.0], [0.0, 70.0]], 240)
    assert trajectory(places).roughness > 1.0


def test_parts_that_rest_elsewhere_are_no_part_of_a_swing():
    turns = np.arange(200) / 8.0
    places = np.column_stack([300.0 + 80.0 * np.sin(turns), 200.0 + 10.0 * np.cos(2.0 * turns)])
    places[60:90] = [40.0, 40.0]
    cleaned = trajectory(places).without_rests()
    assert not cleaned.is_seen[60:90].any()
    assert cleaned.is_seen.sum() == 170
    # A ball that rests where it swung, as after an impact, is still the ball.
    places[60:90] = places[100] + [3.0, 3.0]
    assert trajectory(places).without_rests().is_seen.all()


def tracked_without_clicks(path, initial_angle, **camera):
    """Return the true table of a clip of a free swing, and that which is found in it."""
    run = ll.simulate(ll.Pendulum(length=0.3, mass=0.1), initial_angle=initial_angle, duration=3.0)
    view = Camera(width=480, height=360, fps=40.0, **camera)
    truth = synthesise_video(run, path, Scene(ball_radius=0.02), view, seed=1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return truth, ll.track(path)


def off_by(truth, table, name):
    """Return how far a place that was found lies from the true one [pixels]."""
    names = [f"{name}_pixel_{axis}" for axis in "uv"]
    return np.hypot(*(table.attrs[each] - truth.attrs[each] for each in names))


def test_the_pivot_of_a_swing_seen_obliquely_is_found_without_clicks(tmp_path):
    truth, table = tracked_without_clicks(tmp_path / "aside.mp4", 0.9, yaw=0.6)
    assert off_by(truth, table, "pivot") < 4.0  # as near as a click
    assert abs(table.attrs["tilt"] - 0.6) < 0.05
    error = np.abs(table.angle_1.values - truth.angle_1.values)[table.flag_1.values == "ok"]
    assert np.mean(error < 0.02) > 0.9


def test_a_ball_that_never_leaves_its_place_is_found_without_clicks(tmp_path):
    truth, table = tracked_without_clicks(tmp_path / "small.mp4", 0.05, pixels_per_metre=800.0)
    assert off_by(truth, table, "pivot") < 12.0  # a twentieth of the arm
    assert off_by(truth, table, "ball_1") < 2.0  # as near as a click
    assert np.mean(table.flag_1.values == "ok") > 0.9
