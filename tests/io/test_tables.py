"""Exports of the programs of a laboratory are recognised and read, or refused with the cause."""

import gzip
import io
import json
import zipfile

import numpy as np
import pytest

from latolato.core.errors import InputError
from latolato.io.tables.source import parse_source
from spreadsheets import workbook, zipped

TRACKER = "\tpendulum A\t\t\nt\tx\ty\t\n0.000\t1.25E-1\t-3.41E-1\n0.033\t1.19E-1\t-3.43E-1\n"
TWO_TRACKS = (
    "#multi:\n\tright ball\t\tleft ball\t\t\t\nt\tx\ty\tx\ty\t\n"
    "0.000\t12.5\t-34.1\t-11.0\t-33.9\n0.033\t11.9\t-34.3\t-11.4\t-33.7\n"
)
OLD_TRACKER = "cm_A\nt\tx\ty\n0.000000000E0\t1.25E1\t-3.41E1\n3.3E-2\t1.19E1\t-3.43E1\n"
COMMA_TRACKER = ",mass A,,,\nt,frame,x,y,\n0.0E0,1.2E2,-3.5E0,4.1E0,\n3.3E-2,1.21E2,-3.4E0,4.2E0,\n"
VERNIER = (
    "Vernier Format 2\nswing.cmbl 3/10/2026 12:13:14 .\nRun 1\nTime\tAngle\nT\tθ\ns\trad\n\n"
    "0\t0.40\n0.05\t0.38\n"
)
VERNIER_CSV = "Latest: Time (s),Latest: Angle (rad)\n0,0.4\n0.05,0.38\n"
DATA_SETS = (
    "Data Set 1:Time(s),Data Set 1:Angle(rad),Data Set 2:Time(s),Data Set 2:Angle(rad)\n"
    "0,0.4,0,0.3\n0.05,0.38,0.05,0.29\n0.1,0.35,,\n"
)
LABCHART = (
    "Interval=\t0.01 s\nExcelDateTime=\t4.63E+04\t3/10/26 11:08:37.48\nTimeFormat=\tStartOfBlock\n"
    "DateFormat=\t\nChannelTitle=\tAngle\tPivot\nRange=\t10.000 V\t10.000 V\nUnitName=\tdeg\tmm\n"
    "{0}\t22.9\t0.1\n{0}.01\t22.8\t0.2\t#* released\n"
)
CAPSTONE = (
    '"Time (s) Run #1","Angle (rad) Run #1","Time (s) Run #2","Angle (rad) Run #2"\n'
    "0.000,0.400,0.000,0.380\n0.050,0.390,0.050,0.370\n,,0.100,0.350\n"
)
TRACKMATE = (
    "LABEL,ID,TRACK_ID,POSITION_X,POSITION_Y,POSITION_T,FRAME\n"
    "Label,Spot ID,Track ID,X,Y,T,Frame\nLabel,Spot ID,Track ID,X,Y,T,Frame\n"
    ",,,(micron),(micron),(sec),\nID1,1,0,11.5,21.0,0.0,0\nID2,2,0,11.9,20.5,0.04,1\n"
)
KINOVEA = (
    "#Kinovea Trajectory data export\n#T X Y\n\n# Trajectory 1\n"
    "0 866.00 320.00\n33.4 847.00 321.00\n"
    "\n# My left ball\n0 412.00 318.00\n33.4 431.00 319.00\n"
)
PHYPHOX = (
    '"Time (s)","Gyroscope x (rad/s)","Gyroscope y (rad/s)"\n'
    "4.9E-3,-2.16E-1,1.0E-2\n1.5E-2,-2.10E-1,NaN\n"
)
ANDROSENSOR = (
    "SATELLITES,TIME SINCE START (ms),DATE (YYYY-MO-DD HH-MI-SS_SSS),GYROSCOPE X (rad/s)\n"
    "18 / 19,5,2026-10-03 09:13:29:506,0.25\n18 / 19,15,2026-10-03 09:13:29:516,0.26\n"
)
SENSOR_LOGGER = "time,seconds_elapsed,z,y,x\n1718030736872695300,0.0707,-0.32,0.15,0.67\n"


