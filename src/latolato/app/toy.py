"""A toy that runs while its parameters change: the exact integrator, one tick of time at a go."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from latolato.app.recording import Recording
from latolato.app.steering import checked_state, cosine_of, limits_of
from latolato.core.errors import InputError
from latolato.core.quantities import QUANTITIES, Range
from latolato.core.registry import checked_number, suggest
from latolato.numerics import records
from latolato.numerics.engine.events import Output
from latolato.numerics.engine.loop import Timetable
from latolato.numerics.engine.record import FLIGHT
from latolato.numerics.integrate import (
    Floats,
    engine_of,
    laws_key,
    observe,
)
from latolato.numerics.observe import (
    BALL_ROWS,
    KINETIC,
    PIVOT_ROWS,
    POTENTIAL,
    Observation,
    ball_records,
)
from latolato.numerics.prepare import cases_of, choose_stepper, prepared_runs
from latolato.numerics.watch import Eyes
from latolato.physics.contacts import BOTTOM, TOP, ExactContact, contact_laws
from latolato.physics.drives.stretch import (
    COSINE,
    Stretch,
    fastest_frequency,
    largest_acceleration,
    pivot_acceleration,
    pivot_height,
    pivot_velocity,
    write_change,
    written,
)
from latolato.physics.pendulum import BallPair, LatoLato, System
from latolato.scenario.scenario import Scenario
from latolato.simulation.start import DEFAULT_REST_SPEED, checked_contact, checked_start, walls_of

TICKS_PER_SECOND = 60
# Aimed-at error over a few hundred periods [rad]; see `latolato.simulate`.
TOLERANCE = 1e-10
# The least time of a change, and the acceleration that no change adds more of, so that moving a
# slider is no blow: about half of gravity.
SHORTEST_CHANGE = 0.05  # s
GENTLE = 5.0  # m/s^2
# A hand moves no faster than this, and halves its distance from where it wants to be in a tick.
HAND_SPEED = 8.0  # m/s
_HAND_GAIN = 0.6
_HELD_STILL = 1e-4  # rad
MOST_PUSH = 20.0  # rad/s
# Samples of a recording in a tick.
_RECORDED = 4
_ROOM = 256
_CALLS = 200  # of the kernel in a tick; more means that the motion cannot be followed


class Toy:
    """A system whose drive, damping and restitution may change at every tick.

    Attributes
    ----------
    controls : dict
        What was asked for last: `drive_amplitude`, `drive_frequency`, `damping` and, where balls
        meet, `restitution`, in SI units.
    limits : dict
        The least and largest value of each.
    kinetic, potential : float
        The energies of all balls on show [J].
    """

    def __init__(self, scenario: Scenario, was: Mapping[str, Any] | None = None) -> None:
        """Begin as a scenario does, or go on from what `state` returned."""
        run, system = scenario.run, scenario.system
        law = checked_contact(run.get("contact", "exact"), system)
        self._law = ExactContact() if law.meets else law
        self._rest_speed = float(run.get("rest_speed", DEFAULT_REST_SPEED))
        self.system: System = system
        self.walls = walls_of(system, law)
        amplitude, frequency, phase = cosine_of(scenario.drive, system)
        self.limits = limits_of(system)
        self.controls = {"drive_amplitude": amplitude, "drive_frequency": frequency}
        self.controls["damping"] = system.balls[0].damping
        if isinstance(system, (LatoLato, BallPair)):
            self.controls["restitution"] = system.restitution
        self._check(self.controls)
        angles = run.get("initial_angle")
        velocities = run.get("initial_angular_velocity", 0.0)
        offset, time = run.get("initial_offset"), 0.0
        if was is not None:
            known = checked_state(was, system.angles)
            time, phase, angles, velocities = known[:4]
            offset = None
            amplitude, frequency = known[4:]
            self._check({"drive_amplitude": amplitude, "drive_frequency": frequency})
        start = checked_start(system, self.walls, angles, velocities, offset)
        if max(map(abs, start.velocities)) > 100.0 * system.natural_frequency:
            raise InputError("is too fast for Live", parameter="initial_angular_velocity")

        self._stepper = choose_stepper(system)
        drive_laws = pivot_height, pivot_velocity, pivot_acceleration
        self._carry_on = engine_of(system.angles, pivot_acceleration, *laws_key(system))
        self._laws = *drive_laws, *laws_key(system)
        case = cases_of(
            system, law, angles=start.angles, velocities=start.velocities, bounds=(0.0, 0.0),
            tolerance=TOLERANCE, is_exact=1,
        )  # fmt: skip
        self._runs, _ = prepared_runs(case, self._stepper)
        self._state = self._runs["state"].view(np.recarray)[0]
        self.ticks = round(time * TICKS_PER_SECOND)
        self._state.t_base = self.time
        self._eyes = Eyes(np.zeros(1), 0, system.angles)
        self._buffers = np.empty(_ROOM), np.empty(_ROOM, dtype=np.int64), np.zeros((4, _ROOM))
        self._no_kick = np.empty(0), np.empty((system.angles, 0))
        balls = len(system.balls)
        self._seen = {
            n: (
                np.full((records.SAMPLE_ROWS, n), np.nan),
                np.empty((len(PIVOT_ROWS), n)),
                np.empty((balls, len(BALL_ROWS), n)),
            )
            for n in (1, _RECORDED)
        }
        self.stages: list[Stretch] = [Stretch(self.time, COSINE, phase, frequency, 0.0, amplitude)]
        self._push = np.zeros(system.angles)
        self._held: tuple[int, float] | None = None
        self._wants_record = False
        self.recording: Recording | None = None
        self.contacts, self.clack = 0, 0.0
        self._speed = 0.0
        self._prepare()
        self._look_at(np.array([self.time]), start_only=True)
        if was is not None:
            self._steer()

    @property
    def time(self) -> float:
        """The instant that was reached [s]."""
        return self.ticks / TICKS_PER_SECOND

    @property
    def angles(self) -> tuple[float, ...]:
        """The angles [rad], right ball first."""
        return tuple(map(float, self._state.angle[: self.system.angles]))

    @property
    def velocities(self) -> tuple[float, ...]:
        """The angular velocities [rad/s], right ball first."""
        return tuple(map(float, self._state.velocity[: self.system.angles]))

    def set(self, values: Mapping[str, Any]) -> None:
        """Take new values of controls, which the next tick begins to show.

        Raises
        ------
        InputError
            If one is unknown or beyond its limits; then none is taken.
        """
        result = self._check(values)
        self.controls.update(result)
        ball = {"damping": result["damping"]} if "damping" in result else {}
        whole = {"restitution": result["restitution"]} if "restitution" in result else {}
        if ball or whole:
            if isinstance(self.system, BallPair):
                right, left = (replace(b, **ball) for b in self.system.balls)
                self.system = replace(self.system, right=right, left=left, **whole)
            else:
                self.system = replace(self.system, **ball, **whole)
            if self.recording is not None:
                self.recording.by_hand = True
        if "drive_amplitude" in result or "drive_frequency" in result:
            self._steer()
        self._prepare()

    def push(self, speed: Any) -> None:
        """Give the ball, or both apart, an angular velocity [rad/s] at the next tick."""
        size = checked_number("push", speed, Range(-MOST_PUSH, MOST_PUSH), "rad/s")
        self._push += np.array([size, -size])[: self.system.angles]

    def hold(self, ball: Any, angle: Any) -> None:
        """Lead a ball to an angle [rad] from now on, as a hand would."""
        if isinstance(ball, bool) or not isinstance(ball, int):
            raise InputError("must be a whole number", parameter="ball", value=ball)
        if not 0 <= ball < self.system.angles:
            raise InputError(f"must lie in [0, {self.system.angles}), got {ball}", parameter="ball")
        turns = Range(-1e4, 1e4)
        target = checked_number("angle", angle, turns, "rad")
        if self.system.angles == 1:
            target = min(max(target, self.walls[0]), self.walls[1])
        self._held = ball, target

    def release(self) -> None:
        """Let go of the ball that is held; it keeps the velocity that the hand gave it."""
        self._held = None

    @property
    def is_held(self) -> bool:
        """Whether a hand leads a ball."""
        return self._held is not None

    def settle(self) -> None:
        """Let the drive do at once what was asked for, instead of moving there."""
        now = self.stages[0].at(self.time)
        amplitude, frequency = self.controls["drive_amplitude"], self.controls["drive_frequency"]
        self.stages = [Stretch(self.time, COSINE, now.phase, frequency, 0.0, amplitude)]
        self._prepare()

    def record(self) -> None:
        """Begin a recording as soon as the drive is steady."""
        self._wants_record = True

    def finish(self) -> Recording | None:
        """Return the recording that ends here, None if none had begun."""
        result, self.recording, self._wants_record = self.recording, None, False
        return result if result is not None and result.times else None

    @property
    def is_recording(self) -> bool:
        """Whether a recording runs or is about to."""
        return self._wants_record or self.recording is not None

    def advance(self) -> None:
        """Move on by one tick.

        Raises
        ------
        ArithmeticError
            If the motion left the range of numbers or cannot be followed in time.
        """
        if len(self.stages) > 1 and self.time >= self.stages[1].start:
            del self.stages[0]
            self._prepare()
        if self._wants_record and len(self.stages) == 1 and self._held is None:
            self._begin_recording()
        kick = self._kick()
        speed = max(map(abs, self.velocities)) + max(map(abs, kick), default=0.0)
        if speed > self._speed:
            self._prepare(speed)
        state = self._state
        before, self.ticks = self.time, self.ticks + 1
        stop = self.time
        count = _RECORDED if self.recording is not None else 1
        instants = before + (stop - before) * np.arange(1, count + 1) / count
        instants[-1] = stop
        samples = self._seen[count][0]
        given = self._no_kick
        if kick.any():
            given = np.array([before]), np.ascontiguousarray(kick[:, None])
            if self.recording is not None:
                self.recording.by_hand = True
        state.sample = state.kick = 0
        timetable = Timetable(self._stretches, *given)
        output = Output(instants, samples, *self._buffers)
        for _ in range(_CALLS):
            rows = self._carry_on(self._runs, timetable, output, self._eyes, stop, 10_000)
            if rows:
                self._note_contacts(rows)
            if state.t_base + state.steps * self._step >= stop:
                break
        else:
            raise InputError("the motion cannot be followed in real time")
        if not np.all(np.isfinite([state.angle, state.velocity])):
            raise InputError("the motion left the range of numbers")
        state.t_base, state.steps = stop, 0
        self._look_at(instants)
        if self.recording is not None:
            self.recording.add(instants, *self._seen[count])

    def state(self) -> dict[str, Any]:
        """Return what a toy needs to go on from here."""
        now = self.stages[0].at(self.time)
        return {
            "time": self.time,
            "phase": now.phase % (2.0 * math.pi),
            "drive_amplitude": now.c0,
            "drive_frequency": now.frequency,
            "angles": list(self.angles),
            "velocities": list(self.velocities),
        }

    def _check(self, values: Mapping[str, Any]) -> dict[str, float]:
        """Return values of controls as numbers within their limits."""
        result = {}
        for name, value in values.items():
            if name not in self.controls:
                raise InputError(f"unknown control '{name}': {suggest(name, list(self.controls))}")
            low, high = self.limits[name]
            if not isinstance(value, (int, float)) or isinstance(value, bool):
                raise InputError("must be a number", parameter=name, value=value)
            result[name] = checked_number(name, value, Range(low, high), QUANTITIES[name].unit)
        return result

    def _steer(self) -> None:
        """Lead the drive from what it does now to what was asked for."""
        amplitude, frequency = self.controls["drive_amplitude"], self.controls["drive_frequency"]
        now = self.stages[0].at(self.time)
        more = abs(amplitude - now.c0)
        turn = max(amplitude, abs(now.c0)) * abs(frequency - now.frequency)
        ramp = max(SHORTEST_CHANGE, math.sqrt(6.0 * more / GENTLE), turn / GENTLE)
        self.stages = written(
            write_change, 2, self.stages[0], self.time, amplitude, frequency, ramp
        )
        if self.recording is not None:
            self.recording.steer(self.time, amplitude, frequency, ramp)

    def _prepare(self, speed: float | None = None) -> None:
        """Write what the kernel reads and a tick does not change."""
        system, stages = self.system, self.stages
        self._speed = 1.5 * max(*map(abs, self.velocities), speed or 0.0, system.natural_frequency)
        case = cases_of(
            system, self._law, speed=self._speed, tolerance=TOLERANCE, rest_speed=self._rest_speed,
            bounds=(largest_acceleration(stages, math.inf), fastest_frequency(stages, math.inf)),
            is_exact=1,
        )  # fmt: skip
        result, _ = prepared_runs(case, self._stepper)
        self._step = float(result["settings"]["step"][0])
        for part in ("settings", "bodies"):
            self._runs[part] = result[part]
        self._stretches = np.array(list(map(tuple, stages)), dtype=_STRETCH)
        self._state.stretch = 0
        self._balls = ball_records(system.balls)

    def _kick(self) -> Floats:
        """Return the change of velocity that pushes and the hand make now [rad/s]."""
        kick = self._push.copy()
        self._push[:] = 0.0
        if self._held is None:
            return kick
        ball, target = self._held
        angle, velocity = self.angles[ball], self.velocities[ball]
        away = target - angle
        if self._state.mode > FLIGHT and abs(away) < _HELD_STILL:
            return kick
        body, now = self.system.balls[ball], self.stages[0].at(self.time)
        lift = pivot_acceleration(self.time, now)
        fall = -(self.system.gravity + lift) / body.length * self.system.restoring(angle)
        if self.system.angles == 1 and target in self.walls and fall * (target - math.pi / 2) > 0.0:
            fall = 0.0  # it presses the ball where it is wanted
        fastest = HAND_SPEED / body.length
        wanted = min(max(_HAND_GAIN * away * TICKS_PER_SECOND, -fastest), fastest)
        kick[ball] += wanted - 0.5 * fall / TICKS_PER_SECOND - velocity
        return kick

    def _note_contacts(self, rows: int) -> None:
        """Count contacts and remember the hardest, for the flash; keep them if recording."""
        times, kinds, values = self._buffers
        hits = (kinds[:rows] == BOTTOM) | (kinds[:rows] == TOP)
        self.contacts += int(hits.sum())
        if hits.any():
            before = values[:, :rows][:, hits]
            closing = before[0] - before[1] if self.system.angles == 2 else 2.0 * before[0]
            self.clack = max(self.clack, float(np.abs(closing).max()))
        if self.recording is not None:
            self.recording.add_contacts(times[:rows], kinds[:rows], values[:, :rows])

    def _look_at(self, instants: Floats, *, start_only: bool = False) -> None:
        """Compute energies and the pivot's motion at the samples of this tick."""
        samples, pivot, out = self._seen[len(instants)]
        if start_only:
            samples[: 2 * self.system.angles, 0] = np.column_stack(
                (self.angles, self.velocities)
            ).ravel()
            samples[records.S_WORK :, 0] = 0.0
        observation = Observation(
            instants, samples[records.S_MODE], samples, self._stretches, self._balls,
            float(self.system.gravity), int(self.system.is_linear), 0,
            pivot, out,
        )  # fmt: skip
        observe(observation, *self._laws)
        self.pivot = tuple(map(float, pivot[:, -1]))
        twins = 2.0 if isinstance(self.system, LatoLato) else 1.0
        self.kinetic = twins * float(out[:, KINETIC, -1].sum())
        self.potential = twins * float(out[:, POTENTIAL, -1].sum())

    def _begin_recording(self) -> None:
        """Begin a recording at this instant."""
        self._wants_record = False
        run: dict[str, Any] = {
            "initial_angle": self.angles if self.system.angles == 2 else self.angles[0],
            "initial_angular_velocity": (
                self.velocities if self.system.angles == 2 else self.velocities[0]
            ),
            "contact": contact_laws.name_of(self._law),
            "rest_speed": self._rest_speed,
        }
        now = self.stages[0].at(self.time)
        self.recording = Recording(self.system, self.time, now, run)
        samples, pivot, out = self._seen[1]
        self._look_at(np.array([self.time]), start_only=True)
        for name in _LEDGER:
            self._state[name] = 0.0
        self.recording.add(np.array([self.time]), samples, pivot, out)


_LEDGER = ("drive_work", "damping_loss", "impact_loss", "capture_loss", "noise_work")
_STRETCH = records.stretch_dtype()
