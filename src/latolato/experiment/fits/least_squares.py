"""Least squares with residuals that may be correlated in time: what all fits share.

A first fit shows how residuals of neighbouring samples go together; with that correlation
residuals are whitened (generalised least squares, first-order autoregression in continuous time,
so that gaps and variable frame rates are right) and fitted again. What correlation is left is
allowed for by the prewhitened estimator of Andrews & Monahan (1992), which may only widen. Errors
that all samples share do not show as scatter, so parameters may have priors.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError, import_extra
from latolato.experiment.fits.result import Estimate, quantity_of
from latolato.experiment.rules import broken, listed, said

Floats = NDArray[np.float64]
Model = Callable[[Mapping[str, float]], Floats]
# Gives the derivatives of a model for some of its parameters.
Jacobian = Callable[[Mapping[str, float], Sequence[str]], Floats]

# Residuals beyond this many robust standard deviations are taken for mistakes of the tracker.
OUTLIER = 6.0
# Correlations up to this size are kept; beyond, a series is a random walk.
MOST_CORRELATION = 0.99
# Standard deviations of a prior within which a value is believed.
FAR = 3.0
# Information of the samples over that of a prior which rounding and linearity leave meaningful.
_HARDLY = 1e-8
# Information on a combination of parameters, over that on the best known one, which may be
# rounding, and the share of such a combination from which a parameter takes part in it.
_ROUNDING, _TAKES_PART = 1e-12, 0.1
# Parameters that messages name.
_LISTED = 4
_ROUNDS = 2
# Trials after which a fit gives up, unless its caller can only spare fewer.
MOST_TRIALS = 400


class ConvergenceError(InputError):
    """The samples do not determine the parameters of a fit, or its search does not converge."""


@dataclass(frozen=True)
class Data:
    """Samples of one or several series, one after the other.

    Attributes
    ----------
    times : ndarray, shape (sample,)
        Instants [s], increasing within a series.
    values, sigmas : ndarray, shape (sample,)
        What was measured and its relative uncertainty; equal ones where none is known.
    series : ndarray of int, shape (sample,)
        Which series a sample belongs to; correlation does not reach across.
    """

    times: Floats
    values: Floats
    sigmas: Floats
    series: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.times)

    def __getitem__(self, chosen: Any) -> Data:
        """Return some of the samples."""
        return Data(
            self.times[chosen], self.values[chosen], self.sigmas[chosen], self.series[chosen]
        )


def one_series(times: Floats, values: Floats, sigmas: Floats | None = None) -> Data:
    """Return the samples of a single series, whose number is 1; without sigmas all count alike."""
    sigmas = np.ones(len(times)) if sigmas is None else sigmas
    return Data(times, values, sigmas, np.ones(len(times), dtype=np.int64))


@dataclass(frozen=True)
class Guess:
    """Where a parameter's search starts, and the range that it is kept in.

    `prior` is its standard deviation about `expected` as known without the samples.
    """

    value: float
    low: float = -math.inf
    high: float = math.inf
    prior: float = math.inf
    expected: float = 0.0

    @property
    def surprise(self) -> float:
        """How far the value is from the expected one, in deviations of the prior."""
        return (self.value - self.expected) / self.prior


@dataclass(frozen=True)
class Solution:
    """A least-squares solution.

    Attributes
    ----------
    names : tuple of str
        Parameters, in the order of `covariance`.
    values, guesses : dict
        Their values, and these with their ranges and priors, for another fit.
    covariance : ndarray, shape (parameter, parameter)
        Correlation of residuals allowed for, scaled by their scatter.
    intervals : dict
        95 percent profile intervals of the `profiles` that `solve` took, by name.
    kept : ndarray of bool, shape (sample,)
        What was fitted; False for outliers.
    residuals, curve : ndarray, shape (sample,)
        Measured minus fitted, and fitted.
    correlation : float
        Of residuals one typical sample apart.
    scatter : float
        Root mean square of the residuals.
    chi_square : float
        Reduced, of the whitened residuals over their sigmas.
    effective_samples : float
        Number of independent samples that would determine a mean equally well.
    slopes : ndarray, shape (sample, parameter)
        Derivatives of `curve`.
    origin : float
        Instant of the first sample [s].
    own : dict
        Where the samples alone, without its prior, would put a parameter that has one.
    """

    names: tuple[str, ...]
    values: dict[str, float]
    covariance: Floats
    kept: NDArray[np.bool_]
    residuals: Floats
    curve: Floats
    correlation: float
    scatter: float
    chi_square: float
    effective_samples: float
    log_likelihood: float
    slopes: Floats = field(default_factory=lambda: np.empty((0, 0)), repr=False)
    origin: float = 0.0
    guesses: dict[str, Guess] = field(default_factory=dict, repr=False)
    own: dict[str, Estimate] = field(default_factory=dict, repr=False)
    intervals: dict[str, tuple[float, float]] = field(default_factory=dict)

    def sigma(self, name: str) -> float:
        """Return the standard deviation of a parameter."""
        place = self.names.index(name)
        return math.sqrt(self.covariance[place, place])

    def estimate(self, name: str, unit: str | None = None) -> Estimate:
        """Return a parameter with its deviation and its interval, the profile's if there is one.

        Its unit is by default that of the quantity of this name.
        """
        unit = quantity_of(name).unit if unit is None else unit
        interval = self.intervals.get(name, (math.nan, math.nan))
        return Estimate(self.values[name], self.sigma(name), unit, *interval)

    def covariance_of(self, numbers: Callable[[Mapping[str, float]], Floats]) -> Floats:
        """Return the covariance of numbers that follow from the parameters, to first order."""
        columns, middle = [], numbers(self.values)
        for name in self.names:
            step = max(0.1 * self.sigma(name), 1e-9)
            moved = numbers({**self.values, name: self.values[name] + step})
            columns.append((moved - middle) / step)
        slopes = np.column_stack(columns)
        result: Floats = slopes @ self.covariance @ slopes.T
        return result

    @property
    def prior_misfit(self) -> float:
        """Sum of the squares of how far parameters are from their priors, in deviations."""
        return sum(guess.surprise**2 for guess in self.guesses.values())

    @property
    def contradicted(self) -> dict[str, float]:
        """Priors more than three deviations off what the samples alone say, in deviations.

        A tight prior keeps a parameter near its expected value whatever the samples say: only
        without it do they show that they disagree.
        """
        off = {
            name: (own.value - self.guesses[name].expected)
            / math.hypot(own.sigma, self.guesses[name].prior)
            for name, own in self.own.items()
        }
        return {name: size for name, size in off.items() if abs(size) > FAR}

    @property
    def outliers(self) -> int:
        """How many samples were left out."""
        return int((~self.kept).sum())

    def curves(self, data: Data, name: str) -> dict[str, tuple[str, Any]]:
        """Return the samples that were fitted and what was found, as variables of a fit.

        `name` is that of the quantity that was measured.
        """
        return {
            "time": ("sample", data.times),
            name: ("sample", data.values),
            f"{name}_fit": ("sample", self.curve),
            f"{name}_residual": ("sample", self.residuals),
            "is_outlier": ("sample", ~self.kept),
        }

    @property
    def quality(self) -> dict[str, Any]:
        """How good it is, by its residuals: attributes of a fit."""
        return {
            "scatter": self.scatter,
            "autocorrelation": self.correlation,
            "effective_samples": self.effective_samples,
            "outliers": self.outliers,
        }

    @property
    def bayes(self) -> float:
        """Schwarz's criterion (BIC), with the number of effective samples."""
        return len(self.names) * math.log(self.effective_samples) - 2.0 * self.log_likelihood


