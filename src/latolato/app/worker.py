"""What a job of `latolato.app.jobs` does in its process, and how far it is."""

from __future__ import annotations

import importlib
import json
import os
import signal
import sys
import tempfile
import time
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType
from typing import Any

from numpy.typing import NDArray

from latolato.app.languages import language_of
from latolato.core.errors import InputError
from latolato.core.faults import line_of
from latolato.core.language import speaking
from latolato.io.progress import compiling

# Header and arrays of a block for the page: see `latolato.app.blocks`.
Result = tuple[dict[str, Any], dict[str, NDArray[Any]]]
# What a job does, ``(request, folder, progress)``. It calls ``progress(share)``, or
# ``progress(share, stage)`` if its work has stages.
Compute = Callable[[Mapping[str, Any], Path, Callable[..., None]], Result]
# What most jobs import.
_HEAVY = ("latolato.figures.plot", "matplotlib.figure", "xarray", "numba")
_NICENESS = 5
# Where a job says how far it is.
STATUS = "status.json"
# Time between two reports [s].
_PAUSE = 0.1


def run(compute: Compute, request: Mapping[str, Any], folder: Path) -> Result:
    """Return the result of a job, with its warnings in the header.

    It is presented in the `language` of the page that asks, by its code.

    Raises
    ------
    InputError
        For bad input, and for any other fault with the line of its report.
    """
    # What a process that is killed leaves behind goes with the folder of its job.
    tempfile.tempdir = str(folder)
    report = _Report(folder)
    report.progress()
    try:
        with (
            warnings.catch_warnings(record=True) as caught,
            speaking(language_of(request.get("language", "en"))),
            compiling(report.compiling, report.compiled),
        ):
            warnings.simplefilter("always", RuntimeWarning)
            about, arrays = compute(request, folder, report.progress)
    except InputError:
        raise
    except Exception as error:  # the traceback does not leave this process
        raise InputError(line_of(error)) from None
    told = [each.message for each in caught if issubclass(each.category, RuntimeWarning)]
    texts = [each.args[0] if isinstance(each, Warning) else each for each in told]
    return {"warnings": list(dict.fromkeys(texts)), **about}, arrays


def run_apart(compute: Compute, request: Mapping[str, Any], folder: Path) -> Result:
    """Return the result of a job in a process that has no other task."""
    stand_back()
    return run(compute, request, folder)


def import_heavy() -> None:
    """Import what most jobs need, so that the next one in this process begins at once."""
    for name in _HEAVY:
        importlib.import_module(name)


def stand_back() -> None:
    """Leave terminal, screen and most of the processor to the server."""
    # AnyIO takes the main module away where the server was started from no file (python -c, a
    # notebook), and lmfit imports it.
    sys.modules.setdefault("__main__", ModuleType("__main__"))
    # Ctrl-C in the terminal is meant for the server, which then ends its jobs.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "setpriority"):
        os.setpriority(os.PRIO_PROCESS, 0, _NICENESS)
    os.environ["MPLBACKEND"] = "Agg"
    # Nobody reads what decoders print.
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 2)
    os.close(nowhere)


class _Report:
    """Writes how far a job is to a file in its folder."""

    def __init__(self, folder: Path) -> None:
        self._path = folder / STATUS
        self._written = 0.0
        self._status: dict[str, Any] = {}
        self._has_compiled = False

    def _write(self, status: Mapping[str, Any]) -> None:
        """Write a status; a reader finds this one or the one before."""
        unfinished = self._path.with_suffix(".part")
        unfinished.write_text(json.dumps(status), encoding="utf-8")
        unfinished.replace(self._path)

    def progress(self, share: float | None = None, stage: str = "working") -> None:
        """Write the share of a stage that is done, unless one of this stage was just written."""
        now = time.monotonic()
        if stage != self._status.get("state") or now - self._written > _PAUSE:
            self._written = now
            self._status = {"state": stage} | ({} if share is None else {"progress": float(share)})
            self._write(self._status)

    def compiling(self) -> None:
        """Write that the job compiles, once: a page reads out each change."""
        if not self._has_compiled:
            self._write({"state": "compiling"})
        self._has_compiled = True

    def compiled(self) -> None:
        """Write the stage that goes on."""
        self._write(self._status)


def status_in(folder: Path) -> dict[str, Any]:
    """Return how far the job with this folder is."""
    try:
        status: dict[str, Any] = json.loads((folder / STATUS).read_bytes())
    except OSError:  # its turn has not come
        return {"state": "waiting"}
    return status
