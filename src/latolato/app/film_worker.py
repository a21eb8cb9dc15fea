"""The process that reads an uploaded video: with limits on what it may take, for one job.

It reads one line of JSON from its standard input, works, and writes lines of JSON: ``progress``,
and at last ``done`` or ``error``. It ends when its standard input is closed, for then the server
has gone.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from collections.abc import Callable
from typing import Any, TextIO

# Size of the largest file that a job writes [bytes].
_LARGEST_FILE = 1_000_000_000
_FILES = 256
# Between the signal that ends a process for its processor time and the one that kills it [s].
_SPARED = 10


def main() -> None:
    """Do the job that is told on standard input."""
    answers = _own_output()
    line = sys.stdin.readline()
    if not line.strip():
        return
    job = json.loads(line)
    limit(job["memory"], job["cpu_time"])
    threading.Thread(target=_end_with_the_server, daemon=True).start()

    def tell(message: dict[str, Any]) -> None:
        answers.write(json.dumps(message) + "\n")
        answers.flush()

    try:
        tell({"done": _work(job, lambda stage, share: tell({"stage": stage, "progress": share}))})
    except MemoryError:
        tell({"error": "this video needs more memory than it may take: scale it down"})
    except Exception as error:  # whatever a broken file does to a decoder is one line
        tell({"error": one_line(error, job)})
    answers.flush()
    # Threads of decoders must not hold the end back.
    os._exit(0)


def limit(memory: float, cpu_time: float) -> None:
    """Let this process take no more than so much memory [bytes] and processor time [s]."""
    try:
        import resource
    except ModuleNotFoundError:  # Windows has wall time only
        return
    for name, most in (
        ("RLIMIT_AS", memory),
        ("RLIMIT_CPU", cpu_time),
        ("RLIMIT_FSIZE", _LARGEST_FILE),
        ("RLIMIT_NOFILE", _FILES),
        ("RLIMIT_CORE", 0),
    ):
        kind = getattr(resource, name, None)
        if kind is None:
            continue
        _, hard = resource.getrlimit(kind)
        wanted = int(most) if hard == resource.RLIM_INFINITY else min(int(most), hard)
        # Beyond the hard limit of time the reason is lost.
        spared = wanted + _SPARED if name == "RLIMIT_CPU" else wanted
        try:
            resource.setrlimit(kind, (wanted, spared if hard == resource.RLIM_INFINITY else hard))
        except (ValueError, OSError):  # macOS refuses some
            continue


def one_line(error: Exception, job: dict[str, Any]) -> str:
    """Return why a job failed, in one line about the film's name instead of its path."""
    text = " ".join(str(error).split()) or type(error).__name__
    for quoted in (f"'{job['path']}'", str(job["path"])):
        text = text.replace(quoted, job["name"])
    # How to say it on the command line is no help here.
    for hint in (": --pivot", ": --ball", " (in Python"):
        text = text.partition(hint)[0]
    if not isinstance(error, (ValueError, TypeError, RuntimeError, OSError, ImportError)):
        return f"{job['name']} could not be worked on: {type(error).__name__}: {text}"
    return text


def _work(job: dict[str, Any], tell: Callable[[str, float], None]) -> dict[str, Any]:
    """Return what a job found."""
    from latolato.app.film_work import WORK

    return WORK[job["do"]](job, tell)


def _own_output() -> TextIO:
    """Return the standard output, which nothing else writes to from now on."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    nothing = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nothing, 1)
    return answers


def _end_with_the_server() -> None:
    """End this process when its standard input is closed."""
    while sys.stdin.readline():
        pass
    os._exit(1)


if __name__ == "__main__":
    main()
