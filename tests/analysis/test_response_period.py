"""Response periods: known orbits, their symmetry, rest, chaos, and shares of a map."""

import math

import numpy as np
import pytest

import latolato as ll
from latolato.analysis import response_period, response_period_map, wilson_interval
from latolato.core.errors import InputError
from latolato.numerics.callbacks import blank_slots
from latolato.observables import Step
from latolato.observables.period import ResponsePeriod, Samples, find_mirror, find_period
from latolato.physics.contacts import BOTTOM

SINGLE = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
TOY = ll.LatoLato(length=0.245, mass=0.10644, radius=0.0196, restitution=0.9, damping=0.00506)
BALL = ll.Ball(length=0.245, mass=0.10644, radius=0.0196, damping=0.00506)
PAIR = ll.BallPair(right=BALL, left=BALL, restitution=0.9)


def at_ratio(system, ratio, amplitude):
    return ll.Harmonic(drive_amplitude=amplitude, drive_frequency=ratio * system.natural_frequency)


def test_the_pendulum_in_the_tongue_repeats_after_two_drive_periods_and_is_its_own_mirror_image():
    found = response_period(SINGLE, at_ratio(SINGLE, 2.0, 0.05), initial_angle=0.1)
    assert found.status == "periodic"
    assert found.response_period == 2.0
    assert found.rotation_number == 0.5  # one swing in two drive periods
    assert found.mirror_shift == 1.0  # the only shift that leads back when done twice
    assert found.mirror_residual < 1e-5  # a hundred tolerances of the run


def test_the_hanging_pendulum_outside_the_tongue_comes_to_rest():
    found = response_period(SINGLE, at_ratio(SINGLE, 1.6, 0.05), initial_angle=0.1)
    assert found.status == "rest"
    assert found.response_period == 1.0
    assert found.rotation_number == 0.0


def test_balls_at_rest_below_lift_off_stay_at_rest():
    found = response_period(TOY, at_ratio(TOY, 2.4, 0.03), initial_offset=0.0)
    assert (found.status, found.response_period, found.rotation_number) == ("rest", 1.0, 0.0)


@pytest.mark.parametrize("ratio, period", [(2.4, 1.0), (5.0, 2.0)])
def test_two_equal_balls_repeat_as_their_mirror_symmetric_model_does(ratio, period):
    one = response_period(TOY, at_ratio(TOY, ratio, 0.03), initial_offset=0.2)
    two = response_period(PAIR, at_ratio(TOY, ratio, 0.03), initial_angle=(0.3, -0.28))
    assert one.response_period == two.response_period == period
    assert one.rotation_number == two.rotation_number == 1.0 / period  # impacts
    # 500 periods of transient against a decay of exp(-2 k t), and the tolerance of the run.
    assert two.mirror_residual < 1e-4
    assert two.largest_angle_watched.item() == pytest.approx(
        one.largest_angle_watched.item(), abs=1e-4
    )


@pytest.mark.parametrize("sense", [-1.0, 1.0])
def test_a_rotating_pendulum_turns_once_per_drive_period_in_the_sense_of_its_velocity(sense):
    # A start well inside the basin of rotation, and its mirror image.
    found = response_period(
        SINGLE,
        at_ratio(SINGLE, 2.0, 0.05),
        initial_angle=-2.9 * sense,
        initial_angular_velocity=5.3 * sense,
    )
    assert (found.status, found.response_period) == ("periodic", 1.0)
    assert found.turns_per_period == sense
    assert found.rotation_number == sense
    assert np.sign(found.section_angular_velocity.mean()) == sense
    assert found.largest_angle_watched.item() == pytest.approx(math.pi, abs=1e-12)  # by definition
    assert found.mirror_residual > 1.0  # the other sense of rotation is another motion


