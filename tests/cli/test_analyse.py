"""`latolato analyse`: options made from signatures, scenarios, files, refusals in one line."""

import inspect
import json
import math
import re
import subprocess
import sys
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import latolato as ll
from latolato.analysis import analyses
from latolato.analysis.floquet import floquet
from latolato.analysis.registry import labelled, recorded
from latolato.analysis.summary import as_lines, summarise
from latolato.cli.analyse import AnalysisCall, Targets
from latolato.cli.analyse import run as run_question
from latolato.cli.main import app, main
from latolato.core.parameters import UnitOf, parameter_texts
from latolato.core.quantities import Quantity
from latolato.io.analysis_tables import load_curves
from latolato.io.progress import working
from latolato.scenario.analysis_options import LAWS, options_of, read_value, summary_of

PENDULUM = ["--system", "pendulum", "--length", "1 m", "--mass", "800 g", "--damping", "0.05"]
SHAKE = ["--drive-amplitude", "5 cm", "--drive-frequency", "6"]
SYSTEM = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
DRIVE = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.0)


CURVE = ["bifurcation_curve", *PENDULUM, "--drive-amplitude", "5 cm", "--frequency-ratio", "1.91",
         "--kind", "period_doubling", "--points", "3"]  # fmt: skip


@pytest.fixture(autouse=True)
def _folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def run(*arguments):
    """Standard output of the command line in this process."""
    done = CliRunner().invoke(app, [str(a) for a in arguments])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    assert done.exit_code == 0, done.output
    return done.stdout


def values(*arguments):
    """What the JSON of an analysis says, by variable."""
    found = json.loads(run("analyse", *arguments, "--json"))
    return {name: about.get("values") for name, about in found["variables"].items()}


