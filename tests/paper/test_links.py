"""The links of the report lead to runs that the pages can compute, the runs of the figures."""

import json
from urllib.parse import parse_qs

import pytest

from latolato.app.run_request import RunRequest, check_size
from latolato.core.language import speaking
from latolato.paper.links import links_to_maps, links_to_presets, links_to_runs, presets_of
from latolato.paper.page_words import LANGUAGES
from latolato.report.addresses import address_of_map
from latolato.scenario.scenario import scenarios
from quick_figures import EVIDENCE, quick_data

# Made in a second or two.
QUICK = ("fig01", "fig03", "fig04", "text_decay", "text_model")
PRESETS = sorted({name for figure in EVIDENCE for name in presets_of(figure)})


def read(address):
    """Return what a link tells a page: the view, and the options as texts."""
    folder, _, query = address.partition("?")
    assert folder == "../"  # the pages are beside the folder of the report
    texts = {name: value for name, [value] in parse_qs(query, strict_parsing=True).items()}
    return texts.pop("view"), texts


def test_every_scenario_of_a_figure_has_its_link():
    assert set(PRESETS) == {name for name, scenario in scenarios().items() if scenario.figure}


@pytest.mark.parametrize("figure", [name for name in EVIDENCE if presets_of(name)])
def test_a_preset_opens_as_a_run_or_as_a_map(figure):
    for name, link in zip(presets_of(figure), links_to_presets(figure), strict=True):
        view = "map" if scenarios()[name].varied else "toy"
        assert read(link.address) == (view, {"scenario": name})
        action = "Open in Map" if view == "map" else "Open in Toy"
        assert link.text == f"{action}: {scenarios()[name].title}"


def test_presets_are_described_in_the_language_of_their_links():
    for figure in EVIDENCE:
        english = links_to_presets(figure)
        with speaking(LANGUAGES["id"]):
            indonesian = links_to_presets(figure)
        for one, other in zip(english, indonesian, strict=True):
            assert one.address == other.address
            assert other.description != one.description


@pytest.mark.parametrize("name", PRESETS)
def test_every_preset_of_a_figure_can_be_computed(name):
    scenario = RunRequest(name, {}).to_scenario()
    if scenario.varied:
        assert scenario.plan().size > 0
    else:
        check_size(scenario)
        run = RunRequest(name, {"duration": "0.5 s"}).to_scenario().record()
        assert run.attrs["status"] == "complete"


@pytest.mark.parametrize("name", QUICK)
def test_every_run_behind_a_figure_opens_as_it_was_computed(name):
    dataset = quick_data(name)
    links = links_to_runs(dataset)
    assert len({link.text for link in links}) == len(links)
    if not links:
        assert "scenario" not in dataset
        return
    for link, text in zip(links, dataset["scenario"].values, strict=True):
        wanted = json.loads(str(text))
        view, options = read(link.address)
        found = RunRequest(None, options).to_scenario()
        assert view == "toy"
        assert found.to_dict()["system"] == wanted["system"]
        assert found.to_dict()["drive"] == wanted["drive"]
        assert "gravity" not in options  # what is usual would only lengthen addresses
        check_size(found)
    run = RunRequest(None, {**options, "duration": "0.5 s"}).to_scenario().record()
    assert run.attrs["status"] == "complete"


def test_the_motion_that_was_filmed_has_its_link():
    [link] = links_to_runs(quick_data("fig07"))
    view, options = read(link.address)
    assert view == "toy"
    scenario = RunRequest(None, options).to_scenario()
    wanted = float(quick_data("fig07")["damping_rendered"])
    assert scenario.system.damping == wanted
    assert scenario.run["duration"] == 16.0  # of a quick video


def test_every_sweep_behind_a_figure_opens_with_its_system_and_ranges():
    dataset = quick_data("fig03cd")
    links = links_to_maps(dataset)
    assert [link.text for link in links] == list(dataset["sweep"].values)
    for link, text in zip(links, dataset["plan"].values, strict=True):
        plan = json.loads(str(text))
        view, texts = read(link.address)
        assert view == "map"
        for which, axis in zip("yx", plan["axes"], strict=True):
            [values] = axis["values"]
            assert texts.pop(f"map.{which}") == axis["name"]
            assert float(texts.pop(f"map.{which}low")) == pytest.approx(values[0], rel=1e-9)
            assert float(texts.pop(f"map.{which}high")) == pytest.approx(values[-1], rel=1e-9)
        assert float(texts.pop("map.duration")) == plan["duration"]
        assert float(texts.pop("map.transient")) == plan["transient"]
        assert RunRequest(None, texts).to_scenario().to_dict()["system"] == plan["system"]


def test_a_sweep_that_map_cannot_show_has_no_link():
    plan = json.loads(str(quick_data("fig03cd")["plan"].values[0]))
    assert address_of_map({**plan, "axes": plan["axes"][:1]}) is None
    assert address_of_map({**plan, "noise": {"kind": "velocity_kicks"}}) is None
