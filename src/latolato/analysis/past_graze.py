"""The way of a branch past a graze, to the motion with one impact more or one less.

At a graze the map over a period has a square root, so Newton's method fails there. Begun at the
graze itself the motion is smooth in another unknown beside the parameter: the speed of the new
impact, or the distance at which the former one is missed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from latolato.analysis.branch import Branch, Place
from latolato.analysis.conditions import Plane, Touch
from latolato.analysis.curve import Curve
from latolato.analysis.flow import Floats, Flow
from latolato.analysis.orbits import CLOSED, find_orbit
from latolato.physics.contacts import REST
from latolato.physics.pendulum import System

_SAMPLES = 4000
# How fast a new impact is, or how far a former one is missed, when the branch goes on with ordinary
# steps: in natural units, as shares of the motion's size; the largest that can be reached is taken.
_ENOUGH = (0.1, 0.03, 0.01, 0.003)
_POINTS = 60


@dataclass(frozen=True)
class Line(Plane):
    """One parameter of a system under a drive, and how fast or how far a contact is."""

    def at(self, values: Floats, turn: float = 0.0) -> Flow:
        """Return the motion at other values; the second one is not of the system."""
        return super().at(values[:1], turn)


class Contact(Touch):
    """A motion begun at a slow impact, or at the instant at which one is missed.

    Unknowns are the drive's phase there, the parameter, and the closing speed or the distance; of
    two balls also the left one's angle and the mean angular velocity that an impact leaves alone.
    """

    def __init__(self, plane: Plane, periods: int, wall: int, *, is_hit: bool) -> None:
        super().__init__(plane, "grazing", periods, wall=wall)
        self.is_hit = is_hit

    def ends(self, free: Floats, flow: Flow, values: Floats) -> tuple[Floats, Floats]:
        """Return the states after and before the contact."""
        system: Any = flow.system
        wall, sign = flow.walls[self.wall], 1.0 if self.wall == 0 else -1.0
        if not self.is_hit:
            state = _apart(system, free, wall + sign * values[1], 0.0)
            return state, state
        speed = sign * float(values[1])
        after = _apart(system, free, wall, system.restitution * speed)
        return after, _apart(system, free, wall, -speed)

    def tests(self, solution: Any) -> dict[str, float]:
        """Return nothing: special points are looked for along the branch."""
        return {}


def _apart(system: System, free: Floats, separation: float, opening: float) -> Floats:
    """Return the state at which balls are so far apart [rad] and separate so fast [rad/s]."""
    if system.angles == 1:
        return np.array([separation, opening])
    angle, mean = free
    share = _share(system)
    return np.array(
        [angle + separation, mean + (1.0 - share) * opening, angle, mean - share * opening]
    )


def _share(system: System) -> float:
    """Return the right ball's share of the inertia of both."""
    right, left = (ball.mass * ball.length**2 for ball in system.balls)
    return right / (right + left)


def past_graze(branch: Branch, place: Place) -> Place | None:
    """Return a point of a branch beyond the graze at which it ended, or None."""
    orbit = place.orbit
    if not math.isfinite(orbit.flow.walls[0]) or orbit.rests:
        return None
    near = _nearest(orbit.flow, orbit.start, orbit.duration)
    if near is None:
        return None
    time, wall, was_hit = near
    size = max(orbit.passage.largest_angle, 1e-6) * orbit.flow.system.natural_frequency
    for share in _ENOUGH:
        enough = share * size / (orbit.flow.system.natural_frequency if was_hit else 1.0)
        # The motion that is not begun at the graze is looked for on the other side of it.
        beyond = _beyond(branch, place, time, wall, is_hit=not was_hit, enough=enough)
        if beyond is not None:
            return beyond
    return None


def _nearest(flow: Flow, start: Floats, duration: float) -> tuple[float, int, bool] | None:
    """Return when a motion nearly grazes [s], which wall, and whether it hits it."""
    times = np.linspace(0.0, duration, _SAMPLES, endpoint=False)
    run = flow.sampled(start, times)
    angles, rate = np.atleast_2d(run["angle"]), flow.system.natural_frequency
    separation = angles[0] if flow.size == 2 else angles[0] - angles[1]
    passage = flow.follow(start, duration)
    hits = np.flatnonzero(passage.contact_kinds < REST)
    speeds = passage.contact_values
    speed = speeds[0] if flow.size == 2 else speeds[0] - speeds[1]
    found = [
        (0.5 * (float(speed[i]) / rate) ** 2, float(passage.contact_times[i]),
         int(speed[i] > 0.0), True)
        for i in hits
    ]  # fmt: skip
    for wall, gap in enumerate((separation - flow.walls[0], flow.walls[1] - separation)):
        least = (gap[1:-1] < gap[:-2]) & (gap[1:-1] <= gap[2:])
        for i in np.flatnonzero(least) + 1:
            # Beside an impact a sample is near the wall too.
            apart = np.abs(passage.contact_times[hits] - times[i]).min(initial=math.inf)
            if apart > 2.0 * times[1]:
                found.append((float(gap[i]), float(times[i]), wall, False))
    if not found:
        return None
    _, time, wall, was_hit = min(found)
    return time, wall, was_hit


def _beyond(
    branch: Branch, place: Place, time: float, wall: int, *, is_hit: bool, enough: float
) -> Place | None:
    """Return a point of the branch with a contact this fast, or missed by this much, or None."""
    flow, duration = branch.at(place.value)
    low, high = branch.span
    whole = replace(flow, drive=branch.flow.drive)  # of which the phase at time zero is meant
    plane = Line(whole, (branch.parameter,), np.array([low, 0.0]), np.array([high, enough]))  # type: ignore[arg-type]
    condition = Contact(plane, branch.period, wall, is_hit=is_hit)
    drive: Any = flow.drive
    turn = math.tau * branch.period * place.shift + drive.drive_frequency * time
    state = flow.follow(place.orbit.start, time).end if time > 0.0 else place.orbit.start.copy()
    if flow.size == 4:
        state[3] += _share(flow.system) * (state[1] - state[3])
    guess = condition.begin(state, turn, np.array([place.value, 0.0]))
    if guess is None:
        return None
    curve = Curve(condition)
    # Without speed and distance it is the graze; to the other side of it both grow.
    fixed = np.append(np.zeros(len(guess) - 1), 1.0)
    first = curve.at_value(guess, fixed)
    if first is None:
        return None
    way = 1.0 if first.tangent[-1] >= 0.0 else -1.0
    points, _, _ = curve.follow(first, way, _POINTS, lambda _: None)
    end = next((p for p in points if p.unknowns[-1] * enough >= 0.999 * enough), None)
    if end is None:
        return None
    solution = end.solution
    free = 0.5 * duration * min(1.0, 2.0 * condition.flight)
    middle = solution.flow.follow(solution.start, free).end
    old = branch.shift
    branch.shift = (
        math.fmod(
            solution.turn / (math.tau * branch.period) + free / condition.duration(solution.flow),
            1.0,
        )
        % 1.0
    )
    value = float(solution.values[0])
    begun, _ = branch.at(value)
    orbit = find_orbit(begun, middle, branch.period, settles=False)
    change = 1 if is_hit else -1
    if orbit.defect > CLOSED or orbit.passage.impacts != place.orbit.passage.impacts + change:
        branch.shift = old
        return None
    like = np.zeros(orbit.flow.size + 1)
    like[-1] = math.copysign(1.0, value - place.value)
    return branch.rescaled(branch.place(orbit, value, like))
