"""Maps of the page are the sweeps of the library, and say what is wrong as it does."""

from __future__ import annotations

import dataclasses
import json
import shlex
import warnings

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import latolato as ll
from latolato.app.map import stored
from latolato.app.map.files import scenario_of
from latolato.cli.main import app as command
from latolato.sweeps.points import make_batch
from latolato.sweeps.statuses import codes_of
from map_in_node import views_in_node

SHORT = {"duration": 12.0, "transient": 6.0}
SWEEPS = {
    name: {"scenario": name, **SHORT} for name in ll.scenarios() if ll.scenarios()[name].varied
}
CHIRP = {
    "drive": "chirp", "drive_amplitude": 0.05, "drive_frequency": 4.0,
    "drive_frequency_final": 7.0, "sweep_time": 5.0,
}  # fmt: skip
STAGES = {
    "drive": "staged_harmonic", "drive_times": [0.0, 0.5], "drive_frequencies": [15.0, 12.0],
    "drive_amplitudes": [0.02, 0.03], "ramps": [0.1, 0.1], "drive_phase": 0.5,
}  # fmt: skip
STRINGS = {"suspension": "string", "string_restitution": 0.5}
PLANAR = {
    "drive": "planar_harmonic", "vertical_amplitude": 0.02, "horizontal_amplitude": 0.0,
    "drive_frequency": 12.0,
}  # fmt: skip


def over(scenario, x, y, duration=3.0, **more):
    """Return the request for a map over two parameters, each a name or a name with both ends."""
    axes = {}
    for which, axis in (("x", x), ("y", y)):
        name, *ends = [axis] if isinstance(axis, str) else axis
        axes[which] = {"name": name, **dict(zip(("low", "high"), ends, strict=False))}
    return {"scenario": scenario, **axes, "duration": duration, **more}


# Axes of every kind, laws of every kind, with points that make no sense among them.
KINDS = {
    "walls": over("fig05_push", "restitution", "radius", 5.0),
    "offset": over("fig05_push", "initial_offset", "frequency_ratio", 5.0),
    "phase": over(
        "fig05_push", "frequency_ratio", "drive_amplitude", 5.0, options={"drive_phase": 0.5}
    ),
    "start": over("fig02", "initial_angle", "initial_angular_velocity", 5.0),
    "two balls": over("ballpair_asymmetric", "right_mass", ("initial_angle_left", -0.3, 0.1)),
    "kicks of two": over(
        "ballpair_asymmetric", "restitution", ("noise_interval", 0.01, 0.05),
        options={"noise_strength": 0.02},
    ),
    "ratios": over("fig09", "drive_frequency", "amplitude_ratio", 5.0, transient=0.0),
    "clamp": over(
        "toy", "frequency_ratio", ("drive_acceleration_ratio", 0.1, 2.0),
        options={"contact": "clamp"},
    ),
    "start and rod": over("fig05_push", ("initial_angle", 0.2, 1.1), ("length", 0.3, 1.2), 5.0),
    "ends of a chirp": over(
        "fig02", ("sweep_time", 4.0, 5.0), ("amplitude_ratio", 0.01, 0.05), 5.0, options=CHIRP,
        observable="lyapunov_exponent",
    ),
    "pair": over(
        "ballpair_asymmetric", "left_mass", ("initial_angular_velocity_left", 0.0, 1.0), 5.0,
        observable="lyapunov_exponent",
    ),
    "noise": over(
        "toy", ("noise_seed", 0, 6), "noise_strength", options={"noise_strength": 0.02}
    ),
    "kicks": over("toy", "damping", "mass", options={"noise_strength": 0.02}),
    "crank": over(
        "crank_slider", ("connecting_rod_length", 0.01, 0.2), ("drive_amplitude", 0.0, 0.1)
    ),
    "schedule": over("fig12", ("ramp", 0.0, 8.0), "drive_phase", 1.0),
    "stages": over("fig12", "drive_phase", "length", 1.0, options=STAGES),
    "chirp": over("fig02", "drive_frequency_final", "sweep_time", 5.0, options=CHIRP),
    "drag": over("fig02", "quadratic_damping", ("coulomb_damping", 0.0, 0.01)),
    "linear": over("fig02", "length", "gravity", 5.0, options={"system": "mathieu"}),
    "exponent": over("fig02", "length", "damping", 5.0, observable="lyapunov_exponent"),
    "response": over(
        "fig02", "drive_frequency", "drive_amplitude", 60.0, observable="response_period"
    ),
    "words": over(
        "toy", ("frequency_ratio", 1.0, 5.0), ("drive_amplitude", 0.01, 0.1), 60.0,
        observable="contact_word",
    ),
    "no frequency": over(
        "toy", ("frequency_ratio", 0.0, 2.0), ("drive_acceleration_ratio", 0.0, 2.0)
    ),
    "too far": over("toy", ("initial_offset", 0.0, 4.0), ("length", 0.01, 0.4)),
    "strings": over(
        "toy_strings", "string_restitution", ("initial_distance", 0.1, 0.2), 1.5
    ),
    **{
        name: over(
            "toy_strings", "frequency_ratio", "drive_amplitude", 2.0, observable=name,
            transient=0.4,
        )
        for name in ("slack_fraction", "first_slack", "largest_string_impulse", "retension_loss")
    },
    "exponent on strings": over(
        "fig02", "drive_frequency", "drive_amplitude", 5.0,
        options={"suspension": "string", "damping": 0.3}, observable="lyapunov_exponent",
    ),
    "two strings": over(
        "ballpair_asymmetric", ("initial_distance_left", 0.15, 0.25), "right_damping", 1.0,
        options=STRINGS, observable="slack_fraction",
    ),
    "sideways": over(
        "ballpair_asymmetric", "horizontal_amplitude", "frequency_ratio", 2.0, options=PLANAR
    ),
    "ellipse": over(
        "fig02", "horizontal_phase", "vertical_amplitude", 5.0,
        options=PLANAR | {"horizontal_amplitude": 0.05},
    ),
    "air at rest": over("toy", "damping", "drive_amplitude", 2.0, options={"drag_frame": "lab"}),
}  # fmt: skip
WIDTH, HEIGHT = 7, 6
# Values that none of these changes of gravity (relative) moves by more are regular. The smallest
# ones act as rounding does.
NUDGES = (1e-13, -2e-13, 3e-13, 4e-16, -4e-16, 1e-15, -1e-15, 3e-15)
# So much may rounding add up to, in rad for angles.
ROUNDING = 1e-12


