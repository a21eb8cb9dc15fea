"""Sweeps of one figure in one dataset, maps in its panels, and numbers read off maps."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from latolato import Harmonic, LatoLato, Pendulum
from latolato.figures import overlays
from latolato.paper import systems as paper
from latolato.paper.cases import Floats, variable

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

    from latolato.physics.pendulum import OneBall

Mask = NDArray[np.bool_]

# One list for all maps of a system, so that each kernel is compiled once.
PENDULUM_OBSERVABLES = (
    "mean_energy",
    "crossings",
    "largest_angle",
    "largest_angle_after_transient",
    "motion_class",
)
PAIR_OBSERVABLES = (
    "mean_energy",
    "crossings",
    "largest_angle",
    "largest_angle_after_transient",
    "top_contacts",
)
# What Figs. 3cd and 5 keep of their maps.
KEPT = ("mean_energy", "crossings", "largest_angle")
_LABELS = {
    "mean_energy": r"mean energy $\langle E\rangle$ [J]",
    "crossings": "crossings of 2 rad",
}
# The statuses with which a sweep leaves a point without numbers.
WITHOUT_ANSWER = ("event_limit", "failed", "invalid", "outside_model")
# Where the band of order 2 is looked for, and the ratios beside it that it is compared with.
BAND, BESIDE_BAND = (0.95, 1.05), (0.85, 1.15)


def even(last: float, count: int) -> Floats:
    """Return `count` evenly spaced values above zero, up to `last`."""
    return np.linspace(last / count, last, count)


def paper_axes(length: float, count: int) -> dict[str, Floats]:
    """Return the axes of Figs. 3cd and 5 for a length [m], with `count` points along each."""
    return {
        "drive_amplitude": even(paper.LARGEST_AMPLITUDE_RATIO * length, count),
        "frequency_ratio": even(paper.LARGEST_FREQUENCY_RATIO, count),
    }


def without_walls(system: Pendulum, count: int) -> xr.Dataset:
    """Return the map of Fig. 3cd of a pendulum, from rest at the toy's low contact angle."""
    from latolato import sweep

    return sweep(
        system,
        axes=paper_axes(system.length, count),
        duration=paper.SWEEP_DURATION,
        initial_angle=paper.TOY.contact_angle_low,
        observables=PENDULUM_OBSERVABLES,
    )


def gather(
    grids: Mapping[str, xr.Dataset],
    *,
    title: str,
    keep: Sequence[str],
    apart: Mapping[str, xr.Dataset] | None = None,
) -> xr.Dataset:
    """Return sweeps as one dataset.

    Parameters
    ----------
    grids : mapping of str to xarray.Dataset
        Results of `latolato.sweep` over the same axes, by a label; they are stacked along `case`.
    title : str
        Title of the dataset.
    keep : sequence of str
        Variables that are kept.
    apart : mapping of str to xarray.Dataset, optional
        Sweeps over other axes; their variables and axes get the label and ``_`` in front.

    Returns
    -------
    xarray.Dataset
        With the plan of each sweep (JSON, enough to run it again), its number of points and of
        points without an answer, over `sweep`.
    """
    import xarray as xr

    apart = apart or {}
    first = next(iter(grids.values()))
    variables: dict[str, Any] = {}
    coordinates: dict[str, Any] = {
        "case": variable("case", list(grids), units="1", long_name="case")
    }
    for name in keep:
        values = np.stack([grid[name].values for grid in grids.values()])
        variables[name] = (("case", *first[name].dims), values, dict(first[name].attrs))
    for dim in map(str, first[keep[0]].dims):
        coordinates[dim] = (dim, first[dim].values, dict(first[dim].attrs))
    for label, grid in apart.items():
        for name in keep:
            dims = [f"{label}_{dim}" for dim in grid[name].dims]
            variables[f"{label}_{name}"] = (dims, grid[name].values, dict(grid[name].attrs))
        for dim in map(str, grid[keep[0]].dims):
            about = {"units": "1", "long_name": dim, "symbol": ""} | dict(grid[dim].attrs)
            coordinates[f"{label}_{dim}"] = (f"{label}_{dim}", grid[dim].values, about)
    everything = {**grids, **apart}
    counts = {
        "points": ("points of the sweep", [g.status.size for g in everything.values()]),
        "unanswered": (
            "points without an answer",
            [int(g.status.isin(WITHOUT_ANSWER).sum()) for g in everything.values()],
        ),
    }
    for name, (meaning, numbers) in counts.items():
        variables[name] = variable("sweep", numbers, units="1", long_name=meaning)
    plans = [grid.attrs["plan"] for grid in everything.values()]
    variables["plan"] = variable("sweep", plans, units="1", long_name="the sweep as JSON")
    coordinates["sweep"] = variable("sweep", list(everything), units="1", long_name="sweep")
    versions = ("latolato_version", "numpy_version", "numba_version")
    about = {name: first.attrs[name] for name in versions}
    return xr.Dataset(variables, coordinates, attrs={"title": title, **about})


