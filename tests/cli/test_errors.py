"""Refused input and faults of the program: which is which, and how each is reported."""

import contextlib
import copy
import dataclasses
import os
import pickle
import random
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

import latolato as ll
from latolato import analysis
from latolato.cli import main as cli
from latolato.core.errors import InputError
from latolato.core.faults import refusal_of, report_of
from latolato.scenario.options import law_options
from latolato.scenario.scenario import Scenario

TOY = (
    "--system latolato --length 1 --mass 0.8 --radius 0.1 --initial-angle 0.5 --duration 1 "
    "--drive harmonic --drive-amplitude 1cm --drive-frequency 6"
)
MAP = f"{TOY} --axis 'damping = 0 : 0.1 : 3' --observable crossings --output out.nc"
COMMANDS = [
    "simulat",
    "simulate",
    "simulate nowhere",
    "simulate nowhere.toml",
    "simulate .",
    "simulate empty.toml",
    "simulate binary.toml",
    "simulate broken.toml",
    "simulate deep.toml",
    "simulate tables.toml",
    "simulate list.toml",
    "simulate number.toml",
    "simulate date.toml",
    "simulate binary.nc",
    "simulate empty.nc",
    "simulate --from binary.nc",
    "simulate --from other.csv",
    "simulate --from nowhere.nc",
    "simulate --from deep.csv",
    "simulate fig02 --output out.txt",
    "simulate fig02 --output nowhere/out.nc",
    "simulate fig02 --output .",
    "simulate fig02 --plot out.txt",
    "simulate fig02 --animate out.mov",
    "simulate fig02 --animate out.gif --speed 0",
    "simulate fig02 --animate out.gif --speed nan",
    "simulate fig02 --animate out.gif --fps -1",
    "simulate fig02 --samples 1",
    "simulate fig02 --samples many",
    "simulate fig02 --samples 1e99",
    "simulate fig02 --times 1,2,x",
    "simulate fig02 --times nowhere.csv",
    "simulate fig02 --times binary.nc",
    "simulate fig02 --times empty.toml",
    "simulate fig02 --contact glue",
    "simulate fig02 --frame moon",
    "simulate fig02 --length 1 --length 2",
    "simulate fig02 --drive",
    "simulate fig02 --drive magnet",
    "simulate fig02 --system rope",
    "simulate fig02 --drive measured_pivot --drive-times 0,1 --pivot-heights 0,0",
    "simulate fig02 --drive measured_pivot --drive-times 0,1,2,3 --pivot-heights 0,0",
    "simulate fig02 --drive crank_slider --guide sideways",
    "simulate fig02 --noise-strength -1",
    "simulate fig02 --noise-strength 1 --noise-seed -1",
    "simulate fig02 --noise-seed half",
    "simulate fig05",
    "sweep",
    "sweep fig02",
    "sweep deep.toml",
    "sweep nowhere.toml",
    "sweep --status nowhere.zarr",
    "sweep --status .",
    "sweep --status binary.nc",
    "sweep --from binary.nc",
    "sweep --from other.csv",
    f"sweep {MAP} --axis 'lenght = 1, 2'",
    f"sweep {MAP} --axis 'length'",
    f"sweep {MAP} --axis 'length = 1 : 2'",
    f"sweep {MAP} --axis 'length = 1 : 2 : 3 : 4'",
    f"sweep {MAP} --axis 'length = 1 : 2 : many'",
    f"sweep {MAP} --axis 'length = 1 : 2 : 1e99'",
    f"sweep {MAP} --axis 'length = -1 : 2 : 3 log'",
    f"sweep {MAP} --axis 'length = nan, 1'",
    f"sweep {MAP} --axis 'length = 1 kg, 2 kg'",
    f"sweep {MAP} --axis '= 1, 2'",
    f"sweep {MAP} --axis 'case: length = 1, 2; mass = 1'",
    f"sweep {MAP} --observable nothing",
    f"sweep {MAP} --observable 'crossings(angle)'",
    f"sweep {MAP} --observable 'crossings(crossing_angle = x)'",
    f"sweep {MAP} --observable 'crossings('",
    f"sweep {MAP} --executor abacus",
    f"sweep {MAP} --workers 0",
    f"sweep {MAP} --executor reference --workers 3",
    f"sweep {MAP} --chunk-size 0",
    f"sweep {MAP} --transient x",
    f"sweep {MAP} --transient 5",
    f"sweep {MAP} --continuation length",
    f"sweep {MAP} --direction sideways",
    f"sweep {MAP} --store binary.nc",
    f"sweep {MAP} --store nowhere/map.zarr",
    f"sweep {MAP} --executor dask --address nowhere",
    f"sweep {MAP} --executor dask --address tcp://127.0.0.1:1",
    "plot",
    "plot nowhere.nc",
    "plot binary.nc",
    "plot empty.nc",
    "plot other.csv",
    "plot .",
    "plot broken.toml",
    "analyse wilson-interval",
    "analyse floquet",
    "analyse floquet nowhere",
    "analyse floquet fig02 --period 0",
    "analyse floquet fig02 --period x",
    "analyse floquet deep.toml",
    "analyse tongue-edges fig02 --order half",
    "analyse tongue-edges fig02 --position sideways",
    "analyse basins fig02 --angle-points x",
    "analyse basins fig02 --output out.txt",
    "analyse continue-orbit fig02 --parameter colour --low 0 --high 1",
    "analyse growth-rate fig02 --drive-amplitude x",
    "fit decay nowhere.csv",
    "fit decay binary.nc",
    "fit decay other.csv",
    "fit decay other.csv --column time=x",
    "fit decay other.csv --column time",
    "fit drive empty.toml",
    "fit restitution deep.csv",
    "fit model other.csv",
    "import other.csv",
    "import binary.nc",
    "import other.csv --column 'time=volts'",
    "import other.csv --column 'time=volts [s]' --pivot x",
    "import nowhere.csv",
    "trials",
    "trials nowhere",
    "trials .",
    "trials other.csv",
    "trials other.csv --workers 0",
    "compare",
    "compare nowhere.csv --system pendulum",
    "compare other.csv --system pendulum --length 1 --mass 1 --initial-angle 0.1",
    "compare --trials other.csv --map binary.nc",
    "compare other.csv --fit binary.nc",
    "synthesise fig02",
    "synthesise fig02 --output out.avi",
    "synthesise fig02 --output out.mp4 --camera 'fps = -1'",
    "synthesise fig02 --output out.mp4 --scene 'colour = blue'",
    "synthesise fig02 --output out.mp4 --seed -1",
    "track nowhere.mp4 --ball 1,1",
    "track binary.nc --ball 1,1",
    "track other.csv --ball 1,1",
    "track binary.nc --ball 1",
    "track binary.nc --balls 3",
    "track binary.nc --limit frames",
    "track binary.nc --limit frames=x",
    "track binary.nc --limit colours=3",
    "track binary.nc --length x",
    "track binary.nc --sidecar broken.toml",
    "track binary.nc --jobs 0",
    "track . --ball 1,1",
    "app --report nowhere --no-browser",
    "app --open nowhere.nc --no-browser",
    "scenarios show nowhere",
    "reproduce --output other.csv",
    "cite now",
]
SCENARIO = """
[system]
kind = "latolato"
length = 1.0
mass = 0.8
radius = 0.1
[run]
initial_angle = 0.5
duration = 1.0
"""
DEPTH = 5000


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with files that are not what a command needs."""
    monkeypatch.chdir(tmp_path)
    Path("empty.toml").touch()
    Path("empty.nc").touch()
    Path("binary.toml").write_bytes(bytes(range(256)))
    Path("binary.nc").write_bytes(bytes(range(256)))
    Path("broken.toml").write_text("[system\n")
    Path("deep.toml").write_text(f"a = {'[' * DEPTH}{']' * DEPTH}\n")
    Path("tables.toml").write_text(f"[{'.'.join('a' * DEPTH)}]\nb = 1\n")
    Path("list.toml").write_text("system = [1, 2]\n")
    Path("number.toml").write_text(SCENARIO.replace("1.0", "1" * 5000, 1))
    Path("date.toml").write_text(SCENARIO.replace("1.0", "2026-01-01", 1))
    Path("other.csv").write_text("time,volts\n0,1\n1,2\n")
    Path("deep.csv").write_text(f"# scenario: {'[' * DEPTH}\ntime,angle\n0,1\n1,2\n")
    return tmp_path


def outcome(capsys, arguments):
    """The exit code of a command, and what it printed on standard error."""
    code = cli.main(arguments)
    return code, capsys.readouterr().err


@pytest.mark.parametrize("command", COMMANDS)
def test_a_bad_command_is_refused_in_one_line(command, folder, capsys):
    before = sorted(folder.iterdir())
    code, said = outcome(capsys, shlex.split(command))
    assert code == 2, said
    assert said.startswith("latolato: ")
    assert said.count("\n") == 1
    assert sorted(folder.iterdir()) == before


@pytest.mark.parametrize(
    "text", ["abc", "nan", "1e999", "-1e308", "1e31", "1 kg kg", "0,,1", "[1", "ü", ""]
)
@pytest.mark.parametrize("name", [o.name for o in law_options().values() if o.kind is not bool])
def test_a_bad_value_of_any_option_is_refused_in_one_line(name, text, folder, capsys):
    code, said = outcome(capsys, ["simulate", "fig02", f"--{name.replace('_', '-')}={text}"])
    assert code == 2, said
    assert said.startswith("latolato: ")
    assert said.count("\n") == 1


WHOLE = {
    "system": {"kind": "latolato", "length": 1.0, "mass": 0.8, "radius": 0.1},
    "drive": {"kind": "harmonic", "drive_amplitude": 0.1, "drive_frequency": 6.0},
    "noise": {"strength": 0.1, "seed": 1},
    "run": {"initial_angle": 0.5, "duration": 1.0, "contact": "exact", "times": [0.5, 1.0]},
    "sweep": {
        "axes": {"damping": {"low": 0.0, "high": 1.0, "count": 3}, "length": [1.0, 2.0]},
        "observables": ["crossings", {"kind": "crossings", "crossing_angle": 1.0}],
        "transient": 0.1,
    },
}
PLACES = [
    ("system",), ("system", "kind"), ("system", "length"), ("system", "left"), ("drive",),
    ("drive", "kind"), ("drive", "drive_amplitude"), ("drive", "times"), ("noise",),
    ("noise", "seed"), ("run",), ("run", "duration"), ("run", "times"), ("run", "contact"),
    ("run", "initial_angle"), ("run", "samples"), ("sweep",), ("sweep", "axes"),
    ("sweep", "axes", "damping"), ("sweep", "axes", "damping", "count"),
    ("sweep", "axes", "damping", "low"), ("sweep", "axes", "damping", "spacing"),
    ("sweep", "axes", "length"), ("sweep", "observables"), ("sweep", "transient"), ("name",),
    ("sweep", "continuation"), ("sweep", "chunk_size"), ("unknown",), ("run", "unknown"),
]  # fmt: skip
PLAIN = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=8),
    st.sampled_from(["1 m", "latolato", "harmonic", "crossings", "0 : 1 : 3", 10**400, "exact"]),
)  # fmt: skip
VALUES = st.recursive(
    PLAIN,
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.sampled_from(["kind", "low", "length", "x", ""]), inner, max_size=3)
    ),
    max_leaves=5,
)


@settings(max_examples=400, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(PLACES), VALUES), min_size=1, max_size=2), st.booleans())
def test_a_scenario_of_anything_is_read_or_refused(changes, is_map):
    tables = copy.deepcopy(WHOLE)
    if not is_map:
        del tables["sweep"]
    for place, value in changes:
        inner = tables
        for name in place[:-1]:
            inner = inner.setdefault(name, {}) if isinstance(inner, dict) else {}
        if isinstance(inner, dict):
            inner[place[-1]] = value
    with contextlib.suppress(InputError, OSError):
        Scenario.from_dict(tables)


# Of these bytes some take the place of a word or a number in a file.
SCRAPS = [b"", b"0", b"-1", b"nan", b"1e999", b"null", b"[]", b"{}", b",", b"\n", b"\xff", b"\0"]
TAMPERED = {
    "run.nc": ["simulate --from run.nc"],
    "run.csv": ["simulate --from run.csv"],
    "run.parquet": ["simulate --from run.parquet"],
    "map.nc": ["sweep --from map.nc"],
    "map.zarr": ["sweep --status map.zarr", "sweep --verify map.zarr", "sweep --from map.zarr"],
    "run.toml": ["simulate run.toml"],
    "table.csv": ["fit decay table.csv --length 1 --mass 1 --method equation"],
    "film.mp4": ["track film.mp4 --ball 30,30 --length 1"],
    "set-up.toml": ["track film.mp4 --sidecar set-up.toml --length 1"],
}


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A folder with one file of each kind."""
    folder = tmp_path_factory.mktemp("whole")
    (folder / "run.toml").write_text(SCENARIO)
    run = ll.simulate(SYSTEM, DRIVE, initial_angle=0.5, duration=1.0)
    for suffix in (".nc", ".csv", ".parquet"):
        ll.save(run, folder / f"run{suffix}")
    for name in ("map.nc", "map.zarr"):
        command = MAP.replace("out.nc", shlex.quote(str(folder / name)))
        assert cli.main(["sweep", *shlex.split(command)]) == 0
    filmed = "synthesise --system pendulum --length 1 --mass 1 --damping 0.1 --initial-angle 0.4"
    small = "--duration 2 --camera 'width = 96' --camera 'height = 72'"
    files = f"--output {folder / 'film.mp4'} --truth {folder / 'table.csv'}"
    assert cli.main(shlex.split(f"{filmed} {small} {files}")) == 0
    (folder / "set-up.toml").write_text("[scale]\nlength = 1.0\n[pivot]\nu = 48.0\nv = 9.0\n")
    return folder


