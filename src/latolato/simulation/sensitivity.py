"""Derivatives of a run with respect to its parameters: which, along which numbers, and how known.

A parameter acts through the numbers that the engine reads: geometry of the contact, bodies, forces,
drive and start. How these depend on it is a chain of smooth formulas without any motion in it
(`numerics.prepare`, `Drive.write`). Its derivative is found by differences of sixth order, which
are exact to some 1e-13 of it, for any law; all that follows in time is differentiated exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError
from latolato.core.parameters import Parameter
from latolato.core.quantities import Range
from latolato.core.registry import suggest
from latolato.numerics import records
from latolato.numerics.engine import doubts
from latolato.numerics.engine.taut_step import STILL
from latolato.numerics.integrate import Directions, Floats, Start, prepared_numbers
from latolato.numerics.run_record import CHANGE, MOST_PARAMETERS
from latolato.physics.contacts import ContactLaw, ExactContact, PassThrough
from latolato.physics.drives import Drive
from latolato.physics.drives.segment import CHANGES
from latolato.physics.pendulum import LatoLato, System, restoring_linear, restoring_sine
from latolato.simulation.vary import DERIVED, parameters_of, replaced

if TYPE_CHECKING:
    from latolato.simulation.plan import RunPlan

# What the engine reads of a run: records of `CHANGE` and of segments, and the start.
Numbers = dict[str, NDArray[Any]]

# Why derivatives are not known from some instant on.
DOUBTS = {
    doubts.GRAZING: "a ball grazed a contact, where derivatives grow beyond all bounds",
    doubts.TOGETHER: "two events fell on one instant, and a change of a parameter parts them",
    doubts.CAPTURED: "the last bounces of a capture were not followed one by one",
    doubts.START: "at the start the balls touch, and the parameter would part or overlap them",
    doubts.JUMP_IN_SLACK: "the drive changed at an instant that depends on the parameter while a "
    "string was slack",
}

# Weights of values at x + k h for the first derivative, over h, of sixth order; the values at x
# need none, as all are taken as differences to them.
_CENTRAL = {-3: -1 / 60, -2: 3 / 20, -1: -3 / 4, 1: 3 / 4, 2: -3 / 20, 3: 1 / 60}
_FORWARD = {1: 6.0, 2: -15 / 2, 3: 20 / 3, 4: -15 / 4, 5: 6 / 5, 6: -1 / 6}
# The width h, as a share of the parameter's size: what it leaves is below rounding, some 1e-13.
_WIDTH = 2e-3
# The same of second order, with a third of the formulas to compute, exact to some 1e-8.
_QUICK, _QUICK_WIDTH = {-1: -0.5, 1: 0.5}, 1e-4
# Segments are looked for up to this multiple of a run's end, beyond what these widths may shift.
_BEYOND = 1.1


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
        if not isinstance(name, str) or name not in known:
            raise InputError(
                f"has no parameter {name!r}: {suggest(str(name), list(known))}",
                parameter="sensitivity_to",
            )
    if len(set(wanted)) < len(wanted):
        repeated = next(name for i, name in enumerate(wanted) if name in wanted[:i])
        raise InputError(f"names {repeated} twice", parameter="sensitivity_to")
    setters: dict[str, str] = {}
    for name in wanted:
        other = setters.setdefault(DERIVED.get(name, name), name)
        if other != name:
            raise InputError(
                f"names {other} and {name}, which both set {DERIVED.get(name, name)}",
                parameter="sensitivity_to",
                way_out="leave one out",
            )
    if "drive_acceleration_ratio" in wanted and plan.drive.drive_frequency == 0.0:  # type: ignore[attr-defined]
        raise InputError(
            "names drive_acceleration_ratio, which sets no amplitude at frequency 0",
            parameter="sensitivity_to",
            way_out="leave it out",
        )
    for name in wanted:
        # At rest is what the engine takes for it: `STILL` rad/s, and as near to the bottom in rad.
        ball = int(name.endswith("_left"))
        if (
            name.startswith("initial_angular_velocity")
            and abs(plan.start.velocities[ball]) < STILL
            and plan.system.balls[ball].coulomb_damping > 0.0
        ):
            raise InputError(
                f"names {name}, and a ball at rest that is pushed either way is slowed by dry "
                "friction: the derivatives on both sides differ",
                parameter="sensitivity_to",
                way_out="let the ball move at the start, or leave dry friction out",
            )
        left = int(name == "left_coulomb_damping")
        if (
            name.endswith("coulomb_damping")
            and max(abs(plan.start.angles[left]), abs(plan.start.velocities[left])) < STILL
            and not plan.drive.moves_across
        ):
            raise InputError(
                f"names {name}, and a ball that hangs at rest has no direction that friction "
                "opposes",
                parameter="sensitivity_to",
                way_out="give it an angle or a velocity at the start",
            )
    _check_run(plan)
    return tuple(known[name] for name in wanted)


def known_parameters(plan: RunPlan) -> dict[str, Parameter]:
    """Return the parameters of a run that are numbers of its laws or of its start."""
    # Strings are taut at the start, and the sigmas of a table choose the knots of a spline.
    known = {
        name: parameter
        for name, parameter in parameters_of(plan.system, plan.drive).items()
        if not name.startswith("initial_distance") and not name.endswith("_sigma")
    }
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

    Ratios among all parameters of the plan keep their values while the others change.

    Raises
    ------
    InputError
        If a parameter acts on nothing, as a mass without drag.
    """
    slopes = []
    ratios = [each for each in plan.sensitivity_to if each.name in _RATIOS]
    held = {ratio.name: _value_of(plan, ratio) for ratio in ratios}
    laws = [(plan.system, plan.drive, plan.start)]
    still = numbers_of(laws, plan.end, plan.law, plan.step) | segments_of([plan.drive], plan.end)
    unchanged = {name: np.zeros_like(middle[0]) for name, middle in still.items()}
    for parameter in parameters:
        if parameter.owner == "run":
            unit = np.eye(4)[_place_of(parameter.name)]
            slopes.append({**unchanged, "start": unit})
            continue
        value = _value_of(plan, parameter)
        if parameter.unit == "rad":  # a phase acts by its sine, however large it is
            size = 1.0
        else:
            size = abs(value) or max(map(abs, parameter.suggested or (1.0,)))

        def numbers(values: Sequence[float], parameter: Parameter = parameter) -> Numbers:
            varied = [_varied(plan, parameter, value, held) for value in values]
            result: Numbers = {}
            if parameter.owner == "system":
                result |= numbers_of(varied, plan.end, plan.law, plan.step)
            if varied[0][1] is not plan.drive:
                result |= segments_of([drive for _, drive, _ in varied], plan.end)
            return result

        own = unchanged | slopes_of(parameter.name, numbers, value, size, parameter.allowed)
        if not _acts(plan, own):
            only = ", as it does through drag or on another ball" * ("mass" in parameter.path)
            raise InputError(
                f"names {parameter.name}, which does not act on this run{only}",
                parameter="sensitivity_to",
                way_out="leave it out",
            )
        slopes.append(own)
    return joined(slopes)


