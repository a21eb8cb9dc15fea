"""What a page asks for becomes a scenario; what is too large or unknown is refused before work."""

import time

import numpy as np
import pytest

from latolato.app.blocks import unpack
from latolato.app.forms import registry
from latolato.app.given import RunRequest, TooLargeError, check_size, options_of
from latolato.app.lines import command_line, python_line
from latolato.app.runs import run_block, simulate_request, strobes_of
from latolato.numerics import records
from latolato.numerics.engine.record import as_objects
from latolato.physics.drives import Chirp, FixedPivot, FrequencySchedule, Harmonic
from latolato.scenario.scenario import scenarios

RUNS = [name for name, scenario in scenarios().items() if not scenario.varied]


@pytest.mark.parametrize("name", RUNS)
def test_the_options_of_a_scenario_make_the_scenario_again(name):
    scenario = scenarios()[name]
    again = RunRequest(None, options_of(scenario)).to_scenario()
    assert again.system == scenario.system
    assert again.drive == scenario.drive
    assert again.run == scenario.run


@pytest.mark.parametrize("name", RUNS)
def test_the_python_lines_on_show_make_the_same_run(name):
    short = RunRequest(name, {"duration": "0.5 s"})
    scenario, run = simulate_request(short)
    names: dict = {}
    exec(python_line(scenario), names)
    last = names["run"]["angle"].values[..., -1]
    np.testing.assert_allclose(last, run["angle"][..., -1], rtol=0, atol=1e-12)


def test_the_command_on_show_asks_for_the_same_run():
    import shlex

    scenario = RunRequest("fig12", {}).to_scenario()
    words = shlex.split(command_line(scenario))[2:]
    given = {w[2:].replace("-", "_"): v for w, v in zip(words[::2], words[1::2], strict=True)}
    again = RunRequest(None, given).to_scenario()
    assert (again.system, again.drive, again.run) == (scenario.system, scenario.drive, scenario.run)


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
        {"duration": "90000 s", "drive_frequency": "1e6 rad/s"},
        {"tolerance": "1e-14", "duration": "1e5 s"},
    ],
)
def test_a_run_that_is_too_large_is_refused_before_any_work(options):
    scenario = RunRequest("fig04b_push", options).to_scenario()
    begun = time.perf_counter()
    with pytest.raises(TooLargeError, match=r"must not exceed|the limit is"):
        check_size(scenario)
    assert time.perf_counter() - begun < 1.0  # no simulation of this size ends so soon


def test_a_block_holds_what_the_run_holds():
    _, run = simulate_request(RunRequest("fig04a_push", {"duration": "3 s"}), 400)
    about, arrays = unpack(run_block(RunRequest("fig04a_push", {"duration": "3 s"}), samples=400))
    np.testing.assert_array_equal(arrays["time"], run["time"])
    np.testing.assert_array_equal(arrays["angle"][0], run["angle"].astype(np.float32))
    np.testing.assert_array_equal(arrays["contact_time"], run["contact_time"])
    assert about["balls"][1] == {**about["balls"][0], "name": "left", "sign": -1}
    assert about["summary"]["status"] == "complete"


def test_the_registry_names_units_and_ranges_of_every_number():
    found = registry()
    numbers = [o for o in found["options"].values() if o["unit"] not in ("", "1")]
    assert numbers
    for option in numbers:
        assert option["units"], option
        assert any(unit["size"] == 1.0 for unit in option["units"]), option
    for law in [*found["systems"].values(), *found["drives"].values()]:
        for name in law["options"]:
            option = found["options"][name]
            has_start = option["default"] is not None or option["usual"] is not None
            assert has_start or name == "pivot_heights", f"a form cannot begin with {name}"


def height_of(drive, t):
    """Return the height of the pivot by the drive's own formula [m]."""
    found = records.stretch_records(drive, 10.0)
    stretch = as_objects(found)[np.searchsorted(found["start"], t, side="right") - 1]
    return drive.height(t, stretch)


def test_an_option_is_described_by_its_own_parameter_and_no_namesake():
    options = registry()["options"]
    # A quantity of the tracker and a field of some drives bear the same names.
    assert (options["frame"]["label"], options["frame"]["unit"]) == ("frame", "")
    assert options["drive_times"]["several"]
    assert options["drive_times"]["description"] == "stage starts"
    assert options["noise_seed"]["default"] == 0
    assert options["noise_seed"]["high"] == 2**63


def test_a_strobe_stands_wherever_the_drive_begins_a_period():
    schedule = FrequencySchedule(
        drive_amplitude=0.01, times=(0.0, 3.0), drive_frequencies=(5.0, 8.0), ramp=1.0
    )
    chirp = Chirp(
        drive_amplitude=0.01, drive_frequency=9.0, drive_frequency_final=2.0, sweep_time=6.0
    )
    harmonic = Harmonic(drive_amplitude=0.01, drive_frequency=7.0, drive_phase=0.4)
    for drive in (schedule, chirp, harmonic):
        strobes = strobes_of(drive, 10.0)
        heights = [height_of(drive, t) for t in strobes]
        np.testing.assert_allclose(heights, 0.01, rtol=0, atol=1e-12)
        tops = np.array([height_of(drive, t) for t in np.linspace(0.0, 10.0, 20_001)])
        peaks = np.count_nonzero((tops[1:-1] > tops[:-2]) & (tops[1:-1] >= tops[2:]))
        assert peaks + (tops[0] > 0.01 - 1e-12) == len(strobes)


def test_a_drive_without_periods_has_no_strobes():
    assert strobes_of(FixedPivot(), 10.0).size == 0


def test_whole_numbers_may_come_as_texts_of_an_address():
    scenario = RunRequest("zeno", {"samples": "11", "contact_limit": " 500 "}).to_scenario()
    assert len(scenario.run["times"]) == 11
    assert scenario.run["contact_limit"] == 500
    with pytest.raises(ValueError, match="samples must be a whole number"):
        RunRequest("zeno", {"samples": "1.5"}).to_scenario()
