"""Compiled fit of moving balls to a window of a frame."""

from __future__ import annotations

import math

import numpy as np

from latolato.experiment.tracking.kernels.jit import jit
from latolato.experiment.tracking.kernels.layers import Ball, Patch, cover, normal_equations

# Steps below this are the last [pixels]; longer ones than this share of the smear's half length are
# cut.
_CONVERGED, _LONGEST = 0.05, 0.3


@jit
def draw(
    path: np.ndarray,
    shift: np.ndarray,
    pivot: np.ndarray,
    ball: Ball,
    number: int,
    corner: np.ndarray,
    out: np.ndarray,
) -> None:
    """Add the ball of a number, which moves along a shifted path, to `out` (row, column, 4)."""
    places, turns = np.empty((len(path), 2)), np.zeros(len(path))
    for k in range(len(path)):
        for c in range(2):
            places[k, c] = path[k, c] + shift[c]
        if ball.is_spinning:
            turns[k] = math.atan2(places[k, 0] - pivot[0], places[k, 1] - pivot[1])
    cover(places, turns, ball, number, corner, out)


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
    for round_ in range(rounds):
        layers = np.zeros((balls, rows, columns, 4), np.float32)
        for b in range(balls):
            for c in range(2):
                centres[b, c] = shift[b, c]
                for k in range(len(paths[b])):
                    centres[b, c] += paths[b][k, c] / len(paths[b])
            draw(paths[b], shift[b], pivot, ball, b, patch.corner, layers[b])
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
            smear = 0.0
            for c in range(2):
                smear += (paths[b][len(paths[b]) - 1, c] - paths[b][0, c]) ** 2
            reach = ball.radius + 0.5 * math.sqrt(smear)
            part = min(1.0, _LONGEST * reach / max(length, 1e-12))
            shift[b, 0] += part * across
            shift[b, 1] += part * down
            largest = max(largest, abs(part * across), abs(part * down))
        if scales[round_] <= scales[rounds - 1] and largest < _CONVERGED:
            break
    return cost, shift, matrix, tally
