"""The direction of gravity in a picture, and the error that all angles share because of it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from latolato.experiment.calibration.hinge import CLICK, NARROW_ARC, UNROUND, WIDE_ARC, Hinge

# Stroke of the pivot from which its axis is taken as vertical [pixels].
STROKE = 6.0
# Lean from which a motion of the pivot is no drive [rad].
_LEAN = math.radians(40.0)
# Parts of the pivot's axis that are compared.
_PARTS = 8
# Standard deviation of straight down in the picture of a camera that was levelled by eye [rad].
LEVELLED = math.radians(5.0)
# Swings that are fitted, and fewest samples of them.
_SWINGS, _FEWEST = 8, 40
# What a fitted swing may leave over, as a share of the range of angles seen.
_LEFT_OVER = 0.02
# Scatter of the mean of two balls that swing against each other [rad].
_AGAINST = 0.02


@dataclass(frozen=True)
class Gravity:
    """Gravity's direction from straight down in the picture, and its standard deviation [rad].

    The source is ``"drive axis"``, ``"rest position"``, ``"fitted swing"`` or ``"image"``.
    """

    direction: float
    source: str
    sigma: float


@dataclass(frozen=True)
class Extreme:
    """A turning point that was seen from both sides.

    Attributes
    ----------
    number : int
        Which half swing it belongs to; successive ones differ by one.
    time, angle : float
        Where it is [s, rad].
    """

    number: int
    time: float
    angle: float


def find_gravity(
    times: np.ndarray, pivots: np.ndarray, angles: np.ndarray, is_clean: np.ndarray
) -> Gravity:
    """Return gravity's direction from straight down in the image, and where it comes from."""
    ok = np.isfinite(pivots).all(axis=1)
    centred = pivots[ok] - pivots[ok].mean(axis=0)
    _, sizes, axes = np.linalg.svd(centred, full_matrices=False)
    stroke = 2.0 * math.sqrt(2.0) * sizes[0] / math.sqrt(max(len(centred), 1))
    is_upright = abs(float(axes[0][1])) > math.cos(_LEAN)
    if stroke > STROKE and sizes[1] < 0.2 * sizes[0] and is_upright:
        axis = axes[0] * np.sign(axes[0][1])
        direction = float(math.atan2(axis[0], axis[1]))
        return Gravity(direction, "drive axis", _axis_sigma(centred @ axes.T))
    if stroke < 0.25 * STROKE or not is_upright:
        rest = _rest_position(times, np.where(is_clean, angles, np.nan))
        if rest is not None:
            return rest
    return Gravity(0.0, "image", LEVELLED)


def angle_offset_sigma(down: Gravity, hinge: Hinge) -> float:
    """Return the standard deviation of what all angles have in common [rad].

    About the rest position the hinge's place cancels.
    """
    if down.source == "rest position":
        return math.hypot(down.sigma, 0.5 * UNROUND / hinge.arm)
    if not hinge.is_seen:
        beside = hinge.aside
    elif hinge.arc >= WIDE_ARC and math.isfinite(hinge.residual):
        beside = 0.5 * hinge.residual
    elif hinge.arc >= NARROW_ARC:
        beside = 1.0 / math.hypot(1.0 / CLICK, hinge.arc / (2.0 * math.sqrt(2.0) * UNROUND))
    else:
        beside = CLICK
    return math.hypot(down.sigma, beside / hinge.arm)


def _axis_sigma(path: np.ndarray) -> float:
    """Return the standard deviation of the direction of a path (along, aside) [rad].

    Where the pivot passes, the wall draws it aside by as much in every stroke: the means in parts
    of its axis scatter about a straight line, and neighbouring parts alike, which doubles the
    error of the line. A path of fewer than four parts says nothing.
    """
    along, aside = path.T
    part = np.floor((along - along.min()) / (np.ptp(along) + 1e-9) * _PARTS).astype(int)
    count = np.bincount(part, minlength=_PARTS)
    seen = count > 0
    if seen.sum() < 4:
        return LEVELLED
    places = (np.bincount(part, along, _PARTS) / np.maximum(count, 1))[seen]
    means = (np.bincount(part, aside, _PARTS) / np.maximum(count, 1))[seen]
    line = np.polyfit(places, means, 1)
    rest = means - np.polyval(line, places)
    scatter = math.sqrt(float(np.sum(rest**2)) / (len(rest) - 2))
    return 2.0 * scatter / math.sqrt(float(np.sum((places - places.mean()) ** 2)))


def _rest_position(times: np.ndarray, angles: np.ndarray) -> Gravity | None:
    """Return the angle about which balls swing freely; angles that were not seen are NaN.

    Two balls of equal frequency have it in the mean of their angles, which impacts between equal
    balls do not change.
    """
    swings = [swing for swing in angles.T if np.isfinite(swing).any() and np.nanstd(swing) > 0.01]
    if not swings:
        return None
    swing = np.mean(swings, axis=0)
    seen = swing[np.isfinite(swing)]
    if len(seen) < _FEWEST:
        return None
    if len(swings) == 2 and np.std(seen) < _AGAINST:
        return Gravity(float(np.median(seen)), "rest position", float(np.std(seen)))
    extremes = find_extremes(times, swing)
    return _between_extremes(extremes) or _fitted(times, swing, extremes)


