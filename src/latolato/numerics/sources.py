"""Digests of the sources that compiled code is made of."""

from __future__ import annotations

import functools
import hashlib
import sys
from pathlib import Path

from latolato.core.versions import version_of

_LAYERS = ("core/scalar.py", "physics", "observables", "numerics")


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


@functools.cache
def sources_hash() -> str:
    """Return a digest of the kernel layers' sources and of the versions of the compilers here."""
    text = f"{digest_of_sources()} {version_of('numba')} {version_of('llvmlite')} {sys.version}"
    return hashlib.sha256(text.encode()).hexdigest()[:24]
