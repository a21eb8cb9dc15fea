"""Maps that pages ask for are the sweeps of the library, cell by cell, and end when pages go."""

import contextlib
import json
import re
import time
import zipfile

import hypothesis
import numpy as np
import pytest
import xarray as xr
from hypothesis import strategies as st
from starlette.testclient import TestClient
from starlette.websockets import WebSocketDisconnect

import latolato as ll
from latolato.app.blocks import unpack
from latolato.app.map_cells import Maps, known_of
from latolato.app.map_job import in_order, levels
from latolato.app.map_request import MapRequest, make_map
from latolato.app.map_stored import named
from latolato.app.maps import cells_of
from latolato.app.server import Settings, make_app
from latolato.sweeps.store import store_status

HOME = "http://127.0.0.1:8000"
SMALL = {
    "scenario": "fig05_push",
    "options": {},
    "duration": 20.0,
    "width": 14,
    "height": 9,
    "x": {"name": "frequency_ratio", "low": 0.5, "high": 4.5},
    "y": {"name": "drive_amplitude", "low": 0.05, "high": 0.45},
}


@pytest.fixture
def client():
    with TestClient(make_app(Settings()), base_url=HOME) as found:
        yield found


def connected(client):
    return client.websocket_connect("ws://127.0.0.1:8000/ws/map", headers={"origin": HOME})


def asked(client, plan):
    """Return texts, headers and arrays of everything that the server sends for a plan."""
    texts, blocks = [], []
    with connected(client) as socket:
        socket.send_text(plan if isinstance(plan, str) else json.dumps(plan))
        while True:
            message = socket.receive()
            if message["type"] == "websocket.close":
                return texts, blocks
            if message.get("text") is not None:
                texts.append(json.loads(message["text"]))
            else:
                blocks.append(unpack(message["bytes"]))


def gathered(blocks):
    """Return each variable of a map as rows from the bottom, and the statuses."""
    about, sides = blocks[0]
    shape = len(sides["y"]), len(sides["x"])
    values = np.full((len(about["variables"]), shape[0] * shape[1]), np.nan, np.float32)
    status = np.full(shape[0] * shape[1], 255, np.uint8)
    for header, arrays in blocks[1:]:
        if header["kind"] == "cells":
            values[:, arrays["cell"]] = arrays["values"]
            status[arrays["cell"]] = arrays["status"]
    names = [v["name"] if v["ball"] is None else (v["name"], v["ball"]) for v in about["variables"]]
    return dict(zip(names, values.reshape(-1, *shape), strict=True)), status.reshape(shape)


def test_a_finished_map_is_the_sweep_over_the_same_axes_cell_by_cell(client):
    texts, blocks = asked(client, SMALL)
    assert "choices" in texts[0]
    assert blocks[-1][0]["kind"] == "done"
    values, status = gathered(blocks)
    wanted = ll.load_scenario("fig05_push").sweep(
        duration=20.0,
        axes={
            "drive_amplitude": np.linspace(0.05, 0.45, 9),
            "frequency_ratio": np.linspace(0.5, 4.5, 14),
        },
    )
    np.testing.assert_array_equal(status, wanted.status.values)
    assert set(values) == {"mean_energy", "crossings", "largest_angle", "top_contacts"}
    for name, found in values.items():
        np.testing.assert_array_equal(found, wanted[name].values.astype(np.float32), err_msg=name)
    # Large amplitudes are the upper rows.
    assert np.nanmean(values["mean_energy"][-1]) > np.nanmean(values["mean_energy"][0])


def test_the_kicks_of_a_cell_are_those_of_the_same_cell_of_a_sweep(client):
    plan = {**SMALL, "options": {"noise_strength": 0.02}, "observable": "final_angle"}
    texts, blocks = asked(client, plan | {"width": 4, "height": 3, "duration": 2.0})
    assert blocks, texts
    values, _ = gathered(blocks)
    scenario = make_map(MapRequest.from_json(plan)).scenario
    wanted = ll.sweep(
        scenario.system,
        noise=scenario.run["noise"],
        initial_offset=scenario.run["initial_offset"],
        duration=2.0,
        observables=["final_angle"],
        axes={
            "drive_amplitude": np.linspace(0.05, 0.45, 3),
            "frequency_ratio": np.linspace(0.5, 4.5, 4),
        },
    )
    np.testing.assert_array_equal(
        values["final_angle"], wanted.final_angle.values.astype(np.float32)
    )