def source(text, encoding="utf-8", **options):
    return parse_source(text.encode(encoding), **options)


def numbers(section):
    columns = [column for column in section.columns if column.kind == "numbers"]
    values, _ = section.numbers(columns)
    return {column.path: each.tolist() for column, each in zip(columns, values, strict=True)}


@pytest.mark.parametrize(
    "text, about, columns",
    [
        (
            TRACKER,
            "Tracker export, 1 track: pendulum A",
            "t [s], pendulum A/x [m], pendulum A/y [m]",
        ),
        (
            TWO_TRACKS,
            "Tracker export, 2 tracks: right ball, left ball",
            "t [s], right ball/x [m], right ball/y [m], left ball/x [m], left ball/y [m]",
        ),
        (OLD_TRACKER, "Tracker export, 1 track: cm_A", "t [s], cm_A/x [m], cm_A/y [m]"),
        (
            COMMA_TRACKER,
            "Tracker export, 1 track: mass A",
            "t [s], frame, mass A/x [m], mass A/y [m]",
        ),
        (VERNIER, "Vernier text", "Time [s], Angle [rad]"),
        (VERNIER_CSV, "Vernier table, 1 track: Latest", "Latest/Time [s], Latest/Angle [rad]"),
        (
            DATA_SETS,
            "Vernier table, 2 tracks: Data Set 1, Data Set 2",
            "Data Set 1/Time [s], Data Set 1/Angle [rad], Data Set 2/Time [s], "
            "Data Set 2/Angle [rad]",
        ),
        (LABCHART.format(43), "LabChart export", "Time [s], Angle [deg], Pivot [mm]"),
        (
            CAPSTONE,
            "Capstone export, 2 tracks: Run #1, Run #2",
            "Run #1/Time [s], Run #1/Angle [rad], Run #2/Time [s], Run #2/Angle [rad]",
        ),
        (
            TRACKMATE,
            "TrackMate export",
            "LABEL, ID, TRACK_ID, POSITION_X [um], POSITION_Y [um], POSITION_T [s], FRAME",
        ),
        (PHYPHOX, "phyphox export", "Time [s], Gyroscope x [rad/s], Gyroscope y [rad/s]"),
        (
            ANDROSENSOR,
            "AndroSensor recording",
            "SATELLITES, TIME SINCE START [ms], DATE (YYYY-MO-DD HH-MI-SS_SSS), "
            "GYROSCOPE X [rad/s]",
        ),
        (SENSOR_LOGGER, "Sensor Logger recording", "time [ns], seconds_elapsed [s], z, y, x"),
    ],
)
def test_exports_are_recognised_with_their_columns_and_units(text, about, columns):
    found = source(text)
    assert found.about == about
    (section,) = found.sections
    shown = [c.path + (f" [{c.unit}]" if c.unit else "") for c in section.columns]
    assert ", ".join(shown) == columns


def test_numbers_of_exports_are_those_in_the_file():
    assert numbers(source(TWO_TRACKS).section()) == {
        "t": [0.0, 0.033],
        "right ball/x": [12.5, 11.9],
        "right ball/y": [-34.1, -34.3],
        "left ball/x": [-11.0, -11.4],
        "left ball/y": [-33.9, -33.7],
    }
    assert numbers(source(VERNIER).section()) == {"Time": [0.0, 0.05], "Angle": [0.4, 0.38]}
    assert numbers(source(TRACKMATE).section())["POSITION_X"] == [11.5, 11.9]
    assert numbers(source(LABCHART.format(43)).section())["Pivot"] == [0.1, 0.2]
    runs = numbers(source(CAPSTONE).section())
    np.testing.assert_array_equal(runs["Run #1/Angle"], [0.4, 0.39, np.nan])
    assert runs["Run #2/Angle"] == [0.38, 0.37, 0.35]


def test_names_of_several_header_lines_are_all_known():
    section = source(TRACKMATE).section()
    for name in ("POSITION_X", "X", "X [um]", "4", "4 [um]"):
        column, unit = section.column(name)
        assert (column.position, unit) == (4, "um")
    section = source(VERNIER).section()
    assert section.column("θ")[0] is section.column("Angle (rad)")[0]


