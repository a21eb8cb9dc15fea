"""Every observable against the same number taken from a single run with dense samples."""

import functools
import math

import numpy as np
import pytest

import latolato as ll
from latolato.observables import Crossings, MotionClass, SelfStart, Stroboscope, observables
from latolato.observables.hermite import quintic, turning_angle

# Both sides follow the same motion with this tolerance.
TOLERANCE = 1e-10
DURATION = 10.0
# Everything there is; instances only where the default would not tell much in ten seconds.
WATCHED = (
    "mean_energy",
    "crossings",
    "rotations",
    "largest_angle",
    "largest_angle_after_transient",
    MotionClass(),
    SelfStart(),
    "bottom_contacts",
    "top_contacts",
    "impact_speed",
    "rest_fraction",
    "works",
    "final_angle",
    "final_angular_velocity",
    Stroboscope(periods=4),
)
# Slack is followed by single trajectories only: it keeps the others out of the lanes.
ALL = (*WATCHED, "slack_fraction")
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
        ll.BallPair(
            right=BALL, left=ll.Ball(length=0.95, mass=0.5, radius=0.1), restitution=0.8
        ),
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
    """All samples of |x|, and its stationary values between them (quintic of a short step)."""
    found = list(np.abs(x))
    for i in np.flatnonzero((v[:-1] * v[1:] < 0.0) & (np.diff(t) > 1e-9)):
        h = t[i + 1] - t[i]
        u = v[i] / (v[i] - v[i + 1])
        # cubic Hermite: samples are a millisecond apart, its error is below 1e-12
        d = x[i + 1] - x[i]
        b, c = v[i] * h, v[i + 1] * h
        found.append(abs(x[i] + u * (b + u * ((3 * d - 2 * b - c) + u * (b + c - 2 * d)))))
    return found


def sign_changes(values):
    """How often samples change their sign."""
    return np.count_nonzero(np.diff(np.signbit(values)))


def by_hand(name, begin):
    """Every variable from the dense run, arrays over the ball; only what a run tells."""
    run, weights = dense_run(name, begin)
    system = CASES[name][0]
    balls = system.angles
    t = run.time.values
    late = t >= begin
    observed = DURATION - begin
    x, v = per_ball(run, "angle"), per_ball(run, "angular_velocity")
    found = {"final_angle": x[:, -1], "final_angular_velocity": v[:, -1]}
    energy = per_ball(run, "total_energy")
    found["mean_energy"] = (energy * np.where(late, weights, 0.0)).sum(axis=1) / observed
    found["crossings"] = [sign_changes(np.cos(a[late]) - math.cos(2.0)) for a in x]
    found["rotations"] = [sign_changes(np.cos(0.5 * a[late])) for a in x]
    when, kind = run.contact_time.values, run.contact_kind.values
    walls = []
    if system.angles == 1 and system.has_contacts:
        wall = {"bottom": system.contact_angle_low, "top": system.contact_angle_high}
        walls = [(a, wall[k]) for a, k in zip(when, kind, strict=True) if k in wall]
    bounced = [[w for a, w in walls if a >= since] for since in (0.0, begin)]
    found["largest_angle"] = [max(tops(t, *a) + bounced[0]) for a in zip(x, v, strict=True)]
    found["largest_angle_after_transient"] = [
        max(tops(t[late], a[late], b[late]) + bounced[1]) for a, b in zip(x, v, strict=True)
    ]
    found["motion_class"] = [
        2 if a >= math.pi / 2 else 1 if b >= math.pi / 4 else 0
        for a, b in zip(
            found["largest_angle"], found["largest_angle_after_transient"], strict=True
        )
    ]
    found["self_start"] = np.max(np.abs(x - x[:, :1]), axis=1) > 0.01
    for side in ("bottom", "top"):
        found[f"{side}_contacts"] = [np.count_nonzero((kind == side) & (when >= begin))] * balls
    hits = np.isin(kind, ("bottom", "top")) & (when >= begin)
    before = per_ball(run, "angular_velocity_before")[:, hits]
    speeds = np.abs(before[0] - before[1] if balls == 2 else before[0])
    nothing = math.nan
    found["mean_impact_speed"] = [speeds.mean() if len(speeds) else nothing] * balls
    found["impact_speed_deviation"] = [speeds.std() if len(speeds) else nothing] * balls
    found["largest_impact_speed"] = [speeds.max() if len(speeds) else nothing] * balls
    rests, releases = when[kind == "rest"], when[kind == "release"]
    if name == "toy at rest":  # it has been in contact all the time, which no row tells
        rests = np.array([0.0])
    ends = [min(releases[releases > a], default=DURATION) for a in rests]
    held = sum(max(0.0, b - max(a, begin)) for a, b in zip(rests, ends, strict=True))
    found["rest_fraction"] = [held / observed] * balls
    first = int(np.flatnonzero(t == begin)[0])
    for name_ in LEDGER:
        ledger = run[name_].values
        found[name_] = ledger[-1] - ledger[first]
    pushed = []
    for a in per_ball(run, "tension"):
        negative = np.minimum(a[late], 0.0)
        share = np.where(negative < 0.0, 1.0, 0.0)
        pushed.append(float((np.diff(t[late]) * 0.5 * (share[1:] + share[:-1])).sum()) / observed)
    found["slack_fraction"] = pushed
    return {k: np.asarray(a, dtype=np.float64) for k, a in found.items()}


@functools.cache
def swept(name, how, executor):
    """A sweep of one point."""
    system, drive, start = CASES[name]
    start = dict(start)
    key = "restitution" if system.has_contacts else "mass"
    value = system.restitution if system.has_contacts else system.mass
    return ll.sweep(
        system, drive, axes={key: [value]}, duration=DURATION, observables=ALL, **start,
        **TRANSIENTS[how], tolerance=TOLERANCE, executor=executor,
    ) if drive is not None else ll.sweep(
        system, axes={key: [value]}, duration=DURATION, observables=ALL[:-2] + ALL[-1:], **start,
        **TRANSIENTS[how], tolerance=TOLERANCE, executor=executor,
    )


def tolerance_of(variable):
    """How far a variable may lie from the dense run's, and why."""
    if variable in COUNTS:
        return 0.0
    if variable == "slack_fraction":
        # ends of slack lie between samples a millisecond apart, each half off: a few dozen ends
        return 1e-3
    if variable == "mean_energy":
        # the trapezoid with end correction has order 4: (rate step)^4/720 = 2e-7 of the energy
        return 3e-6
    return 3e-8  # a hundred tolerances of growth over ten seconds, times speeds up to 10 rad/s


ONE_BALL = [name for name in CASES if name != "two balls"]


@pytest.mark.parametrize("how", TRANSIENTS)
@pytest.mark.parametrize("name", ONE_BALL)
def test_variables_of_one_ball_are_those_of_a_dense_run(name, how):
    compare(name, how, "threads")


@pytest.mark.parametrize("how", TRANSIENTS)
def test_variables_of_two_balls_are_those_of_a_dense_run(how):
    compare("two balls", how, "reference")


def compare(name, how, executor):
    system, drive, _ = CASES[name]
    begin = transient_of(system, drive, **TRANSIENTS[how])
    wanted = by_hand(name, begin)
    found = swept(name, how, executor).squeeze()
    for variable, values in wanted.items():
        actual = found[variable].values
        expected = values if system.angles == 2 or variable in LEDGER else values[0]
        np.testing.assert_allclose(
            actual, expected, rtol=0.0, atol=tolerance_of(variable), err_msg=variable
        )
