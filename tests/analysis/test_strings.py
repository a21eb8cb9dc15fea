"""Analyses of strings, of air at rest in the room, and of a pivot that moves sideways."""

import math
from dataclasses import replace
from inspect import signature

import numpy as np
import pytest

import latolato as ll
from latolato.analysis.checks import hits_pull
from latolato.analysis.continue_orbit import continue_orbit
from latolato.analysis.floquet import floquet
from latolato.analysis.lyapunov_spectrum import lyapunov_spectrum
from latolato.analysis.pair_symmetry import as_pair
from latolato.analysis.poincare_section import poincare_section
from latolato.analysis.response_period import response_period
from latolato.core.errors import InputError

NATURAL = math.sqrt(9.8)
ROD = ll.Pendulum(length=1.0, mass=0.8, damping=0.3)
STRING = ll.Pendulum(length=1.0, mass=0.8, damping=0.3, suspension="string")
ROOM = ll.Pendulum(length=1.0, mass=0.8, damping=0.3, drag_frame="lab")
TOY = {"length": 1.0, "mass": 0.8, "radius": 0.1, "damping": 0.05, "restitution": 0.9}
BALL = ll.Ball(length=1.0, mass=0.8, radius=0.1, damping=0.05)
PLANAR = ll.PlanarHarmonic(
    vertical_amplitude=0.1, horizontal_amplitude=0.05, drive_frequency=2.0, horizontal_phase=1.0
)


def shake(ratio, amplitude):
    return ll.Harmonic(drive_amplitude=amplitude, drive_frequency=ratio * NATURAL)


# Every analysis of a run, with what it needs beside system, drive and start.
OF_RUNS = {
    "basins": {"angle_points": 5, "velocity_points": 5},
    "bifurcation_diagram": {"parameter": "frequency_ratio", "low": 2.0, "high": 2.1, "points": 2},
    "continue_orbit": {"low": 1.0, "high": 3.0},
    "first_push": {"frequency_ratio": [2.0]},
    "floquet": {},
    "hysteresis": {"frequency_ratio": [2.0, 2.1]},
    "lyapunov_spectrum": {},
    "poincare_section": {},
    "response_period": {},
    "response_period_map": {"drive_amplitude": [0.1], "frequency_ratio": [2.0]},
    "shortest_protocol": {},
    "time_crystal": {},
}
LINEARISED = {
    "tongue_edges": {"drive_amplitude": 0.05},
    "threshold_amplitude": {},
    "growth_rate": {},
    "inverted_limits": {"frequency_ratio": 20.0},
}


def needs_start(name):
    return "initial_angle" in signature(ll.analysis.analyses[name]).parameters


@pytest.mark.parametrize("name", ["bifurcation_diagram", "hysteresis", "shortest_protocol"])
def test_motions_on_strings_are_not_carried_on_by_angle_and_velocity(name):
    start = {"initial_angle": 0.3} if needs_start(name) else {}
    with pytest.raises(InputError, match="suspension must be 'rod' here"):
        ll.analysis.analyses[name](STRING, shake(2.0, 0.1), **OF_RUNS[name], **start)


def test_the_symmetry_of_a_toy_on_strings_is_not_that_of_rods():
    toy = ll.LatoLato(**TOY, suspension="string", string_restitution=0.5)
    assert as_pair(toy).suspension == "string"
    assert as_pair(toy).string_restitution == 0.5
    drive, start = shake(2.0, 0.3), {"initial_angle": 0.8}
    strings, rods = (
        ll.analysis.pair_symmetry(ll.LatoLato(**TOY, suspension=kind), drive, **start)
        for kind in ("string", "rod")
    )
    assert strings.status.item() in ("valid", "broken")
    assert abs(strings.transverse_exponent - rods.transverse_exponent) > 1e-3
    with pytest.raises(InputError, match="breaks the mirror symmetry"):
        ll.analysis.pair_symmetry(ll.LatoLato(**TOY), PLANAR, initial_angle=0.3)


@pytest.mark.parametrize(
    "name", sorted((OF_RUNS | LINEARISED).keys() - {"lyapunov_spectrum", "floquet"})
)
def test_a_pivot_that_moves_sideways_is_refused_where_it_is_not_described(name):
    start = {"initial_angle": 0.3} if needs_start(name) else {}
    with pytest.raises(InputError, match="drive must be vertical, got 'PlanarHarmonic'"):
        ll.analysis.analyses[name](ROD, drive=PLANAR, **(OF_RUNS | LINEARISED)[name], **start)