@pytest.fixture(scope="module")
def shown():
    """What the page shows of all maps of this file, by name."""
    maps = SWEEPS | KINDS
    size = {"width": WIDTH, "height": HEIGHT}
    return dict(
        zip(maps, views_in_node([{"request": size | r} for r in maps.values()]), strict=True)
    )


def sweep_of(scenario, nudge=0.0):
    """Return the sweep of a scenario, with another gravity."""
    system = dataclasses.replace(scenario.system, gravity=scenario.system.gravity * (1.0 + nudge))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return dataclasses.replace(scenario, system=system).sweep()


def of_point(grid, variable):
    """Return one number a point: of a ball, and the first where there are several."""
    values = grid[variable["name"]]
    if variable["ball"]:
        values = values.sel(ball=variable["ball"])
    return values.values.reshape(WIDTH * HEIGHT, -1)[:, 0]


@pytest.mark.parametrize("name", [*SWEEPS, *KINDS])
def test_a_map_of_the_page_is_the_sweep_over_the_same_axes(name, shown):
    page = shown[name]
    assert "error" not in page, page
    scenario = scenario_of(page["tables"])
    wanted = sweep_of(scenario)
    np.testing.assert_array_equal(page["status"], codes_of(wanted.status).ravel())
    nudges = () if "gravity" in wanted.dims else NUDGES
    others = [sweep_of(scenario, nudge) for nudge in nudges]
    compared = 0
    for variable, row in zip(page["about"]["variables"], page["values"], strict=True):
        found, one = np.array(row, dtype=float), of_point(wanted, variable)
        np.testing.assert_array_equal(np.isnan(found), np.isnan(one))
        size = 1.0 + np.abs(one)
        with np.errstate(invalid="ignore"):
            moved = [np.abs(of_point(each, variable) - one) < 3e-13 * size for each in others]
        regular = np.all([np.isfinite(one), *moved], axis=0)
        assert np.all(np.abs(found - one)[regular] < ROUNDING * size[regular]), variable
        compared += np.count_nonzero(regular)
    assert compared >= 0.3 * WIDTH * HEIGHT


def test_every_picture_has_more_points_and_steps_are_counted_before(shown):
    for page in shown.values():
        assert page["points"] == sorted(set(page["points"]))
        assert page["points"][-1] == WIDTH * HEIGHT
    # Of small maps, the points are counted one by one.
    for name in ("fig05_push", "two balls", "noise", "pair"):
        plan = scenario_of(shown[name]["tables"]).plan()
        batch = make_batch(plan, np.arange(plan.size))
        steps = plan.duration / batch.points.settings["step"][batch.valid]
        assert shown[name]["steps"] == pytest.approx(steps.sum(), rel=1e-12), name


