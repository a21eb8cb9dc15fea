"""Installs the lowest versions that pyproject.toml declares in a new environment and tries them.

Only the minima of users' extras are meant; packages that ours need are as new as they may be.
`latolato[cuda]` is resolved but not installed: its libraries take gigabytes.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import tomllib
import urllib.request
from collections.abc import Iterator
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parents[1]
NOT_INSTALLED = "cuda"
PLAY = """
import latolato as ll
for name in ("run.nc", "run.parquet"):
    assert ll.play(ll.load(name)) is not None
"""
# What numba compiles for laws of one's own, here for all.
COMPILE = """
import latolato as ll
from latolato.numerics import shipped
shipped._archive = lambda: None
assert ll.load_scenario("fig02").simulate(duration=8.0).status == "complete"
"""
COMMANDS = """
latolato simulate fig02 --duration 8 --output run.nc --plot run.png --animate run.mp4
latolato simulate fig02 --duration 8 --output run.parquet
latolato sweep fig02 --duration 8 --axis length=0.2:0.4:6 --store map.zarr --plot map.svg
latolato sweep fig02 --duration 8 --axis length=0.2:0.4:6 --executor dask --workers 1 --output d.nc
latolato plot map.zarr --output again.png
latolato analyse tongue_edges fig03a --plot tongue.png
latolato synthesise --system pendulum --length 0.363 --mass 0.108 --damping 0.00274
    --initial-angle 0.4 --duration 8 --scene ball_radius=0.0242 --camera fps=60 --output clip.mp4
latolato track clip.mp4 --balls 1 --length 0.363 --radius 0.0242 --output clip.csv
    --report clip.html
latolato fit decay clip.csv --length 0.363 --mass 0.108 --plot decay.png
""".replace("\n    ", " ")


def requirements(project: dict[str, object], extras: set[str]) -> Iterator[Requirement]:
    """Yield what the package needs, with some of its extras."""
    for text in project["dependencies"]:
        yield Requirement(text)
    for extra in sorted(extras):
        for text in project["optional-dependencies"][extra]:
            yield Requirement(text)


def pinned(need: Requirement) -> str:
    """Return a requirement at its lowest version, as a constraint of pip."""
    (version,) = (each.version for each in need.specifier if each.operator == ">=")
    return f"{need.name}=={version}" + (f"; {need.marker}" if need.marker else "")


def main() -> None:
    """Install, then use each part once."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    (everything,) = project["optional-dependencies"]["all"]
    extras = Requirement(everything).extras
    pins = [pinned(need) for need in requirements(project, extras)]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "lowest.txt").write_text("\n".join(pins), encoding="utf-8")
        subprocess.run([sys.executable, "-m", "venv", "--without-pip", folder / "venv"], check=True)
        binaries = folder / "venv/bin"
        install = [
            *(sys.executable, "-m", "pip", "--python", str(binaries / "python"), "install", "-q"),
            *("--disable-pip-version-check", "--no-compile", "-c", str(folder / "lowest.txt")),
        ]
        print("installing", *pins, flush=True)
        chosen = ",".join(sorted(extras - {NOT_INSTALLED}))
        subprocess.run([*install, f"{ROOT}[{chosen}]"], check=True)
        subprocess.run([*install, "--dry-run", f"{ROOT}[{NOT_INSTALLED}]"], check=True)
        # Kernels of another compiler are of no use to anyone later.
        environment = {**os.environ, "LATOLATO_CACHE_DIR": str(folder / "kernels")}
        environment |= {"PATH": f"{binaries}{os.pathsep}{environment['PATH']}", "MPLBACKEND": "Agg"}
        environment.pop("PYTHONPATH", None)
        files = folder / "files"
        files.mkdir()
        for command in COMMANDS.strip().splitlines():
            print("$", command, flush=True)
            subprocess.run(command.split(), cwd=files, env=environment, check=True)
        for code in (PLAY, COMPILE):
            print("$ python -c", code, flush=True)
            subprocess.run(["python", "-c", code], cwd=files, env=environment, check=True)
        try_the_application(files, environment)


def try_the_application(files: Path, environment: dict[str, str]) -> None:
    """Ask the application for its page and for a run."""
    command = ["latolato", "app", "--no-browser", "--port", "0"]
    print("$", *command, flush=True)
    with subprocess.Popen(
        command, cwd=files, env=environment, stdout=subprocess.PIPE, text=True
    ) as server:
        address = server.stdout.readline().split(" at ")[1].strip()
        try:
            assert b"latolato" in urllib.request.urlopen(address).read()
            asked = urllib.request.Request(
                f"{address}api/run",
                b'{"scenario": "fig02", "options": {"duration": "8 s"}}',
                {"Content-Type": "application/json"},
            )
            assert len(urllib.request.urlopen(asked).read()) > 1000
        finally:
            server.terminate()


if __name__ == "__main__":
    main()
