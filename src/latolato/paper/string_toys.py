"""The toys of the results on strings, each on rods and on strings."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

from latolato import Ball, BallPair, LatoLato
from latolato.figures import style
from latolato.paper import systems as paper

# The toy of a MATLAB toolkit whose cords go slack; its mass changes no angle and is assumed.
MASS = 0.05  # kg
LENGTH, RADIUS = 0.186, 0.012  # m
RESTITUTION, STRING_RESTITUTION = 0.822, 0.90
DECAY = 0.16  # 1/s, C/(m l)
DAMPING = DECAY * MASS * LENGTH
CORD_TOY = LatoLato(
    length=LENGTH, mass=MASS, damping=DAMPING, radius=RADIUS, restitution=RESTITUTION
)
# The same toy as two balls that need not mirror each other.
_BALL = Ball(length=LENGTH, mass=MASS, damping=DAMPING, radius=RADIUS)
CORD_PAIR = BallPair(right=_BALL, left=_BALL, restitution=RESTITUTION)
# The toy of the paper's Figs. 4 and 6 with balls that bounce less than perfectly, so that they come
# to rest against each other.
PAPER_TOY = replace(paper.TOY, restitution=0.8)

RODS, INELASTIC, ELASTIC = "rods", "strings, e_s = 0", "strings, e_s = 0.9"
COLOURS = {RODS: style.GREY, INELASTIC: style.BLUE, ELASTIC: style.RED}
Toy = TypeVar("Toy", LatoLato, BallPair)


def label_of(case: str) -> str:
    """Return a case as it is printed."""
    return case.replace("e_s", "$e_s$")


def on_each(system: Toy) -> dict[str, Toy]:
    """Return a system on rods, on strings that snap taut, and on strings that bounce."""
    return {
        RODS: system,
        INELASTIC: replace(system, suspension="string"),
        ELASTIC: replace(system, suspension="string", string_restitution=STRING_RESTITUTION),
    }


def on_one_engine(system: LatoLato) -> LatoLato:
    """Return an undamped system that is run by the same program on rods and on strings.

    Without drag it does not matter where the air rests, but all runs with drag relative to the room
    use the same steps. So equal motions are equal to the last digit.
    """
    if system.damping > 0.0:
        raise ValueError("only without damping are both frames the same")
    return replace(system, drag_frame="lab")
