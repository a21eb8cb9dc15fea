"""The disc near a click: its centre and radius in one frame."""

from __future__ import annotations

import numpy as np

from latolato.experiment.tracking.appearance import Colours
from latolato.experiment.video import Frame

# How much more must step if steps up and down count alike, for a ball to have two colours.
_TWO_COLOURED = 1.1


def disc_at(
    frame: Frame,
    colours: Colours,
    click: np.ndarray,
    radius: float,
    pivot: np.ndarray,
    is_known: bool,
) -> tuple[np.ndarray, float, float]:
    """Return centre and radius of the disc near a click, and how much the colour steps there.

    It is the one across which colours step most. Daugman, IEEE Trans. Pattern Anal. Mach. Intell.
    15 (1993) 1148: the mean difference across a circle, here as the mean over directions of a
    difference that is bounded, so that rods, shadows and another ball do not decide. The difference
    has one sign all around, unless a ball of two colours is lighter than the wall on one side and
    darker on the other.
    """
    reach = int(3.2 * radius) + 8
    corner = np.rint(click).astype(int) - reach
    side = 2 * reach + 1
    image = colours.window(frame[2:], corner, (side, side))
    image = np.nan_to_num(np.sqrt(image), nan=0.0)
    turns = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    away = np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    towards = (pivot - click) / max(float(np.hypot(*(pivot - click))), 1e-9)
    away = away[away @ towards < 0.85]
    best: tuple[float, np.ndarray, float] | None = None
    for is_two_coloured in (False, True):
        score, centre, size = _refined(
            image, away, np.array(click, float) - corner, radius, is_known, is_two_coloured
        )
        # Anything steps more if steps up and down count alike.
        if best is None or score > _TWO_COLOURED * best[0]:
            best = (score, centre + corner, size)
    assert best is not None
    return best[1], best[2], best[0]


def _refined(
    image: np.ndarray,
    away: np.ndarray,
    click: np.ndarray,
    radius: float,
    is_known: bool,
    is_two_coloured: bool,
) -> tuple[float, np.ndarray, float]:
    """Return the mean step, centre and radius of the circle across which colours step most."""
    known = radius * np.linspace(0.9, 1.1, 9)
    sizes = known if is_known else radius * np.geomspace(0.4, 2.5, 24)
    score, centre, size = -np.inf, click, radius
    for reach, count in ((0.3 * radius, 7), (0.06 * radius, 7), (0.015 * radius, 5)):
        offsets = np.linspace(-reach, reach, count)
        trials = centre + np.stack(np.meshgrid(offsets, offsets), axis=-1).reshape(-1, 2)
        scores = np.stack([_steps(image, trials, away, one, is_two_coloured) for one in sizes])
        which, at = np.unravel_index(int(np.argmax(scores)), scores.shape)
        score, size, centre = float(scores[which, at]), float(sizes[which]), trials[at]
        if is_known and sizes is known and which in (0, len(known) - 1):
            return _refined(image, away, click, radius, False, is_two_coloured)
        sizes = size * np.linspace(0.94, 1.06, 7)
    return score, centre, size


def _steps(
    image: np.ndarray, centres: np.ndarray, away: np.ndarray, size: float, is_two_coloured: bool
) -> np.ndarray:
    """Return the mean bounded step of colours across circles about some centres (centre, 2)."""
    gap = max(1.2, 0.07 * size)
    inner = _looked_up(image, centres[:, None] + away * (size - gap))
    outer = _looked_up(image, centres[:, None] + away * (size + gap))
    step = inner - outer
    typical = np.median(step, axis=1)
    norm = np.maximum(np.linalg.norm(typical, axis=1), 1e-6)
    along = np.einsum("tdc,tc->td", step, typical) / norm[:, None]
    if is_two_coloured:
        along = np.abs(along)
    mean: np.ndarray = np.clip(along, -0.1, 0.25).mean(axis=1)
    return mean


def _looked_up(image: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the colours nearest to places (..., 2) of column and row."""
    at = np.rint(places).astype(int)
    i = np.clip(at[..., 0], 0, image.shape[1] - 1)
    j = np.clip(at[..., 1], 0, image.shape[0] - 1)
    colours: np.ndarray = image[j, i]
    return colours
