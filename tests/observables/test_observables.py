"""Every observable against the same number taken from a single run with dense samples."""

import functools
import math
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import brentq

import latolato as ll
from latolato.core.quantities import Quantity
from latolato.core.scalar import formula
from latolato.observables import (
    ContactWord,
    Crossings,
    MotionClass,
    Observable,
    PoincareSection,
    ResponseSamples,
    SelfStart,
    observables,
)
from latolato.observables.hermite import quintic, turning_angle
from watched import ALL

# Both sides follow the same motion with this tolerance.
TOLERANCE = 1e-10
DURATION = 10.0
LEDGER = ("drive_work", "damping_loss", "impact_loss", "capture_loss")
COUNTS = ("crossings", "rotations", "bottom_contacts", "top_contacts", "motion_class", "self_start")

BALL = ll.Ball(length=1.0, mass=0.8, radius=0.1, damping=0.02)
CASES = {
    "rotating pendulum": (
        ll.Pendulum(length=1.0, mass=0.8, damping=0.05),
        ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.0),
        {"initial_angle": 0.1, "initial_angular_velocity": 8.0},
    ),
    "pendulum that dies away": (
        ll.Pendulum(length=0.7, mass=0.8, damping=0.3),
        None,
        {"initial_angle": 2.4},
    ),
    "bouncing toy": (
        ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.9),
        ll.Harmonic(drive_amplitude=0.2, drive_frequency=8.0, drive_phase=0.4),
        {"initial_offset": 0.9, "initial_angular_velocity": 6.0},
    ),
    "toy that rests and is thrown": (
        ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.3),
        ll.Harmonic(drive_amplitude=0.05, drive_frequency=18.0),
        {"initial_offset": 0.3},
    ),
    "toy at rest": (
        ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.9),
        ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.0),
        {"initial_offset": 0.0},
    ),
    "two balls": (
        ll.BallPair(right=BALL, left=ll.Ball(length=0.95, mass=0.5, radius=0.1), restitution=0.8),
        ll.Harmonic(drive_amplitude=0.1, drive_frequency=7.0),
        {"initial_angle": (1.5, -0.9), "initial_angular_velocity": (0.0, -1.0)},
    ),
}
TRANSIENTS = {
    "no transient": {},
    "transient by time": {"transient": 2.2},
    "transient by periods": {"transient_periods": 2.5},
    "both transients": {"transient": 1.1, "transient_periods": 1.5},
}


def transient_of(system, drive, transient=0.0, transient_periods=0.0):
    """The transient in seconds, by hand."""
    rate = math.sqrt(9.8 / system.balls[0].length) if drive is None else drive.drive_frequency
    return transient + transient_periods * 2.0 * math.pi / rate


@functools.cache
def dense_run(name, begin):
    """A run sampled so that means and largest values can be taken, and weights of a time mean.

    Samples: Gauss nodes of panels that no contact cuts, one every millisecond, and `begin`.
    """
    system, drive, start = CASES[name]
    first = ll.simulate(system, drive, **start, times=[DURATION], tolerance=TOLERANCE)
    cuts = np.concatenate([first.contact_time.values, [0.0, begin, DURATION]])
    cuts = np.unique(np.concatenate([cuts, np.arange(0.0, DURATION, 0.05)]))
    nodes, weights = np.polynomial.legendre.leggauss(6)
    low, width = cuts[:-1], np.diff(cuts)
    wide = width > 1e-6  # a bounce of a Zeno cascade that short weighs nothing
    low, width = low[wide], width[wide]
    instants = (low[:, None] + 0.5 * width[:, None] * (1.0 + nodes)).ravel()
    weights = (0.5 * width[:, None] * weights).ravel()
    even = np.linspace(0.0, DURATION, 10_001)
    times = np.concatenate([instants, even, [begin]])
    weights = np.concatenate([weights, np.zeros(len(even) + 1)])
    times, where = np.unique(times, return_index=True)
    run = ll.simulate(system, drive, **start, times=times, tolerance=TOLERANCE)
    return run, weights[where]


