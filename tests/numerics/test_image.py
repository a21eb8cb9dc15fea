"""Small deviations through slack: the saltation matrices of slack, taut and hits in between."""

import math
from dataclasses import replace

import numpy as np
import pytest

import latolato as ll
from latolato.analysis.floquet import floquet
from latolato.analysis.flow import Flow
from latolato.analysis.lyapunov_spectrum import lyapunov_spectrum
from latolato.core.errors import InputError
from latolato.numerics.records import C_RADIAL
from latolato.physics.contacts import BOTTOM, SLACK, TAUT, TOP

STRING = ll.Pendulum(length=1.0, mass=0.8, suspension="string")
LOOP = (0.0, math.sqrt(3.5 * STRING.gravity))  # goes slack above the pivot
STILL = ll.Harmonic(drive_amplitude=0.0, drive_frequency=5.0)
SHAKEN = ll.Harmonic(drive_amplitude=0.1, drive_frequency=5.0)
CIRCLED = ll.PlanarHarmonic(
    vertical_amplitude=0.2, horizontal_amplitude=0.15, drive_frequency=6.0, horizontal_phase=1.0
)
TOY = ll.LatoLato(
    length=0.186, radius=0.012, mass=0.05, restitution=0.822, damping=1.5e-3, suspension="string"
)
HAND = ll.Harmonic(drive_amplitude=0.05, drive_frequency=18.0)
PAIR = ll.BallPair(
    right=ll.Ball(length=1.27, mass=0.8, radius=0.05, damping=0.05),
    left=ll.Ball(length=1.2, mass=0.5, radius=0.04, damping=0.03),
    restitution=0.8,
    suspension="string",
)

_TWIN = ll.Ball(length=0.186, radius=0.012, mass=0.05, damping=1.5e-3)
TWINS = ll.BallPair(right=_TWIN, left=_TWIN, restitution=0.822, suspension="string")


def bouncing(system, restitution):
    return replace(system, string_restitution=restitution)


# What begins where, for how long [s], and what must happen on the way.
MOTIONS = {
    "loop": (STRING, STILL, LOOP, 2.5, [SLACK, TAUT]),
    "thrown back": (bouncing(STRING, 0.3), STILL, LOOP, 6.0, [SLACK, TAUT, TAUT]),
    "driven with drag": (replace(STRING, damping=0.05), SHAKEN, (0.3, 6.0), 6.0, [SLACK, TAUT]),
    "quadratic drag": (
        replace(STRING, damping=0.05, quadratic_damping=0.08), SHAKEN, (0.3, 6.0), 6.0,
        [SLACK, TAUT],
    ),
    "air in the room, circling pivot": (
        replace(STRING, damping=0.1, drag_frame="lab"), CIRCLED, (0.3, 5.0), 6.0,
        [SLACK, TAUT, SLACK, TAUT],
    ),
    "toy": (TOY, HAND, (0.5, 3.0), 2.0, [SLACK, TAUT, BOTTOM, SLACK, TAUT]),
    "toy whose balls are thrown back": (
        bouncing(TOY, 0.9), HAND, (0.5, 3.0), 1.5, [SLACK, TAUT, TAUT],
    ),
    "toy, a hit at the top": (
        replace(TOY, restitution=0.5), STILL, (0.3, 16.2), 1.2, [TOP, SLACK, TAUT],
    ),
    "two balls, one after the other": (
        PAIR, SHAKEN, (0.34, 4.23, -0.4, -2.03), 2.0, [SLACK, TAUT, BOTTOM, SLACK, TAUT],
    ),
    "hits that loosen the shorter string, and hits while it is slack": (
        PAIR, SHAKEN, (0.61, 1.36, -0.65, 0.46), 2.0, [BOTTOM, SLACK, BOTTOM, TAUT],
    ),
    "two balls that meet at the top": (
        PAIR, SHAKEN, (0.44, 5.13, -0.89, -5.88), 2.0, [SLACK, TOP, SLACK, TAUT, TAUT],
    ),
    "two mirrored balls, always at once": (
        TWINS, HAND, (0.5, 3.0, -0.5, -3.0), 2.0, [SLACK, SLACK, TAUT, TAUT, BOTTOM, SLACK],
    ),
    "two balls that are thrown back": (
        bouncing(PAIR, 0.4), SHAKEN, (0.89, 1.54, -0.6, -0.57), 3.0,
        [SLACK, TAUT, TAUT, BOTTOM, TAUT],
    ),
}  # fmt: skip


def flow_of(system, drive):
    return Flow(system, drive, speed=20.0, through_slack=True)


def holds(kinds, expected):
    """Return whether the expected kinds occur in this order."""
    rest = iter(kinds)
    return all(kind in rest for kind in expected)


@pytest.mark.parametrize("name", MOTIONS)
def test_matrices_are_the_differences_of_neighbouring_motions(name):
    system, drive, start, duration, expected = MOTIONS[name]
    flow, start = flow_of(system, drive), np.array(start)
    passage = flow.follow(start, duration)
    assert holds(passage.contact_kinds, expected), passage.contact_kinds
    assert passage.is_complete
    columns = []
    for nudge in 1e-6 * np.eye(start.size):
        one, two = (
            flow.follow(start + k * nudge, duration).end
            - flow.follow(start - k * nudge, duration).end
            for k in (1, 2)
        )
        columns.append((8.0 * one - two) / 12e-6)
    # Motions are known to 1e-12 or so.
    error = np.abs(np.array(columns).T - passage.matrix).max() / np.abs(passage.matrix).max()
    assert error < 1e-6


