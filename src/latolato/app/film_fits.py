"""Fits of a track table for the page: numbers, their truth if known, the model in the picture."""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.app.blocks import pack
from latolato.app.film_options import Told
from latolato.app.given import options_of
from latolato.core.errors import InputError
from latolato.experiment.fits.decay import fit_decay
from latolato.experiment.fits.drive import fit_drive
from latolato.experiment.fits.model import fit_model
from latolato.experiment.fits.restitution import fit_restitution
from latolato.experiment.fits.result import Fit, quantity_of
from latolato.experiment.table import balls_of
from latolato.experiment.trials import trial_of
from latolato.physics.drives import Drive, FixedPivot
from latolato.physics.pendulum import GRAVITY, LatoLato, Pendulum, System, systems
from latolato.scenario.scenario import Scenario

if TYPE_CHECKING:
    import xarray as xr

# Where nothing is said: mass [kg], first guesses of damping [kg m/s] and restitution, ball over
# length.
_MASS, _DAMPING, _RESTITUTION, _SMALL = 0.1, 0.003, 0.9, 1.0 / 12.0
# Gaps between samples that a model's curve is drawn across [s].
_GAP = 0.15
# Draws of a comparison: its spread is not shown.
_DRAWS = 1


def fits_of(
    table: xr.Dataset, told: Told, folder: Path, size: tuple[int, int]
) -> dict[str, dict[str, Any]]:
    """Return the fits that need no choice: each with its numbers, or why there are none."""
    if str(table.attrs.get("geometry")) == "unknown":
        return {}
    kinds = ["drive", "decay"] + (["restitution"] if balls_of(table) == 2 else [])
    found: dict[str, dict[str, Any]] = {}
    for kind in kinds:
        try:
            found[kind] = fit_of(kind, table, told, folder, size)
        except InputError as error:
            # What to do about it in Python is no help here.
            found[kind] = {"kind": kind, "error": str(error).partition("; ")[0]}
    return found


def fit_of(
    kind: str, table: xr.Dataset, told: Told, folder: Path, size: tuple[int, int]
) -> dict[str, Any]:
    """Return one fit as the page shows it; a model of the angle is written to ``model.bin``.

    Raises
    ------
    InputError
        If the table does not allow it.
    """
    gravity = told.gravity or GRAVITY
    length = told.length or table.attrs.get("length")
    drive: Drive = FixedPivot()
    system: System | None = None
    model: list[Any] | None = None
    verdict = ""
    start: tuple[float, float] | None = None
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        if kind == "decay":
            fit = fit_decay(table, mass=told.mass, length=length, gravity=gravity)
            times, angles = fit.dataset["time"].values, fit.dataset["angle_fit"].values
            model = [(times, angles)]
            start = start_of(times, angles)
            system = _decaying(fit, told, length, gravity)
        elif kind == "drive":
            fit = fit_drive(table)
            drive = fit.drive or drive
            if length:
                system = _guess(table, told, length, gravity)
        elif kind == "restitution":
            fit = fit_restitution(table, length=length, radius=told.radius, gravity=gravity)
        else:
            if not length:
                raise InputError("must be known: it is the scale of the motion", parameter="length")
            guess = _guess(table, told, length, gravity)
            fit = fit_model(table, guess)
            system = _system_of(fit)
            drive = fit.drive or drive
            model, verdict = _laid(table, system, fit)
            start = start_of(*model[0])
    found = shown(fit)
    if verdict:
        found["verdict"] = f"{found['verdict']} {verdict}"
    if system is not None:
        found["play"] = play_options(system, drive, start, table)
    if model is not None:
        (folder / "model.bin").write_bytes(model_block(table, kind, model, size))
        found["model"] = True
    return found


def shown(fit: Fit) -> dict[str, Any]:
    """Return the numbers of a fit with label, symbol and unit."""
    values = fit.to_dict()["values"]
    for name, value in values.items():
        quantity = quantity_of(name)
        value |= {"label": quantity.long_name, "symbol": quantity.symbol}
    return {"kind": fit.kind, "verdict": fit.verdict, "values": values}


def start_of(times: Any, angles: Any) -> tuple[float, float]:
    """Return the first angle [rad] and the angular velocity there [rad/s], by a parabola."""
    _, speed, _ = np.polynomial.polynomial.polyfit(times[:5] - times[0], angles[:5], 2)
    return float(angles[0]), float(speed)


def _decaying(fit: Fit, told: Told, length: float | None, gravity: float) -> Pendulum:
    """Return the pendulum that a decay has shown."""
    length = length or fit["length"].value
    mass = told.mass or _MASS
    damping = 2.0 * fit["decay_rate"].value * mass * length if "decay_rate" in fit else 0.0
    if "damping" in fit:
        damping = fit["damping"].value
    return Pendulum(length=length, mass=mass, damping=max(damping, 0.0), gravity=gravity)


