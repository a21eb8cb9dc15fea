"""Balls that rest for longer than they move: what is behind them, and where they are."""

import math
import warnings

import numpy as np
import pytest

import latolato as ll
from latolato.core.errors import InputError
from latolato.experiment.follow import _check_motion
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.synthetic.synthesise import synthesise_video
from latolato.experiment.tracking.background import background_of
from latolato.experiment.tracking.detect import Blobs, Copies
from latolato.experiment.tracking.link import Trajectory, are_alike
from latolato.experiment.tracking.positions import Positions
from latolato.experiment.tracking.route import (
    _are_one,
    _meeting,
    _told_apart,
    _touching,
    find_route,
    radius_of_parts,
)

WALL, BALL = np.array([180, 120, 130]), np.array([90, 100, 190])


def pictures(places, *, texture=0.0, seed=0):
    """Return small pictures of a disc at places on a thin rod, shape (frame, 60, 80, 3)."""
    rng = np.random.default_rng(seed)
    rows, columns = np.mgrid[:60, :80]
    wall = WALL + texture * rng.standard_normal((60, 80, 1))
    out = []
    for u, v in places:
        picture = wall + rng.normal(0.0, 0.5, (60, 80, 3))
        along = np.clip((rows - 5.0) / (v - 5.0), 0.0, 1.0)
        is_rod = (np.abs(columns - (40.0 + along * (u - 40.0))) < 1.0) & (rows > 5) & (rows < v)
        is_ball = np.hypot(columns - u, rows - v) < 7.0
        picture[is_rod], picture[is_ball] = (60, 128, 128), BALL
        out.append(picture)
    return np.rint(np.clip(out, 0, 255)).astype(np.uint8), wall


@pytest.mark.parametrize("texture", [0.0, 8.0])
@pytest.mark.parametrize("resting", ["at the end", "at first", "never"])
def test_the_background_is_the_wall_wherever_a_ball_rests(resting, texture):
    swing = 40.0 + 30.0 * np.cos(np.linspace(0.0, 12.0, 30)), np.full(30, 45.0)
    still = {"at the end": (40.0, 46.0), "at first": (70.0, 30.0), "never": None}[resting]
    moving = np.column_stack(swing)
    rest = np.tile(still, (70, 1)) if still else np.empty((0, 2))
    places = np.concatenate([rest, moving] if resting == "at first" else [moving, rest])
    seen, wall = pictures(places, texture=texture)
    off = np.abs(background_of(seen) - wall).max(axis=-1)
    # All of the ball and its rod but for their ends at the pivot, where the rod always is.
    assert np.quantile(off[12:], 0.999) < 6.0 + 0.5 * texture


def test_what_never_leaves_its_place_belongs_to_the_background():
    seen, _ = pictures(np.tile([40.0, 45.0], (40, 1)))
    assert np.abs(background_of(seen)[42:49, 37:44] - BALL).max() < 6


@pytest.mark.parametrize("reach", [5.0, 7.0])  # in most frames the ball covers its middle
def test_the_background_is_the_wall_behind_a_ball_that_never_leaves_its_place(reach):
    swing = 40.0 + reach * np.cos(np.linspace(0.0, 12.0, 61))
    seen, wall = pictures(np.column_stack([swing, np.full(61, 45.0)]))
    assert np.abs(np.median(seen, axis=0) - wall)[45, 40].max() > 50.0
    # But for the rod, which is always near the pivot.
    assert np.abs(background_of(seen) - wall)[35:].max() < 6.0


def test_a_ball_that_moves_only_in_a_few_frames_stays_in_the_background():
    still = np.tile([40.0, 45.0], (61, 1))
    still[::20, 0] += 5.0
    seen, _ = pictures(still)
    assert np.abs(background_of(seen) - np.median(seen, axis=0)).max() <= 1.0


@pytest.mark.parametrize("nearest", [2.1, 3.1])  # radii between the centres
def test_balls_meet_only_where_they_may_touch(nearest):
    times = np.arange(90) / 30.0
    swing = 40.0 * (1.0 - np.cos(6.0 * times))
    own = np.column_stack([100.0 - swing, np.full(90, 50.0)])
    other = np.column_stack([100.0 + 10.0 * nearest + swing, np.full(90, 50.0)])
    radii, looks = np.full(90, 10.0), np.tile(BALL, (90, 1)).astype(float)
    one = np.ones(1)
    left = [
        Blobs(place[None], 10 * one, 10 * one, 90 * one, looks[:1], WALL[None].astype(float))
        for place in other
    ]
    meets = _meeting(times, Trajectory(own, radii, radii, looks), left)
    assert np.isfinite(meets) == (nearest < 2.5)


