"""The temporary folder of a server; that of one that was killed goes when the next one starts."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from latolato.sweeps import lock

_PREFIX = "latolato-app-"
# Held by the server as long as it runs; the operating system gives it free when the server ends,
# however that happens, so that no process number is trusted.
_LOCK = "lock"


@contextmanager
def scratch_folder() -> Iterator[Path]:
    """Put the temporary files of this process and its children into a folder of its own.

    Yields
    ------
    Path
        The folder, which is removed in the end.
    """
    usual, variable = tempfile.tempdir, os.environ.get("TMPDIR")
    remove_orphans(Path(tempfile.gettempdir()))
    folder, descriptor = _make()
    tempfile.tempdir = os.environ["TMPDIR"] = str(folder)
    try:
        yield folder
    finally:
        tempfile.tempdir = usual
        if variable is None:
            del os.environ["TMPDIR"]
        else:
            os.environ["TMPDIR"] = variable
        _remove(folder, descriptor)


def remove_orphans(place: Path) -> None:
    """Remove the folders below `place` whose servers ended without tidying up."""
    for folder in place.glob(f"{_PREFIX}*"):
        with suppress(OSError):  # a folder of somebody else, or gone meanwhile
            if folder.is_symlink() or not _is_ours(folder) or lock.is_held(folder / _LOCK):
                continue
            descriptor = lock.acquire(folder / _LOCK)
            if descriptor is not None:
                _remove(folder, descriptor)


def _make() -> tuple[Path, int]:
    """Return a new folder and the descriptor that holds its lock."""
    while True:
        folder = Path(tempfile.mkdtemp(prefix=_PREFIX))
        # Before it is locked another server may take it for an orphan.
        with suppress(FileNotFoundError):
            descriptor = lock.acquire(folder / _LOCK)
            if descriptor is not None:
                return folder, descriptor


def _remove(folder: Path, descriptor: int) -> None:
    """Remove a folder whose lock we hold."""
    shutil.rmtree(folder, ignore_errors=True)
    lock.release(descriptor, folder / _LOCK)
    with suppress(OSError):  # where an open file cannot be removed, the folder is left until now
        folder.rmdir()


def _is_ours(folder: Path) -> bool:
    """Return whether a folder belongs to the user."""
    return not hasattr(os, "getuid") or folder.stat().st_uid == os.getuid()
