"""What a file of another program holds, as one value that a page can show."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError, Sentence, Word, joined, reading
from latolato.core.registry import checked_choice, suggest
from latolato.io.tables.cells import BLANKS, MISSING_WORDS, is_comment, split, without_mark
from latolato.io.tables.container import LARGEST, Part, read_parts
from latolato.io.tables.headings import HeaderLine, Heading, header_of, later_header
from latolato.io.tables.joining import Rows, meet, side_by_side
from latolato.io.tables.kinds import Units, kind_of_file
from latolato.io.tables.layout import Block, Layout, delimiter_name, layout_of
from latolato.io.tables.numbers import (
    DECIMALS,
    POINT,
    Floats,
    is_comma_both,
    numbers_of,
    other_delimiter,
    plain_text,
    shown,
    signs_of,
)
from latolato.io.tables.rules import broken, said
from latolato.io.tables.units import canonical, is_known, is_unit

# Columns that number the object to which a row belongs, and those that all objects share.
_OBJECTS = ("track_id", "track id", "particle", "object")
_CLOCKS = ("position_t", "time", "t", "zeit", "temps", "tiempo", "tempo", "waktu", "frame")
_MOST_OBJECTS = 50
# So many names are listed in a sentence.
_MOST_LISTED = 20
# The sheet or member that a program's export keeps the measurement in.
_MAIN = ("raw data",)


@dataclass(frozen=True)
class SourceColumn:
    """A column of a file.

    Attributes
    ----------
    position : int
        Counted from 1.
    name : str
        Without unit and track, "" if the file has none.
    unit : str
        As this package spells it, or as written; "" if the file has none.
    track : str
        The object or run to which it belongs, "" for all of them.
    written : str
        The cell of the header.
    aliases : tuple of str
        Other names that the file has for it.
    kind : {"numbers", "texts", "empty"}
        What its cells hold.
    unit_from : str
        What the unit was inferred from, "" if it is stated.
    """

    position: int
    name: str
    unit: str
    track: str
    written: str
    aliases: tuple[str, ...]
    kind: str
    unit_from: str

    @property
    def path(self) -> str:
        """Track and name, such as ``right ball/x``; the position if there is no name."""
        if not self.name:
            return str(self.position)
        return f"{self.track}/{self.name}" if self.track else self.name

    @property
    def label(self) -> str:
        """The path in quotes for messages."""
        return f"'{self.path}'" if self.name else f"{self.position}"


@dataclass(frozen=True)
class Section:
    """A table in a file: columns and rows.

    Attributes
    ----------
    name : str
        Its title, its sheet or its number; "" if it has none and is the only one.
    columns : tuple of SourceColumn
    lines : array of int, shape (row,)
        The line of the file in which each row stands.
    comments : tuple of str
        The comments above the rows, without their marks.
    """

    name: str
    columns: tuple[SourceColumn, ...]
    lines: NDArray[np.int32]
    comments: tuple[str, ...]
    _layout: Layout = field(repr=False)
    _block: Block = field(repr=False)

    @property
    def tracks(self) -> list[str]:
        """The objects or runs that columns belong to, in their order."""
        return [each for each in dict.fromkeys(c.track for c in self.columns) if each]

    def column(self, name: str) -> tuple[SourceColumn, str]:
        """Return the column that a text means, and the unit that the text or the file states.

        Parameters
        ----------
        name : str
            The name in the file, with or without the unit in brackets, after the track if several
            have the name, or the position: ``"t [s]"``, ``"right ball/x"``, ``"1 [s]"``.

        Raises
        ------
        InputError
            If there is no such column or there are several, and if the units contradict.
        """
        base, unit = _base_and_unit(name)
        column = self._found(name, base, unit)
        if not unit:
            return column, column.unit
        # A word that is no known unit, such as "Grad", says nothing against a known one.
        is_stated = is_unit(column.unit) and not column.unit_from
        if is_stated and unit != column.unit:
            values = {"column": column.label, "unit": column.unit, "other": unit}
            raise broken("stated_unit", values)
        return column, unit

    def _found(self, name: str, base: str, unit: str) -> SourceColumn:
        """Return the only column that fits best."""

        def names(column: SourceColumn) -> set[str]:
            known = {column.name, column.path, *column.aliases}
            return known | {f"{column.track}/{each}" for each in column.aliases if column.track}

        searches = (
            lambda c: c.written == name,
            lambda c: c.written == base,
            lambda c: base in names(c) and unit in ("", c.unit),
            lambda c: base in names(c),
            lambda c: base.lower() in {each.lower() for each in names(c)},
            lambda c: base == str(c.position),
        )
        for search in searches:
            found = [column for column in self.columns if search(column)]
            if len(found) == 1:
                return found[0]
            if found:
                places = names_text([str(column.position) for column in found])
                tracked = next((c.path for c in found if c.track), None)
                way_out = None
                if tracked and len({c.path for c in found}) == len(found):
                    way_out = said("position_or_track", places=places, path=tracked)
                values = {"count": len(found), "name": base, "places": places}
                raise broken("alike_columns", values, way_out=way_out)
        if not any(column.name for column in self.columns):
            raise broken("unnamed_columns", {"name": base, "count": len(self.columns)})
        known = names_text([column.path for column in self.columns])
        raise broken("no_such_column", {"name": base, "names": known})

    def numbers(
        self, columns: Sequence[SourceColumn], *, decimal: str | None = None
    ) -> tuple[list[Floats], list[Sentence]]:
        """Return columns as numbers, NaN where a cell is empty, and what was assumed.

        Parameters
        ----------
        columns : sequence of SourceColumn
        decimal : {".", ","}, optional
            The decimal sign, where the file leaves it open.

        Returns
        -------
        list of array of float, shape (row,)
            In the units of the file.
        list of Sentence
            Which signs group thousands.

        Raises
        ------
        InputError
            For cells that are not numbers, with line and column, and for numbers that could be
            read in two ways.
        """
        for column in columns:
            if column.kind == "texts":
                index = self._layout.columns[column.position - 1].first["text"]
                cells = split(self._layout.lines.line(index), self._layout.delimiter)
                cell = shown(cells[column.position - 1])
                place = {"column": column.label, "line": self._layout.lines.numbers[index]}
                raise broken("column_of_texts", place | {"cell": cell})
        places = [column.position - 1 for column in columns]
        wanted = list(dict.fromkeys(places))
        values, signs = numbers_of(self._layout, self._block, wanted, decimal, self._label)
        notes = []
        if signs.thousands is not None:
            notes.append(said("points_group" if signs.thousands == POINT else "commas_group"))
        return [values[place] for place in places], notes

    def quantities(
        self, columns: Sequence[SourceColumn], *, decimal: str | None = None
    ) -> list[list[str]]:
        """Return columns whose cells may carry units as texts with points as decimal signs.

        Parameters
        ----------
        columns : sequence of SourceColumn
        decimal : {".", ","}, optional
            The decimal sign, where the file leaves it open.

        Raises
        ------
        InputError
            For numbers that could be read in two ways.
        """
        places = [column.position - 1 for column in columns]
        signs = signs_of(self._layout, places, decimal, self._label)
        return [[plain_text(cell, signs) for cell in self.texts(column)] for column in columns]

    def _label(self, place: int) -> str:
        """Return the name of a column, counted from 0, for messages."""
        labels = {column.position - 1: column.label for column in self.columns}
        return labels.get(place, str(place + 1))

    def texts(self, column: SourceColumn, rows: int | None = None) -> list[str]:
        """Return the cells of a column as written, of all rows or the first ones."""
        return [row[column.position - 1] for row in self.cells(rows)]

    def cells(self, rows: int | None = None) -> list[list[str]]:
        """Return the cells of all rows, or of the first ones, as written."""
        width = len(self._layout.columns)
        parted = []
        for index in self._block.rows[:rows]:
            cells = split(self._layout.lines.line(int(index)), self._layout.delimiter)
            parted.append((cells + [""] * width)[:width])
        return parted


@dataclass(frozen=True)
class SourceTable:
    """What was recognised in a file.

    Attributes
    ----------
    kind : str
        The program whose export it is: "Tracker export"; "table" for others.
    sections : tuple of Section
        At least one.
    encoding, delimiter : str
        As words: "utf-8", "semicolons".
    notes : tuple of Sentence
        What was left out or inferred.
    comments : tuple of str
        The comments above the first rows, without their marks.
    """

    kind: str
    sections: tuple[Section, ...]
    encoding: str
    delimiter: str
    notes: tuple[Sentence, ...]
    comments: tuple[str, ...]

    @property
    def about(self) -> Sentence:
        """One line that says what was recognised.

        Such as ``Tracker export, 2 tracks: right ball, left ball``.
        """
        words: list[str] = [Word(self.kind)]
        first = self.sections[0]
        if len(self.sections) > 1:
            names = names_text([section.name for section in self.sections])
            words.append(said("sections", count=len(self.sections), names=names))
        elif first.tracks:
            count = len(first.tracks)
            rule = "one_track" if count == 1 else "tracks"
            words.append(said(rule, count=count, names=names_text(first.tracks)))
        if not any(column.name for column in first.columns):
            words.append(said("no_names"))
        return joined(words, ", ")

    def section(self, name: str | None = None) -> Section:
        """Return a section by its name or its number from 1; by default the only one.

        Raises
        ------
        InputError
            If there are several and none is named, or none has the name.
        """
        names = [section.name for section in self.sections]
        if name is None:
            if len(names) == 1:
                return self.sections[0]
            values = {"count": len(names), "names": names_text(names), "first": names[0]}
            raise broken("several_tables", values)
        if name in names:
            return self.sections[names.index(name)]
        if name.isdigit() and 0 < int(name) <= len(names):
            return self.sections[int(name) - 1]
        raise broken("no_section", {"name": name}, way_out=suggest(name, names))

    def to_dict(self, rows: int = 5) -> dict[str, Any]:
        """Return everything but the body as plain values, for JSON.

        Parameters
        ----------
        rows : int
            How many rows of each section to include, as written.

        Returns
        -------
        dict
            ``kind``, ``about``, ``encoding``, ``delimiter``, ``notes`` and ``sections``. A section
            has its ``name``, ``tracks``, ``rows`` (their number), ``first_line`` and ``last_line``
            of the file, ``first_rows`` (lists of texts, with their ``line_numbers``) and
            ``columns``, each of which has the attributes of `SourceColumn`.
        """
        return {
            "kind": self.kind,
            "about": self.about,
            "encoding": self.encoding,
            "delimiter": self.delimiter,
            "notes": list(self.notes),
            "sections": [
                {
                    "name": section.name,
                    "tracks": section.tracks,
                    "rows": len(section.lines),
                    "first_line": int(section.lines[0]),
                    "last_line": int(section.lines[-1]),
                    "first_rows": section.cells(rows),
                    "line_numbers": section.lines[:rows].tolist(),
                    "columns": [
                        {**vars(column), "aliases": list(column.aliases), "path": column.path}
                        for column in section.columns
                    ],
                }
                for section in self.sections
            ],
        }


def read_source(path: str | Path, *, decimal: str | None = None) -> SourceTable:
    """The tables in a file of another program, with units and notes.

    Delimiter, header, units and sections are found from all lines of the file.

    Parameters
    ----------
    path : str or Path
        A text table in any usual encoding, such a table in a ``.gz`` or ``.zip`` archive, or a
        spreadsheet (``.xls``, ``.xlsx``, ``.ods``).
    decimal : {".", ","}, optional
        The decimal sign, where the file leaves it open.

    Raises
    ------
    InputError
        For files without a table, with what they are instead; for rows with a wrong number of
        cells; and where commas both separate cells and could be decimal signs.
        For a spreadsheet, if the extra `tables` is missing.
    OSError
        If the file cannot be read.
    """
    path = Path(path)
    if path.is_dir():
        raise IsADirectoryError(f"'{path}' is a folder; name a file in it")
    if not path.is_file():
        if path.exists():
            raise FileNotFoundError(f"'{path}' is a device, not a file")
        raise FileNotFoundError(f"there is no file '{path}'")
    with reading(path):
        if path.stat().st_size > LARGEST:
            raise broken("large_file", {"size": LARGEST // 1_000_000})
        return parse_source(path.read_bytes(), path.name, decimal=decimal)


def parse_source(raw: bytes, name: str = "", *, decimal: str | None = None) -> SourceTable:
    r"""The tables in the bytes of a file; see `read_source`.

    Examples
    --------
    >>> table = parse_source(b"t (s);theta (deg)\n0,00;12,5\n0,02;12,4\n")
    >>> [(column.name, column.unit) for column in table.sections[0].columns]
    [('t', 's'), ('theta', 'deg')]
    """
    if decimal is not None:
        checked_choice("decimal", decimal, DECIMALS)
    parts = read_parts(name, raw)
    tables: dict[str, _Found] = {}
    refusals: list[InputError] = []
    for part in parts:
        try:
            tables[part.name] = _sections_of(part, decimal)
        except InputError as error:
            if len(parts) > 1:
                error.where = error.where or part.name
            refusals.append(error)
    if not tables:
        raise refusals[0]
    notes: list[Sentence] = []
    main = [each for each in tables if Path(each).stem.lower() in _MAIN]
    if len(tables) > 1 and len(main) == 1:
        others = ", ".join(each for each in tables if each != main[0])
        notes.append(said("read_sheet", name=main[0], others=others))
        tables = {main[0]: tables[main[0]]}
    sections: list[Section] = []
    for name, found in tables.items():
        notes += [joined([name, note], ": ") if name else note for note in found.notes]
        for section in found.sections:
            title = ": ".join(filter(None, (name if len(tables) > 1 else "", section.name)))
            sections.append(replace(section, name=title))
    first = next(iter(tables.values()))
    return SourceTable(
        kind=first.kind if len(tables) == 1 else "tables",
        sections=tuple(sections),
        encoding=first.part.encoding,
        delimiter=delimiter_name(first.delimiter),
        notes=tuple(notes),
        comments=sections[0].comments,
    )


class _Found(NamedTuple):
    """What one text of a file holds."""

    part: Part
    sections: list[Section]
    kind: str
    delimiter: str
    notes: list[Sentence]


def _sections_of(part: Part, decimal: str | None) -> _Found:
    """Return the sections of a text."""
    layout = layout_of(part.text, delimiter=part.delimiter, decimal=part.decimal)
    lines = layout.lines
    header_lines = [
        [HeaderLine(lines.line(i), is_comment(lines.line(i))) for i in block.header]
        for block in layout.blocks
    ]
    width = max(_names_width(layout, each) for each in header_lines)
    unnamed = frozenset(
        place for place, column in enumerate(layout.columns) if column.counts.keys() <= {"empty"}
    )
    headers = [header_of(header_lines[0], width, layout.delimiter, unnamed)]
    headers += [
        later_header(each, width, layout.delimiter, unnamed, headers[0])
        for each in header_lines[1:]
    ]
    named = headers[0].named
    if decimal != "." and is_comma_both(layout, named):
        _refuse_comma(layout, named)
    if layout.delimiter == BLANKS and 0 < named < layout.width:
        raise broken("blanks_in_names", {"names": named, "columns": layout.width})
    other = other_delimiter(layout)
    if other is not None and not (headers[0].is_own and named == layout.width):
        first = int(layout.blocks[0].rows[0])
        signs = {"one": delimiter_name(layout.delimiter), "other": delimiter_name(other)}
        place = {"line": lines.numbers[first], "text": lines.line(first)[:40]}
        raise broken("two_delimiters", signs | place)
    kind, units = kind_of_file(
        [line.text for line in header_lines[0]], [each.name for each in headers[0].headings]
    )
    sections: list[Section] = []
    for number, (block, header) in enumerate(zip(layout.blocks, headers, strict=True), start=1):
        headings = header.headings if header.named else headers[0].headings
        columns = tuple(
            _column_of(layout, place, heading, units) for place, heading in enumerate(headings)
        )
        name = header.title
        if len(layout.blocks) > 1:
            taken = {section.name for section in sections}
            name = name if name and name not in taken else f"{number}"
        own = header_lines[number - 1]
        comments = tuple(without_mark(line.text).strip() for line in own if line.is_comment)
        numbers = lines.numbers[block.rows]
        sections.append(Section(name, columns, numbers, comments, layout, block))
    notes = list(layout.notes)
    if kind == "Kinovea export" and len(sections) > 1:
        objects = [Rows(each.name, each.lines.tolist(), each.cells()) for each in sections]
        if _meet(sections, objects):
            sections = [_joined(sections[0], objects, None)]
    elif len(sections) == 1:
        column = _column_of_objects(sections[0])
        objects = _objects_of(sections[0], column, notes) if column else []
        if len(objects) > 1:
            sections = [_joined(sections[0], objects, column)]
    return _Found(part, sections, kind, layout.delimiter, notes)


def _shared(section: Section) -> list[int]:
    """Return the places of the columns that are the same for all objects, the time first."""
    names = [column.name.lower() for column in section.columns]
    return [names.index(name) for name in _CLOCKS if name in names]


def _meet(sections: list[Section], objects: list[Rows]) -> bool:
    """Return whether sections are objects that were measured at the same times."""
    shared = _shared(sections[0])
    names = {tuple(column.name for column in section.columns) for section in sections}
    return len(names) == 1 and bool(shared) and meet(objects, shared[0])


def _column_of_objects(section: Section) -> SourceColumn | None:
    """Return the column that says to which object a row belongs."""
    by_name = {column.name.lower(): column for column in reversed(section.columns)}
    return next((by_name[name] for name in _OBJECTS if name in by_name), None)


def _objects_of(section: Section, column: SourceColumn, notes: list[Sentence]) -> list[Rows]:
    """Return the rows of each object; note those of none."""
    objects: dict[str, Rows] = {}
    left_out = 0
    for line, cells in zip(section.lines.tolist(), section.cells(), strict=True):
        name = cells[column.position - 1]
        if name.lower() in ("", *MISSING_WORDS):
            left_out += 1
            continue
        if name.lstrip("-").isdigit():
            name = f"{column.name.lower().removesuffix('_id')} {name}"
        rows = objects.setdefault(name, Rows(name, [], []))
        rows.lines.append(line)
        rows.cells.append(cells)
        if len(objects) > _MOST_OBJECTS:
            raise broken("many_objects", {"column": column.label, "count": _MOST_OBJECTS})
    if left_out:
        rule = "row_of_none" if left_out == 1 else "rows_of_none"
        notes.append(said(rule, count=left_out, column=column.label))
    return list(objects.values())


def _joined(first: Section, objects: list[Rows], column: SourceColumn | None) -> Section:
    """Return a section with the numbers of all objects, without the column that names them."""
    shared = _shared(first)
    if not shared:
        raise broken("no_common_time", {"count": len(objects)})
    own = [
        place
        for place, each in enumerate(first.columns)
        if place not in shared and each is not column and each.kind == "numbers"
    ]
    layout = side_by_side(objects, shared, own, first._layout.decimal)
    titles = [("", place) for place in shared]
    titles += [(each.name, place) for each in objects for place in own]
    columns = tuple(
        replace(first.columns[place], position=position, track=track)
        for position, (track, place) in enumerate(titles, start=1)
    )
    (block,) = layout.blocks
    return Section("", columns, layout.lines.numbers[block.rows], first.comments, layout, block)


def _names_width(layout: Layout, header: list[HeaderLine]) -> int:
    """Return the number of columns: those that hold something, and empty ones that have a name.

    Raises
    ------
    InputError
        If the line above the rows has more names than the rows have cells.
    """
    widths = [layout.width]
    for line in header:
        cells = [] if line.is_comment else split(line.text, layout.delimiter)
        while cells and not cells[-1]:
            cells.pop()
        if len(cells) <= len(layout.columns):
            widths.append(len(cells))
        elif line is header[-1] and layout.delimiter != BLANKS and all(cells):
            first = layout.lines.numbers[layout.blocks[0].rows[0]]
            counts = {"cells": len(layout.columns), "names": len(cells)}
            raise broken("fewer_cells", {"line": first} | counts)
    return max(widths)


def _refuse_comma(layout: Layout, named: int) -> None:
    """Raise the error for a comma that could be both delimiter and decimal sign."""
    first = int(layout.blocks[0].rows[0])
    names = said("names_above", count=named) if named else said("no_names")
    place = {"line": layout.lines.numbers[first], "text": layout.lines.line(first)[:40]}
    raise broken("comma_both", place | {"names": names}, parameter="decimal")


def _column_of(layout: Layout, place: int, heading: Heading, units: Units) -> SourceColumn:
    """Return a column with what header, cells and the kind of the export say about it."""
    cells = layout.columns[place]
    held = cells.counts.keys() - {"empty", "missing"}
    kind = "texts" if cells.is_text else "numbers" if held else "empty"
    unit, unit_from = heading.unit, heading.unit_from
    if not unit and heading.name in units:
        unit, unit_from = units[heading.name]
    return SourceColumn(
        position=place + 1,
        name=heading.name,
        unit=unit,
        track=heading.track,
        written=heading.written,
        aliases=heading.aliases,
        kind=kind,
        unit_from=unit_from,
    )


def _base_and_unit(text: str) -> tuple[str, str]:
    """The name that a caller gives a column, and the unit in brackets after it."""
    match = re.fullmatch(r"(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))", text.strip())
    if not match or not match[1]:
        return text.strip(), ""
    unit = match[2] if match[2] is not None else match[3]
    if match[2] is None and not is_known(unit):
        return text.strip(), ""
    return match[1].strip(), canonical(unit) or unit.strip()


def names_text(names: Sequence[str]) -> str:
    """Return names as a list for a sentence, of many the first ones.

    Examples
    --------
    >>> names_text(["t", "x"]), names_text([f"c{i}" for i in range(90)])[-20:]
    ('t, x', 'c18, c19 and 70 more')
    """
    more = len(names) - _MOST_LISTED
    shown = ", ".join(names[:_MOST_LISTED])
    return said("and_more", names=shown, count=more) if more > 0 else shown
