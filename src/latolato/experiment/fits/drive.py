"""How the pivot was driven: amplitude, frequency, phase, overtones, drift and steps."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError, Sentence, joined
from latolato.core.quantities import Range
from latolato.core.registry import checked_count
from latolato.experiment.fits.adequacy import (
    SHORTEST,
    STRONG,
    Kind,
    changes,
    cut_at,
    misfit_doubt,
    misfit_of,
    place_of_change,
    solutions_of,
)
from latolato.experiment.fits.drive_motion import Shape, across_of, guesses_of_passages, with_across
from latolato.experiment.fits.least_squares import (
    ConvergenceError,
    Data,
    Floats,
    Guess,
    Solution,
    one_series,
    solve,
)
from latolato.experiment.fits.registry import FitKind, fits
from latolato.experiment.fits.result import Adequacy, Estimate, Fit, make_fit, size_questions
from latolato.experiment.fits.samples import (
    is_driven,
    noise_of,
    pivot_swing,
    steps_over_gap,
    within,
    without_repeats,
)
from latolato.experiment.fits.swings import crossings
from latolato.experiment.quality import fitted_harmonic
from latolato.experiment.rules import broken, said
from latolato.experiment.track_table import checked_table
from latolato.physics.drives import Chirp, CrankSlider, FrequencySchedule, Harmonic
from latolato.physics.drives.base import Drive

if TYPE_CHECKING:
    import xarray as xr

MOST_STAGES = 4
# An amplitude below so many times the noise of a sample is a pivot at rest.
_CLEAR = 3.0
# Cycles more or fewer that a gap may hold than it seems to.
_LOST_CYCLES = 4
# What a track may bend a motion by [pixels].
_LEAST_OVERTONE = 0.1
# Multiples of the driving frequency that are looked at.
_OVERTONES = (2, 3, 4)
# What a drive may have besides its stages, and where a search for that starts.
_DRIFT = {"amplitude_drift": Guess(0.0), "frequency_drift": Guess(0.0)}
_CRANK = {"crank_ratio": Guess(0.0, -0.99, 0.99)}
# Durations of ramps that a search starts from [s], and the trials that it may take.
_RAMPS, _TRIES = (0.3, 1.0, 3.0), 50
# Scatter of the times between samples, as a share, from which they are uneven.
_UNEVEN = 0.01
# Samples that are looked through for a drive faster than half their rate, multiples of that rate
# which are tried, and what it must leave of the residuals of a slower one.
_FAST_SAMPLES, _FASTEST, _FAST = 400, 4.0, 0.5
_KINDS = [
    Kind("phase jump", frozenset({"phase"}), "drive_phase_jump"),
    Kind("change of pace", frozenset({"frequency"}), "drive_pace"),
    Kind("change of amplitude", frozenset({"amplitude"}), "drive_size"),
    Kind("shifted height", frozenset({"offset"}), "drive_shift"),
    Kind("another motion", frozenset({"amplitude", "frequency", "phase", "offset"}), "drive_other"),
]
# Drifts over the record below these shares are of no account, however surely they are seen.
_AMPLITUDE_DRIFT, _FREQUENCY_DRIFT = 5e-3, 2e-4


def fit_drive(
    table: xr.Dataset,
    *,
    stages: int | None = None,
    start: Annotated[float | None, "s"] = None,
    end: Annotated[float | None, "s"] = None,
    profile: bool = True,
) -> Fit:
    """Return amplitude, frequency and phase of the pivot's motion, its overtones and steps.

    Includes amplitude and phase of the horizontal motion if the table has it.

    Parameters
    ----------
    table : xarray.Dataset
        A track table; `pivot_y` is fitted, from its first to its last passage through the middle,
        and `pivot_x` at the same instants.
    stages : int, optional
        Number of stages of constant frequency; by default it is found, up to 4.
    start : float, optional
        First instant used [s].
    end : float, optional
        Last instant used [s].
    profile : bool
        Whether to profile the 95 percent intervals of amplitude and frequency.

    Returns
    -------
    Fit
        With `drive_amplitude` [m], `drive_frequency` [rad/s], `drive_phase` (at the first frame of
        the table, which is time zero of ``drive``), `crank_ratio` and, for one stage,
        `amplitude_drift` and `frequency_drift`. With steps `drive_frequency` is the first stage's,
        `drive_frequency_final` the last one's and `step_time` the last step; ``dataset`` has all of
        them on ``stage``. Where `pivot_x` is known and not one value, `horizontal_amplitude` [m]
        and `horizontal_phase` too. The deviations of amplitudes include that of the table's scale
        where it is known (``metres_per_pixel_sigma``). ``drive`` is a `Harmonic`, a
        `PlanarHarmonic` where a horizontal motion is seen, a `CrankSlider` where the second
        harmonic is that of a crank, or a `FrequencySchedule`.

    Raises
    ------
    InputError
        For bad input, or a pivot that does not move up and down.
        If lmfit is missing.

    Notes
    -----
    The height is ``y = A0 cos p - A0 q sin^2 p/(1 + sqrt(1 - q^2 sin^2 p))`` about a mean, with
    the signed crank ratio q = s A0/L of the crank-slider (s = +1: guide above) and a phase p whose
    frequency is constant in each stage and moves within `ramp` between them. Stages, ramp, drift
    and crank are kept if they lower BIC by 10 or more: a drift only if it changes the amplitude by
    half a per cent or the frequency by 0.02 per cent, a crank only if its second harmonic is above
    a tenth of a pixel of the track, to which templates may bend a motion. A second harmonic that is
    not in phase, as an eccentric bearing makes, is reported but not part of ``drive``.

    The horizontal position is ``Ax cos(p + lead)`` about a mean, with the same phase p. The motion
    is seen where Ax exceeds four standard deviations. These include a quarter of a tenth of a
    pixel and, for the part in phase with the height, the table's ``angle_offset_sigma``: a tilted
    camera shows such motion too. Only a `PlanarHarmonic` has it; the verdict names any other drive
    that leaves it out. Horizontal motion at other frequencies counts as scatter.
    """
    checked_table(table, "pivot_y")
    if stages is not None:
        stages = checked_count("stages", stages, Range(1, MOST_STAGES))
    origin = float(table["time"].values[0])
    data, zeros = _samples(table, origin, start, end)
    even = _rate_of(data.times)
    least = _LEAST_OVERTONE * float(table.attrs.get("metres_per_pixel", 0.0))
    shape, solution = _chosen(data, zeros, stages, least)
    if profile:
        profiles = ("drive_amplitude", "drive_frequency")
        solution = _fit(data, shape, solution.guesses, profiles=profiles)
    is_steady = "frequency_drift" not in solution.values
    drift: dict[str, Estimate] = {}
    if shape.stages == 1:
        drifting = _fit(data, shape, solution.guesses | _DRIFT) if is_steady else solution
        drift = {name: drifting.estimate(name) for name in _DRIFT}
    _check_cycles(solution, float(np.ptp(data.times)))
    adequacy = _doubt(data, shape, solution, origin, least)
    estimates = _estimates(solution, shape, origin) | drift
    scale_share = _scale_share(table)
    estimates = {name: with_scale(each, scale_share) for name, each in estimates.items()}
    overtones, overtone_sigma = _overtones(data, shape, solution, least)
    drive, overtone_words = _drive(solution, shape, overtones[0], overtone_sigma)
    words = [*_main_words(estimates, solution, shape, origin), *overtone_words]
    across = across_of(table, data.times, origin, shape, solution, least)
    if across is not None:
        across = replace(across, amplitude=with_scale(across.amplitude, scale_share))
        drive, more = with_across(drive, across)
        words.append(more)
        estimates |= {
            "horizontal_amplitude": across.amplitude, "horizontal_phase": across.phase
        }  # fmt: skip
    if not is_steady:
        changes = _changes(data, solution)
        which = "both" if len(changes) > 1 else next(iter(changes))
        words.append(said(f"unsteady_{which}", span=float(np.ptp(data.times)), **changes))
    elif drift:
        words.append(said("steady_drive"))
    words.append(
        said("scale_included", percent=100.0 * scale_share)
        if scale_share > 0.0
        else said("scale_apart")
    )
    if even is not None:
        words.append(_alias_words(solution.values["drive_frequency"] / math.tau, even))
    curves = {
        **solution.curves(data, "pivot_height"),
        "time": ("sample", origin + data.times),
        "harmonic": ("harmonic", np.array(_OVERTONES)),
        "harmonic_amplitude": ("harmonic", np.abs(overtones)),
        "harmonic_amplitude_sigma": ("harmonic", np.full(len(overtones), overtone_sigma)),
        "stage_start": (
            "stage",
            origin + np.array([0.0, *(solution.values[n] for n in shape.times)]),
        ),
        "drive_frequencies": ("stage", np.array([solution.values[n] for n in shape.frequencies])),
        "drive_frequencies_sigma": (
            "stage",
            np.array([solution.sigma(n) for n in shape.frequencies]),
        ),
    }
    if across is not None:
        curves["pivot_across"] = ("sample", across.samples)
        curves["pivot_across_fit"] = ("sample", across.curve)
    about = {
        "start": origin + float(data.times[0]), "end": origin + float(data.times[-1]),
        "origin": origin, "samples": len(data), "stages": shape.stages,
        "scale_share": scale_share, "scale_source": table.attrs.get("scale_source"),
        **solution.quality,
        "source": table.attrs.get("source"),
    }  # fmt: skip
    return make_fit("drive", estimates, joined(words), curves, about, drive, adequacy=adequacy)


fits.register("drive")(
    FitKind(
        function=fit_drive,
        title="Measured drive",
        headline=(
            "drive_amplitude",
            "drive_frequency",
            "drive_frequency_final",
            "drive_phase",
            "horizontal_amplitude",
            "horizontal_phase",
        ),
        system=lambda _, apparatus, table: apparatus.guess(table) if apparatus.length else None,
    )
)


def _samples(
    table: xr.Dataset, origin: float, start: float | None, end: float | None
) -> tuple[Data, Floats | None]:
    """Return the heights between the first and the last passage, and the passages from `origin` on.

    Of a drive that is faster than half the rate of uneven samples all heights, and None.
    """
    time, height = table["time"].values, table["pivot_y"].values
    good = np.isfinite(height) & within(time, start, end)
    if good.sum() < 16:
        raise broken("few_pivots", {"count": good.sum()})
    time, height = time[good] - origin, height[good]
    seen, _ = without_repeats(one_series(time, height))
    if len(seen) >= 16:
        time, height = seen.times, seen.values
    if _is_fast(time, height):
        return one_series(time, height), None
    low, high = np.percentile(height, [2.0, 98.0])
    noise = noise_of(height)
    if noise > 0.5 * (high - low):  # more than any noise scatters beside its own range
        pause = float(np.median(np.diff(time)))
        raise broken("fast_pivot", {"noise": 1e3 * noise, "pause": pause})
    if high == low or 0.5 * (high - low) < _CLEAR * noise:
        raise _without_height(table.isel(frame=good), 0.5 * float(high - low), noise)
    zeros = crossings(time, height - 0.5 * (low + high))
    if len(zeros) < 6:
        raise broken("few_passages", {"count": len(zeros)})
    chosen = (time >= zeros[0]) & (time <= zeros[-1])
    return one_series(time[chosen], height[chosen]), zeros


def _is_fast(time: Floats, height: Floats) -> bool:
    """Return whether uneven samples show a drive that is faster than half their rate."""
    if _rate_of(time) is not None:
        return False
    few = slice(0, _FAST_SAMPLES)
    *_, slow = fitted_harmonic(time[few], height[few])
    rate, _, rest = fitted_harmonic(time[few], height[few], _fastest(time))
    return rate > math.pi / float(np.median(np.diff(time))) and rest < _FAST * slow


def _fastest(time: Floats) -> float:
    """Return the highest frequency that is tried for uneven samples [rad/s]."""
    return _FASTEST * math.pi / float(np.median(np.diff(time)))


def _scale_share(table: xr.Dataset) -> float:
    """Return the relative standard deviation of a table's scale, 0 where it is not known."""
    sigma = float(table.attrs.get("metres_per_pixel_sigma", 0.0))
    return sigma / float(table.attrs.get("metres_per_pixel", 1.0))


