"""Rods or strings, and where the air is at rest: what systems take, and what they refuse."""

import re

import pytest

import latolato as ll
from latolato.core.registry import describe, rebuild

BALL = {"length": 0.186, "mass": 0.03}
DISC = ll.Ball(**BALL, radius=0.012)
PARTS = {
    ll.Pendulum: BALL,
    ll.LatoLato: {**BALL, "radius": 0.012},
    ll.BallPair: {"right": DISC, "left": DISC},
}
STRINGS = {"suspension": "string", "string_restitution": 0.9, "drag_frame": "lab"}
NO_STRINGS = {**STRINGS, "suspension": "rod"}
REFUSED = [
    (
        {"suspension": "strings"},
        "suspension must be 'rod' or 'string', got 'strings'; did you mean 'string'?",
    ),
    ({"suspension": 1}, "suspension must be 'rod' or 'string', got 1"),
    ({"drag_frame": "room"}, "drag_frame must be 'pivot' or 'lab', got 'room'"),
    ({**STRINGS, "string_restitution": 1.1}, "string_restitution must lie in [0, 1], got 1.1"),
    (
        NO_STRINGS,
        "string_restitution must be 0 with suspension 'rod', as a rod never goes slack, got 0.9; "
        "give 0, or suspension='string'",
    ),
]


@pytest.mark.parametrize("kind", PARTS)
def test_balls_hang_on_rods_in_air_that_moves_with_the_pivot_by_default(kind):
    system = kind(**PARTS[kind])
    assert (system.suspension, system.string_restitution, system.drag_frame) == (
        "rod",
        0.0,
        "pivot",
    )


@pytest.mark.parametrize("kind", PARTS)
def test_descriptions_of_rods_are_those_from_before_there_were_strings(kind):
    assert not STRINGS.keys() & describe(kind(**PARTS[kind])).keys()


@pytest.mark.parametrize("kind", PARTS)
def test_strings_come_back_from_their_description(kind):
    system = kind(**PARTS[kind], **STRINGS)
    assert STRINGS.items() <= describe(system).items()
    assert rebuild(kind, describe(system)) == system


@pytest.mark.parametrize("wrong, message", REFUSED, ids=[m[:40] for _, m in REFUSED])
@pytest.mark.parametrize("kind", PARTS)
def test_what_is_wrong_is_named(kind, wrong, message):
    with pytest.raises(ll.InputError, match=f"^{re.escape(message)}"):
        kind(**PARTS[kind], **wrong)


@pytest.mark.parametrize("kind", PARTS)
def test_quadratic_drag_is_relative_to_the_pivot_only(kind):
    drag = {"quadratic_damping": 1e-4}
    own = drag if kind is not ll.BallPair else {"left": ll.Ball(**BALL, radius=0.012, **drag)}
    assert kind(**PARTS[kind] | own).drag_frame == "pivot"
    with pytest.raises(ll.InputError, match="drag_frame must be 'pivot' with quadratic_damping"):
        kind(**PARTS[kind] | own, drag_frame="lab")


@pytest.mark.parametrize("name", STRINGS)
def test_the_linearised_pendulum_knows_none_of_it(name):
    with pytest.raises(ll.InputError, match=f"unknown parameter '{name}' of Mathieu"):
        ll.Mathieu(**BALL, **{name: STRINGS[name]})
    system = ll.Mathieu(**BALL)
    assert (system.suspension, system.drag_frame) == ("rod", "pivot")
