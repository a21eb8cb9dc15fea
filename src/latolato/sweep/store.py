"""A sweep's results in a Zarr store: written chunk by chunk, resumed to the same bytes.

A store is a Zarr group of format 3 that plain `xarray.open_zarr` opens. Below its folder
``.latolato`` stands a note for every finished chunk with the digests of its files, written after
them: a chunk without a note, or whose files differ from it, is computed again. Files are put in
place whole, the group's own ``zarr.json`` last of those that a new store begins with.
"""

from __future__ import annotations

import json
import math
import os
import re
import warnings
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.errors import InputError
from latolato.files import atomic_path, checked_path
from latolato.numerics.compiled import sources_hash
from latolato.sweep import lock
from latolato.sweep.chunk import STATUS, Values, status_counts
from latolato.sweep.differences import differences
from latolato.sweep.layout import (
    GROUP,
    NOTES,
    OWN,
    ROOT,
    as_text,
    digest_of,
    documents,
    encoders,
    existing_root,
    first_files,
    is_damaged,
    read_note,
    root_of,
    signed,
)
from latolato.sweep.plan import Plan
from latolato.sweep.results import in_order

if TYPE_CHECKING:
    import xarray as xr

_LOCK = f"{OWN}/lock"
# A file that `atomic_path` has not put in place because its process was killed.
_UNFINISHED = re.compile(r"\..+\.\d+\.[0-9a-f]{6}(\.\w+)?")
# What a store begins with, the root apart.
_FIRST = re.compile(r"[^/]+/(zarr\.json|c/0)")
_MOST_TOLD = 4


