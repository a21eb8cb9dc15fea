"""Experiment: other frames, a stick, a region and corrections, from the page to the table."""

import json
import re

import numpy as np
import pytest
import xarray as xr

import latolato as ll
from app_pages import download
from latolato.app import STATIC
from latolato.app.experiment.description import apparatus_of, described
from latolato.core.errors import InputError
from latolato.experiment.overlay import places_of
from latolato.experiment.rules import RULES
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.synthetic.synthesise import synthesise_video
from latolato.experiment.track_table import read_table

SIZE = (320, 240)


@pytest.fixture(scope="module")
def clip(tmp_path_factory):
    """A short swing, its true table, and where the ball is in each frame."""
    path = tmp_path_factory.mktemp("clips") / "swing.mp4"
    ball = ll.Pendulum(length=0.363, mass=0.1, damping=0.01)
    run = ll.simulate(ball, initial_angle=0.6, duration=2.5)
    camera = Camera(width=SIZE[0], height=SIZE[1], fps=30.0)
    truth = synthesise_video(run, path, Scene(ball_radius=0.02), camera, seed=3)
    u, v = (truth.attrs[f"pivot_pixel_{axis}"] for axis in "uv")
    attrs = {"origin_u": u, "origin_v": v, "gravity_direction": 0.0}
    _, balls = places_of(truth.assign_attrs(attrs), SIZE)
    return path, truth, balls[:, 0]


def state(page, name):
    page.locator(f"[data-state={name}]").wait_for()


def go(page, frame):
    """Show a frame of the file and wait until the picture is there."""
    page.evaluate("frame => window.latolato.views.measure.screen.goTo(frame)", frame)
    page.wait_for_function("frame => window.latolato.views.measure.screen.frame === frame",
                           arg=frame)  # fmt: skip


def drag(page, name, place):
    """Move a handle to a place of the picture."""
    page.evaluate(
        "([name, u, v]) => window.latolato.views.measure.handles.move(name, u, v)",
        [name, *map(float, place)],
    )


def test_a_part_is_tracked_from_another_frame_and_corrected_by_hand(page, clip, tmp_path):
    path, truth, balls = clip
    page.goto("/?view=measure")
    page.get_by_label("Drop a video or a table here, or choose one").set_input_files(path)
    state(page, "setup")
    ball = page.get_by_role("button", name=re.compile("^ball"))
    go(page, 20)
    page.get_by_role("button", name="Start here").click()
    go(page, 40)
    # As the tables, the overlay and refusals: the first frame of a file is frame 0.
    page.get_by_text("frame 40 (0 to 74)").wait_for()
    assert ball.count() == 0  # the handles are those of the first frame
    page.get_by_role("button", name="Mark pivot and balls here").click()
    drag(page, "ball_1", balls[40])
    page.get_by_text("Pivot and balls are marked in frame 40. Frames 20 to 74 are used.").wait_for()

    page.get_by_text("More", exact=True).last.click()
    page.get_by_label("a stick of known length is in the picture").check()
    drag(page, "stick_1", (20.0, 40.0))
    drag(page, "stick_2", (20.0, 200.0))
    page.get_by_text("More", exact=True).last.click()
    page.get_by_role("button", name="Track", exact=True).click()
    # What hides the field is opened.
    page.get_by_text(re.compile("^“length of the stick” is missing")).wait_for()
    centimetres = 1e2 * 160.0 * truth.attrs["metres_per_pixel"]
    page.get_by_role("textbox", name="length of the stick").fill(str(centimetres))
    page.keyboard.press("Enter")
    page.get_by_label("look for balls only in part of the picture").check()
    drag(page, "region_1", (0.0, 60.0))
    page.get_by_role("button", name="Track", exact=True).click()
    state(page, "result")

    table = read_table(download(page.get_by_role("link", name="Table (CSV)"), tmp_path))
    assert table.frame.values.tolist() == list(range(20, 75))
    assert table.attrs["click_frame"] == 40
    assert table.attrs["scale_source"] == "stick"
    assert table.attrs["length"] == pytest.approx(0.363, rel=0.02)
    assert table.attrs["region"].startswith("0,60,")
    np.testing.assert_allclose(table["angle_1"], truth["angle_1"][20:75], atol=6e-3)

    # A frame is corrected, taken back, and corrected again.
    page.get_by_role("button", name="Correct by hand").click()
    for _ in range(2):
        go(page, 50)
        drag(page, "ball_1", balls[50] + [3.0, 0.0])
        page.get_by_role("button", name="frame 50, ball", exact=True).wait_for()
        if _ == 0:
            page.get_by_role("button", name="Remove frame 50, ball").click()
            assert page.get_by_role("button", name=re.compile("^frame 50")).count() == 0
    page.locator(".clip-tools").get_by_role("button", name="Track again").click()
    state(page, "tracking")
    state(page, "result")
    page.get_by_text("by hand 1").wait_for()
    corrected = read_table(download(page.get_by_role("link", name="Table (CSV)"), tmp_path))
    assert np.flatnonzero(corrected.flag_1.values == "manual").tolist() == [30]
    assert abs(float(corrected.angle_1[30] - table.angle_1[30])) > 0.01
    assert page.get_by_role("button", name="Next doubtful frame").is_disabled()


