"""Follows the solutions of equations with one unknown more than there are equations.

Pseudo-arclength continuation; Keller (1977), as in AUTO, COCO and BifurcationKit.jl.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import brentq

from latolato.analysis.conditions import Condition, Solution
from latolato.analysis.flow import Floats

# Lengths of steps along a curve, in units of the state and of the parameters' ranges.
_FIRST, _SHORTEST, _LONGEST = 2e-3, 1e-7, 2e-2
# A point this near to an end of its range is at it: beyond, a parameter may have no meaning.
_AT_END = 1e-6
# A test that does not become this much smaller where its sign changes has jumped there.
_SMALLER = 1e-3
# An obstacle is approached to this distance.
_CLOSE = 1e-4
# Equations are solved to this; differences of them are taken over so much.
_SOLVED, _DIFFERENCE = 1e-10, 1e-6
_TRIALS = 12
# The rounding of angles, which equations of the smallest hops do not get below.
_ROUNDED = 1e-15
# A first guess is moved by at most so much in one trial, and is lost beyond so much in all.
_MOVE, _REACH = 0.02, 0.05
# Equations whose matrix is this near to singular describe no curve.
_SINGULAR = 1e-7
# Functions that vanish all along a curve, as where nothing is lost, differ from zero by rounding.
_ROUNDING = 1e-6
# Where, beyond the end of a curve, the reason is looked for.
_BEYOND = (1e-6, 1e-5, 1e-4, 1e-3)
# A motion that is this near to an image of itself has that symmetry.
_MERGED = 1e-5
# Share of a gap that is left where a straight line between two neighbours has it zero: at a true
# zero it is of the second order in the step, at an impact all of it.
_TURNED = 0.5


@dataclass(frozen=True)
class CurvePoint:
    """A point of a curve: unknowns, the motion, the matrix of the equations, the direction."""

    unknowns: Floats
    measure: Floats
    solution: Solution
    matrix: Floats
    tangent: Floats
    tests: dict[str, float]


@dataclass(frozen=True)
class Special:
    """A point of codimension two: its kind, and where it is."""

    kind: str
    point: CurvePoint


class Curve:
    """Follows one curve; made by `bifurcation_curve`."""

    def __init__(self, condition: Condition) -> None:
        self.condition = condition
        plane = condition.plane
        self.low, self.high = plane.low / plane.width, plane.high / plane.width

    def begin(self, guess: Floats) -> CurvePoint | None:
        """Return the point of the curve nearest to a guess, or None."""
        unknowns, solution = guess, self.condition.at(guess)
        for _ in range(2 * _TRIALS):
            if solution is None:
                return None
            if np.linalg.norm(solution.residual) <= self._limit(solution):
                self.condition.settle(solution)
                again = self.condition.at(unknowns)
                point = None if again is None else self._point(unknowns, again)
                return None if point is None else self._inside(point)
            matrix = self._matrix(unknowns, solution)
            if matrix is None:
                return None
            move = np.linalg.lstsq(matrix, -solution.residual, rcond=1e-12)[0]
            size = float(np.linalg.norm(move))
            if size == 0.0:
                return None
            unknowns = unknowns + move * min(1.0, _MOVE / size)
            if np.linalg.norm(unknowns - guess) > _REACH:
                return None
            solution = self.condition.at(unknowns)
        return None

    def _inside(self, point: CurvePoint) -> CurvePoint | None:
        """Return a point, or where the curve enters the range if it lies beyond."""
        border = self._border(point)
        if border is None:
            return point
        which, end = border
        row = np.zeros(len(point.unknowns))
        row[which - 2] = 1.0
        guess = point.unknowns.copy()
        guess[which - 2] = end
        return self._solved(point, guess, row)

    def at_value(self, guess: Floats, row: Floats) -> CurvePoint | None:
        """Return the point of the curve whose distance to a guess is across a direction, or None.

        Unlike along the curve, nothing is known of it yet.
        """
        solution = self.condition.at(guess)
        point = None if solution is None else self._point(guess, solution)
        return None if point is None else self._solved(point, guess, row)

    def is_singular(self, point: CurvePoint) -> bool:
        """Whether the equations leave more than one direction free."""
        sizes = np.linalg.svd(point.matrix, compute_uv=False)
        return bool(sizes[-1] < _SINGULAR * max(1.0, sizes[0]))

    def follow(
        self,
        first: CurvePoint,
        way: float,
        most: int,
        on_point: Callable[[CurvePoint], None],
        goal: CurvePoint | None = None,
    ) -> tuple[list[CurvePoint], list[Special], str]:
        """Return points of the curve after the first, what is special among them, and its end.

        Parameters
        ----------
        way : float
            One along the tangent of the first point, minus one against it.
        most : int
            Most points.
        on_point : callable
            Called with each point.
        goal : CurvePoint, optional
            Where the other way stopped: a curve that comes there from beyond is closed.
        """
        self.condition.measure = first.measure
        self.condition.settle(first.solution)
        begun = self._toward(first, way * first.tangent)
        points: list[CurvePoint] = [begun]
        specials: list[Special] = []
        try:
            reason = self._follow(points, specials, most, on_point, goal)
        except KeyboardInterrupt:
            reason = "interrupted"
        return points[1:], specials, reason

    def _follow(
        self,
        points: list[CurvePoint],
        specials: list[Special],
        most: int,
        on_point: Callable[[CurvePoint], None],
        goal: CurvePoint | None,
    ) -> str:
        """Append points of a curve to the first, and special ones; return why it ends."""
        begun, length = points[0], _FIRST
        while len(points) <= most:
            point = points[-1]
            new = self.correct(point, length)
            if new is None or new.tangent @ point.tangent < 0.9:
                length *= 0.5
                if length < _SHORTEST:
                    at_end = self._border(point, _AT_END) is not None
                    return "end of range" if at_end else self._reason(point)
                continue
            border = self._border(new)
            if border is not None and self._border(point, _AT_END) is not None:
                return "end of range"  # it began there
            if border is not None:
                end = self._at_border(point, new, *border)
                if end is None:
                    length *= 0.5
                    if length < _SHORTEST:
                        return "lost"
                    continue
                specials += self._specials(point, end)
                on_point(end)
                points.append(end)
                return "end of range"
            if why := self.condition.obstacle(new.solution):
                length *= 0.5
                if length < _CLOSE:
                    return why
                continue
            new_specials = self._specials(point, new)
            merge = self._merge_between(point, new)
            if merge is not None:
                points.append(merge)
                return "merges"
            specials += new_specials
            points.append(self._resized(new))
            on_point(new)
            length = min(1.5 * length, _LONGEST)
            returns = len(points) > 10 and _meets(new, begun, length) > 0.5
            if returns or (goal is not None and _meets(new, goal, length) < -0.5):
                return "closed"
        return "point limit"

    def _resized(self, point: CurvePoint) -> CurvePoint:
        """Return a point in units that become those of the condition: the size of its motion."""
        condition, old, units = self.condition, point.measure, self.condition.units
        new = condition.size_of(point.solution)
        if np.all((new > 0.5 * old) & (new < 2.0 * old)):
            return point
        condition.measure = new
        change = units / condition.units
        unknowns = point.unknowns * change
        solution = condition.at(unknowns)
        found = None if solution is None else self._point(unknowns, solution)
        if found is None:
            condition.measure = old
            return point
        return self._toward(found, point.tangent * change)

    def _merge_between(self, old: CurvePoint, new: CurvePoint) -> CurvePoint | None:
        """Return the point between two neighbours at which a motion gains a symmetry, or None.

        It is then the one from which the curve's motions split, and behind it are their images: how
        far a motion is from such an image passes through zero. It may turn round without doing so,
        where an impact falls on the instant at which they are compared.
        """
        reach = float(old.tangent @ (new.unknowns - old.unknowns))
        before = self.condition.images(old.solution)
        after = self.condition.images(new.solution)
        for i, (here, there) in enumerate(zip(before, after, strict=True)):
            if np.linalg.norm(here) < _MERGED or not float(here @ there) < 0.0:
                continue

            def value(point: CurvePoint, i: int = i, here: Floats = here) -> float:
                return float(self.condition.images(point.solution)[i] @ here)

            change = there - here
            between = self.correct(old, -reach * float(here @ change) / float(change @ change))
            if between is not None:
                gap = self.condition.images(between.solution)[i]
                if np.linalg.norm(gap) > _TURNED * max(np.linalg.norm(here), np.linalg.norm(there)):
                    continue
            point = self._zero(value, old, new, reach)
            if np.linalg.norm(self.condition.images(point.solution)[i]) < _MERGED:
                return point
        return None

    def _reason(self, point: CurvePoint) -> str:
        """Return what happens just beyond the end of a curve."""
        for length in _BEYOND:
            beyond = self.condition.at(point.unknowns + length * point.tangent)
            if beyond is None:
                return "lost"
            if why := self.condition.obstacle(beyond):
                return why
            if beyond.passage.impacts != point.solution.passage.impacts:
                return "grazing"
        return "lost"

    def correct(self, point: CurvePoint, length: float) -> CurvePoint | None:
        """Return the point of the curve at a distance along the tangent, or None."""
        guess = point.unknowns + length * point.tangent
        return self._solved(point, guess, point.tangent)

    def _solved(self, point: CurvePoint, guess: Floats, row: Floats) -> CurvePoint | None:
        """Return the point of the curve whose distance to a guess is across a direction, or None.

        Newton's method with the matrix of the last point, improved after each trial (Broyden 1965).
        """
        unknowns, solution = guess, self.condition.at(guess)
        bordered, is_polished = np.vstack([point.matrix, row]), False
        for _ in range(_TRIALS):
            if solution is None or not np.all(np.isfinite(solution.residual)):
                return None
            residual = np.append(solution.residual, row @ (unknowns - guess))
            is_solved = np.linalg.norm(residual) <= self._limit(solution)
            if is_solved and (is_polished or not residual.any()):
                found = self._point(unknowns, solution)
                return None if found is None else self._toward(found, point.tangent)
            is_polished = bool(is_solved)
            move = np.linalg.solve(bordered, -residual)
            size = float(np.linalg.norm(move))
            if size > 10.0 * _LONGEST:
                return None
            unknowns = unknowns + move
            solution = self.condition.at(unknowns)
            if solution is not None:
                left = np.append(solution.residual, row @ (unknowns - guess))
                bordered = bordered + np.outer(left, move) / size**2
        return None

    def _point(self, unknowns: Floats, solution: Solution) -> CurvePoint | None:
        """Return a point with its matrix, direction and tests."""
        self.condition.settle(solution)
        matrix = self._matrix(unknowns, solution)
        if matrix is None:
            return None
        tangent = np.linalg.svd(matrix)[2][-1]
        tests, measure = self.condition.tests(solution), self.condition.measure
        return CurvePoint(unknowns, measure, solution, matrix, tangent, tests)

    def _toward(self, point: CurvePoint, like: Floats) -> CurvePoint:
        """Return a point whose tangent points like a direction."""
        if point.tangent @ like >= 0.0:
            return point
        return replace(point, tangent=-point.tangent)

    def _matrix(self, unknowns: Floats, solution: Solution) -> Floats | None:
        """Return the derivatives of the equations, by differences to one side."""
        columns = []
        for direction in np.eye(len(unknowns)):
            for width in (_DIFFERENCE, -_DIFFERENCE):
                beside = self.condition.at(unknowns + width * direction)
                if beside is not None:
                    break
            if beside is None:
                return None
            columns.append((beside.residual - solution.residual) / width)
        matrix = np.array(columns).T
        return matrix if np.all(np.isfinite(matrix)) else None

    def _border(self, point: CurvePoint, nearness: float = 0.0) -> tuple[int, float] | None:
        """Return which parameter is outside its range by most, and the end that it passed.

        Being inside by less than `nearness` counts too.
        """
        values = point.unknowns[-2:]
        beyond = np.maximum(self.low - values, values - self.high)
        which = int(np.argmax(beyond))
        if beyond[which] <= -nearness:
            return None
        middle = 0.5 * (self.low[which] + self.high[which])
        return which, float(self.low[which] if values[which] < middle else self.high[which])

    def _at_border(
        self, old: CurvePoint, new: CurvePoint, which: int, end: float
    ) -> CurvePoint | None:
        """Return the point at which a parameter reaches the end of its range."""
        row = np.zeros(len(old.unknowns))
        row[which - 2] = 1.0
        begun, gone = old.unknowns[which - 2], new.unknowns[which - 2]
        share = (end - begun) / (gone - begun)
        guess = old.unknowns + share * (new.unknowns - old.unknowns)
        guess[which - 2] = end
        return self._solved(old, guess, row)

    def _specials(self, old: CurvePoint, new: CurvePoint) -> list[Special]:
        """Return the points of codimension two between two neighbours."""
        found = []
        reach = float(old.tangent @ (new.unknowns - old.unknowns))
        for kind in (*old.tests, "cusp"):

            def value(point: CurvePoint, kind: str = kind) -> float:
                # At a cusp both parameters turn back.
                back = float(point.tangent[-2:] @ old.tangent[-2:])
                return back if kind == "cusp" else point.tests[kind]

            before, after = value(old), value(new)
            is_rounding = max(abs(before), abs(after)) < _ROUNDING
            if not before * after < 0.0 or is_rounding:
                continue
            there = self._zero(value, old, new, reach)
            if abs(value(there)) < _SMALLER * max(abs(before), abs(after)):
                found.append(Special(kind, there))
        return found

    def _zero(
        self, value: Callable[[CurvePoint], float], old: CurvePoint, new: CurvePoint, reach: float
    ) -> CurvePoint:
        """Return the point between two neighbours at which a function is nearest to zero."""
        located = {0.0: old, reach: new}

        def at(length: float) -> float:
            if length not in located:
                point = self.correct(old, length)
                if point is None:
                    raise ArithmeticError
                located[length] = point
            return value(located[length])

        # Where branches meet Newton's method may fail: the nearest point will do.
        with suppress(ArithmeticError):
            brentq(at, 0.0, reach, xtol=1e-9)
        return min(located.values(), key=lambda point: abs(value(point)))

    def _limit(self, solution: Solution) -> float:
        """Return how well equations can be solved: a motion enlarges errors, of rounding too."""
        enlarged = max(1.0, float(np.linalg.norm(solution.matrix)))
        return enlarged * _SOLVED + _ROUNDED / float(self.condition.measure[0])


def _meets(new: CurvePoint, old: CurvePoint, length: float) -> float:
    """Return the cosine between the directions of two points within a step of each other, or 0."""
    if not np.array_equal(new.measure, old.measure):
        return 0.0
    if np.linalg.norm(new.unknowns - old.unknowns) > 0.75 * length:
        return 0.0
    return float(new.tangent @ old.tangent)
