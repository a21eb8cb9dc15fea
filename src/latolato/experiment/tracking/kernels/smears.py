"""Compiled drawing of smeared balls: differences of running sums along straight pieces of a path.

A disc that moves on a straight line covers a pixel for as long as the disc's profile along that
line lasts there: the difference of two entries of its running sum, however long the line is.
"""

from __future__ import annotations

import math

import numpy as np

from latolato.experiment.tracking.kernels.jit import jit
from latolato.experiment.tracking.kernels.layers import Ball, add_between

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
    # By how much the last step differs from the first.
    bend_x = knots[count, 0] - knots[count - 1, 0] - knots[1, 0] + knots[0, 0]
    bend_y = knots[count, 1] - knots[count - 1, 1] - knots[1, 1] + knots[0, 1]
    # How far the path's middle is from that of its chord, as an arc and as speed that changes.
    sagitta = count * math.sqrt(bend_x**2 + bend_y**2) / 8.0
    number = max(1, math.ceil(math.sqrt(sagitta / _SAGITTA)))
    if number > count:
        return none
    pieces = np.empty((number, 6))
    for p in range(number):
        a, b = p * count // number, (p + 1) * count // number
        dx, dy = knots[b, 0] - knots[a, 0], knots[b, 1] - knots[a, 1]
        length = math.sqrt(dx * dx + dy * dy)
        along, middle_x, middle_y = 0.0, 0.0, 0.0
        for k in range(a, b):
            step_x, step_y = knots[k + 1, 0] - knots[k, 0], knots[k + 1, 1] - knots[k, 1]
            along += math.sqrt(step_x**2 + step_y**2)
            middle_x += path[k, 0] / (b - a)
            middle_y += path[k, 1] / (b - a)
        if length < max(_SHORTEST, _STRAIGHT * along):
            return none
        # On both sides of the path, not within its bend.
        pieces[p, 0], pieces[p, 1] = middle_x - 0.5 * dx, middle_y - 0.5 * dy
        pieces[p, 2], pieces[p, 3], pieces[p, 4] = dx / length, dy / length, length
        pieces[p, 5] = (b - a) / count
    return pieces


@jit
def running_sum(piece: np.ndarray, turn: float, ball: Ball) -> np.ndarray:
    """Return the running sum of a ball along a piece's direction, shape (across, along, 4).

    The ball is premultiplied colour and share, as `cover` draws it, in steps of `step_of` from
    the corner of the square that holds it.
    """
    step = step_of(ball.blur)
    reach = ball.radius + 2.0 * ball.blur
    core = max(ball.radius - 2.0 * ball.blur, 0.0) ** 2
    count = 2 * math.ceil(reach / step) + 1
    middle = (count - 1) // 2
    half = (ball.paint.shape[0] - 1) // 2
    out = np.zeros((count, count, 4), np.float32)
    # From along and across the piece to columns and rows of the paint.
    cosine, sine = math.cos(turn), math.sin(turn)
    along_u, along_v = (
        piece[2] * cosine - piece[3] * sine,
        piece[2] * sine + piece[3] * cosine,
    )
    before, now = np.zeros(4, np.float32), np.zeros(4, np.float32)
    total = np.zeros(4, np.float32)
    half_step = np.float32(0.5 * step)
    for m in range(count):
        t = (m - middle) * step
        for c in range(4):
            total[c] = before[c] = 0.0
        for n in range(count):
            s = (n - middle) * step
            square = s * s + t * t
            for c in range(4):
                now[c] = 0.0
            if square < reach * reach:
                share = 1.0
                if square > core:
                    depth = (ball.radius - math.sqrt(square)) / ball.blur
                    share = 0.5 + depth * (0.375 - depth * depth * 0.03125)
                u = min(max(s * along_u - t * along_v + half, 0.0), 2.0 * half - 1e-3)
                v = min(max(s * along_v + t * along_u + half, 0.0), 2.0 * half - 1e-3)
                add_between(ball.paint, v, u, share, now)
            for c in range(4):
                total[c] += half_step * (before[c] + now[c])
                out[m, n, c] = total[c]
                before[c] = now[c]
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
    corner: np.ndarray,
    out: np.ndarray,
) -> None:
    """Add a disc that moves along a piece to `out`, shape (row, column, 4), as `cover` does."""
    x0, y0 = piece[0] - corner[0], piece[1] - corner[1]
    ux, uy, length = piece[2], piece[3], piece[4]
    middle = (total.shape[0] - 1) // 2
    reach = middle * step
    weight = piece[5] / length
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
            add_between(total, t, min(s, last), weight, out[j, i])
            if s > early:
                add_between(total, t, s - early, -weight, out[j, i])
