"""A sweep as a frozen, hashable plan: what is varied, what is gathered, and in which chunks."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from latolato.core.errors import InputError
from latolato.core.parameters import Parameter
from latolato.core.registry import (
    describe,
    number_fields,
    rebuild,
    suggest,
)
from latolato.core.rules import broken_rule
from latolato.core.versions import FORMAT, check_format
from latolato.observables import Observable, observables
from latolato.physics.contacts import ContactLaw, ExactContact, contact_laws
from latolato.physics.drives import Drive, Harmonic, PeriodicDrive, drives
from latolato.physics.noise import KEY, STREAMS, VelocityKicks
from latolato.physics.pendulum import System, systems
from latolato.physics.problems import TRANSIENT, refusal
from latolato.simulation.parameters import RUN_PARAMETERS, SWEEP_PARAMETERS
from latolato.simulation.start import (
    DEFAULT_REST_SPEED,
    check_perturbations,
    check_strings,
    checked_contact,
    checked_drive,
    checked_numbers,
    checked_offset,
    checked_system,
    warn_of_degrees,
)
from latolato.simulation.vary import parameters_of, replaced
from latolato.sweeps.axes import Axis, checked_axes, is_replaced, names_in, unknown_parameter

DEFAULT_OBSERVABLES = ("mean_energy", "crossings", "largest_angle")
# More points than this are refused: they would take days to compute, and fill a disk.
_MOST_POINTS = 1_000_000_000
# Velocity kicks of a chunk's points are in memory at once, in 16 bytes each.
_KICKS_OF_A_CHUNK = 4_000_000


@dataclass(frozen=True, kw_only=True)
class Plan:
    """Everything that determines the numbers of a sweep.

    Attributes
    ----------
    shape : tuple of int
        Points along each axis; points are numbered in C order.
    chunk_size : int
        Points of a chunk, which is what a worker takes and a store writes at once.
    """

    system: System
    drive: Drive
    axes: tuple[Axis, ...]
    observables: tuple[Observable, ...]
    start: tuple[tuple[str, float], ...]
    duration: float
    transient: float = 0.0
    transient_periods: float = 0.0
    tolerance: float = 1e-6
    contact: ContactLaw = field(default_factory=ExactContact)
    rest_speed: float = DEFAULT_REST_SPEED
    contact_limit: int = 1_000_000
    noise: VelocityKicks | None = None
    continuation: str = ""
    direction: str = "up"
    chunk_size: int = 4096

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions; a continuation both ways adds `direction` in front."""
        names = tuple(axis.name for axis in self.axes)
        return ("direction", *names) if self.direction == "both" else names

    @property
    def shape(self) -> tuple[int, ...]:
        """Points along each dimension."""
        lengths = tuple(len(axis) for axis in self.axes)
        return (2, *lengths) if self.direction == "both" else lengths

    @property
    def varied(self) -> set[str]:
        """Names of the parameters that vary, derived ones by their own name."""
        return {name for axis in self.axes for name in axis.parameters}

    @property
    def own_streams(self) -> bool:
        """Whether each point has its own random stream, counted from that of the noise.

        Where seed or stream is an axis, points that differ in other parameters see equal kicks.
        """
        return self.noise is not None and not self.varied & set(KEY)

    @property
    def size(self) -> int:
        """Number of points."""
        return math.prod(self.shape)

    @cached_property
    def chunk_shape(self) -> tuple[int, ...]:
        """Extent of a chunk along each dimension: the last ones whole as far as they fit.

        The axis of a continuation is never cut.
        """
        room, result = self.chunk_size, []
        whole = len(self.dims)
        if self.continuation:
            whole = self.dims.index(self.continuation)
            room = max(1, room // self.shape[whole])
        for number in reversed(range(len(self.shape))):
            length = self.shape[number]
            if number == whole:
                result.append(length)
                continue
            extent = 1 if self.dims[number] == "direction" else min(length, max(1, room))
            result.append(extent)
            room //= extent  # one is left where an axis is cut
        return tuple(reversed(result))

    @property
    def chunk_counts(self) -> tuple[int, ...]:
        """Number of chunks along each dimension."""
        return tuple(-(-n // c) for n, c in zip(self.shape, self.chunk_shape, strict=True))

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return math.prod(self.chunk_counts)

    def block(self, number: int) -> tuple[slice, ...]:
        """Return the part of the grid that chunk `number` covers."""
        place = np.unravel_index(number, self.chunk_counts)
        return tuple(
            slice(int(i) * c, min((int(i) + 1) * c, n))
            for i, c, n in zip(place, self.chunk_shape, self.shape, strict=True)
        )

    def describe(self) -> dict[str, Any]:
        """Return the plan as plain values, for attributes and for its hash."""
        contact: dict[str, Any] = {"kind": contact_laws.name_of(self.contact)}
        return {
            "format": FORMAT,
            "system": systems.described(self.system),
            "drive": drives.described(self.drive),
            "axes": [
                {
                    "name": axis.name,
                    "parameters": list(axis.parameters),
                    "values": [list(values) for values in axis.values],
                }
                for axis in self.axes
            ],
            "observables": [observables.described(o) for o in self.observables],
            "start": dict(self.start),
            "contact": contact | describe(self.contact),
            "noise": None if self.noise is None else describe(self.noise),
            **{
                name: getattr(self, name)
                for name in (
                    "duration",
                    "transient",
                    "transient_periods",
                    "tolerance",
                    "rest_speed",
                    "contact_limit",
                    "continuation",
                    "direction",
                    "chunk_size",
                )
            },
        }

    @classmethod
    def from_description(cls, described: Mapping[str, Any]) -> Plan:
        """Return the plan that `describe` described, also after a way through JSON.

        Raises
        ------
        InputError
            If a newer format or something else was described.
        """
        check_format(described.get("format"), "a plan")

        def law(known: Mapping[str, type], entry: Mapping[str, Any]) -> Any:
            return rebuild(known[entry["kind"]], {k: v for k, v in entry.items() if k != "kind"})

        rest = {k: v for k, v in described.items() if k != "format"}
        try:
            noise = rest["noise"]
            return cls(
                **rest
                | {
                    "system": law(systems, rest["system"]),
                    "drive": law(drives, rest["drive"]),
                    "axes": tuple(
                        Axis(
                            axis["name"],
                            tuple(axis["parameters"]),
                            tuple(tuple(values) for values in axis["values"]),
                        )
                        for axis in rest["axes"]
                    ),
                    "observables": tuple(law(observables, o) for o in rest["observables"]),
                    "start": tuple(sorted(rest["start"].items())),
                    "contact": law(contact_laws, rest["contact"]),
                    "noise": None if noise is None else rebuild(VelocityKicks, noise),
                }
            )
        except (KeyError, TypeError, AttributeError) as error:
            raise InputError(f"this describes no plan of a sweep: {error}") from None

    @cached_property
    def hash(self) -> str:
        """Digest of everything that determines the numbers and their layout."""
        text = json.dumps(self.describe(), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:32]


def make_plan(
    system: System,
    drive: Drive | None = None,
    *,
    axes: Mapping[str, Any],
    duration: float,
    observables: Sequence[str | Observable] = DEFAULT_OBSERVABLES,
    initial_angle: float | Sequence[float] | None = None,
    initial_angular_velocity: float | Sequence[float] = 0.0,
    initial_offset: float | None = None,
    initial_distance: float | Sequence[float] | None = None,
    transient: float = 0.0,
    transient_periods: float = 0.0,
    tolerance: float = 1e-6,
    contact: str | ContactLaw | None = "exact",
    rest_speed: float = DEFAULT_REST_SPEED,
    contact_limit: int = 1_000_000,
    noise: VelocityKicks | None = None,
    continuation: str | None = None,
    direction: str = "up",
    chunk_size: int | None = None,
) -> Plan:
    """Return the plan of a sweep; parameters and errors are those of `latolato.sweep`."""
    checked_system(system)
    if noise is not None and not isinstance(noise, VelocityKicks):
        raise InputError("must be VelocityKicks or None", parameter="noise", value=noise)
    varied_names = names_in(axes)
    noise = _noise_for(noise, varied_names)
    drive = _drive_for(system, drive, varied_names, noise)
    known = parameters_of(system, drive, noise)
    dimensions = checked_axes(axes, known)
    watched = tuple(checked_observable(o) for o in _listed(observables))
    _check_laws(system, drive, dimensions, known, watched)
    varied = {name for axis in dimensions for name in axis.parameters}
    length = RUN_PARAMETERS["duration"].checked(duration)
    transient = SWEEP_PARAMETERS["transient"].checked(transient)
    periods = SWEEP_PARAMETERS["transient_periods"].checked(transient_periods)
    if transient >= length:
        raise refusal(TRANSIENT, (transient, length))
    law = checked_contact(contact, system)
    _check_observables(watched, system, drive, law)
    names = {axis.name for axis in dimensions}
    for name in (name for o in watched for name in o.variables):
        if name in names:
            raise InputError(f"axis name '{name}' is that of an observable: choose another")
    direction = SWEEP_PARAMETERS["direction"].checked(direction)
    if continuation is None and direction != "up":
        raise InputError(f"direction {direction!r} needs a continuation: name the axis to follow")
    if continuation is not None:
        if system.suspension == "string":
            raise InputError(
                "needs rods: where a slack ball is, is not carried on from point to point",
                parameter="continuation",
                way_out="leave it out, or give suspension='rod'",
            )
        _check_continuation(continuation, dimensions, drive, noise)
    plan = Plan(
        system=system,
        drive=drive,
        axes=dimensions,
        observables=watched,
        start=_start(
            system,
            varied,
            {
                "initial_angle": initial_angle,
                "initial_angular_velocity": initial_angular_velocity,
                "initial_distance": initial_distance,
            },
            initial_offset,
        ),
        duration=length,
        transient=transient,
        transient_periods=periods,
        tolerance=RUN_PARAMETERS["tolerance"].checked(tolerance),
        contact=law,
        rest_speed=RUN_PARAMETERS["rest_speed"].checked(rest_speed),
        contact_limit=RUN_PARAMETERS["contact_limit"].checked(contact_limit),
        noise=noise,
        continuation=continuation or "",
        direction=direction,
        chunk_size=1 if chunk_size is None else SWEEP_PARAMETERS["chunk_size"].checked(chunk_size),
    )
    if plan.size > _MOST_POINTS:
        numbers = sum(len(o.variables) for o in watched)
        raise InputError(
            f"{' x '.join(map(str, plan.shape))} points exceed the limit of {_MOST_POINTS:,}: "
            f"their results would take {8e-9 * numbers * plan.size:,.0f} GB",
            way_out="take fewer values along an axis, or split the map",
        )
    if noise is not None and plan.own_streams and noise.noise_stream + plan.size not in STREAMS:
        raise broken_rule("streams", {"count": plan.size, "first": noise.noise_stream})
    for name, values in _start_angles(plan).items():
        warn_of_degrees(name, values, stacklevel=3)
    return plan if chunk_size is not None else replace(plan, chunk_size=_usual_chunk_size(plan))


def _start_angles(plan: Plan) -> dict[str, Iterable[float]]:
    """Return the initial angles of a sweep by name [rad], fixed ones and those along its axes."""
    result: dict[str, Iterable[float]] = {name: (value,) for name, value in plan.start}
    for axis in plan.axes:
        result |= dict(zip(axis.parameters, axis.values, strict=True))
    names = ("initial_angle", "initial_angle_right", "initial_angle_left")
    return {name: result[name] for name in names if name in result}


def _usual_chunk_size(plan: Plan) -> int:
    """Return how many points fill SIMD lanes, but leave work for several threads and progress."""
    size = min(max(plan.size // 4, 256), 4096)
    if plan.noise is None:
        return size
    kicks = max(1.0, plan.duration / plan.noise.spacing(plan.system) * plan.system.angles)
    return int(min(size, max(_KICKS_OF_A_CHUNK / kicks, 1.0)))


def _noise_for(noise: VelocityKicks | None, varied: set[str]) -> VelocityKicks | None:
    """Return the noise, some of it if there is none but the axes vary its strength."""
    kicks = VelocityKicks(noise_strength=0.0)
    of_noise = sorted(varied & {f.name for f in number_fields(kicks)})
    if noise is not None or not of_noise:
        return noise
    if "noise_strength" in of_noise:
        return kicks
    raise InputError(
        f"axis {of_noise[0]} needs noise: give VelocityKicks(noise_strength=...) or an axis "
        "noise_strength"
    )


def _drive_for(
    system: System, drive: Drive | None, varied: set[str], noise: VelocityKicks | None
) -> Drive:
    """Return the drive, a harmonic one if there is none but the axes vary one."""
    if drive is not None:
        return checked_drive(drive, system)
    amplitudes = {"drive_amplitude", "amplitude_ratio", "drive_acceleration_ratio"}
    frequencies = {"drive_frequency", "frequency_ratio"}
    harmonic = Harmonic(drive_amplitude=0.0, drive_frequency=0.0)
    known = parameters_of(system, harmonic, noise)
    for name in varied:
        if name not in known:
            raise unknown_parameter(name, known)
    if varied & amplitudes and varied & frequencies:
        return harmonic
    if varied & (amplitudes | frequencies | {"drive_phase"}):
        name = sorted(varied & (amplitudes | frequencies | {"drive_phase"}))[0]
        raise InputError(f"axis {name} needs a drive: give one, for example Harmonic")
    return checked_drive(None)


def _check_laws(
    system: System,
    drive: Drive,
    axes: Sequence[Axis],
    known: Mapping[str, Parameter],
    watched: Sequence[Observable],
) -> None:
    """Raise InputError if axes vary what the laws of the sweep do not describe."""
    exponents = [next(iter(o.variables)) for o in watched if o.tangent is not None]
    for axis in axes:
        for name, values in zip(axis.parameters, axis.values, strict=True):
            if name == "string_restitution" or name.startswith("initial_distance"):
                check_strings(system, name)
            if name.endswith("quadratic_damping"):
                replaced(system, {known[name].path: max(values)})
            if name.endswith("coulomb_damping") and exponents:
                check_perturbations(replaced(system, {known[name].path: max(values)}), exponents[0])
            if name == drive.across_parameter:
                checked_drive(replaced(drive, {known[name].path: max(values)}), system)


def _listed(value: Any) -> list[Any]:
    """Return the requested observables as a list."""
    if isinstance(value, (str, Observable)):
        return [value]
    if not isinstance(value, Iterable):
        raise InputError("must be names or instances", parameter="observables", value=value)
    result = list(value)
    if not result:
        raise InputError(f"observables must name at least one of {', '.join(observables)}")
    return result


def checked_observable(value: Any) -> Observable:
    """Return an observable from its name, that of one of its variables, or itself."""
    if isinstance(value, Observable):
        return value
    if not isinstance(value, str):
        raise InputError("an observable must be a name or an instance", value=value)
    kinds: Mapping[str, Any] = observables
    owners = [kind for kind in kinds.values() if value in kind.variables]
    kind = owners[0] if owners and value not in kinds else kinds[value]
    result: Observable = kind()
    return result


def _check_observables(
    watched: Sequence[Observable], system: System, drive: Drive, law: ContactLaw
) -> None:
    """Raise InputError unless observables go together, and with the laws of a run."""
    names = [name for o in watched for name in o.variables]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"two observables both give '{name}': drop one")
    counts = sorted({o.marks for o in watched} - {0})
    if counts and not isinstance(drive, PeriodicDrive):
        raise broken_rule("single_period", {"name": drives.name_of(drive)})
    if len(counts) > 1:  # marks are numbered for all observables together
        raise InputError(
            f"observables that look once per drive period must mark equally many periods, got "
            f"{' and '.join(map(str, counts))}: set their periods alike"
        )
    for observable in watched:
        observable.check_memory()
        name = next(iter(observable.variables))
        if observable.angles not in (0, system.angles):
            raise InputError(
                f"{name} belongs to systems of {observable.angles} angles, got a system of "
                f"{system.angles}"
            )
        if observable.of_strings:
            check_strings(system, name)
        if "compression" in observable.needs and system.suspension == "string":
            raise broken_rule("of_rods", parameter=name)
        if observable.tangent is not None:
            check_perturbations(system, name)
        if observable.tangent is not None and law.fixed_step is not None:
            raise broken_rule("exact_contact", {"name": name})


def _start(
    system: System,
    varied: set[str],
    given: Mapping[str, Any],
    offset: Any,
) -> tuple[tuple[str, float], ...]:
    """Return the start's parameters that do not vary, by name."""
    sides = ("",) if system.angles == 1 else ("_right", "_left")
    fixed: dict[str, float] = {}
    if offset is not None:
        fixed["initial_offset"] = checked_offset(system, given["initial_angle"], offset)
    if given["initial_distance"] is not None:
        check_strings(system, "initial_distance")
    for name, value in given.items():
        if value is not None:
            allowed = RUN_PARAMETERS[name].allowed
            numbers = checked_numbers(name, value, system.angles, allowed)
            fixed |= {name + side: number for side, number in zip(sides, numbers, strict=True)}
    for name, value in {**given, "initial_offset": offset}.items():
        # Velocities are 0 by default.
        if is_replaced(name, system, varied) and value is not None and np.any(value):
            raise InputError(
                "is given as a value and varied along an axis",
                parameter=name,
                value=value,
                way_out="drop one",
            )
    starts = ("initial_angle", "initial_offset")
    for name, other in zip(starts, reversed(starts), strict=True):
        if name in varied and other in fixed:
            raise InputError(f"give only one of {{parameter}} and an axis {name}", parameter=other)
    if varied & set(starts):
        fixed = {k: v for k, v in fixed.items() if k not in starts}
    missing = [f"initial_angle{s}" for s in sides if f"initial_angle{s}" not in {*fixed, *varied}]
    if missing and "initial_offset" not in {*fixed, *varied}:
        raise broken_rule("axis_needed", {"name": missing[0]})
    return tuple(sorted((k, v) for k, v in fixed.items() if k not in varied))


def _check_continuation(
    name: Any, axes: Sequence[Axis], drive: Drive, noise: VelocityKicks | None
) -> None:
    """Raise InputError unless a sweep can follow the motion along this axis."""
    names = [axis.name for axis in axes]
    if name not in names:
        raise InputError(
            f"continuation must name an axis, got '{name}': {suggest(str(name), names)}"
        )
    axis = axes[names.index(name)]
    for number, values in enumerate(axis.values):
        steps = np.diff(values)
        rises, falls = np.all(steps >= 0.0), np.all(steps <= 0.0)
        if not (rises or falls) or (number == 0 and np.any(steps == 0.0)):
            raise InputError(
                f"axis {name} must increase or decrease steadily to be followed; sort the values "
                f"of {axis.parameters[number]}"
            )
    starts = [p for p in axis.parameters if p.startswith("initial_")]
    if starts:
        raise InputError(
            f"continuation along {starts[0]} is impossible: each point starts where the one "
            "before ended"
        )
    if drive.moves and not isinstance(drive, PeriodicDrive):
        raise InputError(
            "continuation needs a drive that goes on: a periodic one, such as harmonic, or none",
            value=drives.name_of(drive),
        )
    if noise is not None:
        raise InputError("continuation and noise exclude each other")
