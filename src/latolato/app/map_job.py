"""Computes a map from coarse to fine and packs what is new as frames for a page."""

from __future__ import annotations

import time
from collections.abc import Generator, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.app.blocks import pack
from latolato.app.forms import quantity_of, units_of
from latolato.app.map_cells import Maps, known_of, values_of
from latolato.app.map_choices import mappable
from latolato.app.map_lines import sweep_command, sweep_lines
from latolato.app.map_request import Map
from latolato.figures.map import CLASSES
from latolato.figures.sides import Side
from latolato.numerics.records import STATUS_NAMES
from latolato.sweeps.chunk import STATUS, Values
from latolato.sweeps.executors import ROUNDING
from latolato.sweeps.executors.threads import available_processors, run_cancellable
from latolato.sweeps.labels import attributes_of, attributes_of_variables
from latolato.sweeps.plan import Plan

Cells = NDArray[np.int64]

# The coarsest picture has about so many cells along its longer side.
_COARSEST = 12
# A chunk takes about so long on one core; a step of one lane so many of them.
_SECONDS_OF_CHUNK = 0.15
_SECONDS_OF_STEP = 5e-8
# Fewer points leave lanes empty, more make pictures rare.
_CHUNKS = (64, 256)
# Maps give way to everything else that the server does, to live motion above all.
_NICENESS = 5


def levels(width: int, height: int) -> Iterator[tuple[int, Cells]]:
    """Yield, from coarse to fine, the stride of a level and the cells that are new in it.

    Cells are numbered row by row. A level holds every cell whose row and column are multiples of
    its stride; strides are powers of two.

    Examples
    --------
    >>> [(stride, cells.tolist()) for stride, cells in levels(3, 2)]
    [(1, [0, 1, 2, 3, 4, 5])]
    >>> sum(len(cells) for _, cells in levels(100, 75))
    7500
    """
    stride = 1
    while max(width, height) / stride > 2 * _COARSEST:
        stride *= 2
    known = np.zeros((height, width), dtype=bool)
    while stride >= 1:
        new = np.zeros_like(known)
        new[::stride, ::stride] = True
        new &= ~known
        known |= new
        yield stride, np.flatnonzero(new.ravel())
        stride //= 2


def in_order(shown: Map) -> tuple[Cells, Cells]:
    """Return all cells, coarse ones first, and the stride of the level of each."""
    height, width = shown.shape
    parts = list(levels(width, height))
    cells = np.concatenate([cells for _, cells in parts])
    strides = np.concatenate([np.full(len(cells), stride) for stride, cells in parts])
    return cells, strides


def frames(shown: Map, cancel: NDArray[np.int64], maps: Maps) -> Generator[bytes, None, None]:
    """Yield what a page needs: what the map is of, then cells as chunks end, then that it is done.

    Cells that are known, of a map that was stopped, left or moved, come first and at once.

    Raises
    ------
    Cancelled
        If ``cancel[0]`` was set; kernels stop within moments.
    TooLargeError, InputError
        Before any work.
    """
    cost = shown.cost_of_point()
    size = int(np.clip(_SECONDS_OF_CHUNK / (cost * _SECONDS_OF_STEP), *_CHUNKS))
    memory = maps.begin(shown.plan)
    cells, strides = in_order(shown)
    known = known_of(memory)[cells]
    names = variables_of(memory.plan)
    yield _begin(shown, int(np.sum(~known)))
    if known.any():
        values = values_of(memory, cells[known])
        about = {"points": 0, "seconds": 0.0, "rate": 0.0, "reason": ""}
        yield _cells(about, cells[known], strides[known], values, names)
    cells, strides = cells[~known], strides[~known]
    if not len(cells):
        yield pack({"kind": "done", "points": 0, "seconds": 0.0, "rate": 0.0}, {})
        return
    plan = shown.plan_of(cells, size)
    begun, done, rate = time.perf_counter(), 0, 0.0
    first: tuple[float, int] | None = None
    chunks = run_cancellable(
        plan, range(plan.chunks), available_processors(), cancel, niceness=_NICENESS
    )
    for number, (values, reason) in chunks:
        (part,) = plan.block(number)
        memory.put(cells[part], values, reason)
        done += part.stop - part.start
        now = time.perf_counter()
        # The first chunk may have waited for the compiler.
        first = first or (now, done)
        rate = (done - first[1]) / (now - first[0]) if done > first[1] else done / (now - begun)
        about = {"points": done, "seconds": now - begun, "rate": rate, "reason": reason}
        yield _cells(about, cells[part], strides[part], values, names)
    seconds = time.perf_counter() - begun
    yield pack({"kind": "done", "points": done, "seconds": seconds, "rate": rate}, {})


