"""Fits of a track table for the page: numbers, their truth if known, the model in the picture."""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.app.blocks import pack
from latolato.app.experiment.description import Description, apparatus_of, part_of
from latolato.app.forms import units_of
from latolato.app.run_request import options_of
from latolato.core.errors import InputError, joined
from latolato.experiment.fits import fits
from latolato.experiment.fits.drive_motion import vertical_part
from latolato.experiment.fits.result import Fit, quantity_of
from latolato.experiment.rules import said
from latolato.experiment.track_table import balls_of
from latolato.experiment.trials import trial_of
from latolato.physics.pendulum import LatoLato, System
from latolato.scenario.scenario import Scenario

if TYPE_CHECKING:
    import xarray as xr

# Instants and angles of each ball that a page draws.
Motion = list[tuple[Any, Any]]
# The block of a model's motion, by its name; nothing without one.
Model = dict[str, Any]
# Gaps between samples that curves are drawn across [s], or so many usual steps.
_GAP, _STEPS = 0.15, 2.0
# Draws of a comparison: its spread is not shown.
_DRAWS = 1


def fits_of(
    table: xr.Dataset, description: Description, size: tuple[int, int] | None
) -> tuple[dict[str, dict[str, Any]], Model]:
    """Return the fits that need no click: each with its numbers, or why there are none.

    `size` is that of the picture [pixels], None where there is none. With them comes the motion of
    the last one that has a model of it.
    """
    cards: dict[str, dict[str, Any]] = {}
    model: Model = {}
    if str(table.attrs.get("geometry")) == "unknown":
        return cards, model
    for name, kind in fits.items():
        if kind.is_slow or balls_of(table) < kind.fewest_balls:
            continue
        try:
            cards[name], own = fit_of(name, table, description, size)
            model = own or model
        except InputError as error:
            error.way_out = None  # what to do about it in Python is no help here
            cards[name] = {"kind": name, "error": error.parts() or str(error)}
    return cards, model


def fit_of(
    name: str, table: xr.Dataset, description: Description, size: tuple[int, int] | None
) -> tuple[dict[str, Any], Model]:
    """Return one fit as the page shows it, and the block of its model's motion if it has one.

    A fit whose model does not describe the record has its ``doubt`` instead of numbers.

    Raises
    ------
    InputError
        If the table does not allow it.
    """
    kind, apparatus = fits[name], apparatus_of(description, table)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        fit = kind.fit(table, apparatus, **part_of(description))
        if not fit.describes:
            return {"kind": name, "error": fit.refusal, "doubt": fit.doubt}, {}
        system = kind.system(fit, apparatus, table)
        if kind.is_predicted:
            motion, verdict = _predicted(table, fit, part_of(description))
        else:
            motion, verdict = _fitted(fit), ""
    card = card_of(fit)
    if verdict:
        card["verdict"] = joined([card["verdict"], verdict])
    if system is not None:
        start = start_of(*motion[0]) if motion else None
        card["play"] = play_options(system, fit, start, table)
    if not motion:
        return card, {}
    block = model_block(table, name, motion, size)
    return {**card, "model": True}, {"model": np.frombuffer(block, np.uint8)}


def card_of(fit: Fit) -> dict[str, Any]:
    """Return the numbers of a fit with label, symbol and the unit in which people read them."""
    values = fit.to_dict()["values"]
    for name, value in values.items():
        quantity = quantity_of(name)
        value |= {"label": quantity.long_name, "symbol": quantity.symbol}
        value["unit"] = units_of(quantity)[0]
    return {"kind": fit.kind, "verdict": fit.verdict, "values": values}


def start_of(times: Any, angles: Any) -> tuple[float, float]:
    """Return the first angle [rad] and the angular velocity there [rad/s], by a parabola."""
    _, speed, _ = np.polynomial.polynomial.polyfit(times[:5] - times[0], angles[:5], 2)
    return float(angles[0]), float(speed)


def _fitted(fit: Fit) -> Motion:
    """Return the fitted curve of the angle if there is one."""
    if "angle_fit" not in fit.dataset:
        return []
    return [(fit.dataset["time"].values, fit.dataset["angle_fit"].values)]


