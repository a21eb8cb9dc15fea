"""How perturbations evolve: the matrix of a run, and the Lyapunov exponents."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from latolato.core.quantities import Quantity
from latolato.core.scalar import formula
from latolato.observables.base import STATE_SIZE, Observable, Outcome, observables

# A vector shorter than this part of what it was before its part along the others was taken away
# holds rounding only: the motion has lost that direction.
_LOST = 1e-13


@formula
def _multiply(acc: Any, i: int, n: int, size: int, jacobian: Any) -> None:
    """Multiply the matrix of columns, in slots ``4 row + column``, by `jacobian` from the left."""
    for column in range(size):
        for row in range(size):
            total = 0.0
            for k in range(size):
                total += jacobian[row, k] * acc[i + (STATE_SIZE * k + column) * n]
            jacobian[row, STATE_SIZE] = total
        for row in range(size):
            acc[i + (STATE_SIZE * row + column) * n] = jacobian[row, STATE_SIZE]


@formula
def _gather(acc: Any, i: int, n: int, size: int, time: float, spread: float, jacobian: Any) -> None:
    """Gather the matrix and the logarithm of the determinant that it should have."""
    _multiply(acc, i, n, size, jacobian)
    acc[i + STATE_SIZE * STATE_SIZE * n] += spread


@formula
def _start(acc: Any, i: int, n: int, angle: float) -> None:
    """Write the unit matrix."""
    for row in range(STATE_SIZE):
        acc[i + (STATE_SIZE + 1) * row * n] = 1.0


@dataclass(frozen=True, kw_only=True)
class FundamentalMatrix(Observable):
    """The matrix by which a run changes perturbations; not registered, as it is not a number."""

    start: ClassVar[Any] = staticmethod(_start)
    tangent: ClassVar[Any] = staticmethod(_gather)
    is_joint: ClassVar[bool] = True

    @property
    def memory(self) -> int:
        """The matrix and the logarithm."""
        return STATE_SIZE * STATE_SIZE + 1


# Slots of exponents behind the vectors: the growth of each, the time and the divergence; the growth
# of the first vector and the time of steps that lose no direction, how often directions were lost,
# and whether the last step lost one.
_SUMS = STATE_SIZE * STATE_SIZE
_TIME, _SPREAD = _SUMS + STATE_SIZE, _SUMS + STATE_SIZE + 1
_GROWTH, _MOVING, _RESTS, _LOSES = range(_SPREAD + 1, _SPREAD + 5)


@formula
def _stretch(
    acc: Any, i: int, n: int, size: int, time: float, spread: float, jacobian: Any
) -> None:
    """Stretch the vectors, make them orthonormal again, and add up how much they grew.

    A vector that a rest took away leaves the largest exponent at minus infinity for good. Another
    takes its place, so that growth can be counted again once the motion goes on.
    """
    _multiply(acc, i, n, size, jacobian)
    acc[i + _TIME * n] += time
    acc[i + _SPREAD * n] += spread
    first, lost = 0.0, 0.0
    for column in range(size):
        before = 0.0
        for row in range(size):
            before += acc[i + (STATE_SIZE * row + column) * n] ** 2
        for other in range(column):
            along = 0.0
            for row in range(size):
                at = i + STATE_SIZE * row * n
                along += acc[at + other * n] * acc[at + column * n]
            for row in range(size):
                at = i + STATE_SIZE * row * n
                acc[at + column * n] -= along * acc[at + other * n]
        length = 0.0
        for row in range(size):
            length += acc[i + (STATE_SIZE * row + column) * n] ** 2
        length = math.sqrt(length)
        is_lost = length <= _LOST * math.sqrt(before)
        scale = 0.0 if is_lost else 1.0 / length
        for row in range(size):
            acc[i + (STATE_SIZE * row + column) * n] *= scale
        growth = -math.inf if is_lost else math.log(length)
        acc[i + (_SUMS + column) * n] += growth
        jacobian[column, STATE_SIZE + 1] = 1.0 if is_lost else 0.0
        first = growth if column == 0 else first
        lost = 1.0 if is_lost else lost
    for column in range(size):
        # In place of a lost vector, the axis of its number: the next call makes it orthogonal.
        acc[i + (STATE_SIZE + 1) * column * n] += jacobian[column, STATE_SIZE + 1]
    acc[i + _GROWTH * n] += 0.0 if lost > 0.0 else first
    acc[i + _MOVING * n] += 0.0 if lost > 0.0 else time
    acc[i + _RESTS * n] += lost if acc[i + _LOSES * n] == 0.0 else 0.0
    acc[i + _LOSES * n] = lost


@formula
def _start_again(acc: Any, i: int, n: int, angle: float, velocity: float) -> None:
    """Forget the growth, and that the motion rests."""
    for k in range(_SUMS, _LOSES + 1):
        acc[i + k * n] = 0.0


@formula
def _finish_exponents(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write all exponents, largest first, and NaN for exponents that the system does not have.

    Orthonormalisation sorts those that differ; what it cannot tell apart is sorted here.
    """
    time = acc[i + _TIME * n]
    for k in range(STATE_SIZE):
        is_known = time > 0.0 and k < 2 * end.balls
        acc[i + k * n] = acc[i + (_SUMS + k) * n] / time if is_known else math.nan
    for last in range(2 * end.balls - 1, 0, -1):
        for k in range(last):
            first, second = acc[i + k * n], acc[i + (k + 1) * n]
            acc[i + k * n] = second if first < second else first
            acc[i + (k + 1) * n] = first if first < second else second


