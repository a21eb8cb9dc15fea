"""What the report links to: the runs behind a figure, in the pages that show them."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from latolato import Scenario, scenarios
from latolato.app.forms import description_of
from latolato.core.language import local, spoken, tr
from latolato.core.quantities import QUANTITIES
from latolato.figures.style import pretty_unit
from latolato.paper import catalogue
from latolato.report.addresses import (
    address_of_map,
    address_of_preset,
    address_of_run,
    options_that_matter,
)

if TYPE_CHECKING:
    import xarray as xr

# The pages lie beside the folder of the report.
PAGES = "../"
_NUMBER = re.compile(r"(?P<number>\d+)(?P<panel>[a-z]*)")
# Runs of one figure that the report offers to open, and options in the label of each.
_MOST_RUNS = 120
_MOST_PARTS = 3


@dataclass(frozen=True, kw_only=True)
class Link:
    """A link from the report: its words, its address and what it leads to."""

    text: str
    address: str
    description: str = ""


@lru_cache(maxsize=1)
def _presets_by_figure() -> dict[str, list[str]]:
    """Return the names of shipped scenarios by the figure that they belong to."""
    known = catalogue.figures()
    result: dict[str, list[str]] = {}
    for name, scenario in scenarios().items():
        for part in filter(None, map(_NUMBER.fullmatch, scenario.figure.split(", "))):
            base = f"fig{int(part['number']):02d}"
            own = f"{base}{part['panel']}"
            places = result.setdefault(own if own in known else base, [])
            if name not in places:
                places.append(name)
    return result


def in_language(address: str, code: str) -> str:
    """Return the address at which the pages speak a language, whatever a browser prefers.

    Examples
    --------
    >>> in_language("../", "id"), in_language("../?view=toy", "en")
    ('../?lang=id', '../?view=toy&lang=en')
    """
    return f"{address}{'&' if '?' in address else '?'}lang={code}"


def presets_of(figure: str) -> list[str]:
    """Return the names of the shipped scenarios that belong to a figure.

    Examples
    --------
    >>> presets_of("fig03"), presets_of("fig03cd"), presets_of("fig08_chain")
    (['fig03a', 'fig03b'], ['fig03cd'], ['fig08'])
    """
    return _presets_by_figure().get(figure.removesuffix("_chain"), [])


def links_to_presets(figure: str) -> list[Link]:
    """Return links that open the shipped scenarios of a figure."""
    known = {name: scenarios()[name] for name in presets_of(figure)}
    return [
        Link(
            text=f"{tr('Open in Map' if scenario.varied else 'Open in Toy')}: {tr(scenario.title)}",
            address=PAGES + address_of_preset(name, is_map=bool(scenario.varied)),
            description=tr(description_of(scenario)),
        )
        for name, scenario in known.items()
    ]


def flat_scenarios(dataset: xr.Dataset) -> list[dict[str, Any]]:
    """Return the runs' parameters as flat dictionaries."""
    if "scenario" not in dataset:
        return []
    runs = []
    for text in dataset.scenario.values:
        flat: dict[str, Any] = {}
        for part, entries in json.loads(str(text)).items():
            for name, value in entries.items():
                flat[part if name == "kind" else name] = value
        runs.append(flat)
    return runs


def links_to_runs(dataset: xr.Dataset) -> list[Link]:
    """Return links that open the runs behind a figure, each named by what sets it apart."""
    if "scenario" in dataset.attrs:  # of the one motion that was filmed
        scenario = Scenario.from_dict(json.loads(dataset.attrs["scenario"]))
        address = address_of_run(options_that_matter(scenario))
        return [Link(text=tr("the motion that was filmed"), address=PAGES + address)]
    if "scenario" not in dataset or "case" not in dataset.coords:
        return []
    texts = [str(text) for text in dataset["scenario"].values.ravel()[:_MOST_RUNS]]
    runs = flat_scenarios(dataset)
    names = dict.fromkeys(name for run in runs for name in run)
    differing = [n for n in names if len({json.dumps(run.get(n)) for run in runs}) > 1]
    cases = dataset["case"].values.tolist()
    links = []
    for text, case, run in zip(texts, cases, runs, strict=False):
        scenario = Scenario.from_dict(json.loads(text))
        options = options_that_matter(scenario) | _end_of(scenario, dataset)
        links.append(
            Link(text=_label(case, run, differing), address=PAGES + address_of_run(options))
        )
    return links


def links_to_maps(dataset: xr.Dataset) -> list[Link]:
    """Return links that open the sweeps behind a figure, those that Map can show."""
    if "plan" not in dataset:
        return []
    return [
        Link(text=_words(str(label)), address=PAGES + address)
        for label, text in zip(dataset["sweep"].values, dataset["plan"].values, strict=True)
        if (address := address_of_map(json.loads(str(text))))
    ]


def _end_of(scenario: Scenario, dataset: xr.Dataset) -> dict[str, float]:
    """Return the duration of a run whose scenario lists its instants."""
    if "duration" in scenario.run or "time" not in dataset:
        return {}
    return {"duration": float(dataset["time"].values[-1])}


def _label(case: Any, run: Mapping[str, Any], differing: list[str]) -> str:
    """Return the label of a run, with the first values in which it differs from the others."""
    parts = []
    for name in differing:
        value = run.get(name)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            unit = QUANTITIES[name].unit if name in QUANTITIES else "1"
            unit = "" if unit in ("", "1") else f" {pretty_unit(unit)}"
            parts.append(f"{meaning(name)} {local(f'{value:.6g}')}{unit}")
        elif isinstance(value, str):
            parts.append(f"{meaning(name)} {spoken(value)}")
    words = _words(str(case))
    return f"{words}: {', '.join(parts[:_MOST_PARTS])}" if parts else words


def _words(case: str) -> str:
    """Return what a case is called, by words or names of data: ``rest, strings, e_s = 0``."""
    parts = case.split(", ")
    return local(", ".join(spoken(part) if part.isidentifier() else part for part in parts))


def meaning(name: str) -> str:
    """Return what a parameter means."""
    return tr(QUANTITIES[name].long_name) if name in QUANTITIES else spoken(name)
