"""`latolato sweep` and `latolato plot` of maps: options, scenarios, stores, refusals, Ctrl-C."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import latolato as ll
from latolato.cli.main import app, main
from latolato.cli.sweep import lines_of
from latolato.io.progress import SweepProgress
from latolato.scenario.scenario import Scenario
from latolato.scenario.variation import parse_axes, tables_of_plan
from latolato.sweeps.plan import make_plan
from latolato.sweeps.points import arguments_of

COMMAND = [sys.executable, "-m", "latolato"]
PENDULUM = ["--system", "pendulum", "--length", "1", "--mass", "0.8", "--initial-angle", "0.1"]
A0 = ["--axis", "drive_amplitude = 0 : 10 : 3 cm"]
RATIO = ["--axis", "frequency-ratio = 1.9, 2"]
BOTH = [*PENDULUM, *A0, *RATIO, "--duration", "2"]
SYSTEM = {"kind": "pendulum", "length": "1 m", "mass": 0.8}
TOML = """
[system]
kind = "latolato"
length = "24.5 cm"
mass = 0.1
[run]
initial_offset = "1 deg"
[sweep]
duration = "1 s"
observables = ["mean_energy", { kind = "crossings", crossing_angle = "90 deg" }]
transient = "500 ms"
[sweep.axes]
drive_amplitude = "5 mm : 0.02 m : 4"
drive_frequency = { low = "1 Hz", high = "4 Hz", count = 3, spacing = "log" }
radius = ["1 cm", 0.02]
"""


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


def axes_of(axes, system=SYSTEM, **tables):
    """The axes of a scenario's plan: name to columns."""
    tables = {"run": {"initial_angle": 0.1, "duration": 1}, **tables}
    plan = Scenario.from_dict({"system": system, **tables, "sweep": {"axes": axes}}).plan()
    return {axis.name: dict(zip(axis.parameters, axis.values, strict=True)) for axis in plan.axes}


def test_a_sweep_by_options_is_that_of_python():
    found = json.loads(run("sweep", *BOTH, "--output", "map.nc", "--json"))
    wanted = ll.sweep(
        ll.Pendulum(length=1.0, mass=0.8),
        axes={"drive_amplitude": [0.0, 0.05, 0.1], "frequency_ratio": [1.9, 2.0]},
        initial_angle=0.1,
        duration=2.0,
    )
    xr.testing.assert_identical(ll.load("map.nc"), wanted)
    assert found["points"] == 6
    assert found["axes"] == {"drive_amplitude": 3, "frequency_ratio": 2}
    assert found["status"] == {"converged": 6}
    assert found["files"] == ["map.nc"]
    energy = wanted.mean_energy
    assert found["ranges"]["mean_energy"] == [float(energy.min()), float(energy.max())]


def test_a_scenario_file_gives_units_spacings_and_observables():
    Path("mine.toml").write_text(TOML)
    plan = ll.load_scenario("mine.toml").plan()
    amplitude, frequency, radius = (axis.values[0] for axis in plan.axes)
    np.testing.assert_allclose(amplitude, [0.005, 0.01, 0.015, 0.02], rtol=1e-15)
    np.testing.assert_allclose(frequency, 2 * np.pi * np.array([1, 2, 4]), rtol=1e-14)
    assert radius == (0.01, 0.02)
    assert plan.observables == (ll.MeanEnergy(), ll.Crossings(crossing_angle=np.pi / 2))
    assert (plan.duration, plan.transient) == (1.0, 0.5)
    assert dict(plan.start)["initial_offset"] == pytest.approx(np.pi / 180)
    assert isinstance(plan.drive, ll.Harmonic)


