"""The console script: Ctrl-C ends it quietly, also while modules are imported.

It stands beside the package, since importing anything of that imports most of it.
"""

from __future__ import annotations

import atexit
import os
import signal
from typing import Any


def end_at_once(*_: Any) -> None:
    """End with code 130: an exception in the middle of an import could turn into another one."""
    os._exit(130)


def main() -> int:
    """Run the command line and return its exit code."""
    signal.signal(signal.SIGINT, end_at_once)
    # The last thing done before Python takes itself apart, which would restore the system's handler
    # and let Ctrl-C kill a process whose work is done.
    atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)
    import logging

    from latolato.cli.main import main as run

    # Zarr leaves its other reads pending when one is refused; asyncio would report each at the end.
    logging.getLogger("asyncio").setLevel(logging.CRITICAL)
    try:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        return run()
    except KeyboardInterrupt:
        return 130
    finally:
        signal.signal(signal.SIGINT, end_at_once)
