"""Draws of a model's unknown parameters given measured angles: their posterior distribution.

Least squares give a value and a standard deviation, which is the whole truth where angles depend on
parameters nearly linearly. Where they do not, as near a restitution of 1 or where a contact may or
may not happen, the probability of parameters given the samples is wanted itself. It is sampled here
with the No-U-Turn sampler (Hoffman & Gelman 2014) of nutpie, which follows the gradient of the
density. That comes from derivatives of the motion which go through its impacts
(`latolato.simulation.sensitivity`). They are exact but for how the engine's numbers change with
each parameter, which is that of the least-squares solution everywhere.

Where the order of contacts changes with a parameter, angles stay continuous but have a kink, and on
it a derivative does not exist. The sampler stays right there. Its steps, a kick along the gradient
and a drift, keep the volume and can be reversed for any force that is a function of the place
alone, and a step is accepted by the density itself. So a wrong or missing gradient costs
acceptance, not truth; `benchmarks/calibration.py` tests it.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError, import_extra
from latolato.core.quantities import Range
from latolato.core.registry import checked_count
from latolato.experiment.fits.least_squares import (
    MOST_CORRELATION,
    Floats,
    Guess,
    links_of,
    whitened,
)
from latolato.experiment.fits.model import Described, described, doubt_of, drive_to_keep
from latolato.experiment.fits.registry import FitKind, fits
from latolato.experiment.fits.result import (
    TWO_SIDED,
    Adequacy,
    Estimate,
    Fit,
    make_fit,
    quantity_of,
)
from latolato.physics.drives import Drive, drives
from latolato.physics.noise import SEEDS
from latolato.physics.pendulum import System, systems

if TYPE_CHECKING:
    import xarray as xr

# Draws of a chain in which the sampler learns the size of its steps; they are not kept.
_LEARNING = 250
# Share of the steps that are accepted. As the density is nearly a standard normal one, longer steps
# than usual (0.8) cost fewer computations for the same independence.
_ACCEPTED = 0.7
# Starts of the chains are so many times wider than the least-squares solution says.
_SPREAD = 1.5
# Chains that differ by more, or have fewer draws that tell something, are not believed (Vehtari
# et al. 2021, who take 1.01, which as many draws as 400 exceed by chance), nor are those of which a
# larger share of the paths broke off.
_LARGEST_RHAT, _FEWEST, _MOST_BROKEN = 1.02, 400, 0.01
# Scatter over the sigmas, squared, below which samples must share errors.
_MUCH_LESS = 0.5
# Draws whose angles make the band.
_BAND = 200
# The noise of the samples: its size over the sigmas, and the correlation of neighbours.
NOISE_SCALE, NOISE_CORRELATION = "noise_scale", "noise_correlation"


def fit_posterior(
    table: xr.Dataset,
    system: System,
    drive: Drive | str | None = None,
    unknown: Sequence[str] | None = None,
    prior: Mapping[str, Any] | None = None,
    *,
    ball: int | None = None,
    start: Annotated[float | None, "s"] = None,
    end: Annotated[float | None, "s"] = None,
    window: Annotated[float | None, "s"] = None,
    draws: Annotated[int, Range(10)] = 1000,
    chains: Annotated[int, Range(2)] = 4,
    seed: int = 0,
) -> Fit:
    """Return draws of a system's unknown parameters given measured angles.

    The model is that of `fit_model`, with the same pivot, windows and outliers. Beside the
    parameters asked for, the start, the place of the pivot, the size of the noise and its
    correlation are unknown as well.

    Parameters
    ----------
    table : xarray.Dataset
        A track table; samples that are not flagged ok are ignored.
    system : Pendulum, LatoLato or BallPair
        What moves; its values are first guesses of what is unknown, and known otherwise.
    drive : Drive or "measured", optional
        How the pivot moves; as for `fit_model`.
    unknown : sequence of str, optional
        Parameters of the system and the drive that are not known, and ``angle_offset``; by default
        `length`, `damping` and, with contacts, `restitution`.
    prior : mapping of str to float, optional
        What is known beforehand: the standard deviation of an unknown parameter about the value
        that the system or the drive has, in SI units: ``{"length": 2e-3}``. Without one, all
        values that the parameter may have are alike.
    ball : int, optional
        Which ball a system of one angle describes; as for `fit_model`.
    start : float, optional
        First instant used [s].
    end : float, optional
        Last instant used [s].
    window : float, optional
        Time after which the motion gets a new start [s]; by default as long as the model follows.
    draws : int
        Number of draws that are kept of each chain.
    chains : int
        Number of chains, which must agree.
    seed : int
        Of the random numbers; the same seed gives the same draws.

    Returns
    -------
    Fit
        Each unknown parameter with the mean, the standard deviation and the central 95 percent of
        its draws. ``fit.draws`` holds these, on chain and draw, for ArviZ; the dataset has R-hat
        and the effective sample size of each (``restitution_rhat``, ``restitution_effective``).

    Raises
    ------
    InputError
        For bad input, as `fit_model`; if the model does not describe the samples, or these
        contradict a prior; if nutpie is missing.
    ConvergenceError
        If least squares do not converge, from which the chains begin.

    Notes
    -----
    The density is the product of that of the samples, normal with a first-order autoregression
    whose scale (over the sigmas of the table) and correlation are unknown, and of the priors: flat
    in the parameters asked for unless given, flat in the start, normal in how the table sees angles
    (`latolato.experiment.fits.sight`), flat in the logarithm of the scale and in the correlation.
    Angles that scatter by less than 0.7 of their sigmas have errors that samples share, which no
    scatter shows: the scale is then 1, and the correlation that of the residuals.
    The drive that was fitted to the pivot's track is unknown as well, with a normal prior by that
    fit. Of a spline ("measured") the uncertainty is taken to first order: each other motion that
    the track allows is a normal factor of the change that it makes.
    """
    sampling_module("nutpie")
    count = checked_count("draws", draws, Range(10))
    paths = checked_count("chains", chains, Range(2))
    seed = checked_count("seed", seed, SEEDS)
    found = described(
        table, system, drive, unknown, ball=ball, start=start, end=end, window=window,
        prior=prior, fits_pivot=True,
    )  # fmt: skip
    density = Density(found)
    doubt = doubt_of(found, list(density.bends.T))
    if not doubt.describes:
        # Paths in the density of a wrong model can take hours, and no draw would be a result.
        advice = "give start and end to fit a part that the model describes"
        raise InputError(
            f"nothing to sample: {doubt.doubt.rstrip('.')}",
            way_out=advice if doubt.is_in_record else None,
        )
    samples, broken = sampled(density, count, paths, seed)
    return _fit_of(found, density, samples, broken)


fits.register("posterior")(
    FitKind(
        function=fit_posterior,
        title="Posterior",
        is_slow=True,
        hint="How sure the length, damping and restitution are: draws of all values that the "
        "samples allow.",
        is_on_page=False,
        is_predicted=True,
    )
)


@dataclass(frozen=True)
class _Scales:
    """How parameters in ranges stand for numbers without bounds.

    ``theta = u`` without a lower end, ``low + exp u`` without an upper one, and
    ``low + (high - low)/(1 + exp -u)`` in any other range; all shapes are (parameter,).
    """

    low: Floats
    high: Floats

    def _of_kind(self, free: Any, half: Any, closed: Any) -> Floats:
        """Return for each parameter what belongs to its kind of range."""
        return np.select([np.isinf(self.low), np.isinf(self.high)], [free, half], closed)

    @property
    def _width(self) -> Floats:
        return np.where(np.isfinite(self.high - self.low), self.high - self.low, 1.0)

    def inside(self, u: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Return parameters, their derivatives, the logs of these, and the derivatives of logs."""
        from scipy.special import expit, log_expit

        size, share, rest = np.exp(np.minimum(u, 700.0)), expit(u), expit(-u)
        logs = np.log(self._width) + log_expit(u) + log_expit(-u)
        return (
            self._of_kind(u, self.low + size, self.low + self._width * share),
            self._of_kind(1.0, size, self._width * share * rest),
            self._of_kind(0.0, u, logs),
            self._of_kind(0.0, 1.0, rest - share),
        )

    def outside(self, values: Floats, sigmas: Floats) -> tuple[Floats, Floats]:
        """Return the numbers without bounds for values, and their deviations.

        A value at a bound is taken half a deviation inside.
        """
        edge = np.minimum(0.5 * sigmas, self._of_kind(math.inf, math.inf, 0.1 * self._width))
        values = np.clip(values, self.low + edge, self.high - edge)
        late = np.where(np.isinf(self.low), 1.0, values - self.low)
        left = np.where(np.isinf(self.high), 1.0, self.high - values)
        u = self._of_kind(values, np.log(late), np.log(late / left))
        return u, self._of_kind(sigmas, *[np.minimum(sigmas / self.inside(u)[1], 1.0)] * 2)


