"""Clips of bobs that are no discs, painted pixel by pixel: their angles are known."""

from __future__ import annotations

import av
import numpy as np

import latolato as ll
from latolato.experiment.encode import TICKS, write_video

WIDTH, HEIGHT, FPS = 320, 240, 60.0
PIVOT, ARM = np.array([160.0, 40.0]), 130.0
# Subpixels per pixel and moments per exposure, which lasts a quarter of the time between frames.
_FINE, _MOMENTS, _EXPOSURE = 3, 3, 0.25
_INK, _LABEL, _ROD, _BLOCK = (40, 70, 160), (235, 220, 60), (90, 90, 90), (130, 110, 100)


def square(x, y):
    """A block of 24 x 24 pixels, about its middle."""
    return (np.abs(x) < 12) & (np.abs(y) < 12)


def ring(x, y):
    """A ring with a hole through which the wall shows."""
    return (np.hypot(x, y) < 15) & (np.hypot(x, y) > 9)


def bottle(x, y):
    """A bottle that hangs by its neck."""
    return (np.abs(x) < np.where(y < -10, 4, 9)) & (np.abs(y) < 26)


SHAPES = {"square": square, "ring": ring, "bottle": bottle}


def swing(seconds=2.0, amplitude=0.8):
    """Instants of frames and the angle as a function of time."""
    bob = ll.Pendulum(length=0.3, mass=0.1, damping=0.003)
    run = ll.simulate(bob, initial_angle=amplitude, duration=seconds + 1.0 / FPS)
    times = np.arange(int(seconds * FPS)) / FPS + 0.5 / FPS
    return times, lambda t: np.interp(t, run.time.values, run.angle.values)


def write_clip(path, shape, *, texture=0.0, label=False, seed=0, seconds=2.0, hand=False):
    """Write a clip of a shape that swings, and return its true angles.

    `texture` is the roughness of the wall, `label` paints a stripe on the bob, `hand` passes before
    the bob.
    """
    rng = np.random.default_rng(seed)
    times, angle = swing(seconds)
    coarse = rng.normal(size=(HEIGHT // 4, WIDTH // 4)).repeat(4, 0).repeat(4, 1)
    wall = np.full((HEIGHT, WIDTH, 3), 190.0) + texture * coarse[..., None]
    wall[:, :, 2] -= 20.0
    wall[28:53, 140:181] = _BLOCK

    def frame(k, time):
        moments = time + _EXPOSURE / FPS * ((np.arange(_MOMENTS) + 0.5) / _MOMENTS - 0.5)
        picture = np.mean([_painted(wall, shape, float(angle(t)), label) for t in moments], axis=0)
        if hand and 40 <= k < 60:
            picture[100:200, 100 + 4 * (k - 40) : 130 + 4 * (k - 40)] = (200, 150, 120)
        picture = picture + rng.normal(size=picture.shape) * 2.0
        each = av.VideoFrame.from_ndarray(np.clip(picture, 0, 255).astype(np.uint8), format="rgb24")
        return round(time * TICKS), each.to_ndarray(format="yuv420p")

    frames = (frame(k, t) for k, t in enumerate(times))
    write_video(path, frames, fps=FPS, crf=18, rotation=0)
    return angle(times)


def _painted(wall, shape, angle, label):
    """Return the wall with rod and bob at an angle."""
    picture = wall.copy()
    down = np.array([np.sin(angle), np.cos(angle)])
    across = np.array([np.cos(angle), -np.sin(angle)])
    low = np.maximum(np.floor(np.minimum(PIVOT, PIVOT + ARM * down) - 34).astype(int), 0)
    high = np.minimum(np.ceil(np.maximum(PIVOT, PIVOT + ARM * down) + 34), [WIDTH, HEIGHT])
    u0, v0, u1, v1 = *low, *high.astype(int)
    steps = (np.arange(_FINE) + 0.5) / _FINE - 0.5
    v, u = np.meshgrid(
        (np.arange(v0, v1)[:, None] + steps).ravel(), (np.arange(u0, u1)[:, None] + steps).ravel(),
        indexing="ij",
    )  # fmt: skip
    away = np.stack([u, v], axis=-1) - PIVOT
    x, y = away @ across, away @ down - ARM
    layers = [(_ROD, (np.abs(x) < 1.2) & (y < -8) & (y > -ARM)), (_INK, shape(x, y))]
    if label:
        layers.append((_LABEL, shape(x, y) & (np.abs(y - 3) < 4)))
    part = picture[v0:v1, u0:u1]
    fine = part.repeat(_FINE, 0).repeat(_FINE, 1)
    for colour, mask in layers:
        fine[mask] = colour
    picture[v0:v1, u0:u1] = fine.reshape(v1 - v0, _FINE, u1 - u0, _FINE, 3).mean(axis=(1, 3))
    return picture


def places(angle):
    """Return pivot and bob in the picture, as somebody would click on them."""
    bob = PIVOT + ARM * np.array([np.sin(angle), np.cos(angle)])
    return tuple(PIVOT.tolist()), tuple(np.rint(bob).tolist())
