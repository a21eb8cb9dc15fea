"""The numbers of a run or of a sweep that fit on a screen."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

    from latolato.simulation.record import Record
    from latolato.sweeps.plan import Plan

_COPIED = (
    "system",
    "drive",
    "duration",
    "tolerance",
    "status",
    "energy_residual",
    "compression_time",
    "compression_fraction",
    "first_slack",
    "slack_fraction",
    "largest_string_impulse",
    "sensitivity_status",
)
# Contacts that begin and end a rest.
_HELD = ("rest", "release")


def summarise(run: Record | xr.Dataset) -> dict[str, Any]:
    """Return a run's largest angle, contacts and their word, energy residual and status.

    The largest angle and energy are those of the samples and of top contacts of a `LatoLato`; a
    sweep's `largest_angle` includes turning points between samples. With a periodic drive,
    `contact_word` is the word of the last 48 drive periods, as `latolato.ContactWord` describes it,
    or of all of them if there are fewer; None for less than three. On strings the first time and
    the share of time of slackness and the largest impulse take the place of compression. Values are
    as JSON knows them: None for a compression time that never came, lists for two balls.

    Examples
    --------
    >>> import latolato as ll
    >>> result = summarise(ll.load_scenario("zeno").simulate())
    >>> result["contacts"]["rest"], round(result["largest_angle"], 4)
    (1, 1.5708)
    """
    import numpy as np

    kinds, counts = np.unique(np.asarray(run["contact_kind"]), return_counts=True)
    largest = np.nanmax(np.abs(np.asarray(run["angle"])), initial=-np.inf)
    if "top" in kinds and "contact_angle_high" in run.attrs:
        largest = max(largest, run.attrs["contact_angle_high"])  # samples lie beside it
    result = {name: plain(run.attrs[name]) for name in _COPIED if name in run.attrs}
    return result | {
        "largest_angle": plain(largest),
        "largest_energy": plain(np.nanmax(np.asarray(run["total_energy"]), initial=-np.inf)),
        "contacts": dict(zip(kinds.tolist(), counts.tolist(), strict=True)),
        **_word(run),
        "samples": len(run["time"]),
    }


def _word(run: Record | xr.Dataset) -> dict[str, Any]:
    """Return the contact word of a run with a periodic drive, a list for two balls."""
    import numpy as np

    from latolato.observables import contact_words
    from latolato.observables.word import word_of_run
    from latolato.physics.contacts import CONTACT_KINDS
    from latolato.physics.drives import PeriodicDrive, drives

    drive = drives.get(run.attrs["drive"])
    if drive is None or not issubclass(drive, PeriodicDrive):
        return {}
    kinds = [CONTACT_KINDS.index(kind) for kind in np.asarray(run["contact_kind"]).tolist()]
    held = [CONTACT_KINDS[kind] == "rest" for kind in kinds if CONTACT_KINDS[kind] in _HELD]
    final, before = np.asarray(run["angular_velocity"]), np.asarray(run["angular_velocity_before"])
    is_still = bool((final[..., -1] == 0.0).all()) and run.attrs.get("contact", "none") != "none"
    codes = [
        word_of_run(
            np.asarray(run["contact_time"]).tolist(), kinds, velocities.tolist(),
            drive_period=math.tau / run.attrs["drive_frequency"], duration=run.attrs["duration"],
            held=held[-1] if held else is_still,
        )
        for velocities in np.atleast_2d(before)
    ]  # fmt: skip
    words = [word or None for word in contact_words(codes).tolist()]
    return {"contact_word": words if final.ndim == 2 else words[0]}


def summarise_sweep(grid: xr.Dataset, plan: Plan) -> dict[str, Any]:
    """Return a sweep's size, points by status, and the least and largest value of each variable.

    The dataset is read chunk by chunk. Of contact words the points with each come too, the
    commonest first.

    Examples
    --------
    >>> import latolato as ll
    >>> from latolato.sweeps.plan import make_plan
    >>> from latolato.sweeps import run_plan
    >>> plan = make_plan(
    ...     ll.Pendulum(length=1.0, mass=0.8), axes={"initial_angle": [0.1, 0.2]},
    ...     duration=2.0, observables=["largest_angle"],
    ... )
    >>> summarise_sweep(run_plan(plan), plan)["status"]
    {'converged': 2}
    """
    import numpy as np

    from latolato.numerics.records import STATUS_NAMES
    from latolato.observables import contact_words

    counts: Counter[str] = Counter()
    words: Counter[str] = Counter()
    ranges: dict[str, list[float]] = {}
    for number in range(plan.chunks):
        block = plan.block(number)
        for name in grid.data_vars:
            values = grid[name][block].values
            if name == "status":
                counts.update(values.ravel().tolist())
                continue
            if name == "contact_word":
                words.update(word for word in contact_words(values).ravel().tolist() if word)
            if np.isfinite(values).any():
                low, high = float(np.nanmin(values)), float(np.nanmax(values))
                old = ranges.get(str(name), [low, high])
                ranges[str(name)] = [min(low, old[0]), max(high, old[1])]
    return {
        "system": grid.attrs["system"],
        "drive": grid.attrs["drive"],
        "duration": plan.duration,
        "axes": {axis.name: len(axis) for axis in plan.axes},
        "points": plan.size,
        "status": {name: counts[name] for name in STATUS_NAMES if counts[name]},
        "first_invalid": grid.attrs.get("first_invalid", ""),
        "ranges": {
            str(name): [plain(end) for end in ranges.get(str(name), [None, None])]
            for name in grid.data_vars
            if name != "status"
        },
        **({"contact_words": dict(words.most_common())} if "contact_word" in grid else {}),
        "plan_hash": plan.hash,
    }


def plain(value: Any) -> Any:
    """Return a value as JSON knows it: no NumPy types, None for what is no finite number."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(name): plain(part) for name, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
