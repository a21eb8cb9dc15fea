"""The disk cache of compiled kernels."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

# Of the kernels that come with the package these are left aside: they are compiled soonest.
BEGIN = """
import json, sys
import latolato as ll
from latolato.numerics import shipped
load, aside = shipped.load, {"observer", "plane_observer"}
shipped.load = lambda spec: None if spec.name in aside else load(spec)
body = ll.Pendulum(length=1.0, mass=0.8, quadratic_damping=0.02)
shaken = dict(vertical_amplitude=0.1, horizontal_amplitude=0.05, drive_frequency=6.26)
drives = {
    "vertical": ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.26),
    "planar": ll.PlanarHarmonic(**shaken),
}
def end_of(name):
    run = ll.simulate(body, drives[name], initial_angle=0.5, duration=5.0)
    return [float(run.angle[-1]), float(run.tension[-1]), float(run.total_energy[-1])]
"""
RUN = (
    BEGIN
    + """
print(json.dumps({name: end_of(name) for name in sys.argv[1:]}))
"""
)
# A kernel, what is imported then, a kernel and a function that are new.
MIXED = (
    BEGIN
    + """
ends = end_of("vertical")
def is_imported():
    return "numba.cpython.unicode" in sys.modules
before = is_imported()
import numba
aside.add("callback")
axes, seen = {"gravity": [9.0, 9.8]}, ["largest_angle"]
grid = ll.sweep(body, axes=axes, observables=seen, duration=5.0, initial_angle=0.5)
length = numba.njit(lambda text: len(text + "a"))("bc")
print(json.dumps([ends, float(grid.largest_angle[0]), length, before, is_imported()]))
"""
)


def output_of(cache: Path, code: str, *arguments: str) -> str:
    """Return what code prints in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        env={**os.environ, "LATOLATO_CACHE_DIR": str(cache)},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout


def in_new_process(cache: Path, *names: str) -> dict[str, list[float]]:
    """Return the ends of runs made by a process of its own."""
    return dict(json.loads(output_of(cache, RUN, *names)))


@pytest.fixture(scope="module")
def filled(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, list[float]]]:
    """A cache that two processes have filled, and the ends of their runs."""
    cache = tmp_path_factory.mktemp("cache")
    return cache, in_new_process(cache, "vertical") | in_new_process(cache, "planar")


def test_kernels_cached_by_two_processes_serve_a_third(
    filled: tuple[Path, dict[str, list[float]]],
) -> None:
    """Parts of equal name in two cached libraries must not be taken for each other."""
    cache, alone = filled
    files = {f.name: f.stat().st_mtime_ns for f in cache.rglob("*.kernel")}
    assert len(files) == 2
    assert in_new_process(cache, "vertical", "planar") == alone
    assert in_new_process(cache, "planar", "vertical") == alone
    after = {f.name: f.stat().st_mtime_ns for f in cache.rglob("*.kernel")}
    assert after == files, "the third process compiled again instead of reading the cache"


def test_reading_a_kernel_imports_no_compiler_and_leaves_compiling_possible(
    filled: tuple[Path, dict[str, list[float]]],
) -> None:
    cache, alone = filled
    files = len(list(cache.rglob("*.kernel")))
    ends, largest, length, *is_imported = json.loads(output_of(cache, MIXED))
    assert ends == alone["vertical"]
    assert is_imported == [False, True]
    assert largest == pytest.approx(0.5)
    assert length == 3
    assert len(list(cache.rglob("*.kernel"))) > files