def test_sections_below_each_other_keep_titles_columns_and_lines():
    later = KINOVEA.replace("0 412", "99 412").replace("33.4 431", "120.5 431")
    found = source(later)
    assert found.about == "Kinovea export, 2 sections: Trajectory 1, My left ball"
    assert [section.lines.tolist() for section in found.sections] == [[5, 6], [9, 10]]
    assert numbers(found.section("My left ball")) == {
        "T": [99.0, 120.5],
        "X": [412.0, 431.0],
        "Y": [318.0, 319.0],
    }
    with pytest.raises(InputError, match=r"holds 2 tables: Trajectory 1, My left ball; choose one"):
        found.section()
    blocks = source(LABCHART.format(43) + LABCHART.format(88))
    assert [numbers(section)["Time"] for section in blocks.sections] == [
        [43.0, 43.01],
        [88.0, 88.01],
    ]


def test_objects_filmed_together_stand_side_by_side():
    found = source(KINOVEA.replace("33.4 431", "66.7 431"))
    assert found.about == "Kinovea export, 2 tracks: Trajectory 1, My left ball"
    assert found.delimiter == "blanks"
    nan = np.nan
    expected = {
        "T": [0.0, 33.4, 66.7],
        "Trajectory 1/X": [866.0, 847.0, nan],
        "Trajectory 1/Y": [320.0, 321.0, nan],
        "My left ball/X": [412.0, nan, 431.0],
        "My left ball/Y": [318.0, nan, 319.0],
    }
    for name, values in numbers(found.section()).items():
        np.testing.assert_array_equal(values, expected.pop(name))
    assert not expected
    assert found.section().lines.tolist() == [5, 6, 10]
    head, spots = TRACKMATE.rsplit("ID1", 1)
    others = "ID9,9,3,1.5,2.0,0.0,0\nID8,8,3,1.25,2.5,0.04,1\n"
    found = source(f"{head}ID1{spots}{others}")
    assert found.section().tracks == ["track 0", "track 3"]
    assert numbers(found.section())["track 3/POSITION_X"] == [1.5, 1.25]
    # Also if one begins where the other ends; a spot of no track is left out.
    found = source(f"{head}ID1{spots}{others.replace('0.0,0', '0.5,0').replace('3,1.25', ',1.25')}")
    assert numbers(found.section())["track 3/POSITION_X"][-1] == 1.5
    assert found.notes == ("1 row without 'TRACK_ID' left out",)
    with pytest.raises(InputError, match=r"track 3 has a second row for 0\.04 in line 9"):
        source(f"{head}ID1{spots}{others}ID7,7,3,1.5,2.5,0.04,1\n")


@pytest.mark.parametrize(
    "head, delimiter",
    [
        ("# t theta\n", " "),
        ("# t, theta\n", " "),
        ("#t\ttheta\n", " "),
        ("% t [s] theta [rad]\n", " "),
        ("Time (s)   Angle (rad)\n", "   "),
        ("t;theta;\n", ";"),
        ("t,theta,,\n", ","),
        ("sep=;\nt;theta\n", ";"),
        ('"Time\n(s)","Angle\n(rad)"\n', ","),
        ("swing of Monday\n\nt | theta\n", "|"),
        ("t,theta\n# measured twice\n", ","),
        ("      t     theta\n    ____   ______\n\n", "   "),
    ],
)
def test_names_are_found_above_the_numbers(head, delimiter):
    rows = [["0.00", "0.41"], ["0.05", "0.39"]]
    section = source(head + "\n".join(map(delimiter.join, rows))).section()
    assert [column.name.lower() in ("t", "time") for column in section.columns] == [True, False]
    assert list(numbers(section).values()) == [[0.0, 0.05], [0.41, 0.39]]


def test_a_column_that_numbers_the_rows_needs_no_name():
    section = source(",t,x\n0,0.0,0.5\n1,0.1,0.4\n").section()
    assert numbers(section) == {"1": [0, 1], "t": [0.0, 0.1], "x": [0.5, 0.4]}


