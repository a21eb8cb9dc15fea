"""Delimiter, rows and header lines of a text, found from all of its lines."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError, Sentence, Word
from latolato.io.tables.cells import (
    DELIMITER_NAMES,
    DELIMITERS,
    MINUS,
    NUMBERS,
    is_comment,
    kind_of,
    kinds_of,
    number_in,
    opens_quote,
    split,
    zeros,
)
from latolato.io.tables.keys import with_names_above
from latolato.io.tables.rules import broken, said
from latolato.io.tables.shapes import LEADING, Lines, lines_of

# A cell in quotation marks goes over at most so many lines.
_LONGEST_CELL = 10
# Kinds of lines.
_BLANK, _COMMENT, _ROW, _MIXED, _ODD, _TEXT = range(6)
_SEPARATOR = re.compile(r"\"?sep=(.)\"?\s*", re.IGNORECASE)
# The line between names and rows of a table drawn with bars.
_RULE = re.compile(r"[\s|+:=_-]*[-=_]{2}[\s|+:=_-]*")
# A line of more cells holds no row of a table.
_MOST_CELLS = 200_000


@dataclass(frozen=True)
class Column:
    """What all rows hold in one place: how often each kind of cell, and where first.

    Attributes
    ----------
    counts : dict of str to int
        Kinds as `cells.kind_of` gives them.
    first : dict of str to int
        Index of the first line with a cell of that kind.
    words : set of str
        The words for missing numbers, as written.
    """

    counts: dict[str, int] = field(default_factory=dict)
    first: dict[str, int] = field(default_factory=dict)
    words: set[str] = field(default_factory=set)

    @property
    def is_text(self) -> bool:
        """Whether most cells that hold something are texts."""
        counted = sum(self.counts.get(kind, 0) for kind in (*NUMBERS, "quantity"))
        return self.counts.get("text", 0) > counted


@dataclass(frozen=True)
class Block:
    """Rows below each other and the header lines above them, as indices of lines."""

    header: list[int]
    rows: NDArray[np.int64]


@dataclass(frozen=True)
class Layout:
    """A text parted into header lines and rows of cells.

    Attributes
    ----------
    lines : Lines
    delimiter : str
        One of `cells.DELIMITERS`.
    width : int
        Number of columns up to the last one that holds something.
    columns : list of Column
        One for each cell of the rows; those beyond `width` are empty.
    blocks : list of Block
        At least one.
    decimal : str or None
        The decimal sign, where the kind of file settles it.
    has_quotes : bool
        Whether rows hold quotation marks.
    notes : list of Sentence
        What was left out.
    """

    lines: Lines
    delimiter: str
    width: int
    columns: list[Column]
    blocks: list[Block]
    decimal: str | None
    has_quotes: bool
    notes: list[Sentence]


def layout_of(text: bytes, *, delimiter: str | None = None, decimal: str | None = None) -> Layout:
    r"""Return the layout of a text whose lines end in ``\n``.

    Raises
    ------
    InputError
        If there is no row of numbers, a row has a wrong number of cells, or a quotation mark is
        never closed; with the number of the line.
    """
    lines = _with_whole_cells(lines_of(text))
    _refuse_endless_line(lines)
    lines = with_names_above(lines)
    counts = np.bincount(lines.shape_of, minlength=len(lines.shapes))
    if delimiter is None:
        delimiter = _named_delimiter(lines) or _likeliest_delimiter(lines.shapes, counts)
    cells = [_cells(shape, delimiter) for shape in lines.shapes]
    kinds = [kinds_of(row, delimiter) for row in cells]
    raw_width = _usual_width(lines, kinds, counts)
    is_text, width = _column_types(kinds, counts, raw_width)
    of_shape = np.array(
        [
            _COMMENT
            if is_comment(shape)
            else _BLANK
            if _RULE.fullmatch(shape)
            else _kind_of_line(row, each, raw_width, width, is_text)
            for shape, row, each in zip(lines.shapes, cells, kinds, strict=True)
        ]
    )
    of_line = of_shape[lines.shape_of]
    if _SEPARATOR.fullmatch(lines.line(0)):
        of_line[0] = _BLANK
    blocks, notes = _blocks(lines, of_line, delimiter, width, is_text)
    rows = np.concatenate([block.rows for block in blocks])
    columns = _columns(lines, rows, kinds, raw_width, delimiter)
    present = np.unique(lines.shape_of[rows])
    return Layout(
        lines=lines,
        delimiter=delimiter,
        width=width,
        columns=columns,
        blocks=blocks,
        decimal=decimal,
        has_quotes=any('"' in lines.shapes[i] for i in present),
        notes=notes,
    )


def _with_whole_cells(lines: Lines) -> Lines:
    """Return lines in which a cell in quotation marks that goes over several is one line."""
    opening = [opens_quote(shape) and not is_comment(shape) for shape in lines.shapes]
    if not any(opening):
        return lines
    opens = np.flatnonzero(np.array(opening)[lines.shape_of])
    is_odd = np.array([shape.count('"') % 2 == 1 for shape in lines.shapes])[lines.shape_of]
    joined = np.zeros(len(is_odd), dtype=bool)
    at = -1
    for first in opens:
        if first <= at:
            continue
        later = np.flatnonzero(is_odd[first + 1 : first + _LONGEST_CELL])
        if not later.size:
            values = {"line": lines.numbers[first]}
            raise broken("open_quote", values, value=lines.line(int(first))[:40])
        at = int(first + 1 + later[0])
        joined[first + 1 : at + 1] = True
    text = bytearray(lines.text)
    for i in np.flatnonzero(joined):
        text[lines.starts[i] - 1] = ord(" ")
    return lines_of(bytes(text), lines.numbers[~joined])


def _refuse_endless_line(lines: Lines) -> None:
    """Raise for a line of more cells than any table has."""
    for i, shape in enumerate(lines.shapes):
        if len(shape) > _MOST_CELLS and max(map(shape.count, DELIMITERS)) > _MOST_CELLS:
            line = lines.numbers[np.flatnonzero(lines.shape_of == i)[0]]
            raise broken("endless_line", {"line": line, "count": _MOST_CELLS})


def _no_rows(lines: Lines) -> InputError:
    """Return the error for a text without rows of numbers."""
    last = len(lines.numbers) - 1
    return broken("no_rows", {"line": lines.numbers[last], "text": lines.line(last)[:40]})


def _named_delimiter(lines: Lines) -> str | None:
    """Return the delimiter that a first line such as ``sep=;`` names."""
    match = _SEPARATOR.fullmatch(lines.line(0))
    return match[1] if match and match[1] in DELIMITERS else None


def _likeliest_delimiter(shapes: list[str], counts: NDArray[np.int64]) -> str:
    """Return the delimiter that leaves the largest share of numbers among the cells of a line."""
    usual = [i for i in np.argsort(-counts, kind="stable")[:2000] if shapes[i].strip()]
    usual = [i for i in usual if not is_comment(shapes[i])]
    ranks = []
    for place, delimiter in enumerate(DELIMITERS):
        score, weak, several = 0.0, 0.0, False
        for i in usual:
            kinds = kinds_of(_cells(shapes[i], delimiter), delimiter)
            held = sum(kind != "empty" for kind in kinds)
            numbers = sum(_is_number(kind) or kind == "missing" for kind in kinds)
            # Lines with more words than numbers count only if there are no others.
            score += counts[i] * max(2 * numbers - held, 0) / max(held, 1)
            weak += counts[i] * numbers / max(held, 1)
            several = several or numbers > 1
        ranks.append((round(score, 6), several, round(weak, 6) if not score else 0.0, -place))
    return DELIMITERS[-max(ranks)[-1]]


def _cells(shape: str, delimiter: str) -> list[str]:
    """Return the cells of a line's shape without a comment at its end."""
    cells = split(shape, delimiter)
    if len(cells) > 2 and cells[-1].startswith("#") and kind_of(cells[-1]) == "text":
        return cells[:-1]
    return cells