def per_ball(run, name):
    """The values of a variable, shape (ball, ...)."""
    return np.atleast_2d(run[name].values)


def tops(t, x, v):
    """All samples of |x|, and its stationary values between them."""
    result = list(np.abs(x))
    for i in np.flatnonzero((v[:-1] * v[1:] < 0.0) & (np.diff(t) > 1e-9)):
        h = t[i + 1] - t[i]
        u = v[i] / (v[i] - v[i + 1])
        # cubic Hermite: samples are a millisecond apart, its error is below 1e-12
        d = x[i + 1] - x[i]
        b, c = v[i] * h, v[i + 1] * h
        result.append(abs(x[i] + u * (b + u * ((3 * d - 2 * b - c) + u * (b + c - 2 * d)))))
    return result


def sign_changes(values):
    """How often samples change their sign."""
    return np.count_nonzero(np.diff(np.signbit(values)))


def first_passage(t, x, v, level):
    """The first instant at which |x| is at the level, on cubics between samples."""
    if abs(x[0]) >= level:
        return 0.0
    beyond = np.flatnonzero(np.abs(x) >= level)
    if not beyond.size:
        return math.nan
    part = slice(beyond[0] - 1, beyond[0] + 1)
    side = np.sign(x[beyond[0]])
    cubic = CubicHermiteSpline(t[part], side * x[part], side * v[part])
    return brentq(lambda u: cubic(u) - level, t[part][0], t[part][1], xtol=1e-14)


def by_hand(name, begin):
    """Every variable from the dense run, arrays over the ball; only what a run tells."""
    run, weights = dense_run(name, begin)
    system = CASES[name][0]
    balls = system.angles
    t = run.time.values
    late = t >= begin
    observed = DURATION - begin
    x, v = per_ball(run, "angle"), per_ball(run, "angular_velocity")
    result = {"final_angle": x[:, -1], "final_angular_velocity": v[:, -1]}
    energy = per_ball(run, "total_energy")
    result["mean_energy"] = (energy * np.where(late, weights, 0.0)).sum(axis=1) / observed
    result["crossings"] = [sign_changes(np.cos(a[late]) - math.cos(2.0)) for a in x]
    result["rotations"] = [sign_changes(np.cos(0.5 * a[late])) for a in x]
    when, kind = run.contact_time.values, run.contact_kind.values
    walls = []
    if system.angles == 1 and system.has_contacts:
        wall = {"bottom": system.contact_angle_low, "top": system.contact_angle_high}
        walls = [(a, wall[k]) for a, k in zip(when, kind, strict=True) if k in wall]
    bounced = [[w for a, w in walls if a >= since] for since in (0.0, begin)]
    result["largest_angle"] = [max(tops(t, *a) + bounced[0]) for a in zip(x, v, strict=True)]
    result["largest_angle_after_transient"] = [
        max(tops(t[late], a[late], b[late]) + bounced[1]) for a, b in zip(x, v, strict=True)
    ]
    result["motion_class"] = [
        2 if a >= math.pi / 2 else 1 if b >= math.pi / 4 else 0
        for a, b in zip(
            result["largest_angle"], result["largest_angle_after_transient"], strict=True
        )
    ]
    result["self_start"] = np.max(np.abs(x - x[:, :1]), axis=1) > 0.01
    result["first_passage"] = [first_passage(t, *a, 1.2) for a in zip(x, v, strict=True)]
    for side in ("bottom", "top"):
        result[f"{side}_contacts"] = [np.count_nonzero((kind == side) & (when >= begin))] * balls
    hits = np.isin(kind, ("bottom", "top")) & (when >= begin)
    before = per_ball(run, "angular_velocity_before")[:, hits]
    speeds = np.abs(before[0] - before[1] if balls == 2 else before[0])
    nothing = math.nan
    result["mean_impact_speed"] = [speeds.mean() if len(speeds) else nothing] * balls
    result["impact_speed_deviation"] = [speeds.std() if len(speeds) else nothing] * balls
    result["largest_impact_speed"] = [speeds.max() if len(speeds) else nothing] * balls
    rests, releases = when[kind == "rest"], when[kind == "release"]
    if name == "toy at rest":  # it has been in contact all the time, which no row tells
        rests = np.array([0.0])
    ends = [min(releases[releases > a], default=DURATION) for a in rests]
    held = sum(max(0.0, b - max(a, begin)) for a, b in zip(rests, ends, strict=True))
    result["rest_fraction"] = [held / observed] * balls
    first = int(np.flatnonzero(t == begin)[0])
    for name_ in LEDGER:
        ledger = run[name_].values
        result[name_] = ledger[-1] - ledger[first]
    pushed = []
    for a in per_ball(run, "tension"):
        negative = np.minimum(a[late], 0.0)
        share = np.where(negative < 0.0, 1.0, 0.0)
        pushed.append(float((np.diff(t[late]) * 0.5 * (share[1:] + share[:-1])).sum()) / observed)
    result["compression_fraction"] = pushed
    return {k: np.asarray(a, dtype=np.float64) for k, a in result.items()}


