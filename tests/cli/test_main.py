"""The command line: what it writes and prints, and how it refuses bad input in one line."""

import dataclasses
import inspect
import json
import math
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import latolato as ll
from latolato.cli import main as cli
from latolato.cli.main import app, main
from latolato.cli.options import command_from
from latolato.cli.simulate import scenario_of
from latolato.cli.simulate import simulate as simulate_command
from latolato.core.errors import reading
from latolato.experiment.comparison.motion import compare_motion
from latolato.experiment.importing import import_table
from latolato.experiment.synthetic.synthesise import synthesise_video
from latolato.experiment.trials import collect_trials
from latolato.io import progress
from latolato.numerics import shipped
from latolato.physics.drives import drives
from latolato.physics.pendulum import systems
from latolato.scenario.analysis_options import LAWS, options_of
from latolato.scenario.options import law_options
from latolato.scenario.scenario import scenarios

COMMAND = [sys.executable, "-m", "latolato"]
TOY = [
    "--system",
    "latolato",
    "--length",
    "1",
    "--mass",
    "0.8",
    "--radius",
    "0.1",
    "--initial-angle",
    "0.5",
    "--duration",
    "1",
]
PAIR = [
    "--system",
    "ballpair",
    "--right-length",
    "1",
    "--left-length",
    "1",
    "--right-mass",
    "1",
    "--left-mass",
    "1",
    "--right-radius",
    "0.1",
    "--left-radius",
    "0.1",
    "--initial-angle",
    "0.5,-0.4",
    "--duration",
    "1",
]
MEASURED = ["--drive", "measured_pivot", "--pivot-heights", "0,0,0,0,0,0", "--drive-times"]


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def run(*arguments):
    """Exit code, standard output and standard error of the command line in this process."""
    done = CliRunner().invoke(app, [str(a) for a in arguments])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done


def simulate(*arguments):
    """The JSON summary of a run."""
    return json.loads(run("simulate", *arguments, "--json").stdout)