@pytest.mark.parametrize(
    "given, values",
    [
        ("0 : 0.2 : 3 m", (0.0, 0.1, 0.2)),
        ("0 m : 20 cm : 3", (0.0, 0.1, 0.2)),
        ("1 mm : 100 mm : 3 log", (0.001, 0.01, 0.1)),
        ("1 : 100 : 3 log mm", (0.001, 0.01, 0.1)),
        ("0.2 : 0 : 3", (0.2, 0.1, 0.0)),
        ("1 cm, 2 cm", (0.01, 0.02)),
        (["1 cm", 0.02], (0.01, 0.02)),
        ({"low": 0, "high": "2 cm", "count": 3}, (0.0, 0.01, 0.02)),
        (np.array([0.1, 0.2]), (0.1, 0.2)),
    ],
    ids=str,
)
def test_an_axis_is_written_in_many_ways(given, values):
    found = axes_of({"drive_amplitude": given, "frequency_ratio": [2.0]})
    np.testing.assert_allclose(found["drive_amplitude"]["drive_amplitude"], values, rtol=1e-14)


def test_parameters_vary_together_by_option_and_in_a_file():
    case = {"length": ["20 cm", "30 cm"], "mass": [0.1, 0.2]}
    wanted = {"case": {"length": (0.2, 0.3), "mass": (0.1, 0.2)}}
    system = {"kind": "pendulum"}  # needs no values for what varies
    assert axes_of({"case": case}, system) == wanted
    text = "case: length = 20 cm, 30 cm; mass = 0.1, 0.2"
    assert axes_of(parse_axes([text]), system) == wanted


def test_a_column_of_a_file_is_an_axis():
    Path("trials.csv").write_text("set,drive_frequency\n1,12.5\n2,13\n")
    found = axes_of({"drive_frequency": "trials.csv:drive_frequency", "drive_amplitude": [0.01]})
    assert found["drive_frequency"]["drive_frequency"] == (12.5, 13.0)


def test_options_replace_axes_that_set_the_same_thing_and_values_fix_them():
    few = ["--axis", "drive_frequency = 5, 6", "--drive-amplitude", "20 cm", "--duration", "1"]
    run("sweep", "fig03cd", *few, "--observable", "largest_angle", "--output", "map.nc")
    grid = ll.load("map.nc")
    assert grid.largest_angle.dims == ("drive_frequency",)
    assert grid.attrs["drive_amplitude"] == 0.2
    one = ll.simulate(
        ll.Pendulum(length=1.0, mass=0.8),
        ll.Harmonic(drive_amplitude=0.2, drive_frequency=6.0),
        initial_angle=grid.attrs["initial_angle"],
        duration=1.0,
    )
    # the tolerance of sweeps, and the run's sampling of its maximum
    assert float(grid.largest_angle[1]) == pytest.approx(float(abs(one.angle).max()), abs=1e-4)


def test_a_finished_sweep_prints_counts_ranges_and_files():
    printed = run("sweep", *BOTH, "--store", "map.zarr", "--plot", "map.png")
    assert "status           6 converged\n" in printed
    assert "axes             drive_amplitude 3 x frequency_ratio 2\n" in printed
    assert "written          map.zarr, map.png\n" in printed
    assert Path("map.png").read_bytes().startswith(b"\x89PNG")


def test_contact_words_are_counted_instead_of_their_numbers():
    words = "BT", "B", "BB", "T", "R", "S", "BR", "TR", "BTR", "no word"
    counts = {word: 10 - k for k, word in enumerate(words)}
    summary = {
        "system": "latolato", "drive": "harmonic", "duration": 1.0, "axes": {"gravity": 55},
        "points": 55, "status": {"converged": 55}, "first_invalid": "", "wall_time": 1.0,
        "ranges": {"contact_word": [0.0, 70.0]}, "contact_words": counts,
    }  # fmt: skip
    found = lines_of(summary)["contact_word"]
    assert found == "10 BT, 9 B, 8 BB, 7 T, 6 R, 5 S, 4 BR, 3 TR, 3 others"
    few = lines_of({**summary, "contact_words": {"BT": 1, "no word": 2}})
    assert few["contact_word"] == "1 BT, 2 no word"


