"""Motions of balls on strings for latolato and for the independent program, and comparisons."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import latolato as ll
from string_balls import LEDGER, Body, Strings

CASES = json.loads((Path(__file__).parents[1] / "reference/strings.json").read_text())["cases"]
STATE = ("angle", "distance", "angular_velocity", "radial_velocity", "slack")


def read(case):
    """Return a case of the file as `Strings`, its start and its times."""
    p = dict(case["parameters"])
    body = Body(**{name: p.pop(name) for name in ("l", "m", "C", "r") if name in p})
    string = case.get("suspension", "string") == "string"  # that of the toy is not named
    return Strings([body], string=string, **p), [tuple(case["start"])], case["times"]


def laws(motion):
    """Return latolato's system and drive for a motion of the independent program."""
    own = {"suspension": "rod", "gravity": motion.g}
    if motion.string:
        own |= {"suspension": "string", "string_restitution": motion.es}
    own["drag_frame"] = "lab" if motion.lab else "pivot"
    balls = [
        {"length": b.l, "mass": b.m, "damping": b.C, "quadratic_damping": b.C2, "radius": b.r}
        for b in motion.bodies
    ]
    if motion.walls:
        system = ll.LatoLato(**balls[0], **own, restitution=motion.e)
    elif len(balls) == 2:
        right, left = (ll.Ball(**ball) for ball in balls)
        system = ll.BallPair(right=right, left=left, restitution=motion.e, **own)
    else:
        balls[0].pop("radius")
        system = ll.Pendulum(**balls[0], **own)
    if motion.w == 0.0:
        return system, None
    if motion.Ax == 0.0:
        w, phase = motion.w, motion.phase
        return system, ll.Harmonic(drive_amplitude=motion.A0, drive_frequency=w, drive_phase=phase)
    return system, ll.PlanarHarmonic(
        vertical_amplitude=motion.A0,
        horizontal_amplitude=motion.Ax,
        drive_frequency=motion.w,
        vertical_phase=motion.phase,
        horizontal_phase=motion.phx,
    )


def simulated(motion, start, times, **options):
    """Return latolato's run of the same motion."""
    system, drive = laws(motion)
    names = ("initial_angle", "initial_angular_velocity", "initial_distance")
    columns = zip(*start, strict=True)
    begun = {
        name: column[0] if len(start) == 1 else column
        for name, column in zip(names, columns, strict=False)
    }
    return ll.simulate(system, drive, **begun, times=times, **{"tolerance": 1e-12, **options})


def rows(run, kind, least_jump=1e-4):
    """Return the times of contacts of a kind.

    Of strings that tighten only those with a jump that can be seen [m/s]: how many bounces there
    are before a capture is a matter of rounding. Whether a run that begins slack says so is not
    looked at.
    """
    keep = (run.contact_kind == kind) & (run.contact_time > 0.0)
    if kind == "taut" and "slack" in run:
        jump = np.abs(run.radial_velocity_after - run.radial_velocity_before)
        keep &= (jump.max("ball") if "ball" in jump.dims else jump) > least_jump
    return run.contact_time.values[keep.values]


def same_rows(events, kind, least_jump=1e-4):
    """Return the same of the independent program's events."""
    return [
        event.time
        for event in events
        if event.kind == kind
        and event.time > 0.0
        and (
            kind != "taut"
            or np.abs(np.subtract(event.after, event.before))[:, 1].max() > least_jump
        )
    ]