def with_scale(estimate: Estimate, share: float) -> Estimate:
    """Return an estimate whose deviation holds that of the scale, if it is a length.

    All samples share the scale's error, so their scatter does not show it.
    """
    if estimate.unit != "m" or not share > 0.0:
        return estimate
    wider = estimate.widened(math.hypot(estimate.sigma, share * estimate.value))
    return replace(wider, low=max(wider.low, min(estimate.low, 0.0)))  # no amplitude is negative


def without_scale(estimate: Estimate, share: float) -> float:
    """Return the standard deviation of a length of `fit_drive` as a multiple of the scale [m]."""
    return math.sqrt(max(estimate.sigma**2 - (share * estimate.value) ** 2, 0.0))


def _without_height(piece: xr.Dataset, reach: float, noise: float) -> InputError:
    """Return the error of a pivot that does not move upwards: it rests, or moves sideways only."""
    up, scatter, length = 1e3 * reach, 1e3 * noise, float(piece.attrs.get("length") or 0.0)
    if "pivot_x" in piece.variables and is_driven(piece, length, "pivot_x"):
        size = 1e3 * pivot_swing(piece, "pivot_x")
        return broken("sideways_pivot", {"size": size, "up": up, "scatter": scatter})
    if reach == noise == 0.0:
        return broken("constant_pivot")
    return broken("resting_pivot", {"up": up, "scatter": scatter})


