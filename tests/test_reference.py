"""Trajectories with 30 digits: every state, work, contact time and velocity.

``reference/trajectories.json`` was made by mpmath Taylor series and cross-checked by heyoka in
long double; its `_about` says how. Tolerances are those stated there: 1e-9 without contacts, 1e-8
with contacts, relative to max(|reference|, 1e-3).
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import latolato as ll

FILE = Path(__file__).parent / "reference" / "trajectories.json"
CASES = {k: v for k, v in json.loads(FILE.read_text()).items() if not k.startswith("_")}
ENERGIES = ("drive_work", "damping_loss", "impact_loss")


def numbers(texts: Any) -> np.ndarray:
    """Return an array of the reference's decimal texts."""
    return np.array([float(t) for t in (texts if isinstance(texts, list) else [texts])])


def ball(p: dict[str, Any], radius: float) -> ll.Ball:
    """Return a ball of the two-ball model."""
    return ll.Ball(
        length=float(p["length"]), mass=float(p["mass"]), damping=float(p["damping"]), radius=radius
    )


def run_of(case: dict[str, Any]) -> Any:
    """Return the run of a case at its instants."""
    p = case["parameters"]
    drive = ll.Harmonic(
        drive_amplitude=float(p["drive_amplitude"]),
        drive_frequency=float(p["drive_frequency"]),
        drive_phase=float(p["drive_phase"]),
    )
    restitution = float(p["restitution"])
    if "ball1" in p:
        radius = math.sin(0.5 * float(p["contact_separation"])) * float(p["ball1"]["length"])
        right, left = p["ball1"], p["ball2"]
        system: Any = ll.BallPair(
            right=ball(right, radius), left=ball(left, radius), restitution=restitution
        )
        start: Any = tuple(float(b["initial_angle"]) for b in (right, left))
        velocity: Any = tuple(float(b["initial_angular_velocity"]) for b in (right, left))
    else:
        body = {name: float(p[name]) for name in ("length", "mass", "damping")}
        start, velocity = float(p["initial_angle"]), float(p["initial_angular_velocity"])
        system = ll.Pendulum(**body)
        if "contact_angle_low" in p:
            radius = body["length"] * math.sin(float(p["contact_angle_low"]))
            system = ll.LatoLato(**body, radius=radius, restitution=restitution)
    return ll.simulate(
        system,
        drive,
        initial_angle=start,
        initial_angular_velocity=velocity,
        duration=float(p["duration"]),
        times=numbers([s["time"] for s in case["states"]]),
    )


def worst(found: Any, reference: Any) -> float:
    """Return the largest error relative to max(|reference|, 1e-3)."""
    found, reference = np.atleast_1d(found), np.atleast_1d(reference)
    assert found.shape == reference.shape
    scale = np.maximum(np.abs(reference), 1e-3)
    return float(np.max(np.abs(found - reference) / scale, initial=0.0))


@pytest.mark.parametrize("name", CASES)
def test_run_agrees_with_the_reference(name: str) -> None:
    case = CASES[name]
    run = run_of(case)
    tolerance = 1e-8 if case["contacts"] or "contacts" in case["model"] else 1e-9
    for i, state in enumerate(case["states"]):
        at = run.isel(time=i)
        assert worst(at.angle, numbers(state["angle"])) <= tolerance
        assert worst(at.angular_velocity, numbers(state["angular_velocity"])) <= tolerance
        assert worst(at.total_energy, numbers(state["energy"])) <= tolerance
        for quantity in ENERGIES:
            assert worst(at[quantity], numbers(state[quantity])) <= tolerance, quantity
    assert list(run.contact_kind.values) == [c["kind"] for c in case["contacts"]]
    for i, contact in enumerate(case["contacts"]):
        row = run.isel(contact=i)
        assert worst(row.contact_time, numbers(contact["time"])) <= tolerance
        assert worst(row.angular_velocity_before, numbers(contact["velocity_before"])) <= tolerance
        assert worst(row.angular_velocity_after, numbers(contact["velocity_after"])) <= tolerance