@formula
def _finish_largest(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write the largest exponent, that between rests, and the number of these."""
    rests, moving = acc[i + _RESTS * n], acc[i + _MOVING * n]
    between = acc[i + _GROWTH * n] / moving if moving > 0.0 else math.nan
    _finish_exponents(acc, i, n, end)
    acc[i + n] = between if rests > 0.0 else acc[i]
    acc[i + 2 * n] = rests


@formula
def _finish_residual(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write by how much the sum of all exponents misses the mean divergence.

    NaN where the motion loses its past, as both are minus infinity there, and where a string goes
    slack.
    """
    total, time = 0.0, acc[i + _TIME * n]
    for k in range(STATE_SIZE):
        total += acc[i + (_SUMS + k) * n]
    acc[i] = (total - acc[i + _SPREAD * n]) / time if time > 0.0 else math.nan


@dataclass(frozen=True, kw_only=True)
class _Exponents(Observable):
    """What all observables of exponents share."""

    start: ClassVar[Any] = staticmethod(_start)
    tangent: ClassVar[Any] = staticmethod(_stretch)
    restart: ClassVar[Any] = staticmethod(_start_again)
    is_joint: ClassVar[bool] = True

    @property
    def memory(self) -> int:
        """The vectors, their growth and times, and the rests."""
        return _LOSES + 1


@observables.register("lyapunov_exponent")
@dataclass(frozen=True, kw_only=True)
class LyapunovExponent(_Exponents):
    """Largest Lyapunov exponent after the transient, and between the rests in this time.

    Benettin et al., Meccanica 15 (1980) 9, with the saltation matrices of impacts. Minus infinity
    if the motion forgets its past even once: it rests, or meets a wall without rebound. Slack
    strings count from taut to taut; NaN if none tightens, or if balls meet at the very instant at
    which a string tightens.

    `exponent_between_rests` is the growth of one deviation over the time in which the motion keeps
    its past; after each of the `rests` it begins again. It converges only if rests are rare: if
    the time between them is long against its inverse. Without rests it is the largest exponent;
    NaN if the motion never leaves its rest.
    """

    variables: ClassVar[Any] = {
        "lyapunov_exponent": Quantity("1/s", r"\lambda_1", "largest Lyapunov exponent"),
        "exponent_between_rests": Quantity("1/s", r"\lambda_r", "exponent between rests"),
        "rests": Quantity("1", "N_r", "rests, after which the motion has forgotten its past"),
    }
    finish: ClassVar[Any] = staticmethod(_finish_largest)


@observables.register("lyapunov_spectrum")
@dataclass(frozen=True, kw_only=True)
class LyapunovSpectrum(_Exponents):
    """All Lyapunov exponents after the transient, and how well the sum rule holds.

    The exponents add up to the mean divergence of the flow plus ``2 f ln e`` at f impacts per
    second; the residual is the difference. If strings go slack, the laws of motion do not determine
    the sum, and the residual is NaN.
    """

    variables: ClassVar[Any] = {
        "lyapunov_exponents": Quantity("1/s", r"\lambda", "Lyapunov exponents")
    }
    dimension: ClassVar[str] = "exponent"
    finish: ClassVar[Any] = staticmethod(_finish_exponents)


@observables.register("sum_rule_residual")
@dataclass(frozen=True, kw_only=True)
class SumRuleResidual(_Exponents):
    """By how much the sum of the Lyapunov exponents misses what the laws of motion give."""

    variables: ClassVar[Any] = {
        "sum_rule_residual": Quantity(
            "1/s", r"\Delta\lambda", "sum of the exponents minus the mean divergence"
        )
    }
    finish: ClassVar[Any] = staticmethod(_finish_residual)


@formula
def _cross(acc: Any, i: int, n: int, size: int, time: float, spread: float, jacobian: Any) -> None:
    """Stretch the departure from mirror symmetry, in which both balls deviate alike."""
    angle, velocity = acc[i], acc[i + n]
    x = (jacobian[0, 0] + jacobian[0, 2]) * angle + (jacobian[0, 1] + jacobian[0, 3]) * velocity
    v = (jacobian[1, 0] + jacobian[1, 2]) * angle + (jacobian[1, 1] + jacobian[1, 3]) * velocity
    length = math.sqrt(x * x + v * v)
    acc[i + 2 * n] += math.log(length) if length > 0.0 else -math.inf
    acc[i + 3 * n] += time
    acc[i], acc[i + n] = (x / length, v / length) if length > 0.0 else (0.0, 0.0)


@formula
def _cross_again(acc: Any, i: int, n: int, angle: float, velocity: float) -> None:
    """Forget the growth."""
    acc[i + 2 * n] = 0.0
    acc[i + 3 * n] = 0.0


@formula
def _cross_start(acc: Any, i: int, n: int, angle: float) -> None:
    """Write a unit vector."""
    acc[i] = 1.0


@formula
def _cross_finish(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write the rate."""
    time = acc[i + 3 * n]
    acc[i] = acc[i + 2 * n] / time if time > 0.0 else math.nan


@observables.register("transverse_exponent")
@dataclass(frozen=True, kw_only=True)
class TransverseExponent(Observable):
    """Growth rate of small departures from mirror symmetry, for two equal balls started mirrored.

    The mean angle S of both obeys ``S'' + gamma S' + (g + y0'')/l cos(angle) S = 0`` along the
    mirrored motion (linear drag); impacts do not change it. If the rate is negative, the one-ball
    model describes the pair. The computed motion is kept symmetric despite rounding.
    """

    variables: ClassVar[Any] = {
        "transverse_exponent": Quantity(
            "1/s", r"\lambda_\perp", "growth rate of the departure from mirror symmetry"
        )
    }
    start: ClassVar[Any] = staticmethod(_cross_start)
    tangent: ClassVar[Any] = staticmethod(_cross)
    restart: ClassVar[Any] = staticmethod(_cross_again)
    finish: ClassVar[Any] = staticmethod(_cross_finish)
    is_joint: ClassVar[bool] = True
    angles: ClassVar[int] = 2
    mirrored: ClassVar[bool] = True

    @property
    def memory(self) -> int:
        """The vector, its growth and the time."""
        return 4