def joined(slopes: Sequence[Numbers]) -> Directions:
    """Return the derivatives of a run's numbers with respect to several parameters together."""
    changes = np.array([each["changes"] for each in slopes])
    changes["moves_pivot"] = [np.any(_floats(each["segments"])) for each in slopes]
    return Directions(
        changes,
        np.array([each["segments"] for each in slopes]),
        np.column_stack([each["start"] for each in slopes]),
    )


def _acts(plan: RunPlan, slopes: Numbers) -> bool:
    """Return whether a parameter acts on a run: not all numbers matter to all systems."""
    system, change = plan.system, slopes["changes"]
    names = ["inverse_length", "damping_rate", "quadratic", "coulomb"]
    if system.angles == 2:
        names.append("inertia")
    if system.drag_frame == "lab":
        names += ["wind_drag", "wind_offset"]
    seen = [change["bodies"][name] for name in names]
    seen += [change["gravity"], _floats(slopes["segments"]), slopes["start"]]
    if system.has_contacts and plan.law.meets:
        seen += [change[name] for name in ("low", "high", "restitution")]
    if system.suspension == "string":
        seen += [change["radius"], change["string_restitution"]]
    return any(np.any(values) for values in seen)


def slopes_of(
    parameter: str,
    numbers: Callable[[Sequence[float]], Numbers],
    value: float,
    size: float,
    allowed: Range,
    *,
    is_quick: bool = False,
) -> Numbers:
    """Return the derivatives of the numbers of a run with respect to a parameter.

    Parameters
    ----------
    parameter : str
        Its name.
    numbers : callable
        Returns those of `numbers_of` or `segments_of` for several values of the parameter, the
        first of which is `value`.
    value, size : float
        Where, and how large a parameter of its kind is.
    allowed : Range
        Values that the parameter may have.
    is_quick : bool
        Whether an accuracy of 1e-8 will do, as it does for a search.

    Raises
    ------
    InputError
        If the parameter has no room to change.
    """
    refusal = None
    ways = [(_CENTRAL, _WIDTH), (_FORWARD, _WIDTH), (_FORWARD, -_WIDTH)]
    for weights, share in [(_QUICK, _QUICK_WIDTH), *ways] if is_quick else ways:
        width = share * size
        places = [value + k * width for k in weights]
        if not all(place in allowed for place in places):
            continue
        try:
            found = numbers([value, *places])
        except InputError as error:  # laws may forbid more, such as a radius beyond the length
            refusal = error
            continue
        slopes = {name: np.zeros_like(each[0]) for name, each in found.items()}
        shares = np.array(list(weights.values())) / width
        for name, each in found.items():
            here, *there = (_floats(numbers) for numbers in each)
            with np.errstate(invalid="ignore"):  # walls that balls never meet are infinite
                changes = [np.where(other != here, other - here, 0.0) for other in there]
            _floats(slopes[name])[:] = shares @ np.array(changes)
        return slopes
    why = f": {InputError(refusal.rule, parameter=refusal.parameter)}" if refusal else ""
    raise InputError(
        f"names {parameter}, whose value {value:g} leaves no room to change{why}",
        parameter="sensitivity_to",
        way_out="leave it out, or give another value",
    )


