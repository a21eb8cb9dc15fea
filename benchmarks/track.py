"""Frames per CPU second of tracking, decoding included, at 1280 x 960."""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import latolato as ll
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.synthetic.synthesise import synthesise_video
from latolato.experiment.track import track


def _measure(name: str, system: object, scene: Scene, folder: Path, duration: float) -> None:
    """Film, track twice (the first run compiles) and print the second run's rate."""
    drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=2.2 * system.natural_frequency)
    run = ll.simulate(system, drive, initial_angle=0.7, duration=duration)
    path = folder / f"{name}.mp4"
    clicks = synthesise_video(run, path, scene, Camera(), seed=1).attrs
    balls = [
        (clicks[f"ball_{b}_pixel_u"], clicks[f"ball_{b}_pixel_v"])
        for b in (1, 2)
        if f"ball_{b}_pixel_u" in clicks
    ]
    pivot = clicks["pivot_pixel_u"], clicks["pivot_pixel_v"]
    for _ in range(2):
        begun = time.process_time()
        table = track(path, pivot=pivot, balls=balls, length=clicks["length"])
        spent = time.process_time() - begun
    frames = table.sizes["frame"]
    print(f"{name:10} {frames:5} frames  {frames / spent:6.0f} frames per CPU second (asked: 100)")


def main() -> None:
    """Measure one ball and two."""
    with tempfile.TemporaryDirectory() as folder:
        one = ll.Pendulum(length=0.363, mass=0.108, damping=0.003)
        two = ll.LatoLato(length=0.245, mass=0.106, damping=0.005, radius=0.02, restitution=0.9)
        for duration in (10.0, 40.0):
            _measure("one ball", one, Scene(ball_radius=0.02), Path(folder), duration)
            _measure("two balls", two, Scene(), Path(folder), duration)


if __name__ == "__main__":
    main()
