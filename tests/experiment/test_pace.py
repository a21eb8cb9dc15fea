"""The pace of a clip from its swing: whole clips, changes, and what must not be taken for one."""

import math
import re

import numpy as np
import pytest

import latolato as ll
from latolato.experiment.calibration.pace import pace_warnings, parts_of
from latolato.experiment.calibration.swing import Motion, fit_swing

LENGTH = 0.363
STIFFNESS = 9.8 / LENGTH
BALL = ll.Pendulum(length=LENGTH, mass=0.1, damping=0.003, gravity=9.8)
DRIVE = ll.Harmonic(drive_amplitude=0.03, drive_frequency=10.0)
# Runs: drive, angle and speed of the start.
RUNS = {
    "small": (None, 0.2, 0.0),
    "free": (None, 0.9, 0.0),
    "wide": (None, 2.6, 0.0),
    "driven": (DRIVE, 0.6, 0.0),
    "turning": (ll.Harmonic(drive_amplitude=0.05, drive_frequency=10.4), 1.0, 11.0),
}


def filmed(run, changes, rate=30.0, seconds=8.0):
    """Return what a camera sees that plays `factor` times slower from each instant on."""
    from scipy.interpolate import CubicSpline

    instants, times, now, shown = [], [], 0.0, 0.0
    while now < seconds:
        factor = [factor for since, factor in changes if now >= since][-1]
        instants.append(now)
        times.append(shown)
        now, shown = now + 1.0 / (rate * factor), shown + 1.0 / rate
    noise = np.random.default_rng(3).standard_normal((3, len(instants)))
    known = run["time"].values
    angle = CubicSpline(known, run["angle"].values)(instants) + 2e-3 * noise[0]
    height = CubicSpline(known, run["pivot_height"].values)(instants) / LENGTH + 3e-4 * noise[1]
    pivots = np.column_stack([3e-4 * noise[2], height])
    return Motion(np.array(times), angle[:, None], pivots, np.ones((len(times), 1), bool))


def warnings_of(motion, stiffness):
    return pace_warnings(motion, fit_swing(motion), stiffness, 1.0)


@pytest.fixture(scope="module", params=RUNS)
def run(request):
    drive, angle, speed = RUNS[request.param]
    return ll.simulate(
        BALL, drive, initial_angle=angle, initial_angular_velocity=speed, duration=8.1
    )


@pytest.mark.parametrize("factor", [0.5, 1.0, 4.0, 8.0])
def test_a_swing_tells_the_pace_of_a_whole_clip(run, factor):
    motion = filmed(run, [(0.0, factor)], 30.0 if factor >= 1.0 else 60.0)
    assert parts_of(motion) == []
    found = math.sqrt(STIFFNESS / fit_swing(motion).stiffness)
    assert found == pytest.approx(factor, rel=0.01)


@pytest.mark.parametrize("frequency,off", [(0.0, 0.01), (5.0, 0.1), (10.0, 3.0)])
def test_a_fast_drive_that_leans_turns_no_gravity(frequency, off):
    """Of 10 Hz a camera with 30 frames a second sees three places in a period."""
    from scipy.interpolate import CubicSpline

    drive = ll.PlanarHarmonic(
        drive_frequency=math.tau * frequency, vertical_amplitude=0.014, horizontal_amplitude=0.01
    )
    run = ll.simulate(BALL, drive, initial_angle=0.6, duration=12.0)
    times = np.arange(0.0, 12.0, 1.0 / 30.0)
    angle, across, height = (
        CubicSpline(run["time"].values, run[name].values)(times)
        for name in ("angle", "pivot_across", "pivot_height")
    )
    pivots = np.column_stack([across, height]) / LENGTH
    swing = fit_swing(Motion(times, angle[:, None], pivots, np.ones((len(times), 1), bool)))
    assert abs(1e3 * swing.direction) < off  # [mrad]
    assert abs(swing.stiffness / STIFFNESS - 1.0) < 1e-3 * max(off, 0.1)
    if frequency > 0.0:  # a deviation of nothing but rounding says little
        assert abs(swing.direction) < swing.direction_sigma
        assert abs(swing.stiffness - STIFFNESS) < swing.stiffness_sigma


