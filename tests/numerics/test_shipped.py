"""The compiled kernels that come with the package."""

from __future__ import annotations

import json
import struct
import subprocess
import sys
import zipfile
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np
import pytest

import latolato as ll
from latolato.core import cache
from latolato.numerics import abi, kernels, shipped
from latolato.observables import Observable

# Every kind of system, drive, contact and observable, and a question; prints what was imported.
EVERYTHING = """
import json, sys
from dataclasses import replace
import numpy as np
import latolato as ll
body = dict(length=1.0, mass=0.8)
ball = ll.Ball(**body, radius=0.1, damping=0.02)
harmonic = ll.Harmonic(drive_amplitude=0.2, drive_frequency=6.26)
crank = dict(drive_amplitude=0.1, drive_frequency=6.26, connecting_rod_length=0.4)
times = np.linspace(0.0, 6.0, 30)
drives = [
    None, ll.FixedPivot(), harmonic, ll.CrankSlider(**crank),
    ll.Chirp(drive_amplitude=0.1, drive_frequency=3.0, drive_frequency_final=9.0, sweep_time=5.0),
    ll.MeasuredPivot(times=times, pivot_heights=0.1 * np.sin(6.0 * times)),
]
systems = [
    ll.Pendulum(**body), ll.Pendulum(**body, quadratic_damping=0.1, coulomb_damping=0.05),
    ll.Mathieu(**body), ll.LatoLato(**body, radius=0.1, restitution=0.9),
    ll.BallPair(right=ball, left=ball, restitution=0.9),
]
for system in systems:
    for drive in drives:
        start = (0.5, -0.4) if system.angles == 2 else 0.5
        ll.simulate(system, drive, initial_angle=start, duration=5.0)
toy = systems[3]
clamp = ll.ClampContact(clamp_step=1e-3)
ll.simulate(toy, harmonic, initial_angle=0.5, duration=5.0, contact=clamp)
axes = {"drive_amplitude": np.linspace(0.05, 0.3, 3), "drive_frequency": np.linspace(2.0, 9.0, 3)}
for system in systems[:4]:
    for name in sys.argv[1].split():
        ll.sweep(system, harmonic, axes=axes, observables=[name], duration=5.0, initial_angle=0.5)
planar = ll.PlanarHarmonic(vertical_amplitude=0.1, horizontal_amplitude=0.1, drive_frequency=6.0)
for kind, start, drive in (
    (systems[0], 0.5, planar), (systems[3], 0.5, harmonic), (systems[4], (0.5, -0.4), planar),
):
    hung = replace(kind, suspension="string", string_restitution=0.5, drag_frame="lab")
    ll.simulate(hung, drive, initial_angle=start, duration=5.0)
    for name in sys.argv[2].split():
        ll.sweep(
            hung, drive, axes={"gravity": [9.0, 9.8]}, observables=[name], duration=5.0,
            initial_angle=start,
        )
ll.sweep(
    systems[4], harmonic, axes=axes, observables=["transverse_exponent", "mean_energy"],
    duration=5.0, initial_angle=(0.5, -0.5),
)
ll.analysis.floquet(systems[0], harmonic, initial_angle=0.0)
ll.analysis.lyapunov_spectrum(toy, harmonic, initial_angle=0.5, duration=5.0)
print(json.dumps("numba" in sys.modules))
"""


def kinds(kind: type = Observable) -> list[type]:
    """Return every observable of the package."""
    result = [each for each in kind.__subclasses__() if each.__module__.startswith("latolato.")]
    return [one for each in result for one in (each, *kinds(each))]


@pytest.fixture
def forgotten(monkeypatch, tmp_path):
    """A process that has no kernel yet, and an empty cache folder."""
    folder = tmp_path / "cache"
    folder.mkdir(mode=0o700)
    monkeypatch.setenv("LATOLATO_CACHE_DIR", str(folder))
    known = kernels._kernel, shipped._archive, shipped._this_machine, cache.warn
    for function in known:
        function.cache_clear()
    yield folder
    for function in known:
        function.cache_clear()


