"""Cameras that move a little, and pictures that come twice, late or not at all."""

from __future__ import annotations

import warnings

import cv2
import numpy as np
import pytest

import latolato as ll
from latolato.app.experiment.work import points_block
from latolato.core.errors import InputError
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.synthetic.synthesise import synthesise_video
from latolato.experiment.task import prepare
from latolato.experiment.track import run
from latolato.experiment.tracking.sample import Sample, even_times, read_sample
from latolato.experiment.tracking.steady import steadied
from latolato.experiment.video import open_video
from page_blocks import unpack
from videos import rewritten

SWING = ll.Pendulum(length=0.363, mass=0.1, damping=0.003)
WIDE = Camera(width=400, height=300, pixels_per_metre=330.0)
# How much of the wide picture a shaken one leaves out on each side.
LEFT, TOP = 40, 30


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """Return a function that films a swing of some angle once: the file and its true table."""
    folder = tmp_path_factory.mktemp("steady")
    made = {}

    def get(name, angle=0.9, **scene):
        if name not in made:
            run = ll.simulate(SWING, initial_angle=angle, duration=1.5)
            path = folder / f"{name}.mp4"
            made[name] = path, synthesise_video(run, path, Scene(**scene), WIDE, seed=3)
        return made[name]

    return get


def _tracked(path, truth, aside=(0, 0)):
    """Return the table, what was warned of, and errors of the samples that are ok [rad, sigma]."""
    clicks = truth.attrs
    pivot, ball = (
        (clicks[f"{name}_pixel_u"] - aside[0], clicks[f"{name}_pixel_v"] - aside[1])
        for name in ("pivot", "ball_1")
    )
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        table = ll.track(path, pivot=pivot, balls=[ball], length=SWING.length)
    errors = (table.angle_1 - truth.angle_1).values[table.flag_1 == "ok"]
    sigmas = table.angle_sigma_1.values[table.flag_1 == "ok"]
    return table, " ".join(str(one.message) for one in caught), errors, errors / sigmas


def _shaken(pixels):
    """Return a change that films a part of the picture by an unsteady hand."""

    def picture(frames, k):
        time = k / 60.0
        shift = pixels * np.sin(np.array([9.0, 13.0]) * time + [0.0, 0.4])
        turn = 0.001 * pixels * np.sin(7.0 * time)
        matrix = np.array([[1.0, -turn, shift[0]], [turn, 1.0, shift[1]]])
        moved = cv2.warpAffine(
            frames[k][1], matrix, (WIDE.width, WIDE.height), flags=cv2.INTER_CUBIC
        )
        return moved[TOP:-TOP, LEFT:-LEFT]

    return picture


@pytest.fixture(scope="module")
def shaken(film, tmp_path_factory):
    """The file that an unsteady hand filmed, and its true table."""
    path, truth = film("texture", background="texture")
    return rewritten(path, tmp_path_factory.mktemp("hand") / "shaken.mp4", _shaken(2.5)), truth


def test_a_hand_that_shakes_is_corrected_and_said(shaken):
    path, truth = shaken
    start = 2.5 * np.sin(0.4)
    table, warned, errors, ratios = _tracked(path, truth, (LEFT, TOP - start))
    assert "the camera moves by up to" in warned
    assert "corrected on the background" in warned
    # By 2.5 pixels each way, from where it was at first.
    assert 2.5 < table.attrs["camera_motion"] < 8.0
    assert len(errors) > 0.9 * table.sizes["frame"]
    # A shake of 2.5 pixels turns an arm of 120 pixels by 20 mrad.
    assert np.std(errors) < 0.003
    assert np.sqrt(np.mean(ratios**2)) < 1.5


def test_a_page_draws_marks_where_an_unsteady_camera_shows_the_ball(shaken):
    path, truth = shaken
    clicks = truth.attrs
    start = np.array([LEFT, TOP - 2.5 * np.sin(0.4)])
    wide = np.array([clicks["pivot_pixel_u"], clicks["pivot_pixel_v"]])
    ball = np.array([clicks["ball_1_pixel_u"], clicks["ball_1_pixel_v"]])
    task = prepare(path, wide - start, [ball - start], {"length": SWING.length})
    table = run(task)
    _, points = unpack(points_block(table, task.video, table.time.values))
    ones = np.vstack([points["centre"], np.ones(table.sizes["frame"])])
    marks = np.einsum("rcn,cn->rn", points["motion"].reshape(2, 3, -1), ones)
    away = np.stack([truth.ball_1_x, -truth.ball_1_y]) / clicks["metres_per_pixel"]
    times = np.arange(table.sizes["frame"]) / 60.0
    shift = 2.5 * np.sin(np.outer([9.0, 13.0], times) + np.array([[0.0], [0.4]]))
    turn = 0.0025 * np.sin(7.0 * times)
    u, v = away + wide[:, None]
    shown = np.stack([u - turn * v, turn * u + v]) + shift - [[LEFT], [TOP]]
    assert np.nanmax(np.hypot(*(marks - shown))) < 1.0
    assert np.nanmax(np.hypot(*(points["centre"] - shown))) > 3.0
    # Where a frame is corrected by hand, the page draws the place that was clicked.
    at = int(np.argmax(np.hypot(*(points["centre"] - shown))))
    options = {"length": SWING.length, "corrections": ((at, 1, *shown[:, at]),)}
    task = prepare(path, wide - start, [ball - start], options)
    table = run(task)
    assert table.flag_1.values[at] == "manual"
    _, points = unpack(points_block(table, task.video, table.time.values))
    matrix = points["motion"].reshape(2, 3, -1)[..., at]
    mark = matrix @ [*points["centre"][:, at], 1.0]
    assert mark == pytest.approx(shown[:, at], abs=0.01)


