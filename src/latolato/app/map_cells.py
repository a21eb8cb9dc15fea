"""Points of maps that have been computed: what goes on, moves or zooms out begins with these."""

from __future__ import annotations

import threading
from collections import OrderedDict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.sweeps.chunk import STATUS, Values
from latolato.sweeps.executors import ROUNDING
from latolato.sweeps.labels import Memory
from latolato.sweeps.plan import Plan

# Maps that were looked at last stay in memory up to so many bytes.
MOST_BYTES = 300_000_000
# Values of an axis this close, in spacings, are the same: those of a moved map are rounded.
_SAME = 1e-6


def known_of(memory: Memory) -> NDArray[np.bool_]:
    """Return which points of a map, numbered in C order, have been computed."""
    return np.asarray(memory.arrays[STATUS].ravel() >= 0)


def values_of(memory: Memory, points: NDArray[np.int64]) -> Values:
    """Return the values of some points of a map, numbered in C order."""
    size, inner = memory.plan.size, len(memory.plan.shape)
    return {
        name: array.reshape(size, *array.shape[inner:])[points]
        for name, array in memory.arrays.items()
    }


class Maps:
    """Maps that were computed last, whole or in part, by the plan of the sweep over all of them."""

    def __init__(self, most_bytes: int = MOST_BYTES) -> None:
        self._most = most_bytes
        self._found: OrderedDict[str, tuple[Memory, str]] = OrderedDict()
        self._lock = threading.Lock()

    def by_hash(self, plan_hash: Any) -> Memory | None:
        """Return what is known of the map whose plan has this hash, or None."""
        with self._lock:
            result = self._found.get(plan_hash) if isinstance(plan_hash, str) else None
            if result is None:
                return None
            self._found.move_to_end(plan_hash)
            return result[0]

    def begin(self, plan: Plan) -> Memory:
        """Return what is known of a map, with the points that it shares with other maps."""
        result = self.by_hash(plan.hash)
        if result is not None:
            return result
        memory, base = Memory(plan, ROUNDING["threads"]), _base(plan)
        with self._lock:
            others = [other for other, same in self._found.values() if same == base]
            # Kicks are those of a point's number, which another map counts otherwise.
            for other in [] if plan.own_streams else others:
                _take_over(memory, other)
            self._found[plan.hash] = memory, base
            while len(self._found) > 1 and self._bytes() > self._most:
                self._found.popitem(last=False)
        return memory

    def _bytes(self) -> int:
        return sum(a.nbytes for memory, _ in self._found.values() for a in memory.arrays.values())


def _base(plan: Plan) -> str:
    """Return what two maps share whose equal points have equal values."""
    described: dict[str, Any] = plan.describe()
    names = [axis.name for axis in plan.axes]
    return repr({**described, "axes": names, "chunk_size": 0})


def _take_over(memory: Memory, other: Memory) -> None:
    """Put the points of another map where the same ones of this map are not known yet."""
    places = []
    for axis, own in zip(other.plan.axes, memory.plan.axes, strict=True):
        there, here = np.array(axis.values[0]), np.array(own.values[0])
        at = np.clip(np.searchsorted(here, there), 1, len(here) - 1) if len(here) > 1 else 0
        at = at - (np.abs(here[at - 1] - there) < np.abs(here[at] - there))
        spacing = np.min(np.diff(here)) if len(here) > 1 else abs(here[0]) or 1.0
        same = np.abs(here[at] - there) <= _SAME * spacing
        target, first = np.unique(np.broadcast_to(at, there.shape)[same], return_index=True)
        places.append((np.flatnonzero(same)[first], target))
    (there_y, here_y), (there_x, here_x) = places
    if not len(there_y) or not len(there_x):
        return
    source = (there_y[:, None] * other.plan.shape[1] + there_x).ravel()
    target = (here_y[:, None] * memory.plan.shape[1] + here_x).ravel()
    new = known_of(other)[source] & ~known_of(memory)[target]
    source, target = source[new], target[new]
    if not len(source):
        return
    memory.put(target, values_of(other, source), "")
