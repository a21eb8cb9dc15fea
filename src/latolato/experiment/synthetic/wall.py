"""Walls behind a synthetic pendulum: plain, unevenly lit, textured or of wooden planks."""

from __future__ import annotations

import math

import numpy as np

from latolato.experiment.synthetic.render import Floats, Image
from latolato.experiment.synthetic.scene import Scene, linear_colour


def make_wall(scene: Scene, shape: tuple[int, int], random: np.random.Generator) -> Image:
    """Return the background in linear light, shape (height, width, 3)."""
    base = np.array(linear_colour("wall_colour", scene.wall_colour), np.float32)
    wall = np.broadcast_to(base, (*shape, 3)).astype(np.float32)
    if scene.background == "plain" or scene.contrast == 0.0:
        return wall
    v, u = np.mgrid[0.0 : 1.0 : shape[0] * 1j, 0.0 : 1.0 : shape[1] * 1j]
    if scene.background == "gradient":
        light = 1.0 + scene.contrast * (0.6 * (0.5 - u) + 0.8 * (0.5 - v))
        tint = np.array([1.05, 1.0, 0.93], np.float32) ** np.float32(scene.contrast)
        return np.asarray(wall * light[..., None] * tint, np.float32)
    if scene.background == "texture":
        strength = 0.22
        sizes = (240.0, 90.0, 30.0, 10.0, 4.0)
        light = sum(_clouds(shape, (s, s), random) * 0.85**i for i, s in enumerate(sizes))
        tint = _clouds(shape, (150.0, 150.0), random)
    else:
        strength = 0.42
        plank = 140.0
        grain = _clouds(shape, (4.0, 300.0), random) + 0.6 * _clouds(shape, (12.0, 500.0), random)
        warp = 8.0 * _clouds(shape, (60.0, 260.0), random)
        ring = np.sin((v * shape[0] + warp * 3.0) / 5.5 + 2.0 * grain)
        row = np.floor(v * shape[0] / plank).astype(int)
        tone = random.normal(0.0, 0.8, row.max() + 1)[row]
        gap = np.abs(v * shape[0] / plank % 1.0 * plank - 1.0) < 1.5
        light = 0.5 * grain + 0.35 * ring + 0.6 * tone - 2.5 * gap
        tint = 0.8 + 0.5 * tone
    factor = np.exp(strength * scene.contrast * light)[..., None]
    warmth = np.array([0.2, 0.0, -0.3]) * strength * scene.contrast * tint[..., None]
    return np.asarray(np.clip(wall * factor * np.exp(warmth), 0.0, 1.0), np.float32)


def _clouds(
    shape: tuple[int, int], size: tuple[float, float], random: np.random.Generator
) -> Floats:
    """Return smooth noise of unit variance with structures of a size [pixel], v and u."""
    from scipy.interpolate import BSpline

    noise = random.standard_normal([math.ceil(n / s) + 4 for n, s in zip(shape, size, strict=True)])
    for axis, (n, s) in enumerate(zip(shape, size, strict=True)):
        # Uniform cubic B-splines, the one of index i centred at i.
        knots = np.arange(noise.shape[axis] + 4) - 2.0
        places = 1.0 + np.arange(n) / s + random.uniform()
        splines = BSpline.design_matrix(places, knots, 3)
        noise = np.moveaxis(splines @ np.moveaxis(noise, axis, 0), 0, axis)
    return np.asarray(noise / noise.std())
