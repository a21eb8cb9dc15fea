"""Compiled fit of moving balls to a window of a frame."""

from __future__ import annotations

import math

import numpy as np

from latolato.experiment.tracking.kernels.jit import jit
from latolato.experiment.tracking.kernels.layers import Ball, Patch, cover, normal_equations
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
def prepared(path: np.ndarray, pivot: np.ndarray, ball: Ball) -> tuple[np.ndarray, np.ndarray]:
    """A ball's running sum and a path's pieces, to draw it wherever the path is shifted."""
    pieces = pieces_of(path)
    if len(pieces) == 0:
        return np.zeros((1, 1, 4), np.float32), pieces
    # One sum for all pieces: a pattern turns as they do, and shading changes little.
    middle = pieces[len(pieces) // 2]
    x = middle[0] + 0.5 * middle[4] * middle[2] - pivot[0]
    y = middle[1] + 0.5 * middle[4] * middle[3] - pivot[1]
    return running_sum(middle, math.atan2(x, y) if ball.is_spinning else 0.0, ball), pieces


@jit
def draw(
    path: np.ndarray,
    shift: np.ndarray,
    pivot: np.ndarray,
    ball: Ball,
    ready: tuple[np.ndarray, np.ndarray],
    corner: np.ndarray,
    out: np.ndarray,
) -> None:
    """Add a ball that moves along a shifted path to `out`, shape (row, column, 4).

    `ready` is what `prepared` made of it.
    """
    total, pieces = ready
    if len(pieces) > 0:
        moved = np.empty(6)
        for p in range(len(pieces)):
            for c in range(6):
                moved[c] = pieces[p, c] + (shift[c] if c < 2 else 0.0)
            sweep(moved, total, step_of(ball.blur), corner, out)
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
        if ball.is_spinning:
            turns[k] = math.atan2(places[k, 0] - pivot[0], places[k, 1] - pivot[1])
    cover(places, turns, ball, corner, out)


@jit
def _solve(matrix: np.ndarray, vector: np.ndarray) -> None:
    """Replace `vector` by the solution of a positive definite system; `matrix` is used up."""
    size = len(vector)
    for k in range(size):
        for m in range(k + 1, size):
            factor = matrix[m, k] / matrix[k, k]
            for n in range(k, size):
                matrix[m, n] -= factor * matrix[k, n]
            vector[m] -= factor * vector[k]
    for k in range(size - 1, -1, -1):
        for n in range(k + 1, size):
            vector[k] -= matrix[k, n] * vector[n]
        vector[k] /= matrix[k, k]


@jit
def settle(
    patch: Patch,
    places: np.ndarray,
    ends: np.ndarray,
    pivot: np.ndarray,
    ball: Ball,
    scales: np.ndarray,
) -> tuple[float, np.ndarray, np.ndarray, np.ndarray]:
    """Move balls until they explain what is seen (Gauss-Newton).

    Returns the robust cost, the shifts (ball, 2), and matrix and tally of the last of the
    `normal_equations`, of which there are as many as `scales`, or fewer. `places` (sample, 2)
    holds the centres of all balls within the exposure, those of a ball up to its entry in `ends`.
    """
    balls, rounds = len(ends), len(scales)
    rows, columns, _ = patch.seen.shape
    centres, shift = np.empty((balls, 2)), np.zeros((balls, 2))
    paths = [places[0 if b == 0 else ends[b - 1] : ends[b]] for b in range(balls)]
    ready = [prepared(path, pivot, ball) for path in paths]
    for round_ in range(rounds):
        layers = np.zeros((balls, rows, columns, 4), np.float32)
        for b in range(balls):
            for c in range(2):
                centres[b, c] = shift[b, c]
                for k in range(len(paths[b])):
                    centres[b, c] += paths[b][k, c] / len(paths[b])
            draw(paths[b], shift[b], pivot, ball, ready[b], patch.corner, layers[b])
        cost, matrix, vector, tally = normal_equations(
            patch, layers, centres, pivot, ball, scales[round_]
        )
        for m in range(2 * balls):
            matrix[m, m] += 1e-9
        if round_ == rounds - 1:
            break
        _solve(matrix.copy(), vector)
        largest = 0.0
        for b in range(balls):
            across, down = vector[2 * b], vector[2 * b + 1]
            length = math.sqrt(across**2 + down**2)
            part = min(1.0, _LONGEST * ball.radius / max(length, 1e-12))
            shift[b, 0] += part * across
            shift[b, 1] += part * down
            largest = max(largest, abs(part * across), abs(part * down))
        if scales[round_] <= scales[rounds - 1] and largest < _CONVERGED:
            break
    return cost, shift, matrix, tally
