"""Objects whose rows stand below each other, set side by side: one row for each time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from latolato.io.tables.cells import MINUS
from latolato.io.tables.layout import Layout, layout_of
from latolato.io.tables.rules import broken


@dataclass(frozen=True)
class Rows:
    """The rows of one object.

    Attributes
    ----------
    name : str
        What the object is called.
    lines : list of int
        The line of the file in which each row stands.
    cells : list of list of str
        The cells of each row.
    """

    name: str
    lines: list[int]
    cells: list[list[str]]


def _order(time: str) -> tuple[float, str]:
    """Return the place of a time among others: numbers by their value, clocks by their text."""
    try:
        return float(time.replace(",", ".").replace(MINUS, "-")), ""
    except ValueError:
        return 0.0, time


def meet(objects: Sequence[Rows], clock: int) -> bool:
    """Return whether objects have times in common."""
    times = [{row[clock] for row in each.cells} for each in objects]
    return len(set().union(*times)) < sum(map(len, times))


def side_by_side(
    objects: Sequence[Rows], shared: Sequence[int], own: Sequence[int], decimal: str | None
) -> Layout:
    """Return a table with shared columns, and next to them the own ones of each object.

    Parameters
    ----------
    objects : sequence of Rows
    shared : sequence of int
        The places of columns whose cells are the same for all objects; the first is the time.
    own : sequence of int
        The places of the others.
    decimal : {".", ","} or None
        The decimal sign, where it is known.

    Raises
    ------
    InputError
        If an object has two rows for the same time, with the line of the second.
    """
    table: dict[str, tuple[int, list[str]]] = {}
    empty = [""] * (len(shared) + len(own) * len(objects))
    for k, each in enumerate(objects):
        first = len(shared) + k * len(own)
        seen = set()
        for line, cells in zip(each.lines, each.cells, strict=True):
            time = cells[shared[0]]
            if time in seen:
                raise broken("second_row", {"name": each.name, "time": time, "line": line})
            seen.add(time)
            _, row = table.setdefault(time, (line, list(empty)))
            row[: len(shared)] = [cells[i] for i in shared]
            row[first : first + len(own)] = [cells[i] for i in own]
    ordered = sorted(table.values(), key=lambda pair: _order(pair[1][0]))
    text = "".join("\t".join(cells) + "\n" for _, cells in ordered)
    layout = layout_of(text.encode(), delimiter="\t", decimal=decimal)
    numbers = np.array([line for line, _ in ordered], dtype=np.int32)
    return replace(layout, lines=replace(layout.lines, numbers=numbers))
