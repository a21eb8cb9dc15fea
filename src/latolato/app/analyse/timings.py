"""How long answers took on this machine with this version, kept in the cache folder."""

from __future__ import annotations

import hashlib
import json
import os
import platform
from contextlib import suppress
from dataclasses import astuple, dataclass
from pathlib import Path

from latolato.core import cache
from latolato.core.versions import version_of

# So many of the latest answers of a kind are kept, and so many kinds.
_KEPT, _KINDS = 8, 300


@dataclass(frozen=True)
class Timing:
    """How long one answer took.

    Attributes
    ----------
    steps : float
        Steps of motion, as `cost.steps_of` counts them before.
    seconds : float
        Time of the analysis [s].
    rest : float
        Time of its picture and files [s].
    """

    steps: float
    seconds: float
    rest: float


def timings_of(kind: str) -> list[Timing]:
    """Return the latest answers of a kind that were timed here, none if nothing is known."""
    return [Timing(*row) for row in _read().get(kind, ())]


def keep_timing(kind: str, timing: Timing) -> None:
    """Keep how long an answer took; a folder that cannot be written keeps nothing."""
    known = _read()
    latest = [*known.pop(kind, []), list(astuple(timing))][-_KEPT:]
    kept = [*known.items(), (kind, latest)][-_KINDS:]
    with suppress(OSError):
        cache.write(_path(), json.dumps(dict(kept)).encode())


def _read() -> dict[str, list[list[float]]]:
    """Return the rows of all kinds; a file that is missing or damaged has none."""
    try:
        known: dict[str, list[list[float]]] = json.loads(cache.read(_path()))
    except (OSError, ValueError):
        return {}
    return known


def _path() -> Path:
    """Return the file of this machine and this version."""
    machine = (platform.node(), platform.machine(), platform.processor(), os.cpu_count())
    digest = hashlib.sha256(repr((version_of(), machine)).encode()).hexdigest()[:16]
    return cache.cache_directory() / "timings" / f"{digest}.json"
