"""Fits say when their model does not describe a record, and then give no number as a result."""

import json
import math
import re

import numpy as np
import pytest
from typer.testing import CliRunner

import latolato as ll
from broken_records import BROKEN, WHOLE, make_record
from latolato.app.experiment.fits import fits_of
from latolato.cli.main import app
from latolato.core.errors import InputError
from latolato.experiment.fits.adequacy import Kind, misfit_of, place_of_change
from latolato.experiment.fits.least_squares import Data, Guess, solve
from latolato.experiment.fits.restitution import _doubt, _Impact
from latolato.experiment.fits.samples import noise_of
from latolato.experiment.track_table import track_table, write_table
from latolato.experiment.trials import trial_of
from track_tables import drive_table, motion_table

PENDULUM = ll.Pendulum(length=0.363, mass=0.108, damping=0.00274)
QUICK = {"mass": 0.108, "compare": False, "profile": False}


def swing(times, size=1e-3, seed=3, **start):
    """A swing that is seen with noise at these instants."""
    run = ll.simulate(PENDULUM, times=times, **({"initial_angle": 0.4} | start))
    return run.angle.values + np.random.default_rng(seed).normal(scale=size, size=len(times))


def table_of(times, angle, **columns):
    return track_table({"time": times, "angle_1": angle, **columns})


def cut_out(seconds, at=10.0, duration=30.0):
    """A record whose clock misses some seconds."""
    times = np.arange(0.0, duration, 1.0 / 30.0)
    return table_of(times, swing(np.where(times > at, times + seconds, times)))


# All of them are in benchmarks/fit_doubt.py.
SEEDS = pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])


@SEEDS
@pytest.mark.parametrize("kind", WHOLE)
def test_a_record_without_a_break_is_not_doubted_and_its_numbers_are_right(kind, seed):
    record = make_record(kind, seed)
    fit = ll.fit_decay(record.table, mass=record.mass, compare=False, profile=False)
    assert fit.describes
    assert fit.doubt == ""
    for name in ("length", "decay_rate"):
        truth = getattr(record, name)
        # Four deviations, or what nobody minds.
        limit = max(4.0 * fit[name].sigma, 1e-4 * abs(truth))
        assert abs(fit[name].value - truth) < limit, name


@SEEDS
@pytest.mark.parametrize("kind", BROKEN)
def test_a_break_is_noticed_and_nothing_agrees(kind, seed):
    record = make_record(kind, seed)
    if kind == "turn":  # the one break that a swing is refused for
        with pytest.raises(InputError, match="turn"):
            ll.fit_decay(record.table, mass=record.mass, compare=False, profile=False)
        return
    fit = ll.fit_decay(record.table, mass=record.mass, compare=False, profile=False)
    assert not fit.describes
    assert fit.verdict.startswith(fit.doubt)
    assert "agrees" not in fit.verdict
    assert f"{fit['length'].value:.4g} m" not in fit.verdict


@pytest.fixture(scope="module")
def cut():
    """The fit of a record whose clock misses 3.7 seconds."""
    return ll.fit_decay(cut_out(3.7), **QUICK)


def test_a_piece_cut_out_of_the_clock_is_named_with_its_time_and_length(cut):
    fit = cut
    assert fit.dataset.attrs["break"] == "phase jump"
    assert fit.dataset.attrs["fails_at"] == pytest.approx(10.0, abs=0.3)  # a quarter of a swing
    assert "a piece of 3.7 s seems to be missing from the clock" in fit.verdict
    assert re.search("scatter 1[345] times the noise", fit.verdict)
    assert "No number of this fit is a result" in fit.verdict
    assert math.isfinite(fit["length"].value)  # still there, to look at


@pytest.mark.parametrize("seconds", [1.0 / 30.0, 0.6, 1.23])
def test_a_piece_of_any_length_cut_out_of_the_clock_is_named(seconds):
    fit = ll.fit_decay(cut_out(seconds), **QUICK)
    assert fit.dataset.attrs["break"] == "phase jump"
    assert fit.dataset.attrs["fails_at"] == pytest.approx(10.0, abs=0.1)
    assert f"a piece of {seconds:.2f}"[:-1] in fit.verdict


