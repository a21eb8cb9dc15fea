"""Curves in two parameters on which a periodic motion loses its stability, or begins to touch."""

from __future__ import annotations

import math
import re
import warnings
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, get_args

import numpy as np

from latolato.analysis.checks import check_span, check_vertical
from latolato.analysis.conditions import (
    NEARLY,
    Condition,
    Multiplier,
    Plane,
    Solution,
    Touch,
    closing_maps,
)
from latolato.analysis.continue_orbit import continue_orbit
from latolato.analysis.curve import Curve, CurvePoint, Special
from latolato.analysis.flow import (
    Floats,
    Flow,
    checked_flow,
    drive_period,
    named_value,
    parameter_of,
    periodic_drive,
)
from latolato.analysis.orbits import (
    CLOSED,
    PERIODS,
    checked_guess,
    find_orbit,
    multipliers_of,
    run_elsewhere,
    scale_of,
)
from latolato.analysis.registry import analyses, labelled, note, warn
from latolato.analysis.rules import broken_analysis, said
from latolato.analysis.self_start import resting_angles
from latolato.analysis.special_point import SpecialPoint, check_left_out, laws_of
from latolato.core.errors import InputError, Sentence, Word, joined, name_gap
from latolato.core.parameters import UnitOf
from latolato.core.quantities import COUNT, Quantity
from latolato.core.registry import checked_number
from latolato.observables.word import LETTERS
from latolato.physics.contacts import CONTACT_KINDS
from latolato.physics.drives import Drive
from latolato.physics.pendulum import System
from latolato.simulation.start import DEFAULT_REST_SPEED
from latolato.simulation.vary import TARGETS

if TYPE_CHECKING:
    import xarray as xr

Kind = Literal["fold", "period_doubling", "symmetry_breaking", "grazing", "lift_off", "slack_onset"]
KINDS: tuple[Kind, ...] = get_args(Kind)
# Kinds at which a multiplier is critical, which may be one of several maps that close a motion. A
# symmetric motion that doubles its period or breaks its symmetry seems to be at a fold as well.
_CRITICAL: dict[Kind, float] = {"period_doubling": -1.0, "symmetry_breaking": -1.0, "fold": 1.0}
QUANTITIES = {
    "is_edge": Quantity("1", "", "whether stable motions end there"),
    "is_supercritical": Quantity("1", "", "whether the new motions begin stable"),
    "word": Quantity("1", "", "contact word"),
    "special_kind": Quantity("1", "", "what happens to the curve"),
    "end_reason": Quantity("1", "", "why the curve ends"),
}
# Moduli below this are no growth: without any damping all are one, to the root of rounding.
_NEUTRAL = 1.0 + 1e-5
# Samples of a motion in which the instant of a touch is looked for.
_SAMPLES = 2000
# Most points of a branch on which a bifurcation is looked for.
_SEARCHED = 60
_DIRECTIONS: tuple[Literal["up", "down"], ...] = ("up", "down")
# Where closed motions are looked for beside a guess, as shares of the parameters' ranges, and how
# near they must be, in natural units.
_BESIDE = (0.0, 3e-4, 3e-3)
_NEAR = 0.05


