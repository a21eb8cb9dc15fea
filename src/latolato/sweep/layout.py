"""The files of a store: their names, Zarr's metadata, and notes of what is done with digests."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from latolato.errors import InputError
from latolato.sweep.chunk import STATUS
from latolato.sweep.plan import Plan
from latolato.sweep.results import (
    attributes_of,
    attributes_of_variables,
    coordinates_of,
    lengths_of,
    template,
)

ROOT = "zarr.json"
OWN = ".latolato"
NOTES = f"{OWN}/chunks"
# Lets Zarr know the folder of notes as something of its own.
GROUP = b'{"zarr_format": 3, "node_type": "group", "attributes": {}}'


def existing_root(path: Path) -> dict[str, Any]:
    """Return the metadata of a store, or raise if there is none."""
    if not path.exists():
        raise FileNotFoundError(f"there is no store '{path}'")
    try:
        root = root_of(path)
    except FileExistsError as error:
        raise InputError(f"'{path}' is no store of a sweep") from error
    if root is None:
        raise InputError(f"'{path}' is no store of a sweep, or one that was only just begun")
    return root


def root_of(path: Path) -> dict[str, Any] | None:
    """Return a store's metadata, or None where a new one may be made.

    Raises
    ------
    FileExistsError
        If something else is there.
    InputError
        If the metadata of a store are damaged.
    """
    if not path.parent.is_dir():
        raise FileNotFoundError(f"the folder '{path.parent}' does not exist; create it first")
    if path.exists() and not path.is_dir():
        raise FileExistsError(f"'{path}' is a file, not a store of a sweep: name another path")
    has_results = (path / NOTES).exists()
    names = {entry.name for entry in path.iterdir()} if path.exists() else set()
    if OWN not in names and names:
        raise FileExistsError(
            f"'{path}' is a folder of something else, not a store of a sweep: name another path"
        )
    if ROOT not in names and not has_results:
        return None
    try:
        root: dict[str, Any] = json.loads((path / ROOT).read_bytes())
        root["attributes"]["plan_hash"], root["consolidated_metadata"]["metadata"][STATUS]
    except (OSError, ValueError, KeyError, TypeError):
        raise InputError(
            f"{ROOT} of the store '{path}' is damaged or missing: name another path, or delete "
            "the store to begin anew"
        ) from None
    return root


def first_files(plan: Plan) -> tuple[dict[str, Any], dict[str, bytes]]:
    """Return what a new store begins with: its metadata and the files of its coordinates.

    The metadata of the arrays are consolidated here, as Zarr itself warns that this has no
    specification yet.
    """
    import zarr
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
            compressors=None,
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
            dimension_names=dims,
            attributes=about[name],
        )
    # xarray takes the variables that this attribute names for coordinates.
    others = [name for name, (dims, _) in coordinates.items() if dims != (name,)]
    attributes = attributes_of(plan) | ({"coordinates": " ".join(others)} if others else {})
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


def signed(note: Mapping[str, Any]) -> bytes:
    """Return a note as text with its own digest."""
    digest = digest_of(json.dumps(note, sort_keys=True).encode())
    return json.dumps({**note, "digest": digest}, sort_keys=True, indent=1).encode()


def read_note(path: Path, plan: str) -> dict[str, Any] | None:
    """Return the note of a chunk, or None if there is none that is whole and of this plan."""
    try:
        note: dict[str, Any] = json.loads(path.read_bytes())
        digest = note.pop("digest")
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    whole = digest == digest_of(json.dumps(note, sort_keys=True).encode())
    return note if whole and note.get("plan") == plan else None


def is_damaged(path: Path, digest: str) -> bool:
    """Return whether a file is missing or not the one that was written."""
    try:
        return digest_of(path.read_bytes()) != digest
    except OSError:
        return True
