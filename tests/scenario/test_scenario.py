"""Scenarios are read from TOML, changed, stored with a run and run again."""

import dataclasses
import json
import math

import numpy as np
import pytest

import latolato as ll
from latolato.core.errors import InputError
from latolato.core.registry import describe
from latolato.paper import systems as paper
from latolato.scenario.scenario import Scenario, load_scenario, overridden, scenarios
from latolato.scenario.tables import run_options

SHIPPED = sorted(scenarios())
RUNS = [name for name, scenario in sorted(scenarios().items()) if not scenario.varied]
SWEEPS = [name for name in SHIPPED if name not in RUNS]
TOY = {"kind": "latolato", "length": 1.0, "mass": 0.8, "radius": 0.1}
PENDULUM = {"kind": "pendulum", "length": 1.0, "mass": 0.8}
RUN = {"initial_angle": 0.5, "duration": 1.0}


def scenario(system=PENDULUM, **tables):
    return Scenario.from_dict({"system": system, "run": RUN, **tables})


def test_an_axis_takes_the_place_of_a_value_of_the_run():
    own = scenario(sweep={"axes": {"initial_angle": [0.1, 0.2]}})
    assert "initial_angle" not in dict(own.plan().start)
    angles = {"initial_angle": [0.1, 0.2]}
    ready = scenario(sweep={"axes": {"mass": [1.0]}, "observables": ["crossings"]})
    assert list(ready.sweep(axes=angles).initial_angle) == [0.1, 0.2]
    with pytest.raises(InputError, match="initial_angle is given as a value and varied"):
        ready.sweep(axes=angles, initial_angle=0.3)


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_scenario_says_what_it_is_and_survives_json(name):
    shipped = load_scenario(name)
    assert shipped.name == name
    assert shipped.title
    assert shipped.description.endswith(".")
    assert Scenario.from_dict(json.loads(json.dumps(shipped.to_dict()))) == shipped


@pytest.mark.parametrize("name", RUNS)
def test_a_shipped_run_asks_one_short_question(name):
    question = load_scenario(name).question
    assert question.endswith("?")
    assert len(question) <= 60


@pytest.mark.parametrize("question", [3, ["Why?"], {"en": "Why?"}])
def test_a_question_that_is_no_text_is_refused(question):
    with pytest.raises(ValueError, match="question must be a text"):
        scenario(question=question)


@pytest.mark.parametrize("name", SWEEPS)
def test_a_shipped_sweep_has_a_plan_and_is_no_single_run(name):
    shipped = load_scenario(name)
    assert shipped.plan().size > 100
    with pytest.raises(ValueError, match=f"{name} is a sweep .*`latolato sweep {name}`"):
        shipped.simulate()


@pytest.mark.parametrize("name", RUNS)
def test_the_scenario_stored_with_a_run_gives_the_same_run(name):
    run = load_scenario(name).simulate(duration=1.0)
    again = Scenario.from_dict(json.loads(run.attrs["scenario"])).simulate()
    np.testing.assert_array_equal(again.angle, run.angle)


@pytest.mark.parametrize(
    "name, system, drive",
    [
        ("fig02", paper.PENDULUM, paper.DRIVE),
        ("fig02_mathieu", paper.LINEAR, paper.DRIVE),
        ("fig04a_push", paper.TOY, paper.STRONG_DRIVE),
        ("fig04b_push", paper.TOY, paper.WEAK_DRIVE),
        ("fig08", paper.SINGLE, None),
        ("fig12", paper.COUPLED, None),
        ("fig03cd", paper.UNDAMPED, None),
        ("fig05", dataclasses.replace(paper.TOY, damping=0.0), None),
        ("fig09", paper.SINGLE, None),
        ("fig11", paper.COUPLED, None),
        ("fig13b", paper.LINEAR_UNDAMPED, paper.DRIVE),
        ("fig13d", paper.UNDAMPED, paper.DRIVE),
    ],
)
def test_scenarios_and_figures_of_the_paper_use_the_same_parameters(name, system, drive):
    shipped = load_scenario(name)
    for part, expected in ((shipped.system, system), (shipped.drive, drive)):
        if expected is not None:
            # 0.08 * 0.245 m and 0.0196 m differ by a rounding
            assert describe(part) == pytest.approx(describe(expected), rel=1e-15)


def test_the_printed_start_of_figure_4_never_moves_and_the_push_reaches_the_top():
    still = load_scenario("fig04a").simulate()
    assert np.ptp(still.angle.values) == 0.0
    pushed = load_scenario("fig04a_push").simulate()
    assert "top" in pushed.contact_kind.values


