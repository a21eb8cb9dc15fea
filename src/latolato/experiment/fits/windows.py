"""A model of angles over windows with separate starts: robust for long or chaotic motion."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.quantities import Range
from latolato.experiment.fits.least_squares import (
    MOST_TRIALS,
    Data,
    Floats,
    Guess,
    Solution,
    solve,
)
from latolato.experiment.fits.samples import check_end
from latolato.experiment.fits.sight import SEEN, Sight, drop_of
from latolato.numerics.integrate import Directions, Start, integrate
from latolato.numerics.prepare import choose_stepper, rate_of, step_for
from latolato.numerics.run_record import MOST_PARAMETERS
from latolato.numerics.steppers import BLANES_MOAN_GENERAL
from latolato.physics.contacts import ExactContact
from latolato.physics.drives import Drive, FixedPivot, MeasuredPivot, Segment
from latolato.physics.drives.segment import CHANGES
from latolato.physics.pendulum import System
from latolato.simulation.sensitivity import Numbers, joined, numbers_of, segments_of, slopes_of
from latolato.simulation.start import between_walls, walls_of

# Samples to either side from which the state at the start of a window is guessed.
_NEAR = 4
# Relative and absolute steps of derivatives.
_RELATIVE, _ABSOLUTE = 1e-5, 1e-6
# Angle of trials that end early.
_WILD = 10.0
# Aimed-at error of fitted angles [rad]; a camera sees a thousandth at best.
_TOLERANCE = 1e-8
# Balls that part more slowly rest on each other [rad/s].
_REST_SPEED = 1e-5
# What happens where balls meet.
EXACT = ExactContact()
# Parameters of the start of one angle in one window.
START = ("initial_angle", "initial_angular_velocity")
Laws = Callable[[Mapping[str, float]], tuple[System, Drive]]


def start_names(k: int, j: int) -> tuple[str, str]:
    """Return the names of angle j and its angular velocity at the start of window k."""
    place = f"_{k}_{j}" if k or j else ""
    return f"{START[0]}{place}", f"{START[1]}{place}"


@dataclass(frozen=True)
class Window:
    """A piece of the samples that one start belongs to.

    Attributes
    ----------
    begin : float
        Instant of the start [s].
    places : ndarray of int, shape (sample,)
        Where its samples are in the data.
    times : ndarray, shape (time,)
        Instants of all of them from `begin` on, each once [s].
    inside : tuple of ndarray of int, shape (sample,)
        Number of the angle and place in `times` of each sample.
    """

    begin: float
    places: NDArray[np.int64]
    times: Floats
    inside: tuple[NDArray[np.int64], NDArray[np.int64]]


class WindowedModel:
    """Angles of a system over windows, with shared parameters and a start for each window.

    The parameters of a start are named by `start_names`.
    """

    def __init__(
        self, data: Data, laws: Laws, shared: Mapping[str, Guess], begins: Floats, origin: float
    ) -> None:
        self.data, self.laws, self.shared, self.origin = data, laws, dict(shared), origin
        system, drive = laws({name: guess.value for name, guess in shared.items()})
        check_end(drive, origin, float(np.max(data.times)))
        self.angles = system.angles
        self._sight = Sight.of(data)
        self.windows = _windows(data, begins)
        self._window_of = {
            name: k for k, _ in enumerate(self.windows) for j in range(self.angles)
            for name in start_names(k, j)
        }  # fmt: skip
        self._held = not any(name in drive.__dataclass_fields__ for name in shared)
        self._drives = [self._later(drive, w) for w in self.windows] if self._held else []
        reach = max(self._drives, key=lambda d: d.largest_acceleration) if self._held else drive
        acceleration = system.gravity + reach.largest_acceleration
        speed = 2.0 * math.sqrt(acceleration / min(ball.length for ball in system.balls))
        if isinstance(drive, FixedPivot):  # where a swing gets no faster than it is seen to be
            speed *= math.sqrt(0.5 * drop_of(data.values))
        self.step = step_of(system, reach, speed)

    def guesses(self, states: Floats | None = None) -> dict[str, Guess]:
        """Return guesses of all parameters; of the starts from the samples about them."""
        guesses = dict(self.shared)
        system, _ = self.laws({name: guess.value for name, guess in guesses.items()})
        for k, window in enumerate(self.windows):
            if states is None:
                state, _ = _parabolas(self.data, window.begin, self.angles)
            else:
                state = states[k]
            inside = _within_walls(system, state[:, 0])
            for j in range(self.angles):
                angle, velocity = start_names(k, j)
                guesses[angle] = Guess(float(inside[j]))
                guesses[velocity] = Guess(float(state[j, 1]))
        return guesses

    def solved(
        self,
        guesses: Mapping[str, Guess],
        *,
        profiles: Sequence[str] = (),
        like: Solution | None = None,
        limit: int = MOST_TRIALS,
    ) -> Solution:
        """Return the least-squares solution of the samples; options are those of `solve`."""
        return solve(
            self,
            guesses,
            self.data,
            profiles=profiles,
            like=like,
            jacobian=self.jacobian,
            limit=limit,
        )

    def __call__(self, p: Mapping[str, float]) -> Floats:
        """Return the angles at the samples as they are seen [rad]."""
        return self._seen(self.motion(p), p)

    def motion(self, p: Mapping[str, float]) -> Floats:
        """Return the true angles at the samples [rad], NaN where the motion fails."""
        system, drives = self._laws(p)
        out, slopes = np.empty(len(self.data)), np.empty((len(self.data), 0))
        for k in range(len(self.windows)):
            self._run(out, slopes, system, drives[k], p, k, np.empty(0, dtype=np.int64), [])
        return out

    def jacobian(self, p: Mapping[str, float], names: Sequence[str]) -> Floats:
        """Return the derivatives of the angles, shape (sample, name); see `with_slopes`."""
        return self.with_slopes(p, names)[1]

    def with_slopes(
        self,
        p: Mapping[str, float],
        names: Sequence[str],
        directions: Sequence[list[Numbers]] | None = None,
    ) -> tuple[Floats, Floats]:
        """Return the angles at the samples as they are seen [rad], and their derivatives.

        The derivatives have the shape (sample, name). Those of the motion are exact
        (`simulation.sensitivity`), and so are those of how it is seen but for their differences of
        plain formulas. Where a motion has no exact derivative, as after a graze, differences of
        motions stand in.

        Parameters
        ----------
        p : mapping of str to float
            Values of all parameters.
        names : sequence of str
            Those whose derivatives are wanted.
        directions : sequence, optional
            What `directions_at` returns for values that are nearly these; by default for these.
        """
        directions = self.directions_at(p, names) if directions is None else directions
        motion = np.empty(len(self.data))
        slopes = np.zeros((len(self.data), len(names)))
        system, drives = self._laws(p)
        for k in range(len(self.windows)):
            moving = self._moving(names, k)
            self._run(motion, slopes, system, drives[k], p, k, moving, directions[k])
        middle = self._seen(motion, p)
        above, below = self._seen(motion + _ABSOLUTE, p), self._seen(motion - _ABSOLUTE, p)
        matrix = slopes * ((above - below) / (2.0 * _ABSOLUTE))[:, None]
        for i, name in enumerate(names):
            moved, change = self._moved_by_a_little(p, name)
            if np.isnan(slopes[:, i]).any():
                matrix[:, i] = (self._seen(self.motion(moved), moved) - middle) / change
            elif name not in self._window_of:
                matrix[:, i] += (self._seen(motion, moved) - middle) / change
        return middle, matrix

    def directions_at(self, p: Mapping[str, float], names: Sequence[str]) -> list[list[Numbers]]:
        """Return for each window how the engine's numbers change with the parameters that act.

        There are none for a drive with formulas of its own.
        """
        system, drives = self._laws(p)
        return [
            self._directions(system, drives[k], p, k, [names[i] for i in self._moving(names, k)])
            for k in range(len(self.windows))
        ]

    def _moving(self, names: Sequence[str], k: int) -> NDArray[np.int64]:
        """Return the places of the parameters on which the motion in a window depends."""
        own = [i for i, name in enumerate(names) if self._window_of.get(name, k) == k]
        return np.array([i for i in own if names[i] not in SEEN], dtype=np.int64)

    def _moved_by_a_little(
        self, p: Mapping[str, float], name: str
    ) -> tuple[dict[str, float], float]:
        """Return parameters of which one is changed, and by how much."""
        size = max(_RELATIVE * abs(p[name]), _ABSOLUTE)
        # Towards the inside of a bounded range.
        high = self.shared[name].high if name in self.shared else math.inf
        change = -size if p[name] + size > high else size
        return {**p, name: p[name] + change}, change

    def _directions(
        self, system: System, drive: LaterDrive, p: Mapping[str, float], k: int,
        names: Sequence[str],
    ) -> list[Numbers]:  # fmt: skip
        """Return how the engine's numbers in one window change with some of the parameters."""
        if drive.acceleration not in CHANGES:
            return []
        window, begun = self.windows[k], self._begun(system, p, k)
        end = float(window.times[-1])

        def numbers(values: Sequence[float], name: str) -> Numbers:
            pairs = [self.laws({**p, name: value}) for value in values]
            if self._held:  # of a measured pivot there are thousands
                laws = [(law, drive, begun) for law, _ in pairs]
                return numbers_of(laws, end, EXACT, self.step)
            moved = [(law, self._later(other, window), begun) for law, other in pairs]
            own = numbers_of(moved, end, EXACT, self.step)
            return own | segments_of([later for _, later, _ in moved], end)

        still = numbers_of([(system, drive, begun)], end, EXACT, self.step)
        still |= segments_of([drive], end)
        unchanged = {name: np.zeros_like(values[0]) for name, values in still.items()}
        units = [name for j in range(self.angles) for name in start_names(k, j)]
        directions: list[Numbers] = []
        for name in names:
            own = dict(unchanged)
            if name in units:
                own["start"] = np.eye(4)[units.index(name)]
            else:
                guess = self.shared[name]
                allowed = Range(guess.low, guess.high)
                size = max(abs(p[name]), 1e-3)
                one = partial(numbers, name=name)
                own |= slopes_of(name, one, p[name], size, allowed, is_quick=True)
            directions.append(own)
        return directions

    def _run(
        self, out: Floats, slopes: Floats, system: System, drive: LaterDrive,
        p: Mapping[str, float], k: int, moving: NDArray[np.int64], directions: list[Numbers],
    ) -> None:  # fmt: skip
        """Write the angles of one window, and their derivatives by some of the parameters."""
        window, begun = self.windows[k], self._begun(system, p, k)
        if len(directions) < len(moving):  # a drive with formulas of its own has none
            slopes[np.ix_(window.places, moving)] = math.nan
            moving = moving[:0]
        for first in range(0, max(len(moving), 1), MOST_PARAMETERS):
            some = moving[first : first + MOST_PARAMETERS]
            chosen = joined(directions[first : first + MOST_PARAMETERS]) if len(some) else None
            angles, _, derivatives = motion_at(
                system, drive, begun, window.times, chosen, step=self.step
            )
            out[window.places] = angles[window.inside]
            if len(some):
                found = np.where(np.isfinite(angles), derivatives, 0.0)[:, *window.inside]
                slopes[np.ix_(window.places, some)] = found.T

    def _begun(self, system: System, p: Mapping[str, float], k: int) -> Start:
        """Return the start of a window, clear of the walls."""
        names = [start_names(k, j) for j in range(self.angles)]
        angles = _within_walls(system, np.array([p[angle] for angle, _ in names]))
        return Start(tuple(angles.tolist()), tuple(p[velocity] for _, velocity in names))

    def _seen(self, angles: Floats, p: Mapping[str, float]) -> Floats:
        """Return the angles at the samples as they are seen about the table's pivot [rad]."""
        # A trial too wild to be followed to the end is a bad fit, not an error.
        angles = np.where(np.isfinite(angles), angles, _WILD)
        if self.angles == 1:
            return self._sight.seen(angles, p)
        lengths = np.array([ball.length for ball in self.laws(p)[0].balls])
        return self._sight.seen(angles, p, (lengths.mean() / lengths)[self.data.series - 1])

    def states_at(self, p: Mapping[str, float], begins: Floats) -> Floats:
        """Return angles and velocities of the solution at instants, shape (instant, angle, 2)."""
        system, drives = self._laws(p)
        starts = np.array([window.begin for window in self.windows])
        out = np.empty((len(begins), self.angles, 2))
        for i, instant in enumerate(begins):
            k = max(int(np.searchsorted(starts, instant + 1e-9)) - 1, 0)
            begun, late = self._begun(system, p, k), instant - starts[k]
            state: Any = begun.angles, begun.velocities
            if late > 1e-9:
                times = np.array([late])
                *state, _ = motion_at(system, drives[k], begun, times, step=self.step)
            out[i] = np.column_stack(state)
        return out

    def _laws(self, p: Mapping[str, float]) -> tuple[System, list[LaterDrive]]:
        """Return the system, and the drive as each window sees it."""
        system, drive = self.laws(p)
        return system, self._drives or [self._later(drive, w) for w in self.windows]

    def _later(self, drive: Drive, window: Window) -> LaterDrive:
        """Return the drive with its time counted from the start of a window."""
        return LaterDrive(drive, window.begin - self.origin, float(window.times[-1]) + 1e-5)