@analyses.register("bifurcation_curve", check_vertical, periodic_drive)
def bifurcation_curve(
    system: System,
    drive: Drive | None = None,
    *,
    kind: Kind | None = None,
    parameters: Sequence[str] = ("drive_amplitude", "frequency_ratio"),
    low: Annotated[Sequence[float], UnitOf("parameters")],
    high: Annotated[Sequence[float], UnitOf("parameters")],
    at: xr.DataArray | None = None,
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    period: Annotated[int | None, PERIODS] = None,
    points: Annotated[int, COUNT] = 200,
    contact: str | None = "exact",
    tolerance: float = 1e-12,
    rest_speed: float = DEFAULT_REST_SPEED,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Return the curve over two parameters on which a periodic motion is at a bifurcation.

    Pseudo-arclength continuation of the motion and both parameters; Keller (1977), with the test
    functions of Govaerts (2000), and touches as in TC-HAT (Thota & Dankowicz 2008).

    Parameters
    ----------
    system, drive
        Any system under `Harmonic` or `CrankSlider`. The curve is that of the bifurcation near
        their values: three digits will do. Where none is, it is the nearest one that the motion
        meets while one of both parameters varies alone.
    kind : {"fold", "period_doubling", "symmetry_breaking", "grazing", "lift_off", "slack_onset"}
        What is followed, by default the one of the first three to which a multiplier of the motion
        is nearest, or that it meets first. ``fold``: two motions meet and vanish, a multiplier is
        one. ``period_doubling``: a multiplier is minus one. ``symmetry_breaking``: a motion that
        equals its image in a mirror gives way to two that do not. ``grazing``: a ball touches the
        other one, or its image, without speed. ``lift_off``: the force between balls at rest on
        each other touches zero. ``slack_onset``: the least tension of a string touches zero.
    parameters : pair of str
        What is varied: parameters of system or drive, ``frequency_ratio``, ``amplitude_ratio`` or
        ``drive_acceleration_ratio``.
    low, high : pair of float
        The lowest and highest value of each parameter [SI]; the curve ends there.
    at : xarray.DataArray, optional
        A special point of `continue_orbit` of the same system and drive, as ``branch.special[0]``:
        it brings its parameter's value, the motion, its period and its kind, which are not given
        beside it.
    initial_angle, initial_angular_velocity, initial_offset, period
        Guess of the motion, as in a Floquet analysis; the period is 1 by default.
    points : int
        Most points of the curve.
    contact, tolerance, rest_speed
        As in a Floquet analysis.
    progress : callable, optional
        Called with the fraction of `points` that is done.

    Returns
    -------
    xarray.Dataset
        Over ``point`` along the curve: both parameters, ``initial_angle`` and
        ``initial_angular_velocity`` of the motion at time zero, ``largest_angle``,
        ``multipliers`` of the map that closes it, ``impacts``, ``word`` (as of `ContactWord`; that
        of a graze is without the touch itself), and ``is_edge``: whether all multipliers but the
        critical one are inside the unit circle, so that a stable motion ends there. Period
        doublings and broken symmetries also have ``is_supercritical``: 1 where the new motions
        begin small and stable as the old one loses its stability (a soft edge), 0 where they are
        unstable and meet the old one (a steep edge: runs jump away), -1 where impacts beside the
        motion, or a second critical multiplier, hide it.
        Over ``special`` the points of codimension two, again with both parameters:
        ``special_kind`` is ``cusp``, ``resonance_1_1``, ``resonance_1_2``, ``fold_flip`` (a fold
        meets a period doubling), ``generalised_flip`` and ``degenerate_pitchfork`` (where
        ``is_supercritical`` changes), ``meets_fold`` and ``meets_flip`` (the touching motion has a
        multiplier of one or minus one) or ``degenerate`` (a touch that does not bend away).
        Over ``end`` the ``end_reason`` of both ends: ``end of range``, ``closed``,
        ``merges`` (the motions become the more symmetric one from which they split), ``grazing``,
        ``touches_twice``, ``slackens``, ``point limit`` (more would follow), ``interrupted`` or
        ``lost`` (no smaller step helps). ``status``: ``complete``, ``closed``, ``interrupted``,
        ``not found`` (no such bifurcation is near, or met) or ``singular`` (two are, at one point).

    Raises
    ------
    InputError
        For unknown parameters, a range that does not hold their present values, a kind that the
        system cannot have, and as `floquet`.

    Notes
    -----
    Equations are solved to 1e-10. Derivatives with respect to the state are those of the engine,
    through impacts; test functions need second derivatives, which are differences of them, as are
    those by parameters. A graze is approached from the side on which nothing is hit: the motion
    begins at the instant of the touch, so the square root of the other side does not occur. Motions
    on strings are followed as on rods, until one would be pushed. Two points of codimension two of
    the same kind within one step are missed.

    Examples
    --------
    The first Mathieu tongue: hanging still doubles its period.

    >>> import latolato as ll
    >>> system = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    >>> drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=1.91 * 9.8**0.5)
    >>> tongue = bifurcation_curve(
    ...     system, drive, kind="period_doubling", low=(0.0, 1.8), high=(0.1, 2.2)
    ... )
    >>> print(tongue.status.item(), tongue.frequency_ratio.values[[0, -1]].round(4).tolist())
    complete [1.8306, 2.2]
    """
    if at is None:
        period = period or 1
    else:
        check_left_out(
            kind=kind, period=period, initial_angle=initial_angle, initial_offset=initial_offset,
            initial_angular_velocity=initial_angular_velocity,
        )  # fmt: skip
        special = SpecialPoint.of(at, system, drive)
        system, drive, period = special.system, special.drive, special.period
        initial_angle, initial_angular_velocity = special.angle, special.angular_velocity
        if _kind_of(special.kind) not in KINDS:
            raise broken_analysis("kind_of_point", {"kind": special.kind}, parameter="at")
        kind = KINDS[KINDS.index(_kind_of(special.kind))]
    flow = checked_flow(system, drive, contact=contact, tolerance=tolerance, rest_speed=rest_speed)
    plane = _checked_plane(flow, parameters, low, high)
    guess = checked_guess(flow, initial_angle, initial_angular_velocity, initial_offset)
    candidates = (kind,) if kind else tuple(_CRITICAL)
    asked = _word_of(kind) if kind else Word("bifurcation")
    kind = kind or _nearest_kind(plane, guess, period)
    _check_kind(flow, kind)
    condition, unknowns = _condition_of(plane, kind, guess, period)
    curve = Curve(condition)
    first = None if unknowns is None else curve.begin(unknowns)
    if first is None and at is None:
        met = _nearest_met(
            plane, candidates, guess, period=period, contact=contact, progress=progress
        )
        if met is not None:
            curve_there = bifurcation_curve(
                system, drive, at=met.point, parameters=parameters, low=low, high=high,
                points=points, contact=contact, tolerance=tolerance, rest_speed=rest_speed,
                progress=progress and (lambda share: progress(0.5 + 0.5 * share)),
            )  # fmt: skip
            # The laws stay those that were given; where the curve begins is said.
            gaps = {"asked": asked, "where": _place(plane), **met.gaps(flow)}
            message = note(
                said("met_where_settled", **gaps) if met.settles else said("met_near_guess", **gaps)
            )
            return curve_there.assign_attrs(laws_of(system, flow.drive), message=message)
    curve_points: list[CurvePoint] = []
    specials: list[Special] = []
    ends = ["", ""]
    status = "not found" if first is None else "singular" if curve.is_singular(first) else ""
    if first is not None and not status:
        curve_points, specials, ends = _both_ways(curve, first, points, progress)
        status = next((each for each in ("closed", "interrupted") if each in ends), "complete")
    if status in ("not found", "singular"):
        values = {"kind": asked, "where": _place(plane)}
        nearest = _nearest_kind(plane, guess, period)
        rule = "no_bifurcation" if period == 1 else "no_bifurcation_of_several"
        if kind in _CRITICAL and nearest != kind:
            warn("other_bifurcation", nearest=_word_of(nearest), **values)
        elif status == "not found":
            warn(rule, period=period, **values)
        else:
            warn("two_bifurcations", **values)
    return labelled(
        _variables(plane, condition, curve_points, specials)
        | {"status": status, "end_reason": ("end", np.array(ends, dtype="U20"))},
        system=system,
        drive=flow.drive,
        quantities=QUANTITIES | _quantities(plane),
        settings={"bifurcation": kind, "period": period, "low": plane.low, "high": plane.high},
    )


def _checked_plane(flow: Flow, names: Any, low: Any, high: Any) -> Plane:
    """Return two parameters with their limits."""
    names = tuple(names) if isinstance(names, (list, tuple)) else (names,)
    if not all(isinstance(name, str) for name in names):
        raise broken_analysis("two_parameters", parameter="parameters", value=list(names))
    if len(names) != 2 or TARGETS.get(names[0], names[0]) == TARGETS.get(names[1], names[1]):
        raise broken_analysis("two_parameters", parameter="parameters", value=list(names))
    limits = []
    for word, ends in (("low", low), ("high", high)):
        if not hasattr(ends, "__len__") or len(ends) != 2:
            raise broken_analysis("end_of_each", parameter=word, value=ends)
        numbers = []
        for name, end in zip(names, ends, strict=True):
            known = parameter_of(flow.system, flow.drive, name)
            # An end that the parameter itself may not have, such as no drive, may be approached.
            allowed = replace(known.allowed, open_low=False, open_high=False)
            numbers.append(checked_number(f"{word} ({name})", end, allowed, known.quantity.unit))
        limits.append(np.array(numbers))
    plane = Plane(flow, names, *limits)
    for name, value, least, most in zip(names, plane.values, *limits, strict=True):
        check_span(float(least), float(most), of=name)
        if not least <= value <= most:
            raise broken_analysis(
                "first_orbit", {"name": name_gap(name), "begun": value, "low": least, "high": most}
            )
    return plane


class _Met(NamedTuple):
    """A special point that a motion meets where one parameter alone varies.

    The motion is the one in which the run from the guess settles, or the one near the guess.
    """

    point: xr.DataArray
    settles: bool

    def gaps(self, flow: Flow) -> dict[str, Any]:
        """Return what the rule says about the point."""
        name, value = str(self.point.attrs["parameter"]), float(self.point["special_value"])
        kind = _word_of(_kind_of(str(self.point["special_kind"].item())))
        return {"kind": kind, "place": named_value(flow, name, value)}


def _nearest_met(
    plane: Plane,
    kinds: Sequence[str],
    guess: Floats,
    *,
    period: int,
    contact: str | None,
    progress: Callable[[float], None] | None,
) -> _Met | None:
    """Return the nearest bifurcation of these kinds that the motion meets, None if it meets none.

    The motion is the one in which the run from the guess settles, or where that meets none the one
    near the guess. Each parameter varies alone, up and down, on at most `_SEARCHED` points, so this
    takes up to eight branches; it can miss what lies beyond those, and all that both must reach.
    """
    flow = plane.flow
    orbit = find_orbit(flow, guess, period)
    settled = run_elsewhere(orbit, guess) if orbit.defect <= CLOSED else None
    starts = [(False, guess)] if settled is None else [(True, settled[1]), (False, guess)]
    for settles, start in starts:
        angle, velocity = (np.squeeze(each).tolist() for each in (start[0::2], start[1::2]))
        distances: list[tuple[float, xr.DataArray]] = []
        limits = zip(plane.names, plane.values, plane.low, plane.high, strict=True)
        ways = [(*each, direction) for each in limits for direction in _DIRECTIONS]
        for k, (name, value, low, high, direction) in enumerate(ways):
            if progress:  # the curve itself is the other half
                progress(0.5 * k / len(ways))
            with warnings.catch_warnings():
                # A branch that is lost shows what it met before.
                warnings.simplefilter("ignore", RuntimeWarning)
                branch = continue_orbit(
                    flow.system, flow.drive, parameter=name, low=low, high=high,
                    direction=direction, initial_angle=angle,
                    initial_angular_velocity=velocity, period=period, points=_SEARCHED,
                    contact=contact, tolerance=flow.tolerance,
                    rest_speed=flow.rest_speed,
                )  # fmt: skip
            distances += [
                (abs(float(each["special_value"]) - value) / (high - low), each)
                for each in branch["special"]
                if _kind_of(each["special_kind"].item()) in kinds
            ]
        if distances:
            return _Met(min(distances, key=lambda each: each[0])[1], settles)
    return None


def _place(plane: Plane) -> Sentence:
    """Return the values of both parameters in words."""
    pairs = zip(plane.names, plane.values, strict=True)
    return joined([named_value(plane.flow, name, float(value)) for name, value in pairs], ", ")


def _kind_of(special: str) -> str:
    """Return the kind of the curve that begins at a special point, by the point's kind."""
    return "slack_onset" if special == "slackens" else special


