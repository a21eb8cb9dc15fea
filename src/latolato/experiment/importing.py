"""Import tables of other programs: exports of Tracker, phone sensors, spreadsheets."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import InputError, name_gap, reading
from latolato.core.quantities import NON_NEGATIVE, POSITIVE, QUANTITIES, Quantity
from latolato.core.registry import checked_choice, checked_number, suggest
from latolato.experiment.rules import broken, said
from latolato.experiment.track_table import column_names, read_table, track_table
from latolato.io.tables.clocks import seconds_of
from latolato.io.tables.rules import broken as broken_table
from latolato.io.tables.source import (
    Section,
    SourceColumn,
    SourceTable,
    names_text,
    read_source,
)
from latolato.io.tables.units import IN_OTHERS, canonical, units_like
from latolato.scenario.units import to_si

if TYPE_CHECKING:
    import xarray as xr

Floats = NDArray[np.float64]

# What people call the columns, in small letters and without units; used where none is named.
_TIMES = (
    "t", "time", "zeit", "temps", "tiempo", "tempo", "waktu", "seconds_elapsed",
    "time since start", "position_t",
)  # fmt: skip
_ANGLES = (
    "theta", "angle", "angular", "θ", "θr", "phi", "φ", "winkel", "ángulo", "angolo", "sudut",
)  # fmt: skip
# A clock that starts with the record is better than another one.
_OWN_CLOCKS = ("seconds_elapsed", "time since start")
_FRAMES = ("frame", "frames", "frame number", "frame no", "image", "slice", "bild")
# Tracks that are the pivot and not a ball, and words for a ball: "y pivot", "ball 2 x".
_PIVOTS = ("pivot", "suspension", "hand", "support", "aufhängung", "drehpunkt", "poros")
_BALLS = (
    "ball", "bob", "mass", "pendulum", "kugel", "pendel", "bola", "péndulo", "pendolo", "bandul",
)  # fmt: skip
# What tells one ball from another beside a number, and what says nothing in the name of a column.
_SIDES, _EMPTY_WORDS = ("left", "right"), ("position", "of", "the")
_WORD = re.compile(r"[^\W\d_]+|\d+")
# What may be imported: the table's numbers.
TARGETS = tuple(n for n in column_names(2) if n != "frame" and not n.startswith("flag"))
_PLACES = tuple(name for name in TARGETS if name.endswith(("_x", "_y")))
# What a gyroscope measures; it becomes the angle.
_RATE = "angular_velocity_1"
# Stated angles that lie within so much may have been wrapped into a turn, whose ends noise blurs
# [rad]; and how often a swing changes sides before it is one.
_WRAPPED, _TO_AND_FRO = 2.1 * np.pi, 3
# The line of a CSV that says it is a track table, and how far down it may stand.
_MARK, _HEADER_LINES = ["#", "table:", "track"], 200


@dataclass
class _Import:
    """What is asked of a file, what was read from it, and what had to be assumed.

    `series` holds the columns of the track table and `lines` the line of the file of each row, both
    of shape (row,).
    """

    section: Section
    columns: dict[str, tuple[SourceColumn, str]]
    lines: NDArray[np.int32]
    series: dict[str, Floats] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    questions: list[str] = field(default_factory=list)


def import_table(
    path: str | Path,
    columns: Mapping[str, str] | None = None,
    *,
    section: str | None = None,
    decimal: str | None = None,
    frame_rate: float | None = None,
    length: float | None = None,
    radius: float | None = None,
    pivot: Sequence[float] | None = None,
    angle_from: Literal["down", "right"] = "down",
    y_axis: Literal["up", "down"] = "up",
    angle_sigma: Annotated[float | None, "rad"] = None,
    notes: list[str] | None = None,
    questions: list[str] | None = None,
) -> xr.Dataset:
    """Return a track table from a file of another program.

    Parameters
    ----------
    path : str or Path
        A table as text, as a spreadsheet or in an archive. Delimiter, decimal sign, encoding,
        header and units are found from the whole file; see
        `latolato.io.tables.source.read_source`.
    columns : mapping of str to str, optional
        For each column of the track table, the column of the file:
        ``{"time": "t [s]", "angle_1": "theta [deg]"}``. A column is named as in the file, with its
        track if several have the name (``"right ball/x"``), or by its position (``"1 [s]"``). The
        unit is given in brackets, here or in the file. By default columns called t, theta, x and y
        are used. Instead of an angle you may give ``angular_velocity_1``, a gyroscope's rate about
        the axis of the swing.
    section : str, optional
        Which table of the file, if it holds several: the title of the section, the sheet, the
        member of the archive, or a run beside others.
    decimal : {".", ","}, optional
        The decimal sign, "." or ",", needed only where the file leaves it open.
    frame_rate : float, optional
        Frames per second [1/s], if the column for the time holds frame numbers, or times such as
        ``0:00:03:12``. Missing numbers stay gaps. A table without frame numbers and without times
        has one row for each frame.
    length : float, optional
        Pivot to ball centre [m], kept with the table.
    radius : float, optional
        Radius of the ball [m], kept with the table.
    pivot : pair of float, optional
        Position of the pivot in the file's coordinates, if angles come from positions and the
        file has no pivot: in m, or in pixels (px) if the positions are in pixels.
    angle_from : {"down", "right"}
        Direction from which the file counts angles, counter-clockwise: "right" is the x axis.
    y_axis : {"up", "down"}
        Direction in which the file's y increases.
    angle_sigma : float, optional
        Standard deviation of the angles [rad], if the file has none.
    notes : list of str, optional
        Is extended by the sentences on what had to be assumed, as pages translate them.
    questions : list of str, optional
        Is extended by questions about angles that no swing has: their unit or direction seems to be
        another one.

    Returns
    -------
    xarray.Dataset
        A track table, see `latolato.experiment.track_table`. Angles are computed from positions
        where the file has none; cells without a number are NaN and flagged lost. Angles are
        unwrapped, and whole turns are taken off. Its attribute ``recognised`` says what the file
        is, ``imported`` which columns were read, and ``assumed`` what the file does not state, with
        the questions.

    Raises
    ------
    InputError
        For files without a table, numbers that could be read in two ways, missing or duplicate
        columns, missing or unsuitable units, cells that are not numbers, times that do not
        increase, and positions without a pivot; with the line of the file where there is one.
    OSError
        If the file cannot be read.

    Notes
    -----
    Positions in pixels give angles only, since nothing says how long a pixel is.
    """
    path = Path(path)
    checked_choice("angle_from", angle_from, ("down", "right"))
    checked_choice("y_axis", y_axis, ("up", "down"))
    if frame_rate is not None:
        frame_rate = checked_number("frame_rate", frame_rate, POSITIVE, "1/s")
    source = read_source(path, decimal=decimal)
    with reading(path):
        if columns is None and is_track_file(path):
            raise broken("own_table")
        part = _chosen(source, section)
        if columns is None:
            columns = usual_columns(part, has_rate=frame_rate is not None)
        asked = _asked(part, columns, has_rate=frame_rate is not None)
        asked.notes += source.notes
        _read_series(asked, frame_rate, decimal)
        _convert(asked, frame_rate)
        if not asked.columns.keys() - {"time"}:
            raise _unclear(part, columns, has_time=True)
        series = asked.series
        if y_axis == "down":
            series |= {axis: -series[axis] for axis in series if axis.endswith("_y")}
        if pivot is not None:
            pivot = _checked_pivot(series, pivot, y_axis)
        if _RATE in series:
            series["angle_1"] = _integrated(series["time"], series.pop(_RATE))
        stated = [name for name in ("angle_1", "angle_2") if name in series]
        _place_angles(series, pivot, angle_from)
        asked.questions += unit_questions({name: series[name] for name in stated})
        for name in stated:
            series[name] = _near_zero(name, series[name], asked.notes)
        if any(unit == "px" for _, unit in asked.columns.values()):
            for place in _PLACES:  # which have served for angles
                series.pop(place, None)
            asked.notes.append(said("only_angles"))
        if not asked.questions:
            _ask_about_directions(series, stated, asked.questions)
        for ball in (1, 2):
            if angle_sigma is not None and f"angle_{ball}" in series:
                sigma = checked_number("angle_sigma", angle_sigma, POSITIVE, "rad")
                series.setdefault(f"angle_sigma_{ball}", np.full(len(series["time"]), sigma))
        attributes: dict[str, Any] = {
            "source": path.name,
            "source_sha256": hashlib.sha256(path.read_bytes()).hexdigest(),
            "recognised": source.about,
            "imported": "; ".join(
                f"{name} = {column.path}" + (f" [{unit}]" if unit else "")
                for name, (column, unit) in asked.columns.items()
            ),
            "assumed": "; ".join([*asked.notes, *asked.questions]) or None,
            "section": section,
        }
        if length is not None:
            attributes["length"] = checked_number("length", length, POSITIVE, "m")
        if radius is not None:
            attributes["radius"] = checked_number("radius", radius, NON_NEGATIVE, "m")
        if notes is not None:
            notes += asked.notes
        if questions is not None:
            questions += asked.questions
        return track_table(series, attributes)


def read_measured(path: str | Path, columns: Mapping[str, str] | None = None) -> xr.Dataset:
    """Return the track table in a file, or the one that another program's table gives.

    Parameters
    ----------
    path : str or Path
        A track table (``.csv``, ``.parquet``, ``.nc``) or anything that `import_table` reads.
    columns : mapping of str to str, optional
        As for `import_table`.

    Raises
    ------
    InputError, OSError
        As `read_table` and `import_table`.
    """
    path = Path(path)
    is_own = columns is None and (
        path.suffix.lower() in (".nc", ".parquet") or is_track_file(path) or not path.is_file()
    )
    return read_table(path) if is_own else import_table(path, columns)


def is_track_file(path: Path) -> bool:
    """Return whether the header of a text file says that it is a track table."""
    try:
        with path.open(encoding="utf-8-sig", errors="replace") as file:
            head = [line for line, _ in zip(file, range(_HEADER_LINES), strict=False)]
    except OSError:
        return False
    return any(line.startswith("#") and line.split() == _MARK for line in head)


def parts_of(source: SourceTable) -> dict[str, Section]:
    r"""Return the tables that can be imported from a file, by the names that `section` takes.

    They are its sections or, if its only section holds several runs beside each other, the runs.

    Examples
    --------
    >>> from latolato.io.tables.source import parse_source
    >>> list(parts_of(parse_source(b"t,theta\n0,1\n1,2\n")))
    ['']
    """
    first = source.sections[0]
    runs = _runs(first)
    if len(source.sections) == 1 and len(runs) > 1:
        return {run: _of_run(first, run) for run in runs}
    return {section.name: section for section in source.sections}


def _chosen(source: SourceTable, name: str | None) -> Section:
    """Return the section that is asked for, or the columns of one run beside others."""
    first = source.sections[0]
    if len(source.sections) > 1 or name in (None, first.name):
        return source.section(name)
    runs = first.tracks
    if name not in runs:
        way_out = suggest(str(name), runs) if runs else said("one_table")
        raise broken_table("no_section", {"name": name}, way_out=way_out)
    return _of_run(first, name)


def _of_run(section: Section, run: str) -> Section:
    """Return the columns of one run and those that belong to all runs."""
    return replace(section, columns=tuple(c for c in section.columns if c.track in ("", run)))


def _runs(section: Section) -> list[str]:
    """Return the tracks that have a time of their own."""
    return [c.track for c in section.columns if c.track and _is_called(c, _TIMES)]


def _is_called(column: SourceColumn, names: Sequence[str]) -> bool:
    """Return whether a column has one of some names, perhaps with a sensor behind a comma."""
    return any(
        each.lower() in names or each.lower().split(",")[0] in names
        for each in (column.name, *column.aliases)
    )


def _times(section: Section, *, has_rate: bool = False) -> list[SourceColumn]:
    """Return the columns that may be the time: numbers rather than texts, their own clock first."""
    usual = _FRAMES if has_rate else _TIMES
    found = [c for c in section.columns if c.kind != "empty" and _is_called(c, usual)]
    own = [c for c in found if _is_called(c, _OWN_CLOCKS)]
    return own or [c for c in found if c.kind == "numbers"] or found


def _may_be(column: SourceColumn, unit: str) -> bool:
    """Return whether a column's unit, if it has one, converts to another unit."""
    return column.kind == "numbers" and column.unit in ("", *units_like(unit))


