"""Metres per pixel: by the length, by a stick of known length in the picture, or by the radius."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from latolato.experiment.calibration.hinge import CLICK_SIGMA
from latolato.experiment.calibration.lens import undistorted
from latolato.experiment.sidecar import Setup

# Share by which a declared size must differ from the measured one to be worth a warning.
TOLERANCE = 0.03


@dataclass(frozen=True)
class Scale:
    """What sets the scale of a picture.

    Attributes
    ----------
    metres : float
        Metres per pixel.
    share : float
        Its relative standard deviation.
    source : str
        ``"length"``, ``"stick"`` or ``"radius"``.
    """

    metres: float
    share: float
    source: str


def stick_pixels(setup: Setup, size: tuple[int, int]) -> float:
    """Return how long the stick of a set-up is in a picture of a width and a height [pixels]."""
    ends = undistorted(np.array(setup.stick), size, setup.optics)
    return float(np.hypot(*(ends[1] - ends[0])))


def scale_of(
    setup: Setup,
    size: tuple[int, int],
    arm: tuple[float, float],
    radius: tuple[float, float] | None = None,
) -> Scale | None:
    """Return the scale by the first that is known of length, stick and radius, None without any.

    Parameters
    ----------
    setup : Setup
        What is declared [m].
    size : tuple of int
        Width and height of the picture [pixels].
    arm, radius : tuple of float
        Pivot to ball centre and a ball's radius in the picture, each with its standard deviation
        [pixels]; no radius as long as it is not measured.

    Notes
    -----
    A click on an end of the stick is accurate to 1 pixel in each direction, the stick's length to
    the square root of 2.
    """
    if setup.length:
        return Scale(setup.length / arm[0], arm[1] / arm[0], "length")
    if setup.stick and setup.stick_length:
        pixels = stick_pixels(setup, size)
        return Scale(setup.stick_length / pixels, math.sqrt(2.0) * CLICK_SIGMA / pixels, "stick")
    if setup.radius and radius:
        return Scale(setup.radius / radius[0], radius[1] / radius[0], "radius")
    return None