def tampered(data, dice):
    """Bytes of which some are flipped, cut off, left out, or replaced by others."""
    changed, place = bytearray(data), dice.randrange(len(data))
    way = dice.randrange(4)
    if way == 0:
        changed[place] = dice.randrange(256)
    elif way == 1:
        del changed[place:]
    elif way == 2:
        del changed[place : place + dice.choice([1, 10, 1000])]
    else:
        words = list(re.finditer(rb"[A-Za-z_]{3,}|-?[0-9.]+", data[:100_000]))
        word = dice.choice(words)
        changed[word.start() : word.end()] = dice.choice(SCRAPS)
    return bytes(changed)


@pytest.mark.parametrize("name", TAMPERED)
def test_a_tampered_file_is_read_or_refused(name, whole, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    shutil.copytree(whole, tmp_path, dirs_exist_ok=True)
    dice = random.Random(name)
    for _ in range(6 if name in ("film.mp4", "set-up.toml") else 20):
        target = Path(name)
        if target.is_dir():
            target = dice.choice(sorted(p for p in target.rglob("*") if p.stat().st_size))
        if target.is_dir():
            continue
        content = target.read_bytes()
        target.write_bytes(tampered(content, dice))
        for command in TAMPERED[name]:
            code, said = outcome(capsys, command.split())
            assert code in (0, 1, 2), said
            assert "Traceback" not in said
        target.write_bytes(content)


def test_a_track_table_is_no_run_to_plot(whole, capsys):
    code, said = outcome(capsys, ["plot", str(whole / "table.csv")])
    assert code == 2
    assert "is a track table, not a run; see `latolato fit --help`" in said


def test_a_film_that_cannot_be_decoded_is_refused(folder, whole, capsys):
    pixels = np.random.default_rng(0).integers(0, 256, (8, 8, 3), np.uint8)
    Image.fromarray(pixels).save("picture.png")
    Path("picture.mp4").write_bytes(Path("picture.png").read_bytes())
    data = (whole / "film.mp4").read_bytes()
    start = data.index(b"mdat") + 4
    Path("damaged.mp4").write_bytes(data[:start] + bytes(1000) + data[start + 1000 :])
    for name in ("picture.mp4", "damaged.mp4"):
        code, said = outcome(capsys, ["track", name, "--ball", "3,3", "--length", "1"])
        assert code == 2, said
        assert name in said
        assert said.count("\n") == 1


SYSTEM = ll.LatoLato(length=1.0, mass=0.8, radius=0.1)
DRIVE = ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.0)
GAP = [0.0, 0.1, 0.2, 0.3, 0.4, 1e80]
CALLS = {
    "play nothing": lambda: ll.play(None),
    "play a path": lambda: ll.play("run.nc"),
    "load nothing": lambda: ll.load(None),
    "load a number": lambda: ll.load(3),
    "load a folder": lambda: ll.load("."),
    "save nowhere": lambda: ll.save(ll.simulate(SYSTEM, initial_angle=0.5, duration=0.1), None),
    "save nothing": lambda: ll.save(None, "out.nc"),
    "plot nothing": lambda: ll.plot(None),
    "animate nothing": lambda: ll.animate(None, "out.mp4"),
    "track a number": lambda: ll.track(3),
    "track with a text as length": lambda: ll.track("binary.nc", length="x"),
    "load_scenario nothing": lambda: ll.load_scenario(None),
    "a store that is a number": lambda: ll.sweep(
        SYSTEM,
        axes={"damping": [0.0]},
        duration=1.0,
        initial_angle=0.5,
        observables=["crossings"],
        store=3,
    ),
    "axes that are a number": lambda: ll.sweep(
        SYSTEM, axes=3, duration=1.0, observables=["crossings"]
    ),
    "no observables": lambda: ll.sweep(
        SYSTEM, axes={"damping": [0.0]}, duration=1.0, initial_angle=0.5, observables=None
    ),
    "an executor that is a number": lambda: ll.sweep(
        SYSTEM,
        axes={"damping": [0.0]},
        duration=1.0,
        initial_angle=0.5,
        observables=["crossings"],
        executor=3,
    ),
    "a gap in the heights": lambda: ll.MeasuredPivot(times=GAP, pivot_heights=[0.0] * 6),
    "a gap that the curve leaves by kilometres": lambda: ll.MeasuredPivot(
        times=[0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 100.0, 100.1], pivot_heights=[0.0, 0.1] * 4
    ),
    "axes by number": lambda: ll.sweep(SYSTEM, axes={3: [0.1, 0.2]}, duration=1.0),
    "progress that is no function": lambda: ll.simulate(
        SYSTEM, initial_angle=0.5, duration=1.0, progress=3
    ),
    "a share of words": lambda: analysis.wilson_interval("a", 3),
    "a gap in smoothed heights": lambda: ll.MeasuredPivot(
        times=GAP, pivot_heights=[0.0, 0.1, 0.0, 0.1, 0.0, 0.1], height_sigma=1e-3
    ),
    "two parameters": lambda: analysis.continue_orbit(
        SYSTEM, DRIVE, parameter=("damping", "mass"), low=0.0, high=1.0
    ),
    "five of three": lambda: analysis.wilson_interval(5, 3),
    "fewer than none": lambda: analysis.wilson_interval(-1, 3),
    "a name that is close": lambda: ll.Harmonic(amplitude=0.1, drive_frequency=6.0),
    "numbers without names": lambda: ll.Harmonic(0.1, 6.0),
    "a missing number": lambda: ll.Harmonic(drive_amplitude=0.1),
    "a system's wrong name": lambda: ll.Pendulum(lenght=1.0, mass=1.0),
    "a ball's wrong name": lambda: ll.Ball(lenght=1.0, mass=1.0),
    "an observable's wrong name": lambda: ll.Crossings(angle=1.0),
    "a noise's wrong name": lambda: ll.VelocityKicks(sigma=1.0),
    "a contact's wrong name": lambda: ll.ClampContact(width=1.0),
    "a system that is a name": lambda: ll.simulate("latolato", duration=1.0),
    "a drive that is a number": lambda: ll.simulate(SYSTEM, 3, initial_angle=0.5, duration=1.0),
    "a start that is a text": lambda: ll.simulate(SYSTEM, initial_angle="x", duration=1.0),
    "times that are a text": lambda: ll.simulate(SYSTEM, initial_angle=0.5, times="x"),
    "compare nothing": lambda: ll.compare(None, SYSTEM),
    "boundary of nothing": lambda: ll.map_boundary(None, "crossings", 1.0),
    "fit_decay of nothing": lambda: ll.fit_decay(None),
    "fit_drive of nothing": lambda: ll.fit_drive(None),
    "fit_model of nothing": lambda: ll.fit_model(None, SYSTEM),
    "fit_restitution of nothing": lambda: ll.fit_restitution(None, length=1.0),
    "gather no trials": lambda: ll.collect_trials([]),
    "gather a number": lambda: ll.collect_trials(3),
    "an equivalent_pendulum of a text": lambda: ll.equivalent_pendulum("x", 1.0),
    "a stability of nothing": lambda: analysis.floquet(None, DRIVE),
    "basins of nothing": lambda: analysis.basins(SYSTEM, None),
    "a tongue of a text": lambda: analysis.tongue_edges(SYSTEM, drive_amplitude=0.1, order="x"),
}