def lmfit_module() -> Any:
    """Return lmfit."""
    return import_extra("lmfit", "video", "a fit")


def solve(
    model: Model,
    guesses: Mapping[str, Guess],
    data: Data,
    *,
    profiles: Sequence[str] = (),
    like: Solution | None = None,
    jacobian: Jacobian | None = None,
    limit: int = MOST_TRIALS,
) -> Solution:
    """Return the least-squares solution.

    Parameters
    ----------
    model : callable
        Returns the fitted values, shape (sample,), for parameters by name.
    guesses : mapping of str to Guess
        The parameters.
    data : Data
        What was measured.
    profiles : sequence of str
        Parameters whose 95 percent interval is profiled (``lmfit.conf_interval``).
    like : Solution, optional
        Whose samples, correlation and spread of residuals are taken; by default the samples are
        all but outliers of the first fit, and the others are found from the residuals.
    jacobian : callable, optional
        Derivatives of the model, shape (sample, name); by default central differences.
    limit : int
        Number of trials after which a fit gives up, without those for derivatives.

    Raises
    ------
    InputError
        If there are fewer samples than twice the parameters without a prior.
    ConvergenceError
        If the search does not converge.
    """
    names = tuple(guesses)
    # What is believed beforehand needs no samples: a prior is one more of them.
    loose = sum(math.isinf(guess.prior) for guess in guesses.values())
    if len(data) < 2 * loose:
        told = {"count": len(data), "names": some_of(names), "least": 2 * loose}
        raise broken("few_samples", told)
    parameters = lmfit_module().Parameters()
    for name, guess in guesses.items():
        parameters.add(name, guess.value, min=guess.low, max=guess.high)
    jacobian = jacobian or partial(_differences, model)
    mask = np.ones(len(data), dtype=bool) if like is None else like.kept
    rho = 0.0 if like is None else like.correlation
    # Priors are absolute, residuals over sigmas have a spread: at first as the sigmas say.
    spread = 1.0 if like is None else like.chi_square
    residuals = data.values
    # Without a solution to be like: all samples, those that are no outliers, then whitened ones.
    for turn in range(1 if like is not None else _ROUNDS + 2):
        if turn == 1:
            cleaned = _without_outliers(residuals / data.sigmas)
            if cleaned.sum() < 2 * loose:
                counts = {"count": int(cleaned.sum()), "total": len(data)}
                told = {"names": some_of(names), **counts}
                raise broken("follows_few", told, kind=ConvergenceError)
            if np.array_equal(cleaned, mask):
                continue
            mask = cleaned
        elif turn > 1:
            rho = correlation_of(data[mask], (residuals / data.sigmas)[mask])
            spread = _spread(whitened(data, mask, rho)(residuals / data.sigmas), loose)
        white = whitened(data, mask, rho)
        minimizer = _minimizer(model, jacobian, parameters, data, white, guesses, spread)
        result = _minimized(minimizer, limit)
        parameters = result.params
        values = parameters.valuesdict()
        residuals = data.values - model(values)
    slopes = jacobian(values, names)
    errors = white(residuals / data.sigmas)
    spread = _spread(errors, loose)
    covariance, widening = _covariance(
        names, white(slopes / data.sigmas[:, None]), errors, spread, _beliefs(guesses, spread) ** 2
    )
    count = len(errors)
    solution = Solution(
        names=names,
        values=dict(values),
        covariance=covariance,
        kept=mask,
        residuals=residuals,
        curve=data.values - residuals,
        correlation=rho,
        scatter=float(np.sqrt(np.mean(residuals[mask] ** 2))),
        chi_square=spread,
        effective_samples=max(count * (1.0 - rho) / (1.0 + rho), len(names) + 2.0),
        log_likelihood=-0.5 * count * math.log(max(float(errors @ errors) / count, 1e-300)),
        slopes=slopes,
        origin=float(data.times[0]),
        guesses={name: replace(guess, value=values[name]) for name, guess in guesses.items()},
    )
    solution.own.update(_without_priors(solution, widening))
    if profiles:
        solution.intervals.update(_profiles(minimizer, result, solution, widening, profiles))
    return solution


