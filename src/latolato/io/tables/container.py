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

from latolato.core.errors import Sentence, import_extra
from latolato.io.tables.cells import NUMBERS, kind_of, zeros
from latolato.io.tables.rules import broken, said

# Files, packed or unpacked, beyond this size are taken for mistakes [bytes].
LARGEST = 500_000_000
_MEGABYTES = LARGEST // 1_000_000
_CONTROL = "[\x00-\x08\x0e-\x1f]"
# How files begin that hold no table of text, and the rule that says what they are.
_SIGNATURES = {
    b"%PDF": "is_pdf",
    b"\x89PNG": "is_picture",
    b"\xff\xd8\xff": "is_picture",
    b"GIF8": "is_picture",
    b"\x89HDF": "is_hdf5",
    b"PAR1": "is_parquet",
    b"SQLite format 3": "is_database",
    b"CFWB": "is_labchart",
    b"7z\xbc\xaf": "is_7z",
    b"Rar!": "is_rar",
    b"BZh": "is_bzip2",
    b"\xfd7zXZ": "is_xz",
    b"\x28\xb5\x2f\xfd": "is_zstandard",
    b"MATLAB": "is_matlab",
    b"\x93NUMPY": "is_numpy",
    b"{\\rtf": "is_rtf",
}
# Where a tar archive says what it is.
_TAR = slice(257, 262)
# What begins the text of files that hold no table, in small letters, without blanks.
_TEXT_KINDS = {
    "opensourcephysics": "is_tracker",
    "<kinoveavideoanalysis": "is_kinovea",
    "<trackmate": "is_trackmate",
    "<!doctypehtml": "is_web_page",
    "<html": "is_web_page",
    "<phyphox": "is_phyphox",
    "<?xml": "is_xml",
}
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
        raise broken("empty_file")
    if raw[:2] == b"\x1f\x8b":
        return read_parts(name.removesuffix(".gz"), _gunzipped(raw))
    if raw[:4] == b"PK\x03\x04":
        return _parts_of_zip(raw)
    if raw[:8] == _OLD_OFFICE:
        return _sheets(raw)
    if raw[4:8] == b"ftyp" or raw[:4] == b"RIFF":
        raise broken("is_video")
    for start, rule in _SIGNATURES.items():
        if raw.startswith(start):
            raise broken(rule)
    if raw[_TAR] == b"ustar":
        raise broken("is_tar")
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
            raise broken("damaged_gzip", {"fault": str(error)}) from None
        if len(contents[-1]) > room:
            raise broken("large_gzip", {"size": _MEGABYTES})
        if not unpacker.eof:
            raise broken("short_gzip")
        raw = unpacker.unused_data
    return b"".join(contents)


def _parts_of_zip(raw: bytes) -> list[Part]:
    """Return the sheets of a spreadsheet, or the tables in an archive."""
    try:
        archive = zipfile.ZipFile(io.BytesIO(raw))
    except zipfile.BadZipFile as error:
        raise broken("damaged_zip", {"fault": str(error)}) from None
    with archive:
        members = {each.filename: each for each in archive.infolist() if not each.is_dir()}
        if any(each in members for each in _SHEETS_OF_ZIP):
            return _sheets(raw)
        if any(each.lower().endswith(".trk") for each in members):
            raise broken("is_tracker")
        tables = {
            each: info
            for each, info in members.items()
            if each.lower().endswith(_ENDINGS) and not each.startswith("__MACOSX/")
        }
        if not tables:
            raise broken("no_tables", {"names": ", ".join(list(members)[:5]) or said("nothing")})
        if sum(each.file_size for each in tables.values()) > LARGEST:
            raise broken("large_archive", {"size": _MEGABYTES})
        try:
            contents = {each: archive.read(info) for each, info in tables.items()}
        except (zipfile.BadZipFile, RuntimeError, NotImplementedError, zlib.error) as error:
            raise broken("unknown_zip", {"fault": str(error)}) from None
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
        raise broken("locked_sheets") from None
    except (calamine.CalamineError, OSError, ValueError) as error:
        raise broken("unknown_sheets", {"fault": str(error)}) from None
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
        raise broken("empty_sheets")
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
        raise broken("is_no_text", {"subject": _named(name)}) from None
    # Some programs fill up the end of a file, or mark it.
    text = text.lstrip("\ufeff").rstrip("\0\x1a\r\n")
    start = "".join(text[:4000].lower().split())
    for mark, rule in _TEXT_KINDS.items():
        if start.startswith("<") and mark in start:
            raise broken(rule)
    if re.match(r"\{[\"}]|\[[\[{]", start):
        raise broken("is_json", {"subject": _named(name)})
    text = text.replace("\r\n", "\n").replace("\r", "\n").replace("\f", "\n")
    _refuse_control_characters(text, name)
    return Part(name, text.encode() + b"\n", encoding)


def _refuse_control_characters(text: str, name: str) -> None:
    """Raise for characters that no text holds, with the line of the first if there are few."""
    found = re.search(_CONTROL, text)
    if found is None:
        return
    if len(re.findall(_CONTROL, text[:100_000])) > 0.01 * len(text[:100_000]):
        raise broken("is_no_text", {"subject": _named(name)})
    line = text.count("\n", 0, found.start()) + 1
    values = {"line": line, "name": name or said("the_file"), "character": repr(found[0])}
    raise broken("control_character", values)


def _named(member: str) -> Sentence:
    """Return the subject of a sentence about a member of an archive, or the file."""
    return said("member", name=member) if member else said("this_file")


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