@pytest.mark.parametrize("width, height", [(200, 200), (50, 31), (1, 7), (25, 400)])
def test_levels_hold_every_cell_once_and_coarse_ones_first(width, height):
    parts = list(levels(width, height))
    cells = np.concatenate([cells for _, cells in parts])
    assert sorted(cells.tolist()) == list(range(width * height))
    strides = [stride for stride, _ in parts]
    assert strides == sorted(strides, reverse=True)
    assert strides[-1] == 1
    assert len(parts[0][1]) <= 25 * 25
    for stride, each in parts:
        row, column = np.divmod(each, width)
        assert not (row % stride).any()
        assert not (column % stride).any()


def computed(blocks):
    """Return how many points were computed for these frames."""
    assert blocks[-1][0]["kind"] == "done"
    return blocks[-1][0]["points"]


def test_a_map_that_was_stopped_goes_on_where_it_stopped(client):
    plan = {**SMALL, "width": 60, "height": 60, "duration": 60.0}
    with connected(client) as socket:
        socket.send_json(plan)
        frames = 0
        while frames < 4:
            message = socket.receive()
            frames += message.get("bytes") is not None
    while client.app.state.maps.borrowed_tokens:
        time.sleep(0.01)
    (memory, _), *_ = client.app.state.map_cells._found.values()
    before = int(known_of(memory).sum())
    assert 0 < before < 3600
    _, blocks = asked(client, plan)
    assert blocks[0][0]["points"] == computed(blocks) == 3600 - before
    # What is known comes first, coarse points before fine ones.
    assert len(blocks[1][1]["cell"]) == before
    assert (np.diff(blocks[1][1]["stride"].astype(int)) <= 0).all()
    values, status = gathered(blocks)
    assert status.max() < 255
    assert known_of(memory).all()
    np.testing.assert_array_equal(
        values["mean_energy"], memory.arrays["mean_energy"].astype(np.float32)
    )


def test_points_of_a_map_that_was_seen_are_not_computed_again(client):
    _, first = asked(client, SMALL)
    assert computed(first) == 14 * 9
    _, again = asked(client, SMALL | {"observable": "crossings"})
    assert computed(again) == 0
    step = 4.0 / 13
    moved = {"name": "frequency_ratio", "low": 0.5 + 3 * step, "high": 4.5 + 3 * step}
    _, beside = asked(client, SMALL | {"x": moved})
    assert computed(beside) == 3 * 9
    old, new = (gathered(blocks)[0]["largest_angle"] for blocks in (first, beside))
    np.testing.assert_array_equal(new[:, :11], old[:, 3:])
    # Other kicks for another number of the point: these are computed.
    noisy = SMALL | {"options": {"noise_strength": 0.02}, "observable": "final_angle"}
    noisy |= {"width": 4, "height": 3, "duration": 2.0}
    asked(client, noisy)
    assert computed(asked(client, noisy)[1]) == 0
    shifted = {"name": "frequency_ratio", "low": 0.5 + 4.0 / 3, "high": 4.5 + 4.0 / 3}
    assert computed(asked(client, noisy | {"x": shifted})[1]) == 12


def test_maps_beyond_the_memory_are_forgotten_the_oldest_first():
    plans = [
        make_map(MapRequest.from_json({**SMALL, "duration": seconds})).plan for seconds in (1, 2, 3)
    ]
    maps = Maps(most_bytes=9000)  # four variables of 126 points: 4 kB a map
    for plan in plans:
        maps.begin(plan)
    assert [maps.by_hash(plan.hash) is None for plan in plans] == [True, False, False]


def test_a_logarithmic_axis_is_spaced_evenly_in_its_logarithm(client):
    axis = {"name": "drive_amplitude", "low": 0.004, "high": 0.4, "log": True}
    plan = {**SMALL, "y": axis, "height": 5, "width": 4, "duration": 8.0}
    texts, blocks = asked(client, plan)
    about, sides = blocks[0]
    assert [about["x"]["log"], about["y"]["log"]] == [False, True]
    np.testing.assert_array_equal(sides["y"], np.geomspace(0.004, 0.4, 5))
    np.testing.assert_allclose(sides["y_edges"][1:] / sides["y_edges"][:-1], 10**0.5, rtol=1e-12)
    assert texts[0]["choices"]["y"]["log"]
    # Both lines on show compute the same points.
    assert "np.geomspace(0.004, 0.4, 5)" in about["python"]
    names: dict = {}
    exec(about["python"], names)
    values, _ = gathered(blocks)
    np.testing.assert_array_equal(
        values["mean_energy"], names["grid"].mean_energy.values.astype(np.float32)
    )
    assert "drive_amplitude = 0.004 : 0.4 : 5 log m" in about["command"]
    # Where nothing is said of its ends, it lies above zero.
    _, blocks = asked(client, plan | {"y": {"name": "drive_amplitude", "log": True}})
    assert blocks[0][1]["y"][0] > 0.0