@functools.cache
def swept(name, how, executor):
    """A sweep of one point, along an axis that changes nothing."""
    system, drive, start = CASES[name]
    watched = [o for o in ALL if drive is not None or not isinstance(o, PoincareSection)]
    return ll.sweep(
        system, drive, axes={"gravity": [9.8]}, duration=DURATION, observables=watched, **start,
        **TRANSIENTS[how], tolerance=TOLERANCE, executor=executor,
    ).squeeze("gravity")  # fmt: skip


def tolerance_of(variable, largest_energy):
    """How far a variable may lie from the dense run's, and why."""
    if variable in COUNTS:
        return 0.0
    if variable == "compression_fraction":
        # ends of compression lie between samples a millisecond apart: up to a dozen in ten seconds
        return 1e-4
    if variable == "mean_energy":
        # the trapezoid with end correction has order 4: (2 rate step)^4/720 = 3e-6 at rate step
        # 0.1, as the energy turns twice as fast as the angle; most of it cancels along the run
        return 1e-6 * largest_energy
    return 1e-10  # the runs differ by the rounding of a few hundred steps and impacts


def compare(name, how, executor):
    """Hold every variable of a sweep against the dense run."""
    system, drive, _ = CASES[name]
    begin = transient_of(system, drive, **TRANSIENTS[how])
    target = by_hand(name, begin)
    largest_energy = float(dense_run(name, begin)[0].total_energy.max())
    result = swept(name, how, executor)
    for variable, values in target.items():
        alone = system.angles == 1 or variable in LEDGER
        expected = np.ravel(values)[0] if alone else values
        atol = tolerance_of(variable, largest_energy)
        np.testing.assert_allclose(
            result[variable].values, expected, rtol=0.0, atol=atol, err_msg=variable
        )


@pytest.mark.parametrize("how", TRANSIENTS)
@pytest.mark.parametrize("name", [name for name in CASES if name != "two balls"])
def test_variables_of_one_ball_are_those_of_a_dense_run(name, how):
    compare(name, how, "threads")


@pytest.mark.parametrize("how", TRANSIENTS)
def test_variables_of_two_balls_are_those_of_a_dense_run(how):
    compare("two balls", how, "reference")


def test_mean_energy_has_order_four():
    system, drive, start = CASES["rotating pendulum"]
    exact = by_hand("rotating pendulum", 0.0)["mean_energy"][0]
    # a step is 5 tolerance^(1/6) over the rate; the motion itself, of order 6, is far better
    result = [
        ll.sweep(
            system, drive, axes={"gravity": [9.8]}, duration=DURATION, observables=["mean_energy"],
            tolerance=tolerance, executor="reference", **start,
        ).mean_energy.item()
        for tolerance in (1e-9, 1e-9 / 64.0, 1e-9 / 64.0**2)
    ]  # fmt: skip
    errors = np.abs(np.array(result) - exact)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.1)


