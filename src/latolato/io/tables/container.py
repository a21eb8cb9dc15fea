"""From the bytes of a file to texts: archives, spreadsheets, encodings."""

from __future__ import annotations

import codecs
import io
import re
import zipfile
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal
from itertools import chain
from pathlib import PurePosixPath
from typing import Any

from latolato.core.errors import InputError, import_extra
from latolato.io.tables.cells import NUMBERS, kind_of, zeros

# Files, packed or unpacked, beyond this size are taken for mistakes [bytes].
LARGEST = 500_000_000
_EXPORT_CSV = "export its data as CSV"
_AS_TEXT = "save the table as UTF-8 text"
_CONTROL = "[\x00-\x08\x0e-\x1f]"
_TRACKER = (
    "it is a Tracker project, not its data",
    "open it in Tracker and use File, Export, Data File",
)
# How files begin that hold no table of text, what they are and what to do.
_SIGNATURES: tuple[tuple[bytes, str, str], ...] = (
    (b"%PDF", "it is a PDF document", "save its table as CSV"),
    (b"\x89PNG", "it is a picture", "import the table that it shows as CSV"),
    (b"\xff\xd8\xff", "it is a picture", "import the table that it shows as CSV"),
    (b"GIF8", "it is a picture", "import the table that it shows as CSV"),
    (b"\x89HDF", "it is an HDF5 or NetCDF file", _EXPORT_CSV),
    (b"PAR1", "it is a Parquet file of another program", _EXPORT_CSV),
    (b"SQLite format 3", "it is a database", _EXPORT_CSV),
    (b"CFWB", "it is a LabChart binary file", "in LabChart, save the data as text"),
    (b"7z\xbc\xaf", "it is a 7z archive", "unpack it"),
    (b"Rar!", "it is a RAR archive", "unpack it"),
    (b"BZh", "it is a bzip2 file", "unpack it"),
    (b"\xfd7zXZ", "it is an xz file", "unpack it"),
    (b"\x28\xb5\x2f\xfd", "it is a Zstandard file", "unpack it"),
    (b"MATLAB", "it is a MATLAB file", "in MATLAB, save its table with writetable"),
    (b"\x93NUMPY", "it is a NumPy array", "save it with numpy.savetxt"),
    (b"{\\rtf", "it is a text with formats (RTF)", "save it as plain text"),
)
# Where a tar archive says what it is.
_TAR = slice(257, 262)
# What begins the text of files that hold no table, in small letters, without blanks.
_TEXT_KINDS: tuple[tuple[str, str, str], ...] = (
    ("opensourcephysics", *_TRACKER),
    (
        "<kinoveavideoanalysis",
        "it is a Kinovea analysis, not its data",
        "in Kinovea, export the measured data as CSV or text",
    ),
    ("<trackmate", "it is a TrackMate file", "in TrackMate, export the spots as CSV"),
    ("<!doctypehtml", "it is a web page", "save its table as CSV"),
    ("<html", "it is a web page", "save its table as CSV"),
    ("<phyphox", "it is a phyphox experiment", "in phyphox, use Export Data, CSV"),
    ("<?xml", "it is an XML file", _EXPORT_CSV),
)
_SHEETS_OF_ZIP = ("xl/workbook.xml", "xl/workbook.bin", "content.xml")
_OLD_OFFICE = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
_ENDINGS = (".csv", ".txt", ".tsv", ".dat", ".asc")


@dataclass(frozen=True)
class Part:
    r"""One text of a file: the file itself, a member of an archive, or a sheet.

    Attributes
    ----------
    name : str
        The member or sheet, "" where the file is the only one.
    text : bytes
        In UTF-8, with line ends as ``\n``, also after the last line.
    encoding : str
        How it was written.
    delimiter, decimal : str or None
        What separates its cells, and its decimal sign, where they are known: those of sheets are.
    """

    name: str
    text: bytes
    encoding: str
    delimiter: str | None = None
    decimal: str | None = None


