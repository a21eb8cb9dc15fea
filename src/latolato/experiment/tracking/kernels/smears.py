"""Compiled drawing of smeared balls: differences of running sums along straight pieces of a path.

A disc that moves on a straight line covers a pixel for as long as the disc's profile along that
line lasts there: the difference of two entries of its running sum, however long the line is.
"""

from __future__ import annotations

import math

import numpy as np

from latolato.experiment.tracking.kernels.jit import jit

# Paths of fewer samples are drawn one by one.
FEWEST = 4
# How far a straight piece may leave the path, and the least length of one [pixels].
_SAGITTA, _SHORTEST = 0.1, 1.0
# Length of a piece over that of its part of the path, below which the ball turns back.
_STRAIGHT = 0.98
# Steps of the running sums: at least this, and this share of the edge's softness [pixels].
_STEP = 0.7


@jit
def pieces_of(path: np.ndarray) -> np.ndarray:
    """Return straight pieces of a path, shape (piece, 6); none if it is short or turns back.

    `path` holds centres at the middles of equal shares of the exposure. A piece is its start,
    direction, length and share of the exposure.
    """
    count = len(path)
    none = np.empty((0, 6))
    if count < FEWEST:
        return none
    knots = np.empty((count + 1, 2))
    for c in range(2):
        knots[0, c] = 1.5 * path[0, c] - 0.5 * path[1, c]
        knots[count, c] = 1.5 * path[count - 1, c] - 0.5 * path[count - 2, c]
        for k in range(1, count):
            knots[k, c] = 0.5 * (path[k - 1, c] + path[k, c])
    steps = knots[1:] - knots[:-1]
    first, last = steps[0], steps[count - 1]
    lengths = np.sqrt(steps[:, 0] ** 2 + steps[:, 1] ** 2)
    bend = abs(
        math.atan2(first[0] * last[1] - first[1] * last[0], first[0] * last[0] + first[1] * last[1])
    )
    number = max(1, math.ceil(math.sqrt(lengths.sum() * bend / (8.0 * _SAGITTA))))
    if number > count:
        return none
    pieces = np.empty((number, 6))
    for p in range(number):
        a, b = p * count // number, (p + 1) * count // number
        dx, dy = knots[b, 0] - knots[a, 0], knots[b, 1] - knots[a, 1]
        length = math.sqrt(dx * dx + dy * dy)
        if length < max(_SHORTEST, _STRAIGHT * lengths[a:b].sum()):
            return none
        # On both sides of the path, not within its bend.
        pieces[p, 0] = path[a:b, 0].mean() - 0.5 * dx
        pieces[p, 1] = path[a:b, 1].mean() - 0.5 * dy
        pieces[p, 2], pieces[p, 3], pieces[p, 4] = dx / length, dy / length, length
        pieces[p, 5] = (b - a) / count
    return pieces


@jit
def running_sum(
    piece: np.ndarray, turn: float, radius: float, blur: float, paint: np.ndarray
) -> np.ndarray:
    """Return the running sum of a disc along a piece's direction, shape (across, along, 4).

    The disc is premultiplied colour and share, as `cover` draws it, in steps of `step_of` from
    the corner of the square that holds it.
    """
    step = step_of(blur)
    reach = radius + 2.0 * blur
    count = 2 * math.ceil(reach / step) + 1
    middle = (count - 1) // 2
    half = (paint.shape[0] - 1) // 2
    out = np.zeros((count, count, 4), np.float32)
    # From along and across the piece to columns and rows of the paint.
    cosine, sine = math.cos(turn), math.sin(turn)
    along_u, along_v = (
        piece[2] * cosine - piece[3] * sine,
        piece[2] * sine + piece[3] * cosine,
    )
    before = np.zeros(4)
    now = np.zeros(4)
    for m in range(count):
        t = (m - middle) * step
        total0, total1, total2, total3 = 0.0, 0.0, 0.0, 0.0
        before[:] = 0.0
        for n in range(count):
            s = (n - middle) * step
            square = s * s + t * t
            now[:] = 0.0
            if square < reach * reach:
                depth = (radius - math.sqrt(square)) / blur
                share = 1.0 if depth >= 2.0 else 0.5 + depth * (0.375 - depth * depth * 0.03125)
                u = min(max(s * along_u - t * along_v + half, 0.0), 2.0 * half - 1e-3)
                v = min(max(s * along_v + t * along_u + half, 0.0), 2.0 * half - 1e-3)
                p, q = int(u), int(v)
                a, b = u - p, v - q
                for c in range(3):
                    now[c] = share * (
                        (1.0 - b) * ((1.0 - a) * paint[q, p, c] + a * paint[q, p + 1, c])
                        + b * ((1.0 - a) * paint[q + 1, p, c] + a * paint[q + 1, p + 1, c])
                    )
                now[3] = share
            total0 += 0.5 * step * (before[0] + now[0])
            total1 += 0.5 * step * (before[1] + now[1])
            total2 += 0.5 * step * (before[2] + now[2])
            total3 += 0.5 * step * (before[3] + now[3])
            out[m, n, 0], out[m, n, 1] = total0, total1
            out[m, n, 2], out[m, n, 3] = total2, total3
            before[:] = now
    return out