def test_without_simd_a_map_is_the_same_to_the_last_bit(shown):
    size = {"width": WIDTH, "height": HEIGHT}
    names = ["fig05_push", "two balls"]
    pages = views_in_node([{"request": size | (SWEEPS | KINDS)[n]} for n in names], scalar=True)
    for name, page in zip(names, pages, strict=True):
        assert page["values"] == shown[name]["values"]


def test_variables_are_called_what_datasets_call_them(shown):
    for name, page in shown.items():
        wanted = sweep_of(scenario_of(page["tables"]))
        for variable in page["about"]["variables"]:
            assert variable["label"] == wanted[variable["name"]].attrs["long_name"], name
            assert variable["unit"] == wanted[variable["name"]].attrs["units"], name
        for axis in page["sides"].values():
            assert wanted[axis["name"]].attrs["symbol"] == axis["symbol"]
            np.testing.assert_array_equal(axis["values"], wanted[axis["name"]].values)


@pytest.mark.parametrize(
    "name",
    ["fig05_push", "fig11", "two balls", "noise", "clamp", "crank", "chirp", "schedule",
     "slack_fraction", "two strings", "sideways"],
)  # fmt: skip
def test_a_table_of_the_page_opens_as_the_sweep(name, shown, tmp_path):
    path = tmp_path / "map.csv"
    path.write_text(shown[name]["csv"])
    wanted = sweep_of(scenario_of(shown[name]["tables"]))
    found = ll.load(path)
    assert set(found.variables) == set(wanted.variables)
    for each in wanted.coords:
        xr.testing.assert_equal(found[each], wanted[each])
    np.testing.assert_array_equal(found.status, wanted.status)
    # The program shows it as well.
    cells = stored.compute({"path": stored.named([path])["map.csv"]}, tmp_path, print)[1]
    np.testing.assert_array_equal(cells["status"], codes_of(wanted.status).ravel())
    for variable in wanted.data_vars:
        assert found[variable].attrs == wanted[variable].attrs
        if variable != "status":
            np.testing.assert_array_equal(np.isnan(found[variable]), np.isnan(wanted[variable]))


def test_a_table_of_a_coarse_map_holds_its_points_alone(tmp_path):
    coarse = {"width": 99, "height": 6, "stride": 4}
    requests = [SWEEPS["fig05_push"] | coarse, KINDS["kicks"] | coarse]
    pages = views_in_node([{"request": request} for request in requests])
    found = []
    for page in pages:
        (tmp_path / "map.csv").write_text(page["csv"])
        found.append((ll.load(tmp_path / "map.csv"), sweep_of(scenario_of(page["tables"]))))
    (few, whole), (kicked, _) = found
    for axis in whole.dims:
        np.testing.assert_array_equal(few[axis], whole[axis][::4])
    assert few.sizes == {"drive_amplitude": 2, "frequency_ratio": 25}
    assert not (few.status == "missing").any()
    assert few.attrs["subset"] == "every 4th value along both axes of a map of 99 x 6 points"
    assert "unfinished" not in few.attrs
    # Kicks are those of a point's number among all: these points are no sweep of their own.
    assert kicked.status.size == 99 * 6
    assert int((kicked.status != "missing").sum()) == 2 * 25
    assert kicked.attrs["unfinished"].startswith("544 of 594 points are not computed")


def test_exponents_fit_no_table(shown):
    (page,) = views_in_node([{"request": KINDS["exponent"] | {"observable": "lyapunov_exponents"}}])
    assert page["csv"] == (
        "lyapunov_exponents has several numbers for each point: it fits no table; use NetCDF"
    )


@pytest.mark.parametrize(
    "name",
    ["fig05_push", "fig09", "two balls", "noise", "clamp", "crank", "two strings", "sideways"],
)
def test_the_lines_on_show_compute_the_same_map(name, shown):
    about, wanted = shown[name]["about"], sweep_of(scenario_of(shown[name]["tables"]))
    names: dict = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        exec(about["python"], names)
        result = CliRunner().invoke(command, [*shlex.split(about["command"])[1:], "--json"])
    xr.testing.assert_identical(names["grid"].drop_attrs(), wanted.drop_attrs())
    assert result.exit_code == 0, result.output
    values = wanted[about["observable"]]
    ranges = json.loads(result.stdout)["ranges"][about["observable"]]
    np.testing.assert_allclose(ranges, [values.min(), values.max()], rtol=1e-6)


