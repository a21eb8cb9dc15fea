"""Compiled inner loops of the pivot's template: moved, smeared, compared, shifted."""

from __future__ import annotations

import math

import numpy as np

from latolato.experiment.tracking.kernels.jit import jit

# Steps below this are the last [pixels], and the most of them.
_CONVERGED, _ROUNDS = 2e-3, 6


@jit
def _cubic(s: float) -> tuple[float, float, float, float]:
    """Return Keys' cubic convolution weights of the four neighbours at `s` between two pixels."""
    return (
        ((-0.5 * s + 1.0) * s - 0.5) * s,
        (1.5 * s - 2.5) * s * s + 1.0,
        ((-1.5 * s + 2.0) * s + 0.5) * s,
        (0.5 * s - 0.5) * s * s,
    )


@jit
def resample(plane: np.ndarray, left: float, top: float, out: np.ndarray) -> None:
    """Write the plane's values at (left + column, top + row) into `out`, cubic convolution."""
    i0, j0 = math.floor(left), math.floor(top)
    a0, a1, a2, a3 = _cubic(left - i0)
    b0, b1, b2, b3 = _cubic(top - j0)
    height, width = plane.shape
    rows, columns = out.shape
    line = np.empty(columns + 3)
    across = np.empty((rows + 3, columns))
    for j in range(rows + 3):
        y = min(max(j0 + j - 1, 0), height - 1)
        for i in range(columns + 3):
            line[i] = plane[y, min(max(i0 + i - 1, 0), width - 1)]
        for i in range(columns):
            across[j, i] = a0 * line[i] + a1 * line[i + 1] + a2 * line[i + 2] + a3 * line[i + 3]
    for j in range(rows):
        for i in range(columns):
            out[j, i] = (
                b0 * across[j, i]
                + b1 * across[j + 1, i]
                + b2 * across[j + 2, i]
                + b3 * across[j + 3, i]
            )


@jit
def smeared(template: np.ndarray, across: float, down: float, count: int) -> np.ndarray:
    """Return a template averaged over `count` places along a motion."""
    rows, columns = template.shape
    total, part = np.zeros((rows, columns)), np.empty((rows, columns))
    for k in range(count):
        share = (k + 0.5) / count - 0.5
        resample(template, -share * across, -share * down, part)
        for j in range(rows):
            for i in range(columns):
                total[j, i] += part[j, i] / count
    return total


@jit
def refine_shift(
    plane: np.ndarray,
    model: np.ndarray,
    weight: np.ndarray,
    limit: float,
    corner: np.ndarray,
    shift: np.ndarray,
) -> float:
    """Move `shift` until the model, moved by it from `corner`, fits (Gauss-Newton).

    Returns the robust cost; infinite beyond the frame.
    """
    rows, columns = model.shape
    moved = np.empty((rows, columns))
    cost = np.inf
    for _ in range(_ROUNDS):
        x, y = corner[0] + shift[0], corner[1] + shift[1]
        x0, y0 = int(np.rint(x)), int(np.rint(y))
        if x0 < 0 or y0 < 0 or x0 + columns > plane.shape[1] or y0 + rows > plane.shape[0]:
            return np.inf
        resample(model, x0 - x, y0 - y, moved)
        cost, vx, vy, xx, xy, yy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(1, rows - 1):
            for i in range(1, columns - 1):
                if weight[j, i] <= 0.0:
                    continue
                r = plane[y0 + j, x0 + i] - moved[j, i]
                robust = 1.0 / (1.0 + weight[j, i] * r * r / limit)
                cost += weight[j, i] * r * r * robust
                factor = weight[j, i] * robust * robust
                sx = -0.5 * (moved[j, i + 1] - moved[j, i - 1])
                sy = -0.5 * (moved[j + 1, i] - moved[j - 1, i])
                vx += factor * sx * r
                vy += factor * sy * r
                xx += factor * sx * sx
                xy += factor * sx * sy
                yy += factor * sy * sy
        slack = 1e-9 + 1e-6 * (xx + yy)
        xx, yy = xx + slack, yy + slack
        size = xx * yy - xy * xy
        dx = min(max((yy * vx - xy * vy) / size, -1.0), 1.0)
        dy = min(max((xx * vy - xy * vx) / size, -1.0), 1.0)
        shift[0] += dx
        shift[1] += dy
        if max(abs(dx), abs(dy)) < _CONVERGED:
            break
    return cost


@jit
def search_shift(
    plane: np.ndarray,
    model: np.ndarray,
    weight: np.ndarray,
    corners: np.ndarray,
    limit: float,
    stride: int,
    out: np.ndarray,
) -> None:
    """Write the robust difference between `model` and the plane at each whole-pixel corner.

    Every `stride`-th pixel is looked at.
    """
    height, width = np.uint64(plane.shape[0]), np.uint64(plane.shape[1])
    most = (model.shape[0] // stride + 1) * (model.shape[1] // stride + 1)
    column, row = np.empty(most, np.int64), np.empty(most, np.int64)
    value, share = np.empty(most, np.float32), np.empty(most, np.float32)
    count = 0
    for j in range(0, model.shape[0], stride):
        for i in range(0, model.shape[1], stride):
            if weight[j, i] > 0.0:
                column[count], row[count] = i, j
                value[count], share[count] = model[j, i], weight[j, i] / limit
                count += 1
    one = np.float32(1.0)
    for k in range(corners.shape[0]):
        left, top = corners[k, 0], corners[k, 1]
        is_inside = (
            left >= 0
            and top >= 0
            and left + model.shape[1] <= width
            and top + model.shape[0] <= height
        )
        cost = np.float32(0.0)
        for n in range(count):
            # Without a sign numbers do not count from the end; negative ones lie beyond it.
            x, y = np.uint64(left + column[n]), np.uint64(top + row[n])
            if not is_inside and (x >= width or y >= height):
                cost += one
                continue
            r = np.float32(plane[y, x]) - value[n]
            square = share[n] * r * r
            cost += square / (one + square)
        out[k] = cost / max(count, 1)