def proposed_columns(section: Section, *, has_rate: bool = False) -> dict[str, str]:
    r"""Return the columns that are called as usual, by position, as `import_table` takes them.

    Parameters
    ----------
    section : Section
    has_rate : bool
        Whether the time is looked for among frame numbers.

    Returns
    -------
    dict of str to str
        Incomplete where the names leave something open: no time, two columns for the same, or more
        than two balls. What is open is the error of `usual_columns`.

    Examples
    --------
    >>> from latolato.io.tables.source import parse_source
    >>> proposed_columns(parse_source(b"Zeit;Masse;Winkel\n0;1;2\n1;1;3\n").section())
    {'time': '1', 'angle_1': '3'}
    """
    times = _times(section, has_rate=has_rate)
    mapping = {"time": str(times[0].position)} if len(times) == 1 else {}
    tracks = _usual_tracks(section)
    balls = _balls_among(tracks)
    for ball, track in enumerate(balls if len(balls) <= 2 else [], start=1):
        found = tracks[track]
        names = {"angle": f"angle_{ball}"} if "angle" in found else {
            "x": f"ball_{ball}_x", "y": f"ball_{ball}_y"
        }  # fmt: skip
        mapping |= {name: found[what] for what, name in names.items()}
    for track in tracks.keys() - set(balls):
        if "x" in tracks[track]:
            mapping |= {"pivot_x": tracks[track]["x"], "pivot_y": tracks[track]["y"]}
    return mapping