def _windows(data: Data, begins: Floats) -> list[Window]:
    """Return the pieces of the samples that begin at these instants."""
    ends = [*begins[1:], math.inf]
    windows = []
    for begin, end in zip(begins, ends, strict=True):
        places = np.flatnonzero((data.times >= begin - 1e-9) & (data.times < end - 1e-9))
        late = np.maximum(data.times[places] - begin, 0.0)
        times, inside = np.unique(late, return_inverse=True)
        windows.append(Window(float(begin), places, times, (data.series[places] - 1, inside)))
    return windows


def _parabolas(data: Data, instant: float, angles: int) -> tuple[Floats, float]:
    """Fit a parabola to the samples of each angle that are nearest to an instant.

    Returns
    -------
    states : ndarray, shape (angle, 2)
        Angles and angular velocities there.
    misfit : float
        Sum of the squares that the parabolas leave, and of the durations of the samples, as gaps
        are no good place.
    """
    states, misfit = np.zeros((angles, 2)), 0.0
    for j in range(angles):
        own = np.flatnonzero(data.series == j + 1)
        near = own[np.argsort(np.abs(data.times[own] - instant), kind="stable")[: 2 * _NEAR + 1]]
        late = data.times[near] - instant
        scale = max(float(np.max(np.abs(late))), 1e-6)
        coefficients = np.polyfit(late / scale, data.values[near], 2)
        states[j] = coefficients[2], coefficients[1] / scale
        left = data.values[near] - np.polyval(coefficients, late / scale)
        misfit += float(left @ left) + float(np.ptp(late))
    return states, misfit


