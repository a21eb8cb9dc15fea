"""Parts of the lines of Python that answer a question or make a map again.

Those of single runs pages write themselves, in `static/js/model/run_code.js`.
"""

from __future__ import annotations

from dataclasses import MISSING, fields
from typing import Any


def constructor(law: Any) -> str:
    """Return the call that makes a law; values that are the default are left out."""
    parts = []
    # What a law inherits, such as gravity, is said last.
    own = sorted(fields(law), key=lambda f: f.name == "gravity")
    for f in own:
        value = getattr(law, f.name)
        if not f.init or (f.default is not MISSING and value == f.default):
            continue
        shown = constructor(value) if hasattr(value, "__dataclass_fields__") else literal(value)
        parts.append(f"{f.name}={shown}")
    return f"ll.{type(law).__name__}({', '.join(parts)})"


def literal(value: Any) -> str:
    """Return a value as Python writes it; tuples as lists."""
    return repr(list(value)) if isinstance(value, tuple) else repr(value)