def _floats(numbers: Any) -> Floats:
    """Return the memory of numbers, of which all that differ are floats, as one row."""
    row: Floats = np.ravel(numbers).view(np.float64)
    return row


def _value_of(plan: RunPlan, parameter: Parameter) -> float:
    """Return the value of a parameter of a run's system or drive."""
    name, system, drive = parameter.name, plan.system, plan.drive
    if name in _RATIOS:
        return float(_RATIOS[name][1](system, drive))
    value: Any = system if parameter.owner == "system" else drive
    for part in parameter.path:
        value = getattr(value, part)
    return float(value)


def _place_of(name: str) -> int:
    """Return which number of the start a parameter is."""
    place = 1 if name.startswith("initial_angular_velocity") else 0
    return place + 2 if name.endswith("_left") else place


def _lift(system: System, drive: Any) -> float:
    """Return the acceleration amplitude of a cosine per gravity."""
    lifted: float = drive.drive_amplitude * drive.drive_frequency**2
    return lifted / system.gravity


# Ratios that stand for a number of the drive: which, the ratio, and that number for a ratio. An
# amplitude may follow from the frequency, which stands first.
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


def _varied(
    plan: RunPlan, parameter: Parameter, value: float, held: Mapping[str, float]
) -> tuple[System, Drive, Start]:
    """Return the laws and the start of a run whose system or drive has another value.

    The ratios `held` keep theirs: numbers of the drive follow.
    """
    system, drive, start = plan.system, plan.drive, plan.start
    if parameter.owner == "system":
        system = replaced(system, {parameter.path: value})
    elif parameter.name not in _RATIOS:
        drive = replaced(drive, {parameter.path: value})
    for ratio, (target, _, number) in _RATIOS.items():
        if ratio in held:
            own = value if ratio == parameter.name else held[ratio]
            drive = replace(drive, **{target: number(system, drive, own)})
    if plan.offset is not None:
        assert isinstance(system, LatoLato)
        start = replace(start, angles=(system.contact_angle_low + plan.offset,))
    return system, drive, start


def numbers_of(
    laws: Sequence[tuple[System, Any, Start]], end: float, law: ContactLaw, step: float
) -> Numbers:
    """Return what the engine reads of runs up to `end` [s] but for their drives: changes, starts.

    There is a row for each of the systems, drives and starts.
    """
    settings, bodies, states = prepared_numbers(laws, end, law, step)
    changes = np.zeros(len(laws), dtype=CHANGE)
    changes["bodies"] = bodies
    for name in CHANGE.names or ():
        if name in (settings.dtype.names or ()):
            changes[name] = settings[name]
    angles, velocities = states["angle"], states["velocity"]
    return {
        "changes": changes,
        "start": np.column_stack([angles[:, 0], velocities[:, 0], angles[:, 1], velocities[:, 1]]),
    }


def segments_of(drives: Sequence[Any], end: float) -> Numbers:
    """Return the segments of drives up to `end` [s], as many for each as the first one has.

    Raises
    ------
    InputError
        If the first one moves by a formula of its own, which has no derivatives then.
    """
    first, *others = drives
    segments = records.segment_records(first, end)
    result = [segments]
    for drive in others:
        # One that begins close to the end begins later for another value of the parameter.
        later = records.segment_records(drive, _BEYOND * end)[: len(segments)]
        same_forms = np.array_equal(later["form"], segments["form"])
        if not same_forms or drive.moves_across != first.moves_across:
            raise InputError("at this value the drive moves by a formula of its own")
        result.append(later)
    return {"segments": np.array(result)}


def batches_of(parameters: Sequence[Parameter]) -> list[Sequence[Parameter]]:
    """Return parameters in groups that one run can carry."""
    return [
        parameters[first : first + MOST_PARAMETERS]
        for first in range(0, len(parameters), MOST_PARAMETERS)
    ]
