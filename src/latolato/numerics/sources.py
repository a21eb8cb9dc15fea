"""A digest of the sources that compiled code is made of."""

from __future__ import annotations

import functools
import hashlib
from pathlib import Path

_LAYERS = ("scalar.py", "physics", "observables", "numerics")


@functools.cache
def digest_of_sources() -> str:
    """Return a digest of the sources of the kernel layers."""
    digest = hashlib.sha256()
    root = Path(__file__).resolve().parents[1]
    for layer in _LAYERS:
        path = root / layer
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            digest.update(file.read_bytes())
    return digest.hexdigest()[:24]
