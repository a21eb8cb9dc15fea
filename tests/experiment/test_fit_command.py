"""`latolato fit` and `latolato import` read, fit, draw and refuse as they say."""

import json

import numpy as np
import pytest

import latolato as ll
from latolato.cli.main import main
from latolato.experiment.fits import fits
from latolato.experiment.fits.result import load_fit, quantity_of
from latolato.experiment.track_table import read_table, write_table
from latolato.figures.plot import module_of
from latolato.scenario.analysis_options import options_of
from track_tables import decay_table, drive_table, motion_table

BODY = {"length": 0.3630, "mass": 0.10804, "damping": 0.00274}


@pytest.fixture(scope="module")
def decay(tmp_path_factory):
    return write_table(decay_table(**BODY), tmp_path_factory.mktemp("fits") / "decay.csv")


def test_a_decay_is_fitted_drawn_stored_and_printed_as_json(decay, tmp_path, capsys):
    picture, result = tmp_path / "decay.png", tmp_path / "decay.nc"
    arguments = ["--length", "36.3 cm", "--mass", "108.04 g", "--plot", picture, "--output", result]
    assert main(["fit", "decay", str(decay), *map(str, arguments), "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert summary["values"]["damping"]["value"] == pytest.approx(0.00274, rel=0.01)
    assert "Linear drag describes this decay best" in summary["verdict"]
    assert picture.stat().st_size > 10_000
    assert load_fit(result)["damping"].value == summary["values"]["damping"]["value"]
    assert main(["plot", str(result), "--output", str(tmp_path / "again.png")]) == 0
    assert (tmp_path / "again.png").read_bytes() == picture.read_bytes()
    assert main(["plot", str(result), "--animate", str(tmp_path / "again.gif")]) == 2
    assert "a fit" in capsys.readouterr().err


def test_a_parameter_varies_by_its_name_as_options_spell_it(decay, capsys):
    system = ["--system", "pendulum", "--length", "0.36", "--mass", "0.1", "--damping", "0.003"]
    several = ["--vary", "length", "--vary", "damping,angle-offset"]
    assert main(["fit", "model", str(decay), *system, *several, "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert list(summary["values"]) == ["length", "damping", "angle_offset"]


def test_drive_restitution_and_model_have_a_command_and_a_picture(tmp_path, capsys):
    drive = ll.Harmonic(drive_amplitude=0.03, drive_frequency=15.1)
    ball = ll.Ball(length=0.245, mass=0.106, damping=0.005, radius=0.02)
    pair = ll.BallPair(right=ball, left=ball, restitution=0.9)
    moving = write_table(drive_table(drive, duration=6.0), tmp_path / "drive.csv")
    table = motion_table(pair, drive, initial_angle=(0.5, -0.3), duration=4.0)
    balls = write_table(table, tmp_path / "pair.csv")
    body = ["--length", "0.245", "--radius", "0.02"]
    system = ["--system", "latolato", "--mass", "0.106", "--damping", "0.004", *body]
    arguments = ["--drive-amplitude", "3 cm", "--drive-frequency", "15.1"]
    for name, rest in {
        "drive": [str(moving)],
        "restitution": [str(balls), *body],
        "model": [str(balls), *system, *arguments, "--vary", "length,restitution", "--ball", "1"],
    }.items():
        picture = tmp_path / f"{name}.svg"
        assert main(["fit", name, *rest, "--plot", str(picture)]) == 0
        assert picture.exists()
        out = capsys.readouterr().out
        assert out.startswith("fit ")
        assert "95 %" in out


def test_a_table_of_another_program_is_imported_or_fitted_at_once(tmp_path, capsys):
    table = decay_table(**BODY, duration=8.0)
    degrees = np.rad2deg(table.angle_1.values)
    rows = "\n".join(f"{t:.6f};{a:.5f}" for t, a in zip(table.time.values, degrees, strict=True))
    path = tmp_path / "tracker.txt"
    path.write_text(f"mass A\nt;theta\n{rows}\n")
    columns = ["--column", "time=t [s]", "--column", "angle_1=theta [deg]"]
    assert main(["import", str(path), *columns, "--length", "36.3 cm"]) == 0
    target = tmp_path / "tracker.track.csv"
    out = capsys.readouterr().out
    assert str(target) in out
    assert " deg" in out  # the range of the angle shows a wrong unit
    assert read_table(target).attrs["length"] == 0.363
    assert main(["fit", "decay", str(path), *columns, "--method", "envelope"]) == 0
    assert "decay_rate_envelope" in capsys.readouterr().out


def test_an_import_never_replaces_a_measurement_or_another_import(tmp_path, capsys):
    path = tmp_path / "swing.csv"
    text = "t [s],left [deg],right [deg]\n0.0,1.5,2\n0.1,2.5,3\n0.2,3.5,4\n"
    path.write_text(text)
    left, right = (
        ["import", str(path), "--column", "time=t", "--column", f"angle_1={name}"]
        for name in ("left", "right")
    )
    assert main([*left, "--output", str(path)]) == 2
    assert "is the measurement itself" in capsys.readouterr().err
    assert path.read_text() == text
    assert main(left) == main(left) == 0
    assert main(right) == 2
    assert "was not imported from these columns; name another file" in capsys.readouterr().err
    target = tmp_path / "swing.track.csv"
    assert main([*right, "--output", str(target)]) == 0
    assert read_table(target).attrs["imported"].endswith("angle_1 = right [deg]")
    assert main(["import", str(tmp_path)]) == 2
    assert "is a folder" in capsys.readouterr().err


def test_a_preview_shows_what_was_recognised_and_writes_nothing(tmp_path, capsys):
    path = tmp_path / "pair.txt"
    path.write_text("\tright ball\t\t\nt\tx\ty\t\n0.0\t0.125\t-0.3\n0.1\t0.12\t-0.31\n")
    assert main(["import", str(path), "--preview"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("Tracker export, 1 track: right ball\nutf-8, tabs\n")
    assert "2 right ball/x [m]: 0.125, 0.12 ..." in out
    assert main(["import", str(path), "--preview", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["kind"] == "Tracker export"
    assert list(tmp_path.iterdir()) == [path]
    arguments = ["import", str(path), "--pivot", "0, 0", "--json"]
    assert main(arguments) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["rows"] == 2
    assert "x' is in [m], from the kind of file" in told["attributes"]["assumed"]
    assert main([*arguments, "--frame-rate", "quick"]) == 2


def test_a_table_whose_columns_are_recognised_is_fitted_without_naming_them(tmp_path, capsys):
    table = decay_table(**BODY, duration=8.0)
    rows = "\n".join(
        f"{t:.6f}\t{a:.6f}" for t, a in zip(table.time.values, table.angle_1.values, strict=True)
    )
    path = tmp_path / "swing.txt"
    path.write_text(f"t_s\ttheta [rad]\n{rows}\n")
    assert main(["fit", "decay", str(path), "--method", "envelope"]) == 0
    captured = capsys.readouterr()
    assert "decay_rate_envelope" in captured.out
    assert "'t' is in [s], from its name" in captured.err


@pytest.mark.parametrize("name", fits)
def test_every_fit_has_options_words_and_a_picture(name):
    kind = fits[name]
    for option in options_of(kind.function).values():
        assert option.description != option.name.replace("_", " ")  # its docstring says more
    assert kind.title
    assert kind.hint or not kind.is_slow
    assert all(quantity_of(each).long_name for each in kind.headline)
    assert callable(module_of("fit", name).draw)


@pytest.mark.parametrize(
    "arguments, said",
    [
        (["decay", "missing.csv"], "there is no file"),
        (["decay", "TABLE", "--mass", "3 cm"], "mass must be given in kg"),
        (["decay", "TABLE", "--column", "time"], "--column must be NAME=COLUMN"),
        (["decay", "TABLE", "--output", "fit.txt"], "must end in .nc"),
        (["decay", "TABLE", "--law", "cubic"], "unknown drag law"),
        (["decai", "TABLE"], "unknown fit 'decai': did you mean 'decay'?"),
        (["drive", "TABLE"], "'pivot_y' of the track table holds no numbers"),
        (["restitution", "TABLE"], "no impact was seen"),
        (["model", "TABLE"], "name the system"),
        (
            ["model", "TABLE", "--system", "pendulum", "--length=1", "--mass=1", "--window=-1"],
            "window must lie in (0, inf) s, got -1; give more than 0",
        ),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(arguments, said, decay, tmp_path, capsys):
    words = [str(decay) if word == "TABLE" else word for word in arguments]
    before = sorted(decay.parent.iterdir())
    assert main(["fit", *words]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    assert sorted(decay.parent.iterdir()) == before