class Density:
    """The logarithm of the posterior density, and its gradient, in numbers without bounds.

    The sampler's numbers `q` are those without bounds relative to the least-squares solution, in
    units of its deviations and along its axes, so that the density is nearly a standard normal one.

    Attributes
    ----------
    names : list of str
        All parameters, in the order of the values that `values` returns.
    """

    def __init__(self, found: Described) -> None:
        solution, model, data = found.solution, found.model, found.data
        self.found, self.moving = found, list(solution.names)
        guesses = dict(solution.guesses)
        bends = []
        begins = np.array([window.begin for window in model.windows])
        for number, (laws, weight) in enumerate(found.others, 1):
            other = type(model)(data, laws, model.shared, begins, model.origin)
            bends.append(math.sqrt(weight) * (other(solution.values) - solution.curve))
            guesses[f"pivot_motion_{number}"] = Guess(0.0, prior=1.0)
        scale, rho = math.sqrt(solution.chi_square), max(solution.correlation, 0.1)
        self.noise = (1.0, solution.correlation) if shares_errors(found) else None
        if self.noise is None:
            guesses[NOISE_SCALE] = Guess(scale, low=0.0)
            guesses[NOISE_CORRELATION] = Guess(rho, 0.0, MOST_CORRELATION)
        else:
            scale = 1.0
        self.bends = np.column_stack(bends) if bends else np.empty((len(data), 0))
        # The information of samples and priors, of which that of the noise is by itself.
        white = whitened(data, solution.kept, solution.correlation)
        slopes = np.column_stack([solution.slopes, self.bends]) / data.sigmas[:, None]
        known = white(slopes) / scale
        self._precision = np.array([guess.prior**-2 for guess in guesses.values()])
        information = np.diag(self._precision)
        size = known.shape[1]
        information[:size, :size] += known.T @ known
        if self.noise is None:
            information[size, size] = 2.0 * solution.effective_samples / scale**2
            information[-1, -1] = len(data) / (1.0 - rho**2)
        self.names = list(guesses)
        low, high, best, self._expected = (
            np.array([getattr(guess, part) for guess in guesses.values()])
            for part in ("low", "high", "value", "expected")
        )
        self._scales = _Scales(low, high)
        self.centre, self.root = _standardised(self._scales, best, information)
        self._kept, self._data = solution.kept, data[solution.kept]
        self._late, self._inside = links_of(self._data)
        # How the engine's numbers change with each parameter. Finding this takes longer than a
        # motion, and over a posterior it changes by the share by which a parameter is uncertain,
        # which makes an error of the gradient only.
        self._directions = model.directions_at(solution.values, self.moving)

    def values(self, q: Floats) -> Floats:
        """Return all parameters for the sampler's numbers."""
        return self._scales.inside(self.centre + self.root @ q)[0]

    def curve(self, values: Floats) -> Floats:
        """Return the angles at the samples for the values of all parameters [rad]."""
        return self.found.model(self._moving(values)) + self.bends @ self._shares(values)

    def noise_of(self, values: Floats) -> tuple[float, float]:
        """Return the size of the noise over the sigmas, and the correlation of neighbours."""
        if self.noise is not None:
            return self.noise
        scale, correlation = values[-2:].tolist()
        return scale, correlation

    def _moving(self, values: Floats) -> dict[str, float]:
        """Return the parameters of the motion and of how it is seen."""
        return dict(zip(self.moving, values.tolist(), strict=False))

    def _shares(self, values: Floats) -> Floats:
        """Return how much there is of each other motion of the pivot."""
        first = len(self.moving)
        return values[first : first + self.bends.shape[1]]

    def __call__(self, q: Floats) -> tuple[float, Floats]:
        """Return the logarithm of the density and its gradient."""
        values, slopes, logs, bends = self._scales.inside(self.centre + self.root @ q)
        nothing = -math.inf, np.zeros(len(q))
        p = self._moving(values)
        try:
            curve, matrix = self.found.model.with_slopes(p, self.moving, self._directions)
        except InputError:  # a law that is none: a radius beyond the length
            return nothing
        data = self._data
        columns = np.column_stack([matrix, self.bends])[self._kept]
        curve = (curve + self.bends @ self._shares(values))[self._kept]
        density, by_errors, by_noise = self._of_errors(
            (data.values - curve) / data.sigmas, *self.noise_of(values)
        )
        beyond = values - self._expected
        density += float(np.sum(logs)) - 0.5 * float(np.sum(self._precision * beyond**2))
        gradient = -self._precision * beyond
        gradient[: columns.shape[1]] -= columns.T @ (by_errors / data.sigmas)
        if self.noise is None:
            gradient[-2:] += by_noise
        whole = self.root.T @ (gradient * slopes + bends)
        if not (math.isfinite(density) and np.isfinite(whole).all()):
            return nothing
        return density, whole

    def _of_errors(
        self, errors: Floats, scale: float, rho: float
    ) -> tuple[float, Floats, tuple[float, float]]:
        """Return the logarithm of the density of errors over their sigmas, and its derivatives.

        The second are those by the errors, the third those by `scale` and `rho`.

        Notes
        -----
        Of neighbours that are linked by ``f_i = rho^(dt_i/spacing)``, the fresh part is
        ``e_i = (r_i - f_i r_(i-1))/sqrt(1 - f_i^2)``, and

            log p = -n log s - sum log(1 - f_i^2)/2 - sum e_i^2/(2 s^2).
        """
        links = np.where(self._inside, rho**self._late, 0.0)
        rest = 1.0 - links**2
        root = np.sqrt(rest)
        fresh = errors.copy()
        fresh[1:] = (errors[1:] - links * errors[:-1]) / root
        power = float(fresh @ fresh) / scale**2
        density = -len(errors) * math.log(scale) - 0.5 * float(np.sum(np.log(rest))) - 0.5 * power
        by_errors = -fresh / scale**2
        by_errors[1:] /= root
        by_errors[:-1] -= links * by_errors[1:]
        by_links = links / rest + fresh[1:] / scale**2 * (
            errors[:-1] / root - links * fresh[1:] / rest
        )
        by_rho = float(np.sum(by_links * self._late * links)) / rho if rho > 0.0 else 0.0
        return density, by_errors, ((power - len(errors)) / scale, by_rho)


