"""The disc near a click: its centre and radius in one frame."""

from __future__ import annotations

import numpy as np

from latolato.experiment.tracking.appearance import Colours
from latolato.experiment.video import Frame


def disc_at(
    frame: Frame,
    colours: Colours,
    click: np.ndarray,
    radius: float,
    pivot: np.ndarray,
    is_known: bool,
) -> tuple[np.ndarray, float]:
    """Return centre and radius of the disc near a click: where the colour steps most outwards.

    Daugman, IEEE Trans. Pattern Anal. Mach. Intell. 15 (1993) 1148: the mean difference across a
    circle, here as the mean over directions of a difference that is bounded, so that rods, shadows
    and another ball do not decide.
    """
    reach = int(3.2 * radius) + 8
    corner = np.rint(click).astype(int) - reach
    side = 2 * reach + 1
    image = colours.window(frame[2:], (int(corner[0]), int(corner[1])), (side, side))
    image = np.nan_to_num(np.sqrt(image), nan=0.0)
    turns = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    away = np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    towards = (pivot - click) / max(float(np.hypot(*(pivot - click))), 1e-9)
    away = away[away @ towards < 0.85]

    def score(centre: np.ndarray, size: float) -> float:
        gap = max(1.2, 0.07 * size)
        inner = _looked_up(image, centre + away * (size - gap) - corner)
        outer = _looked_up(image, centre + away * (size + gap) - corner)
        step = inner - outer
        typical = np.median(step, axis=0)
        along = step @ typical / max(float(np.linalg.norm(typical)), 1e-6)
        return float(np.mean(np.clip(along, -0.1, 0.25)))

    known = radius * np.linspace(0.9, 1.1, 9)
    sizes = known if is_known else radius * np.geomspace(0.4, 2.5, 24)
    centre, size = np.array(click, float), radius
    for reach_, count in ((0.3 * radius, 7), (0.06 * radius, 7), (0.015 * radius, 5)):
        offsets = np.linspace(-reach_, reach_, count)
        trials = [
            (score(centre + np.array([dx, dy]), one), dx, dy, one)
            for one in sizes
            for dx in offsets
            for dy in offsets
        ]
        _, dx, dy, size = max(trials)
        centre = centre + np.array([dx, dy])
        if is_known and sizes is known and size in (known[0], known[-1]):
            return disc_at(frame, colours, click, radius, pivot, is_known=False)
        sizes = size * np.linspace(0.94, 1.06, 7)
    return centre, float(size)


def _looked_up(image: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the colours nearest to places (place, 2) of column and row."""
    at = np.rint(places).astype(int)
    i = np.clip(at[:, 0], 0, image.shape[1] - 1)
    j = np.clip(at[:, 1], 0, image.shape[0] - 1)
    colours: np.ndarray = image[j, i]
    return colours
