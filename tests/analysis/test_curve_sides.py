"""Runs on both sides of curves of bifurcations do what the curve says, whatever made the curve."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import fsolve
from scipy.special import ellipk, ellipkinc

import latolato as ll
from latolato.analysis.bifurcation_curve import KINDS, bifurcation_curve

PENDULUM = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
STRING = ll.Pendulum(length=1.0, mass=0.8, damping=0.05, suspension="string")
TOY = ll.LatoLato(length=0.245, mass=0.106, damping=0.005, radius=0.02, restitution=0.85)
SHARE = 1e-3


def shake(system, ratio, amplitude, phase=0.0):
    return ll.Harmonic(
        drive_amplitude=amplitude, drive_frequency=ratio * system.natural_frequency,
        drive_phase=phase,
    )  # fmt: skip


def start_at(point):
    return {
        "initial_angle": float(point.initial_angle),
        "initial_angular_velocity": float(point.initial_angular_velocity),
    }


def strobed(system, drive, start, periods):
    """Return angle and angular velocity after these whole numbers of drive periods."""
    times = np.asarray(periods, dtype=float) * math.tau / drive.drive_frequency
    run = ll.simulate(system, drive, times=times, **start)
    return np.array([run.angle.values, run.angular_velocity.values / system.natural_frequency]).T


def keeps_swinging(system, drive, point):
    """Whether a run that begins on the motion at the fold still swings about as far at its end."""
    period = math.tau / drive.drive_frequency
    times = period * np.linspace(1990.0, 2000.0, 1001)
    late = ll.simulate(system, drive, times=times, **start_at(point)).angle.values
    return late.max() > 0.8 * float(point.largest_angle)


def repeats_every_period(system, drive, point):
    """Whether a run beside the motion ends in one that each drive period repeats."""
    start = start_at(point)
    start["initial_angular_velocity"] *= 1.001
    before, after = strobed(system, drive, start, [1999, 2000])
    return bool(np.linalg.norm(after - before) < 1e-5)


def stays_symmetric(system, drive, point):
    """Whether a small push of a hanging ball, which its mirror image lacks, dies out."""
    run = strobed(system, drive, {"initial_angle": 1e-6}, range(501))
    size = np.linalg.norm(run, axis=1)
    return bool(size[-20:].max() < size[180:200].max())


def rests(system, drive, point):
    """Whether a ball that begins at rest on the wall never leaves it."""
    times = np.linspace(0.0, 20.0 * math.tau / drive.drive_frequency, 2001)
    angle = ll.simulate(system, drive, times=times, **start_at(point)).angle.values
    return bool(np.ptp(angle) < 1e-12)


def stays_taut(system, drive, point):
    """Whether the string of the motion at the curve does not go slack for a period."""
    times = np.linspace(0.0, 2.0 * math.tau / drive.drive_frequency, 201)
    run = ll.simulate(system, drive, times=times, **start_at(point))
    return "slack" not in set(run.contact_kind.values.astype(str))


def is_without_new_impact(system, drive, point):
    """Whether the motion beside the curve has no more impacts than the one that grazes.

    Its start, half a drive period later and so away from the wall, is solved for by SciPy, from
    whole periods of `simulate`.
    """
    own = shake(system, float(point.frequency_ratio), float(point.drive_amplitude))
    guess = strobed(system, own, start_at(point), [0.0, 0.5])[1]
    drive = replace(drive, drive_phase=math.pi)

    def begun(start):
        angle, velocity = max(start[0], system.contact_angle_low), start[1]
        return {
            "initial_angle": angle,
            "initial_angular_velocity": velocity * system.natural_frequency,
        }

    solved, about, *_ = fsolve(
        lambda start: strobed(system, drive, begun(start), [0, 1])[1] - start, guess,
        full_output=True, xtol=1e-12,
    )  # fmt: skip
    run = ll.simulate(system, drive, duration=math.tau / drive.drive_frequency, **begun(solved))
    closes = np.linalg.norm(about["fvec"]) < 1e-9 and np.linalg.norm(solved - guess) < 0.01
    return bool(closes) and run.sizes["contact"] == int(point.impacts)


def fold():
    return TOY, bifurcation_curve(
        TOY, shake(TOY, 1.5197, 0.03), low=(0.01, 0.8), high=(0.06, 6.0),
        initial_angle=1.48775, initial_angular_velocity=5.83894,
    )  # fmt: skip


def doubling():
    return TOY, bifurcation_curve(
        TOY, shake(TOY, 4.73, 0.03), kind="period_doubling", low=(0.02, 4.0), high=(0.04, 6.0),
        initial_angle=0.0849, initial_angular_velocity=0.658,
    )  # fmt: skip


def breaking():
    return PENDULUM, bifurcation_curve(
        PENDULUM, shake(PENDULUM, 0.9897, 0.2955), kind="symmetry_breaking", low=(0.1, 0.5),
        high=(0.5, 1.5),
    )  # fmt: skip


def graze():
    return TOY, bifurcation_curve(
        TOY, shake(TOY, 4.573, 0.03), kind="grazing", low=(0.01, 3.0), high=(0.08, 6.0),
        initial_angle=0.08174, initial_angular_velocity=0.0132,
    )  # fmt: skip


def lift_off():
    return TOY, bifurcation_curve(
        TOY, shake(TOY, 2.8, 0.03), kind="lift_off", low=(0.005, 1.0), high=(0.1, 8.0),
        initial_angle=TOY.contact_angle_low,
    )  # fmt: skip


def slack():
    return STRING, bifurcation_curve(
        STRING, shake(STRING, 2.2, 0.2), kind="slack_onset", low=(0.05, 1.0), high=(0.5, 4.0)
    )  # fmt: skip


CURVES = {
    "fold": (fold, keeps_swinging),
    "period_doubling": (doubling, repeats_every_period),
    "symmetry_breaking": (breaking, stays_symmetric),
    "grazing": (graze, is_without_new_impact),
    "lift_off": (lift_off, rests),
    "slack_onset": (slack, stays_taut),
}


@pytest.mark.parametrize("kind", KINDS)
def test_runs_on_both_sides_of_a_curve_do_what_its_kind_says(kind):
    make, holds = CURVES[kind]
    system, curve = make()
    assert list(curve.end_reason.values) == ["end of range"] * 2
    logarithms = np.log([curve.drive_amplitude.values, curve.frequency_ratio.values])
    along = np.gradient(logarithms, axis=1)
    across = np.array([-along[1], along[0]]) / np.abs(along).max(axis=0)
    count = curve.sizes["point"]
    found = []
    for i in np.linspace(0.15 * count, 0.85 * count, 4).astype(int):
        for side in (SHARE, -SHARE):
            amplitude, ratio = np.exp(logarithms[:, i] + side * across[:, i])
            found.append(holds(system, shake(system, ratio, amplitude), curve.isel(point=i)))
    # One side of the whole curve has what the other one lacks.
    assert found in ([True, False] * 4, [False, True] * 4)


@pytest.mark.parametrize("phase", [0.0, math.pi])
def test_a_bounce_that_just_reaches_the_top_takes_the_time_of_elliptic_integrals(phase):
    # Without drag and loss, and with less and less drive, it swings freely from one wall to the
    # other: at the angle at which the balls meet at the top it stands still.
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=math.sin(0.4), restitution=1.0)
    modulus = math.sin(0.5 * toy.contact_angle_high)
    low = math.asin(math.sin(0.5 * toy.contact_angle_low) / modulus)
    free = math.pi / float(ellipk(modulus**2) - ellipkinc(low, modulus**2))
    curve = bifurcation_curve(
        toy, shake(toy, free, 0.01, phase), kind="grazing", points=60,
        low=(1e-4, 0.5 * free), high=(0.05, 1.5 * free),
        initial_angle=toy.contact_angle_high - 1e-6,
    )  # fmt: skip
    assert set(curve.word.values) == {"B"}
    order = np.argsort(curve.drive_amplitude.values)[:25]
    amplitude, ratio = curve.drive_amplitude.values[order], curve.frequency_ratio.values[order]
    assert amplitude[0] == pytest.approx(1e-4)
    assert abs(ratio[0] - free) > 1e-6
    assert float(np.polyfit(amplitude, ratio, 4)[-1]) == pytest.approx(free, abs=1e-10)
