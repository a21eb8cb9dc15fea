"""Columns of numbers: one decimal sign for the whole file, or a refusal."""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError, Sentence
from latolato.io.tables.cells import (
    BLANKS,
    GROUPING,
    MINUS,
    MISSING_WORDS,
    NUMBERS,
    kind_of,
    kinds_of,
    number_in,
    split,
    zeros,
)
from latolato.io.tables.layout import Block, Layout
from latolato.io.tables.rules import broken, said

Floats = NDArray[np.float64]
# A number whose thousands a comma groups, in a shape of a line.
_GROUP = re.compile(rf"[-+{MINUS}]?\d{{1,3}},\d{{3}}(\.\d*)?")
# Blanks other than the usual ones, in UTF-8.
_BLANK = re.compile(
    rb"\xc2[\x85\xa0]|\xe1\x9a\x80|\xe2\x80[\x80-\x8a\xa8\xa9\xaf]|\xe2\x81\x9f|\xe3\x80\x80|[\v\f]"
)
Label = Callable[[int], str]

POINT, COMMA = DECIMALS = (".", ",")
# Kinds of cells that only one decimal sign allows, and the kind that both do: three digits
# behind the sign, which may be decimals or end a number with grouped thousands.
_PROOFS = {POINT: ("point", "commas of thousands"), COMMA: ("comma", "points of thousands")}
_UNSURE = {POINT: "point or thousands", COMMA: "comma or thousands"}
_GROUPS = {POINT: "points of thousands", COMMA: "commas of thousands"}
_OR_GROUPS = {POINT: "points_or_groups", COMMA: "commas_or_groups"}


@dataclass(frozen=True)
class Signs:
    """The decimal sign of a file, and the sign that groups thousands, None without one."""

    decimal: str
    thousands: str | None


def signs_of(layout: Layout, places: Sequence[int], decimal: str | None, label: Label) -> Signs:
    """Return the signs with which the numbers in some columns are written.

    Parameters
    ----------
    layout : Layout
    places : sequence of int
        The columns, from 0.
    decimal : {".", ","}, optional
        The decimal sign, if the caller knows it.
    label : callable
        Gives the name of a column for messages.

    Raises
    ------
    InputError
        If columns contradict each other, or a number could be read in two ways.

    Notes
    -----
    Numbers such as ``0.25`` or ``1.234,5`` settle the decimal sign of the file. Numbers such as
    ``1.234`` do not. They are read with the decimal sign that others settle, but refused where a
    column looks as if it counted in thousands: ``999`` in one row and ``1.000`` in another.
    """
    given = decimal = decimal or layout.decimal
    if decimal is None:
        decimal = _settled_sign(layout, places, label)
    other = COMMA if decimal == POINT else POINT
    unsure = _first_place(layout, places, _UNSURE[other])
    if given is None:
        for place in places:
            if _counts_in_thousands(layout, place, _UNSURE[decimal]):
                raise _two_ways(layout, place, decimal, label)
        has_proof = _first_place(layout, range(layout.width), _GROUPS[other]) is not None
        for place in places:
            if (
                _UNSURE[other] in layout.columns[place].counts
                and not has_proof
                and not _counts_in_thousands(layout, place, _UNSURE[other])
            ):
                raise _two_ways(layout, place, other, label)
    has_groups = unsure is not None or _first_place(layout, places, _GROUPS[other]) is not None
    return Signs(decimal, other if has_groups else None)


def _settled_sign(layout: Layout, places: Sequence[int], label: Label) -> str:
    """Return the decimal sign that numbers settle: those asked for, or else any of the file."""
    every = [i for i in range(layout.width) if not layout.columns[i].is_text]
    for among in (places, every):
        proofs = {}
        for sign in DECIMALS:
            found = [
                (place, kind)
                for place in among
                for kind in _PROOFS[sign]
                if kind in layout.columns[place].counts
            ]
            if found:
                proofs[sign] = found[0]
        if len(proofs) == 2 and among is places:
            one, other = (_example(layout, *each, label) for each in proofs.values())
            raise broken("two_decimal_signs", {"one": one, "other": other})
        if len(proofs) == 1:
            return next(iter(proofs))
    for sign in DECIMALS:
        place = _first_place(layout, places, _UNSURE[sign])
        # Where commas separate the cells, points are decimal signs.
        if place is not None and (sign == COMMA or layout.delimiter != COMMA):
            raise _two_ways(layout, place, sign, label)
    return POINT


def _first_place(layout: Layout, places: Sequence[int], kind: str) -> int | None:
    """Return the first column that holds a kind of cell."""
    return next((i for i in places if kind in layout.columns[i].counts), None)