def test_columns_that_hold_nothing_need_no_name():
    section = source("t;;x;y\n0,5;;1;2\n0,6;;3;4\n").section()
    assert numbers(section) == {"t": [0.5, 0.6], "x": [1, 3], "y": [2, 4]}
    section = source("t;;x;y\n0,5;7;1;2\n0,6;8;3;4\n").section()
    assert numbers(section)["x"] == [1, 3]


def test_an_index_of_rows_is_no_track_of_tracker():
    found = source(",t,x\n0,0.5,200\n1,0.6,300\n")
    assert found.kind == "table"
    assert [column.unit for column in found.section().columns] == ["", "", ""]


def test_comments_about_the_file_are_no_names():
    text = "# Created by Octave 8.4.0, Mon Oct 05 2026\n# type: matrix\n# rows: 2\n 0.5 1\n 0.6 2\n"
    assert source(text).about == "table, no names"


def test_labchart_headers_need_no_units_to_be_headers():
    text = "Interval=\t0.01 s\nChannelTitle=\tAngle\nRange=\t10.000 V\n0\t22.5\n0.01\t21.5\n"
    assert numbers(source(text).section()) == {"Time": [0.0, 0.01], "Angle": [22.5, 21.5]}


def test_a_table_drawn_with_bars_is_read():
    text = "| t (s) | x (m) |\n|-------|:-----:|\n| 0.0 | 0.5 |\n| 0.1 | 0.4 |\n"
    assert numbers(source(text).section()) == {"t": [0.0, 0.1], "x": [0.5, 0.4]}


def test_blank_lines_between_rows_part_no_table_whose_first_column_swings():
    x = np.round(np.cos(np.arange(30) / 3.0), 3)
    text = "x,t\n" + "".join(f"{each},{i / 25}\n\n" for i, each in enumerate(x))
    assert numbers(source(text).section())["x"] == x.tolist()


def test_comments_and_other_lines_between_and_below_rows_are_no_rows():
    text = "t,x\n0,0.5\n# released\n1,0.6\n\n2,0.7\n# stopped\nend of the data\n"
    found = source(text)
    assert found.notes == ("line 8 left out, which is no row: 'end of the data'",)
    assert found.section().lines.tolist() == [2, 4, 6]
    assert numbers(found.section()) == {"t": [0.0, 1.0, 2.0], "x": [0.5, 0.6, 0.7]}


@pytest.mark.parametrize(
    "text, values",
    [
        ("t;x\n0,1;\u22120,0548\n0,2;\u22125,1\n", {"t": [0.1, 0.2], "x": [-0.0548, -5.1]}),
        ('t,x\n"0,799","0,41"\n"0,832", "0,40"\n', {"t": [0.799, 0.832], "x": [0.41, 0.40]}),
        ("t;x\n1.234,5;0,3\n2.234,5;0,4\n", {"t": [1234.5, 2234.5], "x": [0.3, 0.4]}),
        ("t;x\n1 234,5;0,3\n2 234,5;0,4\n", {"t": [1234.5, 2234.5], "x": [0.3, 0.4]}),
        ("t;x\n1\u202f234,5;0,3\n2\u00a0234,5;0,4\n", {"t": [1234.5, 2234.5], "x": [0.3, 0.4]}),
        ("t;x\n1'234.5;0.3\n2'234.5;0.4\n", {"t": [1234.5, 2234.5], "x": [0.3, 0.4]}),
        ('t,x\n"1,234.5",0.3\n"2,234.5",0.4\n', {"t": [1234.5, 2234.5], "x": [0.3, 0.4]}),
        ("t;x\n966;0,41\n999;0,4\n1.033;0,39\n", {"t": [966, 999, 1033], "x": [0.41, 0.4, 0.39]}),
        ("t\tx\n432\t0.25\n432.001\t0.5\n", {"t": [432.0, 432.001], "x": [0.25, 0.5]}),
        ("t x\n0 866 \n33 847\n100 200\n", {"t": [0, 33, 100], "x": [866, 847, 200]}),
        ("t;x\n0.1;\n;0.2\n0.3;#N/A\n", {"t": [0.1, np.nan, 0.3], "x": [np.nan, 0.2, np.nan]}),
        ("t,x\n0.1\u00a0,\u00a00.25\n0.2,0.5\u2009\n", {"t": [0.1, 0.2], "x": [0.25, 0.5]}),
        ("t1=12,x=0.5\nt1=13,x=-0.25\n", {"t1": [12, 13], "x": [0.5, -0.25]}),
        ("ready\nt: 0.5 x: 1\n# t: 2 x: 3\nt: 0.6 x: 2\n", {"t": [0.5, 0.6], "x": [1, 2]}),
        ("t x\n0.1\u00a0234\n0.2\u00a0235\n", {"t": [0.1, 0.2], "x": [234, 235]}),
        ("\ufeff\ufefft,x\n0.1,2\n0.2,3\n\0\0\x1a", {"t": [0.1, 0.2], "x": [2, 3]}),
    ],
)  # fmt: skip
def test_numbers_are_read_as_written(text, values):
    found = numbers(source(text).section())
    assert found.keys() == values.keys()
    for name, expected in values.items():
        np.testing.assert_array_equal(found[name], expected)