def engine() -> abi.KernelSpec:
    """Return the engine of one ball."""
    return next(kernels.every_spec([]))


def test_every_kernel_is_there():
    archive = shipped._archive()
    assert archive is not None, "type `make kernels`: there are none of these sources"
    specs = list(kernels.every_spec(kinds()))
    assert len(specs) > 50
    assert {spec.key for spec in specs} == set(archive.names)


def test_what_comes_with_the_package_never_imports_numba():
    from latolato.observables.base import observables

    names = " ".join(
        name
        for name, kind in observables.items()
        if name != "transverse_exponent" and not kind.of_strings
    )
    of_strings = " ".join(name for name, kind in observables.items() if kind.of_strings)
    done = subprocess.run(
        [sys.executable, "-c", EVERYTHING, names, of_strings],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) is False


def runs(count: int) -> list[list[float]]:
    """Return ends and ledgers of random runs of all kinds."""
    random, result = np.random.default_rng(16), []
    for number in range(count):
        body = {"length": random.uniform(0.3, 2.0), "mass": random.uniform(0.1, 1.0)}
        body["damping"] = random.choice([0.0, 0.05])
        body["coulomb_damping"] = random.choice([0.0, 0.0, 0.1])
        drive = ll.Harmonic(
            drive_amplitude=random.uniform(0.0, 0.4), drive_frequency=random.uniform(1.0, 12.0)
        )
        ball, other = ll.Ball(**body, radius=0.1), ll.Ball(**{**body, "mass": 0.5}, radius=0.1)
        restitution = random.uniform(0.5, 1.0)
        system = (
            ll.Pendulum(**body),
            ll.LatoLato(**body, radius=0.1, restitution=restitution),
            ll.BallPair(right=ball, left=other, restitution=restitution),
        )[number % 3]
        angle = random.uniform(0.4, 0.9)
        start = (angle, -0.4) if system.angles == 2 else angle
        run = ll.simulate(system, drive, initial_angle=start, duration=4.0)
        ends = [run[name].values.ravel()[-1] for name in ("angle", "drive_work", "tension")]
        result.append([*map(float, ends), run.attrs["contacts"]])
    return result


@pytest.mark.slow
def test_numba_computes_the_same(forgotten, monkeypatch):
    as_shipped = np.array(runs(60))
    kernels._kernel.cache_clear()
    monkeypatch.setattr(shipped, "load", lambda spec: None)
    assert list(forgotten.rglob("*.o"))
    np.testing.assert_allclose(np.array(runs(60)), as_shipped, rtol=1e-7, atol=1e-9)
    assert list(forgotten.rglob("*.kernel"))


def test_machine_code_is_kept_and_checked(forgotten):
    assert shipped.load(engine()).address != 0
    (file,) = forgotten.rglob("*.o")
    made = file.stat().st_mtime_ns
    assert shipped.load(engine()).address != 0
    assert file.stat().st_mtime_ns == made
    content = cache.read(file)
    file.write_bytes(file.read_bytes()[:-1] + b"?")
    assert shipped.load(engine()).address != 0
    assert cache.read(file) == content


INTEL = "-sse4a,+avx512f,+avx512vl"


@pytest.mark.parametrize(
    "name, features, tuned",
    [
        ("cascadelake", INTEL, "znver4"),
        ("rocketlake", INTEL, "znver4"),
        ("haswell", "+avx2,-avx512f,-avx512vl", "haswell"),
        ("knl", "+avx512f,-avx512vl", "knl"),
        ("znver5", INTEL, "znver5"),
        ("apple-m1", "+neon", "apple-m1"),
        ("generic", "", "generic"),
    ],
)
def test_lanes_are_tuned_where_vectors_of_512_bits_are_avoided(name, features, tuned):
    processor = shipped.Processor(name, features)
    assert shipped.tuned_for_lanes(processor) == (tuned, features)


