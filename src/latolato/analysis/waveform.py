"""Hill's equation of any periodic waveform, in Fourier space (Hill, 1886).

``x'' + c x' + (a + F(p)) x = 0`` over the drive's phase p, with F of period 2 pi. With
``x = sum u_k exp(i kappa_k p)``, ``kappa_k = k`` (multiplier +1, even tongues) or ``k + 1/2``
(multiplier -1, odd tongues), an edge is where the determinant of the rows

    (a + i c kappa_k - kappa_k^2) u_k + sum_j F_(k-j) u_j = 0

vanishes, the drag c included. Rows are divided by ``-kappa_k^2``. Then the determinant is
``exp(pi c) (1 + exp(-2 pi c) - s trace)/4`` for the multiplier s, divided by pi^2 for s = +1, up to
a positive factor that tends to 1: positive where the motion is stable. The zeros converge faster
than any power of the number of harmonics.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.analysis.roots import find_root
from latolato.analysis.rules import broken_analysis
from latolato.core.errors import InputError

Complexes = NDArray[np.complex128]
Floats = NDArray[np.float64]

# Relative size below which a waveform's overtones are rounding.
_NEGLIGIBLE = 1e-15
_FEWEST_SAMPLES, _MOST_SAMPLES = 64, 8192
# The largest number of harmonics on either side, where doubling ends.
_MOST_HARMONICS = 2000
# Answers from one and from twice the number of harmonics agree so closely.
_AGREEMENT = 1e-12


def fourier_coefficients(waveform: Callable[[float], float]) -> Complexes:
    """Return F_0, F_1, ... of a real function of period 2 pi, up to the last that matters.

    Those of an even function are exactly real.

    Raises
    ------
    InputError
        If 8192 samples do not resolve it.
    """
    count = _FEWEST_SAMPLES
    while count <= _MOST_SAMPLES:
        samples = [waveform(math.tau * i / count) for i in range(count)]
        result = np.fft.rfft(samples) / count
        sizes = np.abs(result)
        least = _NEGLIGIBLE * float(sizes.max())
        if float(sizes[count // 4 :].max()) <= least:
            result = result[: 1 + int(np.flatnonzero(sizes >= least)[-1])]
            is_even = float(np.abs(result.imag).max()) <= least
            return np.asarray(result.real + 0j if is_even else result)
        count *= 2
    raise broken_analysis("smooth_drive", {"count": _MOST_SAMPLES // 4})


def enough_harmonics(coefficients: Complexes, is_odd: bool, count: int) -> int:
    """Return how many harmonics on either side give the lowest `count` edges of bands.

    Their number is doubled until the edges no longer change by more than 1e-12; drag couples no
    harmonics, so it needs no more.

    Raises
    ------
    InputError
        If they still change beyond 2000 harmonics.
    """
    strength = float(np.abs(coefficients).sum())
    harmonics = 6 + (count + len(coefficients)) // 2 + math.ceil(3.0 * math.sqrt(strength))
    now = band_edges(coefficients, is_odd, harmonics, count)
    while harmonics <= _MOST_HARMONICS:
        before, now = now, band_edges(coefficients, is_odd, 2 * harmonics, count)
        if np.allclose(before, now, rtol=_AGREEMENT, atol=_AGREEMENT):
            return harmonics
        harmonics *= 2
    raise InputError(
        f"the Fourier series did not settle with {harmonics} harmonics; lower the drive's "
        "amplitude or raise its frequency"
    )


def _wave_numbers(is_odd: bool, harmonics: int) -> Floats:
    """Return kappa, shape (wave,)."""
    if is_odd:
        return np.arange(-harmonics, harmonics, dtype=np.float64) + 0.5
    return np.arange(-harmonics, harmonics + 1, dtype=np.float64)


def _coupling(coefficients: Complexes, size: int) -> Complexes:
    """Return the matrix of F_(k-j), shape (size, size)."""
    column = np.zeros(size, dtype=np.complex128)
    count = min(size, len(coefficients))
    column[:count] = coefficients[:count]
    both = np.concatenate((column[:0:-1].conj(), column))
    k = np.arange(size)
    return np.asarray(both[size - 1 + k[:, None] - k])


def hill_value(a: float, c: float, coefficients: Complexes, is_odd: bool, harmonics: int) -> float:
    """Return the determinant of the (anti)periodic Fourier system; positive where stable."""
    kappa = _wave_numbers(is_odd, harmonics)
    matrix = _coupling(coefficients, len(kappa))
    matrix[np.diag_indices(len(kappa))] += a + 1j * c * kappa - kappa**2
    rows = np.where(kappa == 0.0, 1.0, -(kappa**2))
    return float(np.linalg.det(matrix / rows[:, None]).real)


def band_edges(coefficients: Complexes, is_odd: bool, harmonics: int, count: int) -> Floats:
    """Return the lowest a, shape (count,), at which ``x'' + (a + F) x = 0`` is (anti)periodic.

    Eigenvalues of a Hermitian matrix, each taken once more as Rayleigh quotient of its vector:
    then its error is that of its own size, not of the largest element.
    """
    kappa = _wave_numbers(is_odd, harmonics)
    matrix: Any = np.diag(kappa**2) - _coupling(coefficients, len(kappa))
    if not coefficients.imag.any():
        matrix = matrix.real
    vectors = np.linalg.eigh(matrix)[1][:, :count]
    return np.asarray(np.einsum("ki,ki->i", vectors.conj(), matrix @ vectors).real)


def undamped_growth(a: float, coefficients: Complexes, is_odd: bool, harmonics: int) -> float:
    """Return the growth of ``x'' + (a + F) x = 0`` per unit of phase in (odd) tongues, 0 outside.

    With ``x = exp(m p) y`` it is ``y'' + 2 m y' + (a + m^2 + F) y = 0``: the growth m is the drag
    under which y is just periodic (odd: antiperiodic), a zero of `hill_value`.
    """

    def value(m: float) -> float:
        return hill_value(a + m * m, 2.0 * m, coefficients, is_odd, harmonics)

    if value(0.0) >= 0.0:
        return 0.0
    # No solution grows faster than the square root of the largest -(a + F).
    return find_root(value, 0.0, math.sqrt(abs(a) + 2.0 * float(np.abs(coefficients).sum())))