def _usual_tracks(section: Section) -> dict[str, dict[str, str]]:
    """Return the positions of angle, x and y of each track that has an angle or both places."""
    tracks: dict[str, dict[str, str]] = {}
    for (what, track), columns in _candidates(section).items():
        if len(columns) == 1:
            tracks.setdefault(track, {})[what] = str(columns[0].position)
    return {track: found for track, found in tracks.items() if "angle" in found or len(found) == 2}


def _candidates(section: Section) -> dict[tuple[str, str], list[SourceColumn]]:
    """Return the columns that may be the angle, x or y of each track.

    Where none is called as usual, one alone whose name and unit are those of an angle is that.
    """
    found: dict[tuple[str, str], list[SourceColumn]] = {}
    for column in section.columns:
        meant = _meant(column) if column.kind == "numbers" else None
        if meant is not None:
            found.setdefault(meant, []).append(column)
    angles = [c for c in section.columns if c.unit and _may_be(c, "rad") and _has_angle(c)]
    if not found and len(angles) == 1:
        found["angle", angles[0].track] = angles
    return found


def _has_angle(column: SourceColumn) -> bool:
    """Return whether the name of a column speaks of an angle, of whatever."""
    return any(word in _ANGLES for word in _WORD.findall(column.name.lower()))


def _meant(column: SourceColumn) -> tuple[str, str] | None:
    """Return which of angle, x and y a column is called, and of which track; None for others.

    An object in the name is a track, as in ``x pivot`` and ``left ball y``; a ball that is called
    nothing else has the track of the column.
    """
    for name in (column.name, *column.aliases):
        words = _WORD.findall(name.lower().split(",")[0])
        found = [word for word in words if word in ("x", "y", *_ANGLES)]
        others = [word for word in words if word not in (*found, *_BALLS, *_EMPTY_WORDS)]
        is_object = all(w in (*_PIVOTS, *_SIDES) or w.isdecimal() for w in others)
        if len(found) == 1 and is_object:
            what = found[0] if found[0] in "xy" else "angle"
            return what, " ".join(filter(None, (column.track, *others)))
    return None