def _chosen(
    data: Data, zeros: Floats | None, stages: int | None, least: float
) -> tuple[Shape, Solution]:
    """Return the shape that the criterion prefers, and its solution.

    Stages are added as long as each is worth its parameters.
    """
    middle = 0.5 * float(data.times[0] + data.times[-1])
    chosen: tuple[Shape, Solution] | None = None
    for count in range(1, MOST_STAGES + 1) if stages is None else [stages]:
        shape = Shape(count, middle)
        try:
            trial = _of_stages(data, zeros, shape, least)
        except InputError:
            if chosen is None:
                raise
            break
        if chosen and not (_is_better(trial, chosen[1]) and _is_real(trial, shape, data)):
            break
        chosen = shape, trial
    assert chosen is not None
    return chosen


def _of_stages(data: Data, zeros: Floats | None, shape: Shape, least: float) -> Solution:
    """Return the best solution of so many stages: plain, changing smoothly, with a crank."""
    best = _plain(data, zeros, shape)
    for further in (_ramps(best, shape) if shape.times else [_DRIFT], [_CRANK]):
        starts = [best.guesses | each for each in further]
        for trial in solutions_of(partial(_fit, data, shape, limit=_TRIES), starts)[:1]:
            if _is_better(trial, best) and _is_large(data, trial, least):
                best = trial
    return best