def _predicted(table: xr.Dataset, fit: Fit, part: dict[str, Any]) -> tuple[Motion, str]:
    """Return the motion computed from the start on and its verdict, or the curve where it fails."""
    from latolato.experiment.comparison.motion import compare_motion, verdict_of

    assert fit.system is not None
    try:
        comparison = compare_motion(table, fit.system, fit.drive, draws=_DRAWS, **part)
    except InputError:
        motion, verdict = _fitted(fit), ""
    else:
        motion = [(comparison["time"].values, comparison["angle_computed"].values)]
        verdict = verdict_of(comparison)
    if isinstance(fit.system, LatoLato):
        motion += [(times, -angles) for times, angles in motion]
    return motion, verdict


def play_options(
    system: System, fit: Fit, start: tuple[float, float] | None, table: xr.Dataset
) -> dict[str, Any]:
    """Return the options of a run that begins as the clip does, on the pivot of a fit."""
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
    laws: dict[str, Any] = {"system": system}
    if fit.drive is not None:
        mirrored = isinstance(system, LatoLato)
        laws["drive"] = vertical_part(fit.drive) if mirrored else fit.drive
    return options_of(Scenario(**laws, run=run))


def model_block(
    table: xr.Dataset, kind: str, motion: Motion, size: tuple[int, int] | None
) -> bytes:
    """Return the model's angle at every instant and, in a picture, where its balls are."""
    time = table["time"].values
    angles = np.stack([across(time, *each) for each in motion])
    arrays = {"angle": angles.astype(np.float32)}
    if size is not None:
        arrays["centre"] = _centres(table, angles, size)
    return pack({"kind": kind, "balls": len(motion)}, arrays)


def _centres(table: xr.Dataset, angles: Any, size: tuple[int, int]) -> Any:
    """Return columns and rows of the model's balls in the picture [pixels]."""
    from latolato.experiment.calibration.tilt import tilt_of
    from latolato.experiment.overlay import places_of

    length = float(table.attrs.get("length") or math.nan)
    ghost = table.copy()
    for b, angle in enumerate(angles, start=1):
        if math.isfinite(length):
            ghost[f"ball_{b}_x"] = table["pivot_x"] + length * np.sin(angle)
            ghost[f"ball_{b}_y"] = table["pivot_y"] - length * np.cos(angle)
        elif "pivot_u" in table.variables:
            arm = float(table.attrs["arm_pixels"])
            turned = angle + float(table.attrs["gravity_direction"])
            away = arm * np.column_stack([np.sin(turned), np.cos(turned)])
            for end, shown in zip("uv", tilt_of(table.attrs).seen(away).T, strict=True):
                ghost[f"ball_{b}_{end}"] = table[f"pivot_{end}"] + shown
    _, centres = places_of(ghost, size)
    balls = len(angles)
    return centres[:, :balls].transpose(1, 2, 0).reshape(2 * balls, -1).astype(np.float32)


def across(instants: Any, times: Any, values: Any) -> Any:
    """Return values at other instants, NaN beyond the ends and in gaps."""
    order = np.argsort(times)
    times, values = np.asarray(times)[order], np.asarray(values)[order]
    between = np.interp(instants, times, values, left=np.nan, right=np.nan)
    after = np.clip(np.searchsorted(times, instants), 0, len(times) - 1)
    before = np.clip(after - 1, 0, len(times) - 1)
    longest = longest_step(times)
    between[(times[after] - times[before] > longest) & (times[after] != instants)] = np.nan
    return between


def longest_step(times: Any) -> float:
    """Return the longest step between samples that is no gap [s]."""
    steps = np.diff(times)
    return max(_GAP, _STEPS * float(np.median(steps))) if steps.size else _GAP


def trial_row(
    table: xr.Dataset, description: Description
) -> tuple[dict[str, Any] | None, str | dict[str, Any] | None]:
    """Return the row of the trial table, or None and why there is none."""
    if str(table.attrs.get("geometry")) == "unknown":
        return None, said("no_angles")
    try:
        gravity = apparatus_of(description, table).gravity
        length = description.get("length")
        row = trial_of(table, length=length, gravity=gravity, **part_of(description))
    except InputError as error:
        error.way_out = None
        return None, error.parts() or str(error)
    return row, None
