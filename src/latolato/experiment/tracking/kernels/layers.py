"""Compiled inner loops of the tracker: colours of windows, moving layers, normal equations.

Positions are (column, row) with whole numbers at the centres of pixels. Colours are linear light,
red, green and blue between 0 and 1.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from latolato.experiment.tracking.kernels.jit import jit

# Steps of the table that turns a coded value between 0 and 255 into linear light.
_FINENESS = 4
# ITU-R BT.2100-2, tables 4 and 5.
_HLG_A = 0.17883277
_HLG_C = 0.5 - _HLG_A * math.log(4.0 * _HLG_A)
_PQ_M1, _PQ_M2 = 2610.0 / 16384.0, 2523.0 / 32.0
_PQ_C1, _PQ_C2, _PQ_C3 = 3424.0 / 4096.0, 2413.0 / 128.0, 2392.0 / 128.0
# The brightest light of PQ [1000 cd/m^2], which is where HLG ends.
_PQ_PEAK = 10.0
# Shares of red and blue in luma: ITU-R BT.601, BT.709 and BT.2020.
_RED_AND_BLUE = {"bt601": (0.299, 0.114), "bt709": (0.2126, 0.0722), "bt2020": (0.2627, 0.0593)}
# Part of a ball's largest share from which a pixel is the ball's.
_CORE = 0.7
# Part of the ball's radius beyond which, towards the pivot, the rod is left out, and half-width.
_ROD_BEGINS, _ROD_HALF_WIDTH = 0.7, 0.45


class Ball(NamedTuple):
    """How balls are drawn: sizes [pixels], colours about the centre, whether these turn.

    `paint` and `shading` have the shape (ball, row, column, 4), `variance` (ball, row, column);
    balls that look alike share the last one. A fourth colour, 1, becomes the share that a ball
    covers. `shading` is added to colours that turn, and stays as the light does; its fourth colour
    is 0. `variance` is by how much more than the background the colours vary from frame to frame,
    as those of a pattern that moves. Both have a single pixel if there is none.
    """

    radius: float
    blur: float
    paint: np.ndarray
    shading: np.ndarray
    variance: np.ndarray
    is_spinning: bool


class Patch(NamedTuple):
    """A window of a frame from its corner (column, row) on: colours seen and of the background.

    Of so many pixels along a row it has one; the rows are shifted against each other.
    """

    seen: np.ndarray
    behind: np.ndarray
    corner: np.ndarray
    every: int


def linear_light(tone: str) -> np.ndarray:
    """Return linear light for coded values 0 to 255 in quarter steps.

    The tone curves are those of IEC 61966-2-1 (``"srgb"``) and ITU-R BT.2100-2 (``"hlg"``, light of
    the scene, and ``"pq"``, light of the display [1000 cd/m^2]).
    """
    coded = np.arange(255 * _FINENESS + 2) / (255.0 * _FINENESS)
    if tone == "hlg":
        above = np.exp((coded - _HLG_C) / _HLG_A) + 1.0 - 4.0 * _HLG_A
        curve = np.where(coded <= 0.5, 4.0 * coded**2, above) / 12.0
    elif tone == "pq":
        root = coded ** (1.0 / _PQ_M2)
        share = np.maximum(root - _PQ_C1, 0.0) / (_PQ_C2 - _PQ_C3 * root)
        curve = share ** (1.0 / _PQ_M1) * _PQ_PEAK
    else:
        curve = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)
    return curve.astype(np.float32)


def colour_coefficients(matrix: str, is_full_range: bool) -> np.ndarray:
    """Return (luma gain, luma offset, red, green of blue, green of red, blue) for 8-bit planes."""
    kr, kb = _RED_AND_BLUE[matrix]
    kg = 1.0 - kr - kb
    gain, offset, chroma = (1.0, 0.0, 1.0) if is_full_range else (255 / 219, 16.0, 255 / 224)
    red, blue = 2.0 * (1.0 - kr) * chroma, 2.0 * (1.0 - kb) * chroma
    return np.array([gain, offset, red, -kb * blue / kg, -kr * red / kg, blue], np.float32)


@jit
def _linear(value: float, table: np.ndarray) -> float:
    """Look up the linear light of a coded value."""
    at = min(max(value, 0.0), 255.0) * _FINENESS
    light: float = table[int(at + 0.5)]
    return light


@jit
def _chroma(plane: np.ndarray, column: float, row: float) -> float:
    """Interpolate a chroma plane at a luma position (columns cosited, rows between)."""
    height, width = plane.shape
    u = min(max(0.5 * column, 0.0), width - 1.0)
    v = min(max(0.5 * row - 0.25, 0.0), height - 1.0)
    i, j = int(u), int(v)
    i1, j1 = min(i + 1, width - 1), min(j + 1, height - 1)
    a, b = u - i, v - j
    top = (1.0 - a) * plane[j, i] + a * plane[j, i1]
    low = (1.0 - a) * plane[j1, i] + a * plane[j1, i1]
    chroma: float = (1.0 - b) * top + b * low - 128.0
    return chroma


@jit
def window(
    planes: tuple[np.ndarray, ...],
    corner: tuple[int, int],
    colours: tuple[np.ndarray, np.ndarray],
    whiten: np.ndarray,
    every: int,
    out: np.ndarray,
) -> None:
    """Write the linear colours of a window, times a matrix, into `out`, shape (row, column, 3).

    Positions outside the frame become NaN. `colours` are the table of `linear_light` and the
    `colour_coefficients`. Only pixels are written that `normal_equations` looks at.
    """
    luma, blue, red = planes
    table, mix = colours
    rows, columns = out.shape[0], out.shape[1]
    for j in range(rows):
        y = corner[1] + j
        for i in range(3 * j % every, columns, every):
            x = corner[0] + i
            if x < 0 or y < 0 or x >= luma.shape[1] or y >= luma.shape[0]:
                out[j, i] = np.nan
                continue
            light = mix[0] * (luma[y, x] - mix[1])
            b, r = _chroma(blue, x, y), _chroma(red, x, y)
            first = _linear(light + mix[2] * r, table)
            second = _linear(light + mix[3] * b + mix[4] * r, table)
            third = _linear(light + mix[5] * b, table)
            for c in range(3):
                out[j, i, c] = whiten[c, 0] * first + whiten[c, 1] * second + whiten[c, 2] * third


@jit
def add_between(
    table: np.ndarray, row: float, column: float, share: float, out: np.ndarray
) -> None:
    """Add a share of what a table (row, column, 4) holds between its entries to `out`."""
    # Whole numbers without a sign spare the question whether they count from the end. Four single
    # numbers are added at once.
    q, p, one = np.uint32(row), np.uint32(column), np.uint32(1)
    b, a = row - q, column - p
    k11, k10, k01 = share * a * b, share * b, share * a
    k10, k01, k00 = k10 - k11, k01 - k11, share - k10 - k01 + k11
    f00, f01, f10, f11 = np.float32(k00), np.float32(k01), np.float32(k10), np.float32(k11)
    for c in range(4):
        out[c] += (
            f00 * table[q, p, c]
            + f01 * table[q, p + one, c]
            + f10 * table[q + one, p, c]
            + f11 * table[q + one, p + one, c]
        )


@jit
def _own(number: int, looks: np.ndarray) -> int:
    """Return which of looks (look, ...) is a ball's: its own, or the last one, which is shared."""
    last: int = looks.shape[0] - 1
    return min(number, last)