def shares_errors(found: Described) -> bool:
    """Return whether angles scatter by so much less than they are uncertain that they share errors.

    The scatter then says nothing of their size. The sigmas of the table stand for all errors.
    """
    return found.has_sigmas and found.solution.chi_square < _MUCH_LESS


def sampling_module(name: str) -> Any:
    """Return a module of nutpie or ArviZ, without the news of its next version."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"\s*ArviZ is undergoing", FutureWarning)
        return import_extra(name, "posterior", "a posterior")


def _standardised(scales: _Scales, best: Floats, information: Floats) -> tuple[Floats, Floats]:
    """Return the solution in numbers without bounds, and a root of their covariance."""
    sizes = np.diag(information) ** -0.5
    centre, widths = scales.outside(best, sizes)
    # In units of what each number would be known to by itself.
    values, vectors = np.linalg.eigh(information * np.outer(sizes, sizes))
    floor = 1e-12 * values.max()  # below that is rounding: numbers that nothing tells apart
    return centre, widths[:, None] * vectors / np.sqrt(np.maximum(values, floor))


def sampled(
    density: Density, draws: int, chains: int, seed: int
) -> tuple[Floats, NDArray[np.bool_]]:
    """Return draws of all parameters, shape (chain, draw, parameter), and which paths broke off."""
    size = len(density.names)

    def start(seed: int) -> Floats:
        random = np.random.default_rng(seed)
        for _ in range(100):
            q = _SPREAD * random.standard_normal(size)
            if math.isfinite(density(q)[0]):
                return q
        return np.zeros(size)

    model = sampling_module("nutpie.compiled_pyfunc").from_pyfunc(
        size,
        lambda: density,
        lambda *_: lambda q: {"values": density.values(q)},
        [np.dtype(np.float64)],
        [(size,)],
        ["values"],
        make_initial_point_fn=start,
    )
    trace = sampling_module("nutpie").sample(
        model, draws=draws, tune=_LEARNING, chains=chains, seed=seed, cores=1,
        progress_bar=False, save_warmup=False, target_accept=_ACCEPTED,
    )  # fmt: skip
    values = np.asarray(trace["posterior"]["values"])
    return values, np.asarray(trace["sample_stats"]["diverging"], dtype=bool)


def _fit_of(found: Described, density: Density, samples: Floats, broken: NDArray[np.bool_]) -> Fit:
    """Return the result that draws of all parameters make."""
    import xarray as xr

    arviz = sampling_module("arviz")
    known = xr.Dataset(
        {name: (("chain", "draw"), samples[..., i]) for i, name in enumerate(density.names)}
    )
    rhat = {name: float(value) for name, value in arviz.rhat(known).items()}
    # Of the others it matters only that their chains agree.
    effective = {name: float(arviz.ess(known[[name]])[name]) for name in found.names}
    estimates = {}
    for name in found.names:
        values = known[name].values
        ends = np.quantile(values, [0.025, 0.975])
        estimates[name] = Estimate(
            float(values.mean()), float(values.std(ddof=1)), quantity_of(name).unit, *ends.tolist()
        )
    flat = samples.reshape(-1, len(density.names))
    middle, width = _band(density, flat)
    data = found.data
    inside = np.abs(data.values - middle) <= TWO_SIDED * width
    share = float(np.mean(inside[found.solution.kept]))
    mean = dict(zip(density.names, flat.mean(axis=0).tolist(), strict=True))
    best, best_drive = found.laws(mean)
    curves = found.curves | {
        "angle_fit": ("sample", middle),
        "angle_residual": ("sample", data.values - middle),
        "band_low": ("sample", middle - TWO_SIDED * width),
        "band_high": ("sample", middle + TWO_SIDED * width),
    }
    about = found.attributes | {
        "system": systems.name_of(best), "drive": drives.name_of(best_drive),
        "chains": samples.shape[0], "draws": samples.shape[1],
        "rhat": max(rhat.values()), "effective_draws": min(effective.values()),
        "divergences": int(broken.sum()), "band_share": share,
        "shares_errors": shares_errors(found),
    }  # fmt: skip
    fit = make_fit(
        "posterior", estimates, _verdict(estimates, about), curves, about,
        drive_to_keep(best_drive), best,
        adequacy=_doubt_of_chains(rhat, effective, broken),
    )  # fmt: skip
    more: dict[str, Any] = {}
    for name in found.names:
        quantity = quantity_of(name)
        words = f"draws of {quantity.long_name}"
        attributes = {**quantity.attributes, "long_name": words}
        more[f"{name}_draw"] = (("chain", "draw"), known[name].values, attributes)
        plain = {"units": "1", "long_name": f"R-hat of {quantity.long_name}"}
        more[f"{name}_rhat"] = ((), rhat[name], plain)
        plain = {"units": "1", "long_name": f"effective draws of {quantity.long_name}"}
        more[f"{name}_effective"] = ((), effective[name], plain)
    others = [i for i, name in enumerate(density.names) if name not in found.names]
    more["nuisance"] = ("nuisance", [density.names[i] for i in others])
    more["nuisance_draw"] = (
        ("chain", "draw", "nuisance"),
        samples[..., others],
        {"long_name": "draws of the parameters that were not asked for, in SI units"},
    )
    return Fit(fit.dataset.assign(more))


def _band(density: Density, flat: Floats) -> tuple[Floats, Floats]:
    """Return mean and standard deviation of what the samples should be by the draws [rad]."""
    some = flat[:: max(1, len(flat) // _BAND)]
    curves = np.array([density.curve(values) for values in some])
    scale = np.mean([density.noise_of(values)[0] ** 2 for values in some])
    noise = density.found.data.sigmas * math.sqrt(float(scale))
    return curves.mean(axis=0), np.sqrt(curves.var(axis=0) + noise**2)


def _doubt_of_chains(
    rhat: Mapping[str, float], effective: Mapping[str, float], broken: NDArray[np.bool_]
) -> Adequacy:
    """Return whether the chains are to be believed."""
    name = max(rhat, key=lambda each: rhat[each])
    if not rhat[name] <= _LARGEST_RHAT:
        return Adequacy(
            f"The chains do not agree: R-hat is {rhat[name]:.3f} for {name}, and should be at "
            f"most {_LARGEST_RHAT}. More draws may help.",
            "chains",
            is_in_record=False,
        )
    name = min(effective, key=lambda each: effective[each])
    if not effective[name] >= _FEWEST:
        return Adequacy(
            f"The draws are too few: those of {name} tell as much as {effective[name]:.0f} "
            f"independent ones, and should as {_FEWEST}. Take more draws.",
            "draws",
            is_in_record=False,
        )
    share = float(broken.mean())
    if share > _MOST_BROKEN:
        return Adequacy(
            f"The sampler lost its way on {100.0 * share:.2g} % of its paths, so there may be "
            "values that it could not reach.",
            "divergences",
            is_in_record=False,
        )
    return Adequacy()


def _verdict(estimates: Mapping[str, Estimate], about: Mapping[str, Any]) -> str:
    """Return the result in plain words."""
    values = ", ".join(f"{quantity_of(n).long_name} {e}" for n, e in estimates.items())
    lost = about["divergences"]
    paths = "no divergence" if not lost else f"{lost} divergence{'s' if lost > 1 else ''}"
    return (
        f"{values[0].upper()}{values[1:]}: mean and standard deviation of {about['chains']} chains "
        f"of {about['draws']} draws, which agree (R-hat {about['rhat']:.3f}, as good as "
        f"{about['effective_draws']:.0f} independent draws, {paths}). The 95 % band of the draws "
        f"holds {100.0 * about['band_share']:.1f} % of the samples{_less(about)}."
    )


def _less(about: Mapping[str, Any]) -> str:
    """Return what is to be said about samples that scatter less than they should, "" of others."""
    if not about["shares_errors"]:
        return ""
    return (
        f", which scatter by {math.sqrt(about['chi_square']):.2g} of their sigmas: the rest is "
        "taken for errors that they share"
    )
