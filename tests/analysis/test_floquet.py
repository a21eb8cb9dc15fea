"""Multipliers of periodic motions: known values, invariants, and doubt where it is due."""

import math

import numpy as np
import pytest

import latolato as ll
from hanging import growth_rate
from latolato.analysis.floquet import floquet

NATURAL = math.sqrt(9.8)
PENDULUM = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
SHAKE = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.26)
TOY = ll.LatoLato(length=0.245, mass=0.1, radius=0.0196, damping=0.00274, restitution=0.9)
TOY_SHAKE = ll.Harmonic(drive_amplitude=0.03, drive_frequency=2.389 * math.sqrt(9.8 / 0.245))


@pytest.mark.parametrize("kind", [ll.Pendulum, ll.Mathieu])
@pytest.mark.parametrize("damping", [0.0, 0.05])
def test_hanging_still_grows_as_hills_determinant_says(kind, damping):
    result = floquet(kind(length=1.0, mass=0.8, damping=damping), SHAKE)
    expected = growth_rate(
        drive_amplitude=0.05, drive_frequency=6.26, length=1.0, mass=0.8, damping=damping
    )
    assert result.growth_rate.item() == pytest.approx(float(expected), abs=1e-9)
    assert result.status.item() == "unstable"
    assert result.multiplier_error.item() < 1e-10


@pytest.mark.parametrize("amplitude, status", [(0.1, "unstable"), (0.12, "stable")])
def test_upright_is_stable_above_kapitzas_amplitude(amplitude, status):
    # A0 w > sqrt(2 g l) to first order: at w = 40 that is 0.1107 m.
    fast = ll.Harmonic(drive_amplitude=amplitude, drive_frequency=40.0)
    result = floquet(PENDULUM, fast, initial_angle=math.pi)
    assert result.initial_angle.item() == pytest.approx(math.pi, abs=1e-12)
    assert result.status.item() == status


def test_multipliers_multiply_to_what_drag_and_impacts_take():
    cases = (
        (PENDULUM, SHAKE, {}, 1),
        (TOY, TOY_SHAKE, {"initial_angle": 0.3, "initial_angular_velocity": 1.0}, 1),
        (TOY, TOY_SHAKE, {"initial_angle": 0.3, "initial_angular_velocity": 1.0}, 2),
    )
    for system, drive, start, period in cases:
        result = floquet(system, drive, period=period, **start)
        time = period * math.tau / drive.drive_frequency
        rate = system.damping / (system.mass * system.length)
        bounces = result.impacts.item() * 2.0 * math.log(getattr(system, "restitution", 1.0))
        expected = math.exp(-rate * time + bounces)
        product = np.prod(result.multipliers.values)
        # Rounding of a determinant of matrices with entries up to ten.
        assert product == pytest.approx(expected, abs=1e-12)
        assert result.determinant.item() == pytest.approx(expected, abs=1e-12)
        assert result.expected_determinant.item() == pytest.approx(expected, abs=1e-12)
        assert result.difference_residual.item() < 1e-6


def test_a_run_that_settles_on_another_motion_than_its_orbit_is_mentioned_with_its_end():
    toy = ll.LatoLato(length=0.2, mass=0.05, damping=0.001, radius=0.018, restitution=0.9)
    drive = ll.Harmonic(drive_amplitude=0.06, drive_frequency=6.0 * math.pi)
    held = {"initial_angle": math.radians(20.0)}
    near = floquet(toy, drive, **held)
    gap = held["initial_angle"] - near.initial_angle
    velocity = near.initial_angular_velocity / toy.natural_frequency
    assert near.guess_distance.item() == pytest.approx(math.hypot(gap, velocity))
    assert near.status.item() == "unstable"
    assert np.degrees(near.initial_angle.item()) < 6.0
    branch = ll.analysis.continue_orbit(toy, drive, low=1.0, high=3.0, points=1, **held)
    assert branch.attrs["message"] == near.attrs["message"]
    assert branch.guess_distance == near.guess_distance
    run = ll.simulate(toy, drive, duration=400 * math.tau / drive.drive_frequency, **held)
    angle, velocity = (run[name][-1].item() for name in ("angle", "angular_velocity"))
    assert (
        f"its angle is {angle:.6g} rad and its angular velocity {velocity:.6g} rad/s"
        in (near.attrs["message"])
    )
    # From there the orbit of the run itself, to which a start beside it leads as well.
    for change in (0.0, -0.7):
        own = floquet(toy, drive, initial_angle=angle, initial_angular_velocity=velocity + change)
        assert own.status.item() == "stable"
        assert own.initial_angle.item() == pytest.approx(angle, abs=1e-5)
        assert "message" not in own.attrs