def refused(capsys, *arguments):
    """The one line that `main` prints for bad input; nothing else may happen."""
    before = sorted(Path().rglob("*"))
    assert main(["analyse", *map(str, arguments)]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("latolato: ")
    assert printed.err.count("\n") == 1
    assert sorted(Path().rglob("*")) == before
    return printed.err.removeprefix("latolato: ").rstrip("\n")


def example(
    system,
    drive=None,
    *,
    low: Annotated[float, UnitOf("parameter")],
    parameter: str = "drive_amplitude",
    dwell_times: Sequence[float] | None = None,
    counts: Sequence[int] = (1, 2),
    names: Sequence[str] = ("a",),
    noise_strength: float = 0.0,
    either: float | Sequence[float] | None = None,
    check: bool = False,
    most: int | None = None,
    duration: float = 10.0,
    table: Mapping[str, float] | None = None,
):
    """Return what `example` [1/s] was given, ``low`` [rad] and others.

    Nobody (2024).

    Parameters
    ----------
    system, drive
        Any.
    low : float
        Where it begins, in the parameter's unit.
    parameter : str
        What is varied.
    dwell_times : sequence of float, optional
        How long [s], in [0, 1].
    counts, names
        As of `latolato.simulate`.
    noise_strength, either : float
        Two things.
    check : bool
        Also check.
    most : int, optional
        A number.

    Returns
    -------
    xarray.Dataset
        ``low`` : nothing of the parameters.
    """
    given = {"low": low, "parameter": parameter, "dwell_times": dwell_times, "counts": counts}
    given |= {"names": names, "noise_strength": noise_strength, "either": either, "check": check}
    example.given = given | {"drive": drive, "most": most, "duration": duration}
    found = labelled({"low": low}, system=system, quantities={"low": Quantity("1", "", "low")})
    return recorded("floquet", found, {})


def ask(source=None, **given):
    """What `example` gets from a scenario and options."""
    question = AnalysisCall("example", example, options_of(example))
    run_question(question, source, given, Targets(None, None), as_json=True)
    return example.given


def test_without_a_name_all_analyses_are_listed_with_what_they_return():
    for text in (run("analyse"), run("analyse", "--help")):
        for name, function in analyses.items():
            assert name.replace("_", "-") in text
            assert summary_of(function).split()[0] in text


def test_both_spellings_of_both_words_are_understood():
    for one, other in (("analyse", "analyze"), ("synthesise", "synthesize")):
        assert run(one, "--help").split() == run(other, "--help").replace(other, one).split()
        assert f" {other} " not in run("--help")
    with_dash, without = (run("analyse", f"tongue{mark}edges", "--help") for mark in "-_")
    assert without.replace("tongue_edges", "tongue-edges") == with_dash


@pytest.mark.parametrize("name", analyses)
def test_every_analysis_has_help_and_an_option_for_each_parameter(name):
    text = run("analyse", name, "--help")
    own = options_of(analyses[name])
    in_python_only = {"known", "at", "progress"}  # former results, and a function
    parameters = set(inspect.signature(analyses[name]).parameters)
    assert set(own) == parameters - set(LAWS) - in_python_only
    assert all(option.flag[:20] in text for option in own.values())
    assert all(option.description for option in own.values())
    assert "`" not in text


def test_the_command_line_starts_without_any_analysis():
    code = (
        "import sys, latolato.cli; "
        "print([m for m in sys.modules if m.startswith(('latolato.analysis', 'matplotlib', "
        "'latolato.cli.main.analyse_options'))])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


def test_a_scenario_gives_system_drive_and_what_is_needed():
    found = values("tongue_edges", "fig03a")
    scenario = ll.load_scenario("fig03a")
    wanted = analyses["tongue_edges"](scenario.system, scenario.drive, drive_amplitude=0.05)
    assert found["low"] == wanted.low.item()
    assert found["high"] == wanted.high.item()


def test_options_alone_are_enough_and_may_carry_units():
    found = values("tongue_edges", *PENDULUM, "--drive-amplitude", "80 cm", "--order", "2")
    wanted = analyses["tongue_edges"](SYSTEM, drive_amplitude=0.8, order=2)
    assert found["status"] == "found"
    assert found["low"] == wanted.low.item()


def test_an_option_of_the_analysis_wins_over_that_of_the_drive():
    found = values("threshold-amplitude", "fig03a", "--frequency-ratio", "2.1")
    wanted = analyses["threshold_amplitude"](SYSTEM, DRIVE, frequency_ratio=2.1)
    assert found["drive_amplitude"] == wanted.drive_amplitude.item()


@pytest.mark.parametrize(
    "name, scenario",
    [("threshold_amplitude", "fig03a"), ("self_start", "fig04a"), ("inverted_limits", "kapitza")],
)
def test_an_answer_at_one_frequency_is_for_that_of_the_drive(name, scenario):
    law = ll.load_scenario(scenario)
    ratio = law.drive.drive_frequency / law.system.natural_frequency
    wanted = analyses[name](law.system, frequency_ratio=ratio)
    for key, found in values(name, scenario).items():
        assert found == wanted[key].item(), key


def test_options_are_made_from_the_signature_and_from_the_docstring():
    own = options_of(example)
    assert set(own) == {
        "low", "parameter", "dwell_times", "counts", "names", "noise_strength", "either", "check",
        "most", "duration",
    }  # fmt: skip
    assert own["low"].unit_of == "parameter"
    assert own["low"].is_required
    assert own["dwell_times"].unit == "s"
    assert own["noise_strength"].unit == "rad/s^(3/2)"
    assert own["dwell_times"].description == "how long, in [0, 1]"
    assert read_value(own["dwell_times"], "0 : 1 : 3 s") == [0.0, 0.5, 1.0]
    assert read_value(own["dwell_times"], "250 ms") == [0.25]
    assert read_value(own["counts"], "3, 4") == [3, 4]
    assert read_value(own["names"], "a, b") == ["a", "b"]
    assert read_value(own["either"], "2") == 2.0
    assert read_value(own["either"], "2, 3") == [2.0, 3.0]
    with pytest.raises(ValueError, match="counts must be whole numbers"):
        read_value(own["counts"], "1.5, 2")
    assert parameter_texts(inspect.getdoc(example))["either"] == "Two things."
    assert summary_of(example) == "What example (1/s) was given, low (rad) and others."


def test_a_parameter_that_cannot_be_typed_is_refused_only_if_needed():
    def needs(system, *, weights: Mapping[str, float]):
        """Return nothing."""

    with pytest.raises(TypeError, match="needs 'weights', which cannot be typed"):
        options_of(needs)


def test_a_value_may_have_the_unit_of_the_quantity_that_another_option_names(capsys):
    assert ask("fig03a", low="3 cm")["low"] == 0.03
    assert ask("fig03a", low="90 deg", parameter="initial_angle")["low"] == pytest.approx(
        math.pi / 2, rel=1e-15
    )
    with pytest.raises(ValueError, match="low must be given in m"):
        ask("fig03a", low="3 kg")


def test_what_the_scenario_says_of_the_run_is_handed_on_and_options_replace_it():
    assert ask("fig03a", low="0")["duration"] == 300.0
    assert ask("fig03a", low="0", duration="2 min")["duration"] == 120.0
    assert ask("fig04a", low="0", times="0, 5")["duration"] == 5.0


def test_noise_comes_from_the_scenario():
    def noisy(system, drive=None, *, noise_strength: float):
        """Return nothing."""
        return labelled({"a": noise_strength}, quantities={"a": Quantity("1", "", "a")})

    Path("noisy.toml").write_text(
        '[system]\nkind = "pendulum"\nlength = 1.0\nmass = 1.0\n[noise]\nnoise_strength = 0.25\n'
    )
    question = AnalysisCall("noisy", noisy, options_of(noisy))
    assert question.arguments("noisy.toml", {})["noise_strength"] == 0.25
    given = {"noise_strength": "0.5"}
    assert question.arguments("noisy.toml", given)["noise_strength"] == 0.5
    assert ask("noisy.toml", low="0")["noise_strength"] == 0.25


def test_what_a_sweep_varies_must_be_given(capsys):
    message = refused(capsys, "floquet", "fig05", "--initial-angle", "0.5")
    assert "'fig05' varies drive_amplitude, frequency_ratio: give values" in message


def test_left_out_laws_are_told_in_one_line(capsys):
    assert main(["analyse", "self_start", "fig04a_clamp", "--frequency-ratio", "2"]) == 0
    error = capsys.readouterr().err
    assert error.startswith("latolato: warning: the scenario's contact 'clamp' is left out")
    assert error.count("\n") == 1


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["floqet", "fig03a"], "unknown analysis 'floqet': did you mean 'floquet'?"),
        (["tongue_edges", "fig03"], "there is no scenario or file 'fig03'"),
        (["tongue_edges"], "name what to analyse: a scenario"),
        (["tongue_edges", *PENDULUM], "this analysis needs --drive-amplitude [m]"),
        (
            ["tongue_edges", *PENDULUM, "--drive-amplitude", "5 kg"],
            "--drive-amplitude must be given in m (or a unit that converts to it), got '5 kg'",
        ),
        (["tongue_edges", "fig03a", "--order", "-1"], "--order must"),
        (["tongue_edges", "fig03a", "--order", "one"], "Invalid value for '--order'"),
        (["tongue_edges", "fig03a", "--samples", "5"], "No such option: --samples"),
        (["tongue_edges", "fig03a", "--order", "1", "--order", "2"], "must be given once"),
        (["tongue_edges", "fig03a", "--output", "a.txt"], "the result of an analysis must end in"),
        (["tongue_edges", "fig03a", "--output", "no/a.nc"], "the folder 'no' does not exist"),
        (["tongue_edges", "fig03a", "--plot", "a.txt"], "the name of a picture must end in"),
        (["pair_symmetry", "fig04a", "--drive-amplitude", "0 : 1"], "must be low : high : count"),
        (["continue_orbit", "fig03a", "--low", "1"], "this analysis needs --high"),
        (
            ["continue_orbit", "fig03a", "--low", "3", "--high", "1"],
            "--low must be less than --high",
        ),
        (["bifurcation_diagram", "fig03a"], "this analysis needs --parameter"),
        (
            ["basins", "fig04a", "--angle-high", "0.1"],
            "--angle-low must be less than --angle-high",
        ),
        (
            ["first_push", "fig04a", "--frequency-ratio", "2, 2"],
            "--frequency-ratio must not repeat a value, got 2; remove one",
        ),
        (
            [
                "response_period_map",
                "fig04a",
                "--frequency-ratio",
                "2",
                "--drive-amplitude",
                "1, 1",
            ],
            "--drive-amplitude must not repeat a value, got 1; remove one",
        ),
        (
            ["hysteresis", "fig04a", "--drive-amplitude", "1, 1"],
            "--drive-amplitude must not repeat a value, got 1 twice; remove one",
        ),
        (
            ["continue_orbit", "fig03a", "--low", "1", "--high", "3", "--parameter", "lenght"],
            "unknown parameter 'lenght': did you mean 'length'?",
        ),
        ([*CURVE, "--low", "0", "1.8"], "need commas between them: write --low 0,1.8"),
        ([*CURVE, "--low", "0 1.8", "--high", "1,2"], "put commas between the values"),
        (
            [*CURVE, "--low", "0,1.8"],
            "needs --high; give one value for each parameter, with commas",
        ),
        (
            [*CURVE, "--low", "0,2", "--high", "0.1,2"],
            "--low must be less than --high for --frequency-ratio",
        ),
        (
            [*CURVE, "--low", "1,1", "--high", "2,3"],
            "--low and --high must enclose the --drive-amplitude of the first orbit",
        ),
        (
            [*CURVE, "--low", "0 kg,1.8", "--high", "1,2"],
            "--low (drive_amplitude) must be given in m",
        ),
        ([*CURVE, "--low", "1,2,3", "--high", "1,2"], "--low must be a value for each of both"),
    ],
)
def test_bad_input_is_refused_in_one_line_and_writes_nothing(capsys, arguments, message):
    arguments = [*arguments, *(["--output", "found.nc"] if "--output" not in arguments else [])]
    assert message in refused(capsys, *arguments)


