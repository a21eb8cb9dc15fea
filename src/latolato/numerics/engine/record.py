"""The record of a trajectory under way: what the engine reads and writes, by name.

Compiled code sees NumPy records, plain Python objects with the same attributes: see `as_objects`.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.numerics.records import BODY, SETTINGS, segment_dtype

# The largest stepper has so many drifts; its table has one kick more.
MOST_STAGES = 12

# Modes of motion. In flight all strings are taut.
UNSETTLED, FLIGHT, REST, STICKING, SLACK = -1, 0, 1, 2, 3
# Events at the end of a step.
NOTHING, TURN, CONTACT, SETTLE, RELEASE, GO_SLACK, RETENSION = range(7)
# Which motion a row belongs to: two balls in sticking contact swing as a joint body.
PAIR_ROW = 2
# Rows of a step's table.
KICK, DRIFT_TIME, OFFSET = 0, 1, 2
# The last rows of `tangent_map`: by how much perturbations delay the present event, for each ball
# [s].
DELAY_ROWS = 8

# What is kept of a trajectory from one call of the engine to the next.
STATE = np.dtype(
    [
        ("t_base", "f8"),  # the time is t_base + steps * step [s]
        ("steps", "i8"),
        ("mode", "i8"),
        ("side", "f8"),  # of the contact that lasts or was left last: -1 bottom, 1 top
        ("touch", "f8"),  # the side that balls in flight have just left; 0 away from contacts
        ("held_until", "f8"),  # no check for release before this time [s]
        ("segment", "i8"),  # which segment of the drive, which kick, which sample comes next
        ("kick", "i8"),
        ("sample", "i8"),
        ("contacts", "i8"),  # rows written
        ("grazes", "i8"),
        ("total_steps", "i8"),
        ("rests", "i8"),  # whether contact lasts or friction holds all balls, at the end of a call
        ("angle", "f8", (2,)),  # rad, of each ball
        ("velocity", "f8", (2,)),  # rad/s
        ("drive_work", "f8"),  # J, as all that follow
        ("damping_loss", "f8"),
        ("impact_loss", "f8"),
        ("capture_loss", "f8"),
        ("noise_work", "f8"),
        ("retension_loss", "f8"),
        ("compression_start", "f8", (2,)),  # s, NaN before
        ("compression_time", "f8", (2,)),  # s
        ("is_slack", "i8", (2,)),  # whether a ball's string is slack
        ("leaves", "i8", (2,)),  # whether a slack ball has just been at its string's full length
        ("taut_until", "f8", (2,)),  # before this time a string does not go slack again [s]
        ("place", "f8", (2, 4)),  # of a slack ball from the pivot [m], and its velocity [m/s]
        ("slack_start", "f8", (2,)),  # s, NaN before
        ("slack_time", "f8", (2,)),  # s
        ("string_impulse", "f8"),  # the largest that tightened a string [N s]
        # Perturbations since a string went slack; see `tangent_map`.
        ("has_tangent_map", "i8"),
        ("tangent_map_start", "f8"),  # s
        ("tangent_map", "f8", (DELAY_ROWS + 2, 4)),  # a column each; rows x, y, vx, vy of each ball
        ("is_outside_model", "i8"),  # whether something happened that the engine does not describe
        ("first_energy", "f8"),  # J; these three tell how well the ledger closes
        ("largest_energy", "f8"),
        ("ledger_error", "f8"),
    ],
    align=True,
)

# A point of the motion of one ball, or of two as one body, and what the step to it did.
POINT = np.dtype(
    [
        ("angle", "f8"),  # rad
        ("velocity", "f8"),  # rad/s
        ("sign", "f8"),  # of the velocity, or of the motion that begins; 0 where friction holds
        ("acceleration", "f8"),  # of a kick: without drag that depends on the speed [rad/s^2]
        ("driven", "f8"),  # the drive's part of it [rad/s^2]
        ("pivot_acceleration", "f8"),  # m/s^2
        ("tension", "f8"),  # over mass and length [1/s^2]
        ("work", "f8"),  # of the drive in the step, over the moment of inertia [1/s^2]
        ("loss", "f8"),  # by drag, likewise
        # In the plane only.
        ("across", "f8"),  # the pivot's horizontal acceleration [m/s^2]
        ("wind_x", "f8"),  # the pivot's velocity against the air, where that counts [m/s]
        ("wind_y", "f8"),
        ("x", "f8"),  # of the ball, from the pivot [m]
        ("y", "f8"),
        ("vx", "f8"),  # m/s
        ("vy", "f8"),
    ],
    align=True,
)

# Rows are those of the state; the further columns are free for scratch.
MATRIX_SHAPE = (4, 7)

# As many words as an observable is shown at most; see `callbacks`.
_SHOWN = 14
# As many words as say where everything lies that compiled code is given; see `abi.words_of`.
_WORDS = 48


@functools.cache
def run_dtype(segment: np.dtype[Any] | None = None) -> np.dtype[Any]:
    """Return the layout of `run`; `segment` is that of the drive's segments."""
    return np.dtype(
        [
            ("state", STATE),
            ("settings", SETTINGS),
            # Ball 1, ball 2, and the bodies that both form in contact at the bottom and at the top.
            ("bodies", BODY, (4,)),
            # The step: where it begins, where it ends, and a third set for looking inside.
            ("now", POINT, (3,)),
            ("end", POINT, (3,)),
            ("inside", POINT, (3,)),
            ("t", "f8"),  # s
            ("goal", "f8"),  # the next instant at which a step must end [s]
            ("length", "f8"),  # s
            ("t_end", "f8"),  # s
            ("is_whole", "i8"),  # whether the step is a full one
            ("event", "i8"),
            ("side", "f8"),  # of the contact that is met: -1 bottom, 1 top
            ("ball", "i8"),  # which one turns
            ("work", "f8"),  # of the drive in the step, and the loss by drag [J]
            ("loss", "f8"),
            ("work_inside", "f8"),  # the same up to the point inside
            ("loss_inside", "f8"),
            ("keeps_touch", "i8"),  # whether the balls still touch at the end
            ("rows", "i8"),  # of the contact table, written in this call
            ("done", "i8"),  # steps taken in this call
            ("is_nonsmooth", "i8"),  # whether any drag is not smooth where the velocity is zero
            # The stepper's weights, and tables of what steps need: kicks, reaches, offsets.
            ("stages", "i8"),
            ("kicks", "f8", (MOST_STAGES + 1,)),
            ("drifts", "f8", (MOST_STAGES,)),
            ("nodes", "f8", (MOST_STAGES,)),
            ("tables", "f8", (5, 3, MOST_STAGES + 1)),
            # What observables are shown: words of it, and a matrix of perturbations.
            ("shown", "i8", (_SHOWN,)),
            ("jacobian", "f8", MATRIX_SHAPE),
            ("words", "i8", (_WORDS,)),
            # Addresses of the engine and of the observables' kernels; see `kernels.callback_table`.
            ("engine", "i8"),
            ("callbacks", "i8"),
            ("segment", segment or segment_dtype()),  # last: a drive may bring its own layout
        ],
        align=True,
    )


