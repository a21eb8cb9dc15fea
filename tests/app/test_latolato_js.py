"""The module for JavaScript: its runs and its refusals are those of Python."""

from __future__ import annotations

import warnings

import pytest

from latolato.app.forms import registry
from latolato.core.errors import InputError
from same_runs import check_same, in_python

PENDULUM = {"system": "pendulum", "length": 1, "mass": 1, "initial_angle": 0.1, "duration": 2}
TOY = {
    "system": "latolato", "length": 1, "mass": 1, "radius": 0.1, "restitution": 0.8,
    "initial_angle": 0.5, "duration": 2,
}  # fmt: skip
PAIR = {
    "system": "ballpair", "right_length": 1, "right_mass": 1, "right_radius": 0.1,
    "left_length": 1, "left_mass": 1, "left_radius": 0.1, "initial_angle": [0.5, -0.4],
    "duration": 2,
}  # fmt: skip
HARMONIC = {"drive": "harmonic", "drive_amplitude": 0.1, "drive_frequency": 3}
CRANK = {**HARMONIC, "drive": "crank_slider", "connecting_rod_length": 0.5}
SCHEDULE = {
    "drive": "frequency_schedule", "drive_amplitude": 0.1, "drive_times": [0, 1],
    "drive_frequencies": [3, 4],
}  # fmt: skip
STAGES = {
    "drive": "staged_harmonic", "drive_times": [0, 1], "drive_frequencies": [3, 4],
    "drive_amplitudes": [0.1, 0.2], "ramps": [0.1, 0.1],
}  # fmt: skip
CHIRP = {
    "drive": "chirp", "drive_amplitude": 0.1, "drive_frequency": 1, "drive_frequency_final": 4,
    "sweep_time": 1,
}  # fmt: skip
RATIO = {"drive": "harmonic", "drive_amplitude": 0.1, "frequency_ratio": 2}
STRING = {"suspension": "string", "string_restitution": 0.4}
PLANAR = {
    "drive": "planar_harmonic", "vertical_amplitude": 0.1, "horizontal_amplitude": 0.05,
    "drive_frequency": 8, "horizontal_phase": 1,
}  # fmt: skip
FAST = {"initial_angular_velocity": 5}
LIFTED = {name: value for name, value in TOY.items() if name != "initial_angle"}
UNITS = {
    "length": "24.5 cm", "mass": "3 oz", "initial_angle": "20 deg", "duration": "0.1 min",
    "damping": "2 g*m/s", "drive": "harmonic", "drive_frequency": "1.6 Hz",
    "drive_amplitude": "1.5 in",
}  # fmt: skip


def without(options, *names):
    return {name: value for name, value in options.items() if name not in names}


