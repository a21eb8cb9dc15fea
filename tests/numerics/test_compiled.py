"""The disk cache of compiled kernels."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

RUN = """
import json, sys
import latolato as ll
body = dict(length=1.0, mass=0.8, quadratic_damping=0.02)  # its turning points are searched for
systems = {"pendulum": ll.Pendulum(**body), "mathieu": ll.Mathieu(**body)}
drive = ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.26)
found = {}
for name in sys.argv[1:]:
    run = ll.simulate(systems[name], drive, initial_angle=0.5, duration=5.0)
    found[name] = [float(run.angle[-1]), float(run.drive_work[-1]), float(run.total_energy[-1])]
print(json.dumps(found))
"""


def in_new_process(cache: Path, *names: str) -> dict[str, list[float]]:
    """Return the ends of runs made by a process of its own."""
    environment = {**os.environ, "LATOLATO_CACHE_DIR": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", RUN, *names],
        env=environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return dict(json.loads(done.stdout))


def test_kernels_cached_by_two_processes_serve_a_third(tmp_path: Path) -> None:
    """Parts of equal name in two cached libraries must not be taken for each other."""
    alone = in_new_process(tmp_path, "pendulum") | in_new_process(tmp_path, "mathieu")
    files = {f.name: f.stat().st_mtime_ns for f in tmp_path.rglob("*.nbc")}
    assert files
    assert in_new_process(tmp_path, "pendulum", "mathieu") == alone
    assert in_new_process(tmp_path, "mathieu", "pendulum") == alone
    after = {f.name: f.stat().st_mtime_ns for f in tmp_path.rglob("*.nbc")}
    assert after == files, "the third process compiled again instead of reading the cache"
