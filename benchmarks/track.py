"""Tracking beside decoding alone, per processor second, and the memory that tracking takes.

    python benchmarks/track.py

A clip is decoded twice, so half the rate of decoding is the most that tracking can reach. One ball
and two at 1280 x 960; memory, beside that of an idle process, at 3840 x 2160 as well.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import latolato as ll
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.synthetic.synthesise import synthesise_video
from latolato.experiment.track import track
from latolato.experiment.video import open_video

ONE = ll.Pendulum(length=0.363, mass=0.108, damping=0.003)
TWO = ll.LatoLato(length=0.245, mass=0.106, damping=0.005, radius=0.02, restitution=0.9)
# A process that tracks a clip and prints the most memory that it had [MB], as Linux counts it.
_MEMORY = """
import sys
import latolato as ll
import xarray

def most():
    lines = open("/proc/self/status").read().splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM"))

idle = most()
ll.track(sys.argv[1], pivot=eval(sys.argv[2]), balls=eval(sys.argv[3]))
print(f"{most():.0f} MB, idle {idle:.0f} MB")
"""


def _filmed(
    path: Path, system: ll.Pendulum | ll.LatoLato, camera: Camera, duration: float
) -> tuple[tuple[float, float], list[tuple[float, float]]]:
    """Film a driven pendulum; return the exact clicks on pivot and balls."""
    drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=2.2 * system.natural_frequency)
    run = ll.simulate(system, drive, initial_angle=0.7, duration=duration)
    seen = synthesise_video(run, path, Scene(ball_radius=0.02), camera, seed=1).attrs
    balls = [
        (float(seen[f"ball_{b}_pixel_u"]), float(seen[f"ball_{b}_pixel_v"]))
        for b in (1, 2)
        if f"ball_{b}_pixel_u" in seen
    ]
    return (float(seen["pivot_pixel_u"]), float(seen["pivot_pixel_v"])), balls


def _rates(path: Path, pivot: tuple[float, float], balls: list[tuple[float, float]]) -> str:
    """Return frames per processor second of tracking and of decoding, the best of three."""
    tracking, decoding, count = [], [], 0
    for _ in range(3):
        begun = time.process_time()
        count = track(path, pivot=pivot, balls=balls).sizes["frame"]
        tracking.append(time.process_time() - begun)
        begun = time.process_time()
        for _frame in open_video(path).frames():
            pass
        decoding.append(time.process_time() - begun)
    whole, part = min(tracking), min(decoding)
    return (
        f"{count} frames, {count / whole:.0f} per processor second; decoding {count / part:.0f}; "
        f"two decodings are {200.0 * part / whole:.0f} % of the work"
    )


def main() -> None:
    """Measure and print."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "clip.mp4"
        for name, system in (("one ball", ONE), ("two balls", TWO)):
            for duration in (10.0, 40.0):
                clicks = _filmed(path, system, Camera(), duration)
                print(f"{name}: {_rates(path, *clicks)}", flush=True)
        for camera in (Camera(), Camera(width=3840, height=2160)):
            pivot, balls = _filmed(path, ONE, camera, 5.0)
            command = [sys.executable, "-W", "ignore", "-c", _MEMORY, str(path)]
            said = subprocess.run(
                [*command, repr(pivot), repr(balls)], capture_output=True, text=True, check=True
            )
            print(f"{camera.width} x {camera.height}: {said.stdout.strip()}", flush=True)


if __name__ == "__main__":
    main()