def label(values: xr.DataArray) -> str:
    """Return the label of a map: its quantity with symbol and unit."""
    return _LABELS[str(values.name).removeprefix("clamp_")]


def draw_overlay(axes: Axes, system: OneBall, name: str) -> Any:
    """Draw the tongue of eq14 or the lift-off curve over a map and return its legend entry."""
    context = overlays.Context(
        x="frequency_ratio",
        y="drive_amplitude",
        length=system.length,
        mass=system.mass,
        damping=system.damping,
        gravity=system.gravity,
        has_walls=isinstance(system, LatoLato),
        other_drag=False,
    )
    return overlays.draw(axes, context, name)


def acceleration_ratio(dataset: xr.Dataset, prefix: str = "") -> Floats:
    """Return A0 w^2/g at each point of a map of a system of length 1 m: A0/l times ratio^2."""
    amplitude = dataset[f"{prefix}drive_amplitude"].values
    ratio = dataset[f"{prefix}frequency_ratio"].values
    return np.asarray(amplitude[:, None] * ratio[None, :] ** 2)


def smallest_amplitude(active: xr.DataArray) -> tuple[float, float]:
    """Return the smallest amplitude [m] that has an active point, and the first ratio."""
    rows = np.flatnonzero(active.values.any(axis=1))
    if not rows.size:
        return math.nan, math.nan
    first = int(np.argmax(active.values[rows[0]]))
    return float(active.drive_amplitude[rows[0]]), float(active.frequency_ratio[first])


def band_gain(energy: xr.DataArray) -> float:
    """Return by what factor the energy at ratio 1 exceeds that beside it, at most over A0."""
    ratio = energy.frequency_ratio
    inside = energy.where((ratio > BAND[0] - 1e-9) & (ratio < BAND[1] + 1e-9), drop=True)
    beside = [energy.sel(frequency_ratio=r, method="nearest") for r in BESIDE_BAND]
    gain = inside.max("frequency_ratio") / np.sqrt(beside[0] * beside[1])
    return float(gain.max())


def in_band(values: xr.DataArray) -> float:
    """Return the largest value of a map around ratio 1."""
    ratio = values.frequency_ratio
    return float(values.where((ratio > BAND[0] - 1e-9) & (ratio < BAND[1] + 1e-9)).max())


def outliers(active: Mask) -> float:
    """Return the share of points that differ from most of the nine around and on them."""
    windows = np.lib.stride_tricks.sliding_window_view(active, (3, 3)).sum(axis=(2, 3))
    return float(np.mean(active[1:-1, 1:-1] != (windows >= 5)))


def shake(system: OneBall, ratio: float, amplitude: float) -> Harmonic:
    """Return the harmonic drive of a frequency ratio [1] and an amplitude [m]."""
    return Harmonic(drive_amplitude=amplitude, drive_frequency=ratio * system.natural_frequency)


def padded(datasets: Sequence[xr.Dataset], name: str) -> Floats:
    """Return a variable of branches or curves as rows, with NaN behind the shorter ones."""
    rows = np.full((len(datasets), max(each.sizes["point"] for each in datasets)), np.nan)
    for row, dataset in zip(rows, datasets, strict=True):
        row[: dataset.sizes["point"]] = dataset[name].values
    return rows
