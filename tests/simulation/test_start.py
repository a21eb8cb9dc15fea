"""How balls on strings begin, and what does not go together: refused before any work."""

import math
import re
from dataclasses import dataclass

import numpy as np
import pytest

import latolato as ll
from latolato.core.errors import InputError
from latolato.numerics.integrate import Start, integrate
from latolato.simulation.start import checked_contact, checked_drive, checked_start

BALL = {"length": 0.2, "mass": 0.1}
DISC = ll.Ball(**BALL, radius=0.02)
ONE = ll.Pendulum(**BALL, suspension="string")
TOY = ll.LatoLato(**BALL, radius=0.02, suspension="string")
PAIR = ll.BallPair(right=DISC, left=DISC, suspension="string")
RODS = ll.LatoLato(**BALL, radius=0.02)


def started(system, angle, distance, *, velocity=0.0, offset=None, contact="exact"):
    law = checked_contact(contact, system)
    return checked_start(system, law, angle, velocity, offset, distance)


def refusal(*start):
    """What is said of a start, nothing if it is taken."""
    try:
        started(*start)
    except ll.InputError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("distance", [None, 0.2])
def test_a_start_at_the_length_is_taut(distance):
    assert started(TOY, 0.5, distance).distances == ()


def test_two_strings_are_taut_only_at_both_lengths():
    assert started(PAIR, (0.5, -0.5), (0.2, 0.2)).distances == ()
    assert started(PAIR, (0.5, -0.5), (0.2, 0.1)).distances == (0.2, 0.1)


def test_a_slack_start_keeps_what_is_given():
    start = started(TOY, 0.5, 0.1, velocity=3.0)
    assert (start.angles, start.velocities, start.distances) == ((0.5,), (3.0,), (0.1,))
    offset = started(TOY, None, 0.15, offset=0.4)
    assert offset.angles == (TOY.contact_angle_low + 0.4,)


def test_one_ball_without_walls_may_begin_anywhere_within_its_string():
    assert started(ONE, -40.0, 1e-3).distances == (1e-3,)


def test_balls_on_slack_strings_may_touch():
    # At this distance a ball touches the mirror plane, which it may, to rounding.
    touching = math.asin(0.02 / 0.1)
    assert started(TOY, touching, 0.1).distances == (0.1,)
    assert started(PAIR, (touching, -touching), (0.1, 0.1)).distances == (0.1, 0.1)


def test_balls_may_hang_one_above_the_other_where_the_lower_string_is_slack():
    assert started(PAIR, (0.0, 0.0), (0.19, 0.1)).angles == (0.0, 0.0)


def test_a_start_in_a_taut_string_is_refused_where_a_run_would_end_at_once():
    generator, ends = np.random.default_rng(3), []
    for _ in range(100):
        angles = (generator.uniform(0.0, 2.0 * math.pi), 0.0)
        distances = tuple(generator.permutation([0.2, generator.uniform(0.001, 0.2)]))
        said = refusal(PAIR, angles, distances)
        if "overlap" in said:
            continue
        is_refused = "the taut string of one ball runs through the other ball" in said
        start = Start(angles, (0.0, 0.0), distances)
        run = integrate(PAIR, ll.FixedPivot(), start, np.zeros(1), 1e-6, step=0.01)
        ends.append(run.status != "complete")
        assert ends[-1] is is_refused
    assert 5 < sum(ends) < len(ends) - 5


def test_balls_that_pass_through_each_other_may_overlap():
    assert started(TOY, 0.15, 0.1, contact="none").distances == (0.1,)
    assert started(PAIR, (0.0, 0.0), (0.2, 0.1), contact="none").distances == (0.2, 0.1)


REFUSED = [
    (TOY, 0.5, 0.3, "initial_distance must not exceed the length of the string, got 0.3; give at "
     "most 0.2 m, at which the string is taut"),
    (PAIR, (0.5, -0.5), (0.1, 0.3), "initial_distance[1] must not exceed the length of the string"),
    (TOY, 0.5, 0.0, "initial_distance must lie in (0, inf) m, got 0"),
    (TOY, 0.5, -0.1, "initial_distance must lie in (0, inf) m, got -0.1"),
    (TOY, 0.5, math.nan, "initial_distance must be a number in m, got nan"),
    (TOY, 0.5, (0.1, 0.1), "initial_distance must be one number in m for one angle"),
    (PAIR, (0.5, -0.5), 0.1, "initial_distance of a BallPair must be two numbers (right, left)"),
    (RODS, 0.5, 0.1, "initial_distance is for balls on strings: a rod keeps its ball"),
    (TOY, 0.15, 0.1, "the balls overlap at this initial_distance: their centres must be at least "
     "0.04 m apart, but are 0.0298876"),
    (PAIR, (0.0, 0.0), (0.2, 0.17), "the balls overlap at this initial_distance"),
    (TOY, 3.5, 0.1, "initial_angle must lie in [0, pi] rad, got 3.5"),
    (TOY, 2.0 * math.pi + 0.5, 0.1, "initial_angle must lie in [0, pi] rad"),
    (PAIR, (-0.5, 0.5), (0.1, 0.1), "initial_angle[0] - initial_angle[1] must lie in "
     "[0, 2 pi] rad, got -1"),
    (PAIR, (0.0, 0.0), (0.2, 0.1), "at this initial_distance the taut string of one ball runs "
     "through the other ball; give other distances or angles"),
]  # fmt: skip


