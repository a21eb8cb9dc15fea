"""High-precision trajectories: every state, work, loss, contact time and velocity they list.

`reference/trajectories.json` holds 30 digits from Taylor series in mpmath; `reference/cases.json`
is made by `reference/make_cases.py` in the same way. Neither shares anything with latolato.
"""

import json
import math
from pathlib import Path

import numpy as np
import pytest

import latolato as ll

FOLDER = Path(__file__).parent / "reference"
CASES = {
    name: case
    for file in ("trajectories.json", "cases.json")
    for name, case in json.loads((FOLDER / file).read_text()).items()
    if not name.startswith("_")
}
# Stated in trajectories.json: relative to max(|reference|, 1e-3).
WITHOUT_CONTACTS, WITH_CONTACTS = 1e-9, 1e-8
KINDS = {
    "harmonic": (ll.Harmonic, ("drive_amplitude", "drive_frequency", "drive_phase")),
    "crank_slider": (
        ll.CrankSlider,
        ("drive_amplitude", "drive_frequency", "drive_phase", "connecting_rod_length", "guide"),
    ),
    "frequency_schedule": (
        ll.FrequencySchedule,
        ("drive_amplitude", "drive_phase", "times", "drive_frequencies", "ramp"),
    ),
    "chirp": (
        ll.Chirp,
        (
            "drive_amplitude",
            "drive_phase",
            "drive_frequency",
            "drive_frequency_final",
            "sweep_time",
        ),
    ),
}
BODY = ("length", "mass", "damping", "quadratic_damping", "coulomb_damping")


def number(value):
    if isinstance(value, list):
        return [number(v) for v in value]
    try:
        return float(value)
    except ValueError:
        return value


def read(case):
    """The system, drive, start and end that a case describes."""
    p = {name: number(v) for name, v in case["parameters"].items() if not isinstance(v, dict)}
    kind, names = KINDS[p.get("drive", "harmonic")]
    drive = kind(**{name: p[name] for name in names})
    if "ball1" in case["parameters"]:
        balls = [
            {k: number(v) for k, v in case["parameters"][ball].items()}
            for ball in ("ball1", "ball2")
        ]
        if "radius" not in balls[0]:  # equal balls: the separation says it
            for ball in balls:
                ball["radius"] = ball["length"] * math.sin(0.5 * p["contact_separation"])
        made = [
            ll.Ball(**{k: v for k, v in ball.items() if k in (*BODY, "radius")}) for ball in balls
        ]
        system = ll.BallPair(
            right=made[0], left=made[1], restitution=p["restitution"], gravity=p["gravity"]
        )
        start = {
            name: tuple(ball[name] for ball in balls)
            for name in ("initial_angle", "initial_angular_velocity")
        }
        return system, drive, start, p["duration"]
    own = {name: p[name] for name in (*BODY, "gravity") if name in p}
    if "contact_angle_low" in p:
        own["radius"] = own["length"] * math.sin(p["contact_angle_low"])
    elif "radius" in p:
        own["radius"] = p["radius"]
    if "radius" in own:
        system = ll.LatoLato(**own, restitution=p["restitution"])
    else:
        system = (ll.Mathieu if "eq14" in case["model"] else ll.Pendulum)(**own)
    angle = p["initial_angle"]
    if isinstance(angle, str) or angle == p.get("contact_angle_low"):
        angle = system.contact_angle_low
    start = {"initial_angle": angle, "initial_angular_velocity": p["initial_angular_velocity"]}
    return system, drive, start, p["duration"]


def check(found, reference, bound, what):
    reference = np.array(number(reference), dtype=float)
    scale = np.maximum(np.abs(reference), 1e-3)
    error = np.abs(np.asarray(found, dtype=float) - reference) / scale
    assert np.max(error, initial=0.0) <= bound, (what, found, reference, error)


@pytest.fixture(scope="module", params=CASES)
def case(request):
    return CASES[request.param]


@pytest.fixture(scope="module", params=[1e-10, 1e-12])
def run(request, case):
    system, drive, start, end = read(case)
    times = [float(state["time"]) for state in case["states"]]
    return ll.simulate(system, drive, **start, times=times, duration=end, tolerance=request.param)


def bound_of(case):
    return WITH_CONTACTS if case.get("contacts") else WITHOUT_CONTACTS


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


def test_slack(case, run):
    if "slack_time" not in case:
        if "balls" not in case["model"] and case["model"] != "linear pendulum (eq14)":
            assert math.isnan(run.attrs["slack_time"]) or "agree_digits" not in case
        return
    check(run.attrs["slack_time"], case["slack_time"], 1e-8, "slack_time")
    check(run.attrs["slack_fraction"], case["slack_fraction"], 1e-8, "slack_fraction")


def test_state_at_a_contact_is_the_state_after_it(case):
    listed = [row for row in case.get("contacts", []) if row["kind"] != "release"]
    if not listed:
        return
    system, drive, start, end = read(case)
    first = ll.simulate(system, drive, **start, times=[0.0], duration=end)
    run = ll.simulate(system, drive, **start, times=first.contact_time.values, duration=end)
    np.testing.assert_array_equal(run.angular_velocity, first.angular_velocity_after)


def test_copy_of_the_given_file_is_complete():
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
