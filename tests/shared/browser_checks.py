"""What every page of the application is held to."""

from pathlib import Path
from typing import Any

import axe_playwright_python


def serious_faults(page: Any) -> list[str]:
    """Return what axe-core finds serious or critical on a page, one line each."""
    source = Path(axe_playwright_python.__file__).parent / "axe.min.js"
    # The page's policy forbids scripts that are not its own: the tool comes in from outside.
    page.evaluate(source.read_text(encoding="utf-8"))
    found = page.evaluate("() => axe.run()")
    return [
        f"{fault['id']}: {node['html'][:120]} {node.get('failureSummary', '')[:300]}"
        for fault in found["violations"]
        if fault["impact"] in ("serious", "critical")
        for node in fault["nodes"]
    ]