def test_variables_of_two_balls_are_the_same_compiled():
    plain, compiled = (swept("two balls", "both transients", e) for e in ("reference", "threads"))
    assert plain.status.equals(compiled.status)
    for name in set(plain.data_vars) - {"status"}:
        # the rounding of a few hundred steps, as math.sin is not the compiled polynomial
        np.testing.assert_allclose(compiled[name], plain[name], rtol=0.0, atol=1e-9, err_msg=name)


def test_every_registered_observable_is_held_against_a_dense_run():
    output = set(by_hand("bouncing toy", 0.0)) | set(PoincareSection.variables)
    output |= set(ResponseSamples.variables)  # in tests/analysis/test_periods.py
    output |= set(ContactWord.variables)  # in test_contact_word.py
    # Those of strings are in tests/numerics/test_strings.py.
    output |= {name for kind in observables.values() if kind.of_strings for name in kind.variables}
    for name, kind in observables.items():
        # What becomes of deviations is held against differences, in tests/analysis/test_flow.py.
        assert kind.tangent is not None or set(kind.variables) <= output, name


def test_the_cases_have_something_to_find():
    # a number that is zero in every case would be right for the wrong reason
    for variable in set(by_hand("bouncing toy", 0.0)) - {"capture_loss"}:
        sizes = [np.nanmax(np.abs(by_hand(name, 0.0)[variable]), initial=0.0) for name in CASES]
        assert max(sizes) > 0.0, variable
    classes = {c for name in CASES for c in by_hand(name, 0.0)["motion_class"]}
    assert classes == {0.0, 1.0, 2.0}


@pytest.mark.parametrize("name", ["rotating pendulum", "bouncing toy", "two balls"])
def test_stroboscope_gives_the_state_at_whole_periods(name):
    system, drive, start = CASES[name]
    period = 2.0 * math.pi / drive.drive_frequency
    last = math.floor(DURATION / period)
    times = period * np.arange(last - 3, last + 1)
    run = ll.simulate(system, drive, **start, times=times, duration=DURATION, tolerance=TOLERANCE)
    executor = "reference" if system.angles == 2 else "threads"
    result = swept(name, "no transient", executor)
    assert result.sizes["sample"] == 4
    pairs = {"section_angle": "angle", "section_angular_velocity": "angular_velocity"}
    for variable, plain in pairs.items():
        # a step ends at each sample: other steps, each with its share of the tolerance
        np.testing.assert_allclose(result[variable].values, run[plain].values, rtol=0.0, atol=1e-8)


def test_stroboscope_leaves_out_what_is_before_the_start_or_in_the_transient():
    system, drive, start = CASES["rotating pendulum"]
    period = 2.0 * math.pi / drive.drive_frequency
    options = {"observables": [PoincareSection(periods=4)], "executor": "reference", **start}
    axes = {"gravity": [9.8]}
    for transient, known in ((0.0, [False, True, True, True]), (1.5, [False, False, False, True])):
        result = ll.sweep(
            system, drive, axes=axes, duration=2.2 * period, transient=transient * period, **options
        )
        angles = result.section_angle.values[0]
        assert list(np.isfinite(angles)) == known
        if not transient:
            assert angles[1] == start["initial_angle"]  # period 0 is the start itself


@pytest.mark.parametrize("periods, frequency", [(3, 6.0), (11, 4.0), (22, 7.0)])
def test_a_whole_number_of_periods_ends_with_the_final_state(periods, frequency):
    # the last two durations are rounded to just below so many periods
    system, _, start = CASES["rotating pendulum"]
    result = ll.sweep(
        system,
        ll.Harmonic(drive_amplitude=0.1, drive_frequency=frequency),
        axes={"gravity": [9.8]},
        duration=periods * math.tau / frequency,
        observables=[PoincareSection(periods=4), "final_angle", "final_angular_velocity"],
        executor="reference",
        **start,
    )
    assert result.section_angle.values[0, -1] == result.final_angle.values[0]
    velocity = result.section_angular_velocity.values[0, -1]
    assert velocity == result.final_angular_velocity.values[0]