def read_parts(name: str, raw: bytes) -> list[Part]:
    """Return the texts in the bytes of a file.

    Raises
    ------
    InputError
        For an empty file and one that holds no text, with its kind and what to do instead.
        For a spreadsheet, if the extra `tables` is missing.
    """
    if not raw.strip(b"\0 \t\r\n"):
        raise InputError("it is empty", way_out="export the data again")
    if raw[:2] == b"\x1f\x8b":
        return read_parts(name.removesuffix(".gz"), _gunzipped(raw))
    if raw[:4] == b"PK\x03\x04":
        return _parts_of_zip(raw)
    if raw[:8] == _OLD_OFFICE:
        return _sheets(raw)
    if raw[4:8] == b"ftyp" or raw[:4] == b"RIFF":
        raise InputError("it is a video, not a table", way_out="use latolato track")
    for start, what, way_out in _SIGNATURES:
        if raw.startswith(start):
            raise InputError(what, way_out=way_out)
    if raw[_TAR] == b"ustar":
        raise InputError("it is a tar archive", way_out="unpack it")
    return [_decoded(raw)]


def _gunzipped(raw: bytes) -> bytes:
    """Return the content of a gzip file, which may have several members one after the other."""
    contents: list[bytes] = []
    while raw[:2] == b"\x1f\x8b":
        unpacker = zlib.decompressobj(zlib.MAX_WBITS | 16)
        room = LARGEST - sum(map(len, contents))
        try:
            contents.append(unpacker.decompress(raw, room + 1))
        except zlib.error as error:
            raise InputError(
                f"it is a damaged gzip file ({error})", way_out="pack it again"
            ) from None
        is_large = len(contents[-1]) > room
        if is_large or not unpacker.eof:
            cause = f"larger than {LARGEST // 1_000_000} MB" if is_large else "cut off"
            raise InputError(f"it is a gzip file whose content is {cause}", way_out="unpack it")
        raw = unpacker.unused_data
    return b"".join(contents)


def _parts_of_zip(raw: bytes) -> list[Part]:
    """Return the sheets of a spreadsheet, or the tables in an archive."""
    try:
        archive = zipfile.ZipFile(io.BytesIO(raw))
    except zipfile.BadZipFile as error:
        raise InputError(f"it is a damaged zip file ({error})", way_out="pack it again") from None
    with archive:
        members = {each.filename: each for each in archive.infolist() if not each.is_dir()}
        if any(each in members for each in _SHEETS_OF_ZIP):
            return _sheets(raw)
        if any(each.lower().endswith(".trk") for each in members):
            raise InputError(_TRACKER[0], way_out=_TRACKER[1])
        tables = {
            each: info
            for each, info in members.items()
            if each.lower().endswith(_ENDINGS) and not each.startswith("__MACOSX/")
        }
        if not tables:
            listed = ", ".join(list(members)[:5]) or "nothing"
            raise InputError(f"it is an archive without tables: {listed}", way_out="unpack it")
        if sum(each.file_size for each in tables.values()) > LARGEST:
            raise InputError(
                f"it is an archive of more than {LARGEST // 1_000_000} MB", way_out="unpack it"
            )
        try:
            contents = {each: archive.read(info) for each, info in tables.items()}
        except (zipfile.BadZipFile, RuntimeError, NotImplementedError, zlib.error) as error:
            raise InputError(f"it is a zip file that cannot be unpacked: {error}",
                             way_out="unpack it") from None  # fmt: skip
    known = {each: content for each, content in contents.items() if content.strip()}
    # What describes the phone and the clock lies in a folder of its own.
    outer = [each for each in known if PurePosixPath(each).parts[0] != "meta"] or list(known)
    return [_decoded(known[each], each) for each in outer]


def _sheets(raw: bytes) -> list[Part]:
    """Return the sheets of a spreadsheet as texts with tabs between the cells."""
    calamine = import_extra(
        "python_calamine", "tables", "a spreadsheet", way_out="save its sheet as CSV"
    )
    try:
        book = calamine.CalamineWorkbook.from_filelike(io.BytesIO(raw))
        sheets = [
            (name, book.get_sheet_by_name(name).to_python(skip_empty_area=False))
            for name in book.sheet_names
        ]
    except calamine.PasswordError:
        raise InputError("it is a spreadsheet with a password", way_out="save it without") from None
    except (calamine.CalamineError, OSError, ValueError) as error:
        raise InputError(
            f"it is a spreadsheet that cannot be read ({error})", way_out="save its sheet as CSV"
        ) from None
    parts = []
    for name, rows in sheets:
        # Where numbers are written as texts, the other cells must not settle their decimal sign.
        has_texts = any(map(_is_text_number, chain(*rows)))
        written, decimal = (_plain_number, None) if has_texts else (repr, ".")
        lines = ["\t".join(_cell_text(cell, written) for cell in row) for row in rows]
        if any(line.strip() for line in lines):
            text = ("\n".join(lines) + "\n").encode()
            parts.append(Part(name, text, "spreadsheet", "\t", decimal))
    if not parts:
        raise InputError("it is a spreadsheet without cells", way_out="export the data again")
    return parts