def test_chaos_has_no_period_and_says_so():
    found = response_period(SINGLE, at_ratio(SINGLE, 2.0, 0.5), initial_angle=0.1)
    assert found.status == "aperiodic"
    assert math.isnan(found.response_period)
    assert math.isnan(found.mirror_residual)
    assert "no period up to 16" in found.attrs["message"]


def test_a_period_longer_than_asked_for_is_not_found():
    found = response_period(SINGLE, at_ratio(SINGLE, 2.0, 0.05), initial_angle=0.1, longest=1)
    assert found.status == "aperiodic"
    assert found.recurrence_residual > 0.1


# Where 49 angles and then 49 velocities of one ball lie.
SAMPLES = Samples(0, 49, 1, 0, 49, 1)


@pytest.mark.parametrize("period", [1, 2, 3, 7, 16])
def test_samples_made_with_a_period_show_it_and_no_shorter_one(period):
    rng = np.random.default_rng(period)
    cycle = rng.uniform(-3.0, 3.0, (5, 1, period))
    angle = np.tile(cycle, 49)[..., :49]
    angle = angle + 2.0 * math.pi * np.arange(49)  # whole turns do not count
    for samples in angle[:, 0]:
        found, left = find_period([*samples, *np.zeros(49)], SAMPLES, 1.0, 16, 1e-4)
        assert found == period
        assert left < 1e-12  # rounding of some hundred radians


def test_the_mirror_image_is_found_at_half_the_period_only_if_it_is_there():
    cycle = np.array([0.3, -0.5, 0.7, -0.3, 0.5, -0.7])
    angle = np.tile(cycle, 9)[:49]
    spoilt = angle + 0.1
    for samples, residual in ((angle, 0.0), (spoilt, 0.2)):
        left, shift = find_mirror([*samples, *np.zeros(49)], SAMPLES, 1.0, 6.0)
        assert shift == 3.0
        assert left == pytest.approx(residual, abs=1e-12)  # rounding


@pytest.mark.parametrize(
    "slowest, held, kind", [(1e-6, 0.0, 2.0), (1e-2, 0.0, 1.0), (1e-6, 0.3, 1.0)]
)
def test_a_motion_grazes_if_an_impact_has_hardly_any_speed_and_nothing_rests(slowest, held, kind):
    watched = ResponsePeriod(longest=2, angle_tolerance=1e-5)
    slots = blank_slots([watched], 1)
    acc = slots.ravel()
    ResponsePeriod.start(acc, 0, 1, 0.3)
    for number in range(watched.marks):  # one drive period is one second
        ResponsePeriod.mark(acc, 0, 1, number, float(number), 0.3, 1.0)
    ResponsePeriod.contact(acc, 0, 1, 0.5, BOTTOM, -slowest, slowest, slowest)
    at_rest = Step(0.0, held, *[0.3] * 2, *[0.0] * 8, 1.0, 0.3)
    ResponsePeriod.step(acc, 0, 1, at_rest)
    ResponsePeriod.finish(acc, 0, 1, None)
    found = watched.read(slots, 1)
    assert found["response_period"] == 1.0
    assert found["periodicity"] == kind


@pytest.mark.parametrize(
    "count, total, low, high",
    # Wilson's formula at z = 1.96 for 0/10 and 5/10; Newcombe (1998), table I, gives 81/263.
    [(0, 10, 0.0, 0.2775), (5, 10, 0.2366, 0.7634), (81, 263, 0.2553, 0.3662)],
)
def test_the_interval_of_a_share_is_that_of_wilson(count, total, low, high):
    share, least, most = wilson_interval(count, total)
    assert share == count / total
    assert least == pytest.approx(low, abs=5e-5)  # digits printed
    assert most == pytest.approx(high, abs=5e-5)