@pytest.mark.parametrize("name", LINEARISED)
def test_drag_relative_to_the_room_has_no_closed_form(name):
    options = LINEARISED[name] | ({"drive": shake(2.0, 0.05)} if name == "growth_rate" else {})
    with pytest.raises(InputError, match="drag_frame must be 'pivot' here"):
        ll.analysis.analyses[name](ROOM, **options)
    # Without drag the air does not matter.
    still = ll.Pendulum(length=1.0, mass=0.8, drag_frame="lab")
    same = ll.analysis.analyses[name](ll.Pendulum(length=1.0, mass=0.8), **options)
    assert ll.analysis.analyses[name](still, **options).equals(same)


def test_self_start_refuses_drag_relative_to_the_room():
    with pytest.raises(InputError, match="drag_frame must be 'pivot' here"):
        ll.analysis.self_start(ll.LatoLato(**TOY, drag_frame="lab"), 2.0)


@pytest.mark.parametrize("name", ["tongue_edges", "threshold_amplitude"])
def test_a_taut_string_has_the_tongues_of_the_rod(name):
    options = LINEARISED[name] | {"drive_amplitude": 0.15} if name == "tongue_edges" else {}
    result = ll.analysis.analyses[name](STRING, **options)
    assert result.equals(ll.analysis.analyses[name](ROD, **options))
    assert result.status.item() == "found"


def test_a_tongue_ends_where_the_hanging_string_goes_slack():
    free = ll.Pendulum(length=1.0, mass=0.8)
    string = ll.Pendulum(length=1.0, mass=0.8, suspension="string")
    for amplitude in (0.20, 0.26):
        rod = ll.analysis.tongue_edges(free, drive_amplitude=amplitude)
        # A0 w^2 < g is A0/l (w/w0)^2 < 1.
        stays = [amplitude * float(edge) ** 2 < 1.0 for edge in (rod.low, rod.high)]
        if all(stays):
            result = ll.analysis.tongue_edges(string, drive_amplitude=amplitude)
            assert result.equals(rod)
            continue
        with pytest.warns(RuntimeWarning, match="slack string before the tongue ends"):
            result = ll.analysis.tongue_edges(string, drive_amplitude=amplitude)
        assert result.status.item() == "slackens"
        assert float(result.low) == float(rod.low)
        assert math.isnan(result.high)
    assert not all(stays)


def test_a_string_that_goes_slack_first_has_no_threshold_and_no_growth_rate():
    with pytest.warns(RuntimeWarning, match="goes slack at a drive that leaves hanging stable"):
        result = ll.analysis.threshold_amplitude(STRING, frequency_ratio=3.0)
    assert result.status.item() == "slackens"
    assert math.isnan(result.drive_amplitude)
    just = 1.0 / 9.0  # A0 w^2 = g at three times the natural frequency
    ll.analysis.growth_rate(STRING, shake(3.0, 0.999 * just))
    with pytest.raises(InputError, match="drive_amplitude must be smaller for a ball that hangs"):
        ll.analysis.growth_rate(STRING, shake(3.0, 1.001 * just))


def test_a_string_does_not_hold_a_ball_upright():
    for name, options in (("tongue_edges", {"drive_amplitude": 0.1}), ("growth_rate", {})):
        with pytest.raises(InputError, match="a string does not push"):
            ll.analysis.analyses[name](STRING, position="inverted", **options)
    with pytest.raises(InputError, match="a string does not push"):
        ll.analysis.inverted_limits(STRING, frequency_ratio=20.0)


@pytest.mark.parametrize("system", [ll.LatoLato(**TOY), ll.BallPair(right=BALL, left=BALL)])
def test_strings_start_by_themselves_where_rods_do(system):
    string = replace(system, suspension="string")
    result = ll.analysis.self_start(string, 3.0, check=True)
    assert result.drive_acceleration_ratio.item() == pytest.approx(1.0, rel=1e-15)
    # Beyond the onset by 1e-9 the string is slack for 1e-4 s and the gap is 1e-14 of a metre.
    expected = float(result.drive_amplitude)
    assert result.simulated_amplitude.item() == pytest.approx(expected, rel=1e-8)