def _ramps(best: Solution, shape: Shape) -> list[dict[str, Guess]]:
    """Return ramps between stages about the steps of a solution."""
    return [
        {name: Guess(best.values[name] - 0.5 * ramp) for name in shape.times}
        | {"ramp": Guess(ramp, 0.0)}
        for ramp in _RAMPS
    ]


def _plain(data: Data, zeros: Floats | None, shape: Shape) -> Solution:
    """Return the best solution of a shape from all starts.

    A gap, or mistakes of the tracker, change the number of passages, but not the best harmonic. A
    gap may hold some cycles more or fewer than that has.
    """
    if zeros is None:
        if shape.times:
            raise broken("fast_stages")
        few = slice(0, _FAST_SAMPLES)
        fast = _harmonic_guess(data.times[few], data.values[few], _fastest(data.times))
        return _fit(data, shape, fast)
    starts = [guesses_of_passages(data, zeros, shape)]
    if shape.stages == 1:
        harmonic = _harmonic_guess(data.times, data.values)
        starts += [harmonic, *_over_gap(data, harmonic)]
    tries = solutions_of(partial(_fit, data, shape), starts)
    if not tries:
        raise broken("no_shape", kind=ConvergenceError)
    return tries[0]


def _over_gap(data: Data, harmonic: Mapping[str, Guess]) -> list[dict[str, Guess]]:
    """Return drives like a harmonic before the longest gap, with other numbers of cycles in it."""
    rate, phase = (harmonic[name].value for name in ("drive_frequency", "drive_phase"))
    early = float(np.mean(data.times[: int(np.argmax(np.diff(data.times))) + 1]))
    return [
        {
            **harmonic,
            "drive_frequency": Guess(rate + step),
            "drive_phase": Guess(phase - step * early),
        }
        for step in steps_over_gap(data.times, rate, _LOST_CYCLES)
    ]