class Store:
    """A sweep's results in a folder, for one writer at a time.

    Parameters
    ----------
    plan : Plan
        The sweep.
    path : str or Path
        The store: a new or empty folder, or one that holds a part or all of this sweep.

    Attributes
    ----------
    missing : list of int
        Chunks that have to be computed, known once the store is entered.
    points_done : int
        Points of the other chunks.

    Raises
    ------
    FileExistsError
        On entering, if `path` is something else; nothing is touched then.
    BlockingIOError
        If another process writes the store.
    InputError
        If the store holds another sweep, or a part of this one by other kernels.
    OSError
        If the disk is full, while writing too; finished chunks are kept.
    """

    def __init__(self, plan: Plan, path: str | Path) -> None:
        self.plan = plan
        self.path = checked_path("store", path)
        self.missing: list[int] = []
        self.points_done = 0
        self._counts: Counter[str] = Counter()
        self._reasons: dict[int, str] = {}
        self._root: dict[str, Any] = {}
        self._encoded: dict[str, Any] = {}
        self._arrays: dict[str, Any] = {}
        self._descriptor = -1

    def __enter__(self) -> Store:
        self._check_place()
        lock_path = self.path / _LOCK
        try:
            self.path.mkdir(exist_ok=True)
            (self.path / OWN).mkdir(exist_ok=True)
            descriptor = lock.acquire(lock_path)
        except OSError as error:
            raise self._told(error) from None
        if descriptor is None:
            raise BlockingIOError(
                f"{lock.holder(lock_path)} is writing the store '{self.path}': wait for it, stop "
                "it, or name another path"
            )
        self._descriptor = descriptor
        try:
            self._open()
        except BaseException as error:
            self.__exit__()
            if isinstance(error, OSError) and error.errno is not None:
                raise self._told(error) from None
            raise
        return self

    def __exit__(self, *_: object) -> None:
        """Let others write."""
        lock.release(self._descriptor, self.path / _LOCK)

    def write(self, number: int, values: Values, reason: str) -> None:
        """Put the values of a chunk in their place, then note that it is done."""
        digests = {}
        try:
            for name, array in self._arrays.items():
                array[self.plan.block(number)] = values[name]
                for key in [k for k in self._encoded if not k.endswith(ROOT)]:
                    content = self._encoded.pop(key).to_bytes()
                    self._put(key, content)
                    digests[key] = digest_of(content)
            counts = status_counts(values[STATUS])
            note = {
                "plan": self.plan.hash,
                "files": digests,
                "first_invalid": reason,
                "status": counts,
            }
            self._put(f"{NOTES}/{number}.json", signed(note))
            self._add(number, counts, reason)
            if len(self._reasons) == self.plan.chunks:
                self._finish()
        except OSError as error:
            raise self._told(error) from None

    def status_counts(self) -> dict[str, int]:
        """Return how many points of the finished chunks have each status that occurs."""
        return in_order(self._counts)

    def dataset(self) -> xr.Dataset:
        """Return the labelled dataset, whose values are read on use."""
        return _opened(self.path)

    def _check_place(self) -> None:
        """Raise unless the path can become, or is, a store of this plan."""
        root = root_of(self.path)
        if root is None:
            return
        attributes = root["attributes"]
        if attributes["plan_hash"] != self.plan.hash:
            asked = json.loads(json.dumps(self.plan.describe()))
            found = differences(json.loads(attributes["plan"]), asked)
            more = f" and {len(found) - _MOST_TOLD} more" if len(found) > _MOST_TOLD else ""
            raise InputError(
                f"the store '{self.path}' holds another sweep: {', '.join(found[:_MOST_TOLD])}"
                f"{more}; name another path, or delete the store to begin anew"
            )

    def _open(self) -> None:
        """Create the store or find out what is missing, with the lock held."""
        self._check_place()  # again: somebody may have written it before we had the lock
        root = root_of(self.path)
        new, labels = first_files(self.plan)
        self._root = root or new
        files = labels | documents(self._root) | {f"{OWN}/{ROOT}": GROUP}
        if root is None:
            self._remove(lambda name, key: _FIRST.fullmatch(key) or _UNFINISHED.fullmatch(name))
            self.missing = list(range(self.plan.chunks))
            for key, content in files.items():
                self._put(key, content)
            self._put(ROOT, as_text(self._root))
        else:
            damaged = self._survey()
            self._check_kernels()
            self._remove(lambda name, _: _UNFINISHED.fullmatch(name))
            self._repair(damaged, files)
        self._arrays, self._encoded = encoders(self.plan, self._root)
        if not self.missing:
            self._finish()

    def _survey(self) -> dict[int, str]:
        """Find the chunks that are missing; return what is wrong with those noted as done."""
        damaged: dict[int, str] = {}
        for number in range(self.plan.chunks):
            path = self.path / NOTES / f"{number}.json"
            note = read_note(path, self.plan.hash)
            if note is None:
                self.missing.append(number)
                if path.exists():
                    damaged[number] = f"{NOTES}/{number}.json is damaged"
                continue
            wrong = [k for k, d in note["files"].items() if is_damaged(self.path / k, d)]
            if wrong:
                self.missing.append(number)
                damaged[number] = f"{wrong[0]} is damaged or missing"
            else:
                self._add(number, note["status"], note["first_invalid"])
        self.points_done = self._counts.total()
        return damaged

    def _check_kernels(self) -> None:
        """Raise unless what is missing would be computed like the rest."""
        attributes = self._root["attributes"]
        if self.missing and attributes["kernel_sources"] != sources_hash():
            raise InputError(
                f"{len(self.missing)} of {self.plan.chunks} chunks of '{self.path}' are missing, "
                f"and latolato {attributes['latolato_version']} wrote the others with other "
                f"kernels ({attributes['kernel_sources'][:8]}, here {sources_hash()[:8]}): finish "
                "it with that version, name another path, or delete the store to begin anew"
            )

    def _repair(self, damaged: Mapping[int, str], files: Mapping[str, bytes]) -> None:
        """Forget damaged chunks and write other damaged files again, and say so."""
        told = list(damaged.values())
        for number in damaged:
            (self.path / NOTES / f"{number}.json").unlink()
        for key, content in files.items():
            if is_damaged(self.path / key, digest_of(content)):
                told.append(f"{key} is damaged or missing")
                self._put(key, content)
        if told:
            more = f" and {len(told) - _MOST_TOLD} more" if len(told) > _MOST_TOLD else ""
            warnings.warn(
                f"the store '{self.path}' is made good: {', '.join(told[:_MOST_TOLD])}{more}; "
                f"{len(damaged)} of {self.plan.chunks} chunks are computed again",
                RuntimeWarning,
                stacklevel=6,
            )

    def _remove(self, is_left: Callable[[str, str], object]) -> None:
        """Remove files of a killed writer, known by name and place, and folders left empty."""
        for folder, _, files in os.walk(self.path, topdown=False):
            for name in files:
                path = Path(folder) / name
                if is_left(name, path.relative_to(self.path).as_posix()):
                    path.unlink()
            if not os.listdir(folder):
                os.rmdir(folder)

    def _add(self, number: int, counts: Mapping[str, int], reason: str) -> None:
        """Take note of a finished chunk."""
        self._counts.update(counts)
        self._reasons[number] = reason

    def _finish(self) -> None:
        """Tell in the attributes of a complete store why points have no answer."""
        reason = next((r for _, r in sorted(self._reasons.items()) if r), "")
        if reason and self._root["attributes"].get("first_invalid") != reason:
            self._root["attributes"]["first_invalid"] = reason
            self._put(ROOT, as_text(self._root))

    def _put(self, key: str, content: bytes) -> None:
        """Write a file of the store, whole or not at all."""
        path = self.path / key
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_path(path) as unfinished:
            unfinished.write_bytes(content)

    def _told(self, error: OSError) -> OSError:
        """Return an error of the system with what is kept and the way out."""
        said = error.strerror or str(error)
        way_out = "finished chunks are kept; once this is mended, the same sweep goes on from there"
        return OSError(error.errno, f"{said} ({way_out})", str(self.path))


