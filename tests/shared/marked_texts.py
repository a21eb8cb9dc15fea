"""A language that puts each of its texts between marks, to find those that it does not pass."""

from __future__ import annotations

import re
from xml.etree import ElementTree

from latolato.core.language import Language

# Units, names and functions, which are the same in every language.
KNOWN = {"mm", "ms", "rad", "mJ", "Re", "Im", "ln", "Kapitza"}
_SVG = "{http://www.w3.org/2000/svg}"


class _Marked(dict[str, str]):
    """Texts of a language that puts each between marks."""

    def get(self, text, default=None):
        return f"⟨{text}⟩"


MARKED = Language(_Marked(), ",")


def texts_of(picture: bytes) -> list[str]:
    """Return all texts of a picture as SVG."""
    root = ElementTree.fromstring(picture)
    return ["".join(each.itertext()) for each in root.iter(f"{_SVG}text")]


def unmarked(texts: list[str]) -> set[str]:
    """Return words outside marks, mathematics and units, and numbers with a decimal point."""
    text = re.sub(r"\$[^$]*\$|\[[^]]*\]", " ", " ".join(texts))
    while (inner := re.sub(r"⟨[^⟨⟩]*⟩", " ", text)) != text:
        text = inner
    points = {text for text in texts if re.search(r"\d\.\d", text)}
    return set(re.findall(r"[A-Za-z]{2,}", text)) - KNOWN | points