def lanes(name: str, monkeypatch: pytest.MonkeyPatch) -> bytes:
    """Return a map, computed in lanes that are scheduled for a processor of that name."""
    monkeypatch.setattr(shipped, "tuned_for_lanes", lambda processor: processor._replace(name=name))
    shipped._this_machine.cache_clear()
    kernels._kernel.cache_clear()
    result = ll.sweep(
        ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.9),
        axes={
            "drive_amplitude": np.linspace(0.02, 0.4, 8),
            "frequency_ratio": np.linspace(0.3, 5.0, 20),
        },
        duration=10.0,
        observables=["mean_energy", "crossings", "final_angle"],
        initial_offset=0.2,
        tolerance=1e-6,
    )
    return b"".join(values.values.tobytes() for values in result.data_vars.values())


def test_tuning_changes_no_bit(forgotten, monkeypatch):
    own = shipped.this_processor().name
    if not llvm.get_process_triple().startswith("x86_64"):
        pytest.skip("lanes are tuned on x86_64 only")
    as_it_is = lanes(own, monkeypatch)
    before = len(list(forgotten.rglob("*.o")))
    other = "znver4" if own != "znver4" else "cascadelake"
    assert lanes(other, monkeypatch) == as_it_is
    assert len(list(forgotten.rglob("*.o"))) > before  # some were made again


def test_edited_sources_are_left_to_numba(forgotten, monkeypatch):
    monkeypatch.setattr(shipped, "digest_of_sources", lambda: "edited")
    assert shipped.load(engine()) is None
    monkeypatch.undo()
    monkeypatch.setattr(shipped, "ARCHIVE", forgotten / "none.zip")
    shipped._archive.cache_clear()
    assert shipped.load(engine()) is None