def _without_priors(solution: Solution, widening: Floats) -> dict[str, Estimate]:
    """Return what the samples alone say about each parameter with a prior, to first order.

    Information adds up: that of the samples is 1/sigma^2 - 1/prior^2, and the solution lies
    between both estimates as their shares of it. What samples hardly determine is left out.
    """
    result = {}
    for name, wider in zip(solution.names, widening, strict=True):
        guess = solution.guesses[name]
        if math.isinf(guess.prior):
            continue
        known = (guess.prior / (solution.sigma(name) / float(wider))) ** 2 - 1.0
        if known > _HARDLY:
            value = guess.expected + (guess.value - guess.expected) * (1.0 + 1.0 / known)
            result[name] = Estimate(value, guess.prior * float(wider) / math.sqrt(known), "")
    return result


def _spread(errors: Floats, loose: int) -> float:
    """Return the reduced sum of squares."""
    return float(errors @ errors) / max(len(errors) - loose, 1)


def _beliefs(guesses: Mapping[str, Guess], spread: float) -> Floats:
    """Return by what each parameter is multiplied to be a further residual, 0 without a prior."""
    return np.array([math.sqrt(max(spread, 1e-300)) / guess.prior for guess in guesses.values()])


def _minimizer(
    model: Model,
    jacobian: Jacobian,
    parameters: Any,
    data: Data,
    white: Callable[[Floats], Floats],
    guesses: Mapping[str, Guess],
    spread: float,
) -> Any:
    """Return lmfit's minimizer of the whitened residuals, and of what is known beforehand."""
    beliefs = _beliefs(guesses, spread)
    expected = np.array([guess.expected for guess in guesses.values()])
    known = beliefs > 0.0

    def errors(trial: Any) -> Floats:
        values = trial.valuesdict()
        beyond = beliefs * (np.array(list(values.values())) - expected)
        return np.append(white((data.values - model(values)) / data.sigmas), beyond[known])

    def slopes(trial: Any) -> Floats:
        # A profile holds one of the parameters.
        vary = np.array([parameter.vary for parameter in trial.values()])
        names = [name for name in trial if trial[name].vary]
        derivatives = white(-jacobian(trial.valuesdict(), names) / data.sigmas[:, None])
        return np.vstack([derivatives, np.diag(beliefs)[known][:, vary]])

    return lmfit_module().Minimizer(
        errors, parameters, nan_policy="raise", calc_covar=True,
        xtol=1e-7, ftol=1e-9, Dfun=slopes,
    )  # fmt: skip