def test_a_wind_in_the_middle_is_named():
    times = np.arange(0.0, 30.0, 1.0 / 30.0)
    early = ll.simulate(PENDULUM, times=times[:450], initial_angle=0.4)
    blown = {
        "initial_angle": float(early.angle[-1]) - 0.02,
        "initial_angular_velocity": float(early.angular_velocity[-1]),
    }
    late = ll.simulate(PENDULUM, times=times[449:], **blown).angle.values + 0.02
    angle = np.concatenate([early.angle.values, late[1:]])
    fit = ll.fit_decay(table_of(times, angle + swing(times) - swing(times, size=0.0)), **QUICK)
    assert fit.dataset.attrs["break"] == "another rest"
    assert "the ball hangs elsewhere from there on, by 0.0" in fit.verdict


@pytest.mark.parametrize("change", ["gain", "smoothed", "drift"])
def test_what_apparatus_does_to_a_swing_is_in_its_deviations(change):
    times = np.arange(0.0, 40.0, 1.0 / 30.0)
    angle = swing(times, initial_angle=0.6)
    if change == "gain":
        angle = 1.01 * angle
    elif change == "smoothed":
        angle = np.convolve(np.pad(angle, 1, "edge"), np.ones(3) / 3.0, "valid")
    else:
        times = times * (1.0 + 1e-4 * times / 40.0)
    fit = ll.fit_decay(table_of(times, angle), **QUICK)
    assert fit.describes
    assert "Their deviations include that" in fit.verdict
    assert abs(fit["length"].value - 0.363) < 4.0 * fit["length"].sigma < 1e-2


def test_noise_that_grows_is_no_break():
    times = np.arange(0.0, 40.0, 1.0 / 30.0)
    still = swing(times, size=0.0)
    for seed in range(2):
        noise = np.random.default_rng(seed).normal(scale=1e-3 * np.exp(times / 14.0))
        assert ll.fit_decay(table_of(times, still + noise), **QUICK).describes


def test_a_sample_half_a_turn_away_is_no_jump():
    times = np.arange(0.0, 20.0, 1.0 / 30.0)
    angle = swing(times)
    angle[[100, 300]] += math.pi
    fit = ll.fit_decay(table_of(times, angle), **QUICK)
    assert "2 outliers were left out" in fit.verdict
    assert abs(fit["length"].value - 0.363) < 4.0 * fit["length"].sigma


def test_a_quarter_turn_of_the_camera_and_a_ball_at_rest_are_refused_as_such():
    times = np.arange(0.0, 40.0, 1.0 / 30.0)
    with pytest.raises(InputError, match="the angle is the same in all samples"):
        ll.fit_decay(table_of(times, np.full(len(times), 0.3)), **QUICK)
    angle = swing(times, initial_angle=0.1) + 0.5 * math.pi * (times > 20.0)
    with pytest.raises(InputError, match=r"jumps by 1\.\d* rad at 20"):
        ll.fit_decay(table_of(times, angle), **QUICK)


def test_a_swing_that_dies_at_once_is_fitted_without_an_envelope():
    rate = math.sqrt(9.8 / 0.363) / 4.0  # a quality of 2
    damped = ll.Pendulum(length=0.363, mass=0.108, damping=2.0 * rate * 0.108 * 0.363)
    times = np.arange(0.0, 6.0, 1.0 / 120.0)
    angle = ll.simulate(damped, times=times, initial_angle=1.0).angle.values
    angle = angle + np.random.default_rng(0).normal(scale=1e-3, size=len(times))
    fit = ll.fit_decay(table_of(times, angle), **QUICK)
    assert "turning points are too few for an envelope" in fit.verdict
    assert abs(fit["length"].value - 0.363) < 4.0 * fit["length"].sigma
    assert abs(fit["decay_rate"].value - rate) < 4.0 * fit["decay_rate"].sigma