def open_store(path: str | Path) -> xr.Dataset:
    """Return the dataset of a store, whose values are read on use.

    Warns
    -----
    RuntimeWarning
        If the sweep is unfinished; `status` is -1 where nothing has been computed.

    Raises
    ------
    FileNotFoundError, InputError
        If there is no store of a sweep.
    """
    path = Path(path)
    state = store_status(path)
    if not state["complete"]:
        warnings.warn(
            f"the sweep in '{path}' is unfinished: {state['points_done']} of {state['points']} "
            "points are done, status is -1 at the others; run the sweep again to go on",
            RuntimeWarning,
            stacklevel=3,
        )
    return _opened(path)


def store_status(path: str | Path) -> dict[str, Any]:
    """Return what a store holds, how far its sweep is, and whether somebody is writing it.

    Raises
    ------
    FileNotFoundError, InputError
        If there is no store of a sweep.

    Notes
    -----
    Chunks count as done by their notes; whether their files are sound is seen on resuming.
    """
    path = Path(path)
    root = existing_root(path)
    attributes = root["attributes"]
    plan = json.loads(attributes["plan"])
    metadata = root["consolidated_metadata"]["metadata"][STATUS]
    shape = metadata["shape"]
    extents = metadata["chunk_grid"]["configuration"]["chunk_shape"]
    chunks = math.prod(-(-n // c) for n, c in zip(shape, extents, strict=True))
    counts: Counter[str] = Counter()
    done, reasons = 0, {}
    for number in range(chunks):
        note = read_note(path / NOTES / f"{number}.json", attributes["plan_hash"])
        if note is not None:
            done += 1
            counts.update(note["status"])
            reasons[number] = note["first_invalid"]
    return {
        "store": str(path),
        "plan_hash": attributes["plan_hash"],
        "latolato_version": attributes["latolato_version"],
        "system": attributes["system"],
        "drive": attributes["drive"],
        "axes": {axis["name"]: len(axis["values"][0]) for axis in plan["axes"]},
        "observables": [observable["kind"] for observable in plan["observables"]],
        "duration": plan["duration"],
        "tolerance": plan["tolerance"],
        "chunks": chunks,
        "chunks_done": done,
        "points": math.prod(shape),
        "points_done": counts.total(),
        "status_counts": in_order(counts),
        "first_invalid": next((r for r in reasons.values() if r), ""),
        "complete": done == chunks,
        "writer_active": lock.is_held(path / _LOCK),
    }


def plan_from_store(path: str | Path) -> Plan:
    """Return the plan of the sweep in a store, finished or not, or in a NetCDF file of one.

    Raises
    ------
    FileNotFoundError, InputError
        If there is no sweep, or its plan was changed by hand.
    """
    path = Path(path)
    if path.is_file():
        from latolato.files import load

        attributes: Mapping[str, Any] = load(path).attrs
        if "plan" not in attributes:
            raise InputError(f"'{path}' holds no sweep: it has no plan")
    else:
        attributes = existing_root(path)["attributes"]
    plan = Plan.from_description(json.loads(attributes["plan"]))
    if plan.hash != attributes["plan_hash"]:
        raise InputError(
            f"the plan in '{path}' does not fit its hash: one of them was changed; use the "
            "scenario instead"
        )
    return plan


def _opened(path: Path) -> xr.Dataset:
    """Return the dataset of a folder that is known to be a store."""
    import xarray as xr

    dataset: xr.Dataset = xr.open_zarr(str(path), chunks=None)
    # As NumPy's fixed-width text, like the coordinates of a sweep in memory.
    texts = {n: c for n, c in dataset.coords.items() if c.dtype.kind not in "iuf"}
    return dataset.assign_coords(
        {name: (c.dims, np.array(c.values.tolist()), c.attrs) for name, c in texts.items()}
    )
