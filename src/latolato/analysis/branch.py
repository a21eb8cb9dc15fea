"""One branch of periodic motions: its points, Newton's method along it, and its special points."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from latolato.analysis.flow import Floats, Flow, drive_period, varied
from latolato.analysis.orbits import CLOSED, Orbit, confined, find_orbit, gap_of, scale_of
from latolato.core.errors import InputError
from latolato.observables.period import wrapped
from latolato.physics.contacts import REST
from latolato.physics.pendulum import BallPair

KINDS = (
    "fold", "period_doubling", "symmetry_breaking", "branch_point", "torus", "grazing", "lift_off",
    "rest_ends", "slackens",
)  # fmt: skip
_TESTS = ("fold", "period_doubling", "crossing", "torus")
_MARKS = ("grazing", "lift_off", "rest_ends")
# The longest step along the branch, in units of the range of the parameter and of radians.
LONGEST_STEP = 2e-2
BISECTIONS = 60
_NEWTON = 8
# Beside a wall steps are cut, and the map jumps by the error of a step: this much is enough then.
_CLOSE = 1e-9
_ROUNDING = 1e-15  # of angles, which small hops do not get below
_DIFFERENCE = 1e-6  # of the parameter's range, for its derivative
# Where, beyond the end of a branch, the reason is searched for, in lengths of steps.
_BEYOND = (1e-6, 1e-5, 1e-4, 1e-3)
# Steps are as long for motions of this share of a radian and more; smaller bounces set the unit.
_SMALL = 0.1
# Orbits that differ by less than this, in the branch's units, are one.
_SAME = 1e-6
# An orbit behind a turning point lies so near to the image of one before it, if it is that image.
_MEETS = 1e-3


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
    """

    orbit: Orbit
    value: float
    tangent: Floats
    shift: float

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
            "crossing": float(np.linalg.det(matrix - unit)),
            "torus": float(np.max(np.where(turning, moduli, 0.0), initial=0.0)) - 1.0,
        }

    def step_from(self, other: Place, scale: Floats) -> float:
        """Return how far this point lies along the tangent of another one, in a branch's units."""
        gap = np.append(self.orbit.start - other.orbit.start, self.value - other.value)
        return float(other.tangent @ (gap / scale))

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
        # Units of state and parameter.
        self.scale = np.append(scale_of(flow.system), span[1] - span[0])
        # When orbits begin, as a share of their duration: not at an impact, where they jump.
        self.shift = 0.0

    def at(self, value: float) -> tuple[Flow, float]:
        """Return the flow at a value of the parameter, and the duration of the orbit."""
        system, drive = varied(self.flow.system, self.flow.drive, self.parameter, value)
        turned: Any = drive
        phase = math.fmod(turned.drive_phase + math.tau * self.period * self.shift, math.tau)
        drive = replace(turned, drive_phase=phase)
        flow = replace(self.flow, system=system, drive=drive)
        return flow, self.period * drive_period(drive)

    def place(self, orbit: Orbit, value: float, like: Floats) -> Place:
        """Return a point of the branch that points like a vector."""
        matrix = (orbit.passage.matrix - np.eye(orbit.flow.size)) * self.scale[:-1]
        matrix /= self.scale[:-1, None]
        system = np.column_stack([matrix, self.slope(orbit.start, value, orbit.turns)])
        rows = np.linalg.svd(system)[2]
        tangent: Floats = rows[-1] if rows[-1] @ like >= 0.0 else -rows[-1]
        return Place(orbit, value, tangent, self.shift)

    def rescaled(self, place: Place, least: Floats | float = 0.0) -> Place:
        """Return a point in units that become those of the branch: the size of its orbit.

        Bouncing balls may hop by any fraction of a radian. `least` keeps units from shrinking
        along a branch, which may lead to a motion of size zero; others begin in natural units.
        """
        orbit, scale = place.orbit, self.scale.copy()
        scale[:-1] = scale_of(self.flow.system)
        if orbit.passage.impacts and not orbit.rests:
            impacts = orbit.passage.contact_kinds < REST
            times = np.sort(orbit.passage.contact_times[impacts])
            flight = float(np.diff(np.append(times, times[0] + orbit.duration)).max())
            speed = float(np.abs(orbit.passage.contact_values[:, impacts]).max())
            size = np.tile([0.25 * speed * flight, speed], self.flow.system.angles)
            scale[:-1] = np.minimum(scale[:-1], np.maximum(size / _SMALL, least))
        change = scale / self.scale
        if change.min() > 0.5 and change.max() < 2.0:
            return place
        self.scale = scale
        return self.place(orbit, place.value, place.tangent / change)

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

    def leaving(self, place: Place) -> Place:
        """Return a special point with the direction in which another branch leaves.

        That is the eigenvector of the multiplier one; the parameter changes in second order only.
        """
        scale = self.scale[:-1]
        values, vectors = np.linalg.eig(place.orbit.passage.matrix * scale / scale[:, None])
        direction = np.real(vectors[:, np.argmin(np.abs(values - 1.0))])
        return replace(place, tangent=np.append(direction / np.linalg.norm(direction), 0.0))

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

        Central, or to one side where the parameter cannot be larger or smaller, or where another
        contact appears on the other side.
        """
        shares, gaps, words = [], [], []
        for share in (1.0, -1.0, 0.0):
            try:
                flow, duration = self.at(value + share * _DIFFERENCE * self.scale[-1])
            except InputError:
                continue
            x = confined(flow, start)
            passage = flow.follow(x, duration)
            shares.append(share)
            gaps.append(gap_of(x, passage.end, turns))
            words.append(passage.contact_kinds.tolist())
            if len(gaps) == 2 and words[0] == words[1]:
                break
        first = next((i for i, word in enumerate(words[:-1]) if word == words[-1]), 0)
        slope = (gaps[first] - gaps[-1]) / ((shares[first] - shares[-1]) * _DIFFERENCE)
        return np.asarray(slope / self.scale[:-1])

    def correct(self, place: Place, length: float) -> Place | None:
        """Return the point of the branch at a distance along the tangent, or None."""
        begin = np.append(place.orbit.start, place.value) / self.scale
        guess = begin + length * place.tangent
        point, column = guess, None
        turns = place.orbit.turns
        closed = 0.5 * CLOSED + _ROUNDING / float(self.scale.min())
        for trial in range(_NEWTON):
            value = float(point[-1] * self.scale[-1])
            try:
                flow, duration = self.at(value)
            except InputError:  # beyond what the parameter may be
                return None
            x = confined(flow, point[:-1] * self.scale[:-1])
            passage = flow.follow(x, duration)
            gap = gap_of(x, passage.end, turns)
            residual = np.append(gap / self.scale[:-1], place.tangent @ (point - guess))
            size = float(np.linalg.norm(residual))
            if not passage.is_complete or not math.isfinite(size):
                return None
            if size <= (closed if trial < _NEWTON - 1 else max(closed, _CLOSE)):
                defect = float(np.linalg.norm(gap / scale_of(flow.system)))
                orbit = Orbit(flow, x, passage, duration, turns, defect)
                return self.place(orbit, value, place.tangent)
            if column is None:
                column = self.slope(x, value, turns)
            matrix = (passage.matrix - np.eye(flow.size)) * self.scale[:-1] / self.scale[:-1, None]
            bordered = np.vstack([np.column_stack([matrix, column]), place.tangent])
            try:
                move = np.linalg.solve(bordered, -residual)
            except np.linalg.LinAlgError:
                return None
            if np.linalg.norm(move) > 10.0 * LONGEST_STEP:
                return None
            point = point + move
        return None

    def specials(self, old: Place, new: Place, length: float) -> list[tuple[str, Place]]:
        """Return the special points between two neighbours, located along the branch."""
        result = []
        before, after = old.tests, new.tests
        both_move = not (old.orbit.rests or new.orbit.rests)
        if both_move and old.marks == new.marks:
            for kind in _TESTS:
                # At a fold a multiplier is one as well: that is no other branch.
                if kind == "crossing" and before["fold"] * after["fold"] < 0.0:
                    continue
                if before[kind] * after[kind] < 0.0:
                    if kind == "torus" and min(before[kind], after[kind]) == -1.0:
                        continue  # two real multipliers meet: nothing crosses the unit circle
                    there = self._locate(old, new, length, _sign_of(kind, before))
                    if kind == "fold" and (met := self._image_met(old, new, there)):
                        result.append((met, self._vertex(old, new, length, there)))
                    elif kind == "crossing":
                        result.append((self._broken(old.orbit, there.orbit), there))
                    else:
                        result.append((kind, there))
        elif before["fold"] * after["fold"] < 0.0:
            result.append(("fold", self._locate(old, new, length, _sign_of("fold", before))))
        return result + [
            (kind, self._locate(old, new, length, _same(kind, old)))
            for kind in _MARKS
            if old.marks[kind] != new.marks[kind] and (kind != "grazing" or both_move)
        ]

    def jumps(self, old: Place, new: Place, length: float) -> bool:
        """Whether two neighbours with different impacts do not meet at the graze between them.

        Motions that differ by one slow impact are so alike that a step can end on another branch.
        """
        if old.orbit.rests or new.orbit.rests or old.marks["grazing"] == new.marks["grazing"]:
            return False
        graze = self._locate(old, new, length, _same("grazing", old))
        before = self.correct(old, graze.step_from(old, self.scale) - _SAME)
        if before is None or before.marks["grazing"] != old.marks["grazing"]:
            return True
        gap = np.append(graze.orbit.start - before.orbit.start, graze.value - before.value)
        return float(np.linalg.norm(gap / self.scale)) > 10.0 * _SAME

    def until_slack(self, old: Place, new: Place, length: float) -> Place:
        """Return the point between two neighbours beyond which a string goes slack."""
        return self._locate(old, new, length, lambda place: not place.orbit.slackens)

    def _images(self, orbit: Orbit) -> Iterator[tuple[str, Floats, Floats]]:
        """Yield the kind, the state and the linearised map of each image of an orbit.

        An image is the motion seen in a mirror, or a number of drive periods later, or both.
        """
        period = orbit.duration / self.period
        unit = np.eye(orbit.flow.size)
        for mirror in (*mirrors_of(orbit.flow), unit):
            kind = "period_doubling" if mirror is unit else "symmetry_breaking"
            for count in range(1 if mirror is unit else 0, self.period):
                end, matrix = orbit.start, unit
                if count:
                    passage = orbit.flow.follow(orbit.start, count * period)
                    end, matrix = passage.end, passage.matrix
                gap = mirror @ end - orbit.start
                gap[0::2] = wrapped(gap[0::2])
                yield kind, orbit.start + gap, mirror @ matrix

    def _broken(self, old: Orbit, there: Orbit) -> str:
        """Return the kind of event where a multiplier is one and the branch goes on.

        An image that equals the motion itself is a symmetry. It is lost if the eigenvector, along
        which the other branch leaves, changes its sign under it.
        """
        values, vectors = np.linalg.eig(there.passage.matrix)
        scale = self.scale[:-1]
        leaving = np.real(vectors[:, np.argmin(np.abs(values - 1.0))]) / scale
        for (kind, image, _), (_, _, matrix) in zip(
            self._images(old), self._images(there), strict=True
        ):
            moved = (matrix @ (leaving * scale)) / scale
            is_own = np.linalg.norm((image - old.start) / scale) < _SAME
            if is_own and np.linalg.norm(moved + leaving) < np.linalg.norm(moved - leaving):
                return kind
        return "branch_point"

    def _image_met(self, old: Place, new: Place, there: Place) -> str | None:
        """Return the event where the branch turns round into images of itself, or None.

        In a pitchfork the orbits behind the turning point are images of those before it; at a fold
        they are other motions.
        """
        near, far = sorted((old, new), key=lambda place: abs(place.value - there.value))
        here = np.append(near.orbit.start, near.value) / self.scale
        origin = np.append(far.orbit.start, far.value) / self.scale
        for kind, image, _ in self._images(far.orbit):
            point = np.append(image, far.value) / self.scale
            apart = float(np.linalg.norm(point - origin))
            if apart < 0.1 * np.linalg.norm(here - origin):
                continue  # the orbit's own symmetry
            behind = self.correct(near, float(near.tangent @ (point - here)))
            if behind is not None:
                end = np.append(behind.orbit.start, behind.value) / self.scale
                if np.linalg.norm(end - point) < _MEETS * apart:
                    return kind
        return None

    def obstacles(self, place: Place) -> list[tuple[str, Place]]:
        """Return which contact appears or vanishes just beyond the end of a branch."""
        here = np.append(place.orbit.start, place.value) / self.scale
        for length in _BEYOND:
            beyond = (here + length * place.tangent) * self.scale
            try:
                flow, duration = self.at(float(beyond[-1]))
            except InputError:  # beyond what the parameter may be
                return []
            passage = flow.follow(confined(flow, beyond[:-1]), duration)
            marks = replace(place, orbit=replace(place.orbit, passage=passage)).marks
            for kind in _MARKS:
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
        """Return the first point where a condition no longer holds, by bisection."""
        low, high, place = 0.0, length, new
        for _ in range(BISECTIONS):
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


def mirrors_of(flow: Flow) -> list[Floats]:
    """Return the matrices that turn every motion into another one, its mirror image.

    Angles count modulo 2 pi. Walls at one side, as those of a `LatoLato`, leave no mirror.
    """
    unit = np.eye(flow.size)
    has_walls = math.isfinite(flow.walls[0])
    system = flow.system
    if not isinstance(system, BallPair):
        return [] if has_walls else [-unit]
    result = [-unit]
    if not has_walls:
        one = np.diag([-1.0, -1.0, 1.0, 1.0])
        result += [one, -one]
    if system.right == system.left:
        exchanged = np.roll(unit, 2, axis=0)
        result += [-exchanged, exchanged]
    return result


def _sign_of(kind: str, before: dict[str, float]) -> Callable[[Place], bool]:
    """Return whether a test function still has its sign."""
    return lambda place: place.tests[kind] * before[kind] > 0.0


def _same(kind: str, old: Place) -> Callable[[Place], bool]:
    """Return whether a whole number is still the same."""
    return lambda place: place.marks[kind] == old.marks[kind]
