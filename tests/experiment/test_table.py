"""Track tables keep everything through files and refuse bad ones in one line."""

import numpy as np
import pytest
import xarray as xr

from latolato.core.errors import InputError
from latolato.experiment.track_table import (
    FLAGS,
    column_names,
    read_table,
    track_table,
    write_table,
)


def example(balls=1):
    time = np.array([0.0, 0.016, 0.035, 0.05])
    columns = {"time": time, "pivot_y": 0.01 * np.cos(time)}
    for ball in range(1, balls + 1):
        columns[f"angle_{ball}"] = np.array([0.1 * ball, 0.2, np.nan, 0.3])
        columns[f"angle_sigma_{ball}"] = np.full(4, 1e-3)
        columns[f"flag_{ball}"] = ["ok", "collision", "lost", "predicted"]
    about = {"source": "clip 1.mp4", "source_sha256": "123", "length": 0.36, "radius": None}
    return track_table(columns, about)


@pytest.mark.parametrize("balls", [1, 2])
@pytest.mark.parametrize("suffix", [".csv", ".parquet", ".nc"])
def test_a_table_is_the_same_after_writing_and_reading(tmp_path, balls, suffix):
    table = example(balls)
    read = read_table(write_table(table, tmp_path / f"clip{suffix}"))
    xr.testing.assert_identical(read, table)
    assert [p.name for p in tmp_path.iterdir()] == [f"clip{suffix}"]


def test_the_columns_of_a_csv_are_in_the_order_of_the_table(tmp_path):
    path = write_table(example(2), tmp_path / "clip.csv")
    lines = path.read_text().splitlines()
    body = [line for line in lines if not line.startswith("#")]
    assert tuple(body[0].split(",")) == column_names(2)
    assert body[0].startswith("frame,time,pivot_x,pivot_y,ball_1_x,ball_1_y,ball_2_x,ball_2_y,")
    assert len(body) == 5
    assert "# source: clip 1.mp4" in lines
    assert '# source_sha256: "123"' in lines  # a text that looks like a number stays a text
    assert "# column angle_sigma_1 [rad]: standard deviation of the right ball's angle" in lines


def test_what_was_not_measured_is_unknown_and_every_variable_has_units():
    table = track_table({"time": [0.0, 1.0], "angle_1": [0.1, np.nan]})
    assert table.flag_1.values.tolist() == ["ok", "lost"]
    assert np.isnan(table.ball_1_x.values).all()
    assert table.frame.values.tolist() == [0, 1]
    assert set(table.flag_1.values) <= set(FLAGS)
    for variable in table.variables.values():
        assert {"units", "long_name", "symbol"} <= variable.attrs.keys()


@pytest.mark.parametrize(
    "columns, said",
    [
        ({"angle_1": [0.1]}, "needs the column 'time'"),
        ({"time": []}, "needs rows, but this one has none; give one row or more"),
        ({"time": [0.0, 0.0]}, "time must increase strictly, above 0 in row 2, got 0"),
        ({"time": [0.0, np.nan]}, "time must be known in every row"),
        ({"time": [0.0], "angel_1": [0.1]}, "no column 'angel_1'"),
        ({"time": [0.0], "angle_1": [0.1, 0.2]}, "must have 1 rows"),
        ({"time": [0.0], "angle_1": [np.inf]}, "infinite"),
        ({"time": [0.0], "flag_1": ["fine"]}, "must be 'ok', 'collision'"),
        ({"time": [0.0], "frame": [0.5]}, "whole numbers"),
    ],
)
def test_bad_columns_are_refused_in_one_line(columns, said):
    with pytest.raises(ValueError, match=said) as caught:
        track_table(columns)
    assert "\n" not in str(caught.value)


def test_numbers_that_are_texts_are_refused():
    with pytest.raises(InputError, match="'angle_1' must hold numbers, got 'left'"):
        track_table({"time": [0.0], "angle_1": ["left"]})


@pytest.mark.parametrize(
    "change, said",
    [
        (lambda text: "", "is empty"),
        (lambda text: "time,angle\n0,1\n", "is not a track table"),
        (lambda text: text.replace("[rad]: angle of", "[deg]: angle of"), r"must be \[rad\]"),
        (lambda text: text.replace("# column time [s]: time\n", ""), r"'time' must be \[s\]"),
        (lambda text: text.replace("pivot_x,", "pivot,"), "of a track table: pivot_x"),
        (lambda text: text + "1,2\n", "row 5 has 2 cells"),
        (lambda text: text.replace("\n1,0.016", "\n1,-0.016"), "time must increase"),
        (lambda text: text.replace("0.016", "soon"), "'time' must hold numbers, got 'soon'"),
    ],
)
def test_bad_files_are_refused_in_one_line(tmp_path, change, said):
    path = write_table(example(), tmp_path / "clip.csv")
    path.write_text(change(path.read_text()))
    with pytest.raises(ValueError, match=said) as caught:
        read_table(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["clip.parquet", "clip.nc"])
def test_files_of_something_else_are_refused(tmp_path, name):
    (tmp_path / name).write_text("hello")
    with pytest.raises(ValueError, match="is no"):
        read_table(tmp_path / name)


def test_a_missing_file_and_an_unknown_suffix_are_named(tmp_path):
    with pytest.raises(FileNotFoundError, match="there is no file"):
        read_table(tmp_path / "clip.csv")
    with pytest.raises(ValueError, match=r"must end in \.csv, \.parquet, \.nc"):
        write_table(example(), tmp_path / "clip.txt")
    assert list(tmp_path.iterdir()) == []


def test_what_else_a_netcdf_file_says_of_its_frames_is_kept(tmp_path):
    table = track_table({"time": [0.0, 0.1], "angle_1": [0.2, 0.1]})
    table["covered_1"] = ("frame", [0.0, 0.5], {"units": "1", "long_name": "hidden part"})
    write_table(table, tmp_path / "truth.nc")
    assert read_table(tmp_path / "truth.nc").covered_1.values.tolist() == [0.0, 0.5]


def test_a_refused_file_is_named_with_the_parts_of_the_error(tmp_path):
    path = tmp_path / "table.csv"
    write_table(track_table({"time": [0.0, 0.1], "angle_1": [0.2, 0.1]}), path)
    path.write_text(path.read_text().replace("column time [s]", "column time [ms]"))
    with pytest.raises(
        InputError, match=r"unit of column 'time' must be \[s\], got 'ms'"
    ) as caught:
        read_table(path)
    error = caught.value
    assert (error.where, error.parameter, error.value) == (str(path), "time", "ms")