@pytest.mark.parametrize(
    "text, said",
    [
        (
            "t,x,\n0,22,93\n33,22,58\n67,21,44\n",
            "delimiter and decimal sign at once.* line 2",
        ),
        ("t,x\n0,000,0,41\n0,033,0,40\n", r"line 2 is '0,000,0,41' below 2 names"),
        ("t,x\n0,033,0,41\n0,067,1\n0,100,0,39\n", "if commas are decimal signs too"),
        ("0,1\n1,2\n", "delimiter and decimal sign at once"),
        ("0.5,1,000\n0.6,1,033\n", "or to group thousands: line 1 is '0.5,1,000'"),
        (
            "t;x\n1.000;0,4000\n1.033;0,3942\n",
            "line 2, column 't'; give the decimal sign",
        ),
        ("t;x\n1,234;5,678\n2,345;6,789\n", "commas may be decimal signs or group thousands"),
        ("t\tx\n1.234\t5.678\n", "points may be decimal signs or group thousands"),
        (
            "t;x\n999;0.41\n1.000;0.40\n",
            "or group thousands: '1.000' in line 3",
        ),
        ("t;x\n0,5;0.41\n0,6;0.40\n", "two decimal signs: '0.41' in line 2.*'0,5' in line 2"),
        ("0,-1 000\n\n0,0\n", None),
        ("particle,x\n0,0.5\n1,0.6\n", "holds 2 objects below each other without a time"),
        ("0.50,1,000.000\n1,000.50,0.000\n", "or to group thousands"),
        ("t,x\n5,1 000\n6,1 010\n", "could be separated by blanks or commas"),
        ("t;x\n0.5;0.3\nlost;0.4\n", r"line 3 of column 't' holds 'lost'"),
        ("t;x\n0.5;0.3\n0.39_1;0.4\n", r"line 3 of column 't' holds '0.39_1'"),
        ("t;x\n0.5 s;0.3\n0.6 s;0.4\n", "write the unit into the column's name"),
        ("t;x\n0.5;0.3\n\u200b0.6;0.4\n", r"line 3 of column 't' holds '.u200b0.6'"),
        ("t;x\n0.5;\u20130.3\n0.6;\u20130.4\n", "texts such as '\u20130.3' in line 2"),
        ("t;x\n1;0.5\n2;0.6\nstopped\n3\n4;0.7\n", "line 5 has 1 cell, but"),
        ("t;x\n1;0.5\n2;a;0.6\n4;0.7\n", "line 3 has 3 cells, but"),
        ("0.5,0.000,\n0.6,0.000,\n0.7,1,000.000,\n1,000.5,0.000,\n", "or to group thousands"),
        ("t,x\n0.5,1\n0.6,\x002\n" + "0.7,3\n" * 50, "line 3 of the file holds the control"),
        ("t=1,x=2\nt=2,x=3\nx=4,t=3\n", "line 3 has the names x, t, but the other rows have t, x"),
        ("t=1,x1=2,x2=3\nt=2,x2=3,x1=4\n", "line 2 has the names t, x2, x1, but"),
        ("t=1,x=2\nt=2,x=3\nt=3\n", "line 3 has the names t, but the other rows have t, x"),
        ("0," * 200_001, "line 1 has more than 200000 cells"),
        ("f(0.5);f(1)\n", r"no rows of numbers: line 1 is 'f\(0.5\);f\(1\)'"),
        ("t;x\n0:00:00:03;0.3\n0:00:00:06;0.4\n", None),
        ("t;x\n0.5;0.3\n0.6\n", "line 3 has 1 cell, but the other rows have 2"),
        ("0.1;0.2\n0.5;0.3;0.4\n0.6;0.3;0.4\n", "line 1 has 2 cells, but the other rows have 3"),
        ("t,x,y\n0.5,0.3\n", "line 2 has 2 cells below 3 names"),
        ("t;x\nmean;0.5\n0.5;0.3\n0.6;0.3\n", r"line 2 of column 't' holds 'mean'"),
        ('"swing of 3 October\n' + "t,x\n" + "0.1,0.2\n" * 50, "mark in line 1 is not closed"),
        ("", "is empty"),
        ("t,x\n", "no rows of numbers"),
        ("'t','x'\n'0.1','5'\n", "single quotation marks"),
    ],
)
def test_what_could_be_read_in_two_ways_or_not_at_all_is_refused(text, said):
    try:
        section = source(text).section()
        columns = list(section.columns)
        section.numbers(columns)
    except InputError as error:
        caught = error
    assert "\n" not in str(caught)
    assert caught.way_out
    if said is not None:
        with pytest.raises(InputError, match=said):
            raise caught


