"""How fast a clip plays: gravity and length make a pendulum a clock."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from latolato.experiment.calibration.calibrate import Calibration
    from latolato.experiment.tracking.positions import Positions

# Width of what is averaged, in the time in which the phase of the fastest swing grows by 1.
_WIDTH = 1.0
# Share of angles and speeds that are below those of the fastest swing.
_LARGEST = 0.98
# Fewest averages that tell a pace, and that are a stretch of their own.
_FEWEST, _SHORTEST = 6, 4
# How near its circle a ball is whose string is taut, as a share of the radius.
_TAUT = 0.05
# How much larger than the scatter from frame to frame a swing must be.
_CLEAR = 3.0
# Residuals that count half, in their median.
_OUTLYING = 3.0
# How surely a pace must be known, what it may leave over as a share of the accelerations, and by
# which factor parts of a clip differ.
_SURE, _LEFT_OVER, _OTHER = 0.15, 0.4, 1.25
# Most averages that are compared; what one pace may leave over, as a share of the accelerations;
# what a change of pace must save, in squares of that and of the noise.
_MOST, _ROUGH, _CHANGE = 1500, 0.02, 40.0
# Factor from which a pace does not fit length and gravity: the mass of a rod makes less.
_WRONG = 1.3
# How near a whole number counts as whole.
_WHOLE = 0.07


@dataclass(frozen=True)
class Part:
    """A part of a clip that plays at one pace.

    Attributes
    ----------
    begin, end : float
        First and last instant [s].
    stiffness, sigma : float
        Gravity over length in the clip's time, and its standard deviation [1/s^2].
    """

    begin: float
    end: float
    stiffness: float
    sigma: float


class Motion(NamedTuple):
    """What was seen of balls and pivot.

    `times` (frame,) [s], `angles` (frame, ball) from gravity's direction [rad], `pivots` (frame, 2)
    to the right and up [arms], and which angles `is_free` of contacts and well seen, (frame, ball).
    """

    times: np.ndarray
    angles: np.ndarray
    pivots: np.ndarray
    is_free: np.ndarray

    def between(self, first: int, last: int) -> Motion:
        """The motion from frame `first` up to, but without, frame `last`."""
        return Motion(*(values[first:last] for values in self))


def motion_of(seen: Positions, measured: Calibration) -> Motion:
    """The motion of balls and pivot, free where nothing but rod and air act on a ball."""
    away = np.hypot(*(measured.centres - measured.pivots[:, None]).transpose(2, 0, 1))
    is_free = (seen.flags == "ok") & (np.abs(away / measured.hinge.arm - 1.0) < _TAUT)
    if seen.centres.shape[1] == 2:
        apart = np.hypot(*(seen.centres[:, 0] - seen.centres[:, 1]).T)
        closing = np.abs(np.gradient(apart))
        is_free &= (apart > 2.0 * seen.radius + 1.5 * closing)[:, None]
    turn, pivots = measured.gravity.direction, measured.pivots / measured.hinge.arm
    right = np.array([math.cos(turn), -math.sin(turn)])
    up = np.array([-math.sin(turn), -math.cos(turn)])
    places = np.column_stack([pivots @ right, pivots @ up])
    return Motion(seen.times, measured.angles, places, is_free)


def pace_warnings(motion: Motion, stiffness: float | None, slow_motion: float) -> list[str]:
    """Warnings about the pace at which a clip plays.

    `stiffness` is gravity over length [1/s^2], None where it is unknown, and `slow_motion` what the
    times were divided by.
    """
    parts = parts_of(motion)
    if not parts:
        return []
    values = np.array([part.stiffness for part in parts])
    factors = np.sqrt((stiffness or values.max()) / values)
    ratios = factors / factors.min()
    if ratios.max() > _OTHER:
        if np.max(np.abs(np.rint(ratios) / ratios - 1.0)) > _WHOLE:
            return []
        paces = ", ".join(
            f"{_number(factor * slow_motion)} from {part.begin:.2f} to {part.end:.2f} s"
            for part, factor in zip(parts, factors, strict=True)
        )
        known = "" if stiffness else ", if its fastest part is at normal speed"
        # Times of a part are divided by its own slow motion.
        each = ", ".join(
            f"start {part.begin / factor:.2f} and end {part.end / factor:.2f} s with slow motion "
            f"{_number(factor * slow_motion)}"
            for part, factor in zip(parts, factors, strict=True)
        )
        return [
            f"the clip changes its pace (slow motion {paces}{known}): track its parts "
            f"separately, {each}"
        ]
    longest = int(np.argmax([part.end - part.begin for part in parts]))
    factor, part = float(factors[longest]), parts[longest]
    if not stiffness or max(factor, 1.0 / factor) < _WRONG:
        return []
    how = f"{_number(max(factor, 1.0 / factor))} times too {'slow' if factor > 1.0 else 'fast'}"
    return [
        f"the swing from {part.begin:.2f} to {part.end:.2f} s is {how} for its length and gravity: "
        f"declare a slow motion of {_number(factor * slow_motion)}, or correct the length"
    ]


def _number(factor: float) -> str:
    """Return a factor as text, as a whole number if it is near one."""
    whole = round(factor)
    return str(whole) if abs(factor - whole) < _WHOLE * factor else f"{factor:.2g}"


def parts_of(motion: Motion) -> list[Part]:
    """Return the parts of a clip with different paces; none if the motion does not show them.

    Notes
    -----
    The equation of motion about a moving pivot, ``a'' + y'' sin(a) + x'' cos(a) = -k sin(a) - c
    a'`` with the pivot's place (x, y) in arms, averaged with weights ``(1 - u^2)^2`` of the time u.
    Its left side uses differences of slopes, so uneven time stamps do no harm. The parts are
    those with the least residual plus a penalty for each (Jackson et al., IEEE Signal Proc.
    Lett. 12 (2005) 105); parts whose k agree are one. It can miss changes by less than a factor of
    1.25, parts shorter than half a swing, and balls that touch too often. It can mistake a ball
    swung by hand for one that swings freely.
    """
    parts: list[tuple[int, int, Part]] = []
    for first, last in _stretches(motion):
        part = _fitted(motion.between(first, last))
        if part is None:
            continue
        if parts:
            both = _fitted(motion.between(parts[-1][0], last))
            if both is not None and _agree(parts[-1][2], both) and _agree(both, part):
                first, part = parts.pop()[0], both
        parts.append((first, last, part))
    return [part for _, _, part in parts]


def _stretches(motion: Motion) -> list[tuple[int, int]]:
    """Return the first frames of stretches at one pace each, and the frames after their ends."""
    rows = _rows(motion)
    if len(rows) < _FEWEST:
        return []
    rows = rows[:: math.ceil(len(rows) / _MOST)]
    count = len(rows)
    # Sums up to each row give the cost of every stretch.
    products = rows[:, 1:, None] * rows[:, None, 1:]
    sums = np.concatenate([np.zeros((1, 3, 3)), np.cumsum(products, axis=0)])

    def cost(first: np.ndarray, last: int) -> np.ndarray:
        part = sums[last] - sums[first]
        squares = part[:, 1:, 1:] + 1e-12 * sums[-1, 1, 1] * np.eye(2)
        known = np.linalg.solve(squares, part[:, 1:, :1])
        rest = part[:, 0, 0] - (part[:, None, 0, 1:] @ known)[:, 0, 0]
        return np.asarray(np.maximum(rest, 0.0))

    short = [float(cost(np.array([k]), k + _FEWEST)[0]) for k in range(count - _FEWEST + 1)]
    noise = float(np.median(short)) / (_FEWEST - 2) + _ROUGH**2 * sums[-1, 0, 0] / count
    least = np.full(count + 1, math.inf)
    least[0], origin = 0.0, np.zeros(count + 1, int)
    for last in range(_SHORTEST, count + 1):
        first = np.arange(last - _SHORTEST + 1)
        total = least[first] + cost(first, last) + _CHANGE * noise
        origin[last], least[last] = np.argmin(total), np.min(total)
    ends = [count]
    while origin[ends[-1]]:
        ends.append(int(origin[ends[-1]]))
    reach = 0.5 * _width(motion)
    spans = [
        (rows[first, 0] - reach, rows[last - 1, 0] + reach)
        for first, last in pairwise([0, *ends[::-1]])
    ]
    spans[0] = motion.times[0], spans[0][1]
    spans[-1] = spans[-1][0], motion.times[-1] + reach
    frames = np.searchsorted(motion.times, spans).tolist()
    return [
        (max(first, before), last) for (_, before), (first, last) in pairwise([(0, 0), *frames])
    ]


def _agree(one: Part, other: Part) -> bool:
    """Return whether two parts play at one pace."""
    return abs(math.log(one.stiffness / other.stiffness)) < 2.0 * math.log(_OTHER)


def _width(motion: Motion) -> float:
    """Return half the time over which is averaged [s], 0 for balls that rest or are not seen."""
    angles = np.abs(motion.angles[motion.is_free])
    if len(angles) < _FEWEST:
        return 0.0
    size = min(float(np.quantile(angles, _LARGEST)), 1.0)
    bends = np.abs(np.diff(motion.angles, 2, axis=0))[motion.is_free[1:-1]]
    if not size > _CLEAR * float(np.nanmedian(bends)):
        return 0.0
    step = float(np.median(np.diff(motion.times)))
    width, lag = 0.0, 1
    for _ in range(4):  # noise makes speeds over short times large
        passed = (motion.times[lag:] - motion.times[:-lag])[:, None]
        speeds = np.abs(motion.angles[lag:] - motion.angles[:-lag]) / passed
        speeds = speeds[motion.is_free[lag:] & motion.is_free[:-lag]]
        speed = float(np.quantile(speeds, _LARGEST)) if len(speeds) else 0.0
        if not speed > 0.0:
            return 0.0
        width = max(_WIDTH * size / speed, 2.01 * step)
        lag = min(max(int(0.5 * width / step), 1), len(motion.times) // 4)
    return width


def _rows(motion: Motion) -> np.ndarray:
    """Return averages: time, left side, sine and speed, shape (average, 4), in order of time."""
    times, pivots, width = motion.times, motion.pivots, _width(motion)
    if width == 0.0:
        return np.empty((0, 4))
    steps = np.diff(times)
    pushes = np.diff(np.diff(pivots, axis=0) / steps[:, None], axis=0)
    spans = 0.5 * (steps[1:] + steps[:-1])
    inner = times[1:-1]
    rows = []
    for angle, free in zip(motion.angles.T, motion.is_free.T, strict=True):
        sine, cosine = np.sin(angle[1:-1]), np.cos(angle[1:-1])
        left = np.diff(np.diff(angle) / steps) + pushes[:, 1] * sine + pushes[:, 0] * cosine
        each = np.column_stack([left, sine * spans, 0.5 * (angle[2:] - angle[:-2])])
        usable = free[2:] & free[1:-1] & free[:-2] & np.isfinite(left)
        for middle in np.arange(times[0] + width, times[-1] - width, 0.5 * width):
            first, last = np.searchsorted(inner, [middle - width, middle + width])
            near = slice(first, last)
            if last - first < 3 or not usable[near].all():
                continue
            weight = (1.0 - ((inner[near] - middle) / width) ** 2) ** 2
            rows.append([middle, *(weight @ each[near])])
    found: np.ndarray = np.array(rows).reshape(-1, 4)
    return found[np.argsort(found[:, 0], kind="stable")]


def _solved(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return stiffness and drag, what they leave over, and the weights of the averages."""
    weight = np.ones(len(rows))
    for _ in range(4):
        root = np.sqrt(weight)[:, None]
        known = np.linalg.lstsq(-rows[:, 2:] * root, rows[:, 1] * root[:, 0], rcond=None)[0]
        rest = rows[:, 1] + rows[:, 2:] @ known
        limit = _OUTLYING * float(np.median(np.abs(rest))) + 1e-12
        weight = 1.0 / (1.0 + (rest / limit) ** 2)
    return known, rest, weight


def _fitted(motion: Motion) -> Part | None:
    """Return a clip as one part, None if its motion does not tell the pace."""
    rows = _rows(motion)
    if len(rows) < _FEWEST:
        return None
    (stiffness, _), rest, weight = _solved(rows)
    matrix = (rows[:, 2:] * weight[:, None]).T @ rows[:, 2:]
    spread = float(np.sum(weight * rest**2)) / (len(rows) - 2)
    sigma = math.sqrt(spread * float(np.linalg.pinv(matrix)[0, 0]))
    is_explained = spread < _LEFT_OVER**2 * float(np.mean(rows[:, 1] ** 2))
    if not (is_explained and 0.0 < sigma < _SURE * stiffness):
        return None
    begin, end = (float(motion.times[k]) for k in (0, -1))
    if (end - begin) * math.sqrt(stiffness) < math.pi:
        return None
    return Part(begin, end, float(stiffness), sigma)