def test_points_without_an_answer_are_counted_and_warned_of(capsys):
    toy = ["--system", "latolato", "--length", "1", "--mass", "1", "--initial-angle", "0.5"]
    axis = ["--axis", "radius = 0.1, 0.2, 0.6"]  # the last ball begins inside the other
    assert main(["sweep", *toy, *axis, "--duration", "1"]) == 0
    printed = capsys.readouterr()
    assert "1 of 3 points have no answer: 1 invalid (initial_angle must lie" in printed.err
    assert "2 converged, 1 invalid (initial_angle must lie" in printed.out


def test_a_store_is_shown_and_run_again_with_changes():
    run("sweep", *BOTH, "--store", "map.zarr")
    shown = json.loads(run("sweep", "--status", "map.zarr", "--json"))
    assert (shown["complete"], shown["points_done"]) == (True, 6)
    printed = run("sweep", "--status", "map.zarr")
    assert "chunks           1 of 1 done" in printed
    assert "go on with" not in printed
    run("sweep", "--from", "map.zarr", "--output", "again.nc")
    again = ll.load("again.nc")
    np.testing.assert_array_equal(again.mean_energy, ll.load("map.zarr").mean_energy)
    run("sweep", "--from", "again.nc", "--duration", "1", "--output", "short.nc")
    assert ll.load("short.nc").attrs["duration"] == 1.0
    assert ll.load("short.nc").sizes == again.sizes


@pytest.mark.parametrize(
    "system, options",
    [
        (ll.Pendulum(length=1.0, mass=0.8), {"initial_angle": 0.1}),
        (
            ll.LatoLato(length=1.0, mass=0.8, radius=0.1),
            {
                "initial_offset": 0.1,
                "contact": ll.ClampContact(clamp_step=2e-3),
                "transient_periods": 2.0,
            },
        ),
        (
            ll.BallPair(
                right=ll.Ball(length=1.0, mass=0.8, radius=0.1),
                left=ll.Ball(length=1.0, mass=0.7, radius=0.1),
            ),
            {
                "initial_angle": (0.3, -0.2),
                "noise": ll.VelocityKicks(noise_strength=1e-3, noise_seed=2),
            },
        ),
        (
            ll.LatoLato(
                **{"length": 1.0, "mass": 0.8, "radius": 0.1, "drag_frame": "lab"},
                suspension="string",
                string_restitution=0.9,
            ),
            {"initial_angle": 0.3, "initial_distance": 0.9},
        ),
        (
            ll.BallPair(
                right=ll.Ball(length=1.0, mass=0.8, radius=0.1),
                left=ll.Ball(length=1.0, mass=0.7, radius=0.1),
                suspension="string",
            ),
            {"initial_angle": (0.3, -0.2), "initial_distance": (0.9, 1.0)},
        ),
    ],
    ids=["pendulum", "clamp", "pair", "strings", "two strings"],
)
def test_the_tables_of_a_plan_make_the_same_plan(system, options):
    axes = {"drive_amplitude": [0.1, 0.2], "case": {"frequency_ratio": [1, 2], "gravity": [9, 10]}}
    observables = ["mean_energy", ll.Crossings(crossing_angle=1.0, unwrapped=True)]
    plan = make_plan(system, axes=axes, observables=observables, duration=3.0, **options)
    assert Scenario.from_dict(json.loads(json.dumps(tables_of_plan(plan)))).plan() == plan


def test_strings_and_distances_vary_along_axes():
    toy = {**SYSTEM, "kind": "latolato", "radius": "10 cm", "suspension": "string"}
    axes = {"string_restitution": "0 : 1 : 3", "initial_distance": "80 cm, 1 m"}
    tables = {"system": toy, "run": {"initial_angle": 0.5, "duration": 1}, "sweep": {"axes": axes}}
    plan = Scenario.from_dict(tables).plan()
    assert {axis.name: axis.values[0] for axis in plan.axes} == {
        "string_restitution": (0.0, 0.5, 1.0), "initial_distance": (0.8, 1.0)
    }  # fmt: skip
    points = [arguments_of(plan, number) for number in range(plan.size)]
    assert [point["initial_distance"] for point in points] == [0.8, 1.0] * 3
    assert [p["system"].string_restitution for p in points] == [0.0, 0.0, 0.5, 0.5, 1.0, 1.0]


