"""Compiled painting: balls, rods, block and shadow in linear light, sensor noise and colour codes.

Lengths are in pixels of the undistorted picture, u to the right and v down. Edges are ramps one
pixel wide of the signed distance, so that positions are right to a small fraction of a pixel.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple, TypeVar, cast

import numba
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Image = NDArray[np.float32]
Colour = tuple[float, float, float]
Extent = tuple[float, float]
_Function = TypeVar("_Function", bound=Callable[..., Any])

# Reflected by a metal ball: what lies below, around and above, and the width of the horizon.
_FLOOR, _CEILING, _HORIZON = 0.12, 1.0, 0.35
# A rod is a cylinder: its edges are darker by this much.
_ROD_EDGE = 0.35


class Look(NamedTuple):
    """Sizes [pixel] and the light."""

    radii: tuple[float, float]
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


# Rows of the colours that `paint` takes, linear RGB; the first two are the balls'.
PATTERN, ROD, BLOCK, BOLT = range(2, 6)


def _compiled(function: _Function, **more: Any) -> _Function:
    """Compile a function with the options of all kernels, and more."""
    options: Any = {"error_model": "numpy", "fastmath": {"contract"}, "nogil": True, **more}
    return cast(_Function, numba.njit(**options)(function))


def _part(function: _Function) -> _Function:
    """Compile a part of `paint` into it.

    Handing over a `Look`, and counting references to arrays, would cost more than all painting.
    """
    return _compiled(function, forceinline=True, _nrt=False)


@_part
def _coverage(distance: float) -> float:
    """Covered part of a pixel at a signed distance from an edge."""
    return min(max(0.5 - distance, 0.0), 1.0)


@_part
def _over(colour: Colour, alpha: float, light: float, colours: Floats, row: int) -> Colour:
    """Blend one of the colours, as bright as `light`, over another colour."""
    red, green, blue = colour
    return (
        red + alpha * (light * colours[row, 0] - red),
        green + alpha * (light * colours[row, 1] - green),
        blue + alpha * (light * colours[row, 2] - blue),
    )


@_part
def _rod_square(x: float, y: float, du: float, dv: float) -> float:
    """Squared distance of a point from an axis that leads from (0, 0) to (du, dv)."""
    along = (x * du + y * dv) / max(du * du + dv * dv, 1e-9)
    along = min(max(along, 0.0), 1.0)
    x, y = x - along * du, y - along * dv
    return x * x + y * y


@_part
def _extent(
    v: float, pu: float, pv: float, bu: float, bv: float, half: float, radius: float
) -> Extent:
    """First and last u that a rod with its ball covers in a row."""
    low, high = 1e9, -1e9
    dv = bv - pv
    if abs(dv) < 1e-6:
        first, last = (0.0, 1.0) if abs(v - pv) <= half else (1.0, 0.0)
    else:
        one, other = (v - half - pv) / dv, (v + half - pv) / dv
        first, last = max(min(one, other), 0.0), min(max(one, other), 1.0)
    if first <= last:
        one, other = pu + first * (bu - pu), pu + last * (bu - pu)
        low, high = min(one, other) - half, max(one, other) + half
    if abs(v - bv) <= radius:
        chord = math.sqrt(radius * radius - (v - bv) ** 2)
        low, high = min(low, bu - chord), max(high, bu + chord)
    return low, high


@_part
def _row_extents(v: float, points: Floats, look: Look) -> tuple[Extent, Extent]:
    """First and last u that change in a row with each ball, its rod, the block and shadows.

    From left to right; the last is empty for one ball.
    """
    pu, pv = points[0, 0], points[0, 1]
    tilt, lean = abs(look.cosine), abs(look.sine)
    block_u = max(tilt * look.block_u + lean * look.block_v, look.bolt) + 1.0
    block_v = max(lean * look.block_u + tilt * look.block_v, look.bolt) + 1.0
    soft = 0.5 * look.softness + 1.0
    left = right = (1e9, -1e9)
    for ball in range(1, len(points)):
        bu, bv, radius = points[ball, 0], points[ball, 1], look.radii[ball - 1]
        low, high = _extent(v, pu, pv, bu, bv, look.rod + 1.0, radius + 1.0)
        if abs(v - pv) <= block_v:
            low, high = min(low, pu - block_u), max(high, pu + block_u)
        if look.shadow > 0.0:
            first, last = _extent(v - look.shadow_v, pu, pv, bu, bv, look.rod + soft, radius + soft)
            low, high = min(low, first + look.shadow_u), max(high, last + look.shadow_u)
        left, right = ((low, high), left) if low < left[0] else (left, (low, high))
    return left, right


@_part
def _shade(n_u: float, n_v: float, look: Look) -> tuple[float, float]:
    """Reflected part of the colour, and white highlight, of a sphere."""
    n_w = math.sqrt(max(1.0 - n_u * n_u - n_v * n_v, 0.0))
    facing = n_u * look.light_u + n_v * look.light_v + n_w * look.light_w
    matt = look.ambient + (1.0 - look.ambient) * max(facing, 0.0)
    up = -2.0 * n_w * n_v  # of the mirrored line of sight
    part = min(max(0.5 + 0.5 * up / _HORIZON, 0.0), 1.0)
    mirror = _FLOOR + (_CEILING - _FLOOR) * part * part * (3.0 - 2.0 * part)
    mirror *= 0.55 + 0.45 * n_w
    half = (facing + n_w) / math.sqrt(2.0 + 2.0 * look.light_w)
    highlight = look.gloss * max(half, 0.0) ** 32
    return (1.0 - look.metal) * matt + look.metal * mirror, highlight


@_part
def _painted(colour: Colour, u: float, v: float, points: Floats, look: Look,
             colours: Floats) -> Colour:  # fmt: skip
    """Colour of a pixel of the wall with everything in front of it."""
    # From here on all places are relative to the pivot.
    x, y = u - points[0, 0], v - points[0, 1]
    # The shadow of rods and balls takes light from the wall, less towards its soft edge.
    if look.shadow > 0.0:
        dark = 0.0
        su, sv = x - look.shadow_u, y - look.shadow_v
        for ball in range(1, len(points)):
            bu, bv = points[ball, 0] - points[0, 0], points[ball, 1] - points[0, 1]
            radius = look.radii[ball - 1]
            distance, soft = 1e9, 0.5 * look.softness
            square = _rod_square(su, sv, bu, bv)
            if square < (look.rod + soft) ** 2:
                distance = math.sqrt(square) - look.rod
            square = (su - bu) ** 2 + (sv - bv) ** 2
            if square < (radius + soft) ** 2:
                distance = min(distance, math.sqrt(square) - radius)
            part = min(max(0.5 - distance / look.softness, 0.0), 1.0)
            dark = max(dark, part * part * (3.0 - 2.0 * part))
        left = 1.0 - look.shadow * dark
        colour = (colour[0] * left, colour[1] * left, colour[2] * left)
    # The block that carries the pivot turns with the camera.
    if (
        min(look.block_u, look.block_v) > 0.0
        and x * x + y * y < (look.block_u + look.block_v + 1.0) ** 2
    ):
        across, down = look.cosine * x - look.sine * y, look.sine * x + look.cosine * y
        part = _coverage(abs(across) - look.block_u) * _coverage(abs(down) - look.block_v)
        colour = _over(colour, part, 1.0 - 0.25 * down / look.block_v, colours, BLOCK)
    # Rods are cylinders: darker towards their edges.
    if look.rod > 0.0:
        half = max(look.rod, 0.5)
        for ball in range(1, len(points)):
            bu, bv = points[ball, 0] - points[0, 0], points[ball, 1] - points[0, 1]
            square = _rod_square(x, y, bu, bv)
            if square >= (half + 0.5) ** 2:
                continue
            distance = math.sqrt(square)
            # a rod thinner than a pixel never covers one
            part = _coverage(distance - half) * min(2.0 * look.rod, 1.0)
            light = 1.0 - _ROD_EDGE * min(distance / half, 1.0) ** 2
            colour = _over(colour, part, light, colours, ROD)
    if look.bolt > 0.0 and x * x + y * y < (look.bolt + 0.5) ** 2:
        part = _coverage(math.sqrt(x * x + y * y) - look.bolt)
        colour = _over(colour, part, 1.0, colours, BOLT)
    for ball in range(1, len(points)):
        bu, bv = points[ball, 0] - points[0, 0], points[ball, 1] - points[0, 1]
        radius = look.radii[ball - 1]
        au, av = x - bu, y - bv
        square = au * au + av * av
        if square >= (radius + 0.5) ** 2:
            continue
        part = _coverage(math.sqrt(square) - radius)
        # Lambert's law with a highlight; the band lies across the rod.
        light, highlight = _shade(au / radius, av / radius, look)
        row = ball - 1
        own = (colours[row, 0], colours[row, 1], colours[row, 2])
        if look.pattern > 0.0:
            along = (au * bu + av * bv) / max(math.sqrt(bu * bu + bv * bv), 1e-9)
            own = _over(own, _coverage(abs(along) - look.pattern * radius), 1.0, colours, PATTERN)
        red, green, blue = colour
        colour = (
            red + part * (light * own[0] + highlight - red),
            green + part * (light * own[1] + highlight - green),
            blue + part * (light * own[2] + highlight - blue),
        )
    return colour


@partial(_compiled, cache=True, _nrt=False)
def paint(
    total: Image,
    corner: tuple[int, int],
    wall: Image,
    states: Floats,
    axis: int,
    maps: tuple[Image, Image],
    look: Look,
    colours: Floats,
) -> None:
    """Add to `total` what each moment changes in `wall`, both of shape (rows, columns, 3).

    `states` has the shape (moment, line, point, 2): u and v of the pivot and of each ball; a line
    is a row (`axis` 0) or a column (1) of the picture that a rolling shutter reads, or there is
    only one. The maps give each pixel of the picture its undistorted place; they are empty where
    each pixel is at its own.
    """
    rows, columns = total.shape[0], total.shape[1]
    is_rolling, is_plain = states.shape[1] > 1, maps[0].size == 0
    for moment in range(states.shape[0]):
        for row in range(rows):
            points = states[moment, corner[1] + row if is_rolling and axis == 0 else 0]
            extents = ((0.0, 1e9), (1e9, -1e9))
            if is_plain and not (is_rolling and axis == 1):
                extents = _row_extents(float(corner[1] + row), points, look)
            done = 0  # columns to the left of it
            for low, high in extents:
                first = max(math.floor(max(low - corner[0], 0.0)), done)
                done = max(math.ceil(min(high - corner[0], columns - 1.0)) + 1, done)
                for column in range(first, done):
                    i, j = corner[1] + row, corner[0] + column
                    if is_rolling and axis == 1:
                        points = states[moment, j]
                    u, v = float(j), float(i)
                    if not is_plain:
                        u, v = float(maps[0][i, j]), float(maps[1][i, j])
                    red = float(wall[row, column, 0])
                    green = float(wall[row, column, 1])
                    blue = float(wall[row, column, 2])
                    colour = _painted((red, green, blue), u, v, points, look, colours)
                    total[row, column, 0] += np.float32(colour[0] - red)
                    total[row, column, 1] += np.float32(colour[1] - green)
                    total[row, column, 2] += np.float32(colour[2] - blue)


@partial(_compiled, cache=True)
def develop(
    picture: Image,
    gain: Image,
    noise: Image,
    offsets: NDArray[np.int64],
    shot: float,
    read: float,
    codes: Image,
    luma: NDArray[np.uint8],
    chroma: NDArray[np.uint8],
) -> None:
    """Turn linear light into the 8-bit planes of BT.709: noise, tone curve, YUV 4:2:0.

    `noise` holds normal numbers, read from the row's offset on; the noise of a value x in [0, 1]
    is ``sqrt(shot x + read)``.
    """
    rows, columns = picture.shape[0], picture.shape[1]
    top = len(codes) - 1
    halves = np.zeros((columns // 2, 2), np.float32)
    for i in range(rows):
        at = offsets[i]
        for j in range(columns):
            light = gain[i, j]
            r, g, b = light * picture[i, j, 0], light * picture[i, j, 1], light * picture[i, j, 2]
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
                chroma[0, i >> 1, j] = np.uint8(128.5 + halves[j, 0])
                chroma[1, i >> 1, j] = np.uint8(128.5 + halves[j, 1])
            halves[:] = 0.0
