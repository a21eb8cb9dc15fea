"""Swings of a noisy angle: crossings, turning points, the instant of release, and the envelope."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from latolato.experiment.fits.least_squares import Floats, Guess, Solution, one_series, solve
from latolato.experiment.fits.samples import noise_of
from latolato.experiment.fits.sight import Sight, drop_of
from latolato.experiment.quality import fitted_harmonic
from latolato.experiment.rules import broken

# A swing must pass zero by so many times the noise, and this share of the largest, to count.
_CLEAR = 6.0
_SHARE = 0.02
# A ball that stays near its largest angle longer than this many periods is being held.
_HELD = 0.4


# Samples in a swing below which its turning points and a hand that holds the ball are not seen.
SPARSE = 12
# Share of neighbours on other sides of the middle, and how smoothly their sizes change, if samples
# are turning points.
_ALTERNATE, _SMOOTH = 0.95, 0.2
# The longest time without a sample in a half swing, which is pi.
_HOLE = 1.2
# The least share of a multiple that is fitted, and the widest swing that has a period [rad].
_SHARE_SEEN, _WIDEST = 1e-4, 3.1
# What a sine may leave of a swing, as a share of its scatter.
_SINE = 0.7
# Amplitudes at which the action of a swing is tabulated.
_GRID = 4096


@dataclass(frozen=True)
class Swings:
    """Turning points of a decaying swing.

    Attributes
    ----------
    times, angles, sigmas : ndarray, shape (swing,)
        Instants [s], signed angles and their standard deviations [rad].
    halves : ndarray, shape (swing,)
        Half periods [s].
    """

    times: Floats
    angles: Floats
    sigmas: Floats
    halves: Floats


def crossings(times: Floats, values: Floats) -> Floats:
    """Return the instants at which a noisy oscillation crosses zero, each once [s]."""
    threshold = max(_CLEAR * noise_of(values), _SHARE * float(np.max(np.abs(values))))
    clear = np.flatnonzero(np.abs(values) > threshold)
    signs = np.sign(values[clear])
    instants = []
    for k in np.flatnonzero(signs[1:] != signs[:-1]):
        first, last = clear[k], clear[k + 1]
        # A line through everything between both clear sides is steadier than two samples.
        t, v = times[first : last + 1], values[first : last + 1]
        if len(t) > 2:
            slope, height = np.polyfit(t - t[0], v, 1)
            at = t[0] - height / slope if slope != 0.0 else 0.5 * (t[0] + t[-1])
            at = min(max(at, t[0]), t[-1])
        else:
            at = t[0] - v[0] * (t[1] - t[0]) / (v[1] - v[0])
        instants.append(float(at))
    return np.array(instants)


def swings_of(times: Floats, angles: Floats) -> Swings:
    """Return the turning points between crossings, each from a fit of its half swing.

    Between two crossings the swing is ``a cos(W s) + b sin(W s) + c cos(3 W s)`` of the time s
    from their middle, W being pi over the half period; its turning angle is ``a + c`` to the
    square of b/a. Large swings have more odd multiples of W. A half swing with a gap is left out.
    """
    orders = _multiples(float(np.quantile(np.abs(angles), 0.99)))
    zeros = crossings(times, angles)
    rows = []
    for begin, end in pairwise(zeros):
        inside = (times > begin) & (times < end)
        if inside.sum() < 5:
            continue
        half = end - begin
        rate, middle = math.pi / half, 0.5 * (begin + end)
        s = rate * (times[inside] - middle)
        if np.max(np.diff(s, prepend=-0.5 * math.pi, append=0.5 * math.pi)) > _HOLE:
            continue
        own = np.array(orders[: len(s) // 3])
        design = np.column_stack([np.sin(s), np.cos(np.outer(s, own))])
        coefficients, *_ = np.linalg.lstsq(design, angles[inside], rcond=None)
        error = angles[inside] - design @ coefficients
        freedom = max(len(s) - design.shape[1], 1)
        inverse = np.linalg.pinv(design.T @ design)
        weights = np.append(0.0, np.ones(len(own)))
        spread = float(error @ error) / freedom
        # Where the slope is 0: by so much after the middle.
        late = float(coefficients[0] / (coefficients[1:] @ own**2))
        if not abs(late) < 1.0:
            continue
        top = float(weights @ coefficients) + 0.5 * late * float(coefficients[0])
        shape = math.sqrt(float(weights @ inverse @ weights))
        rows.append((middle + late / rate, top, shape, half, spread))
    if not rows:
        raise broken("no_crossings")
    tops, angles_there, shapes, halves, spreads = np.array(rows).T
    # One scatter for all: that of a single half swing is too uncertain to weigh it by.
    return Swings(tops, angles_there, shapes * math.sqrt(float(np.median(spreads))), halves)


def _multiples(amplitude: float) -> list[int]:
    """Return the odd multiples of its frequency that a pendulum's swing has.

    Their shares are q^((n-1)/2)/n, q being the nome (DLMF 22.11).
    """
    from scipy.special import ellipk

    m = math.sin(0.5 * min(amplitude, _WIDEST)) ** 2
    q = math.exp(-math.pi * float(ellipk(1.0 - m)) / float(ellipk(m))) if m > 0.0 else 0.0
    return [1, 3, *(n for n in range(5, 18, 2) if q ** (0.5 * (n - 1)) / n > _SHARE_SEEN)]


def samples_per_swing(times: Floats, values: Floats) -> float:
    """Return how many samples there are in a swing, infinity where no sine is seen."""
    pause = float(np.median(np.diff(times)))
    few = slice(0, 12 * SPARSE)
    centred = values[few] - np.median(values[few])
    rate, _, rest = fitted_harmonic(times[few] - times[0], centred)
    return math.tau / rate / pause if rest < _SINE * float(np.std(centred)) else math.inf


def are_turning_points(centred: Floats) -> bool:
    """Return whether samples lie right and left of the middle by turns, with steady sizes."""
    signs = np.sign(centred)
    if not np.mean(signs[1:] != signs[:-1]) > _ALTERNATE:
        return False
    sizes = np.log(np.maximum(np.abs(centred), 1e-300))
    return bool(np.median(np.abs(np.diff(sizes, 2))) < _SMOOTH)


def swings_of_turning_points(times: Floats, angles: Floats) -> Swings:
    """Return the swings of samples that are turning points themselves."""
    ones = np.full(len(times), max(noise_of(np.abs(angles - np.median(angles))), 1e-9))
    halves = np.gradient(times)
    return Swings(times, angles, ones, halves)


def free_start(times: Floats, angles: Floats) -> float:
    """Return the instant from which a ball swings freely [s]: after the hand that held it let go.

    A ball that stays near its largest angle longer than a swing would is being held; the motion is
    used from the next zero crossing after that, clear of the release.
    """
    zeros = crossings(times, angles)
    if np.ptp(angles) == 0.0:
        raise broken("constant_angle")
    if len(zeros) < 3:
        raise broken("few_crossings")
    period = 2.0 * float(np.median(np.diff(zeros)))
    largest = float(np.max(np.abs(angles)))
    first = int(np.argmax(np.abs(angles) >= 0.95 * largest))
    away = np.flatnonzero(np.abs(angles[first:]) < 0.9 * largest)
    left = first + int(away[0]) if away.size else len(angles) - 1
    # A ball that has passed the middle before was swinging, and grows.
    swung = np.count_nonzero(zeros < times[first]) > 2
    if swung or times[left] - times[0] < _HELD * period:
        return float(times[0])
    later = zeros[zeros > times[left]]
    if len(later) < 3:
        raise broken("held_ball")
    return float(later[0])


def period_factor(amplitude: float) -> float:
    """Return the period of a pendulum over that of small swings, 2 K(sin(amplitude/2))/pi."""
    from scipy.special import ellipk

    return float(ellipk(math.sin(0.5 * min(abs(amplitude), _WIDEST)) ** 2)) * 2.0 / math.pi


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
    nuisances: Mapping[str, Guess],
    profiles: tuple[str, ...],
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
    nuisances : mapping of str to Guess
        The pivot's misplacement (`latolato.experiment.fits.sight`).
    profiles : tuple of str
        Parameters whose 95 percent interval is profiled.

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
        **nuisances,
    }

    def model(p: Mapping[str, float]) -> Floats:
        effective = p["effective"] * np.exp(-p["decay_rate"] * times)
        return sight.seen(signs * amplitude_of(effective), p)

    data = one_series(swings.times, swings.angles, sigmas)
    return solve(model, guesses, data, profiles=profiles)