def refused(capsys, *arguments):
    """The one line that `main` prints for bad input; nothing else may happen."""
    before = sorted(Path().rglob("*"))
    assert main([str(a) for a in arguments]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("latolato: ")
    assert printed.err.count("\n") == 1
    assert sorted(Path().rglob("*")) == before
    return printed.err.removeprefix("latolato: ").rstrip("\n")


def but(base, *changed):
    """Options with some replaced or added, as none may be given twice."""
    pairs = zip(base[::2], base[1::2], strict=True)
    return [*(part for pair in pairs if pair[0] not in changed for part in pair), *changed]


BAD_INPUT = [
    (but(TOY, "--length", "nan"), "length must be a number in m, got nan"),
    (but(TOY, "--mass", "inf"), "mass must be a number in kg, got inf"),
    (but(TOY, "--damping", "-inf"), "damping must be a number in kg*m/s, got -inf"),
    (but(TOY, "--mass", "-1"), "mass must lie in (0, inf) kg, got -1"),
    (but(TOY, "--length", "-1 m"), "length must lie in (0, inf) m, got -1"),
    (but(TOY, "--restitution", "-0.1"), "restitution must lie in [0, 1]"),
    (but(TOY, "--restitution", "1.5"), "restitution must lie in [0, 1]"),
    (but(TOY, "--radius", "1"), "radius must lie in [0, length), got 1; give less than 1"),
    (but(TOY, "--gravity", "0"), "gravity must lie in (0, inf) m/s^2, got 0"),
    (but(TOY, "--duration", "-1"), "duration must lie in (0, inf) s, got -1"),
    (but(TOY, "--tolerance", "1"), "tolerance must lie in [1e-14, 0.01] rad, got 1"),
    (
        but(TOY, "--initial-angle", "0.05"),
        "--initial-angle must lie between the contact angles [0.1001674211616, 3.041425232428] "
        "rad, got 0.05",
    ),
    (["fig04a", "--initial-offset", "-1 deg"], "--initial-offset must lie in [0, inf) rad"),
    (but(TOY, "--initial-angle", "nan"), "--initial-angle must be a number in rad, got nan"),
    (but(TOY, "--times", "0,1,1"), "times must increase strictly, got 1 after 1 at position 2"),
    (but(TOY, "--times", "0,2,1"), "times must increase strictly, got 1 after 2 at position 2"),
    (but(TOY, "--times", "0 s, nan s"), "times[1] must be a number in s, got nan"),
    (but(TOY, "--length", "24.5 kg"), "length must be given in m (or a unit that converts to it)"),
    (but(TOY, "--drive-amplitude", "1 Hz"), "--drive-amplitude must be given in m"),
    (but(TOY, "--drive-amplitude", "1 cm"), "Harmonic needs --drive-frequency [rad/s]"),
    (
        [
            *(*TOY, "--drive", "frequency_schedule", "--drive-amplitude", "1 cm"),
            *("--drive-times", "0,2,1", "--drive-frequencies", "3,2,1"),
        ],
        "--drive-times must increase strictly, got 1 after 2 at position 2",
    ),
    (but(TOY, *MEASURED, "0,1,2,3,5,4"), "--drive-times must increase strictly, got 4 after 5"),
    (but(TOY, *MEASURED, "0,1"), "--drive-times must hold at least 6 values, got 2"),
    (but(TOY, *MEASURED, ""), "--drive-times must be given in s"),
    (
        but(TOY, *MEASURED, "0,1,2,3,4,5", "--duration", "9"),
        "the pivot samples cover 0 to 5 s, but",
    ),
    (but(PAIR, "--left-length", "0.5"), "the balls never meet: the lengths must differ by less"),
    (
        but(PAIR, "--left-length", "0.89", "--right-radius", "0.01", "--left-radius", "0.11"),
        "the right rod or string would hit the left ball before the balls meet",
    ),
    (
        but(PAIR, "--left-radius", "1"),
        "--left-radius must lie in [0, length), got 1; give",
    ),
    (but(PAIR, "--initial-angle", "0.5"), "--initial-angle of a BallPair must be two numbers"),
    (but(PAIR, "--initial-angle", "0.1,0"), "must lie between the contact angles"),
    (
        but(TOY, "--suspension", "cord"),
        "suspension must be 'rod' or 'string', got 'cord'",
    ),
    (but(TOY, "--drag-frame", "labs"), "got 'labs'; did you mean 'lab'?"),
    (
        but(TOY, "--string-restitution", "0.9"),
        "--string-restitution must be 0 with suspension 'rod', as a rod never goes slack, got 0.9",
    ),
    (
        but(TOY, "--suspension", "string", "--contact", "clamp"),
        "contact 'clamp' is described for rods and for drag relative to the pivot only",
    ),
    (
        but(TOY, "--system", "mathieu", "--suspension", "string"),
        "belongs to system pendulum or latolato or ballpair, not to mathieu",
    ),
    (but(TOY, "--system", "latolat"), "unknown system 'latolat': did you mean 'latolato'?"),
    (but(TOY, "--drive", "harmonics"), "unknown drive 'harmonics': did you mean 'harmonic'?"),
    (but(TOY, "--contact", "clam"), "unknown contact law 'clam': did you mean 'clamp'?"),
    (but(TOY, "--frame", "moon"), "frame must be 'pivot' or 'both', got 'moon'"),
    (
        but(TOY, "--noise-strength", "-1"),
        "--noise-strength must lie in [0, inf) rad/s^(3/2), got -1",
    ),
    (but(TOY, "--lenght", "1"), "No such option: --lenght"),
    (but(TOY, "--samples", "many"), "Invalid value for '--samples'"),
    (["zen"], "there is no scenario or file 'zen': did you mean 'zeno'?"),
    (["on\ntwo lines"], "there is no scenario or file 'on two lines'"),
    ([], "name what to run: a scenario"),
    (["zeno", "--from", "run.nc"], "give either a scenario or --from, not both"),
    (["--from", "run.nc"], "there is no file 'run.nc'"),
    (["zeno", "--output", "run.xls"], "the name of a result file must end in .nc, .csv, .parquet"),
    (["zeno", "--plot", "run.jpg"], "the name of a picture must end in .png, .svg, .pdf"),
    (["zeno", "--animate", "run.avi"], "the name of an animation must end in .mp4, .gif"),
    (["zeno", "--plot", "no/run.png"], "the folder 'no' does not exist; create it first"),
    (["zeno", "--animate", "run.gif", "--speed", "0"], "speed must lie in (0, 1e+06]"),
    ([*TOY, "--mass", "2"], "option --mass must be given once, it was given 2 times"),
    (
        but(TOY, "--times", "0", "--times", "1"),
        "option --times must be given once, it was given 2 times",
    ),
    ([*TOY, "--json", "--json"], "option --json must be given once, it was given 2 times"),
    (
        but(TOY, "--left-mass", "2"),
        "--left-mass belongs to system ballpair, not to latolato; use --mass or change the system",
    ),
    (
        but(TOY, "--connecting-rod-length", "1"),
        "--connecting-rod-length belongs to drive crank_slider, not to harmonic; leave it out or",
    ),
    (but(PAIR, "--length", "1"), "BallPair has no --length of its own"),
    ([*PAIR[:8], *PAIR[10:]], "Ball needs --left-mass [kg]"),
    (
        but(TOY, "--contact", "clamp", "--clamp-step", "-1"),
        "--clamp-step must lie in (0, inf) s, got -1",
    ),
    (but(TOY, "--noise-seed", "3"), "VelocityKicks needs --noise-strength [rad/s^(3/2)]"),
    (
        but(TOY, "--noise-strength", "1", "--noise-seed", "-1"),
        "--noise-seed must lie in [0, 2^63), got -1",
    ),
    (
        but(TOY, "--noise-strength", "1", "--noise-seed", "9223372036854775808"),
        "--noise-seed must lie in [0, 2^63), got 9223372036854775808",
    ),
    (but(TOY, "--times", "no.txt"), "got 'no.txt'; there is no file of that name either"),
    (
        ["--system", "pendulum", "--length", "1e-29", *TOY[4:6], *TOY[8:]],
        "10¹⁶ default samples exceed the limit of 20000000; shorten the duration or name fewer",
    ),
    (but(TOY, "--samples", "20000001"), "samples must lie in [2, 2e+07], got 20000001"),
    (
        but(TOY, "--contact-limit", "9223372036854775808"),
        "--contact-limit must lie in [1, 2^63), got 9223372036854775808; give less than 2^63",
    ),
    (["zeno", "--output", "."], "'.' is a folder; name a file in it"),
    (["zeno", "--plot", "."], "'.' is a folder; name a file in it"),
    (["zeno", "--animate", "."], "'.' is a folder; name a file in it"),
]


@pytest.mark.parametrize("arguments, message", BAD_INPUT, ids=[m[:45] for _, m in BAD_INPUT])
def test_bad_input_gives_one_line_with_value_and_rule_and_writes_nothing(
    arguments, message, capsys
):
    output = [] if {"--output", "--plot", "--animate"} & set(arguments) else ["--output", "run.nc"]
    assert message in refused(capsys, "simulate", *arguments, *output)


def test_options_hang_balls_on_strings():
    strings = ["--suspension", "--string-restitution", "--drag-frame", "--initial-distance"]
    given = dict(zip(TOY[::2], TOY[1::2], strict=True)) | dict(
        zip(strings, ["string", "0.9", "lab", "80 cm"], strict=True)
    )
    # As typer hands them on; the command has each of them.
    known = inspect.signature(simulate_command).parameters
    values = {flag[2:].replace("-", "_"): text for flag, text in given.items()}
    assert values.keys() <= known.keys()
    ready = scenario_of(None, None, values)
    assert (ready.system.suspension, ready.system.drag_frame) == ("string", "lab")
    assert (ready.system.string_restitution, ready.run["initial_distance"]) == (0.9, 0.8)


@pytest.mark.parametrize(
    "text, message",
    [
        ("lenght = 1", "unknown parameter 'lenght' of Pendulum: did you mean 'length'?"),
        ("length = '24.5 kg'", "length must be given in m"),
        ("length = true", "length must be a number in m, got True"),
        ("[runn]", "unknown entry 'runn': did you mean 'run'?"),
        ("length = 1\n[run]\ndurration = 1", "unknown entry 'durration' of [run]: did you mean"),
        ("[drive", "mine.toml is no TOML file: "),
    ],
)
def test_a_bad_scenario_file_gives_one_line_and_writes_nothing(text, message, capsys):
    Path("mine.toml").write_text(f"[system]\nkind = 'pendulum'\nmass = 1\n{text}\n")
    assert message in refused(capsys, "simulate", "mine.toml", "--output", "run.nc")


@pytest.mark.parametrize(
    "arguments",
    [
        ["simulate", *but(TOY, "--length", "nan"), "--output", "run.nc"],
        ["simulate", "zeno", "--no-such-option"],
        ["no-such-command"],
        ["plot", "missing.nc"],
        ["scenarios", "show", "zen"],
    ],
)
def test_the_process_ends_with_code_2_and_one_line(arguments):
    done = subprocess.run([*COMMAND, *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.count("\n") == 1
    assert "Traceback" not in done.stderr
    assert list(Path().iterdir()) == []


@pytest.mark.skipif(sys.platform == "win32", reason="signals are others on Windows")
@pytest.mark.parametrize("number, code", [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupted_process_leaves_no_file(number, code):
    arguments = ["simulate", "fig02", "--animate", "long.gif"]  # 9000 frames, about a minute
    process = subprocess.Popen([*COMMAND, *arguments], stderr=subprocess.PIPE, text=True)
    begun = time.monotonic()
    while not list(Path().iterdir()):
        assert process.poll() is None
        assert time.monotonic() - begun < 120.0  # a first run compiles its kernels
        time.sleep(0.02)
    process.send_signal(number)
    _, printed = process.communicate(timeout=60)
    assert process.returncode == code
    assert printed == ""
    assert list(Path().iterdir()) == []


@pytest.mark.parametrize("cause, code", [(SystemExit(143), 143), (KeyboardInterrupt(), 130)])
def test_a_signal_that_python_wraps_in_an_error_ends_as_that_signal(monkeypatch, cause, code):
    def app(**_):
        raise RuntimeError("error calling __set_name__") from cause

    monkeypatch.setattr(cli, "app", app)
    assert cli.main([]) == code


@pytest.mark.parametrize("kept", [True, False])
def test_ctrl_c_says_nothing_of_a_call_that_it_came_before(monkeypatch, capsys, kept):
    async def write():
        """Never begun, as Ctrl-C comes before it is given to the event loop."""

    def app(**_):
        call = write()
        if not kept:
            del call
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "app", app)
    assert cli.main([]) == 130
    assert capsys.readouterr() == ("", "")


def test_plain_options_run_the_toy_of_the_experiment():
    # the example of the documentation
    result = simulate(
        *("--system", "latolato", "--length", "24.5 cm", "--mass", "0.1", "--radius", "2 cm"),
        *("--damping", "0.005", "--drive-amplitude", "20 mm", "--drive-frequency", "15.1"),
        *("--initial-angle", "20 deg", "--duration", "10", "--output", "run.nc"),
    )
    toy = ll.LatoLato(length=0.245, mass=0.1, radius=0.02, damping=0.005)
    drive = ll.Harmonic(drive_amplitude=0.02, drive_frequency=15.1)
    expected = ll.simulate(toy, drive, initial_angle=math.radians(20), duration=10.0)
    written = ll.load("run.nc")
    np.testing.assert_array_equal(written.angle, expected.angle)
    assert result["largest_angle"] == float(abs(expected.angle).max())
    assert result["contacts"] == {"bottom": expected.sizes["contact"]}
    assert result["files"] == ["run.nc"]
    assert result["status"] == "complete"
    assert result["energy_residual"] < 1e-9 * result["largest_energy"]  # the promise of the ledger


def test_a_frequency_in_hertz_is_turned_into_an_angular_one():
    run(
        "simulate",
        *TOY,
        "--drive-amplitude",
        "0",
        "--drive-frequency",
        "1.6 Hz",
        "--output",
        "a.nc",
    )
    assert ll.load("a.nc").attrs["drive_frequency"] == pytest.approx(10.053096, abs=1e-6)


def test_options_replace_what_the_scenario_says():
    run(
        "simulate",
        "fig04a_push",
        *("--drive-amplitude", "2 cm", "--duration", "1", "--output", "a.nc"),
    )
    attributes = ll.load("a.nc").attrs
    assert attributes["drive_amplitude"] == 0.02
    assert attributes["duration"] == 1.0
    assert attributes["drive_frequency"] == 6.26


def test_two_balls_are_set_by_right_and_left_options():
    run(
        "simulate",
        *but(PAIR, "--left-mass", "2 kg", "--initial-angle", "20 deg, -25 deg"),
        "--output",
        "a.nc",
    )
    written = ll.load("a.nc")
    assert (written.attrs["right_mass"], written.attrs["left_mass"]) == (1.0, 2.0)
    np.testing.assert_allclose(np.degrees(written.angle[:, 0]), [20, -25], rtol=1e-15)


def test_times_come_from_a_list_or_a_file_and_samples_are_even():
    Path("times.txt").write_text("0\n0.25\n1\n")
    run("simulate", *TOY, "--times", "times.txt", "--output", "a.nc")
    np.testing.assert_array_equal(ll.load("a.nc").time, [0.0, 0.25, 1.0])
    run("simulate", *TOY, "--times", "0,250 ms,1 s", "--output", "a.nc")
    np.testing.assert_array_equal(ll.load("a.nc").time, [0.0, 0.25, 1.0])
    run("simulate", *TOY, "--samples", "3", "--output", "a.nc")
    np.testing.assert_array_equal(ll.load("a.nc").time, [0.0, 0.5, 1.0])


def test_files_named_by_options_are_looked_for_in_the_working_directory(tmp_path):
    (tmp_path / "elsewhere").mkdir()
    output = run("scenarios", "show", "zeno").stdout
    Path("elsewhere/mine.toml").write_text(output)
    Path("times.txt").write_text("0\n0.25\n")
    run("simulate", "elsewhere/mine.toml", "--times", "times.txt", "--output", "a.nc")
    np.testing.assert_array_equal(ll.load("a.nc").time, [0.0, 0.25])


def test_a_result_file_is_run_again_to_the_same_numbers():
    run("simulate", *TOY, "--times", "0,0.3,1", "--output", "a.nc")
    run("simulate", "--from", "a.nc", "--output", "b.csv")
    np.testing.assert_array_equal(ll.load("b.csv").angle, ll.load("a.nc").angle)
    assert simulate("--from", "b.csv", "--duration", "2")["duration"] == 2.0


def test_a_result_a_picture_and_an_animation_are_written_in_one_go():
    names = ["run.csv", "run.svg", "run.gif"]
    options = zip(("--output", "--plot", "--animate"), names, strict=True)
    result = simulate(*TOY, *(part for option in options for part in option), "--speed", "4")
    assert result["files"] == names
    assert {p.name for p in Path().iterdir()} == {*names, "run.contacts.csv"}
    assert Path("run.svg").read_text().startswith("<?xml")
    assert Path("run.gif").read_bytes().startswith(b"GIF89a")


def test_a_folder_is_no_result_file_to_plot(capsys):
    assert refused(capsys, "plot", ".") == "'.' is a folder; name a file in it"


LINEAR = ["simulate", "fig02_mathieu", "--drive-amplitude", "0.5", "--drive-frequency", "6.26"]


def test_a_run_that_leaves_the_range_of_numbers_fails_with_one_warning(capsys, tmp_path):
    shape = ["--length", "1", "--initial-angle", "0.1", "--duration", "400"]
    assert cli.main([*LINEAR, *shape, "--plot", str(tmp_path / "run.png")]) == 0
    printed = capsys.readouterr()
    assert printed.err.count("\n") == 1
    assert "the motion left the range of numbers; there are no values after that" in printed.err
    assert "energy residual  unknown" in printed.out


def test_a_run_that_fails_before_its_first_sample_is_refused(capsys):
    shape = ["--length", "1", "--initial-angle", "0.1", "--times", "390,400"]
    assert cli.main([*LINEAR, *shape]) == 2
    assert "no sample and no contact is known" in capsys.readouterr().err


def test_existing_files_are_replaced():
    Path("run.nc").write_text("old")
    run("simulate", *TOY, "--output", "run.nc")
    assert ll.load("run.nc").attrs["duration"] == 1.0


def test_a_saved_run_is_plotted_beside_its_file_by_default():
    run("simulate", *TOY, "--output", "run.nc")
    assert run("plot", "run.nc").stdout == "run.png\n"
    assert Path("run.png").read_bytes().startswith(b"\x89PNG")
    run("plot", "run.nc", "--output", "other.pdf", "--animate", "run.gif", "--speed", "4")
    assert Path("other.pdf").read_bytes().startswith(b"%PDF")
    assert Path("run.gif").exists()


def test_a_run_is_differentiated_by_each_parameter_that_is_named():
    names = ["restitution", "length", "initial_offset"]
    options = [part for name in names for part in ("--sensitivity-to", name)]
    start = ["zeno", "--duration", "1", "--initial-offset", "0.3"]
    printed = run("simulate", *start, *options, "--output", "a.nc").stdout
    assert "derivatives      known" in printed
    first = ll.load("a.nc")
    assert set(first.coords) == {"time", "parameter", "parameter_unit"}
    assert first.parameter.values.tolist() == names
    assert first.parameter_unit.values.tolist() == ["1", "m", "rad"]
    assert (abs(first.angle_sensitivity[:, -1]) > 0.0).all()
    assert simulate("--from", "a.nc", "--output", "b.nc")["sensitivity_status"] == "known"
    np.testing.assert_array_equal(ll.load("b.nc").angle_sensitivity, first.angle_sensitivity)


def test_what_a_file_gives_is_called_as_there_and_what_is_typed_by_its_option(capsys, tmp_path):
    file = tmp_path / "swing.toml"
    file.write_text("[system]\nkind = 'pendulum'\nlength = -1\nmass = 0.8\n")
    for arguments, called in ([], "swing.toml: length"), (["--length", "-2"], "--length"):
        assert main(["simulate", str(file), "--duration", "1", *arguments]) == 2
        assert capsys.readouterr().err.startswith(f"latolato: {called} must lie in (0, inf) m")


def test_what_a_file_gives_is_called_as_there_beside_the_same_option():
    def run(length: float = 1.0, *, is_of_file: bool = True) -> None:
        with reading("swing", gives_values=is_of_file):
            raise ll.InputError("must be positive", parameter="length", value=-1)

    command = command_from(run, "try", "Try.")
    with pytest.raises(ll.InputError, match=r"^swing: length must be positive"):
        command.main(["--length", "2"], standalone_mode=False)
    with pytest.raises(ll.InputError, match=r"^swing: --length must be positive"):
        command.main(["--length", "2", "--no-is-of-file"], standalone_mode=False)


def test_what_is_wrong_in_a_scenario_is_called_as_there_and_what_is_typed_by_its_option(capsys):
    pair = ["simulate", "--system", "ballpair", "--duration", "1"]
    assert "no --length of its own: give --right-length and --left-length" in refused(
        capsys, *pair, "--length", "0.2"
    )
    assert "Ball needs --right-length [m]" in refused(capsys, *pair)
    path = Path("pair.toml")
    path.write_text("[system]\nkind = 'ballpair'\nlength = 0.2\n")
    told = "pair.toml: BallPair has no 'length' of its own: give right.length and left.length"
    for command in ("simulate", "sweep", "analyse floquet"):
        assert told in refused(capsys, *command.split(), str(path), "--damping", "0")
    ball = "{length = 0.2, mass = 1, radius = 0.01}"
    path.write_text(f"[system]\nkind = 'ballpair'\nright = {ball}\nleft.length = 0.2\n")
    assert "pair.toml: Ball needs 'left.mass' [kg]" in refused(capsys, "simulate", str(path))
    path.write_text(path.read_text() + "left.mass = -2\n")
    assert "pair.toml: left.mass must lie in (0, inf) kg" in refused(capsys, "simulate", str(path))
    given = ["--left-mass", "-1"]
    assert refused(capsys, "simulate", str(path), *given).startswith("--left-mass must lie in")


@pytest.mark.parametrize(
    "name, message",
    [
        ("lenght", "--sensitivity-to has no parameter 'lenght': did you mean 'length'?"),
        ("length", "--sensitivity-to names length twice"),
        ("string_restitution", "leaves no room to change: string_restitution must be 0 with"),
    ],
)
def test_a_parameter_without_derivatives_is_refused(name, message, capsys):
    options = ["--sensitivity-to", "length", "--sensitivity-to", name]
    assert message in refused(capsys, "simulate", *TOY, *options, "--output", "run.nc")


def test_without_json_the_summary_is_for_reading():
    printed = run("simulate", *TOY).stdout
    assert "status           complete" in printed
    assert "contacts         1 bottom" in printed
    assert "nothing; name a file with --output" in printed


def test_the_largest_angle_counts_swings_to_the_left():
    pendulum = ["--system", "pendulum", "--length", "1", "--mass", "1"]
    assert (
        simulate(*pendulum, "--initial-angle", "-0.5", "--duration", "0.1")["largest_angle"] == 0.5
    )


def test_json_is_strict_and_has_null_for_what_never_happened():
    printed = run("simulate", *TOY, "--json").stdout

    def refuse(constant):
        raise ValueError(constant)

    assert json.loads(printed, parse_constant=refuse)["compression_time"] is None


def test_a_warning_is_one_line_on_standard_error(capsys):
    options = ["--duration", "400", "--samples", "9", "--contact-limit", "100"]
    assert main(["simulate", *but(TOY, *options), "--json"]) == 0
    printed = capsys.readouterr()
    assert printed.err.startswith("latolato: warning: the run ")
    assert printed.err.count("\n") == 1
    assert json.loads(printed.out)["status"] != "complete"


@pytest.mark.parametrize(
    "typed, answer",
    [("trails", "did you mean 'trials'?"), ("quux", "known are app, site, simulate")],
)
def test_an_unknown_command_is_answered_with_the_closest_one(capsys, typed, answer):
    assert answer in refused(capsys, typed)


@pytest.mark.parametrize(
    "command, function",
    [
        ("trials", collect_trials),
        ("import", import_table),
        ("compare", compare_motion),
        ("synthesise", synthesise_video),
    ],
)
def test_options_of_measuring_commands_are_those_of_the_functions_they_call(command, function):
    printed = run(command, "--help").stdout
    options = options_of(function, without=(*LAWS, "sources", "path", "run", "notes", "questions"))
    # How often a comparison computes depends on its kind.
    for name in options.keys() - ({"draws", "seed"} if command == "compare" else set()):
        assert re.search(rf"{options[name].flag} +(VALUE|<int>|U,V)", printed), name


def test_a_pivot_that_is_no_place_is_quoted_as_typed(capsys):
    assert "such as 640,200, got '3'" in refused(capsys, "trials", ".", "--pivot", "3")


def test_all_shipped_scenarios_are_listed_and_printed():
    listed = run("scenarios").stdout.splitlines()
    assert [line.split()[0] for line in listed] == list(scenarios())
    output = run("scenarios", "show", "zeno").stdout
    Path("mine.toml").write_text(output)
    assert ll.load_scenario("mine.toml").system == ll.load_scenario("zeno").system


def test_every_parameter_of_every_law_is_an_option():
    paths = {(option.owner, *option.path) for option in law_options().values()}
    for part, registry in (("system", systems), ("drive", drives)):
        for law in registry.values():
            for field in dataclasses.fields(law):
                if field.init and field.name not in ("right", "left"):
                    assert (part, field.name) in paths
    for field in dataclasses.fields(ll.Ball):
        assert {("system", "right", field.name), ("system", "left", field.name)} <= paths
    for field in dataclasses.fields(ll.VelocityKicks):
        assert ("noise", field.name) in paths


@pytest.mark.parametrize(
    "command", [[], ["simulate"], ["scenarios"], ["plot"], ["reproduce"], ["cite"]]
)
def test_help_is_printed_with_code_0(command):
    assert "Usage: " in run(*command, "--help").stdout


def test_without_a_command_help_is_printed():
    assert run().stdout == run("--help").stdout


def test_the_version_is_printed():
    first, second = run("--version").stdout.splitlines()
    assert first == f"latolato {ll.__version__}"
    processor = shipped.this_processor()
    lanes = shipped.tuned_for_lanes(processor).name
    assert second == f"compiles for {processor.name}, lanes as for {lanes}"


def test_the_citation_names_software_and_paper_as_the_citation_file_does():
    printed = run("cite").stdout
    file = (Path(__file__).parents[2] / "CITATION.cff").read_text(encoding="utf-8")
    title = "Parametric resonance and nonlinear dynamics in a coupled double-pendulum system"
    for text in (title, "The latolato developers", ll.__version__):
        assert text in file
        assert text in printed
    for family in ("Niu", "Liu", "Fan", "Bai", "Zhang"):
        assert f"family-names: {family}" in file
        assert family in printed
    assert printed == ll.cite() + "\n"


def test_reproduce_hands_folder_and_quickness_on_and_prints_claims(monkeypatch):
    from latolato.paper import report
    from latolato.paper.claim import Claim, Verdict

    claim = Claim(
        name="tension", where="Fig. 1", words="the string is tight", finding="it is slack for 1 s",
        criteria=(("slack: 1 s (at most 0 s)", False),), assumption="", why="",
        verdict=Verdict.NOT_AS_PRINTED, numbers={"compression": math.inf},
    )  # fmt: skip
    calls = []

    def reproduce(folder, *, quick, full, progress, paper):
        calls.append((folder, quick, full))
        return report.Result(folder / "index.html", (claim,), ("Figure 7: no videos",))

    monkeypatch.setattr(report, "reproduce", reproduce)
    printed = run("reproduce", "--quick", "--output", "there").stdout
    assert calls == [(Path("there"), True, False)]
    assert "the string is tight" in printed
    assert "Figure 7: no videos" in printed
    assert printed.endswith(f"{Path('there') / 'index.html'}\n")
    summary = json.loads(run("reproduce", "--output", "there", "--json").stdout)
    assert summary["claims"][0]["verdict"] == "not as printed"
    assert summary["claims"][0]["numbers"] == {"compression": None}
    assert summary["left_out"] == ["Figure 7: no videos"]
    assert summary["files"] == [str(Path("there") / "index.html")]


def test_a_bar_is_drawn_on_a_screen_for_long_work_only(monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    with progress.bar("working") as show:
        show(0.5)
        assert capsys.readouterr().err == ""
        monkeypatch.setattr(progress, "_PATIENCE", 0.0)
        show(1.0)
    assert capsys.readouterr().out == ""  # standard output stays for results


def test_starting_imports_nothing_heavy():
    heavy = [
        "matplotlib",
        "pint",
        "numba",
        "xarray",
        "pandas",
        "scipy",
        "rich",
        "h5py",
        "av",
        "PIL",
    ]
    code = f"import sys, latolato.cli; print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_a_run_without_pictures_loads_no_more_than_it_needs():
    code = (
        "import json, sys; from latolato.cli.main import main\n"
        "main(['simulate', 'zeno', '--duration', '2 s', '--output', 'run.nc'])\n"
        "heavy = 'matplotlib', 'xarray', 'pandas', 'dask', 'numba', 'scipy'\n"
        "print('loaded', json.dumps([name for name in heavy if name in sys.modules]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "loaded []"


def test_the_installed_command_runs_main():
    script = Path(sys.executable).with_name("latolato.exe" if os.name == "nt" else "latolato")
    assert script.exists(), "install the package beside this Python, as `make test` does"
    done = subprocess.run([script, "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith(f"latolato {ll.__version__}\n")