@pytest.mark.parametrize(
    "which, span, words",
    [
        ("y", ("drive_amplitude", 0.4, 0.1), "driving amplitude: the end must lie above the start"),
        ("x", ("frequency_ratio", 2.0, 2.0), "the end must lie above the start, got 2 to 2"),
        ("y", ("drive_amplitude", 0.0, 0.1, True), "logarithmic axis must begin above zero"),
        ("y", ("initial_angle", -0.1, 0.1, True), "got -5.72958 deg: raise the start, or make"),
        ("y", ("restitution", 0.5, 2.0), "values must be at least 0 and at most 1, got 2"),
        ("y", ("length", 0.0, 2.0), "values must be above 0 cm, got 0 cm"),
        ("y", ("frequency_ratio", 0.0, 2.0), "both axes show the"),
        ("y", ("drive_frequency", 0.0, 2.0), "set the same thing: choose another axis"),
    ],
)
def test_a_bad_axis_is_told_by_the_name_of_its_quantity(client, which, span, words):
    given = dict(zip(("name", "low", "high", "log"), span, strict=False))
    texts, blocks = asked(client, SMALL | {which: given})
    assert not blocks
    assert words in texts[-1]["error"]


def test_an_axis_has_the_usual_end_and_parameter_where_none_is_given():
    from latolato.app.map_request import MapRequest, make_map

    def spans(**asked):
        shown = make_map(MapRequest.from_json({"scenario": "fig05_push", "options": {}, **asked}))
        return shown.x, shown.y

    usual_x, usual_y = spans()
    x, y = spans(x={"low": 1.0}, y={"high": 0.2, "log": True})
    assert (x.name, x.low, x.high) == (usual_x.name, 1.0, usual_x.high)
    # Two decades, as a logarithmic axis has to begin with.
    assert (y.name, y.low, y.high, y.log) == (usual_y.name, pytest.approx(0.002), 0.2, True)


def test_closing_the_socket_stops_the_kernels(client):
    plan = {"scenario": "fig05_push", "width": 400, "height": 400, "options": {}}
    with connected(client) as socket:
        socket.send_json(plan)
        while "bytes" not in (message := socket.receive()) or message["bytes"] is None:
            assert "error" not in (message.get("text") or "")
        begun = time.perf_counter()
    # The whole map takes a minute of two cores, so the next one would wait for the first.
    _, blocks = asked(client, SMALL)
    assert blocks[-1][0]["kind"] == "done"
    assert time.perf_counter() - begun < 30.0
    while client.app.state.maps.borrowed_tokens:  # given back after the last message
        assert time.perf_counter() - begun < 60.0
        time.sleep(0.01)


@pytest.mark.parametrize(
    "changed, words",
    [
        ({"width": 1001}, "width must not exceed 1000"),
        ({"width": 600, "height": 600}, "width x height must not exceed"),
        ({"duration": 1e6, "width": 200, "height": 200}, "the limit is"),
        ({"duration": 1e25}, "would take more than"),
        ({"tolerance": 1e-300}, "must lie in"),
    ],
)
def test_a_map_that_is_too_large_is_refused_before_any_work(client, changed, words):
    texts, blocks = asked(client, SMALL | changed)
    assert not blocks
    assert words in texts[-1]["error"]
    assert "\n" not in texts[-1]["error"]


@pytest.mark.parametrize(
    "plan",
    [
        "",
        "{",
        "[" * 50_000,
        "3",
        "null",
        "[]",
        '{"x": 3}',
        '{"scenario": "../secret"}',
        '{"scenario": 3}',
        '{"stored": "/etc/passwd"}',
        '{"stored": 3}',
        '{"unknown": 1}',
        *(
            json.dumps(SMALL | changed)
            for changed in (
                {"width": "many"},
                {"width": 0},
                {"width": True},
                {"x": {"name": "frequency_ratio", "low": 2.0, "high": 1.0}},
                {"x": {"name": "frequency_ratio", "low": 9.0}},
                {"x": {"name": "drive_amplitude", "low": 0.1, "high": 0.2}},
                {"x": {"name": "frequencyratio", "low": 1.0, "high": 2.0}},
                {"y": {"name": "restitution", "low": 0.5, "high": 2.0}},
                {"observable": "energy"},
                {"observable": ["mean_energy"]},
                {"y": {"name": "drive_amplitude", "log": 3}},
                {"duration": "long"},
                {"duration": -1.0},
                {"transient": 30.0},
                {"options": {"length": "3 s"}},
            )
        ),
    ],
)
def test_a_bad_plan_is_refused_with_one_line(client, plan):
    texts, blocks = asked(client, plan)
    assert not blocks
    assert texts[-1]["error"]
    assert "\n" not in texts[-1]["error"]


