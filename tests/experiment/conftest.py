"""Small clips with known truth, made once for all tests of tracking."""

import numpy as np
import pytest

import latolato as ll
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.synthetic.synthesise import synthesise_video

SMALL = Camera(width=320, height=240, fps=60.0)
SWING = ll.Pendulum(length=0.363, mass=0.1, damping=0.003)
TOY = ll.LatoLato(length=0.245, mass=0.1, damping=0.005, radius=0.02, restitution=0.9)
DRIVE = ll.Harmonic(drive_amplitude=0.02, drive_frequency=10.0)


class Clip:
    """A clip, its true table and the clicks that somebody would make."""

    def __init__(self, path, truth):
        self.path, self.truth = path, truth
        attrs = truth.attrs
        self.pivot = self._place(attrs, "pivot")
        self.balls = [
            self._place(attrs, f"ball_{b}") for b in (1, 2) if f"ball_{b}_pixel_u" in attrs
        ]
        self.length = attrs["length"]

    @staticmethod
    def _place(attrs, name):
        return tuple(round(attrs[f"{name}_pixel_{axis}"], 1) for axis in "uv")

    def places_at(self, number):
        """Pivot and balls in a frame, as somebody would click on them."""
        scale = self.truth.attrs["metres_per_pixel"]

        def place(name):
            x, y = (self.truth[f"{name}_{axis}"].values for axis in "xy")
            moved = np.array([x[number] - pivot[0], pivot[1] - y[number]]) / scale
            return tuple(np.rint(self.pivot + moved).tolist())

        pivot = [self.truth[f"pivot_{axis}"].values[0] for axis in "xy"]
        return place("pivot"), [place(f"ball_{b + 1}") for b in range(len(self.balls))]

    @property
    def options(self):
        """The command line's clicks."""
        result = ["--balls", str(len(self.balls)), "--pivot", "{},{}".format(*self.pivot)]
        for ball in self.balls:
            result += ["--ball", "{},{}".format(*ball)]
        return [*result, "--length", f"{self.length} m", "--radius", "2 cm"]


def made(path, system, seconds, angle):
    run = ll.simulate(system, DRIVE, initial_angle=angle, duration=seconds)
    scene = Scene(ball_radius=0.02)
    return Clip(path, synthesise_video(run, path, scene, SMALL, seed=2))


@pytest.fixture(scope="session")
def swing(tmp_path_factory):
    """One ball about a driven pivot."""
    return made(tmp_path_factory.mktemp("clips") / "swing.mp4", SWING, 2.5, 0.9)


@pytest.fixture(scope="session")
def toy(tmp_path_factory):
    """Two balls that meet."""
    return made(tmp_path_factory.mktemp("clips") / "toy.mp4", TOY, 1.5, 0.9)
