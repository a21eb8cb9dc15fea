"""Whether the panels of a page leave each other room."""

from typing import Any

# Cards and figures that can be seen, cut off by whatever they scroll in; two that overlap and are
# not inside each other, at some place of the page's scrollbar.
_OVERLAPS = """() => {
  const seen = [...document.querySelectorAll(
    "main section, main figure, main .card, main .panel, main .stage, main .map-field, main form")]
    .filter((e) => e.checkVisibility() && e.getClientRects().length);
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
  const name = (e) => `${e.tagName.toLowerCase()}.${[...e.classList].join(".")} `
    + `'${(e.querySelector("h2, summary, figcaption")?.textContent ?? "").slice(0, 30)}'`;
  const found = new Set();
  const end = document.scrollingElement.scrollHeight - innerHeight;
  for (const share of [0, 0.25, 0.5, 0.75, 1]) {
    scrollTo({ top: share * end, behavior: "instant" });
    const boxes = seen.map(cut);
    for (let i = 0; i < seen.length; i += 1)
      for (let j = i + 1; j < seen.length; j += 1) {
        if (seen[i].contains(seen[j]) || seen[j].contains(seen[i])) continue;
        const [a, b] = [boxes[i], boxes[j]];
        const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
        const high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
        if (wide > 2 && high > 2) found.add(`${name(seen[i])} over ${name(seen[j])}`);
      }
  }
  scrollTo({ top: 0, behavior: "instant" });
  const wider = document.scrollingElement.scrollWidth - innerWidth;
  if (wider > 1) found.add(`the page is ${wider} px wider than the window`);
  return [...found];
}"""

# A small laptop and a phone.
SIZES = ({"width": 1366, "height": 768}, {"width": 390, "height": 844})


def assert_panels_have_room(page: Any) -> None:
    """Fail if panels overlap on a laptop or on a phone."""
    for size in SIZES:
        page.set_viewport_size(size)
        page.wait_for_timeout(200)  # curves are laid out anew
        overlaps = page.evaluate(_OVERLAPS)
        assert not overlaps, f"{size['width']} px: " + "; ".join(overlaps)