def _within_walls(system: System, angles: Floats) -> Floats:
    """Return angles that noise has put beyond a wall, moved onto it."""
    if not system.has_contacts:
        return angles
    return between_walls(angles, walls_of(system, EXACT))


def window_starts(data: Data, length: float, angles: int) -> Floats:
    """Return instants about `length` seconds apart at which the motion is smooth.

    Near a contact the samples do not give a good guess of the state, so each start is moved to
    where a parabola fits best within a quarter of the length.
    """
    first, last = float(np.min(data.times)), float(np.max(data.times))
    count = max(1, round((last - first) / length)) if math.isfinite(length) else 1
    starts = [first]
    one = data.times[data.series == 1]
    for k in range(1, count):
        about = first + k * (last - first) / count
        near = one[np.abs(one - about) < 0.25 * length]
        if not len(near):
            continue
        picked = near[:: max(1, len(near) // 24)]
        misfit = [_parabolas(data, float(t), angles)[1] for t in picked]
        starts.append(float(picked[int(np.argmin(misfit))]))
    return np.array(starts)


class LaterDrive:
    """A drive whose time zero is `origin` of another one's; what `integrate` asks of a drive.

    Formulas read time only against a segment's start, so shifting that is all.
    """

    def __init__(self, drive: Drive, origin: float, duration: float) -> None:
        self.height, self.velocity = drive.height, drive.velocity
        self.acceleration, self.rotation = drive.acceleration, drive.rotation
        self.across, self.across_velocity = drive.across, drive.across_velocity
        self.across_acceleration, self.moves_across = drive.across_acceleration, drive.moves_across
        # Properties of a measured pivot look at every sample: ask once.
        self.fastest_frequency = drive.fastest_frequency
        self.largest_acceleration = drive.largest_acceleration
        end = origin + duration
        if isinstance(drive, MeasuredPivot):  # whose last piece holds a moment longer
            end = min(end, drive.times[-1])
        segments = drive.segments(end)
        begin = max((i for i, s in enumerate(segments) if s.start <= origin), default=0)
        self._stretches = [s._replace(start=s.start - origin) for s in segments[begin:]]

    def segments(self, duration: float) -> list[Segment]:
        """Return the segments that meet [0, duration]."""
        return [segment for segment in self._stretches if segment.start <= duration]


def step_of(system: System, drive: Any, speed: float) -> float:
    """Return the step [s] of a fit, the same for all trials so that they differ smoothly."""
    shortest = min(ball.length for ball in system.balls)
    bounds = drive.largest_acceleration, drive.fastest_frequency
    rate = rate_of(system.gravity, shortest, *bounds, speed, 0.0, 0.0)
    return step_for(rate, _TOLERANCE, choose_stepper(system) is BLANES_MOAN_GENERAL)


def motion_at(
    system: System,
    drive: Any,
    start: Start,
    times: Floats,
    directions: Directions | None = None,
    *,
    step: float,
) -> tuple[Floats, Floats, Floats]:
    """Return angles and angular velocities at instants, and derivatives of the angles.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive or LaterDrive
        How the pivot moves.
    start : Start
        Angles and angular velocities at time 0 [rad, rad/s].
    times : ndarray, shape (time,)
        Increasing instants from 0 on [s].
    directions : Directions, optional
        Those in which derivatives are taken.
    step : float
        Step of the integrator [s].

    Returns
    -------
    angles, velocities : ndarray, shape (angle, time)
        Right ball first [rad, rad/s]; NaN where the motion fails.
    slopes : ndarray, shape (direction, angle, time)
        NaN where they do not exist.
    """
    run = integrate(
        system,
        drive,
        start,
        np.ascontiguousarray(times, dtype=np.float64),
        max(float(times[-1]), 1e-9),
        law=EXACT,
        step=step,
        rest_speed=_REST_SPEED,
        contact_limit=10_000,
        directions=directions,
    )
    size = 2 * system.angles
    count = 0 if directions is None else len(directions.changes)
    rows = run.samples[len(run.samples) - size * count :].reshape(count, size, len(times))
    return run.samples[0:size:2], run.samples[1:size:2], rows[:, 0::2]
