"""Statistics of trials: classes, sets, turning points, the largest of noisy angles, agreement."""

from __future__ import annotations

import math
from statistics import NormalDist
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.experiment.calibration.parabola import parabola_top
from latolato.observables.angles import MotionClass

Floats = NDArray[np.float64]

# Angles nearer to the limit of a class than so many standard deviations are borderline.
BORDERLINE = 3.0
# Amplitudes of one set differ by less than this share, or by so many standard deviations.
_SAME, _SAME_SIGMAS = 0.04, 4.0
# A turning point stands out by so many standard deviations, and by this share of the largest.
_CLEAR, _SHARE = 6.0, 0.05


def class_limits() -> tuple[float, float]:
    """Return the angles of weak and of strong motion, those of the sweeps [rad]."""
    law = MotionClass()
    return law.weak_angle, law.strong_angle


def class_of(largest: Any, settled: Any) -> Any:
    """Return the class as sweeps number it: 2 strong, 1 weak, 0 none; element by element.

    Examples
    --------
    >>> class_of([0.2, 1.0, 1.7], [0.1, 0.9, 0.3]).tolist()
    [0, 1, 2]
    """
    weak, strong = class_limits()
    return np.where(np.asarray(largest) >= strong, 2, np.where(np.asarray(settled) >= weak, 1, 0))


def is_borderline(largest: Any, largest_sigma: Any, settled: Any, settled_sigma: Any) -> Any:
    """A mask of the trials whose class could be another one within 3 standard deviations."""
    weak, strong = class_limits()
    largest, settled = np.asarray(largest, dtype=float), np.asarray(settled, dtype=float)
    largest_width, settled_width = (
        BORDERLINE * np.nan_to_num(s) for s in (largest_sigma, settled_sigma)
    )
    near_strong = np.abs(largest - strong) <= largest_width
    near_weak = (largest < strong + largest_width) & (np.abs(settled - weak) <= settled_width)
    return near_strong | near_weak


def sets_of(amplitude: Any, sigma: Any = None) -> list[str]:
    """Return the set of each trial: amplitudes in order, parted where they differ clearly.

    Examples
    --------
    >>> sets_of([0.020, 0.0301, 0.0202, 0.030])
    ['set 1', 'set 2', 'set 1', 'set 2']
    """
    amplitude = np.asarray(amplitude, dtype=float)
    sigma = np.zeros_like(amplitude) if sigma is None else np.nan_to_num(sigma)
    order = np.argsort(amplitude, kind="stable")
    sizes, unsure = amplitude[order], sigma[order]
    same = np.maximum(_SAME * sizes[:-1], _SAME_SIGMAS * np.hypot(unsure[:-1], unsure[1:]))
    numbers = np.ones(len(amplitude), dtype=int)
    numbers[order[1:]] += np.cumsum(np.diff(sizes) > same)
    return [f"set {number}" for number in numbers]


def cohen_kappa(one: Any, other: Any) -> float:
    """Return Cohen's kappa of two classifications: 1 if they agree, 0 if by chance only.

    Examples
    --------
    >>> cohen_kappa([0, 0, 1, 1], [0, 0, 1, 1]), cohen_kappa([0, 1, 0, 1], [0, 0, 1, 1])
    (1.0, 0.0)
    """
    one, other = np.asarray(one), np.asarray(other)
    agreed = float(np.mean(one == other))
    chance = float(sum(np.mean(one == k) * np.mean(other == k) for k in range(3)))
    if chance >= 1.0:  # both put all into one class, the same
        return 1.0
    return (agreed - chance) / (1.0 - chance)


def turning_points(
    time: Floats, angle: Floats, sigma: Floats, flag: Any
) -> tuple[Floats, Floats, Floats]:
    """Return when abs(angle) is largest [s], how large, and its standard deviation [rad].

    The parabola through three neighbouring samples; where one is missing, or balls touch, the
    sample itself.
    """
    from scipy.signal import find_peaks

    size = np.abs(angle)
    clear = max(_CLEAR * float(np.median(sigma)), _SHARE * float(size.max()))
    places, _ = find_peaks(size, prominence=clear)
    pause = float(np.median(np.diff(time)))
    when, sizes = time[places].copy(), size[places].copy()
    for i, k in enumerate(places):
        near = slice(k - 1, k + 2)
        if time[k + 1] - time[k - 1] > 3.0 * pause or (flag[near] != "ok").any():
            continue
        when[i], sizes[i] = parabola_top(time[near], size[near])
    return when, sizes, sigma[places]


def largest_of(
    sizes: Floats, errors: Floats, samples: Floats, sigma: Floats, varies: float | None = None
) -> tuple[float, float]:
    """Largest size of an angle without what noise adds to it, and its standard deviation [rad].

    Parameters
    ----------
    sizes, errors : ndarray, shape (turning_point,)
        Sizes of the angle where it turns, and their standard deviations [rad].
    samples, sigma : ndarray, shape (sample,)
        The same of all samples, for a motion that does not turn, or is largest at an end [rad].
    varies : float, optional
        By how much the motion itself varies [rad]; by default what the sizes show beyond noise.
    """
    largest = float(np.max(sizes, initial=0.0))
    if largest < float(np.max(samples)) - 3.0 * float(np.max(sigma)):
        # It lies at an end of the record, or nothing turns.
        k = int(np.argmax(samples))
        return float(samples[k]), float(sigma[k])
    if not len(sizes):
        n = len(samples)
        noise = float(np.median(sigma))
        raised = _expected_largest(n) * noise
        top = max(float(np.max(samples)) - raised, float(np.median(samples)))
        return top, math.hypot(noise, 0.5 * raised)
    # Only those about as large take part in what is the largest.
    near = sizes > 0.8 * largest
    n, noise = int(near.sum()), float(np.median(errors[near]))
    spread = float(np.std(sizes[near])) if n > 2 else noise
    motion = math.sqrt(max(spread**2 - noise**2, 0.0))
    raised = _expected_largest(n) * (math.hypot(motion, noise) - motion)
    total = math.hypot(motion if varies is None else varies, noise)
    return largest - raised, math.hypot(total / math.sqrt(1.0 + 0.8 * math.log(n)), 0.5 * raised)


def _expected_largest(count: int) -> float:
    """Return the expected largest of standard normal numbers (Blom, 1958)."""
    return NormalDist().inv_cdf((count - 0.375) / (count + 0.25)) if count > 1 else 0.0
