"""Result files hold the whole run, and are written whole or not at all."""

import json
import os
import stat
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import latolato as ll
from latolato.core.atomic import atomic_path
from latolato.core.errors import InputError
from latolato.io.files import SUFFIXES, load, save
from latolato.io.shown_units import SIZES, read_texts, shown_texts
from latolato.simulation.run import record
from latolato.sweeps.labels import Memory
from latolato.sweeps.plan import make_plan

BALL = ll.Ball(length=1.0, mass=0.8, radius=0.1, damping=0.02)
TOY = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, restitution=0.9)
HUNG = ll.LatoLato(
    length=1.0, mass=0.8, radius=0.1, restitution=0.9, suspension="string", string_restitution=0.5
)
SHAKE = ll.Harmonic(drive_amplitude=0.3, drive_frequency=9.0)
PLANAR = ll.PlanarHarmonic(
    vertical_amplitude=0.3, horizontal_amplitude=0.1, drive_frequency=9.0, horizontal_phase=1.0
)
SAMPLED = np.linspace(0.0, 6.0, 10_001)
MEASURED = ll.MeasuredPivot(times=SAMPLED, pivot_heights=0.01 * np.cos(SAMPLED))
SCHEDULE = ll.FrequencySchedule(
    drive_amplitude=0.02, times=[0.0, 1.0], drive_frequencies=[7.0, 6.0]
)


@pytest.fixture(
    scope="module",
    params=[
        *("toy", "no contact yet", "pair", "pair without walls", "pendulum", "mathieu"),
        *("toy on strings", "pair on strings", "string"),
    ],
)
def run(request):
    """Runs with and without walls, contacts, a second ball, noise, long sample lists."""
    if request.param == "toy":
        return ll.simulate(TOY, SCHEDULE, initial_angle=0.5, duration=6.0, frame="both")
    if request.param == "no contact yet":
        return ll.simulate(TOY, initial_angle=0.5, duration=0.1)
    if request.param == "pair":
        noise = ll.VelocityKicks(noise_strength=0.05, noise_seed=2)
        pair = ll.BallPair(right=BALL, left=BALL)
        return ll.simulate(pair, initial_angle=(0.5, -0.4), duration=3.0, noise=noise)
    if request.param == "pair without walls":
        pair = ll.BallPair(right=BALL, left=BALL)
        return ll.simulate(pair, initial_angle=(0.5, -0.4), duration=3.0, contact=None)
    if request.param == "toy on strings":
        return ll.simulate(HUNG, SHAKE, initial_angle=0.5, duration=3.0)
    if request.param == "pair on strings":
        pair = ll.BallPair(right=BALL, left=BALL, suspension="string", drag_frame="lab")
        return ll.simulate(pair, PLANAR, initial_angle=(0.5, -0.4), duration=1.0)
    if request.param == "string":  # slack and taut without walls
        string = ll.Pendulum(length=1.0, mass=1.0, suspension="string")
        start = {"initial_angle": 0.5, "initial_distance": 0.9}
        return ll.simulate(string, **start, duration=1.0)
    if request.param == "pendulum":
        return ll.simulate(
            ll.Pendulum(length=1.0, mass=1.0), MEASURED, initial_angle=0.5, duration=3.0
        )
    return ll.simulate(ll.Mathieu(length=1.0, mass=1.0), initial_angle=0.5, duration=3.0)


def plain(attributes):
    return {k: v.tolist() if hasattr(v, "tolist") else v for k, v in attributes.items()}


def need(suffix):
    if suffix == ".parquet":
        pytest.importorskip("pyarrow", reason="Parquet needs the extra 'parquet'")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_saved_run_comes_back_to_the_last_bit(run, tmp_path, suffix):
    need(suffix)
    path = save(run, tmp_path / f"run{suffix}")
    found = load(path)
    xr.testing.assert_identical(
        found.drop_attrs(deep=False).drop_encoding(), run.drop_attrs(deep=False)
    )


