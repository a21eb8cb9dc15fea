"""The language in which results are presented: English, unless a caller speaks another.

A text is born in English, which is also its key, as in gettext. Files and datasets keep English:
only what presents a result, such as a picture, asks for translations.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field

# A decimal point; in mathematics a comma needs braces, else a space follows it.
_POINT = re.compile(r"(?<=\d)\.(?=\d)")
_RATIO = re.compile(r"(?<=\d)_(?=\d)")
_MATHEMATICS = re.compile(r"(\$[^$]*\$)")


@dataclass(frozen=True)
class Language:
    """Texts by their English ones, and the sign between whole numbers and decimals."""

    texts: Mapping[str, str] = field(default_factory=dict)
    decimal: str = "."


ENGLISH = Language()
_SPOKEN: ContextVar[Language] = ContextVar("language", default=ENGLISH)


@contextmanager
def speaking(language: Language) -> Iterator[None]:
    """Present results in a language inside a ``with`` block."""
    token = _SPOKEN.set(language)
    try:
        yield
    finally:
        _SPOKEN.reset(token)


def tr(text: str, **values: object) -> str:
    """A text in the language that is spoken, with its gaps filled; English where it has none.

    Examples
    --------
    >>> with speaking(Language({"{share} of all": "{share} dari semua"}, ",")):
    ...     tr("{share} of all", share=0.5), tr("unknown"), local("$0.5$ and 0.25")
    ('0,5 dari semua', 'unknown', '$0{,}5$ and 0,25')
    """
    known = _SPOKEN.get().texts.get(text, text)
    return local(known.format(**values) if values else known)


def spoken(name: str) -> str:
    """A name in data as words: ``resonance_1_1`` is *resonance 1:1*."""
    return tr(_RATIO.sub(":", name).replace("_", " "))


def local(text: str) -> str:
    """A text whose numbers have the decimal sign of the language that is spoken."""
    sign = _SPOKEN.get().decimal
    if sign == ".":
        return text
    parts = _MATHEMATICS.split(text)
    parts[::2] = (_POINT.sub(sign, part) for part in parts[::2])
    parts[1::2] = (_POINT.sub(f"{{{sign}}}", part) for part in parts[1::2])
    return "".join(parts)
