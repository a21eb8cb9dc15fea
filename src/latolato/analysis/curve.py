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


@dataclass(frozen=True)
class Place:
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
    place: Place


class Curve:
    """Follows one curve; made by `bifurcation_curve`."""

    def __init__(self, condition: Condition) -> None:
        self.condition = condition
        plane = condition.plane
        self.low, self.high = plane.low / plane.width, plane.high / plane.width

    def begin(self, guess: Floats) -> Place | None:
        """Return the point of the curve nearest to a guess, or None."""
        unknowns, solution = guess, self.condition.at(guess)
        for _ in range(2 * _TRIALS):
            if solution is None:
                return None
            if np.linalg.norm(solution.missed) <= self._limit(solution):
                self.condition.settle(solution)
                again = self.condition.at(unknowns)
                place = None if again is None else self._place(unknowns, again)
                return None if place is None else self._inside(place)
            matrix = self._matrix(unknowns, solution)
            if matrix is None:
                return None
            move = np.linalg.lstsq(matrix, -solution.missed, rcond=1e-12)[0]
            size = float(np.linalg.norm(move))
            if size == 0.0:
                return None
            unknowns = unknowns + move * min(1.0, _MOVE / size)
            if np.linalg.norm(unknowns - guess) > _REACH:
                return None
            solution = self.condition.at(unknowns)
        return None

    def _inside(self, place: Place) -> Place | None:
        """Return a point, or where the curve enters the range if it lies beyond."""
        border = self._border(place)
        if border is None:
            return place
        which, end = border
        row = np.zeros(len(place.unknowns))
        row[which - 2] = 1.0
        guess = place.unknowns.copy()
        guess[which - 2] = end
        return self._solved(place, guess, row)

    def at_value(self, guess: Floats, row: Floats) -> Place | None:
        """Return the point of the curve whose distance to a guess is across a direction, or None.

        Unlike along the curve, nothing is known of it yet.
        """
        solution = self.condition.at(guess)
        place = None if solution is None else self._place(guess, solution)
        return None if place is None else self._solved(place, guess, row)

    def is_singular(self, place: Place) -> bool:
        """Whether the equations leave more than one direction free."""
        sizes = np.linalg.svd(place.matrix, compute_uv=False)
        return bool(sizes[-1] < _SINGULAR * max(1.0, sizes[0]))

    def follow(
        self,
        first: Place,
        way: float,
        most: int,
        is_seen: Callable[[Place], None],
        goal: Place | None = None,
    ) -> tuple[list[Place], list[Special], str]:
        """Return points of the curve after the first, what is special among them, and its end.

        Parameters
        ----------
        way : float
            One along the tangent of the first point, minus one against it.
        most : int
            Most points.
        is_seen : callable
            Called with each point.
        goal : Place, optional
            Where the other way stopped: a curve that comes there from beyond is closed.
        """
        self.condition.measure = first.measure
        self.condition.settle(first.solution)
        begun = self._toward(first, way * first.tangent)
        places: list[Place] = [begun]
        specials: list[Special] = []
        try:
            reason = self._follow(places, specials, most, is_seen, goal)
        except KeyboardInterrupt:
            reason = "interrupted"
        return places[1:], specials, reason

    def _follow(
        self,
        places: list[Place],
        specials: list[Special],
        most: int,
        is_seen: Callable[[Place], None],
        goal: Place | None,
    ) -> str:
        """Append points of a curve to the first, and special ones; return why it ends."""
        begun, length = places[0], _FIRST
        while len(places) <= most:
            place = places[-1]
            new = self.correct(place, length)
            if new is None or new.tangent @ place.tangent < 0.9:
                length *= 0.5
                if length < _SHORTEST:
                    at_end = self._border(place, _AT_END) is not None
                    return "end of range" if at_end else self._reason(place)
                continue
            border = self._border(new)
            if border is not None and self._border(place, _AT_END) is not None:
                return "end of range"  # it began there
            if border is not None:
                end = self._at_border(place, new, *border)
                if end is None:
                    length *= 0.5
                    if length < _SHORTEST:
                        return "lost"
                    continue
                specials += self._specials(place, end)
                is_seen(end)
                places.append(end)
                return "end of range"
            if why := self.condition.obstacle(new.solution):
                length *= 0.5
                if length < _CLOSE:
                    return why
                continue
            met = self._specials(place, new)
            merged = self._merged(place, new)
            if merged is not None:
                places.append(merged)
                return "merges"
            specials += met
            places.append(self._resized(new))
            is_seen(new)
            length = min(1.5 * length, _LONGEST)
            returns = len(places) > 10 and _meets(new, begun, length) > 0.5
            if returns or (goal is not None and _meets(new, goal, length) < -0.5):
                return "closed"
        return "points"

    def _resized(self, place: Place) -> Place:
        """Return a point in units that become those of the condition: the size of its motion."""
        condition, old, units = self.condition, place.measure, self.condition.units
        new = condition.size_of(place.solution)
        if np.all((new > 0.5 * old) & (new < 2.0 * old)):
            return place
        condition.measure = new
        change = units / condition.units
        unknowns = place.unknowns * change
        solution = condition.at(unknowns)
        found = None if solution is None else self._place(unknowns, solution)
        if found is None:
            condition.measure = old
            return place
        return self._toward(found, place.tangent * change)

    def _merged(self, old: Place, new: Place) -> Place | None:
        """Return the point between two neighbours at which a motion gains a symmetry, or None.

        It is then the one from which the curve's motions split, and behind it are their images: how
        far a motion is from such an image passes through zero.
        """
        reach = float(old.tangent @ (new.unknowns - old.unknowns))
        before = self.condition.images(old.solution)
        after = self.condition.images(new.solution)
        for i, (here, there) in enumerate(zip(before, after, strict=True)):
            if np.linalg.norm(here) < _MERGED or not float(here @ there) < 0.0:
                continue

            def value(place: Place, i: int = i, here: Floats = here) -> float:
                return float(self.condition.images(place.solution)[i] @ here)

            place = self._zero(value, old, new, reach)
            if np.linalg.norm(self.condition.images(place.solution)[i]) < _MERGED:
                return place
        return None

    def _reason(self, place: Place) -> str:
        """Return what happens just beyond the end of a curve."""
        for length in _BEYOND:
            beyond = self.condition.at(place.unknowns + length * place.tangent)
            if beyond is None:
                return "lost"
            if why := self.condition.obstacle(beyond):
                return why
            if beyond.passage.impacts != place.solution.passage.impacts:
                return "grazing"
        return "lost"

    def correct(self, place: Place, length: float) -> Place | None:
        """Return the point of the curve at a distance along the tangent, or None."""
        guess = place.unknowns + length * place.tangent
        return self._solved(place, guess, place.tangent)

    def _solved(self, place: Place, guess: Floats, row: Floats) -> Place | None:
        """Return the point of the curve whose distance to a guess is across a direction, or None.

        Newton's method with the matrix of the last point, improved after each trial (Broyden 1965).
        """
        unknowns, solution = guess, self.condition.at(guess)
        bordered, is_polished = np.vstack([place.matrix, row]), False
        for _ in range(_TRIALS):
            if solution is None or not np.all(np.isfinite(solution.missed)):
                return None
            missed = np.append(solution.missed, row @ (unknowns - guess))
            is_solved = np.linalg.norm(missed) <= self._limit(solution)
            if is_solved and (is_polished or not missed.any()):
                found = self._place(unknowns, solution)
                return None if found is None else self._toward(found, place.tangent)
            is_polished = bool(is_solved)
            move = np.linalg.solve(bordered, -missed)
            size = float(np.linalg.norm(move))
            if size > 10.0 * _LONGEST:
                return None
            unknowns = unknowns + move
            solution = self.condition.at(unknowns)
            if solution is not None:
                left = np.append(solution.missed, row @ (unknowns - guess))
                bordered = bordered + np.outer(left, move) / size**2
        return None

    def _place(self, unknowns: Floats, solution: Solution) -> Place | None:
        """Return a point with its matrix, direction and tests."""
        self.condition.settle(solution)
        matrix = self._matrix(unknowns, solution)
        if matrix is None:
            return None
        tangent = np.linalg.svd(matrix)[2][-1]
        tests, measure = self.condition.tests(solution), self.condition.measure
        return Place(unknowns, measure, solution, matrix, tangent, tests)

    def _toward(self, place: Place, like: Floats) -> Place:
        """Return a point whose tangent points like a direction."""
        if place.tangent @ like >= 0.0:
            return place
        return replace(place, tangent=-place.tangent)

    def _matrix(self, unknowns: Floats, solution: Solution) -> Floats | None:
        """Return the derivatives of the equations, by differences to one side."""
        columns = []
        for direction in np.eye(len(unknowns)):
            for width in (_DIFFERENCE, -_DIFFERENCE):
                moved = self.condition.at(unknowns + width * direction)
                if moved is not None:
                    break
            if moved is None:
                return None
            columns.append((moved.missed - solution.missed) / width)
        matrix = np.array(columns).T
        return matrix if np.all(np.isfinite(matrix)) else None

    def _border(self, place: Place, nearness: float = 0.0) -> tuple[int, float] | None:
        """Return which parameter is outside its range by most, and the end that it passed.

        Being inside by less than `nearness` counts too.
        """
        values = place.unknowns[-2:]
        beyond = np.maximum(self.low - values, values - self.high)
        which = int(np.argmax(beyond))
        if beyond[which] <= -nearness:
            return None
        middle = 0.5 * (self.low[which] + self.high[which])
        return which, float(self.low[which] if values[which] < middle else self.high[which])

    def _at_border(self, old: Place, new: Place, which: int, end: float) -> Place | None:
        """Return the point at which a parameter reaches the end of its range."""
        row = np.zeros(len(old.unknowns))
        row[which - 2] = 1.0
        begun, gone = old.unknowns[which - 2], new.unknowns[which - 2]
        share = (end - begun) / (gone - begun)
        guess = old.unknowns + share * (new.unknowns - old.unknowns)
        guess[which - 2] = end
        return self._solved(old, guess, row)

    def _specials(self, old: Place, new: Place) -> list[Special]:
        """Return the points of codimension two between two neighbours."""
        found = []
        reach = float(old.tangent @ (new.unknowns - old.unknowns))
        for kind in (*old.tests, "cusp"):

            def value(place: Place, kind: str = kind) -> float:
                # At a cusp both parameters turn back.
                back = float(place.tangent[-2:] @ old.tangent[-2:])
                return back if kind == "cusp" else place.tests[kind]

            before, after = value(old), value(new)
            is_rounding = max(abs(before), abs(after)) < _ROUNDING
            if not before * after < 0.0 or is_rounding:
                continue
            there = self._zero(value, old, new, reach)
            if abs(value(there)) < _SMALLER * max(abs(before), abs(after)):
                found.append(Special(kind, there))
        return found

    def _zero(self, value: Callable[[Place], float], old: Place, new: Place, reach: float) -> Place:
        """Return the point between two neighbours at which a function is nearest to zero."""
        located = {0.0: old, reach: new}

        def at(length: float) -> float:
            if length not in located:
                place = self.correct(old, length)
                if place is None:
                    raise ArithmeticError
                located[length] = place
            return value(located[length])

        # Where branches meet Newton's method may fail: the nearest point will do.
        with suppress(ArithmeticError):
            brentq(at, 0.0, reach, xtol=1e-9)
        return min(located.values(), key=lambda place: abs(value(place)))

    def _limit(self, solution: Solution) -> float:
        """Return how well equations can be solved: a motion enlarges errors, of rounding too."""
        enlarged = max(1.0, float(np.linalg.norm(solution.matrix)))
        return enlarged * _SOLVED + _ROUNDED / float(self.condition.measure[0])


def _meets(new: Place, old: Place, length: float) -> float:
    """Return the cosine between the directions of two points within a step of each other, or 0."""
    if not np.array_equal(new.measure, old.measure):
        return 0.0
    if np.linalg.norm(new.unknowns - old.unknowns) > 0.75 * length:
        return 0.0
    return float(new.tangent @ old.tangent)