def test_bytes_that_are_no_text_do_not_crash_the_server(client):
    with connected(client) as socket:
        socket.send_bytes(b"\xff\xfe\x00")
        assert "error" in json.loads(socket.receive()["text"])
        with pytest.raises(WebSocketDisconnect):
            socket.receive_text()
    assert asked(client, SMALL | {"width": 2, "height": 2})[1]


@pytest.mark.parametrize(
    "scenario, x, y",
    [
        ("fig05_push", "restitution", "radius"),
        ("fig05_push", "initial_offset", "frequency_ratio"),
        ("fig02", "initial_angle", "initial_angular_velocity"),
        ("ballpair_asymmetric", "right_mass", "initial_angle_left"),
        ("fig09", "amplitude_ratio", "drive_frequency"),
    ],
)
def test_any_two_parameters_can_be_the_axes(client, scenario, x, y):
    plan = {"scenario": scenario, "x": {"name": x}, "y": {"name": y}, "width": 3, "height": 3}
    plan |= {"duration": 3.0, "transient": 0.0, "observable": "largest_angle"}
    texts, blocks = asked(client, plan)
    assert blocks, texts
    values, status = gathered(blocks)
    assert status.max() < 255
    assert blocks[0][0]["x"]["name"] == x
    assert any(np.isfinite(v).any() for v in values.values())


def test_the_run_of_a_point_is_what_its_cell_says(client):
    # Short: in chaos, lanes and a single run part after some ten bounces by their rounding.
    plan = {**SMALL, "duration": 8.0}
    _, blocks = asked(client, plan)
    values, _ = gathered(blocks)
    sides = blocks[0][1]
    answer = client.post("/api/map/point", json={**plan, "at": [sides["x"][9], sides["y"][6]]})
    about, _ = unpack(answer.content)
    assert about["options"]["drive_amplitude"] == sides["y"][6]
    assert about["summary"]["contacts"]["top"] == values["top_contacts"][6, 9]
    assert values["top_contacts"][6, 9] == 6
    # The largest angle is the wall, which the ball meets between two samples.
    largest = values["largest_angle"][6, 9]
    np.testing.assert_allclose(about["summary"]["largest_angle"], largest, rtol=2e-3)


def test_the_lines_on_show_compute_the_same_map(client):
    import shlex

    from typer.testing import CliRunner

    from latolato.cli.main import app as command

    plan = {**SMALL, "scenario": "fig09", "transient": 10.0, "width": 3, "height": 2}
    _, blocks = asked(client, plan)
    values, _ = gathered(blocks)
    names: dict = {}
    exec(blocks[0][0]["python"], names)
    grid = names["grid"]
    for name, found in values.items():
        np.testing.assert_array_equal(found, grid[name].values.astype(np.float32), err_msg=name)
    words = shlex.split(blocks[0][0]["command"])
    result = CliRunner().invoke(command, [*words[1:], "--json"])
    assert result.exit_code == 0, result.output
    energy = values["mean_energy"]
    found = json.loads(result.output)["ranges"]["mean_energy"]
    np.testing.assert_allclose(found, [energy.min(), energy.max()], rtol=1e-6)


TRIALS = "drive_amplitude,frequency_ratio,class\n100 mm,2,strong\n200 mm,3,none\n900 mm,2,weak\n"


def test_theory_and_trials_come_in_the_coordinates_of_the_map(client):
    body = {**SMALL, "limits": [0.0, 5.0, 0.0, 0.5], "trials": TRIALS}
    about, arrays = unpack(client.post("/api/map/overlays", json=body).content)
    lift = arrays["lift_off_y"] * (arrays["lift_off_x"] ** 2) / 1.0  # A0/l (w/w0)^2 is 1
    np.testing.assert_allclose(lift, 1.0, rtol=1e-12)
    tip = np.argmin(arrays["tongue_y"])
    np.testing.assert_allclose(arrays["tongue_x"][tip], 2.0, atol=1e-6)
    np.testing.assert_allclose(arrays["trial_x"], [2.0, 3.0, 2.0], rtol=1e-15)
    assert arrays["trial_y"].tolist() == [0.1, 0.2, 0.9]
    assert arrays["trial_class"].tolist() == [2, 0, 1]
    assert about["outside"] == 1
    other = body | {"x": {"name": "restitution", "low": 0, "high": 1}}
    about, arrays = unpack(client.post("/api/map/overlays", json=other).content)
    assert not arrays
    assert "amplitude" in about["notes"]["all"]


