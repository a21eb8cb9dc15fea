"""Marks a scalar formula as compilable without importing a compiler.

A formula is a plain function of numbers that uses :mod:`math` only. It runs as it stands in Python;
`latolato.numerics.jit` makes the same function callable from compiled code. Nothing here
imports numba, so that ``import latolato`` stays fast.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])

_formulas: list[Callable[..., Any]] = []
_listeners: list[Callable[[Callable[..., Any]], None]] = []


def formula(function: Function) -> Function:
    """Return `function` itself, known from now on as callable from compiled code."""
    _formulas.append(function)
    for listen in _listeners:
        listen(function)
    return function


def for_each_formula(action: Callable[[Callable[..., Any]], None]) -> None:
    """Apply `action` to every formula there is, and to each one that is marked later."""
    for function in _formulas:
        action(function)
    _listeners.append(action)


# pi in three parts whose first two have 30 bits, so that n * part is exact for |n| < 2^23.
_PI_1, _PI_2, _PI_3 = 3.141592651605606, 1.9841871583270443e-09, 1.034036596358821e-18
_PER_PI = 1.0 / math.pi
_ROUND = 6755399441055744.0  # 1.5 * 2^52: adding and subtracting it rounds to an integer
# sin(r) = r + r^3 P(r^2) on |r| <= pi/2: minimax fit of P with relative error 2.8e-19 of the sine.
_S1, _S2 = -1.6666666666666665569e-1, 8.3333333333331942054e-3
_S3, _S4 = -1.9841269841209180547e-4, 2.7557319211130439969e-6
_S5, _S6 = -2.5052106872161995412e-8, 1.6058939673086827799e-10
_S7, _S8 = -7.6429906202367365909e-13, 2.7211656563086963027e-15


@formula
def _reduced_sine(r: float, n: float) -> float:
    """Return (-1)^n sin(r) for |r| <= pi/2; the polynomial is summed in pairs for speed."""
    u = r * r
    u2 = u * u
    low = (_S1 + u * _S2) + u2 * (_S3 + u * _S4)
    high = (_S5 + u * _S6) + u2 * (_S7 + u * _S8)
    value = r + r * u * (low + u2 * u2 * high)
    half = 0.5 * n
    return value if (half + _ROUND) - _ROUND == half else -value


@formula
def sine(x: float) -> float:
    """Return sin(x) with an error below 2.3e-16 (1 + 1e-7 |x|) for |x| < 1e7.

    A polynomial instead of the library's function: it is inlined, vectorises, and gives the same
    on every backend.
    """
    n = (x * _PER_PI + _ROUND) - _ROUND
    return _reduced_sine(((x - n * _PI_1) - n * _PI_2) - n * _PI_3, n)


@formula
def cosine(x: float) -> float:
    """Return cos(x) with the error of `sine`."""
    n = (x * _PER_PI - 0.5 + _ROUND) - _ROUND + 0.5
    return _reduced_sine(((x - n * _PI_1) - n * _PI_2) - n * _PI_3, n + 0.5)


@formula
def floor(x: float) -> float:
    """Return the largest whole number up to x as a float, for |x| < 2^51.

    Compiled, `math.floor` returns an integer, for which most processors have no vectors.
    """
    n = (x + _ROUND) - _ROUND
    return n - 1.0 if n > x else n
