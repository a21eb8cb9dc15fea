"""Every file that states version, date or licence of the release states the same."""

import json
import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def text(name):
    return (ROOT / name).read_text(encoding="utf-8")


PROJECT = tomllib.loads(text("pyproject.toml"))["project"]
VERSION, DATE = re.search(r"^## (\S+), (\d{4}-\d\d-\d\d)$", text("CHANGELOG.md"), re.M).groups()


def test_the_newest_entry_of_the_changelog_is_the_version_of_the_package():
    assert PROJECT["version"] == VERSION


def test_the_citation_agrees():
    citation = text("CITATION.cff")
    assert f"\nversion: {VERSION}\n" in citation
    assert f'\ndate-released: "{DATE}"\n' in citation
    assert f"\nlicense: {PROJECT['license']}\n" in citation
    listed = citation.split("\nkeywords:\n")[1].split("\nreferences:")[0]
    assert re.findall(r"  - (.+)", listed) == PROJECT["keywords"]


def test_what_archives_and_catalogues_read_agrees():
    catalogue, archive = json.loads(text("codemeta.json")), json.loads(text(".zenodo.json"))
    assert catalogue["version"] == archive["version"] == VERSION
    assert catalogue["datePublished"] == archive["publication_date"] == DATE
    assert catalogue["license"].endswith("/" + PROJECT["license"])
    assert archive["license"] == PROJECT["license"]
    assert catalogue["keywords"] == archive["keywords"] == PROJECT["keywords"]
    (author,), (creator,), (owner,) = catalogue["author"], archive["creators"], PROJECT["authors"]
    assert author["name"] == creator["name"] == owner["name"]


def test_the_recipe_for_conda_needs_what_the_package_and_its_application_need():
    recipe, extras = text("conda.recipe/recipe.yaml"), PROJECT["optional-dependencies"]
    assert f'version: "{VERSION}"' in recipe
    needed = {*PROJECT["dependencies"], *extras["app"], *extras["tables"]} - {"latolato[tables]"}
    needed = {need.replace("matplotlib>", "matplotlib-base>") for need in needed}
    listed = recipe.split("  run:\n")[1].split("\ntests:")[0]
    packages = re.findall(r"- (\S+) (>=\S+)", listed)
    assert {name + version for name, version in packages if name != "python"} == needed
    assert f'python_min: "{PROJECT["requires-python"].removeprefix(">=")}"' in recipe
