"""High-precision trajectories: every state, work, loss, contact time and velocity they list.

`tests/reference/trajectories.json` holds 30 digits from Taylor series in mpmath; `cases.json`
beside it is made by `make_cases.py` in the same way. Neither shares anything with latolato.
"""

import math

import numpy as np
import pytest

import latolato as ll
from references import CASES, WITH_CONTACTS, bound_of, check, read


@pytest.fixture(scope="module", params=CASES)
def case(request):
    return CASES[request.param]


@pytest.fixture(scope="module", params=[1e-10, 1e-12])
def run(request, case):
    system, drive, start, end = read(case)
    times = [float(state["time"]) for state in case["states"]]
    return ll.simulate(system, drive, **start, times=times, duration=end, tolerance=request.param)


def test_states_energies_and_ledger(case, run):
    bound = bound_of(case)
    for i, state in enumerate(case["states"]):
        now = run.isel(time=i)
        for name, key in (
            ("angle", "angle"),
            ("angular_velocity", "angular_velocity"),
            ("total_energy", "energy"),
        ):
            check(np.atleast_1d(now[name].values), state[key], bound, (name, state["time"]))
        for name in ("drive_work", "damping_loss", "impact_loss"):
            check(now[name].values, state[name], bound, (name, state["time"]))
        assert float(now["capture_loss"]) == 0.0


def test_contacts(case, run):
    listed = case.get("contacts", [])
    assert list(run.contact_kind.values) == [row["kind"] for row in listed]
    for i, row in enumerate(listed):
        check(run.contact_time.values[i], row["time"], WITH_CONTACTS, ("time", i))
        if row["kind"] == "release":
            assert float(run.angular_velocity_after[i]) == 0.0
            continue
        before = np.atleast_1d(run.angular_velocity_before.values.T[i])
        after = np.atleast_1d(run.angular_velocity_after.values.T[i])
        check(before, row["velocity_before"], WITH_CONTACTS, ("before", i))
        check(after, row["velocity_after"], WITH_CONTACTS, ("after", i))


def test_compression(case, run):
    if "compression_time" not in case:
        if "balls" not in case["model"] and case["model"] != "linear pendulum (eq14)":
            assert math.isnan(run.attrs["compression_time"]) or "agree_digits" not in case
        return
    check(run.attrs["compression_time"], case["compression_time"], 1e-8, "compression_time")
    check(
        run.attrs["compression_fraction"],
        case["compression_fraction"],
        1e-8,
        "compression_fraction",
    )


def test_state_at_a_contact_is_the_state_after_it(case):
    listed = [row for row in case.get("contacts", []) if row["kind"] != "release"]
    if not listed:
        return
    system, drive, start, end = read(case)
    first = ll.simulate(system, drive, **start, times=[0.0], duration=end)
    run = ll.simulate(system, drive, **start, times=first.contact_time.values, duration=end)
    np.testing.assert_array_equal(run.angular_velocity, first.angular_velocity_after)


def test_the_copy_of_the_file_is_complete():
    assert {name[:3] for name in CASES if name.startswith("R")} == {
        "R01", "R03", "R06", "R08", "R10", "R13", "R14", "R16"
    }  # fmt: skip
    assert len([name for name in CASES if name.startswith("N")]) >= 14


def test_exact_values_stated_with_the_cases():
    period = CASES["R13_undriven_large"]["exact"]["period"]
    run = ll.simulate(
        ll.Pendulum(length=1.0, mass=0.8),
        initial_angle=2.5,
        times=[float(period), 2.0 * float(period)],
        tolerance=1e-12,
    )
    np.testing.assert_allclose(run.angle, 2.5, rtol=0, atol=1e-9)
    exact = CASES["R14_undriven_bounce"]["exact"]
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1)
    run = ll.simulate(toy, initial_angle=0.6, duration=10.0)
    n = np.arange(1, run.sizes["contact"] + 1)
    np.testing.assert_allclose(run.contact_time, (2 * n - 1) * float(exact["tau"]), rtol=1e-9)
    np.testing.assert_allclose(run.angular_velocity_after, float(exact["v_impact"]), rtol=1e-9)
