"""Figures made through the whole chain: a synthetic video is tracked, fitted and compared.

What stands in for the paper's videos is rendered from eq10 with the paper's parameters. It shows
that the chain returns what is there; it says nothing of the paper's own measurements.
"""

from __future__ import annotations

import importlib.util
import warnings
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato import FixedPivot, LatoLato, Pendulum
from latolato.core.errors import extra_command
from latolato.figures import style
from latolato.paper.cases import Floats, variable

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes

    from latolato.experiment.synthetic.scene import Camera, Scene
    from latolato.physics.drives import Drive

# What the extra `video` brings that is used here.
_MODULES = ("av", "cv2", "lmfit")
MISSING = f"it needs the extra video; {extra_command('video')}, then reproduce again"
# Noise of simulated tables, as the tracker leaves it at 640 x 480: angle [rad], pivot [m].
_ANGLE_NOISE, _PIVOT_NOISE = 3e-4, 2e-5
# The largest side of a still [pixel].
_STILL = 320


@dataclass(frozen=True, kw_only=True)
class Clip:
    """A motion to film, or to sample at the times of a film.

    Attributes
    ----------
    start : tuple of (str, float)
        Of the run, as for `latolato.simulate`.
    size : tuple of int
        Width and height of the picture [pixel].
    scene : tuple of (str, object)
        Values of `latolato.experiment.synthetic.scene.Scene` that differ from its defaults.
    """

    system: Pendulum | LatoLato
    drive: Drive = field(default_factory=FixedPivot)
    start: tuple[tuple[str, float], ...]
    duration: float
    fps: float = 30.0
    size: tuple[int, int] = (640, 480)
    scene: tuple[tuple[str, Any], ...] = ()
    seed: int = 0

    def run(self, times: Floats | None = None) -> xr.Dataset:
        """Return the motion."""
        from latolato import simulate

        options: dict[str, Any] = dict(self.start)
        options |= {"duration": self.duration} if times is None else {"times": times}
        return simulate(self.system, self.drive, **options)

    def stage(self) -> tuple[Scene, Camera]:
        """Return the scene and the camera."""
        from latolato.experiment.synthetic.scene import Camera, Scene

        width, height = self.size
        camera = Camera(width=width, height=height, fps=self.fps)
        return Scene(**dict(self.scene)), camera


def is_missing() -> bool:
    """Return whether a module that videos need is not installed."""
    return any(importlib.util.find_spec(name) is None for name in _MODULES)


@lru_cache(maxsize=128)
def film(clip: Clip) -> xr.Dataset:
    """Return the track table of a clip: rendered as a video, decoded and tracked.

    The first frame's true places stand for the clicks. ``rms_error`` is the error of the angles
    flagged ok [rad].
    """
    from latolato import track
    from latolato.experiment.synthetic.synthesise import synthesise_video

    scene, camera = clip.stage()
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        # The table records them.
        warnings.simplefilter("ignore", RuntimeWarning)
        path = Path(folder) / "synthetic.mp4"
        truth = synthesise_video(clip.run(), path, scene, camera, seed=clip.seed)
        about = truth.attrs
        balls = [number for number in (1, 2) if f"angle_{number}" in truth]
        table = track(
            path,
            pivot=(about["pivot_pixel_u"], about["pivot_pixel_v"]),
            balls=[(about[f"ball_{b}_pixel_u"], about[f"ball_{b}_pixel_v"]) for b in balls],
            length=about["length"],
            radius=about["radius"],
        )
    errors = [
        (table[f"angle_{b}"] - truth[f"angle_{b}"]).values[table[f"flag_{b}"].values == "ok"]
        for b in balls
    ]
    table.attrs["rms_error"] = float(np.sqrt(np.mean(np.concatenate(errors) ** 2)))
    table.attrs["source"] = "synthetic video"
    return table


def sample(clip: Clip) -> xr.Dataset:
    """Return the track table that a clip would give, without a video: samples with noise."""
    from latolato.experiment.track_table import track_table

    random = np.random.default_rng(clip.seed)
    time = np.arange(0.0, clip.duration, 1.0 / clip.fps)
    run = clip.run(time)
    angle = run["angle"].values
    angles = [angle, -angle] if isinstance(clip.system, LatoLato) else [angle]
    height = run["pivot_height"].values
    columns: dict[str, Any] = {
        "time": time,
        "pivot_x": np.zeros_like(time),
        "pivot_y": height - height.mean() + _PIVOT_NOISE * random.standard_normal(len(time)),
    }
    for ball, values in enumerate(angles, start=1):
        noise = _ANGLE_NOISE * random.standard_normal(len(time))
        columns[f"angle_{ball}"] = values + noise
        columns[f"angle_sigma_{ball}"] = np.full(len(time), _ANGLE_NOISE)
    return track_table(columns, {"length": clip.system.length, "source": "simulated"})


def still_of(clip: Clip, number: int = 0) -> Any:
    """Return a frame of the video as variables: colours of pixels, shape (row, column, rgb)."""
    from latolato.experiment.synthetic.synthesise import prepare

    scene, camera = clip.stage()
    run = clip.run()
    picture = np.clip(prepare(run, scene, camera, seed=clip.seed).picture(number), 0.0, 1.0)
    step = max(1, -(-max(picture.shape) // _STILL))
    # IEC 61966-2-1, from linear light.
    colours = np.where(picture <= 0.0031308, 12.92 * picture, 1.055 * picture ** (1 / 2.4) - 0.055)
    shrunk = np.round(255.0 * colours[::step, ::step]).astype(np.uint8)
    return variable(("row", "column", "rgb"), shrunk, units="1", long_name="frame of the video")


def error_of(table: xr.Dataset) -> tuple[Any, Any, dict[str, str]]:
    """Return the error of the tracked angle as a variable."""
    return variable(
        (), table.attrs["rms_error"], units="rad", long_name="error of the tracked angle"
    )


def draw_still(axes: Axes, dataset: xr.Dataset, letter: str) -> None:
    """Draw the frame of the video and say that it is synthetic."""
    axes.imshow(dataset.still.values, interpolation="bilinear")
    axes.set_axis_off()
    style.panel_title(axes, letter, "synthetic video")