@pytest.mark.parametrize(
    "changed", [{"limits": [0, 1]}, {"trials": 3}, {"trials": "a,b\n1,2\n"}, {"trials": "\0\n,,,"}]
)
def test_bad_trials_are_refused_with_one_line(client, changed):
    body = {**SMALL, "limits": [0.0, 5.0, 0.0, 0.5], **changed}
    answer = client.post("/api/map/overlays", json=body)
    assert answer.status_code == 422
    assert "\n" not in answer.json()["error"]


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    """A stored map with a third axis, and another one in NetCDF."""
    folder = tmp_path_factory.mktemp("stored")
    axes = {
        "restitution": [0.5, 0.9],
        "drive_amplitude": [0.1, 0.2, 0.4],
        "frequency_ratio": [1.0, 1.5, 2.5, 3.0],
    }
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1)
    options = {"duration": 5.0, "initial_offset": 0.2, "observables": ["largest_angle"]}
    grid = ll.sweep(toy, axes=axes, store=folder / "map.zarr", **options)
    ll.save(grid, folder / "map.nc")
    return folder, grid


@pytest.mark.parametrize("name", ["map.zarr", "map.nc"])
def test_a_stored_map_opens_by_its_name_only(stored, name):
    folder, grid = stored
    app = make_app(Settings(stored=named([folder / name])))
    with TestClient(app, base_url=HOME) as client:
        assert client.get("/api/map/stored").json() == [name]
        texts, blocks = asked(client, {"stored": name, "select": {"restitution": 1}})
        assert blocks, texts
        values, _ = gathered(blocks)
        wanted = grid.largest_angle.isel(restitution=1).values.astype(np.float32)
        np.testing.assert_array_equal(values["largest_angle"], wanted)
        about, sides = blocks[0]
        assert about["select"][0]["values"] == ["0.5", "0.9"]
        assert sides["x_edges"].tolist() == [0.75, 1.25, 2.0, 2.75, 3.25]
        body = {"stored": name, "select": {"restitution": 1}, "at": [2.4, 0.21]}
        body["names"] = ["frequency_ratio", "drive_amplitude"]
        about, _ = unpack(client.post("/api/map/point", json=body).content)
        assert about["options"]["restitution"] == 0.9
        assert about["options"]["drive_amplitude"] == 0.2
        # Samples, a hundred in a period, miss a turn by less than (pi / 100)^2 / 2 of it.
        largest = float(grid.largest_angle[1, 1, 2])
        np.testing.assert_allclose(about["summary"]["largest_angle"], largest, rtol=5e-4)
        for other in (str(folder / name), "../map.zarr", None):
            texts, blocks = asked(client, {"stored": other})
            assert not blocks
            assert "there is no stored map" in texts[-1]["error"]


def test_what_is_no_map_cannot_be_opened(tmp_path):
    with pytest.raises(FileNotFoundError, match="there is no file or store"):
        named([tmp_path / "none.zarr"])
    (tmp_path / "empty.zarr").mkdir()
    with pytest.raises(ValueError, match="not a store of a sweep"):
        named([tmp_path / "empty.zarr"])


NUMBERS = st.sampled_from([0, 1, -1, 3, 7, 0.5, 1e-300, 1e300, 1e308, 2**63, -0.0, True])
SPANS = st.fixed_dictionaries(
    {
        "name": st.sampled_from(
            ["frequency_ratio", "drive_amplitude", "length", "gravity", "initial_offset", "radius"]
        )
        | st.text(max_size=5),
        "low": NUMBERS,
        "high": NUMBERS,
        "log": st.booleans(),
    }
)
ANYTHING = st.recursive(
    NUMBERS | st.none() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=5,
)
PLANS = st.fixed_dictionaries(
    {"scenario": st.sampled_from(["fig05_push", "ballpair_asymmetric", "fig12", "zeno"])},
    optional={
        "x": SPANS | ANYTHING,
        "y": SPANS | ANYTHING,
        "width": st.integers(1, 4) | ANYTHING,
        "height": st.integers(1, 4) | ANYTHING,
        "duration": st.sampled_from([0.1, 1.0]) | ANYTHING,
        "transient": NUMBERS | ANYTHING,
        "tolerance": NUMBERS | ANYTHING,
        "observable": st.sampled_from(["crossings", "largest_angle"]) | ANYTHING,
        "options": st.dictionaries(st.sampled_from(["length", "radius", "gravity"]), ANYTHING),
        "limits": st.lists(NUMBERS, min_size=4, max_size=4),
        "trials": st.text(max_size=30),
        "at": st.lists(NUMBERS, min_size=2, max_size=2) | ANYTHING,
        "stored": ANYTHING,
    },
)


