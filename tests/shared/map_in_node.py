"""Maps in Node.js, computed as a page does: in workers, from coarse to fine."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from in_node import NODE


def maps_in_node(plans: Sequence[dict[str, Any]], workers: int = 2) -> list[dict[str, Any]]:
    """Return what comes of plans of ``js/map/plan.js`` one after the other.

    Of each its ``estimate``, ``pictures`` (after how many seconds, of how many points), ``status``
    and ``values`` of all cells, row by row, and the ``variables`` that these are.
    """
    done = subprocess.run(
        [NODE, Path(__file__).with_suffix(".mjs")],
        input=json.dumps({"plans": plans, "workers": workers}),
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    result: list[dict[str, Any]] = json.loads(done.stdout)
    return result