@pytest.mark.parametrize("suffix", [".nc", ".csv"])
@pytest.mark.parametrize("kind", ["toy", "pair", "pendulum", "string"])
def test_a_record_is_written_as_its_dataset_is(tmp_path, kind, suffix):
    system = {
        "toy": TOY,
        "pair": ll.BallPair(right=BALL, left=BALL),
        "pendulum": ll.Pendulum(length=1.0, mass=1.0),
        "string": ll.Pendulum(length=1.0, mass=1.0, suspension="string"),
    }[kind]
    start = (0.5, -0.4) if kind == "pair" else 0.5
    found = record(system, SCHEDULE, initial_angle=start, duration=3.0)
    paths = [tmp_path / f"{name}{suffix}" for name in ("record", "dataset")]
    save(found, paths[0])
    save(found.to_dataset(), paths[1])
    one, other = map(load, paths)
    xr.testing.assert_identical(one, other)
    if suffix == ".nc":
        for name in one.variables:
            kept = [each[name].encoding for each in (one, other)]
            assert repr(kept[0].get("_FillValue")) == repr(kept[1].get("_FillValue"))
            assert kept[0]["dtype"] == kept[1]["dtype"]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_attributes_come_back_as_plain_values(run, tmp_path, suffix):
    need(suffix)
    found = load(save(run, tmp_path / f"run{suffix}")).attrs
    wanted = plain(run.attrs)
    assert found.keys() == wanted.keys()
    for name, value in found.items():
        np.testing.assert_equal(value, wanted[name])
        assert type(value) is type(wanted[name]), name


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_file_of_a_newer_format_is_refused(run, tmp_path, suffix, monkeypatch):
    need(suffix)
    monkeypatch.setattr("latolato.io.files.FORMAT", 2)
    path = save(run, tmp_path / f"run{suffix}")
    with pytest.raises(InputError, match="must be at most 1, got 2; use a newer latolato"):
        load(path)


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_contacts_are_a_second_file_for_systems_with_walls_only(tmp_path, suffix):
    need(suffix)
    toy = ll.simulate(TOY, initial_angle=0.5, duration=2.0)
    save(toy, tmp_path / f"toy{suffix}")
    free = ll.simulate(ll.Pendulum(length=1.0, mass=1.0), initial_angle=0.5, duration=2.0)
    save(free, tmp_path / f"free{suffix}")
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {f"toy{suffix}", f"toy.contacts{suffix}", f"free{suffix}"}


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_string_without_walls_keeps_when_it_is_slack_and_taut(tmp_path, suffix):
    need(suffix)
    string = ll.Pendulum(length=1.0, mass=1.0, suspension="string")
    run = ll.simulate(string, initial_angle=0.5, initial_distance=0.9, duration=1.0)
    found = load(save(run, tmp_path / f"run{suffix}"))
    assert list(found.contact_kind.values) == ["taut"]
    assert found.radial_velocity_before.item() > 0.0
    assert found.slack.dtype == np.int8
    assert found.tension.attrs["long_name"] == "tension of the string"


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_stored_run_on_strings_says_how_to_run_it_again(tmp_path, suffix):
    need(suffix)
    pair = ll.BallPair(right=BALL, left=BALL, suspension="string", drag_frame="lab")
    start = {"initial_angle": (0.5, -0.4), "initial_distance": (0.9, 0.8)}
    run = ll.simulate(pair, PLANAR, **start, duration=1.4, frame="both")
    found = load(save(run, tmp_path / f"run{suffix}"))
    assert set(found.contact_kind.values) == {"slack", "taut", "bottom"}
    assert found.rod_power.attrs["long_name"].startswith("power of the string on the ball")
    again = ll.Scenario.from_dict(json.loads(found.attrs["scenario"])).simulate()
    xr.testing.assert_identical(again, run)


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_the_contacts_are_put_in_place_before_the_run(tmp_path, suffix, monkeypatch):
    need(suffix)
    order, replace = [], os.replace

    def noted(source, target):
        order.append(os.path.basename(target))
        replace(source, target)

    monkeypatch.setattr(os, "replace", noted)
    save(ll.simulate(TOY, initial_angle=0.5, duration=1.0), tmp_path / f"run{suffix}")
    assert order == [f"run.contacts{suffix}", f"run{suffix}"]