def _word_of(kind: str) -> Word:
    """Return a kind in words."""
    return Word(kind.replace("_", " "))


def _check_kind(flow: Flow, kind: str) -> None:
    """Raise InputError for a kind that a system cannot have."""
    if kind in ("grazing", "lift_off") and not math.isfinite(flow.walls[0]):
        raise broken_analysis("touching_balls", parameter="kind", value=kind)
    if kind == "lift_off":
        resting_angles(flow.system)
    if kind == "slack_onset" and not flow.is_string:
        raise broken_analysis("needs_strings", parameter="kind", value=kind)


def _condition_of(
    plane: Plane, kind: Kind, guess: Floats, period: int
) -> tuple[Condition, Floats | None]:
    """Return the equations of a kind of curve, and unknowns to begin with."""
    if kind in _CRITICAL:
        start, values = _closed_near(plane, guess, period, beside=(0.0,))
        maps = _maps_of(plane.at(values), start, kind, period)
        if not maps:
            raise broken_analysis("needs_mirror", parameter="kind", value=kind)
        # Of maps that are equally near, the shortest.
        _, mirror, count = min(maps, key=lambda each: each[0])
        condition = Multiplier(plane, mirror, count, _CRITICAL[kind])
        return condition, condition.begin(start, values)
    return _touch_of(plane, kind, *_closed_near(plane, guess, period, beside=_BESIDE), period)