@pytest.mark.parametrize("name", CALLS)
def test_a_bad_call_is_refused_in_one_line(name, folder):
    with pytest.raises((InputError, OSError)) as caught:
        CALLS[name]()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "call, name",
    [
        (lambda: ll.Harmonic(amplitude=0.1), "drive_amplitude"),
        (lambda: ll.Pendulum(lenght=1.0), "length"),
        (lambda: ll.Ball(lenght=1.0), "length"),
        (lambda: ll.Crossings(angle=1.0), "crossing_angle"),
        (lambda: ll.VelocityKicks(noise_strenght=1.0), "noise_strength"),
    ],
)
def test_a_wrong_name_of_any_law_is_answered_with_the_closest_one(call, name):
    with pytest.raises(InputError, match=f"did you mean '{name}'"):
        call()


def test_laws_are_copied_pickled_and_replaced_as_dataclasses_are():
    assert pickle.loads(pickle.dumps(DRIVE)) == DRIVE
    assert dataclasses.replace(DRIVE, drive_amplitude=0.2).drive_amplitude == 0.2
    with pytest.raises(InputError, match="did you mean 'drive_amplitude'"):
        dataclasses.replace(DRIVE, amplitude=0.2)


# Says when Ctrl-C is looked after; what Python does before is its own affair.
STARTED = """
import signal, sys
plain = signal.signal
def tell(number, handler):
    found = plain(number, handler)
    signal.signal = plain
    print("ready", flush=True)
    return found
signal.signal = tell
import latolato_command
sys.exit(latolato_command.main())
"""


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGINT for a single process")
def test_ctrl_c_at_any_moment_of_the_start_ends_quietly():
    codes = []
    for delay in [0.0, 0.003, 0.02, 0.08, 0.3, 0.6, 1.5]:
        command = [sys.executable, "-c", STARTED, "simulate", "fig02", "--json"]
        process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        assert process.stdout.readline() == "ready\n"
        time.sleep(delay)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=120)
        assert said == "", said
        codes.append(process.returncode)
    assert set(codes) <= {130, 0}  # a fast machine may be done before the last
    assert codes[0] == 130


