"""What comparisons share: uncertain parameters, runs at the places of trials, their classes."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError
from latolato.core.quantities import NON_NEGATIVE, QUANTITIES, Quantity
from latolato.core.registry import checked_number, suggest
from latolato.experiment.trial_statistics import class_of
from latolato.physics.pendulum import BallPair, LatoLato, System
from latolato.sweeps.plan import Plan

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]
LATE = "largest_angle_after_transient"


def variable(
    dims: str | tuple[str, ...], values: Any, name: str, words: str | None = None
) -> tuple[Any, Any, dict[str, str]]:
    """Return a variable with unit and symbol of a quantity, and other words where given."""
    attributes = QUANTITIES[name].attributes
    return dims, values, {**attributes, "long_name": words or attributes["long_name"]}


def plain(
    dims: str | tuple[str, ...], values: Any, words: str, unit: str = "1"
) -> tuple[Any, Any, dict[str, str]]:
    """Return a variable that is no named quantity."""
    return dims, values, Quantity(unit, "", words).attributes


def checked_sigmas(system: System, sigmas: Mapping[str, Any] | None) -> dict[str, float]:
    """Return the standard deviations of a system's parameters, checked.

    Raises
    ------
    InputError
        For a name that the system does not have, or a negative deviation.
    """
    known = [f.name for f in fields(system) if isinstance(getattr(system, f.name, None), float)]
    deviations = {}
    for name, value in (sigmas or {}).items():
        if name not in known:
            raise InputError(f"the system has no number '{name}': {suggest(name, known)}")
        deviations[name] = checked_number(
            f"the deviation of {name}", value, NON_NEGATIVE, QUANTITIES[name].unit
        )
    return deviations


def frequencies_of(trials: xr.Dataset, system: System) -> tuple[Floats, Floats]:
    """Return frequency [rad/s] and frequency ratio of trials, each from the other where unknown."""
    frequency, ratio = trials["drive_frequency"].values, trials["frequency_ratio"].values
    natural = system.natural_frequency
    ratio = np.where(np.isfinite(ratio), ratio, frequency / natural)
    return np.where(np.isfinite(frequency), frequency, ratio * natural), ratio


def drawn(
    system: System, sigmas: Mapping[str, float], count: int, random: np.random.Generator
) -> dict[str, Floats]:
    """Return values of uncertain parameters, shape (draw,); the first are those of the system."""
    draws = {}
    for name, sigma in sigmas.items():
        field = next(f for f in fields(system) if f.name == name)
        allowed = field.metadata["range"]
        value = float(getattr(system, name))
        values = value + sigma * random.standard_normal(count)
        values[0] = value
        tiny = 1e-9 * max(abs(value), 1e-9)
        low = allowed.low + (tiny if allowed.open_low else 0.0)
        draws[name] = np.clip(values, low, allowed.high)
    return draws


def plan_of(grid: Any) -> Plan:
    """Return the plan of a sweep's dataset.

    Raises
    ------
    InputError
        If it is no sweep of a system of one angle.
    """
    import xarray as xr

    if not isinstance(grid, xr.Dataset):
        raise InputError("a map must be the dataset of a sweep", value=type(grid).__name__)
    if "plan" not in grid.attrs:
        raise InputError("the dataset is not a map: it does not hold the plan of a sweep")
    plan = Plan.from_description(json.loads(grid.attrs["plan"]))
    if isinstance(plan.system, BallPair):
        raise InputError("trials are compared with maps of a Pendulum or a LatoLato")
    return plan


def classes_in(dataset: xr.Dataset) -> xr.DataArray:
    """Return the class at each point of a sweep: 0, 1, 2, NaN where there is no answer.

    Raises
    ------
    InputError
        If the sweep gathered neither classes nor both angles.
    """
    if "motion_class" in dataset:
        return dataset["motion_class"].round()
    if "largest_angle" in dataset and LATE in dataset:
        largest, late = dataset["largest_angle"], dataset[LATE]
        classes = largest.copy(data=class_of(largest.values, late.values).astype(float))
        return classes.where(np.isfinite(largest) & np.isfinite(late)).rename("motion_class")
    raise InputError(
        f"the map holds no classes: sweep with the observables motion_class, or largest_angle and "
        f"{LATE}"
    )


def run_at(plan: Plan, columns: Mapping[str, Any]) -> xr.Dataset:
    """Return a sweep's observables at points of their own, on the dimension ``case``.

    Parameters
    ----------
    plan : Plan
        Says all that `columns` does not.
    columns : mapping of str to array_like, shape (case,)
        Values of parameters of system and drive.
    """
    from latolato.sweeps import sweep

    start: dict[str, Any] = dict(plan.start)
    if isinstance(plan.system, LatoLato) and "initial_angle" in start:
        # The offset stays what it is where the contact angle moves.
        low = plan.system.contact_angle_low
        start["initial_offset"] = max(start.pop("initial_angle") - low, 0.0)
    names = list(columns)
    rows = np.stack([np.asarray(columns[name], dtype=float) for name in names], axis=1)
    # A sweep takes no point twice.
    points, places = np.unique(rows, axis=0, return_inverse=True)
    varied = dict(zip(names, points.T, strict=True))
    grid = sweep(
        plan.system,
        plan.drive,
        axes={"case": varied},
        duration=plan.duration,
        transient=plan.transient,
        transient_periods=plan.transient_periods,
        observables=plan.observables,
        tolerance=plan.tolerance,
        contact=plan.contact,
        rest_speed=plan.rest_speed,
        contact_limit=plan.contact_limit,
        noise=plan.noise,
        **{name: value for name, value in start.items() if name not in varied},
    )
    return grid.isel(case=np.ravel(places))
