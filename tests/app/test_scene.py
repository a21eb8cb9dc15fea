"""The picture of a toy: hand, trails, flashes and arrows, against runs of Python."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import latolato as ll
from app_pages import open_view

PRESETS = [name for name in ll.scenarios() if not ll.load_scenario(name).sweep]
PLAYER = "const { motion, scene, clock } = window.latolato.views.toy.player;"


def open_play(page, query):
    """Open Play with a run that stands still."""
    open_view(page, query)
    of_scene(page, "clock.pause()")


def of_scene(page, expression, argument=None):
    """What an expression of the player's `motion`, `scene` and `clock` and of `argument` says."""
    return page.evaluate(f"async (argument) => {{ {PLAYER} return {expression}; }}", argument)


# The ends of all that is drawn up to an instant, in shares of the canvas as it is then or, for
# `still`, at the start.
ENDS = """(() => {
  const { reach, still, end } = argument;
  const { width, height } = scene.canvas;
  const ends = { left: 1, right: 0, top: 1, bottom: 0 };
  const take = (x, y, r) => {
    ends.left = Math.min(ends.left, (x - r) / width);
    ends.right = Math.max(ends.right, (x + r) / width);
    ends.top = Math.min(ends.top, (y - r) / height);
    ends.bottom = Math.max(ends.bottom, (y + r) / height);
  };
  for (let k = 0; k <= 20000; k += 1) {
    const time = (k / 20000) * Math.min(end ?? Infinity, motion.end);
    scene.time = still ? 0 : time;
    const { size } = scene.scale();
    const pose = motion.pose(time);
    for (const { ball, x, y } of pose.balls) take(...scene.place(x, y), motion.radius(ball) * size);
    const hand = reach.map((each) => each * scene.fist);
    take(...scene.place(-hand[0], pose.height), 0);
    take(...scene.place(hand[1], pose.height + hand[2]), 0);
    take(...scene.place(0, pose.height - hand[3]), 0);
  }
  return ends;
})()"""


def test_nothing_of_the_motion_is_outside_of_the_canvas(page):
    for name, width in itertools.product(PRESETS, (390, 1366)):
        if width == 390:
            open_play(page, f"&scenario={name}")
        page.set_viewport_size({"width": width, "height": 768})
        page.wait_for_function("(width) => innerWidth === width", arg=width)
        reach = page.evaluate(
            """async () => {
              const { handBox } = await import("/js/player/pivot.js");
              const { left, right, high, low } = handBox(1);
              return [-left, right, high, -low];
            }"""
        )
        ends = of_scene(page, ENDS, {"reach": reach})
        assert ends["left"] >= 0, name
        assert ends["top"] >= 0, name
        assert ends["right"] <= 1, name
        assert ends["bottom"] <= 1, name
        # What is seen at first fills the canvas, however high the balls go later. One of its sides
        # is what limits its size: the rest of it is a margin of 5 % at each end.
        first = of_scene(page, "4 * 2 * Math.PI / motion.naturalFrequency")
        ends = of_scene(page, ENDS, {"reach": reach, "still": True, "end": first})
        largest = max(ends["right"] - ends["left"], ends["bottom"] - ends["top"])
        assert largest > 0.85, name


def pixel(page, expression):
    """The colour that the canvas has at a point of the plane, and what the style sheet calls it."""
    return of_scene(
        page,
        f"""(() => {{
          const [x, y] = scene.place(...{expression});
          const copy = document.createElement("canvas").getContext("2d");
          copy.drawImage(scene.canvas, Math.floor(x), Math.floor(y), 1, 1, 0, 0, 1, 1);
          const pixel = copy.getImageData(0, 0, 1, 1).data;
          const near = (paint) => [1, 3, 5].every((k, i) =>
            Math.abs(parseInt(paint.slice(k, k + 2), 16) - pixel[i]) < 4);
          return Object.keys(scene.colours).filter((name) => near(scene.colours[name]));
        }})()""",
    )


