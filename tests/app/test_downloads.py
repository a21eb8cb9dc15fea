"""Files of the run on show hold the run."""

import io
import json
import sys

import numpy as np
import pytest
from starlette.testclient import TestClient

import latolato as ll
from app_server import frames_of
from latolato.app.blocks import unpack
from latolato.app.downloads import FPS, compute, request_of
from latolato.app.run_request import RunRequest
from latolato.app.server import Settings, make_app
from latolato.io.files import load

HOME = "http://127.0.0.1:8000"
SOCKET = "ws://127.0.0.1:8000/ws/animation"
# A pair whose balls touch, in units that are not SI.
QUERY = "view=toy&scenario=fig04a_push&duration=2 s&length=90 cm&map.x=damping"


@pytest.fixture(scope="module")
def client():
    with TestClient(make_app(Settings()), base_url=HOME, headers={"origin": HOME}) as found:
        yield found


@pytest.fixture(scope="module")
def run():
    return (
        RunRequest("fig04a_push", {"duration": "2 s", "length": "90 cm"}).to_scenario().simulate()
    )


def stored(client, kind, folder):
    """Return the path of a downloaded file."""
    answer = client.get(f"/download/run.{kind}?{QUERY}")
    assert answer.status_code == 200, answer.text
    assert f'filename="latolato_fig04a_push.{kind}"' in answer.headers["content-disposition"]
    path = folder / f"run.{kind}"
    path.write_bytes(answer.content)
    return path


def test_netcdf_holds_the_run_that_python_makes(client, run, tmp_path):
    found = load(stored(client, "nc", tmp_path))
    assert set(found.variables) == set(run.variables)
    for name in ("time", "angle", "total_energy", "contact_time"):
        np.testing.assert_array_equal(found[name].values, run[name].values)
    assert list(found["contact_kind"].values) == list(run["contact_kind"].values)


def test_pictures_are_pictures(client, tmp_path):
    from PIL import Image

    with Image.open(stored(client, "png", tmp_path)) as picture:
        picture.load()
        assert picture.width > 1000
        assert len(picture.convert("RGB").getcolors(1 << 24)) > 20
    text = stored(client, "svg", tmp_path).read_text(encoding="utf-8")
    assert text.startswith("<?xml")
    assert text.rstrip().endswith("</svg>")


@pytest.mark.parametrize(
    "path, status, words",
    [
        ("run.exe?scenario=zeno", 422, "is stored as"),
        ("run.nc?scenario=fig05", 422, "is a map"),
        ("run.nc?scenario=nothing", 422, "no scenario"),
        ("run.nc?scenario=zeno&radius=9 m", 422, "radius"),
        ("run.nc?scenario=zeno&duration=1e9 s", 413, "must not exceed"),
        ("run.nc?scenario=zeno&samples=500000", 413, "at most 200000 samples"),
        ("run.csv?scenario=zeno", 422, "is stored as"),
        ("run.nc?scenario=../../etc/passwd", 422, "no scenario"),
        ("run.nc", 422, "name what to run"),
    ],
)
def test_what_cannot_be_stored_is_refused_with_one_line(client, path, status, words):
    answer = client.get(f"/download/{path}")
    assert answer.status_code == status
    assert words in answer.json()["error"]
    assert "\n" not in answer.json()["error"]


def test_nothing_stays_on_disk(client, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    client.get(f"/download/run.nc?{QUERY}")
    client.get("/download/run.png?scenario=fig02&duration=1 s")
    assert list(tmp_path.iterdir()) == []


def test_parts_of_the_address_that_belong_to_views_are_no_options():
    asked = request_of({"view": "map", "length": "1 m", "map.x": "damping"})
    assert asked == RunRequest(None, {"length": "1 m"})


def film(client, given):
    """Return all frames of the socket that makes an animation."""
    return frames_of(client, SOCKET, given)


def test_the_animation_is_a_film_of_the_run_at_the_speed_asked_for(client, tmp_path):
    av = pytest.importorskip("av", reason="needs the extra 'video'")
    given = {"scenario": "fig04a_push", "options": {"duration": "2 s"}, "speed": 2}
    *told, block, _ = film(client, given)
    assert json.loads(told[0]["text"])["state"] == "waiting"
    about, arrays = unpack(block["bytes"])
    assert about["name"] == "latolato_fig04a_push.mp4"
    with av.open(io.BytesIO(arrays["file"].tobytes())) as file:
        stream = file.streams.video[0]
        pictures = [frame.to_ndarray(format="gray") for frame in file.decode(stream)]
        assert stream.average_rate == FPS
    assert len(pictures) == 31  # 2 s at twice the speed, both ends
    assert np.abs(pictures[-1].astype(int) - pictures[0]).max() > 100


@pytest.mark.parametrize(
    "given, words",
    [
        ({"scenario": "zeno", "speed": -1}, "speed"),
        ({"scenario": "fig05", "speed": 1}, "is a map"),
    ],
)
def test_an_animation_that_cannot_be_made_is_refused(client, given, words):
    *_, refused, closed = film(client, given)
    assert words in json.loads(refused["text"])["error"]
    assert closed["type"] == "websocket.close"


def test_the_extra_that_animations_need_is_named(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(ll.InputError, match=r'pip install "\.\[video\]"'):
        compute({"scenario": "zeno", "speed": 1}, tmp_path, print)


def test_the_menu_stores_what_is_on_show(page, tmp_path):
    page.goto("/?view=toy&scenario=fig04a_push&duration=2 s&length=90 cm")
    page.wait_for_selector("[data-runs]", timeout=240_000)
    page.get_by_text("Download", exact=True).click()
    with page.expect_download() as caught:
        page.get_by_role("link", name="NetCDF").click()
    path = tmp_path / caught.value.suggested_filename
    caught.value.save_as(path)
    assert path.name == "latolato_fig04a_push.nc"
    shown = page.evaluate(
        """() => { const m = window.latolato.views.toy.player.motion;
          return [m.end, m.angle(m.balls[0], m.end)]; }"""
    )
    run = ll.load(path)
    assert run["time"].values[-1] == shown[0] == 2.0
    assert run["angle"].values[-1] == pytest.approx(shown[1], abs=1e-6)  # float32 on the way


def test_an_animation_is_made_from_the_menu_or_cancelled(page, tmp_path):
    av = pytest.importorskip("av", reason="needs the extra 'video'")
    page.goto("/?view=toy&scenario=fig02&duration=100 s")
    page.wait_for_selector("[data-runs]", timeout=240_000)
    page.get_by_text("Download", exact=True).click()
    page.get_by_role("button", name="Make an MP4").click()
    page.get_by_role("button", name="Cancel").click()
    page.get_by_role("button", name="Make an MP4").wait_for(state="visible")
    menu = page.locator(".downloads")
    menu.get_by_label("Speed").select_option("100")
    with page.expect_download(timeout=240_000) as caught:
        page.get_by_role("button", name="Make an MP4").click()
    path = tmp_path / "run.mp4"
    caught.value.save_as(path)
    with av.open(str(path)) as file:
        assert sum(1 for _ in file.decode(video=0)) == 31
