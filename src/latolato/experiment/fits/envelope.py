"""The paper's way to the damping: turning points of a free decay under an exponential (eq13)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache

import numpy as np

from latolato.experiment.fits.least_squares import Floats, Guess, Solution, one_series, solve
from latolato.experiment.fits.sight import Sight, drop_of
from latolato.experiment.fits.swings import Swings
from latolato.experiment.rules import broken

_GRID = 4096


@lru_cache(maxsize=1)
def _actions() -> tuple[Floats, Floats]:
    """Return amplitudes up to pi and the root of their action, scaled to equal small ones."""
    from scipy.special import ellipe, ellipk

    amplitudes = np.linspace(0.0, math.pi - 1e-6, _GRID)
    m = np.sin(0.5 * amplitudes) ** 2
    action = (16.0 / math.pi) * (ellipe(m) - (1.0 - m) * ellipk(m))
    return amplitudes, np.sqrt(np.maximum(action, 0.0))


def effective_amplitude(amplitude: Floats) -> Floats:
    """Return the root of the action of a swing, scaled to be the amplitude of small ones [rad].

    Linear drag shrinks the action of a swing of any size by exp(-2 k t): this decays exactly as
    eq13 has it for small angles.
    """
    amplitudes, roots = _actions()
    return np.interp(amplitude, amplitudes, roots)


def amplitude_of(effective: Floats) -> Floats:
    """Return the inverse of `effective_amplitude`."""
    amplitudes, roots = _actions()
    return np.interp(effective, roots, amplitudes)


def fit_envelope(
    swings: Swings,
    offset: float,
    profiles: tuple[str, ...] = (),
    nuisances: Mapping[str, Guess] | None = None,
) -> Solution:
    """Return the decay of the turning points.

    Paper eq13, ``A exp(-k t)``, with A the `effective_amplitude`, so that it holds for large
    swings too. Parameters: ``effective`` (at the first turning point), ``decay_rate``,
    ``angle_offset`` and nuisances.

    Parameters
    ----------
    swings : Swings
        Turning points.
    offset : float
        First guess of the angle about which it swings [rad].
    profiles : tuple of str
        Parameters whose 95 percent interval is profiled.
    nuisances : mapping of str to Guess, optional
        The pivot's misplacement (`latolato.experiment.fits.sight`).

    Raises
    ------
    InputError
        For fewer than six turning points.
    """
    if len(swings.times) < 6:
        raise broken("few_turning_points", value=len(swings.times))
    times = swings.times - swings.times[0]
    signs = np.sign(swings.angles - offset)
    sigmas = np.maximum(swings.sigmas, 1e-9)
    sizes = effective_amplitude(np.abs(swings.angles - offset))
    slope, height = np.polyfit(times, np.log(np.maximum(sizes, 1e-9)), 1)
    # The largest speed of a swing goes as the sine of half its angle.
    speeds = np.abs(np.sin(0.5 * (swings.angles - offset)))
    sight = Sight(speeds / np.max(speeds), drop_of(swings.angles))
    guesses = {
        "effective": Guess(math.exp(height), 0.0),
        "decay_rate": Guess(max(-slope, 1e-4)),
        "angle_offset": Guess(offset),
        **(nuisances or {}),
    }

    def model(p: Mapping[str, float]) -> Floats:
        effective = p["effective"] * np.exp(-p["decay_rate"] * times)
        return sight.seen(signs * amplitude_of(effective), p)

    data = one_series(swings.times, swings.angles, sigmas)
    return solve(model, guesses, data, profiles=profiles)
