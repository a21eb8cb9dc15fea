"""A sweep's results in a Zarr store: written chunk by chunk, resumed to the same bytes.

A store is a Zarr group of format 3 that plain `xarray.open_zarr` opens. A checksum (CRC32C) ends
every file of values, so that plain Zarr refuses a damaged one. The folder ``.latolato`` holds a
note for every finished chunk with the digests of its files, written after them, and a copy of the
group's metadata: a chunk without a note, or whose files differ from it, is computed again. Files
are put in place whole, the group's own ``zarr.json`` last of those that a new store begins with.
"""

from __future__ import annotations

import json
import os
import re
import warnings
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.atomic import atomic_path, checked_path
from latolato.core.errors import InputError
from latolato.numerics.abi import sources_hash
from latolato.observables import observables
from latolato.sweeps import lock
from latolato.sweeps.chunk import STATUS, Values, status_counts
from latolato.sweeps.differences import differences
from latolato.sweeps.executors import ROUNDING
from latolato.sweeps.labels import Results, in_order, template
from latolato.sweeps.layout import (
    COPY,
    GROUP,
    NOTES,
    OWN,
    ROOT,
    Survey,
    as_text,
    copy_of,
    damaged_error,
    digest_of,
    documents,
    encoders,
    first_files,
    has_store,
    place_of,
    signed,
    survey,
    with_reason,
)
from latolato.sweeps.plan import Plan
from latolato.sweeps.statuses import with_words

if TYPE_CHECKING:
    import xarray as xr

_LOCK = f"{OWN}/lock"
# A file that `atomic_path` has not put in place because its process was killed.
_UNFINISHED = re.compile(r"\..+\.\d+\.[0-9a-f]{6}(\.\w+)?")
# What a store begins with, the root apart.
_FIRST = re.compile(r"[^/]+/(zarr\.json|root\.json|c/0)")
_MOST_LISTED = 4


