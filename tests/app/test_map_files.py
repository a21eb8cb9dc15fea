"""What the server does for the view Map: it opens stored maps and makes files."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
import xarray as xr
from starlette.testclient import TestClient

import latolato as ll
from latolato.app.downloads import TYPES
from latolato.app.map import files, stored
from latolato.app.server import Settings, make_app
from latolato.core.errors import InputError
from latolato.core.language import speaking
from marked_texts import MARKED, texts_of, unmarked

HOME = "http://127.0.0.1:8000"
AXES = {"drive_amplitude": [0.05, 0.25, 0.45], "frequency_ratio": [0.5, 1.5, 2.5, 3.5]}
OWN = {
    "options": {
        "system": "latolato", "length": 1.0, "mass": 0.8, "radius": 0.1, "restitution": 1.0,
        "initial_offset": 0.05, "duration": 5.0, "tolerance": 1e-6, "drive": "harmonic",
        "drive_amplitude": 0.25, "drive_frequency": 7.0,
    },
    "sweep": {
        "axes": AXES,
        "observables": [
            {"kind": "mean_energy"}, {"kind": "crossings", "crossing_angle": 2.0},
            {"kind": "largest_angle"},
        ],
        "transient": 0.0, "transient_periods": 0.0,
    },
}  # fmt: skip
ASKED = {"observable": "mean_energy", "kind": "nc"}
TRIALS = "drive_amplitude,frequency_ratio,class\n100 mm,2,strong\n200 mm,3,none\n"


@cache
def wanted():
    """Return the sweep of the map above."""
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, restitution=1.0)
    drive = ll.Harmonic(drive_amplitude=0.25, drive_frequency=7.0)
    return ll.sweep(toy, drive, axes=AXES, duration=5.0, initial_offset=0.05)


def made(request, folder, known=None):
    """Return what is said of a file, and its bytes, without a process of its own."""
    job = files.prepare(known or {}, ASKED | request)
    folder.mkdir(exist_ok=True)
    about, arrays = files.compute(job.request, folder, lambda share: None)
    return about, arrays["file"].tobytes()


def cells_of(path, **request):
    """What is said of a stored map, and its cells."""
    return stored.compute({"path": path, **request}, path.parent, print)


@pytest.mark.parametrize("kind", ["csv", "nc"])
def test_a_file_of_a_map_holds_its_numbers_and_opens_again(kind, tmp_path):
    about, content = made({**OWN, "kind": kind}, tmp_path / "work")
    path = tmp_path / f"map.{kind}"
    path.write_bytes(content)
    grid = ll.load(path)
    xr.testing.assert_identical(grid.load().drop_attrs(), wanted().drop_attrs())
    assert grid.attrs["plan_hash"] == wanted().attrs["plan_hash"]
    assert about["type"] == TYPES[kind]
    # The application opens it as well, with the same cells.
    _, arrays = cells_of(path, observable="mean_energy")
    np.testing.assert_array_equal(arrays["values"], wanted().mean_energy.values.ravel())


def test_a_picture_of_a_map_has_axes_colour_bar_curves_and_contours(tmp_path):
    contours = {"observable": "largest_angle", "levels": [0.5, 1.5]}
    look = {"overlays": ["tongue", "lift_off"], "scale": "viridis_r", "limits": [0.1, 80.0]}
    request = {**OWN, **look, "kind": "svg", "log": True, "ylog": True, "trials": TRIALS}
    about, svg = made(request | {"contours": contours}, tmp_path)
    assert about["type"] == "image/svg+xml"
    text = svg.decode()
    for words in ("frequency", "driving amplitude", "mean of the total energy", "Mathieu tongue",
                  "lift-off"):  # fmt: skip
        assert words in text, words
    _, without = made(request, tmp_path)
    assert text.count('style="fill: none') - without.decode().count('style="fill: none') >= 4
    _, png = made({**OWN, "kind": "png"}, tmp_path)
    assert png.startswith(b"\x89PNG")


@pytest.mark.parametrize("observable", ["mean_energy", "contact_word", "motion_class", "status"])
def test_every_text_of_a_picture_of_a_map_is_in_the_language_of_the_page(observable, tmp_path):
    observables = [{"kind": kind} for kind in ("mean_energy", "contact_word", "motion_class")]
    request = {
        "options": OWN["options"] | {"suspension": "string", "drag_frame": "lab"},
        "sweep": OWN["sweep"] | {"observables": observables},
        "observable": observable, "kind": "svg", "overlays": ["tongue", "lift_off"],
        "contours": {"observable": "mean_energy", "levels": [0.25, 2.5]},
        "trials": TRIALS + "900 mm,2,weak\n", "log": True,
    }  # fmt: skip
    with speaking(MARKED):
        _, svg = made(request, tmp_path)
    texts = texts_of(svg)
    assert len(texts) > 20
    assert unmarked(texts) == set()


@pytest.mark.parametrize(
    "changed, words",
    [
        ({"stored": "none"}, "there is no stored map 'none'"),
        ({"sweep": {**OWN["sweep"], "axes": {"length": [1.0], "mass": [1.0, -1.0]}}}, r"mass\[1\]"),
        ({"options": {**OWN["options"], "length": "3 s"}}, "length must be given in m"),
        ({"kind": "svg", "overlays": ["tongues"]}, "unknown overlay"),
    ],
)  # fmt: skip
def test_a_bad_file_of_a_map_is_refused_with_one_line(changed, words, tmp_path):
    with pytest.raises(InputError, match=words) as caught:
        made({**OWN, **changed}, tmp_path)
    assert "\n" not in str(caught.value)


@pytest.fixture(scope="module")
def maps(tmp_path_factory):
    """A stored map with a third axis, as a store and as NetCDF, and what it holds."""
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
def test_a_stored_map_opens_by_its_name_only(maps, name):
    folder, grid = maps
    known = stored.named([folder / name])
    with TestClient(make_app(Settings(stored=known)), base_url=HOME) as client:
        assert client.get("/api/map/stored").json() == [name]
    job = stored.prepare(known, {"stored": name, "select": {"restitution": 1}})
    about, arrays = stored.compute(job.request, folder, print)
    wanted = grid.largest_angle.isel(restitution=1).values.ravel()
    np.testing.assert_array_equal(arrays["values"], wanted)
    assert about["stored"]["select"][0]["values"] == ["0.5", "0.9"]
    assert arrays["x_edges"].tolist() == [0.75, 1.25, 2.0, 2.75, 3.25]
    assert about["stored"]["sets"]["all"] == {"restitution": 0.9}
    assert about["stored"]["sets"]["y"] == {"drive_amplitude": [0.1, 0.2, 0.4]}
    assert about["stored"]["options"]["initial_offset"] == 0.2
    assert about["parameters"] == {
        "gravity": 9.8, "length": 1.0, "mass": 0.8, "damping": 0.0, "quadratic_damping": 0.0,
        "coulomb_damping": 0.0, "radius": 0.1, "restitution": 0.9,
    }  # fmt: skip
    assert about["has_contact"]
    with pytest.raises(InputError, match="there is no stored map"):
        stored.prepare(known, {"stored": str(folder / name)})


def test_the_streams_of_a_stored_map_are_those_of_its_points(tmp_path):
    axes = {"restitution": [0.9, 0.5], "mass": [1.0, 0.8, 0.9], "radius": [0.1, 0.05]}
    noise = ll.VelocityKicks(noise_strength=0.01, noise_stream=7)
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.1)
    run = {"duration": 1.0, "initial_offset": 0.2, "observables": ["final_angle"]}
    grid = ll.sweep(toy, axes=axes, noise=noise, store=tmp_path / "map.zarr", **run)
    about, arrays = cells_of(tmp_path / "map.zarr", select={"restitution": 1})
    # Masses and radii are sorted; points count in the order of the sweep.
    streams, sets = about["stored"]["streams"], about["stored"]["sets"]
    assert sets["y"] == {"mass": [0.8, 0.9, 1.0]}
    stream = streams["y"][1] + streams["x"][0]
    assert stream == 7 + 6 + 2 * 2 + 1
    alone = ll.simulate(
        ll.LatoLato(length=1.0, mass=0.9, radius=0.05, damping=0.1, restitution=0.5),
        noise=ll.VelocityKicks(noise_strength=0.01, noise_stream=stream),
        duration=1.0, initial_offset=0.2, times=[1.0], tolerance=1e-6,
    )  # fmt: skip
    assert float(alone.angle[-1]) == pytest.approx(arrays["values"][2 * 1 + 0], rel=1e-9)
    assert grid.sizes["mass"] == 3


def test_points_of_a_continuation_do_not_run_alone(tmp_path):
    path = tmp_path / "map.zarr"
    axes = {"drive_amplitude": [0.02, 0.03], "drive_frequency": [5.0, 6.0]}
    ll.sweep(
        ll.Pendulum(length=1.0, mass=0.8, damping=0.05), axes=axes, duration=2.0,
        initial_angle=0.1, continuation="drive_frequency", store=path,
    )  # fmt: skip
    about, _ = cells_of(path)
    assert about["stored"]["options"] is None
    assert "continues from its neighbour" in about["stored"]["reason"]


def test_a_stored_map_takes_either_spacing(maps):
    folder, _ = maps
    about, arrays = cells_of(folder / "map.zarr", ylog=True, xlog=False, select={})
    assert about["y"]["log"]
    assert not about["x"]["log"]
    np.testing.assert_allclose(arrays["y_edges"][1:3], [0.02**0.5, 0.08**0.5])


def test_what_is_no_map_cannot_be_opened(tmp_path):
    with pytest.raises(FileNotFoundError, match="there is no file or store"):
        stored.named([tmp_path / "none.zarr"])
    (tmp_path / "empty.zarr").mkdir()
    with pytest.raises(ValueError, match="not a store of a sweep"):
        stored.named([tmp_path / "empty.zarr"])


@pytest.mark.parametrize("kind", ["csv", "nc", "png"])
@pytest.mark.parametrize("name", ["map.zarr", "map.nc"])
def test_a_stored_map_can_be_downloaded(maps, kind, name, tmp_path):
    folder, grid = maps
    request = {"stored": name, "observable": "largest_angle", "select": {"restitution": 1}}
    about, content = made(
        request | {"kind": kind}, tmp_path / "work", stored.named([folder / name])
    )
    assert about["missing"] == 0
    path = tmp_path / f"map.{kind}"
    if kind == "png":
        assert content.startswith(b"\x89PNG")
        return
    path.write_bytes(content)
    xr.testing.assert_equal(ll.load(path).load(), grid.load())


def test_a_file_of_an_unfinished_map_says_so(tmp_path):
    grid = wanted().copy(deep=True)
    grid.status[0, :3] = "missing"
    grid.to_netcdf(tmp_path / "part.nc")
    known = stored.named([tmp_path / "part.nc"])
    request = {"stored": "part.nc"}
    about, content = made(request, tmp_path / "work", known)
    assert about["missing"] == 3
    (tmp_path / "again.nc").write_bytes(content)
    told = ll.load(tmp_path / "again.nc").attrs["unfinished"]
    assert told == "3 of 12 points are not computed: status is 'missing' there"
    _, svg = made(request | {"kind": "svg"}, tmp_path / "work", known)
    assert b"not computed yet (3)" in svg