class TestDeterminant:
    """Each impact takes ``d(loss) d(time)``, in units of m l^2, from the area of deviations."""

    @pytest.mark.parametrize("restitution", [0.0, 0.3])
    @pytest.mark.parametrize("damping", [0.0, 0.05])
    def test_area_that_tightening_takes(self, restitution, damping):
        system = replace(STRING, damping=damping, string_restitution=restitution)
        flow, start, duration = flow_of(system, STILL), np.array(LOOP), 6.0
        passage = flow.follow(start, duration)
        mass, rate = system.mass, damping / (system.mass * system.length)
        nudge = 1e-5
        taken = 0.0
        rows = np.flatnonzero(passage.contact_kinds == TAUT)
        assert rows.size == 1 if restitution == 0.0 else rows.size > 5
        for row in rows[:6]:  # those that follow are a thousand times smaller
            slopes = []
            for step in nudge * np.eye(2):
                ahead, behind = (
                    tightening(flow, start + k * step, duration, row) for k in (1.0, -1.0)
                )
                slopes.append((ahead - behind) / (2.0 * nudge))
            (loss_1, time_1), (loss_2, time_2) = slopes
            before = passage.contact_times[row]
            area = (loss_1 * time_2 - loss_2 * time_1) / mass
            taken += area * math.exp(rate * before)
        expected = math.exp(-rate * duration) * (1.0 - taken)
        assert np.linalg.det(passage.matrix) == pytest.approx(expected, rel=2e-3)

    def test_without_loss_nothing_is_taken(self):
        elastic = bouncing(STRING, 1.0)
        matrix = flow_of(elastic, STILL).follow(np.array([0.3, 2.0]), 5.0).matrix
        assert np.linalg.det(matrix) == pytest.approx(1.0, abs=1e-10)


def tightening(flow, start, duration, row):
    """Return the energy that a string takes [J], and when [s]."""
    passage = flow.follow(start, duration)
    before, after = passage.contact_values[[C_RADIAL, C_RADIAL + 1], row]
    return np.array([
        0.5 * flow.system.mass * (before**2 - after**2), passage.contact_times[row],
    ])  # fmt: skip


def test_multipliers_of_an_orbit_through_slack():
    system = ll.Pendulum(length=1.0, mass=0.8, damping=0.44, suspension="string")
    drive = ll.Harmonic(drive_amplitude=0.21, drive_frequency=1.93 * system.natural_frequency)
    start = {"initial_angle": 0.44, "initial_angular_velocity": 4.13}
    result = floquet(system, drive, period=2, **start)
    assert result.status == "stable"
    assert result.difference_residual < 1e-6
    assert math.isnan(result.expected_determinant)
    exponents = lyapunov_spectrum(system, drive, duration=4000.0, transient=200.0, **start)
    duration = 2.0 * math.tau / drive.drive_frequency
    by_orbit = np.log(np.abs(result.multipliers.values)) / duration
    # The growth of single directions is averaged over the run; the exponents converge as 1/time.
    assert exponents.lyapunov_exponents.values == pytest.approx(by_orbit, abs=5e-3)
    assert math.isnan(exponents.sum_rule_residual)


def test_an_orbit_begins_taut():
    system = ll.Pendulum(length=1.0, mass=0.8, damping=0.44, suspension="string")
    drive = ll.Harmonic(drive_amplitude=0.21366, drive_frequency=2.74 * system.natural_frequency)
    with pytest.warns(RuntimeWarning, match="strings must be taut at time zero"):
        result = floquet(system, drive, period=2, initial_angle=-0.0157)
    assert result.status == "not found"


def test_the_past_is_lost_at_rest_and_unknown_where_string_and_ball_meet_at_once():
    toy = replace(TOY, damping=0.0)
    low = toy.contact_angle_low
    drive = ll.Harmonic(drive_amplitude=1.2 * toy.gravity / 18.0**2, drive_frequency=18.0)
    ball = ll.Ball(length=0.186, radius=0.012, mass=0.05)
    pair = ll.BallPair(right=ball, left=ball, restitution=0.822, suspension="string")
    alone, both = (
        ll.sweep(
            system, drive, axes={"drive_frequency": [18.0]}, observables=["lyapunov_exponent"],
            initial_angle=angles, duration=10.0, transient=0.0,
        ).lyapunov_exponent.values[0]
        for system, angles in ((toy, low), (pair, (low, -low)))
    )  # fmt: skip
    assert alone == -math.inf
    assert math.isnan(both)


def test_dry_friction_on_strings_is_refused():
    rough = replace(STRING, coulomb_damping=0.1)
    words = "coulomb_damping must be 0 for lyapunov_exponent on strings"
    with pytest.raises(InputError, match=words):
        lyapunov_spectrum(rough, SHAKEN, initial_angle=0.3, duration=20.0)
    with pytest.raises(InputError, match="coulomb_damping must be 0 for orbits on strings"):
        floquet(rough, SHAKEN)
    with pytest.raises(InputError, match="coulomb_damping must be 0 for lyapunov_exponent on"):
        ll.sweep(STRING, SHAKEN, axes={"coulomb_damping": [0.0, 0.1]}, duration=5.0,
            observables=["lyapunov_exponent"], initial_angle=0.3)  # fmt: skip