@pytest.mark.parametrize("name", ["fig12", "fig12_sudden"])
@pytest.mark.parametrize("phase", [0.0, 1.0, 3.0])
def test_the_frequency_step_of_figure_12_catches_on_at_every_phase(name, phase):
    shipped = load_scenario(name)
    drive = dataclasses.replace(shipped.drive, drive_phase=phase)
    run = shipped.simulate(drive=drive, duration=60.0)
    late = run.angle.sel(time=slice(50.0, None))
    assert math.degrees(float(late.max())) == pytest.approx(42.0, abs=0.05)  # as it is written


def test_a_frequency_ratio_counts_natural_frequencies():
    table = {"kind": "harmonic", "drive_amplitude": 0.02, "frequency_ratio": 1.942}
    result = scenario(drive=table)
    assert result.drive.drive_frequency == 1.942 * result.system.natural_frequency


def test_frequency_ratios_of_stages_and_of_a_chirp_count_natural_frequencies():
    stages = {
        "kind": "frequency_schedule",
        "drive_amplitude": 0.02,
        "times": [0, "2 s"],
        "frequency_ratios": [3, 2],
    }
    natural = math.sqrt(9.8)
    assert scenario(drive=stages).drive.drive_frequencies == (3 * natural, 2 * natural)
    chirp = {
        "kind": "chirp",
        "drive_amplitude": 0.02,
        "frequency_ratio": 1,
        "frequency_ratio_final": 2,
        "sweep_time": "1 min",
    }
    assert scenario(drive=chirp).drive.drive_frequency_final == 2 * natural
    assert scenario(drive=chirp).drive.sweep_time == 60.0


def test_two_balls_are_two_tables():
    ball = {"length": "1 m", "mass": "500 g", "radius": "10 cm"}
    result = Scenario.from_dict(
        {
            "system": {"kind": "ballpair", "right": ball, "left": ball},
            "run": {"initial_angle": ["20 deg", "-25 deg"], "duration": 1},
        }
    )
    assert result.system.right == ll.Ball(length=1.0, mass=0.5, radius=0.1)
    assert result.run["initial_angle"] == pytest.approx((math.pi / 9, -math.radians(25)))


STRINGS = """
[system]
kind = "latolato"
length = "18.6 cm"
mass = "30 g"
radius = "12 mm"
suspension = "string"
string_restitution = 0.9
drag_frame = "lab"
[run]
initial_angle = "20 deg"
initial_distance = "150 mm"
duration = 1
"""


def test_a_scenario_file_hangs_balls_on_strings(tmp_path):
    path = tmp_path / "strings.toml"
    path.write_text(STRINGS)
    result = load_scenario(path)
    own = {"length": 0.186, "mass": 0.03, "radius": 0.012}
    assert result.system == ll.LatoLato(
        **own, suspension="string", string_restitution=0.9, drag_frame="lab"
    )
    assert result.run["initial_distance"] == 0.15
    again = json.loads(json.dumps(result.to_dict()))
    assert Scenario.from_dict(again) == result
    assert again["system"]["suspension"] == "string"