POINTS = [
    "fig05_push", "offset", "start", "two balls", "ratios", "noise", "kicks", "chirp",
    "strings", "two strings", "sideways",
]  # fmt: skip


def test_the_run_of_a_point_is_what_its_cell_says():
    maps = SWEEPS | KINDS
    cell = 2 * WIDTH + 3
    size = {"width": WIDTH, "height": HEIGHT, "duration": 2.0, "transient": 0.0}
    watched = {"observable": "final_angle"}
    pages = views_in_node([{"request": maps[n] | size | watched, "run": cell} for n in POINTS])
    for name, page in zip(POINTS, pages, strict=True):
        for k, angle in enumerate(page["run"]["final"]):
            # The map's step and that of a run alone are the same.
            assert angle == pytest.approx(page["values"][k][cell], rel=1e-9, abs=1e-9), name


@pytest.mark.parametrize(
    "request_, words",
    [
        ({"width": 600, "height": 600}, "at most 250000 points, got 600 x 600: choose fewer"),
        ({"duration": 1e6}, " 10⁶; shorten it, loosen tolerance"),
        ({"duration": 1e25}, "steps of 0.16 s, the limit is 10¹⁰; shorten it"),
        ({"duration": 0.0}, "each run must last longer than 0 s, got 0 s"),
        ({"transient": -1.0}, "“leave out the first” must be at least 0 s, got -1 s"),
        ({"transient": 300.0}, "transient must be shorter than duration (300 s), got 300"),
        ({"scenario": "fig55"}, "there is no scenario 'fig55'"),
        ({"options": {"lenght": "1 m"}}, "unknown option 'lenght': did you mean 'length'?"),
        ({"options": {"length": "3 s"}}, "length must be given in m"),
        ({"options": {"radius": 2.0}}, "radius must lie in [0, length)"),
        ({"options": {"initial_angle": 3.3}}, "initial_angle must lie between the contact angles"),
        ({"options": {"system": "pendulum"}}, "counts from the low contact angle of a LatoLato"),
        ({"observable": "energy"}, "unknown observable 'energy': did you mean 'mean_energy'?"),
        ({"x": {"name": "frequencyratio"}}, "unknown parameter 'frequencyratio': did you mean"),
        ({"y": {"name": "drive_amplitude", "low": 0.4, "high": 0.1}},
         "driving amplitude: the end must lie above the start, got 400 mm to 100 mm"),
        ({"x": {"low": 2.0, "high": 2.0}}, "the end must lie above the start, got 2 to 2"),
        ({"y": {"low": 0.0, "high": 0.1, "log": True}},
         "driving amplitude: a logarithmic axis must begin above zero, got 0 mm: raise the start"),
        ({"y": {"name": "initial_angle", "low": -0.1, "high": 0.1, "log": True}},
         "got -5.72958°: raise the start, or make the axis linear"),
        ({"y": {"name": "restitution", "low": 0.5, "high": 2.0}},
         "“coefficient of restitution” must be between 0 and 1, got 2"),
        ({"x": {"high": 1e300}},
         "“driving over natural frequency” is too large to compute with, got 10³⁰⁰; check its "
         "order of magnitude"),
        ({"y": {"name": "length", "low": 0.0, "high": 2.0}},
         "“pivot to ball centre” must be above 0 cm, got 0 cm"),
        ({"y": {"name": "frequency_ratio", "low": 0.0, "high": 2.0}},
         "both axes show the driving over natural frequency: choose another one"),
        ({"y": {"name": "drive_frequency", "low": 0.0, "high": 2.0}},
         "set the same thing: choose another axis"),
        ({"x": {"name": "noise_seed", "low": 0, "high": 1}, "options": {"noise_strength": 0.01}},
         "noise_seed must be a whole number, got 0.3"),
        ({"options": CHIRP, "observable": "response_period"},
         "a chirp drive has no single period that a stroboscope could follow"),
        ({"options": {"contact": "clamp"}, "observable": "lyapunov_exponent"},
         "lyapunov_exponent needs exact contact"),
        ({"x": {"name": "string_restitution"}}, "string_restitution is for balls on strings"),
        ({"y": {"name": "initial_distance"}}, "initial_distance is for balls on strings"),
        ({"options": {"initial_distance": 0.3}}, "initial_distance is for balls on strings"),
        ({"observable": "slack_fraction"}, "slack_fraction is for balls on strings"),
        ({"options": {"suspension": "string"}, "observable": "compression_fraction"},
         "compression_fraction is for balls on rods: a string never pushes, it goes slack"),
        ({"options": {"suspension": "string", "coulomb_damping": 0.001},
          "observable": "lyapunov_exponent"},
         "coulomb_damping must be 0 for lyapunov_exponent on strings"),
        ({"options": {"drag_frame": "lab"}, "x": {"name": "quadratic_damping"}},
         "drag_frame must be 'pivot' with quadratic_damping"),
        ({"options": PLANAR, "x": {"name": "horizontal_amplitude"}},
         "moves the pivot sideways, which breaks the mirror symmetry of a LatoLato"),
        ({"options": {"drive": "measured_pivot"}},
         "a map with the drive measured_pivot is computed by the installed program: run "
         "`latolato sweep` and open its file with `latolato app --open`"),
    ],
)  # fmt: skip
def test_a_bad_request_is_refused_with_one_line(request_, words, refusals):
    text = refusals[repr(request_)]
    assert words in text
    assert "\n" not in text