def test_files_and_pictures_are_written_and_drawn_again():
    text = run("analyse", "floquet", *PENDULUM, *SHAKE, "--output", "a.nc", "--plot", "a.svg")
    wanted = floquet(SYSTEM, DRIVE)
    found = ll.load("a.nc")
    assert found.multipliers.dtype == complex
    xr.testing.assert_identical(found.drop_attrs(deep=False), wanted.drop_attrs(deep=False))
    assert found.attrs.keys() == wanted.attrs.keys()
    assert "unstable" in text
    assert "a.nc, a.svg" in text
    assert f"{wanted.growth_rate.item():.6g} 1/s" in text
    assert Path("a.svg").read_text().startswith("<?xml")
    assert run("plot", "a.nc").strip() == "a.png"
    assert Path("a.png").stat().st_size > 0
    # The parts of complex numbers are plain variables for other programs.
    plain = xr.load_dataset("a.nc", engine="h5netcdf")
    assert np.array_equal(plain.multipliers_real, wanted.multipliers.values.real)


def test_curves_with_a_unit_for_each_end_are_drawn_over_maps_from_tables():
    run("analyse", *CURVE, "--low", "0 mm,1.8", "--high", "10 cm,2.2", "--output", "a.csv")
    (curve,) = load_curves(Path("a.csv"))
    assert (curve.sizes["point"], curve.attrs["bifurcation"]) == (3, "period_doubling")
    assert re.findall(r"[\d.]*\d", curve.attrs["high"]) == ["0.1", "2.2"]
    axes = ["--axis", "drive_amplitude = 0, 0.1", "--axis", "frequency_ratio = 1.8, 2"]
    start = ["--initial-angle", "0.1", "--duration", "1"]
    run("sweep", *PENDULUM, *axes, *start, "--output", "map.nc")
    drawn = run("plot", "map.nc", "--overlay", "a.csv", "--overlay", "tongue", "--output", "a.svg")
    assert drawn == "a.svg\n"
    run("sweep", *PENDULUM[:-1], "0.1", *axes, *start, "--output", "other.nc")
    run("simulate", *PENDULUM, *start, "--output", "other.csv")
    for text, why in (
        ("a.csv", "is of another system"),
        ("other.csv", "'other.csv' holds no bifurcation curve"),
        ("none.csv", "there is no file 'none.csv'"),
    ):
        target = "other.nc" if text == "a.csv" else "map.nc"
        with pytest.raises((ValueError, OSError), match=why):
            run("plot", target, "--overlay", text)