def some_of(names: Sequence[str]) -> str:
    """Return names in words: the first of them, and how many others there are."""
    if len(names) <= _LISTED + 1:
        return listed(names)
    return listed([*names[:_LISTED], said("others", count=len(names) - _LISTED)])


def _minimized(minimizer: Any, limit: int) -> Any:
    """The result of lmfit, refused if it did not converge."""
    names = some_of(list(minimizer.params))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            result = minimizer.minimize(method="leastsq", max_nfev=limit)
        except ValueError as error:  # a trial that the model refuses, or has no value for
            raise broken("left_range", {"names": names}, kind=ConvergenceError) from error
    # lmfit's own words of such an end are about tolerances, which is misleading.
    if result.aborted or not result.success:
        values = {"names": names, "count": result.nfev}
        raise broken("many_trials", values, kind=ConvergenceError)
    return result


def whitened(data: Data, mask: NDArray[np.bool_], rho: float) -> Callable[[Floats], Floats]:
    """A filter that makes residuals independent whose neighbours have the correlation `rho`.

    ``e_i = (r_i - f r_(i-1))/sqrt(1 - f^2)`` with ``f = rho^((t_i - t_(i-1))/spacing)``; the first
    of a series is itself. Residuals may have further axes after that of the samples.
    """
    if rho <= 0.0 or mask.sum() < 2:
        return lambda residuals: residuals[mask]
    late, inside = links_of(data[mask])
    factor = np.where(inside, rho**late, 0.0)
    scale = np.sqrt(1.0 - factor**2)

    def white(residuals: Floats) -> Floats:
        kept = residuals[mask]
        out = kept.copy()
        out[1:] = ((kept[1:].T - factor * kept[:-1].T) / scale).T
        return out

    return white


def links_of(data: Data) -> tuple[Floats, NDArray[np.bool_]]:
    """Return how late samples follow the one before, over the typical time, and if in a series."""
    inside, steps = data.series[1:] == data.series[:-1], np.diff(data.times)
    typical = float(np.median(steps[inside])) if inside.any() else 1.0
    return np.maximum(steps, 0.0) / typical, inside