def _closed_near(
    plane: Plane, guess: Floats, period: int, *, beside: Sequence[float]
) -> tuple[Floats, Floats]:
    """Return the start and the parameters of a closed motion near a guess, or else the guess.

    Beyond a bifurcation there may be none: other values of the parameters are tried too, away by
    these shares of their ranges.
    """
    for share in beside:
        for side in np.vstack([np.eye(2), -np.eye(2)]):
            values = plane.values + share * plane.width * side
            try:
                flow = plane.at(values)
            except InputError:  # beyond what a parameter may be
                continue
            orbit = find_orbit(flow, guess, period, settles=False)
            near = np.linalg.norm((orbit.start - guess) / scale_of(flow.system))
            if orbit.defect <= CLOSED and near <= _NEAR:
                return orbit.start, values
            if share == 0.0:
                break
    return guess, plane.values


def _maps_of(flow: Flow, start: Floats, kind: Kind, period: int) -> list[tuple[float, Floats, int]]:
    """Return mirror and drive periods of each map that may be at a bifurcation of a kind.

    Before them stands how far from critical its nearest multiplier is.
    """
    unit = np.eye(flow.size)
    result = []
    for mirror, count in closing_maps(flow, start, period, NEARLY) or [(unit, period)]:
        if kind == "fold" or np.array_equal(mirror, unit) == (kind == "period_doubling"):
            matrix = mirror @ flow.follow(start, count * drive_period(flow.drive)).matrix
            far = np.min(np.abs(multipliers_of(matrix) - _CRITICAL[kind]))
            result.append((round(float(far), 6), mirror, count))
    return result


