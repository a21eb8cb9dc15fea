"""The files of a store as Zarr reads them, each compared with its digest."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from zarr.storage import LocalStore, WrapperStore

from latolato.sweeps.layout import damaged_error, digest_of, place_of


class CheckedFiles(WrapperStore[LocalStore]):
    """The files of a store for reading; a damaged or missing one is an error that names it.

    Zarr's own checksum finds damage too, but names neither the file nor a way out, and a missing
    file reads as values that were never computed.
    """

    def __init__(self, store: LocalStore, digests: Mapping[str, str]) -> None:
        super().__init__(store)
        self._digests = digests

    @classmethod
    def of(cls, path: Path, digests: Mapping[str, str]) -> CheckedFiles:
        """Return the files of the store at `path`."""
        return cls(LocalStore(path, read_only=True), digests)

    def _with_store(self, store: LocalStore) -> CheckedFiles:
        return type(self)(store, self._digests)

    async def get(self, key: str, prototype: Any, byte_range: Any = None) -> Any:
        """Return a file, or a part of it."""
        variable, chunk = place_of(key)
        if chunk is None or key not in self._digests:
            return await self._store.get(key, prototype, byte_range)
        content = await self._store.get(key, prototype)
        what = f"chunk {chunk} of {variable}"
        if content is None:
            raise damaged_error(self._store.root, f"{what} is missing")
        if digest_of(content.to_bytes()) != self._digests[key]:
            raise damaged_error(self._store.root, f"{what} is damaged")
        if byte_range is not None:
            return await self._store.get(key, prototype, byte_range)
        return content
