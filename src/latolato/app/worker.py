"""A process for long work: reads jobs from standard input, writes how far they are.

A job is one line of JSON, ``{"job": name, "given": {...}, "folder": path}``; its files go to the
folder. Answers are lines of JSON as well: ``{"ready": true}`` once, then for each job any number of
``{"progress": share}`` and ``{"compiling": true}``, and at last ``{"done": {...}}`` or
``{"error": text}``. The process ends when its input does, in the middle of a job too: whoever
wanted the answer is gone.
"""

from __future__ import annotations

import importlib
import json
import os
import queue
import signal
import sys
import threading
import traceback
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from latolato.progress import compiling
from latolato.summary import plain

# Where the functions ``(given, folder, progress) -> dict`` are.
JOBS = {
    "analyse": ("latolato.app.analyses", "compute"),
    "animate": ("latolato.app.downloads", "film"),
    "figure": ("latolato.app.paper", "compute"),
}
# Imported before a job is there, so that it begins at once.
_HEAVY = ("latolato.figures.plot", "matplotlib.figure", "xarray", "numba")
_NICENESS = 5

Tell = Callable[[Mapping[str, Any]], None]


def run(job: Mapping[str, Any], tell: Tell) -> None:
    """Do one job and tell its end."""
    module, name = JOBS[job["job"]]
    function = getattr(importlib.import_module(module), name)
    try:
        with (
            warnings.catch_warnings(record=True) as caught,
            compiling(lambda: tell({"compiling": True}), lambda: tell({"compiling": False})),
        ):
            warnings.simplefilter("always", RuntimeWarning)
            found = function(
                job["given"], Path(job["folder"]), lambda share: tell({"progress": share})
            )
    except (ArithmeticError, OSError, TypeError, ValueError, ModuleNotFoundError) as error:
        tell({"error": " ".join(str(error).split())})
    except MemoryError:
        tell({"error": "the computation needs more memory than there is: ask for less"})
    except Exception as error:
        traceback.print_exc()
        tell({"error": f"the computation failed: {type(error).__name__}"})
    else:
        told = [str(w.message) for w in caught if issubclass(w.category, RuntimeWarning)]
        tell({"done": {**found, "warnings": list(dict.fromkeys(told))}})


def main() -> None:
    """Do jobs until the input ends."""
    # Ctrl-C in the terminal is meant for the server, whose end closes our input.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(os, "nice"):
        os.nice(_NICENESS)  # live pages go first
    os.environ["MPLBACKEND"] = "Agg"
    answers = sys.stdout
    sys.stdout = sys.stderr  # what others print is no answer
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
    for name in _HEAVY:
        importlib.import_module(name)
    tell({"ready": True})
    while True:
        run(json.loads(jobs.get()), tell)


if __name__ == "__main__":
    main()