def assert_agree(run, expected, bound):
    """Compare states, works, losses and contacts.

    Velocities and energies are compared relative to their size, beyond 1 rad/s, 1 m/s and 1 J.
    """
    samples, two = expected.samples, "ball" in run.dims
    for name in (*STATE, "kinetic_energy", "potential_energy", *LEDGER):
        wanted = samples[name] if two or samples[name].ndim == 1 else samples[name][0]
        size = max(1.0, np.abs(wanted).max()) if name not in STATE[:2] else 1.0
        np.testing.assert_allclose(run[name], wanted, rtol=0, atol=bound * size, err_msg=name)
    for kind in ("bottom", "top", "slack", "taut"):
        np.testing.assert_allclose(
            rows(run, kind), same_rows(expected.events, kind), rtol=0, atol=bound, err_msg=kind
        )
    impulse = max([*expected.snaps, *expected.reactions], default=0.0)
    end = float(run.time[-1])
    assert np.max(run.attrs["largest_string_impulse"]) == pytest.approx(impulse, abs=bound)
    np.testing.assert_allclose(
        np.atleast_1d(run.attrs["slack_fraction"]) * end, expected.slack_time, rtol=0, atol=bound
    )


def some(rng, low, high):
    """Return zero, or a number between."""
    return float(rng.choice([0.0, rng.uniform(low, high)]))


def any_body(rng, length, radius):
    drags = some(rng, 1e-4, 3e-3), some(rng, 1e-4, 2e-3)
    return Body(length, rng.uniform(0.03, 0.2), *drags, radius)


def moved(rng, bodies, planar, **own):
    """Return balls with laws that the three kinds of motion share.

    Drag relative to the room is linear: latolato describes no other.
    """
    own |= {"lab": bool(rng.integers(2)), "es": some(rng, 0.2, 1.0), "e": rng.uniform(0.6, 1.0)}
    own |= {"A0": rng.uniform(0.0, 0.07), "w": rng.uniform(8.0, 20.0), "phase": rng.uniform(0, 6)}
    if planar:
        own |= {"Ax": rng.uniform(0.0, 0.05), "phx": rng.uniform(0.0, 6.0)}
    if own["lab"]:
        bodies = [replace(body, C2=0.0) for body in bodies]
    return Strings(bodies, **own)


def any_ball(rng):
    """Return one ball that begins taut or slack."""
    l = rng.uniform(0.15, 0.4)
    start = [(rng.uniform(-3.0, 3.0), rng.uniform(-13.0, 13.0))]
    if rng.integers(2):
        start = [(*start[0], rng.uniform(0.3, 0.95) * l)]
    return moved(rng, [any_body(rng, l, 0.0)], planar=True), start


def any_toy(rng):
    l, r = rng.uniform(0.15, 0.4), rng.uniform(0.01, 0.04)
    start = [(rng.uniform(math.asin(r / l) + 0.1, 2.5), rng.uniform(-12.0, 12.0))]
    return moved(rng, [any_body(rng, l, r)], planar=False, walls=True), start


def any_pair(rng):
    l, r = rng.uniform(0.2, 0.3), rng.uniform(0.025, 0.035, 2)
    bodies = [any_body(rng, l, r[0]), any_body(rng, l + rng.uniform(-0.03, 0.03), r[1])]
    start = [(side * rng.uniform(0.5, 2.0), rng.uniform(-8.0, 8.0)) for side in (1, -1)]
    return moved(rng, bodies, planar=True), start


# Of the pairs, those in which no ball comes near the other's string, which is not described, nor a
# slack ball within both radii of the pivot.
TOYS = (0, 1, 2, 3, 4, 7, 9, 10, 11, 13, 14, 18, 28, 30, 42, 53)
PAIRS = (2, 3, 4, 6, 7, 11, 12, 15, 16, 18, 21, 23, 26, 40, 45, 51, 52, 54, 62, 64)
MOTIONS = [
    *[(any_ball, seed, 1.0) for seed in range(16)],
    *[(any_toy, seed, 1.0) for seed in TOYS],
    *[(any_pair, seed, 0.7) for seed in PAIRS],
]


def total(run):
    """Return the energy of all balls, and what the ledger makes of the first one [J]."""
    energy = run.total_energy.sum("ball") if "ball" in run.dims else run.total_energy
    losses = run.damping_loss + run.impact_loss + run.capture_loss + run.retension_loss
    return energy.values, (energy[0] + run.drive_work - losses).values
