"""Each problem of the table is refused in the same words by a run, a sweep and the pages."""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import pytest

import latolato as ll
from latolato.app.run_request import RunRequest
from latolato.physics.problems import PROBLEMS
from map_in_node import views_in_node
from same_runs import in_python

TOY = {
    "system": "latolato", "length": 1, "mass": 1, "radius": 0.1, "initial_angle": 0.5,
    "duration": 2,
}  # fmt: skip
LIFTED = {name: value for name, value in TOY.items() if name != "initial_angle"}
PAIR = {
    "system": "ballpair", "right_length": 1, "right_mass": 1, "right_radius": 0.1,
    "left_length": 1, "left_mass": 1, "left_radius": 0.1, "initial_angle": [0.5, -0.5],
    "duration": 2,
}  # fmt: skip
STRING = {"suspension": "string"}
HALF = {**PAIR, **STRING, "initial_distance": [0.5, 0.5]}
# The radii are the largest numbers below the lengths.
HUGE = {
    "right_length": 1.97, "right_radius": 1.9699999999999998, "left_length": 1.87,
    "left_radius": 1.8699999999999999,
}  # fmt: skip


class Case(NamedTuple):
    """Good options and what is changed of them; along an axis of a sweep if that has other names.

    Some problems are known to sweeps and maps only.
    """

    options: dict[str, Any]
    change: dict[str, Any]
    axis: dict[str, float] | None = None
    settings: Mapping[str, Any] = MappingProxyType({})
    maps_only: bool = False


CASES = {
    "never meet": Case(PAIR, {"left_length": 0.5}),
    "too large": Case(PAIR, HUGE),
    "left rod hits": Case(PAIR, {"right_radius": 0.4, "left_length": 1.05, "left_radius": 0.001}),
    "right rod hits": Case(PAIR, {"left_radius": 0.4, "right_length": 1.05, "right_radius": 0.001}),
    "radius": Case(TOY, {"radius": 1.5}),
    "right radius": Case(PAIR, {"right_radius": 1.5}),
    "left radius": Case(PAIR, {"left_radius": 1.5}),
    "angle": Case(TOY, {"initial_angle": 0.05}),
    "angle in degrees": Case(TOY, {"initial_angle": 30}),
    "separation": Case(PAIR, {"initial_angle": [-0.45, -0.5]}, {"initial_angle_right": -0.45}),
    "separation in degrees": Case(
        PAIR, {"initial_angle": [30, -0.5]}, {"initial_angle_right": 30}
    ),
    "offset": Case({**LIFTED, "initial_offset": 0.1}, {"initial_offset": 3}),
    "offset in degrees": Case({**LIFTED, "initial_offset": 0.1}, {"initial_offset": 30}),
    "half turn": Case({**TOY, **STRING, "initial_distance": 0.5}, {"initial_angle": 4}),
    "turn": Case(HALF, {"initial_angle": [-1, -0.5]}, {"initial_angle_right": -1}),
    "overlap": Case({**TOY, **STRING}, {"initial_distance": 0.15}),
    "string hits": Case(
        {**HALF, "initial_angle": [0.05, 0], "initial_distance": [0.5, 0.1]},
        {"initial_distance": [0.5, 1.0]}, {"initial_distance_left": 1.0},
    ),
    "distance": Case({**TOY, **STRING}, {"initial_distance": 1.5}),
    "right distance": Case(HALF, {"initial_distance": [1.5, 0.5]}, {"initial_distance_right": 1.5}),
    "left distance": Case(HALF, {"initial_distance": [0.5, 1.5]}, {"initial_distance_left": 1.5}),
    "not mirrored": Case(
        PAIR, {"initial_angle": [0.5, -0.4]}, {"initial_angle_left": -0.4},
        {"observables": ["transverse_exponent"]}, maps_only=True,
    ),
    "too many steps": Case({**TOY, "samples": 3, "duration": 1e12}, {"length": 0.5}),
    "transient": Case(TOY, {"length": 0.5}, settings={"transient_periods": 9}, maps_only=True),
}  # fmt: skip
# What no input of a user leads to: nothing, and numbers beyond all ranges.
INSIDE = {"fine", "out of range"}


