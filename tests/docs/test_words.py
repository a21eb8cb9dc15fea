"""The word list of `make lint` finds what it refuses, and nothing else."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def words(*names):
    """Return what the check prints."""
    command = [sys.executable, ROOT / ".ci" / "words.py", *names]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == bool(result.stderr)
    return result.stderr


@pytest.mark.parametrize(
    "name, text, phrase",
    [
        ("a.md", "Of what takes\nlonger the time is told.", "Of what takes"),
        ("a.md", "It says beside\nit why a value cannot be.", "says beside"),
        ("a.md", "It explains why a value cannot be.", "why a value cannot be"),
        ("a.md", "Hardly: 5% of them.", "5%"),
        ("a.py", '# Computed\n    # anew.\nx = "it parts "\n"from it"\n', "parts from"),
        ("a.js", "// What a page knows\n  // of a map.\n", "knows of"),
        ("a.json", '{"hint": "What is left."}', "What is left"),
    ],
)
def test_a_planted_phrase_is_refused_with_its_line(tmp_path, name, text, phrase):
    path = tmp_path / name
    path.write_text(f"\n{text}\n", "utf-8")
    line = 2 + text[: text.lower().index(phrase.lower().split()[0])].count("\n")
    assert f"{path}:{line}: '{phrase}" in words(path)


def test_ordinary_words_are_not_refused(tmp_path):
    path = tmp_path / "a.md"
    path.write_text(
        "They are told apart. A value that cannot be read is left out. Two parts. 5 % of it. "
        'What is left out stays. <p style="width: 50%">',
        "utf-8",
    )
    assert words(path) == ""


def test_the_repository_has_none():
    assert words() == ""
