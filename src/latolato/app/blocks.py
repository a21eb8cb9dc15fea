"""Arrays as one binary block: what the pages receive instead of JSON numbers.

A block is the length of its header as four bytes (little-endian), the header as JSON in UTF-8,
then the arrays one after the other. Header and arrays are padded to multiples of eight bytes, so
that a page looks at them in place. The header's entry ``arrays`` says for each array its name, its
type (``f4``, ``f8``, ``i4`` or ``u1``), its shape and where it begins after the header.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.summary import plain

TYPES = ("f4", "f8", "i4", "u1")
_ALIGNMENT = 8
_LENGTH = 4


def pack(about: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Return a header and arrays as one block; NaN in the header becomes null.

    Raises
    ------
    ValueError
        If an array is of a type that pages do not read.
    """
    entries, parts, offset = [], [], 0
    for name, values in arrays.items():
        data = np.ascontiguousarray(values)
        kind = data.dtype.str[1:]
        if kind not in TYPES:
            raise ValueError(f"{name} is of type {data.dtype}, pages read {', '.join(TYPES)}")
        raw = data.astype(data.dtype.newbyteorder("<"), copy=False).tobytes()
        entries.append({"name": name, "type": kind, "shape": list(data.shape), "offset": offset})
        raw += bytes(-len(raw) % _ALIGNMENT)
        parts.append(raw)
        offset += len(raw)
    header = json.dumps(plain({**about, "arrays": entries}), allow_nan=False).encode()
    header += b" " * (-(len(header) + _LENGTH) % _ALIGNMENT)
    return b"".join([len(header).to_bytes(_LENGTH, "little"), header, *parts])


def unpack(block: bytes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return the header and the arrays of a block.

    Raises
    ------
    ValueError
        If the bytes are no such block.

    Examples
    --------
    >>> about, arrays = unpack(pack({"unit": "rad"}, {"angle": np.array([0.5], np.float32)}))
    >>> about["unit"], arrays["angle"].tolist()
    ('rad', [0.5])
    """
    try:
        begin = _LENGTH + int.from_bytes(block[:_LENGTH], "little")
        about = json.loads(block[_LENGTH:begin])
        arrays = {}
        for entry in about.pop("arrays"):
            if entry["type"] not in TYPES:
                raise ValueError(entry["type"])
            count = math.prod(entry["shape"])
            found = np.frombuffer(block, f"<{entry['type']}", count, begin + entry["offset"])
            arrays[entry["name"]] = found.reshape(entry["shape"])
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise ValueError(f"these {len(block)} bytes are no block of arrays: {error}") from None
    return about, arrays
