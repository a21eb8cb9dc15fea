"""Arrays as one binary block: what the pages receive instead of JSON numbers.

A block is the length of its header as four bytes (little-endian), the header as JSON in UTF-8,
then the arrays one after the other. Header and arrays are padded to multiples of eight bytes, so
that a page looks at them in place. The header's entry ``arrays`` says for each array its name, its
type (``f4``, ``f8``, ``i4`` or ``u1``), its shape and where it begins after the header. Evenly
spaced numbers of ``f8`` are of the type ``even``: their first and last one are in the entry.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.core.errors import in_parts
from latolato.simulation.summary import plain

TYPES = ("f4", "f8", "i4", "u1")
EVEN = "even"
_ALIGNMENT = 8
_LENGTH = 4


def pack(about: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Return a header and arrays as one block.

    NaN in the header becomes null, and sentences are as `latolato.core.errors.in_parts` has them.

    Raises
    ------
    ValueError
        If an array is of a type that pages do not read.
    """
    entries: list[dict[str, Any]] = []
    parts: list[Any] = []
    offset = 0
    for name, values in arrays.items():
        data = np.ascontiguousarray(values)
        kind = data.dtype.str[1:]
        if kind not in TYPES:
            raise ValueError(f"{name} is of type {data.dtype}, pages read {', '.join(TYPES)}")
        entry = {"name": name, "type": kind, "shape": list(data.shape)}
        if kind == "f8" and _is_even(data):
            ends = {"first": float(data[0]), "last": float(data[-1])}
            entries.append({**entry, "type": EVEN, **ends})
            continue
        entries.append({**entry, "offset": offset})
        little = data.astype(data.dtype.newbyteorder("<"), copy=False)
        parts += [little.data, bytes(-little.nbytes % _ALIGNMENT)]
        offset += little.nbytes + len(parts[-1])
    header = json.dumps(plain(in_parts({**about, "arrays": entries})), allow_nan=False).encode()
    header += b" " * (-(len(header) + _LENGTH) % _ALIGNMENT)
    return b"".join([len(header).to_bytes(_LENGTH, "little"), header, *parts])


def content_of(path: Path) -> NDArray[np.uint8]:
    """Return the bytes of a file as an array of a block."""
    return np.fromfile(path, np.uint8)


def _is_even(values: NDArray[np.float64]) -> bool:
    """Return whether an array is what `numpy.linspace` makes from its ends, to the last bit."""
    if values.ndim != 1 or len(values) < 3:
        return False
    if not (np.isfinite(values[[0, -1]]).all() and values[0] < values[-1]):
        return False
    with np.errstate(over="ignore", invalid="ignore"):
        return np.array_equal(values, np.linspace(values[0], values[-1], len(values)))
