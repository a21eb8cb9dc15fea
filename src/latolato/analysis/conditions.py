"""What makes a periodic motion special, as equations for its state and two parameters.

Two ideas hold all kinds. Either a multiplier of the map that closes the motion is one (a fold) or
minus one (it loses a symmetry or doubles its period); or something that must not be negative, the
clearance between balls, the force between them or the tension of a string, touches zero at one
instant. A motion of the second kind begins at that instant, so nothing in it is steep there: the
square root that a grazing impact brings into the map lies on the other side of the curve.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.analysis.branch import mirrors_of
from latolato.analysis.flow import Floats, Flow, Passage, drive_period, value_of, varied
from latolato.analysis.orbits import gap_of, scale_of, turns_of
from latolato.analysis.self_start import holding_friction, resting_angles
from latolato.core.errors import InputError
from latolato.numerics.integrate import LARGEST
from latolato.observables.period import wrapped
from latolato.physics.contacts import REST
from latolato.physics.pendulum import System
from latolato.simulation.vary import DERIVED

# A motion begun at a touch flies so long, in its own durations, before contacts are looked for.
_FLIGHT = 0.05
# A point at which motions merge is known to some 1e-5: it and its image are one within this.
NEARLY = 1e-4
# A product of all multipliers so near one is that of a motion without losses.
_LOSSLESS = 1e-6
# Samples of one instant: a polynomial through so many, over so much of a drive period, gives value
# and derivatives at its beginning to some 1e-12.
_NODES, _SPAN = 9, 0.02
# Units of a state, in sizes of the motion; a motion without impacts may vanish, its units do not.
_SIZES, _SMALLEST = 6.0, 0.1
# The second derivative of a map's matrix is a difference over so much, in units of the state.
_BESIDE = 3e-3
# Left and right eigenvectors of length one, this near to a right angle, belong to a multiplier that
# is there twice.
_DEFECTIVE = 1e-4
# In samples of a motion something is negative if it is below this, in natural units.
_NEGATIVE, _SAMPLES = 1e-7, 400


@dataclass(frozen=True)
class Plane:
    """Two parameters of a system under a drive, between limits.

    Attributes
    ----------
    flow : Flow
        The motion at some values of both.
    names : pair of str
    low, high : ndarray, shape (2,)
        SI units.
    """

    flow: Flow
    names: tuple[str, str]
    low: Floats
    high: Floats

    @property
    def width(self) -> Floats:
        """The range of each parameter, the unit in which it is measured along a curve."""
        return self.high - self.low

    @property
    def values(self) -> Floats:
        """Both parameters of the motion that is given."""
        return np.array([value_of(self.flow.system, self.flow.drive, n) for n in self.names])

    def at(self, values: Floats, turn: float = 0.0) -> Flow:
        """Return the motion at other values, begun when the drive has turned by some radians.

        Ratios are set last, since they are of other parameters, and the ratio of accelerations
        after that of frequencies.
        """
        system: System = self.flow.system
        drive: Any = self.flow.drive
        given = dict(zip(self.names, values, strict=True))
        order = ("drive_acceleration_ratio", *DERIVED)
        for name in sorted(given, key=lambda each: (each in order, each == order[0])):
            system, drive = varied(system, drive, name, float(given[name]))
        phase = math.fmod(drive.drive_phase + turn, math.tau)
        return replace(self.flow, system=system, drive=replace(drive, drive_phase=phase))


@dataclass(frozen=True)
class Solution:
    """A motion at some values of the unknowns.

    Attributes
    ----------
    residual : ndarray, shape (equation,)
        By how much it misses the equations, in units of the state.
    flow, start, turn
        The motion, its state where it begins, and by how much the drive has turned there [rad].
    passage : Passage
        Through the duration of the map.
    matrix : ndarray, shape (state, state)
        Of the map that closes the motion, in units of the state.
    values : ndarray, shape (2,)
        The parameters.
    """

    residual: Floats
    flow: Flow
    start: Floats
    turn: float
    passage: Passage
    matrix: Floats
    values: Floats


class Condition(ABC):
    """Equations whose solutions are a curve, for one more unknown than there are of them.

    Unknowns are numbers of the state, over the size of the motion, and the two parameters over
    their ranges; so are the equations.

    Attributes
    ----------
    measure : ndarray, shape (state,)
        Units of the state, which suit the size of the motion.
    """

    plane: Plane
    measure: Floats

    @property
    def units(self) -> Floats:
        """Units of the unknowns."""
        return np.concatenate([self.free_part(self.measure), self.further, self.plane.width])

    @property
    def further(self) -> Floats:
        """Units of unknowns between state and parameters."""
        return np.empty(0)

    @abstractmethod
    def at(self, unknowns: Floats) -> Solution | None:
        """Return the motion at some unknowns, or None where there is none."""

    @abstractmethod
    def tests(self, solution: Solution) -> dict[str, float]:
        """Return functions whose sign changes at points of codimension two, by their kind."""

    @abstractmethod
    def others(self, solution: Solution) -> NDArray[np.complex128]:
        """Return the multipliers that are not critical by the condition itself."""

    def free_part(self, state: Floats) -> Floats:
        """Return what of a state is unknown."""
        return state

    def images(self, solution: Solution) -> list[Floats]:
        """Return how far a motion is from each of its images, in units of the state."""
        return []

    def settle(self, solution: Solution) -> None:  # noqa: B027
        """Take what is held fixed beside a solution from it, if anything is."""

    def obstacle(self, solution: Solution) -> str:
        """Return what else happens in a motion, which ends the curve; nothing in most."""
        return "slackens" if math.isfinite(solution.passage.slack_time) else ""

    def size_of(self, solution: Solution) -> Floats:
        """Return units of the state that suit a motion: bouncing balls hop by any angle."""
        passage, natural = solution.passage, scale_of(solution.flow.system)
        impacts = passage.contact_kinds < REST
        if not impacts.any() or np.any(passage.contact_kinds == REST):
            return natural * max(_SIZES * passage.largest_angle, _SMALLEST)
        times = np.sort(passage.contact_times[impacts])
        duration = self.duration(solution.flow)
        flight = float(np.diff(np.append(times, times[0] + duration)).max())
        speed = float(np.abs(passage.contact_values[:, impacts]).max())
        hop = np.tile([0.25 * speed * flight, speed], len(natural) // 2)
        return np.asarray(_SIZES * np.minimum(natural * max(passage.largest_angle, _SMALLEST), hop))

    @abstractmethod
    def duration(self, flow: Flow) -> float:
        """Return the time over which the motion is followed [s]."""


class Multiplier(Condition):
    """A multiplier of the map that closes a motion is one or minus one.

    The map leads over some drive periods, and to the image in a mirror where the motion equals its
    image. So the loss of a symmetry is a multiplier of minus one like the doubling of a period, and
    regular: over the whole period it would be one, and the equations singular.

    Parameters
    ----------
    plane : Plane
    mirror : ndarray, shape (state, state)
    periods : int
        Of the drive, over which the map leads.
    critical : float
        One or minus one.
    """

    def __init__(self, plane: Plane, mirror: Floats, periods: int, critical: float) -> None:
        self.plane, self.mirror, self.periods, self.critical = plane, mirror, periods, critical
        self.measure = scale_of(plane.flow.system)
        self.turns: int | None = None
        size = len(self.measure)
        # Left and right null vectors of the critical matrix, as they were at the last solution.
        self.left, self.right = np.ones(size), np.ones(size)

    def begin(self, start: Floats, values: Floats) -> Floats | None:
        """Return unknowns of a motion to begin with; they solve nothing yet."""
        solution = self.at(np.append(start, values) / self.units)
        if solution is None:
            return None
        self.measure = self.size_of(solution)
        solution = self.at(np.append(start, values) / self.units)
        assert solution is not None
        self.settle(solution)
        return np.append(start, values) / self.units

    def settle(self, solution: Solution) -> None:
        """Take the null vectors from a solution, each on the side of the last one."""
        left, _, right = np.linalg.svd(solution.matrix - self.critical * np.eye(len(self.measure)))
        self.left = left[:, -1] if left[:, -1] @ self.left >= 0.0 else -left[:, -1]
        self.right = right[-1] if right[-1] @ self.right >= 0.0 else -right[-1]

    def at(self, unknowns: Floats) -> Solution | None:
        """Return the motion at a state and two parameters."""
        numbers = unknowns * self.units
        start, values = numbers[:-2], numbers[-2:]
        try:
            flow = self.plane.at(values)
        except InputError:
            return None
        passage = flow.follow(start, self.duration(flow))
        end = self.mirror @ passage.end
        if not passage.is_complete or not np.all(np.abs(end) < LARGEST):
            return None
        if self.turns is None:
            self.turns = turns_of(flow, start, end)
        gap = gap_of(start, end, self.turns) / self.measure
        matrix = (self.mirror @ passage.matrix) * self.measure / self.measure[:, None]
        border = self._border(matrix)
        residual = np.append(gap, np.linalg.solve(border, np.eye(len(border))[-1])[-1])
        return Solution(residual, flow, start, 0.0, passage, matrix, values)

    def _border(self, matrix: Floats) -> Floats:
        """Return the critical matrix with a border that makes it regular.

        The last number of its solution for the last unit vector vanishes where the matrix is
        singular; Govaerts (2000), as in MatCont.
        """
        size = len(matrix)
        border = np.zeros((size + 1, size + 1))
        border[:size, :size] = matrix - self.critical * np.eye(size)
        border[:size, size], border[size, :size] = self.left, self.right
        return border

    def duration(self, flow: Flow) -> float:
        """Return the time over which the map leads [s]."""
        return self.periods * drive_period(flow.drive)

    def images(self, solution: Solution) -> list[Floats]:
        """Return how far a motion is from each of its images, in units of the state.

        Those are its states after fewer drive periods, and in a mirror.
        """
        found = []
        flow, start = solution.flow, solution.start
        for count in range(1, self.periods + 1):
            end = flow.follow(start, count * drive_period(flow.drive)).end
            for mirror in (np.eye(flow.size), *mirrors_of(flow)):
                gap = mirror @ end - start
                gap[0::2] = wrapped(gap[0::2])
                found.append(gap / scale_of(flow.system))
        return found

    def others(self, solution: Solution) -> NDArray[np.complex128]:
        """Return the multipliers of the map but for the critical one."""
        multipliers = np.linalg.eigvals(solution.matrix).astype(complex)
        return np.delete(multipliers, np.argmin(np.abs(multipliers - self.critical)))

    def tests(self, solution: Solution) -> dict[str, float]:
        """Return those of other multipliers: one equals the critical one, or is its opposite.

        Without losses multipliers come in pairs of product one, so the partner of the critical one
        equals it at every point of the curve, which is no event.
        """
        others = self.others(solution)
        if abs(np.linalg.det(solution.matrix) - 1.0) < _LOSSLESS:
            others = np.delete(others, np.argmin(np.abs(others - self.critical)))
        equal = float(np.real(np.prod(self.critical - others)))
        opposite = float(np.real(np.prod(self.critical + others)))
        if self.critical > 0.0:
            return {"resonance_1_1": equal, "fold_flip": opposite}
        cubic = self.cubic(solution)
        return {"resonance_1_2": equal, "fold_flip": opposite, self.degenerate: cubic}

    @property
    def degenerate(self) -> str:
        """The kind of the points at which the cubic coefficient vanishes."""
        is_doubling = np.array_equal(self.mirror, np.eye(len(self.mirror)))
        return "generalised_flip" if is_doubling else "degenerate_pitchfork"

    def cubic(self, solution: Solution) -> float:
        """Return the cubic coefficient of the map at a multiplier of minus one.

        On its centre manifold the map is ``-x + c x^3``. Positive: stable motions of less symmetry
        or twice the period begin where the motion loses its stability; negative: unstable ones end
        there. NaN where impacts come or go beside the motion, and where two multipliers are minus
        one, as without damping; Kuznetsov (2004), section 5.4.
        """
        unit, middle = np.eye(len(self.measure)), solution.matrix
        values, vectors = np.linalg.eig(middle)
        right = np.real(vectors[:, np.argmin(np.abs(values + 1.0))])
        values, vectors = np.linalg.eig(middle.T)
        left = np.real(vectors[:, np.argmin(np.abs(values + 1.0))])
        if abs(left @ right) < _DEFECTIVE:
            return math.nan
        sides = []
        for width in (_BESIDE, -_BESIDE):
            start = solution.start + width * right * self.measure
            passage = solution.flow.follow(start, self.duration(solution.flow))
            if not np.array_equal(passage.contact_kinds, solution.passage.contact_kinds):
                return math.nan
            sides.append((self.mirror @ passage.matrix) * self.measure / self.measure[:, None])
        slope = (sides[0] - sides[1]) / (2.0 * _BESIDE)
        bend = (sides[0] - 2.0 * middle + sides[1]) / _BESIDE**2
        second = np.linalg.lstsq(unit - middle, slope @ right, rcond=None)[0]
        return float(left @ (bend @ right + 3.0 * slope @ second) / (6.0 * (left @ right)))


class Touch(Condition):
    """Something that must not be negative touches zero where the motion begins.

    Unknowns are what of the state is free at that instant, the phase of the drive there, and the
    two parameters. Equations: the motion closes, and the first derivative of what touches zero
    vanishes with it.

    Parameters
    ----------
    plane : Plane
    kind : {"grazing", "lift_off", "slack_onset"}
    periods : int
        Of the drive, after which the motion closes.
    wall : int
        Which of ``flow.walls`` balls touch, for the first two kinds.
    ball : int
        Whose string touches tension zero, for the last.
    """

    def __init__(self, plane: Plane, kind: str, periods: int, wall: int = 0, ball: int = 0) -> None:
        self.plane, self.kind, self.periods, self.wall, self.ball = plane, kind, periods, wall, ball
        self.measure = scale_of(plane.flow.system)
        self.turns: int | None = None
        self.flight = _FLIGHT

    @property
    def further(self) -> Floats:
        """The unit of the drive's phase."""
        return np.ones(1)

    def size_of(self, solution: Solution) -> Floats:
        """Return units of the state; the hops of a force of zero are rounding."""
        if self.kind == "lift_off":
            return scale_of(solution.flow.system)
        return super().size_of(solution)

    def begin(self, start: Floats, turn: float, values: Floats) -> Floats | None:
        """Return unknowns of a motion that is nearly special, begun where it touches."""
        numbers = np.concatenate([self.free_part(start), [turn], values])
        solution = self.at(numbers / self.units)
        if solution is None:
            return None
        self.measure = self.size_of(solution)
        return np.asarray(numbers / self.units)

    def free_part(self, state: Floats) -> Floats:
        """Return what of a state is not said by the touch."""
        if self.kind == "lift_off":
            return state[:0]  # balls at rest balance each other
        return state if self.kind == "slack_onset" else state[2:]

    def ends(self, free: Floats, flow: Flow, values: Floats) -> tuple[Floats, Floats]:
        """Return the states after and before the touch, which are one where nothing is hit."""
        if self.kind == "slack_onset":
            return free, free
        wall = flow.walls[self.wall]
        if self.kind == "lift_off" and flow.size == 4:
            right, left = resting_angles(flow.system)
            return np.array([right, 0.0, left, 0.0]), np.array([right, 0.0, left, 0.0])
        state = [wall, 0.0] if flow.size == 2 else [free[0] + wall, free[1], free[0], free[1]]
        return np.array(state), np.array(state)

    def settle(self, solution: Solution) -> None:
        """Let the flight past the touch end halfway to the nearest other contact."""
        duration, times = self.duration(solution.flow), solution.passage.contact_times
        nearest = float(np.min(np.minimum(times, duration - times), initial=math.inf))
        self.flight = min(_FLIGHT, 0.5 * nearest / duration) or _FLIGHT

    def at(self, unknowns: Floats) -> Solution | None:
        """Return the motion begun at a touch."""
        numbers = unknowns * self.units
        free, turn, values = numbers[:-3], float(numbers[-3]), numbers[-2:]
        try:
            flow = self.plane.at(values, turn)
        except InputError:
            return None
        start, end = self.ends(free, flow, values)
        passage = self._around(flow, start)
        if passage is None:
            return None
        if self.turns is None:
            self.turns = turns_of(flow, end, passage.end)
        gap = gap_of(end, passage.end, self.turns) / self.measure
        if self.kind == "grazing":
            residual = gap
        elif self.kind == "slack_onset":
            residual = np.append(gap, self._touch_derivatives(flow, start)[:2])
        else:  # balls at rest stay where they are
            residual = self._touch_derivatives(flow, start)[:2]
        matrix = passage.matrix * self.measure / self.measure[:, None]
        return Solution(residual, flow, start, turn, passage, matrix, values)

    def _around(self, flow: Flow, start: Floats) -> Passage | None:
        """Return the way back to the touch, which itself is passed without contact."""
        duration = self.duration(flow)
        if self.kind != "grazing":
            passage = flow.follow(start, duration)
            return passage if passage.is_complete else None
        free = replace(flow, contact=None)
        pieces = ((free, self.flight), (flow, 1.0 - 2.0 * self.flight), (free, self.flight))
        begun, way, state = 0.0, None, start
        for each, share in pieces:
            each = later(each, begun * duration)
            passage = each.follow(state, share * duration)
            if not passage.is_complete:
                return None
            way = passage if way is None else joined_passages(way, passage, begun * duration)
            state, begun = passage.end, begun + share
        return way

    def _touch_derivatives(self, flow: Flow, start: Floats) -> Floats:
        """Return what touches zero, its first and its second derivative over drive periods.

        For a grazing contact it is the acceleration with which the clearance grows that must not
        vanish; its own first two derivatives are zero and this acceleration.
        """
        span = _SPAN * drive_period(flow.drive)
        nodes = 0.5 * span * (1.0 - np.cos(np.pi * np.arange(_NODES) / (_NODES - 1)))
        if self.kind == "lift_off":
            return _derivatives(nodes / span, self._contact_force(flow, start, nodes))
        if self.kind == "grazing":
            return self._clearance(flow, start, nodes)
        return _derivatives(nodes / span, self._sampled(flow, start, nodes, "tension")[self.ball])

    def _contact_force(self, flow: Flow, start: Floats, times: Floats) -> Floats:
        """Return the force that holds one ball at a wall, or two together, over the weight's part.

        Gravity and the pivot press balls against the lower wall together; friction holds them too.
        """
        (segment, *_) = flow.drive.segments(float(times[-1]))
        acceleration = type(flow.drive).acceleration
        accelerations = np.array([acceleration(float(time), segment) for time in times])
        gravity = flow.system.gravity
        friction = holding_friction(flow.system, tuple(start[0::2]))
        sign = 1.0 if self.wall == 0 else -1.0
        return np.asarray(sign * (1.0 + accelerations / gravity) + friction / gravity)

    def _clearance(self, flow: Flow, start: Floats, nodes: Floats) -> Floats:
        """Return how far balls are from touching, and its derivatives, over natural units."""
        angles = self._sampled(flow, start, nodes, "angle")
        separation = angles[0] if flow.size == 2 else angles[0] - angles[1]
        sign = 1.0 if self.wall == 0 else -1.0
        rate = flow.system.natural_frequency
        return _derivatives(nodes * rate, sign * (separation - flow.walls[self.wall]))

    def _sampled(
        self, flow: Flow, start: Floats, nodes: Floats, name: str, contact: Any = None
    ) -> Floats:
        """Return a variable of each ball after so many seconds, as if nothing were in the way."""
        system: Any = flow.system
        if flow.is_string:
            system = replace(system, suspension="rod", string_restitution=0.0)
        run = replace(flow, system=system, contact=contact).sampled(start, nodes)
        return np.atleast_2d(run[name])

    def duration(self, flow: Flow) -> float:
        """Return the time after which the motion closes [s]."""
        return self.periods * drive_period(flow.drive)

    def others(self, solution: Solution) -> NDArray[np.complex128]:
        """Return all multipliers."""
        return np.linalg.eigvals(solution.matrix).astype(complex)

    def obstacle(self, solution: Solution) -> str:
        """Return whether what touches zero is below it at another instant, or a string slackens."""
        if self.kind != "slack_onset" and math.isfinite(solution.passage.slack_time):
            return "slackens"
        return "touches_twice" if self._least(solution) < -_NEGATIVE else ""

    def _least(self, solution: Solution) -> float:
        """Return the smallest value of what touches zero, in natural units, along the motion.

        A graze is passed without contact, and so are its neighbours in time.
        """
        flow, duration = solution.flow, self.duration(solution.flow)
        times = np.linspace(0.0, duration, _SAMPLES)
        if self.kind == "slack_onset":
            weight = flow.system.balls[self.ball].mass * flow.system.gravity
            values = self._sampled(flow, solution.start, times, "tension", contact=flow.contact)
            return float(np.min(values[self.ball])) / weight
        if self.kind == "lift_off":
            return float(np.min(self._contact_force(flow, solution.start, times)))
        angles = self._sampled(
            flow, solution.start, times[times <= self.flight * duration], "angle"
        )
        separation = angles[0] if flow.size == 2 else angles[0] - angles[1]
        return float(min(np.min(separation - flow.walls[0]), np.min(flow.walls[1] - separation)))

    def tests(self, solution: Solution) -> dict[str, float]:
        """Return those of the multipliers, and of the second derivative of what touches."""
        unit = np.eye(len(solution.matrix))
        result = {"degenerate": float(self._touch_derivatives(solution.flow, solution.start)[2])}
        if self.kind == "lift_off":
            return result
        return result | {
            "meets_fold": float(np.linalg.det(solution.matrix - unit)),
            "meets_flip": float(np.linalg.det(solution.matrix + unit)),
        }


