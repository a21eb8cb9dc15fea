"""Sweeps up and down: the tongue's edges, the lift-off rule, areas by hand, and bad input."""

import math

import numpy as np
import pytest

import latolato as ll
from hanging import tongue_edges
from latolato.analysis import hysteresis
from latolato.analysis.hysteresis import _loop
from latolato.figures.analyses.hysteresis import draw

PENDULUM = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
TOY = ll.LatoLato(length=0.245, mass=0.10644, damping=0.00506, radius=0.0196, restitution=0.9)
BALL = ll.Ball(length=0.245, mass=0.10644, damping=0.00506, radius=0.0196)
DRIVE = ll.Harmonic(drive_amplitude=0.03, drive_frequency=15.0)


def test_the_pendulum_jumps_up_at_the_left_edge_of_its_tongue_and_dies_at_the_right_one():
    ratios = np.arange(1.84, 2.16, 0.02)
    found = hysteresis(
        PENDULUM, ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.0),
        frequency_ratio=ratios, duration=250.0,
    )  # fmt: skip
    low, high = tongue_edges(drive_amplitude=0.05, length=1.0, mass=0.8, damping=0.05)
    # half a step, and as much again: growth just inside an edge takes longer than a step lasts
    assert found.jump_ratio.sel(direction="up").item() == pytest.approx(low, abs=0.021)
    assert found.jump_height.sel(direction="up").item() > 1.0
    assert found.bistable_low.item() == ratios[0]  # the sweep down still is on its branch there
    assert found.bistable_high.item() == pytest.approx(low, abs=0.021)
    down = found.largest_angle.sel(direction="down").values.ravel()
    alive = ratios[down > 0.1]
    assert alive.max() == pytest.approx(high, abs=0.021)
    assert found.status.item() == "hysteresis"


def test_the_toy_leaves_the_wall_at_lift_off_only_but_keeps_its_branch_below():
    found = hysteresis(
        TOY, DRIVE, frequency_ratio=np.arange(2.0, 3.41, 0.05), drive_amplitude=[0.02, 0.03],
        duration=40.0,
    )  # fmt: skip
    weak, strong = found.isel(drive_amplitude=0), found.isel(drive_amplitude=1)
    assert weak.status.item() == "no hysteresis"
    assert weak.loop_area.item() == 0.0
    assert strong.status.item() == "hysteresis"
    lift_off = math.sqrt(0.245 / 0.03)
    jump = strong.jump_ratio.sel(direction="up").item()
    # visible motion from rest needs 1 to 1.28 of the acceleration of lift-off at e = 0.9
    assert lift_off < jump < lift_off * math.sqrt(1.28)
    at_stage_2 = strong.largest_angle.sel(frequency_ratio=2.4, method="nearest")
    # Paper Fig. 12, at 2.389: 42 degrees against 4.6 from rest
    assert np.rad2deg(at_stage_2.sel(direction="down")) == pytest.approx(41.1, abs=0.5)
    assert at_stage_2.sel(direction="up") == TOY.contact_angle_low
    assert draw(found).axes


def test_two_balls_have_the_loop_of_the_mirror_pair():
    pair = ll.BallPair(right=BALL, left=BALL, restitution=0.9)
    asked = {"frequency_ratio": [2.4, 2.8, 3.2], "duration": 25.0}
    one, two = (hysteresis(system, DRIVE, **asked) for system in (TOY, pair))
    # another kernel: rounding, damped by the attractor
    np.testing.assert_allclose(two.largest_angle, one.largest_angle, rtol=1e-3)


