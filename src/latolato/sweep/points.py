"""Turns points of a plan into the arrays that kernels read.

Where every law is plain arithmetic of its parameters (one ball, harmonic or no drive) whole columns
are turned at once; elsewhere each point is built as the objects of a single run. Both give the
same numbers; a test compares them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.errors import InputError
from latolato.numerics import records
from latolato.numerics.integrate import (
    Start,
    body_rows,
    choose_step,
    choose_stepper,
    fastest_rate,
    initial_states,
    rate_of,
    settings_values,
    step_for,
)
from latolato.numerics.many import Points
from latolato.numerics.records import BODY, SETTINGS
from latolato.numerics.steppers import Stepper
from latolato.physics.drives import Drive, Harmonic, Static
from latolato.physics.drives.stretch import COSINE
from latolato.physics.noise import KEY, VelocityKicks
from latolato.physics.pendulum import Ball, LatoLato, System, restoring_linear
from latolato.quantities import is_computable
from latolato.simulate import MOST_STEPS
from latolato.start import ON_WALL, checked_start, kicks_of, walls_of
from latolato.sweep.axes import DERIVED, parameters_of
from latolato.sweep.plan import Plan

Floats = NDArray[np.float64]
Columns = dict[str, Floats]

_OUT_OF_RANGE = "the numbers of this point leave the range of floats"


@dataclass(frozen=True)
class Batch:
    """Points ready to run.

    Attributes
    ----------
    columns : dict of ndarray, shape (point,)
        Every parameter by name.
    states : ndarray, shape (point,)
        Records of the motion at time zero.
    valid : ndarray of bool, shape (point,)
        False where the parameters contradict each other; such points do not run.
    reason : str
        What is wrong with the first invalid point.
    """

    columns: Columns
    points: Points
    states: NDArray[Any]
    valid: NDArray[np.bool_]
    reason: str


@dataclass(frozen=True)
class Previous:
    """Where the points before these on a continuation ended; arrays of shape (angle, point)."""

    angles: Floats
    velocities: Floats
    phase: Floats | None


def is_arithmetic(plan: Plan) -> bool:
    """Return whether whole columns of this plan's points can be turned at once."""
    laws = isinstance(plan.drive, (Harmonic, Static))
    return plan.system.angles == 1 and laws and plan.noise is None


def is_smooth(plan: Plan) -> bool:
    """Return whether no point of the plan has drag that is not smooth at rest."""
    names = {"quadratic_damping", "coulomb_damping"}
    varied = {p.removeprefix("right_").removeprefix("left_") for p in plan.varied}
    return not names & varied and all(
        getattr(ball, name) == 0.0 for ball in plan.system.balls for name in names
    )


def stepper_of(plan: Plan) -> Stepper:
    """Return the one stepper that all points of a plan use."""
    if is_smooth(plan):
        return choose_stepper(plan.system)
    rough = Ball(length=1.0, mass=1.0, coulomb_damping=1.0)
    return choose_stepper(SimpleNamespace(balls=(rough,)))  # type: ignore[arg-type]


def columns_of(plan: Plan, index: NDArray[np.int64]) -> Columns:
    """Return every parameter of the points with these numbers, arrays of shape (point,)."""
    known = parameters_of(plan.system, plan.drive, plan.noise)
    owners = {"system": plan.system, "drive": plan.drive}
    columns: Columns = {}
    for name, parameter in known.items():
        if parameter.owner not in owners or name in DERIVED:
            continue
        value: Any = owners[parameter.owner]
        for part in parameter.path:
            value = getattr(value, part)
        columns[name] = np.full(len(index), value)
    columns |= {name: np.full(len(index), value) for name, value in plan.start}
    if plan.own_streams:
        assert plan.noise is not None
        columns["noise_stream"] = (plan.noise.stream + index).astype(np.float64)
    place = dict(zip(plan.dims, np.unravel_index(index, plan.shape), strict=True))
    for axis in plan.axes:
        for name, values in zip(axis.parameters, axis.values, strict=True):
            columns[name] = np.array(values)[place[axis.name]]
    _resolve(columns)
    return columns