@hypothesis.given(plan=PLANS)
@hypothesis.settings(max_examples=150, deadline=None, derandomize=True)
def test_no_plan_makes_the_server_stumble(plan):
    # What a job does before kernels run; the socket itself is tested above.
    own = {k: v for k, v in plan.items() if k not in ("limits", "trials", "at", "stored")}
    with contextlib.suppress(TypeError, ValueError):
        shown = make_map(MapRequest.from_json(own))
        shown.cost_of_point()
        cells, _ = in_order(shown)
        Maps().begin(shown.plan)
        assert len(cells) <= 16 or "width" not in plan or "height" not in plan
    app = make_app(Settings())
    for path in ("/api/map/point", "/api/map/overlays"):
        answer = TestClient(app, base_url=HOME).post(path, json=plan)
        assert answer.status_code in (200, 413, 422)
        if answer.status_code != 200:
            assert "\n" not in answer.json()["error"]


def filled(client, plan, field):
    """Return the sides and the key of a map whose energy is a field of x and y."""
    shown = make_map(MapRequest.from_json(plan))
    memory = cells_of(client.app).begin(shown.plan)
    x, y = shown.grid
    values = {name: np.zeros_like(array) for name, array in memory.arrays.items()}
    values["mean_energy"] = field(*np.meshgrid(x, y))
    everything = np.arange(memory.plan.size)
    memory.put(everything, {k: v.reshape(memory.plan.size) for k, v in values.items()}, "")
    return x, y, memory


CONTOURS = {"observable": "mean_energy", "levels": [1.0, 2.5]}


def contours_of(client, body):
    """Return what is told of contours, and the corners of each level."""
    answer = client.post("/api/map/contours", json=body)
    assert answer.status_code == 200, answer.text
    about, arrays = unpack(answer.content)
    ends = [*arrays["first"], len(arrays["x"])]
    lines = [
        (about["levels"][n], arrays["x"][a:b], arrays["y"][a:b])
        for n, a, b in zip(arrays["level"], arrays["first"][:-1], ends[1:], strict=False)
    ]
    return about, lines


@pytest.mark.parametrize("log", [False, True])
def test_a_contour_lies_where_an_analytic_field_has_its_value(client, log):
    low = 0.01 if log else 0.0
    y_axis = {"name": "drive_amplitude", "low": low, "high": 0.4, "log": log}
    plan = {**SMALL, "y": y_axis, "width": 41, "height": 61}
    x, y, memory = filled(client, plan, lambda x, y: x**2 * (1.0 + np.sin(5.0 * y)))
    about, lines = contours_of(client, {**CONTOURS, "key": memory.plan.hash, "ylog": log})
    assert about["levels"] == [1.0, 2.5]
    assert {level for level, *_ in lines} == {1.0, 2.5}
    for level, at_x, at_y in lines:
        exact = np.sqrt(level / (1.0 + np.sin(5.0 * at_y)))
        # Straight between points: off by h^2 f'' / (8 f') = h^2 / (8 x), a fiftieth of a cell.
        assert np.abs(at_x - exact).max() < 0.02 * (x[1] - x[0])
        # From the lower to the upper side of the map.
        assert at_y.min() == pytest.approx(y[0])
        assert at_y.max() == pytest.approx(y[-1])


def test_contours_of_a_stopped_map_are_those_of_its_complete_coarse_points(client):
    plan = {**SMALL, "width": 41, "height": 41}
    *_, memory = filled(client, plan, lambda x, y: x)
    memory.arrays["status"][3, 3] = -1
    memory.arrays["mean_energy"][3, 3] = np.nan
    about, lines = contours_of(client, {**CONTOURS, "key": memory.plan.hash, "levels": [1.23]})
    assert about["missing"] == 1
    ((_, at_x, at_y),) = lines
    np.testing.assert_allclose(at_x, 1.23, rtol=1e-12)
    assert len(at_y) == 21