def test_ctrl_c_in_the_middle_of_a_cleanup_ends_quietly():
    # Python drops whatever a finaliser raises.
    code = """
import signal, sys, time
import latolato.cli.main as cli

class Cleaned:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)
        time.sleep(0)

def slow(_):
    cleaned = Cleaned()
    del cleaned
    end = time.monotonic() + 60
    while time.monotonic() < end:
        time.sleep(0.01)

cli.load_scenario = slow
sys.exit(cli.main(["scenarios", "show", "fig02"]))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (130, "")


def test_importing_the_package_leaves_signals_alone():
    code = """
import signal, sys
sys.argv[0] = "-m"
before = [signal.getsignal(each) for each in signal.valid_signals()]
import latolato, latolato.cli.main
assert [signal.getsignal(each) for each in signal.valid_signals()] == before
"""
    command = [sys.executable, "-c", code, "latolato"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


def test_the_console_script_is_the_one_that_looks_after_ctrl_c():
    project = tomllib.loads((Path(__file__).parents[2] / "pyproject.toml").read_text())
    assert project["project"]["scripts"] == {"latolato": "latolato_command:main"}


def test_a_fault_of_the_program_asks_for_a_report_and_keeps_the_traceback(capsys, monkeypatch):
    monkeypatch.setattr(cli, "load_scenario", lambda name: 1 / 0)
    assert cli.main(["scenarios", "show", "fig02"]) == 70
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "internal error (ZeroDivisionError)" in said
    assert "please report it" in said
    path = Path(said.split("'")[1])
    try:
        assert "ZeroDivisionError: division by zero" in path.read_text()
    finally:
        path.unlink()


def test_a_report_that_cannot_be_written_gives_an_error(capsys, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(tempfile, "mkstemp", full)
    assert "its traceback could not be written: [Errno 28]" in report_of(KeyError("x"))


@pytest.mark.parametrize("kind", [ValueError, TypeError, RuntimeError, KeyError, ImportError])
def test_only_our_own_error_and_those_of_the_system_are_refusals(kind):
    assert refusal_of(kind("x")) is None
    assert refusal_of(InputError("x")) == "x"
    assert refusal_of(OSError("disk full")) == "disk full"
    assert "not enough memory" in refusal_of(MemoryError())


def test_the_parts_of_a_refusal_survive_pickling_and_make_its_text():
    with pytest.raises(InputError) as caught:
        ll.Pendulum(length=-1.0, mass=1.0)
    for error in (caught.value, pickle.loads(pickle.dumps(caught.value))):
        assert (error.parameter, error.value) == ("length", -1.0)
        assert error.rule == "must lie in (0, inf) m"
        assert error.way_out == "give more than 0"
        assert str(error) == "length must lie in (0, inf) m, got -1; give more than 0"