@jit
def cover(
    path: np.ndarray,
    turns: np.ndarray,
    ball: Ball,
    number: int,
    corner: np.ndarray,
    out: np.ndarray,
) -> None:
    """Add a moving ball, averaged over `path`, to `out`, shape (row, column, 4).

    `number` says which of the balls it is. `path` holds centres, shape (sample, 2), `turns` the
    paint's turn at each from straight down to the right [rad]. The last channel of `out`, which
    begins at `corner`, is the share of the exposure in which the ball covers a pixel, the
    others its premultiplied colour.
    """
    rows, columns = out.shape[0], out.shape[1]
    paint = ball.paint[_own(number, ball.paint)]
    shading = ball.shading[_own(number, ball.shading)]
    half, is_shaded = (paint.shape[0] - 1) // 2, shading.shape[0] > 1
    weight = 1.0 / path.shape[0]
    reach = ball.radius + 2.0 * ball.blur
    core = max(ball.radius - 2.0 * ball.blur, 0.0) ** 2
    for k in range(path.shape[0]):
        cx, cy = path[k, 0] - corner[0], path[k, 1] - corner[1]
        cosine, sine = math.cos(turns[k]), math.sin(turns[k])
        for j in range(max(0, int(cy - reach)), min(rows, int(cy + reach) + 2)):
            dy = j - cy
            if abs(dy) >= reach:
                continue
            wide = math.sqrt(reach * reach - dy * dy)
            for i in range(max(0, int(cx - wide)), min(columns, int(cx + wide) + 2)):
                dx = i - cx
                share = weight
                if dx * dx + dy * dy > core:
                    depth = (ball.radius - math.sqrt(dx * dx + dy * dy)) / ball.blur
                    if depth <= -2.0:
                        continue
                    # A smooth edge close to the integral of a bell of standard deviation `blur`.
                    share *= 0.5 + depth * (0.375 - depth * depth * 0.03125)
                u = min(max(dx * cosine - dy * sine + half, 0.0), 2.0 * half - 1e-3)
                v = min(max(dx * sine + dy * cosine + half, 0.0), 2.0 * half - 1e-3)
                add_between(paint, v, u, share, out[j, i])
                if is_shaded:
                    u = min(max(dx + half, 0.0), 2.0 * half - 1e-3)
                    v = min(max(dy + half, 0.0), 2.0 * half - 1e-3)
                    add_between(shading, v, u, share, out[j, i])