@pytest.mark.parametrize("scenario", ["toy", "kapitza", "crank_slider", "ballpair_asymmetric"])
def test_the_hand_holds_the_pivot_and_hides_no_ball(page, scenario):
    page.emulate_media(reduced_motion="reduce")
    open_play(page, f"&scenario={scenario}")
    for step, share in enumerate(np.linspace(0, 1, 40)):
        if step % 20 == 0:  # half of it in each theme
            page.emulate_media(color_scheme="dark" if step else "light")
            page.wait_for_timeout(100)
        of_scene(page, "clock.seek(argument * clock.end)", float(share))
        assert pixel(page, "[0.27 * scene.fist, scene.pose().height + 0.2 * scene.fist]") == [
            "skin"
        ]
        names = of_scene(page, "motion.balls.map((ball) => ball.name)")
        for k, name in enumerate(names):
            at = f"[scene.pose().balls[{k}].x, scene.pose().balls[{k}].y]"
            assert pixel(page, at) == ["left" if name == "left" else "right"]


@pytest.mark.parametrize("scenario", ["toy", "ballpair_asymmetric", "fig02"])
def test_a_trail_goes_through_the_places_where_the_balls_were(page, scenario):
    open_play(page, f"&scenario={scenario}")
    found = of_scene(
        page,
        """[0.05, 1.7, 4.21].map((time) => ({ time, span: 2 * Math.PI / 3 / motion.naturalFrequency,
          trail: motion.recent(time, 2 * Math.PI / 3 / motion.naturalFrequency, 48).map(
            ({ height, balls }) => [height, balls.map(({ x, y }) => [x, y])]) }))""",
    )
    case = ll.load_scenario(scenario)
    for each in found:
        time, span, trail = each["time"], each["span"], each["trail"]
        step = span / 48
        first = max(0.0, time - span)
        between = step * np.arange(math.floor(first / step) + 1, math.ceil(time / step))
        instants = np.array([first, *between, time])
        assert len(instants) == len(trail)
        run = case.simulate(times=np.unique(np.concatenate([[0.0], instants])))
        run = run.sel(time=instants, method="nearest")
        angles = np.atleast_2d(run["angle"].transpose(..., "time").values)
        if scenario == "toy":
            angles = np.vstack([angles, -angles])
        balls = of_scene(page, "motion.balls.map(({ length }) => length)")
        for k, (height, places) in enumerate(trail):
            pivot = float(run["pivot_height"].values[k])
            # Heights are linear between samples, of which a period has 100. The angles of two free
            # balls are not known at their contact, so a cubic goes on through it.
            assert height == pytest.approx(pivot, abs=1e-3 * balls[0])
            near = 2e-3 if scenario == "ballpair_asymmetric" else 1e-4
            for (x, y), angle, length in zip(places, angles[:, k], balls, strict=True):
                assert x == pytest.approx(length * math.sin(angle), abs=near * length)
                assert y == pytest.approx(pivot - length * math.cos(angle), abs=1e-3 * length)


