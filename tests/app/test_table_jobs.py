"""Tables that pages upload: recognised, imported and fitted in a process of their own."""

import io
import runpy
import shlex

import numpy as np
import pytest
from typer.testing import CliRunner

import latolato as ll
from clip_pages import one_line, opened
from latolato.app.experiment.work import WORK
from latolato.cli.main import app
from latolato.experiment.track_table import read_table, track_table, write_table
from page_blocks import unpack
from track_tables import motion_table, noise

LENGTH, DAMPING, MASS = 0.5, 0.004, 0.1
TIME = np.arange(0.0, 20.0, 0.02)


@pytest.fixture(scope="module")
def angle():
    """A free swing of one ball with the noise of a measurement [rad]."""
    swing = ll.Pendulum(length=LENGTH, mass=MASS, damping=DAMPING)
    run = ll.simulate(swing, initial_angle=0.4, times=TIME)
    return run.angle.values + noise(len(TIME), seed=1)


def text_of(head, *columns, delimiter=","):
    body = io.StringIO()
    np.savetxt(body, np.column_stack(columns), "%.6f", delimiter)
    return f"{head}\n{body.getvalue()}"


def job_of(folder, text, name):
    """Return a job on an uploaded text, as a process gets it."""
    (folder / "clip").write_text(text, "utf-8")
    return {"path": str(folder / "clip"), "folder": str(folder), "name": name, "limits": {}}


def done(do, job, description=None):
    about, arrays = WORK[do]({**job, "description": description}, lambda stage, share: None)
    return about | {"points": arrays.get("points")}


def test_a_table_is_recognised_imported_fitted_and_exported(angle):
    text = text_of("Zeit;Winkel", TIME, np.degrees(angle), delimiter=";").replace(".", ",")
    with opened() as (page, _):
        clip = page.clip(text.encode(), "Messung.csv")
        table = page.do(do="look", clip=clip)["done"]["table"]
        (part,) = table["sections"]
        assert part["roles"] == {"time": 1, "angle_1": 2}
        assert part["first_rows"][1][0] == "0,020000"
        unnamed = {"columns": {"time": "1", "angle_1": "2"}}
        answer = one_line(page.do(do="import", clip=clip, description=unnamed))
        assert answer.startswith("Messung.csv: the unit of column 'Zeit' is missing; write it")
        named = {"columns": {"time": "1 [s]", "angle_1": "2 [deg]"}, "mass": "100 g"}
        answer = page.do(do="import", clip=clip, description=named)
        found = answer["done"]["fits"]["decay"]["values"]
        assert found["length"]["value"] == pytest.approx(LENGTH, rel=1e-3)
        assert found["damping"]["value"] == pytest.approx(DAMPING, rel=0.02)
        assert {"points", "model"} <= set(answer)
        again = page.do(do="fit", kind="decay", clip=clip, description=named)["done"]
        assert again["values"] == found
        assert page.do(do="export", file="track.nc", clip=clip)["done"]["file"] == "track.nc"
        assert page.file(clip, "track.nc").status_code == 200
        assert page.file(clip, "track.csv").text.startswith("# table: track")


@pytest.mark.parametrize(
    "head, seconds, factor, question",
    [
        ("t (s),theta (rad)", 1e3, 1.0, "This is the period of a pendulum of "),
        ("t (s),theta (rad)", 1e6, 1.0, "This is the period of a pendulum of "),
        ("t (s),theta (rad)", 1.0, 180.0 / np.pi, "angle_1 swings to and fro by "),
    ],
)
def test_a_unit_that_nobody_measures_in_is_asked_for_before_any_number(
    tmp_path, angle, head, seconds, factor, question
):
    job = job_of(tmp_path, text_of(head, seconds * TIME, factor * angle), "swing.csv")
    about = done("import", job, {"columns": {"time": "1", "angle_1": "2"}})
    assert about["finding"][0].startswith(question)
    assert about["finding"][0].endswith("?")
    assert any("One swing" in each or "It swings" in each for each in about["finding"][1:])
    assert about["answer"] == []


def test_a_track_table_in_degrees_is_asked_about_too(tmp_path, angle):
    path = write_table(
        track_table({"time": TIME, "angle_1": np.degrees(angle)}), tmp_path / "a.csv"
    )
    about = done("import", job_of(tmp_path, path.read_text("utf-8"), "a.csv"), {})
    assert about["finding"][0].endswith("is it in degrees, and its unit wrong?")


