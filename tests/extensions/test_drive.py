"""Drives that a user brings: that of the page on drives, and a periodic one."""

import json
import math
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from types import ModuleType
from typing import NamedTuple
from unittest import mock

import numpy as np
import pytest

import latolato as ll
from latolato.analysis import (
    bifurcation_diagram,
    continue_orbit,
    floquet,
    poincare_section,
    response_period,
)
from latolato.app.analyse.answer import compute as compute_analysis
from latolato.app.analyse.forms import about_request
from latolato.app.forms import registry
from latolato.app.run_request import RunRequest
from latolato.app.runs import compute
from latolato.core.quantities import UNIT_INTERVAL, quantity_field
from latolato.core.scalar import cosine, formula, sine
from latolato.physics.drives import Drive, PeriodicDrive, drives
from page_blocks import unpack

ROOT = Path(__file__).parents[2]


class Tone(NamedTuple):
    """A cosine and its third overtone."""

    start: float
    amplitude: float
    frequency: float
    phase: float
    sharpness: float


@formula
def tone_height(t, p):
    q = p.frequency * t + p.phase
    return p.amplitude * (cosine(q) + p.sharpness * cosine(3.0 * q))


@formula
def tone_velocity(t, p):
    q = p.frequency * t + p.phase
    return -p.amplitude * p.frequency * (sine(q) + 3.0 * p.sharpness * sine(3.0 * q))


@formula
def tone_acceleration(t, p):
    q = p.frequency * t + p.phase
    return -p.amplitude * p.frequency**2 * (cosine(q) + 9.0 * p.sharpness * cosine(3.0 * q))


@dataclass(frozen=True, kw_only=True)
class Sharp(PeriodicDrive):
    """A cosine with a third overtone."""

    height = staticmethod(tone_height)
    velocity = staticmethod(tone_velocity)
    acceleration = staticmethod(tone_acceleration)

    sharpness: float = quantity_field("amplitude_ratio", UNIT_INTERVAL, default=0.0)

    def segments(self, duration):
        given = self.drive_amplitude, self.drive_frequency, self.drive_phase, self.sharpness
        return [Tone(0.0, *given)]

    @property
    def fastest_frequency(self):
        return 3.0 * self.drive_frequency

    @property
    def largest_acceleration(self):
        return self.drive_amplitude * self.drive_frequency**2 * (1.0 + 9.0 * self.sharpness)


TOY = ll.LatoLato(length=0.245, mass=0.1, damping=0.005, radius=0.02, restitution=0.9)
RUN = {"initial_angle": 0.7, "duration": 5.0}


@pytest.fixture(scope="module")
def own():
    """The example of the page on drives, run as printed."""
    page = Path(__file__).parents[2] / "docs" / "how-to" / "drives.md"
    section = page.read_text(encoding="utf-8").split("## Use your own motion\n")[1]
    # Its class lives in a module, as a user's does.
    module = ModuleType("own")
    module.ll = ll
    with (
        mock.patch.dict(sys.modules, own=module),
        mock.patch.object(drives, "_entries", dict(drives._entries)),
    ):
        exec(section.split("```python\n")[1].split("```")[0], vars(module))
        yield module


@pytest.fixture(autouse=True)
def known(monkeypatch, forget):
    """Only these tests know the drives: others range over all registered ones."""
    monkeypatch.setattr(drives, "_entries", dict(drives._entries))
    drives.register("sharp")(Sharp)
    forget()


def test_a_drive_of_ones_own_moves_the_toy_like_the_packages_own(own):
    # One that does not fade is the harmonic drive.
    shaken = {"drive_amplitude": 0.02, "drive_frequency": 15.1}
    mine = ll.simulate(TOY, own.Fading(**shaken, fading_rate=0.0), **RUN)
    known = ll.simulate(TOY, ll.Harmonic(**shaken), **RUN)
    assert mine.sizes["contact"] == known.sizes["contact"] > 5
    # Same formulas up to the order of a product; 10 impacts in 5 s enlarge roundings a little.
    for name in ("angle", "pivot_height", "pivot_velocity", "pivot_acceleration", "drive_work"):
        scale = float(np.max(np.abs(known[name])))
        np.testing.assert_allclose(mine[name], known[name], rtol=0.0, atol=1e-10 * scale)


