"""The few distinct shapes of a text's lines, so that all of a long file can be looked at.

In the shape of a line, every digit is a 0, longer runs of digits have four, and signs of numbers
are left out. A million lines of measured numbers have some dozens of shapes, each of which is then
studied once.
"""

from __future__ import annotations

import io
import re
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

# A lone zero in front of a point or comma, which no thousands have.
LEADING = "\x01"
_LEADING = re.compile(rb"(?<![0-9.,])0(?=[.,][0-9])")
# What makes no difference between shapes: the sign of a number, digits in front of a point.
_SIGN = re.compile(rb"(?<![\w.,+-])[+-](?=[\x010.])")
_WHOLE = re.compile(rb"(?<![0.,' \x80-\xff])0{2,3}(?=\.0)")
_LONG = re.compile(rb"0{5,}")
# So many lines are looked at together, which bounds the memory that this takes.
_CHUNK = 20_000
_DIGITS = bytes.maketrans(b"123456789", b"000000000")


@dataclass(frozen=True)
class Lines:
    r"""The lines of a text and their shapes.

    Attributes
    ----------
    text : bytes
        The text in UTF-8; each line ends in ``\n``.
    starts : array of int, shape (line + 1,)
        Where each line begins, and the end of the text.
    shape_of : array of int, shape (line,)
        Number of each line's shape.
    shapes : list of str
        The shapes.
    numbers : array of int, shape (line,)
        Number of each line in the file, from 1.
    """

    text: bytes
    starts: NDArray[np.int64]
    shape_of: NDArray[np.int32]
    shapes: list[str]
    numbers: NDArray[np.int32]

    def line(self, index: int) -> str:
        """Return a line without its end."""
        return self.text[self.starts[index] : self.starts[index + 1] - 1].decode()


def lines_of(text: bytes, numbers: NDArray[np.int32] | None = None) -> Lines:
    r"""Return the lines of a text with their shapes.

    Examples
    --------
    >>> lines_of(b"0.25;31,5\n0.50;32,5\n").shapes
    ['\x01.00;00,0']
    """
    ends = np.flatnonzero(np.frombuffer(text, dtype=np.uint8) == ord("\n"))
    starts = np.concatenate([[0], ends + 1])
    known: dict[bytes, int] = {}
    shape_of = np.empty(len(ends), dtype=np.int32)
    for first in range(0, len(ends), _CHUNK):
        last = min(first + _CHUNK, len(ends))
        part = _LEADING.sub(LEADING.encode(), text[starts[first] : starts[last]])
        flat = _SIGN.sub(b"", _LONG.sub(b"0000", part.translate(_DIGITS)))
        flat = _WHOLE.sub(b"0", flat)
        shape_of[first:last] = [known.setdefault(line, len(known)) for line in io.BytesIO(flat)]
    shapes = [shape.removesuffix(b"\n").decode() for shape in known]
    if numbers is None:
        numbers = np.arange(1, len(ends) + 1, dtype=np.int32)
    return Lines(text, starts, shape_of, shapes, numbers)