RUNS = [
    PENDULUM, TOY, PAIR, {**PENDULUM, "system": "mathieu", **HARMONIC}, {**PENDULUM, **HARMONIC},
    {**PENDULUM, **RATIO}, {**PENDULUM, **CHIRP}, {**TOY, **SCHEDULE, "ramp": 0.5},
    {**TOY, **SCHEDULE, "step_impulse": True}, {**TOY, **STAGES, "drive_phase": 1},
    {**TOY, **CRANK, "guide": "above"}, {**PENDULUM, **UNITS}, {**TOY, "contact": "clamp"},
    {**TOY, "contact": "none"}, {**TOY, "frame": "both"}, {**LIFTED, "initial_offset": 0},
    {**TOY, "contact_limit": 1, "duration": 20}, {**PENDULUM, "times": [0, 1, 2]},
    {**PENDULUM, "samples": 11}, {**PENDULUM, "initial_angular_velocity": "1 Hz"},
    {**PAIR, "initial_angle": "20 deg, -15 deg"}, {**PENDULUM, "quadratic_damping": 0.1},
    {**PENDULUM, "coulomb_damping": 0.05}, {**TOY, **SCHEDULE, "duration": 0.7},
    {**PENDULUM, **HARMONIC, "drive_frequency": 40, "tolerance": 1e-2},
    {**PENDULUM, "noise_strength": 0.1, "noise_seed": 3}, {**PAIR, "noise_strength": 0.1},
    {**TOY, "noise_strength": 0.1, "noise_stream": 7, "noise_interval": "20 ms"},
    {**PENDULUM, "gravity": "0.5 g_0"}, {**PENDULUM, "duration": "0.023435 min"},
    {**PENDULUM, "length": "1.1 metres", "duration": "2 seconds"}, {**PENDULUM, "times": 1.5},
    {**PENDULUM, **FAST, **STRING}, {**TOY, **FAST, **STRING, **HARMONIC, "drive_frequency": 9},
    {**PAIR, **STRING, **PLANAR}, {**PENDULUM, **PLANAR, "damping": 0.1, "drag_frame": "lab"},
    {**PENDULUM, **STRING, "initial_distance": "40 cm"}, {**TOY, **STRING, "initial_distance": 0.5},
    {**PAIR, **STRING, "initial_distance": [0.9, 1.0]}, {**TOY, "suspension": "string"},
    {**TOY, "damping": 0.1, "drag_frame": "lab", **HARMONIC, "frame": "both"},
    {**PENDULUM, **PLANAR, "horizontal_amplitude": 0}, {**TOY, **STRING, "contact": "none"},
    {**PENDULUM, **FAST, **STRING, "contact_limit": 1, "duration": 20},
]  # fmt: skip
CHANGED = [
    {"length": 0.3}, {"drive": "crank_slider", "connecting_rod_length": "10 cm"},
    {"system": "pendulum", "duration": 2}, {"drive_amplitude": "2 cm"}, {"contact": "clamp"},
    {"drive": "fixed_pivot"}, {"frequency_ratio": 1.5}, {"initial_offset": 0.1},
]  # fmt: skip
WRONG = [
    {}, *({**PENDULUM, **wrong} for wrong in (
        {"length": -1}, {"length": 0}, {"length": "x"}, {"length": "3 s"}, {"length": 1e-40},
        {"length": "nan"}, {"length": "-inf mm"},
        {"length": 1e40}, {"length": "1 m, 2 m"}, {"mass": True}, {"lenght": 1},
        {"system": "pendlum"}, {"system": []}, {"drive": 3}, {"contact": []}, {"mass": {"a": 1}},
        {"radius": 0.1}, {"initial_angle": "x"}, {"initial_angle": 1e7},
        {"initial_offset": 0.1}, {"duration": 0}, {"duration": -3}, {"duration": 1e12},
        {"tolerance": 1}, {"tolerance": 1e-20}, {"contact": "exakt"}, {"frame": "x"},
        {"times": [1, 1]}, {"times": []}, {"times": [-1, 1]}, {"times": [1, 3]}, {"samples": 1},
        {"samples": 1.5}, {"samples": 10**9}, {"samples": "1000000000"}, {"frame": "a\\b\n\t'\""},
        {"length": [None, 1]}, {"mass": [[1], [2]]}, {"length": "1 gs"},
        {"samples": 3, "times": [0, 1]}, {"rest_speed": -1},
        {"noise_strength": -1}, {"noise_seed": 1}, {"noise_strength": 1, "noise_seed": 0.5},
        {"noise_strength": 1, "noise_seed": -1}, {"contact_limit": 0}, {"contact_limit": 2.5},
        {"damping": "3 m"},
        {"initial_angle": "20 deg, 3"}, {"drive": "harmonik"}, {"contact": "clamp"},
        {**HARMONIC, "drive_amplitude": -1}, {**HARMONIC, "frequency_ratio": 2},
        {**RATIO, "frequency_ratio": -2}, {**RATIO, "frequency_ratio": "x"},
        {**RATIO, "frequency_ratio": [2]},
        without(HARMONIC, "drive_amplitude"), {**HARMONIC, "connecting_rod_length": 1},
        {**SCHEDULE, "frequency_ratio": 2}, {**RATIO, "frequency_ratios": [1, 2]},
        {"frequency_ratio": 2, "drive": "fixed_pivot"},
        {**CRANK, "connecting_rod_length": 0.05}, {**CRANK, "guide": "left"},
        {**CRANK, "guide": "belw"}, {"suspension": "sting"}, {"drag_frame": 1},
        {"suspension": "string", "string_restitution": 2}, {"string_restitution": 0.9},
        {"drag_frame": "lab", "quadratic_damping": 0.1}, {"initial_distance": 0.5},
        {**STRING, "initial_distance": 1.5}, {**STRING, "initial_distance": 0},
        {"system": "mathieu", **PLANAR},
        {**PLANAR, "vertical_amplitude": -1}, {**PLANAR, "drive_phase": 1},
        {"system": "mathieu", "suspension": "rod"},
        without(CRANK, "connecting_rod_length"), {**SCHEDULE, "drive_times": [1, 2]},
        {**SCHEDULE, "drive_times": [0, 0]}, {**SCHEDULE, "drive_times": [0]},
        {**SCHEDULE, "ramp": 2}, {**SCHEDULE, "step_impulse": "maybe"},
        {**SCHEDULE, "drive_frequencies": [3, -4]}, {**SCHEDULE, "drive_frequencies": 5},
        {**SCHEDULE, "drive_frequencies": []}, {**STAGES, "ramps": [0, 0]},
        {**STAGES, "ramps": [0.1]}, {**STAGES, "drive_times": [0, -1]}, {**CHIRP, "sweep_time": 0},
    )),
    *(without(PENDULUM, name) for name in PENDULUM), without(TOY, "radius"),
    *({**TOY, **wrong} for wrong in (
        {"radius": 1}, {"radius": 2}, {"initial_angle": 0.01}, {"initial_angle": 3.1},
        {"initial_offset": 0.1}, {"restitution": 1.5}, {"restitution": -1},
        {"contact": "clamp", "clamp_step": 0}, {"contact": "clamp", "clamp_step": 5},
        {"clamp_step": 0.1}, PLANAR, {"contact": "clamp", "suspension": "string"},
        {"contact": "clamp", "drag_frame": "lab"}, {**STRING, "initial_distance": 0.15},
        {**STRING, "initial_distance": 0.5, "initial_angle": 4},
    )),
    {**LIFTED, "initial_offset": -1}, {**LIFTED, "initial_offset": 4},
    *({**PAIR, **wrong} for wrong in (
        {"right_length": 3}, {"right_radius": 0.99, "left_radius": 0.99}, {"right_radius": 1.5},
        {"right_radius": 0.4, "left_length": 0.95, "left_radius": 0.001},
        {"initial_angle": 0.3}, {"initial_angle": [0.1, 0.1]}, {"contact": "clamp"},
        {"length": 1}, {"left_mass": -1}, {**STRING, "initial_distance": [0.1, 1.1]},
        {**STRING, "initial_distance": 0.5},
        {**STRING, "initial_distance": [0.5, 0.5], "initial_angle": [-1, 1]},
        {**STRING, "initial_distance": [0.5, 0.5], "initial_angle": [0.05, 0]},
        {**STRING, "initial_distance": [0.5, 1.0], "initial_angle": [0.05, 0]},
    )),
    without(PAIR, "right_mass"), without(PAIR, "right_mass", "right_length", "right_radius"),
]  # fmt: skip
PRESETS = list(registry()["scenarios"])


