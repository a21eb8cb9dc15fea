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


# Panels of all views, of which none may lie on another, wherever the page is scrolled to.
_OVERLAPS = """async () => {
  const panels = [...document.querySelectorAll(
    "main :is(.card, .panel, .stage, details, fieldset, nav, section, aside)")]
    .filter((each) => each.checkVisibility() && each.getClientRects().length);
  const name = (each) => [each.tagName.toLowerCase(), ...each.classList].join(".")
    + ` "${each.innerText.trim().slice(0, 30)}"`;
  const found = new Set();
  const { scrollHeight } = document.documentElement;
  for (let top = 0; top < scrollHeight; top += innerHeight / 2) {
    scrollTo(0, top);
    await new Promise((done) => requestAnimationFrame(done));
    const boxes = panels.map((each) => each.getBoundingClientRect());
    panels.forEach((one, i) => panels.slice(i + 1).forEach((other, k) => {
      if (one.contains(other)) return;
      const [a, b] = [boxes[i], boxes[i + 1 + k]];
      const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (across > 2 && down > 2) found.add(`${name(one)} and ${name(other)}`);
    }));
  }
  scrollTo(0, 0);
  return [...found];
}"""


def overlaps(page: Any) -> list[str]:
    """Panels of a page that cover each other somewhere, in pairs."""
    found: list[str] = page.evaluate(_OVERLAPS)
    return found