def archive(folder: Path, **changes: object) -> Path:
    """Return a copy of the package's kernels with another description, or of a damaged kernel."""
    with zipfile.ZipFile(shipped.ARCHIVE) as arguments:
        about = json.loads(arguments.read("about.json"))
        code = arguments.read(about["kernels"][engine().key])
    content = {"about.json": json.dumps({**about, **changes}).encode()}
    content[about["kernels"][engine().key]] = code[: len(code) // 2] if not changes else code
    copy = folder / "copy.zip"
    with zipfile.ZipFile(copy, "w") as written:
        for name, data in content.items():
            written.writestr(name, data)
    return copy


def flipped(folder: Path) -> Path:
    """Return a copy of the package's kernels with one wrong byte in the first of them."""
    with zipfile.ZipFile(shipped.ARCHIVE) as arguments:
        name = json.loads(arguments.read("about.json"))["kernels"][engine().key]
        at = arguments.getinfo(name).header_offset + 1000
    content = bytearray(shipped.ARCHIVE.read_bytes())
    content[at] ^= 255
    copy = folder / "flipped.zip"
    copy.write_bytes(content)
    return copy


@pytest.mark.parametrize(
    "trouble, reason",
    [
        ("cut", "zip"),
        ("flipped", ""),
        ("calls", "no_such_function"),
        ("odd", "int"),
        ("damaged", "bitcode"),
    ],
)
def test_what_cannot_be_used_is_said_once(forgotten, monkeypatch, tmp_path, trouble, reason):
    if trouble == "cut":
        copy = tmp_path / "cut.zip"
        copy.write_bytes(shipped.ARCHIVE.read_bytes()[:5000])
    elif trouble == "flipped":
        copy = flipped(tmp_path)
    elif trouble == "calls":
        copy = archive(tmp_path, calls=["sqrt", "no_such_function"])
    elif trouble == "odd":
        copy = archive(tmp_path, calls=7)
    else:
        copy = archive(tmp_path)
    monkeypatch.setattr(shipped, "ARCHIVE", copy)
    words = f"cannot be used here .*{reason}.*, so numba compiles it"
    with pytest.warns(RuntimeWarning, match=words) as caught:
        result = [shipped.load(engine()) for _ in range(2)]
    assert result == [None, None]
    assert len(caught) == 1


def test_replacing_the_file_changes_nothing_in_a_process_that_runs(
    forgotten, monkeypatch, tmp_path
):
    copy = tmp_path / "kernels.zip"
    copy.write_bytes(shipped.ARCHIVE.read_bytes())
    monkeypatch.setattr(shipped, "ARCHIVE", copy)
    names = dict(shipped._archive().names)
    copy.write_bytes(flipped(tmp_path).read_bytes()[:3000])
    assert shipped.load(engine()).address != 0
    assert shipped._archive().names == names


def words(code: bytes, at: int, layout: str) -> tuple[int, ...]:
    """Return numbers of an object file."""
    return struct.unpack_from("<" + layout, code, at)


def elf_of(code: bytes) -> tuple[set[int], set[str]]:
    """Return the kinds of relocations of an ELF file of 64 bits, and what it does not define."""
    first, size, count = *words(code, 40, "Q"), *words(code, 58, "HH")
    sections = [words(code, first + i * size, "IIQQQQIIQQ") for i in range(count)]
    kinds, missing = set(), set()
    for _, kind, _, _, at, length, link, _, _, step in sections:
        for i in range(at, at + length, step or length or 1):
            if kind == 4:  # relocations
                kinds.add(words(code, i, "QIIq")[1])
            elif kind == 2:  # symbols
                name, _, _, section, _, _ = words(code, i, "IBBHQQ")
                begin = sections[link][4] + name
                text = code[begin : code.index(b"\0", begin)].decode()
                if section == 0 and text:
                    missing.add(text)
    return kinds, missing


# The first bytes of an object file, of ELF or Mach-O, and where it names the processor.
@pytest.mark.parametrize(
    "triple, first, at, processor",
    [
        ("x86_64-unknown-linux-gnu", b"\x7fELF", 18, 62),
        ("aarch64-unknown-linux-gnu", b"\x7fELF", 18, 183),
        ("x86_64-apple-macosx11", b"\xcf\xfa\xed\xfe", 4, 7),
        ("arm64-apple-macosx11", b"\xcf\xfa\xed\xfe", 4, 12),
        ("x86_64-pc-windows-msvc-elf", b"\x7fELF", 18, 62),  # llvmlite loads ELF there as well
    ],
)
def test_other_platforms_get_their_machine_code(triple, first, at, processor):
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    target = shipped.target_for(triple)
    with zipfile.ZipFile(shipped.ARCHIVE) as arguments:
        about = json.loads(arguments.read("about.json"))
        names = list(about["kernels"].values())
        for name in (names[5], names[-1]):
            code = shipped.machine_code(arguments.read(name), target)
            assert code.startswith(first)
            assert int.from_bytes(code[at : at + 2], "little") == processor
            assert name.encode() in code
            if processor == 62:
                kinds, missing = elf_of(code)
                assert kinds <= {1, 24}  # absolute and relative addresses of 64 bits: no tables
                assert missing <= set(about["calls"])


@pytest.mark.slow
def test_the_functions_that_all_kernels_call_are_known(forgotten):
    archive = shipped._archive()
    target = shipped._this_machine(for_lanes=False).target
    with zipfile.ZipFile(shipped.ARCHIVE) as arguments:
        calls = set(json.loads(arguments.read("about.json"))["calls"])
    for name in archive.names.values():
        _, missing = elf_of(shipped.machine_code(archive.content.read(name), target))
        assert missing <= calls, name


def test_words_are_those_of_the_kind_that_is_expected():
    example = (1.0, 1, np.zeros(2))
    good = abi.words_of((2, np.int64(3), np.ones(3)), example)
    assert struct.unpack("d", struct.pack("q", good[0])) == (2.0,)
    assert good[1] == 3
    assert good[3:] == [3, 8]
    for bad in (
        (1.0, 2.5, np.ones(3)),
        (1.0, 2, 5),
        (1.0, 2, np.ones(3, dtype=np.int64)),
        (1.0, 2, np.ones((3, 3))),
        (1.0, 2, np.ones(6)[::2]),
    ):
        with pytest.raises(TypeError):
            abi.words_of(bad, example)