def _harmonic_guess(late: Floats, height: Floats, fastest: float | None = None) -> dict[str, Guess]:
    """Return the best harmonic as a guess."""
    rate, weights, _ = fitted_harmonic(late, height, fastest)
    mean, cosine, sine = map(float, weights)
    return {
        "mean_height": Guess(mean),
        "drive_amplitude": Guess(math.hypot(cosine, sine), 0.0),
        "drive_phase": Guess(math.atan2(-sine, cosine)),
        "drive_frequency": Guess(rate),
    }


def _is_large(data: Data, solution: Solution, least: float) -> bool:
    """Return whether overtones exceed what a track may bend, and drifts those of any motor."""
    p = solution.values
    if "crank_ratio" in p:
        return 0.25 * abs(p["crank_ratio"]) * p["drive_amplitude"] > least
    return "frequency_drift" not in p or bool(_changes(data, solution))


def _is_better(trial: Solution, best: Solution) -> bool:
    """Return whether a richer model is worth its parameters, by BIC with one correlation."""
    # The likelihoods of two correlations cannot be compared; the better fit's noise counts.
    kept = trial.kept & best.kept
    squares = [float(np.sum(s.residuals[kept] ** 2)) for s in (trial, best)]
    count = kept.sum() * (1.0 - trial.correlation) / (1.0 + trial.correlation)
    gain = count * math.log(squares[1] / max(squares[0], 1e-300))
    extra = len(trial.names) - len(best.names)
    return bool(gain - max(extra, 0) * math.log(max(count, 2.0)) >= STRONG)


def _is_real(solution: Solution, shape: Shape, data: Data) -> bool:
    """Return whether every stage lasts two periods and differs from the one before."""
    marks = [
        float(data.times[0]),
        *(solution.values[n] for n in shape.times),
        float(data.times[-1]),
    ]
    rates = [solution.values[name] for name in shape.frequencies]
    long = all(
        (b - a) * w > 2.0 * math.tau for (a, b), w in zip(pairwise(marks), rates, strict=True)
    )
    apart = all(
        abs(b - a) > max(4.0 * solution.sigma(name), 1e-3 * a)
        for a, b, name in zip(rates[:-1], rates[1:], shape.frequencies[1:], strict=True)
    )
    return long and apart and min(rates) > 0.0


def _fit(data: Data, shape: Shape, guesses: Mapping[str, Guess], **options: Any) -> Solution:
    """Return the least-squares solution of a shape."""
    return solve(lambda p: shape.height(p, data.times), guesses, data, **options)


def _estimates(solution: Solution, shape: Shape, origin: float) -> dict[str, Estimate]:
    """Return the estimates under their public names."""
    estimates = {name: solution.estimate(name) for name in ("drive_amplitude", "drive_frequency")}
    if shape.stages > 1:
        estimates["drive_frequency_final"] = solution.estimate(shape.frequencies[-1], "rad/s")
        estimates["step_time"] = solution.estimate(shape.times[-1], "s").shifted(origin)
    phase = solution.estimate("drive_phase")
    value = math.remainder(phase.value, math.tau)
    estimates["drive_phase"] = Estimate(value, phase.sigma, "rad")
    for name in ("ramp", "crank_ratio"):
        if name in solution.values:
            estimates[name] = solution.estimate(name)
    return estimates


