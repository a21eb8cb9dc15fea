"""Parameters of systems and drives as NumPy records, which every backend reads alike."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.physics.drives import Drive, Stretch
from latolato.physics.pair import joint_coupling
from latolato.physics.pendulum import Ball

BODY = np.dtype(
    [
        ("coupling", "f8"),  # 1/length [1/m]
        ("rate", "f8"),  # damping/(mass length) [1/s]
        ("quadratic", "f8"),  # quadratic_damping/(mass length) [1]
        ("coulomb", "f8"),  # coulomb_damping/(mass length) [rad/s^2]
        ("inertia", "f8"),  # mass length^2 [kg m^2]
    ],
    align=True,
)


def body_record(ball: Ball) -> tuple[float, ...]:
    """Return one ball's numbers in the order of `BODY`."""
    l, m = ball.length, ball.mass
    return (
        1.0 / l,
        ball.damping / (m * l),
        ball.quadratic_damping / (m * l),
        ball.coulomb_damping / (m * l),
        m * l * l,
    )


def bodies(*rows: tuple[float, ...]) -> NDArray[Any]:
    """Return records of shape (body,)."""
    return np.array(list(rows), dtype=BODY)


def joint_record(
    right: tuple[float, ...], left: tuple[float, ...], separation: float
) -> tuple[tuple[float, ...], float]:
    """Return the record of two balls in lasting contact and its angle offset [rad]."""
    k1, rate_1, quadratic_1, coulomb_1, inertia_1 = right
    k2, rate_2, quadratic_2, coulomb_2, inertia_2 = left
    total = inertia_1 + inertia_2

    def mean(first: float, second: float) -> float:
        return (inertia_1 * first + inertia_2 * second) / total

    coupling, offset = joint_coupling(inertia_1 * k1, inertia_2 * k2, total, separation)
    drags = mean(rate_1, rate_2), mean(quadratic_1, quadratic_2), mean(coulomb_1, coulomb_2)
    return (coupling, *drags, total), offset


def stretch_records(drive: Drive, duration: float) -> tuple[NDArray[Any], NDArray[np.float64]]:
    """Return the drive's stretches as records, shape (stretch,), and their start times [s]."""
    found = drive.stretches(duration)
    records = np.array([tuple(s) for s in found], dtype=stretch_dtype(type(found[0])))
    return records, np.array([stretch.start for stretch in found])


def stretch_dtype(kind: type[Any] = Stretch) -> np.dtype[Any]:
    """Return the layout of records of a kind of stretch."""
    return np.dtype([(name, "f8") for name in kind._fields], align=True)


SETTINGS = np.dtype(
    [
        ("gravity", "f8"),  # m/s^2
        ("low", "f8"),  # contacts: angle of one ball, or separation of two [rad]
        ("high", "f8"),
        ("restitution", "f8"),
        ("rest_speed", "f8"),  # rad/s
        ("step", "f8"),  # s
        ("pivot_bound", "f8"),  # largest |pivot_acceleration| [m/s^2]
        ("offset_low", "f8"),  # angle offset of the body that both balls form in contact [rad]
        ("offset_high", "f8"),
        ("sag", "f8"),  # relative dip of the tension within a step that is looked for
        ("follows_tension", "i8"),
        ("follows_ledger", "i8"),
        ("mirrored", "i8"),  # keep two equal balls mirror images of each other
        ("is_linear", "i8"),  # whether the restoring factor is the angle itself
        ("law", "f8", (2,)),  # what a contact law says to its motion
    ],
    align=True,
)

# Rows of the sample array: the states of the balls, then the ledger.
S_WORK, S_DAMPED, S_IMPACT, S_CAPTURED, S_NOISE, S_MODE = 4, 5, 6, 7, 8, 9
SAMPLE_ROWS = 10

# Status of one point of a sweep.
CONVERGED, GRAZING, AT_REST, EVENT_LIMIT, FAILED, INVALID = range(6)
STATUS_NAMES = ("converged", "grazing", "rest", "event_limit", "failed", "invalid")
