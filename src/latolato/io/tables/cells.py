"""Cells of a line, and what the shape of a cell says about it."""

from __future__ import annotations

import csv
import re
from functools import lru_cache

from latolato.io.tables.rules import broken
from latolato.io.tables.shapes import LEADING

# The delimiters, the likeliest first; blanks are any number of blanks and tabs.
BLANKS = " "
DELIMITERS = ("\t", ";", "|", ",", BLANKS)
DELIMITER_NAMES = {"\t": "tabs", ";": "semicolons", "|": "bars", ",": "commas", BLANKS: "blanks"}
# Signs that group digits and cannot be decimal signs.
GROUPING = " '\u2019\u00a0\u202f\u2009"
MINUS = "\u2212"
# What programs write for a number that is not known, in small letters.
MISSING_WORDS = (
    "nan", "na", "n/a", "#n/a", "#na", "none", "null", "-", "--", "?",
    "#div/0!", "#value!", "#num!", "#ref!", "#name?", "#null!", "#wert!", "#zahl!", "#nv",
)  # fmt: skip

_D = f"[0{LEADING}]"
_SIGN = f"[+{MINUS}-]?"
_EXPONENT = f"(?:[eE][+{MINUS}-]?{_D}+)?"
_ANY = f"{_SIGN}(?:{_D}+(?:[.,{GROUPING}]{_D}+)*\\.?|[.,]{_D}+){_EXPONENT}"
_KINDS = {
    "integer": f"{_SIGN}{_D}+{_EXPONENT}",
    "point or thousands": f"{_SIGN}0{{1,3}}\\.{_D}{{3}}",
    "comma or thousands": f"{_SIGN}0{{1,3}},{_D}{{3}}",
    "point": f"{_SIGN}(?:{_D}+\\.{_D}*|\\.{_D}+){_EXPONENT}",
    "comma": f"{_SIGN}(?:{_D}+,{_D}+|,{_D}+){_EXPONENT}",
    "points of thousands": f"{_SIGN}0{{1,3}}(?:(?:\\.{_D}{{3}}){{2,}}|(?:\\.{_D}{{3}})+,{_D}+)",
    "commas of thousands": f"{_SIGN}0{{1,3}}(?:(?:,{_D}{{3}}){{2,}}|(?:,{_D}{{3}})+\\.{_D}*)",
}  # fmt: skip
_COMPILED = {kind: re.compile(pattern) for kind, pattern in _KINDS.items()}
_GROUPED = re.compile(f"({_SIGN}0{{1,3}})((?:[{GROUPING}]{_D}{{3}})+)(?!{_D})(.*)")
_QUANTITY = re.compile(rf"{_ANY}\s*[^\W\d_°µ%][\w°µ%/^²*.]*|{_ANY}\s*[°%µ][\w/]*")
# Kinds that are numbers, whatever the decimal sign.
NUMBERS = (*_KINDS, "three digits")
_NUMBER = re.compile(_ANY.replace(_D, f"[0-9{LEADING}]"))
_FRAME = re.compile(r"^\s*\|(.*)\|\s*$")
_COMMENT = re.compile(r"\s*(?:#|%|//)")


@lru_cache(maxsize=100_000)
def kind_of(cell: str) -> str:
    """The kind of a cell's shape: a kind of number, "quantity", "missing", "empty" or "text".

    Examples
    --------
    >>> kind_of("0,0000"), kind_of("00.000"), kind_of("0.000.000"), kind_of("mm")
    ('comma', 'point or thousands', 'points of thousands', 'text')
    """
    cell = cell.strip()
    if not cell:
        return "empty"
    if cell.lower() in MISSING_WORDS:
        return "missing"
    if re.fullmatch(f"{_SIGN}000", cell):
        return "three digits"
    grouped = _GROUPED.fullmatch(cell)
    if grouped:
        cell = grouped[1] + "000" * (len(grouped[2]) // 4) + grouped[3]
        # Groups of blanks leave the other signs to the decimals.
        for kind in ("integer", "point", "comma"):
            if _COMPILED[kind].fullmatch(cell):
                return kind
        return "text"
    for kind, pattern in _COMPILED.items():
        if pattern.fullmatch(cell):
            return kind
    return "quantity" if _QUANTITY.fullmatch(cell) else "text"


def kinds_of(cells: list[str], delimiter: str) -> list[str]:
    """Return the kinds of cells; between commas and blanks no blank groups digits."""
    kinds = [kind_of(cell) for cell in cells]
    if delimiter in (",", BLANKS):
        return [
            "text" if kind in NUMBERS and any(c.isspace() for c in cell) else kind
            for kind, cell in zip(kinds, cells, strict=True)
        ]
    return kinds


def zeros(cell: str) -> str:
    """Return a cell with a zero for each digit, nearly its shape."""
    return re.sub(r"\d", "0", cell)


def number_in(cell: str) -> str:
    """Return the number with which a quantity begins.

    Examples
    --------
    >>> number_in("20,5 mm"), number_in("1e3 s")
    ('20,5', '1e3')
    """
    match = _NUMBER.match(cell.strip())
    return match[0] if match else ""


def is_comment(line: str) -> bool:
    """Return whether a line is a comment: a word for a missing number is none."""
    if not _COMMENT.match(line):
        return False
    first = re.split(r"[\t;,|\s]", line.strip(), maxsplit=1)[0].strip('"').lower()
    return first not in MISSING_WORDS


def without_mark(line: str) -> str:
    """Return a comment without the mark at its beginning."""
    return re.sub(r"^\s*(?:[#%]+|//+)\s?", "", line)


def split(line: str, delimiter: str) -> list[str]:
    """Return the cells of a line without the blanks about them.

    Examples
    --------
    >>> split('"0,5"; a ;', ";"), split("  1   2 ", BLANKS)
    (['0,5', 'a', ''], ['1', '2'])
    """
    if delimiter == BLANKS:
        if '"' not in line:
            return line.split()
        return [cell.strip('"') for cell in re.findall(r'"[^"]*"|[^\s"]+', line)]
    if delimiter == "|":
        # The bars at both ends of a line are a frame.
        line = _FRAME.sub(r"\1", line)
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    try:
        (cells,) = csv.reader([line], delimiter=delimiter, skipinitialspace=True)
    except csv.Error as error:
        raise broken("spoiled_line", {"text": line[:30], "fault": str(error)}) from None
    return [cell.strip() for cell in cells]


def opens_quote(line: str) -> bool:
    """Return whether a cell of a line begins with a quotation mark that the line does not close."""
    if line.count('"') % 2 == 0:
        return False
    return re.search(r'(?:^|[\t;,|])\s*"', line) is not None