def _overtones(
    data: Data, shape: Shape, solution: Solution, least: float
) -> tuple[NDArray[np.complex128], float]:
    """Return the multiples of the driving frequency in the height, and their deviation [m].

    The real parts are in phase, the imaginary ones in quadrature. A track may bend the height by
    `least`, which is no scatter.
    """
    phase = shape.phase(solution.values, data.times)
    columns = [np.ones(len(data))]
    for k in (1, *_OVERTONES):
        columns += [np.cos(k * phase), np.sin(k * phase)]
    design = np.column_stack(columns)[solution.kept]
    values, *_ = np.linalg.lstsq(design, data.values[solution.kept], rcond=None)
    rest = data.values[solution.kept] - design @ values
    scatter = 2.0 * float(np.mean(rest**2)) / solution.effective_samples
    return values[3::2] + 1j * values[4::2], math.sqrt(scatter + (0.25 * least) ** 2)


def _drive(
    solution: Solution, shape: Shape, second: complex, second_sigma: float
) -> tuple[Drive, list[Sentence]]:
    """Return the drive object, and sentences on its second harmonic [m]."""
    p = solution.values
    amplitude, phase = p["drive_amplitude"], math.remainder(p["drive_phase"], math.tau)
    share, q = 100.0 * abs(second) / amplitude, p.get("crank_ratio")
    if q is not None:
        ratio = f"{abs(q):.3g} ± {solution.sigma('crank_ratio'):.1g}"
        words = [said("crank_above" if q > 0.0 else "crank_below", share=share, ratio=ratio)]
    elif abs(second) > 4.0 * second_sigma:
        words = [said("no_crank", share=share)]
    else:
        words = [said("no_harmonic", share=400.0 * second_sigma / amplitude)]
    if q is not None and abs(second.imag) > max(4.0 * second_sigma, abs(second.real)):
        words.append(said("out_of_phase"))
    if shape.stages > 1:
        first: Any = {"drive_amplitude": amplitude, "drive_phase": phase}
        times = [0.0, *(p[name] for name in shape.times)]
        rates = [p[name] for name in shape.frequencies]
        ramp = min(max(p.get("ramp", 0.0), 0.0), float(np.min(np.diff(times))))
        if q is not None:
            words.append(said("omitted_harmonic"))
        drive: Drive = FrequencySchedule(times=times, drive_frequencies=rates, ramp=ramp, **first)
        return drive, words
    rate, middle = p.get("frequency_drift", 0.0), shape.middle
    if rate != 0.0:
        drive = Chirp(
            drive_amplitude=amplitude,
            drive_frequency=p["drive_frequency"] - rate * middle,
            drive_frequency_final=p["drive_frequency"] + rate * middle,
            sweep_time=2.0 * middle,
            drive_phase=math.remainder(phase + 0.5 * rate * middle**2, math.tau),
        )
        return drive, words
    if q is not None:
        return CrankSlider(
            drive_amplitude=amplitude,
            drive_frequency=p["drive_frequency"],
            drive_phase=phase,
            connecting_rod_length=amplitude / abs(q),
            guide="above" if q > 0.0 else "below",
        ), words
    return Harmonic(
        drive_amplitude=amplitude, drive_frequency=p["drive_frequency"], drive_phase=phase
    ), words


def _main_words(
    estimates: Mapping[str, Estimate], solution: Solution, shape: Shape, origin: float
) -> list[Sentence]:
    """Return amplitude and frequencies in plain words."""

    def at(rate: Estimate) -> dict[str, str]:
        return {"rate": str(rate), "turns": str(rate.scaled(1.0 / math.tau, "Hz"))}

    later = [
        said(
            "drive_stage",
            time=str(solution.estimate(before, "s").shifted(origin)),
            **at(solution.estimate(name, "rad/s")),
        )
        for name, before in zip(shape.frequencies[1:], shape.times, strict=True)
    ]
    ramp = said("drive_ramp", ramp=str(estimates["ramp"])) if "ramp" in estimates else ""
    amplitude = str(estimates["drive_amplitude"].scaled(1e3, "mm"))
    rates = at(estimates["drive_frequency"])
    moves = said("drive_moves", amplitude=amplitude, **rates, later=joined(later, ""), ramp=ramp)
    sizes = {name: estimates[name].value for name in ("drive_amplitude", "drive_frequency")}
    return [*size_questions(sizes), moves]


