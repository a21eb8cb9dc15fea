"""What every page of the application is held to."""

from pathlib import Path
from typing import Any

import axe_playwright_python


def serious_faults(page: Any) -> list[str]:
    """Return what axe-core finds serious or critical on a page, one line each."""
    source = Path(axe_playwright_python.__file__).parent / "axe.min.js"
    # The page's policy forbids scripts that are not its own: the tool comes in from outside.
    page.evaluate(source.read_text(encoding="utf-8"))
    result = page.evaluate("() => axe.run()")
    return [
        f"{fault['id']}: {node['html'][:120]} {node.get('failureSummary', '')[:300]}"
        for fault in result["violations"]
        if fault["impact"] in ("serious", "critical")
        for node in fault["nodes"]
    ]


# Panels of all views, cut off by whatever they scroll in: none may lie on another, wherever the
# page is scrolled to, nor reach beyond the window.
_OVERLAPS = """async () => {
  const kinds =
    ".card, .panel, .stage, .map-field, details, fieldset, figure, form, nav, section, aside";
  const panels = [...document.querySelectorAll(`main :is(${kinds})`)]
    .filter((each) => each.checkVisibility() && each.getClientRects().length);
  const cut = (element) => {
    const { left, top, right, bottom } = element.getBoundingClientRect();
    const box = { left, top, right, bottom };
    for (let e = element.parentElement; e && e !== document.body; e = e.parentElement) {
      if (getComputedStyle(e).overflowY === "visible") continue;
      const frame = e.getBoundingClientRect();
      box.left = Math.max(box.left, frame.left); box.right = Math.min(box.right, frame.right);
      box.top = Math.max(box.top, frame.top); box.bottom = Math.min(box.bottom, frame.bottom);
    }
    return box;
  };
  const name = (each) => [each.tagName.toLowerCase(), ...each.classList].join(".")
    + ` "${each.innerText.trim().slice(0, 30)}"`;
  // Where the page is scrolled, the rest of it passes below what stays in place.
  const isPinned = (element) => {
    for (let e = element; e; e = e.parentElement)
      if (getComputedStyle(e).position === "sticky") return true;
    return false;
  };
  const pairs = new Set();
  const { scrollHeight, scrollWidth } = document.scrollingElement;
  for (let top = 0; top < scrollHeight; top += innerHeight / 2) {
    scrollTo({ top, behavior: "instant" });
    await new Promise((done) => requestAnimationFrame(done));
    const boxes = panels.map(cut);
    panels.forEach((one, i) => panels.slice(i + 1).forEach((other, k) => {
      if (one.contains(other)) return;
      if (top > 0 && isPinned(one) !== isPinned(other)) return;
      const [a, b] = [boxes[i], boxes[i + 1 + k]];
      const across = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const down = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (across > 2 && down > 2) pairs.add(`${name(one)} and ${name(other)}`);
    }));
  }
  scrollTo({ top: 0, behavior: "instant" });
  const wider = scrollWidth - innerWidth;
  return wider > 0 ? [...pairs, `the page is ${wider} px wider than the window`] : [...pairs];
}"""

# A small laptop and a phone.
SIZES = ({"width": 1366, "height": 768}, {"width": 390, "height": 844})


def assert_panels_have_room(page: Any) -> None:
    """Fail if panels overlap on a laptop or on a phone."""
    for size in SIZES:
        page.set_viewport_size(size)
        page.wait_for_timeout(200)  # curves are laid out again
        overlaps = page.evaluate(_OVERLAPS)
        assert not overlaps, f"{size['width']} px: " + "; ".join(overlaps)
