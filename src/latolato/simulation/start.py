"""How a run begins: system, drive, contact law, walls, start and kicks, checked."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from latolato.core.errors import InputError
from latolato.core.quantities import ANY, NON_NEGATIVE, POSITIVE, QUANTITIES, Range
from latolato.core.registry import checked_array, checked_number, in_unit
from latolato.core.rules import broken_rule
from latolato.numerics.integrate import Floats, Start, prepared_runs
from latolato.numerics.prepare import cases_of, choose_stepper, move_between
from latolato.physics.contacts import ContactLaw, ExactContact, PassThrough, contact_laws
from latolato.physics.drives import Drive, FixedPivot, drives
from latolato.physics.noise import VelocityKicks
from latolato.physics.pendulum import BallPair, LatoLato, System, systems

DEFAULT_REST_SPEED = 1e-7  # rad/s
# More velocity kicks than this would fill the memory.
MOST_KICKS = 20_000_000


def checked_system(system: Any) -> System:
    """Return a system, or raise with what is known."""
    if not isinstance(system, System):
        raise InputError(f"must be one of {', '.join(systems)}", parameter="system", value=system)
    return system


def checked_drive(drive: Drive | None, system: System | None = None) -> Drive:
    """Return a drive that suits a system, a pivot at rest for None."""
    if drive is None:
        return FixedPivot()
    if not isinstance(drive, Drive):
        raise InputError(
            f"must be None or one of {', '.join(drives)}", parameter="drive", value=drive
        )
    if getattr(drive, "moves_across", False) and system is not None:
        name = type(drive).__name__
        if isinstance(system, LatoLato):
            raise broken_rule("mirrored_pivot", {"law": "LatoLato"}, parameter="drive", value=name)
        if system.is_linear:
            law = type(system).__name__
            raise broken_rule("vertical_pivot", {"law": law}, parameter="drive", value=name)
    return drive


def checked_contact(contact: Any, system: System) -> ContactLaw:
    """Return the contact law; systems that never meet a wall have none."""
    if contact is None:
        return PassThrough()
    law = contact_laws[contact]() if isinstance(contact, str) else contact
    if not isinstance(law, ContactLaw):
        names = ", ".join(contact_laws)
        raise broken_rule("one_of", {"names": names}, parameter="contact", value=contact)
    if not system.has_contacts:
        if not isinstance(law, (ExactContact, PassThrough)):
            raise broken_rule(
                "meeting_balls",
                {"name": contact_laws.name_of(law), "law": type(system).__name__},
                parameter="contact",
            )
        return PassThrough()
    law.check_system(system)
    if law.motion != "exact" and (system.suspension != "rod" or system.drag_frame != "pivot"):
        what = "strings" if system.suspension != "rod" else "drag_frame 'lab'"
        raise broken_rule(
            "clamped_rods",
            {"name": contact_laws.name_of(law), "what": what},
            parameter="contact",
        )
    return law


def walls_of(system: System, law: ContactLaw) -> tuple[float, float]:
    """Return the contact angles of one ball or the contact separations of two [rad]."""
    if not law.meets:
        return -math.inf, math.inf
    if isinstance(system, BallPair):
        return system.contact_separation, 2.0 * math.pi - system.contact_separation
    assert isinstance(system, LatoLato)
    return system.contact_angle_low, system.contact_angle_high


def between_walls(angles: Sequence[float] | Floats, walls: tuple[float, float]) -> Floats:
    """Return the angles of one or two balls, moved to the nearest wall if they lie beyond it."""
    result = np.array(angles, dtype=np.float64)
    move_between(result, len(result), *walls)
    return result


def checked_numbers(name: str, value: Any, count: int, allowed: Range = ANY) -> tuple[float, ...]:
    """Return one or two checked numbers of a start."""
    unit = QUANTITIES[name].unit
    value = in_unit(name, value, unit)
    if count == 1:
        if isinstance(value, (list, tuple)) or np.ndim(value) > 0:
            raise broken_rule("one_number", {"unit": unit}, parameter=name, value=value)
        return (checked_number(name, value, allowed, unit),)
    if np.isscalar(value) and value == 0.0 and not isinstance(value, str):
        value = (0.0, 0.0)
    if isinstance(value, str) or not hasattr(value, "__len__") or len(value) != 2:
        raise broken_rule("two_numbers", parameter=name, value=value)
    return tuple(checked_array(name, value, allowed, unit=unit))


def checked_offset(system: System, angle: Any, offset: Any) -> float:
    """Return an offset that replaces an angle [rad]."""
    if not isinstance(system, LatoLato):
        raise broken_rule("offset_of_toy", parameter="initial_offset")
    if angle is not None:
        raise broken_rule("angle_or_offset", parameter="initial_angle")
    return checked_number("initial_offset", offset, NON_NEGATIVE, "rad")


def check_strings(system: System, parameter: str) -> None:
    """Raise InputError for a parameter of strings unless the system hangs on them."""
    if system.suspension != "string":
        raise broken_rule("of_strings", parameter=parameter)


def check_perturbations(system: System, what: str) -> None:
    """Raise InputError for a result on small perturbations where it is not known."""
    if system.suspension == "string" and any(ball.coulomb_damping > 0.0 for ball in system.balls):
        raise broken_rule("no_friction", {"what": what}, parameter="coulomb_damping")


def checked_distances(system: System, value: Any) -> tuple[float, ...]:
    """Return the distances from the pivot at which balls start [m], none for taut strings."""
    if value is None:
        return ()
    check_strings(system, "initial_distance")
    distances = checked_numbers("initial_distance", value, system.angles, POSITIVE)
    return distances if distances != tuple(ball.length for ball in system.balls) else ()


def checked_start(
    system: System,
    law: ContactLaw,
    angle: Any,
    velocity: Any,
    offset: Any,
    distance: Any = None,
) -> Start:
    """Return the start, moved onto a wall that it is within 1e-12 rad of.

    With a `distance` below the length a ball starts on a slack string, without radial velocity.

    Raises
    ------
    InputError
        With what `latolato.numerics.prepare` reports: balls that overlap and the like.
    """
    if angle is None and offset is None:
        raise broken_rule("angle_needed", parameter="initial_angle")
    numbers: dict[str, Any] = {}
    if offset is not None:
        numbers["initial_offset"] = checked_offset(system, angle, offset)
        angle = 0.0
    velocities = checked_numbers("initial_angular_velocity", velocity, system.angles)
    distances = checked_distances(system, distance)
    if distances:
        numbers["initial_distance"] = (*distances, math.nan)[:2]
    if system.angles == 2 and not hasattr(angle, "__len__"):  # not even 0: the balls would overlap
        raise broken_rule("two_numbers", parameter="initial_angle", value=angle)
    angles = checked_numbers("initial_angle", angle, system.angles)
    case = cases_of(
        system, law, angles=angles, velocities=velocities, bounds=(0.0, 0.0), tolerance=1.0,
        **numbers,
    )  # fmt: skip
    state = prepared_runs(case, choose_stepper(system))["state"][0]
    return Start(tuple(state["angle"][: system.angles].tolist()), velocities, distances)


def warn_of_degrees(name: str, angles: Iterable[float], stacklevel: int) -> None:
    """Warn of initial angles beyond a turn that look like degrees.

    Those that a run of a rotating pendulum ended with are beyond a turn too, but never so even.
    """
    for angle in angles:
        if abs(angle) > math.tau and math.fmod(2.0 * angle, 1.0) == 0.0:
            warnings.warn(
                f"{name} is in rad, and {angle:g} rad are {abs(angle) / math.tau:.3g} turns: if "
                f"you meant {angle:g} degrees, give {math.radians(angle):.6g}",
                RuntimeWarning,
                stacklevel=stacklevel + 1,
            )
            return


def kicks_of(
    noise: VelocityKicks | None, system: System, end: float
) -> tuple[Floats | None, Floats | None]:
    """Return instants and sizes of the velocity kicks; equal for equal seed and stream."""
    if noise is None:
        return None, None
    if not isinstance(noise, VelocityKicks):
        raise InputError("must be VelocityKicks or None", parameter="noise", value=noise)
    spacing = noise.spacing(system)
    if end / spacing > MOST_KICKS:
        raise InputError(
            f"{end / spacing:.3g} velocity kicks exceed the limit of {MOST_KICKS}; "
            "make noise_interval longer"
        )
    count = int(end / spacing)
    instants: Floats = spacing * np.arange(1, count + 1, dtype=np.float64)
    generator = np.random.Generator(
        np.random.Philox(key=np.array([noise.noise_seed, noise.noise_stream], dtype=np.uint64))
    )
    normal = generator.standard_normal((count, system.angles)).T
    return instants, np.ascontiguousarray(normal * noise.noise_strength * math.sqrt(spacing))