@jit
def normal_equations(
    patch: Patch,
    layers: np.ndarray,
    centres: np.ndarray,
    pivot: np.ndarray,
    ball: Ball,
    scale: float,
) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
    """Return the robust cost, matrix and vector of the shifts of layers, and what pixels look like.

    The image is ``behind (1 - sum of shares) + sum of layers``, all in whitened colours; `layers`
    has shape (ball, row, column, 4), `centres` (ball, 2). With ``v`` the variance of the colours of
    a ball that covers a share ``a``, residuals are divided by the root of ``1 + a^2 v``; beyond
    `scale` they count less and less (Geman and McClure). The sum over a part of the pixels leaves
    out those that no layer reaches.

    The last one has shape (ball, 4): pixels of each ball, those explained, those that look like
    what is behind instead, and the ball's largest share, which decides what its pixels are.
    """
    seen, behind, corner, every = patch
    balls, rows, columns = layers.shape[0], layers.shape[1], layers.shape[2]
    matrix, vector = np.zeros((2 * balls, 2 * balls)), np.zeros(2 * balls)
    tally = np.zeros((balls, 4))
    for b in range(balls):
        for j in range(rows):
            for i in range(columns):
                if layers[b, j, i, 3] > tally[b, 3]:
                    tally[b, 3] = layers[b, j, i, 3]
    cost = 0.0
    limit = scale * scale
    slope = np.zeros((4, 3))
    rods = np.empty((balls, 2))
    for b in range(balls):
        across, down = pivot[0] - centres[b, 0], pivot[1] - centres[b, 1]
        length = math.sqrt(across**2 + down**2)
        rods[b, 0], rods[b, 1] = across / length, down / length
    for j in range(1, rows - 1):
        for i in range(3 * j % every or every, columns - 1, every):
            is_edge = _has_slope(layers, j, i)
            if every > 1 and not is_edge:
                continue
            b0, b1, b2 = behind[j, i, 0], behind[j, i, 1], behind[j, i, 2]
            d0, d1, d2 = seen[j, i, 0] - b0, seen[j, i, 1] - b1, seen[j, i, 2] - b2
            if not (d0 == d0 and b0 == b0):
                continue
            if _is_rod(corner[0] + i, corner[1] + j, centres, rods, ball.radius):
                continue
            shares, allowed = 0.0, 1.0
            r0, r1, r2 = d0, d1, d2
            for b in range(balls):
                share = layers[b, j, i, 3]
                shares += share
                if share > 0.0:
                    x, y = corner[0] + i - centres[b, 0], corner[1] + j - centres[b, 1]
                    allowed += share * share * _variance(ball, b, x, y, rods[b])
                r0 -= layers[b, j, i, 0] - share * b0
                r1 -= layers[b, j, i, 1] - share * b1
                r2 -= layers[b, j, i, 2] - share * b2
            square = r0 * r0 + r1 * r1 + r2 * r2
            robust = limit / (limit + square / allowed)
            cost += square / allowed * robust
            if shares > 0.0:
                gap = d0 * d0 + d1 * d1 + d2 * d2
                for b in range(balls):
                    if layers[b, j, i, 3] > _CORE * tally[b, 3]:
                        tally[b, 0] += 1.0
                        if square < limit:
                            tally[b, 1] += 1.0
                        if gap < square:
                            tally[b, 2] += 1.0
            if not is_edge:
                continue
            factor = robust * robust / allowed
            for b in range(balls):
                left, right = layers[b, j, i - 1], layers[b, j, i + 1]
                above, below = layers[b, j - 1, i], layers[b, j + 1, i]
                across, down = right[3] - left[3], below[3] - above[3]
                # The layer moves with its centre: its value falls by its slope.
                slope[2 * b, 0] = -0.5 * (right[0] - left[0] - b0 * across)
                slope[2 * b, 1] = -0.5 * (right[1] - left[1] - b1 * across)
                slope[2 * b, 2] = -0.5 * (right[2] - left[2] - b2 * across)
                slope[2 * b + 1, 0] = -0.5 * (below[0] - above[0] - b0 * down)
                slope[2 * b + 1, 1] = -0.5 * (below[1] - above[1] - b1 * down)
                slope[2 * b + 1, 2] = -0.5 * (below[2] - above[2] - b2 * down)
            for m in range(2 * balls):
                s0, s1, s2 = factor * slope[m, 0], factor * slope[m, 1], factor * slope[m, 2]
                vector[m] += s0 * r0 + s1 * r1 + s2 * r2
                for n in range(m + 1):
                    matrix[m, n] += s0 * slope[n, 0] + s1 * slope[n, 1] + s2 * slope[n, 2]
    for m in range(2 * balls):
        for n in range(m):
            matrix[n, m] = matrix[m, n]
    return cost, matrix, vector, tally


