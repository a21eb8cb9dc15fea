"""All parameters of a system against the measured angles, with the measured pivot as its drive."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from latolato.core.errors import InputError, Sentence, joined
from latolato.core.parameters import Parameter, law_parameters
from latolato.core.quantities import POSITIVE
from latolato.core.registry import checked_number, suggest
from latolato.experiment.fits.adequacy import (
    MOST_OUTLIERS,
    SHORTEST,
    misfit_doubt,
    place_of_change,
)
from latolato.experiment.fits.least_squares import (
    ConvergenceError,
    Data,
    Floats,
    Guess,
    Solution,
)
from latolato.experiment.fits.pivots import Pivot, measured_motion
from latolato.experiment.fits.registry import FitKind, fits
from latolato.experiment.fits.result import Adequacy, Estimate, Fit, make_fit, named, quantity_of
from latolato.experiment.fits.samples import is_mirrored
from latolato.experiment.fits.sight import ABOVE, BENT, SMEAR_ABOVE, pivot_doubt, sight_guesses
from latolato.experiment.fits.windows import Laws, WindowedModel, window_starts
from latolato.experiment.rules import said
from latolato.physics.drives import Drive, FixedPivot, MeasuredPivot, drives
from latolato.physics.pendulum import System, systems
from latolato.simulation.vary import replaced

if TYPE_CHECKING:
    import xarray as xr

# Windows in natural periods, from what any guess can follow to the whole.
_LEVELS = (2.0, 6.0, 20.0, math.inf)
# A longer window is taken if the scatter grows by no more than this.
_GROWTH = 1.15
# What a camera may be turned by beyond what the table allows for [rad].
_TILT = 0.5


def fit_model(
    table: xr.Dataset,
    system: System,
    drive: Drive | str | None = None,
    vary: Sequence[str] | None = None,
    *,
    ball: int | None = None,
    start: Annotated[float | None, "s"] = None,
    end: Annotated[float | None, "s"] = None,
    window: Annotated[float | None, "s"] = None,
    profile: bool = False,
) -> Fit:
    """Return the parameters of a system that best describe measured angles.

    Paper eq10 with impacts by eq11, as `simulate` solves them. The pivot moves as it was measured
    unless a drive is given; the values of the system are first guesses of what varies.

    Parameters
    ----------
    table : xarray.Dataset
        A track table; samples that are not flagged ok are ignored.
    system : Pendulum, LatoLato or BallPair
        What moves; its values are first guesses of what varies, and held otherwise.
    drive : Drive or "measured", optional
        How the pivot moves, from the table's first frame on. By default as it was measured: at
        rest, or as `fit_drive` describes it, or by a spline (`MeasuredPivot`) where that leaves
        more than 2 percent of the amplitude; "measured" takes the spline always.
    vary : sequence of str, optional
        Parameters to fit: of the system, of the drive, and ``angle_offset``; by default
        `length`, `damping` and, with contacts, `restitution`. Of a `BallPair` ``right_length`` and
        so on.
    ball : int, optional
        Which ball a system of one angle describes; by default 1, and for a `LatoLato` with both
        balls in the table half the difference of their angles.
    start : float, optional
        First instant used [s].
    end : float, optional
        Last instant used [s].
    window : float, optional
        Time after which the motion gets a new start [s]; by default as long as the model follows.
    profile : bool
        Whether to profile 95 percent intervals.

    Returns
    -------
    Fit
        With each fitted parameter under its own name.

    Raises
    ------
    InputError
        For bad input, parameters that the system does not have or that no motion determines (mass).
        If lmfit is missing.
    ConvergenceError
        If the fit does not converge even in the shortest windows, or the samples do not tell
        parameters apart, as gravity, length and damping on a pivot at rest.

    Notes
    -----
    Multiple shooting: the record is cut into windows, each with a start of its own, fitted
    together with the shared parameters. Windows of 2 natural periods come first, then longer ones
    up to the whole record while the scatter of the residuals grows by less than 15 percent: a
    regular motion ends in one window, a chaotic one in as many as it takes. How the uncertainty
    of the pivot's motion changes the parameters is part of their standard deviations: the fit is
    repeated with drives that the track allows as well. The angle of the hanging ball and the
    pivot's offset from its position in the table are fitted as well
    (`latolato.experiment.fits.sight`).
    """
    found = described(table, system, drive, vary, ball=ball, start=start, end=end, window=window)
    names, model, solution = found.names, found.model, found.solution
    if profile:
        solution = model.solved(solution.guesses, profiles=names)
    widening, bent, unknown = _by_pivots(found)
    estimates = {
        name: own.widened(math.hypot(own.sigma, widening[name]))
        for name in names
        for own in [solution.estimate(name)]
    }
    best, best_drive = found.laws(solution.values)
    verdict = _verdict(estimates, solution, model, found.lost, unknown)
    return make_fit(
        "model", estimates, verdict, found.curves,
        found.attributes | {"system": systems.name_of(best), "drive": drives.name_of(best_drive)},
        drive_to_keep(best_drive), best, adequacy=doubt_of(found, bent),
    )  # fmt: skip


fits.register("model")(
    FitKind(
        function=fit_model,
        title="Model",
        is_slow=True,
        hint="The length, damping and restitution that best describe the whole motion about "
        "the measured pivot. The computed motion is then drawn over the curve and a video.",
        is_predicted=True,
    )
)


@dataclass(frozen=True)
class Described:
    """What least squares find of a model against the measured angles.

    Attributes
    ----------
    names : list of str
        The parameters that were asked for.
    data : Data
        The angles that the model is about.
    pivot : Pivot
        How the pivot moves, and other motions of it that its track allows as well.
    others : list of (Laws, float)
        The laws with each of these, and the weight of the squared change that it makes.
    laws : callable
        System and drive for values of the parameters.
    lost : int
        The number of longer windows in which the fit did not converge, 0 without such.
    period : float
        Natural, of the system that was given [s].
    source : str or None
        Where the table is from.
    has_sigmas : bool
        Whether the table states the uncertainty of the angles.
    """

    names: list[str]
    data: Data
    pivot: Pivot
    others: list[tuple[Laws, float]]
    laws: Laws
    solution: Solution
    model: WindowedModel
    lost: int
    period: float
    source: str | None
    has_sigmas: bool

    @property
    def curves(self) -> dict[str, tuple[str, Any]]:
        """Measured and fitted angles, as variables of a fit."""
        data, solution = self.data, self.solution
        return {
            **solution.curves(data, "angle"),
            "ball_number": ("sample", data.series),
            "window_start": ("window", np.array([w.begin for w in self.model.windows])),
        }

    @property
    def attributes(self) -> dict[str, Any]:
        """What was fitted and how well, as attributes of a fit."""
        return {
            "start": float(self.data.times.min()), "end": float(self.data.times.max()),
            "samples": len(self.data), "pivot": self.pivot.words,
            **self.solution.quality, "chi_square": self.solution.chi_square,
            "windows": len(self.model.windows), "source": self.source,
        }  # fmt: skip


def described(
    table: xr.Dataset,
    system: System,
    drive: Drive | str | None,
    vary: Sequence[str] | None,
    *,
    ball: int | None,
    start: float | None,
    end: float | None,
    window: float | None,
    prior: Mapping[str, Any] | None = None,
    fits_pivot: bool = False,
) -> Described:
    """Return the least-squares solution of a model; see `fit_model`, of `prior` `fit_posterior`.

    With `fits_pivot` the parameters of a drive that was fitted to the pivot's track are fitted once
    more, and that first fit is what is known of them beforehand.
    """
    if window is not None:
        window = checked_number("window", window, POSITIVE, "s")
    table, data, moving = measured_motion(table, system, drive, ball, start, end)
    known = _known(system, moving.drive)
    names = _names(system, known, vary)
    varied = [known[name] for name in names if name in known]
    of_pivot = {
        name: sigma for name, sigma in moving.deviations.items() if fits_pivot and name not in names
    }
    varied += [known[name] for name in of_pivot]
    shared = {"angle_offset": Guess(0.0, prior=_TILT), **sight_guesses(table, data)}
    if is_mirrored(table, system, ball):
        shared = {name: shared[name] for name in (ABOVE, SMEAR_ABOVE, BENT) if name in shared}
    shared |= {name: Guess(0.0) for name in names}
    shared |= {each.name: _guess(system, moving.drive, each) for each in varied}
    for name, deviation in (of_pivot | _deviations(prior, names)).items():
        expected = _value(system, moving.drive, known[name]) if name in known else 0.0
        shared[name] = replace(shared[name], expected=expected, prior=deviation)
    laws = _laws(system, moving.drive, varied)
    period = math.tau / system.natural_frequency
    levels = [x * period for x in _LEVELS] if window is None else [window]
    solution, model, lost = _longest(data, laws, shared, levels, moving.origin)
    neighbours = [] if moving.deviations and fits_pivot else moving.others
    others = [(_laws(system, other, varied), weight) for other, weight in neighbours]
    return Described(
        names, data, moving, others, laws, solution, model, lost, period,
        table.attrs.get("source"), bool(np.isfinite(table["angle_sigma_1"].values).any()),
    )  # fmt: skip


def drive_to_keep(drive: Drive) -> Drive | None:
    """Return a drive if a fit keeps it: one of formulas, not the samples of a table."""
    return None if isinstance(drive, (MeasuredPivot, FixedPivot)) else drive


def _known(system: System, drive: Drive) -> dict[str, Parameter]:
    """The parameters that can vary, by name."""
    of_drive, of_system = law_parameters(drive, "drive"), law_parameters(system, "system")
    return {
        each.name: each
        for each in (*of_drive, *of_system)
        if isinstance(_value(system, drive, each), float)
    }


def _names(system: System, known: Mapping[str, Parameter], vary: Sequence[str] | None) -> list[str]:
    """The names of the parameters to vary, checked."""
    if vary is None:
        names = ["length", "damping"]
        if system.angles == 2:
            names = [f"{side}_{name}" for name in names for side in ("right", "left")]
        return names + (["restitution"] if system.has_contacts else [])
    if isinstance(vary, str):
        vary = [vary]
    for name in vary:
        if name.endswith("mass"):
            raise InputError("mass acts only through damping/mass: vary damping and give the mass")
        if name.endswith("radius"):
            raise InputError("the radius is geometry: measure it")
        if name not in known and name != "angle_offset":
            choices = ["angle_offset", *known]
            raise InputError(f"nothing called '{name}' can vary: {suggest(name, choices)}")
    if not vary:
        raise InputError("there is nothing to fit: give at least one name")
    return list(dict.fromkeys(vary))


def _deviations(prior: Any, names: list[str]) -> dict[str, float]:
    """Return the standard deviations of parameters that are known beforehand, in SI units."""
    if prior is None:
        return {}
    if not isinstance(prior, Mapping):
        raise InputError("must map names to standard deviations", parameter="prior", value=prior)
    for name in prior:
        if name not in names:
            raise InputError(
                f"'{name}' is not among what is fitted: {suggest(str(name), names)}",
                parameter="prior",
            )
    return {
        name: checked_number(f"the prior of {name}", value, POSITIVE, quantity_of(name).unit)
        for name, value in prior.items()
    }


def _value(system: System, drive: Drive, parameter: Parameter) -> Any:
    """Return the value that a law has."""
    return reduce(getattr, parameter.path, system if parameter.owner == "system" else drive)


def _guess(system: System, drive: Drive, parameter: Parameter) -> Guess:
    """Return the guess of a parameter, clear of the ends of its range."""
    value, allowed = _value(system, drive, parameter), parameter.allowed
    if parameter.path[-1] == "damping" and value == 0.0:
        ball = system.balls[0]
        value = 0.01 * ball.mass * ball.length * system.natural_frequency
    elif value <= allowed.low:
        value = allowed.low + 1e-3
    elif value >= allowed.high:
        value = allowed.high - 0.05
    return Guess(value, allowed.low + (1e-9 if allowed.open_low else 0.0), allowed.high)


def _laws(system: System, drive: Drive, varied: Sequence[Parameter]) -> Laws:
    """A function for system and drive with other values of some parameters."""

    def laws(p: Mapping[str, float]) -> tuple[System, Drive]:
        values: dict[str, dict[tuple[str, ...], float]] = {"system": {}, "drive": {}}
        for each in varied:
            values[each.owner][each.path] = p[each.name]
        return replaced(system, values["system"]), replaced(drive, values["drive"])

    return laws


def _longest(
    data: Data, laws: Any, shared: Mapping[str, Guess], levels: Sequence[float], origin: float
) -> tuple[Solution, WindowedModel, int]:
    """Return the solution of the longest windows that the model follows.

    The third is the number of longer windows in which the fit did not converge, 0 without such.
    """
    best: tuple[Solution, WindowedModel] | None = None
    lost = 0
    duration = float(np.ptp(data.times))
    for level in levels:
        if best is not None and len(best[1].windows) == 1:
            break
        span = level if level < duration else math.inf
        begins = window_starts(data, span, int(data.series.max()))
        states = None
        if best is not None:
            solution, before = best
            shared = {name: solution.guesses[name] for name in shared}
            states = before.states_at(solution.values, begins)
        model = WindowedModel(data, laws, shared, begins, origin)
        try:
            trial = model.solved(model.guesses(states))
        except ConvergenceError:
            if best is None:
                raise
            lost = len(begins)
            break
        left_out = float(np.mean(~trial.kept))
        if best is not None and (
            trial.scatter > _GROWTH * best[0].scatter
            or left_out > max(MOST_OUTLIERS, 1.5 * float(np.mean(~best[0].kept)))
        ):
            break
        best = trial, model
    assert best is not None
    return *best, lost


def _by_pivots(found: Described) -> tuple[dict[str, float], list[Floats], int]:
    """Return the standard deviations that the uncertainty of the pivot's motion alone makes.

    The second are the changes of the fitted angles [rad], the third is how many fits of them did
    not converge, and are left out.
    """
    names, data, solution, model = found.names, found.data, found.solution, found.model
    squares = dict.fromkeys(names, 0.0)
    bent: list[Floats] = []
    lost = 0
    begins = np.array([window.begin for window in model.windows])
    shared = {name: solution.guesses[name] for name in model.shared}
    for laws, weight in found.others:
        moved = WindowedModel(data, laws, shared, begins, model.origin)
        try:
            trial = moved.solved(solution.guesses, like=solution)
        except ConvergenceError:
            lost += 1
            continue
        for name in names:
            squares[name] += weight * (trial.values[name] - solution.values[name]) ** 2
        bent.append(trial.curve - solution.curve)
    return {name: math.sqrt(square) for name, square in squares.items()}, bent, lost


def doubt_of(found: Described, bent: Sequence[Floats]) -> Adequacy:
    """Return whether the model describes the record, with what other pivots bend it by [rad].

    A motion in several pieces, each with its own start, may change at any of these: only its
    scatter is judged.
    """
    data, solution, model = found.data, found.solution, found.model
    few = pivot_doubt(solution) or _prior_doubt(found) or misfit_doubt(solution, data)
    if few is None and len(model.windows) == 1 and model.angles == 1:
        whole = replace(solution, slopes=np.column_stack([solution.slopes, *bent]))
        place = place_of_change(data, whole, SHORTEST * found.period)
        if place is not None:
            at = float(data.times[place])
            return Adequacy(said("changed_model", time=at), "change", at)
    return few or Adequacy()


def _prior_doubt(found: Described) -> Adequacy | None:
    """Return the doubt in a fit whose samples contradict a prior, None without."""
    for name, times in found.solution.contradicted.items():
        if name in found.names:
            own = replace(found.solution.own[name], unit=quantity_of(name).unit)
            doubt = said("contradicted_prior", name=name, value=str(own), times=abs(times))
            return Adequacy(doubt, "prior", is_in_record=False)
    return None


def _verdict(
    estimates: Mapping[str, Estimate],
    solution: Solution,
    model: WindowedModel,
    lost: int,
    unknown: int,
) -> Sentence:
    """Return the result in plain words, and which fits did not converge."""
    values = joined([named(*each) for each in estimates.items()], ", ")
    count, scatter = len(model.windows), 1e3 * solution.scatter
    words = [
        said("model_gives", values=values),
        said("one_piece" if count == 1 else "pieces", count=count, scatter=scatter),
    ]
    if lost:
        words.append(said("lost_one_piece" if lost == 1 else "lost_pieces", count=lost))
    if unknown:
        words.append(said("lost_pivots", count=unknown))
    if solution.outliers:
        words.append(said("outliers", count=solution.outliers))
    return joined(words)