def test_friction_does_not_hold_a_ball_on_a_slack_string():
    rod, string = (
        ll.LatoLato(**TOY, coulomb_damping=0.05, suspension=s) for s in ("rod", "string")
    )
    held = ll.analysis.self_start(rod, 3.0).drive_acceleration_ratio.item()
    assert held == pytest.approx(1.0 + 0.05 / (0.8 * 0.1 * 9.8), rel=1e-14)  # C0/(m g sin(angle))
    freed = ll.analysis.self_start(string, 3.0).drive_acceleration_ratio.item()
    assert freed == pytest.approx(1.0, rel=1e-15)


def test_self_start_refuses_strings_of_very_different_lengths():
    short = ll.Ball(length=0.9, mass=0.8, radius=0.1)
    pair = ll.BallPair(right=BALL, left=short, suspension="string")
    assert not hits_pull(pair)  # 1 - 0.81 > 0.04
    with pytest.raises(InputError, match="balls of so different lengths"):
        ll.analysis.self_start(pair, 3.0)
    near = ll.BallPair(right=BALL, left=ll.Ball(length=0.99, mass=0.8, radius=0.1))
    assert hits_pull(near)


def test_an_orbit_on_taut_strings_has_the_multipliers_of_rods():
    start = {"initial_angle": 0.2, "initial_angular_velocity": 1.92}
    drive = shake(2.4, 0.1)
    toys = [ll.LatoLato(**TOY, suspension=each) for each in ("rod", "string")]
    rods, strings = (floquet(toy, drive, **start) for toy in toys)
    assert rods.status.item() == "stable"
    assert rods.impacts.item() == 1.0
    assert strings.status.item() == "stable"
    assert strings.expected_determinant.item() == pytest.approx(rods.expected_determinant.item())
    # The orbit closes to 2e-11.
    assert strings.multipliers.values == pytest.approx(rods.multipliers.values, abs=1e-9)
    assert strings.attrs["suspension"] == "string"
    # The string itself comes back to the start without going slack.
    begun = rods.initial_angle.item(), rods.initial_angular_velocity.item()
    run = ll.simulate(
        toys[1], drive, initial_angle=begun[0], initial_angular_velocity=begun[1],
        duration=math.tau / drive.drive_frequency, tolerance=1e-12,
    )  # fmt: skip
    assert math.isnan(run.attrs["first_slack"])
    # The run's tolerance, after one impact.
    assert (run.angle[-1], run.angular_velocity[-1]) == pytest.approx(begun, abs=1e-9)


def swing(amplitude):
    """The swing of period 2 in the first tongue, at a start on it."""
    drive = shake(2.0, amplitude)
    run = ll.simulate(ROD, drive, initial_angle=0.9, times=[100 * math.tau / NATURAL])
    return drive, float(run.angle[-1]), float(run.angular_velocity[-1])


def least_tension(system, drive, angle, velocity):
    """The least tension of a rod over two drive periods, from many samples."""
    times = np.linspace(0.0, 2.0 * math.tau / drive.drive_frequency, 20001)
    run = ll.simulate(
        system, drive, initial_angle=angle, initial_angular_velocity=velocity, times=times
    )
    return float(run.tension.min())


def test_a_branch_on_strings_ends_where_the_least_tension_of_the_orbit_vanishes():
    drive, angle, velocity = swing(0.12)
    start = {"initial_angle": angle, "initial_angular_velocity": velocity, "period": 2}
    options = {"parameter": "drive_amplitude", "low": 0.1, "high": 0.6}
    branch = continue_orbit(STRING, drive, **options, **start)
    assert branch.status.item() == "slackens"
    assert branch.special_kind.values[-1] == "slackens"
    end = branch.special_value.values[-1]
    assert branch.drive_amplitude.values[-1] == end
    last = branch.isel(point=-1)
    state = last.initial_angle.item(), last.initial_angular_velocity.item()
    assert last.largest_angle.item() > 0.5  # a swing, not hanging still
    # Samples a ten-thousandth of a period apart miss 1e-7 of the least tension, of some 8 N.
    assert least_tension(ROD, shake(2.0, end), *state) == pytest.approx(0.0, abs=1e-5)
    rods = continue_orbit(ROD, drive, **options, **start)
    assert rods.drive_amplitude.values.max() > end


