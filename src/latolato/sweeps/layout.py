"""The files of a store: names, Zarr's metadata, digests, and what a look at them finds."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from latolato.core.errors import InputError
from latolato.sweeps.chunk import STATUS
from latolato.sweeps.labels import (
    attributes_of,
    attributes_of_variables,
    coordinates_of,
    lengths_of,
    template,
)
from latolato.sweeps.plan import Plan

ROOT = "zarr.json"
OWN = ".latolato"
NOTES = f"{OWN}/chunks"
# The group's metadata as the store began, with a digest: `ROOT` is checked and rebuilt by it.
COPY = f"{OWN}/root.json"
_REASON = "first_invalid"
# Lets Zarr know the folder of notes as something of its own.
GROUP = b'{"zarr_format": 3, "node_type": "group", "attributes": {}}'


@dataclass(frozen=True)
class Survey:
    """What a store holds.

    Attributes
    ----------
    root : dict
        The group's metadata as the store began.
    plan : Plan
        The sweep.
    notes : dict of int to dict
        Notes of finished chunks in order, without those of damaged chunks.
    digests : dict of str to str
        Digests of the files that hold coordinates, metadata and finished chunks.
    damaged : dict of str to (int or None)
        Damaged or missing files, with the chunk that they belong to.
    """

    root: dict[str, Any]
    plan: Plan
    notes: dict[int, dict[str, Any]] = field(default_factory=dict)
    digests: dict[str, str] = field(default_factory=dict)
    damaged: dict[str, int | None] = field(default_factory=dict)

    @property
    def reason(self) -> str:
        """What is wrong with the first invalid point of the finished chunks."""
        return next((note[_REASON] for note in self.notes.values() if note[_REASON]), "")

    @property
    def is_complete(self) -> bool:
        """Whether all chunks are finished and none is known to be damaged."""
        return len(self.notes) == self.plan.chunks


def survey(path: Path, *, read_all: bool) -> Survey:
    """Return the contents of a store; with `read_all` every file is compared with its digest.

    Raises
    ------
    FileNotFoundError, FileExistsError, InputError
        If there is no store of a sweep, or one whose metadata are lost.
    """
    if not path.exists():
        raise FileNotFoundError(f"there is no store '{path}'")
    try:
        is_store = has_store(path)
    except FileExistsError as error:
        raise InputError(f"'{path}' is not a store of a sweep") from error
    if not is_store:
        raise InputError(f"'{path}' is not a store of a sweep, or one that was only just begun")
    document, copy = _read(path / ROOT), _signed_content(path / COPY)
    if copy is None and _is_root(document) and "rounding" not in document["attributes"]:
        raise InputError(
            f"the store '{path}' was written by an earlier latolato, without checksums",
            way_out="read it with xarray.open_zarr, or run the sweep again into another store",
        )
    plan: Plan | None
    if copy is not None:
        root = json.loads(copy["root"])
        plan = Plan.from_description(json.loads(root["attributes"]["plan"]))
    else:
        root = _without_reason(document)
        plan = _plan_of(root)
    if plan is None:
        raise InputError(
            f"{ROOT} and {COPY} of the store '{path}' are both damaged or missing",
            way_out="name another path, or delete the store and run the sweep again",
        )
    result = Survey(root, plan)
    if copy is None:
        result.damaged[COPY] = None
    files = first_files(plan, root["attributes"]["rounding"])[1] | documents(root)
    result.digests.update({key: digest_of(content) for key, content in files.items()})
    result.digests[f"{OWN}/{ROOT}"] = digest_of(GROUP)
    for number in range(plan.chunks):
        key = f"{NOTES}/{number}.json"
        note = read_note(path / key, plan.hash)
        if note is not None:
            result.notes[number] = note
            result.digests.update(note["files"])
        elif (path / key).exists():
            result.damaged[key] = number
    reason = result.reason if result.is_complete else None
    if _without_reason(document) != root or reason not in (
        None,
        document["attributes"].get(_REASON, reason),
    ):
        result.damaged[ROOT] = None
    if read_all:
        number_of = {key: n for n, note in result.notes.items() for key in note["files"]}
        for key, digest in result.digests.items():
            if is_damaged(path / key, digest):
                result.damaged[key] = number_of.get(key)
        for chunk in result.damaged.values():
            if chunk is not None:
                result.notes.pop(chunk, None)
    return result


def has_store(path: Path) -> bool:
    """Return whether a store is at `path`; False where a new one can be made.

    Raises
    ------
    FileNotFoundError
        If the folder around it does not exist.
    FileExistsError
        If something else is there.
    """
    if not path.parent.is_dir():
        raise FileNotFoundError(f"the folder '{path.parent}' does not exist; create it first")
    if path.exists() and not path.is_dir():
        raise FileExistsError(f"'{path}' is a file, not a store of a sweep: name another path")
    names = {entry.name for entry in path.iterdir()} if path.exists() else set()
    if OWN not in names and names:
        raise FileExistsError(
            f"'{path}' is a folder of something else, not a store of a sweep: name another path"
        )
    return ROOT in names or (path / NOTES).exists()


def damaged_error(path: Path, what: str) -> InputError:
    """Return the error for a store of which a part cannot be read."""
    return InputError(
        f"{what} in the store '{path}'",
        way_out=(
            f"'latolato sweep --verify {path}' lists all damage, and running the sweep again with "
            "this store repairs it"
        ),
    )


def place_of(key: str) -> tuple[str | None, str | None]:
    """Return the variable and the chunk that a file of a store holds, None for other files."""
    variable, _, rest = key.partition("/")
    if variable == OWN or not rest:
        return None, None
    return variable, rest if rest.startswith("c/") else None


def with_reason(root: Mapping[str, Any], reason: str) -> dict[str, Any]:
    """Return the metadata of a complete store, with why points have no answer."""
    more = {_REASON: reason} if reason else {}
    return {**root, "attributes": {**root["attributes"], **more}}


def _read(path: Path) -> Any:
    """Return a JSON document, None if it cannot be read."""
    try:
        return json.loads(path.read_bytes())
    except (OSError, ValueError):
        return None


def _is_root(document: Any) -> bool:
    """Return whether a document looks like the metadata of a store."""
    return isinstance(document, dict) and isinstance(document.get("attributes"), dict)


def copy_of(root: Mapping[str, Any]) -> bytes:
    """Return the content of `COPY`."""
    return signed({"root": as_text(root).decode()})


def _without_reason(document: Any) -> Any:
    """Return a group's metadata as they were when the store began."""
    if not _is_root(document):
        return document
    attributes = {k: v for k, v in document["attributes"].items() if k != _REASON}
    return document | {"attributes": attributes}


