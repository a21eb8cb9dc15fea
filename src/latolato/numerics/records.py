"""Parameters of systems and drives as NumPy records, which every backend reads alike."""

from __future__ import annotations

import functools
from typing import Annotated, Any, Protocol, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from latolato.physics.drives import Drive, Segment
from latolato.physics.pendulum import Ball
from latolato.physics.problems import MOST_VALUES

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Records = NDArray[Any]  # whose elements have fields
Pair = Annotated[Floats, 2]
PairOfIntegers = Annotated[Integers, 2]


def layout_of(record: type, **given: np.dtype[Any]) -> np.dtype[Any]:
    """The NumPy layout of a record that is declared as a class.

    Its fields are floats, integers, other records, and arrays of these of a given shape, which
    stands in ``Annotated``. So editors and type checkers know the fields that kernels read.

    Parameters
    ----------
    given : dtype
        Layouts of fields by name, instead of those declared.
    """
    hints = get_type_hints(record, include_extras=True)
    return np.dtype(
        [(name, *_kind_of(hint, given.get(name))) for name, hint in hints.items()], align=True
    )


def _kind_of(hint: Any, layout: np.dtype[Any] | None) -> tuple[Any, ...]:
    """The NumPy type of a field, and its shape if it is an array."""
    if layout is not None:
        return (layout,)
    if hint in _NUMBERS:
        return (_NUMBERS[hint],)
    if get_origin(hint) is not Annotated:
        return (layout_of(hint),)
    array, shape = get_args(hint)
    (kind,) = get_args(array) if get_origin(array) is list else (_NUMBERS[array],)
    return (kind if isinstance(kind, str) else layout_of(kind), shape)


_NUMBERS: dict[Any, str] = {float: "f8", int: "i8", Floats: "f8", Integers: "i8"}


class Body(Protocol):
    """A body that swings: a ball, or two in sticking contact."""

    inverse_length: float  # 1/length [1/m]
    damping_rate: float  # damping/(mass length) [1/s]
    quadratic: float  # quadratic_damping/(mass length) [1]
    coulomb: float  # coulomb_damping/(mass length) [rad/s^2]
    inertia: float  # mass length^2 [kg m^2]
    # How air that moves past the pivot turns it: damping_rate/length [1/(m s)], and at which
    # angle from its own [rad]; that is zero but for two balls as one body.
    wind_drag: float
    wind_offset: float


BODY = layout_of(Body)


BALL = layout_of(Ball)


def ball_record(ball: Ball) -> tuple[float, ...]:
    """Return one ball's parameters in the order of `BALL`."""
    return tuple(getattr(ball, name) for name in BALL.names or ())


class Case(Protocol):
    """The public parameters of a run; see `latolato.numerics.prepare`."""

    gravity: float  # m/s^2
    balls: Annotated[list[Ball], 2]  # right, left
    restitution: float
    initial_angle: Pair  # rad
    initial_offset: float  # instead of it [rad], or NaN
    initial_angular_velocity: Pair  # rad/s
    duration: float  # s
    tolerance: float  # rad
    rest_speed: float  # rad/s
    step: float  # s; 0: to be chosen
    speed: float  # which the step must allow for beside those at the start [rad/s]
    pivot_bound: float  # of the drive [m/s^2]; NaN: both are to be found from its segments
    drive_rate: float  # its fastest frequency [rad/s]
    law: Pair  # numbers of the contact law, and its fastest rate [rad/s]
    law_rate: float
    angles: int  # of the state
    collides: int  # whether balls meet
    is_linear: int  # whether the restoring factor is the angle itself
    is_nonsmooth: int  # whether the step is one of `steppers.BLANES_MOAN_GENERAL`
    is_exact: int  # whether the start is taken as it is, wherever that may be
    clamps_start: int  # whether a start beyond a wall is moved there
    follows_tension: int
    follows_ledger: int
    mirrored: int  # whether two equal balls are kept mirror images of each other
    is_string: int  # whether balls hang on strings
    in_lab: int  # whether the air is at rest in the room, not around the pivot
    string_restitution: float
    initial_distance: Pair  # from the pivot [m], or NaN: the length


CASE = layout_of(Case)


class Problem(Protocol):
    """What is wrong with a case: one of `latolato.physics.problems`, and what its rule names."""

    number: int
    values: Annotated[Floats, MOST_VALUES]


PROBLEM = layout_of(Problem)


def segment_records(drive: Drive, duration: float) -> NDArray[Any]:
    """Return the drive's segments as records, shape (segment,)."""
    result = drive.segments(duration)
    records = np.zeros(len(result), dtype=segment_dtype(type(result[0])))
    for k, segment in enumerate(result):
        records[k] = (*segment, 0.0)[: len(records.dtype)]  # those without a jump have none
    return records


def segment_dtype(kind: type[Any] = Segment) -> np.dtype[Any]:
    """Return the layout of records of a kind of segment, with a `jump` if that has none."""
    return _layout(kind._fields if "jump" in kind._fields else (*kind._fields, "jump"))


@functools.cache
def _layout(names: tuple[str, ...]) -> np.dtype[Any]:
    """Return the layout of records of floats."""
    return np.dtype([(name, "f8") for name in names], align=True)


class Settings(Protocol):
    """What stays the same throughout a run."""

    gravity: float  # m/s^2
    low: float  # contacts: angle of one ball, or separation of two [rad]
    high: float
    restitution: float
    rest_speed: float  # rad/s
    step: float  # s
    pivot_bound: float  # largest |pivot_acceleration| [m/s^2]
    drive_rate: float  # the drive's fastest angular frequency [rad/s]
    offset_low: float  # angle offset of the body that both balls form in contact [rad]
    offset_high: float
    tension_dip: float  # relative dip of the tension within a step that is looked for
    follows_tension: int
    follows_ledger: int
    mirrored: int  # keep two equal balls mirror images of each other
    is_linear: int  # whether the restoring factor is the angle itself
    law: Pair  # what a contact law says to its motion
    is_string: int  # whether balls hang on strings
    in_lab: int  # whether the air is at rest in the room, not around the pivot
    string_restitution: float
    radius: Pair  # of the balls [m]


SETTINGS = layout_of(Settings)

# Rows of the sample array: the states of the balls, then the ledger.
S_WORK, S_DAMPED, S_IMPACT, S_CAPTURED, S_NOISE, S_MODE = 4, 5, 6, 7, 8, 9
SAMPLE_ROWS = 10
# More rows of motions in the plane: distance [m], its rate [m/s] and slackness of each ball, and
# the ledger's last part.
S_DISTANCE, S_RETENSION, PLANE_ROWS = 10, 16, 17
# Rows of the contact table: angular velocities before and after, two each. Of motions in the plane
# the velocities along the strings follow, and which ball it was (-1: both).
C_RADIAL, C_BALL, CONTACT_ROWS = 4, 8, 9

# Status of one point of a sweep.
CONVERGED, GRAZING, AT_REST, EVENT_LIMIT, FAILED, INVALID, OUTSIDE_MODEL = range(7)
STATUS_NAMES = (
    "converged", "grazing", "rest", "event_limit", "failed", "invalid", "outside_model",
)  # fmt: skip