def _counts_in_thousands(layout: Layout, place: int, unsure: str) -> bool:
    """Return whether a column seems to go on from ``999`` to ``1.000``.

    It holds whole numbers of three digits, others like ``1.234`` only, and where the two kinds meet
    the numbers are closer to each other if the sign groups thousands.
    """
    whole = ("three digits", "integer")
    held = layout.columns[place].counts.keys() - {"empty", "missing", "text", "quantity"}
    if not {unsure, whole[0]} <= held <= {unsure, *whole}:
        return False
    kinds = [
        kind_of(cells[place]) if place < len(cells) else "empty"
        for cells in (split(shape, layout.delimiter) for shape in layout.lines.shapes)
    ]
    is_whole = np.array([kind in whole for kind in kinds])
    is_unsure = np.array([kind == unsure for kind in kinds])
    jumps = {"decimal": 0.0, "thousands": 0.0}
    for block in layout.blocks:
        shapes = layout.lines.shape_of[block.rows]
        for first, second in ((is_whole, is_unsure), (is_unsure, is_whole)):
            for at in np.flatnonzero(first[shapes[:-1]] & second[shapes[1:]])[:20]:
                cells = [_cell(layout, int(i), place) for i in block.rows[at : at + 2]]
                for meaning, mark in (("decimal", "."), ("thousands", "")):
                    plain = (re.sub("[.,]", mark, each.replace(MINUS, "-")) for each in cells)
                    before, after = (np.log1p(abs(float(each))) for each in plain)
                    jumps[meaning] += abs(after - before)
    return jumps["thousands"] <= jumps["decimal"]


def _two_ways(layout: Layout, place: int, sign: str, label: Label) -> InputError:
    """Return the error for numbers that could be read in two ways."""
    cell = _example(layout, place, _UNSURE[sign], label)
    return broken(_OR_GROUPS[sign], {"cell": cell}, parameter="decimal")


def _example(layout: Layout, place: int, kind: str, label: Label) -> Sentence:
    """Return a cell of a kind with its line and column, for messages."""
    index = layout.columns[place].first[kind]
    cell = _cell(layout, index, place)
    return said("cell_at", cell=cell, line=layout.lines.numbers[index], column=label(place))


def _cell(layout: Layout, index: int, place: int) -> str:
    """Return a cell of a line as written."""
    return split(layout.lines.line(index), layout.delimiter)[place]


def is_comma_both(layout: Layout, named: int) -> bool:
    """Return whether commas separate the cells and could be decimal signs as well.

    They could where the names do not account for all cells, or some rows have more. Then no point
    is a decimal sign, or whole numbers are followed by columns of three digits, like ``1,000`` or
    ``1,000.5``, or all rows, or those with more cells, hold such numbers.
    """
    if layout.delimiter != COMMA or layout.has_quotes:
        return False
    rows = np.concatenate([block.rows for block in layout.blocks])
    shapes = [layout.lines.shapes[i] for i in np.unique(layout.lines.shape_of[rows])]
    cells = [split(shape, COMMA) for shape in shapes]
    is_ragged = len({len(each) for each in cells}) > 1
    if named >= layout.width and not is_ragged:
        return False
    kinds = [column.counts.keys() - {"empty", "missing"} for column in layout.columns]
    if not set().union(*kinds) & {"point", "quantity"}:
        return True
    groups = [[_is_group(*pair) for pair in pairwise(each)] for each in cells]
    least = min(map(len, groups))
    for width in (least, least - 1):  # that they all might have
        wider = [each for each in groups if len(each) > width]
        if wider and all(each.count(True) >= len(each) - width for each in wider):
            return True
    return any(set(place) in ({True}, {True, None}) for place in zip(*groups, strict=False)) or any(
        first <= {"integer", "three digits"} and second == {"three digits"}
        for first, second in pairwise(kinds)
    )


def _is_group(first: str, second: str) -> bool | None:
    """Return whether neighbouring cells could be one number such as ``1,000.5``; None if empty."""
    if not first or not second:
        return None
    return _GROUP.fullmatch(f"{first},{second}") is not None


def other_delimiter(layout: Layout) -> str | None:
    """Return another delimiter that would make numbers of all rows: of ``5,1 000`` a comma."""
    if layout.delimiter != BLANKS:
        return None
    widths = set()
    for shape in np.unique(layout.lines.shape_of[np.concatenate([b.rows for b in layout.blocks])]):
        cells = split(layout.lines.shapes[shape], COMMA)
        if not all(kind_of(cell) in NUMBERS for cell in cells):
            return None
        widths.add(len(cells))
    return COMMA if len(widths) == 1 and widths != {1} else None


def numbers_of(
    layout: Layout, block: Block, places: Sequence[int], decimal: str | None, label: Label
) -> tuple[dict[int, Floats], Signs]:
    """Return columns of numbers, NaN for missing cells, and the signs with which they are written.

    Raises
    ------
    InputError
        As for `signs_of`, and for cells that are not numbers, with line and column.
    """
    signs = signs_of(layout, places, decimal, label)
    for place in places:
        _refuse_other_cells(layout, block, place, signs, label)
    return _parsed(layout, block, places, signs), signs


