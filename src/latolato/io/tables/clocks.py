"""Times written as on a clock: ``0:03.25``, ``00:00:03.250``, ``2026-10-05T09:13:00Z``."""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import date
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from latolato.io.tables.cells import MISSING_WORDS
from latolato.io.tables.rules import broken, said

_CLOCK = re.compile(
    r"(?:(?P<year>\d{4})-(?P<month>\d\d)-(?P<day>\d\d)[T ])?"
    r"(?:(?P<hours>\d{1,3}):)?(?P<minutes>\d{1,2}):(?P<seconds>\d\d)"
    r"(?:[.,](?P<decimals>\d+)|:(?P<parts>\d{2,3}))?(?:Z|[+-]\d\d:?\d\d)?"
)


def is_clock(cell: str) -> bool:
    """Return whether a cell is a time with seconds as on a clock."""
    match = _CLOCK.fullmatch(cell.strip())
    # 12:30 may be hours and minutes.
    return match is not None and (match["hours"] or match["decimals"]) is not None


def seconds_of(
    cells: Sequence[str], lines: Sequence[int], frame_rate: float | None = None
) -> NDArray[np.float64]:
    """Return times on a clock in seconds since midnight of the first day, NaN where one is missing.

    Parameters
    ----------
    cells : sequence of str
    lines : sequence of int
        The line of the file in which each cell stands.
    frame_rate : float, optional
        Frames per second, for times such as ``0:00:03:12`` whose last part counts frames or, in
        Kinovea, hundredths of a second. The times are then those of the frames.

    Raises
    ------
    InputError
        For cells that are no such times, and where nothing says what their last part counts.

    Examples
    --------
    >>> seconds_of(["00:00:03.250", "0:01:00"], [2, 3]).tolist()
    [3.25, 60.0]
    >>> seconds_of(["0:00:00:24", "0:00:01:00", "0:00:01:01"], [2, 3, 4], 25.0).tolist()
    [0.96, 1.0, 1.04]
    """
    seconds = np.full(len(cells), np.nan)
    parts = np.full(len(cells), np.nan)
    digits = set()
    first_day = None
    for i, cell in enumerate(cells):
        cell = cell.strip()
        if not cell or cell.lower() in MISSING_WORDS:
            continue
        match = _CLOCK.fullmatch(cell) if is_clock(cell) else None
        is_time = match is not None and int(match["seconds"]) < 60
        if match is None or not is_time or (match["hours"] and int(match["minutes"]) > 59):
            raise broken("no_clock", {"line": lines[i], "cell": cell[:40]})
        day = (
            date(*map(int, match.group("year", "month", "day"))).toordinal() if match["year"] else 0
        )
        first_day = day if first_day is None else first_day
        minutes = 60 * int(match["hours"] or 0) + int(match["minutes"]) + 1440 * (day - first_day)
        seconds[i] = 60 * minutes + float(f"{match['seconds']}.{match['decimals'] or 0}")
        if match["parts"]:
            parts[i] = int(match["parts"])
            digits.add(len(match["parts"]))
    if not digits:
        return seconds
    if digits == {3}:
        return seconds + parts / 1000.0
    return _of_frames(seconds, parts, frame_rate, cells)


def _of_frames(
    seconds: NDArray[np.float64],
    parts: NDArray[np.float64],
    frame_rate: float | None,
    cells: Sequence[str],
) -> NDArray[np.float64]:
    """Return times of frames whose last part is a frame or the hundredths that were begun."""
    if frame_rate is None:
        _refuse(cells, said("rate_of_clock"))
    known = np.isfinite(parts)
    written = (seconds + parts / 100.0) * frame_rate
    # The first frame whose time is rounded or cut to the hundredths that are written.
    of_hundredths = np.ceil(np.round(written - 0.005 * frame_rate, 6))
    of_parts = seconds * frame_rate + parts
    readings = []
    if np.all(of_hundredths[known] < written[known] + 0.01 * frame_rate):
        readings.append(of_hundredths / frame_rate)
    if np.all(parts[known] < frame_rate) and float(frame_rate).is_integer():
        readings.append(of_parts / frame_rate)
    if len(readings) != 1 and not (
        readings and np.array_equal(readings[0], readings[1], equal_nan=True)
    ):
        _refuse(cells)
    return readings[0]


def _refuse(cells: Sequence[str], way_out: str | None = None) -> NoReturn:
    """Raise the error for a last part that could be two things."""
    example = next(cell for cell in cells if cell.strip())
    raise broken("frames_or_hundredths", {"cell": example.strip()}, way_out=way_out)