@pytest.mark.parametrize(
    "part, match",
    [
        ({"start": "12 s", "end": "2 s"}, "start must not lie after end, which is 2 s, got 12"),
        ({"start": "2500 s"}, "no sample lies between start and end: the table goes from 0 to"),
    ],
)
def test_a_part_that_is_none_of_the_table_is_refused(tmp_path, angle, part, match):
    job = job_of(tmp_path, text_of("t (s),angle (rad)", TIME, angle), "swing.csv")
    with pytest.raises(ll.InputError, match=match):
        done("import", job, {"columns": {"time": "1", "angle_1": "2"}, **part})


def test_what_is_said_of_a_table_is_about_the_part_that_is_used(tmp_path, angle):
    middle = float(TIME.mean())
    faster = np.where(middle > TIME, angle, 0.1 * np.cos(12.0 * TIME))
    job = job_of(tmp_path, text_of("t (s),angle (rad)", TIME, faster), "swing.csv")
    about = done(
        "import", job, {"columns": {"time": "1", "angle_1": "2"}, "start": f"{middle + 1.0} s"}
    )
    [period] = [each["value"] for each in about["answer"] if each["name"].endswith("period")]
    assert period == pytest.approx(2.0 * np.pi / 12.0, rel=1e-3)


def test_a_table_of_times_alone_is_refused(tmp_path):
    job = job_of(tmp_path, text_of("t (s),mass (kg)", TIME, TIME), "swing.csv")
    with pytest.raises(ll.InputError, match="which column is angle_1; it has t, mass"):
        done("import", job, {"columns": {"time": "1"}})


def test_lines_of_python_and_commands_make_the_same_fit(angle, tmp_path, monkeypatch, capsys):
    folder, here = tmp_path / "upload", tmp_path / "here"
    folder.mkdir()
    here.mkdir()
    x, y = 10.0 + 50.0 * np.sin(angle), 2.0 + 50.0 * np.cos(angle)
    text = text_of("t (s),x,y", TIME, x, y)
    job = job_of(folder, text, "my swing.csv")
    description = {
        "columns": {"time": "1", "ball_1_x": "2 [cm]", "ball_1_y": "3 [cm]"},
        "pivot_x": "10", "pivot_y": "2", "y_axis": "down", "length": "50 cm", "mass": "100 g",
    }  # fmt: skip
    result = done("import", job, description)
    verdict = result["fits"]["decay"]["verdict"]
    assert result["fits"]["decay"]["values"]["damping"]["value"] == pytest.approx(DAMPING, rel=0.02)
    monkeypatch.chdir(here)
    (here / "my swing.csv").write_text(text)
    (here / "lines.py").write_text(result["code"][0])
    runpy.run_path(str(here / "lines.py"))
    # The page adds how far the motion can be predicted.
    printed = capsys.readouterr().out.strip()
    assert len(printed) > 40
    assert verdict.startswith(printed)
    first, second = (shlex.split(line) for line in result["code"][1].splitlines())
    assert first[:3] == ["latolato", "import", "my swing.csv"]
    for words in (first, second):
        answer = CliRunner().invoke(app, words[1:])
        assert answer.exit_code == 0, answer.output
    assert printed in " ".join(answer.output.split())


def test_a_track_table_of_this_package_keeps_its_flags(angle, tmp_path):
    flags = np.where(TIME < 1.0, "lost", "ok")
    table = track_table({"time": TIME, "angle_1": angle, "flag_1": flags}, {"length": LENGTH})
    path = write_table(table, tmp_path / "swing.track.csv")
    job = job_of(tmp_path, path.read_text("utf-8"), path.name)
    assert done("look", job)["table"]["is_own"] is True
    result = done("import", job, {})
    assert "read_table('swing.track.csv')" in result["code"][0]
    assert read_table(tmp_path / "track.csv").flag_1.values.tolist() == flags.tolist()


def test_a_page_knows_where_rows_of_a_table_are_missing(angle, tmp_path):
    before = np.count_nonzero(TIME < 6.0)
    for kept, gaps in (((TIME < 6.0) | (TIME >= 7.3), [before]), (TIME < 1e-9, [])):
        job = job_of(tmp_path, text_of("t (s),theta (rad)", TIME[kept], angle[kept]), "gap.csv")
        told = done("import", job, {"columns": {"time": "1", "angle_1": "2"}})
        about, _ = unpack(told["points"].tobytes())
        assert about["after_gaps"] == gaps