def test_the_decimal_sign_can_be_given_where_the_file_leaves_it_open():
    text = "t;x\n1.000;4\n1.033;3\n"
    for decimal, expected in ((".", [1.0, 1.033]), (",", [1000.0, 1033.0])):
        section = source(text).section()
        (values,), notes = section.numbers([section.columns[0]], decimal=decimal)
        assert values.tolist() == expected
        assert bool(notes) == (decimal == ",")
    assert numbers(source("0,1\n1,2\n", decimal=".").section()) == {"1": [0, 1], "2": [1, 2]}


def test_columns_that_nobody_asked_for_may_hold_anything():
    text = "t,when,x\n0.5,2026-10-03 09:13:29,0.3\n0.6,-,0.4\n"
    section = source(text).section()
    assert [column.kind for column in section.columns] == ["numbers", "texts", "numbers"]
    (values,), _ = section.numbers([section.column("x")[0]])
    assert values.tolist() == [0.3, 0.4]
    with pytest.raises(InputError, match="'when' holds texts such as '2026-10-03 09:13:29'"):
        section.numbers([section.column("when")[0]])


def test_a_column_is_named_by_name_track_or_position():
    section = source(TWO_TRACKS).section()
    assert section.column("left ball/x")[0].position == 4
    assert section.column("4 [cm]")[1] == "cm"
    with pytest.raises(
        InputError, match=r"2 columns 'x'; name one by its position \(2, 4\) or its track"
    ):
        section.column("x")
    with pytest.raises(InputError, match="no column 'z'; it has t, right ball/x"):
        section.column("z")
    section = source("theta [deg];theta (rad)\n1;0.5\n2;0.6\n").section()
    assert section.column("theta (deg)")[0].position == 1
    assert section.column("theta [rad]")[0].position == 2
    with pytest.raises(InputError, match="2 columns 'theta'"):
        section.column("theta")
    section = source("theta (x axis) (Deg);t (S)\n1;0.5\n2;0.6\n").section()
    assert section.column("theta (x axis)")[1] == "deg"
    assert section.column("T")[1] == "s"
    with pytest.raises(InputError, match=r"is in \[deg\] itself, not in \[rad\]"):
        section.column("theta (x axis) [rad]")


def test_a_unit_that_nobody_knows_does_not_contradict_one_that_is_given():
    section = source("t (s);Winkel (Grad);U (V)\n1;5;0.5\n2;6;0.6\n").section()
    assert section.column("Winkel")[1] == "Grad"
    assert section.column("Winkel [deg]")[1] == "deg"
    with pytest.raises(InputError, match=r"is in \[V\] itself, not in \[deg\]"):
        section.column("U [deg]")


