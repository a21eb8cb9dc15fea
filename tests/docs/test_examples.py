"""The scripts in examples/, run as a user runs them; each asserts a number of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

import latolato as ll

FOLDER = Path(__file__).parents[2] / "examples"
SCRIPTS = sorted(FOLDER.glob("*.py"))


def test_the_folder_holds_the_examples_and_each_asserts_something():
    assert len(SCRIPTS) >= 4
    for script in SCRIPTS:
        text = script.read_text(encoding="utf-8")
        assert "\nassert " in text or "\n    assert " in text, script.name
        assert len(text.splitlines()) <= 80, script.name


@pytest.mark.parametrize("script", SCRIPTS, ids=[script.stem for script in SCRIPTS])
def test_an_example_succeeds_and_draws_its_picture(script, tmp_path):
    picture = tmp_path / "picture.png"
    done = subprocess.run(
        [sys.executable, "-W", "error", str(script), str(picture)],
        capture_output=True,
        text=True,
        encoding="utf-8",
        cwd=tmp_path,
        env={**os.environ, "PYTHONIOENCODING": "utf-8"},
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    assert done.stdout.strip()
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_the_table_of_analyses_names_them_all():
    page = FOLDER.parent / "docs" / "how-to" / "analysis.md"
    table = page.read_text(encoding="utf-8")
    missing = [name for name in ll.analysis.analyses if f"`analysis.{name}(" not in table]
    assert not missing
