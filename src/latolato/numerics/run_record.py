"""The record of a trajectory under way: what the engine reads and writes, by name.

Compiled code sees NumPy records, plain Python objects with the same attributes: see `as_objects`.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from types import SimpleNamespace
from typing import Annotated, Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from latolato.numerics.records import (
    Body,
    Floats,
    Integers,
    Pair,
    PairOfIntegers,
    Settings,
    layout_of,
    segment_dtype,
)
from latolato.physics.drives import Segment

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
# Tables of full steps are those of ball 1 and ball 2; then come those of steps of any length, for
# ball 1, ball 2 and both as one body.
ANY_LENGTH = 2
# Columns of a step's record, a row for each kick and the drift after it: the velocity between them,
# the derivative of the acceleration by the angle, those of the drift by the velocity, that of the
# drift's effective time by the rate of the drag, those of angle and angular velocity at the end of
# the step by the acceleration of the kick, and those of this by the numbers of
# `forces.Pull.weights`.
VELOCITY, GRADIENT, FAR, KEPT, TIME_SLOPE, LATER, FASTER, WEIGHTS = range(8)
_RECORDED = WEIGHTS + 7
# The last rows of `tangent_map`: by how much perturbations delay the present event, for each ball
# [s].
DELAY_ROWS = 8


class State(Protocol):
    """What is kept of a trajectory from one call of the engine to the next."""

    t_base: float  # the time is t_base + steps * step [s]
    steps: int
    mode: int
    side: float  # of the contact that lasts or was left last: -1 bottom, 1 top
    touch: float  # the side that balls in flight have just left; 0 away from contacts
    held_until: float  # no check for release before this time [s]
    segment: int  # which segment of the drive, which kick, which sample comes next
    kick: int
    sample: int
    contacts: int  # rows written
    grazes: int
    total_steps: int
    rests: int  # whether contact lasts or friction holds all balls, at the end of a call
    angle: Pair  # rad, of each ball
    velocity: Pair  # rad/s
    drive_work: float  # J, as all that follow
    damping_loss: float
    impact_loss: float
    capture_loss: float
    noise_work: float
    retension_loss: float
    compression_start: Pair  # s, NaN before
    compression_time: Pair  # s
    is_slack: PairOfIntegers  # whether a ball's string is slack
    leaves: PairOfIntegers  # whether a slack ball has just been at its string's full length
    taut_until: Pair  # before this time a string does not go slack again [s]
    place: Annotated[Floats, (2, 4)]  # of a slack ball from the pivot [m], and its velocity [m/s]
    slack_start: Pair  # s, NaN before
    slack_time: Pair  # s
    string_impulse: float  # the largest that tightened a string [N s]
    # Perturbations since a string went slack; see `tangent_map`.
    has_tangent_map: int
    tangent_map_start: float  # s
    tangent_map: Annotated[
        Floats, (DELAY_ROWS + 2, 4)
    ]  # a column each; rows x, y, vx, vy of each ball
    is_outside_model: int  # whether something happened that the engine does not describe
    first_energy: float  # J; these three tell how well the ledger closes
    largest_energy: float
    ledger_error: float


STATE = layout_of(State)


class Point(Protocol):
    """A point of the motion of one ball, or of two as one body, and what the step to it did."""

    angle: float  # rad
    velocity: float  # rad/s
    sign: float  # of the velocity, or of the motion that begins; 0 where friction holds
    acceleration: float  # of a kick: without drag that depends on the speed [rad/s^2]
    driven: float  # the drive's part of it [rad/s^2]
    pivot_acceleration: float  # m/s^2
    tension: float  # over mass and length [1/s^2]
    work: float  # of the drive in the step, over the moment of inertia [1/s^2]
    loss: float  # by drag, likewise
    # In the plane only.
    across: float  # the pivot's horizontal acceleration [m/s^2]
    wind_x: float  # the pivot's velocity against the air, where that counts [m/s]
    wind_y: float
    x: float  # of the ball, from the pivot [m]
    y: float
    vx: float  # m/s
    vy: float


POINT = layout_of(Point)

# Rows are those of the state; the further columns are free for scratch.
MATRIX_SHAPE = (4, 7)

# With respect to so many parameters a run may be differentiated at once.
MOST_PARAMETERS = 8


class Change(Protocol):
    """By how much the numbers of a run change per unit of a parameter."""

    bodies: Annotated[list[Body], 4]
    gravity: float
    low: float
    high: float
    restitution: float
    string_restitution: float
    offset_low: float
    offset_high: float
    radius: Pair
    moves_pivot: int  # whether the segments of the drive change


CHANGE = layout_of(Change)

# As many words as an observable is shown at most; see `callbacks`.
_SHOWN = 14
# As many words as say where everything lies that compiled code is given; see `abi.words_of`.
_WORDS = 48


class Run(Protocol):
    """A trajectory under way: all that the engine and its parts read and write."""

    state: State
    settings: Settings
    # Ball 1, ball 2, and the bodies that both form in contact at the bottom and at the top.
    bodies: Annotated[list[Body], 4]
    # The step: where it begins, where it ends, and a third set for looking inside.
    now: Annotated[list[Point], 3]
    end: Annotated[list[Point], 3]
    inside: Annotated[list[Point], 3]
    t: float  # s
    goal: float  # the next instant at which a step must end [s]
    length: float  # s
    t_end: float  # s
    is_whole: int  # whether the step is a full one
    event: int
    side: float  # of the contact that is met: -1 bottom, 1 top
    ball: int  # which one turns
    work: float  # of the drive in the step, and the loss by drag [J]
    loss: float
    work_inside: float  # the same up to the point inside
    loss_inside: float
    keeps_touch: int  # whether the balls still touch at the end
    rows: int  # of the contact table, written in this call
    done: int  # steps taken in this call
    is_nonsmooth: int  # whether any drag is not smooth where the velocity is zero
    # The stepper's weights, and tables of what steps need: kicks, reaches, offsets.
    stages: int
    kicks: Annotated[Floats, MOST_STAGES + 1]
    drifts: Annotated[Floats, MOST_STAGES]
    nodes: Annotated[Floats, MOST_STAGES]
    tables: Annotated[Floats, (5, 3, MOST_STAGES + 1)]
    # What observables are shown: words of it, and a matrix of perturbations.
    shown: Annotated[Integers, _SHOWN]
    jacobian: Annotated[Floats, MATRIX_SHAPE]
    words: Annotated[Integers, _WORDS]
    # Addresses of the engine and of the observables' kernels; see `kernels.callback_table`.
    engine: int
    callbacks: int
    # Derivatives with respect to parameters, see `engine.sensitivity`. There is room for them only
    # where they are asked for (`run_dtype`). The entry after the last parameter is the time.
    parameters: int
    doubt: int  # why they are not known any more, and since when [s]
    doubted_since: float
    changes: list[Change]  # shape (parameter + 1,)
    sensitivity: Floats  # of the state, shape (4, parameter)
    forcing: Floats  # what a step or an event adds to them, likewise
    delay: Floats  # by how much the present event is later [s per unit], shape (parameter,)
    kept: Floats  # a copy of the tangent map through slack
    segment_changes: list[Segment]  # of the present segment, shape (parameter + 1,)
    # The latest step by each table, and where a step ends that is only taken to be recorded.
    path: Floats
    begun: Floats  # the forcing before it, shape (2, parameter)
    passing: list[Point]
    segment: Segment  # last: a drive may bring its own layout


class Output(NamedTuple):
    """Where samples and contacts are written; see `latolato.numerics.records`."""

    sample_times: Floats
    samples: Floats
    contact_times: Floats
    contact_kinds: Integers
    contact_values: Floats


@functools.cache
def run_dtype(segment: np.dtype[Any] | None = None, parameters: int = 0) -> np.dtype[Any]:
    """The layout of a `Run`; `segment` is that of the drive's segments.

    It has room for derivatives with respect to so many `parameters`.
    """
    segment, slack_rows = segment or segment_dtype(), DELAY_ROWS + 2
    directions = parameters + 1 if parameters > 0 else 0
    columns = 4 + parameters if parameters > 0 else 0
    return layout_of(
        Run,
        state=layout_of(State, tangent_map=_array("f8", slack_rows, 4 + parameters)),
        changes=_array(CHANGE, directions),
        sensitivity=_array("f8", 4, parameters),
        forcing=_array("f8", 4, parameters),
        delay=_array("f8", parameters),
        kept=_array("f8", slack_rows, columns),
        segment_changes=_array(segment, directions),
        path=_array("f8", 5 if parameters > 0 else 0, MOST_STAGES + 1, _RECORDED),
        begun=_array("f8", 2, parameters),
        passing=_array(POINT, 1 if parameters > 0 else 0),
        segment=segment,
    )


def _array(kind: Any, *shape: int) -> np.dtype[Any]:
    """The layout of an array of this kind and shape."""
    return np.dtype((kind, shape))


def as_objects(records: NDArray[Any]) -> Any:
    """Records as objects of plain Python, which reads these a hundred times faster.

    They stand in a list that behaves as an array of records does where kernels use it.
    """
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