def _balls_among(tracks: Mapping[str, Any]) -> list[str]:
    """Return the tracks that are no pivot, a right ball before a left one, and 1 before 2."""

    def place(name: str) -> tuple[int, str]:
        side = ("left" in name.lower()) - ("right" in name.lower())
        return side, name if name.isdecimal() else ""

    return sorted((track for track in tracks if track.lower() not in _PIVOTS), key=place)


def usual_columns(section: Section, *, has_rate: bool = False) -> dict[str, str]:
    r"""Return the columns of `proposed_columns` if they are all that an import needs.

    Raises
    ------
    InputError
        If the time or everything else is missing, or there are several runs or too many tracks.

    Examples
    --------
    >>> from latolato.io.tables.source import parse_source
    >>> usual_columns(parse_source(b"frame,theta\n0,2\n1,3\n").section())
    Traceback (most recent call last):
    latolato.core.errors.InputError: it has frame numbers and no time; give frame_rate in 1/s
    """
    runs = _runs(section)
    if len(runs) > 1:
        values = {"count": len(runs), "names": names_text(runs), "first": runs[0]}
        raise broken("several_runs", values)
    _refuse_rivals(section, has_rate=has_rate)
    mapping = proposed_columns(section, has_rate=has_rate)
    has_time = "time" in mapping
    if not has_time and not has_rate and _times(section, has_rate=True):
        raise broken("frames_only")
    clocks = [] if has_time else _times(section)
    if has_rate and clocks:
        # Times such as 0:00:03:12 need a frame rate too.
        if clocks[0].kind != "texts":
            raise _needless_rate(clocks[0])
        mapping["time"] = str(clocks[0].position)
    has_time = has_rate or has_time
    balls = _balls_among(_usual_tracks(section))
    if len(balls) > 2:
        own = {what: found for (what, ball), found in _candidates(section).items()
               if ball == balls[0]}  # fmt: skip
        what = "angle" if "angle" in own else "x"
        values = {
            "count": len(balls), "names": names_text([ball or own[what][0].path for ball in balls]),
            "target": name_gap("angle_1" if what == "angle" else "ball_1_x"),
            "first": own[what][0].path,
        }  # fmt: skip
        raise broken("several_tracks", values)
    if not has_time or not balls:
        raise _unclear(section, mapping, has_time=has_time)
    return mapping


