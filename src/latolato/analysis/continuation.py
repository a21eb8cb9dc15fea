"""Branches of periodic motions followed through a parameter, around folds and through contacts."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.analysis.flow import Floats, Flow, drive_period, periodic_drive, value_of, varied
from latolato.analysis.orbits import (
    CLOSED,
    LONGEST,
    Orbit,
    checked_guess,
    confined,
    find_orbit,
    gap_of,
    scale_of,
)
from latolato.analysis.registry import analyses, labelled
from latolato.physics.drives import Drive
from latolato.physics.pendulum import System
from latolato.quantities import ANY, NON_NEGATIVE, Quantity, Range
from latolato.quantities import QUANTITIES as KNOWN
from latolato.registry import checked_count, checked_number
from latolato.start import DEFAULT_REST_SPEED

if TYPE_CHECKING:
    import xarray as xr

QUANTITIES = {
    "is_stable": Quantity("1", "", "whether the motion is stable"),
    "special_kind": Quantity("1", "", "what happens to the branch"),
    "special_value": Quantity("1", "", "where it happens"),
    "special_angle": Quantity("rad", r"\theta_{max}", "largest angle there"),
}
KINDS = (
    "fold", "period_doubling", "symmetry_breaking", "torus", "grazing", "lift_off", "rest_ends",
)  # fmt: skip
# Length of a step along the branch, in units of the range of the parameter and of radians.
_FIRST, _LONGEST, _SHORTEST = 1e-3, 2e-2, 1e-7
# A branch that cannot go on this near to an end of the range, as a share of it, has reached it.
_AT_END = 1e-6
_NEWTON = 8
# Beside a wall steps are cut, and the map jumps by the error of a step: this much is enough then.
_CLOSE = 1e-9
_DIFFERENCE = 1e-6  # of the parameter's range, for its derivative
_BISECTIONS = 60
# How far beyond the end of a branch the reason is looked for, in lengths of steps.
_BEYOND = (1e-6, 1e-5, 1e-4, 1e-3)
# Below this singular value branches cross: the one that is followed turns round in a pitchfork.
_CROSSING = 1e-3


@dataclass(frozen=True)
class Place:
    """A point of a branch.

    Attributes
    ----------
    orbit : Orbit
        The motion, begun `shift` of its duration after time zero.
    value : float
        Of the parameter.
    tangent : ndarray
        Direction of the branch, of state and parameter, in the branch's units.
    rank : float
        Smallest singular value of what determines the tangent: zero where branches cross.
    """

    orbit: Orbit
    value: float
    tangent: Floats
    shift: float
    rank: float

    @property
    def tests(self) -> dict[str, float]:
        """Functions whose sign changes at special points of the branch."""
        matrix = self.orbit.passage.matrix
        unit = np.eye(len(matrix))
        moduli = np.abs(self.orbit.multipliers)
        turning = np.abs(self.orbit.multipliers.imag) > 1e-9
        return {
            "fold": float(self.tangent[-1]),
            "period_doubling": float(np.linalg.det(matrix + unit)),
            "symmetry_breaking": float(np.linalg.det(matrix - unit)),
            "torus": float(np.max(np.where(turning, moduli, 0.0), initial=0.0)) - 1.0,
        }

    @property
    def marks(self) -> dict[str, float]:
        """Whole numbers whose change is a special point."""
        return {
            "lift_off": float(self.orbit.stays),
            "rest_ends": float(self.orbit.rests),
            "grazing": float(self.orbit.passage.impacts) if not self.orbit.rests else -1.0,
        }


class Branch:
    """Follows one branch; made by `continue_orbit`."""

    def __init__(self, flow: Flow, parameter: str, span: tuple[float, float], period: int) -> None:
        self.flow, self.parameter, self.span, self.period = flow, parameter, span, period
        self.scale = np.append(scale_of(flow.system), span[1] - span[0])
        # When orbits begin, as a share of their duration: not at an impact, where they jump.
        self.shift = 0.0

    def at(self, value: float) -> tuple[Flow, float]:
        """Return the flow at a value of the parameter, and the duration of the orbit."""
        system, drive = varied(self.flow.system, self.flow.drive, self.parameter, value)
        turned: Any = drive
        phase = math.fmod(turned.drive_phase + math.tau * self.period * self.shift, math.tau)
        drive = replace(turned, drive_phase=phase)
        return self.flow.with_law(system, drive), self.period * drive_period(drive)

    def place(self, orbit: Orbit, value: float, like: Floats) -> Place:
        """Return a point of the branch that points like a vector."""
        matrix = (orbit.passage.matrix - np.eye(orbit.flow.size)) * self.scale[:-1]
        matrix /= self.scale[:-1, None]
        system = np.column_stack([matrix, self.slope(orbit.start, value, orbit.turns)])
        _, sizes, rows = np.linalg.svd(system)
        tangent: Floats = rows[-1] if rows[-1] @ like >= 0.0 else -rows[-1]
        return Place(orbit, value, tangent, self.shift, float(sizes[-1]))

    def begin_between_contacts(self, place: Place) -> Place | None:
        """Return the same point begun in the longest time without contact, or None."""
        orbit = place.orbit
        times = np.sort(orbit.passage.contact_times)
        if not times.size:
            return None
        ends = np.append(times[1:], times[0] + orbit.duration)
        longest = int(np.argmax(ends - times))
        later = math.fmod(0.5 * (times[longest] + ends[longest]), orbit.duration)
        if later == 0.0:
            return None
        moved = orbit.flow.follow(orbit.start, later).end
        self.shift = math.fmod(self.shift + later / orbit.duration, 1.0)
        flow, _ = self.at(place.value)
        again = find_orbit(flow, moved, self.period, settles=False)
        if not again.defect <= CLOSED:
            return None
        like = np.zeros(flow.size + 1)
        like[-1] = place.tangent[-1]
        return self.place(again, place.value, like)

    def at_time_zero(self, place: Place) -> Floats:
        """Return the state of a point at time zero."""
        orbit = place.orbit
        if place.shift == 0.0:
            return orbit.start
        end = orbit.flow.follow(orbit.start, (1.0 - place.shift) * orbit.duration).end
        if orbit.turns:
            end[0::2] -= math.tau * orbit.turns
        return np.asarray(end)

    def slope(self, start: Floats, value: float, turns: int) -> Floats:
        """Return how the gap changes with the parameter, scaled, by differences.

        Central, or to one side where the parameter cannot be larger or smaller.
        """
        gaps, shares = [], []
        for share in (1.0, -1.0, 0.0):
            try:
                flow, duration = self.at(value + share * _DIFFERENCE * self.scale[-1])
            except ValueError:
                continue
            x = confined(flow, start)
            gaps.append(gap_of(flow, x, flow.follow(x, duration).end, turns))
            shares.append(share)
            if len(gaps) == 2:
                break
        slope = (gaps[0] - gaps[1]) / ((shares[0] - shares[1]) * _DIFFERENCE)
        return np.asarray(slope / self.scale[:-1])

    def correct(self, place: Place, length: float) -> Place | None:
        """Return the point of the branch at a distance along the tangent, or None."""
        begin = np.append(place.orbit.start, place.value) / self.scale
        guess = begin + length * place.tangent
        point, column = guess, None
        turns = place.orbit.turns
        for trial in range(_NEWTON):
            value = float(point[-1] * self.scale[-1])
            try:
                flow, duration = self.at(value)
            except ValueError:  # beyond what the parameter may be
                return None
            x = confined(flow, point[:-1] * self.scale[:-1])
            passage = flow.follow(x, duration)
            gap = gap_of(flow, x, passage.end, turns)
            missed = np.append(gap / self.scale[:-1], place.tangent @ (point - guess))
            size = float(np.linalg.norm(missed))
            if not passage.is_complete or not math.isfinite(size):
                return None
            if size <= (0.5 * CLOSED if trial < _NEWTON - 1 else _CLOSE):
                orbit = Orbit(flow, x, passage, duration, turns, size)
                return self.place(orbit, value, place.tangent)
            if column is None:
                column = self.slope(x, value, turns)
            matrix = (passage.matrix - np.eye(flow.size)) * self.scale[:-1] / self.scale[:-1, None]
            bordered = np.vstack([np.column_stack([matrix, column]), place.tangent])
            try:
                move = np.linalg.solve(bordered, -missed)
            except np.linalg.LinAlgError:
                return None
            if np.linalg.norm(move) > 10.0 * _LONGEST:
                return None
            point = point + move
        return None

    def specials(self, old: Place, new: Place, length: float) -> list[tuple[str, Place]]:
        """Return the special points between two neighbours, located along the branch."""
        found = []
        before, after = old.tests, new.tests
        both_move = not (old.orbit.rests or new.orbit.rests)
        if both_move and old.marks == new.marks:
            for test in KINDS[:4]:
                kind = test
                # At a fold a multiplier is one as well: that is no other branch.
                if kind == "symmetry_breaking" and before["fold"] * after["fold"] < 0.0:
                    continue
                if before[kind] * after[kind] < 0.0:
                    if kind == "torus" and min(before[kind], after[kind]) == -1.0:
                        continue  # two real multipliers meet: nothing crosses the unit circle
                    there = self._locate(old, new, length, _sign_of(kind, before))
                    if kind == "fold" and there.rank < _CROSSING:
                        kind = "symmetry_breaking"
                        there = self._vertex(old, new, length, there)
                    found.append((kind, there))
        elif before["fold"] * after["fold"] < 0.0:
            found.append(("fold", self._locate(old, new, length, _sign_of("fold", before))))
        return found + [
            (kind, self._locate(old, new, length, _same(kind, old)))
            for kind in KINDS[4:]
            if old.marks[kind] != new.marks[kind] and (kind != "grazing" or both_move)
        ]

    def obstacles(self, place: Place) -> list[tuple[str, Place]]:
        """Return which contact appears or vanishes just beyond the end of a branch."""
        here = np.append(place.orbit.start, place.value) / self.scale
        for length in _BEYOND:
            beyond = (here + length * place.tangent) * self.scale
            try:
                flow, duration = self.at(float(beyond[-1]))
            except ValueError:  # beyond what the parameter may be
                return []
            passage = flow.follow(confined(flow, beyond[:-1]), duration)
            marks = replace(place, orbit=replace(place.orbit, passage=passage)).marks
            for kind in KINDS[4:]:
                if marks[kind] != place.marks[kind]:
                    return [(kind, place)]
        return []

    def _vertex(self, old: Place, new: Place, length: float, there: Place) -> Place:
        """Return a crossing at the vertex of the parabola that the parameter describes.

        Newton's method is singular at the crossing itself; beside it the branch is symmetric.
        """
        for share in (0.5, 0.3, 0.7):
            middle = self.correct(old, share * length)
            if middle is not None:
                s, values = [0.0, share, 1.0], [old.value, middle.value, new.value]
                bend, slope, _ = np.polyfit(s, values, 2)
                vertex = -0.5 * slope / bend
                return replace(there, value=float(np.polyval(np.polyfit(s, values, 2), vertex)))
        return there

    def _locate(
        self, old: Place, new: Place, length: float, is_before: Callable[[Place], bool]
    ) -> Place:
        """Return the first point found where a condition no longer holds, by bisection."""
        low, high, place = 0.0, length, new
        for _ in range(_BISECTIONS):
            # Where branches cross Newton's method may fail at one place and not beside it.
            for share in (0.5, 0.4, 0.6, 0.3, 0.7):
                middle = low + share * (high - low)
                trial = self.correct(old, middle)
                if trial is not None:
                    break
            if trial is None or high - low < 1e-11:
                break
            if is_before(trial):
                low = middle
            else:
                high, place = middle, trial
        return place


def _sign_of(kind: str, before: dict[str, float]) -> Callable[[Place], bool]:
    """Return whether a test function still has its sign."""
    return lambda place: place.tests[kind] * before[kind] > 0.0


def _same(kind: str, old: Place) -> Callable[[Place], bool]:
    """Return whether a whole number is still the same."""
    return lambda place: place.marks[kind] == old.marks[kind]


@analyses.register("continue_orbit")
def continue_orbit(
    system: System,
    drive: Drive | None = None,
    *,
    parameter: str = "frequency_ratio",
    low: float,
    high: float,
    direction: str = "up",
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    period: int = 1,
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
        Where the branch is followed, in the parameter's unit.
    direction : str
        ``up`` or ``down``: where the parameter goes at first; a fold may turn it round.
    initial_angle, initial_angular_velocity, initial_offset, period
        Guess of the first orbit, as of `floquet`.
    points : int
        Most points of the branch.
    contact, tolerance, rest_speed
        As of `floquet`.

    Returns
    -------
    xarray.Dataset
        Over ``point`` in the order in which they were met: the parameter, ``initial_angle`` and
        ``initial_angular_velocity`` at time zero, ``largest_angle`` on the orbit, ``multipliers``
        (largest modulus first), ``is_stable``, ``impacts``. Over ``special`` the points located on
        the way: ``special_kind`` (``fold``, ``period_doubling``, ``symmetry_breaking``: a
        multiplier is one without a fold, ``torus``: a complex pair crosses the unit circle,
        ``grazing``: an impact appears or vanishes, ``lift_off``: what was at rest all the time
        begins to move, ``rest_ends``: the last phase at rest appears or vanishes),
        ``special_value`` in the parameter's unit and ``special_angle``. ``status``: ``end of
        range``, ``points`` (more would follow), ``closed`` (the branch is a loop), ``lost`` (it
        ends here, as at grazing, or its steps became too short) or ``not found``.

    Raises
    ------
    ValueError
        For an unknown parameter, a range that does not hold its present value, and as `floquet`.

    Notes
    -----
    Steps adapt to Newton's convergence, between 1e-7 and 2e-2 of radians and of the range.
    Special points are bisected to 1e-11 of a step, pitchforks in which the branch turns round are
    taken from a parabola (error about 1e-7 of the range). Missed are two of the same kind within
    one step, and branches that are not connected to the first orbit. At grazing the map has a
    square root: a branch may end there, and says ``lost``.

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
    driven = periodic_drive(system, drive)
    begun = value_of(system, driven, parameter)
    low = checked_number("low", low, ANY, "1")
    high = checked_number("high", high, ANY, "1")
    if not low < high or not low <= begun <= high:
        raise ValueError(
            f"low and high must enclose the {parameter} of the first orbit, {begun:.9g}, got "
            f"[{low:g}, {high:g}]"
        )
    if direction not in ("up", "down"):
        raise ValueError(f"direction must be 'up' or 'down', got {direction!r}")
    count = int(checked_number("period", period, Range(1, LONGEST), "1"))
    most = checked_count("points", points)
    flow = Flow(
        system,
        driven,
        contact=contact,
        tolerance=checked_number("tolerance", tolerance, Range(1e-14, 1e-2), "rad"),
        rest_speed=checked_number("rest_speed", rest_speed, NON_NEGATIVE, "rad/s"),
        speed=2.0 * system.natural_frequency,
    )
    guess = checked_guess(flow, initial_angle, initial_angular_velocity, initial_offset)
    branch = Branch(flow, parameter, (low, high), count)
    first = find_orbit(flow, guess, count)
    places: list[Place] = []
    specials: list[tuple[str, Place]] = []
    status = "not found"
    if first.defect <= CLOSED:
        toward = np.zeros(flow.size + 1)
        toward[-1] = 1.0 if direction == "up" else -1.0
        places = [branch.place(first, begun, toward)]
        places[0] = branch.begin_between_contacts(places[0]) or places[0]
        status = _follow(branch, places, specials, most)
    if status in ("not found", "lost"):
        where = f" at {parameter} = {places[-1].value:.9g}" if places else ""
        hint = "; try a start on the attractor"
        if places:
            why = specials[-1][0].replace("_", " ") if specials else ""
            near = bool(why) and specials[-1][1].value == places[-1].value
            hint = f", by {why}" if near else ": Newton's method fails with the shortest steps"
        warnings.warn(f"the branch was {status}{where}{hint}", RuntimeWarning, stacklevel=2)
    return _dataset(branch, places, specials, status, {
        "low": low, "high": high, "direction": direction, "period": count, "points": most,
        "tolerance": flow.tolerance, "rest_speed": flow.rest_speed,
    })  # fmt: skip


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
        if new is None or new.tangent @ place.tangent < 0.9:
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
        specials += branch.specials(place, new, length)
        places.append(new)
        stepped, length = length, min(1.5 * length, _LONGEST)
        if not low <= new.value <= high:
            places[-1] = _end(branch, place, stepped)
            return "end of range"
        if new.shift != places[0].shift:
            continue
        gap = np.append(new.orbit.start - places[0].orbit.start, new.value - places[0].value)
        if len(places) > 10 and np.linalg.norm(gap / branch.scale) < 0.5 * length:
            return "closed"
    return "points"


def _end(branch: Branch, old: Place, length: float) -> Place:
    """Return the point where the branch leaves the range, by bisection along the branch."""
    low, high = branch.span
    inside, outside, place = 0.0, length, old
    for _ in range(_BISECTIONS):
        middle = 0.5 * (inside + outside)
        trial = branch.correct(old, middle)
        if trial is None or outside - inside < 1e-11:
            break
        if low <= trial.value <= high:
            inside, place = middle, trial
        else:
            outside = middle
    return place


def _dataset(
    branch: Branch,
    places: list[Place],
    specials: list[tuple[str, Place]],
    status: str,
    settings: dict[str, Any],
) -> xr.Dataset:
    """Return the labelled branch."""
    flow, parameter = branch.flow, branch.parameter
    two = flow.size == 4
    starts = np.array([branch.at_time_zero(p) for p in places]).reshape(-1, flow.size)
    per_ball = ("point", "ball") if two else ("point",)

    def ball(values: Floats) -> Floats:
        return values if two else values[:, 0]

    # The name of a parameter of one of two balls begins with the ball's.
    about = KNOWN[parameter if parameter in KNOWN else parameter.split("_", 1)[1]]
    multipliers = np.array([p.orbit.multipliers for p in places], dtype=complex)
    multipliers = multipliers.reshape(-1, flow.size)
    largest = np.abs(multipliers).max(axis=1, initial=0.0)
    variables = {
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
        "status": status,
    }
    quantities = QUANTITIES | {
        parameter: about,
        "special_value": replace(QUANTITIES["special_value"], unit=about.unit),
    }
    return labelled(
        "continue_orbit",
        variables,
        coordinates={"ball": ("ball", ["right", "left"])} if two else None,
        quantities=quantities,
        system=flow.system,
        drive=flow.drive,
        settings={"parameter": parameter, **settings},
    )
