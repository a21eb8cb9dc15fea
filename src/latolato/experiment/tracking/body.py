"""Bobs that are not discs: which part of the patch about the click is the bob, and its colours."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from latolato.experiment.rules import broken
from latolato.experiment.tracking.appearance import Appearance
from latolato.experiment.tracking.paint import filled, painted
from latolato.experiment.video import Frame

if TYPE_CHECKING:
    from latolato.experiment.tracking.teach import Sighting

# Half the side of the patch where it is not given: over the radius of the bob, or over the arm.
ROUND, SHARE = 1.4, 0.15
# First guess of what the patch does not explain, as a share of white.
_NOISE = 0.03
# Least contrast of the bob with the wall, as a share of white.
_PLAIN = 0.02
# A pixel is the bob's if the wall would leave this many times more of it unexplained, and this
# share of the contrast.
_CLEAR, _CLEAR_SHARE = 4.0, 0.25
# Error of half the bob's width [pixels].
_UNSURE = 1.0


def learn_body(
    look: Appearance,
    frames: list[Frame],
    sightings: list[Sighting],
    medians: tuple[np.ndarray, ...],
) -> None:
    """Learn colours and outline of bobs, as they look when they hang down, from some of them.

    Raises
    ------
    InputError
        If nothing about the click differs from the wall.
    """
    # The paint keeps its size, of which `painted` makes a patch this large.
    half = (look.paint.shape[1] - 5) / 2.6
    own, wall = (
        np.stack(
            [
                painted(planes, one.centre, one.angle, look.colours, half, half + 0.5)
                for one, planes in each
            ]
        )
        for each in (
            [(one, frames[one.frame][2:]) for one in sightings],
            [(one, medians) for one in sightings],
        )
    )
    inside = np.isfinite(own).all(axis=(0, 3))
    look.paint = filled(np.median(own, axis=0))[None]
    # Coded values are about the roots of light.
    root, behind, paint = (np.sqrt(np.maximum(each, 0.0)) for each in (own, wall, look.paint))
    as_wall = np.median(np.mean((root - behind) ** 2, axis=-1), axis=0)
    rest = np.median(np.mean((root - paint) ** 2, axis=-1), axis=0)
    if len(sightings) < 3:  # one patch explains itself
        rest = np.full_like(as_wall, _NOISE**2)
    contrast = float(np.quantile(as_wall[inside], 0.95))
    if contrast < _PLAIN**2:
        raise broken("plain_patch")
    body = inside & (as_wall > np.maximum(_CLEAR * rest, _CLEAR_SHARE**2 * contrast))
    if body.any():
        look.body = body
        columns = np.nonzero(body)[1] - (body.shape[1] - 1) // 2
        look.radius = float(np.quantile(np.abs(columns), 0.95)) + 0.5
        look.radius_sigma = _UNSURE
    elif look.body is None:
        look.body = inside
    look.whitened()