def _resolve(columns: Columns) -> None:
    """Replace parameters that stand for others; frequencies come before accelerations."""
    length = columns["length"] if "length" in columns else columns["right_length"]
    gravity = columns["gravity"]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        if "frequency_ratio" in columns:
            ratio = columns.pop("frequency_ratio")
            columns["drive_frequency"] = ratio * np.sqrt(gravity / length)
        if "amplitude_ratio" in columns:
            columns["drive_amplitude"] = columns.pop("amplitude_ratio") * length
        if "drive_acceleration_ratio" in columns:
            lift = columns.pop("drive_acceleration_ratio") * gravity
            columns["drive_amplitude"] = lift / columns["drive_frequency"] ** 2


def make_batch(
    plan: Plan, index: NDArray[np.int64], stepper: Stepper, previous: Previous | None = None
) -> Batch:
    """Return the points with these numbers, of which some may continue earlier ones."""
    columns = columns_of(plan, index)
    if previous is not None and previous.phase is not None:
        columns["drive_phase"] = previous.phase
    build = _from_columns if is_arithmetic(plan) else _from_objects
    return build(plan, columns, stepper, previous)


def _noise(plan: Plan, columns: Columns, k: int) -> VelocityKicks | None:
    """Return the noise of one point."""
    if plan.noise is None:
        return None
    values: dict[str, Any] = {}
    for field in ("strength", "interval", *KEY):
        if f"noise_{field}" in columns:
            value = columns[f"noise_{field}"][k]
            values[field] = int(value) if field in KEY else float(value)
    return replace(plan.noise, **values)


def transient_of(plan: Plan, columns: Columns) -> Floats:
    """Return how long the transient lasts at each point [s]."""
    period = _drive_period(columns)
    length = columns["length"] if "length" in columns else columns["right_length"]
    with np.errstate(over="ignore"):
        natural = math.tau * np.sqrt(length / columns["gravity"])
        periods: Floats = plan.transient_periods * np.where(np.isfinite(period), period, natural)
    return plan.transient + periods


def _drive_period(columns: Columns) -> Floats:
    """Return the drive's period at each point [s], infinite without a drive."""
    first = next(iter(columns.values()))
    frequency = columns.get("drive_frequency", np.zeros(len(first)))
    with np.errstate(divide="ignore"):
        period: Floats = math.tau / frequency
    return period


def _stops(plan: Plan, columns: Columns) -> tuple[Floats, NDArray[np.bool_]]:
    """Return the instants at which steps end, (point, 2 + mark), and where they make sense."""
    transient = transient_of(plan, columns)
    marks = max((o.marks for o in plan.observables), default=0)
    stops = np.full((len(transient), 2 + marks), np.nan)
    stops[:, 0], stops[:, -1] = transient, plan.duration
    if marks:
        period = _drive_period(columns)
        with np.errstate(invalid="ignore"):
            last = np.floor(plan.duration / period * (1.0 + 1e-14))
            numbers = last[:, None] - np.arange(marks - 1, -1, -1)
            instants = np.minimum(numbers * period[:, None], plan.duration)
        seen = np.isfinite(instants) & (numbers >= 0.0) & (instants >= transient[:, None])
        stops[:, 1:-1] = np.where(seen, instants, np.nan)
    return stops, transient < plan.duration