def test_the_drive_of_the_page_on_drives_runs_as_printed(own):
    assert own.run.pivot_height[0] == pytest.approx(0.03, abs=1e-15)
    assert own.run.attrs["energy_residual"] < 1e-9
    heights = own.run.pivot_height.values
    # Differences of 100 samples per period err by 2e-4 of the slope.
    slope = np.gradient(heights, own.run.time.values)
    np.testing.assert_allclose(slope[1:-1], own.run.pivot_velocity.values[1:-1], atol=1e-3)
    slope = np.gradient(own.run.pivot_velocity.values, own.run.time.values)
    np.testing.assert_allclose(slope[1:-1], own.run.pivot_acceleration.values[1:-1], atol=1e-2)


def test_a_drive_of_ones_own_is_swept_along_its_own_parameters(own):
    rates = np.array([0.2, 0.4])
    drive = own.Fading(drive_amplitude=0.02, drive_frequency=15.1, fading_rate=0.2)
    run = {"initial_angle": 0.7, "duration": 1.0, "tolerance": 1e-8}
    axes, seen = {"fading_rate": rates}, ["final_angle"]
    grid = ll.sweep(TOY, drive, axes=axes, observables=seen, executor="reference", **run)
    for value, found in zip(rates, grid.final_angle.values, strict=True):
        one = ll.simulate(TOY, replace(drive, fading_rate=value), **run)
        # Two impacts at a tolerance of 1e-8; `simulate` may halve the step, a sweep does not.
        assert found == pytest.approx(float(one.angle[-1]), abs=1e-7)


def test_a_drive_without_bounds_or_with_former_jumps_is_refused(own):
    class Boundless(own.Fading):
        fastest_frequency = Drive.fastest_frequency

    found = Boundless(drive_amplitude=0.1, drive_frequency=3.0, fading_rate=0.0)
    with pytest.raises(TypeError, match="must define fastest_frequency and largest_acceleration"):
        ll.simulate(ll.Pendulum(length=1.0, mass=1.0), found, initial_angle=0.1, duration=1.0)
    with pytest.raises(TypeError, match="a segment has its `jump`"):

        class Jumping(own.Fading):
            def velocity_jumps(self, duration):
                return [0.0]


# A sharp drive without its overtone is the harmonic one, and with it it is not.
PENDULUM = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
SHAKEN = {"drive_amplitude": 0.05, "drive_frequency": 6.26}
SOFT, SHARP = Sharp(**SHAKEN), Sharp(**SHAKEN, sharpness=0.1)
HARMONIC = ll.Harmonic(**SHAKEN)
# Motions of one law whose formulas differ by roundings.
CLOSE = {"rtol": 1e-6, "atol": 1e-9}


def equal(name, own, harmonic, **close):
    """Compare a variable of two answers; `close` where roundings grow."""
    np.testing.assert_allclose(own[name], harmonic[name], **(close or CLOSE))


def test_a_periodic_drive_of_ones_own_repeats_itself():
    period, t = math.tau / SHARP.drive_frequency, np.linspace(0.0, 1.0, 7)
    run = ll.simulate(PENDULUM, SHARP, initial_angle=0.1, times=[*t, *(t + period)][1:])
    heights = np.array([SHARP.height(0.0, SHARP.segments(9.0)[0]), *run.pivot_height])
    np.testing.assert_allclose(heights[:7], heights[7:], rtol=0.0, atol=1e-15)


def test_it_is_swept_over_ratios_and_followed_from_point_to_point():
    options = {"duration": 20.0, "observables": ["largest_angle"], "initial_angle": 0.1}
    axes = {"drive_amplitude": [0.02, 0.05], "frequency_ratio": [1.9, 2.0, 2.1]}
    for more in ({}, {"continuation": "frequency_ratio"}):
        found = [ll.sweep(PENDULUM, d, axes=axes, **options, **more) for d in (SOFT, HARMONIC)]
        equal("largest_angle", *found)
    both, plain = (
        axes | {"sharpness": [0.0, 0.1]},
        ll.sweep(PENDULUM, HARMONIC, axes=axes, **options),
    )
    equal("largest_angle", ll.sweep(PENDULUM, SHARP, axes=both, **options).isel(sharpness=0), plain)