@pytest.mark.parametrize(
    "heading, name, unit, stated",
    [
        ("t/s", "t", "s", True),
        ("θ / º", "θ", "deg", True),
        ("t_s", "t", "s", False),
        ("t in ms", "t", "ms", False),
        ("theta (gon)", "theta", "gon", True),
        ("x [Pixels]", "x", "px", True),
        ("x (km/h)", "x", "km/h", True),
        ("theta (x axis)", "theta (x axis)", "", True),
    ],
)
def test_units_inside_names_are_found(heading, name, unit, stated):
    column = source(f"{heading};u\n1.5;2\n1.6;3\n").section().columns[0]
    assert (column.name, column.unit, not column.unit_from) == (name, unit, stated)


@pytest.mark.parametrize(
    "encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "cp1252"]
)
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_encodings_and_line_ends_are_found(encoding, end):
    text = end.join(["Zeit (s);Auslenkung (°)", "0,05;12,5", "0,10;11,5", ""])
    section = source(text, encoding).section()
    assert numbers(section) == {"Zeit": [0.05, 0.1], "Auslenkung": [12.5, 11.5]}
    assert section.columns[1].unit == "deg"


def test_archives_are_opened():
    first, second = PHYPHOX[:80], PHYPHOX[80:]
    raw = gzip.compress(first.encode()) + gzip.compress(second.encode())
    found = parse_source(raw, "swing.csv.gz")
    assert numbers(found.section())["Time"] == [4.9e-3, 1.5e-2]
    raw = zipped(
        **{"Raw Data.csv": PHYPHOX, "Range.csv": "a,b\n1.5,2\n", "meta__time.csv": "x\n1\n"}
    )
    found = parse_source(raw, "phyphox.zip")
    assert found.notes == ("read 'Raw Data.csv', not Range.csv",)
    assert numbers(found.section())["Time"] == [4.9e-3, 1.5e-2]
    found = parse_source(zipped(**{"a.csv": PHYPHOX, "b.csv": PHYPHOX}))
    assert [section.name for section in found.sections] == ["a.csv", "b.csv"]


@pytest.mark.parametrize(
    "raw, said",
    [
        (
            b'<?xml version="1.0"?>\n<object class="org.opensourcephysics.tracker">',
            "Tracker project.*File, Export",
        ),
        (zipped(**{"swing.trk": "<object>"}), "Tracker project.*File, Export"),
        (b"<KinoveaVideoAnalysis>", "Kinovea analysis"),
        (b"<html><table>", "web page"),
        (b'{"t": [0, 1]}', "JSON"),
        (b"%PDF-1.7", "PDF"),
        (b"\x89HDF\r\n", "HDF5"),
        (b"BZh91AY", "bzip2"),
        (b"swing.csv" + bytes(248) + b"ustar", "tar archive"),
        (b"\0\0\0\x18ftypmp42", "video"),
        (gzip.compress(b"t,x\n0.1,2\n", mtime=0)[:-9], "cut off"),
        (zipped(**{"a.png": "x"}), "archive without tables: a.png"),
        (bytes(range(256)) * 8, "is not a text file"),
        (b"PK\x03\x04 broken", "damaged zip"),
    ],
    ids=lambda each: each if isinstance(each, str) else "raw",  # an archive holds the hour
)
def test_files_without_a_table_are_named_with_the_way_out(raw, said):
    with pytest.raises(InputError, match=said) as caught:
        parse_source(raw)
    assert caught.value.way_out


