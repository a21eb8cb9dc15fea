"""What can be wrong with a run, and the words that refuse it: one table for Python and pages.

The formulas that prepare a run report the number of a problem and the values that its rule names
(`latolato.numerics.prepare`). `refusal` turns both into the error of a run or of a point of a map;
pages get the table with the compiled code and do the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from latolato.core.errors import NOT_GIVEN, InputError
from latolato.core.rules import Rule, broken_rule


class Problem(NamedTuple):
    """A rule that a run may break.

    Attributes
    ----------
    name : str
        What tests and pages call it.
    rule, way_out : str
        Those of `InputError`, in which values stand as Python's format strings have them.
    values : tuple of str
        The names of the values that are reported with it, in this order.
    parameter : str or None
        The one at fault, if it is a single one.
    value : str
        Which of the values was given for it, "" if the text repeats none.
    """

    name: str
    rule: str
    way_out: str = ""
    values: tuple[str, ...] = ()
    parameter: str | None = None
    value: str = ""


_PAIR = (
    "right_length", "left_length", "right_radius", "left_radius", "half_width", "separation",
)  # fmt: skip
_ROD_HITS = (
    "the {0} rod or string would hit the {1} ball before the balls meet: asin(radius/length) = "
    "{{half_width:g}} rad of the {1} ball exceeds the contact separation {{separation:g}} rad"
)
_RADIUS = Problem(
    "radius", "must lie in [0, length)", "give less than {length:.15g}", ("radius", "length"),
    "radius", "radius",
)  # fmt: skip
# Bounds have so many digits that a bound which is typed as it stands here is admitted: a start is
# on a wall that it misses by 1e-12 rad, and lengths have no more than 15 digits.
_ANGLE = Problem(
    "angle", "{parameter} must lie between the contact angles [{low:.13g}, {high:.13g}] rad",
    "give one at which the balls do not overlap", ("angle", "low", "high", "radians"),
    "initial_angle", "angle",
)  # fmt: skip
_SEPARATION = _ANGLE._replace(
    name="separation",
    rule=_ANGLE.rule.replace("{parameter}", "the separation {parameter}[0] - {parameter}[1]"),
)
_OFFSET = _ANGLE._replace(
    name="offset", parameter="initial_offset",
    rule="{parameter} counts from the lower contact angle and must lie in [0, {high:.13g}] rad",
)  # fmt: skip
_DISTANCE = Problem(
    "distance", "must not exceed the length of the string",
    "give at most {length:.15g} m, at which the string is taut", ("distance", "length"),
    "initial_distance", "distance",
)  # fmt: skip


def _in_degrees(problem: Problem) -> Problem:
    """Return the problem of an angle that would be fine if it were degrees."""
    way_out = "angles are in rad: {angle:g} degrees are {radians:.6g}"
    return problem._replace(name=f"{problem.name} in degrees", way_out=way_out)


PROBLEMS = (
    Problem("fine", ""),
    Problem(
        "never meet",
        "the balls never meet: the lengths must differ by less than the sum of the radii, got "
        "lengths {right_length:g} and {left_length:g} with radii {right_radius:g} and "
        "{left_radius:g}",
        values=_PAIR,
    ),
    Problem(
        "too large",
        "the balls are too large to hang side by side: radii {right_radius:g} and "
        "{left_radius:g} for lengths {right_length:g} and {left_length:g}",
        values=_PAIR,
    ),
    Problem(
        "left rod hits", _ROD_HITS.format("left", "right"), "make the left ball larger", _PAIR
    ),
    Problem(
        "right rod hits", _ROD_HITS.format("right", "left"), "make the right ball larger", _PAIR
    ),
    _RADIUS,
    _RADIUS._replace(name="right radius", parameter="right_radius"),
    _RADIUS._replace(name="left radius", parameter="left_radius"),
    _ANGLE,
    _in_degrees(_ANGLE),
    _SEPARATION,
    _in_degrees(_SEPARATION),
    _OFFSET,
    _in_degrees(_OFFSET),
    # Of balls on slack strings.
    _ANGLE._replace(
        name="half turn", rule="{parameter} must lie in [0, pi] rad", values=("angle",)
    ),
    _SEPARATION._replace(
        name="turn", values=("angle",),
        rule="the separation {parameter}[0] - {parameter}[1] must lie in [0, 2 pi] rad",
    ),
    Problem(
        "overlap",
        "the balls overlap at this {parameter}: their centres must be at least {least:.9g} m "
        "apart, but are {apart:.9g} m apart",
        "give other distances or angles", ("least", "apart"), "initial_distance",
    ),
    Problem(
        "string hits",
        "at this {parameter} the taut string of one ball runs through the other ball",
        "give other distances or angles", parameter="initial_distance",
    ),
    _DISTANCE,
    _DISTANCE._replace(name="right distance", parameter="initial_distance[0]"),
    _DISTANCE._replace(name="left distance", parameter="initial_distance[1]"),
    # Of observables of mirrored motion.
    Problem(
        "not mirrored",
        "belongs to two equal balls that begin as mirror images: give both the same properties, "
        "and the left one the opposite angle and angular velocity",
        parameter="transverse_exponent",
    ),
    Problem(
        "too many steps",
        "a run of this {parameter} would take {steps:.3g} steps of {step:.3g} s, the limit is "
        "{limit:g}",
        "shorten it, loosen {@tolerance} (with contact 'clamp': enlarge {@clamp_step}), or choose "
        "less damping, a slower start or a slower drive",
        ("steps", "step", "limit"), "duration",
    ),
    # Of points of a map.
    Problem(
        "transient", "{parameter} must be shorter than {@duration} ({duration:g} s)",
        values=("transient", "duration"), parameter="transient", value="transient",
    ),
    Problem("out of range", "the numbers of this run leave the range of floats"),
)  # fmt: skip
MOST_VALUES = max(len(problem.values) for problem in PROBLEMS)
# Their numbers.
(
    FINE, NEVER_MEET, TOO_LARGE, LEFT_ROD_HITS, RIGHT_ROD_HITS, RADIUS, RIGHT_RADIUS, LEFT_RADIUS,
    ANGLE, ANGLE_IN_DEGREES, SEPARATION, SEPARATION_IN_DEGREES, OFFSET, OFFSET_IN_DEGREES,
    HALF_TURN, TURN, OVERLAP, STRING_HITS, DISTANCE, RIGHT_DISTANCE, LEFT_DISTANCE, NOT_MIRRORED,
    TOO_LONG, TRANSIENT, OUT_OF_RANGE,
) = range(len(PROBLEMS))  # fmt: skip


def refusal(number: int, values: Sequence[Any]) -> InputError:
    """Return the error that says what is wrong and how to mend it.

    Parameters
    ----------
    number : int
        Of one of `PROBLEMS`.
    values : sequence of float
        What is reported with it; there may be more than the problem has.

    Examples
    --------
    >>> print(refusal(RADIUS, [0.5, 0.4]))
    radius must lie in [0, length), got 0.5; give less than 0.4
    """
    problem = PROBLEMS[number]
    named = {name: float(x) for name, x in zip(problem.values, values, strict=False)}
    return broken_rule(
        problem.name,
        named,
        parameter=problem.parameter,
        value=named.get(problem.value, NOT_GIVEN),
        table={problem.name: Rule(problem.rule, problem.way_out)},
    )
