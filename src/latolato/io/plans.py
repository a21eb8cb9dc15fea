"""The plan of a sweep that was stored, to run it again or to go on."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from latolato.core.errors import InputError
from latolato.io.files import load
from latolato.sweeps.layout import survey
from latolato.sweeps.plan import Plan


def plan_from_store(path: str | Path) -> Plan:
    """Return the plan of the sweep in a store, finished or not, or in a file of one.

    Raises
    ------
    FileNotFoundError, InputError
        If there is no sweep, or its plan was changed by hand.
    """
    path = Path(path)
    if not path.is_file():
        return survey(path, read_all=False).plan
    attributes: Mapping[str, Any] = load(path).attrs
    if "plan" not in attributes:
        raise InputError(f"'{path}' holds no sweep: it has no plan")
    plan = Plan.from_description(json.loads(attributes["plan"]))
    # The tables that pages write have no hash.
    if attributes.get("plan_hash", plan.hash) != plan.hash:
        raise InputError(
            f"the plan in '{path}' does not fit its hash: one of them was changed",
            way_out="use the scenario instead",
        )
    return plan
