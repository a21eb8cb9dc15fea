"""High-precision trajectories: the cases of ``tests/reference`` as latolato reads them."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np

import latolato as ll

FOLDER = Path(__file__).parents[1] / "reference"
CASES = {
    name: case
    for file in ("trajectories.json", "cases.json")
    for name, case in json.loads((FOLDER / file).read_text()).items()
    if not name.startswith("_")
}
# Stated in trajectories.json: relative to max(|reference|, 1e-3).
WITHOUT_CONTACTS, WITH_CONTACTS = 1e-9, 1e-8
KINDS = {
    "harmonic": (ll.Harmonic, ("drive_amplitude", "drive_frequency", "drive_phase")),
    "crank_slider": (
        ll.CrankSlider,
        ("drive_amplitude", "drive_frequency", "drive_phase", "connecting_rod_length", "guide"),
    ),
    "frequency_schedule": (
        ll.FrequencySchedule,
        ("drive_amplitude", "drive_phase", "times", "drive_frequencies", "ramp"),
    ),
    "chirp": (
        ll.Chirp,
        (
            "drive_amplitude",
            "drive_phase",
            "drive_frequency",
            "drive_frequency_final",
            "sweep_time",
        ),
    ),
}
BODY = ("length", "mass", "damping", "quadratic_damping", "coulomb_damping")


def number(value):
    if isinstance(value, list):
        return [number(v) for v in value]
    try:
        return float(value)
    except ValueError:
        return value


def read(case):
    """The system, drive, start and end that a case describes."""
    p = {name: number(v) for name, v in case["parameters"].items() if not isinstance(v, dict)}
    kind, names = KINDS[p.get("drive", "harmonic")]
    drive = kind(**{name: p[name] for name in names})
    if "ball1" in case["parameters"]:
        balls = [
            {k: number(v) for k, v in case["parameters"][ball].items()}
            for ball in ("ball1", "ball2")
        ]
        if "radius" not in balls[0]:  # equal balls: the separation says it
            for ball in balls:
                ball["radius"] = ball["length"] * math.sin(0.5 * p["contact_separation"])
        made = [
            ll.Ball(**{k: v for k, v in ball.items() if k in (*BODY, "radius")}) for ball in balls
        ]
        system = ll.BallPair(
            right=made[0], left=made[1], restitution=p["restitution"], gravity=p["gravity"]
        )
        start = {
            name: tuple(ball[name] for ball in balls)
            for name in ("initial_angle", "initial_angular_velocity")
        }
        return system, drive, start, p["duration"]
    own = {name: p[name] for name in (*BODY, "gravity") if name in p}
    if "contact_angle_low" in p:
        own["radius"] = own["length"] * math.sin(p["contact_angle_low"])
    elif "radius" in p:
        own["radius"] = p["radius"]
    if "radius" in own:
        system = ll.LatoLato(**own, restitution=p["restitution"])
    else:
        system = (ll.Mathieu if "eq14" in case["model"] else ll.Pendulum)(**own)
    angle = p["initial_angle"]
    if isinstance(angle, str) or angle == p.get("contact_angle_low"):
        angle = system.contact_angle_low
    start = {"initial_angle": angle, "initial_angular_velocity": p["initial_angular_velocity"]}
    return system, drive, start, p["duration"]


def check(result, reference, bound, what):
    reference = np.array(number(reference), dtype=float)
    scale = np.maximum(np.abs(reference), 1e-3)
    error = np.abs(np.asarray(result, dtype=float) - reference) / scale
    assert np.max(error, initial=0.0) <= bound, (what, result, reference, error)


def bound_of(case):
    return WITH_CONTACTS if case.get("contacts") else WITHOUT_CONTACTS