def _from_columns(
    plan: Plan, columns: Columns, stepper: Stepper, previous: Previous | None
) -> Batch:
    """Return points whose laws are arithmetic, whole columns at once."""
    c = SimpleNamespace(**columns)
    count = len(c.length)
    known = parameters_of(plan.system, plan.drive, plan.noise)
    valid = np.ones(count, dtype=bool)
    for name in columns.keys() & known.keys():
        allowed, unit = known[name].allowed, known[name].quantity.unit
        valid &= allowed.holds(columns[name]) & is_computable(columns[name], allowed, unit)
    low = np.full(count, -math.inf)
    high = -low
    if isinstance(plan.system, LatoLato):
        valid &= (c.radius >= 0.0) & (c.radius < c.length)
        share = np.where(valid, c.radius / np.where(valid, c.length, 1.0), 0.0)
        contact_angle = np.array([math.asin(x) for x in share])
        if "initial_offset" in columns:
            columns["initial_angle"] = contact_angle + columns["initial_offset"]
        if plan.contact.meets:
            low, high = contact_angle, math.pi - contact_angle
    angle, velocity = columns["initial_angle"], columns["initial_angular_velocity"]
    if previous is not None:
        angle = np.clip(previous.angles[0], low, high)
        velocity = previous.velocities[0]
    valid &= (angle >= low - ON_WALL) & (angle <= high + ON_WALL)
    angle = np.where(abs(angle - low) <= ON_WALL, low, angle)
    angle = np.where(abs(angle - high) <= ON_WALL, high, angle)

    zero = np.zeros(count)
    lift = frequency = zero
    with np.errstate(all="ignore"):
        if isinstance(plan.drive, Harmonic):
            # The properties are arithmetic: they take columns as well as numbers.
            lift = Harmonic.largest_acceleration.fget(c)  # type: ignore[attr-defined]
            frequency = Harmonic.fastest_frequency.fget(c)  # type: ignore[attr-defined]
        body = records.body_record(c)  # type: ignore[arg-type]
        speed = abs(velocity)
        rate = rate_of(c.gravity, c.length, lift, frequency, speed, (body[1], body[2]))
        rate = np.maximum(rate, plan.contact.fastest_rate)
        step = step_for(rate, plan.tolerance, stepper)
        if plan.contact.fixed_step is not None:
            step = np.full(count, plan.contact.fixed_step)
        valid &= np.isfinite(step) & (step > 0.0) & (plan.duration <= MOST_STEPS * step)
    settings = np.zeros(count, dtype=SETTINGS)
    values = settings_values(
        gravity=c.gravity,
        walls=(low, high),
        restitution=columns.get("restitution", 1.0),
        rest_speed=plan.rest_speed,
        step=np.where(valid, step, 0.0),
        pivot_bound=lift,
        rate=np.where(valid, rate, 0.0),
        follows_tension=_follows_tension(plan),
        is_linear=plan.system.restoring is restoring_linear,
        law=plan.contact.numbers,
    )
    for name, value in zip(SETTINGS.names or (), values, strict=True):
        settings[name] = value
    bodies = np.zeros((count, 1), dtype=BODY)
    for name, value in zip(BODY.names or (), body, strict=True):
        bodies[name][:, 0] = value
        valid &= np.isfinite(value)
    stretches = np.zeros(count, dtype=records.stretch_dtype())
    if isinstance(plan.drive, Harmonic):
        stretches["form"], stretches["phase"] = COSINE, columns["drive_phase"]
        stretches["c0"], stretches["frequency"] = columns["drive_amplitude"], frequency
    stops, sensible = _stops(plan, columns)
    valid &= sensible
    each = np.arange(count + 1)
    points = Points(
        settings, bodies, stretches, zero, zero, each, np.zeros(0), np.zeros((1, 0)),
        np.zeros(count + 1, dtype=np.int64), stops, plan.contact_limit,
    )  # fmt: skip
    states = initial_states([angle], [velocity], count)
    reason = ""
    if not valid.all():
        reason = _reason(plan, columns, int(np.argmin(valid)), stepper)
    return Batch(columns, points, states, valid, reason)


def _reason(plan: Plan, columns: Columns, k: int, stepper: Stepper) -> str:
    """Return what is wrong with a point, as the objects of a single run say it."""
    try:
        _objects(plan, columns, k, stepper, None)
    except InputError as error:
        return str(error)
    except ArithmeticError:
        pass
    return _OUT_OF_RANGE


