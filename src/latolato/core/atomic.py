"""Files that are written whole or not at all, and the folders they go to."""

from __future__ import annotations

import os
import platform
import re
import secrets
import sys
import zlib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from latolato.core.errors import InputError


@contextmanager
def atomic_path(path: str | Path) -> Iterator[Path]:
    """Give the name of a temporary file beside `path` that becomes `path` when the block ends.

    If the block raises, or is interrupted, nothing is left. The temporary name keeps the suffix,
    from which many writers choose their format.

    Raises
    ------
    OSError
        If the folder does not exist or `path` is a folder.
    """
    path = Path(path)
    check_folder(path)
    name = f".{path.stem}.{_machine()}.{os.getpid()}.{secrets.token_hex(3)}{path.suffix}"
    unfinished = path.with_name(name)
    try:
        yield unfinished
        os.replace(unfinished, path)
    except OSError as error:
        if error.errno is None:
            raise
        # The temporary name would mean nothing to anyone.
        raise OSError(error.errno, error.strerror, str(path)) from None
    finally:
        unfinished.unlink(missing_ok=True)


def _machine() -> str:
    """Return a short mark of this machine, for process numbers mean nothing on another."""
    return f"{zlib.crc32(platform.node().encode()):08x}"


def remove_leftovers(path: Path) -> None:
    """Remove unfinished files for `path` whose writers, processes of this machine, are no more."""
    stem, suffix = re.escape(path.stem), re.escape(path.suffix)
    ours = re.compile(rf"\.{stem}\.{_machine()}\.(\d{{1,9}})\.[0-9a-f]{{6}}{suffix}")
    with suppress(OSError):  # a folder that may be written but not read
        for name in os.listdir(path.parent):
            match = ours.fullmatch(name)
            if match and not _is_alive(int(match[1])):
                with suppress(OSError):
                    path.with_name(name).unlink()


def _is_alive(process: int) -> bool:
    """Return whether a process may still run; on Windows asking would end it, so it may."""
    if sys.platform == "win32":
        return True
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except OSError:  # of another user
        return True
    return True


def check_folder(path: Path) -> None:
    """Raise OSError unless a file can be named `path`."""
    if path.is_dir():
        raise IsADirectoryError(f"'{path}' is a folder; name a file in it")
    if not path.parent.is_dir():
        raise FileNotFoundError(f"the folder '{path.parent}' does not exist; create it first")


def checked_path(name: str, value: Any) -> Path:
    """Return a path, or raise InputError for what is none."""
    if not isinstance(value, (str, os.PathLike)):
        raise InputError("must be a path", parameter=name, value=value)
    return Path(os.fsdecode(value))