def test_half_swings_with_a_gap_are_no_turning_points():
    times = np.arange(0.0, 400.0, 1.0 / 30.0)
    kept = (times < 5.0) | (times > 395.0)
    slow = ll.Pendulum(length=0.363, mass=0.108, damping=1e-4)
    angle = ll.simulate(slow, times=times, initial_angle=0.4).angle.values
    angle = angle + np.random.default_rng(0).normal(scale=1e-3, size=len(times))
    fit = ll.fit_decay(table_of(times[kept], angle[kept]), method="envelope", **QUICK)
    rate = 1e-4 / (2.0 * 0.108 * 0.363)
    assert abs(fit["decay_rate_envelope"].value - rate) < 4.0 * fit["decay_rate_envelope"].sigma


@pytest.mark.parametrize("degrees, rate", [(90, 12.0), (150, 30.0), (175, 30.0)])
def test_the_envelope_of_large_swings_is_right(degrees, rate):
    times = np.arange(0.0, 60.0, 1.0 / rate)
    angle = swing(times, initial_angle=math.radians(degrees))
    fit = ll.fit_decay(table_of(times, angle), method="envelope", **QUICK)
    truth = 0.00274 / (2.0 * 0.108 * 0.363)
    assert abs(fit["decay_rate_envelope"].value - truth) < 4.0 * fit["decay_rate_envelope"].sigma


def test_samples_so_few_that_another_swing_looks_the_same_say_so():
    times = np.arange(0.0, 60.0, 1.0 / 1.5)
    fit = ll.fit_decay(table_of(times, swing(times, initial_angle=0.05)), **QUICK)
    truth = math.tau * math.sqrt(0.363 / 9.8)
    assert fit["period"].value > 1.1 * truth
    assert f"a period of {truth:.3g} s would look the same" in fit.verdict


@pytest.mark.parametrize("first, end, angle", [(8, 48, 0.4), (8, 25.1, 0.4), (8, 48, 1.2)])
def test_a_gap_loses_no_swing(first, end, angle):
    times = np.arange(0.0, 60.0, 1.0 / 30.0)
    seen = swing(times, initial_angle=angle)
    kept = (times < first) | (times >= end)
    fit = ll.fit_decay(table_of(times[kept], seen[kept]), **QUICK)
    assert fit.describes
    assert abs(fit["length"].value - 0.363) < 4.0 * fit["length"].sigma
    assert fit["length"].sigma < 1e-5


def test_a_gap_that_leaves_the_number_of_swings_open_gives_no_length():
    # Three swings before and after ten minutes: several lengths fit.
    times = np.r_[np.arange(0.0, 3.6, 1.0 / 30.0), np.arange(600.0, 603.6, 1.0 / 30.0)]
    undamped = ll.simulate(
        ll.Pendulum(length=0.363, mass=0.108), initial_angle=0.1, times=times
    ).angle.values
    noise = np.random.default_rng(0).normal(scale=5e-3, size=len(times))
    fit = ll.fit_decay(table_of(times, undamped + noise), method="equation", **QUICK)
    assert "does not tell how many swings there were in its gap" in fit.verdict


def test_a_swing_that_grows_and_one_without_drag_are_reported_as_such():
    times = np.arange(0.0, 40.0, 1.0 / 30.0)
    backwards = swing(times)[::-1]
    fit = ll.fit_decay(table_of(times, backwards), **QUICK)
    assert "a swing that grows by 0.03" in fit.verdict
    assert fit["decay_rate"].value == pytest.approx(-0.03495, rel=0.01)
    assert fit.system is None
    still = ll.simulate(ll.Pendulum(length=0.363, mass=0.108), initial_angle=0.3, times=times)
    noise = np.random.default_rng(0).normal(scale=1e-3, size=len(times))
    fit = ll.fit_decay(table_of(times, still.angle.values + noise), **QUICK)
    assert "no drag within its error (decay rate below" in fit.verdict
    assert "which agrees" not in fit.verdict or "too uncertain" not in fit.verdict