def _guess(table: xr.Dataset, told: Told, length: float, gravity: float) -> Pendulum:
    """Return what swings, with first guesses of what is not known."""
    given: dict[str, Any] = {
        "length": length,
        "mass": told.mass or _MASS,
        "damping": _DAMPING if told.damping is None else told.damping,
        "gravity": gravity,
    }
    if balls_of(table) == 1:
        return Pendulum(**given)
    radius = told.radius or table.attrs.get("measured_radius") or _SMALL * length
    restitution = _RESTITUTION if told.restitution is None else told.restitution
    return LatoLato(**given, radius=float(radius), restitution=restitution)


def _system_of(fit: Fit) -> Any:
    """Return the system that a fit of a model found."""
    from latolato.core.registry import rebuild

    described = json.loads(fit.dataset.attrs["system_description"])
    return rebuild(systems[described.pop("kind")], described)


def _laid(table: xr.Dataset, system: Any, fit: Fit) -> tuple[list[Any], str]:
    """Return the computed motion from the start on, or the fitted pieces where it is lost."""
    from latolato.experiment.comparison.motion import compare_motion

    try:
        found = compare_motion(table, system, fit.drive, draws=_DRAWS)
        times, angles = found["time"].values, found["angle_computed"].values
        verdict = str(found.attrs["verdict"])
    except InputError:
        times, angles = fit.dataset["time"].values, fit.dataset["angle_fit"].values
        verdict = ""
    model = [(times, angles)]
    if isinstance(system, LatoLato):
        model.append((times, -angles))
    return model, verdict


def play_options(
    system: System, drive: Drive, start: tuple[float, float] | None, table: xr.Dataset
) -> dict[str, Any]:
    """Return the options of a run that begins as the film does."""
    time = table["time"].values
    angle = np.stack([table[f"angle_{b}"].values for b in range(1, balls_of(table) + 1)])
    if start is None:
        known = angle[0][np.isfinite(angle[0])]
        start = (float(known[0]) if known.size else 0.0), 0.0
    first, speed = start
    if isinstance(system, LatoLato):
        low, high = system.contact_angle_low, system.contact_angle_high
        first = min(max(first, low), high)
    run = {
        "initial_angle": first,
        "initial_angular_velocity": speed,
        "duration": float(math.ceil(time[-1] - time[0])),
    }
    return options_of(Scenario(system=system, drive=drive, run=run))


def model_block(
    table: xr.Dataset, kind: str, model: Sequence[tuple[Any, Any]], size: tuple[int, int]
) -> bytes:
    """Return the model's angle in every frame and where its balls are in the picture."""
    from latolato.experiment.overlay import places_of

    time = table["time"].values
    angles = np.stack([across(time, *each) for each in model])
    length = float(table.attrs.get("length") or math.nan)
    ghost = table.copy()
    for b, angle in enumerate(angles, start=1):
        if math.isfinite(length):
            ghost[f"ball_{b}_x"] = table["pivot_x"] + length * np.sin(angle)
            ghost[f"ball_{b}_y"] = table["pivot_y"] - length * np.cos(angle)
        elif "pivot_u" in table.variables:
            arm = float(table.attrs["arm_pixels"])
            turned = angle + float(table.attrs["gravity_direction"])
            ghost[f"ball_{b}_u"] = table["pivot_u"] + arm * np.sin(turned)
            ghost[f"ball_{b}_v"] = table["pivot_v"] + arm * np.cos(turned)
    _, centres = places_of(ghost, size)
    centres = centres[:, : len(model)]
    return pack(
        {"kind": kind, "balls": len(model)},
        {
            "angle": angles.astype(np.float32),
            "centre": centres.transpose(1, 2, 0).reshape(2 * len(model), -1).astype(np.float32),
        },
    )


def across(wanted: Any, times: Any, values: Any) -> Any:
    """Return values at other instants, NaN beyond the ends and in gaps."""
    order = np.argsort(times)
    times, values = np.asarray(times)[order], np.asarray(values)[order]
    found = np.interp(wanted, times, values, left=np.nan, right=np.nan)
    after = np.clip(np.searchsorted(times, wanted), 0, len(times) - 1)
    before = np.clip(after - 1, 0, len(times) - 1)
    found[(times[after] - times[before] > _GAP) & (times[after] != wanted)] = np.nan
    return found


def trial_row(table: xr.Dataset, told: Told) -> tuple[dict[str, Any] | None, str | None]:
    """Return the row of the trial table, or None and why there is none."""
    if str(table.attrs.get("geometry")) == "unknown":
        return None, "no pivot in the picture: no angles"
    try:
        gravity = told.gravity or GRAVITY
        row = trial_of(table, length=told.length, gravity=gravity)
    except InputError as error:
        return None, str(error).partition("; ")[0]
    return row, None