def _between_extremes(extremes: list[Extreme]) -> Gravity | None:
    """Return the rest position from three successive extremes each.

    ``(a1 + 2 a2 + a3)/4`` is the rest position up to second order of the decrement, whatever the
    amplitude; which side it errs to alternates.
    """
    angle = {one.number: one.angle for one in extremes}
    middles = np.array(
        [
            0.25 * (angle[k] + 2.0 * angle[k + 1] + angle[k + 2])
            for k in angle
            if k + 1 in angle and k + 2 in angle
        ]
    )
    if len(middles) < 2:
        return None
    rest = float(np.median(0.5 * (middles[1:] + middles[:-1])))
    # Only swings below a right angle all the way have no other rest position beside.
    if max(abs(one.angle - rest) for one in extremes) > 2.0:
        return None
    sigma = float(np.std(middles, ddof=1)) / math.sqrt(len(middles))
    return Gravity(rest, "rest position", sigma)


def _fitted(times: np.ndarray, swing: np.ndarray, extremes: list[Extreme]) -> Gravity | None:
    """Return the rest position of the damped pendulum that runs through what was seen of a swing.

    The drag's law is not known: where linear and quadratic drag fit about as well, what they differ
    by is part of the error.
    """
    pauses = [
        2.0 * (b.time - a.time) / (b.number - a.number)
        for a, b in pairwise(extremes)
        if b.number - a.number <= 2
    ]
    if not pauses:
        return None
    period = float(np.median(pauses))
    # A hand may have held the ball at the first.
    for first in extremes[:2]:
        late = times - first.time
        chosen = (late >= 0.0) & (late <= _SWINGS * period) & np.isfinite(swing)
        if chosen.sum() < _FEWEST:
            continue
        best, other = sorted(
            (
                _swing_fit(late[chosen], swing[chosen], period, drag)
                for drag in ("damping", "quadratic_damping")
            ),
            key=lambda fit: fit[2],
        )
        rest, sigma, left_over = best
        if other[2] < 2.0 * left_over:
            sigma = math.hypot(sigma, other[0] - rest)
        if left_over < _LEFT_OVER * np.ptp(swing[chosen]) and sigma < LEVELLED:
            return Gravity(rest, "fitted swing", sigma)
    return None


def _swing_fit(
    times: np.ndarray, swing: np.ndarray, period: float, drag: str
) -> tuple[float, float, float]:
    """Return rest position, its standard deviation and the root mean square left over [rad]."""
    from scipy.optimize import least_squares

    from latolato.experiment.fits.motion import angles_at, step_of
    from latolato.experiment.fits.swings import period_factor
    from latolato.physics.drives import FixedPivot
    from latolato.physics.pendulum import Pendulum

    frequency = 2.0 * math.pi / period * period_factor(float(swing[0]))

    def pendulum(frequency: float, rate: float) -> Pendulum:
        drags: dict[str, Any] = {drag: rate}
        return Pendulum(length=1.0, mass=1.0, gravity=frequency**2, **drags)

    step = step_of(pendulum(frequency, 0.0), FixedPivot(), 2.0 * frequency)

    def rest(p: np.ndarray) -> np.ndarray:
        system = pendulum(frequency * math.exp(p[1]), p[2])
        start = [p[3] - p[0]], [p[4]]
        path = angles_at(system, FixedPivot(), *start, times, step=step)[0] + p[0]
        return np.where(np.isfinite(path), path - swing, math.pi)

    guess = np.array([0.0, 0.0, 0.02 * frequency, float(swing[0]), 0.0])
    # A drag that is cut off at zero instead would stay there: beyond it nothing depends on it.
    low, high = np.array([-math.inf, -1.0, 0.0, -math.inf, -math.inf]), np.full(5, math.inf)
    high[1] = 1.0
    fit = least_squares(
        rest, guess, bounds=(low, high), loss="soft_l1", f_scale=1e-3, x_scale="jac", max_nfev=60
    )
    over = rest(fit.x)
    left_over = math.sqrt(float(np.mean(over**2)))
    # Neighbouring residuals go together: fewer of them count.
    alike = float(np.clip(np.corrcoef(over[1:], over[:-1])[0, 1], 0.0, 0.99))
    spread = np.linalg.pinv(fit.jac.T @ fit.jac)[0, 0] * (1.0 + alike) / (1.0 - alike)
    return float(fit.x[0]), left_over * math.sqrt(float(spread)), left_over


def find_extremes(times: np.ndarray, swing: np.ndarray) -> list[Extreme]:
    """Return the extremes of a swing, each from a parabola through its top.

    Angles that were not seen are NaN. Where the swing goes on out of sight there is no extreme.
    """
    seen = np.flatnonzero(np.isfinite(swing))
    if len(seen) < 5:
        return []
    middle = float(np.median(swing[seen]))
    pause = 2.5 * float(np.median(np.diff(times)))
    changes = np.flatnonzero(np.diff(np.sign(swing[seen] - middle)) != 0) + 1
    extremes = []
    for number, (begin, end) in enumerate(pairwise([0, *changes, len(seen)])):
        part = seen[begin:end]
        if len(part) < 5:
            continue
        top = int(np.argmax(np.abs(swing[part] - middle)))
        width = max(2, len(part) // 6)
        near = part[max(0, top - width) : top + width + 1]
        late = times[near] - times[part[top]]
        if np.max(np.diff(late)) > pause:
            continue
        scale = max(float(np.max(np.abs(late))), 1e-9)
        bend, slope, height = np.polyfit(late / scale, swing[near], 2)
        at = -0.5 * slope / bend if bend != 0.0 else math.inf
        is_turning = bend * (swing[part[top]] - middle) < 0.0
        # The top lies between samples on both sides, half the width away or more.
        if is_turning and -0.5 * scale >= late[0] and late[-1] >= 0.5 * scale and abs(at) < 0.5:
            height -= 0.25 * slope**2 / bend
            extremes.append(Extreme(number, float(times[part[top]] + at * scale), float(height)))
    return extremes