def test_one_of_two_strings_begins_slack():
    ball = {"length": "1 m", "mass": 0.8, "radius": "10 cm"}
    pair = {"kind": "ballpair", "right": ball, "left": ball, "suspension": "string"}
    run = {"initial_angle": [0.5, -0.5], "duration": 1}
    sweep = {"axes": {"initial_distance_left": [0.5, 0.9]}}
    plan = Scenario.from_dict({"system": pair, "run": run, "sweep": sweep}).plan()
    assert [arguments_of(plan, k)["initial_distance"] for k in (0, 1)] == [(1.0, 0.5), (1.0, 0.9)]


def refused(capsys, *arguments):
    """The one line that `main` prints for bad input; nothing else may happen."""
    before = sorted(Path().rglob("*"))
    assert main([str(a) for a in arguments]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1, printed.err
    assert sorted(Path().rglob("*")) == before
    return printed.err.removeprefix("latolato: ").rstrip("\n")


BAD = [
    ([*PENDULUM, "--duration", "1"], "nothing to vary; give axes"),
    (["zeno"], "'zeno' names nothing to vary; give axes"),
    (
        [*PENDULUM, *RATIO, "--axis", "drive_amplitude=0:1:0 m"],
        "axis drive_amplitude needs at least one value",
    ),
    (
        [*PENDULUM, *RATIO, "--axis", "drive_amplitude=0:1:1 m"],
        "needs at least 2 values to go from",
    ),
    ([*PENDULUM, *RATIO, "--axis", "drive_amplitude=0:1:-3"], "must have 1 to 10000000 values"),
    ([*PENDULUM, *RATIO, "--axis", "drive_amplitude=0:1:x"], "needs a whole number of values"),
    ([*PENDULUM, *RATIO, "--axis", "drive_amplitude=0:1:1e9"], "needs a whole number of values"),
    ([*PENDULUM, *RATIO, "--axis", "drive_amplitude=0:1"], "must be low : high : count or a list"),
    ([*PENDULUM, *RATIO, "--axis", "drive_amplitude=0:1:3 kg"], "must be given in m"),
    ([*PENDULUM, *RATIO, "--axis", "drive_amplitude=1 m:2:3"], "must carry a unit on every value"),
    ([*PENDULUM, *RATIO, "--axis", "drive_amplitude=0:1:3 log m"], "log spacing must lie above 0"),
    ([*PENDULUM, *RATIO, "--axis", "drive_amplitude=nan:1:3"], "must be a number in m, got nan"),
    (
        [*PENDULUM, *RATIO, "--axis", "drive_amplitude=1,2,1"],
        "must not repeat a value, got 1 twice",
    ),
    ([*PENDULUM, *RATIO, "--axis", "drive_amplitude"], "an axis must be NAME=VALUES"),
    ([*PENDULUM, *A0, *A0], "axis drive_amplitude must be given once"),
    ([*PENDULUM, "--axis", "drive_amplitud=1,2"], "did you mean 'drive_amplitude'?"),
    ([*PENDULUM, "--axis", "radius=1,2"], "unknown parameter 'radius' in axes"),
    (
        [*PENDULUM, "--axis", "string_restitution = 0 : 1 : 3"],
        "string_restitution is for balls on strings: a rod",
    ),
    (
        [*PENDULUM, "--axis", "suspension = rod, string"],
        "suspension is 'rod' or 'string', but an axis varies numbers only; run one sweep for each",
    ),
    ([*PENDULUM, *A0], "axis drive_amplitude needs a drive"),
    ([*BOTH, "--axis", "drive_frequency=1,2"], "both set drive_frequency: drop one"),
    ([*BOTH, "--drive-amplitude", "1"], "given as a value and varied along axis drive_amplitude"),
    ([*BOTH, "--observable", "mean_enrgy"], "did you mean 'mean_energy'?"),
    ([*BOTH, "--observable", "crossings(angle=1)"], "unknown parameter 'angle' of Crossings"),
    ([*BOTH, "--observable", "crossings(crossing_angle=1 m)"], "must be given in rad"),
    ([*BOTH, "--transient", "2"], "transient must be shorter than --duration"),
    ([*BOTH, "--continuation", "frequency"], "continuation must name an axis"),
    ([*BOTH, "--direction", "down"], "direction 'down' needs a continuation"),
    (
        [*PENDULUM, *A0, "--axis", "frequency_ratio=2,1,3", "--continuation", "frequency_ratio"],
        "must increase or decrease steadily to be followed; sort the values",
    ),
    ([*BOTH, "--executor", "thread"], "unknown executor 'thread': did you mean 'threads'?"),
    ([*BOTH, "--workers", "0"], "workers must lie in [1, 2^63)"),
    ([*BOTH, "--executor", "reference", "--workers", "2"], "--workers belongs to executor threads"),
    ([*BOTH, "--address", "tcp://x:1"], "--address belongs to executor dask, not to threads"),
    ([*BOTH, "--output", "map.csv"], "the name of a map must end in .nc, .zarr"),
    ([*BOTH, "--output", "no/map.nc"], "the folder 'no' does not exist"),
    ([*BOTH, "--store", "no/map.zarr"], "the folder 'no' does not exist"),
    ([*BOTH, "--store", "a.zarr", "--output", "b.zarr"], "give one store"),
    ([*BOTH, "--plot", "map.jpg"], "the name of a picture must end in"),
    ([*BOTH, "--plot", "map.png", "--variable", "x"], "unknown variable 'x'"),
    ([*BOTH, "--variable", "crossings"], "--variable names what --plot shows"),
    (
        [*PENDULUM[:4], *PENDULUM[6:], *A0, *RATIO, "--axis", "mass=1,2", "--plot", "map.png"],
        "mean_energy varies over drive_amplitude (3), frequency_ratio (2), mass (2)",
    ),
    (["--status", "no.zarr"], "there is no store 'no.zarr'"),
    (["fig05", "--status", "no.zarr"], "leave out a scenario"),
    (["fig05", "--verify", "no.zarr"], "--verify only looks at a store; leave out a scenario"),
    (["--status", "a.zarr", "--verify", "b.zarr"], "leave out --verify"),
    (["--verify", "no.zarr"], "there is no store 'no.zarr'"),
    (["fig05", "--from", "no.zarr"], "give either a scenario or --from, not both"),
    (["--from", "no.zarr"], "there is no store 'no.zarr'"),
    (["fig05", "--times", "1,2"], "No such option: --times"),
    (["fig05", "--duration", "1", "--duration", "2"], "option --duration must be given once"),
]


@pytest.mark.parametrize("arguments, message", BAD, ids=[m[:50] for _, m in BAD])
def test_bad_input_gives_one_line_and_writes_nothing(arguments, message, capsys):
    asked = [] if {"--output", "--status", "--store"} & set(arguments) else ["--store", "map.zarr"]
    if "--duration" not in arguments and "--system" in arguments and "nothing" not in message:
        asked += ["--duration", "2"]
    assert message in refused(capsys, "sweep", *arguments, *asked)


@pytest.mark.parametrize(
    "text, message",
    [
        ("axs = {}", "unknown entry 'axs' of [sweep]: did you mean 'axes'?"),
        ("axes = 3", "axes must be a table of names and values, got 3"),
        ("axes.length = []", "axis length needs at least one value"),
        ("axes.length = 1", "axis length must hold numbers in m, got 1"),
        ("axes.length = {low = 1, high = 2}", "axis length needs 'count' beside low, high"),
        ("axes.length = {low = 1, hihg = 2}", "unknown entry 'hihg' of axis length: did you mean"),
        ("axes.length = {low = 1, high = 2, count = 2.5}", "must be a whole number, got 2.5"),
        ("axes.x = {length = [1, 2], mass = [1]}", "must be equally many, got length 2, mass 1"),
        ("axes.length = [1, 2]\nobservables = 3", "observables must be a list of names or tables"),
        ("axes.length = [1, 2]\nduration = 3", "give duration either in [run] or in [sweep]"),
        ("axes.length = [1, 2]\ntransient = '1 m'", "transient must be given in s"),
    ],
)
def test_a_bad_table_gives_one_line_and_writes_nothing(text, message, capsys):
    head = "[system]\nkind = 'pendulum'\nmass = 1\n[run]\ninitial_angle = 1\nduration = 1\n"
    Path("mine.toml").write_text(f"{head}[sweep]\n{text}\n")
    assert message in refused(capsys, "sweep", "mine.toml", "--store", "map.zarr")


def test_a_foreign_store_is_refused_and_kept(capsys):
    run("sweep", *BOTH, "--store", "map.zarr")
    said = refused(capsys, "sweep", *BOTH[:-1], "3", "--store", "map.zarr")
    assert "holds another sweep: duration is 2.0, not 3.0" in said


def test_verify_says_what_is_damaged_and_how_to_repair_it(capsys):
    few = ["--axis", "gravity = 9.7, 9.8", "--duration", "0.05", "--executor", "reference"]
    run("sweep", *PENDULUM, *few, "--observable", "largest_angle", "--store", "map.zarr")
    assert main(["sweep", "--verify", "map.zarr"]) == 0
    sound = capsys.readouterr().out
    assert "state            complete" in sound
    assert "read, none damaged or missing" in sound
    assert "repair with" not in sound
    for name in ("largest_angle/c/0", "gravity/c/0", "zarr.json"):
        content = bytearray(Path("map.zarr", name).read_bytes())
        content[-7] ^= 1
        Path("map.zarr", name).write_bytes(content)
    assert main(["sweep", "--verify", "map.zarr"]) == 1
    printed = " ".join(capsys.readouterr().out.split())
    assert "read, 3 damaged or missing" in printed
    assert "damaged chunk c/0 of gravity" in printed
    assert "chunk c/0 of largest_angle, part of chunk 0 of the sweep zarr.json" in printed
    way = "latolato sweep --from map.zarr --store map.zarr --executor reference"
    assert f"repair with {way}" in printed
    assert main(["sweep", "--verify", "map.zarr", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert [each["number"] for each in found["damaged"]] == [None, 0, None]
    assert main(way.split()[1:]) == 0
    assert "repaired the store 'map.zarr'" in capsys.readouterr().err
    assert main(["sweep", "--verify", "map.zarr"]) == 0


def test_a_damaged_store_is_refused_in_one_line(capsys):
    few = ["--axis", "gravity = 9.7, 9.8", "--duration", "0.05", "--executor", "reference"]
    run("sweep", *PENDULUM, *few, "--observable", "largest_angle", "--store", "map.zarr")
    file = Path("map.zarr", "largest_angle", "c", "0")
    file.write_bytes(file.read_bytes()[:-1])
    said = refused(capsys, "plot", "map.zarr", "--output", "map.svg")
    assert "chunk c/0 of largest_angle is damaged in the store 'map.zarr'; 'latolato sweep" in said


def test_a_sweep_is_no_single_run(capsys):
    said = refused(capsys, "simulate", "fig05", "--output", "run.nc")
    assert said.startswith("fig05 is a sweep over drive_amplitude, frequency_ratio, not one run")
    assert "`latolato sweep fig05`" in said


def test_sweeps_are_marked_in_the_list_of_scenarios():
    kinds = {line.split()[0]: line.split()[1] for line in run("scenarios").splitlines()}
    assert (kinds["fig05"], kinds["fig04a"]) == ("sweep", "run")


@pytest.mark.skipif(sys.platform == "win32", reason="signals are others on Windows")
def test_ctrl_c_keeps_the_store_and_says_how_to_go_on():
    long = ["sweep", *PENDULUM, "--axis", "drive_amplitude=0:0.1:40 m", "--duration", "3000"]
    long += ["--axis", "frequency_ratio=1:3:40", "--chunk-size", "8", "--store", "map.zarr"]
    process = subprocess.Popen(
        [*COMMAND, *long], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    begun = time.monotonic()
    while len(list(Path().glob("map.zarr/.latolato/chunks/*.json"))) < 2:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() - begun < 120.0  # a first run compiles its kernels
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    printed, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert printed == ""
    assert said.count("\n") == 1
    assert "go on with: latolato sweep --from map.zarr --store map.zarr" in said
    shown = run("sweep", "--status", "map.zarr")
    assert "state            unfinished, no process is writing it" in shown
    assert "go on with       latolato sweep --from map.zarr --store map.zarr" in shown
    state = json.loads(run("sweep", "--status", "map.zarr", "--json"))
    assert 2 <= state["chunks_done"] < state["chunks"]


def test_progress_tells_rate_and_remaining_time_on_a_screen(monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    now = 0.0
    monkeypatch.setattr("latolato.io.progress.time.monotonic", lambda: now)
    with SweepProgress() as progress:
        progress(0, 1000)
        now = 20.0  # the first chunk, compiling included, tells no rate
        progress(100, 1000)
        now = 24.0
        progress(200, 1000)
        assert progress.pace() == "25 points/s, 32 s left"
    printed = capsys.readouterr()
    assert printed.out == ""
    assert "200/1000" in printed.err


def test_maps_are_drawn_from_stores_and_files():
    run("sweep", *BOTH, "--axis", "damping = 0, 0.1", "--store", "map.zarr", "--output", "map.nc")
    asked = ["--select", "damping=0.1", "--overlay", "tongue", "--log", "--output", "a.svg"]
    assert run("plot", "map.zarr", *asked) == "a.svg\n"
    curves = ["--variable", "largest_angle", "--curves", "--select", "damping=0"]
    assert run("plot", "map.nc", *curves) == "map.png\n"
    Path("t.csv").write_text("drive_amplitude,frequency_ratio,class\n1 cm,1.95,weak\n")
    points = ["--points", "t.csv", "--select", "drive-amplitude=5 cm", "--output", "b.pdf"]
    with pytest.raises(ValueError, match="need a map of amplitude"):
        run("plot", "map.nc", *points)


@pytest.mark.parametrize(
    "options, message",
    [
        (["--animate", "a.gif"], "'map.nc' holds a map: only a run can be animated"),
        (["--variable", "x"], "unknown variable 'x'"),
        (["--select", "mass"], "--select must be NAME=VALUE"),
        (["--select", "mass=1"], "mean_energy has no dimension 'mass'"),
        (["--select", "frequency_ratio=9"], "frequency_ratio runs from 1.9 to 2 here, got 9"),
        (["--select", "drive_amplitude=9 kg"], "drive_amplitude must be given in m"),
    ],
)
def test_bad_input_to_a_picture_gives_one_line(options, message, capsys):
    run("sweep", *BOTH, "--output", "map.nc")
    assert message in refused(capsys, "plot", "map.nc", *options)


def test_a_run_is_not_drawn_as_a_map(capsys):
    run("simulate", "zeno", "--output", "run.nc")
    said = refused(capsys, "plot", "run.nc", "--log", "--overlay", "tongue")
    assert "'run.nc' holds a run: --log, --overlay only fits a map" in said


def test_a_sweep_that_cannot_begin_leaves_no_store(capsys):
    pytest.importorskip("distributed")
    said = refused(
        capsys,
        *("sweep", *BOTH, "--executor", "dask", "--address", "tcp://127.0.0.1:1"),
        *("--store", "map.zarr"),
    )
    assert "no Dask scheduler answers at 'tcp://127.0.0.1:1'" in said
