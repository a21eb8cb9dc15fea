"""Sentences about tables of other programs: what was recognised, notes and refusals.

The pages translate a sentence by its name, as those of `latolato.core.rules`.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from latolato.core.errors import Sentence
from latolato.core.rules import Rule, broken_rule, sentence

RULES = {
    # what was recognised
    "one_track": Rule("1 track: {names}"),
    "tracks": Rule("{count} tracks: {names}"),
    "sections": Rule("{count} sections: {names}"),
    "no_names": Rule("no names"),
    "and_more": Rule("{names} and {count} more"),
    "unit_of_name": Rule("its name"),
    "unit_of_kind": Rule("the kind of file ({kind})"),
    # notes
    "read_sheet": Rule("read '{name}', not {others}"),
    "row_of_none": Rule("1 row without {column} left out"),
    "rows_of_none": Rule("{count} rows without {column} left out"),
    "line_left_out": Rule("line {line} left out, which is no row: '{text}'"),
    "lines_left_out": Rule("line {line} and {count} more left out, which is no row: '{text}'"),
    "points_group": Rule("points group thousands, ',' is the decimal sign"),
    "commas_group": Rule("commas group thousands, '.' is the decimal sign"),
    # files without a table
    "large_file": Rule("it is larger than {size} MB", "cut it"),
    "empty_file": Rule("it is empty", "export the data again"),
    "is_video": Rule("it is a video, not a table", "use latolato track"),
    "is_pdf": Rule("it is a PDF document", "save its table as CSV"),
    "is_picture": Rule("it is a picture", "import the table that it shows as CSV"),
    "is_hdf5": Rule("it is an HDF5 or NetCDF file", "export its data as CSV"),
    "is_parquet": Rule("it is a Parquet file of another program", "export its data as CSV"),
    "is_database": Rule("it is a database", "export its data as CSV"),
    "is_labchart": Rule("it is a LabChart binary file", "in LabChart, save the data as text"),
    "is_7z": Rule("it is a 7z archive", "unpack it"),
    "is_rar": Rule("it is a RAR archive", "unpack it"),
    "is_bzip2": Rule("it is a bzip2 file", "unpack it"),
    "is_xz": Rule("it is an xz file", "unpack it"),
    "is_zstandard": Rule("it is a Zstandard file", "unpack it"),
    "is_tar": Rule("it is a tar archive", "unpack it"),
    "is_matlab": Rule("it is a MATLAB file", "in MATLAB, save its table with writetable"),
    "is_numpy": Rule("it is a NumPy array", "save it with numpy.savetxt"),
    "is_rtf": Rule("it is a text with formats (RTF)", "save it as plain text"),
    "is_tracker": Rule(
        "it is a Tracker project, not its data",
        "open it in Tracker and use File, Export, Data File",
    ),
    "is_kinovea": Rule(
        "it is a Kinovea analysis, not its data",
        "in Kinovea, export the measured data as CSV or text",
    ),
    "is_trackmate": Rule("it is a TrackMate file", "in TrackMate, export the spots as CSV"),
    "is_web_page": Rule("it is a web page", "save its table as CSV"),
    "is_phyphox": Rule("it is a phyphox experiment", "in phyphox, use Export Data, CSV"),
    "is_xml": Rule("it is an XML file", "export its data as CSV"),
    "is_json": Rule("{subject} is JSON, not a table", "export its data as CSV"),
    "is_no_text": Rule("{subject} is not a text file", "save the table as UTF-8 text"),
    "this_file": Rule("it"),
    "member": Rule("its member '{name}'"),
    "control_character": Rule(
        "line {line} of {name} holds the control character {character}",
        "remove it, or export the data again",
    ),
    "the_file": Rule("the file"),
    "damaged_gzip": Rule("it is a damaged gzip file ('{fault}')", "pack it again"),
    "large_gzip": Rule("it is a gzip file whose content is larger than {size} MB", "unpack it"),
    "short_gzip": Rule("it is a gzip file whose content is cut off", "unpack it"),
    "damaged_zip": Rule("it is a damaged zip file ('{fault}')", "pack it again"),
    "unknown_zip": Rule("it is a zip file that cannot be unpacked ('{fault}')", "unpack it"),
    "large_archive": Rule("it is an archive of more than {size} MB", "unpack it"),
    "no_tables": Rule("it is an archive without tables: {names}", "unpack it"),
    "nothing": Rule("nothing"),
    "locked_sheets": Rule("it is a spreadsheet with a password", "save it without"),
    "unknown_sheets": Rule(
        "it is a spreadsheet that cannot be read ('{fault}')", "save its sheet as CSV"
    ),
    "empty_sheets": Rule("it is a spreadsheet without cells", "export the data again"),
    # rows and cells
    "no_rows": Rule(
        "it has no rows of numbers: line {line} is '{text}'",
        "save the table as CSV: a line of names and rows of numbers below it",
    ),
    "single_quotes": Rule(
        "its numbers stand in single quotation marks", "remove them, or use double ones"
    ),
    "open_quote": Rule("the quotation mark in line {line} is not closed", "close it or remove it"),
    "spoiled_line": Rule(
        "a line that begins '{text}' cannot be divided into cells ('{fault}')",
        "look for a quotation mark that is not closed",
    ),
    "endless_line": Rule(
        "line {line} has more than {count} cells",
        "write each row of the table into a line of its own",
    ),
    "one_cell": Rule(
        "line {line} has 1 cell, but the other rows have {width}", "complete or remove that line"
    ),
    "wrong_width": Rule(
        "line {line} has {count} cells, but the other rows have {width}",
        "complete or remove that line",
    ),
    "commas_in_line": Rule(
        "complete or remove that line; if commas are decimal signs too, export it with semicolons "
        "or tabs"
    ),
    "other_keys": Rule(
        "line {line} has the names {names}, but the other rows have {others}",
        "complete or remove that line",
    ),
    "fewer_cells": Rule(
        "line {line} has {cells} cells below {names} names",
        "complete the rows, or remove names without a column",
    ),
    "blanks_in_names": Rule(
        "it has {names} names above {columns} columns that blanks separate",
        "write names without blanks, also one above row numbers, or export it with semicolons or "
        "tabs",
    ),
    "two_delimiters": Rule(
        "its rows could be separated by {one} or {other}: line {line} is '{text}'",
        "export it with semicolons or tabs",
    ),
    "comma_both": Rule(
        "the comma seems to be delimiter and {parameter} sign at once, or to group thousands: line "
        "{line} is '{text}' below {names}",
        "export it with semicolons or tabs, or with decimal points; if its numbers are whole, give "
        "{@decimal} '.'",
    ),
    "names_above": Rule("{count} names"),
    # numbers
    "two_decimal_signs": Rule(
        "its numbers have two decimal signs: {one} and {other}",
        "write all numbers with the same sign",
    ),
    "points_or_groups": Rule(
        "its points may be {parameter} signs or group thousands: {cell}",
        "give the decimal sign: {@decimal} '.' or ','",
    ),
    "commas_or_groups": Rule(
        "its commas may be {parameter} signs or group thousands: {cell}",
        "give the decimal sign: {@decimal} '.' or ','",
    ),
    "cell_at": Rule("'{cell}' in line {line}, column {column}"),
    "no_number": Rule(
        "line {line} of column {column} holds {cell}, which is no number",
        "leave the cell empty if the number is missing",
    ),
    "plain_seconds": Rule("export the time in seconds or milliseconds"),
    "unit_in_name": Rule("write the unit into the column's name"),
    "column_of_numbers": Rule("name a column of numbers"),
    "column_of_texts": Rule(
        "column {column} holds texts such as {cell} in line {line}",
        "write plain numbers such as -0.25, or name another column",
    ),
    "no_clock": Rule(
        "line {line} holds '{cell}', which is no time such as 0:03.25 or 09:13:03.25",
        "export the time in seconds or milliseconds",
    ),
    "frames_or_hundredths": Rule(
        "the last part of '{cell}' may count frames or hundredths of a second",
        "export the time in seconds or milliseconds",
    ),
    "rate_of_clock": Rule("give {@frame_rate} in 1/s"),
    # columns, sections and objects
    "stated_unit": Rule(
        "column {column} is in [{unit}] itself, not in [{other}]",
        "write [{unit}], or change the file",
    ),
    "alike_columns": Rule("it has {count} columns '{name}'", "name one by its position ({places})"),
    "position_or_track": Rule("name one by its position ({places}) or its track, as in '{path}'"),
    "no_such_column": Rule("it has no column '{name}'; it has {names}"),
    "unnamed_columns": Rule(
        "it has no column '{name}', for it has no names above its columns ({count})",
        "name columns by position, as in '1 [s]'",
    ),
    "several_tables": Rule(
        "it holds {count} tables: {names}", "choose one with {@section}, as in '{first}'"
    ),
    "no_section": Rule("it has no section '{name}'"),
    "many_objects": Rule(
        "column {column} names more than {count} objects", "keep the rows of one or two"
    ),
    "no_common_time": Rule(
        "it holds {count} objects below each other without a time",
        "add a column of times or of frame numbers",
    ),
    "second_row": Rule("{name} has a second row for {time} in line {line}", "remove one of them"),
}

broken = partial(broken_rule, table=RULES)


def said(rule: str, /, **values: Any) -> Sentence:
    """The sentence of a rule."""
    return sentence(rule, RULES, **values)