def test_a_map_agrees_with_single_answers_and_its_shares_sum_to_one():
    ratios = [2.4, 3.0, 5.0]
    found = response_period_map(
        TOY, drive_amplitude=[0.02, 0.03], frequency_ratio=ratios, initial_offset=0.2
    )
    for ratio in ratios:
        one = response_period(TOY, at_ratio(TOY, ratio, 0.03), initial_offset=0.2)
        cell = found.sel(drive_amplitude=0.03, frequency_ratio=ratio)
        assert cell.status == one.status
        assert cell.response_period == one.response_period
    assert found.share.sum().item() == pytest.approx(1.0, abs=1e-15)
    assert found.active_share.sum().item() == pytest.approx(1.0, abs=1e-15)
    assert found.cells.sum() == 6
    assert np.all(found.share_low <= found.share)
    assert np.all(found.share <= found.share_high)
    assert all("units" in v.attrs and "long_name" in v.attrs for v in found.variables.values())


def test_the_observable_gives_what_the_analysis_does():
    drive = at_ratio(SINGLE, 2.0, 0.05)
    grid = ll.sweep(
        SINGLE,
        drive,
        axes={"initial_angle": [0.1, 0.2]},
        duration=551.0,
        observables=["response_samples"],
    )
    assert grid.response_period.dims == ("initial_angle",)
    assert grid.section_angle.dims == ("initial_angle", "sample")
    assert np.all(grid.response_period == 2.0)


@pytest.mark.parametrize("executor", ["threads", "reference"])
def test_counts_and_extremes_are_those_of_a_dense_run(executor):
    drive = at_ratio(TOY, 3.0, 0.1)  # knocks at both walls
    period = math.tau / drive.drive_frequency
    duration = 12.0 * period * (1.0 + 1e-12)
    grid = ll.sweep(
        TOY,
        drive,
        axes={"initial_offset": [0.2]},
        duration=duration,
        observables=[ll.ResponseSamples(longest=4)],
        tolerance=1e-11,
        executor=executor,
    ).squeeze()
    times = np.linspace(0.0, 12.0 * period, 12 * 2000 + 1)
    run = ll.simulate(
        TOY, drive, initial_offset=0.2, times=times, duration=duration, tolerance=1e-12
    )
    # Both runs' errors, amplified by a dozen impacts.
    tolerance = 1e-6
    for name in ("angle", "angular_velocity"):
        np.testing.assert_allclose(
            grid[f"section_{name}"], run[name].values[::2000], atol=tolerance
        )
    speeds = abs(run.angular_velocity_before.values)
    assert grid.slowest_impact.item() == pytest.approx(speeds.min(), abs=tolerance)
    # Speeds are looked at once per step, and samples lie as close.
    assert grid.fastest_speed.item() == pytest.approx(
        abs(run.angular_velocity).max().item(), rel=0.02
    )
    assert grid.largest_angle_watched.item() == pytest.approx(TOY.contact_angle_high, abs=1e-9)
    cycles = grid.response_period.item() if np.isfinite(grid.response_period) else 1.0
    whole = 12 // cycles * cycles
    counted = (run.contact_time.values >= times[-1] - whole * period).sum()
    assert grid.impacts_per_period.item() == pytest.approx(counted / whole, abs=1e-12)


def test_swings_are_half_the_passages_of_a_dense_run():
    drive = at_ratio(SINGLE, 2.0, 0.5)  # tumbles
    period = math.tau / drive.drive_frequency
    grid = ll.sweep(
        SINGLE,
        drive,
        axes={"initial_angle": [0.5]},
        duration=12.0 * period * (1.0 + 1e-12),
        observables=[ll.ResponseSamples(longest=4)],
        tolerance=1e-9,
    ).squeeze()
    times = np.linspace(0.0, 12.0 * period, 12 * 2000 + 1)
    run = ll.simulate(SINGLE, drive, initial_angle=0.5, times=times)
    turns = np.floor(run.angle.values / math.tau)
    assert grid.windings.item() == pytest.approx(0.5 * abs(np.diff(turns)).sum() / 12, abs=1e-12)
    net = (run.angle.values[-1] - run.angle.values[0]) / math.tau / 12
    assert grid.turns_per_period.item() == pytest.approx(net, abs=1e-6)  # both runs' errors
    high = abs((run.angle.values + math.pi) % math.tau - math.pi).max()
    # Samples lie a two-thousandth of a period apart; pi stands for a passage over the top.
    assert grid.largest_angle_watched.item() == pytest.approx(high, abs=0.02)