def test_answers_that_die_out_and_gaps_of_a_range_are_not_counted_nor_shaded(tmp_path):
    toy = ll.LatoLato(length=0.2, mass=0.05, damping=0.001, radius=0.018, restitution=0.9)
    drive = ll.Harmonic(drive_amplitude=0.06, drive_frequency=6.0 * math.pi)
    found = hysteresis(toy, drive, frequency_ratio=np.linspace(1.4, 3.2, 41))
    row = found.squeeze("drive_amplitude")
    differ, two = (
        np.abs(row[name].diff("direction").values[0]) >= 0.1
        for name in ("largest_angle", "settled_angle")
    )
    # At 1.625 the clacking goes on for a while before it dies out.
    assert row.frequency_ratio.values[differ & ~two] == pytest.approx([1.625])
    assert (row.bistable_low, row.bistable_high) == pytest.approx((1.67, 3.2))
    assert row.bistable_ranges == 2
    assert found.attrs["message"] == (
        "at 1 of 41 points both ways differ only for a while, or do not settle: these do not count "
        "as two answers; there are still two answers at frequency_ratio 3.2, where the sweep ends: "
        "end higher to see the whole range"
    )
    (axes,) = draw(ll.load(ll.save(found, tmp_path / "loop.nc"))).axes
    shade, *hollow = axes.collections
    shaded = shade.get_paths()
    covered = [
        any(path.contains_point((ratio, math.radians(120.0))) for path in shaded)
        for ratio in (1.625, 1.8, 2.0, 3.1)
    ]
    assert covered == [False, True, False, True]
    drawn = np.degrees([each.get_offsets()[:, 1] for each in hollow])
    assert drawn.ravel() == pytest.approx([5.16, 174.8], abs=0.1)


def test_area_range_and_jumps_of_a_square_loop():
    ratios = np.linspace(1.0, 2.0, 11)
    up = np.where(ratios > 1.75, 0.5, 0.0)
    down = np.where(ratios > 1.25, 0.5, 0.0)
    found = _loop(ratios, up, down, 0.1, down - up > 0.1)
    assert found["jump_ratio"] == pytest.approx([1.75, 1.25])
    assert found["jump_height"] == pytest.approx([0.5, -0.5])
    assert found["loop_area"] == pytest.approx(0.5 * 0.5)
    assert (found["bistable_low"], found["bistable_high"]) == pytest.approx((1.3, 1.7))


def test_a_point_without_an_answer_leaves_the_loop_unknown():
    angles = np.array([0.0, math.nan, 0.5])
    found = _loop(np.array([1.0, 2.0, 3.0]), angles, np.zeros(3), 0.1, np.zeros(3, dtype=bool))
    assert found["status"] == "no answer"
    assert math.isnan(found["loop_area"])
    assert math.isnan(found["jump_ratio"][0])


@pytest.mark.parametrize(
    "system, drive, changed, message",
    [
        (TOY, None, {}, "single period, got 'none'"),
        (TOY, DRIVE, {"frequency_ratio": [2.0, 1.0]}, "frequency_ratio must increase strictly"),
        (TOY, DRIVE, {"duration": 0.0}, r"duration must lie in \(0, inf\)"),
        (TOY, DRIVE, {"least_jump": 0.0}, r"least_jump must lie in \(0, inf\)"),
        (TOY, DRIVE, {"drive_amplitude": []}, "drive_amplitude must hold at least 1 value"),
        (ll.Mathieu(length=1.0, mass=0.8), DRIVE, {}, "must have motion that settles"),
    ],
)
def test_bad_input_is_refused(system, drive, changed, message):
    with pytest.raises(ValueError, match=message):
        hysteresis(system, drive, **changed)


@pytest.mark.parametrize(
    "system, drive, asked",
    [
        # Both ways begin with a swing that dies down, for want of a drive.
        (TOY, ll.Harmonic(drive_amplitude=0.0, drive_frequency=15.0), {"initial_offset": 0.5}),
        # Nothing settles without damping.
        (
            ll.Pendulum(length=0.245, mass=0.1),
            ll.Harmonic(drive_amplitude=0.01, drive_frequency=15.0),
            {"initial_angle": 0.5},
        ),
    ],
)
def test_what_has_not_settled_is_no_hysteresis(system, drive, asked):
    found = hysteresis(system, drive, frequency_ratio=[1.6, 2.0, 2.4], duration=5.0, **asked)
    assert found.status.item() == "not settled"
    assert math.isnan(found.bistable_low.item())
    assert found.loop_area.item() > 0.0