def test_only_runs_are_animated_and_single_numbers_have_no_axes(capsys):
    run("analyse", "tongue_edges", "fig03a", "--output", "a.nc")
    for arguments, message in (
        (["--animate", "a.gif"], "holds an analysis: only a run can be animated"),
        (["--variable", "high"], "high is a single value"),
    ):
        assert main(["plot", "a.nc", *arguments]) == 2
        assert message in capsys.readouterr().err


def test_json_knows_no_infinity_and_shortens_long_arrays():
    names = {name: Quantity("1", "", name) for name in ("short", "long", "which", "roots")}
    found = labelled(
        {
            "short": ("a", np.array([math.nan, -math.inf, 1.0])),
            "long": ("b", np.linspace(0.0, 2.0, 1001)),
            "which": ("c", np.array(["x", "y", "x"] * 4)),
            "roots": ("d", np.array([1.0 + 2.0j])),
        },
        quantities=names,
    )
    found = recorded("floquet", found, {})
    told = json.loads(json.dumps(summarise(found), allow_nan=False))["variables"]
    assert told["short"]["values"] == [None, "-inf", 1.0]
    assert told["long"] == {"units": "1", "dims": {"b": 1001}, "range": [0.0, 2.0]}
    assert told["roots_imag"]["values"] == [2.0]
    lines = as_lines(found)
    assert lines["short"] == "no value, \N{MINUS SIGN}∞, 1"
    assert lines["long"] == "0 to 2 (1001 values)"
    assert lines["which"] == "8 x, 4 y"
    assert lines["roots"] == "1 + 2 i"


