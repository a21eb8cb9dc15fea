"""The recipe for a new kind of drag names every file that knows one of the present kinds."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[2]
SOURCES = ROOT / "src" / "latolato"
# What is not asked when drag is added: measurements, the paper, texts and scenarios.
ELSEWHERE = ("experiment", "paper", "scenario", "languages", "stories", "vendor")


def recipe():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    return text.partition("A new kind of drag")[2].partition("A command is a function")[0]


def files_that_know(pattern):
    for path in [*SOURCES.rglob("*.py"), *SOURCES.rglob("*.js")]:
        parts = path.relative_to(SOURCES).parts
        is_asked = not {part.partition(".")[0] for part in parts} & set(ELSEWHERE)
        if is_asked and re.search(pattern, path.read_text(encoding="utf-8")):
            yield "/".join(parts)


def test_the_recipe_names_every_file_that_reads_quadratic_drag():
    known = set(files_that_know(r"[.\"']quadratic\b|quadratic_damping"))
    named = set(re.findall(r"`([\w/]+\.(?:py|js))`", recipe()))
    assert known == named


def test_the_functions_that_the_recipe_names_are_those_of_the_laws():
    from latolato.physics import damping

    first = recipe().partition(";")[0]
    names = set(re.findall(r"`(\w+)`", first))
    assert names
    assert names <= set(vars(damping))
