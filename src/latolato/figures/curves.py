"""Curves of a run for drawing: its samples, and what is known just before and after contacts."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from latolato.physics.contacts import ExactContact
from latolato.physics.energy import kinetic_energy, potential_energy
from latolato.physics.pendulum import System
from latolato.scenario.scenario import Scenario
from latolato.simulation.start import walls_of

if TYPE_CHECKING:
    import xarray as xr

    Floats = NDArray[np.float64]
    # Just before and just after each contact.
    Sides = tuple[Floats, Floats]

# Signs with which the ledger's parts make up the energy gained, beside the drive's work.
_CHANGING = {"damping_loss": -1.0, "impact_loss": -1.0, "capture_loss": -1.0, "noise_work": 1.0}


def with_contacts(run: xr.Dataset) -> xr.Dataset:
    """Return a run's curves with two points more for each contact: just before and just after it.

    Parameters
    ----------
    run : xarray.Dataset
        What `latolato.simulate` returned; it is not changed.

    Returns
    -------
    xarray.Dataset
        Angles, energies and ledger over ``time``, in which instants of contacts repeat, and over
        ``contact`` the contacts between the first and the last sample reached, with their
        ``contact_angle``. A run without contacts is returned as it is.

    Notes
    -----
    From instant to instant the angle moves by the mean of the velocities at both ends, an error of
    third order in the time between them; what is missing at the next sample is spread evenly. At
    exact contacts the angle is then put on the wall. Energies follow from angles and velocities,
    impact and capture loss from the energies' jumps, damping loss and noise by straight lines, the
    drive's work from the ledger.
    """
    if not run.sizes.get("contact") or "scenario" not in run.attrs:
        return run
    known = np.isfinite(_by_ball(run, "angle")).all(axis=0)
    time, at = run["time"].values[known], run["contact_time"].values
    if not time.size:
        return run
    inside = (at >= time[0]) & (at <= time[-1])
    run = run.isel(time=known, contact=inside)
    at = at[inside]
    system = Scenario.from_dict({"system": json.loads(run.attrs["scenario"])["system"]}).system
    place = np.searchsorted(time, at, side="right")  # behind a sample of the same instant
    angles = _angles_at(run, place)
    if run.attrs["contact"] == "exact":
        angles = _on_walls(system, angles, run["contact_kind"].values)
    points: dict[str, Sides] = {"angle": (angles, angles)}
    points |= _energies_at(system, run, angles)
    points |= _ledger_at(run, place, points["total_energy"])

    per_contact = run["angular_velocity_before"]
    variables = {"contact_angle": (per_contact.dims, angles.reshape(per_contact.shape))}
    twice = np.repeat(place, 2)
    for name, sides in points.items():
        both = np.stack(sides, axis=-1).reshape(*sides[0].shape[:-1], -1)
        values = np.insert(np.reshape(run[name].values, (*both.shape[:-1], -1)), twice, both, -1)
        variables[name] = (run[name].dims, values.reshape(*run[name].shape[:-1], -1))
    curves = run[["contact_kind", "contact_time"]].assign(variables)
    curves = curves.assign_coords(time=np.insert(time, twice, np.repeat(at, 2)))
    if "ball" in run.coords:
        curves = curves.assign_coords(ball=run["ball"])
    for name in (*points, "time"):
        curves[name].attrs = run[name].attrs
    return curves


def _by_ball(run: xr.Dataset, name: str) -> Floats:
    """Return a variable with a row for each ball, shape (ball, n)."""
    return np.atleast_2d(run[name].values)


def _angles_at(run: xr.Dataset, place: NDArray[np.int64]) -> Floats:
    """Return the angles at the contacts that stand before the samples `place`, in free flight."""
    time, at = run["time"].values, run["contact_time"].values
    instants = np.insert(time, place, at)
    is_contact = np.insert(np.zeros(time.size, dtype=bool), place, True)
    angles = []
    for angle, velocity, before, after in zip(
        *(
            _by_ball(run, name)
            for name in (
                "angle",
                "angular_velocity",
                "angular_velocity_before",
                "angular_velocity_after",
            )
        ),
        strict=True,
    ):
        arriving, leaving = np.insert(velocity, place, before), np.insert(velocity, place, after)
        steps = 0.5 * (leaving[:-1] + arriving[1:]) * np.diff(instants)
        path = np.concatenate([[0.0], np.cumsum(steps)])
        missing = np.interp(at, time, angle - path[~is_contact])
        angles.append(path[is_contact] + missing)
    return np.stack(angles)


def _on_walls(system: System, angles: Floats, kinds: NDArray[np.str_]) -> Floats:
    """Return the angles at exact contacts moved onto the walls, both balls by as much."""
    low, high = walls_of(system, ExactContact())
    gap = angles[0] if len(angles) == 1 else angles[0] - angles[1]
    is_high = np.where(np.isin(kinds, ("bottom", "top")), kinds == "top", gap > 0.5 * (low + high))
    missing = np.where(is_high, high, low) - gap
    shares = np.array([[1.0]] if len(angles) == 1 else [[0.5], [-0.5]])
    return np.asarray(angles + shares * missing)


def _energies_at(system: System, run: xr.Dataset, angles: Floats) -> dict[str, Sides]:
    """Return the energies before and after the contacts, by name, of shape (ball, contact)."""
    before, after = (_by_ball(run, f"angular_velocity_{side}") for side in ("before", "after"))
    potential, first, second = (np.empty_like(angles) for _ in range(3))
    for i, ball in enumerate(system.balls):
        m, l = ball.mass, ball.length
        for k, angle in enumerate(angles[i]):
            potential[i, k] = potential_energy(system.potential(angle), m, l, system.gravity)
            first[i, k] = kinetic_energy(before[i, k], m, l)
            second[i, k] = kinetic_energy(after[i, k], m, l)
    return {
        "kinetic_energy": (first, second),
        "potential_energy": (potential, potential),
        "total_energy": (first + potential, second + potential),
    }


def _ledger_at(run: xr.Dataset, place: NDArray[np.int64], energy: Sides) -> dict[str, Sides]:
    """Return the ledger's parts before and after the contacts, by name, of shape (contact,)."""
    at, kinds = run["contact_time"].values, run["contact_kind"].values
    before, after = (each.sum(axis=0) for each in energy)
    speeds = _by_ball(run, "angular_velocity_before")
    approach = np.abs(speeds[0] if len(speeds) == 1 else speeds[0] - speeds[1])
    is_capture = (kinds == "rest") & (approach <= run.attrs["rest_speed"])
    lost = before - after
    jumps = {
        "impact_loss": np.where(is_capture, 0.0, lost),
        "capture_loss": np.where(is_capture, lost, 0.0),
    }
    sides: dict[str, Sides] = {}
    last = place - 1  # the sample before each contact
    gain = before - _by_ball(run, "total_energy").sum(axis=0)[last]
    for name, sign in _CHANGING.items():
        if name not in run:
            continue
        values = run[name].values
        if name in jumps:
            total = np.concatenate([[0.0], np.cumsum(jumps[name])])
            first = np.searchsorted(place, place)  # the first contact since that sample
            start = values[last] + total[:-1] - total[first]
            sides[name] = (start, start + jumps[name])
        else:
            start = np.interp(at, run["time"].values, values)
            sides[name] = (start, start)
        gain -= sign * (start - values[last])
    work = run["drive_work"].values[last] + gain
    return sides | {"drive_work": (work, work)}