def test_frame_numbers_and_runs_are_offered_as_they_are(angle, tmp_path):
    job = job_of(tmp_path, text_of("frame,theta (rad)", 50.0 * TIME, angle), "frames.csv")
    (part,) = done("look", job)["table"]["sections"]
    assert part["roles"] == {"frame": 1, "angle_1": 2}
    assert part["question"] == "it has frame numbers and no time"
    description = {"columns": {"time": "1", "angle_1": "2"}, "frame_rate": "50"}
    done("import", job, description)
    assert read_table(tmp_path / "track.csv").time.values == pytest.approx(TIME)
    head = "Run #1,,Run #2,\nTime (s),Angle (rad),Time (s),Angle (rad)"
    job = job_of(tmp_path, text_of(head, TIME, angle, TIME, -angle), "capstone.csv")
    parts = done("look", job)["table"]["sections"]
    assert [part["name"] for part in parts] == ["Run #1", "Run #2"]
    description = {"section": "Run #2", "columns": {"time": "3", "angle_1": "4"}}
    code = done("import", job, description)["code"]
    assert read_table(tmp_path / "track.csv").angle_1.values == pytest.approx(-angle, abs=1e-6)
    assert "section='Run #2'" in code[0]


def test_a_table_with_a_driven_pivot_is_a_trial(tmp_path):
    drive = ll.Harmonic(drive_amplitude=0.02, drive_frequency=10.09)
    swing = ll.Pendulum(length=0.363, mass=MASS, damping=DAMPING)
    table = motion_table(swing, drive, initial_angle=0.2)
    columns = (table.time, np.degrees(table.angle_1), 1e3 * table.pivot_y)
    job = job_of(tmp_path, text_of("t (s),theta (deg),hand (mm)", *columns), "driven.csv")
    description = {
        "columns": {"time": "1", "angle_1": "2", "pivot_y": "3"}, "length": "36.3 cm",
    }  # fmt: skip
    result = done("import", job, description)
    assert result["no_trial"] is None
    assert result["trial"]["drive_amplitude"] == pytest.approx(0.02, rel=0.01)
    assert result["finding"][0].startswith("Shaken with an amplitude of")
    assert result["code"][1].splitlines()[-1] == "latolato fit drive driven.track.csv"


def test_a_doubted_fit_is_told_before_anything_else(angle, tmp_path):
    # A piece of 0.73 s was cut out of the clock.
    kept = (TIME < 8.0) | (TIME > 8.73)
    time = np.where(TIME < 8.0, TIME, TIME - 0.73)[kept]
    job = job_of(tmp_path, text_of("t (s),theta (rad)", time, angle[kept]), "cut.csv")
    result = done("import", job, {"columns": {"time": "1", "angle_1": "2"}})
    decay = result["fits"]["decay"]
    assert "values" not in decay
    assert decay["doubt"]
    assert result["finding"][0] == decay["doubt"]
    assert "decay" not in result["code"][1]


@pytest.mark.parametrize(
    "description, words",
    [
        ({"columns": ["t"]}, "columns must be an object of texts"),
        ({"columns": {"time": 1}}, "columns must be an object of texts"),
        ({"section": 3}, "section must be a text"),
        ({"angle_from": "left"}, "angle_from must be 'down' or 'right'"),
        ({"y_axis": "left"}, "y_axis must be 'up' or 'down'"),
        ({"decimal": ";"}, "decimal must be"),
        ({"frame_rate": "-3"}, r"frame_rate must lie in \(0"),
        ({"section": "2"}, "it has no section '2'"),
    ],
)  # fmt: skip
def test_what_a_page_says_about_a_table_is_checked(tmp_path, description, words):
    job = job_of(tmp_path, text_of("t (s),theta (rad)", TIME, TIME), "swing.csv")
    with pytest.raises(ll.InputError, match=words):
        done("import", job, {"columns": {"time": "1"}} | description)


def test_fits_use_the_part_of_a_table_that_a_page_gives(angle, tmp_path):
    broken = np.where(TIME < 6.0, angle, angle[::-1])
    job = job_of(tmp_path, text_of("t (s),theta (rad)", TIME, broken), "swing.csv")
    description = {"columns": {"time": "1", "angle_1": "2"}, "length": "50 cm"}
    whole = done("import", job, description)["fits"]["decay"]
    assert "give start and end to fit a part" in str(whole["error"])
    # A page shows no values of such a fit.
    assert "kept for inspection" not in str(whole["error"])
    part = done("import", job, {**description, "end": "5.9 s"})
    assert part["fits"]["decay"]["values"]["length"]["value"] == pytest.approx(LENGTH, rel=0.01)
    lines, commands = part["code"]
    assert "end=5.9" in lines
    assert "--end 5.9" in commands
