"""The line that a program prints for an exception: a refusal, or where the report of a fault is."""

from __future__ import annotations

import os
import platform
import sys
import tempfile
import traceback

from latolato.core.cache import cache_directory
from latolato.core.errors import InputError
from latolato.core.versions import version_of


def refusal_of(error: BaseException) -> str | None:
    """Return the one line that refuses an input, None if the error is a fault of the program.

    Refused are an `InputError`, what the system does not allow, such as a file that does not
    exist, and a request that needs more memory than there is.
    """
    if isinstance(error, MemoryError):
        return "not enough memory; ask for fewer samples, points or frames"
    if isinstance(error, OSError) and error.strerror and error.filename:
        text = f"{error.strerror}: {error.filename}"
    elif isinstance(error, (InputError, OSError)):
        text = str(error)
    else:
        return None
    return " ".join(text.split()) or type(error).__name__


def report_of(error: BaseException) -> str:
    """Write the traceback of a fault to a file; return the line that asks for a report.

    The file is in the cache folder: the application removes its temporary files when it ends. If
    the file cannot be written, the line says so.
    """
    name = type(error).__name__
    begin = f"internal error ({name}), a fault of the program and not of your input"
    try:
        folder = cache_directory() / "faults"
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        number, path = tempfile.mkstemp(prefix="fault-", suffix=".txt", dir=folder)
        with os.fdopen(number, "w", encoding="utf-8", errors="backslashreplace") as file:
            file.write(f"latolato {version_of()}, Python {platform.python_version()}, ")
            file.write(f"{platform.platform()}\n{sys.argv!r}\n")
            file.writelines(traceback.format_exception(error))
    except Exception as failure:  # of a disk that is full: the report itself never fails
        return f"{begin}; please report it (its traceback could not be written: {failure})"
    return f"{begin}; please report it with the traceback in '{path}'"


def line_of(error: BaseException) -> str:
    """Return one line: why the input is refused, or where the report of a fault is."""
    return refusal_of(error) or report_of(error)