def test_the_shipped_toy_on_strings_reaches_the_top_and_with_rods_it_does_not():
    shipped = load_scenario("toy_strings")
    # The toolkit's linear drag of 0.16 1/s; the four digits of the file hold it whole.
    toy = shipped.system
    assert toy.damping / (toy.mass * toy.length) == pytest.approx(0.16, rel=1e-15)
    run = shipped.simulate()
    late = run.contact_kind[run.contact_time > 3.0].values
    assert late.tolist() == ["top", "bottom"] * (len(late) // 2)
    assert float(run.slack.sel(time=slice(0.0, 3.0)).mean()) > 0.9
    rods = dataclasses.replace(toy, suspension="rod", string_restitution=0.0)
    assert set(shipped.simulate(system=rods).contact_kind.values) == {"bottom"}


def test_a_scenario_of_rods_says_nothing_of_strings():
    system = scenario(TOY).to_dict()["system"]
    assert not {"suspension", "string_restitution", "drag_frame"} & system.keys()


def test_two_strings_have_two_distances():
    ball = {"length": "1 m", "mass": "500 g", "radius": "10 cm"}
    pair = {"kind": "ballpair", "right": ball, "left": ball, "suspension": "string"}
    result = scenario(pair, run={**RUN, "initial_distance": "80 cm, 1 m"})
    assert result.run["initial_distance"] == (0.8, 1.0)


def test_noise_and_clamp_are_built_from_their_tables():
    result = scenario(
        TOY,
        noise={"noise_strength": 0.1, "noise_seed": 3},
        run={**RUN, "contact": "clamp", "clamp_step": "2 ms"},
    )
    assert result.run["noise"] == ll.VelocityKicks(noise_strength=0.1, noise_seed=3)
    assert result.run["contact"] == ll.ClampContact(clamp_step=2e-3)
    assert Scenario.from_dict(result.to_dict()) == result


def test_samples_are_evenly_spaced_over_the_duration():
    run = scenario(run={**RUN, "samples": 5}).simulate()
    np.testing.assert_array_equal(run.time, [0.0, 0.25, 0.5, 0.75, 1.0])


def test_data_files_are_looked_for_beside_the_scenario(tmp_path):
    instants = np.linspace(0.0, 1.0, 21)
    table = np.column_stack([instants, 0.01 * np.cos(instants), 0.02 * np.sin(instants)])
    head = "time,height,across"
    np.savetxt(tmp_path / "pivot.csv", table, delimiter=",", header=head, comments="")
    (tmp_path / "mine.toml").write_text(
        "[system]\nkind = 'pendulum'\nlength = 1\nmass = 1\n"
        "[drive]\nkind = 'measured_pivot'\n"
        "times = 'pivot.csv:time'\npivot_heights = 'pivot.csv:height'\n"
        "pivot_across = 'pivot.csv:across'\n"
    )
    drive = load_scenario(tmp_path / "mine.toml").drive
    assert drive.times == tuple(instants)
    assert drive.pivot_across == tuple(table[:, 2])


def test_overrides_take_the_place_of_what_excludes_them():
    pushed = load_scenario("fig04a_push")
    assert float(pushed.simulate(initial_angle=0.7, duration=1.0).angle[0]) == 0.7
    sampled = scenario(run={**RUN, "samples": 5})
    assert float(sampled.simulate(duration=2.0).time[-1]) == 2.0
    assert sampled.simulate(times=[0.0, 3.0]).sizes["time"] == 2


def test_a_changed_kind_keeps_the_parameters_that_it_knows():
    tables = {
        "system": TOY,
        "drive": {"kind": "harmonic", "drive_amplitude": 0.02, "frequency_ratio": 2},
        "run": RUN,
    }
    changes = {
        "system": {"kind": "pendulum"},
        "drive": {"kind": "crank_slider", "connecting_rod_length": 0.2},
    }
    result = Scenario.from_dict(overridden(tables, changes))
    assert result.system == ll.Pendulum(length=1.0, mass=0.8)
    assert result.drive.drive_amplitude == 0.02
    assert result.drive.connecting_rod_length == 0.2


def test_changing_one_ball_keeps_the_other_values_of_both():
    ball = {"length": 1, "mass": 1, "radius": 0.1}
    tables = {"system": {"kind": "ballpair", "right": ball, "left": ball}, "run": RUN}
    changed = overridden(tables, {"system": {"left": {"mass": 2}}})
    assert changed["system"]["left"] == {"length": 1, "mass": 2, "radius": 0.1}
    assert changed["system"]["right"] == ball
    assert tables["system"]["left"]["mass"] == 1


@pytest.mark.parametrize("suffix", [".nc", ".csv", ".parquet"])
def test_a_result_file_is_a_scenario_with_the_same_instants(tmp_path, suffix):
    if suffix == ".parquet":
        pytest.importorskip("pyarrow", reason="Parquet needs the extra 'parquet'")
    run = load_scenario("fig04a_push").simulate(times=[0.0, 0.3, 2.0, 2.5], duration=3.0)
    path = ll.save(run, tmp_path / f"run{suffix}")
    again = load_scenario(path).simulate()
    np.testing.assert_array_equal(again.time, run.time)
    np.testing.assert_array_equal(again.angle, run.angle)
    np.testing.assert_array_equal(again.contact_time, run.contact_time)


@pytest.mark.parametrize(
    "text, message",
    [
        ("[systm]\nkind = 'pendulum'", "unknown entry 'systm': did you mean 'system'?"),
        ("[run]\nduration = 1", "a scenario needs [system] with a kind: pendulum,"),
        ("[system]\nkind = 'pendulm'", "unknown system 'pendulm': did you mean 'pendulum'?"),
        ("[system]\nlength = 1", "[system] needs a kind: pendulum,"),
        ("[system]\nkind = 1", "the kind of system must be a text, got 1"),
        ("system = 3", "system must be a table of names and values, got 3"),
        ("[system", "mine.toml is no TOML file: "),
        ("title = 3\n[system]\nkind = 'pendulum'", "title must be a text, got 3"),
    ],
)
def test_a_broken_file_is_refused_with_its_name_and_the_way_out(tmp_path, text, message):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(InputError) as refused:
        load_scenario(path)
    assert str(refused.value).startswith("mine.toml: ")
    assert message in str(refused.value)


@pytest.mark.parametrize(
    "tables, message",
    [
        (
            {"system": {**PENDULUM, "lenght": 2}},
            "unknown parameter 'lenght' of Pendulum: did you mean 'length'?",
        ),
        ({"system": {"kind": "pendulum", "mass": 1}}, "Pendulum needs 'length' [m]"),
        (
            {"system": {**PENDULUM, "length": "24.5 kg"}},
            "length must be given in m (or a unit that converts to it), got '24.5 kg'",
        ),
        ({"system": {**PENDULUM, "mass": True}}, "mass must be a number in kg, got True"),
        ({"system": {**PENDULUM, "mass": [1]}}, "mass must be a number in kg, got [1]"),
        (
            {"system": {"kind": "ballpair", "length": 1}},
            "BallPair has no 'length' of its own: give right_length and left_length",
        ),
        ({"drive": {"drive_amplitude": 1}}, "[drive] needs a kind: "),
        ({"drive": {"kind": "harmonics"}}, "unknown drive 'harmonics': did you mean 'harmonic'?"),
        (
            {"drive": {"kind": "harmonic", "drive_frequency": 1, "frequency_ratio": 1}},
            "give either drive_frequency or frequency_ratio, got both",
        ),
        (
            {"drive": {"kind": "harmonic", "drive_amplitude": 0.1, "frequency_ratio": -1}},
            "frequency_ratio must lie in [0, inf), got -1",
        ),
        (
            {"drive": {"kind": "frequency_schedule", "frequency_ratios": 2}},
            "frequency_ratios must be a sequence of numbers, got 2",
        ),
        (
            {"drive": {"kind": "harmonic", "frequency_ratios": [1, 2]}},
            "frequency_ratios belongs to drive frequency_schedule or staged_harmonic, not to",
        ),
        (
            {"drive": {"kind": "frequency_schedule", "step_impulse": "yes"}},
            "step_impulse must be true or false, got 'yes'",
        ),
        ({"format": 2}, "the format of a scenario must be at most 1, got 2; use a newer latolato"),
        ({"run": {"durration": 1}}, "unknown entry 'durration' of [run]: did you mean 'duration'?"),
        ({"run": {**RUN, "contact": "clam"}}, "unknown contact law 'clam': did you mean 'clamp'?"),
        (
            {"run": {**RUN, "clamp_step": 1}},
            "clamp_step belongs to contact clamp, not to exact",
        ),
        ({"run": {**RUN, "samples": 1}}, "samples must lie in [2, 2e+07], got 1; give at least 2"),
        ({"run": {"samples": 9}}, "samples needs a duration"),
        ({"run": {"samples": 9, "times": [1]}}, "give either times or samples, got both"),
        ({"noise": {"strenght": 1}}, "unknown parameter 'strenght' of VelocityKicks"),
        ({"noise": 1}, "noise must be a table of names and values, got 1"),
        ({"noise": {"noise_seed": 3}}, "VelocityKicks needs 'noise_strength' [rad/s^(3/2)]"),
        ({"noise": {"noise_strength": "1 m"}}, "noise_strength must be given in rad/s^(3/2)"),
        (
            {"noise": {"noise_strength": 1, "noise_interval": 0}},
            "noise_interval must lie in (0, inf) s, got 0",
        ),
        (
            {"run": {**RUN, "contact": "clamp", "clamp_step": -1}},
            "clamp_step must lie in (0, inf) s, got -1",
        ),
        (
            {"drive": {"kind": "measured_pivot", "times": [0, 1], "pivot_heights": [0, 1]}},
            "drive_times must hold at least 6 values, got 2",
        ),
        ({"drive": {"kind": "measured_pivot"}}, "MeasuredPivot needs 'drive_times' [s]"),
        (
            {"system": {**PENDULUM, "left": {"mass": 1}}},
            "left_mass belongs to system ballpair, not to pendulum; use mass or change the system",
        ),
        (
            {"system": {"kind": "ballpair", "right": {"length": 1, "mass": -1}}},
            "right_mass must lie in (0, inf) kg, got -1",
        ),
        (
            {"system": {**PENDULUM, "suspension": "sting"}},
            "suspension must be 'rod' or 'string', got 'sting'; did you mean 'string'?",
        ),
        (
            {"system": {**PENDULUM, "kind": "mathieu", "suspension": "string"}},
            "suspension belongs to system pendulum or latolato or ballpair, not to mathieu",
        ),
        ({"system": {**PENDULUM, 1: 2}}, "the names in system must be texts, got 1"),
    ],
)
def test_wrong_names_types_and_units_are_refused_with_the_rule(tables, message):
    with pytest.raises(InputError) as refused:
        scenario(**tables).simulate()
    assert message in str(refused.value)


def test_an_unknown_name_is_refused_with_the_closest_one():
    with pytest.raises(
        FileNotFoundError, match="no scenario or file 'fig4a': did you mean 'fig04a'"
    ):
        load_scenario("fig4a")


def test_an_error_in_a_file_names_the_file_and_keeps_its_parts(tmp_path):
    path = tmp_path / "heavy.toml"
    path.write_text('[system]\nkind = "pendulum"\nlength = "-3 m"\nmass = 1\n')
    with pytest.raises(ll.InputError) as refused:
        ll.load_scenario(path)
    error = refused.value
    assert (error.parameter, error.value) == ("length", -3.0)
    assert str(error) == "heavy.toml: length must lie in (0, inf) m, got -3; give more than 0"


@pytest.mark.parametrize("names", ["length", ["length", "damping"]])
def test_a_run_is_differentiated_by_what_its_scenario_names(names):
    system = {"kind": "pendulum", "length": 1, "mass": 1, "damping": 0.1}
    run = {"initial_angle": 0.1, "duration": 0.5, "sensitivity_to": names}
    scenario = Scenario.from_dict({"system": system, "run": run})
    result = scenario.simulate()
    assert result.parameter.values.tolist() == ([names] if isinstance(names, str) else names)
    again = Scenario.from_dict(scenario.to_dict()).simulate()
    np.testing.assert_array_equal(again.angle_sensitivity, result.angle_sensitivity)
    wrong = Scenario.from_dict({"system": system, "run": {**run, "sensitivity_to": 3}})
    with pytest.raises(InputError, match="sensitivity_to has no parameter 3"):
        wrong.simulate()
    # Derivatives belong to one run, as its times do: a sweep leaves them out.
    sweep = {"axes": {"damping": [0.0, 0.1]}, "observables": ["largest_angle"]}
    many = Scenario.from_dict({"system": system, "run": run, "sweep": sweep}).sweep()
    assert set(many.data_vars) == {"largest_angle", "status"}


@pytest.mark.parametrize("contact", ["clamp", "exact", "none"])
def test_a_contact_law_is_refused_where_nothing_meets_and_the_default_is_none(contact):
    system = {"kind": "pendulum", "length": 1, "mass": 1}
    run = {"initial_angle": 0.1, "duration": 0.5, "contact": contact}
    scenario = Scenario.from_dict({"system": system, "run": run})
    if contact == "clamp":
        with pytest.raises(ll.InputError, match="is for balls that meet, and a Pendulum has none"):
            scenario.simulate()
    else:
        assert scenario.simulate().attrs["contact"] == "none"


def test_a_dataset_without_a_scenario_is_refused(tmp_path):
    import xarray as xr

    path = ll.save(xr.Dataset({"a": 1}), tmp_path / "other.nc")
    with pytest.raises(ValueError, match=r"other\.nc holds no run of latolato"):
        load_scenario(path)


def test_every_run_option_is_an_argument_of_simulate_or_turned_into_one():
    import inspect

    known = set(inspect.signature(ll.simulate).parameters)
    assert set(run_options()) - known == {"samples", "clamp_step"}


@pytest.mark.parametrize(
    "system, run, words",
    [
        (TOY, {"clamp_step": 0.001}, {"part": "contact", "owners": "clamp", "kind": "exact"}),
        ({"kind": "pendulum", "mass": 1.0}, {}, {"law": "Pendulum"}),
        ({"kind": "ballpair", "length": 1.0}, {}, {"law": "BallPair"}),
        ({"kind": "latolatto"}, {}, {"kind": "system"}),
    ],
)
def test_pages_translate_the_names_of_laws_in_a_refusal(system, run, words):
    with pytest.raises(InputError) as caught:
        Scenario.from_dict({"system": system, "run": {**RUN, **run}})
    values = caught.value.parts()["rule"]["values"]
    assert {name: values[name] for name in words} == {n: {"word": w} for n, w in words.items()}