def _follows_tension(plan: Plan) -> bool:
    """Return whether an observable asks for the time of slack."""
    asked = any("slack" in o.needs for o in plan.observables)
    return asked and plan.system.restoring is not restoring_linear


def _objects(
    plan: Plan, columns: Columns, k: int, stepper: Stepper, previous: Previous | None
) -> tuple[System, Drive, Any, tuple[float, float], float]:
    """Return system, drive, start, walls and step of one point, built like those of a run."""
    known = parameters_of(plan.system, plan.drive, plan.noise)
    changed: dict[str, dict[str, Any]] = {"system": {}, "drive": {}}
    for name in plan.varied | (
        {"drive_phase"} if previous and previous.phase is not None else set()
    ):
        target = DERIVED.get(name, name)
        parameter = known[target]
        if parameter.owner not in changed:
            continue
        value = float(columns[target][k])
        if len(parameter.path) == 2:
            part, inner = parameter.path
            old = changed["system"].get(part, {})
            changed["system"][part] = {**old, inner: value}
        else:
            changed[parameter.owner][parameter.path[0]] = value
    parts = {
        name: replace(getattr(plan.system, name), **value) if isinstance(value, dict) else value
        for name, value in changed["system"].items()
    }
    system = replace(plan.system, **parts) if parts else plan.system
    drive = replace(plan.drive, **changed["drive"]) if changed["drive"] else plan.drive
    walls = walls_of(system, plan.contact)
    sides = ("",) if system.angles == 1 else ("_right", "_left")
    offset = None
    angle: tuple[float, ...] = ()
    if previous is not None:
        angle = _inside(tuple(float(a[k]) for a in previous.angles), walls)
        velocity = tuple(float(v[k]) for v in previous.velocities)
    else:
        velocity = tuple(float(columns[f"initial_angular_velocity{s}"][k]) for s in sides)
        if "initial_offset" in columns:
            offset = float(columns["initial_offset"][k])
        else:
            angle = tuple(float(columns[f"initial_angle{s}"][k]) for s in sides)
    one = system.angles == 1
    given: Any = None if offset is not None else (angle[0] if one else angle)
    start = checked_start(system, walls, given, velocity[0] if one else velocity, offset)
    transient = float(transient_of(plan, {name: c[k : k + 1] for name, c in columns.items()})[0])
    if not transient < plan.duration:
        raise InputError(
            f"the transient must be shorter than the duration {plan.duration:g} s, "
            f"got {transient:g} s"
        )
    if any(o.mirrored for o in plan.observables):
        _check_mirrored(system, start)
    step = plan.contact.fixed_step
    if step is None:
        step = choose_step(system, drive, start, plan.tolerance, stepper, plan.contact)
    if not plan.duration <= MOST_STEPS * step:
        raise InputError(
            f"this point would take more than {MOST_STEPS:.0e} steps of {step:.3g} s: shorten the "
            "duration, loosen the tolerance or slow the motion"
        )
    return system, drive, start, walls, step


def arguments_of(plan: Plan, number: int) -> dict[str, Any]:
    """Return the arguments of `latolato.simulate` that run one point of a plan alone.

    Raises
    ------
    InputError
        If the point's parameters contradict each other, or if it goes on from another point.
    """
    if plan.continuation:
        raise InputError(
            f"a point of this map goes on from its neighbour along {plan.continuation}: it cannot "
            "run alone"
        )
    columns = columns_of(plan, np.array([number]))
    system, drive, start, *_ = _objects(plan, columns, 0, stepper_of(plan), None)
    one = system.angles == 1
    found = {
        "system": system,
        "drive": drive,
        "initial_angle": start.angles[0] if one else start.angles,
        "initial_angular_velocity": start.velocities[0] if one else start.velocities,
        "duration": plan.duration,
        "tolerance": plan.tolerance,
        "contact": plan.contact if system.has_contacts else None,
        "rest_speed": plan.rest_speed,
        "contact_limit": plan.contact_limit,
        "noise": _noise(plan, columns, 0),
    }
    return {name: value for name, value in found.items() if value is not None}


