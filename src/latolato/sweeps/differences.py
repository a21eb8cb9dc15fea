"""Where the description of one plan differs from another's, in words."""

from __future__ import annotations

import json
from typing import Any

import numpy as np


def differences(there: Any, here: Any, name: str = "") -> list[str]:
    """Return the differences of two plans, such as ``duration is 60.0, not 30.0``."""
    if isinstance(there, list) and isinstance(here, list):
        theirs, ours = _by_name(there), _by_name(here)
        if theirs and ours:
            if list(theirs) == list(ours):
                return differences(theirs, ours, name)
            there, here = list(theirs), list(ours)
    if isinstance(there, dict) and isinstance(here, dict):
        result = []
        for key in [*there, *(k for k in here if k not in there)]:
            below = f"{name}.{key}" if name else str(key)
            result += differences(there.get(key), here.get(key), below)
        return result
    return [] if there == here else [f"{name} is {_brief(there, here)}, not {_brief(here, there)}"]


def _by_name(entries: list[Any]) -> dict[str, Any]:
    """Return axes or observables by their name, or nothing if they have none."""
    if not all(isinstance(entry, dict) for entry in entries):
        return {}
    return {str(entry.get("name") or entry.get("kind")): entry for entry in entries}


def _brief(value: Any, other: Any) -> str:
    """Return a value in brief, with the part that differs from another one."""
    text = json.dumps(value)
    if len(text) <= 40:
        return text
    both = [np.ravel(np.array(v, dtype=object)) for v in (value, other)]
    if len(both[0]) == len(both[1]):
        at = next((i for i, (a, b) in enumerate(zip(*both, strict=True)) if a != b), 0)
        return f"[... {json.dumps(both[0][at])} ...]" if len(both[0]) > 1 else f"{text[:37]}..."
    return f"[{len(both[0])} values]"
