"""A process for long work: reads jobs from standard input, writes how far they are.

A job is one line of JSON, ``{"job": name, "request": {...}, "folder": path}``; its files go to the
folder. Answers are lines of JSON as well: ``{"ready": true}`` once, then for each job any number of
``{"stage": word, "progress": share}`` and ``{"compiling": true}``, and at last ``{"done": {...}}``
or ``{"error": text, "parameter": name}``. The process ends when its input does, in the middle of a
job too: whoever wanted the answer is gone.

A process with the argument ``once`` is for one job, and imports nothing before that is there.
"""

from __future__ import annotations

import importlib
import json
import os
import queue
import signal
import sys
import tempfile
import threading
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TextIO

from latolato.core.errors import InputError
from latolato.core.faults import line_of
from latolato.io.progress import compiling
from latolato.simulation.summary import plain

# Where the functions ``(request, folder, progress) -> dict`` are. They call
# ``progress(share)``, or ``progress(share, stage)`` if their work has stages.
JOBS = {
    "analyse": ("latolato.app.analyse.answer", "compute"),
    "animate": ("latolato.app.downloads", "compute"),
    "clip": ("latolato.app.experiment.jobs", "compute"),
    "map_file": ("latolato.app.map.files", "compute"),
    "open_map": ("latolato.app.map.stored", "compute"),
}
# Imported before a job is there, so that it begins at once.
_HEAVY = ("latolato.figures.plot", "matplotlib.figure", "xarray", "numba")
_NICENESS = 5

Tell = Callable[[Mapping[str, Any]], None]


def run(job: Mapping[str, Any], tell: Tell) -> None:
    """Do one job and tell its end."""

    def progress(share: float, stage: str = "working") -> None:
        tell({"stage": stage, "progress": share})

    try:
        # What a process that is killed leaves behind goes with the folder of its job.
        tempfile.tempdir = job["folder"]
        module, name = JOBS[job["job"]]
        function = getattr(importlib.import_module(module), name)
        with (
            warnings.catch_warnings(record=True) as caught,
            compiling(lambda: tell({"compiling": True}), lambda: tell({"compiling": False})),
        ):
            warnings.simplefilter("always", RuntimeWarning)
            result = function(job["request"], Path(job["folder"]), progress)
    except Exception as error:
        if isinstance(error, InputError):
            text = error.worded("{parameter}")
            tell({"error": text, "parameter": error.parameter, "parts": error.parts()})
        else:
            tell({"error": line_of(error)})
    else:
        texts = [str(w.message) for w in caught if issubclass(w.category, RuntimeWarning)]
        tell({"done": {**result, "warnings": list(dict.fromkeys(texts))}})


def main() -> None:
    """Do jobs until the input ends."""
    # Ctrl-C in the terminal is meant for the server, whose end closes our input.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(_NICENESS)  # live pages go first
    os.environ["MPLBACKEND"] = "Agg"
    answers = own_output()
    lock = threading.Lock()

    def tell(message: Mapping[str, Any]) -> None:
        with lock:
            print(json.dumps(plain(message)), file=answers, flush=True)

    jobs: queue.Queue[str] = queue.Queue()

    def read() -> None:
        for line in sys.stdin:
            jobs.put(line)
        os._exit(0)

    threading.Thread(target=read, daemon=True).start()
    if "once" not in sys.argv[1:]:
        for name in _HEAVY:
            importlib.import_module(name)
    tell({"ready": True})
    while True:
        run(json.loads(jobs.get()), tell)


def own_output() -> TextIO:
    """Return the standard output; what others print from now on is no answer."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    return answers


if __name__ == "__main__":
    main()