@pytest.mark.parametrize("angle", [0.3, 1.0, 2.0, 3.1])
def test_crossings_of_the_unwrapped_angle_are_those_of_the_two_angles_only(angle):
    system, drive, start = CASES["rotating pendulum"]
    watched = Crossings(crossing_angle=angle, unwrapped=True)
    wrapped = Crossings(crossing_angle=angle)
    counts = [
        float(ll.sweep(
            system, drive, axes={"gravity": [9.8]}, duration=DURATION, observables=[o], **start,
            executor="reference", tolerance=TOLERANCE,
        ).crossings[0])
        for o in (watched, wrapped)
    ]  # fmt: skip
    run, _ = dense_run("rotating pendulum", 0.0)
    x = run.angle.values
    assert counts[0] == sign_changes(x - angle) + sign_changes(x + angle)
    assert counts[1] == sign_changes(np.cos(x) - math.cos(angle))
    assert counts[0] < counts[1]


@pytest.mark.parametrize("turn", ["free", "at a wall"])
def test_a_level_just_below_the_turning_point_is_crossed_twice_a_swing(turn):
    # The swing from 2 rad turns 1e-4 rad beyond the level and is back within 2 sqrt(2 1e-4/8.9)
    # = 9.5 ms; a step takes 73 ms at tolerance 1e-8, so that most turns lie within one. Between
    # walls the ball comes back in the time of one fall, on the same side.
    arguments = {"length": 1.0, "mass": 0.8}
    low = 0.0 if turn == "free" else 0.1
    system = (
        ll.Pendulum(**arguments)
        if turn == "free"
        else ll.LatoLato(**arguments, radius=math.sin(low))
    )
    fall = quad(
        # dt = dth/sqrt(2 g (cos th - cos 2)), th = 2 - (2 - low) s^2
        lambda s: 2.0 * (2.0 - low) * s
        / math.sqrt(2.0 * 9.8 * (math.cos(2.0 - (2.0 - low) * s * s) - math.cos(2.0))),
        0.0, 1.0,
    )[0]  # fmt: skip
    swings = 20
    result = ll.sweep(
        system, axes={"initial_angle": [2.0]}, duration=(2 * swings + 1) * fall, tolerance=1e-8,
        observables=[Crossings(crossing_angle=2.0 - 1e-4)], executor="reference",
    )  # fmt: skip
    assert float(result.crossings[0]) == 1.0 + 2.0 * swings  # the start is beyond the level


def test_friction_that_holds_the_ball_counts_as_rest():
    system = ll.Pendulum(length=1.0, mass=0.8, coulomb_damping=0.3)
    run = ll.simulate(
        system, initial_angle=0.5, duration=DURATION, times=np.linspace(0.0, DURATION, 100_001)
    )
    held = run.angular_velocity.values == 0.0
    result = ll.sweep(
        system, axes={"gravity": [9.8]}, initial_angle=0.5, duration=DURATION,
        observables=["rest_fraction"], executor="reference", tolerance=TOLERANCE,
    )  # fmt: skip
    assert 0.3 < float(result.rest_fraction[0]) < 1.0
    # one of a hundred thousand samples may lie on either side of the stop, one more is the start
    assert float(result.rest_fraction[0]) == pytest.approx(np.mean(held), abs=3e-5)