@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_contacts_of_a_replaced_run_do_not_stay(tmp_path, suffix):
    need(suffix)
    free = ll.simulate(ll.Pendulum(length=1.0, mass=1.0), initial_angle=0.5, duration=1.0)
    path = save(ll.simulate(TOY, initial_angle=0.5, duration=1.0), tmp_path / f"run{suffix}")
    save(free, path)
    assert list(tmp_path.iterdir()) == [path]
    other = tmp_path / f"run.contacts{suffix}"
    other.write_text("names and addresses\n")
    save(free, path)
    assert other.read_text() == "names and addresses\n"


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no signal that kills at once")
def test_leftovers_of_killed_writes_are_removed_by_the_next(tmp_path):
    code = (
        "import os, sys; from latolato.core.atomic import atomic_path\n"
        "with atomic_path(sys.argv[1]) as unfinished:\n"
        "    unfinished.write_text('half'); os.kill(os.getpid(), 9)"
    )
    for name in ("run.csv", "run.contacts.csv", "other.csv"):
        subprocess.run([sys.executable, "-B", "-c", code, str(tmp_path / name)], check=False)
    hidden = {path.name.split(".")[1] for path in tmp_path.iterdir()}
    assert len(list(tmp_path.iterdir())) == 3
    assert hidden == {"run", "other"}
    run = ll.simulate(TOY, initial_angle=0.5, duration=1.0)
    with atomic_path(tmp_path / "run.csv") as ours:  # a write that still goes on
        ours.write_text("half")
        save(run, tmp_path / "run.csv")
        assert ours.exists()
    left = [path.name for path in tmp_path.iterdir() if path.name.startswith(".")]
    assert [name.split(".")[1] for name in left] == ["other"]


def test_leftovers_of_another_machine_stay(tmp_path):
    with atomic_path(tmp_path / "run.csv") as unfinished:
        unfinished.write_text("")
        parts = unfinished.name.split(".")
    parts[2:4] = ["00000000", "999999999"]  # no such machine, no such process
    other = tmp_path / ".".join(parts)
    other.write_text("half")
    save(ll.simulate(TOY, initial_angle=0.5, duration=1.0), tmp_path / "run.csv")
    assert other.exists()


def test_a_csv_file_reads_as_a_table_with_comments(tmp_path):
    toy = ll.simulate(TOY, initial_angle=0.5, duration=2.0)
    path = save(toy, tmp_path / "toy.csv")
    lines = path.read_text().splitlines()
    assert "# length [m]: 1.0" in lines
    assert "# restitution: 0.9" in lines
    assert "# column angle [deg]: angle from the downward vertical" in lines
    assert "# column angular_velocity [rad/s]: angular velocity" in lines
    header = next(line for line in lines if not line.startswith("#"))
    assert header.startswith("time,angle [deg],angular_velocity")
    table = pd.read_csv(path, comment="#")
    # pandas' own reading
    np.testing.assert_allclose(table["angle [deg]"], np.rad2deg(toy.angle), rtol=1e-14)


def test_two_balls_are_two_columns(tmp_path):
    pair = ll.BallPair(right=BALL, left=BALL)
    run = ll.simulate(pair, initial_angle=(0.5, -0.4), duration=1.0)
    path = save(run, tmp_path / "pair.csv")
    table = pd.read_csv(path, comment="#")
    left = run.angle.sel(ball="left")
    # pandas' own reading
    np.testing.assert_allclose(table["angle_left [deg]"], np.rad2deg(left), rtol=1e-14)


@given(value=st.floats(allow_nan=False), unit=st.sampled_from(sorted(SIZES)))
def test_every_number_comes_back_from_the_unit_in_which_it_is_read(value, unit):
    (text,) = shown_texts([value], unit)
    assert read_texts([text], unit) == [value]


def test_a_file_in_si_units_and_one_in_an_unknown_unit(tmp_path):
    run = ll.simulate(ll.Pendulum(length=1.0, mass=1.0), initial_angle=0.5, duration=1.0)
    path = save(run, tmp_path / "run.csv")
    text = path.read_text()
    table = pd.read_csv(path, comment="#", dtype=str)
    table["angle [deg]"] = [repr(float(angle)) for angle in run.angle]
    head = "".join(line for line in text.splitlines(True) if line.startswith("#"))
    older = table.rename(columns={"angle [deg]": "angle"}).to_csv(index=False)
    path.write_text(head + older)
    np.testing.assert_array_equal(load(path).angle, run.angle)
    path.write_text(text.replace("\ntime,angle [deg]", "\ntime,angle [furlong]"))
    with pytest.raises(InputError, match=r"column 'angle \[furlong\]' has an unknown unit"):
        load(path)