def test_levels_to_begin_with_are_round_in_the_unit_on_show(client):
    def levels(low, high, **asked):
        field = lambda x, y: low + (high - low) * (y - 0.05) / 0.4  # noqa: E731
        plan = SMALL | {"duration": 20.0 + high}
        *_, memory = filled(client, plan, field)
        memory.arrays["largest_angle"][:] = memory.arrays["mean_energy"]
        return contours_of(client, {"key": memory.plan.hash, **asked})[0]["levels"]

    assert levels(0.03, 2.9, observable="mean_energy") == [0.5, 1.0, 1.5, 2.0, 2.5]
    found = levels(0.0, 3.0, observable="largest_angle")
    np.testing.assert_allclose(np.degrees(found), [30, 60, 90, 120, 150], rtol=1e-12)
    found = levels(1e-3, 50.0, observable="mean_energy", log=True)
    assert found == [0.01, 0.1, 1.0, 10.0]


@pytest.mark.parametrize(
    "changed, words",
    [
        ({"levels": []}, "levels must be a list"),
        ({"levels": ["high"]}, "a level must be a number"),
        ({"levels": list(range(21))}, "at most 20 contour lines"),
        ({"observable": "motion_class"}, "unknown observable"),
        ({"ball": "lower"}, "ball must be"),
        ({"key": "0" * 32}, "compute it again"),
        ({"key": [1]}, "compute it again"),
        ({"ylog": 3}, "log of “driving amplitude”"),
        ({"stored": "none"}, "there is no stored map"),
    ],
)
def test_bad_contours_are_refused_with_one_line(client, changed, words):
    *_, memory = filled(client, SMALL, lambda x, y: x)
    body = {**CONTOURS, "key": memory.plan.hash, **changed}
    answer = client.post("/api/map/contours", json=body)
    assert answer.status_code in (413, 422)
    assert words in answer.json()["error"]
    assert "\n" not in answer.json()["error"]


def test_a_stored_map_has_contours_and_either_spacing(stored):
    folder, grid = stored
    app = make_app(Settings(stored=named([folder / "map.zarr"])))
    with TestClient(app, base_url=HOME) as client:
        body = {"stored": "map.zarr", "observable": "largest_angle", "select": {"restitution": 1}}
        values = grid.largest_angle.isel(restitution=1).values
        column = int(np.argmax(np.abs(values[1] - values[0])))
        level = float(0.7 * values[0, column] + 0.3 * values[1, column])
        about, lines = contours_of(client, body | {"levels": [level], "ylog": True})
        assert about["missing"] == 0
        wanted = np.array([grid.frequency_ratio.values[column], 0.1 * 2.0**0.3])
        corners = np.concatenate([np.stack(line[1:], axis=1) for line in lines])
        assert np.abs(corners - wanted).max(axis=1).min() < 1e-12
        _, blocks = asked(client, {"stored": "map.zarr", "ylog": True, "xlog": False})
        about, sides = blocks[0]
        assert about["y"]["log"]
        assert not about["x"]["log"]
        np.testing.assert_allclose(sides["y_edges"][1:3], [0.02**0.5, 0.08**0.5])


def file_of(client, kind, body):
    answer = client.post(f"/download/map.{kind}", json=body)
    assert answer.status_code == 200, answer.text
    return answer.content, answer.headers


@pytest.mark.parametrize("kind", ["csv", "nc", "zarr"])
def test_a_file_of_a_map_holds_its_numbers_and_opens_again(client, kind, tmp_path):
    _, blocks = asked(client, SMALL)
    body = {"key": blocks[0][0]["key"], "observable": "mean_energy"}
    content, headers = file_of(client, kind, body)
    assert headers["X-Points-Missing"] == "0"
    (name,) = re.findall(r'filename="(.+)"', headers["Content-Disposition"])
    path = tmp_path / name
    path.write_bytes(content)
    if kind == "zarr":
        with zipfile.ZipFile(path) as archive:
            archive.extractall(tmp_path)
        path = tmp_path / name.removesuffix(".zip")
        assert store_status(path)["complete"]
    grid = ll.load(path)
    names: dict = {}
    exec(blocks[0][0]["python"], names)
    wanted = names["grid"]
    xr.testing.assert_identical(grid.load().drop_attrs(), wanted.drop_attrs())
    for each in grid.variables:
        assert grid[each].attrs["units"] == wanted[each].attrs["units"]
    assert grid.attrs["plan_hash"] == wanted.attrs["plan_hash"]
    if kind == "csv":
        assert "# column drive_amplitude [m]: driving amplitude" in content.decode()
    # The application opens it as well, with the same cells.
    with TestClient(make_app(Settings(stored=named([path]))), base_url=HOME) as other:
        _, again = asked(other, {"stored": path.name, "observable": "mean_energy"})
    found = [gathered(each)[0]["mean_energy"] for each in (blocks, again)]
    np.testing.assert_array_equal(*found)