def _unclear(section: Section, mapping: Mapping[str, str], *, has_time: bool) -> InputError:
    """Return the error for a table of which nobody knows the time, or what was measured."""
    names = names_text([column.path for column in section.columns])
    if not any(column.name for column in section.columns):
        return broken("no_headings", {"count": len(section.columns)})
    wanted = {"angle_1": "rad", _RATE: "rad/s"} if has_time else {"time": "s"}
    what = next(iter(wanted))
    named = {"target": name_gap(what), "path": "NAME", "unit": wanted[what]}
    for column in section.columns:
        is_angle = (_meant(column) or ("", ""))[0] == "angle"
        if is_angle if has_time else _is_called(column, _TIMES):
            _refuse_without_numbers(section, column)
    for target, unit in wanted.items():
        others = [c for c in section.columns if str(c.position) != mapping.get("time")]
        fitting = [c for c in others if _may_be(c, unit) and (c.unit or target == "time")]
        if fitting:
            stated = fitting[0].unit or unit
            named = {"target": name_gap(target), "path": fitting[0].path, "unit": stated}
            break
    rule = "unclear_angle" if has_time else "unclear_time"
    return broken(rule, {"names": names, **named})


def _needless_rate(column: SourceColumn) -> InputError:
    """Return the error for a frame rate beside times."""
    return broken("needless_rate", {"column": column.label})


def _refuse_without_numbers(section: Section, column: SourceColumn) -> None:
    """Raise for a column that holds no numbers."""
    if column.kind == "empty":
        raise broken("column_without_numbers", {"column": column.label})
    section.numbers([column])  # says which text it holds


def _refuse_rivals(section: Section, *, has_rate: bool) -> None:
    """Raise if several columns may be the time, the angle, x or y of the same object."""
    rivals = {("time", ""): _times(section, has_rate=has_rate), **_candidates(section)}
    for (what, _), found in rivals.items():
        if len(found) > 1:
            target = {"time": "time", "angle": "angle_1"}.get(what, f"ball_1_{what}")
            places = ", ".join(f"{c.position} ({c.written})" for c in found)
            values = {"count": len(found), "target": name_gap(target), "places": places}
            raise broken("rival_columns", {**values, "position": found[0].position})


def _asked(section: Section, mapping: Mapping[str, str], *, has_rate: bool) -> _Import:
    """Return the columns that a mapping names, with their units; with a frame rate, of frames too.

    Raises
    ------
    InputError
        For a missing time, unknown names, and columns that are not in the file.
    """
    if has_rate and "time" not in mapping:
        frames = _times(section, has_rate=True)
        mapping = {**mapping, "time": str(frames[0].position)} if frames else mapping
    elif "time" not in mapping:
        raise broken("which_time")
    known = [*TARGETS, _RATE]
    for target in mapping:
        if target not in known:
            raise broken("no_target", {"name": target}, way_out=suggest(target, known))
    if _RATE in mapping and "angle_1" in mapping:
        raise broken("angle_or_rate", {"rate": name_gap(_RATE)})
    columns = {name: section.column(text) for name, text in mapping.items()}
    asked = _Import(section, columns, section.lines)
    for column, unit in asked.columns.values():
        if column.unit_from and unit == column.unit:
            told = {"column": column.label, "unit": unit, "source": column.unit_from}
            asked.notes.append(said("unit_from", **told))
    return asked