def _is_text_number(cell: Any) -> bool:
    """Return whether a cell is a text that is a number with a decimal sign or groups of digits."""
    return isinstance(cell, str) and kind_of(zeros(cell)) in NUMBERS and not cell.strip().isdigit()


def _plain_number(number: float) -> str:
    """Return a number without a decimal sign, as digits and an exponent.

    Examples
    --------
    >>> _plain_number(-0.04), _plain_number(1e-7)
    ('-4e-2', '1e-7')
    """
    sign, digits, exponent = Decimal(repr(number)).as_tuple()
    return f"{'-' * sign}{''.join(map(str, digits))}e{exponent}"


def _cell_text(cell: Any, written: Callable[[float], str]) -> str:
    """Return a cell of a spreadsheet as text; a number keeps every digit."""
    if isinstance(cell, float):
        return str(int(cell)) if cell.is_integer() and abs(cell) < 1e15 else written(cell)
    return re.sub(r"[\x00-\x1f\"]+", " ", str(cell)).strip()


def _decoded(raw: bytes, name: str = "") -> Part:
    """Return a text of known encoding with plain line ends."""
    encoding = _encoding_of(raw)
    try:
        text = raw.decode(encoding)
    except UnicodeDecodeError:
        raise InputError(f"{_named(name)} is not a text file", way_out=_AS_TEXT) from None
    # Some programs fill up the end of a file, or mark it.
    text = text.lstrip("\ufeff").rstrip("\0\x1a\r\n")
    start = "".join(text[:4000].lower().split())
    for mark, what, way_out in _TEXT_KINDS:
        if start.startswith("<") and mark in start:
            raise InputError(what, way_out=way_out)
    if re.match(r"\{[\"}]|\[[\[{]", start):
        raise InputError(f"{_named(name)} is JSON, not a table", way_out=_EXPORT_CSV)
    text = text.replace("\r\n", "\n").replace("\r", "\n").replace("\f", "\n")
    _refuse_control_characters(text, name)
    return Part(name, text.encode() + b"\n", encoding)


def _refuse_control_characters(text: str, name: str) -> None:
    """Raise for characters that no text holds, with the line of the first if there are few."""
    found = re.search(_CONTROL, text)
    if found is None:
        return
    if len(re.findall(_CONTROL, text[:100_000])) > 0.01 * len(text[:100_000]):
        raise InputError(f"{_named(name)} is not a text file", way_out=_AS_TEXT)
    line = text.count("\n", 0, found.start()) + 1
    raise InputError(
        f"line {line} of {name or 'the file'} holds the control character {found[0]!r}",
        way_out="remove it, or export the data again",
    )


def _named(member: str) -> str:
    """Return the subject of a sentence about a member of an archive, or the file."""
    return f"its member '{member}'" if member else "it"


def _encoding_of(raw: bytes) -> str:
    """Return the encoding of a text: by its mark, its zero bytes, or by trial."""
    marks = (
        (codecs.BOM_UTF8, "utf-8-sig"),
        (codecs.BOM_UTF32_LE, "utf-32"),
        (codecs.BOM_UTF32_BE, "utf-32"),
        (codecs.BOM_UTF16_LE, "utf-16"),
        (codecs.BOM_UTF16_BE, "utf-16"),
    )
    for mark, encoding in marks:
        if raw.startswith(mark):
            return encoding
    # Of a table in two or four bytes a letter nearly all letters are below 256.
    head = raw[: len(raw) // 4 * 4][:4000]
    zeros = [sum(not byte for byte in head[k::4]) * 8 > len(head) for k in range(4)]
    wide = {
        (False, True, False, True): "utf-16-le",
        (True, False, True, False): "utf-16-be",
        (False, True, True, True): "utf-32-le",
        (True, True, True, False): "utf-32-be",
    }.get((zeros[0], zeros[1], zeros[2], zeros[3]))
    if wide is not None:
        return wide
    try:
        raw.decode("utf-8")
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8"