class Store(Results):
    """A sweep's results in a folder, for one writer at a time.

    Parameters
    ----------
    plan : Plan
        The sweep.
    path : str or Path
        The store: a new or empty folder, or one that holds a part or all of this sweep.
    rounding : str
        How the values that will be written are rounded, a value of `executors.ROUNDING`.

    Raises
    ------
    FileExistsError
        On entering, if `path` is something else; nothing is touched then.
    BlockingIOError
        If another process writes the store.
    InputError
        If the store holds another sweep, or a part of this one by other kernels or with another
        rounding.
    OSError
        If the disk is full, while writing too; finished chunks are kept.
    """

    def __init__(self, plan: Plan, path: str | Path, rounding: str) -> None:
        super().__init__(plan, rounding)
        self.path = checked_path("store", path)
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
            raise self._with_way_out(error) from None
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
                raise self._with_way_out(error) from None
            raise
        return self

    def __exit__(self, *_: object) -> None:
        """Release the lock."""
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
            raise self._with_way_out(error) from None

    def dataset(self) -> xr.Dataset:
        """Return the labelled dataset, whose values are checked and read on use."""
        return _opened(self.path, survey(self.path, read_all=False))

    def _check_place(self) -> Survey | None:
        """Return the contents of this plan's store, None where it can begin; raise for another."""
        if not has_store(self.path):
            return None
        result = survey(self.path, read_all=self._descriptor != -1)
        if result.plan.hash != self.plan.hash:
            own = json.loads(json.dumps(self.plan.describe()))
            stored = json.loads(result.root["attributes"]["plan"])
            raise InputError(
                f"the store '{self.path}' holds another sweep: "
                f"{_shortened(differences(stored, own))}",
                way_out="name another path, or delete the store to start again",
            )
        stored_names = {key.partition("/")[0] for key in documents(result.root)}
        unknown = [name for name in template(self.plan) if name not in stored_names]
        if unknown:
            version = result.root["attributes"]["latolato_version"]
            raise InputError(
                f"the store '{self.path}' has no {', '.join(unknown)}: the observables of latolato "
                f"{version} did not give that yet",
                way_out="name another path, or delete the store to start again",
            )
        return result

    def _open(self) -> None:
        """Create the store or find out what is missing, with the lock held."""
        result = self._check_place()  # again, now that nobody else writes it
        new, coordinates = first_files(self.plan, self.rounding)
        self._root = new if result is None else result.root
        files = {
            **coordinates,
            **documents(self._root),
            f"{OWN}/{ROOT}": GROUP,
            COPY: copy_of(self._root),
            ROOT: as_text(self._root),
        }
        if result is None:
            self._remove(lambda name, key: _FIRST.fullmatch(key) or _UNFINISHED.fullmatch(name))
            for key, content in files.items():
                self._put(key, content)
        else:
            self.missing = [n for n in range(self.plan.chunks) if n not in result.notes]
            self._check_origin()
            for number, note in result.notes.items():
                self._add(number, note["status"], note["first_invalid"])
            self.points_done = self._counts.total()
            self._remove(lambda name, _: _UNFINISHED.fullmatch(name))
            self._repair(result.damaged, files)
        self._arrays, self._encoded = encoders(self.plan, self._root)
        if not self.missing:
            self._finish()

    def _check_origin(self) -> None:
        """Raise unless what is missing would be computed like the rest."""
        if not self.missing:
            return
        attributes = self._root["attributes"]
        missing = f"{len(self.missing)} of {self.plan.chunks} chunks of '{self.path}' are missing"
        other_way = "name another path, or delete the store to start again"
        if attributes["kernel_sources"] != sources_hash():
            raise InputError(
                f"{missing}, and latolato {attributes['latolato_version']} wrote the others with "
                f"other kernels ({attributes['kernel_sources'][:8]}, here {sources_hash()[:8]})",
                way_out=f"finish it with that version, {other_way}",
            )
        if attributes["rounding"] != self.rounding:
            raise InputError(
                f"{missing}, and the store was begun with executor "
                f"{_executors(attributes['rounding'])}, which rounds differently from "
                f"{_executors(self.rounding)}",
                way_out=f"finish it with that executor, {other_way}",
            )

    def _repair(self, damaged: Mapping[str, int | None], files: Mapping[str, bytes]) -> None:
        """Forget damaged chunks, write other damaged files again, and warn of it."""
        if not damaged:
            return
        chunks = {number for number in damaged.values() if number is not None}
        for number in chunks:
            (self.path / NOTES / f"{number}.json").unlink(missing_ok=True)
        for key in files.keys() & damaged.keys():
            self._put(key, files[key])
        warnings.warn(
            f"repaired the store '{self.path}': {_shortened(sorted(damaged))} damaged or missing; "
            f"{len(chunks)} of {self.plan.chunks} chunks are computed again",
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

    def _finish(self) -> None:
        """Say in the attributes of a complete store why points have no answer."""
        content = as_text(with_reason(self._root, self._reason))
        if (self.path / ROOT).read_bytes() != content:
            self._put(ROOT, content)

    def _put(self, key: str, content: bytes) -> None:
        """Write a file of the store, whole or not at all."""
        path = self.path / key
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_path(path) as unfinished:
            unfinished.write_bytes(content)

    def _with_way_out(self, error: OSError) -> OSError:
        """Return an error of the system with what is kept and the way out."""
        text = error.strerror or str(error)
        way_out = "no chunk was finished; name another path, or make sure that this one is writable"
        if self._reasons:
            way_out = "finished chunks are kept; once this is fixed, the same sweep resumes there"
        return OSError(error.errno, f"{text} ({way_out})", str(self.path))


def open_store(path: str | Path) -> xr.Dataset:
    """Return the dataset of a store, whose values are checked and read on use.

    Warns
    -----
    RuntimeWarning
        If the sweep is unfinished; `status` is ``missing`` where nothing has been computed.

    Raises
    ------
    FileNotFoundError
        If there is no store of a sweep.
    InputError
        If there is something else, or the metadata are damaged; on use also if values are.
    """
    path = Path(path)
    result = survey(path, read_all=False)
    if ROOT in result.damaged:
        raise damaged_error(path, f"its {ROOT} is damaged or missing")
    if not result.is_complete:
        done = sum(sum(note["status"].values()) for note in result.notes.values())
        notes = sorted(key for key in result.damaged if key.startswith(NOTES))
        why = f" ({_shortened(notes)} damaged)" if notes else ""
        warnings.warn(
            f"the sweep in '{path}' is unfinished: {done} of {result.plan.size} points are done"
            f"{why}, status is 'missing' at the others; run the sweep again to go on",
            RuntimeWarning,
            stacklevel=3,
        )
    return _opened(path, result)


def verify_store(path: str | Path) -> dict[str, Any]:
    """Read every file of a store and return what is damaged.

    Returns
    -------
    dict
        What `store_status` returns, and ``files``, the number of files that were read, and
        ``damaged``, a list of mappings: the ``file``, the ``variable`` and the ``chunk`` (in Zarr's
        name, ``c/1/0``) that it holds, None if it holds none, and the ``number`` of the chunk that
        a resumed sweep computes again, None if nothing is.

    Raises
    ------
    FileNotFoundError, InputError
        If there is no store of a sweep.

    Notes
    -----
    Files are compared with the SHA-256 digests that were taken when they were written. Chunks that
    are not noted as finished hold nothing to verify.
    """
    result = survey(Path(path), read_all=True)
    damaged = []
    for key, number in sorted(result.damaged.items()):
        variable, chunk = place_of(key)
        damaged.append({"file": key, "variable": variable, "chunk": chunk, "number": number})
    return _status(Path(path), result) | {"files": len(result.digests) + 2, "damaged": damaged}


def store_status(path: str | Path) -> dict[str, Any]:
    """Return the contents of a store, the progress of its sweep, and whether it is being written.

    Raises
    ------
    FileNotFoundError, InputError
        If there is no store of a sweep.

    Notes
    -----
    Chunks count as done by their notes; `verify_store` reads their files.
    """
    return _status(Path(path), survey(Path(path), read_all=False))


def _status(path: Path, contents: Survey) -> dict[str, Any]:
    """Return the state of a store as plain values."""
    attributes, plan = contents.root["attributes"], contents.plan
    counts: Counter[str] = Counter()
    for note in contents.notes.values():
        counts.update(note["status"])
    return {
        "store": str(path),
        "plan_hash": plan.hash,
        "latolato_version": attributes["latolato_version"],
        "rounding": attributes["rounding"],
        "system": attributes["system"],
        "drive": attributes["drive"],
        "axes": {axis.name: len(axis) for axis in plan.axes},
        "observables": [observables.name_of(observable) for observable in plan.observables],
        "duration": plan.duration,
        "tolerance": plan.tolerance,
        "chunks": plan.chunks,
        "chunks_done": len(contents.notes),
        "points": plan.size,
        "points_done": counts.total(),
        "status_counts": in_order(counts),
        "first_invalid": contents.reason,
        "complete": contents.is_complete,
        "writer_active": lock.is_held(path / _LOCK),
    }


def _opened(path: Path, contents: Survey) -> xr.Dataset:
    """Return the dataset of a store, whose files are compared with their digests on use."""
    import xarray as xr

    from latolato.sweeps.checked import CheckedFiles

    dataset: xr.Dataset = xr.open_zarr(CheckedFiles.of(path, contents.digests), chunks=None)
    # As NumPy's fixed-width text, like the coordinates of a sweep in memory.
    texts = {n: c for n, c in dataset.coords.items() if c.dtype.kind not in "iuf"}
    dataset = dataset.assign_coords(
        {name: (c.dims, np.array(c.values.tolist()), c.attrs) for name, c in texts.items()}
    )
    return with_words(dataset, on_use=True)


def _executors(rounding: str) -> str:
    """Return the executors that round alike, as text."""
    return " or ".join(repr(name) for name, family in ROUNDING.items() if family == rounding)


def _shortened(texts: list[str]) -> str:
    """Return the first few of many texts."""
    more = f" and {len(texts) - _MOST_LISTED} more" if len(texts) > _MOST_LISTED else ""
    return ", ".join(texts[:_MOST_LISTED]) + more