def _cells(
    about: dict[str, Any],
    cells: Cells,
    strides: Cells,
    values: Values,
    names: list[tuple[str, int | None]],
) -> bytes:
    """Return the frame of some cells."""
    with np.errstate(over="ignore"):  # what is beyond all pictures becomes infinite
        shown = np.array([of_point(values, name) for name in names], dtype=np.float32)
    return pack(
        {"kind": "cells", **about},
        {
            "cell": cells.astype(np.int32),
            "stride": strides.astype(np.uint8),
            "status": values[STATUS].astype(np.uint8),
            "values": shown,
        },
    )


def variables_of(plan: Plan) -> list[tuple[str, int | None]]:
    """Return the variables to send, of two balls each one's."""
    result: list[tuple[str, int | None]] = []
    for observable in plan.observables:
        apart = plan.system.angles == 2 and not observable.is_joint
        for name in mappable(observable, plan.system.angles):
            result += [(name, 0), (name, 1)] if apart else [(name, None)]
    return result


def of_point(values: Values, variable: tuple[str, int | None]) -> NDArray[np.float64]:
    """Return one number a point: of a ball, and the first where there are several."""
    name, ball = variable
    result = values[name] if ball is None else values[name][:, ball]
    return result.reshape(len(result), -1)[:, 0]


def _begin(shown: Map, points: int) -> bytes:
    """Return the frame that a map begins with."""
    known = {axis["name"]: axis for axis in shown.choices["axes"]}
    about = attributes_of_variables(shown.plan)
    variables = [about_variable(name, about[name], ball) for name, ball in variables_of(shown.plan)]
    return pack(
        {
            "kind": "begin",
            "x": {**known[shown.x.name], "log": shown.x.log},
            "y": {**known[shown.y.name], "log": shown.y.log},
            "key": shown.plan.hash,
            "observable": shown.shown,
            "statuses": [name.replace("_", " ") for name in STATUS_NAMES],
            "variables": variables,
            "points": points,
            "title": shown.scenario.title,
            "python": sweep_lines(shown),
            "command": sweep_command(shown),
            **constants_of(attributes_of(shown.plan, ROUNDING["threads"])),
        },
        sides_of(*sides(shown)),
    )


def constants_of(attributes: Mapping[str, Any]) -> dict[str, Any]:
    """Return what does not vary over a map: numbers, and whether balls meet walls."""
    numbers = {name: value for name, value in attributes.items() if isinstance(value, (int, float))}
    return {"parameters": numbers, "has_contact": attributes.get("contact", "none") != "none"}


def about_variable(name: str, about: dict[str, Any], ball: int | None) -> dict[str, Any]:
    """Return how a variable is shown, with the colours of its classes if it has some."""
    return {
        "name": name,
        "ball": None if ball is None else ("right", "left")[ball],
        "label": about["long_name"],
        "symbol": about["symbol"],
        "unit": about["units"],
        "units": units_of(quantity_of(name, about["units"])),
        "classes": [list(entry) for entry in CLASSES.get(name, {}).items()],
    }


def sides(shown: Map) -> tuple[Side, Side]:
    """Return the axes of a map, x first."""
    x, y = (
        Side(span.name, values, {}, span.name, is_log=bool(span.log))
        for span, values in zip((shown.x, shown.y), shown.grid, strict=True)
    )
    return x, y


def sides_of(x: Side, y: Side) -> dict[str, Any]:
    """Return the arrays of both axes: middles and borders of the cells."""
    return {"x": x.values, "x_edges": x.edges, "y": y.values, "y_edges": y.edges}
