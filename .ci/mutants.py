"""Tries mutants of the physics, the observables and the engine on the tests: `make mutants`.

Cosmic Ray makes them; `mutants.toml` says where, how many, and which change nothing. They live in a
copy of the sources, where tests run as plain Python (`plain_python.py`).
"""

from __future__ import annotations

import json
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections import Counter, defaultdict
from pathlib import Path
from typing import Any, NamedTuple

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import MutationVisitor
from cosmic_ray.plugins import get_operator, operator_names

from latolato.core.cache import cache_directory
from latolato.numerics.abi import digest_of_sources

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
SETTINGS = tomllib.loads((HERE / "mutants.toml").read_text(encoding="utf-8"))


class Mutant(NamedTuple):
    """A file's code with one change: the number of the line, and the line before and after."""

    file: str
    code: str
    line: int
    before: str
    after: str


def places_in(file: Path) -> list[tuple[Path, list[tuple[str, int]]]]:
    """Return what can change at each place within functions, as operators and occurrences."""
    found = defaultdict(list)
    nodes = list(ast_nodes(get_ast(file.read_text(encoding="utf-8"))))
    for name in filter(re.compile(SETTINGS["operators"]).search, sorted(operator_names())):
        positions = get_operator(name)().mutation_positions
        places = [(node, start) for node in nodes for start, _ in positions(node)]
        for occurrence, (node, start) in enumerate(places):
            if node.search_ancestor("funcdef"):
                found[start].append((name, occurrence))
    return [(file, kinds) for _, kinds in sorted(found.items())]


def draw_mutants(group: dict[str, Any], draw: random.Random) -> list[Mutant]:
    """Return so many mutants of a group of files, each at a place of its own."""
    files = sorted({f for pattern in group["files"] for f in ROOT.glob(pattern)})
    drawn = []
    for file, kinds in draw.sample([p for f in files for p in places_in(f)], group["count"]):
        name, occurrence = draw.choice(kinds)
        old = file.read_text(encoding="utf-8")
        new = MutationVisitor.mutate_code(old, get_operator(name)(), occurrence)
        lines = enumerate(zip(old.splitlines(), new.splitlines(), strict=True), 1)
        line, (before, after) = next((n, pair) for n, pair in lines if pair[0] != pair[1])
        where = file.relative_to(ROOT).as_posix()
        drawn.append(Mutant(where, new, line, before.strip(), after.strip()))
    return drawn


def run_tests(group: dict[str, Any], folder: Path) -> str:
    """Return the first test of a group that fails in a folder, or nothing."""
    times = folder / f"{group['name']}.json"
    added = {
        "PYTHONPATH": os.pathsep.join(map(str, (folder / "src", HERE))),
        "PYTHONDONTWRITEBYTECODE": "1",  # two mutants may be of one size and one second
        "TIMES": str(times),
        "LONGEST": str(group["longest"]),
        "KERNELS": digest_of_sources() if group["is_compiled"] else "",
    }
    options = ["-p", "plain_python", "-p", "no:cacheprovider", "-p", "no:xdist", "-q", "--tb=no"]
    stop = ["-x"] if times.exists() else []
    command = [sys.executable, "-m", "pytest", *options, *stop, *group["tests"]]
    done = subprocess.run(
        command, cwd=folder, env={**os.environ, **added}, capture_output=True, text=True,
        check=False,
    )  # fmt: skip
    failed = re.search(r"^(?:FAILED|ERROR) (\S+)", done.stdout, re.MULTILINE)
    last = (done.stdout + done.stderr).strip().splitlines()[-1][:80]
    return "" if done.returncode == 0 else failed[1] if failed else last


def try_mutant(mutant: Mutant, group: dict[str, Any], folder: Path) -> str:
    """Return what became of a mutant, and print it."""
    begin, path = time.perf_counter(), folder / mutant.file
    known = SETTINGS["equivalent"]
    same = [k for k in known if (k["file"], k["after"]) == (mutant.file, mutant.after)]
    if same:
        fate, detail = "equivalent", same[0]["reason"]
    else:
        original = path.read_text(encoding="utf-8")
        path.write_text(mutant.code, encoding="utf-8")
        detail = run_tests(group, folder)
        path.write_text(original, encoding="utf-8")
        fate = "killed" if detail else "SURVIVED"
    print(f"{fate} in {time.perf_counter() - begin:.0f} s: {mutant.file}:{mutant.line} {detail}")
    print(f"  - {mutant.before}\n  + {mutant.after}", flush=True)
    return fate


def main() -> int:
    """Try the mutants of a seed; return 1 if one survives that nobody has explained."""
    seed = int(sys.argv[1]) if len(sys.argv) > 1 else SETTINGS["seed"]
    fates: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for part in ("src", "tests"):
            shutil.copytree(ROOT / part, folder / part)
        shutil.copy(ROOT / "pyproject.toml", folder)
        for group in SETTINGS["groups"]:
            begin = time.perf_counter()
            run_tests(group, folder)  # notes the tests that are quick enough
            if failed := run_tests(group, folder):
                # Every mutant would seem killed.
                print(f"{group['name']}: the tests fail without a mutant: {failed}")
                return 1
            count = len(json.loads((folder / f"{group['name']}.json").read_text()))
            print(f"{group['name']}: {count} quick tests, {time.perf_counter() - begin:.0f} s")
            mutants = draw_mutants(group, random.Random(seed))
            fates.update(try_mutant(mutant, group, folder) for mutant in mutants)
    shutil.rmtree(cache_directory() / "mutants", ignore_errors=True)
    print(f"seed {seed}: " + ", ".join(f"{n} {fate}" for fate, n in fates.items()))
    return int(fates["SURVIVED"] > 0)


if __name__ == "__main__":
    sys.exit(main())