def test_a_file_of_an_unfinished_map_says_so(client, tmp_path):
    *_, memory = filled(client, SMALL, lambda x, y: x)
    memory.arrays["status"][0, :3] = -1
    body = {"key": memory.plan.hash, "observable": "mean_energy"}
    content, headers = file_of(client, "nc", body)
    assert headers["X-Points-Missing"] == "3"
    assert "_unfinished.nc" in headers["Content-Disposition"]
    (tmp_path / "map.nc").write_bytes(content)
    told = ll.load(tmp_path / "map.nc").attrs["unfinished"]
    assert told == "3 of 126 points are not computed: status is -1 there"
    svg, _ = file_of(client, "svg", body)
    assert b"not computed yet (3)" in svg
    answer = client.post("/download/map.zarr", json=body)
    assert answer.status_code == 422
    assert "3 points are not computed yet" in answer.json()["error"]


def test_a_picture_of_a_map_has_axes_colour_bar_curves_and_contours(client):
    axis = {"name": "drive_amplitude", "low": 0.01, "high": 0.45, "log": True}
    *_, memory = filled(client, SMALL | {"y": axis}, lambda x, y: x * (1.0 + y))
    body = {"key": memory.plan.hash, "observable": "mean_energy", "ylog": True}
    contours = {**body, "levels": [1.25, 2.5]}
    body |= {"overlays": ["tongue", "lift_off"], "scale": "magma", "limits": [0.0, 8.0]}
    body |= {"trials": TRIALS, "contours": contours}
    svg, headers = file_of(client, "svg", body)
    assert headers["Content-Type"] == "image/svg+xml"
    text = svg.decode()
    for words in (
        "frequency",
        "driving amplitude",
        "mean of the total energy",
        "Mathieu tongue",
        "lift-off",
    ):
        assert words in text, words
    # Two lines, each with its ground; their values are drawn as curves too.
    without, _ = file_of(client, "svg", body | {"contours": None})
    assert text.count('style="fill: none') - without.decode().count('style="fill: none') >= 4
    png, _ = file_of(client, "png", body)
    assert png.startswith(b"\x89PNG")


@pytest.mark.parametrize(
    "kind, changed, words",
    [
        ("exe", {}, "a map is stored as csv, nc, png, svg, zarr"),
        ("png", {"scale": "jet"}, "unknown scale 'jet'"),
        ("png", {"limits": [1]}, "limits must be two numbers"),
        ("png", {"overlays": "tongue"}, "overlays must be a list"),
        ("png", {"overlays": ["tongues"]}, "unknown overlay"),
        ("png", {"trials": 3}, "trials must be the text"),
        ("csv", {"key": None}, "compute it again"),
        ("csv", {"key": "x", "observable": 3}, "observable must be a text"),
    ],
)
def test_a_bad_file_of_a_map_is_refused_with_one_line(client, kind, changed, words):
    *_, memory = filled(client, SMALL, lambda x, y: x)
    body = {"key": memory.plan.hash, "observable": "mean_energy", **changed}
    answer = client.post(f"/download/map.{kind}", json=body)
    assert answer.status_code == 422
    assert words in answer.json()["error"]
    assert "\n" not in answer.json()["error"]


@pytest.mark.parametrize("kind", ["csv", "nc", "zarr", "png"])
def test_a_stored_map_can_be_downloaded(stored, kind, tmp_path):
    folder, grid = stored
    for name in ("map.zarr", "map.nc"):
        with TestClient(make_app(Settings(stored=named([folder / name]))), base_url=HOME) as client:
            body = {"stored": name, "observable": "largest_angle", "select": {"restitution": 1}}
            content, headers = file_of(client, kind, body)
        if kind == "png":
            continue
        path = tmp_path / re.findall(r'filename="(.+)"', headers["Content-Disposition"])[0]
        path.write_bytes(content)
        if kind == "zarr":
            with zipfile.ZipFile(path) as archive:
                archive.extractall(tmp_path)
            path = path.with_suffix("")
        xr.testing.assert_equal(ll.load(path).load(), grid.load())
