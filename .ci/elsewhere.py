"""Installs the wheel in an environment of its own, away from the sources, and uses it.

``elsewhere.py [PYTHON]`` takes the newest packages and tries the application, file by file, with
the newest Python that is here and that pyproject.toml names, or with the given one.
``elsewhere.py --lowest`` takes the lowest versions that pyproject.toml declares and tries each
part once. Only the minima of users' extras are meant there; packages that ours need are as new as
they may be. `latolato[cuda]` is resolved but not installed: its libraries take gigabytes.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
import urllib.request
from collections.abc import Iterator
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).resolve().parents[1]
STATIC = ROOT / "src/latolato/app/static"
NOT_INSTALLED = "cuda"
NEWEST = """
latolato --version
latolato scenarios
latolato simulate fig04a_push --output run.nc
"""
# The package is the installed one, with all compiled code for pages, and its file is readable.
READ_BACK = """
import pathlib
import sys
import xarray as xr
import latolato as ll
where = pathlib.Path(ll.__file__)
assert pathlib.Path(sys.prefix) in where.parents, f"imported from {where}, not from the wheel"
modules = {path.name for path in (where.parent / "app" / "static" / "kernels").iterdir()}
names = "one", "two", "plane_one", "plane_two", "lanes"
kinds = {f"{name}{kind}.wasm" for name in names for kind in ("", "-scalar")}
assert modules == {"layout.json", *kinds}, modules
run = xr.open_dataset("run.nc")
assert run["angle"].attrs["units"] == "rad"
assert run.sizes["time"] > 100
"""
LOWEST = """
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
latolato fit posterior clip.csv --system pendulum --length 0.363 --mass 0.108 --damping 0.00274
    --unknown length --draws 100 --chains 2 --plot posterior.png
""".replace("\n    ", " ")
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


def project() -> dict[str, object]:
    """Return the project's table of pyproject.toml."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


def requirements(extras: set[str]) -> Iterator[Requirement]:
    """Yield what the package needs, with some of its extras."""
    for text in project()["dependencies"]:
        yield Requirement(text)
    for extra in sorted(extras):
        for text in project()["optional-dependencies"][extra]:
            if Requirement(text).name != "latolato":  # another of the extras
                yield Requirement(text)


def pinned(need: Requirement) -> str:
    """Return a requirement at its lowest version, as a constraint of pip."""
    (version,) = (each.version for each in need.specifier if each.operator == ">=")
    return f"{need.name}=={version}" + (f"; {need.marker}" if need.marker else "")


def newest_python() -> str:
    """Return the newest Python here that pyproject.toml names."""
    named = re.findall(r"Python :: (3\.\d+)", " ".join(project()["classifiers"]))
    for version in reversed(named):
        places = [*Path.home().glob(f".pyenv/versions/{version}.*/bin/python{version}")]
        for place in (*map(str, places), shutil.which(f"python{version}")):
            # What pyenv puts on the path may only say that this version is not chosen.
            if place and subprocess.run([place, "-c", "import venv"], check=False).returncode == 0:
                return place
    return sys.executable


def install(folder: Path, python: str, *, lowest: bool) -> dict[str, str]:
    """Install the wheel below a folder and return the environment in which its commands run."""
    (wheel,) = (ROOT / "dist").glob("*.whl")
    print(f"{wheel.name} with {python}", flush=True)
    subprocess.run([python, "-m", "venv", "--without-pip", folder / "venv"], check=True)
    binaries = folder / "venv" / ("Scripts" if os.name == "nt" else "bin")
    pip = [
        *(sys.executable, "-m", "pip", "--python", str(folder / "venv"), "install", "-q"),
        *("--disable-pip-version-check", "--no-compile"),
    ]
    if lowest:
        (everything,) = project()["optional-dependencies"]["all"]
        extras = Requirement(everything).extras
        pins = [pinned(need) for need in requirements(extras)]
        (folder / "lowest.txt").write_text("\n".join(pins), encoding="utf-8")
        pip += ["-c", str(folder / "lowest.txt")]
        print("installing", *pins, flush=True)
        chosen = ",".join(sorted(extras - {NOT_INSTALLED}))
        subprocess.run([*pip, f"{wheel}[{chosen}]"], check=True)
        subprocess.run([*pip, "--dry-run", f"{wheel}[{NOT_INSTALLED}]"], check=True)
    else:
        subprocess.run([*pip, f"{wheel}[app]"], check=True)
    # Kernels of another compiler are of no use to anyone later.
    environment = {**os.environ, "LATOLATO_CACHE_DIR": str(folder / "kernels")}
    environment |= {"PATH": f"{binaries}{os.pathsep}{environment['PATH']}", "MPLBACKEND": "Agg"}
    environment.pop("PYTHONPATH", None)
    return environment


def found(command: str, environment: dict[str, str]) -> list[str]:
    """Return the words of a command; on Windows the path of an environment finds no programs."""
    name, *words = command.split()
    return [shutil.which(name, path=environment["PATH"]), *words]


def use(commands: str, codes: tuple[str, ...], files: Path, environment: dict[str, str]) -> None:
    """Run commands, then pieces of Python, in a folder."""
    for command in commands.strip().splitlines():
        print("$", command, flush=True)
        subprocess.run(found(command, environment), cwd=files, env=environment, check=True)
    for code in codes:
        print("$ python -c", code, flush=True)
        python = found("python", environment)
        subprocess.run([*python, "-c", code], cwd=files, env=environment, check=True)


def try_the_application(files: Path, environment: dict[str, str]) -> None:
    """Ask the application for every file of its pages and for a run."""
    command = "latolato app --no-browser --port 0"
    print("$", command, flush=True)
    with subprocess.Popen(
        found(command, environment), cwd=files, env=environment, stdout=subprocess.PIPE, text=True
    ) as server:
        address = server.stdout.readline().split(" at ")[1].strip()
        try:
            assert b"latolato" in urllib.request.urlopen(address).read()
            served = [path for path in STATIC.rglob("*") if path.is_file()]
            for path in served:
                url = f"{address}{path.relative_to(STATIC).as_posix()}"
                assert urllib.request.urlopen(url).read() == path.read_bytes(), url
            asked = urllib.request.Request(
                f"{address}api/run",
                b'{"scenario": "fig02", "options": {"duration": "8 s"}}',
                {"Content-Type": "application/json"},
            )
            assert len(urllib.request.urlopen(asked).read()) > 1000
        finally:
            server.terminate()
    print(f"the application serves its page, {len(served)} files of it and a run")


def main() -> None:
    """Install, then use each part once."""
    lowest = sys.argv[1:] == ["--lowest"]
    if lowest:
        python = sys.executable
    elif sys.argv[1:]:
        python = sys.argv[1]
    else:
        python = newest_python()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        files = folder / "files"
        files.mkdir()
        environment = install(folder, python, lowest=lowest)
        if lowest:
            use(LOWEST, (PLAY, COMPILE), files, environment)
        else:
            use(NEWEST, (READ_BACK,), files, environment)
        try_the_application(files, environment)


if __name__ == "__main__":
    main()