def test_sentences_call_parameters_as_their_fields_and_buttons(page):
    # Some sentences are others on pages.
    own = json.loads((STATIC / "languages" / "en.json").read_text())["rules"]
    shown = [rule._asdict() | own.get(name, {}) for name, rule in RULES.items()]
    texts = [text for rule in shown for text in rule.values() if "{@" in text]
    page.goto("/?view=measure")
    page.get_by_label("Drop a video or a table here, or choose one").wait_for(state="attached")
    said = page.evaluate(
        """async texts => {
          const { sentenceInLanguage } = await import("/js/page/refusals.js");
          const rule = { name: "", part: "rule", values: {} };
          return texts.map(text => sentenceInLanguage({ ...rule, text }));
        }""",
        texts,
    )
    assert "copy it again, or use the part before that (“End here”)" in said
    # With quotes for the name, and for the word to which it is set.
    names = [re.findall(r"{@(\w+)(=[a-z]\w*)?", text) for text in texts]
    for text, each in zip(said, names, strict=True):
        assert text.count("“") == sum(2 if word else 1 for _, word in each), text
    assert sum(map(len, names)) > 20


@pytest.mark.parametrize(
    "value, match",
    [
        ([], "must be an object"),
        ({"lenght": "1 m"}, "unknown name 'lenght'"),
        ({"length": "36 parsec"}, "length must be given in m"),
        ({"length": "nan m"}, "length must be a number in m"),
        ({"mass": [1]}, "mass must be a text or a number"),
        ({"pivot": [1]}, "pivot must be a column and a row"),
        ({"pivot": "12"}, "pivot must be a column and a row"),
        ({"balls": [[1, 2]] * 3}, "one place or two"),
        ({"balls": [[1, float("inf")]]}, "balls must be a column and a row"),
        ({"shape": "cube"}, "shape must be 'disc' or 'template'"),
        ({"region": [1, 2, 3]}, "region must be left, top, right and bottom"),
        ({"stick": [[1, 2]]}, "stick must be two places"),
        ({"click_frame": -1}, "frame must lie in"),
        ({"first_frame": 1.5}, "frame must be a whole number"),
        ({"corrections": [[1, 2, 3]]}, "corrections must be frame, ball, column and row"),
        ({"corrections": "all"}, "corrections must be a list"),
        ({"stick_length": "-1 m"}, r"stick_length must lie in \(0"),
        ({"radius": "0 mm"}, r"radius must lie in \(0"),
        ({"mass": 0}, r"mass must lie in \(0"),
        ({"damping": "-1"}, r"damping must lie in \[0"),
        ({"restitution": "1.5"}, "restitution must lie in"),
        ({"length": "1e400"}, "length must be a number in m"),
        ({"length": "1e30 cm"}, r"length must lie in \(0, 1000\] m"),
    ],
)
def test_what_a_page_says_of_a_clip_is_checked(value, match):
    with pytest.raises(InputError, match=match):
        described(value)


@pytest.mark.parametrize(
    "given, sigma", [({}, 2e-3), ({"length": "36 cm", "length_sigma": "0.5 mm"}, 5e-4)]
)
def test_a_length_is_as_uncertain_as_its_scale_unless_it_was_measured(given, sigma):
    attributes = {"length": 0.36, "length_sigma": 2e-3}
    table = xr.Dataset(attrs={} if given else attributes)
    apparatus = apparatus_of(described(given), table)
    assert (apparatus.length, apparatus.length_sigma) == (0.36, sigma)