def test_two_mirrored_balls_have_the_multipliers_of_one():
    one = floquet(TOY, TOY_SHAKE, initial_angle=0.3, initial_angular_velocity=1.0)
    ball = TOY.balls[0]
    pair = ll.BallPair(right=ball, left=ball, restitution=TOY.restitution)
    two = floquet(pair, TOY_SHAKE, initial_angle=(0.3, -0.3), initial_angular_velocity=(1.0, -1.0))
    assert two.multipliers.shape == (4,)
    for multiplier in one.multipliers.values:
        assert np.min(np.abs(two.multipliers.values - multiplier)) < 1e-9
    assert two.initial_angle.values == pytest.approx(
        [one.initial_angle.item(), -one.initial_angle.item()], abs=1e-10
    )


def test_twice_the_period_squares_the_multipliers():
    once = floquet(TOY, TOY_SHAKE, initial_angle=0.3, initial_angular_velocity=1.0)
    names = ("initial_angle", "initial_angular_velocity")
    orbit = {name: once[name].item() for name in names}
    twice = floquet(TOY, TOY_SHAKE, period=2, **orbit)
    assert "message" not in floquet(TOY, TOY_SHAKE, **orbit).attrs
    assert "repeats after 1 of 2 drive periods" in twice.attrs["message"]
    assert twice.response_period.item() == 1
    assert twice.multipliers.values == pytest.approx(once.multipliers.values**2, abs=1e-9)


def test_the_swing_in_the_tongue_has_period_two_and_is_stable():
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=2.0 * NATURAL)
    end = 400 * math.tau / drive.drive_frequency
    run = ll.simulate(PENDULUM, drive, initial_angle=0.1, times=[0.0, end])
    result = floquet(
        PENDULUM, drive, period=2,
        initial_angle=run.angle.values[-1],
        initial_angular_velocity=run.angular_velocity.values[-1],
    )  # fmt: skip
    assert (result.status.item(), result.response_period.item()) == ("stable", 2)
    assert abs(result.initial_angular_velocity.item()) > 0.1  # not the hanging one


def test_a_toy_at_rest_has_multipliers_of_exactly_zero():
    result = floquet(TOY, None or ll.Harmonic(drive_amplitude=0.01, drive_frequency=10.0),
                    initial_offset=0.0)  # fmt: skip
    assert result.status.item() == "rest"
    assert not result.multipliers.values.any()
    assert result.growth_rate.item() == -math.inf


def test_a_rotating_pendulum_repeats_itself_modulo_a_turn():
    # Locked to one turn per drive period.
    drive = ll.Harmonic(drive_amplitude=0.1, drive_frequency=2.0 * NATURAL)
    starts = ((angle, drive.drive_frequency) for angle in np.linspace(-3.0, 3.0, 7))
    tried = [
        floquet(PENDULUM, drive, initial_angle=angle, initial_angular_velocity=velocity)
        for angle, velocity in starts
    ]
    turning = [result for result in tried if result.turns.item() == 1]
    assert turning
    for result in turning:
        run = ll.simulate(
            PENDULUM, drive, times=[0.0, math.tau / drive.drive_frequency],
            initial_angle=result.initial_angle.item(),
            initial_angular_velocity=result.initial_angular_velocity.item(),
        )  # fmt: skip
        assert run.angle.values[1] - run.angle.values[0] == pytest.approx(math.tau, abs=1e-9)


def test_what_is_not_there_is_said_and_not_made_up():
    free = ll.Harmonic(drive_amplitude=0.4, drive_frequency=9.0)
    with pytest.warns(RuntimeWarning, match="no motion of period 1"):
        result = floquet(
            ll.LatoLato(length=1.0, mass=0.8, radius=0.1), free, initial_angle=1.0, tolerance=1e-6,
            initial_angular_velocity=2.0,
        )  # fmt: skip
    assert result.status.item() == "not found"
    assert np.isnan(result.multipliers.values).all()
    assert math.isnan(result.growth_rate.item())


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"drive": None}, "must repeat itself"),
        ({"drive": ll.Chirp(drive_amplitude=0.1, drive_frequency=2.0, drive_frequency_final=4.0,
                            sweep_time=10.0)}, "must repeat itself"),
        ({"drive": ll.Harmonic(drive_amplitude=0.1, drive_frequency=0.0)}, "must lie in"),
        ({"period": 0}, "period must lie in"),
        ({"period": 17}, "period must lie in"),
        ({"period": 1.5}, "whole number"),
        ({"system": TOY}, "initial_angle is needed"),
        ({"system": TOY, "initial_angle": 0.0}, "overlap"),
        ({"system": TOY, "initial_offset": 0.1, "contact": "clamp"}, "exact or none"),
        ({"initial_angle": math.nan}, "must be a number in rad, got nan"),
    ],
)  # fmt: skip
def test_bad_input_is_refused_with_a_way_out(changes, message):
    arguments = {"system": PENDULUM, "drive": SHAKE} | changes
    with pytest.raises(ValueError, match=message):
        floquet(arguments.pop("system"), arguments.pop("drive"), **arguments)
