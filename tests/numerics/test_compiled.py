"""The disk cache of compiled kernels."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

# Pieces that come with the package are left aside.
RUN = """
import json, sys
import latolato as ll
from latolato.numerics import shipped
shipped._archive = lambda: None
body = dict(length=1.0, mass=0.8, quadratic_damping=0.02)  # its turning points are searched for
systems = {"pendulum": ll.Pendulum(**body), "mathieu": ll.Mathieu(**body)}
drive = ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.26)
found = {}
for name in sys.argv[1:]:
    run = ll.simulate(systems[name], drive, initial_angle=0.5, duration=5.0)
    found[name] = [float(run.angle[-1]), float(run.drive_work[-1]), float(run.total_energy[-1])]
print(json.dumps(found))
"""
# A kernel, what is imported then, and with an argument a law and a function that are new.
MIXED = """
import json, sys
import latolato as ll
from latolato.numerics import shipped
shipped._archive = lambda: None
def swing(**drag):
    system = ll.Pendulum(length=1.0, mass=0.8, **drag)
    return float(ll.simulate(system, initial_angle=0.5, duration=5.0).angle[-1])
found = [swing(), "numba.cpython.unicode" in sys.modules]
if sys.argv[1:]:
    import numba
    found += [swing(coulomb_damping=0.01), numba.njit(lambda text: len(text + "a"))("bc")]
print(json.dumps(found))
"""


def output_of(cache: Path, code: str, *given: str) -> str:
    """Return what code prints in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-c", code, *given],
        env={**os.environ, "LATOLATO_CACHE_DIR": str(cache)},
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout


def in_new_process(cache: Path, *names: str) -> dict[str, list[float]]:
    """Return the ends of runs made by a process of its own."""
    return dict(json.loads(output_of(cache, RUN, *names)))


def test_kernels_cached_by_two_processes_serve_a_third(tmp_path: Path) -> None:
    """Parts of equal name in two cached libraries must not be taken for each other."""
    alone = in_new_process(tmp_path, "pendulum") | in_new_process(tmp_path, "mathieu")
    files = {f.name: f.stat().st_mtime_ns for f in tmp_path.rglob("*.kernel")}
    assert files
    assert in_new_process(tmp_path, "pendulum", "mathieu") == alone
    assert in_new_process(tmp_path, "mathieu", "pendulum") == alone
    after = {f.name: f.stat().st_mtime_ns for f in tmp_path.rglob("*.kernel")}
    assert after == files, "the third process compiled again instead of reading the cache"


def test_reading_a_kernel_imports_no_compiler_and_leaves_compiling_possible(tmp_path: Path) -> None:
    angle, was_imported = json.loads(output_of(tmp_path, MIXED))
    assert was_imported

    found = json.loads(output_of(tmp_path, MIXED, "more"))

    assert found[:2] == [angle, False]
    assert abs(found[2]) < abs(angle)
    assert found[3] == 3
