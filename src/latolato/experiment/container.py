"""What a container declares: the rate of filming, how it is shown, whether it is complete."""

from __future__ import annotations

import math
import struct
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

# Where Android keeps the rate of filming (MediaRecorder.setCaptureRate). Apple has no such key: the
# files of an iPhone have the times of filming until they are exported in slow motion.
_CAPTURE_RATE = "com.android.capture.fps"
# Rates of filming from which no camera falls to a half in the dark [1/s]: below, a file of fewer
# frames a second than were planned need not be slow motion.
_HIGH_SPEED = 90.0
# Factor from which a rate is another one, and how near a whole one counts as whole.
_OTHER, _WHOLE = 1.5, 0.03
# ISO/IEC 14496-12 and QuickTime: kinds of the outermost parts.
_BOXES = frozenset(
    (b"ftyp", b"moov", b"mdat", b"free", b"skip", b"wide", b"pnot", b"uuid", b"udta", b"meta",
     b"moof", b"mfra", b"sidx", b"styp")
)  # fmt: skip
# RFC 8794: an EBML header, and the segment of a Matroska file.
_ELEMENTS = (b"\x1a\x45\xdf\xa3", b"\x18\x53\x80\x67")


class Clock(NamedTuple):
    """Rates that a container declares [1/s], 0 if unknown, and what follows from them.

    `slow_motion` is how many times slower than life it plays according to them; `is_sure` tells
    whether they leave no doubt.
    """

    capture_rate: float
    shown_rate: float
    slow_motion: float
    is_sure: bool


def declared_clock(container: Any, stream: Any) -> Clock:
    """Return the rates of filming and of showing, and the slow motion that they declare."""
    try:
        filmed = float(container.metadata.get(_CAPTURE_RATE, 0.0))
    except ValueError:
        filmed = 0.0
    shown = _shown_rate(stream)
    if not (0.0 < filmed < math.inf and shown > 0.0):
        return Clock(0.0, shown, 1.0, True)
    factor = filmed / shown
    if max(factor, 1.0 / factor) < _OTHER:
        return Clock(filmed, shown, 1.0, True)
    whole = round(factor)
    if whole and abs(factor / whole - 1.0) < _WHOLE:
        factor = float(whole)
    return Clock(filmed, shown, factor, filmed >= _HIGH_SPEED and factor > 1.0)


def _shown_rate(stream: Any) -> float:
    """Return the usual rate of a stream's frames [1/s]: frames left out do not count."""
    stamps = np.array([entry.timestamp for entry in stream.index_entries])
    step = float(np.median(np.diff(stamps))) if len(stamps) > 1 else 0.0
    if step > 0.0:
        return 1.0 / (step * float(stream.time_base))
    return float(stream.average_rate or 0.0)


def displayed_turn(picture: Any) -> tuple[int, bool]:
    """Return by how much a picture is turned clockwise [degrees], and whether it is mirrored.

    A mirrored picture is flipped from left to right first.
    """
    matrix = picture.side_data.get("DISPLAYMATRIX")
    if matrix is None:
        return 0, False
    a, b, _, c, d = struct.unpack("=5i", bytes(matrix)[:20])
    is_mirrored = a * d - b * c < 0
    if is_mirrored:
        a, b = -a, -b
    return round(math.degrees(math.atan2(b, a)) / 90.0) % 4 * 90, is_mirrored


def square_size(width: int, height: int, aspect: Any) -> tuple[int, int]:
    """Return the size of a picture whose pixels become square, none fewer than it had."""
    ratio = float(aspect or 1.0)
    if not 0.0 < ratio < math.inf or abs(math.log(ratio)) < 0.005:
        return width, height
    return round(width * max(ratio, 1.0)), round(height / min(ratio, 1.0))


def missing_bytes(path: Path) -> int:
    """Return how many bytes are missing at the end of an MP4, QuickTime, AVI or Matroska file.

    The outermost parts of such a file tell their sizes. 0 for a whole file, and where the sizes
    are unknown.
    """
    end = path.stat().st_size
    at = size = 0
    with path.open("rb") as stream:
        while at < end:
            stream.seek(at)
            size = _part_size(stream.read(16))
            if not size:
                break
            at += size
    return max(at - end, 0)


def _part_size(head: bytes) -> int:
    """Return the size of the part of a file that begins so, 0 if it does not say."""
    if len(head) < 16:
        return 0
    if head[:4] == b"RIFF":
        size = 8 + int.from_bytes(head[4:8], "little")
        return size + size % 2
    if head[:4] in _ELEMENTS:
        width = 9 - head[4].bit_length()
        if width > 8:
            return 0
        size = int.from_bytes(head[4 : 4 + width], "big") & ((1 << 7 * width) - 1)
        return 0 if size == (1 << 7 * width) - 1 else 4 + width + size
    if head[4:8] not in _BOXES:
        return 0
    size = int.from_bytes(head[:4], "big")
    return int.from_bytes(head[8:16], "big") if size == 1 else size