@pytest.mark.parametrize("digits", [3, 9])
def test_samples_without_noise_are_not_doubted(digits):
    times = np.arange(0.0, 15.0, 1.0 / 60.0)
    angle = np.round(swing(times, size=0.0, initial_angle=0.5), digits)
    fit = ll.fit_decay(table_of(times, angle), **QUICK)
    assert fit.describes
    assert fit["length"].value == pytest.approx(0.363, rel=1e-5)


@pytest.mark.parametrize("rate", [6.0, 4.0, 3.0])
def test_few_samples_in_a_swing_are_fitted(rate):
    times = np.arange(0.0, 30.0, 1.0 / rate)
    fit = ll.fit_decay(table_of(times, swing(times)), **QUICK)
    assert abs(fit["length"].value - 0.363) < 4.0 * fit["length"].sigma
    assert "samples in a swing are too few to see its turning points" in fit.verdict
    with pytest.raises(InputError, match="too few to see its turning points"):
        ll.fit_decay(table_of(times, swing(times)), method="envelope", **QUICK)


def test_turning_points_alone_give_an_envelope_and_those_of_one_side_are_refused():
    times = np.arange(0.0, 30.0, 0.6046)
    sizes = 0.4 * np.exp(-0.035 * times) + np.random.default_rng(1).normal(
        scale=1e-3, size=len(times)
    )
    both = table_of(times, sizes * (-1.0) ** np.arange(len(times)))
    fit = ll.fit_decay(both, **QUICK)
    assert abs(fit["decay_rate_envelope"].value - 0.035) < 4.0 * fit["decay_rate_envelope"].sigma
    assert "The samples are turning points only" in fit.verdict
    with pytest.raises(InputError, match="turning points only"):
        ll.fit_decay(both, method="equation", **QUICK)
    with pytest.raises(InputError, match="give those of both sides"):
        ll.fit_decay(table_of(times[::2], sizes[::2]), **QUICK)


def test_the_period_is_the_first_number_and_an_offset_larger_than_the_swing_changes_nothing():
    times = np.arange(0.0, 20.0, 1.0 / 30.0)
    plain = ll.fit_decay(table_of(times, swing(times)), **QUICK)
    assert next(iter(plain.estimates)) == "period"
    truth = math.tau * math.sqrt(0.363 / 9.8)
    assert abs(plain["period"].value - truth) < 4.0 * plain["period"].sigma
    assert "a period of 1.209" in plain.verdict
    moved = ll.fit_decay(table_of(times, swing(times) - 0.6), **QUICK)
    for name in ("length", "decay_rate", "decay_rate_envelope"):
        assert moved[name].value == pytest.approx(plain[name].value, rel=1e-4)


def test_a_jump_by_a_turn_is_named_with_its_time():
    times = np.arange(0.0, 20.0, 1.0 / 30.0)
    angle = swing(times) + math.tau * (times > 12.0)
    with pytest.raises(InputError, match=r"jumps by a whole turn at 12\.0"):
        ll.fit_decay(table_of(times, angle), **QUICK)


def test_a_clock_or_a_length_that_nobody_has_is_questioned():
    times = np.arange(0.0, 20.0, 1.0 / 30.0)
    fit = ll.fit_decay(table_of(60.0 * times, swing(times)), **QUICK)
    assert fit.verdict.startswith("This is the period of a pendulum of 1310 m: is the clock")
    late = ll.fit_decay(table_of(1.02 * times, swing(times)), length=0.363, **QUICK)
    assert "the clock (frame rate, slow motion)" in late.verdict