def test_parquet_fields_carry_their_units(tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet", reason="Parquet needs the extra 'parquet'")
    run = ll.simulate(TOY, initial_angle=0.5, duration=1.0)
    schema = parquet.read_schema(save(run, tmp_path / "run.parquet"))
    assert schema.field("angular_velocity").metadata[b"units"] == b"rad/s"


def test_any_dataset_goes_to_netcdf_but_only_runs_to_tables(tmp_path):
    other = xr.Dataset({"energy": (("x", "y"), np.eye(2))})
    assert load(save(other, tmp_path / "map.nc"))["energy"].sum() == 2.0
    with pytest.raises(ValueError, match=r".csv files hold runs and sweeps; use .nc"):
        save(other, tmp_path / "map.csv")


@pytest.mark.parametrize("name", ["run.xls", "run", ".nc"])
def test_an_unknown_suffix_is_refused_with_the_known_ones(tmp_path, name):
    run = xr.Dataset({"angle": ("time", [0.0])})
    with pytest.raises(ValueError, match=rf"must end in \.nc, \.csv, \.parquet, got '{name}'"):
        save(run, tmp_path / name)
    with pytest.raises(ValueError, match="must end in"):
        load(tmp_path / name)


def test_a_missing_folder_is_refused_before_anything_is_written(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"folder '.*no' does not exist; create it first"):
        save(xr.Dataset(), tmp_path / "no" / "run.nc")
    (tmp_path / "folder.nc").mkdir()
    with pytest.raises(IsADirectoryError, match="is a folder; name a file in it"):
        save(xr.Dataset(), tmp_path / "folder.nc")


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"there is no file '.*run\.nc'"):
        load(tmp_path / "run.nc")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_file_of_something_else_is_refused(tmp_path, suffix):
    need(suffix)
    path = tmp_path / f"run{suffix}"
    path.write_bytes(b"time,angle\n0,1\n")
    with pytest.raises((ValueError, OSError), match="run"):
        load(path)


def test_parquet_without_its_extra_names_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    with pytest.raises(InputError, match=r'pip install "\.\[parquet\]", or use \.nc'):
        save(xr.Dataset({"angle": ("time", [0.0])}), tmp_path / "run.parquet")


class Interruption(BaseException):
    """Like KeyboardInterrupt, which would end the tests themselves."""


def half_written(path, error):
    with atomic_path(path) as unfinished:
        unfinished.write_text("half of the n")
        raise error


@pytest.mark.parametrize(
    "error", [Interruption(), OSError(28, "No space left on device"), ValueError()]
)
def test_an_interrupted_write_leaves_the_old_file_and_no_litter(tmp_path, error):
    path = tmp_path / "run.txt"
    path.write_text("old")
    with pytest.raises(type(error)) as caught:
        half_written(path, error)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
    if isinstance(error, OSError):
        assert caught.value.filename == str(path)  # not the temporary name


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_writer_that_fails_leaves_no_file(tmp_path, suffix, monkeypatch):
    need(suffix)

    def fail(*_):
        raise OSError(28, "No space left on device")

    run = ll.simulate(TOY, initial_angle=0.5, duration=1.0)
    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="No space left on device"):
        save(run, tmp_path / f"run{suffix}")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit of file sizes")
