"""A store ends with the same bytes whatever happened on the way, and belongs to one sweep."""

import errno
import json
import os
import signal
import subprocess
import sys
import textwrap
from contextlib import contextmanager

import numpy as np
import pytest
import xarray as xr

import latolato as ll
from latolato.core.errors import InputError
from latolato.io.plans import plan_from_store
from latolato.numerics.records import STATUS_NAMES
from latolato.observables import observables
from latolato.physics.contacts import contact_laws
from latolato.sweeps import store as store_module
from latolato.sweeps.axes import Axis
from latolato.sweeps.chunk import STATUS
from latolato.sweeps.differences import differences
from latolato.sweeps.executors import ROUNDING
from latolato.sweeps.labels import Memory, lengths_of, template
from latolato.sweeps.plan import Plan, make_plan
from latolato.sweeps.statuses import with_words
from latolato.sweeps.store import Store, store_status, verify_store

TOY = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, restitution=0.9)
BALL = ll.Ball(length=1.0, mass=0.8, radius=0.1)
# 8 points in 4 chunks; a radius beyond the length gives two points without an answer.
SWEEP = {
    "axes": {"drive_amplitude": [0.0, 0.05], "radius": [0.05, 0.1, 0.2, 1.5]},
    "duration": 0.05,
    "initial_angle": 0.4,
    "observables": ["largest_angle", "energy_ledger"],
    "chunk_size": 2,
}
DRIVE = ll.Harmonic(drive_amplitude=0.0, drive_frequency=6.0)
WITHOUT_ANSWER = "2 of 8 points have no answer: 2 invalid"
PLAN = make_plan(TOY, DRIVE, **SWEEP)
# A process that dies, by a signal that it cannot see coming, just before or after it puts a file
# of the store in its place.
KILLED = """
    import os, signal, warnings
    import latolato as ll
    from latolato import Harmonic, LatoLato

    warnings.simplefilter("ignore")
    place, seen = os.replace, 0

    def replace(source, target):
        global seen
        hit = str(target) == {target!r}
        seen += hit
        if hit and seen == {times} and {when!r} == "before":
            os.kill(os.getpid(), signal.SIGKILL)
        place(source, target)
        if hit and seen == {times}:
            os.kill(os.getpid(), signal.SIGKILL)

    os.replace = replace
    ll.sweep({system}, {drive}, **{sweep!r}, executor="reference", store={path!r})
"""
not_on_windows = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals")


def contents(path):
    """All files below a folder with their bytes."""
    return {
        file.relative_to(path).as_posix(): file.read_bytes()
        for file in sorted(path.rglob("*"))
        if file.is_file()
    }