@pytest.mark.parametrize(
    "degrees, duration, damping, digits",
    [(2.0, 20.0, 0.00274, 9), (2.0, 6.0, 0.0, 2), (3.0, 20.0, 0.0, 4), (2.0, 15.0, 0.03, 1)],
)
def test_degrees_that_a_table_calls_radians_are_asked_for(degrees, duration, damping, digits):
    times = np.arange(0.0, duration, 1.0 / 25.0)
    system = ll.Pendulum(length=0.363, mass=0.108, damping=damping)
    run = ll.simulate(system, initial_angle=math.radians(degrees), times=times)
    fit = ll.fit_decay(table_of(times, np.round(np.degrees(run.angle.values), digits)), **QUICK)
    assert fit.doubt.startswith("It swings as a pendulum does at ")
    assert "rad: are the angles in degrees, and their unit wrong?" in fit.doubt


@pytest.mark.parametrize("angle", [2.0, math.radians(2.0)])
def test_no_unit_is_asked_for_where_the_stated_one_is_right(angle):
    times = np.arange(0.0, 20.0, 1.0 / 30.0)
    assert ll.fit_decay(table_of(times, swing(times, initial_angle=angle)), **QUICK).describes


def test_files_json_and_pages_hold_the_doubt(tmp_path):
    table = cut_out(3.7, at=6.0, duration=16.0)
    write_table(table, tmp_path / "cut.csv")
    arguments = ["fit", "decay", str(tmp_path / "cut.csv"), "--no-compare", "--no-profile"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0
    assert "not a result: " in result.output
    found = json.loads(CliRunner().invoke(app, [*arguments, "--json"]).output)
    assert found["describes"] is False
    assert found["attributes"]["break"] == "phase jump"
    card = fits_of(table, {}, (640, 480))[0]["decay"]
    assert "values" not in card
    assert "does not describe this record" in card["error"]


def test_a_fit_that_does_not_describe_its_record_is_compared_with_nothing(cut):
    with pytest.raises(InputError, match="does not describe this record"):
        ll.compare(cut_out(0.0), cut)


def driven(times, clock=0.0, true=None, amplitude=0.03, noise=1e-4, rate=15.1):
    true = times if true is None else true
    height = amplitude * np.cos(rate * true + 0.5)
    height = height + np.random.default_rng(0).normal(scale=noise, size=len(times))
    return table_of(times + clock, 0.1 * np.cos(7.5 * times), pivot_y=height)


@pytest.mark.parametrize("clock", [0.0, 1e5, 1.7e9])
def test_a_drive_is_the_same_on_any_clock(clock):
    times = np.arange(0.0, 12.0, 1.0 / 60.0)
    fit = ll.fit_drive(driven(times, clock), profile=False)
    assert abs(fit["drive_frequency"].value - 15.1) < 4.0 * fit["drive_frequency"].sigma
    assert abs(fit["drive_phase"].value - 0.5) < 4.0 * fit["drive_phase"].sigma
    assert fit["drive_phase"].sigma < 1e-3
    assert fit.dataset.attrs["start"] - clock < 1.0
    row = trial_of(driven(times, clock), length=0.363)
    assert row["drive_frequency"] == pytest.approx(15.1, rel=1e-4)


def test_even_frames_leave_a_fast_drive_open_and_uneven_ones_decide():
    times = np.arange(0.0, 30.0, 1.0 / 60.0)
    even = ll.fit_drive(driven(times, rate=math.tau * 52.0, noise=2e-5), profile=False)
    assert even["drive_frequency"].value == pytest.approx(math.tau * 8.0, rel=1e-4)
    assert "a pivot at 52, 68 or 112 Hz would look the same" in even.verdict
    uneven = np.sort(times + np.random.default_rng(1).normal(scale=2e-3, size=len(times)))
    uneven -= uneven[0]
    table = driven(uneven, rate=math.tau * 52.0, noise=2e-5)
    fit = ll.fit_drive(table, profile=False)
    assert fit["drive_frequency"].value == pytest.approx(math.tau * 52.0, rel=1e-4)
    assert "look the same" not in fit.verdict
    with pytest.raises(InputError, match="faster than half the rate of the samples has no stages"):
        ll.fit_drive(table, stages=2, profile=False)


@pytest.mark.parametrize("first, end", [(10.0, 20.0), (1.0, 29.3)])
def test_a_gap_loses_no_cycle_of_a_drive(first, end):
    times = np.arange(0.0, 30.0, 1.0 / 60.0)
    fit = ll.fit_drive(driven(times).isel(frame=(times < first) | (times > end)), profile=False)
    assert fit.describes
    assert abs(fit["drive_frequency"].value - 15.1) < 4.0 * fit["drive_frequency"].sigma < 1e-3


def test_mistakes_and_repeats_in_the_track_of_a_drive_change_nothing():
    times = np.arange(0.0, 15.0, 1.0 / 60.0)
    table = driven(times)
    random = np.random.default_rng(0)
    table["pivot_y"].values[random.uniform(size=len(times)) < 0.03] += 0.02
    fit = ll.fit_drive(table, profile=False)
    twice = driven(times)
    twice["pivot_y"].values[1::2] = twice["pivot_y"].values[::2]
    for each in (fit, ll.fit_drive(twice, profile=False)):
        assert each.describes
        for name, truth in (("drive_frequency", 15.1), ("drive_phase", 0.5)):
            assert abs(each[name].value - truth) < 4.0 * each[name].sigma


def test_a_drive_that_the_frames_cannot_follow_is_not_at_rest():
    times = np.arange(0.0, 15.0, 1.0 / 60.0)
    with pytest.raises(InputError, match="it moves too fast for them"):
        ll.fit_drive(driven(times, rate=math.tau * 29.0), profile=False)


def test_a_drive_that_nobody_has_is_questioned():
    times = np.arange(0.0, 15.0, 1.0 / 60.0)
    table = table_of(1e3 * times, 0.1 * np.cos(7.5 * times), pivot_y=20.0 * np.cos(15.1 * times))
    fit = ll.fit_drive(table, profile=False)
    assert fit.verdict.startswith("A drive amplitude of 20 m is unusual")
    assert "A drive frequency of 0.0151 rad/s is unusual" in fit.verdict
    note = trial_of(table, length=0.363)["note"]
    assert "unusual drive amplitude: units?" in note


def test_breaks_of_a_drive_are_noticed():
    times = np.arange(0.0, 20.0, 1.0 / 60.0)
    jump = driven(times, true=np.where(times > 10, times + 3.3, times))
    jumped = ll.fit_drive(jump, profile=False)
    assert not jumped.describes
    assert jumped.dataset.attrs["fails_at"] == pytest.approx(10.0, abs=0.5)
    louder = driven(times, amplitude=np.where(times > 12, 0.033, 0.03))
    louder = ll.fit_drive(louder, profile=False)
    assert louder.dataset.attrs["break"] == "change of amplitude"
    with pytest.raises(InputError, match="does not describe the pivot's motion"):
        trial_of(jump, length=0.363)


def test_a_trial_whose_ball_hangs_at_a_turn_has_no_class():
    times = np.arange(0.0, 15.0, 1.0 / 60.0)
    table = driven(times)
    table["angle_1"].values[:] += math.tau
    with pytest.raises(InputError, match="ball 1 moves about 360 degrees"):
        trial_of(table, length=0.363)


def test_a_model_notices_a_jump_of_the_clock():
    system = ll.Pendulum(length=0.363, mass=0.1, damping=0.003)
    table = motion_table(system, initial_angle=0.5, duration=16.0)
    good = ll.fit_model(table, system, window=1e6)
    assert good.describes
    late = table.isel(frame=np.r_[0:480, 500:960])
    times = late["time"].values.copy()
    times[480:] -= 20.0 / 60.0
    fit = ll.fit_model(late.assign_coords(time=("frame", times)) if "time" in late.coords
                       else late.assign(time=("frame", times, late.time.attrs)),
                       system, window=1e6)  # fmt: skip
    assert not fit.describes


def test_halves_of_a_record_with_other_restitutions_are_told_apart():
    random = np.random.default_rng(0)

    def impacts(late):
        return [
            _Impact(float(i), -1.0, (0.9 if i < 20 else late) + 0.005 * random.normal(), 0.1, 0.01,
                    0.005)
            for i in range(40)
        ]  # fmt: skip

    assert _doubt(impacts(0.9)).describes
    doubt = _doubt(impacts(0.8))
    assert doubt.fails_at == 20.0
    assert "One coefficient of restitution does not describe these impacts" in doubt.doubt


def test_noise_alone_shows_a_change_less_often_than_one_in_fifty():
    times = np.arange(0.0, 20.0, 0.05)
    alarms = 0
    for seed in range(60):
        errors = np.random.default_rng(seed).normal(size=len(times))
        data = Data(times, errors, np.ones(len(times)), np.ones(len(times), dtype=np.int64))
        whole = solve(
            lambda p: p["a"] * np.cos(5.0 * times) + p["b"] * np.sin(5.0 * times) + p["c"],
            {name: Guess(0.0) for name in "abc"},
            data,
        )
        alarms += place_of_change(data, whole, 2.0) is not None
    assert alarms <= 1


def test_the_kind_of_a_break_is_the_one_with_the_fewest_changes():
    covariance = np.diag([1e-4, 1e-4])
    kinds = [
        Kind("one", frozenset({"phase"}), ""),
        Kind("both", frozenset({"amplitude", "phase"}), ""),
    ]

    def likeliest(**differences):
        return min(kinds, key=lambda kind: misfit_of(kind, differences, covariance)).name

    assert likeliest(amplitude=0.01, phase=1.0) == "one"
    assert likeliest(amplitude=0.10, phase=1.0) == "both"


def test_repeated_samples_are_left_out_and_rounded_ones_are_not():
    times = np.arange(0.0, 20.0, 1.0 / 30.0)
    angle = swing(times)
    angle[100:400:10] = angle[99:399:10]
    fit = ll.fit_decay(table_of(times, angle), **QUICK)
    assert "30 samples that repeat the one before were left out" in fit.verdict
    assert abs(fit["length"].value - 0.363) < 4.0 * fit["length"].sigma
    rounded = ll.fit_decay(table_of(times, np.round(swing(times), 2)), **QUICK)
    assert "repeat" not in rounded.verdict


@pytest.mark.parametrize("rate", [4.0, 6.0, 30.0, 200.0])
def test_noise_is_seen_however_few_samples_a_swing_has(rate):
    times = np.arange(0.0, 60.0, 1.0 / rate)
    random = np.random.default_rng(0)
    values = 0.4 * np.cos(math.tau * 0.8 * times) + random.normal(scale=5e-3, size=len(times))
    # Few samples leave something of the swing in every difference.
    assert 3e-3 < noise_of(values) < (4e-2 if rate < 6.0 else 8e-3)


def test_a_steady_drive_of_a_table_is_not_doubted():
    drive = ll.Harmonic(drive_amplitude=0.02, drive_frequency=12.0)
    for seed in range(3):
        assert ll.fit_drive(drive_table(drive, duration=10.0, seed=seed), profile=False).describes


@pytest.mark.parametrize("digits", [3, 5, 12])
def test_a_drive_in_rounded_numbers_is_not_doubted(digits):
    times = np.arange(0.0, 12.0, 1.0 / 60.0)
    drive = ll.Harmonic(drive_amplitude=0.02, drive_frequency=10.09)
    run = ll.simulate(PENDULUM, drive, initial_angle=0.1, times=times)
    height = np.round(run.pivot_height.values, digits)
    fit = ll.fit_drive(table_of(times, run.angle.values, pivot_y=height), profile=False)
    assert fit.describes
    assert fit["drive_frequency"].value == pytest.approx(10.09, rel=1e-4)