def _check_mirrored(system: System, start: Start) -> None:
    """Raise InputError unless two equal balls begin as mirror images of each other."""
    right, left = system.balls
    images = all(a == -b for a, b in (start.angles, start.velocities))
    if right != left or not images:
        raise InputError(
            "transverse_exponent belongs to two equal balls that begin as mirror images: give both "
            "the same properties, and the left one the opposite angle and angular velocity"
        )


def _inside(angles: tuple[float, ...], walls: tuple[float, float]) -> tuple[float, ...]:
    """Return angles moved between the walls where parameters of the walls have changed."""
    low, high = walls
    if len(angles) == 1:
        return (min(max(angles[0], low), high),)
    gap = angles[0] - angles[1]
    shift = 0.5 * (min(max(gap, low), high) - gap)
    return (angles[0] + shift, angles[1] - shift)


def _from_objects(
    plan: Plan, columns: Columns, stepper: Stepper, previous: Previous | None
) -> Batch:
    """Return points each of which is built like a single run."""
    count = len(next(iter(columns.values())))
    angles = plan.system.angles
    stops, _ = _stops(plan, columns)
    settings = np.zeros(count, dtype=SETTINGS)
    bodies = np.zeros((count, 1 if angles == 1 else 4), dtype=BODY)
    x, v = np.zeros((angles, count)), np.zeros((angles, count))
    valid = np.zeros(count, dtype=bool)
    reason = ""
    stretches, starts, jumps, kick_times, kick_sizes = [], [], [], [], []
    firsts, kick_firsts = np.zeros(count + 1, dtype=np.int64), np.zeros(count + 1, dtype=np.int64)
    known: tuple[Drive, Any, Any, Any] | None = None
    for k in range(count):
        firsts[k + 1], kick_firsts[k + 1] = firsts[k], kick_firsts[k]
        try:
            system, drive, start, walls, step = _objects(plan, columns, k, stepper, previous)
        except InputError as error:
            reason = reason or str(error)
            continue
        except ArithmeticError:
            reason = reason or _OUT_OF_RANGE
            continue
        valid[k] = True
        rows, offsets = body_rows(system, walls)
        bodies[k] = np.array(rows, dtype=BODY)
        settings[k] = settings_values(
            gravity=system.gravity,
            walls=walls,
            restitution=getattr(system, "restitution", 1.0),
            rest_speed=plan.rest_speed,
            step=step,
            pivot_bound=drive.largest_acceleration,
            rate=fastest_rate(system, drive, start, plan.contact),
            offsets=offsets,
            follows_tension=_follows_tension(plan),
            is_linear=plan.system.restoring is restoring_linear,
            mirrored=any(o.mirrored for o in plan.observables),
            law=plan.contact.numbers,
        )
        x[:, k], v[:, k] = start.angles, start.velocities
        if known is None or known[0] is not drive:
            found = records.stretch_records(drive, plan.duration)
            known = (drive, *found, np.array(drive.velocity_jumps(plan.duration)))
        stretches.append(known[1])
        starts.append(known[2])
        jumps.append(known[3])
        firsts[k + 1] += len(known[2])
        instants, sizes = kicks_of(_noise(plan, columns, k), system, plan.duration)
        if instants is not None and sizes is not None:
            kick_times.append(instants)
            kick_sizes.append(sizes)
            kick_firsts[k + 1] += len(instants)
    points = Points(
        settings, bodies,
        np.concatenate(stretches) if stretches else np.zeros(0, dtype=records.stretch_dtype()),
        np.concatenate(starts) if starts else np.zeros(0),
        np.concatenate(jumps) if jumps else np.zeros(0),
        firsts,
        np.concatenate(kick_times) if kick_times else np.zeros(0),
        np.concatenate(kick_sizes, axis=1) if kick_sizes else np.zeros((angles, 0)),
        kick_firsts, stops, plan.contact_limit,
    )  # fmt: skip
    states = initial_states(list(x), list(v), count)
    return Batch(columns, points, states, valid, reason)