def later(flow: Flow, time: float) -> Flow:
    """Return a flow whose time zero is some seconds later."""
    drive: Any = flow.drive
    phase = math.fmod(drive.drive_phase + drive.drive_frequency * time, math.tau)
    return replace(flow, drive=replace(drive, drive_phase=phase))


def joined_passages(first: Passage, second: Passage, begun: float) -> Passage:
    """Return two ways one after the other as one; the second begins `begun` seconds later."""
    return replace(
        second,
        matrix=second.matrix @ first.matrix,
        spread=first.spread + second.spread,
        largest_angle=max(first.largest_angle, second.largest_angle),
        contact_times=np.append(first.contact_times, begun + second.contact_times),
        contact_kinds=np.append(first.contact_kinds, second.contact_kinds),
        contact_values=np.concatenate([first.contact_values, second.contact_values], axis=1),
        grazes=first.grazes + second.grazes,
        slack_time=min(first.slack_time, begun + second.slack_time),
    )


def _derivatives(times: Floats, values: Floats) -> Floats:
    """Return value, first and second derivative at the first of some times."""
    fit = np.polynomial.Polynomial.fit(times, values, len(times) - 1)
    return np.array([fit(times[0]), fit.deriv(1)(times[0]), fit.deriv(2)(times[0])])


def closing_maps(
    flow: Flow, start: Floats, period: int, nearness: float = 1e-6
) -> list[tuple[Floats, int]]:
    """Return the mirror and the drive periods of each map under which a motion is its own image.

    The shorter ones first, and those without a mirror before others. A motion and its image are one
    if they differ by less than `nearness` [rad, and over the natural frequency].
    """
    unit = np.eye(flow.size)
    found = []
    scale = scale_of(flow.system)
    for count in range(1, period + 1):
        end = flow.follow(start, count * drive_period(flow.drive)).end
        for mirror in (unit, *mirrors_of(flow)):
            gap = mirror @ end - start
            gap[0::2] = wrapped(gap[0::2])
            if np.linalg.norm(gap / scale) < nearness:
                found.append((mirror, count))
    return found
