"""Rows that name their numbers: ``t=12,a=3.4``, as a microcontroller logs them."""

from __future__ import annotations

import re

import numpy as np

from latolato.io.tables.cells import DELIMITERS, MINUS, NUMBERS, is_comment, kind_of, split, zeros
from latolato.io.tables.rules import broken
from latolato.io.tables.shapes import LEADING, Lines, lines_of

_KEY = re.compile(rf"(?<![\w.])([^\W\d]\w*)[ \t]*[=:][ \t]*(?=[-+{MINUS}]?[.,]?[0-9{LEADING}])")


def with_names_above(lines: Lines) -> Lines:
    """Return lines without the names in front of their numbers, which a line above them has.

    Raises
    ------
    InputError
        For a row with other names, or in another order, with its line.
    """
    keys = [[] if is_comment(shape) else _KEY.findall(shape) for shape in lines.shapes]
    counts = np.bincount(lines.shape_of, minlength=len(keys))
    counts[[i for i, shape in enumerate(lines.shapes) if not shape.strip()]] = 0
    usual = int(np.argmax(counts))
    if not _are_all_named(lines.shapes[usual]):
        return lines
    has_keys = np.array([bool(each) for each in keys])[lines.shape_of]
    names = _KEY.findall(lines.line(int(np.argmax(lines.shape_of == usual))))
    texts = [lines.line(i) for i in range(len(lines.numbers))]
    for i in np.flatnonzero(has_keys).tolist():
        found = _KEY.findall(texts[i])
        if found != names:
            values = {"line": lines.numbers[i], "names": ", ".join(found)}
            raise broken("other_keys", values | {"others": ", ".join(names)})
        texts[i] = _KEY.sub("", texts[i])
    first = int(np.argmax(has_keys))
    texts.insert(first, "\t".join(names))
    numbers = np.insert(lines.numbers, first, lines.numbers[first])
    return lines_of(("\n".join(texts) + "\n").encode(), numbers)


def _are_all_named(shape: str) -> bool:
    """Return whether a line's shape is two numbers or more, each with a name of its own."""
    names = _KEY.findall(shape)
    left = _KEY.sub("", shape)
    parted = ([zeros(cell) for cell in split(left, each)] for each in DELIMITERS)
    return len(names) > 1 and any(
        len(cells) == len(names) and all(kind_of(cell) in NUMBERS for cell in cells)
        for cells in parted
    )