def test_a_path_that_changes_balls_at_an_impact_is_no_second_ball():
    angle = 0.8 * np.cos(np.linspace(0.0, 9.0, 90))

    def path(sides):
        places = 200.0 * np.column_stack([sides * np.abs(np.sin(angle)), np.cos(angle)])
        places[:, 0] += sides * 10.0
        one = np.full(90, 10.0)
        return Trajectory(places, one, one, np.tile(BALL, (90, 1)).astype(float))

    right, left = path(np.ones(90)), path(-np.ones(90))
    crossing = path(np.where(np.arange(90) < 45, 1.0, -1.0))
    assert are_alike(right, left)
    assert not are_alike(right, crossing)


def test_two_balls_in_one_blob_are_one_on_each_side_of_it():
    times = np.arange(60) / 60.0
    places = np.full((60, 2, 2), np.nan)
    places[:20, 0] = np.column_stack([np.linspace(180.0, 112.0, 20), np.full(20, 200.0)])
    places[:20, 1] = np.column_stack([np.linspace(20.0, 88.0, 20), np.full(20, 200.0)])
    places[20:, 0] = [100.0, 200.0]  # what is seen there is both
    is_one = _are_one(times, places, 10.0)
    assert is_one[20:].all()
    assert not is_one[:20].any()
    # Half the length of the ellipse of two discs; without a gap they are a radius from the middle.
    for gap, away in ((0.0, 10.0), (5.0, 12.5), (-8.0, 10.0)):
        lengths = np.full(40, np.sqrt(10.0**2 + (20.0 + gap) ** 2))
        touching = _touching(places[20:, 0], lengths, np.array([100.0, 0.0]), 10.0)
        ends = np.tile([100.0 - away, 100.0 + away], (40, 1))
        np.testing.assert_allclose(np.sort(touching[..., 0], axis=1), ends)
    # One that is out of sight somewhere else is not in the blob.
    places[:20, 1, 0] -= 200.0
    assert not _are_one(times, places, 10.0).any()


def test_balls_that_are_two_blobs_in_between_are_no_single_one():
    places = np.full((4, 2, 2), np.nan)
    places[:, 1] = [100.0, 200.0]
    # Like it and beside it; too long; too far away; none.
    others = [([130.0, 200.0], 10.0), ([130.0, 200.0], 40.0), ([160.0, 200.0], 10.0), None]
    left = [
        Blobs.of([(*one[0], 10.0, one[1], 90.0, *BALL, *WALL)] if one else [], 1) for one in others
    ]
    found = _told_apart(left, places, np.arange(4), 10.0)
    assert found.tolist() == [True, False, False, False]
    assert places[0, 0].tolist() == [130.0, 200.0]
    assert np.isnan(places[1:, 0]).all()


@pytest.mark.parametrize("restitution, damping", [(0.75, 0.03), (0.9, 0.02)])
def test_balls_that_clack_until_they_rest_are_measured_to_the_end(restitution, damping, tmp_path):
    # In most frames they touch or nearly do: the median shows them, and they are one blob.
    toy = ll.LatoLato(length=0.25, mass=0.1, radius=0.028, restitution=restitution, damping=damping)
    run = ll.simulate(toy, initial_angle=0.9, duration=5.0)
    camera = Camera(width=480, height=360, fps=60.0)
    truth = synthesise_video(run, tmp_path / "toy.mp4", Scene(), camera, seed=2)
    pivot, *balls = (
        tuple(truth.attrs[f"{part}_pixel_{axis}"] for axis in "uv")
        for part in ("pivot", "ball_1", "ball_2")
    )
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "(the|only|1 frame|[0-9]+ frames)", RuntimeWarning)
        table = ll.track(tmp_path / "toy.mp4", pivot=pivot, balls=balls, length=0.25, radius=0.028)
    for ball in (1, 2):
        is_measured = table[f"flag_{ball}"].isin(["ok", "collision"]).values
        assert is_measured.mean() > 0.98
        off = (table[f"angle_{ball}"].values - truth[f"angle_{ball}"].values)[is_measured]
        assert np.sqrt(np.mean(off**2)) < 2e-3
        assert np.abs(off).max() < 0.02


