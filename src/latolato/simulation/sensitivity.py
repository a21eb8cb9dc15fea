"""Derivatives of a run with respect to its parameters: which, along which numbers, and how known.

A parameter acts through the numbers that the engine reads: geometry of the contact, bodies, forces,
drive and start. How these depend on it is a chain of smooth formulas without any motion in it
(`numerics.prepare`, `Drive.write`). Its derivative is found by differences of eighth order, which
are exact to some 1e-13 of it, for any law; all that follows in time is differentiated exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.errors import InputError
from latolato.core.parameters import Parameter
from latolato.core.registry import suggest
from latolato.numerics import records
from latolato.numerics.engine import sensitivity as engine
from latolato.numerics.integrate import Directions, Floats, Start, prepared_case
from latolato.numerics.run_record import CHANGE, MOST_PARAMETERS
from latolato.physics.contacts import ExactContact, PassThrough
from latolato.physics.drives import Drive
from latolato.physics.drives.segment import CHANGES
from latolato.physics.pendulum import LatoLato, System, restoring_linear, restoring_sine
from latolato.simulation.vary import parameters_of, replaced

if TYPE_CHECKING:
    from latolato.simulation.plan import RunPlan

# Why derivatives are not known from some instant on.
DOUBTS = {
    engine.GRAZING: "a ball grazed a contact, where derivatives grow beyond all bounds",
    engine.TOGETHER: "two events fell on one instant, and a change of a parameter parts them",
    engine.CAPTURED: "the last bounces of a capture were not followed one by one",
    engine.START: "at the start the balls touch, and the parameter would part or overlap them",
    engine.JUMP_IN_SLACK: "the drive changed at an instant that depends on the parameter while a "
    "string was slack",
}

# Weights of values at x + k h for the first derivative, over h: k = -4..4, and k = 0..8.
_CENTRAL = (1 / 280, -4 / 105, 1 / 5, -4 / 5, 0.0, 4 / 5, -1 / 5, 4 / 105, -1 / 280)
_FORWARD = (-761 / 280, 8.0, -14.0, 56 / 3, -35 / 2, 56 / 5, -14 / 3, 8 / 7, -1 / 8)
# The width h, as a share of the parameter's size: truncation and rounding are both below 1e-12.
_WIDTH = 2e-3


def checked_names(names: Any, plan: RunPlan) -> tuple[Parameter, ...]:
    """Return the parameters of these names, each of which must act on the run.

    Raises
    ------
    InputError
        If derivatives with respect to one of them, or of such a run, do not exist.
    """
    if isinstance(names, str):
        names = [names]
    try:
        wanted = list(names)
    except TypeError:
        wanted = [names]
    known = known_parameters(plan)
    for name in wanted:
        if name not in known:
            raise InputError(
                f"has no parameter {name!r}: {suggest(str(name), list(known))}",
                parameter="sensitivity_to",
            )
    if len(set(wanted)) < len(wanted):
        repeated = next(name for i, name in enumerate(wanted) if name in wanted[:i])
        raise InputError(f"names {repeated} twice", parameter="sensitivity_to")
    _check_run(plan)
    return tuple(known[name] for name in wanted)


def known_parameters(plan: RunPlan) -> dict[str, Parameter]:
    """Return the parameters of a run that are numbers of its laws or of its start."""
    known = parameters_of(plan.system, plan.drive)
    if plan.offset is None:
        known.pop("initial_offset", None)
    else:
        known.pop("initial_angle", None)
    return known


def _check_run(plan: RunPlan) -> None:
    """Raise InputError if a run has no derivatives."""
    where = {"parameter": "sensitivity_to"}
    if plan.noise is not None:
        raise InputError("needs a run without noise", way_out="leave the noise out", **where)
    if type(plan.law) not in (ExactContact, PassThrough):
        raise InputError(
            "needs exact contact: this contact law has no derivatives with respect to parameters",
            way_out="leave contact out", **where,
        )  # fmt: skip
    drive, system = plan.drive, plan.system
    if drive.acceleration not in CHANGES:
        raise InputError(
            f"needs the derivatives of the pivot's motion, and {type(drive).__name__} has formulas "
            "of its own",
            way_out="write the drive as segments (Drive.write), whose derivatives are known",
            **where,
        )
    if system.restoring not in (restoring_sine, restoring_linear):
        raise InputError(
            f"needs a restoring factor of the package, and {type(system).__name__} has its own",
            **where,
        )
    if plan.start.distances and min(plan.start.distances) < max(b.length for b in system.balls):
        is_slack = any(
            distance < ball.length
            for distance, ball in zip(plan.start.distances, system.balls, strict=True)
        )
        if is_slack:
            raise InputError("needs a run that begins with taut strings", **where)


def directions_of(plan: RunPlan, parameters: Sequence[Parameter]) -> Directions:
    """Return how all numbers of a run change per unit of each parameter.

    Raises
    ------
    InputError
        If a parameter acts on nothing, as a mass without drag.
    """
    segments = records.segment_records(plan.drive, plan.end)
    changes = np.zeros(len(parameters), dtype=CHANGE)
    segment_changes = np.zeros((len(parameters), len(segments)), dtype=segments.dtype)
    start = np.zeros((4, len(parameters)))
    for p, parameter in enumerate(parameters):
        slopes = _slopes(plan, parameter)
        change = changes[p]
        change["bodies"] = _rows(slopes["bodies"], change["bodies"].dtype, (4,))
        for name in ("gravity", "low", "high", "restitution", "string_restitution"):
            change[name] = slopes[name]
        change["offset_low"], change["offset_high"] = slopes["offset_low"], slopes["offset_high"]
        change["radius"] = slopes["radius"]
        own = slopes["segments"]
        change["moves_pivot"] = bool(np.any(own))
        segment_changes[p] = _rows(own, segments.dtype, segments.shape)
        start[:, p] = slopes["start"]
        if not _acts(plan, change, own, slopes["start"]):
            raise InputError(
                f"names {parameter.name}, which does not act on this run",
                parameter="sensitivity_to",
                way_out="leave it out; a mass acts only through drag or on another ball",
            )  # fmt: skip
    return Directions(changes, segment_changes, start)


def _acts(plan: RunPlan, change: Any, segments: Floats, start: Floats) -> bool:
    """Return whether a parameter acts on a run: not all numbers matter to all systems."""
    system, bodies = plan.system, change["bodies"]
    names = ["inverse_length", "damping_rate", "quadratic", "coulomb"]
    if system.angles == 2:
        names.append("inertia")
    if system.drag_frame == "lab":
        names += ["wind_drag", "wind_offset"]
    seen = [bodies[name] for name in names] + [change["gravity"], segments, start]
    if system.has_contacts and plan.law.meets:
        seen += [change[name] for name in ("low", "high", "restitution")]
    if system.suspension == "string":
        seen += [change["radius"], change["string_restitution"]]
    return any(np.any(values) for values in seen)


def _rows(values: Floats, kind: np.dtype[Any], shape: tuple[int, ...]) -> Any:
    """Return plain numbers as records of floats."""
    return np.ascontiguousarray(values).view(kind).reshape(shape)


def _slopes(plan: RunPlan, parameter: Parameter) -> dict[str, Floats]:
    """Return the derivatives of the numbers of a run with respect to a parameter, by name."""
    value = _value_of(plan, parameter)
    largest = max(abs(end) for end in parameter.suggested) if parameter.suggested else 1.0
    width = _WIDTH * (abs(value) or largest)
    at = _numbers(plan, parameter.name, value)
    refusal = None
    for weights, first, sign in ((_CENTRAL, -4, 1.0), (_FORWARD, 0, 1.0), (_FORWARD, 0, -1.0)):
        places = [value + sign * (first + k) * width for k in range(len(weights))]
        if not all(place in parameter.allowed for place in places):
            continue
        try:
            around = [_numbers(plan, parameter.name, place) for place in places]
        except InputError as error:  # laws may forbid more, such as a radius beyond the length
            refusal = error
            continue
        slopes = {name: np.zeros_like(middle) for name, middle in at.items()}
        for weight, each in zip(weights, around, strict=True):
            for name, middle in at.items():
                moves = each[name] != middle  # walls that balls never meet are infinite
                slopes[name][moves] += sign * weight * (each[name][moves] - middle[moves]) / width
        return slopes
    raise refusal or InputError(
        f"names {parameter.name}, which its limits leave no room to change",
        parameter="sensitivity_to",
    )


def _value_of(plan: RunPlan, parameter: Parameter) -> float:
    """Return a parameter's value in a run."""
    name, system, drive = parameter.name, plan.system, plan.drive
    if parameter.owner in ("system", "drive") and name in _RATIOS:
        return float(_RATIOS[name][1](system, drive))
    if parameter.owner in ("system", "drive"):
        value: Any = system if parameter.owner == "system" else drive
        for part in parameter.path:
            value = getattr(value, part)
        return float(value)
    if name == "initial_offset":
        assert plan.offset is not None
        return plan.offset
    stem, ball = _ball_of(name)
    if stem == "initial_angle":
        return plan.start.angles[ball]
    if stem == "initial_angular_velocity":
        return plan.start.velocities[ball]
    return float(plan.start.distances[ball] if plan.start.distances else system.balls[ball].length)


