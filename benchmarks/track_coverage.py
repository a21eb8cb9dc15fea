"""Counts how often true angles lie within the stated deviations of tracked synthetic clips.

For each filming condition, with one driven ball, two driven balls and one that swings freely: the
share of samples flagged ok within two deviations (wanted: 90 percent, or a warning), the root mean
square error, the median deviation and the warnings. Clicks are rounded to whole pixels. Lens and
rolling shutter are declared in one pass and undeclared in another.
``PYTHONPATH=tests/shared python benchmarks/track_coverage.py [CONDITION ...]``; prints a table.
"""

from __future__ import annotations

import sys
import tempfile
import warnings
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr

import latolato as ll
from conditions import conditions
from latolato.experiment.calibration.lens import Optics
from latolato.experiment.synthetic.synthesise import synthesise_video

ONE = ll.Pendulum(length=0.363, mass=0.108, damping=0.00274)
TWO = ll.LatoLato(length=0.245, mass=0.1064, damping=0.005, radius=0.02, restitution=0.9)


def _runs() -> Iterator[tuple[str, xr.Dataset]]:
    """Yield what is filmed."""
    for name, system, ratio, angle in (("one", ONE, 1.95, 0.6), ("two", TWO, 2.3, 0.9)):
        drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=ratio * system.natural_frequency)
        yield name, ll.simulate(system, drive, initial_angle=angle, duration=4.0)
    yield "free", ll.simulate(ONE, None, initial_angle=0.7, duration=5.0)


def _measure(
    name: str, run: xr.Dataset, folder: Path
) -> Iterator[tuple[str, xr.Dataset, xr.Dataset]]:
    """Film and track; yield whether the optics are declared, the truth and the table."""
    scene, camera = conditions[name].make(scene={"ball_radius": 0.02})
    path = folder / "clip.mp4"
    truth = synthesise_video(run, path, scene, camera, seed=7)
    clicks = truth.attrs
    places = [
        (round(clicks[f"{part}_pixel_u"]), round(clicks[f"{part}_pixel_v"]))
        for part in ("pivot", "ball_1", "ball_2")
        if f"{part}_pixel_u" in clicks
    ]
    declared = Optics(row_time=camera.row_time, lens_k1=camera.k1, lens_k2=camera.k2)
    for optics in dict.fromkeys((declared, Optics())):
        table = ll.track(
            path, pivot=places[0], balls=places[1:], length=clicks["length"],
            radius=clicks["radius"], optics=optics,
        )  # fmt: skip
        yield "declared" if optics == declared else "undeclared", truth, table


def main(names: list[str]) -> None:
    """Print one line for each clip."""
    warnings.simplefilter("ignore")
    print(f"{'condition':10} {'balls':5} {'optics':10} {'ok':>5} {'2 sigma':>7} {'rms':>7} "
          f"{'sigma':>7}  warnings")  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        for name in names or list(conditions):
            for balls, run in _runs():
                for optics, truth, table in _measure(name, run, Path(folder)):
                    angles = [angle for angle in ("angle_1", "angle_2") if angle in table]
                    error = np.stack([(table[a] - truth[a]).values for a in angles])
                    sigma, flag = (
                        np.stack([table[a.replace("angle", part)].values for a in angles])
                        for part in ("angle_sigma", "flag")
                    )
                    ok = flag == "ok"
                    within = np.mean(np.abs(error[ok]) < 2.0 * sigma[ok])
                    told = table.attrs.get("warnings", "")[:60]
                    print(
                        f"{name:10} {balls:5} {optics:10} {np.mean(ok):5.2f} {within:7.2f} "
                        f"{1e3 * np.sqrt(np.mean(error[ok] ** 2)):7.3f} "
                        f"{1e3 * np.median(sigma[ok]):7.3f}  {told}",
                        flush=True,
                    )


if __name__ == "__main__":
    main(sys.argv[1:])