def _is_number(kind: str) -> bool:
    return kind in NUMBERS or kind == "quantity"


def _usual_width(lines: Lines, kinds: list[list[str]], counts: NDArray[np.int64]) -> int:
    """Return how many cells most lines of numbers have, empty ones at the end too."""
    weights: dict[int, int] = {}
    for row, count in zip(kinds, counts, strict=True):
        numbers = sum(map(_is_number, row))
        if numbers:
            weights[len(row)] = weights.get(len(row), 0) + int(count) * numbers
    if not weights and any(re.search(r"'[-+.,]?0", shape) for shape in lines.shapes):
        raise broken("single_quotes")
    if not weights:
        raise _no_rows(lines)
    return max(weights, key=lambda width: (weights[width], width))


def _column_types(
    kinds: list[list[str]], counts: NDArray[np.int64], raw_width: int
) -> tuple[list[bool], int]:
    """Return for each column whether it holds texts, and the number of columns that hold any."""
    balance = [0] * raw_width
    width = 0
    for row, count in zip(kinds, counts, strict=True):
        if len(row) != raw_width or not any(map(_is_number, row)):
            continue
        for place, kind in enumerate(row):
            if kind != "empty" and count > 0:
                balance[place] += int(count) * (
                    1 if _is_number(kind) else -1 if kind == "text" else 0
                )
    for row in kinds:
        if len(row) == raw_width and any(map(_is_number, row)):
            held = [place for place, kind in enumerate(row) if kind != "empty"]
            width = max(width, held[-1] + 1)
    return [each < 0 for each in balance], width


