"""A lock of the operating system on a file: held by one writer, gone with its process."""

from __future__ import annotations

import contextlib
import os
import socket
import sys
import time
from pathlib import Path

if sys.platform == "win32":
    import msvcrt
else:
    import fcntl

# Looking whether a lock is held takes it for an instant; a writer tries again meanwhile.
_ATTEMPTS = 10
_PAUSE = 0.02  # s


def acquire(path: Path) -> int | None:
    """Return a descriptor that holds the lock, or None while another holder has it.

    The lock of a killed process is free; that of a running one is not, in this process or another.
    """
    for attempt in range(_ATTEMPTS):
        if attempt:
            time.sleep(_PAUSE)
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        try:
            # Its last holder may have removed the file between opening and locking it.
            if _try(descriptor) and _is_named(descriptor, path):
                with contextlib.suppress(OSError):  # the name of the holder is a courtesy
                    os.ftruncate(descriptor, 0)
                    os.write(descriptor, f"{os.getpid()} on {socket.gethostname()}".encode())
                return descriptor
        except BaseException:
            os.close(descriptor)
            raise
        os.close(descriptor)
    return None


def release(descriptor: int, path: Path) -> None:
    """Give up the lock and remove its file."""
    if sys.platform == "win32":  # open files cannot be removed there
        os.close(descriptor)
        with contextlib.suppress(OSError):
            path.unlink()
    else:
        with contextlib.suppress(OSError):
            path.unlink()
        os.close(descriptor)


def is_held(path: Path) -> bool:
    """Return whether a process holds the lock."""
    try:
        descriptor = os.open(path, os.O_RDWR if sys.platform == "win32" else os.O_RDONLY)
    except FileNotFoundError:
        return False
    try:
        return not _try(descriptor)
    finally:
        os.close(descriptor)


def holder(path: Path) -> str:
    """Return who holds the lock, as far as the file names it."""
    try:
        process = path.read_text()
    except OSError:
        process = ""
    return f"process {process}" if process else "another process"


def _is_named(descriptor: int, path: Path) -> bool:
    """Return whether the open file is still the one of that name."""
    try:
        return os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False


if sys.platform == "win32":

    def _try(descriptor: int) -> bool:
        """Return whether the lock could be taken; the byte locked lies beyond what is read."""
        os.lseek(descriptor, 1 << 30, os.SEEK_SET)
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError:
            return False
        os.lseek(descriptor, 0, os.SEEK_SET)
        return True

else:

    def _try(descriptor: int) -> bool:
        """Return whether the lock could be taken."""
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        return True
