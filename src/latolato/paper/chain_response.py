"""Fig. 11 through the chain: response curves of trials, and where they peak."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.figures import comparisons, style
from latolato.paper import chain_trials, grids
from latolato.paper import systems as paper
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def data(
    trials: chain_trials.Trials, title: str, quick: bool = False, full: bool = False
) -> xr.Dataset:
    """Return the response curves of the trials and the computed ones."""
    from latolato.experiment.comparison.response import compare_response

    table = trials.table(quick, full)
    dataset = compare_response(
        table,
        trials.system,
        duration=trials.duration,
        transient=trials.transient,
        **dict(trials.start),
        points=121 if quick else 241,
        sigmas=dict(trials.sigmas),
        draws=3 if quick else 8,
        observables=grids.PAIR_OBSERVABLES,
    )
    return chain_trials.note_sources(dataset, title, table.attrs["failed"])


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that the statement needs."""
    peaks, computed = dataset.peak_measured_place.values, dataset.peak_computed_place.values
    sigma = np.hypot(dataset.peak_measured_sigma.values, dataset.peak_computed_sigma.values)
    return {
        **{f"peak_{i}": float(peak) for i, peak in enumerate(peaks)},
        **{f"computed_{i}": float(peak) for i, peak in enumerate(computed)},
        "sigma": float(np.mean(dataset.peak_measured_sigma)),
        "pull": float(np.max(np.abs(peaks - computed) / sigma)),
        "first": float(peaks.min()),
        "last": float(peaks.max()),
    }


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the response curves."""
    figure = comparisons.draw(dataset)
    figure.axes[0].axvspan(*paper.PEAK_RATIOS, color=style.ORANGE, alpha=0.22, lw=0, zorder=0)
    return figure
