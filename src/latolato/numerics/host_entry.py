"""What a host without Python calls from public parameters on: the drive, then the run's beginning.

Python builds both with the same formulas, `Drive.write` and `prepare.prepare`.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np

from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.prepare import has_nonsmooth_drag, prepare
from latolato.numerics.records import CASE, PROBLEM, Floats, Integers, Records, segment_dtype
from latolato.numerics.run_record import Run, run_dtype
from latolato.numerics.steppers import BLANES_MOAN_GENERAL, BLANES_MOAN_RKN
from latolato.physics.drives import drives

# The package's drives that are written from their numbers; a host gives their places as `kind`.
WRITTEN: dict[str, Any] = {
    name: kind
    for name, kind in drives.items()
    if kind.__module__.startswith("latolato.") and getattr(kind, "write", None) is not None
}


def _parameters() -> dict[str, Any]:
    """Return every parameter of these drives with an example of its kind, as `Drive.numbers`."""
    result: dict[str, Any] = {"kind": 0}
    for kind in WRITTEN.values():
        for field in fields(kind):
            number = 0.0 if "quantity" in field.metadata else 0
            result[field.name] = np.zeros(0) if field.metadata.get("array") else number
    return result


_EXAMPLES = _parameters()
# All of them, of which a drive has some.
DriveParameters: Any = namedtuple("DriveParameters", tuple(_EXAMPLES))  # type: ignore[misc]


class Shaking(NamedTuple):
    """A drive's parameters, and where its segments and their number go."""

    drive: Any
    segments: Records  # with room for two for each of its times and two more
    number: Integers  # shape (1,)


class Beginning(NamedTuple):
    """A run's parameters and its drive's segments, and where its record goes; of shape (1,)."""

    case: Records
    segments: Records  # shape (segment,)
    run: Records
    problem: Records


def empty_shaking() -> Shaking:
    """Return arrays of the kinds that writing a drive takes."""
    drive = DriveParameters(*_EXAMPLES.values())
    return Shaking(drive, np.zeros(0, dtype=segment_dtype()), np.zeros(0, dtype=np.int64))


def empty_beginning() -> Beginning:
    """Return arrays of the kinds that beginning a run takes."""
    return Beginning(
        np.zeros(0, dtype=CASE), np.zeros(0, dtype=segment_dtype()), np.zeros(0, dtype=run_dtype()),
        np.zeros(0, dtype=PROBLEM),
    )  # fmt: skip


def _by_kind(kinds: Sequence[Any], number: int, part: Part) -> Callable[..., int]:
    """Return the function that calls the formula of the drive's kind; `number` is the first's."""
    write, *others = kinds
    otherwise = _by_kind(others, number + 1, part) if others else None

    @part
    def chosen(out: Any, drive: Any) -> int:
        if drive.kind == number:
            result: int = write(out, drive)
            return result
        return otherwise(out, drive) if otherwise is not None else 0

    return chosen


def make_shake(part: Part = as_it_stands) -> Callable[[Any], None]:
    """Return the function that writes a drive's segments."""
    write = _by_kind([kind.write for kind in WRITTEN.values()], 0, part)

    def shake(work: Shaking) -> None:
        work.number[0] = write(work.segments, work.drive)

    return part(shake)


def make_begin(part: Part = as_it_stands) -> Callable[[Any], None]:
    """Return the function that makes the record of a run at time zero."""
    smooth, rough = (
        (stepper.kicks, stepper.drifts, stepper.nodes)
        for stepper in (BLANES_MOAN_RKN, BLANES_MOAN_GENERAL)
    )

    @part
    def write_weights(run: Run, kicks: Floats, drifts: Floats, nodes: Floats) -> None:
        """Write a stepper's weights."""
        run.stages = len(drifts)
        for i in range(len(drifts)):
            run.kicks[i], run.drifts[i], run.nodes[i] = kicks[i], drifts[i], nodes[i]
        run.kicks[len(drifts)] = kicks[len(drifts)]

    def begin(work: Beginning) -> None:
        case, run = work.case[0], work.run[0]
        case.is_nonsmooth = 1 if has_nonsmooth_drag(case.balls, case.angles) else 0
        prepare(case, work.segments, run.settings, run.bodies, run.state, work.problem[0])
        if case.is_nonsmooth != 0:
            write_weights(run, *rough)
        else:
            write_weights(run, *smooth)

    return part(begin)