def test_sheets_of_a_spreadsheet_are_tables():
    pytest.importorskip("python_calamine", reason="needs the extra 'tables'")
    rows = [["Time (s)", "Angle (deg)"], [0.0, 12.125], [0.1 + 0.2, 1234.0]]
    raw = workbook(**{"Raw Data": rows, "Metadata": [["version", "1.1"], ["phone", "mine"]]})
    found = parse_source(raw, "swing.xlsx")
    assert numbers(found.section()) == {"Time": [0.0, 0.1 + 0.2], "Angle": [12.125, 1234.0]}
    assert found.section().lines.tolist() == [2, 3]
    # Numbers written as texts have the sign that they are written with.
    texts = [["t", "x"], ["0,25", 1.5], ["0,50", 2.5e-7]]
    found = numbers(parse_source(workbook(Sheet1=texts)).section())
    assert found == {"t": [0.25, 0.5], "x": [1.5, 2.5e-7]}
    (section,) = parse_source(
        workbook(Sheet1=[["t", "x"], ["1.000", 1.5], ["1.040", 2.5]])
    ).sections
    with pytest.raises(InputError, match=r"points may be decimal signs .*: '1\.000' in line 2"):
        section.numbers(section.columns)
    # Numbers of a sheet have no decimal sign that could be in doubt.
    whole = parse_source(workbook(Sheet1=[["t", "x"], [1.125, 2.25], [1.126, 5.125]]))
    assert numbers(whole.section())["t"] == [1.125, 1.126]


def test_a_spreadsheet_of_libreoffice_is_read():
    pytest.importorskip("python_calamine", reason="needs the extra 'tables'")

    def number(value, shown, kind="float"):
        return (
            f'<table:table-cell office:value-type="{kind}" office:value="{value}">'
            f"<text:p>{shown}</text:p></table:table-cell>"
        )

    def text(shown, more=""):
        return (
            f'<table:table-cell office:value-type="string" {more}><text:p>{shown}</text:p>'
            "</table:table-cell>"
        )

    empty = "<table:table-cell/>"
    head = text("Pendel", 'table:number-columns-spanned="2"') + "<table:covered-table-cell/>"
    rows = [
        empty, head, text("Zeit (s)") + text("Winkel (°)"),
        number(0, "0,00") + number(12.125, "12,1"),
        number(0.04, "0,04") + number(-1234.5, "-1.234,5"),
        number(0.08, "0,08") + number(0.5, "50 %", "percentage"),
        '<table:table-cell table:number-columns-repeated="900"/>',
    ]  # fmt: skip
    names = "urn:oasis:names:tc:opendocument:xmlns"
    body = "".join(f"<table:table-row>{row}</table:table-row>" for row in rows)
    content = (
        f'<office:document-content xmlns:office="{names}:office:1.0" '
        f'xmlns:table="{names}:table:1.0" xmlns:text="{names}:text:1.0"><office:body>'
        f'<office:spreadsheet><table:table table:name="Tabelle1">{body}</table:table>'
        "</office:spreadsheet></office:body>"
        "</office:document-content>"
    )
    memory = io.BytesIO()
    with zipfile.ZipFile(memory, "w") as archive:
        archive.writestr("mimetype", "application/vnd.oasis.opendocument.spreadsheet")
        archive.writestr("content.xml", content)
        archive.writestr("META-INF/manifest.xml", "<manifest:manifest/>")
    section = parse_source(memory.getvalue(), "swing.ods").section()
    assert numbers(section) == {
        "Pendel/Zeit": [0.0, 0.04, 0.08],
        "Pendel/Winkel": [12.125, -1234.5, 0.5],
    }
    assert section.columns[1].unit == "deg"


def test_a_missing_reader_of_spreadsheets_says_what_to_install(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "python_calamine", None)
    with pytest.raises(InputError, match=r"a spreadsheet needs the package.*\[tables\].*as CSV"):
        parse_source(workbook(Sheet1=[["t", "x"], [1.0, 2.0]]))


def test_the_result_is_plain_values_for_a_page():
    shown = json.loads(json.dumps(source(TWO_TRACKS).to_dict(rows=1)))
    assert shown["about"] == "Tracker export, 2 tracks: right ball, left ball"
    (section,) = shown["sections"]
    assert section["tracks"] == ["right ball", "left ball"]
    assert (section["rows"], section["first_line"], section["last_line"]) == (2, 4, 5)
    assert section["first_rows"] == [["0.000", "12.5", "-34.1", "-11.0", "-33.9"]]
    assert section["line_numbers"] == [4]
    column = section["columns"][1]
    assert (column["path"], column["unit"], column["position"]) == ("right ball/x", "m", 2)
    assert column["unit_from"] == "the kind of file (Tracker export)"