def _read_series(asked: _Import, frame_rate: float | None, decimal: str | None) -> None:
    """Read the columns, in the units of the file, in the rows that have a time."""
    series, lines = asked.series, asked.lines
    if "time" not in asked.columns:
        others = np.flatnonzero(np.diff(lines) != 1)
        if others.size:
            raise broken("split_frames", {"line": lines[others[0]] + 1})
        series["time"] = np.arange(len(lines), dtype=np.float64)
        asked.notes.append(said("rows_are_frames"))
    elif asked.columns["time"][0].kind == "texts":
        series["time"] = _clock_times(asked, frame_rate)
    names = [name for name in asked.columns if name not in series]
    values, notes = asked.section.numbers(
        [asked.columns[name][0] for name in names], decimal=decimal
    )
    asked.notes += notes
    series |= dict(zip(names, values, strict=True))
    has_time = np.isfinite(series["time"])
    if not has_time.any():
        column, _ = asked.columns["time"]
        _refuse_without_numbers(asked.section, replace(column, kind="empty"))
    measured = [name for name in names if name != "time"]
    has_more = np.any([np.isfinite(series[name]) for name in measured], axis=0)
    if measured and not has_more.any():
        _refuse_without_numbers(asked.section, replace(asked.columns[measured[0]][0], kind="empty"))
    lost = np.flatnonzero(has_more & ~has_time)
    if lost.size:
        raise broken("missing_time", {"line": lines[lost[0]]})
    if not has_time.all():
        count = int((~has_time).sum())
        rule = "empty_row" if count == 1 else "empty_rows"
        asked.notes.append(said(rule, count=count))
        series |= {name: each[has_time] for name, each in series.items()}
        asked.lines = lines[has_time]
    falls = np.flatnonzero(np.diff(series["time"]) <= 0.0)
    if falls.size:
        at = int(falls[0])
        time, following = map(float, series["time"][at : at + 2])
        place = {"time": time, "line": asked.lines[at + 1]}
        raise broken("falling_time", place, parameter="time", value=following)
    _refuse_marks(asked)
    _refuse_lost_places(asked)


def _clock_times(asked: _Import, frame_rate: float | None) -> Floats:
    """Return times such as ``0:00:03:12`` in seconds; a time of day begins at 0."""
    column, _ = asked.columns["time"]
    cells = asked.section.texts(column)
    times = seconds_of(cells, asked.lines.tolist(), frame_rate)
    if frame_rate is not None and not any(cell.count(":") == 3 for cell in cells):
        raise _needless_rate(column)
    known = np.flatnonzero(np.isfinite(times))
    if known.size and times[known[0]] >= 3600.0:
        times = times - times[known[0]]
        asked.notes.append(said("times_from", time=cells[known[0]]))
    return times


def _refuse_marks(asked: _Import) -> None:
    """Raise for numbers like -999 that stand for missing ones: nines, far from all others."""
    for name in asked.columns.keys() - {"time"}:
        values = asked.series[name]
        known = values[np.isfinite(values)]
        if known.size < 3:
            continue
        for mark in (known.min(), known.max()):
            rest = known[known != mark]
            digits = f"{abs(mark):.15g}".replace(".", "").strip("0")
            is_mark = abs(mark) >= 1e10 or re.fullmatch("9{2,}", digits)
            if is_mark and rest.size and np.abs(rest - mark).min() > max(np.ptp(rest), 10.0):
                raise _no_measurement(asked, name, mark, int(np.flatnonzero(values == mark)[0]))


def _refuse_lost_places(asked: _Import) -> None:
    """Raise for places (0, 0) and (-1, -1), far from all others, which stand for lost balls."""
    for ball in (1, 2):
        x, y = (asked.series.get(f"ball_{ball}_{axis}") for axis in "xy")
        if x is None or y is None:
            continue
        is_mark = (x == y) & np.isin(x, (0.0, -1.0))
        rest = np.isfinite(x + y) & ~is_mark
        if is_mark.any() and rest.any():
            at = int(np.argmax(is_mark))
            nearest = np.hypot(x[rest] - x[at], y[rest] - y[at]).min()
            if nearest > 0.5 * np.hypot(np.ptp(x[rest]), np.ptp(y[rest])):
                raise _no_measurement(asked, f"ball_{ball}_x", x[at], at)


def _refuse_leaps(asked: _Import, written: Mapping[str, Floats]) -> None:
    """Raise for an angle that changes by more than one and a half turns from row to row."""
    steps = np.diff(asked.series["time"])
    is_next = steps < 3.0 * np.median(steps) if steps.size else np.zeros(0, dtype=bool)
    for name in ("angle_1", "angle_2"):
        if name in asked.columns:
            leaps = is_next & (np.abs(np.diff(asked.series[name])) > 3.0 * np.pi)
            if leaps.any():
                at = int(np.argmax(leaps)) + 1
                raise _no_measurement(asked, name, written[name][at], at)


def _no_measurement(asked: _Import, name: str, value: float, row: int) -> InputError:
    """Return the error for a number that cannot have been measured."""
    column = asked.columns[name][0].label
    return broken("far_number", {"line": asked.lines[row], "column": column, "number": value})