def _nearest_kind(plane: Plane, guess: Floats, period: int) -> Kind:
    """Return the kind of bifurcation to which the motion near a guess is nearest."""
    start, values = _closed_near(plane, guess, period, beside=(0.0,))
    flow = plane.at(values)
    far = {
        kind: min((each[0] for each in _maps_of(flow, start, kind, period)), default=math.inf)
        for kind in _CRITICAL
    }
    return min(far, key=lambda kind: far[kind])


def _touch_of(
    plane: Plane, kind: str, start: Floats, values: Floats, period: int
) -> tuple[Condition, Floats | None]:
    """Return the equations of a touch, begun at the instant where a motion nearly does."""
    flow = plane.at(values)
    duration = period * drive_period(flow.drive)
    times = np.linspace(0.0, duration, _SAMPLES, endpoint=False)
    two = flow.size == 4
    run = flow.sampled(start, times)
    angles, speeds = np.atleast_2d(run["angle"]), np.atleast_2d(run["angular_velocity"])
    wall = ball = 0
    separation = angles[0] - angles[1] if two else angles[0]
    clearances = np.array([separation - flow.walls[0], flow.walls[1] - separation])
    if kind == "slack_onset":
        tension = np.atleast_2d(run["tension"])
        ball, at = _least(tension)
    elif kind == "lift_off":
        wall = int(np.argmin(clearances[:, 0]))
        at = int(np.argmin((1.0, -1.0)[wall] * run["pivot_acceleration"]))
    else:
        # Of all instants at which balls are nearest, that with the least to go, in height.
        speed = (speeds[0] - speeds[1] if two else speeds[0]) / flow.system.natural_frequency
        nearest = (clearances <= np.roll(clearances, 1, axis=1)) & (
            clearances <= np.roll(clearances, -1, axis=1)
        )
        far = np.where(nearest, np.abs(clearances) + 0.5 * speed**2, math.inf)
        wall, at = _least(far)
    unit = np.eye(flow.size)
    same = [n for m, n in closing_maps(flow, start, period, NEARLY) if np.array_equal(m, unit)]
    condition = Touch(plane, kind, min(same, default=period), wall=wall, ball=ball)
    state = np.array([angles[:, at], speeds[:, at]]).T.ravel()
    turn = flow.drive.drive_frequency * float(times[at])
    return condition, condition.begin(state, turn, values)


def _least(values: Floats) -> tuple[int, int]:
    """Return row and column of the smallest number."""
    row, column = np.unravel_index(int(np.argmin(values)), values.shape)
    return int(row), int(column)


