"""Names, units and tracks of columns, from the lines above the rows."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace

from latolato.io.tables.cells import (
    BLANKS,
    DELIMITERS,
    NUMBERS,
    kind_of,
    split,
    without_mark,
    zeros,
)
from latolato.io.tables.rules import said
from latolato.io.tables.units import APPENDED, canonical, is_known, is_unit

_BRACKETS = re.compile(r"(?P<name>.*?)\s*(?:\[(?P<square>[^\[\]]*)\]|\((?P<round>[^()]*)\))\s*")
_RUN = re.compile(
    r"(?P<name>.+?)\s+(?P<track>(?:Run|Trial|Set|Lauf|Messung|Essai) #?\d+)", re.IGNORECASE
)
_OF_OBJECT = re.compile(r"(?P<track>.+)/(?P<name>x|y)", re.IGNORECASE)
_PREFIX = re.compile(r"(?P<track>[^:()\[\]]*[^:()\[\]\s]):\s*(?P<name>[^\s:].*)")
# A word with the brackets behind it, as blanks separate them.
_WORD = re.compile(r"[^\s\[(]+(?:\s*(?:\([^)]*\)|\[[^\]]*\]))*|\([^)]*\)|\[[^\]]*\]")
# What Tracker calls its point masses.
_OBJECT = re.compile(r"\w+[ _][A-Z]\d*")
# A comment about the file, such as "type: matrix", above which comments hold no names.
_PAIR = re.compile(r"\s*\w+:\s[^:\t;,|]*")
# Columns that all objects of a table share.
_SHARED = ("t", "time", "frame", "step")


@dataclass(frozen=True)
class Heading:
    """What the header says about a column.

    Attributes
    ----------
    name : str
        Without unit and track; "" if there is none.
    unit : str
        As the package spells it, or as written if it is another; "" if there is none.
    track : str
        The object or run to which the column belongs, "" for a column of all of them.
    written : str
        The whole cell of the header.
    aliases : tuple of str
        Other names in the header: the short ones of Vernier, those of TrackMate's pages.
    unit_from : str
        Where the unit was found, if it is not stated as a unit: "its name"; else "".
    """

    name: str = ""
    unit: str = ""
    track: str = ""
    written: str = ""
    aliases: tuple[str, ...] = ()
    unit_from: str = ""


@dataclass(frozen=True)
class HeaderLine:
    """A line above the rows."""

    text: str
    is_comment: bool


@dataclass(frozen=True)
class Header:
    """What the lines above the rows say.

    Attributes
    ----------
    headings : list of Heading
        One for each column, with empty names if the file has none.
    title : str
        The line above the names, or above the rows of a later section.
    named : int
        How many names there are.
    is_own : bool
        Whether the names are separated by the delimiter of the rows.
    """

    headings: list[Heading]
    title: str
    named: int
    is_own: bool = False


def heading_of(cell: str) -> Heading:
    """Return name, unit and track of a column from its cell in the header.

    Examples
    --------
    >>> heading = heading_of("Latest: Angle (Deg)")
    >>> heading.name, heading.unit, heading.track
    ('Angle', 'deg', 'Latest')
    >>> heading_of("theta (x axis) (rad)").name, heading_of("t/s").unit, heading_of("x_mm").unit
    ('theta (x axis)', 's', 'mm')
    """
    written = " ".join(cell.split()).strip('"').strip()
    text, track = written, ""
    run = _RUN.fullmatch(text)
    prefix = _PREFIX.fullmatch(text)
    if run:
        text, track = run["name"].strip(), run["track"]
    elif prefix:
        text, track = prefix["name"].strip(), prefix["track"].strip()
    name, unit, unit_from = _name_and_unit(text)
    if not track:  # the run may stand between name and unit, the object in front of x and y
        run = (_RUN.fullmatch(name) if unit else None) or _OF_OBJECT.fullmatch(name)
        if run:
            name, track = run["name"].strip(), run["track"].strip()
    return Heading(name, unit, track, written, (), unit_from)


def _name_and_unit(text: str) -> tuple[str, str, str]:
    """Return name and unit, and where the unit comes from if it does not stand in brackets."""
    match = _BRACKETS.fullmatch(text)
    if match:
        unit = match["square"] if match["square"] is not None else match["round"]
        if match["name"] and is_known(unit):
            return match["name"].strip(), canonical(unit) or unit.strip(), ""
        return text, "", ""
    name, slash, unit = text.rpartition("/")
    if slash and name.strip() and canonical(unit) is not None:
        return name.strip(), str(canonical(unit)), ""
    for divider in (" in ", ", "):
        name, found, unit = text.rpartition(divider)
        if found and name.strip() and canonical(unit) is not None:
            return name.strip(), str(canonical(unit)), said("unit_of_name")
    name, found, unit = text.rpartition("_")
    if found and name and unit.lower() in APPENDED:
        return name, unit.lower(), said("unit_of_name")
    return text, "", ""


def header_of(
    lines: list[HeaderLine], width: int, delimiter: str, unnamed: frozenset[int] = frozenset()
) -> Header:
    """Names, units and tracks of the columns by the lines above the rows.

    Parameters
    ----------
    lines : list of HeaderLine
        Without empty ones.
    width : int
        Number of columns.
    delimiter : str
        That of the rows; the header may have another.
    unnamed : frozenset of int
        Columns that hold nothing, from 0: they need no name.
    """
    key_lines = _key_lines(lines)
    if key_lines:
        return _of_keys(key_lines, width)
    parted = [_fitting(line, width, delimiter) for line in lines]
    title_at = len(lines) - 1
    place, units = _names_at(lines, parted, width, unnamed | {0})
    if place is None:
        title = without_mark(lines[-1].text).strip() if lines else ""
        return Header([Heading()] * width, _title(title, delimiter), 0)
    names = parted[place] or []
    rows = [names]
    title_at = place - 1
    if units is not None:
        # Above names and units there may be longer names.
        while title_at >= 0 and len(parted[title_at] or []) == width and all(parted[title_at]):  # type: ignore[arg-type]
            rows.insert(0, parted[title_at] or [])
            title_at -= 1
    headings = [heading_of(cell) for cell in rows[0]]
    headings += [Heading()] * (width - len(headings))
    headings = [
        replace(each, aliases=tuple(row[i] for row in rows[1:] if i < len(row) and row[i]))
        for i, each in enumerate(headings)
    ]
    if units is not None:
        headings = [_with_unit(each, cell) for each, cell in zip(headings, units, strict=False)]
    title = without_mark(lines[title_at].text) if title_at >= 0 else ""
    if title_at >= 0 and not lines[title_at].is_comment and not any(h.track for h in headings):
        tracks = _tracks(lines[title_at].text, delimiter, width)
        if tracks:
            title = ""
            headings = [
                each
                if not tracks[0] and each.name.lower() in _SHARED
                else replace(each, track=track)
                for each, track in zip(headings, tracks, strict=True)
            ]
    below = [without_mark(line.text) for line in lines[place + 1 :] if line.is_comment]
    if below and units is None:  # the title of a section
        title = below[-1]
    line = without_mark(lines[place].text) if lines[place].is_comment else lines[place].text
    own = _WORD.findall(line) if delimiter == BLANKS else split(line, delimiter)
    return Header(
        headings=headings,
        title=_title(title, delimiter),
        named=sum(bool(cell) for cell in names),
        is_own=len(own) >= len(names),
    )


def later_header(
    lines: list[HeaderLine], width: int, delimiter: str, unnamed: frozenset[int], first: Header
) -> Header:
    """The heading of a later section; a comment may be its title only."""
    header = header_of(lines, width, delimiter, unnamed)
    known = {each.name for each in first.headings if each.name}
    if all(line.is_comment for line in lines) and not known & {h.name for h in header.headings}:
        title = without_mark(lines[-1].text) if lines else ""
        return Header([], _title(title, delimiter), 0)
    return header


def _names_at(
    lines: list[HeaderLine], parted: list[list[str] | None], width: int, unnamed: frozenset[int]
) -> tuple[int | None, list[str] | None]:
    """Return the line that holds the names, and the units in a line below it."""
    is_kinovea = any("kinovea" in line.text.lower() for line in lines)
    pairs = [
        i
        for i, line in enumerate(lines)
        if line.is_comment and _PAIR.fullmatch(without_mark(line.text))
    ]
    candidates = [
        i
        for i, cells in enumerate(parted)
        if cells
        and not (is_kinovea and lines[i].text.startswith("# "))
        and not (pairs and i <= pairs[-1] and lines[i].is_comment)
    ]
    plain = [i for i in candidates if not lines[i].is_comment]
    for group in (plain, candidates):
        # A column that numbers the rows may have no name.
        whole = [
            i
            for i in group
            if len(parted[i] or []) == width
            and all(cell or k in unnamed for k, cell in enumerate(parted[i] or []))
        ]
        if not whole:
            continue
        below = [i for i in group if i >= whole[-1]]
        units = next((i for i in below if all(map(is_unit, filter(None, parted[i] or [])))), None)
        if units is None:
            return whole[-1], None
        above = [i for i in whole if i < units]
        if above:
            cells = parted[units] or []
            return above[-1], cells + [""] * (width - len(cells))
        return whole[-1], None
    # Names for some columns only, better the first of them than others with gaps.
    for is_enough in (all, lambda cells: sum(map(bool, cells)) > 1):
        for group in (plain, candidates):
            some = [i for i in group if len(parted[i] or []) > 1 and is_enough(parted[i] or [])]
            if some:
                return some[-1], None
    alone = [i for i in plain if width == 1 and len(parted[i] or []) == 1]
    return (alone[-1] if alone else None), None


def _fitting(line: HeaderLine, width: int, delimiter: str) -> list[str] | None:
    """Return the cells of a header line, empty ones at its end left out; None for other lines."""
    text = without_mark(line.text) if line.is_comment else line.text
    best: list[str] | None = None
    # Between words that blanks separate there may be other delimiters too.
    order: tuple[str, ...] = DELIMITERS if delimiter == BLANKS else (delimiter, *DELIMITERS)
    if delimiter != BLANKS and delimiter in text:
        order = (delimiter,)
    for each in dict.fromkeys(order):
        cells = _WORD.findall(text) if each == BLANKS else split(text, each)
        for candidate in (cells, re.split(r"\s{2,}", text.strip())) if each == BLANKS else (cells,):
            candidate = [cell.strip().strip('"').strip() for cell in candidate]
            while candidate and not candidate[-1]:
                candidate.pop()
            if not candidate or len(candidate) > width:
                continue
            if any(kind_of(zeros(cell)) in NUMBERS for cell in candidate):
                continue
            if len(candidate) == width and all(candidate):
                return candidate
            if best is None and each == delimiter:
                best = candidate
    return best


def _with_unit(heading: Heading, cell: str) -> Heading:
    """Return a heading with the unit in a cell of the line of units."""
    text = cell.strip().strip("()[]").strip()
    if not text or heading.unit:
        return heading
    return replace(heading, unit=canonical(text) or text, unit_from="")


def _tracks(line: str, delimiter: str, width: int) -> list[str]:
    """Return for each column the object named above it, none for those that all share.

    A name stands above the first column of its object; one alone at the beginning of its line
    belongs to all columns but the first.
    """
    cells = split(line, delimiter) if delimiter in line else [line.strip()]
    if delimiter == BLANKS or not any(cells) or any(kind_of(zeros(c)) in NUMBERS for c in cells):
        return []
    if len(cells) == 1:
        return ["", *cells * (width - 1)] if _OBJECT.fullmatch(cells[0]) else []
    if cells[0] and all(cells):
        return []
    tracks, current = [], ""
    for cell in [*cells, *[""] * width][:width]:
        current = cell or current
        tracks.append(current)
    return tracks


def _title(text: str, delimiter: str) -> str:
    """Return a line as a title."""
    return " ".join(cell for cell in split(text, delimiter) if cell) if text.strip() else ""


def _key_lines(lines: list[HeaderLine]) -> dict[str, list[str]]:
    """Return LabChart's header: lines that begin with a key such as ``ChannelTitle=``."""
    found = {}
    for line in lines:
        key, *cells = (cell.strip() for cell in line.text.split("\t"))
        if re.fullmatch(r"[A-Za-z]+=", key):
            found[key.removesuffix("=")] = cells
    return found if "ChannelTitle" in found else {}


def _of_keys(lines: dict[str, list[str]], width: int) -> Header:
    """Return the header of a LabChart export, whose first column is the time in seconds."""
    names, units = lines["ChannelTitle"], lines.get("UnitName", [])
    time = Heading("Time", "s", "", "Time", (), "LabChart")
    headings = [time, *(heading_of(cell) for cell in names if cell)]
    headings = (headings + [Heading()] * width)[:width]
    for i, cell in enumerate(units[: width - 1], start=1):
        headings[i] = _with_unit(headings[i], cell)
    return Header(headings, "", sum(bool(each.name) for each in headings))