def _ball_of(name: str) -> tuple[str, int]:
    """Return the name of a start's parameter without its ball, and which ball it is."""
    for ball, side in enumerate(("_right", "_left")):
        if name.endswith(side):
            return name.removesuffix(side), ball
    return name, 0


def _lift(system: System, drive: Any) -> float:
    """Return the acceleration amplitude of a cosine per gravity."""
    lifted: float = drive.drive_amplitude * drive.drive_frequency**2
    return lifted / system.gravity


# Ratios that stand for a number of the drive: which, the ratio, and that number for a ratio.
_RATIOS: dict[str, tuple[str, Callable[..., float], Callable[..., float]]] = {
    "frequency_ratio": (
        "drive_frequency",
        lambda system, drive: drive.drive_frequency / system.natural_frequency,
        lambda system, drive, ratio: ratio * system.natural_frequency,
    ),
    "amplitude_ratio": (
        "drive_amplitude",
        lambda system, drive: drive.drive_amplitude / system.balls[0].length,
        lambda system, drive, ratio: ratio * system.balls[0].length,
    ),
    "drive_acceleration_ratio": (
        "drive_amplitude",
        _lift,
        lambda system, drive, ratio: ratio * system.gravity / drive.drive_frequency**2,
    ),
}


def _varied(plan: RunPlan, name: str, value: float) -> tuple[System, Drive, Start]:
    """Return the laws and the start of a run in which one parameter has another value."""
    system, drive, start = plan.system, plan.drive, plan.start
    parameter = parameters_of(system, drive)[name]
    if name in _RATIOS:
        target, _, number = _RATIOS[name]
        drive = replace(drive, **{target: number(system, drive, value)})
    elif parameter.owner == "system":
        system = replaced(system, {parameter.path: value})
    elif parameter.owner == "drive":
        drive = replaced(drive, {parameter.path: value})
    elif name != "initial_offset":
        stem, ball = _ball_of(name)
        field = {"initial_angle": "angles", "initial_angular_velocity": "velocities"}[stem]
        numbers = list(getattr(start, field))
        numbers[ball] = value
        start = replace(start, **{field: tuple(numbers)})
    if plan.offset is not None:
        assert isinstance(system, LatoLato)
        offset = value if name == "initial_offset" else plan.offset
        start = replace(start, angles=(system.contact_angle_low + offset,))
    return system, drive, start


def _numbers(plan: RunPlan, name: str, value: float) -> dict[str, Floats]:
    """Return what the engine reads of a run in which one parameter has another value."""
    system, drive, start = _varied(plan, name, value)
    case = prepared_case(system, drive, start, plan.end, plan.law, plan.step)
    settings, bodies, state = case["settings"][0], case["bodies"][0], case["state"][0]
    segments = records.segment_records(drive, plan.end)
    result = {
        field: np.array(settings[field], dtype=np.float64)
        for field in (
            "gravity", "low", "high", "restitution", "string_restitution", "offset_low",
            "offset_high", "radius",
        )
    }  # fmt: skip
    result["bodies"] = bodies.view(np.float64).copy()
    result["segments"] = segments.view(np.float64).copy()
    angles, velocities = state["angle"], state["velocity"]
    result["start"] = np.array([angles[0], velocities[0], angles[1], velocities[1]])
    return result


def batches_of(parameters: Sequence[Parameter]) -> list[Sequence[Parameter]]:
    """Return parameters in groups that one run can carry."""
    return [
        parameters[first : first + MOST_PARAMETERS]
        for first in range(0, len(parameters), MOST_PARAMETERS)
    ]
