"""One point of a map as a run of its own, and what is drawn over a map: theory and trials."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.app.blocks import pack
from latolato.app.map_request import MapRequest, make_map
from latolato.core.errors import InputError
from latolato.core.quantities import ANY
from latolato.core.registry import checked_number, describe
from latolato.physics.contacts import contact_laws
from latolato.scenario.scenario import Scenario
from latolato.simulation.run import simulate
from latolato.sweeps.executors import ROUNDING
from latolato.sweeps.labels import attributes_of
from latolato.sweeps.points import arguments_of

if TYPE_CHECKING:
    from latolato.figures.overlays import Context

Find = Callable[[Any], Path]

# In the order of the classes.
CLASSES = ("none", "weak", "strong")


def scenario_at(given: Any, find: Find) -> Scenario:
    """Return the run of the point ``at: [x, y]`` of the map that a page asks for.

    Raises
    ------
    InputError
        If there is no such point, or its parameters contradict each other.
    """
    if not isinstance(given, Mapping):
        raise InputError(f"a request must be an object, got {given!r}")
    rest = dict(given)
    x, y = _pair("at", rest.pop("at", None))
    if "stored" in rest:
        from latolato.app.map_stored import arguments_at

        names = rest.get("names")
        if not isinstance(names, list) or len(names) != 2:
            raise InputError("names must be those of the two axes")
        path = find(rest["stored"])
        select = rest.get("select") or {}
        result = arguments_at(path, (str(names[0]), x), (str(names[1]), y), select)
    else:
        result = arguments_of(make_map(MapRequest.from_json(rest)).plan_at(x, y), 0)
    system, drive = result.pop("system"), result.pop("drive")
    law = result.get("contact")
    if law is not None and not describe(law):
        result["contact"] = contact_laws.name_of(law)
    usual = {name: p.default for name, p in signature(simulate).parameters.items()}
    run = {k: v for k, v in result.items() if v != usual[k]}
    return Scenario(system=system, drive=drive, run=run)


def _pair(name: str, value: Any) -> tuple[float, float]:
    """Return two numbers."""
    if not isinstance(value, (list, tuple)) or len(value) != 2:
        raise InputError("must be two numbers", parameter=name, value=value)
    x, y = (checked_number(name, v, ANY, "SI") for v in value)
    return x, y


def overlays(given: Any, find: Find) -> bytes:
    """Return tongue, lift-off curve and trials in the coordinates of a map, as a block.

    A request may hold ``trials``, the text of a trial table. What a map cannot show is left out;
    ``notes`` says why.

    Raises
    ------
    InputError
        For bad input, also of trials that are no trial table.
    """
    from latolato.figures.overlays import OVERLAYS, curve

    if not isinstance(given, Mapping):
        raise InputError(f"a request must be an object, got {given!r}")
    rest = dict(given)
    text = rest.pop("trials", None)
    limits = rest.pop("limits", None)
    if not isinstance(limits, list) or len(limits) != 4:
        raise InputError(f"limits must be four numbers, got {limits!r}")
    left, right, bottom, top = (checked_number("limits", v, ANY, "SI") for v in limits)
    if not (left < right and bottom < top):
        raise InputError(f"limits must go upwards, got {limits}")
    arrays: dict[str, Any] = {}
    notes: dict[str, str] = {}
    try:
        context = _context(rest, find)
    except InputError as error:
        return pack({"notes": {"all": str(error)}, "outside": 0}, {})
    for name in OVERLAYS:
        try:
            with np.errstate(all="ignore"):  # what is beyond all numbers is not drawn
                x, y = curve(context, name, (left, right), (bottom, top))
        except InputError as error:
            notes[name] = str(error)
            continue
        arrays |= {f"{name}_x": np.array(x, dtype=float), f"{name}_y": np.array(y, dtype=float)}
    outside = 0
    if text is not None:
        x, y, kinds = _trials(text, context)
        arrays |= {"trial_x": x, "trial_y": y, "trial_class": kinds}
        outside = int(np.sum((x < left) | (x > right) | (y < bottom) | (y > top)))
    return pack({"notes": notes, "outside": outside}, arrays)


def _context(rest: dict[str, Any], find: Find) -> Context:
    """Return what turns amplitudes and frequencies into coordinates of the map."""
    import xarray as xr

    from latolato.figures.overlays import Context

    if "stored" in rest:
        from latolato.app.map_stored import opened

        names = rest.get("names")
        if not isinstance(names, list) or len(names) != 2:
            raise InputError("names must be those of the two axes")
        return Context.of(opened(find(rest["stored"])), str(names[0]), str(names[1]))
    shown = make_map(MapRequest.from_json(rest))
    plan = shown.plan_at(shown.x.high, shown.y.high)
    grid = xr.Dataset(attrs=attributes_of(plan, ROUNDING["threads"]))
    return Context.of(grid, shown.x.name, shown.y.name)


def _trials(text: Any, context: Context) -> tuple[Any, Any, Any]:
    """Return the coordinates and the classes of the trials of a table."""
    from latolato.experiment.trial_table import parse_trials

    if not isinstance(text, str):
        raise InputError("trials must be the text of a trial table")
    table = parse_trials(text)
    amplitude = table["drive_amplitude"].values.astype(float)
    # In natural frequencies of the toy that was measured, where these are known.
    by_ratio = table["frequency_ratio"].values.astype(float) * context.natural_frequency
    plain = table["drive_frequency"].values.astype(float)
    frequency = plain if context.x == "drive_frequency" else by_ratio
    frequency = np.where(
        np.isfinite(frequency), frequency, np.where(np.isfinite(plain), plain, by_ratio)
    )
    x, y = context.place(amplitude, frequency)
    kinds = np.array([CLASSES.index(str(k)) for k in table["class"].values], dtype=np.uint8)
    return np.asarray(x, dtype=float), np.asarray(y, dtype=float), kinds