@jit
def step_of(blur: float) -> float:
    """Return the step of running sums [pixels]."""
    return max(_STEP, _STEP * blur)


@jit
def sweep(
    piece: np.ndarray,
    total: np.ndarray,
    step: float,
    left: float,
    top: float,
    out: np.ndarray,
) -> None:
    """Add a disc that moves along a piece to `out`, shape (row, column, 4), as `cover` does."""
    x0, y0 = piece[0] - left, piece[1] - top
    ux, uy, length = piece[2], piece[3], piece[4]
    middle = (total.shape[0] - 1) // 2
    reach = middle * step
    weight = np.float32(piece[5] / length)
    across, along = ux / step, uy / step
    x1, y1 = x0 + length * ux, y0 + length * uy
    rows, columns = out.shape[0], out.shape[1]
    early, last = length / step, 2 * middle - 1e-3
    for j in range(max(0, int(min(y0, y1) - reach)), min(rows, int(max(y0, y1) + reach) + 2)):
        dy = j - y0
        # The columns within reach of the piece.
        low, high = min(x0, x1) - reach, max(x0, x1) + reach
        if abs(uy) > 1e-6:
            one, two = (dy * ux - reach) / uy, (dy * ux + reach) / uy
            low, high = max(low, x0 + min(one, two)), min(high, x0 + max(one, two))
        for i in range(max(0, int(low)), min(columns, int(high) + 2)):
            dx = i - x0
            t = dy * across - dx * along + middle
            if t < 0.0 or t >= 2 * middle:
                continue
            s = dx * across + dy * along + middle
            if s <= 0.0 or s - early >= 2 * middle:
                continue
            late0, late1, late2, late3 = _looked_up(total, t, min(s, last))
            if s > early:
                early0, early1, early2, early3 = _looked_up(total, t, s - early)
                late0, late1 = late0 - early0, late1 - early1
                late2, late3 = late2 - early2, late3 - early3
            out[j, i, 0] += weight * late0
            out[j, i, 1] += weight * late1
            out[j, i, 2] += weight * late2
            out[j, i, 3] += weight * late3


@jit
def _looked_up(total: np.ndarray, t: float, s: float) -> tuple[float, float, float, float]:
    """Return the running sum between its entries."""
    # Whole numbers without a sign spare the question whether they count from the end.
    m, n = np.uint64(t), np.uint64(s)
    b, a = np.float32(t - m), np.float32(s - n)
    row, next_row = total[m], total[m + np.uint64(1)]
    p, q = row[n], row[n + np.uint64(1)]
    v, w = next_row[n], next_row[n + np.uint64(1)]
    k11 = a * b
    k10, k01 = b - k11, a - k11
    k00 = np.float32(1.0) - a - k10
    return (
        k00 * p[0] + k01 * q[0] + k10 * v[0] + k11 * w[0],
        k00 * p[1] + k01 * q[1] + k10 * v[1] + k11 * w[1],
        k00 * p[2] + k01 * q[2] + k10 * v[2] + k11 * w[2],
        k00 * p[3] + k01 * q[3] + k10 * v[3] + k11 * w[3],
    )