@jit
def _variance(ball: Ball, number: int, x: float, y: float, rod: np.ndarray) -> float:
    """Return the variance of a ball's colours at a place from its centre; `rod` points upwards."""
    half = (ball.variance.shape[1] - 1) // 2
    if ball.is_spinning:
        # Its turn from straight down has the sine -rod[0] and the cosine -rod[1].
        x, y = y * rod[0] - x * rod[1], -x * rod[0] - y * rod[1]
    i, j = math.floor(x + 0.5) + half, math.floor(y + 0.5) + half
    if i < 0 or j < 0 or i > 2 * half or j > 2 * half:
        return 0.0
    variance: float = ball.variance[_own(number, ball.variance), j, i]
    return variance


@jit
def _has_slope(layers: np.ndarray, j: int, i: int) -> bool:
    """Return whether a pixel or a neighbour is covered by any layer."""
    for b in range(layers.shape[0]):
        if (
            layers[b, j, i, 3] > 0.0
            or layers[b, j, i - 1, 3] > 0.0
            or layers[b, j, i + 1, 3] > 0.0
            or layers[b, j - 1, i, 3] > 0.0
            or layers[b, j + 1, i, 3] > 0.0
        ):
            return True
    return False


@jit
def _is_rod(x: float, y: float, centres: np.ndarray, rods: np.ndarray, radius: float) -> bool:
    """Return whether a pixel lies where a rod hides the background beside its ball.

    Rods are directions, shape (ball, 2).
    """
    for b in range(centres.shape[0]):
        ux, uy = rods[b]
        dx, dy = x - centres[b, 0], y - centres[b, 1]
        along, across = dx * ux + dy * uy, abs(dx * uy - dy * ux)
        if along > _ROD_BEGINS * radius and across < _ROD_HALF_WIDTH * radius:
            return True
    return False
