"""The cache folder: files that only this user may write, each behind its checksum."""

from __future__ import annotations

import functools
import hashlib
import os
import stat
import sys
import tempfile
import warnings
from contextlib import suppress
from pathlib import Path

_DIGEST_SIZE = hashlib.sha256().digest_size


class UntrustedFolderError(PermissionError):
    """A folder in which another user may put files."""


def reason_of(error: Exception) -> str:
    """Return the message of an error, in a few words on one line."""
    if isinstance(error, OSError) and error.strerror:
        return f"{error.strerror}: '{error.filename}'" if error.filename else error.strerror
    return " ".join(str(error).split()) or type(error).__name__


@functools.cache
def warn(message: str) -> None:
    """Warn once in a process."""
    warnings.warn(message, RuntimeWarning, stacklevel=2)


def cache_directory() -> Path:
    """Return the cache folder; ``LATOLATO_CACHE_DIR`` overrides the default.

    Raises
    ------
    FileNotFoundError
        If this user has no home folder.
    """
    chosen = os.environ.get("LATOLATO_CACHE_DIR")
    if chosen:
        return Path(chosen)
    variable, usual = {
        "win32": ("LOCALAPPDATA", "AppData/Local"),
        "darwin": (None, "Library/Caches"),
    }.get(sys.platform, ("XDG_CACHE_HOME", ".cache"))
    base = os.environ.get(variable) if variable else None
    try:
        return Path(base or Path.home() / usual) / "latolato"
    except RuntimeError:
        raise FileNotFoundError("this user has no home folder") from None


def read(path: Path) -> bytes:
    """Return the content that `write` stored in a file of the cache folder.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    UntrustedFolderError
        If another user owns a folder of the cache or may write to it.
    PermissionError
        If another user owns the file or may write to it.
    ValueError
        If the content does not match its checksum.
    OSError
        If the file cannot be read.
    """
    _check_folders(path.parent)
    with path.open("rb") as file:
        reason = _distrust(os.fstat(file.fileno()))
        if reason:
            raise PermissionError(reason)
        stored = file.read()
    digest, content = stored[:_DIGEST_SIZE], stored[_DIGEST_SIZE:]
    if hashlib.sha256(content).digest() != digest:
        raise ValueError("its checksum does not match")
    return content


def write(path: Path, content: bytes) -> None:
    """Store bytes in a file of the cache folder, whole or not at all.

    Raises
    ------
    UntrustedFolderError
        If another user owns a folder of the cache or may write to it.
    OSError
        If the file cannot be written.
    """
    _make_private(path.parent)
    _check_folders(path.parent)
    descriptor, unfinished = tempfile.mkstemp(dir=path.parent)  # for this user alone
    try:
        with open(descriptor, "wb") as file:
            file.write(hashlib.sha256(content).digest())
            file.write(content)
        os.replace(unfinished, path)
    except PermissionError:
        if os.name != "nt" or not path.exists():
            raise  # on Windows, another process is reading what it stored under this name
    finally:
        with suppress(OSError):
            os.unlink(unfinished)


def _make_private(folder: Path) -> None:
    """Create a folder and its missing parents for this user alone."""
    try:
        folder.mkdir(mode=0o700, exist_ok=True)  # as one step: others may create it just now
    except (FileNotFoundError, NotADirectoryError):  # the parent is missing, or is a file
        _make_private(folder.parent)
        folder.mkdir(mode=0o700, exist_ok=True)
    except FileExistsError:
        raise NotADirectoryError(f"'{folder}' is not a folder") from None


def _check_folders(folder: Path) -> None:
    """Raise unless a folder and its parents up to the cache folder are this user's alone."""
    top = cache_directory()
    for each in (folder, *folder.parents):
        reason = _distrust(each.stat())
        if reason:
            raise UntrustedFolderError(f"'{each}' {reason}")
        if each == top:
            return


def _distrust(status: os.stat_result) -> str | None:
    """Return why a file or folder may hold what another user put there, None if it cannot."""
    if os.name == "nt":  # a user's folders are private there
        return None
    if status.st_uid != os.geteuid():
        return "belongs to another user"
    if status.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return "can be written by other users"
    return None