def _rate_of(times: Floats) -> float | None:
    """Return the rate of evenly spaced samples [Hz], None for uneven ones."""
    steps = np.diff(times)
    pause = float(np.median(steps))
    near = steps[steps < 1.5 * pause]
    return 1.0 / pause if float(np.std(near)) < _UNEVEN * pause else None


def _alias_words(rate: float, even: float) -> Sentence:
    """Return which other frequencies [Hz] would look the same at an even rate of samples [Hz]."""
    others = {"one": even - rate, "other": even + rate, "third": 2.0 * even - rate}
    return said("drive_same_look", rate=even, **others)


def _check_cycles(solution: Solution, duration: float) -> None:
    """Raise InputError unless there are two cycles, of a frequency that is known."""
    rate = solution.values["drive_frequency"]
    if abs(rate) * duration < 2.0 * math.tau or solution.sigma("drive_frequency") > abs(rate):
        raise broken("few_cycles", {"count": abs(rate) * duration / math.tau})


def _doubt(data: Data, shape: Shape, solution: Solution, origin: float, least: float) -> Adequacy:
    """Return whether the model describes the height."""
    shortest = SHORTEST * math.tau / abs(solution.values["drive_frequency"])
    place = place_of_change(data, solution, shortest, 0.5 * least)
    if place is None:
        return misfit_doubt(solution, replace(data, times=data.times + origin)) or Adequacy()
    simple = Shape(1, shape.middle)

    def fit_part(part: Data, about: Solution | None = None) -> Solution:
        if about is not None:
            return _fit(part, simple, about.guesses)
        guesses = _harmonic_guess(part.times, part.values)
        guesses |= {name: solution.guesses[name] for name in _CRANK if name in solution.guesses}
        return _fit(part, simple, guesses)

    noise = max(noise_of(data.values), 1e-300)
    rule = "broken_harmonic" if shape.stages == 1 else "broken_drive"
    ratio = solution.scatter / noise

    def doubt(at: float, reason: str) -> Sentence:
        return said(rule, stages=shape.stages, ratio=ratio, time=at, reason=reason)

    try:
        cut = cut_at(data, solution, place, fit_part, shortest)
    except InputError:
        at = origin + float(data.times[place])
        return Adequacy(doubt(at, ""), "unknown", at)
    at = origin + cut.instant
    one, other, off, covariance = changes(cut, _portrait)
    kind = min(_KINDS, key=lambda each: misfit_of(each, off, covariance))
    numbers = {
        "share": (off["phase"] / math.tau) % 1.0,
        "pace": f"{100.0 * (math.exp(off['frequency']) - 1.0):+.2g} %",
        "size_before": 1e3 * math.exp(one["amplitude"]),
        "size_after": 1e3 * math.exp(other["amplitude"]),
        "offset": 1e3 * off["offset"],
    }
    reason = said("looks_as_if", reason=said(kind.rule, **numbers))
    return Adequacy(doubt(at, reason), kind.name, at)


def _portrait(_: Solution, p: Mapping[str, float], instant: float) -> dict[str, float]:
    """Return the numbers of a drive at an instant, as `adequacy.changes` compares them."""
    return {
        "amplitude": math.log(max(p["drive_amplitude"], 1e-300)),
        "frequency": math.log(max(abs(p["drive_frequency"]), 1e-300)),
        "phase": math.remainder(p["drive_phase"] + p["drive_frequency"] * instant, math.tau),
        "offset": p["mean_height"],
    }


def _changes(data: Data, solution: Solution) -> dict[str, float]:
    """Return by how much an amplitude or a frequency changes over the record, in per cent."""
    parts = {}
    for name, limit in (("amplitude", _AMPLITUDE_DRIFT), ("frequency", _FREQUENCY_DRIFT)):
        change, sigma = solution.values[f"{name}_drift"], solution.sigma(f"{name}_drift")
        share = change * float(np.ptp(data.times)) / solution.values[f"drive_{name}"]
        if abs(change) > 4.0 * sigma and abs(share) > limit:
            parts[name] = 100.0 * share
    return parts