def swept(path, **changed):
    """The sweep of these tests into a store, in plain Python."""
    with pytest.warns(RuntimeWarning, match=WITHOUT_ANSWER):
        return ll.sweep(TOY, DRIVE, **(SWEEP | changed), executor="reference", store=path)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A store that was written without any interruption."""
    path = tmp_path_factory.mktemp("whole") / "map.zarr"
    swept(path)
    return path


@contextmanager
def python(code):
    """A Python process that runs this code, and does not survive the block."""
    command = [sys.executable, "-B", "-c", textwrap.dedent(code)]
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen(command, **pipes) as process:
        try:
            yield process
        finally:
            process.kill()


def made_up(plan, number, reason=""):
    """Values of a chunk that nobody computed."""
    shape = tuple(part.stop - part.start for part in plan.block(number))
    lengths = lengths_of(plan)
    values = {}
    for name, (dims, dtype, _) in template(plan).items():
        full = shape + tuple(lengths[d] for d in dims[len(shape) :])
        values[name] = np.arange(np.prod(full)).reshape(full).astype(dtype) % 3 + number
    values[STATUS][:] = STATUS_NAMES.index("invalid" if reason else "converged")
    return values


def fill(plan, path, numbers=None, reasons=(), make=made_up):
    """Write made-up chunks, in this order, those that are missing by default."""
    with Store(plan, path, "python") as store:
        for number in store.missing if numbers is None else numbers:
            reason = dict(reasons).get(number, "")
            store.write(number, make(plan, number, reason), reason)
        return store.dataset()


@contextmanager
def repaired(what):
    """Expect a warning that names what was damaged."""
    with pytest.warns(RuntimeWarning, match=f"repaired the store .*: {what}"):
        yield


def test_a_store_opens_as_the_dataset_that_memory_gives(whole):
    with pytest.warns(RuntimeWarning, match=WITHOUT_ANSWER):
        memory = ll.sweep(TOY, DRIVE, **SWEEP, executor="reference")
    assert "radius" in memory.attrs["first_invalid"]
    for opened in (
        with_words(xr.open_zarr(whole)),
        with_words(xr.open_zarr(whole, chunks=None, consolidated=False)),
        ll.load(whole),
    ):
        assert opened.isel(radius=0).status.equals(memory.isel(radius=0).status)
        xr.testing.assert_identical(opened.load(), memory)
        assert opened.status.dtype == object
        assert {k: type(v) for k, v in opened.attrs.items()} == {
            k: type(v) for k, v in memory.attrs.items()
        }


@pytest.mark.parametrize("direction", ["up", "both"])
def test_two_balls_samples_and_zipped_axes_come_back(tmp_path, direction):
    plan = make_plan(
        ll.BallPair(right=BALL, left=BALL),
        axes={
            "case": {"frequency_ratio": [1.0, 2.0, 3.0], "drive_amplitude": [0.1, 0.2, 0.3]},
            "gravity": [9.7, 9.8],
        },
        initial_angle=(0.3, -0.3),
        duration=1.0,
        observables=["energy_ledger", "poincare_section", "final_angle"],
        continuation="case",
        direction=direction,
        chunk_size=3,
    )
    memory = Memory(plan, "python")
    for number in range(plan.chunks):
        memory.write(number, made_up(plan, number), "")
    opened = fill(plan, tmp_path / "map.zarr")
    assert opened.ball.dtype == memory.dataset().ball.dtype
    xr.testing.assert_identical(opened.load(), memory.dataset())


def test_a_sweep_of_strings_comes_back_from_a_store_and_from_a_file(tmp_path):
    pair = ll.BallPair(right=BALL, left=BALL, suspension="string", drag_frame="lab")
    drive = ll.PlanarHarmonic(
        vertical_amplitude=0.1, horizontal_amplitude=0.05, drive_frequency=6.0
    )
    start = {"initial_distance_right": [0.5, 0.9, 1.2], "string_restitution": [0.0, 0.5, 1.0]}
    options = {
        "axes": {"start": start, "horizontal_amplitude": [0.0, 0.1]},
        "initial_angle": (0.5, -0.4),
        "initial_distance": (0.8, 0.8),
        "duration": 0.5,
        "observables": [
            *("slack_fraction", "first_slack", "largest_string_impulse"),
            *("retension_loss", "largest_angle"),
        ],
        "executor": "reference",
        "store": tmp_path / "map.zarr",
    }
    with pytest.warns(RuntimeWarning, match="2 of 6 points .* exceed the length of the string"):
        grid = ll.sweep(pair, drive, **options).load()
    assert (grid.slack_fraction.sel(start=0, ball="right") > 0.0).all()
    for name in ("map.nc", "map.csv"):
        ll.save(grid, tmp_path / name)
    for name in ("map.zarr", "map.nc", "map.csv"):
        xr.testing.assert_identical(ll.load(tmp_path / name).load(), grid)
    plan = plan_from_store(tmp_path / "map.zarr")
    assert (plan.system, plan.drive, dict(plan.start)["initial_distance_left"]) == (
        *(pair, drive),
        0.8,
    )


def test_values_in_a_store_are_read_on_use(whole):
    dataset = ll.load(whole)
    assert "[8 values" in repr(dataset.largest_angle)  # xarray shows values that it holds
    assert dataset.chunks == {}


@not_on_windows
@pytest.mark.parametrize(
    "file, times, when",
    [
        ("radius/c/0", 1, "before"),
        ("zarr.json", 1, "before"),
        ("zarr.json", 1, "after"),
        ("largest_angle/c/0/1", 1, "before"),
        ("drive_work/c/1/0", 1, "after"),
        (".latolato/chunks/2.json", 1, "before"),
        (".latolato/chunks/3.json", 1, "after"),
        ("zarr.json", 2, "before"),
    ],
)
def test_a_sweep_killed_at_any_file_resumes_to_the_same_bytes(whole, tmp_path, file, times, when):
    path = tmp_path / "map.zarr"
    target, names = str(path / file), {"sweep": SWEEP, "path": str(path)}
    code = KILLED.format(target=target, times=times, when=when, system=TOY, drive=DRIVE, **names)
    with python(code) as killed:
        assert killed.wait() == -signal.SIGKILL
    assert contents(path) != contents(whole)
    assert (path / ".latolato" / "lock").exists()
    swept(path)
    assert contents(path) == contents(whole)


def test_chunks_in_any_order_end_with_the_same_bytes(tmp_path):
    reasons = [(1, "second"), (3, "fourth")]
    first = fill(PLAN, tmp_path / "a.zarr", [0, 1, 2, 3], reasons)
    second = fill(PLAN, tmp_path / "b.zarr", [3, 2, 1, 0], reasons)
    assert contents(tmp_path / "a.zarr") == contents(tmp_path / "b.zarr")
    assert first.attrs["first_invalid"] == second.attrs["first_invalid"] == "second"
    memory = Memory(PLAN, "python")
    for number in (3, 1):
        memory.write(number, made_up(PLAN, number, dict(reasons)[number]), dict(reasons)[number])
    assert memory.dataset().attrs["first_invalid"] == "second"


def test_an_interrupted_sweep_goes_on_where_it_was(whole, tmp_path):
    path = tmp_path / "map.zarr"
    seen = []

    def progress(done, total):
        seen.append(done)
        if done == 4 and len(seen) == 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        ll.sweep(TOY, DRIVE, **SWEEP, executor="reference", store=path, progress=progress)
    swept(path, chunk_size=2)
    with pytest.warns(RuntimeWarning, match=WITHOUT_ANSWER):
        ll.sweep(TOY, DRIVE, **SWEEP, executor="reference", store=path, progress=progress)
    assert seen == [0, 2, 4, 8]  # the last time there was nothing to do
    assert contents(path) == contents(whole)


def damage(how, file):
    """Spoil a file."""
    content = file.read_bytes()
    if how == "missing":
        file.unlink()
    elif how == "truncated":
        file.write_bytes(content[: len(content) // 2])
    elif how == "empty":
        file.write_bytes(b"")
    else:
        flip(file, 8 * len(content) // 2)


def flip(file, bit):
    """Turn over one bit of a file."""
    content = bytearray(file.read_bytes())
    content[bit // 8] ^= 1 << bit % 8
    file.write_bytes(content)


# One file of every kind, and how many chunks are computed again for it.
FILES = [
    ("largest_angle/c/1/0", 1),
    ("status/c/0/1", 1),
    (".latolato/chunks/2.json", 1),
    ("radius/c/0", 0),
    ("status/zarr.json", 0),
    ("zarr.json", 0),
    (".latolato/root.json", 0),
    (".latolato/zarr.json", 0),
]


@pytest.mark.parametrize("how", ["missing", "truncated", "empty", "one bit"])
@pytest.mark.parametrize("name, again", FILES)
def test_a_damaged_file_is_named_and_made_again(tmp_path, how, name, again):
    path = tmp_path / "map.zarr"
    reasons = [(1, "a reason")]
    fill(PLAN, path, reasons=reasons)
    before = contents(path)
    damage(how, path / name)
    if name.startswith(".latolato/chunks") and how == "missing":  # a chunk that was never done
        assert verify_store(path)["damaged"] == []
        fill(PLAN, path, reasons=reasons)
    else:
        assert [result["file"] for result in verify_store(path)["damaged"]] == [name]
        with repaired(f"{name} damaged or missing; {again} of 4 chunks are computed again"):
            fill(PLAN, path, reasons=reasons)
    assert contents(path) == before
    assert verify_store(path)["damaged"] == []


def test_whole_files_of_another_chunk_or_sweep_are_damage(tmp_path):
    path, name = tmp_path / "map.zarr", "largest_angle/c/1/0"
    fill(PLAN, path)
    other = make_plan(TOY, DRIVE, **SWEEP | {"duration": 0.06})
    fill(other, tmp_path / "other.zarr", make=lambda *chunk: made_up(PLAN, 3))
    for source in (path / "largest_angle/c/0/0", tmp_path / "other.zarr" / name):
        (path / name).write_bytes(source.read_bytes())
        assert [each["file"] for each in verify_store(path)["damaged"]] == [name]
        with pytest.raises(InputError, match="chunk c/1/0 of largest_angle is damaged"):
            ll.load(path).load()
        with repaired(f"{name} damaged or missing; 1 of 4 chunks"):
            fill(PLAN, path)


def test_every_flipped_bit_of_a_chunk_is_noticed(tmp_path):
    path = tmp_path / "map.zarr"
    fill(PLAN, path)
    values, plain = ll.load(path).largest_angle, xr.open_zarr(path, chunks=None).largest_angle
    file = path / "largest_angle" / "c" / "1" / "0"
    for bit in range(8 * file.stat().st_size):
        flip(file, bit)
        with pytest.raises(InputError, match=r"chunk c/1/0 of largest_angle is damaged"):
            values.load()
        with pytest.raises((ValueError, RuntimeError)):  # Zarr by itself
            plain.load()
        flip(file, bit)


@pytest.mark.parametrize(
    "name, part",
    [
        ("largest_angle/c/1/0", "chunk c/1/0 of largest_angle is"),
        ("status/c/0/1", "chunk c/0/1 of status is"),
        ("radius/c/0", "chunk c/0 of radius is"),
        ("zarr.json", r"its zarr\.json is"),
    ],
)
@pytest.mark.parametrize("how", ["missing", "truncated", "empty", "one bit"])
def test_a_damaged_store_is_not_read_as_good_data(tmp_path, how, name, part):
    path = tmp_path / "map.zarr"
    fill(PLAN, path)
    damage(how, path / name)
    with pytest.raises(InputError, match=f"{part} (damaged|missing).* in the store") as caught:
        ll.load(path).load()
    assert str(path) in str(caught.value)
    assert "--verify" in caught.value.way_out
    assert "running the sweep again with this store repairs it" in caught.value.way_out


def test_plain_zarr_refuses_a_damaged_coordinate(tmp_path):
    fill(PLAN, tmp_path / "map.zarr")
    flip(tmp_path / "map.zarr" / "radius" / "c" / "0", 3)
    with pytest.raises(ValueError, match="checksum"):
        xr.open_zarr(tmp_path / "map.zarr")


@pytest.mark.parametrize("how", ["missing", "truncated", "empty", "one bit"])
def test_a_lost_root_is_rebuilt_from_the_plan_that_the_store_keeps(tmp_path, how):
    path = tmp_path / "map.zarr"
    reasons = [(2, "a reason")]
    fill(PLAN, path, [0, 2], reasons)
    damage(how, path / "zarr.json")
    assert plan_from_store(path) == PLAN
    assert store_status(path)["chunks_done"] == 2
    with repaired(r"zarr\.json damaged or missing; 0 of 4 chunks"):
        fill(plan_from_store(path), path)
    fill(PLAN, tmp_path / "other.zarr", reasons=reasons)
    assert contents(path) == contents(tmp_path / "other.zarr")


def test_a_root_with_a_changed_number_is_damaged_though_it_can_be_read(tmp_path):
    path = tmp_path / "map.zarr"
    fill(PLAN, path)
    text = (path / "zarr.json").read_text()
    assert '"duration": 0.05,' in text
    (path / "zarr.json").write_text(text.replace('"duration": 0.05,', '"duration": 0.04,'))
    with pytest.raises(InputError, match=r"its zarr\.json is damaged"):
        ll.load(path)


def test_a_store_that_lost_its_metadata_and_their_copy_is_refused(tmp_path):
    path = tmp_path / "map.zarr"
    fill(PLAN, path, [0])
    for name in ("zarr.json", ".latolato/root.json"):
        damage("truncated", path / name)
    before = contents(path)
    for use in (lambda path: fill(PLAN, path), store_status, plan_from_store, ll.load):
        with pytest.raises(InputError, match="are both damaged or missing; name another path"):
            use(path)
    assert contents(path) == before


def test_a_store_without_checksums_is_refused_with_the_way_out(tmp_path):
    path = tmp_path / "map.zarr"
    fill(PLAN, path)
    root = json.loads((path / "zarr.json").read_text())
    del root["attributes"]["rounding"]
    (path / "zarr.json").write_text(json.dumps(root))
    (path / ".latolato" / "root.json").unlink()
    for use in (lambda path: fill(PLAN, path), store_status, ll.load):
        with pytest.raises(
            InputError, match="earlier latolato, without checksums; read it with xa"
        ):
            use(path)


def test_a_verification_reads_everything_and_says_what_is_damaged(tmp_path):
    path = tmp_path / "map.zarr"
    fill(PLAN, path, [0, 1, 3])
    result = verify_store(path)
    on_disk = {name for name in contents(path) if not name.startswith(".latolato/chunks")}
    assert result["damaged"] == []
    assert result["files"] == len(on_disk)
    assert not result["complete"]
    for name in ("status/c/1/1", "radius/c/0"):
        damage("one bit", path / name)
    result = verify_store(path)
    assert json.loads(json.dumps(result)) == result
    assert result["damaged"] == [
        {"file": "radius/c/0", "variable": "radius", "chunk": "c/0", "number": None},
        {"file": "status/c/1/1", "variable": "status", "chunk": "c/1/1", "number": 3},
    ]
    assert result["chunks_done"] == 2


def test_chunks_of_executors_that_round_differently_do_not_mix(tmp_path):
    path = tmp_path / "map.zarr"
    fill(PLAN, path, [0, 2])
    before = contents(path)
    words = (
        r"2 of 4 chunks .* with executor 'reference', which rounds differently from 'threads' or"
    )
    for executor in ("threads", "dask"):
        with (
            pytest.raises(InputError, match=f"{words} 'dask'; finish it with that executor, name"),
            Store(PLAN, path, ROUNDING[executor]),
        ):
            pass
    with pytest.raises(InputError, match=words):
        ll.sweep(TOY, DRIVE, **SWEEP, store=path)
    assert contents(path) == before
    fill(PLAN, path)
    with Store(PLAN, path, ROUNDING["threads"]) as store:  # nothing is computed, nothing mixes
        assert store.dataset().attrs["rounding"] == "python"


def test_a_damaged_chunk_is_computed_again_by_its_own_rounding_only(tmp_path):
    path = tmp_path / "map.zarr"
    fill(PLAN, path)
    damage("one bit", path / "largest_angle" / "c" / "1" / "0")
    with (
        pytest.raises(InputError, match=r"1 of 4 chunks .* rounds differently"),
        Store(PLAN, path, "cuda"),
    ):
        pass
    with repaired("largest_angle/c/1/0"):
        fill(PLAN, path)


def test_nothing_is_left_of_a_store_that_was_only_just_begun(tmp_path, monkeypatch):
    def full(source, target):
        if target.name == "zarr.json" and target.parent == tmp_path / "map.zarr":
            raise OSError(errno.ENOSPC, "No space left on device")
        replace(source, target)

    replace = os.replace
    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OSError, match="No space left on device"):
        fill(PLAN, tmp_path / "map.zarr")
    assert (tmp_path / "map.zarr" / "radius" / "c" / "0").exists()
    monkeypatch.undo()
    other = make_plan(TOY, DRIVE, **SWEEP | {"axes": {"gravity": [9.7, 9.8]}})
    fill(other, tmp_path / "map.zarr")
    fill(other, tmp_path / "other.zarr")
    assert contents(tmp_path / "map.zarr") == contents(tmp_path / "other.zarr")
    assert not (tmp_path / "map.zarr" / "radius").exists()


def test_a_chunk_without_any_answer_is_a_file_too(tmp_path):
    values = made_up(PLAN, 0, "all of it")
    for name in ("largest_angle", "drive_work"):
        values[name][:] = np.nan
    with Store(PLAN, tmp_path / "map.zarr", "python") as store:
        store.write(0, values, "all of it")
    assert (tmp_path / "map.zarr" / "largest_angle" / "c" / "0" / "0").is_file()
    with Store(PLAN, tmp_path / "map.zarr", "python") as store:
        assert store.missing == [1, 2, 3]
        assert store.points_done == 2
        assert store.status_counts() == {"invalid": 2}


def test_the_store_of_another_sweep_is_refused_with_the_difference(whole):
    before = contents(whole)
    changes = {
        "duration": (0.07, r"duration is 0\.05, not 0\.07"),
        "chunk_size": (4, "chunk_size is 2, not 4"),
        "initial_angle": (0.5, r"start\.initial_angle is 0\.4, not 0\.5"),
        "axes": (
            {"drive_amplitude": [0.0, 0.06], "radius": [0.05, 0.1, 0.2, 1.5]},
            r"axes\.drive_amplitude\.values is \[\[0\.0, 0\.05\]\], not \[\[0\.0, 0\.06\]\]",
        ),
        "observables": (
            ["energy_ledger"],
            r'observables is \["largest_angle", "energy_ledger"\], not \["energy_ledger"\]',
        ),
        "contact": (
            ll.ClampContact(clamp_step=1e-3),
            r'contact\.kind is "exact", not "clamp", contact\.clamp_step',
        ),
    }
    for name, (value, words) in changes.items():
        with pytest.raises(ValueError, match=f"holds another sweep: {words}.*; name another path"):
            ll.sweep(TOY, DRIVE, **(SWEEP | {name: value}), executor="reference", store=whole)
    assert contents(whole) == before


def test_long_differences_are_shortened():
    ours, theirs = list(range(100)), [*range(99), 100]
    assert differences({"a": ours}, {"a": theirs}) == ["a is [... 99 ...], not [... 100 ...]"]
    assert differences({"a": ours}, {"a": ours[:50]}) == ["a is [100 values], not [50 values]"]
    assert differences({"a": {"b": None}}, {"a": {"b": {"c": 1}}}) == ['a.b is null, not {"c": 1}']


def test_other_kernels_may_open_a_complete_store_but_not_finish_another(tmp_path, monkeypatch):
    fill(PLAN, tmp_path / "part.zarr", [2])
    fill(PLAN, tmp_path / "whole.zarr")
    before = contents(tmp_path)
    monkeypatch.setattr(store_module, "sources_hash", lambda: "other kernels")
    with pytest.raises(ValueError, match=r"3 of 4 chunks of .* are missing, and latolato .* other"):
        fill(PLAN, tmp_path / "part.zarr")
    fill(PLAN, tmp_path / "whole.zarr")
    assert contents(tmp_path) == before


@pytest.mark.parametrize("what", ["file", "folder", "zarr", "no parent"])
def test_what_is_no_store_of_a_sweep_is_not_touched(tmp_path, what):
    path = tmp_path / "map.zarr"
    error, words = FileExistsError, "not a store of a sweep: name another path"
    if what == "file":
        path.write_text("precious")
    elif what == "folder":
        path.mkdir()
        (path / "thesis.tex").write_text("precious")
    elif what == "zarr":
        xr.Dataset({"a": ("x", [1.0, 2.0])}).to_zarr(path, consolidated=False)
    else:
        path = tmp_path / "no" / "map.zarr"
        error, words = FileNotFoundError, "does not exist; create it first"
    before = contents(tmp_path)
    with pytest.raises(error, match=words):
        fill(PLAN, path)
    assert contents(tmp_path) == before
    with pytest.raises(
        (ValueError, FileNotFoundError), match=r"no(t a)? store|does not exist|no file"
    ):
        store_status(path)


def test_an_empty_folder_becomes_a_store(tmp_path):
    (tmp_path / "map.zarr").mkdir()
    fill(PLAN, tmp_path / "map.zarr")
    assert store_status(tmp_path / "map.zarr")["complete"]


def test_a_second_writer_in_this_process_is_refused(tmp_path):
    path = tmp_path / "map.zarr"
    with Store(PLAN, path, "python") as store:
        with pytest.raises(BlockingIOError, match=f"process {os.getpid()} on .* is writing the st"):
            fill(PLAN, path)
        store.write(0, made_up(PLAN, 0), "")
        assert store_status(path)["writer_active"]
    assert not store_status(path)["writer_active"]
    assert not (path / ".latolato" / "lock").exists()
    fill(PLAN, path)


@not_on_windows
def test_a_second_writer_is_refused_until_the_first_one_is_killed(tmp_path):
    path = tmp_path / "map.zarr"
    fill(PLAN, path, [0])
    code = f"""
        from latolato.sweeps.store import Store
        from latolato.io.plans import plan_from_store
        with Store(plan_from_store({str(path)!r}), {str(path)!r}, "python"):
            print("writing", flush=True)
            input()
    """
    with python(code) as first:
        assert first.stdout.readline() == b"writing\n"
        with pytest.raises(BlockingIOError, match=f"process {first.pid} on .* wait for it, stop"):
            fill(PLAN, path)
        assert store_status(path)["writer_active"]
    assert not store_status(path)["writer_active"]
    fill(PLAN, path)
    assert store_status(path)["complete"]


@pytest.mark.parametrize("room", [0, 4, 9, 12, 14, 30, 34])
def test_a_full_disk_gives_one_line_and_leaves_a_store_to_go_on_with(tmp_path, monkeypatch, room):
    path, files = tmp_path / "map.zarr", 0
    replace = os.replace

    def full(*names):
        nonlocal files
        files += 1
        if files > room:
            raise OSError(errno.ENOSPC, "No space left on device")
        replace(*names)

    monkeypatch.setattr(os, "replace", full)
    with pytest.raises(OSError, match="No space left on device") as caught:
        fill(PLAN, path, reasons=[(0, "for the last file")])
    is_kept = any((path / ".latolato/chunks").glob("*.json"))
    words = "finished chunks are kept; once" if is_kept else "no chunk was finished; name another"
    assert f"device ({words}" in str(caught.value)
    assert caught.value.errno == errno.ENOSPC
    assert caught.value.filename == str(path)
    monkeypatch.undo()
    fill(PLAN, path, reasons=[(0, "for the last file")])
    fill(PLAN, tmp_path / "other.zarr", reasons=[(0, "for the last file")])
    assert contents(path) == contents(tmp_path / "other.zarr")


@contextmanager
def files_up_to(size):
    """Let the system refuse to make any file larger than this many bytes."""
    import resource

    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no limit of file sizes")
def test_a_sweep_goes_on_when_the_system_takes_larger_files_again(tmp_path):
    def noise_in_chunk_2(plan, number, reason):
        """Two chunks that compress well, then one of 32 kB that does not."""
        values = made_up(plan, number, reason)
        if number == 2:
            angles = values["largest_angle"]
            angles[:] = np.random.default_rng(1).random(angles.shape)
        return values

    axes = {"gravity": np.linspace(9, 10, 100), "drive_amplitude": np.linspace(0, 1, 160)}
    plan = make_plan(TOY, DRIVE, **SWEEP | {"axes": axes, "chunk_size": 4000})
    path = tmp_path / "map.zarr"
    for _ in range(2):  # the second time it is refused again
        with (
            files_up_to(20_000),
            pytest.raises(OSError, match=r"File too large .finished chunks are kept") as caught,
        ):
            fill(plan, path, make=noise_in_chunk_2)
        assert caught.value.errno == errno.EFBIG
        assert store_status(path)["chunks_done"] == 2
        assert not [name for name in contents(path) if name.startswith("largest_angle/c/2")]
    fill(plan, path, make=noise_in_chunk_2)
    fill(plan, tmp_path / "other.zarr", make=noise_in_chunk_2)
    assert contents(path) == contents(tmp_path / "other.zarr")


def test_the_status_tells_how_far_a_sweep_is(tmp_path):
    path = tmp_path / "map.zarr"
    fill(PLAN, path, [3, 1], [(3, "too large")])
    state = store_status(path)
    assert json.loads(json.dumps(state)) == state
    expected = {
        "plan_hash": PLAN.hash,
        "system": "latolato",
        "axes": {"drive_amplitude": 2, "radius": 4},
        "observables": ["largest_angle", "energy_ledger"],
        "chunks": 4,
        "chunks_done": 2,
        "points": 8,
        "points_done": 4,
        "status_counts": {"converged": 2, "invalid": 2},
        "first_invalid": "too large",
        "complete": False,
        "writer_active": False,
    }
    assert {name: state[name] for name in expected} == expected


def test_an_unfinished_store_gives_a_warning_on_loading(tmp_path):
    fill(PLAN, tmp_path / "map.zarr", [0])
    with pytest.warns(RuntimeWarning, match="2 of 8 points are done, status is 'missing'"):
        dataset = ll.load(tmp_path / "map.zarr")
    assert (dataset.status == "missing").sum() == 6
    assert np.isnan(dataset.largest_angle.values[dataset.status.values == "missing"]).all()


def test_a_sweep_goes_to_netcdf_and_back(whole, tmp_path):
    path = ll.save(ll.load(whole), tmp_path / "map.nc")
    result, expected = ll.load(path), ll.load(whole).load()
    xr.testing.assert_identical(result.drop_encoding(), expected)
    assert set(result.status.values.ravel()) == {"converged", "invalid"}
    stored = xr.load_dataset(path, engine="h5netcdf").status  # bytes, with their meanings
    assert stored.dtype == np.int8
    assert stored.attrs["flag_meanings"].split()[int(stored[0, 0])] == result.status[0, 0]
    assert plan_from_store(path) == plan_from_store(whole) == PLAN


def test_axes_beyond_the_64_kilobytes_of_small_attributes_go_to_netcdf(tmp_path):
    plan = make_plan(TOY, DRIVE, **SWEEP | {"axes": {"gravity": np.linspace(9, 10, 9000)}})
    assert len(json.dumps(plan.describe())) > 2**16
    path = ll.save(Memory(plan, "python").dataset(), tmp_path / "map.nc")
    assert plan_from_store(path) == plan


def test_a_file_without_a_sweep_gives_no_plan(tmp_path):
    run = xr.Dataset({"angle": ("time", [0.1, 0.2])})
    with pytest.raises(ValueError, match=r"run\.nc' holds no sweep"):
        plan_from_store(ll.save(run, tmp_path / "run.nc"))
    with pytest.raises(FileNotFoundError, match="there is no store"):
        plan_from_store(tmp_path / "map.zarr")


def test_a_plan_that_was_changed_by_hand_is_refused(tmp_path):
    dataset = Memory(PLAN, "python").dataset()
    dataset.attrs["plan"] = dataset.attrs["plan"].replace('"duration": 0.05', '"duration": 0.06')
    ll.save(dataset, tmp_path / "map.nc")
    with pytest.raises(InputError, match="does not fit its hash"):
        plan_from_store(tmp_path / "map.nc")


def test_a_plan_in_a_damaged_root_is_not_used(tmp_path):
    fill(PLAN, tmp_path / "map.zarr")
    root = tmp_path / "map.zarr" / "zarr.json"
    root.write_text(root.read_text().replace(r"\"duration\": 0.05", r"\"duration\": 0.06"))
    assert plan_from_store(tmp_path / "map.zarr") == PLAN
    (tmp_path / "map.zarr" / ".latolato" / "root.json").unlink()
    with pytest.raises(InputError, match="are both damaged or missing"):
        plan_from_store(tmp_path / "map.zarr")


def described(**changed):
    """A plan of everything there is, and what its description gives after a way through JSON."""
    plan = Plan(
        **{
            "system": TOY,
            "drive": DRIVE,
            "axes": (Axis("case", ("gravity", "damping"), ((9.8, 1 / 3), (0.1, 2e-17))),),
            "observables": tuple(kind() for kind in observables.values()),
            "start": (("initial_angle", 0.1), ("initial_angular_velocity", -0.0)),
            "duration": 7.0,
        }
        | changed
    )
    return plan, Plan.from_description(json.loads(json.dumps(plan.describe())))


def test_every_drive_survives_its_description(drive):
    plan, result = described(drive=drive)
    assert (result, result.hash) == (plan, plan.hash)


def test_every_system_survives_its_description(make_system):
    plan, result = described(system=make_system(damping=0.1, coulomb_damping=0.2))
    assert (result, result.hash) == (plan, plan.hash)


@pytest.mark.parametrize("law", list(contact_laws))
def test_every_contact_law_and_noise_survive_their_description(law):
    noise = ll.VelocityKicks(noise_strength=0.1, noise_seed=2**60 + 1)
    plan, result = described(contact=contact_laws[law](), noise=noise, direction="both")
    assert (result, result.hash) == (plan, plan.hash)


def test_a_description_of_something_else_is_refused():
    text = PLAN.describe()
    with pytest.raises(ValueError, match="the format of a plan must be at most 1, got 99"):
        Plan.from_description(text | {"format": 99})
    with pytest.raises(ValueError, match="unknown parameter 'lenght' of LatoLato"):
        Plan.from_description(text | {"system": {"kind": "latolato", "lenght": 1.0}})
    with pytest.raises(ValueError, match="this describes no plan of a sweep: 'noise'"):
        Plan.from_description({k: v for k, v in text.items() if k != "noise"})


def test_threads_give_one_answer_whatever_the_chunks(tmp_path):
    arguments = {
        "axes": {"drive_amplitude": [0.0, 0.1, 0.2], "frequency_ratio": [1.0, 1.5, 2.0, 2.5]}
    }
    result = [
        ll.sweep(
            TOY,
            **SWEEP | arguments | {"chunk_size": size, "duration": 3.0},
            executor="threads",
            workers=2,
            store=tmp_path / f"{size}.zarr",
        ).load()
        for size in (1, 5, 12)
    ]
    for other in result[1:]:
        for name in result[0].variables:
            np.testing.assert_array_equal(other[name], result[0][name])


def test_a_store_without_a_variable_that_its_observable_gives_now_is_refused(tmp_path, monkeypatch):
    toy, path = ll.LatoLato(length=1.0, mass=0.8, radius=0.1), tmp_path / "old.zarr"
    arguments = {"axes": {"initial_angle": [0.4]}, "duration": 0.1, "store": path}
    ll.sweep(toy, observables=["impact_speed"], **arguments)
    kind = observables["impact_speed"]
    more = {**kind.variables, "median_impact_speed": kind.variables["mean_impact_speed"]}
    monkeypatch.setattr(kind, "variables", more)
    with pytest.raises(ll.InputError, match="has no median_impact_speed: the"):
        ll.sweep(toy, observables=["impact_speed"], **arguments)