def test_it_is_looked_at_once_per_period():
    options = {"initial_angle": 0.1, "transient_periods": 100}
    sections = [poincare_section(PENDULUM, d, periods=4, **options) for d in (SOFT, HARMONIC)]
    equal("angle", *sections)
    span = {"parameter": "frequency_ratio", "low": 1.9, "high": 2.1, "points": 3}
    diagrams = [bifurcation_diagram(PENDULUM, d, **span, **options) for d in (SOFT, HARMONIC)]
    equal("largest_angle_watched", *diagrams)
    found = response_period(PENDULUM, SHARP, initial_angle=1.0, transient_periods=400)
    assert found.response_period == 2.0


def test_its_orbits_and_their_branches_are_followed():
    found = [floquet(PENDULUM, d, period=2, initial_angle=1.0) for d in (SOFT, HARMONIC, SHARP)]
    equal("multipliers", *found[:2])
    assert abs(found[2].multipliers - found[0].multipliers).max() > 1e-4
    options = {"parameter": "sharpness", "low": 0.0, "high": 0.1, "period": 2, "initial_angle": 1.0}
    branch = continue_orbit(PENDULUM, SOFT, **options)
    assert float(branch.sharpness.max()) == pytest.approx(0.1)


def test_its_small_motions_grow_as_those_of_any_waveform():
    growth = ll.analysis.growth_rate
    equal("growth_rate", *(growth(PENDULUM, d) for d in (SOFT, HARMONIC)))
    plain, checked = (growth(PENDULUM, SHARP, method=m) for m in ("determinant", "monodromy"))
    equal("growth_rate", plain, checked)
    edges = [ll.analysis.tongue_edges(PENDULUM, d, drive_amplitude=0.05) for d in (SOFT, HARMONIC)]
    equal("high", *edges)


def test_pages_analyse_it(tmp_path):
    laws = {"system": "pendulum", "length": "1 m", "mass": "0.8 kg", "damping": "0.05 kg m/s"}
    run = {"drive_amplitude": "5 cm", "drive_frequency": "6.26", "initial_angle": "0.1",
           "duration": "5 s"}  # fmt: skip
    asked = {"scenario": None, "options": {**laws, **run, "drive": "sharp"}}
    assert "sharpness" in about_request(RunRequest.from_json(asked))["parameters"]
    asked = {
        "options": {**laws, **run, "drive": "sharp", "sharpness": "0.1"} | {"initial_angle": "1"}
    }
    given = {"analysis": "floquet", "settings": {"period": "2"}}
    answer, _ = compute_analysis({**asked, **given}, tmp_path, print)
    assert answer["lines"]
    assert (tmp_path / "result.png").exists()


def test_it_has_a_form_and_runs_in_the_app():
    form = registry()["drives"]["sharp"]
    assert form["title"] == "Sharp"
    assert form["options"] == ["drive_amplitude", "drive_frequency", "drive_phase", "sharpness"]
    asked = {"options": {"system": "pendulum", "length": "1", "mass": "1", "drive": "sharp",
             "drive_amplitude": "5 cm", "drive_frequency": "6", "sharpness": "0.2",
             "initial_angle": "0.1", "duration": "1"}}  # fmt: skip
    about, _ = unpack(compute(RunRequest.from_json(asked)))
    assert about["attributes"]["sharpness"] == 0.2
    assert not about["is_sinusoidal"]
    asked["options"] |= {"drive": "harmonic", "sharpness": None}
    about, _ = unpack(compute(RunRequest.from_json(asked)))
    assert about["is_sinusoidal"]


def test_the_command_line_knows_it(tmp_path):
    program = (
        # The name of this module is in the keys of its kernels, which are compiled already.
        f"import sys; sys.path[:0] = {[str(ROOT), str(ROOT / 'tests' / 'shared')]!r}\n"
        f"from {__name__} import Sharp, drives\n"
        "drives.register('sharp')(Sharp)\n"
        "from latolato.cli.main import main\nmain()"
    )
    words = (
        "simulate --system pendulum --length 1 --mass 1 --drive sharp --drive-amplitude 5cm "
        "--drive-frequency 6 --sharpness 0.2 --initial-angle 0.1 --duration 1 --json"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, *words.split()], cwd=tmp_path, check=True,
        capture_output=True, text=True,
    )  # fmt: skip
    assert json.loads(done.stdout)["status"] == "complete"