def page_request(case: Case) -> dict[str, Any]:
    """The question of this case, as the view Map puts it."""
    options = case.options | case.change
    duration = options["duration"]
    observable = (case.settings.get("observables") or ["largest_angle"])[0]
    # A page has no periods of a transient.
    transient = {"transient": 3.0} if "transient_periods" in case.settings else {}
    about = {"options": options, "duration": duration, "observable": observable}
    return {"request": about | transient}


@pytest.fixture(scope="module")
def runs(ask_node):
    """Refusals by the pages' model, one for each run."""
    requests = [{"scenario": None, "options": c.options | c.change} for c in CASES.values()]
    return dict(zip(CASES, ask_node("latolato_in_node.mjs", requests), strict=True))


@pytest.fixture(scope="module")
def maps():
    """Refusals by the view Map, one for each case."""
    answers = views_in_node([page_request(case) for case in CASES.values()])
    return dict(zip(CASES, answers, strict=True))


def text_of_sweep(case: Case) -> str:
    """The refusal of the only point of a sweep."""
    scenario = RunRequest(None, case.options).to_scenario()
    run = {name: value for name, value in scenario.run.items() if name != "times"}
    axis = case.axis or case.change
    axes = {"case": {name: [value] for name, value in axis.items()}}
    settings = {"observables": ["largest_angle"], "duration": case.options["duration"]}
    replaced = {"initial_offset", "initial_angle", "initial_distance"} & axis.keys()
    run = {name: value for name, value in run.items() if name not in replaced}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        result = ll.sweep(
            scenario.system, scenario.drive, axes=axes, executor="reference",
            **(run | settings | dict(case.settings) | {"tolerance": 1e-10}),
        )  # fmt: skip
    return str(result.attrs["first_invalid"])


def is_of(name: str, text: str) -> bool:
    """Return whether a text is that of a problem."""
    (problem,) = (each for each in PROBLEMS if each.name == name)
    # Python calls parameters by their names.
    rule, way_out = (
        re.sub(r"\\{\w+:[^}]*\}", ".+", re.sub(r"\\{@(\w+)\\}", r"\1", re.escape(each)))
        for each in (problem.rule, problem.way_out)
    )
    called = re.escape(str(problem.parameter))
    rule = rule.replace(re.escape("{parameter}"), called)
    got = ", got .+" if problem.value else ""
    whole = rf"(?:{called} )?{rule}{got}" + (f"; {way_out}" if way_out else "")
    return re.fullmatch(whole, text) is not None


def test_every_problem_has_a_case():
    assert {problem.name for problem in PROBLEMS} == CASES.keys() | INSIDE


@pytest.mark.parametrize("name", CASES)
def test_a_problem_has_the_same_words_everywhere(name, runs, maps):
    case = CASES[name]
    said = text_of_sweep(case)
    assert is_of(name, said)
    texts = [maps[name]["error"]]
    if not case.maps_only:
        texts.append(runs[name]["error"])
        with pytest.raises(ll.InputError) as refused:
            in_python(None, case.options | case.change)
        texts.append(str(refused.value))
        assert runs[name]["parameter"] == refused.value.parameter
    # Pages have another limit and tolerance of maps, and ask for a transient in seconds.
    varying = {
        "too many steps": r"(\d\S* \S )?1?[\d.e+⁰¹²³⁴⁵⁶⁷⁸⁹-]+(?= steps| s,|;)",
        "transient": r"got .*",
    }
    for text in texts:
        assert is_of(name, text)
        assert re.sub(varying.get(name, "$^"), "", text) == re.sub(
            varying.get(name, "$^"), "", said
        )
