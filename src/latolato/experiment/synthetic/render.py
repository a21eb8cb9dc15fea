"""Compiled painting: balls, rods, block and shadow in linear light, sensor noise and colour codes.

Lengths are in pixels of the undistorted picture, u to the right and v down. Edges are ramps one
pixel wide of the signed distance, so that positions are right to a small fraction of a pixel.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Image = NDArray[np.float32]

# Reflected by a metal ball: what lies below, around and above, and the width of the horizon.
_FLOOR, _CEILING, _HORIZON = 0.12, 1.0, 0.35
# A rod is a cylinder: its edges are darker by this much.
_ROD_EDGE = 0.35


class Look(NamedTuple):
    """Sizes [pixel] and the light, all floats."""

    radius_1: float
    radius_2: float
    rod: float
    block_u: float
    block_v: float
    bolt: float
    cosine: float
    sine: float
    light_u: float
    light_v: float
    light_w: float
    ambient: float
    gloss: float
    metal: float
    pattern: float
    shadow: float
    shadow_u: float
    shadow_v: float
    softness: float


# Rows of the colours that `paint` takes, linear RGB.
BALL_1, BALL_2, PATTERN, ROD, BLOCK, BOLT = range(6)


def _make_paint(compile_part: Callable[..., Any]) -> Callable[..., None]:
    """Fold the parts of `paint`."""

    @compile_part
    def ramp(distance: float) -> float:
        """Return the covered part of a pixel at a signed distance from an edge."""
        return min(max(0.5 - distance, 0.0), 1.0)

    @compile_part
    def rod_square(x: float, y: float, du: float, dv: float, share: float) -> float:
        """Return the squared distance of a point from an axis; both from one end of it.

        `du` and `dv` lead to the other end, `share` is one over their squared length.
        """
        along = min(max((x * du + y * dv) * share, 0.0), 1.0)
        x, y = x - along * du, y - along * dv
        return x * x + y * y

    @compile_part
    def reach(
        v: float, px: float, py: float, bx: float, by: float, half: float, radius: float
    ) -> tuple[float, float]:
        """Return the first and last u that a rod with its ball covers in a row."""
        low, high = 1e9, -1e9
        dv = by - py
        if abs(dv) < 1e-6:
            first, last = (0.0, 1.0) if abs(v - py) <= half else (1.0, 0.0)
        else:
            one, other = (v - half - py) / dv, (v + half - py) / dv
            first, last = max(min(one, other), 0.0), min(max(one, other), 1.0)
        if first <= last:
            one, other = px + first * (bx - px), px + last * (bx - px)
            low, high = min(one, other) - half, max(one, other) + half
        if abs(v - by) <= radius:
            chord = math.sqrt(radius * radius - (v - by) ** 2)
            low, high = min(low, bx - chord), max(high, bx + chord)
        return low, high

    @compile_part
    def shade(n_u: float, n_v: float, look: Any) -> tuple[float, float]:
        """Return (reflected part of the colour, white highlight) of a sphere."""
        n_w = math.sqrt(max(1.0 - n_u * n_u - n_v * n_v, 0.0))
        facing = n_u * look.light_u + n_v * look.light_v + n_w * look.light_w
        matt = look.ambient + (1.0 - look.ambient) * max(facing, 0.0)
        up = -2.0 * n_w * n_v  # of the mirrored line of sight
        part = min(max(0.5 + 0.5 * up / _HORIZON, 0.0), 1.0)
        mirror = _FLOOR + (_CEILING - _FLOOR) * part * part * (3.0 - 2.0 * part)
        mirror *= 0.55 + 0.45 * n_w
        half = (facing + n_w) / math.sqrt(2.0 + 2.0 * look.light_w)
        power = max(half, 0.0) ** 2
        power *= power  # to the power 32 in all
        power *= power
        power *= power
        highlight = look.gloss * power * power
        return (1.0 - look.metal) * matt + look.metal * mirror, highlight

    @compile_part
    def see(
        states: Floats, moment: int, line: int, balls: int, ends: Floats
    ) -> tuple[float, float]:
        """Write where the balls are in a line, shape (ball, 2); return where the pivot is."""
        for ball in range(balls):
            ends[ball, 0] = states[moment, line, 2 + 2 * ball]
            ends[ball, 1] = states[moment, line, 3 + 2 * ball]
        return states[moment, line, 0], states[moment, line, 1]

    @compile_part
    def cross(
        v: float,
        pu: float,
        pv: float,
        ends: Floats,
        balls: int,
        radii: tuple[float, float],
        block_u: float,
        block_v: float,
        look: Any,
        spans: Floats,
    ) -> int:
        """Write first and last u of what may change in a row, from left to right; return how many.

        Block, rods with their balls, and their shadows.
        """
        soft = 0.5 * look.softness + 1.0
        count = 0
        if abs(v - pv) <= block_v:
            spans[0, 0], spans[0, 1] = pu - block_u, pu + block_u
            count = 1
        for ball in range(balls):
            bu, bv = ends[ball, 0], ends[ball, 1]
            low, high = reach(v, pu, pv, bu, bv, look.rod + 1.0, radii[ball] + 1.0)
            spans[count, 0], spans[count, 1] = low, high
            count += 1
            if look.shadow > 0.0:
                low, high = reach(
                    v - look.shadow_v, pu, pv, bu, bv, look.rod + soft, radii[ball] + soft
                )
                spans[count, 0] = low + look.shadow_u
                spans[count, 1] = high + look.shadow_u
                count += 1
        for i in range(1, count):
            for j in range(i, 0, -1):
                if spans[j, 0] < spans[j - 1, 0]:
                    for k in range(2):
                        one = spans[j, k]
                        spans[j, k] = spans[j - 1, k]
                        spans[j - 1, k] = one
        return count

    def paint(
        total: Image,
        corner_u: int,
        corner_v: int,
        wall: Image,
        states: Floats,
        balls: int,
        axis: int,
        flip: int,
        is_plain: bool,
        map_u: Image,
        map_v: Image,
        look: Any,
        colours: Floats,
    ) -> None:
        """Add to `total` what each moment changes in `wall`, both of shape (rows, columns, 3).

        `states` has the shape (moment, line, 6): pivot, ball 1 and ball 2, u and v of each; a line
        is a stored row of a rolling shutter (`axis` 0: v, 1: u, from the other end with `flip`), or
        there is only one. Without `is_plain` the maps give each pixel its undistorted place.
        """
        rows, columns = total.shape[0], total.shape[1]
        lines = states.shape[1]
        radii = (look.radius_1, look.radius_2)
        soft = 0.5 * look.softness + 1.0
        tilt, lean = abs(look.cosine), abs(look.sine)
        block_u = max(tilt * look.block_u + lean * look.block_v, look.bolt) + 1.0
        block_v = max(lean * look.block_u + tilt * look.block_v, look.bolt) + 1.0
        spans, ends = np.empty((5, 2)), np.empty((2, 2))
        near_rod, near_soft = (max(look.rod, 0.5) + 0.5) ** 2, (look.rod + soft) ** 2
        whole = (axis == 1 and lines > 1) or not is_plain
        for moment in range(states.shape[0]):
            for row in range(rows):
                line = 0
                if lines > 1 and axis == 0:
                    line = corner_v + row
                    line = lines - 1 - line if flip else line
                pu, pv = see(states, moment, line, balls, ends)
                spans[0, 0], spans[0, 1] = 0.0, columns - 1.0
                count = 1
                if not whole:
                    v = float(corner_v + row)
                    count = cross(v, pu, pv, ends, balls, radii, block_u, block_v, look, spans)
                    for i in range(count):
                        spans[i, 0] -= corner_u
                        spans[i, 1] -= corner_u
                seen = 0  # columns to the left of it are done
                span = -1
                column = last = -1
                while True:
                    column += 1
                    while column > last:
                        span += 1
                        if span == count:
                            break
                        column = max(math.floor(max(spans[span, 0], 0.0)), seen)
                        last = math.ceil(min(spans[span, 1], columns - 1.0))
                    if span == count:
                        break
                    seen = column + 1
                    if lines > 1 and axis == 1:
                        line = corner_u + column
                        line = lines - 1 - line if flip else line
                        pu, pv = see(states, moment, line, balls, ends)
                    x, y = float(corner_u + column), float(corner_v + row)
                    if not is_plain:
                        i, j = corner_v + row, corner_u + column
                        x, y = float(map_u[i, j]), float(map_v[i, j])
                    red = old_red = float(wall[row, column, 0])
                    green = old_green = float(wall[row, column, 1])
                    blue = old_blue = float(wall[row, column, 2])
                    x, y = x - pu, y - pv  # from here on all is seen from the pivot
                    if look.shadow > 0.0:
                        dark = 0.0
                        su, sv = x - look.shadow_u, y - look.shadow_v
                        for ball in range(balls):
                            bu, bv, reached = ends[ball, 0] - pu, ends[ball, 1] - pv, 1e9
                            square = rod_square(su, sv, bu, bv, 1.0 / max(bu * bu + bv * bv, 1e-9))
                            if square < near_soft:
                                reached = math.sqrt(square) - look.rod
                            square = (su - bu) ** 2 + (sv - bv) ** 2
                            if square < (radii[ball] + soft) ** 2:
                                reached = min(reached, math.sqrt(square) - radii[ball])
                            part = min(max(0.5 - reached / look.softness, 0.0), 1.0)
                            dark = max(dark, part * part * (3.0 - 2.0 * part))
                        left = 1.0 - look.shadow * dark
                        red, green, blue = red * left, green * left, blue * left
                    if look.block_u > 0.0 and abs(x) <= block_u and abs(y) <= block_v:
                        across = look.cosine * x - look.sine * y
                        down = look.sine * x + look.cosine * y
                        part = ramp(abs(across) - look.block_u) * ramp(abs(down) - look.block_v)
                        light = 1.0 - 0.25 * down / look.block_v
                        red += part * (light * colours[BLOCK, 0] - red)
                        green += part * (light * colours[BLOCK, 1] - green)
                        blue += part * (light * colours[BLOCK, 2] - blue)
                    if look.rod > 0.0:
                        for ball in range(balls):
                            bu, bv = ends[ball, 0] - pu, ends[ball, 1] - pv
                            square = rod_square(x, y, bu, bv, 1.0 / max(bu * bu + bv * bv, 1e-9))
                            if square >= near_rod:
                                continue
                            away = math.sqrt(square)
                            # a rod thinner than a pixel never covers one
                            part = ramp(away - max(look.rod, 0.5)) * min(2.0 * look.rod, 1.0)
                            edge = min(away / max(look.rod, 0.5), 1.0)
                            light = 1.0 - _ROD_EDGE * edge * edge
                            red += part * (light * colours[ROD, 0] - red)
                            green += part * (light * colours[ROD, 1] - green)
                            blue += part * (light * colours[ROD, 2] - blue)
                    square = x * x + y * y
                    if look.bolt > 0.0 and square < (look.bolt + 0.5) ** 2:
                        part = ramp(math.sqrt(square) - look.bolt)
                        red += part * (colours[BOLT, 0] - red)
                        green += part * (colours[BOLT, 1] - green)
                        blue += part * (colours[BOLT, 2] - blue)
                    for ball in range(balls):
                        bu, bv, radius = ends[ball, 0] - pu, ends[ball, 1] - pv, radii[ball]
                        au, av = x - bu, y - bv
                        square = au * au + av * av
                        if square >= (radius + 0.5) ** 2:
                            continue
                        part = ramp(math.sqrt(square) - radius)
                        light, highlight = shade(au / radius, av / radius, look)
                        mix = 0.0
                        if look.pattern > 0.0:
                            size = math.sqrt(max(bu * bu + bv * bv, 1e-9))
                            along = (au * bu + av * bv) / size
                            mix = ramp(abs(along) - look.pattern * radius)
                        own = BALL_1 + ball
                        r = (1.0 - mix) * colours[own, 0] + mix * colours[PATTERN, 0]
                        g = (1.0 - mix) * colours[own, 1] + mix * colours[PATTERN, 1]
                        b = (1.0 - mix) * colours[own, 2] + mix * colours[PATTERN, 2]
                        red += part * (light * r + highlight - red)
                        green += part * (light * g + highlight - green)
                        blue += part * (light * b + highlight - blue)
                    total[row, column, 0] += np.float32(red - old_red)
                    total[row, column, 1] += np.float32(green - old_green)
                    total[row, column, 2] += np.float32(blue - old_blue)

    return paint


def _make_blur(compile_part: Callable[..., Any]) -> Callable[..., None]:
    """Make `blur`; it has no parts."""

    def blur(image: Image, work: Image, weights: Image) -> None:
        """Blur an image in place by a symmetric kernel; its edges are continued."""
        rows, columns, channels = image.shape
        half = len(weights) // 2
        for i in range(rows):
            for j in range(columns):
                for c in range(channels):
                    value = np.float32(0.0)
                    if half <= j < columns - half:
                        for k in range(-half, half + 1):
                            value += weights[k + half] * image[i, j + k, c]
                    else:
                        for k in range(-half, half + 1):
                            at = min(max(j + k, 0), columns - 1)
                            value += weights[k + half] * image[i, at, c]
                    work[i, j, c] = value
        for i in range(rows):
            image[i] = np.float32(0.0)
            for k in range(-half, half + 1):
                at = min(max(i + k, 0), rows - 1)
                weight = weights[k + half]
                for j in range(columns):
                    for c in range(channels):
                        image[i, j, c] += weight * work[at, j, c]

    return blur


def _make_develop(compile_part: Callable[..., Any]) -> Callable[..., None]:
    """Make `develop`; it has no parts."""

    def develop(
        wall: Image,
        part: Image,
        corner_u: int,
        corner_v: int,
        gain: Image,
        noise: Image,
        offsets: NDArray[np.int64],
        shot: float,
        read: float,
        codes: Image,
        luma: NDArray[np.uint8],
        chroma_u: NDArray[np.uint8],
        chroma_v: NDArray[np.uint8],
    ) -> None:
        """Turn linear light into the 8-bit planes of BT.709: noise, tone curve, YUV 4:2:0.

        `part` stands in the picture `wall` at its corner. `noise` holds normal numbers, read from
        the row's offset on; the noise of a value x in [0, 1] is ``sqrt(shot x + read)``.
        """
        rows, columns = wall.shape[0], wall.shape[1]
        end_u, end_v = corner_u + part.shape[1], corner_v + part.shape[0]
        top = len(codes) - 1
        halves = np.zeros((columns // 2, 2), np.float32)
        for i in range(rows):
            at = offsets[i]
            inside = corner_v <= i < end_v
            for j in range(columns):
                r, g, b = wall[i, j, 0], wall[i, j, 1], wall[i, j, 2]
                if inside and corner_u <= j < end_u:
                    k, m = i - corner_v, j - corner_u
                    r, g, b = part[k, m, 0], part[k, m, 1], part[k, m, 2]
                light = gain[i, j]
                r, g, b = light * r, light * g, light * b
                r += noise[at] * math.sqrt(shot * max(r, 0.0) + read)
                g += noise[at + 1] * math.sqrt(shot * max(g, 0.0) + read)
                b += noise[at + 2] * math.sqrt(shot * max(b, 0.0) + read)
                at += 3
                r = codes[int(min(max(r, 0.0), 1.0) * top + 0.5)]
                g = codes[int(min(max(g, 0.0), 1.0) * top + 0.5)]
                b = codes[int(min(max(b, 0.0), 1.0) * top + 0.5)]
                y = 0.2126 * r + 0.7152 * g + 0.0722 * b
                luma[i, j] = np.uint8(16.5 + 219.0 * y)
                halves[j >> 1, 0] += (b - y) * (0.25 * 224.0 / 1.8556)
                halves[j >> 1, 1] += (r - y) * (0.25 * 224.0 / 1.5748)
            if i & 1:
                for j in range(columns // 2):
                    chroma_u[i >> 1, j] = np.uint8(128.5 + halves[j, 0])
                    chroma_v[i >> 1, j] = np.uint8(128.5 + halves[j, 1])
                halves[:] = 0.0

    return develop


_KERNELS = {"paint": _make_paint, "blur": _make_blur, "develop": _make_develop}


@lru_cache(maxsize=len(_KERNELS))
def kernel(name: str) -> Callable[..., Any]:
    """Return `paint`, `blur` or `develop`, compiled and kept on disk."""
    from latolato.numerics.jit import compile_kernel

    # The disk cache knows the sources of kernel layers, and this file is in none of them.
    mark = hashlib.sha256(Path(__file__).read_bytes()).hexdigest()[:16]
    return compile_kernel(_KERNELS[name], f"render.{name}.{mark}")
