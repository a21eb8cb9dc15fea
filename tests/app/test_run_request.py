"""A request becomes a scenario; one that is too large or unknown is refused before any work."""

import time

import pytest

from latolato.app.run_request import RunRequest, TooLargeError, check_size, options_of
from latolato.scenario.scenario import scenarios

RUNS = [name for name, scenario in scenarios().items() if not scenario.varied]


@pytest.mark.parametrize("name", RUNS)
def test_the_options_of_a_scenario_make_the_scenario_again(name):
    scenario = scenarios()[name]
    again = RunRequest(None, options_of(scenario)).to_scenario()
    assert again.system == scenario.system
    assert again.drive == scenario.drive
    assert again.run == scenario.run


def test_a_text_never_names_a_file(tmp_path):
    path = tmp_path / "times.csv"
    path.write_text("0\n1\n2\n")
    options = {"drive": "frequency_schedule", "drive_times": str(path)}
    with pytest.raises(ValueError, match="drive_times"):
        RunRequest("fig12", options).to_scenario()


@pytest.mark.parametrize("name", ["../pyproject.toml", "/etc/hostname", "fig2"])
def test_only_shipped_scenarios_are_read(name):
    with pytest.raises(ValueError, match="there is no scenario"):
        RunRequest(name, {}).to_scenario()


@pytest.mark.parametrize(
    "options",
    [
        {"duration": "1e9 s"},
        {"samples": "500000"},
        {"duration": "90000 s", "drive_frequency": "1e6 rad/s"},
        {"tolerance": "1e-14", "duration": "1e5 s"},
    ],
)
def test_a_run_that_is_too_large_is_refused_before_any_work(options):
    scenario = RunRequest("fig04b_push", options).to_scenario()
    begun = time.perf_counter()
    with pytest.raises(TooLargeError, match=r"must not exceed|(has|take) at most"):
        check_size(scenario)
    assert time.perf_counter() - begun < 1.0  # no simulation of this size ends so soon


def test_whole_numbers_may_come_as_texts_of_an_address():
    scenario = RunRequest("zeno", {"samples": "11", "contact_limit": " 500 "}).to_scenario()
    assert len(scenario.run["times"]) == 11
    assert scenario.run["contact_limit"] == 500
    with pytest.raises(ValueError, match="samples must be a whole number"):
        RunRequest("zeno", {"samples": "1.5"}).to_scenario()