def correlation_of(data: Data, errors: Floats) -> float:
    """Return the correlation of errors one typical sample apart, none for a negative one."""
    late, inside = links_of(data)
    near = inside & (late < 1.6)
    if near.sum() < 8:
        return 0.0
    a, b = errors[1:][near], errors[:-1][near]
    size = math.sqrt(float(a @ a) * float(b @ b))
    rho = float(a @ b) / size if size > 0.0 else 0.0
    # Chance alone gives about one over the root of the number.
    if rho < 2.0 / math.sqrt(near.sum()):
        return 0.0
    # Residuals of a fit look less correlated than the noise was (Kendall 1954).
    return min(rho + (1.0 + 3.0 * rho) / int(near.sum()), MOST_CORRELATION)


def _without_outliers(errors: Floats) -> NDArray[np.bool_]:
    """Return which errors are within six robust standard deviations."""
    from scipy.stats import median_abs_deviation

    scale = float(median_abs_deviation(errors, scale="normal"))
    kept: NDArray[np.bool_] = np.abs(errors) <= max(OUTLIER * scale, 1e-300)
    return kept


def _differences(model: Model, values: Mapping[str, float], names: Sequence[str]) -> Floats:
    """Return central differences of the model, shape (sample, name)."""
    columns = []
    for name in names:
        step = 1e-5 * max(abs(values[name]), 1e-3)
        ends = []
        for sign in (1.0, -1.0):
            try:
                ends.append((sign, model({**values, name: values[name] + sign * step})))
            except InputError:  # beyond the range of the parameter
                ends.append((0.0, model(values)))
        (up, above), (down, below) = ends
        columns.append((above - below) / ((up - down) * step))
    return np.column_stack(columns)


def _covariance(
    names: Sequence[str], scores: Floats, errors: Floats, spread: float, stiffness: Floats
) -> tuple[Floats, Floats]:
    """Return the covariance of the parameters and by how much correlation left widens each.

    `stiffness` is what priors add to the diagonal of the normal matrix.

    Raises
    ------
    ConvergenceError
        If the samples determine a combination of parameters no better than rounding does, so that
        where the search ended says nothing.
    """
    scale = np.sqrt(np.sum(scores**2, axis=0) + stiffness)
    scale[scale == 0.0] = 1.0
    unit = scores / scale
    prior = np.diag(stiffness / scale**2)
    sizes, directions = np.linalg.eigh(unit.T @ unit + prior)
    if sizes[0] < _ROUNDING * sizes[-1]:
        open_ones = [
            name
            for name, share in zip(names, directions[:, 0], strict=True)
            if abs(share) > _TAKES_PART
        ]
        rule = "not_told_apart" if len(open_ones) > 1 else "does_not_depend"
        raise broken(rule, {"names": listed(open_ones)}, kind=ConvergenceError)
    inverse = (directions / sizes) @ directions.T
    plain = spread * inverse
    moments = unit * errors[:, None]
    count = len(errors)
    lags = int(1.3 * count ** (1.0 / 3.0))
    middle = moments.T @ moments + spread * prior
    for lag in range(1, min(lags, count - 1) + 1):
        part = moments[lag:].T @ moments[:-lag]
        middle += (1.0 - lag / (lags + 1.0)) * (part + part.T)
    robust = inverse @ middle @ inverse
    widening = np.sqrt(np.maximum(1.0, np.diag(robust) / np.maximum(np.diag(plain), 1e-300)))
    covariance = plain * np.outer(widening, widening) / np.outer(scale, scale)
    return covariance, widening


def _profiles(
    minimizer: Any, result: Any, solution: Solution, widening: Floats, names: Sequence[str]
) -> dict[str, tuple[float, float]]:
    """Return 95 percent profile intervals, none where a profile does not end."""
    lmfit = lmfit_module()
    # lmfit refuses without its own estimate, which a parameter at its bound has not.
    if any(result.params[name].stderr is None for name in solution.names):
        return {}
    intervals: dict[str, tuple[float, float]] = {}
    for name in names:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                interval = lmfit.conf_interval(minimizer, result, p_names=[name], sigmas=[0.95])[
                    name
                ]
        except (ValueError, lmfit.MinimizerException):
            continue
        (_, low), (_, best), (_, high) = interval
        wider = float(widening[solution.names.index(name)])
        if math.isfinite(low) and math.isfinite(high):
            intervals[name] = (best - wider * (best - low), best + wider * (high - best))
    return intervals
