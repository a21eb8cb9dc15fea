"""The numbers of a run that fit on a screen."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

_COPIED = (
    "system",
    "drive",
    "duration",
    "tolerance",
    "status",
    "energy_residual",
    "slack_time",
    "slack_fraction",
)


def summarise(run: xr.Dataset) -> dict[str, Any]:
    """Return a run's largest angle, contacts by kind, energy residual, slack time and status.

    Values are as JSON knows them: None for a slack time that never came, lists for two balls.

    Examples
    --------
    >>> import latolato as ll
    >>> found = summarise(ll.load_scenario("zeno").simulate())
    >>> found["contacts"]["rest"], round(found["largest_angle"], 4)
    (1, 1.5708)
    """
    import numpy as np

    kinds, counts = np.unique(run["contact_kind"].values, return_counts=True)
    found = {name: _plain(run.attrs[name]) for name in _COPIED if name in run.attrs}
    return found | {
        "largest_angle": _plain(np.nanmax(np.abs(run["angle"].values))),
        "largest_energy": _plain(np.nanmax(run["total_energy"].values)),
        "contacts": dict(zip(kinds.tolist(), counts.tolist(), strict=True)),
        "samples": run.sizes["time"],
    }


def _plain(value: Any) -> Any:
    """Return a value without NumPy types, None for what JSON has no number for."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, list):
        return [_plain(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
