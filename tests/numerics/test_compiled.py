"""The disk cache of compiled kernels."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

# Kernels that come with the package are left aside.
BEGIN = """
import json, sys
import latolato as ll
from latolato.numerics import shipped
shipped._archive = lambda: None
body = dict(length=1.0, mass=0.8, quadratic_damping=0.02)  # its turning points are searched for
drive = ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.26)
def end_of(system):
    run = ll.simulate(system, drive, initial_angle=0.5, duration=5.0)
    return [float(run.angle[-1]), float(run.drive_work[-1]), float(run.total_energy[-1])]
"""
RUN = (
    BEGIN
    + """
systems = {"pendulum": ll.Pendulum(**body), "mathieu": ll.Mathieu(**body)}
print(json.dumps({name: end_of(systems[name]) for name in sys.argv[1:]}))
"""
)
# A kernel, what is imported then, a law and a function that are new.
MIXED = (
    BEGIN
    + """
ends = end_of(ll.Pendulum(**body))
def is_imported():
    return "numba.cpython.unicode" in sys.modules
before = is_imported()
import numba
rough = end_of(ll.Pendulum(coulomb_damping=0.1, **body))
length = numba.njit(lambda text: len(text + "a"))("bc")
print(json.dumps([ends, rough, length, before, is_imported()]))
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
    return cache, in_new_process(cache, "pendulum") | in_new_process(cache, "mathieu")


def test_kernels_cached_by_two_processes_serve_a_third(
    filled: tuple[Path, dict[str, list[float]]],
) -> None:
    """Parts of equal name in two cached libraries must not be taken for each other."""
    cache, alone = filled
    files = {f.name: f.stat().st_mtime_ns for f in cache.rglob("*.kernel")}
    assert files
    assert in_new_process(cache, "pendulum", "mathieu") == alone
    assert in_new_process(cache, "mathieu", "pendulum") == alone
    after = {f.name: f.stat().st_mtime_ns for f in cache.rglob("*.kernel")}
    assert after == files, "the third process compiled again instead of reading the cache"


def test_reading_a_kernel_imports_no_compiler_and_leaves_compiling_possible(
    filled: tuple[Path, dict[str, list[float]]],
) -> None:
    cache, alone = filled
    ends, rough, length, *is_imported = json.loads(output_of(cache, MIXED))
    assert ends == alone["pendulum"]
    assert is_imported == [False, True]
    assert rough[2] < ends[2]
    assert length == 3
