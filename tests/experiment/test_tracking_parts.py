"""Parts of the tracker against exact answers: layers, prediction, geometry of the circle."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

import latolato as ll
from latolato.experiment.calibration.deviations import (
    honest_deviations,
    scatter_of,
    time_scatter,
)
from latolato.experiment.calibration.gravity import (
    LEVELLED,
    Gravity,
    angle_offset_sigma,
    find_gravity,
)
from latolato.experiment.calibration.hinge import Hinge, find_hinge
from latolato.experiment.calibration.lens import Optics, lens_errors, undistorted
from latolato.experiment.calibration.swing import Motion
from latolato.experiment.tracking.appearance import Appearance, Colours, samples_for
from latolato.experiment.tracking.disc import disc_at
from latolato.experiment.tracking.edge import Shot, measured_edge
from latolato.experiment.tracking.kernels import fitting
from latolato.experiment.tracking.kernels import layers as kernels
from latolato.experiment.tracking.link import Trajectory
from latolato.experiment.tracking.paint import filled, turned
from latolato.experiment.tracking.pivot import PivotTracker, learn_template
from latolato.experiment.tracking.refine import (
    _Refiner,
    contact_times,
    may_be_other,
    take_off_turns,
)
from latolato.experiment.tracking.route import Route
from latolato.experiment.tracking.sample import _is_wanted, median_planes
from latolato.experiment.tracking.teach import Sighting, _learn_staying, _learn_turning
from latolato.experiment.video import Frame

# Luma of more pixels than are taken together, and chroma.
SHAPES = ((150, 202), (75, 101), (75, 101))


def _drawn(radius, blur, paint):
    """Return how a ball of some colours is drawn."""
    paint = np.dstack([paint, np.ones(paint.shape[:2])])[None].astype(np.float32)
    none = np.zeros((1, 1, 1, 4), np.float32)
    return kernels.Ball(radius, blur, paint, none, none[..., 0], False)


def _disc(centre, radius=10.0, blur=0.8, size=41, colour=(1.0, 0.5, 0.2)):
    """Return a layer (row, column, 4) with a disc of one colour."""
    layer = np.zeros((size, size, 4), np.float32)
    paint = np.ones((31, 31, 3)) * np.array(colour)
    path = np.atleast_2d(np.asarray(centre, float))
    ball = _drawn(radius, blur, paint)
    kernels.cover(path, np.zeros(len(path)), ball, 0, np.zeros(2), layer)
    return layer


@pytest.mark.parametrize("blur", [0.4, 0.8, 1.6])
@pytest.mark.parametrize("centre", [(20.0, 20.0), (20.37, 19.81)])
def test_a_disc_covers_its_area_whatever_its_place_and_blur(centre, blur):
    area = _disc(centre, blur=blur)[..., 3].sum()
    # A soft edge of a curved rim adds a share of about (blur / radius)^2.
    assert area == pytest.approx(math.pi * 100.0, rel=(blur / 10.0) ** 2 + 2e-3)


def test_a_smeared_disc_covers_the_same_area_about_the_middle_of_its_path():
    path = np.stack([np.linspace(15.0, 25.0, 21), np.full(21, 20.0)], axis=-1)
    layer = _disc(path)
    assert layer[..., 3].sum() == pytest.approx(_disc((20.0, 20.0))[..., 3].sum(), rel=1e-3)
    columns = np.arange(41)
    assert (layer[..., 3].sum(axis=0) @ columns) / layer[..., 3].sum() == pytest.approx(20.0)


@pytest.mark.parametrize("length", [10.0, 30.0, 70.0])
def test_few_places_along_an_arc_draw_what_many_do(length):
    radius, blur, arm, half = 12.0, 0.9, 150.0, 18
    j, i = np.mgrid[-half : half + 1, -half : half + 1]
    paint = np.stack([50.0 + 2.0 * i, 30.0 - j, 20.0 + 0.0 * i], axis=-1)

    def path(count):
        angles = 0.4 + length / arm * ((np.arange(count) + 0.5) / count - 0.5)
        return np.stack([arm * np.sin(angles), arm * np.cos(angles) - 75.0], axis=-1)

    pivot = np.array([0.0, -75.0])
    exact, drawn = np.zeros((2, 120, 140, 4), np.float32)
    ball = _drawn(radius, blur, paint)
    kernels.cover(path(400), np.zeros(400), ball, 0, np.zeros(2), exact)
    fitting.draw(path(samples_for(length)), np.zeros(2), pivot, ball, 0, np.zeros(2), drawn)
    assert drawn[..., 3].sum() == pytest.approx(exact[..., 3].sum(), rel=1e-4)
    assert np.abs(drawn - exact)[..., 3].max() < 0.05
    columns = np.arange(140)
    middles = [
        layer[..., 3].sum(axis=0) @ columns / layer[..., 3].sum() for layer in (exact, drawn)
    ]
    assert middles[0] == pytest.approx(middles[1], abs=0.02)


def test_unseen_places_take_the_colours_of_their_nearest_neighbours():
    known = np.random.default_rng(0).uniform(size=(30, 40, 3))
    j, i = np.indices(known.shape[:2])
    unseen = (np.hypot(i - 5.0, j - 2.0) < 6.0) | (np.hypot(i - 25.0, j - 18.0) < 4.5)
    behind = known.copy()
    behind[unseen] = np.nan
    result = filled(behind)
    assert (result[~unseen] == known[~unseen]).all()
    for row, column in np.argwhere(unseen):
        away = np.hypot(i - column, j - row)[~unseen]
        nearest = known[~unseen][away == away.min()]
        assert (nearest == result[row, column]).all(axis=1).any()


@pytest.mark.parametrize("guess", [20.0, 17.0])
def test_a_ball_of_two_colours_is_a_whole_disc(guess):
    # One half is lighter, the other darker than the wall.
    j, i = np.mgrid[:200, :200]
    luma = np.full((200, 200), 110, np.uint8)
    disc = np.hypot(i - 103.0, j - 98.0) < 20.0
    luma[disc] = np.where(i[disc] > 103, 190, 40)
    grey = np.full((100, 100), 128, np.uint8)
    colours = Colours(kernels.linear_light("srgb"), kernels.colour_coefficients("bt709", True))
    click, pivot = np.array([101.0, 100.0]), np.array([100.0, -80.0])
    centre, radius, _ = disc_at(
        Frame(0, 0.0, luma, grey, grey), colours, click, guess, pivot, False
    )
    assert np.allclose(centre, [103.0, 98.0], atol=1.5)
    assert radius == pytest.approx(20.0, rel=0.06)


def _shots(radius, blur, smear=0.0, metal=False, colour=(0.5, 0.12, 0.1), look=0):
    """Return cut-outs of a shaded ball on texture, along paths, with their shadows."""
    random = np.random.default_rng(3)
    shots, j, i = [], *np.mgrid[:91, :91]
    half = 40
    v, u = np.mgrid[-half : half + 1, -half : half + 1] / radius
    light = 0.35 + 0.65 * np.clip(0.7 - 0.4 * u - 0.5 * v, 0.0, 1.0)
    if metal:
        light = np.where(v < 0.1, 0.9, 0.35)
    paint = light[..., None] * np.array(colour)
    for _ in range(6):
        centre = 45.0 + random.uniform(-0.5, 0.5, 2)
        path = centre + np.stack([np.linspace(-0.5, 0.5, 9) * smear, np.zeros(9)], axis=-1)
        layer = np.zeros((91, 91, 4), np.float32)
        ball = _drawn(radius, blur, paint)
        kernels.cover(path, np.zeros(9), ball, 0, np.zeros(2), layer)
        waves = np.sin(0.3 * i + random.uniform(0, 6)) * np.sin(0.2 * j + random.uniform(0, 6))
        wall = (0.4 + 0.08 * waves)[..., None] * np.array([1.0, 0.9, 0.8])
        dark = 0.3 / (1.0 + np.exp((np.hypot(i - centre[0] - 9, j - centre[1] - 9) - radius) / 3))
        image = wall * (1.0 - dark - layer[..., 3])[..., None] + layer[..., :3]
        image += wall * (dark * layer[..., 3])[..., None]
        image += random.normal(0.0, 0.004, image.shape)
        shots.append(Shot(image, wall, path, np.array([45.0, -200.0]), 0.0, np.empty((0, 2)), look))
    return shots


@pytest.mark.parametrize("start", [0.87, 1.0, 1.14])
@pytest.mark.parametrize("smear,metal", [(0.0, False), (6.0, False), (0.0, True)])
def test_the_radius_does_not_depend_on_where_it_begins(start, smear, metal):
    shots = _shots(22.0, 0.9, smear, metal)
    edge = measured_edge(shots, start * 22.0, 0.6, is_far=True)
    assert edge.radius == pytest.approx(22.0, rel=0.01)
    assert edge.blur == pytest.approx(0.9, rel=0.35)
    assert abs(edge.radius - 22.0) < 3.0 * edge.sigma


def test_balls_of_different_colours_have_one_edge():
    light = (0.9, 0.85, 0.8)
    each = [_shots(22.0, 0.9), _shots(22.0, 0.9, colour=light, look=1)]
    edge = measured_edge([*each[0], *each[1]], 0.9 * 22.0, 0.6, is_far=True)
    assert edge.radius == pytest.approx(22.0, rel=0.01)
    assert edge.blur == pytest.approx(0.9, rel=0.35)
    # Taken for one look, their sectors have colours between the two, which no edge explains.
    alike = [*each[0], *_shots(22.0, 0.9, colour=light)]
    off = [abs(each.radius - 22.0) for each in (measured_edge(alike, 22.0, 0.9, False), edge)]
    assert off[0] > 3.0 * off[1]


def test_a_ball_whose_rim_is_out_of_the_picture_has_no_edge_to_measure():
    shots = _shots(22.0, 0.9)
    for shot in shots:
        shot.wall[np.hypot(*(np.indices((91, 91)) - 45)) > 10.0] = np.nan
    with pytest.raises(ll.InputError, match="outside the picture"):
        measured_edge(shots, 22.0, 0.9, is_far=False)
    beside = [dataclasses.replace(s, others=s.path[:1]) for s in _shots(22.0, 0.9)]
    with pytest.raises(ll.InputError, match="beside the other ball"):
        measured_edge(beside, 22.0, 0.9, is_far=False)


def _trajectory(places):
    """Return what moves there, a thing of 5 pixels radius."""
    count = len(places)
    return Trajectory(places, np.full(count, 5.0), np.full(count, 5.0), np.zeros((count, 3)))


def test_travel_counts_no_leaps_but_gaps_and_few_frames():
    swing = 100.0 * np.sin(np.arange(200) / 12.0)[:, None] * [1.0, 0.2]
    extent = np.hypot(*np.ptp(swing, axis=0))
    assert _trajectory(swing).travel == pytest.approx(extent)
    gap = swing.copy()
    gap[50:54] = np.nan
    assert _trajectory(gap).travel == pytest.approx(extent, rel=0.01)
    assert _trajectory(swing[::9]).travel == pytest.approx(extent, rel=0.02)
    resting = np.repeat([[0.0, 0.0], [300.0, 50.0], [100.0, 200.0]], 60, axis=0)
    resting += np.random.default_rng(1).normal(0.0, 0.2, resting.shape)
    assert _trajectory(resting).travel < 5.0


def _meeting(gap, rate, time, restitution=0.8):
    """Return times and angles of two balls that meet at a time, at the bottom."""
    times = np.arange(12) / 60.0
    late = times - time
    half = 0.5 * gap + np.where(late < 0.0, -rate * late, restitution * rate * late)
    return times, np.stack([half, -half], axis=-1)


@pytest.mark.parametrize("time", [0.0855, 0.09])
def test_contacts_are_found_between_frames_at_the_bottom_and_at_the_top(time):
    gap, rate = 0.2, 4.0
    times, angles = _meeting(gap, rate, time)
    assert contact_times(times, angles, gap) == pytest.approx([time])
    above = np.array([math.pi, -math.pi]) - angles
    assert contact_times(times, above, gap) == pytest.approx([time])
    apart = angles + np.array([0.3, -0.3])
    assert contact_times(times, apart, gap) == []


def test_balls_that_are_seen_alone_at_the_place_of_the_other_are_doubtful():
    # They swing 0.4 rad at 5 rad/s, 30 times a second; in a few frames, near contacts, only one is
    # seen, and taken for the other.
    swing = 0.09 + 0.31 * np.abs(np.cos(5.0 * np.arange(90) / 30.0))
    angles, good = np.column_stack([swing, -swing]), np.ones((90, 2), bool)
    taken = [9, 29, 47, 66]
    assert not may_be_other(angles, good, gap=0.15).any()
    angles[taken, 0] = -swing[taken]
    good[taken, 1] = False
    doubtful = may_be_other(angles, good, gap=0.15)
    assert np.flatnonzero(doubtful[:, 0]).tolist() == taken
    assert not doubtful[:, 1].any()


def test_balls_that_seem_to_pass_each_other_keep_their_order():
    # Two equal balls that bounce: detections go on as if one had passed through the other.
    times, angles = _meeting(0.2, 4.0, 0.0855)
    seen = angles.copy()
    seen[6:] = angles[6:, ::-1]
    pivot, arm = np.array([100.0, 50.0]), 80.0
    places = pivot + arm * np.stack([np.sin(seen), np.cos(seen)], axis=-1)
    places[5, 1] = np.nan
    route = Route(times, places, np.isfinite(places[..., 0]), 8.0, 8.0).ordered(pivot)
    found = np.arctan2(*np.moveaxis(route.places - pivot, -1, 0))
    known = np.isfinite(found).all(axis=1)
    assert known.sum() == 11
    np.testing.assert_allclose(found[known], angles[known], atol=1e-9)
    assert route.is_seen[5].tolist() == [True, False]


def test_normal_equations_find_a_shift_of_a_disc():
    behind = np.full((41, 41, 3), 0.3, np.float32)
    true, guess = np.array([20.3, 19.6]), np.array([20.0, 20.0])
    seen = _disc(true)
    ball = _drawn(10.0, 0.8, np.ones((27, 27, 3)))
    image = behind * (1.0 - seen[..., 3:]) + seen[..., :3]
    for _ in range(6):
        patch = kernels.Patch(image.astype(np.float32), behind, np.zeros(2), 1)
        _, matrix, vector, tally = kernels.normal_equations(
            patch, _disc(guess)[None], guess[None], np.array([20.0, -200.0]), ball, 3.0
        )
        guess = guess + np.linalg.solve(matrix, vector)
    # Differences of two pixels as slopes, and four-byte colours.
    assert np.allclose(guess, true, atol=1e-3)
    assert tally[0, 1] == tally[0, 0] > 200


@pytest.mark.parametrize("is_spinning", [False, True])
def test_colours_that_vary_do_not_draw_a_disc_aside(is_spinning):
    true, pivot = np.array([20.3, 19.6]), np.array([-179.7, 19.6])
    ball = _drawn(10.0, 0.8, np.tile(np.linspace(0.5, 1.0, 27)[:, None, None], (1, 27, 3)))
    ball = ball._replace(is_spinning=is_spinning)
    turn = math.atan2(*(true - pivot)) if is_spinning else 0.0
    behind = np.full((41, 41, 3), 0.3, np.float32)
    layer = np.zeros((1, 41, 41, 4), np.float32)
    kernels.cover(true[None], np.array([turn]), ball, 0, np.zeros(2), layer[0])
    image = behind * (1.0 - layer[0, ..., 3:]) + layer[0, ..., :3]
    # A stripe that was not there before, on the side of the rod.
    j, i = np.indices((41, 41))
    along = true[0] - i if is_spinning else true[1] - j
    image[(np.hypot(i - true[0], j - true[1]) < 8.0) & (along > 2.0) & (along < 6.0)] = 0.1
    known = np.zeros((27, 27), np.float32)
    known[6:12] = 1e6
    patch = kernels.Patch(image, behind, np.zeros(2), 1)
    steps = []
    for variance in (known, np.zeros((1, 1), np.float32)):
        _, matrix, vector, _ = kernels.normal_equations(
            patch, layer, true[None], pivot, ball._replace(variance=variance[None]), 30.0
        )
        steps.append(float(np.hypot(*np.linalg.solve(matrix, vector))))
    assert steps[0] < 1e-4
    assert steps[1] > 0.1


def _lit(angle, side=61):
    """Return the light of a ball with a bright stripe across its rod, darker on its left side."""
    j, i = np.indices((side, side)) - side // 2
    along = i * math.sin(angle) + j * math.cos(angle)
    return 0.25 + 0.3 * np.exp(-((along / 4.0) ** 2)) + 0.008 * i


def test_a_pattern_turns_with_the_rod_and_shading_stays():
    mix = kernels.colour_coefficients("bt709", is_full_range=False)
    colours = Colours(kernels.linear_light("srgb"), mix)
    angles = np.linspace(-0.7, 0.7, 15)
    frames, sightings = [], []
    chroma, centre, pivot = np.full((31, 31), 128, np.uint8), np.full(2, 30.0), np.zeros(2)
    for k, angle in enumerate(angles):
        coded = 1.055 * _lit(angle) ** (1.0 / 2.4) - 0.055
        luma = np.rint(16.0 + 219.0 * coded).astype(np.uint8)
        frames.append(Frame(k, 0.03 * k, luma, chroma, chroma))
        sightings.append(Sighting(k, centre, pivot, angle, 0.0, 1.0, np.zeros(2)))
    paint, behind = np.zeros((35, 35, 3)), np.zeros((61, 61, 3), np.float32)
    look = Appearance(colours, 14.0, 0.8, paint[None], behind, np.zeros(2, int), np.eye(3), 4.0)
    left = {}
    for learn in (_learn_staying, _learn_turning):
        learn(look, frames, sightings, 42.0)
        look.whitened()
        layer = look.ball(
            0, centre[None], centre - np.array([15.0, 50.0]), np.zeros(2, int), (61, 61)
        )
        # An angle of which no frame was seen.
        inside = np.hypot(*(np.indices((61, 61)) - 30)) < 9.0
        left[learn] = np.abs(layer[..., 0] - _lit(math.atan2(15.0, 50.0)))[inside].max()
    assert left[_learn_turning] < 0.03
    assert left[_learn_staying] > 0.1


def test_colours_of_smeared_balls_are_learned_without_the_wall():
    mix = kernels.colour_coefficients("bt709", is_full_range=False)
    colours = Colours(kernels.linear_light("srgb"), mix)
    arm, pivot, side = 60.0, np.array([70.0, 20.0]), 141
    j, i = np.indices((43, 43)) - 21
    paint = np.repeat((0.2 + 0.006 * i + 0.004 * j)[..., None], 3, axis=-1)
    behind, chroma = np.full((side, side, 3), 0.8, np.float32), np.full((71, 71), 128, np.uint8)
    look = Appearance(
        colours, 14.0, 0.8, paint[None], behind, np.zeros(2, int), np.eye(3), 4.0, exposure=0.9
    )
    frames, sightings = [], []
    for k, angle in enumerate(np.linspace(-0.7, 0.7, 15)):
        centre = pivot + arm * np.array([math.sin(angle), math.cos(angle)])
        # Smears of 13 pixels.
        one = Sighting(k, centre, pivot, angle, 0.24, 1.0, np.zeros(2))
        layer = look.ball(0, one.path(arm, 0.9), pivot, np.zeros(2, int), (side, side))
        light = layer[..., 0] + (1.0 - layer[..., 3]) * 0.8
        luma = np.rint(16.0 + 219.0 * (1.055 * light ** (1.0 / 2.4) - 0.055)).astype(np.uint8)
        frames.append(Frame(k, 0.03 * k, luma, chroma, chroma))
        sightings.append(one)
    _learn_staying(look, frames, sightings, arm)
    assert np.abs(look.paint[0] - paint)[np.hypot(i, j) < 12.0].max() < 0.03


def test_colours_that_are_turned_back_and_forth_are_the_same():
    paint = np.repeat(
        gaussian_filter(np.random.default_rng(1).random((41, 41)), 3.0)[..., None], 3, -1
    )
    there = turned(turned(paint, 0.4), -0.4)
    inside = np.hypot(*(np.indices((41, 41)) - 20)) < 15.0
    assert np.abs(there - paint)[inside].max() < 5e-3
    assert np.abs(turned(paint, 0.4) - paint)[inside].max() > 0.03


def test_colours_of_grey_planes_are_linear_light():
    luma = np.array([[16, 235, 126]], np.uint8)
    chroma = np.full((1, 2), 128, np.uint8)
    mix = kernels.colour_coefficients("bt709", is_full_range=False)
    out = Colours(kernels.linear_light("srgb"), mix).window((luma, chroma, chroma), (0, 0), (1, 3))
    # sRGB: half the coded range is 21.6 % of the light (IEC 61966-2-1); table of quarter steps.
    half = ((110 / 219 + 0.055) / 1.055) ** 2.4
    assert np.allclose(out[0, :, 0], [0.0, 1.0, half], atol=2e-3)
    assert np.ptp(out, axis=2).max() == 0.0


def _arc(offset, arm=300.0, wide=1.2, oval=0.0, count=200):
    """Return places of a ball about a hinge (column, row) and their angles."""
    angles = wide * np.sin(np.linspace(0.0, 20.0, count))
    radius = arm + oval * np.cos(2.0 * angles)
    away = np.stack([radius * np.sin(angles), radius * np.cos(angles)], axis=-1)
    return away + np.array(offset), angles


def test_the_hinge_is_the_middle_of_a_wide_arc():
    found = find_hinge(*_arc((1.5, -2.0)), noise=0.0)
    assert np.allclose(found.offset, [1.5, -2.0], atol=0.02)  # drawn to the click
    assert found.arm == pytest.approx(300.0, abs=0.02)
    assert found.arc == pytest.approx(2.4, rel=0.01)
    assert found.residual < 0.01
    assert not found.warnings


def test_the_hinge_is_known_the_worse_along_the_middle_the_narrower_the_arc():
    wide = find_hinge(*_arc((0.0, 0.0), wide=3.0), noise=0.0).sigma
    less = find_hinge(*_arc((0.0, 0.0), wide=0.55), noise=0.0).sigma
    assert wide == pytest.approx([0.15, 0.15], rel=0.05)  # what all frames share
    assert less[0] < 0.17
    assert 0.17 < less[1] < 0.4
    # The click tells, to a pixel, what the arc does not.
    narrow = find_hinge(*_arc((0.0, 0.0), wide=0.3), noise=0.0).sigma
    assert narrow[0] < 0.2
    assert 0.6 < narrow[1] < 1.0
    far = find_hinge(*_arc((0.0, 9.0)), noise=0.0).sigma
    assert far[1] == pytest.approx(9.0, rel=0.02)


@pytest.mark.parametrize(
    "case", [{"offset": (0.0, 9.0)}, {"offset": (0.5, 0.0), "oval": 2.0}], ids=["far", "oval"]
)
def test_what_is_no_circle_about_the_click_is_told_and_left(case):
    found = find_hinge(*_arc(**case), noise=0.0)
    assert np.all(found.offset == 0.0)
    assert "lens, perspective or rolling shutter" in found.warnings[0]


def test_a_pivot_that_sways_unseen_is_told_on_a_narrow_arc():
    away, angles = _arc((0.0, 0.0), wide=0.3)
    away[:, 0] += 6.0 * np.cos(np.linspace(0.0, 33.0, len(away)))
    found = find_hinge(away, angles, noise=0.0)
    assert "the pivot may sway by" in found.warnings[0]
    assert found.sway == pytest.approx(6.0, rel=0.3)


def test_a_narrow_arc_moves_the_hinge_across_and_little_along():
    found = find_hinge(*_arc((0.8, 2.0), wide=0.3), noise=0.0)
    assert found.offset[0] == pytest.approx(0.8, rel=0.05)
    assert 0.3 < found.offset[1] < 1.5
    assert not found.warnings


def test_a_very_narrow_arc_does_not_move_the_hinge():
    found = find_hinge(*_arc((2.0, 2.0), wide=0.01), noise=0.0)
    assert np.all(np.abs(found.offset) < 0.4)
    assert np.all(found.sigma > 0.9)


@pytest.mark.parametrize("wide", [0.1, 0.3, 0.6, 1.2, 3.0])
def test_the_error_of_the_hinge_is_as_large_as_its_deviation(wide):
    random = np.random.default_rng(4)
    pulls = []
    for _ in range(40):
        true, noise = random.standard_normal(2), 0.1 * random.standard_normal((200, 2))
        away, angles = _arc(true, wide=wide)
        found = find_hinge(away + noise, angles, noise=0.1)
        pulls.append((found.offset - true) / found.sigma)
    assert np.all(np.sqrt(np.mean(np.square(pulls), axis=0)) < 1.3)


def test_undistorting_undoes_the_lens():
    optics = Optics(lens_k1=-0.08, lens_k2=0.01)
    places = np.array([[100.0, 50.0], [639.5, 479.5], [1200.0, 900.0]])
    middle, unit = np.array([639.5, 479.5]), 800.0
    true = (places - middle) / unit
    square = np.sum(true**2, axis=1, keepdims=True)
    seen = middle + true * (1.0 - 0.08 * square + 0.01 * square**2) * unit
    assert np.allclose(undistorted(seen, (1280, 960), optics), places, atol=1e-6)


def _filmed(k1, wide, stroke=15.0):
    """Return places of a ball and its pivot in a picture of 640 x 480, and true and seen angles."""
    random = np.random.default_rng(6)
    angles = wide * np.sin(np.linspace(0.0, 25.0, 300))
    pivots = np.stack([np.full(300, 320.0), 150.0 + stroke * np.sin(np.arange(300.0))], axis=-1)
    balls = pivots + 250.0 * np.stack([np.sin(angles), np.cos(angles)], axis=-1)
    balls, pivots = (
        np.array([319.5, 239.5])
        + (places - [319.5, 239.5])
        * (1.0 + k1 * np.sum((places - [319.5, 239.5]) ** 2, axis=1, keepdims=True) / 400.0**2)
        for places in (balls, pivots)
    )
    balls = balls + 0.05 * random.standard_normal((300, 2))
    away = balls - pivots
    return balls[:, None], pivots[:, None], angles[:, None], np.arctan2(*away.T)[:, None]


# What is known of these places.
_KNOWN = {"use": np.ones((300, 1), bool), "size": (640, 480), "noise": 0.05}


@pytest.mark.parametrize("wide", [0.7, 1.2])
def test_a_lens_shows_in_the_path_and_what_it_does_to_angles_is_known(wide):
    balls, pivots, true, seen = _filmed(-0.08, wide)
    found = lens_errors(balls, pivots, angles=seen, pivot_sigma=1.0, **_KNOWN)
    assert found is not None
    assert np.ptp(seen - true) > 4e-3
    # What is left is the noise of 0.05 pixels in 250, and the common place of the centre.
    assert np.std(seen + found - true) < 1e-3


@pytest.mark.parametrize(
    "k1,wide,stroke", [(0.0, 1.2, 15.0), (0.0, 0.7, 15.0), (0.0, 0.7, 0.0), (-0.08, 0.1, 0.0)]
)
def test_no_lens_is_seen_without_one_or_in_a_narrow_arc_about_a_still_pivot(k1, wide, stroke):
    balls, pivots, _, seen = _filmed(k1, wide, stroke)
    assert lens_errors(balls, pivots, angles=seen, pivot_sigma=1.0, **_KNOWN) is None


def test_a_lens_that_moves_the_centre_of_a_pivot_at_rest_shows_by_a_click_on_the_pivot():
    balls, pivots, true, seen = _filmed(-0.08, 0.7, 0.0)
    clicked, unclicked = (
        lens_errors(balls, pivots, angles=seen, pivot_sigma=sigma, **_KNOWN)
        for sigma in (1.0, 50.0)
    )
    assert clicked is not None
    assert np.std(seen + clicked - true) < 0.2 * np.std(seen - true)
    assert unclicked is None


def test_scatter_is_the_noise_and_not_the_swing():
    times = np.cumsum(np.random.default_rng(1).uniform(0.8, 1.2, 2000)) / 60
    swing = 0.7 * np.sin(6.0 * times)
    noise = 1e-3 * np.random.default_rng(2).standard_normal(2000)
    assert scatter_of(times, swing) < 2e-5
    assert scatter_of(times, swing + noise) == pytest.approx(1e-3, rel=0.08)


def test_deviations_see_errors_that_last_for_many_frames():
    random = np.random.default_rng(4)
    times, arm = np.arange(600) / 60, 400.0
    # Errors of 0.4 pixels that last for ten frames, along and across; the fits say 0.05.
    lasting = np.convolve(random.standard_normal(629), np.hanning(30), "valid")[:600]
    along, across = 0.4 * lasting / lasting.std(), -0.4 * np.roll(lasting, 200) / lasting.std()
    angles = (0.7 * np.sin(6.0 * times) + along / arm)[:, None]
    sigmas, spreads = np.full((600, 1), 0.05 / arm), np.full((600, 1), 0.05)
    known = {"sigmas": sigmas, "spreads": spreads, "is_clean": np.ones((600, 1), bool), "arm": arm}
    found = honest_deviations(times, angles, off=across[:, None], **known)
    assert np.median(found) * arm == pytest.approx(0.4, rel=0.2)
    across[100] = 5.0
    found = honest_deviations(times, angles, off=across[:, None], **known)
    assert found[100, 0] * arm > 3.0
    assert np.median(found) * arm == pytest.approx(0.4, rel=0.2)


def test_the_common_error_of_angles_is_what_draws_the_pivot_aside():
    random = np.random.default_rng(5)
    rows = 30.0 * np.sin(np.arange(600) * 0.7)
    noise = 0.02 * random.standard_normal(600)
    straight = np.stack([noise, rows], axis=-1)
    bent = np.stack([noise + 0.05 * np.sin(rows / 6.0), rows], axis=-1)
    nothing = np.full((600, 1), np.nan)
    hinge = Hinge(np.zeros(2), np.array([0.15, 1.0]), 400.0, 3.0, 0.0)
    down, other = (
        find_gravity(
            Motion(np.arange(600) / 60, nothing, path / [400.0, -400.0], np.isfinite(nothing)),
            hinge,
        )
        for path in (straight, bent)
    )
    assert down.source == other.source == "vertical drive"  # no ball shows a swing
    sigmas = [angle_offset_sigma(one, hinge) for one in (down, other)]
    assert 0.15 / 400.0 < sigmas[0] < 6e-4
    assert 6e-4 < sigmas[1] < 5e-3
    assert angle_offset_sigma(Gravity(0.0, "image", LEVELLED), hinge) >= LEVELLED


@pytest.mark.parametrize("lean, doubt", [(0.05, 0.0), (0.3, 0.3 - LEVELLED)])
def test_an_axis_that_leans_more_than_a_camera_does_is_doubted(lean, doubt):
    strokes = 30.0 * np.sin(np.arange(600) * 0.7)
    path = strokes[:, None] * [np.sin(lean), np.cos(lean)]
    nothing = np.full((600, 1), np.nan)
    motion = Motion(np.arange(600) / 60, nothing, path / 400.0, np.isfinite(nothing))
    found = _gravity(motion)
    assert found.source == "vertical drive"
    assert abs(found.direction) == pytest.approx(lean)
    assert found.sigma == pytest.approx(doubt, abs=1e-6)


def _swing(rest, seen_from, drags):
    """Return a free swing about a pivot at rest of which only a part is seen."""
    random = np.random.default_rng(8)
    times = np.arange(360) / 60
    system = ll.Pendulum(length=0.363, mass=0.1, **drags)
    angles = ll.simulate(system, initial_angle=0.7, times=times).angle.values
    is_seen = angles > seen_from
    angles = np.where(is_seen, rest + angles + 2e-4 * random.standard_normal(360), np.nan)
    pivots = 5e-5 * random.standard_normal((360, 2))
    return Motion(times, angles[:, None], pivots, is_seen[:, None])


def _gravity(motion):
    return find_gravity(motion, Hinge(np.zeros(2), np.ones(2), 400.0, 1.4, 0.0))


@pytest.mark.parametrize("drags", [{"damping": 0.003}, {"quadratic_damping": 0.01}])
@pytest.mark.parametrize("seen_from", [-9.0, -0.5, -0.3, -0.1, 0.05])
@pytest.mark.parametrize("rest", [0.0, -0.122])
def test_gravity_is_found_where_a_part_of_the_swing_is_out_of_the_picture(rest, seen_from, drags):
    found = _gravity(_swing(rest, seen_from, drags))
    assert found.source == "swing"
    assert abs(found.direction - rest) < 2.0 * found.sigma + 1e-4
    assert found.sigma < 5e-3


def test_gravity_is_found_where_no_turning_point_is_seen():
    motion = _swing(0.1, -9.0, {"damping": 0.003})
    is_seen = np.abs(motion.angles - 0.1) < 0.3
    found = _gravity(motion._replace(angles=np.where(is_seen, motion.angles, np.nan)))
    assert abs(found.direction - 0.1) < 2.0 * found.sigma < 5e-3


@pytest.mark.parametrize("case", ["one arc", "no pendulum"])
def test_gravity_that_cannot_be_found_is_straight_down_to_some_degrees(case):
    motion = _swing(0.1, -9.0, {"damping": 0.003})
    angles = motion.angles
    if case == "one arc":
        angles[40:] = np.nan
    else:
        jumps = np.random.default_rng(9).uniform(-1.0, 1.0, 13)
        angles = np.interp(motion.times, np.arange(13) / 2.0, jumps)[:, None]
        angles[angles < 0.0] = np.nan
    assert _gravity(motion._replace(angles=angles)) == Gravity(0.0, "image", LEVELLED)


@pytest.mark.parametrize("aside", [-5e-4, 0.0, 5e-4])
def test_gravity_is_found_through_contacts_of_two_driven_balls(aside):
    toy = ll.LatoLato(length=0.245, mass=0.1, damping=0.005, radius=0.02, restitution=0.9)
    drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=2.3 * toy.natural_frequency)
    times = np.arange(240) / 60
    run = ll.simulate(toy, drive, initial_angle=0.9, times=times)
    angle, height = run.angle.values, run.pivot_height.values / 0.245
    noise = 1e-3 * np.random.default_rng(2).standard_normal((240, 2))
    angles = 0.02 + np.column_stack([angle, -angle]) + noise
    # The camera is turned by as much as angles are. Along the stroke the wall draws the pivot to
    # either side, by 0.2 pixels of an arm of 400.
    sides = aside * np.tanh(30.0 * height)
    pivots = height[:, None] * [-math.sin(0.02), math.cos(0.02)]
    pivots += sides[:, None] * [math.cos(0.02), math.sin(0.02)]
    found = _gravity(Motion(times, angles, pivots, angles > 9.0))
    assert found.source == "swing"
    assert abs(found.direction - 0.02) < min(2.0 * found.sigma, 1e-4)
    assert found.sigma < (5e-4 if aside == 0.0 else 2e-3)


@pytest.mark.parametrize("period", [2.0, 5.0, 18.68, 37.36, 112.0 / 6.0])
def test_the_sample_meets_a_drive_at_many_phases(period):
    count = 2700
    step = count // 24
    starts = [n for n in range(count) if _is_wanted(n, step) and not _is_wanted(n - 1, step)]
    assert starts[0] == 0
    assert 20 <= len(starts) <= 26
    # Rows of even distance of nearly whole periods would all have one phase.
    phases = np.exp(2j * math.pi * np.array(starts) / period)
    assert abs(phases.mean()) < 0.75


@pytest.mark.parametrize("count", [1, 2, 7, 96])
def test_medians_of_planes_are_lower_medians(count):
    random = np.random.default_rng(count)
    frames = [
        Frame(n, n / 60, *(random.integers(0, 256, shape, np.uint8) for shape in SHAPES))
        for n in range(count)
    ]
    for k, median in enumerate(median_planes(frames)):
        ranked = np.sort([frame[2 + k] for frame in frames], axis=0)
        assert np.array_equal(median, ranked[(count - 1) // 2])


@pytest.mark.parametrize("gap, stays", [(1, 0.0), (5, 0.0), (40, math.tau)])
def test_turns_are_taken_off_that_a_ball_cannot_have_made(gap, stays):
    times = np.arange(200)
    swing = 0.5 * np.sin(0.3 * times)
    angles = swing + np.where(times < 80, 0.0, math.tau)
    angles[80 - gap + 1 : 80] = np.nan
    take_off_turns(angles)
    np.testing.assert_allclose(angles[:80][np.isfinite(angles[:80])], swing[: 81 - gap])
    np.testing.assert_allclose(angles[80:], swing[80:] + stays)


@pytest.mark.parametrize("is_late", [True, False], ids=["late", "shaken"])
def test_errors_of_time_are_told_from_those_of_place_by_the_speed(is_late):
    random = np.random.default_rng(5)
    times = np.arange(300) / 60.0
    errors = 1e-3 * random.standard_normal(300)
    if is_late:
        angles = 0.5 * np.sin(6.0 * (times + errors))
    else:  # as much as the fastest ball is then off
        angles = 0.5 * np.sin(6.0 * times) + 3.0 * errors
    clean = np.ones((300, 1), bool)
    off = time_scatter(times, angles[:, None], is_clean=clean, is_broken=~clean, noise=1e-4)
    assert (0.8e-3 < off < 2.5e-3) == is_late
    assert (off == 0.0) != is_late


def test_turns_that_a_ball_makes_stay():
    turning = 2.9 * np.arange(100)
    angles = turning.copy()
    angles[[20, 21, 60]] = np.nan
    take_off_turns(angles)
    known = np.isfinite(angles)
    np.testing.assert_array_equal(angles[known], turning[known])


def test_a_pivot_whose_slow_frames_are_at_one_end_is_told_from_the_wall():
    random = np.random.default_rng(3)
    wall = 150.0 + 300.0 * gaussian_filter(random.standard_normal((160, 120)), 3.0)
    pairs = [(0, 0)] * 12 + [(row, row + 5) for row in range(10, 58, 4)]
    frames, grey = [], np.full((80, 60), 128, np.uint8)
    for pair, rows in enumerate(pairs):
        for k, row in enumerate(rows):
            luma = wall + 2.0 * random.standard_normal(wall.shape)
            luma[row + 40 : row + 61, 45:76] = 60.0
            luma = np.clip(luma, 0.0, 255.0).astype(np.uint8)
            frames.append(Frame(10 * pair + k, 0.0, luma, grey, grey))
    shifts = np.stack([np.zeros(48), np.array(pairs, float).ravel()], axis=-1)
    side = np.zeros((61, 61))
    tracker = PivotTracker(np.array([60.0, 50.0]), side, side, np.zeros((2, 2)))
    learn_template(tracker, frames, median_planes(frames)[0], shifts)
    rows, columns = (np.abs(at - 30) for at in np.nonzero(tracker.weight))
    # The block of 31 x 21 pixels and its edge.
    assert rows.max() <= 12
    assert columns.max() <= 17
    assert len(rows) > 300


def test_an_uncertain_pivot_is_looked_for_within_its_reach():
    picture = gaussian_filter(np.random.default_rng(1).normal(size=(120, 120)), 2.0)
    luma = np.float32(100.0 + 400.0 * picture)
    side = luma[45:66, 45:66].astype(float)
    reach = np.array([[-3.0, -12.0], [3.0, 12.0]])
    tracker = PivotTracker(np.array([50.0, 48.0]), side, np.ones_like(side), reach)
    guess, velocity = np.array([0.0, -11.0]), np.zeros(2)
    # All places of the reach and about it, coarse and fine, not the room's thirty thousand.
    assert len(tracker._costs(luma, guess, side, room=1000.0)[0]) < 2000
    shift, _ = tracker.locate(luma, guess, velocity, room=1000.0)
    np.testing.assert_allclose(shift, [5.0, 7.0], atol=0.01)


@pytest.mark.parametrize(
    "motion, repeated, is_old",
    [
        ("moves", [18, 19], True),
        ("held", [18, 19], False),  # until the next frame
        ("caught", [21, 22], False),  # in the frame before
        ("turns", [20], False),
    ],
)
def test_a_picture_that_repeats_another_is_old_only_where_the_ball_should_have_moved(
    motion, repeated, is_old
):
    times = np.arange(40) / 30.0
    angles = {
        "moves": 2.0 * times,
        "held": 13.0 * np.maximum(times - times[19], 0.0) ** 2,
        "caught": 2.0 * np.minimum(times, times[20]),
        "turns": 0.5 * np.cos(7.0 * (times - times[20])),
    }[motion].copy()
    if is_old:  # the pictures show the ball where it was
        angles[repeated] = angles[repeated[0] - 1]
    repeats = np.isin(np.arange(40), repeated)
    refiner = SimpleNamespace(
        scene=SimpleNamespace(balls=1, arm=300.0, explained=1.0, look=SimpleNamespace(radius=20.0)),
        out=SimpleNamespace(angles=angles[:, None], times=times),
        explained=np.ones((40, 1)),
    )
    old = _Refiner._is_old(refiner, repeats, np.ones((40, 1), bool))
    assert old[repeated, 0].tolist() == [is_old] * len(repeated)


@pytest.mark.parametrize("apart, is_good", [(1.5, True), (0.95, True), (0.85, False)])
def test_balls_that_overlap_were_not_measured(apart, is_good):
    radius, arm = 10.0, 100.0
    gap = 2.0 * math.asin(radius / arm)
    angles = 0.5 * apart * gap * np.array([[1.0, -1.0]])
    scene = SimpleNamespace(
        look=SimpleNamespace(radius=radius, exposure=0.0), arm=arm, balls=2, explained=1.0,
        off=lambda away: np.abs(np.linalg.norm(away, axis=-1) - arm),
    )  # fmt: skip
    centres = arm * np.stack([np.sin(angles), np.cos(angles)], axis=-1)
    one = np.ones((1, 2))
    refiner = SimpleNamespace(
        scene=scene, gap=gap, interval=0.02, explained=one, hidden=0.0 * one, guesses=angles,
        velocities=np.zeros((1, 2, 2)), is_fixed=one < 0.0,
        route=SimpleNamespace(radius=radius, is_seen=one > 0.0),
        out=SimpleNamespace(angles=angles, centres=centres, pivots=np.zeros((1, 2))),
    )  # fmt: skip
    assert _Refiner._is_good(refiner, slice(None)).tolist() == [[is_good, is_good]]