@pytest.mark.parametrize("system, angle, distance, message", REFUSED)
def test_an_impossible_distance_is_refused(system, angle, distance, message):
    with pytest.raises(ll.InputError, match=re.escape(message)):
        started(system, angle, distance)


@pytest.mark.parametrize("system", [TOY, ll.LatoLato(**BALL, radius=0.02, drag_frame="lab")])
def test_the_clamp_is_for_the_rods_of_the_paper(system):
    with pytest.raises(
        ll.InputError, match=r"contact 'clamp' is described for rods .* use 'exact'"
    ):
        checked_contact("clamp", system)


@dataclass(frozen=True, kw_only=True)
class Sideways(ll.Harmonic):
    """A pivot that moves sideways."""

    moves_across = True


SIDEWAYS = Sideways(drive_amplitude=0.01, drive_frequency=5.0)


@pytest.mark.parametrize(
    "system, message",
    [
        (RODS, r"mirror symmetry of a LatoLato: drive must be vertical, .* use a BallPair"),
        (ll.Mathieu(**BALL), r"a Mathieu does not describe: .* use a Pendulum"),
    ],
)
def test_a_sideways_drive_needs_a_system_that_it_can_move(system, message):
    with pytest.raises(ll.InputError, match=message):
        checked_drive(SIDEWAYS, system)
    with pytest.raises(ll.InputError, match=message):
        ll.sweep(system, SIDEWAYS, axes={"gravity": [9.8]}, initial_angle=0.5, duration=1.0)


@pytest.mark.parametrize("system", [ONE, PAIR])
def test_a_sideways_drive_moves_pendula_and_free_balls(system):
    assert checked_drive(SIDEWAYS, system) is SIDEWAYS


SWING = ll.Pendulum(**BALL)


@pytest.mark.parametrize(
    "started, options",
    [
        (ll.simulate, {"initial_angle": 90}),
        (ll.sweep, {"axes": {"mass": [0.1]}, "initial_angle": 90.0}),
        (ll.sweep, {"axes": {"initial_angle": [1.0, 90.0]}}),
    ],
)
def test_initial_angles_that_look_like_degrees_are_pointed_out(started, options):
    words = r"initial_angle is in rad, and 90 rad are 14.3 turns: if you .* give 1.5708"
    with pytest.warns(RuntimeWarning, match=words) as caught:
        started(SWING, duration=0.1, **options)
    assert caught[0].filename == __file__


def test_an_angle_that_a_rotating_pendulum_ended_with_is_taken_without_a_word():
    turned = ll.simulate(SWING, initial_angle=0.0, initial_angular_velocity=20.0, duration=1.0)
    assert turned.angle[-1] > 2.0 * math.tau
    ll.simulate(SWING, initial_angle=turned.angle[-1].item(), duration=0.1)


def test_mirror_images_near_a_wall_remain_mirror_images():
    rng = np.random.default_rng(3)
    for length, share in zip(rng.uniform(0.2, 1.0, 40), rng.uniform(0.02, 0.3, 40), strict=True):
        ball = ll.Ball(length=length, mass=0.1, radius=share * length)
        low = ll.LatoLato(length=length, mass=0.1, radius=share * length).contact_angle_low
        found = ll.sweep(
            ll.BallPair(right=ball, left=ball),
            axes={"gravity": [9.8]},
            initial_angle=(low, -low),
            duration=0.2,
            observables=["transverse_exponent"],
        )
        assert found.status.item() != "invalid"


@pytest.mark.parametrize("which", [0, 1])
def test_a_bound_that_a_refusal_prints_is_admitted(which):
    toy = ll.LatoLato(length=0.4386146512852849, mass=0.1, radius=0.043673711569397033)
    with pytest.raises(InputError, match="contact angles") as refused:
        ll.simulate(toy, initial_angle=0.0, duration=0.1)
    bounds = str(refused.value).partition("[")[2].partition("]")[0].split(", ")
    ll.simulate(toy, initial_angle=float(bounds[which]), duration=0.1)
