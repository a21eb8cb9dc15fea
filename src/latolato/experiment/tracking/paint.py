"""Colours of balls and background, taken from frames."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import distance_transform_edt, map_coordinates

from latolato.experiment.tracking.appearance import Appearance, Colours
from latolato.experiment.video import Frame


def uncover(
    behind: np.ndarray,
    low: np.ndarray,
    frame: Frame,
    colours: Colours,
    centre: np.ndarray,
    radius: float,
) -> None:
    """Mark the background as unseen where it shows the ball itself, which rested there mostly."""
    j, i = np.indices(behind.shape[:2])
    away = np.hypot(i + low[0] - centre[0], j + low[1] - centre[1])
    picture = colours.window(frame[2:], low, behind.shape[:2])
    inside = away < 0.8 * radius
    outside = (away > 1.3 * radius) & (away < 1.7 * radius)
    if not inside.any() or not outside.any():
        return
    own = np.nanmedian(np.abs(behind - picture)[inside].sum(axis=-1))
    wall = np.nanmedian(behind[outside], axis=0)
    contrast = np.nanmedian(np.abs(behind - wall)[inside].sum(axis=-1))
    if own < 0.5 * contrast:
        behind[away < 1.25 * radius] = np.nan


def filled(behind: np.ndarray) -> np.ndarray:
    """Return the background with unseen places filled from their nearest neighbours."""
    unseen = ~np.isfinite(behind).all(axis=-1)
    if not unseen.any() or unseen.all():
        return behind
    at = distance_transform_edt(unseen, return_distances=False, return_indices=True)
    filled: np.ndarray = behind[tuple(at)]
    return filled


def first_paint(
    frame: Frame, centres: list[np.ndarray], turns: np.ndarray, colours: Colours, radius: float
) -> np.ndarray:
    """Return the mean colours of the balls in the first frame about their centres."""
    each = [
        painted(frame, centre, turn, colours, radius, 0.88 * radius)
        for centre, turn in zip(centres, turns, strict=True)
    ]
    return np.asarray(np.mean(each, axis=0))


def painted(
    frame: Frame, centre: np.ndarray, turn: float, colours: Colours, radius: float, inner: float
) -> np.ndarray:
    """Return the colours about a centre, turned back, extended beyond `inner` by the nearest."""
    half = int(np.ceil(1.3 * radius)) + 2
    reach = int(1.5 * half) + 2
    corner = np.floor(centre).astype(int) - reach
    side = 2 * reach + 2
    image = np.nan_to_num(colours.window(frame[2:], corner, (side, side)))
    j, i = np.indices((2 * half + 1, 2 * half + 1)) - half
    x = centre[0] - corner[0] + i * math.cos(turn) + j * math.sin(turn)
    y = centre[1] - corner[1] - i * math.sin(turn) + j * math.cos(turn)
    planes = np.moveaxis(image, -1, 0)
    paint = np.stack([map_coordinates(p, (y, x), float, 1, mode="nearest") for p in planes], -1)
    paint[np.hypot(i, j) > inner] = np.nan
    return np.asarray(filled(paint), float)


def learn_background(
    look: Appearance, frames: list[Frame], covered: list[tuple[int, np.ndarray]]
) -> None:
    """Learn the background again where balls hid it in much of the sample, from other frames."""
    height, width = look.behind.shape[:2]
    hidden = np.zeros((len(frames), height, width), bool)
    reach = 1.3 * look.radius + 2.0
    for k, centre in covered:
        x, y = centre - look.corner
        i0, i1 = max(0, int(x - reach)), min(width, int(x + reach) + 2)
        j0, j1 = max(0, int(y - reach)), min(height, int(y + reach) + 2)
        if i0 >= i1 or j0 >= j1:
            continue
        j, i = np.mgrid[j0:j1, i0:i1]
        hidden[k, j0:j1, i0:i1] |= np.hypot(i - x, j - y) < reach
    often = hidden.mean(axis=0) > 0.2
    if not often.any():
        return
    rows, columns = np.nonzero(often)
    colours = np.full((len(frames), len(rows), 3), np.nan, np.float32)
    low, shape = (
        (int(rows.min()), int(columns.min())),
        (int(np.ptp(rows)) + 1, int(np.ptp(columns)) + 1),
    )
    for k, frame in enumerate(frames):
        corner = (int(look.corner[0]) + low[1], int(look.corner[1]) + low[0])
        image = look.colours.window(frame[2:], corner, shape)
        colours[k] = image[rows - low[0], columns - low[1]]
        colours[k][hidden[k, rows, columns]] = np.nan
    # The lower median of the frames that show a pixel, which sorting puts first; none: unknown.
    colours.sort(axis=0)
    middle = np.maximum(np.isfinite(colours).sum(axis=0) - 1, 0) // 2
    seen = np.take_along_axis(colours, middle[None], axis=0)[0]
    behind = look.behind.copy()
    behind[rows, columns] = seen
    look.behind = filled(behind)
    look.whitened()