def _plan_of(root: Any) -> Plan | None:
    """Return the plan in a group's metadata, None unless it fits its hash."""
    try:
        attributes = root["attributes"]
        plan = Plan.from_description(json.loads(attributes["plan"]))
        whole = plan.hash == attributes["plan_hash"] and "rounding" in attributes
        root["consolidated_metadata"]["metadata"][STATUS]
    except (ValueError, KeyError, TypeError):
        return None
    return plan if whole else None


def first_files(plan: Plan, rounding: str) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Return the first files of a new store: its metadata and its coordinates.

    The metadata of the arrays are consolidated here, as Zarr itself warns that this has no
    specification yet.
    """
    import zarr
    from zarr.codecs import Crc32cCodec, ZstdCodec
    from zarr.storage import MemoryStore

    files: dict[str, Any] = {}
    group = zarr.create_group(MemoryStore(files), zarr_format=3)
    about = attributes_of_variables(plan)
    lengths = lengths_of(plan)
    coordinates = coordinates_of(plan)
    for name, (dims, values) in coordinates.items():
        array = group.create_array(
            name,
            shape=values.shape,
            chunks=values.shape,
            dtype=str if values.dtype.kind == "U" else values.dtype,
            compressors=[Crc32cCodec()],
            dimension_names=dims,
            attributes=about.get(name, {}),
            config={"write_empty_chunks": True},
        )
        array[:] = values
    variables = template(plan)
    for name, (dims, dtype, fill) in variables.items():
        group.create_array(
            name,
            shape=tuple(lengths[d] for d in dims),
            chunks=plan.chunk_shape + tuple(lengths[d] for d in dims[len(plan.dims) :]),
            dtype=dtype,
            fill_value=fill,
            compressors=[ZstdCodec(), Crc32cCodec()],
            dimension_names=dims,
            attributes=about[name],
        )
    # xarray takes the variables that this attribute names for coordinates.
    others = [name for name, (dims, _) in coordinates.items() if dims != (name,)]
    attributes = attributes_of(plan, rounding) | (
        {"coordinates": " ".join(others)} if others else {}
    )
    arrays = {
        name: json.loads(files.pop(f"{name}/{ROOT}").to_bytes())
        for name in [*coordinates, *variables]
    }
    root = json.loads(files.pop(ROOT).to_bytes()) | {
        "attributes": attributes,
        "consolidated_metadata": {"kind": "inline", "must_understand": False, "metadata": arrays},
    }
    return root, {key: buffer.to_bytes() for key, buffer in files.items()}


def documents(root: Mapping[str, Any]) -> dict[str, bytes]:
    """Return the metadata files of the arrays."""
    arrays = root["consolidated_metadata"]["metadata"]
    return {f"{name}/{ROOT}": as_text(metadata) for name, metadata in arrays.items()}


def encoders(plan: Plan, root: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return the variables as arrays in memory, and the files by name that they turn into."""
    import zarr
    from zarr.core.buffer import default_buffer_prototype
    from zarr.storage import MemoryStore

    buffer = default_buffer_prototype().buffer
    files = {k: buffer.from_bytes(v) for k, v in (documents(root) | {ROOT: GROUP}).items()}
    # Also chunks without any answer become files: one that is not there is missing.
    with zarr.config.set({"array.write_empty_chunks": True}):
        group = zarr.open_group(MemoryStore(files), mode="r+", use_consolidated=False)
        return {name: group[name] for name in template(plan)}, files


def as_text(document: Mapping[str, Any]) -> bytes:
    """Return metadata as Zarr writes them."""
    return json.dumps(document, indent=2).encode()


def digest_of(content: bytes) -> str:
    """Return the digest by which a file is known again."""
    return hashlib.sha256(content).hexdigest()


def signed(content: Mapping[str, Any]) -> bytes:
    """Return a document as text with its own digest."""
    digest = digest_of(json.dumps(content, sort_keys=True).encode())
    return json.dumps({**content, "digest": digest}, sort_keys=True, indent=1).encode()


def _signed_content(path: Path) -> dict[str, Any] | None:
    """Return the content that `signed` wrote to a file, or None unless it is whole."""
    content = _read(path)
    if not isinstance(content, dict):
        return None
    digest = content.pop("digest", None)
    whole = digest == digest_of(json.dumps(content, sort_keys=True).encode())
    return content if whole else None


def read_note(path: Path, plan: str) -> dict[str, Any] | None:
    """Return the note of a chunk, or None if there is none that is whole and of this plan."""
    note = _signed_content(path)
    return note if note is not None and note.get("plan") == plan else None


def is_damaged(path: Path, digest: str) -> bool:
    """Return whether a file is missing or not the one that was written."""
    try:
        return digest_of(path.read_bytes()) != digest
    except OSError:
        return True
