"""Fig. 9 through the chain: classified trials over the computed map."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import comparisons, style
from latolato.paper import chain_trials, grids
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr

AMPLITUDES, RATIOS = (0.008, 0.040), (1.70, 2.45)  # of the map; m and 1
POINTS, QUICK_POINTS = (71, 111), (36, 56)


def data(
    trials: chain_trials.Trials, title: str, quick: bool = False, full: bool = False
) -> xr.Dataset:
    """Return the trials over the map of the same protocol."""
    from latolato import sweep
    from latolato.experiment.comparison.places import compare_map

    table = trials.table(quick, full)
    up, across = QUICK_POINTS if quick else POINTS
    grid = sweep(
        trials.system,
        axes={
            "drive_amplitude": np.linspace(*AMPLITUDES, up),
            "frequency_ratio": np.linspace(*RATIOS, across),
        },
        duration=trials.duration,
        transient=trials.transient,
        **dict(trials.start),
        observables=grids.PENDULUM_OBSERVABLES,
    )
    dataset = compare_map(table, grid, sigmas=dict(trials.sigmas), draws=20 if quick else 60)
    known = np.flatnonzero(np.isfinite(dataset.boundary_computed.values))
    return chain_trials.note_sources(dataset.isel(boundary=known), title, table.attrs["failed"])


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that the statement needs."""
    inside = np.abs(dataset.boundary_x - dataset.boundary_computed) <= dataset.boundary_half_gap
    return {
        "agreement": float(dataset.agreement),
        "low": float(dataset.agreement_low),
        "high": float(dataset.agreement_high),
        "kappa": float(dataset.kappa),
        "count": float(dataset.sizes["trial"]),
        "inside": float(inside.sum()),
        "boundaries": float(inside.size),
        "enclosed": float(inside.mean()),
        "gap": 2.0 * float(dataset.boundary_half_gap.mean()),
    }


draw = style.styled(comparisons.draw)
