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

from latolato.core.errors import extra_command
from latolato.figures import style
from latolato.figures.cases import Floats, quantity, variable
from latolato.figures.claim import Limit, Statement
from latolato.figures.fits import ABOVE, draw_curve, draw_residual, draw_turning_points
from latolato.physics.drives import Drive, FixedPivot
from latolato.physics.pendulum import LatoLato, Pendulum

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from latolato.experiment.scene import Camera, Scene

# What the extra `video` brings that is used here.
_MODULES = ("av", "cv2", "lmfit")
MISSING = f"it needs the extra video; {extra_command('video')}, then reproduce again"
SYNTHETIC = (
    "The video is synthetic, rendered with these parameters: this tests the chain from the video "
    "to the number, not the paper's measurement."
)
# Noise of simulated tables, as the tracker leaves it at 640 x 480: angle [rad], pivot [m].
_ANGLE_NOISE, _PIVOT_NOISE = 3e-4, 2e-5
# The largest side of a still [pixel].
_STILL = 320


@dataclass(frozen=True, kw_only=True)
class Clip:
    """A motion that is filmed, or sampled as a film would.

    Attributes
    ----------
    start : tuple of (str, float)
        Of the run, as for `latolato.simulate`.
    size : tuple of int
        Width and height of the picture [pixel].
    scene : tuple of (str, object)
        Values of `latolato.experiment.scene.Scene` that differ from its defaults.
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
        from latolato.simulation.run import simulate

        options: dict[str, Any] = dict(self.start)
        options |= {"duration": self.duration} if times is None else {"times": times}
        return simulate(self.system, self.drive, **options)

    def stage(self) -> tuple[Scene, Camera]:
        """Return what is seen and how it is filmed."""
        from latolato.experiment.scene import Camera, Scene

        width, height = self.size
        camera = Camera(width=width, height=height, fps=self.fps)
        return Scene(**dict(self.scene)), camera


def is_missing() -> bool:
    """Return whether a module that videos need is not installed."""
    return any(importlib.util.find_spec(name) is None for name in _MODULES)


@lru_cache(maxsize=128)
def filmed(clip: Clip) -> xr.Dataset:
    """Return the track table of a clip: rendered as a video, decoded and tracked.

    The first frame's true places stand for the clicks. ``rms_error`` is the error of the angles
    flagged ok [rad].
    """
    from latolato.experiment import track
    from latolato.experiment.synthetic import synthesise_video

    scene, camera = clip.stage()
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        # The table tells of them.
        warnings.simplefilter("ignore", RuntimeWarning)
        path = Path(folder) / "synthetic.mp4"
        truth = synthesise_video(clip.run(), path, scene, camera, seed=clip.seed)
        about = truth.attrs
        balls = [number for number in (1, 2) if f"angle_{number}" in truth]
        table = track.track(
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


def sampled(clip: Clip) -> xr.Dataset:
    """Return the track table that a clip would give, without a video: samples with noise."""
    from latolato.experiment.table import track_table

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
    from latolato.experiment.synthetic import prepare

    scene, camera = clip.stage()
    run = clip.run()
    picture = np.clip(prepare(run, scene, camera, seed=clip.seed).picture(number), 0.0, 1.0)
    step = max(1, -(-max(picture.shape) // _STILL))
    # IEC 61966-2-1, from linear light.
    colours = np.where(picture <= 0.0031308, 12.92 * picture, 1.055 * picture ** (1 / 2.4) - 0.055)
    shrunk = np.round(255.0 * colours[::step, ::step]).astype(np.uint8)
    return variable(("row", "column", "rgb"), shrunk, units="1", long_name="frame of the video")


def draw_still(axes: Axes, dataset: xr.Dataset, letter: str) -> None:
    """Draw the frame of the video and say that it is synthetic."""
    axes.imshow(dataset.still.values, interpolation="bilinear")
    axes.set_axis_off()
    style.panel_title(axes, letter, "synthetic video")


def decay_statement(name: str, where: str, damping: float, words: str) -> Statement:
    """Return the claim that the chain returns a printed damping coefficient."""
    return Statement(
        name=name,
        where=f"{where}, synthetic video",
        words=words,
        assumed=(
            Limit("error", "relative error of C by the equation", high=0.015),
            Limit("error_envelope", "relative error of C by the envelope", high=0.04),
            Limit("pull", "error of C by the equation over its standard deviation", high=2.0),
        ),
        assumption=SYNTHETIC,
        is_method_check=True,
        finding=(
            f"From a synthetic video rendered with C = {damping:g} kg m/s, "
            "a fit of the equation of motion gives C = ({damping_milli:.5f} ± {sigma_milli:.5f}) "
            "g m/s, {error_percent:.3f} % away, and a fit of the envelope {envelope_milli:.5f} "
            "g m/s, {envelope_percent:.3f} % away."
        ),
        why=(
            "Angles of {frames:.0f} frames are right to {rms_milli:.2f} mrad; the equation takes "
            "the whole curve, the envelope its turning points."
        ),
    )


def decay_data(clip: Clip, title: str, quick: bool) -> xr.Dataset:
    """Return the fit of a filmed decay, with the frame, and the damping that was rendered."""
    from latolato.experiment.fits.decay import fit_decay

    table = filmed(clip)
    fit = fit_decay(table, mass=clip.system.mass, compare=not quick, profile=not quick)
    found = fit.dataset.assign(
        still=still_of(clip),
        damping_rendered=quantity(
            "damping", (), clip.system.damping, long_name="damping that was rendered"
        ),
        frames=variable((), table.sizes["frame"], units="1", long_name="frames of the video"),
        rms_error=variable(
            (), table.attrs["rms_error"], units="rad", long_name="error of the tracked angle"
        ),
    )
    frames = table.sizes["frame"]
    found.attrs |= {"title": title, "chain": f"One synthetic video of {frames} frames, tracked."}
    return found


def decay_numbers(dataset: xr.Dataset) -> dict[str, float]:
    """Return the numbers that the statement of a decay names."""
    true = float(dataset.damping_rendered)
    found, sigma = float(dataset.damping), float(dataset.damping_sigma)
    envelope = float(dataset.damping_envelope)
    return {
        "error": abs(found / true - 1.0),
        "error_percent": 100.0 * abs(found / true - 1.0),
        "error_envelope": abs(envelope / true - 1.0),
        "envelope_percent": 100.0 * abs(envelope / true - 1.0),
        "pull": abs(found - true) / sigma,
        "damping_milli": 1e3 * found,
        "sigma_milli": 1e3 * sigma,
        "envelope_milli": 1e3 * envelope,
        "frames": float(dataset.frames),
        "rms_milli": 1e3 * float(dataset.rms_error),
    }


def draw_decay(dataset: xr.Dataset) -> Figure:
    """Return the frame, the tracked angle under its envelope, and what the equation leaves."""
    figure, panels = style.new_mosaic(
        [["still", "angle"], ["still", "residual"]],
        height=3.2, height_ratios=[1.9, 1.0], width_ratios=[1.0, 2.1],
    )  # fmt: skip
    draw_still(panels["still"], dataset, "a")
    angle, residual = panels["angle"], panels["residual"]
    draw_curve(angle, dataset, "angle", "angle_fit")
    draw_turning_points(angle, dataset)
    angle.set_xlabel("")
    angle.legend(**ABOVE, ncols=3)
    style.panel_letter(angle, "b")
    draw_residual(residual, dataset, "angle_residual")
    style.panel_letter(residual, "c")
    for axes in (angle, residual):
        axes.set_xlim(0.0, float(dataset.time[-1]))
    return figure
