"""Runs of the program for pages, and what pages say and write of runs: it is what Python says."""

from __future__ import annotations

import shlex
import tomllib

import numpy as np
import pytest

import latolato as ll
from latolato.app.run_request import RunRequest, options_of
from latolato.app.runs import balls_of, compute, strobes_of
from latolato.numerics import records
from latolato.numerics.run_record import as_objects
from latolato.physics.drives import Chirp, FixedPivot, FrequencySchedule, Harmonic
from latolato.scenario.scenario import Scenario, scenarios
from latolato.simulation.start import checked_contact
from page_blocks import unpack

RUNS = [name for name, scenario in scenarios().items() if not scenario.varied]
SHORT = {"duration": "5 s"}
STRINGS = {
    "duration": "2.5 s", "suspension": "string", "string_restitution": "0.3",
    "initial_angular_velocity": "5 rad/s",
}  # fmt: skip
PLANAR = {"drive": "planar_harmonic", "vertical_amplitude": "5 cm", "horizontal_amplitude": "2 cm"}
# Scenarios and what is changed of them; the first ones as they are.
REQUESTS = {name: (name, SHORT) for name in RUNS} | {
    "strings": ("fig04a_push", STRINGS),
    "two strings": (
        "ballpair_asymmetric",
        {
            **STRINGS,
            **PLANAR,
            "drive_frequency": "2 Hz",
            "initial_angular_velocity": "5 rad/s, 0 rad/s",
        },
    ),
    "lab": ("fig04a_push", {**SHORT, "drag_frame": "lab", "damping": "20 g*m/s"}),
}


@pytest.fixture(scope="module")
def of_pages(ask_node):
    """What pages say of every scenario, and write of it; Node.js is started once."""
    requests = [{"scenario": name, "options": options} for name, options in REQUESTS.values()]
    return dict(zip(REQUESTS, ask_node("runs_in_node.mjs", requests), strict=True))


@pytest.mark.parametrize("name", REQUESTS)
def test_pages_and_python_say_the_same_of_a_run(of_pages, name):
    scenario, said = RunRequest(*REQUESTS[name]).to_scenario(), of_pages[name]
    assert said["balls"] == balls_of(scenario)
    wanted = options_of(scenario)
    assert {key: said["options"][key] for key in wanted} == wanted
    strobes = strobes_of(scenario.drive, scenario.run["duration"])
    np.testing.assert_allclose(said["strobe"], strobes, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", REQUESTS)
def test_the_python_lines_of_a_page_make_the_same_run(of_pages, name):
    names: dict = {}
    exec(of_pages[name]["python"], names)
    run = RunRequest(*REQUESTS[name]).to_scenario().record()
    last = names["run"]["angle"].values[..., -1]
    np.testing.assert_allclose(last, run["angle"][..., -1], rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", REQUESTS)
def test_the_command_of_a_page_asks_for_the_same_run(of_pages, name):
    words = shlex.split(of_pages[name]["command"])[2:]
    given = {w[2:].replace("-", "_"): v for w, v in zip(words[::2], words[1::2], strict=True)}
    assert_same(RunRequest(None, given).to_scenario(), RunRequest(*REQUESTS[name]).to_scenario())


@pytest.mark.parametrize("name", REQUESTS)
def test_the_toml_file_of_a_page_is_the_same_scenario(of_pages, name):
    again = Scenario.from_dict(tomllib.loads(of_pages[name]["toml"]))
    assert_same(again, RunRequest(*REQUESTS[name]).to_scenario())


def assert_same(*pair):
    """Compare laws and runs; what is usual may be given or not."""
    one, other = (
        {
            "initial_angular_velocity": 0.0,
            **each.run,
            "contact": checked_contact(each.run.get("contact", "exact"), each.system),
            "laws": (each.system, each.drive),
        }
        for each in pair
    )
    assert one == other


@pytest.mark.parametrize(
    "name", ["fig04a_push", "ballpair_asymmetric", "fig02", "strings", "two strings"]
)
def test_the_csv_files_of_a_page_hold_the_run(of_pages, name, tmp_path):
    for kind in ("csv", "contacts"):
        ending = {"csv": "csv", "contacts": "contacts.csv"}[kind]
        (tmp_path / f"run.{ending}").write_text(of_pages[name][kind])
    found = ll.load(tmp_path / "run.csv")
    run = RunRequest(*REQUESTS[name]).to_scenario().simulate()
    assert set(found.variables) == set(run.variables)
    for variable in ("time", "angle", "total_energy", "contact_time"):
        np.testing.assert_allclose(found[variable], run[variable], rtol=0, atol=1e-10)
    assert list(found["contact_kind"].values) == list(run["contact_kind"].values)
    if "distance" in run:
        for variable in ("distance", "slack", "radial_velocity_after", "retension_loss"):
            np.testing.assert_allclose(found[variable], run[variable], rtol=0, atol=1e-9)
        assert found.attrs["slack_fraction"] == pytest.approx(run.attrs["slack_fraction"])


def test_a_block_of_the_program_holds_what_is_known_of_strings():
    run = RunRequest("fig04a_push", STRINGS).to_scenario().simulate()
    about, arrays = unpack(compute(RunRequest("fig04a_push", STRINGS)))
    for name in ("distance", "radial_velocity", "slack", "radial_velocity_before"):
        np.testing.assert_array_equal(arrays[name][0], run[name])
    assert {"slack", "taut"} <= {about["contact_kinds"][kind] for kind in arrays["contact_kind"]}
    assert about["ledger"]["retension_loss"] > 0.0


def test_the_ledger_of_a_run_that_stops_early_is_that_of_its_last_sample():
    limit = {"contact_limit": "10"}
    with pytest.warns(RuntimeWarning, match="contact_limit"):
        run = RunRequest("toy", limit).to_scenario().simulate()
    about, _ = unpack(compute(RunRequest("toy", limit)))
    assert np.isnan(run.drive_work.values[-1])
    assert about["ledger"]["drive_work"] == run.drive_work.dropna("time").values[-1]


def test_a_block_of_the_program_holds_what_the_run_holds():
    request = RunRequest("fig04a_push", {"duration": "3 s"})
    run = request.to_scenario().simulate(times=np.linspace(0.0, 3.0, 200))
    about, arrays = unpack(compute(request, 200))
    for name in ("time", "contact_time"):
        np.testing.assert_array_equal(arrays[name], run[name])
    for name in ("angle", "tension", "drive_work"):
        np.testing.assert_array_equal(arrays[name][0], run[name])
    kinds = [about["contact_kinds"][kind] for kind in arrays["contact_kind"]]
    assert kinds == list(run["contact_kind"].values)
    assert about["balls"][1] == {**about["balls"][0], "name": "left", "sign": -1}
    assert about["attributes"]["status"] == "complete"


def height_of(drive, t):
    """Return the height of the pivot by the drive's own formula [m]."""
    found = records.segment_records(drive, 10.0)
    segment = as_objects(found)[np.searchsorted(found["start"], t, side="right") - 1]
    return drive.height(t, segment)


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