def test_a_hit_that_pushes_a_ball_inwards_is_no_part_of_the_rods_orbit_on_strings():
    short = ll.Ball(length=0.9, mass=0.8, radius=0.1, damping=0.05)
    pair = {"right": BALL, "left": short, "restitution": 0.9}
    start = {"initial_angle": (0.213, -0.204), "initial_angular_velocity": (2.0, -2.48)}
    rods = floquet(ll.BallPair(**pair), shake(2.4, 0.1), **start)
    assert (rods.status.item(), rods.impacts.item()) == ("stable", 1.0)
    begun = [rods[name].values for name in ("initial_angle", "initial_angular_velocity")]
    string = ll.BallPair(**pair, suspension="string")
    run = ll.simulate(
        string, shake(2.4, 0.1), initial_angle=begun[0], initial_angular_velocity=begun[1],
        duration=1.0,
    )  # fmt: skip
    assert list(run.contact_kind.values[:2]) == ["bottom", "slack"]
    with pytest.warns(RuntimeWarning, match="strings must be taut at time zero"):
        result = floquet(string, shake(2.4, 0.1), **start)
    assert result.status.item() == "not found"


def test_multipliers_under_drag_relative_to_the_room_pass_their_checks():
    result = floquet(ROOM, shake(2.0, 0.12), initial_angle=0.9, period=2)
    assert result.status.item() in ("stable", "unstable")
    assert result.difference_residual.item() < 1e-6  # that of finite differences
    plain = floquet(ROD, shake(2.0, 0.12), initial_angle=0.9, period=2)
    assert abs(result.multipliers.values[0] - plain.multipliers.values[0]) > 1e-3


def test_multipliers_of_a_tilted_shake_pass_their_checks():
    result = floquet(ROD, PLANAR, initial_angle=0.0)
    assert result.status.item() == "stable"
    assert abs(result.initial_angle.item()) > 0.01  # the hand swings it
    assert result.difference_residual.item() < 1e-6
    rate = ROD.damping / (ROD.mass * ROD.length)
    expected = math.exp(-rate * math.tau / PLANAR.drive_frequency)
    assert result.determinant.item() == pytest.approx(expected, abs=1e-12)


def test_exponents_under_a_tilted_shake_and_lab_drag_obey_the_sum_rule():
    for system, drive in ((ROD, PLANAR), (ROOM, shake(2.0, 0.1)), (ROOM, PLANAR)):
        result = lyapunov_spectrum(system, drive, initial_angle=0.3, duration=100.0)
        assert abs(result.sum_rule_residual.item()) < 1e-12  # rounding over 2000 steps
        assert result.lyapunov_exponents.values.sum() == pytest.approx(-0.375, abs=1e-10)


def test_a_ball_that_hops_on_its_string_does_not_rest():
    drive = shake(3.0, 0.15)  # A0 w^2 = 1.35 g
    assert response_period(ROD, drive, initial_angle=0.0).status.item() == "rest"
    result = response_period(STRING, drive, initial_angle=0.0)
    assert result.status.item() == "slackens"
    assert math.isnan(result.response_period)
    gentle = response_period(STRING, shake(3.0, 0.1), initial_angle=0.0)
    assert gentle.status.item() == "rest"
    assert float(gentle.response_period) == 1.0
    mapped = ll.analysis.response_period_map(
        STRING, drive_amplitude=[0.1, 0.15], frequency_ratio=[3.0], initial_angle=0.0
    )
    assert list(mapped.cells.sel(motion=["rest", "slackens"]).values) == [1, 1]


def test_a_section_of_strings_tells_all_four_numbers():
    toy = ll.LatoLato(**TOY, suspension="string")
    section = poincare_section(toy, shake(3.0, 0.3), initial_offset=0.0, periods=50)
    assert section.slack.values.any()
    assert (section.distance.values <= 1.0).all()
    assert (section.distance.values < 1.0)[section.slack.values == 1].all()
    assert "distance" not in poincare_section(ROD, shake(2.0, 0.1), initial_angle=0.3, periods=5)