def _kind_of_line(
    cells: list[str], kinds: list[str], raw_width: int, width: int, is_text: list[bool]
) -> int:
    """Return the kind of a line that is no comment."""
    held = [place for place, kind in enumerate(kinds) if kind != "empty"]
    if not held:
        return _BLANK
    numbers = sum(_is_number(kinds[place]) for place in held)
    texts = [place for place in held if kinds[place] == "text"]
    fits = len(kinds) == raw_width or (len(kinds) >= width and held[-1] < width)
    if not fits:
        return _ODD if numbers and not texts else _TEXT
    wrong = [place for place in texts if not is_text[place]]
    if not wrong and (numbers or not texts):
        return _ROW
    return _MIXED if numbers or any(_begins_as_number(cells[i]) for i in wrong) else _TEXT


def _begins_as_number(cell: str) -> bool:
    """Return whether a cell begins with a digit, as a spoiled number does and no name."""
    return re.match(f"[-+.,{MINUS}]?[0{LEADING}]", zeros(cell)) is not None


def _blocks(
    lines: Lines, of_line: NDArray[np.int64], delimiter: str, width: int, is_text: list[bool]
) -> tuple[list[Block], list[Sentence]]:
    """Return the blocks of rows with their header lines, and what was left out."""
    of_line = of_line.copy()
    rows = np.flatnonzero(of_line == _ROW)
    if not rows.size:
        raise _no_rows(lines)
    start = int(rows[0])
    _refuse_odd(lines, of_line, _right_above(of_line, start), delimiter, width)
    start = _with_spoiled_rows(lines, of_line, start, delimiter)
    rows = np.flatnonzero(of_line == _ROW)
    has_sections = any(
        "kinovea" in lines.line(i).lower() for i in range(start) if of_line[i] == _COMMENT
    )
    cuts = [start]
    headers = [[i for i in range(start) if of_line[i] != _BLANK]]
    notes: list[Sentence] = []
    for group in _gaps(of_line, start):
        held = [i for i in group if of_line[i] != _BLANK]
        _refuse_odd(lines, of_line, held, delimiter, width)
        texts = [i for i in held if of_line[i] == _TEXT]
        follows = group[-1] + 1
        if follows == len(of_line):
            if texts:
                notes.append(_left_out(lines, [i for i in held if of_line[i] in (_TEXT, _ODD)]))
                of_line[held] = _COMMENT
        elif _begins_again(lines, rows, follows, delimiter, is_text) or any(
            _looks_like_names(lines.line(i), delimiter, width) for i in texts
        ):
            cuts.append(follows)
            headers.append(held)
            of_line[held] = _COMMENT
        elif has_sections and held:
            cuts.append(follows)
            headers.append(held)
        elif texts:
            _refuse_spoiled(lines, held, delimiter, width)
            notes.append(_left_out(lines, texts))
        of_line[[i for i in held if of_line[i] == _MIXED]] = _ROW
    rows = np.flatnonzero(of_line == _ROW)
    rows = rows[rows >= start]
    edges = [*np.searchsorted(rows, cuts).tolist(), len(rows)]
    blocks = [
        Block(header, rows[low:high])
        for header, low, high in zip(headers, edges[:-1], edges[1:], strict=True)
    ]
    return blocks, notes


def _right_above(of_line: NDArray[np.int64], start: int) -> list[int]:
    """Return the lines of numbers between which and the first row there are no words."""
    found: list[int] = []
    for i in range(start - 1, -1, -1):
        if of_line[i] in (_TEXT, _MIXED):
            break
        if of_line[i] == _ODD:
            found.insert(0, i)
    return found


def _with_spoiled_rows(lines: Lines, of_line: NDArray[np.int64], start: int, delimiter: str) -> int:
    """Return the first row, where words stand in columns of numbers, and mark such lines as rows.

    Above the first row without such words, they are rows if names stand above them, or if a word
    begins with a digit as no name does.
    """
    has_names = bool(np.any(of_line[:start] == _TEXT))
    for i in range(start - 1, -1, -1):
        if of_line[i] in (_BLANK, _COMMENT):
            continue
        if of_line[i] != _MIXED or re.match(r"\w+=\t", lines.line(i)):  # a key of LabChart
            break
        cells = split(lines.line(i), delimiter)
        kinds = kinds_of([zeros(cell) for cell in cells], delimiter)
        words = [cell for cell, kind in zip(cells, kinds, strict=True) if kind == "text"]
        if not has_names and not any(map(_begins_as_number, words)):
            break
        of_line[i] = _ROW
        start = i
    return start