@pytest.fixture(scope="module")
def refusals():
    """The refusals of all requests of the test above, computed at once."""
    (mark,) = test_a_bad_request_is_refused_with_one_line.pytestmark
    given = [request for request, _ in mark.args[1]]
    pages = views_in_node([{"request": {"scenario": "fig05_push"} | each} for each in given])
    return {repr(each): page.get("error", "") for each, page in zip(given, pages, strict=True)}


def test_an_axis_has_the_usual_end_and_parameter_where_none_is_given():
    usual, ended, turned = views_in_node(
        [
            {"planned": True, "request": {"scenario": "fig05_push", **axes}}
            for axes in ({}, {"x": {"low": 1.0}, "y": {"high": 0.2, "log": True}},
                         {"y": {"name": "restitution"}})
        ]
    )  # fmt: skip

    def span(axis):
        return axis["name"], axis["low"], axis["high"], axis["log"]

    high = usual["sides"]["x"]["high"]
    assert span(ended["sides"]["x"]) == ("frequency_ratio", 1.0, high, False)
    # Two decades, as a logarithmic axis has to begin with.
    y = ended["sides"]["y"]
    assert span(y) == ("drive_amplitude", 0.002, 0.2, True)
    np.testing.assert_allclose(y["values"], np.geomspace(0.002, 0.2, 3), rtol=1e-14)
    edges = np.array(y["edges"])
    np.testing.assert_allclose(edges[1:] / edges[:-1], 10.0, rtol=1e-12)
    assert span(turned["sides"]["y"]) == ("restitution", 0.5, 1.0, False)


def test_what_may_be_chosen_stands_once_with_a_description():
    (page,) = views_in_node([{"planned": True, "request": {"scenario": "fig09"}}])
    names = [each["name"] for each in page["choices"]["variables"]]
    assert len(names) == len(set(names))
    assert all(each["description"] for each in page["choices"]["variables"])
    together = [each["name"] for each in page["choices"]["variables"] if each["together"]]
    assert together == [
        "mean_energy", "motion_class", "largest_angle", "largest_angle_after_transient"
    ]  # fmt: skip
    axes = {each["name"] for each in page["choices"]["axes"]}
    assert {"length", "frequency_ratio", "initial_angle"} <= axes
    assert "noise_strength" not in axes


def test_what_belongs_to_strings_is_offered_for_strings_only():
    of_strings = {
        "string_restitution", "initial_distance", "slack_fraction", "first_slack",
        "largest_string_impulse", "retension_loss",
    }  # fmt: skip
    rods, strings = (
        {each["name"] for kind in ("axes", "variables") for each in page["choices"][kind]}
        for page in views_in_node(
            [{"planned": True, "request": {"scenario": name}} for name in ("toy", "toy_strings")]
        )
    )
    assert of_strings <= strings
    assert not of_strings & rods
    assert rods - strings >= {"compression_fraction"}
    assert "lyapunov_exponent" in strings


def test_overlays_learn_what_the_system_is():
    toy, pair = views_in_node(
        [{"planned": True, "request": {"scenario": name, "duration": 1.0}}
         for name in ("fig05_push", "ballpair_asymmetric")]
    )  # fmt: skip
    assert toy["about"]["parameters"]["length"] == 1.0
    assert toy["about"]["has_contact"]
    assert pair["about"]["parameters"]["right_length"] == 0.245
