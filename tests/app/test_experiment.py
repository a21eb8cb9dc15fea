"""Experiment in a real browser: from an uploaded video to its damping, drawn where it is."""

import re

import numpy as np
import pytest

import latolato as ll
from app_pages import download, enter
from browser_checks import serious_faults
from latolato.experiment.synthetic.scene import Camera, Scene
from latolato.experiment.synthetic.synthesise import synthesise_video
from latolato.experiment.track_table import read_table

BALL = ll.Pendulum(length=0.363, mass=0.10804, damping=0.01)


@pytest.fixture(scope="module")
def clip(tmp_path_factory):
    """A short free swing as a camera sees it, and its true table."""
    path = tmp_path_factory.mktemp("clips") / "swing.mp4"
    run = ll.simulate(BALL, initial_angle=0.6, duration=4.5)
    camera = Camera(width=480, height=360, fps=30.0)
    truth = synthesise_video(run, path, Scene(ball_radius=0.02), camera, seed=3)
    return path, truth


def state(page, name):
    page.locator(f"[data-state={name}]").wait_for()


def uploaded(page, path):
    page.goto("/?view=measure")
    page.get_by_label("Drop a video or a table here, or choose one").set_input_files(path)
    state(page, "setup")


def fill(page, label, text):
    field = page.get_by_label(label, exact=False).first
    enter(field, text)


DRAWN = """async frame => {
  const { screen } = window.latolato.views.measure;
  const { clock, video } = screen;
  screen.isMarked = screen.hasGhost = false;
  if (clock.index !== frame) await new Promise(done => {
    // The clock may be there before the picture.
    const look = (_, { mediaTime }) => {
      if (clock.media.findLastIndex(time => time <= mediaTime + 2e-4) === frame) done();
      else video.requestVideoFrameCallback(look);
    };
    video.requestVideoFrameCallback(look);
    clock.go(frame);
  });
  while (video.seeking || video.readyState < 2) await new Promise(requestAnimationFrame);
  screen.draw();
  const { canvas, drawn, size, track } = screen;
  const context = new OffscreenCanvas(canvas.width, canvas.height)
    .getContext("2d", { willReadFrequently: true });
  context.drawImage(canvas, 0, 0);
  const colour = (x, y) => [...context.getImageData(Math.round(x), Math.round(y), 1, 1).data];
  const [at] = drawn.balls;
  const radius = track.radius * canvas.width / size.width;
  const ring = Array.from({ length: 12 }, (_, k) => [Math.cos(k * Math.PI / 6),
    Math.sin(k * Math.PI / 6)]);
  return { frame: drawn.frame, at, ghost: drawn.ghosts[0], scale: canvas.width / size.width,
    inside: ring.map(([c, s]) => colour(at.x + 0.75 * radius * c, at.y + 0.75 * radius * s)),
    outside: ring.map(([c, s]) => colour(at.x + 1.3 * radius * c, at.y + 1.3 * radius * s)) };
}"""


def orange(pixel):
    """Whether a pixel is of the ball rather than of wall, rod or block."""
    red, green, blue, _ = pixel
    return red - blue > 60 and red > green + 20


