"""Finds periodic motions by shooting: Newton's method on the map over whole drive periods."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from latolato.analysis.flow import Floats, Flow, Passage, drive_period
from latolato.analysis.rules import broken_analysis
from latolato.core.quantities import Range
from latolato.physics.contacts import BOTTOM, RELEASE, REST, TOP
from latolato.physics.pendulum import System
from latolato.simulation.start import between_walls, checked_start

PERIODS = Range(1, 16)  # of the drive, that an orbit lasts
# An orbit closes to this [rad, and angular velocity over the natural frequency].
CLOSED = 2e-11
_MOST_TRIALS = 40
_HALVINGS = 8
# The largest change of one iteration, in the same measure.
_LARGEST_MOVE = 0.2
# Periods for which a guess without an orbit is followed before it is tried again.
_SETTLING = (40, 400)
# A guess this near to an orbit is meant to be the orbit [rad].
_MEANT = 0.01
# A run so near to an orbit has settled on it [rad]. It is followed for some of the orbit's periods:
# more of them where perturbations of the orbit die out slowly.
_SETTLED = 1e-3
_FOLLOWED = (400, 4000)
# An impact this slow, over the natural frequency, is grazing: its matrix is unlimited.
GRAZING_SPEED = 1e-5


@dataclass(frozen=True)
class Orbit:
    """A periodic motion.

    Attributes
    ----------
    start : ndarray, shape (state,)
        Angle and angular velocity of the right, then of the left ball, at time zero.
    passage : Passage
        The way back to the start, with the matrix of perturbations.
    duration : float
        Its time [s].
    turns : int
        Whole turns in that time; all balls turn alike.
    defect : float
        By how much it misses the start [1].
    """

    flow: Flow
    start: Floats
    passage: Passage
    duration: float
    turns: int
    defect: float

    @property
    def rests(self) -> bool:
        """Whether balls rest on each other at some time, so that the past is forgotten."""
        return REST in self.passage.contact_kinds or not self.passage.matrix.any()

    @property
    def slackens(self) -> bool:
        """Whether a string goes slack on the way."""
        return math.isfinite(self.passage.slack_time)

    @property
    def stays(self) -> bool:
        """Whether balls rest on each other all the time."""
        low, high = self.flow.walls
        place = self.start[0] if self.flow.size == 2 else self.start[0] - self.start[2]
        still = bool(np.all(self.start[1::2] == 0.0)) or self.flow.size == 4
        moves = np.isin(self.passage.contact_kinds, (BOTTOM, TOP, RELEASE)).any()
        return self.rests and still and not moves and min(place - low, high - place) <= 1e-12

    @property
    def slowest_impact(self) -> float:
        """Smallest closing speed of an impact [rad/s], infinite if there is none."""
        values = self.passage.contact_values[:, self.passage.contact_kinds < REST]
        closing = values[0] - values[1] if self.flow.size == 4 else values[0]
        return float(np.min(np.abs(closing), initial=math.inf))

    @property
    def multipliers(self) -> Floats:
        """Floquet multipliers, largest modulus first."""
        return multipliers_of(self.passage.matrix)


def check_taut(orbit: Orbit) -> None:
    """Raise InputError for an orbit on strings on which one goes slack."""
    if orbit.slackens:
        raise broken_analysis(
            "taut_orbit", {"time": orbit.passage.slack_time}, parameter="suspension", value="string"
        )


def multipliers_of(matrix: Floats) -> Floats:
    """Return the eigenvalues of a matrix, complex, largest modulus first."""
    result = np.linalg.eigvals(matrix).astype(complex)
    # Of two that are equally large, the one with the larger real part, then imaginary part, first.
    order = np.lexsort((-result.imag, -result.real, -np.round(np.abs(result), 12)))
    return np.asarray(result[order])


def checked_guess(flow: Flow, angle: Any, velocity: Any, offset: Any) -> Floats:
    """Return a start as one array; hanging at rest by default where nothing is in the way."""
    system = flow.system
    if angle is None and offset is None:
        if system.has_contacts and math.isfinite(flow.walls[0]):
            raise broken_analysis("first_guess", parameter="initial_angle")
        angle = 0.0 if system.angles == 1 else (0.0, 0.0)
    begun = checked_start(system, flow.contact, angle, velocity, offset)
    return np.array([x for pair in zip(begun.angles, begun.velocities, strict=True) for x in pair])


def find_orbit(flow: Flow, guess: Floats, period: int, *, settles: bool = True) -> Orbit:
    """Return the orbit of `period` drive periods near a guess, or the one it leads to.

    Its defect is above `CLOSED` if there is none.
    """
    duration = period * drive_period(flow.drive)
    orbit = shoot(flow, guess, duration)
    if orbit.defect <= CLOSED or not settles:
        return orbit
    for count in _SETTLING:
        settled = flow.follow(guess, count * duration)
        if not settled.is_complete:
            break
        later = shoot(flow, unwound(flow, settled.end), duration)
        if later.defect <= CLOSED:
            return later
    return orbit


def run_elsewhere(orbit: Orbit, guess: Floats) -> tuple[int, Floats] | None:
    """Return the drive periods and the end of the run from a guess that settles elsewhere, or None.

    None too for a run that cannot be followed, and for one that has come as near as perturbations
    of the orbit let it.
    """
    flow, distance = orbit.flow, distance_of(orbit.flow, orbit.start, guess)
    if distance <= _MEANT:
        return None
    slowest = min(float(np.abs(orbit.multipliers[0])), 1.0)
    needed = math.log(_SETTLED / distance) / math.log(slowest) if 0.0 < slowest < 1.0 else 0.0
    count = int(np.clip(needed, *_FOLLOWED))
    run = flow.follow(guess, count * orbit.duration)
    left = max(_SETTLED, 10.0 * distance * slowest**count if slowest < 1.0 else 0.0)
    period = drive_period(flow.drive)
    shifts = range(round(orbit.duration / period))
    states = (flow.follow(orbit.start, k * period).end if k else orbit.start for k in shifts)
    if not run.is_complete or any(distance_of(flow, run.end, each) <= left for each in states):
        return None
    return count * len(shifts), unwound(flow, run.end)


def distance_of(flow: Flow, one: Floats, other: Floats) -> float:
    """Return how far apart two states are [rad], angular velocities over the natural frequency.

    Whole turns do not count.
    """
    gap = (one - other) / scale_of(flow.system)
    gap[0::2] -= math.tau * np.round(gap[0::2] / math.tau)
    return float(np.linalg.norm(gap))


def shoot(flow: Flow, guess: Floats, duration: float) -> Orbit:
    """Return the result of Newton's method from a guess, closed or not."""
    scale = scale_of(flow.system)
    x = confined(flow, np.asarray(guess, dtype=np.float64))
    passage = flow.follow(x, duration)
    turns = turns_of(flow, x, passage.end)
    gap = gap_of(x, passage.end, turns)
    for _ in range(_MOST_TRIALS):
        size = float(np.linalg.norm(gap / scale))
        if not passage.is_complete or not math.isfinite(size):
            return Orbit(flow, x, passage, duration, turns, math.inf)
        if size <= 1e-14:
            break
        matrix = passage.matrix - np.eye(flow.size)
        move = np.linalg.lstsq(matrix * scale / scale[:, None], -gap / scale, rcond=1e-12)[0]
        length = float(np.linalg.norm(move))
        move *= min(1.0, _LARGEST_MOVE / length) if length > 0.0 else 1.0
        for halving in range(_HALVINGS):
            trial = confined(flow, x + scale * move * 0.5**halving)
            passed = flow.follow(trial, duration)
            residual = gap_of(trial, passed.end, turns)
            smaller = float(np.linalg.norm(residual / scale))
            if passed.is_complete and smaller < size * (1.0 - 1e-4 * 0.5**halving):
                x, passage, gap = trial, passed, residual
                break
        else:
            break
    return Orbit(flow, x, passage, duration, turns, float(np.linalg.norm(gap / scale)))


def scale_of(system: System) -> Floats:
    """Return the units in which angles and angular velocities are alike."""
    return np.array([1.0, system.natural_frequency] * system.angles)


def turns_of(flow: Flow, start: Floats, end: Floats) -> int:
    """Return how often the balls went round; walls do not let a single one."""
    if flow.size == 2 and math.isfinite(flow.walls[0]):
        return 0
    mean = float(np.mean((end - start)[0::2])) / math.tau
    return round(mean) if math.isfinite(mean) else 0


def gap_of(start: Floats, end: Floats, turns: int) -> Floats:
    """Return end minus start, whole turns taken away."""
    gap = end - start
    gap[0::2] -= math.tau * turns
    return np.asarray(gap)


def unwound(flow: Flow, state: Floats) -> Floats:
    """Return a state with the angles moved by whole turns towards zero."""
    result = np.array(state)
    if not (flow.size == 2 and math.isfinite(flow.walls[0])):
        result[0::2] -= math.tau * round(float(np.mean(result[0::2])) / math.tau)
    return result


def confined(flow: Flow, state: Floats) -> Floats:
    """Return a state moved between the walls."""
    result = np.array(state)
    result[0::2] = between_walls(result[0::2], flow.walls)
    return result