@pytest.mark.parametrize("turn", [0.0, 0.5, 1.4])
@pytest.mark.parametrize("radius", [None, 8.0])
def test_a_stripe_like_the_wall_leaves_a_ball_one(radius, turn):
    times, arm = np.arange(80) / 30.0, 45.0
    angle = 0.2 + np.abs(0.8 * np.cos(5.0 * times))  # two that mirror each other, and meet
    places = 5.0 + arm * np.stack(
        [[45.0 / arm + np.sin(angle), np.cos(angle)], [45.0 / arm - np.sin(angle), np.cos(angle)]]
    ).transpose(2, 0, 1)
    rows, columns = np.mgrid[:70, :100]
    rng, pictures = np.random.default_rng(1), []
    for pair in places:
        picture = WALL + rng.normal(0.0, 0.5, (70, 100, 3))
        for u, v in pair:
            across = (columns - u) * np.cos(turn) - (rows - v) * np.sin(turn)
            is_ball = (np.hypot(columns - u, rows - v) < 8.0) & (np.abs(across) > 2.5)
            picture[is_ball] = BALL
        pictures.append(picture)
    copies = Copies(np.rint(pictures).astype(np.uint8), 1, (np.zeros(2), np.array([99.0, 69.0])))
    assert min(len(blobs.radii) for blobs in copies.blobs[:5]) == 4
    pivots = [np.array([50.0, 5.0])] * 2
    route = find_route(copies, times, [*places[0]], 0, radius, np.zeros(80, bool), pivots).ordered(
        pivots[0]
    )
    off = np.linalg.norm(route.places - places, axis=-1)
    assert np.isfinite(off).all()
    assert route.is_seen.mean() > 0.8
    assert off[route.is_seen].max() < 2.0
    # What nobody parts is whole, and so is what has parts on one side only.
    assert math.isnan(radius_of_parts(copies.blobs[0], [places[0, 0] + 4.0]))
    assert radius_of_parts(copies.blobs[0], [*places[0]]) == pytest.approx(8.0, rel=0.25)


def test_a_ball_that_always_rests_has_no_length_to_tell_balls_apart():
    times, arm = np.arange(60) / 30.0, 60.0
    swings = 0.27 + np.maximum(0.0, 0.7 * np.cos(3.0 * times))
    away = arm * np.stack([np.sin(swings), np.cos(swings)], axis=-1)
    places = np.stack([away, np.tile([0.0, arm], (60, 1))], axis=1)
    places += np.array([70.0, 5.0])
    rows, columns = np.mgrid[:90, :140]
    rng, pictures = np.random.default_rng(1), []
    for k, pair in enumerate(places):
        picture = WALL + rng.normal(0.0, 0.5, (90, 140, 3))
        for u, v in pair[1:] if 28 <= k < 46 else pair:  # a hand hides the one that swings
            picture[np.hypot(columns - u, rows - v) < 8.0] = BALL
        pictures.append(picture)
    copies = Copies(np.rint(pictures).astype(np.uint8), 1, (np.zeros(2), np.array([139.0, 89.0])))
    pivots = [np.array([70.0, 5.0])] * 2
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        route = find_route(copies, times, [*places[0]], 0, 8.0, np.zeros(60, bool), pivots)
    assert route.is_traced
    assert np.linalg.norm(route.places - places, axis=-1)[route.is_seen].max() < 1.0


def test_what_leaps_about_at_its_place_and_is_often_lost_is_no_ball():
    times = np.arange(100) / 60.0
    seen = Positions.unknown(times, 1, 3.0)
    seen.flags[:] = "ok"
    seen.centres[:, 0] = [455.0, 220.0]
    seen.centres[:, 0] += np.random.default_rng(1).normal(0.0, 1.2, (100, 2))
    _check_motion(seen, 0.9)  # a ball at rest that is always seen
    with pytest.raises(InputError, match="does not swing: it jumps about"):
        _check_motion(seen, 0.5)
    seen.centres[:, 0, 0] = 455.0 + 4.0 * np.sin(5.0 * times)
    _check_motion(seen, 0.5)  # a small swing


def test_a_toy_that_comes_to_rest_is_found_and_followed_to_the_end(tmp_path):
    toy = ll.LatoLato(length=0.245, mass=0.108, radius=0.02, restitution=0.4, damping=0.003)
    drive = ll.Harmonic(drive_amplitude=0.01, drive_frequency=16.0)
    run = ll.simulate(toy, drive, initial_angle=1.2, duration=3.0)
    camera = Camera(width=400, height=300, fps=60.0)
    truth = synthesise_video(run, tmp_path / "toy.mp4", Scene(), camera, seed=2)
    with pytest.warns(RuntimeWarning, match="found in the video"):
        table = ll.track(tmp_path / "toy.mp4", balls=2, length=0.245)
    assert "too slow" not in table.attrs["warnings"]  # rest tells no pace
    for ball in (1, 2):
        is_measured = table[f"flag_{ball}"].isin(["ok", "collision"]).values
        assert is_measured.mean() > 0.97
        off = (table[f"angle_{ball}"].values - truth[f"angle_{ball}"].values)[is_measured]
        assert np.sqrt(np.mean(off**2)) < 3e-3
        assert np.mean(np.abs(off) < 2.0 * table[f"angle_sigma_{ball}"].values[is_measured]) > 0.93
