"""Films colliding toys and lets the tracker find pivot and balls without clicks.

    python benchmarks/unclicked_pairs.py [SEED] [BACKGROUND]

Each of twelve clips has its own restitution, release, drive, duration, frame rate and exposure; in
many of them the balls rest against each other for most of the time. The table gives how far balls
and pivot are from where they were drawn [pixels], and of the track the share of measured samples,
the error of the angles [mrad] and the share of them within two deviations.
"""

from __future__ import annotations

import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np
import xarray as xr

import latolato as ll
from latolato.core.errors import InputError
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.synthetic.synthesise import synthesise_video

_CLIPS = 12
_MEASURED = ("ok", "collision", "occluded")


def _film(rng: np.random.Generator, path: Path, scene: Scene, seed: int) -> tuple[xr.Dataset, str]:
    """Write a clip; return its true table, and what was filmed."""
    restitution, release, duration = rng.uniform([0.3, 0.4, 1.5], [0.97, 1.6, 6.0])
    amplitude, frequency = rng.choice([0.0, 0.01, 0.03]), rng.uniform(8.0, 25.0)
    rate, exposure = rng.choice([30.0, 60.0, 120.0]), rng.choice([0.1, 0.5])
    toy = ll.LatoLato(
        length=0.245, mass=0.108, radius=0.02, restitution=float(restitution), damping=0.003
    )
    drive = ll.Harmonic(drive_amplitude=float(amplitude), drive_frequency=float(frequency))
    run = ll.simulate(toy, drive, initial_angle=float(release), duration=float(duration))
    camera = Camera(width=640, height=480, fps=float(rate), exposure=float(exposure))
    about = f"e {restitution:.2f}, {duration:.1f} s at {rate:.0f} Hz, A {1e3 * amplitude:.0f} mm"
    return synthesise_video(run, path, scene, camera, seed=seed), about


def _off(table: xr.Dataset, truth: xr.Dataset, name: str) -> float:
    """Return how far something found is from where it was drawn [pixels]."""
    u, v = (table.attrs[f"{name}_pixel_{c}"] - truth.attrs[f"{name}_pixel_{c}"] for c in "uv")
    return float(np.hypot(u, v))


def _row(table: xr.Dataset, truth: xr.Dataset) -> str:
    """Return what a track reached."""
    places = [_off(table, truth, name) for name in ("ball_1", "ball_2", "pivot")]
    is_measured, off, within = [], [], []
    for ball in (1, 2):
        known = np.isin(table[f"flag_{ball}"].values, _MEASURED)
        error = (table[f"angle_{ball}"].values - truth[f"angle_{ball}"].values)[known]
        is_measured.append(known)
        off.append(error)
        within.append(np.abs(error) < 2.0 * table[f"angle_sigma_{ball}"].values[known])
    rms = 1e3 * float(np.sqrt(np.mean(np.concatenate(off) ** 2)))
    shares = (100.0 * float(np.mean(np.concatenate(each))) for each in (is_measured, within))
    measured, inside = shares
    where = " ".join(f"{place:6.1f}" for place in places)
    return f"{where}  {measured:4.0f} %  {rms:6.2f}  {inside:4.0f} %"


def main() -> None:
    """Film, track and print."""
    seed = int(sys.argv[1]) if len(sys.argv) > 1 else 1
    scene = Scene(background=sys.argv[2] if len(sys.argv) > 2 else "plain")
    rng = np.random.default_rng(seed)
    print(f"{'toy':42s} ball 1 ball 2  pivot  measured   rms  2 sigma")
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for number in range(_CLIPS):
            path = Path(folder) / f"{number}.mp4"
            truth, about = _film(rng, path, scene, number)
            try:
                row = _row(ll.track(path, balls=2, length=0.245), truth)
            except (InputError, KeyError) as error:
                row = f"{type(error).__name__}: {error}".replace(str(path), "clip")[:90]
            print(f"{about:42s} {row}", flush=True)


if __name__ == "__main__":
    main()
