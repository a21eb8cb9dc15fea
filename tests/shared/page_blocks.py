"""What a page finds in a block of arrays, as `js/page/block.js` reads it."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray


def unpack(block: bytes) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return the header and the arrays of a block."""
    begin = 4 + int.from_bytes(block[:4], "little")
    about = json.loads(block[4:begin])
    arrays = {}
    for entry in about.pop("arrays"):
        count, kind = math.prod(entry["shape"]), entry["type"]
        if kind == "even":
            arrays[entry["name"]] = np.linspace(entry["first"], entry["last"], count)
        else:
            values = np.frombuffer(block, f"<{kind}", count, begin + entry["offset"])
            arrays[entry["name"]] = values.reshape(entry["shape"])
    return about, arrays
