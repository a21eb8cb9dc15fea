"""Branches of periodic motions followed through a parameter, around folds and through contacts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np

from latolato.analysis.branch import BISECTIONS, LONGEST_STEP, Branch, Place
from latolato.analysis.checks import check_span, check_vertical
from latolato.analysis.conditions import NEARLY, closing_maps
from latolato.analysis.floquet import doubts_about
from latolato.analysis.flow import (
    Floats,
    checked_flow,
    named_value,
    parameter_of,
    periodic_drive,
    value_of,
)
from latolato.analysis.orbits import (
    CLOSED,
    PERIODS,
    check_taut,
    checked_guess,
    distance_of,
    find_orbit,
)
from latolato.analysis.past_graze import past_graze
from latolato.analysis.registry import analyses, labelled, note, warn
from latolato.analysis.rules import broken_analysis
from latolato.analysis.special_point import SpecialPoint, check_left_out, laws_of
from latolato.core.errors import Word, name_gap
from latolato.core.parameters import UnitOf
from latolato.core.quantities import Quantity
from latolato.core.registry import checked_number
from latolato.physics.drives import Drive
from latolato.physics.pendulum import System
from latolato.simulation.start import DEFAULT_REST_SPEED

if TYPE_CHECKING:
    import xarray as xr

QUANTITIES = {
    "is_stable": Quantity("1", "", "whether the motion is stable"),
    "special_kind": Quantity("1", "", "what happens to the branch"),
    "special_value": Quantity("1", "", "where it happens"),
    "special_angle": Quantity("rad", r"\theta_{max}", "largest angle there"),
    **{
        f"special_{name}{side}": Quantity(unit, symbol, f"{words} there{side.replace('_', ', ')}")
        for name, unit, symbol, words in (
            ("initial_angle", "rad", r"\theta_0", "initial angle"),
            ("initial_angular_velocity", "rad/s", r"\dot\theta_0", "initial angular velocity"),
        )
        for side in ("", "_right", "_left")
    },
}
# Where another branch leaves.
_SPLITS = ("period_doubling", "symmetry_breaking", "branch_point")
# Length of the first and of the shortest step along the branch.
_FIRST, _SHORTEST = 1e-3, 1e-7
# A branch that cannot go on this near to an end of the range, as a share of it, has reached it.
_AT_END = 1e-6
# A branch that comes to a graze this near to a former one, in its own units, runs into itself.
_SAME = 1e-4


@analyses.register("continue_orbit", check_vertical, periodic_drive)
def continue_orbit(
    system: System,
    drive: Drive | None = None,
    *,
    parameter: str = "frequency_ratio",
    low: Annotated[float, UnitOf("parameter")],
    high: Annotated[float, UnitOf("parameter")],
    direction: Literal["up", "down"] = "up",
    at: xr.DataArray | None = None,
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    period: Annotated[int | None, PERIODS] = None,
    points: int = 200,
    contact: str | None = "exact",
    tolerance: float = 1e-12,
    rest_speed: float = DEFAULT_REST_SPEED,
) -> xr.Dataset:
    """Return a branch of periodic motions, stable and unstable, over a parameter.

    Pseudo-arclength continuation; Keller (1977), as in AUTO, COCO and BifurcationKit.jl.

    Parameters
    ----------
    system, drive
        Any system under `Harmonic` or `CrankSlider`; the branch begins at their values.
    parameter : str
        What is varied: a parameter of system or drive, ``frequency_ratio``, ``amplitude_ratio``
        or ``drive_acceleration_ratio``.
    low, high : float
        Its lowest and highest value on the branch, in the parameter's SI unit.
    direction : {"up", "down"}
        Where the parameter goes at first; a fold may turn it round.
    at : xarray.DataArray, optional
        A special point of another branch of the same system and drive, as ``branch.special[0]``:
        the branch begins there, at its motion and its value of the parameter. From a
        period doubling it is that of twice the period, from a broken symmetry or a branch point the
        one that leaves there; both of its halves begin alike, and `direction` has no meaning then.
    initial_angle, initial_angular_velocity, initial_offset, period
        Guess of the first orbit, as in a Floquet analysis; the period is 1 by default.
    points : int
        Most points of the branch.
    contact, tolerance, rest_speed
        As in a Floquet analysis.

    Returns
    -------
    xarray.Dataset
        Over ``point`` in the order in which they were met: the parameter, ``initial_angle`` and
        ``initial_angular_velocity`` at time zero, ``largest_angle`` on the orbit, ``multipliers``
        (largest modulus first), ``is_stable``, ``impacts``. Over ``special`` the points located on
        the way: ``special_kind`` (``fold``, ``period_doubling``, ``symmetry_breaking``: a
        multiplier is one without a fold, ``torus``: a complex pair crosses the unit circle,
        ``grazing``: an impact appears or vanishes, ``lift_off``: what was at rest all the time
        begins to move, ``rest_ends``: the last phase at rest appears or vanishes, ``slackens``: the
        least tension of a string along the orbit falls through zero), ``special_value`` in the
        parameter's unit, ``special_angle``, ``special_initial_angle`` and
        ``special_initial_angular_velocity`` (of two balls each with ``_right`` and ``_left``);
        ``special[0]`` holds all of them of the first point,
        for `bifurcation_curve`. ``guess_distance`` is that of the first orbit, as in `floquet`.
        ``status``: ``end of range``, ``point limit`` (more would follow), ``closed`` (the branch is
        a loop, or runs into itself), ``slackens`` (it ends there: slack balls move differently),
        ``lost`` (it ends here, or its steps became too short) or ``not found``.

    Raises
    ------
    InputError
        For an unknown parameter, a range that does not hold its present value, and as `floquet`.

    Notes
    -----
    Steps adapt to Newton's convergence, between 1e-7 and 2e-2 of radians and of the range.
    Special points are bisected to 1e-11 of a step, pitchforks in which the branch turns round are
    taken from a parabola (error about 1e-7 of the range). A branch that turns round is in a
    pitchfork if the orbits on both sides of the turning point are images of each other, and at a
    fold otherwise. Bouncing balls that hop by less than 0.1 rad are followed in units of their
    hops. Missed are two special points of the same kind within one step, and branches that are not
    connected to the first orbit. At a graze the map has a square root, and Newton's method fails;
    the branch goes on with one impact more or less from the graze itself, with the speed of the
    slow impact as an unknown. If the first orbit has a shorter period that fits into `period`, so
    has its branch, and the attribute ``message`` mentions it, as it does a run from the guess that
    settles on another motion.

    Examples
    --------
    Hanging still loses its stability at the edge of the tongue by period doubling:

    >>> import latolato as ll
    >>> system = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    >>> drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=1.85 * 9.8**0.5)
    >>> branch = continue_orbit(system, drive, low=1.8, high=2.0)
    >>> print(branch.special_kind.values, branch.special_value.values.round(6))
    ['period_doubling'] [1.909946]
    """
    leaves = False
    if at is None:
        period = period or 1
    else:
        check_left_out(
            initial_angle=initial_angle, initial_offset=initial_offset, period=period,
            initial_angular_velocity=initial_angular_velocity,
        )  # fmt: skip
        special = SpecialPoint.of(at, system, drive)
        system, drive, period = special.system, special.drive, special.period
        initial_angle, initial_angular_velocity = special.angle, special.angular_velocity
        leaves = special.kind in _SPLITS
    flow = checked_flow(system, drive, contact=contact, tolerance=tolerance, rest_speed=rest_speed)
    drive = flow.drive
    begun = value_of(system, drive, parameter)
    known = parameter_of(system, drive, parameter)
    # An end that the parameter itself may not have, such as no drive at all, may be approached.
    closed, unit = replace(known.allowed, open_low=False, open_high=False), known.quantity.unit
    checked_number(f"low ({parameter})", low, closed, unit)
    checked_number(f"high ({parameter})", high, closed, unit)
    check_span(low, high)
    if not low <= begun <= high:
        raise broken_analysis(
            "first_orbit", {"name": name_gap(parameter), "begun": begun, "low": low, "high": high}
        )
    guess = checked_guess(flow, initial_angle, initial_angular_velocity, initial_offset)
    if at is not None and special.kind == "period_doubling":
        # A branch that merges with one of half its period doubles that one's.
        maps = closing_maps(flow, guess, period, NEARLY)
        same = [count for mirror, count in maps if np.array_equal(mirror, np.eye(flow.size))]
        period = int(checked_number("period", 2 * min(same, default=period), PERIODS, ""))
    branch = Branch(flow, parameter, (low, high), period)
    first = find_orbit(flow, guess, period)
    places: list[Place] = []
    specials: list[tuple[str, Place]] = []
    status, message, distance = "not found", None, math.nan
    if first.defect <= CLOSED:
        check_taut(first)
        distance = distance_of(flow, first.start, guess)
        message = note(*doubts_about(first, guess, period))
        toward = np.zeros(flow.size + 1)
        toward[-1] = 1.0 if direction == "up" else -1.0
        places = [branch.place(first, begun, toward)]
        places[0] = branch.rescaled(branch.begin_between_contacts(places[0]) or places[0])
        if leaves:
            places[0] = branch.leaving(places[0])
        status = _follow(branch, places, specials, points)
        while status == "lost" and _grazes(places, specials) and len(places) < points:
            if _was_here(branch, specials):
                status = "closed"
                break
            beyond = past_graze(branch, places[-1])
            if beyond is None:
                break
            places.append(beyond)
            status = _follow(branch, places, specials, points)
    if status in ("not found", "lost"):
        if not places:
            warn("branch_not_found")
        else:
            where = named_value(flow, parameter, float(places[-1].value))
            why = specials[-1][0].replace("_", " ") if specials else ""
            if why and specials[-1][1].value == places[-1].value:
                warn("branch_lost_by", where=where, kind=Word(why))
            else:
                warn("branch_lost", where=where)
    variables = _variables(branch, places, specials)
    variables |= {"guess_distance": distance, "status": status}
    about = known.quantity
    result = labelled(
        variables,
        system=system,
        drive=drive,
        quantities=QUANTITIES
        | {
            parameter: about,
            "special_value": replace(QUANTITIES["special_value"], unit=about.unit),
        },
        settings={"message": message, "period": period},
    )
    # Each special point holds all that a curve through it needs.
    result = result.assign_coords(special=np.arange(len(specials)))
    result["special"].attrs.update(parameter=parameter, period=period, **laws_of(system, drive))
    return result.set_coords([str(name) for name in result if str(name).startswith("special_")])


def _follow(
    branch: Branch, places: list[Place], specials: list[tuple[str, Place]], most: int
) -> str:
    """Append points to a branch until it ends; return why it does."""
    length, restarted = _FIRST, None
    low, high = branch.span
    while len(places) < most:
        place = places[-1]
        new = branch.correct(place, length)
        # A sharp turn, or a jump to another branch, is taken in shorter steps.
        is_sharp = new is not None and new.tangent @ place.tangent < 0.9
        if new is None or is_sharp or branch.jumps(place, new, length):
            length *= 0.5
            if length < _SHORTEST:
                if min(place.value - low, high - place.value) <= _AT_END * (high - low):
                    return "end of range"  # beyond it the parameter has no meaning
                # An impact may have come to the instant at which the orbits begin.
                moved = branch.begin_between_contacts(place) if place is not restarted else None
                if moved is None:
                    specials += branch.obstacles(place)
                    return "lost"
                places[-1] = restarted = moved
                length = _FIRST
            continue
        # A branch that leaves another one, along no parameter, begins at a special point of that.
        passed = branch.specials(place, new, length) if place.tangent[-1] != 0.0 else []
        slack = branch.until_slack(place, new, length) if new.orbit.slackens else None
        if slack is not None and low <= slack.value <= high:
            reach = slack.step_from(place, branch.scale)
            specials += [s for s in passed if s[1].step_from(place, branch.scale) <= reach]
            specials.append(("slackens", slack))
            places.append(slack)
            return "slackens"
        specials += passed
        places.append(new)
        stepped, length = length, min(1.5 * length, LONGEST_STEP)
        if not low <= new.value <= high:
            places[-1] = _end(branch, place, stepped)
            return "end of range"
        # A branch that closes arrives as it set out, not on the other side of a fold.
        returns = new.tangent[-1] * places[0].tangent[-1] > 0.0
        if new.shift == places[0].shift and returns:
            gap = np.append(new.orbit.start - places[0].orbit.start, new.value - places[0].value)
            if len(places) > 10 and np.linalg.norm(gap / branch.scale) < 0.5 * length:
                return "closed"
        places[-1] = branch.rescaled(new, branch.scale[:-1])
    return "point limit"


def _grazes(places: list[Place], specials: list[tuple[str, Place]]) -> bool:
    """Whether a branch ended by a graze."""
    return bool(specials) and specials[-1][0] == "grazing" and specials[-1][1] is places[-1]


def _was_here(branch: Branch, specials: list[tuple[str, Place]]) -> bool:
    """Whether the last special point of a branch is one of the former ones."""
    last = specials[-1][1]
    here = np.append(branch.at_time_zero(last), last.value) / branch.scale
    return any(
        kind == "grazing"
        and abs(place.value - last.value) < _SAME * branch.scale[-1]
        and np.linalg.norm(
            np.append(branch.at_time_zero(place), place.value) / branch.scale - here
        ) < _SAME
        for kind, place in specials[:-1]
    )  # fmt: skip


def _end(branch: Branch, old: Place, length: float) -> Place:
    """Return the point where the branch leaves the range, by bisection along the branch."""
    low, high = branch.span
    inside, outside, place = 0.0, length, old
    for _ in range(BISECTIONS):
        middle = 0.5 * (inside + outside)
        trial = branch.correct(old, middle)
        if trial is None or outside - inside < 1e-11:
            break
        if low <= trial.value <= high:
            inside, place = middle, trial
        else:
            outside = middle
    return place


def _variables(
    branch: Branch, places: list[Place], specials: list[tuple[str, Place]]
) -> dict[str, Any]:
    """Return the points of a branch as variables."""
    flow, parameter = branch.flow, branch.parameter
    two = flow.size == 4
    starts = np.array([branch.at_time_zero(p) for p in places]).reshape(-1, flow.size)
    there = np.array([branch.at_time_zero(p) for _, p in specials]).reshape(-1, flow.size)
    per_ball = ("point", "ball") if two else ("point",)

    def ball(values: Floats) -> Floats:
        return values if two else values[:, 0]

    multipliers = np.array([p.orbit.multipliers for p in places], dtype=complex)
    multipliers = multipliers.reshape(-1, flow.size)
    largest = np.abs(multipliers).max(axis=1, initial=0.0)
    return {
        parameter: ("point", np.array([p.value for p in places])),
        "initial_angle": (per_ball, ball(starts[:, 0::2])),
        "initial_angular_velocity": (per_ball, ball(starts[:, 1::2])),
        "largest_angle": ("point", np.array([p.orbit.passage.largest_angle for p in places])),
        "multipliers": (("point", "multiplier"), multipliers),
        "is_stable": ("point", (largest < 1.0).astype(np.int8)),
        "impacts": ("point", np.array([p.orbit.passage.impacts for p in places], dtype=int)),
        "special_kind": ("special", np.array([kind for kind, _ in specials], dtype="U20")),
        "special_value": ("special", np.array([p.value for _, p in specials])),
        "special_angle": (
            "special",
            np.array([p.orbit.passage.largest_angle for _, p in specials]),
        ),
        **{
            f"special_{name}{side}": ("special", there[:, 2 * i + k])
            for i, side in enumerate(("_right", "_left") if two else ("",))
            for k, name in enumerate(("initial_angle", "initial_angular_velocity"))
        },
    }