@pytest.fixture(scope="module")
def answers(ask_node):
    """What JavaScript answers to all requests of this file; Node.js is started once."""
    requests = [
        *({"scenario": None, "options": options} for options in RUNS + WRONG),
        *({"scenario": "toy", "options": options} for options in CHANGED),
        *({"scenario": name, "options": {}} for name in [*PRESETS, "nope"]),
        {"scenario": "fig04a_clamp", "options": {"contact": "exact"}},
        {"scenario": "fig12", "options": {"length": 0.3}},
    ]
    pairs = zip(requests, ask_node("latolato_in_node.mjs", requests), strict=True)
    return [(each["scenario"], each["options"], answer) for each, answer in pairs]


def test_runs_and_refusals_are_those_of_python(answers):
    wrong = []
    for name, options, answer in answers:
        try:
            with warnings.catch_warnings(record=True) as caught:
                warnings.simplefilter("always")
                run = in_python(name, options)
        except InputError as error:
            if (answer.get("error"), answer.get("parameter")) != (str(error), error.parameter):
                wrong.append((name, options, str(error), answer.get("error", "it ran")))
            continue
        if "error" in answer:
            wrong.append((name, options, "it ran", answer["error"]))
            continue
        assert answer["warnings"] == [str(each.message) for each in caught], (name, options)
        assert answer["status"] == run.attrs["status"]
        check_same(run, answer, name, options)
    assert not wrong


def test_all_presets_and_cases_are_asked(answers):
    assert len(answers) == len(RUNS + WRONG + CHANGED + PRESETS) + 3
    assert sum("error" in answer for _, _, answer in answers) >= len(WRONG)