def test_an_uploaded_video_gives_its_damping_and_is_drawn_frame_by_frame(page, clip, tmp_path):
    path, truth = clip
    uploaded(page, path)

    assert serious_faults(page) == []
    slider = page.get_by_role("slider", name="frame").bounding_box()
    assert slider["width"] > 0.6 * page.locator(".clip-box").bounding_box()["width"]

    # Handles: found by themselves, moved by keys, and put back.
    handle = page.get_by_role("button", name=re.compile("^pivot: column"))
    column = round(truth.attrs["pivot_pixel_u"])
    found = int(re.search(r"column (\d+)", handle.get_attribute("aria-label"))[1])
    assert abs(found - column) <= 2
    handle.focus()
    page.keyboard.press("Shift+ArrowRight")
    assert f"column {found + 10}," in handle.get_attribute("aria-label")
    box = handle.bounding_box()
    at = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(*at)
    page.mouse.down()
    page.mouse.move(at[0] + 50, at[1], steps=4)
    page.mouse.up()
    wide = page.locator(".clip-box").bounding_box()["width"]
    dragged = int(re.search(r"column (\d+)", handle.get_attribute("aria-label"))[1])
    assert abs(dragged - (found + 10 + 50 * 480 / wide)) <= 1.5
    page.get_by_role("button", name="As found").click()
    assert f"column {found}," in handle.get_attribute("aria-label")

    # Somebody may confirm a handle where it is.
    question = page.get_by_text("Found automatically. Is it right?")
    assert question.is_visible()
    handle.press("Enter")
    assert f"column {found}," in handle.get_attribute("aria-label")
    assert not question.is_visible()
    page.get_by_role("button", name="As found").click()
    assert question.is_visible()

    outside = page.get_by_label("the pivot is outside the picture")
    outside.check()
    assert page.locator(".handle.pivot").count() == 0
    outside.uncheck()
    assert f"column {found}," in handle.get_attribute("aria-label")

    for refused in ("0", "-5", "1e300"):
        fill(page, "pivot to ball centre", refused)
        # Neither nothing nor a kilometre: a length that a pendulum has.
        page.get_by_role("button", name="Take 24.5 cm", exact=True).click()
    fill(page, "pivot to ball centre", "36.3")
    fill(page, "uncertainty of the length", "0,5")
    fill(page, "radius of one ball", "wide")
    page.get_by_text("“wide” is not a number in mm").wait_for()
    assert page.get_by_role("button", name="Track", exact=True).is_disabled()
    fill(page, "radius of one ball", "20")
    fill(page, "mass of one ball", "-1")
    page.get_by_text("“mass of one ball” must be above 0 g").wait_for()
    fill(page, "uncertainty of the length", "1e30")
    page.get_by_text("must be above 0 mm and at most 1000000 mm, got 10³⁰ mm. Take 1 mm").wait_for()
    fill(page, "uncertainty of the length", "0,5")
    assert page.get_by_role("button", name="Track", exact=True).is_disabled()
    fill(page, "mass of one ball", "108.04")
    page.get_by_role("button", name="Track", exact=True).click()
    state(page, "result")

    row = page.locator("[data-fit=decay] [data-name=damping]").first
    assert float(row.get_attribute("data-value")) == pytest.approx(BALL.damping, rel=0.015)
    assert "±" in row.inner_text()
    assert "the pivot is at rest" in page.locator(".cards").inner_text()

    # The answer first, then picture, curves, numbers and what can be taken home.
    swings = BALL.natural_frequency / (2.0 * np.pi)
    answer = page.locator(".finding strong")
    assert float(answer.inner_text().split()[2]) == pytest.approx(swings, rel=0.005)
    assert "±" in answer.inner_text()
    period = page.locator("[data-answer=small_period]")
    assert float(period.get_attribute("data-value")) == pytest.approx(1.0 / swings, rel=0.005)
    assert "±" in period.inner_text()
    assert (
        "with l = 36.3441 cm: the length, 36.3 cm ± 0.5 mm,"
        in page.locator("[data-answer=gravity]").inner_text()
    )
    for width in (1366, 390):
        page.set_viewport_size({"width": width, "height": 900})
        places = (".numbers", ".finding", ".clip-box", ".cards", ".clip-exports")
        tops = [page.locator(place).first.bounding_box()["y"] for place in places]
        assert tops == sorted(tops)
    assert page.locator(".clip-form").bounding_box()["y"] > tops[3]  # on a phone
    page.set_viewport_size({"width": 1280, "height": 900})

    assert serious_faults(page) == []

    # Where the balls are drawn is where they are, in the frame that is on show.
    scale = 1.0 / truth.attrs["metres_per_pixel"]
    for frame in (0, 1, 37, 120, 119, truth.sizes["frame"] - 1):
        drawn = page.evaluate(DRAWN, frame)
        assert drawn["frame"] == frame
        x, y = (float(truth[f"ball_1_{axis}"][frame]) for axis in "xy")
        u = (truth.attrs["pivot_pixel_u"] + x * scale + 0.5) * drawn["scale"]
        v = (truth.attrs["pivot_pixel_v"] - y * scale + 0.5) * drawn["scale"]
        for at in (drawn["at"], drawn["ghost"]):
            assert np.hypot(at["x"] - u, at["y"] - v) < 1.0
        # The highlight of a shaded ball may hide its colour in places; the rod is outside.
        assert sum(map(orange, drawn["inside"])) >= 10
        assert sum(map(orange, drawn["outside"])) <= 1

    # The cursor of the curves is at the frame's time.
    page.get_by_role("button", name="One frame back").click()
    page.get_by_text(f"frame {truth.sizes['frame'] - 2} (0 to ").wait_for()
    cursor = page.evaluate("""() => {
      const { curves, screen } = window.latolato.views.measure;
      const { plot } = curves.charts[0];
      const head = plot.over.querySelector(".playhead").getBoundingClientRect();
      return head.left + 0.5 - plot.over.getBoundingClientRect().left
        - plot.valToPos(screen.clock.time, "x");
    }""")
    assert abs(cursor) <= 1.0

    kept = download(page.get_by_role("link", name="Table (CSV)"), tmp_path)
    assert kept.name == "swing.track.csv"
    table = read_table(kept)
    assert table.attrs["source"] == "swing.mp4"
    np.testing.assert_allclose(table["angle_1"], truth["angle_1"], atol=3e-3)

    page.get_by_role("button", name="Open in Toy").click()
    page.wait_for_selector("[data-runs]")
    options = page.evaluate("() => window.latolato.views.toy.player.motion.about.options")
    assert options["damping"] == pytest.approx(BALL.damping, rel=0.015)
    assert options["initial_angle"] == pytest.approx(0.6, abs=0.01)
    assert options["drive"] == "fixed_pivot"


