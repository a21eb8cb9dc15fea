"""Compiled fit of moving balls to a window of a frame."""

from __future__ import annotations

import math

import numpy as np

from latolato.experiment.tracking.kernels.jit import jit
from latolato.experiment.tracking.kernels.layers import cover, normal_equations
from latolato.experiment.tracking.kernels.smears import (
    FEWEST,
    pieces_of,
    running_sum,
    step_of,
    sweep,
)

# Steps below this are the last [pixels]; longer ones than this share of the radius are cut.
_CONVERGED, _LONGEST = 0.05, 0.3
# Into how many places a sample of a path with no straight pieces is divided.
_BETWEEN = 3


@jit
def prepared(
    path: np.ndarray,
    pivot: np.ndarray,
    is_spinning: bool,
    radius: float,
    blur: float,
    paint: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return what draws a ball along a path wherever it is shifted: running sum and pieces."""
    pieces = pieces_of(path)
    if len(pieces) == 0:
        return np.zeros((1, 1, 4), np.float32), pieces
    # One sum for all pieces: a pattern turns as they do, and shading changes little.
    middle = pieces[len(pieces) // 2]
    turn = _turn(middle, pivot) if is_spinning else 0.0
    return running_sum(middle, turn, radius, blur, paint), pieces


@jit
def draw(
    path: np.ndarray,
    shift: np.ndarray,
    pivot: np.ndarray,
    is_spinning: bool,
    radius: float,
    blur: float,
    paint: np.ndarray,
    pieces: np.ndarray,
    total: np.ndarray,
    left: int,
    top: int,
    out: np.ndarray,
) -> None:
    """Add a ball that moves along a shifted path to `out`, shape (row, column, 4)."""
    if len(pieces) > 0:
        moved = np.empty(6)
        for piece in pieces:
            moved[:] = piece
            moved[:2] += shift
            sweep(moved, total, step_of(blur), left, top, out)
        return
    # A ball that turns back: between its samples it is drawn as well.
    parts = _BETWEEN if len(path) >= FEWEST else 1
    places, turns = np.empty((parts * len(path), 2)), np.zeros(parts * len(path))
    for k in range(len(places)):
        at = (k + 0.5) / parts - 0.5
        first = min(max(math.floor(at), 0), max(len(path) - 2, 0))
        second = min(first + 1, len(path) - 1)
        for c in range(2):
            gap = path[second, c] - path[first, c]
            places[k, c] = path[first, c] + (at - first) * gap + shift[c]
        if is_spinning:
            turns[k] = math.atan2(places[k, 0] - pivot[0], places[k, 1] - pivot[1])
    cover(places, turns, radius, blur, paint, left, top, out)


@jit
def settle(
    seen: np.ndarray,
    behind: np.ndarray,
    places: np.ndarray,
    ends: np.ndarray,
    pivot: np.ndarray,
    is_spinning: bool,
    radius: float,
    blur: float,
    paint: np.ndarray,
    corner: np.ndarray,
    scales: np.ndarray,
    prior: float,
    is_sparse: bool,
    shift: np.ndarray,
    matrix: np.ndarray,
    tally: np.ndarray,
) -> float:
    """Move balls until they explain what is seen (Gauss-Newton); return the robust cost.

    `places` (sample, 2) holds the centres of all balls within the exposure, those of a ball up to
    its entry in `ends`; `shift` (ball, 2) is written, and `matrix` and `tally` as of the last of
    the normal equations, of which there are as many as `scales`, or fewer.
    """
    balls, rounds = len(ends), len(scales)
    layers = np.empty((balls, seen.shape[0], seen.shape[1], 4), np.float32)
    centres, vector, step = np.empty((balls, 2)), np.empty(2 * balls), np.empty(2 * balls)
    left, top = int(corner[0]), int(corner[1])
    paths = [places[0 if b == 0 else ends[b - 1] : ends[b]] for b in range(balls)]
    ready = [prepared(path, pivot, is_spinning, radius, blur, paint) for path in paths]
    shift[:] = 0.0
    cost = 0.0
    for round_ in range(rounds):
        layers[:] = 0.0
        for b in range(balls):
            for c in range(2):
                centres[b, c] = paths[b][:, c].mean() + shift[b, c]
            total, pieces = ready[b]
            draw(
                paths[b], shift[b], pivot, is_spinning, radius, blur, paint, pieces, total, left,
                top, layers[b],
            )  # fmt: skip
        cost = normal_equations(
            seen, behind, layers, centres, pivot, radius, corner, scales[round_], is_sparse,
            matrix, vector, tally,
        )  # fmt: skip
        for m in range(2 * balls):
            matrix[m, m] += prior + 1e-9
            vector[m] -= prior * shift[m // 2, m % 2]
        if round_ == rounds - 1:
            break
        _solve(matrix, vector, step)
        largest = 0.0
        for b in range(balls):
            length = math.sqrt(step[2 * b] ** 2 + step[2 * b + 1] ** 2)
            part = min(1.0, _LONGEST * radius / max(length, 1e-12))
            for c in range(2):
                shift[b, c] += part * step[2 * b + c]
                largest = max(largest, abs(part * step[2 * b + c]))
        if scales[round_] <= scales[rounds - 1] and largest < _CONVERGED:
            break
    return cost


@jit
def _turn(piece: np.ndarray, pivot: np.ndarray) -> float:
    """Return by how much a rod is turned at the middle of a piece of its ball's path [rad]."""
    x = piece[0] + 0.5 * piece[4] * piece[2] - pivot[0]
    return math.atan2(x, piece[1] + 0.5 * piece[4] * piece[3] - pivot[1])


@jit
def _solve(matrix: np.ndarray, vector: np.ndarray, out: np.ndarray) -> None:
    """Solve symmetric, positive normal equations (Cholesky)."""
    size = len(vector)
    root = np.zeros((size, size))
    for m in range(size):
        for n in range(m + 1):
            rest = matrix[m, n]
            for k in range(n):
                rest -= root[m, k] * root[n, k]
            root[m, n] = math.sqrt(max(rest, 1e-30)) if m == n else rest / root[n, n]
    for m in range(size):
        rest = vector[m]
        for k in range(m):
            rest -= root[m, k] * out[k]
        out[m] = rest / root[m, m]
    for m in range(size - 1, -1, -1):
        rest = out[m]
        for k in range(m + 1, size):
            rest -= root[k, m] * out[k]
        out[m] = rest / root[m, m]