def as_objects(records: NDArray[Any]) -> list[Any]:
    """Return records as objects of plain Python, which reads these a hundred times faster."""
    return _Rows(as_objects(r) if isinstance(r, np.ndarray) else _as_object(r) for r in records)


class _Rows(list[Any]):
    """Objects into which others are copied when they are assigned, as records are."""

    def __getitem__(self, index: Any) -> Any:
        if isinstance(index, tuple):
            return self[index[0]][index[1]]
        result = super().__getitem__(index)
        return _Rows(result) if isinstance(index, slice) else result

    def __setitem__(self, index: Any, value: Any) -> None:
        result = {
            name: held.copy() if isinstance(held, np.ndarray) else held
            for name, held in value.__dict__.items()
        }
        self[index].__dict__.update(result)


def _as_object(record: Any) -> Any:
    result = SimpleNamespace()
    for name in record.dtype.names:
        value = record[name]
        if isinstance(value, np.void):
            value = _as_object(value)
        elif isinstance(value, np.ndarray):
            value = as_objects(value) if value.dtype.names else value.copy()
        else:
            value = value.item()
        setattr(result, name, value)
    return result


def write_back(objects: Iterable[Any], records: NDArray[Any]) -> None:
    """Write objects of `as_objects` without nested ones into records."""
    for item, record in zip(objects, records, strict=True):
        for name in records.dtype.names or ():
            record[name] = getattr(item, name)
