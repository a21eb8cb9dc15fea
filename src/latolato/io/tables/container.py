"""From the bytes of a file to texts: archives, spreadsheets, encodings."""

from __future__ import annotations

import codecs
import io
import re
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import PurePosixPath
from typing import Any

from latolato.core.errors import InputError, import_extra

# Files, packed or unpacked, beyond this size are taken for mistakes [bytes].
LARGEST = 500_000_000
_EXPORT_CSV = "export its data as CSV"
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
)
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
    is_sheet : bool
        Whether it is a sheet, whose cells are separated by tabs here and have decimal points.
    """

    name: str
    text: bytes
    encoding: str
    is_sheet: bool = False


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
    return [_decoded(raw)]


def _gunzipped(raw: bytes) -> bytes:
    """Return the content of a gzip file."""
    unpacker = zlib.decompressobj(zlib.MAX_WBITS | 16)
    try:
        content = unpacker.decompress(raw, LARGEST + 1)
    except zlib.error as error:
        raise InputError(f"it is a damaged gzip file ({error})", way_out="pack it again") from None
    if len(content) > LARGEST or not unpacker.eof:
        cause = f"larger than {LARGEST // 1_000_000} MB" if len(content) > LARGEST else "cut off"
        raise InputError(f"it is a gzip file whose content is {cause}", way_out="unpack it")
    return content


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
        lines = ["\t".join(_cell_text(cell) for cell in row) for row in rows]
        if any(line.strip() for line in lines):
            parts.append(Part(name, ("\n".join(lines) + "\n").encode(), "spreadsheet", True))
    if not parts:
        raise InputError("it is a spreadsheet without cells", way_out="export the data again")
    return parts


def _cell_text(cell: Any) -> str:
    """Return a cell of a spreadsheet as text; a number keeps every digit."""
    if isinstance(cell, float):
        return str(int(cell)) if cell.is_integer() and abs(cell) < 1e15 else repr(cell)
    return re.sub(r"[\x00-\x1f\"]+", " ", str(cell)).strip()


def _decoded(raw: bytes, name: str = "") -> Part:
    """Return a text of known encoding with plain line ends."""
    encoding = _encoding_of(raw)
    try:
        text = raw.decode(encoding)
    except UnicodeDecodeError:
        raise InputError(
            f"{_named(name)} is not a text file", way_out="save the table as UTF-8 text"
        ) from None
    start = "".join(text[:4000].lower().split())
    for mark, what, way_out in _TEXT_KINDS:
        if start.startswith("<") and mark in start:
            raise InputError(what, way_out=way_out)
    if re.match(r"\{[\"}]|\[[\[{]", start):
        raise InputError(f"{_named(name)} is JSON, not a table", way_out=_EXPORT_CSV)
    if re.search("[\x00-\x08\x0e-\x1f]", text):
        raise InputError(
            f"{_named(name)} is not a text file", way_out="save the table as UTF-8 text"
        )
    text = text.replace("\r\n", "\n").replace("\r", "\n").replace("\f", "\n")
    return Part(name, text.rstrip("\n").encode() + b"\n", encoding)


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
