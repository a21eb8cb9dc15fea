"""Parameters of systems and drives as NumPy records, which every backend reads alike."""

from __future__ import annotations

import functools
from dataclasses import fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.physics.drives import Drive, Segment
from latolato.physics.pendulum import Ball
from latolato.physics.problems import MOST_VALUES

BODY = np.dtype(
    [
        ("inverse_length", "f8"),  # 1/length [1/m]
        ("damping_rate", "f8"),  # damping/(mass length) [1/s]
        ("quadratic", "f8"),  # quadratic_damping/(mass length) [1]
        ("coulomb", "f8"),  # coulomb_damping/(mass length) [rad/s^2]
        ("inertia", "f8"),  # mass length^2 [kg m^2]
        # How air that moves past the pivot turns it: damping_rate/length [1/(m s)], and at which
        # angle from its own [rad]; that is zero but for two balls as one body.
        ("wind_drag", "f8"),
        ("wind_offset", "f8"),
    ],
    align=True,
)


BALL = np.dtype([(f.name, "f8") for f in fields(Ball)], align=True)


def ball_record(ball: Ball) -> tuple[float, ...]:
    """Return one ball's parameters in the order of `BALL`."""
    return tuple(getattr(ball, name) for name in BALL.names or ())


# The public parameters of a run; see `latolato.numerics.prepare`.
CASE = np.dtype(
    [
        ("gravity", "f8"),  # m/s^2
        ("balls", BALL, (2,)),  # right, left
        ("restitution", "f8"),
        ("initial_angle", "f8", (2,)),  # rad
        ("initial_offset", "f8"),  # instead of it [rad], or NaN
        ("initial_angular_velocity", "f8", (2,)),  # rad/s
        ("duration", "f8"),  # s
        ("tolerance", "f8"),  # rad
        ("rest_speed", "f8"),  # rad/s
        ("step", "f8"),  # s; 0: to be chosen
        ("speed", "f8"),  # which the step must allow for beside those at the start [rad/s]
        ("pivot_bound", "f8"),  # of the drive [m/s^2]; NaN: both are to be found from its segments
        ("drive_rate", "f8"),  # its fastest frequency [rad/s]
        ("law", "f8", (2,)),  # numbers of the contact law, and its fastest rate [rad/s]
        ("law_rate", "f8"),
        ("angles", "i8"),  # of the state
        ("collides", "i8"),  # whether balls meet
        ("is_linear", "i8"),  # whether the restoring factor is the angle itself
        ("is_nonsmooth", "i8"),  # whether the step is one of `steppers.BLANES_MOAN_GENERAL`
        ("is_exact", "i8"),  # whether the start is taken as it is, wherever that may be
        ("clamps_start", "i8"),  # whether a start beyond a wall is moved there
        ("follows_tension", "i8"),
        ("follows_ledger", "i8"),
        ("mirrored", "i8"),  # whether two equal balls are kept mirror images of each other
        ("is_string", "i8"),  # whether balls hang on strings
        ("in_lab", "i8"),  # whether the air is at rest in the room, not around the pivot
        ("string_restitution", "f8"),
        ("initial_distance", "f8", (2,)),  # from the pivot [m], or NaN: the length
    ],
    align=True,
)


# What is wrong with a case: one of `latolato.physics.problems`.
PROBLEM = np.dtype([("number", "i8"), ("values", "f8", (MOST_VALUES,))], align=True)


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


SETTINGS = np.dtype(
    [
        ("gravity", "f8"),  # m/s^2
        ("low", "f8"),  # contacts: angle of one ball, or separation of two [rad]
        ("high", "f8"),
        ("restitution", "f8"),
        ("rest_speed", "f8"),  # rad/s
        ("step", "f8"),  # s
        ("pivot_bound", "f8"),  # largest |pivot_acceleration| [m/s^2]
        ("drive_rate", "f8"),  # the drive's fastest angular frequency [rad/s]
        ("offset_low", "f8"),  # angle offset of the body that both balls form in contact [rad]
        ("offset_high", "f8"),
        ("tension_dip", "f8"),  # relative dip of the tension within a step that is looked for
        ("follows_tension", "i8"),
        ("follows_ledger", "i8"),
        ("mirrored", "i8"),  # keep two equal balls mirror images of each other
        ("is_linear", "i8"),  # whether the restoring factor is the angle itself
        ("law", "f8", (2,)),  # what a contact law says to its motion
        ("is_string", "i8"),  # whether balls hang on strings
        ("in_lab", "i8"),  # whether the air is at rest in the room, not around the pivot
        ("string_restitution", "f8"),
        ("radius", "f8", (2,)),  # of the balls [m]
    ],
    align=True,
)

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
