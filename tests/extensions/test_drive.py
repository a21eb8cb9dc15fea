"""A drive that a user brings: one class with formulas and numbers of its own."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pytest

import latolato as ll
from latolato.core.quantities import NON_NEGATIVE, quantity_field
from latolato.core.scalar import cosine, formula, sine
from latolato.physics.drives import Drive, drives


class Beat(NamedTuple):
    """Two cosines of one amplitude."""

    start: float
    amplitude: float
    slow: float
    fast: float


@formula
def height(t, p):
    return p.amplitude * (cosine(p.slow * t) + cosine(p.fast * t))


@formula
def velocity(t, p):
    return -p.amplitude * (p.slow * sine(p.slow * t) + p.fast * sine(p.fast * t))


@formula
def acceleration(t, p):
    return -p.amplitude * (p.slow**2 * cosine(p.slow * t) + p.fast**2 * cosine(p.fast * t))


@dataclass(frozen=True, kw_only=True)
class Beating(Drive):
    height = staticmethod(height)
    velocity = staticmethod(velocity)
    acceleration = staticmethod(acceleration)

    drive_amplitude: float = quantity_field("drive_amplitude", NON_NEGATIVE)
    slow: float = quantity_field("drive_frequency", NON_NEGATIVE)
    fast: float = quantity_field("drive_frequency", NON_NEGATIVE)

    def stretches(self, duration):
        return [Beat(0.0, self.drive_amplitude, self.slow, self.fast)]

    @property
    def fastest_frequency(self):
        return max(self.slow, self.fast)

    @property
    def largest_acceleration(self):
        return self.drive_amplitude * (self.slow**2 + self.fast**2)


TOY = ll.LatoLato(length=0.245, mass=0.1, damping=0.005, radius=0.02, restitution=0.9)
RUN = {"initial_angle": 0.7, "duration": 5.0}


@pytest.fixture(autouse=True)
def beating():
    """Only these tests know the drive: others range over all registered ones."""
    drives.register("beating")(Beating)
    yield
    del drives._entries["beating"]


def test_a_drive_of_ones_own_moves_the_toy_like_the_packages_own():
    # Two equal cosines of half the amplitude are the harmonic drive.
    own = ll.simulate(TOY, Beating(drive_amplitude=0.01, slow=15.1, fast=15.1), **RUN)
    known = ll.simulate(TOY, ll.Harmonic(drive_amplitude=0.02, drive_frequency=15.1), **RUN)
    assert own.sizes["contact"] == known.sizes["contact"] > 5
    # Same formulas up to the order of a product; 10 impacts in 5 s enlarge roundings a little.
    for name in ("angle", "pivot_height", "pivot_velocity", "pivot_acceleration", "drive_work"):
        scale = float(np.max(np.abs(known[name])))
        np.testing.assert_allclose(own[name], known[name], rtol=0.0, atol=1e-10 * scale)


def test_a_beat_closes_the_ledger_where_the_packages_drives_cannot():
    run = ll.simulate(TOY, Beating(drive_amplitude=0.01, slow=11.0, fast=15.1), **RUN)
    assert run.pivot_height[0] == pytest.approx(0.02, abs=1e-15)
    # The ledger's relative error at the default tolerance of 1e-10, with room.
    assert run.attrs["energy_residual"] < 1e-9


def test_a_drive_of_ones_own_is_swept_along_its_own_parameters():
    slow = np.array([11.0, 13.0])
    drive = Beating(drive_amplitude=0.01, slow=11.0, fast=15.1)
    run = {"initial_angle": 0.7, "duration": 1.0, "tolerance": 1e-8}
    grid = ll.sweep(
        TOY, drive, axes={"slow": slow}, observables=["final_angle"], executor="reference", **run
    )
    for value, found in zip(slow, grid.final_angle.values, strict=True):
        one = ll.simulate(TOY, Beating(drive_amplitude=0.01, slow=value, fast=15.1), **run)
        # Two impacts at a tolerance of 1e-8; `simulate` may halve the step, a sweep does not.
        assert found == pytest.approx(float(one.angle[-1]), abs=1e-7)


def test_a_drive_without_bounds_or_with_former_jumps_is_refused():
    class Boundless(Beating):
        fastest_frequency = Drive.fastest_frequency

    found = Boundless(drive_amplitude=0.1, slow=3.0, fast=4.0)
    with pytest.raises(TypeError, match="must define fastest_frequency and largest_acceleration"):
        ll.simulate(ll.Pendulum(length=1.0, mass=1.0), found, initial_angle=0.1, duration=1.0)
    with pytest.raises(TypeError, match="a stretch has its `jump`"):

        class Jumping(Beating):
            def velocity_jumps(self, duration):
                return [0.0]
