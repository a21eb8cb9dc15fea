"""Tables in many dialects are read to the numbers that were written, or refused."""

import itertools
import math

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

from latolato.core.errors import InputError
from latolato.io.tables.source import parse_source

NAMES = ("t", "x", "theta", "note")
GROUPS = {".": ".", ",": ",", " ": " ", "narrow": "\u202f"}
HEADERS = ("none", "names", "units", "comment", "title", "two lines")
MISSING = ("", "NaN", "-", "N/A")


def grouped(digits, sign):
    """Return whole digits in groups of three."""
    head = len(digits) % 3 or 3
    return sign.join([digits[:head], *(digits[i : i + 3] for i in range(head, len(digits), 3))])


@st.composite
def numbers(draw):
    """Return a number as sign, whole digits, decimals and exponent."""
    whole = str(draw(st.one_of(st.integers(0, 9), st.integers(0, 1500), st.integers(0, 10**7))))
    decimals = draw(st.text("0123456789", max_size=5))
    exponent = draw(st.sampled_from(["", "", "", "", "E-3", "e+02"]))
    return draw(st.booleans()), whole, decimals, exponent


def value_of(number):
    negative, whole, decimals, exponent = number
    return float(f"{'-' * negative}{whole}.{decimals or '0'}{exponent}")


def text_of(number, dialect):
    negative, whole, decimals, exponent = number
    if dialect["thousands"] and not exponent:
        whole = grouped(whole, dialect["thousands"])
    text = dialect["minus"] * negative + whole + (dialect["decimal"] + decimals) * bool(decimals)
    return text + exponent


@st.composite
def dialects(draw):
    delimiter = draw(st.sampled_from(["\t", ";", ",", "|", " ", "   "]))
    decimal = draw(st.sampled_from([".", ","]))
    thousands = draw(st.sampled_from(["", "", "", *GROUPS.values()]))
    if delimiter.isspace() and thousands.isspace() and delimiter != "\t":
        thousands = ""  # nobody could tell the two apart
    if delimiter == "," and thousands == ".":
        thousands = ""  # where commas separate the cells, points are decimal signs
    return {
        "delimiter": delimiter,
        "decimal": decimal,
        "thousands": "" if thousands == decimal else thousands,
        "quoted": draw(st.booleans()),
        "minus": draw(st.sampled_from(["-", "-", "\u2212"])),
        "missing": draw(st.sampled_from(MISSING)),
        "header": draw(st.sampled_from(HEADERS)),
        "trailing": draw(st.sampled_from(["", "header", "rows", "both"])),
        "comments": draw(st.booleans()),
        "blank_lines": draw(st.booleans()),
        "end": draw(st.sampled_from(["\n", "\r\n", "\r"])),
        "encoding": draw(st.sampled_from(["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-32"])),
    }


@st.composite
def tables(draw):
    count = draw(st.integers(2, 4))
    # A column of measured numbers has the same number of decimals in all rows, or any.
    fixed = draw(st.booleans())
    rows = []
    for _ in range(draw(st.integers(2, 8))):
        row = [draw(numbers()) for _ in range(count)]
        rows.append(row)
    if fixed:
        rows = [
            [(n, w, (d + "00000")[: 3 if i else 2], "") for i, (n, w, d, _) in enumerate(row)]
            for row in rows
        ]
    rows.sort(key=lambda row: value_of(row[0]))  # rows that fall back begin another section
    places = st.tuples(st.integers(1, len(rows)), st.integers(1, count - 1))
    lost = draw(st.sets(places, max_size=3))
    return [
        [None if (i, k) in lost else number for k, number in enumerate(row)]
        for i, row in enumerate(rows)
    ]