@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_full_disk_gives_one_line_and_no_file(tmp_path, suffix):
    need(suffix)
    code = (
        "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))\n"
        "from latolato.cli.main import main; sys.exit(main())"
    )
    ll.load_scenario("zeno").simulate()  # keeps its machine code, which the limit would cut too
    # HDF5 would end with a segmentation fault here if it wrote the file itself
    command = ["simulate", "zeno", "--samples", "2000", "--output", f"run{suffix}"]
    done = subprocess.run(
        [sys.executable, "-B", "-c", code, *command],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "too large" in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_files_get_the_usual_permissions(tmp_path):
    usual = tmp_path / "usual"
    usual.write_text("")
    with atomic_path(tmp_path / "ours") as unfinished:
        unfinished.write_text("")
    modes = [stat.S_IMODE((tmp_path / name).stat().st_mode) for name in ("usual", "ours")]
    assert modes[0] == modes[1]


def test_what_is_no_dataset_is_refused(tmp_path):
    with pytest.raises(InputError, match="save needs a dataset, got 3"):
        save(3, tmp_path / "x.nc")
    assert list(tmp_path.iterdir()) == []


def test_a_variable_that_fits_no_table_is_refused(tmp_path):
    run = ll.simulate(TOY, initial_angle=0.5, duration=0.1)
    maps = run.assign(more=(("time", "mode"), np.zeros((run.sizes["time"], 2))))
    with pytest.raises(ValueError, match="more over time, mode fits no table"):
        save(maps, tmp_path / "x.csv")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_is_refused_as_one(tmp_path):
    for refuse in (lambda: save(xr.Dataset(), tmp_path), lambda: load(tmp_path)):
        with pytest.raises(IsADirectoryError, match="is a folder; name a file in it"):
            refuse()


def filled(plan):
    """Return a sweep of made-up numbers."""
    memory, chance = Memory(plan, "compiled"), np.random.default_rng(3)
    for array in memory.arrays.values():
        array[...] = chance.integers(0, 3, array.shape) / 7.0 if array.dtype == float else 1
    return memory.dataset()


def sweeps():
    """Return sweeps: of both balls, both ways along an axis and of parameters together."""
    drive = ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.0)
    both = {"right_mass": [0.5, 1.0], "drive_frequency": [5.0, 6.0, 7.0]}
    pair = ll.BallPair(right=BALL, left=BALL)
    yield filled(make_plan(pair, drive, axes=both, initial_angle=(0.3, -0.2), duration=2.0))
    case = {"length": [0.9, 1.0], "radius": [0.1, 0.2]}
    plan = make_plan(
        ll.BallPair(right=BALL, left=BALL, suspension="string"),
        PLANAR,
        axes={"string_restitution": [0.0, 0.5], "horizontal_amplitude": [0.0, 0.1]},
        initial_angle=(0.3, -0.2),
        duration=2.0,
        observables=["slack_fraction", "first_slack", "largest_string_impulse", "retension_loss"],
    )
    grid = filled(plan)
    grid.status[0, 1] = "outside_model"
    yield grid
    yield filled(
        make_plan(
            TOY,
            drive,
            axes={"case": case, "drive_amplitude": [0.1, 0.2, 0.4]},
            initial_offset=0.1,
            duration=2.0,
            continuation="drive_amplitude",
            direction="both",
            observables=["largest_angle", "motion_class"],
        )
    )


@pytest.mark.parametrize("number", [0, 1, 2])
@pytest.mark.parametrize("suffix", [".csv", ".parquet"])
def test_a_sweep_is_a_table_of_points_and_comes_back(tmp_path, number, suffix):
    if suffix == ".parquet":
        pytest.importorskip("pyarrow", reason="Parquet needs the extra 'parquet'")
    grid = list(sweeps())[number]
    found = load(save(grid, tmp_path / f"map{suffix}"))
    xr.testing.assert_identical(found, grid)
    if suffix == ".csv":
        path = tmp_path / "map.csv"
        assert len(pd.read_csv(path, comment="#")) == grid.status.size
        older = path.read_text().replace(",grazing\n", ",1\n").replace(",outside_model\n", ",6\n")
        assert older != path.read_text()
        path.write_text(older)
        xr.testing.assert_identical(load(path), grid)


def test_what_fits_no_table_is_refused_with_the_way_out(tmp_path):
    drive = ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.0)
    options = {"axes": {"drive_amplitude": [0.1, 0.2]}, "initial_offset": 0.1, "duration": 100.0}
    grid = filled(make_plan(TOY, drive, **options, observables=["poincare_section"]))
    with pytest.raises(ValueError, match=r"over sample: it fits no table; use \.nc"):
        save(grid, tmp_path / "map.csv")
    part = filled(make_plan(TOY, drive, **options)).isel(drive_amplitude=[0])
    with pytest.raises(ValueError, match="hold runs and sweeps"):
        save(part, tmp_path / "map.csv")