@pytest.mark.parametrize("scenario", ["fig04a_push", "kapitza", "ballpair_asymmetric"])
def test_arrows_say_what_python_computes(page, scenario):
    open_play(page, f"&scenario={scenario}")
    case = ll.load_scenario(scenario)
    samples = of_scene(page, "[...Array(9).keys()].map((k) => 0.0113 + 0.0237 * k * motion.end)")
    run = case.simulate(times=[0.0, *samples])
    signs = set()
    for index, time in enumerate(samples, start=1):
        arrows = page.evaluate(
            f"""async (time) => {{ {PLAYER}
              const {{ arrowsAt }} = await import("/js/player/arrows.js");
              return arrowsAt(motion, time, scene.fastest); }}""",
            time,
        )
        now = run.isel(time=index)
        angles = np.atleast_1d(now["angle"].values)
        rates = np.atleast_1d(now["angular_velocity"].values)
        tensions = np.atleast_1d(now["tension"].values)
        balls = of_scene(page, "motion.balls")
        for k, ball in enumerate(balls):
            sign, length, row = ball["sign"], ball["length"], ball["row"]
            speed, weight, force = (
                next(a for a in arrows[3 * k : 3 * k + 3] if a["paint"] == paint)
                for paint in ("speed", "soft", "force")
            )
            angle, rate = sign * angles[row], sign * rates[row]
            velocity = np.array(
                [
                    length * rate * math.cos(angle),
                    length * rate * math.sin(angle) + float(now["pivot_velocity"]),
                ]
            )
            unit = of_scene(page, "0.35 * motion.longest / scene.fastest")
            # Between samples, of which a period has 100, columns are linear.
            assert [speed["dx"], speed["dy"]] == pytest.approx(
                unit * velocity, abs=0.01 * unit * np.abs(velocity).max() + 1e-3 * length
            )
            assert weight["dx"] == 0
            assert weight["dy"] < 0
            # The force of a rod that pulls points from the ball to the pivot.
            inward = np.array([-math.sin(angle), math.cos(angle)])
            along = float(np.dot([force["dx"], force["dy"]], inward))
            across = float(np.dot([force["dx"], force["dy"]], [inward[1], -inward[0]]))
            assert across == pytest.approx(0.0, abs=1e-3 * length)
            weights = tensions[row] / (ball["mass"] * case.system.gravity)
            shown = min(max(-weight["dy"] * weights, -0.8 * length), 0.8 * length)
            assert along == pytest.approx(shown, abs=0.02 * length)
            signs.add(math.copysign(1, along))
    if scenario == "kapitza":
        assert signs == {-1.0, 1.0}  # its rod is pushed as well as pulled


def test_the_key_to_the_arrows_stands_below_them(page):
    open_play(page, "&scenario=toy")
    key = page.locator(".of-arrows")
    assert key.is_hidden()
    page.get_by_label("Arrows", exact=True).check()
    key.get_by_text("force of the rod").wait_for()
    assert key.get_by_text("goes round the circle").is_visible()
    page.get_by_label("Begin with").select_option("fig02_mathieu")
    key.get_by_text("force of the rod").wait_for(state="detached")
    assert key.get_by_text("velocity of the ball").is_visible()
    page.get_by_label("Begin with").select_option("crank_slider")
    key.get_by_text("the crank that moves the hand").wait_for()
    page.get_by_label("Arrows", exact=True).uncheck()
    key.wait_for(state="hidden")


FLASH = """(() => {
  const kinds = motion.block.arrays.contact_kind;
  const k = motion.contacts.findIndex((_, k) => k >= argument && kinds[k] < 2);
  clock.seek(motion.contacts[k] - 1e-3);
  clock.seek(motion.contacts[k] + 1e-3);
  return { time: motion.contacts[k], flashes: scene.flashes.flashes };
})()"""


@pytest.mark.parametrize("scenario", ["toy", "ballpair_asymmetric"])
def test_a_clack_flashes_where_the_balls_touch(page, scenario):
    open_play(page, f"&scenario={scenario}")
    found = of_scene(page, FLASH, 20)
    flash = found["flashes"][-1]
    case = ll.load_scenario(scenario)
    run = case.simulate(times=[0.0, found["time"]]).isel(time=-1)
    pivot = float(run["pivot_height"])
    if scenario == "toy":
        angle = float(run["angle"])
        x, y = 0.0, pivot - case.system.length * math.cos(angle)
    else:
        right, left = case.system.right, case.system.left
        a, b = (float(v) for v in run["angle"])
        share = right.radius / (right.radius + left.radius)
        places = [
            (ball.length * math.sin(t), pivot - ball.length * math.cos(t))
            for ball, t in ((right, a), (left, b))
        ]
        x, y = (p + share * (q - p) for p, q in zip(*places, strict=True))
    longest = of_scene(page, "motion.longest")
    # Heights are linear between samples, of which a period has 100.
    assert (flash["x"], flash["y"]) == pytest.approx((x, y), abs=2e-3 * longest)
    assert 0 < flash["strength"] <= 1
    # It is gone soon, although the run stands still.
    page.wait_for_function("() => !window.latolato.views.toy.player.scene.flashes.flashes.length")