def test_an_example_is_filmed_and_can_be_cancelled_and_removed(page):
    page.goto("/?view=measure")
    page.get_by_role("button", name="A pendulum on a driven pivot").click()
    page.get_by_role("button", name="Cancel").click()
    page.get_by_role("alert").get_by_text("Cancelled.").wait_for()
    page.get_by_role("button", name="Remove A pendulum on a driven pivot").click()
    state(page, "empty")


def test_a_damaged_video_begins_with_the_part_before_its_damage(page, clip, tmp_path):
    content = bytearray(clip[0].read_bytes())
    middle = len(content) // 2
    content[middle : middle + 600] = bytes(255 - k % 256 for k in range(600))
    path = tmp_path / "damaged.mp4"
    path.write_bytes(content)
    uploaded(page, path)
    page.get_by_text("cannot be decoded").and_(page.get_by_text("only the part before")).wait_for()
    last, count = page.evaluate("""() => {
      const { last, about } = window.latolato.views.measure.session.clip;
      return [last, about.frames];
    }""")
    assert last == count - 1
    page.get_by_role("button", name="Track").click()
    state(page, "result")


def test_a_file_that_is_no_video_is_told_in_one_line_of_the_page_s_language(page, tmp_path):
    path = tmp_path / "note.mp4"
    path.write_text("hello")
    page.goto("/?view=measure&lang=id")
    page.get_by_label("Seret video atau tabel ke sini, atau pilih satu").set_input_files(path)
    words = "note.mp4: berkas ini tidak dapat dibaca sebagai video"
    page.get_by_role("alert").filter(has_text=words).wait_for()
    page.get_by_role("button", name="Hapus note.mp4").click()
    state(page, "empty")