def _refuse_other_cells(
    layout: Layout, block: Block, place: int, signs: Signs, label: Label
) -> None:
    """Raise for the first cell of a column that is neither a number nor missing."""
    column = layout.columns[place]
    other = POINT if signs.decimal == COMMA else COMMA
    good = {"integer", "three digits", "empty", "missing", _UNSURE[signs.decimal]}
    good |= set(_PROOFS[signs.decimal]) | {_UNSURE[other]}
    if not column.counts.keys() - good:
        return
    lines = layout.lines
    is_bad = np.zeros(len(lines.shapes), dtype=bool)
    for shape in np.unique(lines.shape_of[block.rows]):
        cells = split(lines.shapes[shape], layout.delimiter)
        kinds = kinds_of(cells, layout.delimiter)
        is_bad[shape] = place < len(kinds) and kinds[place] not in good
    bad = block.rows[is_bad[lines.shape_of[block.rows]]]
    if not bad.size:
        return
    cell = _cell(layout, int(bad[0]), place)
    kind = kind_of(zeros(cell))
    if re.fullmatch(r"\d+(:\d+)+([.,]\d+)?", cell):
        way_out = said("plain_seconds")
    elif kind == "quantity":
        way_out = said("unit_in_name")
    elif len(bad) > 0.5 * len(block.rows):
        way_out = said("column_of_numbers")
    else:
        way_out = None
    values = {"line": lines.numbers[bad[0]], "column": label(place), "cell": shown(cell)}
    raise broken("no_number", values, way_out=way_out)


def shown(cell: str) -> str:
    r"""Return a cell in quotes, with codes for characters that cannot be seen.

    Examples
    --------
    >>> print(shown("0,5 °"), shown("\u200b0.5"))
    '0,5 °' '\u200b0.5'
    """
    return f"'{cell[:40]}'" if cell.isprintable() else repr(cell[:40])


def _body(layout: Layout, block: Block) -> bytes:
    """Return the rows of a block as text, one a line."""
    starts, rows, text = layout.lines.starts, block.rows, layout.lines.text
    if rows[-1] - rows[0] + 1 == len(rows):
        return text[starts[rows[0]] : starts[rows[-1] + 1]]
    return b"".join(text[starts[row] : starts[row + 1]] for row in rows)


def _plain(body: bytes, delimiter: str) -> bytes:
    """Return rows with plain minus and blanks, and without blanks or apostrophes in numbers."""
    body = body.replace(MINUS.encode(), b"-")
    for sign in GROUPING:
        mark = sign.encode()
        if mark in body and not (sign.isspace() and delimiter in (BLANKS, ",")):
            pattern = rb"(?<=[0-9])" + re.escape(mark) + rb"(?=[0-9]{3}(?![0-9]))"
            body = re.sub(pattern, b"", body)
    return re.sub(_BLANK, b" ", body)


def plain_text(cell: str, signs: Signs) -> str:
    """Return a number, perhaps with a unit behind it, with a decimal point; "" if it is missing.

    Examples
    --------
    >>> plain_text("1.020,5 mm", Signs(",", "."))
    '1020.5 mm'
    """
    cell = cell.strip().replace(MINUS, "-")
    if cell.lower() in MISSING_WORDS:
        return ""
    number = number_in(cell)
    plain = re.sub(f"[{GROUPING}{signs.thousands or ''}]", "", number).replace(signs.decimal, ".")
    return plain + cell[len(number) :]


def _parsed(layout: Layout, block: Block, places: Sequence[int], signs: Signs) -> dict[int, Floats]:
    """Return the numbers in columns whose cells are known to be numbers or missing."""
    import pandas as pd

    delimiter = layout.delimiter
    body = _plain(_body(layout, block), delimiter)
    if delimiter == "|":
        body = re.sub(rb"(?m)^[ \t]*\|(.*)\|[ \t]*$", rb"\1", body)
    if delimiter != BLANKS:
        blanks = b" +" if delimiter == "\t" else rb"[ \t]+"
        body = re.sub(blanks + b"(?=" + re.escape(delimiter.encode()) + rb"|\n)", b"", body)
    shapes = np.unique(layout.lines.shape_of[block.rows])
    widest = max(len(split(layout.lines.shapes[i], delimiter)) for i in shapes)
    words = {word for each in MISSING_WORDS for word in (each, each.upper(), each.capitalize())}
    frame = pd.read_csv(
        io.BytesIO(body),
        sep=r"\s+" if delimiter == BLANKS else delimiter,
        header=None,
        names=range(widest),
        usecols=list(places),
        index_col=False,
        skipinitialspace=True,
        skip_blank_lines=False,
        dtype=dict.fromkeys(places, np.float64),
        decimal=signs.decimal,
        thousands=signs.thousands,
        keep_default_na=False,
        na_values=["", "NaN", "N/A", "#N/A", *words],
        engine="c",
        **_exact(pd.__version__),
    )
    assert len(frame) == len(block.rows)
    return {place: frame[place].to_numpy() for place in places}


def _exact(version: str) -> dict[str, Any]:
    """Options with which a version of pandas reads the nearest float to every decimal number."""
    major, minor = (int(part) for part in version.split(".")[:2])
    # From 3.1 on it always does, and warns about the option.
    return {} if (major, minor) >= (3, 1) else {"float_precision": "round_trip"}