@pytest.mark.parametrize("rate", [30.0, 60.0])
def test_a_slow_part_is_found_with_its_ends(run, rate):
    motion = filmed(run, [(0.0, 1.0), (3.0, 8.0), (4.5, 1.0)], rate)
    first, slow, last = parts_of(motion)
    paces = [math.sqrt(STIFFNESS / part[2]) for part in (first, slow, last)]
    assert paces == pytest.approx([1.0, 8.0, 1.0], rel=0.02)
    # It is played from 3 to 15 s.
    assert 2.5 < first[1] <= slow[0] < 3.8
    assert 14.0 < slow[1] <= last[0] < 15.6
    (text,) = warnings_of(motion, STIFFNESS)
    assert "the clip changes its pace (slow motion 1 from 0.00 to " in text
    ends = re.search(r"start ([\d.]+) and end ([\d.]+) s with slow motion 8", text).groups()
    assert [*map(float, ends)] == pytest.approx([slow[0] / 8.0, slow[1] / 8.0], rel=0.05)
    (text,) = warnings_of(motion, None)
    assert "8 from" in text
    assert "if its fastest part is at normal speed" in text


def test_a_clip_at_lifes_pace_gives_no_warning(run):
    motion = filmed(run, [(0.0, 1.0)])
    assert warnings_of(motion, STIFFNESS) == []
    assert warnings_of(motion, None) == []


def test_no_slow_motion_is_suggested_that_no_camera_makes(run):
    told = warnings_of(filmed(run, [(0.0, 1.0)]), 1e-9 * STIFFNESS)
    assert "too fast for its length and gravity: correct the length" in told[0]
    assert "slow motion" not in told[0]


def test_a_length_that_is_somewhat_wrong_gives_no_warning(run):
    assert warnings_of(filmed(run, [(0.0, 1.0)]), 1.5 * STIFFNESS) == []


def test_a_hand_that_holds_or_lifts_the_ball_changes_no_pace():
    free = filmed(ll.simulate(BALL, initial_angle=0.8, duration=8.1), [(0.0, 1.0)])
    noise = 2e-3 * np.random.default_rng(4).standard_normal(90)
    share = np.clip(np.arange(90) / 60.0, 0.0, 1.0)
    for before in (np.full(90, 0.8), 0.8 * share**2 * (3.0 - 2.0 * share)):
        angles = np.concatenate([before + noise, free.angles[:, 0]])[:, None]
        count = len(angles)
        motion = Motion(np.arange(count) / 30.0, angles, np.zeros((count, 2)), angles == angles)
        assert fit_swing(motion).stiffness == pytest.approx(STIFFNESS, rel=0.01)
        assert warnings_of(motion, STIFFNESS) == []


def test_what_does_not_swing_tells_no_pace():
    noise = np.random.default_rng(5).standard_normal((300, 1))
    times, still, seen = np.arange(300) / 30.0, np.zeros((300, 2)), np.ones((300, 1), bool)
    for motion in (
        Motion(times, 2e-3 * noise, still, seen),
        Motion(times, 0.5 + 0.0 * noise, still, seen),
        Motion(times, noise, still, ~seen),
    ):
        assert fit_swing(motion) is None
        assert parts_of(motion) == []


def test_a_few_frames_tell_no_pace():
    motion = filmed(ll.simulate(BALL, initial_angle=0.8, duration=8.1), [(0.0, 1.0)])
    for balls in (1, 2):
        pair = motion._replace(
            angles=np.tile(motion.angles, balls), is_free=np.tile(motion.is_free, balls)
        )
        for count in range(9):
            part = Motion(*(values[:count] for values in pair))
            swing = fit_swing(part)
            assert swing is None or swing.stiffness == pytest.approx(STIFFNESS, rel=0.1)
            assert parts_of(part) == []