def written(rows, dialect):
    """Return the bytes of a table in a dialect."""
    delimiter = dialect["delimiter"]
    count = len(rows[0])
    tail = {"header": (delimiter, ""), "rows": ("", delimiter), "both": (delimiter, delimiter)}
    after_names, after_rows = tail.get(dialect["trailing"], ("", ""))
    names = list(NAMES[:count])
    header = {
        "none": [],
        "names": [names],
        "units": [[f"{name} [s]" for name in names]],
        "comment": [["# " + names[0], *names[1:]]],
        "title": [["Swing 3"], names],
        "two lines": [names, ["(s)"] * count],
    }[dialect["header"]]
    lines = [delimiter.join(cells) + after_names * (len(cells) > 1) for cells in header]
    for i, row in enumerate(rows):
        cells = [dialect["missing"] if n is None else text_of(n, dialect) for n in row]
        if dialect["quoted"]:
            cells = [f'"{cell}"' for cell in cells]
        lines.append(delimiter.join(cells) + after_rows)
        if dialect["blank_lines"] and i % 3 == 0:
            lines.append("")
        if dialect["comments"] and i == 0:
            lines.append("# released here")
    return (dialect["end"].join(lines) + dialect["end"]).encode(dialect["encoding"])


def is_plain(rows, dialect):
    """Return whether a table can be read in one way only, by these rules.

    The delimiter occurs in no number, blanks separate no empty cells, and at least one number has
    decimals that are no group of thousands; nothing groups thousands.
    """
    signs = {dialect["decimal"]}
    if dialect["delimiter"].strip() in signs or dialect["thousands"]:
        return False
    is_blank = dialect["delimiter"].isspace() and dialect["delimiter"] != "\t"
    if is_blank and (dialect["missing"] == "" or dialect["header"] == "units" or dialect["quoted"]):
        return False
    known = [number for row in rows for number in row if number is not None]
    if dialect["decimal"] == "," and dialect["delimiter"] == "|" and dialect["trailing"]:
        return False
    columns = list(zip(*rows, strict=True))
    for column in columns:
        decimals = {len(n[2]) for n in column if n is not None and not n[3]}
        if decimals <= {0, 3} and decimals != {0}:
            return False
    if dialect["delimiter"] == "," and dialect["header"] in ("none", "comment"):
        # Without names "1,234.5" may be one number.
        def is_group(a, b):
            return len(a[1]) < 4 and not a[2] and len(b[1]) == 3 and not b[0]

        pairs = [[p for p in itertools.pairwise(row) if None not in p] for row in rows]
        if all(any(is_group(*pair) for pair in each) for each in pairs):
            return False
        for place in zip(*map(itertools.pairwise, rows), strict=True):
            if all(is_group(*pair) for pair in place if None not in pair):
                return False
    return any(len(decimals) not in (0, 3) for _, _, decimals, _ in known)


def read(raw):
    """Return names and numbers of the columns that hold any, or the error that refuses them."""
    try:
        section = parse_source(raw).section()
        columns = [column for column in section.columns if column.kind != "empty"]
        values, _ = section.numbers(columns)
    except InputError as error:
        return error
    return [column.name for column in columns], np.array(values).T


THOUSANDS = {
    "delimiter": ",", "decimal": ".", "thousands": ",", "quoted": False, "minus": "-",
    "missing": "", "header": "none", "trailing": "", "comments": False, "blank_lines": False,
    "end": "\n", "encoding": "utf-8",
}  # fmt: skip


def check_table(rows, dialect):
    """Assert that a table is read to the numbers that were written, or refused."""
    raw = written(rows, dialect)
    found = read(raw)
    if isinstance(found, InputError):
        assert not is_plain(rows, dialect), (raw, str(found))
        assert "\n" not in str(found)
        return
    names, values = found
    truth = np.array([[math.nan if n is None else value_of(n) for n in row] for row in rows])
    kept = [k for k in range(len(rows[0])) if np.isfinite(truth[:, k]).any()]
    np.testing.assert_array_equal(values, truth[:, kept], err_msg=repr(raw))
    if dialect["header"] != "none":
        assert names == [NAMES[k] for k in kept], raw


@hypothesis.example(
    rows=[[(False, "0", "", ""), (False, "1000", each, "")] for each in ("0", "")],
    dialect=THOUSANDS,
)
@hypothesis.given(rows=tables(), dialect=dialects())
@hypothesis.settings(max_examples=200, deadline=None, derandomize=True)
def test_numbers_are_those_written_or_the_table_is_refused(rows, dialect):
    check_table(rows, dialect)


@pytest.mark.slow
@hypothesis.given(rows=tables(), dialect=dialects())
@hypothesis.settings(max_examples=8000, deadline=None)
def test_numbers_are_those_written_or_refused_in_tables_never_tried(rows, dialect):
    check_table(rows, dialect)