def test_observables_that_mark_differently_many_periods_are_refused():
    with pytest.raises(ValueError, match="equally many periods, got 32 and 49"):
        ll.sweep(
            SINGLE,
            at_ratio(SINGLE, 2.0, 0.05),
            axes={"initial_angle": [0.1]},
            duration=100.0,
            observables=[ll.PoincareSection(), ll.ResponsePeriod()],
        )


@pytest.mark.parametrize(
    "system, drive, options, message",
    [
        (SINGLE, None, {}, "single period, got 'none'"),
        (
            SINGLE,
            ll.FrequencySchedule(drive_amplitude=0.1, times=[0.0, 5.0], drive_frequencies=[6, 5]),
            {},
            "single period",
        ),
        (
            ll.Mathieu(length=1.0, mass=1.0),
            at_ratio(SINGLE, 2.0, 0.1),
            {},
            "only grows",
        ),
        (SINGLE, at_ratio(SINGLE, 2.0, 0.1), {"longest": 0}, "longest must lie"),
        (SINGLE, at_ratio(SINGLE, 2.0, 0.1), {"angle_tolerance": 0.0}, "angle_toler"),
        (SINGLE, at_ratio(SINGLE, 2.0, 0.1), {"transient_periods": -1}, "trans"),
        (
            SINGLE,
            ll.Harmonic(drive_amplitude=0.1, drive_frequency=0.0),
            {},
            "drive_fre",
        ),
        ("pendulum", at_ratio(SINGLE, 2.0, 0.1), {}, "system must be"),
    ],
)
def test_bad_input_is_refused_in_one_line(system, drive, options, message):
    with pytest.raises(InputError, match=message) as caught:
        response_period(system, drive, initial_angle=0.1, **options)
    assert "\n" not in str(caught.value)


SLOW = ll.Pendulum(length=0.25, mass=0.1, damping=0.0005)
SLOW_DRIVE = ll.Harmonic(drive_amplitude=0.03, drive_frequency=2.4 * SLOW.natural_frequency)


@pytest.mark.parametrize("transient", [100, 500, 1500])
def test_motion_that_dies_down_slowly_has_not_settled(transient):
    found = response_period(SLOW, SLOW_DRIVE, initial_angle=0.5, transient_periods=transient)
    assert found.status.item() == "not settled"
    assert math.isnan(found.response_period.item())
    assert f"transient_periods of {4 * transient}" in found.attrs["message"]


def test_slow_motion_settles_after_the_transient_that_is_recommended():
    found = response_period(SLOW, SLOW_DRIVE, initial_angle=0.5, transient_periods=6000)
    assert found.status.item() == "rest"


def test_chaos_that_comes_in_bursts_stays_aperiodic():
    # Its largest angle in 48 drive periods is between 0.1 and 3.04 rad, at any time. No law: other
    # transients and tolerances lose up to 11 of 64 starts to "not settled". Of 64 starts within
    # 1e-3 rad of this one none is lost, so that rounding does not decide.
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.9)
    amplitudes, ratios = np.linspace(0.01, 0.5, 40)[[14, 29]], np.linspace(0.1, 5.0, 40)
    found = ll.analysis.response_period_map(
        toy, drive_amplitude=amplitudes, frequency_ratio=ratios[[13]], initial_offset=0.05,
        transient_periods=300,
    )  # fmt: skip
    assert found.status.values[1, 0] == "aperiodic"
    assert "not settled" in found.motion
    assert found.cells.sum() == 2