def _gaps(of_line: NDArray[np.int64], start: int) -> Iterator[list[int]]:
    """Yield the indices of lines between rows, gap by gap."""
    others = start + np.flatnonzero(of_line[start:] != _ROW)
    for group in np.split(others, np.flatnonzero(np.diff(others) > 1) + 1):
        if group.size:
            yield group.tolist()


def _refuse_odd(
    lines: Lines, of_line: NDArray[np.int64], held: list[int], delimiter: str, width: int
) -> None:
    """Raise for a row with a wrong number of cells, unless it belongs to a header."""
    for i in held:
        if of_line[i] == _ODD and not any(of_line[j] == _TEXT for j in held):
            raise _wrong_width(lines, i, delimiter, width)


def _refuse_spoiled(lines: Lines, held: list[int], delimiter: str, width: int) -> None:
    """Raise for a line among remarks between rows that holds numbers as a row does."""
    for i in held:
        cells = split(lines.line(i), delimiter)
        kinds = kinds_of([zeros(cell) for cell in cells], delimiter)
        numbers = sum(map(_is_number, kinds))
        if len(cells) != width and (numbers > 1 or numbers == len(cells)):
            raise _wrong_width(lines, i, delimiter, width)


def _wrong_width(lines: Lines, i: int, delimiter: str, width: int) -> InputError:
    """Return the error for a row with a wrong number of cells."""
    count = len(split(lines.line(i), delimiter))
    has_commas = delimiter == "," and "." not in lines.line(i)
    return broken(
        "one_cell" if count == 1 else "wrong_width",
        {"line": lines.numbers[i], "count": count, "width": width},
        way_out=said("commas_in_line") if has_commas else None,
    )


def _left_out(lines: Lines, texts: list[int]) -> Sentence:
    """Return a note about lines that belong to no row."""
    first, more = lines.numbers[texts[0]], len(texts) - 1
    shown = " ".join(lines.line(texts[0]).split())[:40]
    return said("lines_left_out" if more else "line_left_out", line=first, count=more, text=shown)


def _begins_again(
    lines: Lines, rows: NDArray[np.int64], after: int, delimiter: str, is_text: list[bool]
) -> bool:
    """Return whether the first column of numbers rises, falls above a row, and rises again."""
    place = is_text.index(False)
    at = int(np.searchsorted(rows, after))
    values = []
    for i in rows[max(at - 2, 0) : at + 2].tolist():
        cells = split(lines.line(i), delimiter)
        text = cells[place].replace(",", ".") if place < len(cells) else ""
        try:
            values.append(float(text))
        except ValueError:
            return False
    if at == 0:  # words stand in the row above
        return False
    steps = [later - earlier for earlier, later in pairwise(values)]
    gap = min(at, 2) - 1
    return steps[gap] < 0.0 and all(step > 0.0 for i, step in enumerate(steps) if i != gap)


def _looks_like_names(line: str, delimiter: str, width: int) -> bool:
    """Return whether a line has as many words as there are columns."""
    cells = split(line, delimiter)
    while cells and not cells[-1]:
        cells.pop()
    return len(cells) == width > 1 and all(cells)


def _columns(
    lines: Lines, rows: NDArray[np.int64], kinds: list[list[str]], width: int, delimiter: str
) -> list[Column]:
    """The kinds of cells in each column, counted over the rows."""
    columns = [Column() for _ in range(width)]
    present, first, counts = np.unique(lines.shape_of[rows], return_index=True, return_counts=True)
    for shape, at, count in zip(present.tolist(), rows[first].tolist(), counts, strict=True):
        cells = split(lines.shapes[shape], delimiter)
        for column, kind, cell in zip(columns, kinds[shape], cells, strict=False):
            column.counts[kind] = column.counts.get(kind, 0) + int(count)
            column.first[kind] = min(at, column.first.get(kind, at))
            if kind == "quantity":  # the number in front of the unit has a decimal sign too
                number = kind_of(number_in(cell))
                column.counts.setdefault(number, 0)
                column.first[number] = min(at, column.first.get(number, at))
    return columns


def delimiter_name(delimiter: str) -> Word:
    """Return the delimiter in words."""
    return Word(DELIMITER_NAMES[delimiter])