def test_a_pair_takes_two_starts_and_axes_of_its_own():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = json.loads(
            run(
                "analyse", "pair_symmetry", "fig04a", "--drive-amplitude", "10 : 20 : 2 cm",
                "--duration", "2", "--transient", "1", "--json",
            )
        )  # fmt: skip
    assert found["variables"]["drive_amplitude"]["values"] == [0.1, 0.2]
    assert found["attributes"]["duration"] == 2.0


def test_compiling_is_told_once_on_standard_error(capsys):
    numba = pytest.importorskip("numba")
    with working("adding"):
        numba.njit(lambda x: x + 1)(1)
        numba.njit(lambda x: x + 2)(1)
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("latolato: compiling")
    assert printed.err.count("\n") == 1


def test_nothing_is_told_where_nothing_compiles(capsys):
    with working("nothing"):
        pass
    assert capsys.readouterr() == ("", "")


def in_new_process(code):
    """What Python writes to standard error and says at the end."""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return done.stdout.strip(), done.stderr


def test_the_compiler_is_watched_once_kernels_need_it():
    code = (
        "from latolato.io.progress import working\n"
        "with working('adding'):\n"
        "    import latolato.numerics.jit, numba\n"
        "    numba.njit(lambda x: x + 1)(1)\n"
        "numba.njit(lambda x: x + 2)(1)\n"
    )
    told = in_new_process(code)[1]
    assert told.startswith("latolato: compiling")
    assert told.count("\n") == 1


def test_questions_without_kernels_do_without_the_compiler():
    code = (
        "import sys\n"
        "from latolato.cli.main import main\n"
        f"main(['analyse', 'tongue_edges', *{PENDULUM!r}, '--drive-amplitude', '0.05'])\n"
        "print('numba' in sys.modules)\n"
    )
    assert in_new_process(code)[0].endswith("False")


def test_json_stays_json_while_kernels_compile(tmp_path):
    command = [sys.executable, "-m", "latolato", "analyse", "growth_rate", *PENDULUM, *SHAKE]
    done = subprocess.run([*command, "--json"], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout)["analysis"] == "growth_rate"


def test_what_stands_in_the_way_of_an_answer_is_printed():
    told = run(
        "analyse", "response_period", "--system", "pendulum", "--length", "1", "--mass", "0.8",
        *SHAKE, "--initial-angle", "0.5", "--transient-periods", "5", "--longest", "2",
    )  # fmt: skip
    assert "\nmessage " in told
    assert "no period up to 2" in told