def _convert(asked: _Import, frame_rate: float | None) -> None:
    """Convert columns to SI units; positions may stay in pixels."""
    series, written = asked.series, dict(asked.series)
    column, unit = asked.columns.get("time", (None, ""))
    is_clock = column is not None and column.kind == "texts"
    is_whole = bool(np.all(series["time"] == np.floor(series["time"])))
    if is_clock:
        if frame_rate is not None:
            asked.notes.append(said("times_of_frames", rate=frame_rate))
    elif frame_rate is not None:
        if column is not None:
            if unit not in ("", "1") or not is_whole:
                raise broken("rate_needs_frames", {"column": column.label})
            asked.notes.append(said("divided_frames", rate=frame_rate))
        series["frame"] = series["time"]
        series["time"] = series["time"] / frame_rate
    elif column is not None and (unit == "1" or (is_whole and _is_called(column, _FRAMES))):
        raise broken("frames_need_rate", {"column": column.label})
    places = {name: unit == "px" for name, (_, unit) in asked.columns.items() if name in _PLACES}
    pixels = [name for name, is_pixels in places.items() if is_pixels]
    if pixels and len(pixels) < len(places):
        other = next(name for name in places if name not in pixels)
        raise broken("mixed_positions", {"name": name_gap(pixels[0]), "other": name_gap(other)})
    for name, (column, unit) in asked.columns.items():
        if name in pixels or (name == "time" and (is_clock or frame_rate is not None)):
            continue
        series[name] = _factor(name, column, unit) * series[name]
    _refuse_leaps(asked, written)


def units_of(target: str) -> list[str]:
    """Return the units that a column of the track table may have in a file.

    Examples
    --------
    >>> units_of("angle_1")
    ['rad', 'mrad', 'deg', 'arcmin', 'gon', 'rev']
    """
    units = [u for u in units_like(canonical(_quantity(target).unit) or "") if u != "1"]
    return [*units, "px"] if target in _PLACES else units


def _quantity(target: str) -> Quantity:
    return QUANTITIES["angular_velocity" if target == _RATE else target]


def _factor(target: str, column: SourceColumn, unit: str) -> float:
    """Return the SI value of a column's unit."""
    quantity = _quantity(target)
    units = ", ".join(units_of(target))
    told = {"column": column.label, "target": name_gap(target), "units": units}
    if not unit:
        raise broken("no_unit", {**told, "path": column.path, "unit": quantity.unit})
    if canonical(unit) is None and canonical(unit.swapcase()) is not None:
        raise broken("misspelt_unit", {**told, "unit": unit, "meant": unit.lower()})
    try:
        return float(to_si(target, IN_OTHERS.get(unit, f"1 {unit}"), quantity.unit))
    except InputError:
        raise broken("foreign_unit", {**told, "unit": unit}) from None


def _checked_pivot(
    series: Mapping[str, Floats], pivot: Sequence[float], y_axis: str
) -> tuple[float, float]:
    """Return a pivot given as numbers, with y upwards."""
    if len(pivot) != 2:
        raise broken("two_coordinates", parameter="pivot", value=pivot)
    if "pivot_x" in series or "pivot_y" in series:
        raise broken("pivot_twice")
    return float(pivot[0]), float(pivot[1]) * (-1.0 if y_axis == "down" else 1.0)


def unit_questions(angles: Mapping[str, Floats]) -> list[str]:
    """Return questions about angles [rad] that swing to and fro by more than whole turns.

    A pendulum that passes the top goes on in the same direction.

    Examples
    --------
    >>> swing = np.sin(np.arange(0.0, 20.0, 0.1))
    >>> unit_questions({"angle_1": swing}), len(unit_questions({"angle_1": 30.0 * swing}))
    ([], 1)
    """
    questions: list[str] = []
    for name, angle in angles.items():
        known = angle[np.isfinite(angle)]
        about = known - np.median(known) if known.size else known
        sides = np.sign(about[np.abs(about) > np.pi])
        if np.count_nonzero(np.diff(sides)) >= _TO_AND_FRO:
            size = 0.5 * float(np.ptp(about))
            questions.append(said("seems_degrees", column=name_gap(name), size=size))
    return questions