@pytest.mark.parametrize(
    "limits, expected", [((1.0, 0.5), 2.0), ((1.3, 1.0), 1.0), ((1.3, 1.25), 0.0)]
)
def test_motion_class_follows_its_angles(limits, expected):
    # 1.2 rad at first, 1.05 rad after a few swings of light damping
    strong, weak = limits
    result = ll.sweep(
        ll.Pendulum(length=1.0, mass=0.8, damping=0.05), axes={"initial_angle": [1.2]},
        duration=DURATION, transient=3.0, executor="reference",
        observables=[MotionClass(strong_angle=strong, weak_angle=weak)],
    )  # fmt: skip
    assert float(result.motion_class[0]) == expected


@pytest.mark.parametrize("least, moved", [(0.05, 1.0), (0.5, 0.0)])
def test_self_start_is_a_motion_by_more_than_its_angle(least, moved):
    result = ll.sweep(
        ll.Pendulum(length=1.0, mass=0.8), axes={"initial_angle": [0.2]}, duration=3.0,
        observables=[SelfStart(least_motion=least)], executor="reference",
    )  # fmt: skip
    assert float(result.self_start[0]) == moved


def test_a_parabola_through_a_turn_is_met_exactly():
    # angle 1 - (t - 0.3)^2 over a step of 1: turns at 0.3, at height 1
    ends = (1.0, 0.91, 0.6, -2.0, 0.51, -1.4, -2.0)
    assert turning_angle(*ends) == pytest.approx(1.0, abs=1e-15)
    assert quintic(0.0, *ends) == 0.91
    assert quintic(1.0, *ends) == pytest.approx(0.51, abs=1e-15)
    still = (1.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0)
    assert turning_angle(*still) == 1.0  # no turn: the end


class Seen:
    """A step that notes which of its numbers are read."""

    def __init__(self):
        self.names = set()

    def __getattr__(self, name):
        self.names.add(name)
        return 0.5


@pytest.mark.parametrize("name", observables)
def test_what_sweeps_find_for_all_observables_is_what_they_say_they_need(name):
    kind = observables[name]
    if kind.step is None:
        assert not {"energy", "turn"} & kind.needs
        return
    seen = Seen()
    kind.step(np.ones(64), 0, 1, seen)
    assert ("turn" in seen.names) == ("turn" in kind.needs)
    assert bool({"e0", "e1"} & seen.names) == ("energy" in kind.needs)


@formula
def _add_time(acc, i, n, segment):
    acc[i + n] += segment.t1 - segment.t0
    acc[i + 2 * n] += 1.0


@dataclass(frozen=True, kw_only=True)
class TimeSeen(Observable):
    """How long a ball was seen, with one slot beside its variable."""

    variables: ClassVar = {"time_seen": Quantity("s", "t", "time")}
    step: ClassVar = staticmethod(_add_time)

    least: float = field(default=0.0)

    @property
    def memory(self):
        return 2


class ForgetfulTimeSeen(TimeSeen):
    """The same without that slot."""

    @property
    def memory(self):
        return 1


def one_point(observable, **options):
    pendulum = ll.Pendulum(length=1.0, mass=0.8)
    return ll.sweep(
        pendulum, axes={"initial_angle": [0.4]}, duration=2.0, observables=[observable], **options
    )


def test_an_observable_of_ones_own_runs_on_every_executor(monkeypatch):
    monkeypatch.setitem(observables._entries, "time_seen", TimeSeen)
    result = [one_point(TimeSeen(), executor=name) for name in ("threads", "reference")]
    for each in result:
        assert each.time_seen.item() == pytest.approx(2.0, rel=1e-12)


def test_a_formula_that_uses_more_slots_than_it_has_is_refused_before_the_sweep(monkeypatch):
    monkeypatch.setitem(observables._entries, "forgetful", ForgetfulTimeSeen)
    with pytest.raises(ll.InputError, match=r"ForgetfulTimeSeen.step uses more than the 2 slots"):
        one_point(ForgetfulTimeSeen())


@pytest.mark.parametrize("value", ["0.5", None, (1.0,)])
def test_parameters_of_an_observable_are_numbers(value):
    with pytest.raises(ll.InputError, match="least must be a number"):
        TimeSeen(least=value)
