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
_CHANGING = {
    "damping_loss": -1.0,
    "impact_loss": -1.0,
    "capture_loss": -1.0,
    "retension_loss": -1.0,
    "noise_work": 1.0,
}
# Kinds of contacts of a string; balls meet in the others.
OF_STRINGS = ("slack", "taut")


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
        ``contact_angle``; on strings also the distances. A run without contacts is returned as it
        is.

    Notes
    -----
    From instant to instant the angle moves by the mean of the velocities at both ends, an error of
    third order in the time between them; what is missing at the next sample is spread evenly. So
    does the distance on a string. At exact contacts the angle is then put on the wall. Energies
    follow from angles, distances and velocities, losses at contacts from the energies' jumps,
    damping loss and noise by straight lines, the drive's work from the ledger.
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
    angles = _at_contacts(run, place, "angle", "angular_velocity")
    lengths = np.array([[ball.length] for ball in system.balls])
    distances = np.broadcast_to(lengths, angles.shape)
    points: dict[str, Sides] = {}
    if "distance" in run:
        distances = np.minimum(_at_contacts(run, place, "distance", "radial_velocity"), lengths)
        points["distance"] = distances, distances
    if run.attrs["contact"] == "exact":
        angles = _on_walls(system, angles, distances, run["contact_kind"].values)
    points["angle"] = angles, angles
    points |= _energies_at(system, run, angles, distances)
    points |= _ledger_at(run, place, points["total_energy"])

    per_contact = run["angular_velocity_before"]
    variables = {"contact_angle": (per_contact.dims, angles.reshape(per_contact.shape))}
    twice = np.repeat(place, 2)
    for name, sides in points.items():
        both = np.stack(sides, axis=-1).reshape(*sides[0].shape[:-1], -1)
        values = np.insert(np.reshape(run[name].values, (*both.shape[:-1], -1)), twice, both, -1)
        variables[name] = (run[name].dims, values.reshape(*run[name].shape[:-1], -1))
    kept = [n for n in ("contact_kind", "contact_time", "contact_ball") if n in run]
    curves = run[kept].assign(variables)
    curves = curves.assign_coords(time=np.insert(time, twice, np.repeat(at, 2)))
    if "ball" in run.coords:
        curves = curves.assign_coords(ball=run["ball"])
    for name in (*points, "time"):
        curves[name].attrs = run[name].attrs
    return curves


def _by_ball(run: xr.Dataset, name: str) -> Floats:
    """Return a variable with a row for each ball, shape (ball, n)."""
    return np.atleast_2d(run[name].values)


def _at_contacts(run: xr.Dataset, place: NDArray[np.int64], name: str, rate: str) -> Floats:
    """Return a variable at the contacts that stand before the samples `place`, by its rate."""
    time, at = run["time"].values, run["contact_time"].values
    instants = np.insert(time, place, at)
    is_contact = np.insert(np.zeros(time.size, dtype=bool), place, True)
    result = []
    names = name, rate, f"{rate}_before", f"{rate}_after"
    for value, velocity, before, after in zip(*(_by_ball(run, n) for n in names), strict=True):
        arriving, leaving = np.insert(velocity, place, before), np.insert(velocity, place, after)
        steps = 0.5 * (leaving[:-1] + arriving[1:]) * np.diff(instants)
        path = np.concatenate([[0.0], np.cumsum(steps)])
        missing = np.interp(at, time, value - path[~is_contact])
        result.append(path[is_contact] + missing)
    return np.stack(result)


def _on_walls(system: System, angles: Floats, distances: Floats, kinds: NDArray[np.str_]) -> Floats:
    """Return the angles at exact contacts moved onto the walls, both balls by as much.

    The walls of slack balls depend on their distances from the pivot.
    """
    meets = ~np.isin(kinds, OF_STRINGS)
    if not meets.any():
        return angles
    low, high = walls_of(system, ExactContact())
    gap = angles[0] if len(angles) == 1 else angles[0] - angles[1]
    is_high = np.where(np.isin(kinds, ("bottom", "top")), kinds == "top", gap > 0.5 * (low + high))
    wall = np.where(is_high, high, low)
    if system.suspension == "string":
        near = _separation(system, distances)
        wall = np.where(is_high, (low + high) - near, near)
    missing = np.where(meets, wall - gap, 0.0)
    shares = np.array([[1.0]] if len(angles) == 1 else [[0.5], [-0.5]])
    return np.asarray(angles + shares * missing)


def _separation(system: System, distances: Floats) -> Floats:
    """Return the gap at which balls so far from the pivot touch below it [rad]."""
    if len(distances) == 1:
        return np.asarray(np.arcsin(np.minimum(system.balls[0].radius / distances[0], 1.0)))
    right, left = distances
    reach = system.balls[0].radius + system.balls[1].radius
    # The half-angle formula keeps the digits of small gaps.
    square = (reach**2 - (right - left) ** 2) / (4.0 * right * left)
    return np.asarray(2.0 * np.arcsin(np.sqrt(np.clip(square, 0.0, 1.0))))


def _energies_at(
    system: System, run: xr.Dataset, angles: Floats, distances: Floats
) -> dict[str, Sides]:
    """Return the energies before and after the contacts, by name, of shape (ball, contact)."""
    before, after = (_by_ball(run, f"angular_velocity_{side}") for side in ("before", "after"))
    potential, first, second = (np.empty_like(angles) for _ in range(3))
    for i, ball in enumerate(system.balls):
        m, l, g = ball.mass, ball.length, system.gravity
        for k, (angle, r) in enumerate(zip(angles[i], distances[i], strict=True)):
            potential[i, k] = potential_energy(system.potential(angle), m, r, g) + m * g * (l - r)
            first[i, k] = kinetic_energy(before[i, k], m, r)
            second[i, k] = kinetic_energy(after[i, k], m, r)
        if "radial_velocity_before" in run:
            first[i] += 0.5 * m * _by_ball(run, "radial_velocity_before")[i] ** 2
            second[i] += 0.5 * m * _by_ball(run, "radial_velocity_after")[i] ** 2
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
    of_string = np.isin(kinds, OF_STRINGS)
    jumps = {
        "impact_loss": np.where(is_capture | of_string, 0.0, lost),
        "capture_loss": np.where(is_capture, lost, 0.0),
        "retension_loss": np.where(of_string, lost, 0.0),
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
    work = run["drive_work"].values[last]
    if run["drive_work"].values.any():  # else only the error of the angles is left
        work = work + gain
    return sides | {"drive_work": (work, work)}
