"""Compare trials with a computed map: where their classes agree, and how certain that is."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.analysis.stroboscopic import wilson_interval
from latolato.core.errors import InputError
from latolato.core.quantities import QUANTITIES
from latolato.core.registry import checked_count
from latolato.experiment.comparison.uncertainties import (
    LATE,
    Floats,
    checked_sigmas,
    classes_in,
    drawn,
    frequencies_of,
    plain,
    plan_of,
    run_at,
    variable,
)
from latolato.experiment.trial_statistics import class_of, cohen_kappa
from latolato.experiment.trial_table import CLASSES, checked_trials

if TYPE_CHECKING:
    import xarray as xr

    from latolato.sweeps.plan import Plan

AMPLITUDES = ("drive_amplitude", "amplitude_ratio")
FREQUENCIES = ("drive_frequency", "frequency_ratio")


def compare_map(
    trials: xr.Dataset,
    grid: xr.Dataset,
    *,
    sigmas: Mapping[str, float] | None = None,
    draws: int = 60,
    seed: int = 0,
) -> xr.Dataset:
    """Compare trials with the classes of a map: agreement with its uncertainty, boundaries.

    Parameters
    ----------
    trials : xarray.Dataset
        A trial table.
    grid : xarray.Dataset
        A sweep over amplitude and frequency with `motion_class`, or with both largest angles.
    sigmas : mapping of str to float, optional
        Standard deviations of the system's parameters, in SI units: ``{"length": 5e-4, ...}``.
    draws : int
        How often all trials are computed again with parameters drawn within their uncertainty;
        0 skips this.
    seed : int
        Of these draws.

    Returns
    -------
    xarray.Dataset
        On ``trial`` the measured class, the class of the map's cell, and the share of the draws
        in which they agree; on ``boundary`` where motion begins and ends in each set, measured
        (midway between neighbours) and on the map; the share that agrees with its 95 percent
        interval, Cohen's kappa, the table of classes; and the map.

    Raises
    ------
    InputError
        For bad input, other axes, or if none of the trials lies on the map.

    Notes
    -----
    In a draw each trial gets a frequency and angles within its own deviations, and all trials share
    one value of each uncertain parameter, and one error of their amplitudes in units of their
    deviations, which are those of the picture's scale. A wrong length makes that scale, and so all
    amplitudes, wrong by the same share. The trials are run at these
    places with everything else as the map's plan says, and trials are taken at random with
    replacement: the interval holds both what the parameters leave open and chance
    (`agreement_sigma_parameters` and `agreement_sigma_binomial` tell them apart).
    """
    import xarray as xr

    checked_trials(trials)
    plan = plan_of(grid)
    widths = checked_sigmas(plan.system, sigmas)
    count = checked_count("draws", draws) if draws else 0
    classes = classes_in(grid)
    up, across = _axes_of(classes)
    classes = classes.transpose(up, across)
    places = _places(trials, plan, up, across)
    rows, inside = _cell(classes[up].values, places[0])
    columns, also = _cell(classes[across].values, places[1])
    predicted = np.full(trials.sizes["trial"], np.nan)
    inside &= also
    predicted[inside] = classes.values[rows[inside], columns[inside]]
    measured = _class_numbers(trials)
    known = np.isfinite(predicted)
    if not known.any():
        raise InputError(
            f"none of the {len(measured)} trials lies on the map, whose {up} goes from "
            f"{classes[up].values.min():.4g} to {classes[up].values.max():.4g} and {across} from "
            f"{classes[across].values.min():.4g} to {classes[across].values.max():.4g}"
        )
    taken = trials.isel(trial=np.flatnonzero(known))
    measured, computed = measured[known], predicted[known].astype(int)
    random = np.random.default_rng(seed)
    again = _drawn_agreement(taken, plan, widths, count, random) if count else None
    variables: dict[str, Any] = {
        "x": variable("trial", places[1][known], across),
        "y": variable("trial", places[0][known], up),
        "class_measured": plain("trial", measured, "measured class (0 none, 1 weak, 2 strong)"),
        "class_computed": plain("trial", computed, "class of the map there"),
        **{name: taken[name].variable for name in ("borderline", "set", "source")},
        **_agreement(measured, computed, again, random),
        **_boundaries(taken, classes, up, across, plan),
        "motion_class": (
            (up, across),
            classes.values,
            {"units": "1", "long_name": "class of motion", **classes.attrs},
        ),
    }
    if "mean_energy" in grid:
        energy = grid["mean_energy"].transpose(up, across)
        variables["mean_energy"] = energy.variable
    outside = int((~known).sum())
    attributes = {
        "comparison": "map", "verdict": _verdict(variables, outside),
        "draws": count,
        "plan": grid.attrs["plan"],
        **{f"sigma_of_{name}": value for name, value in widths.items()},
    }  # fmt: skip
    coordinates = {
        up: classes[up].variable,
        across: classes[across].variable,
        "measured": plain("measured", list(CLASSES), "measured class"),
        "computed": plain("computed", list(CLASSES), "computed class"),
    }
    return xr.Dataset(variables, coordinates, attributes)


def _agreement(
    measured: Any, computed: Any, again: Any, random: np.random.Generator
) -> dict[str, Any]:
    """Return how well two classifications of trials agree, and how surely.

    `again` holds whether they do in draws with other parameters, shape (draw, trial); None without
    any.
    """
    agrees = measured == computed
    n, share = len(agrees), float(agrees.mean())
    low, high = (float(end) for end in wilson_interval(int(agrees.sum()), n)[1:])
    by_parameters, drawn_variables = 0.0, dict[str, Any]()
    if again is not None:
        # Counts first: equal shares differ by nothing, not by a rounding.
        by_parameters = float(np.std(again.sum(axis=1)) / n)
        # Many draws, each with trials taken with replacement.
        repeats = max(len(again), 400)
        row = np.arange(repeats)[:, None] % len(again)
        shares = again[row, random.integers(n, size=(repeats, n))].mean(axis=1)
        low = min(low, float(np.quantile(shares, 0.025)))
        high = max(high, float(np.quantile(shares, 0.975)))
        drawn_variables["chance_of_agreement"] = plain(
            "trial", again.mean(axis=0), "share of draws in which trial and computation agree"
        )
    binomial = math.sqrt(max(share * (1.0 - share), 1.0 / (4.0 * n * n)) / n)
    table = np.zeros((3, 3), dtype=np.int64)
    np.add.at(table, (measured, computed), 1)
    kappa = cohen_kappa(measured, computed)
    return {
        "agrees": plain("trial", agrees.astype(np.int8), "whether both classes agree (1) or not"),
        "agreement": plain((), share, "share of trials whose class is the map's"),
        "agreement_low": plain((), low, "low end of its 95 % interval"),
        "agreement_high": plain((), high, "high end of its 95 % interval"),
        "agreement_sigma_binomial": plain((), binomial, "its deviation due to chance"),
        "agreement_sigma_parameters": plain(
            (), by_parameters, "its deviation due to the parameters"
        ),
        "kappa": plain((), kappa, "Cohen's kappa"),
        "confusion": plain(
            ("measured", "computed"), table, "trials by measured and computed class"
        ),
        **drawn_variables,
    }


def _class_numbers(trials: xr.Dataset) -> Any:
    return np.array([CLASSES.index(name) for name in trials["class"].values.tolist()])


def _drawn_agreement(
    trials: xr.Dataset,
    plan: Plan,
    widths: Mapping[str, float],
    count: int,
    random: np.random.Generator,
) -> Any:
    """Return whether classes of trials and computation agree, each within its uncertainty.

    Of shape (draw, trial).
    """
    n = trials.sizes["trial"]

    def about(name: str, errors: int = n) -> Floats:
        sigma = np.nan_to_num(trials[f"{name}_sigma"].values)
        values: Floats = trials[name].values + sigma * random.standard_normal((count, errors))
        return values

    # Trials share the error of the picture's scale, which makes their amplitudes uncertain.
    amplitude, frequency = about("drive_amplitude", 1), about("drive_frequency")
    varied = drawn(plan.system, widths, count, random)
    if "length" in varied:
        amplitude = amplitude * (varied["length"] / plan.system.balls[0].length)[:, None]
    frequency = np.where(np.isfinite(frequency), frequency, frequencies_of(trials, plan.system)[0])
    columns = {"drive_amplitude": amplitude.ravel(), "drive_frequency": frequency.ravel()}
    columns |= {name: np.repeat(values, n) for name, values in varied.items()}
    computed = classes_in(run_at(plan, columns)).values.reshape(count, n)
    largest, settled = about("largest_angle"), about(LATE)
    has_angles = np.isfinite(largest) & np.isfinite(settled)
    measured = np.where(has_angles, class_of(largest, settled), _class_numbers(trials))
    return measured == computed


def _axes_of(classes: xr.DataArray) -> tuple[str, str]:
    """Return the names of the axes of amplitude and of frequency."""
    dims = [str(dim) for dim in classes.dims]
    up = [dim for dim in dims if dim in AMPLITUDES]
    across = [dim for dim in dims if dim in FREQUENCIES]
    if len(dims) != 2 or not up or not across:
        raise InputError(
            f"trials need a map over {' or '.join(AMPLITUDES)} and {' or '.join(FREQUENCIES)}, got "
            f"one over {', '.join(dims)}"
        )
    return up[0], across[0]


def _places(trials: xr.Dataset, plan: Plan, up: str, across: str) -> tuple[Floats, Floats]:
    """Return the coordinates of the trials along both axes."""
    amplitude, own = trials["drive_amplitude"].values, trials["length"].values
    frequency, ratio = frequencies_of(trials, plan.system)
    # A trial of unknown length is taken to be of the map's.
    own = np.where(np.isfinite(own), own, plan.system.balls[0].length)
    return (
        amplitude if up == "drive_amplitude" else amplitude / own,
        frequency if across == "drive_frequency" else ratio,
    )


def _cell(values: Floats, places: Floats) -> tuple[Any, Any]:
    """Return the cell that each place lies in, and whether it lies in one."""
    order = np.argsort(values)
    ordered = values[order]
    middle = 0.5 * (ordered[1:] + ordered[:-1])
    if len(ordered) > 1:
        low, high = 2.0 * ordered[0] - middle[0], 2.0 * ordered[-1] - middle[-1]
    else:
        low, high = ordered[0], ordered[0]
    return order[np.searchsorted(middle, places)], (places >= low) & (places <= high)


def _boundaries(
    trials: xr.Dataset, classes: xr.DataArray, up: str, across: str, plan: Plan
) -> dict[str, Any]:
    """The boundaries of motion in each set of trials, measured and on the map."""
    height, along = _places(trials, plan, up, across)
    sets = trials["set"].values
    moves = trials["class"].values != "none"
    rows: list[tuple[Any, ...]] = []
    for name in dict.fromkeys(sets.tolist()):
        own = np.flatnonzero(sets == name)
        own = own[np.argsort(along[own])]
        moving = np.flatnonzero(moves[own])
        if not moving.size:
            continue
        y = float(np.mean(height[own]))
        row, inside = _cell(classes[up].values, np.array([y]))
        line = classes.isel({up: int(row[0])})
        for side, edge, step in (("left", moving[0], -1), ("right", moving[-1], 1)):
            if not 0 <= edge + step < len(own):
                continue
            x, other = along[own[edge]], along[own[edge + step]]
            predicted = _edge(line, across, side) if inside[0] else math.nan
            rows.append((name, side, y, 0.5 * (x + other), 0.5 * abs(x - other), predicted))
    columns = np.array(rows, dtype=object).reshape(len(rows), 6).T
    unit = QUANTITIES[across].unit
    about = (
        ("set", str, "set of trials", "1"),
        ("side", str, "side on which the motion ends", "1"),
        ("y", float, QUANTITIES[up].long_name, QUANTITIES[up].unit),
        ("x", float, "measured boundary", unit),
        ("half_gap", float, "half the gap between the trials on its sides", unit),
        ("computed", float, "boundary of the map", unit),
    )
    return {
        f"boundary_{name}": plain("boundary", values.astype(kind), words, unit)
        for (name, kind, words, unit), values in zip(about, columns, strict=True)
    }


def _edge(line: xr.DataArray, across: str, side: str) -> float:
    """The boundary of motion along a row of the map, midway between points; NaN without motion."""
    line = line.sortby(across)
    x, moves = line[across].values, np.nan_to_num(line.values) >= 1
    if not moves.any():
        return math.nan
    k = int(np.argmax(moves)) if side == "left" else len(x) - 1 - int(np.argmax(moves[::-1]))
    other = k - 1 if side == "left" else k + 1
    return float(0.5 * (x[k] + x[other])) if 0 <= other < len(x) else float(x[k])


def _verdict(variables: Mapping[str, Any], outside: int) -> str:
    """The agreement of trials and map in words."""
    names = ("agreement", "agreement_low", "agreement_high", "kappa")
    share, low, high, kappa = (variables[name][1] for name in names)
    words = (
        f"{100 * share:.0f} % of {len(variables['agrees'][1])} trials have the same class as the "
        f"map at their place (95 % interval: {100 * low:.0f} to {100 * high:.0f} %; "
        f"kappa {kappa:.2f})."
    )
    x, computed, half = (variables[f"boundary_{name}"][1] for name in ("x", "computed", "half_gap"))
    gaps = x - computed
    known = np.isfinite(gaps)
    if known.any():
        within = np.abs(gaps[known]) <= half[known]
        words += (
            f" {int(within.sum())} of {int(known.sum())} measured boundaries enclose that of the "
            f"map; the mean shift is {float(np.mean(gaps[known])):+.3f}."
        )
    if outside:
        words += f" {outside} trials lie outside the map."
    return words