def _both_ways(
    curve: Curve, first: CurvePoint, points: int, progress: Callable[[float], None] | None
) -> tuple[list[CurvePoint], list[Special], list[str]]:
    """Return a curve followed from a point both ways: points, specials, and why it ends."""
    done = 1

    def on_point(_: CurvePoint) -> None:
        nonlocal done
        done += 1
        if progress is not None:
            progress(min(done / points, 1.0))

    # Half of the points for one way, the rest for the other, and what that leaves again.
    after, specials, reason = curve.follow(first, 1.0, points // 2, on_point)
    if reason in ("closed", "interrupted"):
        return [first, *after], specials, [reason, reason]
    goal = after[-1] if after and reason == "point limit" else None
    before, others, other = curve.follow(first, -1.0, points - 1 - len(after), on_point, goal)
    if other == "closed":
        return [*before[::-1], first, *after], [*others[::-1], *specials], [other, other]
    left = points - 1 - len(after) - len(before)
    if reason == "point limit" and left > 0 and after and other != "interrupted":
        more, found, reason = curve.follow(after[-1], 1.0, left, on_point)
        after, specials = after + more, specials + found
    return [*before[::-1], first, *after], [*others[::-1], *specials], [other, reason]


def _variables(
    plane: Plane, condition: Condition, curve_points: list[CurvePoint], specials: list[Special]
) -> dict[str, Any]:
    """Return the points of a curve as variables."""
    size = plane.flow.size
    two = size == 4
    per_ball = ("point", "ball") if two else ("point",)
    solutions = [point.solution for point in curve_points]
    special_solutions = [special.point.solution for special in specials]
    starts = np.array([_at_time_zero(each, condition) for each in solutions]).reshape(-1, size)
    multipliers = np.array([multipliers_of(each.matrix) for each in solutions], dtype=complex)
    is_edge = [np.all(np.abs(condition.others(each)) < _NEUTRAL) for each in solutions]

    is_supercritical = {}
    if isinstance(condition, Multiplier) and condition.critical < 0.0:
        cubics = np.array([point.tests[condition.degenerate] for point in curve_points])
        signs = np.where(np.isnan(cubics), -1, cubics > 0.0).astype(np.int8)
        is_supercritical = {"is_supercritical": ("point", signs)}

    def ball(values: Floats) -> Floats:
        return values if two else values[:, 0]

    def along(which: int, of: list[Solution]) -> Floats:
        return np.array([each.values[which] for each in of], dtype=float)

    return {
        **{name: ("point", along(i, solutions)) for i, name in enumerate(plane.names)},
        "initial_angle": (per_ball, ball(starts[:, 0::2])),
        "initial_angular_velocity": (per_ball, ball(starts[:, 1::2])),
        "largest_angle": ("point", np.array([s.passage.largest_angle for s in solutions])),
        "multipliers": (("point", "multiplier"), multipliers.reshape(-1, size)),
        "impacts": ("point", np.array([s.passage.impacts for s in solutions], dtype=int)),
        "word": ("point", np.array([_word(s, condition) for s in solutions], dtype="U64")),
        "is_edge": ("point", np.array(is_edge, dtype=np.int8)),
        **is_supercritical,
        **{
            f"special_{name}": ("special", along(i, special_solutions))
            for i, name in enumerate(plane.names)
        },
        "special_kind": ("special", np.array([each.kind for each in specials], dtype="U20")),
    }


def _quantities(plane: Plane) -> dict[str, Quantity]:
    """Return what both parameters are, along the curve and at its special points."""
    flow = plane.flow
    known = {name: parameter_of(flow.system, flow.drive, name).quantity for name in plane.names}
    return known | {f"special_{name}": about for name, about in known.items()}


def _word(solution: Solution, condition: Condition) -> str:
    """Return the contact word of a motion, as `latolato.contact_words` writes it."""
    if isinstance(condition, Touch) and condition.kind == "lift_off":
        return "R"  # whatever rounding makes of a force of zero
    names = [CONTACT_KINDS[int(kind)] for kind in solution.passage.contact_kinds]
    letters = "".join(name[0].upper() for name in names if name not in ("release", "taut"))
    turned = [letters[i:] + letters[:i] for i in range(len(letters))] or ["no contact"]
    # Impacts that end at rest are written once.
    words = [re.sub(r"B+(?=R)|T+(?=R)", lambda found: found[0][0], word) for word in turned]
    return min(words, key=lambda word: [LETTERS.find(letter) for letter in word])


def _at_time_zero(solution: Solution, condition: Condition) -> Floats:
    """Return the state of a motion at time zero."""
    if solution.turn == 0.0:
        return solution.start
    flow, duration = solution.flow, condition.duration(solution.flow)
    left = (-solution.turn / flow.drive.drive_frequency) % duration
    return flow.follow(solution.start, left).end if left > 0.0 else solution.start