def _near_zero(name: str, angle: Floats, notes: list[str]) -> Floats:
    """Return an angle that the file states without jumps of a turn and without whole turns."""
    finite = angle[np.isfinite(angle)]
    # Angles that lie within a turn may have been wrapped into it, others were not.
    unwrapped = _unwrapped(angle) if finite.size and np.ptp(finite) <= _WRAPPED else angle
    known = unwrapped[np.isfinite(unwrapped)]
    if not known.size:
        return angle
    changed = np.abs(unwrapped - angle)
    if np.nanmax(changed) > np.pi:
        notes.append(said("removed_jumps", column=name_gap(name)))
    # A swing lies about its median; a ball that goes round is counted from where it begins.
    is_swing = np.ptp(known) < 2.0 * np.pi or unit_questions({name: unwrapped})
    middle = np.median(known) if is_swing else known[0]
    turns = round(float(middle) / (2.0 * np.pi))
    if turns == 0:
        return unwrapped
    rule = "shifted_turn" if abs(turns) == 1 else "shifted_turns"
    notes.append(said(rule, count=abs(turns), column=name_gap(name)))
    result: Floats = unwrapped - 2.0 * np.pi * turns
    return result


def _ask_about_directions(
    series: Mapping[str, Floats], stated: Sequence[str], questions: list[str]
) -> None:
    """Ask about balls that are above their pivot most of the time."""
    for name in ("angle_1", "angle_2"):
        angle = series.get(name)
        if angle is None or not np.isfinite(angle).any():
            continue
        if abs(float(np.nanmedian(angle))) > 0.5 * np.pi:
            rule = "stated_above" if name in stated else "placed_above"
            questions.append(said(rule, column=name_gap(name)))


def _place_angles(
    columns: dict[str, Floats], pivot: tuple[float, float] | None, angle_from: str
) -> None:
    """Put the origin at the mean pivot and add the angles that follow from positions."""
    for ball in (1, 2):
        if f"angle_{ball}" in columns and angle_from == "right":
            columns[f"angle_{ball}"] = columns[f"angle_{ball}"] + 0.5 * np.pi
    placed = [b for b in (1, 2) if f"ball_{b}_x" in columns and f"ball_{b}_y" in columns]
    for ball in (1, 2):
        half = {f"ball_{ball}_x", f"ball_{ball}_y"} & columns.keys()
        if len(half) == 1:
            raise broken("half_place", {"name": name_gap(half.pop())})
    if pivot is not None:
        for axis, value in zip("xy", pivot, strict=True):
            columns[f"pivot_{axis}"] = np.full(len(columns["time"]), value)
    if placed and not {"pivot_x", "pivot_y"} <= columns.keys():
        if any(f"angle_{b}" not in columns for b in placed):
            raise broken("pivot_needed")
        return
    for axis in ("x", "y"):
        if f"pivot_{axis}" in columns:
            origin = float(np.nanmean(columns[f"pivot_{axis}"]))
            for name in (f"pivot_{axis}", *(f"ball_{b}_{axis}" for b in placed)):
                columns[name] = columns[name] - origin
    for ball in placed:
        if f"angle_{ball}" not in columns:
            x = columns[f"ball_{ball}_x"] - columns["pivot_x"]
            y = columns[f"ball_{ball}_y"] - columns["pivot_y"]
            columns[f"angle_{ball}"] = _unwrapped(np.arctan2(x, -y))


def _integrated(time: Floats, rate: Floats) -> Floats:
    """Return the angle whose rate a gyroscope measured, swinging about zero.

    The gyroscope's bias and the unknown first angle are a straight line under the swing: that
    through the middles of its turning points is taken off.
    """
    from scipy.interpolate import CubicSpline

    from latolato.experiment.fits.swings import crossings

    known = np.isfinite(rate) & np.isfinite(time)
    if known.sum() < 8 or np.any(np.diff(time[known]) <= 0.0):
        raise broken("few_rates", {"rate": name_gap(_RATE)})
    spline = CubicSpline(time[known], rate[known]).antiderivative()
    turns = crossings(time[known], rate[known] - np.median(rate[known]))
    if len(turns) < 6:
        raise broken("few_turns_of_rate", {"rate": name_gap(_RATE)}, value=len(turns))
    tops = spline(turns)
    middles = 0.25 * (tops[:-2] + 2.0 * tops[1:-1] + tops[2:])
    line = np.polyfit(turns[1:-1], middles, 1)
    angle: Floats = np.where(known, spline(time) - np.polyval(line, time), np.nan)
    return angle


def _unwrapped(angle: Floats) -> Floats:
    """Return an angle without jumps of a turn, also across samples without a number."""
    out = angle.copy()
    known = np.isfinite(angle)
    out[known] = np.unwrap(angle[known])
    return out
