"""Maps in Node.js, computed as a page does: in workers, from coarse to fine."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from in_node import NODE


def views_in_node(
    requests: Sequence[dict[str, Any]], workers: int = 2, *, scalar: bool = False
) -> list[dict[str, Any]]:
    """Return what the view Map shows of requests, or the ``error`` that refuses them.

    Each holds the ``request`` of ``js/map/question.js``, ``run``, a cell to be run alone, and
    ``planned``, whether nothing is computed; `scalar` leaves out SIMD.
    """
    from latolato.app.forms import registry

    usual = {"scenario": None, "options": {}, "x": None, "y": None, "observable": None,
             "width": 4, "height": 3, "duration": None, "transient": None}  # fmt: skip
    given = {
        "requests": [{**each, "request": usual | each["request"]} for each in requests],
        "registry": registry(), "workers": workers, "scalar": scalar,
    }  # fmt: skip
    done = subprocess.run(
        [NODE, Path(__file__).with_suffix(".mjs")],
        input=json.dumps(given),
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    result: list[dict[str, Any]] = json.loads(done.stdout)
    return result
