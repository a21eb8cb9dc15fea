"""Response curves: settled angle against frequency for each set, with the position of its peak."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from latolato.core.errors import InputError
from latolato.core.registry import checked_count
from latolato.experiment.calibration.parabola import parabola_top
from latolato.experiment.comparison.uncertainties import (
    LATE,
    Floats,
    checked_sigmas,
    drawn,
    frequencies_of,
    plain,
    run_at,
    variable,
)
from latolato.experiment.trial_table import checked_trials
from latolato.physics.pendulum import OneBall, System
from latolato.sweeps.plan import make_plan

if TYPE_CHECKING:
    import xarray as xr

    from latolato.sweeps.plan import Plan

# The largest angle on a flank that falls below this share of it within one step is a cliff.
_CLIFF = 0.5
_RESAMPLED = 400
# What a pair's maps gather: their kernel is used again.
_OBSERVABLES = ("mean_energy", "crossings", "largest_angle", LATE, "top_contacts")


@dataclass(frozen=True)
class Peak:
    """The maximum of a response curve: position, its deviation, height, and how it was found."""

    place: float
    sigma: float
    height: float
    kind: str


def compare_response(
    trials: xr.Dataset,
    system: System,
    *,
    duration: float = 90.0,
    transient: Annotated[float, "s"] = 60.0,
    initial_angle: float | None = None,
    initial_offset: float | None = None,
    points: int = 121,
    sigmas: Mapping[str, float] | None = None,
    draws: int = 8,
    seed: int = 0,
    observables: Any = _OBSERVABLES,
) -> xr.Dataset:
    """Return measured and computed response curves of each set, with their peaks.

    Parameters
    ----------
    trials : xarray.Dataset
        A trial table with settled angles.
    system : Pendulum or LatoLato
        What is computed.
    duration : float
        Duration of the computed runs [s].
    transient : float
        Time after which a computed motion counts as settled [s].
    initial_angle, initial_offset : float, optional
        Their start [rad], as for `latolato.sweep`; some motions depend on it.
    points : int
        Points of a computed curve, from 10 percent of the measured range below it to above it.
    sigmas : mapping of str to float, optional
        Standard deviations of the system's parameters, in SI units.
    draws : int
        Number of curves computed with other parameters, for the deviation of the computed peaks.
    seed : int
        Of all draws.

    Raises
    ------
    InputError
        For bad input and trials without settled angles.

    Notes
    -----
    A peak is the vertex of the parabola through the largest angle and its neighbours if both are
    at least half as large; its deviation is that of redrawn angles and frequencies, and half its
    distance from the largest sample. Where the curve falls off a cliff, the peak lies between the
    largest sample and the neighbour at the cliff: the middle of that gap, ±
    gap/sqrt(12). At the end of a set it is the last sample, ± one gap.
    """
    import xarray as xr

    checked_trials(trials)
    if not isinstance(system, OneBall):
        raise InputError("a response needs a Pendulum or a LatoLato", value=system)
    settled = trials[LATE].values
    if not np.isfinite(settled).all():
        raise InputError("response curves need the largest_angle_after_transient of every trial")
    widths = checked_sigmas(system, sigmas)
    count = checked_count("draws", draws)
    points = checked_count("points", points)
    random = np.random.default_rng(seed)
    natural = system.natural_frequency
    _, ratio = frequencies_of(trials, system)
    names = list(dict.fromkeys(trials["set"].values.tolist()))
    members = [np.flatnonzero(trials["set"].values == name) for name in names]
    amplitudes = np.array([float(np.mean(trials["drive_amplitude"].values[m])) for m in members])
    errors = np.nan_to_num(trials["drive_amplitude_sigma"].values)
    # What makes amplitudes uncertain is the picture's scale: trials of one set-up share its error.
    amplitude_sigmas = np.array([float(np.mean(errors[m])) for m in members])
    margin = 0.1 * float(np.ptp(ratio)) or 0.1
    ratios = np.linspace(
        max(float(ratio.min()) - margin, 0.05), float(ratio.max()) + margin, points
    )
    start = {"initial_angle": initial_angle, "initial_offset": initial_offset}
    plan = make_plan(
        system,
        axes={"drive_amplitude": amplitudes, "drive_frequency": [natural]},
        duration=duration,
        transient=transient,
        observables=observables,
        **{name: value for name, value in start.items() if value is not None},  # type: ignore[arg-type]
    )
    varied = drawn(system, widths, count, random)
    off = np.append(0.0, random.standard_normal(count - 1))
    moved = amplitudes + amplitude_sigmas * off[:, None]
    if "length" in varied:  # which is the picture's scale
        moved = moved * (varied["length"] / system.balls[0].length)[:, None]
    curves, at_trials = _curves(plan, moved, varied, ratios, trials)
    measured, computed = [], []
    sigma = np.nan_to_num(trials[f"{LATE}_sigma"].values)
    steady = np.nan_to_num(trials["drive_frequency_sigma"].values) / natural
    for i, own in enumerate(members):
        own = own[np.argsort(ratio[own])]
        measured.append(peak_of(ratio[own], settled[own], sigma[own], steady[own], random))
        first, *others = (peak_of(ratios, curve) for curve in curves[:, i])
        varies = float(np.std([peak.place for peak in (first, *others)]))
        computed.append(replace(first, sigma=math.hypot(first.sigma, varies)))
    variables: dict[str, Any] = {
        LATE: variable("trial", settled, LATE),
        f"{LATE}_sigma": variable("trial", sigma, f"{LATE}_sigma"),
        "trial_ratio": variable("trial", ratio, "frequency_ratio"),
        "set": plain("trial", trials["set"].values.astype(str), "set of trials"),
        "source": plain("trial", trials["source"].values.astype(str), "file of the trial"),
        "angle_at_trial": variable("trial", at_trials, LATE, "computed settled angle there"),
        "angle_computed": variable(
            ("set_name", "frequency_ratio"), curves[0], LATE,
            "computed settled angle",
        ),
        "set_amplitude": variable("set_name", amplitudes, "drive_amplitude"),
    }  # fmt: skip
    variables |= _peak_variables("measured", measured) | _peak_variables("computed", computed)
    coordinates = {
        "frequency_ratio": variable("frequency_ratio", ratios, "frequency_ratio"),
        "set_name": plain("set_name", names, "set of trials"),
    }
    attributes = {
        "comparison": "response", "verdict": _verdict(names, measured, computed), "draws": count,
        "system": repr(system),
        **{f"sigma_of_{name}": value for name, value in widths.items()},
    }  # fmt: skip
    return xr.Dataset(variables, coordinates, attributes)


def _curves(
    plan: Plan, amplitudes: Floats, varied: Mapping[str, Floats], ratios: Floats, trials: xr.Dataset
) -> tuple[Floats, Floats]:
    """Return settled angles along curves, shape (draw, set, ratio), and at the trials.

    `amplitudes` has the shape (draw, set), each of `varied` the shape (draw,).
    """
    shape = (*amplitudes.shape, len(ratios))
    along = {"drive_amplitude": amplitudes[..., None],
             "drive_frequency": ratios * plan.system.natural_frequency,
             **{name: values[:, None, None] for name, values in varied.items()}}  # fmt: skip
    frequency, _ = frequencies_of(trials, plan.system)
    at_trials = {"drive_amplitude": trials["drive_amplitude"].values, "drive_frequency": frequency}
    at_trials |= {name: np.full(len(frequency), getattr(plan.system, name)) for name in varied}
    run = run_at(
        plan,
        {
            name: np.concatenate([np.broadcast_to(values, shape).ravel(), at_trials[name]])
            for name, values in along.items()
        },
    )
    late = run[LATE].values
    return late[: -len(frequency)].reshape(shape), late[-len(frequency) :]


def peak_of(
    places: Floats,
    heights: Floats,
    height_sigmas: Floats | None = None,
    place_sigmas: Floats | None = None,
    random: np.random.Generator | None = None,
) -> Peak:
    """The maximum of a curve of few samples: its position with standard deviation, and height.

    Parameters
    ----------
    places, heights : ndarray, shape (sample,)
        In rising order of the places.
    height_sigmas, place_sigmas : ndarray, optional
        Standard deviations of both, for which `random` draws.

    Examples
    --------
    >>> import numpy as np
    >>> x = np.array([2.0, 2.2, 2.4, 2.6])
    >>> peak = peak_of(x, 1.0 - (x - 2.3) ** 2)
    >>> round(peak.place, 6), peak.kind
    (2.3, 'parabola')
    """
    top, place, height, kind = _vertex(places, heights)
    if kind == "end":
        gap = abs(places[top] - places[top - 1 if top else min(1, len(places) - 1)])
        return Peak(place, float(gap), height, kind)
    if kind == "cliff":
        sides = [k for k in (top - 1, top + 1) if heights[k] < _CLIFF * heights[top]]
        ends = [places[k] for k in sides]
        if len(sides) == 1:
            ends.append(places[top])
        low, high = min(ends), max(ends)
        return Peak(0.5 * (low + high), float(high - low) / math.sqrt(12.0), height, kind)
    drawn_places = []
    if random is not None and height_sigmas is not None and place_sigmas is not None:
        for _ in range(_RESAMPLED):
            x = places + place_sigmas * random.standard_normal(len(places))
            y = heights + height_sigmas * random.standard_normal(len(heights))
            order = np.argsort(x)
            drawn_places.append(_vertex(x[order], y[order])[1])
    varies = float(np.std(drawn_places)) if drawn_places else 0.0
    return Peak(place, math.hypot(varies, 0.5 * abs(place - places[top])), height, kind)


def _peak_variables(kind: str, peaks: list[Peak]) -> dict[str, Any]:
    """Return place, deviation, height and kind of the peaks of all sets as variables."""
    about = (
        ("place", "frequency_ratio", f"place of the {kind} peak"),
        ("sigma", "frequency_ratio", f"deviation of the place of the {kind} peak"),
        ("height", LATE, f"height of the {kind} peak"),
    )
    variables = {
        f"peak_{kind}_{part}": variable(
            "set_name", [getattr(peak, part) for peak in peaks], quantity, words
        )
        for part, quantity, words in about
    }
    kinds = [peak.kind for peak in peaks]
    variables[f"peak_{kind}_kind"] = plain("set_name", kinds, f"how the {kind} peak was found")
    return variables


def _vertex(places: Floats, heights: Floats) -> tuple[int, float, float, str]:
    """Return the largest sample, place and height of the peak, and how it was found."""
    top = int(np.argmax(heights))
    x, y = float(places[top]), float(heights[top])
    if top in (0, len(places) - 1):
        return top, x, y, "end"
    near = slice(top - 1, top + 2)
    if heights[near].min() < _CLIFF * y:
        return top, x, y, "cliff"
    return top, *parabola_top(places[near], heights[near]), "parabola"


def _verdict(names: list[str], measured: list[Peak], computed: list[Peak]) -> str:
    """A sentence on the measured and the computed peaks."""
    parts, apart = [], 0
    for name, one, other in zip(names, measured, computed, strict=True):
        parts.append(
            f"{name} at {one.place:.3f} ± {one.sigma:.3f} (computed {other.place:.3f} ± "
            f"{other.sigma:.3f})"
        )
        apart += abs(one.place - other.place) > 3.0 * math.hypot(one.sigma, other.sigma)
    words = f"The response peaks of {', '.join(parts)}."
    if any(one.sigma > one.place for one in measured):
        return f"{words} A peak that is less certain than its place is large agrees with anything."
    if apart:
        return f"{words} {apart} of {len(names)} differ by more than 3 standard deviations."
    return f"{words} All agree within 3 standard deviations."
