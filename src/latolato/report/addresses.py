"""Addresses of the pages that show a run, relative to the page of the site that opens them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields
from inspect import signature
from typing import Any
from urllib.parse import quote, urlencode

from latolato.scenario.options import flat_options, law_options
from latolato.scenario.scenario import Scenario
from latolato.simulation.run import simulate
from latolato.simulation.vary import DERIVED


def address_of_preset(name: str, *, is_map: bool) -> str:
    """Return the query that opens a shipped scenario: a run in Toy, a sweep in Map.

    Examples
    --------
    >>> address_of_preset("fig05", is_map=True)
    '?view=map&scenario=fig05'
    """
    return "?" + urlencode({"view": "map" if is_map else "toy", "scenario": name})


def address_of_run(options: Mapping[str, Any]) -> str:
    """Return the query that opens a run with these options [SI] in Toy.

    Examples
    --------
    >>> address_of_run({"system": "pendulum", "length": 0.245, "initial_angle": [0.1, -0.1]})
    '?view=toy&system=pendulum&length=0.245%20m&initial_angle=0.1%20rad%2C%20-0.1%20rad'
    """
    texts = {name: _text_of(name, value) for name, value in options.items()}
    return "?" + urlencode({"view": "toy", **texts}, quote_via=quote)


def address_of_map(plan: Mapping[str, Any]) -> str | None:
    """Return the query that opens a sweep in Map, None for one that Map cannot show.

    Parameters
    ----------
    plan : mapping
        The tables of the sweep, as `latolato.sweep` writes them into its result.

    Notes
    -----
    Map shows sweeps of two parameters without noise, in the ranges of the sweep, at other points.
    """
    if plan["noise"] or [len(axis["parameters"]) for axis in plan["axes"]] != [1, 1]:
        return None
    contact = dict(plan["contact"])
    run = {**plan["start"], "contact": contact.pop("kind"), **contact}
    scenario = Scenario.from_dict({"system": plan["system"], "drive": plan["drive"], "run": run})
    options = options_that_matter(scenario)
    ranges = {"map.duration": f"{plan['duration']:g}", "map.transient": f"{plan['transient']:g}"}
    for which, axis in zip("yx", plan["axes"], strict=True):
        [name], [values] = axis["parameters"], axis["values"]
        low, high = min(values), max(values)
        ranges[f"map.{which}"] = name
        ranges |= {f"map.{which}low": f"{low:.12g}", f"map.{which}high": f"{high:.12g}"}
        if name in law_options():  # its plan has no value of its own for what varies
            options.pop(DERIVED.get(name, name), None)
            options[name] = 0.5 * (low + high)
    texts = {name: _text_of(name, value) for name, value in options.items()}
    return "?" + urlencode({"view": "map", **texts, **ranges}, quote_via=quote)


def options_that_matter(scenario: Scenario) -> dict[str, Any]:
    """Return the options of a scenario [SI] without those that repeat a default."""
    usual = {name: p.default for name, p in signature(simulate).parameters.items()}
    usual |= {
        f.name: f.default
        for law in (scenario.system, scenario.drive)
        for f in fields(law)
        if f.default is not MISSING
    }
    if not scenario.system.has_contacts:
        usual["contact"] = "none"
    options = flat_options(scenario.to_dict())
    return {n: v for n, v in options.items() if n in ("system", "drive") or usual.get(n, ...) != v}


def _text_of(name: str, value: Any) -> str:
    """Return an option's value as pages read it."""
    unit = law_options()[name].unit
    unit = "" if unit in ("", "1") else f" {unit}"
    if isinstance(value, (list, tuple)):
        return ", ".join(f"{each}{unit}" for each in value)
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value}{unit}" if isinstance(value, (int, float)) else str(value)
