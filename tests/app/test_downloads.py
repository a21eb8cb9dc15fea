"""Files of the run on show hold the run."""

import io
import sys

import numpy as np
import pytest

import latolato as ll
from app_pages import download, open_view
from latolato.app.downloads import FPS, compute
from latolato.app.run_request import RunRequest
from latolato.core.language import speaking
from marked_texts import MARKED, texts_of, unmarked

# A pair whose balls touch, in units that are not SI.
RUN = {"scenario": "fig04a_push", "options": {"duration": "2 s", "length": "90 cm"}}


def test_netcdf_holds_the_run_that_python_makes(tmp_path):
    run = RunRequest.from_json(RUN).to_scenario().simulate()
    compute({**RUN, "kind": "nc"}, tmp_path, print)
    found = ll.load(tmp_path / "run.nc")
    assert set(found.variables) == set(run.variables)
    for name in ("time", "angle", "total_energy", "contact_time"):
        np.testing.assert_array_equal(found[name].values, run[name].values)
    assert list(found["contact_kind"].values) == list(run["contact_kind"].values)


def test_pictures_are_pictures(tmp_path):
    from PIL import Image

    _, arrays = compute({**RUN, "kind": "png"}, tmp_path, print)
    with Image.open(io.BytesIO(arrays["file"].tobytes())) as picture:
        picture.load()
        assert picture.width > 1000
        assert len(picture.convert("RGB").getcolors(1 << 24)) > 20
    about, arrays = compute({**RUN, "kind": "svg"}, tmp_path, print)
    text = arrays["file"].tobytes().decode()
    assert about["type"] == "image/svg+xml"
    assert text.startswith("<?xml")
    assert text.rstrip().endswith("</svg>")


@pytest.mark.parametrize(
    "scenario", ["fig02", "toy", "ballpair_asymmetric", "toy_strings", "fig04a_clamp"]
)
def test_every_text_of_a_picture_is_in_the_language_of_the_page(scenario, tmp_path):
    with speaking(MARKED):
        _, arrays = compute({"kind": "svg", "scenario": scenario}, tmp_path, print)
    texts = texts_of(arrays["file"].tobytes())
    assert len(texts) > 20
    assert unmarked(texts) == set()


@pytest.mark.parametrize(
    "given, words",
    [
        ({"kind": "exe"}, "is stored as csv, nc, png, svg, mp4, not as 'exe'"),
        ({"kind": "nc", "scenario": "fig05"}, "is a map"),
        ({"kind": "nc", "options": {"duration": "1e9 s"}}, "must not exceed"),
        ({"kind": "mp4", "speed": -1}, "speed"),
    ],
)
def test_what_cannot_be_stored_is_refused(given, words, tmp_path):
    with pytest.raises(ll.InputError, match=words):
        compute({**RUN, **given}, tmp_path, print)


def test_the_animation_is_a_film_of_the_run_at_the_speed_asked_for(tmp_path):
    av = pytest.importorskip("av", reason="needs the extra 'video'")
    _, arrays = compute({**RUN, "kind": "mp4", "speed": 2}, tmp_path, lambda share: None)
    with av.open(io.BytesIO(arrays["file"].tobytes())) as file:
        stream = file.streams.video[0]
        pictures = [frame.to_ndarray(format="gray") for frame in file.decode(stream)]
        assert stream.average_rate == FPS
    assert len(pictures) == 31  # 2 s at twice the speed, both ends
    assert np.abs(pictures[-1].astype(int) - pictures[0]).max() > 100


def test_the_extra_that_animations_need_is_named(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(ll.InputError, match=r'pip install "\.\[video\]"'):
        compute({**RUN, "kind": "mp4", "speed": 1}, tmp_path, print)


def test_the_menu_stores_what_is_on_show(page, tmp_path):
    open_view(page, "&scenario=fig04a_push&duration=2 s&length=90 cm")
    page.get_by_text("Download", exact=True).click()
    path = download(page.get_by_role("button", name="NetCDF"), tmp_path)
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
    open_view(page, "&scenario=fig02&duration=100 s")
    page.get_by_text("Download", exact=True).click()
    page.get_by_role("button", name="MP4").click()
    page.get_by_role("button", name="Cancel").click()
    page.get_by_role("button", name="MP4").wait_for(state="visible")
    menu = page.locator(".downloads")
    menu.get_by_label("Speed").select_option("100")
    path = download(page.get_by_role("button", name="MP4"), tmp_path)
    with av.open(str(path)) as file:
        assert sum(1 for _ in file.decode(video=0)) == 31


def test_a_second_file_is_made_after_the_first(page):
    open_view(page, "&scenario=fig04a_push&duration=20 s")
    page.get_by_text("Download", exact=True).click()
    made = []
    page.on("download", lambda file: made.append(file.suggested_filename))
    page.get_by_role("button", name="SVG").click()
    page.get_by_role("button", name="PNG").click()
    page.get_by_text("PNG is made next, after the file before it.").wait_for()
    page.get_by_text("Stored latolato_fig04a_push.png.").wait_for()
    assert made == ["latolato_fig04a_push.svg", "latolato_fig04a_push.png"]


def test_a_page_gets_pictures_in_its_language(page, tmp_path):
    open_view(page, "&scenario=fig04a_push&duration=2 s&lang=id")
    page.get_by_text("Unduh", exact=True).click()
    path = download(page.get_by_role("button", name="SVG"), tmp_path)
    assert "Sudut dan kontak" in texts_of(path.read_bytes())