def test_a_hand_that_shakes_too_much_is_refused(film, tmp_path):
    path, truth = film("texture", background="texture")
    shaken = rewritten(path, tmp_path / "shaken.mp4", _shaken(9.0))
    with pytest.raises(InputError, match="the camera moves: the background shifts"):
        _tracked(shaken, truth, (LEFT, TOP - 9.0 * np.sin(0.4)))


@pytest.mark.parametrize(
    "name,scene",
    [
        ("texture", {"background": "texture"}),
        ("post", {"post_width": 0.05}),
        ("big", {"ball_radius": 0.16, "pattern": 0.5, "angle": 0.1}),
    ],
)
def test_frames_of_a_camera_at_rest_stay_as_they_are(film, name, scene):
    path, _ = film(name, **scene)
    video = open_video(path)
    sample = read_sample(video)
    # Nothing is pointed at: ball and rod are not left out.
    assert steadied(video, sample) == (video, sample)


def test_pictures_that_come_twice_are_said_and_not_measured(film, tmp_path):
    path, truth = film("plain")
    late = {17, 18, 50, 63}
    twice = rewritten(path, tmp_path / "twice.mp4", lambda f, k: f[k - (k in late) - (k == 18)][1])
    table, warned, _, ratios = _tracked(twice, truth)
    assert "4 frames repeat the previous picture" in warned
    assert set(np.flatnonzero(table.flag_1 != "ok")) == late
    assert np.abs(ratios).max() < 4.0


def test_frames_that_are_missing_are_said():
    times = np.delete(np.arange(40) / 60.0, [7, 20, 21])
    assert np.flatnonzero(Sample(times, []).gaps).tolist() == [7, 19]
    assert Sample(times, []).gaps.sum() == 3
    # Frames that come when something changes.
    assert not Sample(np.cumsum([0.1, 0.4, 0.05, 0.1, 0.3, 0.02, 0.5] * 6), []).gaps.any()


def test_errors_of_time_stamps_are_in_the_deviations(film, tmp_path):
    path, truth = film("plain")
    off = np.random.default_rng(2).normal(0.0, 0.002, truth.sizes["frame"])
    late = rewritten(path, tmp_path / "late.mp4", lambda f, k: f[k][1], late=lambda k: off[k])
    table, warned, _, _ = _tracked(late, truth)
    assert "the time stamps are off by about" in warned
    # The true angle at the time that the file says.
    speeds = np.gradient(truth.angle_1.values, truth.time.values)
    shifted = truth.angle_1.values + speeds * (table.time.values - truth.time.values)
    errors = (table.angle_1.values - shifted)[table.flag_1 == "ok"]
    sigmas = table.angle_sigma_1.values[table.flag_1 == "ok"]
    # All angles share the error of gravity's direction.
    sigmas = np.sqrt(sigmas**2 - table.attrs["angle_offset_sigma"] ** 2)
    assert 0.3 < np.sqrt(np.mean(((errors - errors.mean()) / sigmas) ** 2)) < 1.3


def test_pictures_at_their_times_are_warned_of_nothing(film):
    _, warned, _, _ = _tracked(*film("plain"))
    assert "repeat" not in warned
    assert "time stamps" not in warned


def test_pictures_that_are_repeated_regularly_lie_evenly_in_time():
    # From 24 to 30 frames a second.
    times = np.arange(100) / 30.0
    repeats = np.arange(100) % 5 == 4
    changes = np.where(repeats, 0.0, 10.0)
    even = even_times(times, repeats, changes)
    assert np.diff(even[~repeats]) == pytest.approx(1.0 / 24.0, rel=1e-6)
    assert (np.diff(even) > 0.0).all()
    # At turning points next to nothing moves: nothing is repeated there.
    turning = 10.0 * np.abs(np.sin(np.pi * (np.arange(100) - 4.0) / 10.0))
    assert even_times(times, np.arange(100) % 10 == 4, turning) is times
    # A camera that was late now and then.
    assert even_times(times, np.isin(np.arange(100), [3, 9, 40, 80]), changes) is times