def test_nothing_flashes_for_who_wants_little_motion(page):
    page.emulate_media(reduced_motion="reduce")
    open_play(page, "&scenario=toy")
    assert of_scene(page, FLASH, 20)["flashes"] == []


def test_a_pinned_run_is_not_cut_off_by_a_smaller_one(page):
    open_play(page, "&scenario=toy")
    page.get_by_role("button", name="Pin this run to compare").click()
    page.get_by_label("Begin with").select_option("first_push")
    page.wait_for_function("() => /first_push/.test(location.search)")
    page.wait_for_function(f"() => {{ {PLAYER} return scene.pinned && scene.pinned !== motion; }}")
    above = of_scene(page, "scene.place(0, scene.pinned.box(scene.time).high)[1]")
    assert above >= 0


def test_a_tiny_ball_is_large_enough_to_be_seen(page):
    open_play(page, "&scenario=toy&radius=0.1 mm")
    of_scene(page, "clock.seek(0.4)")
    for away in ("2 / scene.scale().size", "-2 / scene.scale().size"):
        assert pixel(page, f"[scene.pose().balls[0].x + {away}, scene.pose().balls[0].y]") == [
            "right"
        ]


PICTURE = """async ({ title, width }) => {
  const { stagePicture, captionOf } = await import("/js/player/picture.js");
  const { motion, scene } = window.latolato.views.toy.player;
  const drawn = JSON.stringify(scene.drawn);
  const caption = captionOf(motion.about.options);
  const blob = await stagePicture(scene, { title, caption });
  const image = await createImageBitmap(blob);
  const copy = document.createElement("canvas");
  [copy.width, copy.height] = [image.width, image.height];
  const context = copy.getContext("2d", { willReadFrequently: true });
  context.drawImage(image, 0, 0);
  const ratio = window.devicePixelRatio;
  const near = (paint, pixel) => [1, 3, 5].every((k, i) =>
    Math.abs(parseInt(paint.slice(k, k + 2), 16) - pixel[i]) < 4);
  const balls = scene.drawn.map(({ x, y }, i) => near(
    motion.balls[i].name === "left" ? scene.colours.left : scene.colours.right,
    context.getImageData((2 * x) / ratio, (2 * y) / ratio, 1, 1).data));
  const stage = (2 * scene.canvas.height) / ratio;
  const strip = context.getImageData(0, stage, image.width, image.height - stage).data;
  const ground = strip.slice(0, 3).join();
  let [written, last] = [0, 0];
  for (let i = 0; i < strip.length; i += 4)
    if (strip.slice(i, i + 3).join() !== ground) {
      written += 1;
      last = Math.max(last, (i / 4) % image.width);
    }
  return { caption, type: blob.type, width: image.width, height: image.height, stage, balls,
    written, last, ground, isSame: drawn === JSON.stringify(scene.drawn),
    wanted: (2 * scene.canvas.width) / ratio };
}"""


def test_a_picture_of_the_stage_has_its_balls_and_a_caption(page):
    open_play(page, "&scenario=toy")
    of_scene(page, "clock.seek(2.34)")
    grounds = set()
    for width, scheme in itertools.product((390, 1366), ("light", "dark")):
        page.set_viewport_size({"width": width, "height": 768})
        page.emulate_media(color_scheme=scheme)
        page.wait_for_timeout(100)  # size and theme are applied, and drawn
        found = page.evaluate(PICTURE, {"title": "The toy in the hand " * 4, "width": width})
        assert found["type"] == "image/png"
        assert found["width"] == found["wanted"]
        assert found["balls"] == [True, True]
        assert found["height"] > found["stage"] + 80
        assert found["written"] > 500
        assert found["last"] < found["width"] - 20
        assert found["isSame"]
        grounds.add(found["ground"])
    assert len(grounds) == 2
    toy, drive = ll.load_scenario("toy").system, ll.load_scenario("toy").drive
    assert found["caption"].split(" · ") == [
        f"the hand moves by ± {1000 * drive.drive_amplitude:g} mm",
        f"{drive.drive_frequency / (2 * math.pi):.3g} shakes per second",
        f"restitution {toy.restitution:g}",
    ]
