"""Toy and Map for those who hear a page or have no mouse."""

from __future__ import annotations

import base64
import re

import numpy as np
import pytest

from app_pages import enter, open_view
from browser_checks import serious_faults
from held_pages import AT_REST

GAP = 3000  # ms between sentences
CLOCK = "window.latolato.views.toy.player.clock"
# What each view shows.
TOY = "&scenario=toy"
SMALL = "&map.scenario=fig05_push&map.duration=20&map.size=8&map.observable=largest_angle"
QUERIES = {"toy": TOY, "held": TOY, "map": SMALL}
# What the page says, with the times at which it does [ms].
WATCH = """async () => {
  window.said = [];
  const line = document.querySelector(".narration");
  const { accessibility } = window.latolato.views.toy.player;
  await accessibility.load();
  const { liveRegion } = accessibility;
  new MutationObserver(() => window.said.push([liveRegion.announcedAt, line.textContent]))
    .observe(line, { childList: true, characterData: true, subtree: true });
}"""
# Listens to a run as the page plays it at 60 pictures a second, for some seconds and then without
# another picture. Returns both channels.
LISTEN = """async ({ clacks, tones, speed, playing, length }) => {
  const [{ Accessibility }, { Sound }] = await Promise.all(
    ["accessibility", "sound"].map((name) => import(`./js/player/${name}.js`)));
  const { motion } = window.latolato.views.toy.player;
  const context = new OfflineAudioContext(2, length * 48000, 48000);
  const accessibility = new Accessibility(document.createElement("canvas"), () => []);
  accessibility.sound = Object.assign(new Sound(() => context), { clacks, tones });
  accessibility.loudest = 20;
  accessibility.follow(motion);
  await accessibility.load();
  for (let k = 0; k / 60 < playing; k += 1)
    context.suspend(k / 60).then(() => {
      accessibility.move(context.currentTime * speed, true, speed);
      context.resume();
    });
  const heard = await context.startRendering();
  return [0, 1].map((channel) => {
    const bytes = new Uint8Array(heard.getChannelData(channel).buffer);
    let text = "";
    for (let i = 0; i < bytes.length; i += 8192)
      text += String.fromCharCode(...bytes.subarray(i, i + 8192));
    return btoa(text);
  });
}"""
RATE = 48000
DELAY = 0.02  # s, that of `sound.js`


def said(page):
    return page.locator(".narration").text_content()


def wait_until_said(page, text):
    page.wait_for_function(
        "(text) => document.querySelector('.narration').textContent.includes(text)", arg=text
    )


def accessible(page):
    """Nodes of the accessibility tree that are not left out."""
    session = page.context.new_cdp_session(page)
    nodes = session.send("Accessibility.getFullAXTree")["nodes"]
    session.detach()
    return [node for node in nodes if not node["ignored"]]


def text_of(node, field):
    return node.get(field, {}).get("value", "")


def test_a_run_is_told_in_a_polite_region_as_fast_as_one_can_follow(page):
    page.emulate_media(reduced_motion="reduce")  # elsewhere it plays before anybody watches
    open_view(page, TOY)
    page.evaluate(WATCH)
    page.get_by_role("button", name="Play", exact=True).click()
    wait_until_said(page, "below and above the hand in turn, 3.0 times")
    told = page.evaluate("() => window.said")
    assert [text for _, text in told] == [
        "Two balls hang from a hand that moves 6 centimetres up and down from its middle, "
        "3.0 times a second.",
        "The balls clack above the hand for the first time.",
        "The balls clack below and above the hand in turn, 3.0 times a second, without change.",
    ]
    assert np.diff([at for at, _ in told]).min() > GAP
    regions = [node for node in accessible(page)
               if {"name": "live", "value": {"type": "token", "value": "polite"}}
               in node.get("properties", [])]  # fmt: skip
    assert regions
    spoken = [text_of(node, "name") for node in accessible(page)]
    assert told[-1][1] in spoken


def test_each_turn_of_a_loop_is_told_from_its_beginning(page):
    page.emulate_media(reduced_motion="reduce")
    open_view(page, TOY)
    page.evaluate(WATCH)
    page.evaluate(f"() => {{ {CLOCK}.time = 13; }}")
    page.get_by_role("button", name="Play", exact=True).click()
    wait_until_said(page, "below and above the hand in turn")
    page.wait_for_function(f"() => {CLOCK}.time < 5")
    page.wait_for_function("() => document.querySelector('.narration').textContent === ''")
    assert page.evaluate(f"() => {CLOCK}.time") < 1
    wait_until_said(page, "clack above the hand for the first time")
    assert page.evaluate(f"() => {CLOCK}.time") > 0.9 * GAP / 1000  # it goes by frames


def test_a_pause_says_where_everything_is_and_then_is_silent(page):
    open_view(page, TOY)
    page.wait_for_function("() => window.latolato.views.toy.player.clock.time > 0.3")
    page.keyboard.press("Space")
    text = said(page)
    angle = page.evaluate(
        """() => {
          const { motion, clock } = window.latolato.views.toy.player;
          return Math.round(motion.angle(motion.balls[0], clock.time) * 180 / Math.PI);
        }"""
    )
    assert re.match(r"Paused at \d+\.\d\d seconds", text)
    assert f"The right ball is {angle} degrees to the right" in text
    stage = next(node for node in accessible(page) if "Animation" in text_of(node, "name"))
    assert text_of(stage, "description").startswith("Two balls hang")
    assert f"The left ball is {angle} degrees to the left" in text_of(stage, "description")
    page.get_by_label("Time", exact=True).fill("5000")
    page.wait_for_timeout(200)
    assert said(page) == text
    # Unless somebody asks.
    page.get_by_label("Time", exact=True).blur()
    page.keyboard.press("w")
    assert said(page) != text
    assert "clack" in said(page)


def test_a_changed_parameter_is_named(page):
    open_view(page, TOY)
    page.get_by_label("How far the hand moves, slider").fill("40")
    wait_until_said(page, "“How far the hand moves” is smaller now.")
    page.get_by_label("Begin with").select_option("kapitza")
    wait_until_said(page, "A ball hangs from a hand that moves 2 centimetres")


def test_a_toy_in_a_hand_tells_what_a_key_changes(page):
    open_view(page, TOY, view="held")
    wait_until_said(page, "clack above the hand for the first time")
    page.keyboard.press("ArrowUp")
    wait_until_said(page, "“How far the hand moves” is larger now.")
    # A key that changes nothing, at the end of what a toy takes, is no change.
    page.keyboard.press("Space")
    page.evaluate("() => window.latolato.views.toy.knobs.all.restitution.give(1)")
    wait_until_said(page, "“Bounciness” is larger now.")
    page.keyboard.press("e")
    page.wait_for_timeout(900)
    assert said(page) == "“Bounciness” is larger now."
    names = [text_of(node, "name") for node in accessible(page)]
    assert any(
        "angle [°]: right ball, left ball. The angles lie between -17" in name for name in names
    )


def test_charts_say_what_they_show(page):
    open_view(page, TOY)
    page.get_by_text("Energy and more curves").click()
    for quantity in ("angles", "energies", "powers"):
        page.wait_for_selector(f".chart[aria-label*='The {quantity} lie between']")
    names = [text_of(node, "name") for node in accessible(page)]
    assert any("The angles lie between -175 and 175 degrees." in name for name in names)
    assert any("The energies lie between 0 and" in name for name in names)
    assert any("The powers lie between" in name for name in names)


def listen(page, **how):
    """Both channels of what a page lets hear, shape (2, samples)."""
    page.mouse.click(1, 1)  # browsers are silent before
    channels = page.evaluate(LISTEN, how)
    return np.array([np.frombuffer(base64.b64decode(each), np.float32) for each in channels])


def test_every_clack_is_heard_when_balls_meet(page):
    open_view(page, TOY)
    heard = listen(page, clacks=True, tones=False, speed=0.5, playing=7.9, length=8)
    times, kinds = page.evaluate(
        """() => {
          const { arrays } = window.latolato.views.toy.player.motion.block;
          return [[...arrays.contact_time], [...arrays.contact_kind]];
        }"""
    )
    expected = np.array(times)[np.array(kinds) < 2] / 0.5 + DELAY
    expected = expected[expected < 7.8]
    loud = np.flatnonzero(np.abs(heard[0]) > 1e-3) / RATE
    starts = loud[np.diff(loud, prepend=-1.0) > 0.05]
    assert len(expected) > 15
    np.testing.assert_allclose(starts, expected, rtol=0, atol=0.005)
    assert np.abs(heard).max() < 0.9


def test_the_angle_is_heard_as_pitch_and_side(page):
    open_view(page, "&scenario=fig02&initial_angle=60%20deg&duration=10%20s")
    speed = 0.3
    heard = listen(page, clacks=False, tones=True, speed=speed, playing=8, length=9)
    for at in np.arange(0.5, 7.8, 0.37):
        inside = slice(int(at * RATE), int((at + 0.06) * RATE))
        left, right = heard[:, inside]
        louder = max(left, right, key=lambda channel: np.abs(channel).max())
        signs = np.flatnonzero(np.diff(np.signbit(louder)))
        pitch = 0.5 * RATE * (len(signs) - 1) / (signs[-1] - signs[0])
        # The tone follows within 8 ms, and a picture is 17 ms old at most.
        instants = [(at + lag) * speed for lag in (-0.025, 0.015, 0.06)]
        angles = page.evaluate(
            """(times) => {
              const { motion } = window.latolato.views.toy.player;
              return times.map((time) => motion.angle(motion.balls[0], time));
            }""",
            instants,
        )
        pitches = 220 * 2 ** (np.abs(angles) / (np.pi / 2))
        # Half a period more or less fits into what is counted.
        assert pitches.min() * 0.98 < pitch < pitches.max() * 1.02
        if min(map(abs, angles)) > 0.2:
            assert (np.abs(right).max() > np.abs(left).max()) == (angles[1] > 0)
    assert np.abs(heard[:, int(8.5 * RATE) :]).max() < 1e-4


# Counts how often the sound card is asked for. Scripts of the test count as touches of the page;
# here only keys do.
OPENED = """window.opened = 0;
const activation = { hasBeenActive: false };
addEventListener("keydown", () => { activation.hasBeenActive = true; }, true);
Object.defineProperty(navigator, "userActivation", { value: activation });
window.AudioContext = class extends window.AudioContext {
  constructor() { super(); window.opened += 1; }
};"""


def test_a_page_is_silent_until_asked_and_remembers_the_choice(page, watch):
    page.add_init_script(OPENED)
    open_view(page, TOY, view="held")
    page.wait_for_function("() => window.latolato.views.toy.hand.toy.contacts > 3")
    assert page.evaluate("() => window.opened") == 0
    page.get_by_text("Listen and read").click()
    page.get_by_label("Hear the angle").press("Space")
    page.wait_for_function("() => window.opened === 1")
    # Nobody has touched another page yet.
    other = page.context.new_page()
    watch.attach(other)
    other.add_init_script(OPENED)
    open_view(other, TOY, view="held")
    other.wait_for_function("() => window.latolato.views.toy.hand.toy.contacts > 3")
    assert other.get_by_label("Hear the angle").is_checked()
    assert not other.get_by_label("Sound", exact=True).is_checked()
    assert other.evaluate("() => window.opened") == 0
    other.keyboard.press("w")
    other.wait_for_function("() => window.opened === 1")


@pytest.mark.parametrize("view", ["toy", "held"])
def test_clacks_are_switched_on_the_stage_and_the_rest_is_folded(page, view):
    open_view(page, TOY, view)
    sound = page.locator(".stage-tools").get_by_label("Sound", exact=True)
    sound.check()
    page.wait_for_function("() => window.latolato.views.toy.player.accessibility.sound?.clacks")
    for name in ("Hear the angle", "Describe"):
        assert not page.get_by_label(name).is_visible()
    # A reader hears what is said all the same, and who turned that on sees it.
    page.get_by_text("Listen and read").click()
    page.get_by_label("Describe").check()
    page.get_by_text("Listen and read").click()
    page.keyboard.press("w")
    assert said(page).startswith("Two balls hang")
    assert page.locator(".narration").is_visible()


def pressed(page, name):
    """Press a button by the keyboard, and return what has the focus once the button is gone."""
    button = page.get_by_role("button", name=name).first
    button.focus()
    handle = button.element_handle()
    page.keyboard.press("Enter")
    page.wait_for_function(
        """button => !(button.isConnected && button.checkVisibility()) || button.disabled""",
        arg=handle,
    )
    page.wait_for_function("() => document.activeElement !== document.body")
    return page.evaluate_handle("() => document.activeElement")


def test_the_focus_stays_near_a_button_that_goes(page):
    open_view(page, TOY, "toy")
    knob = page.locator(".knob").filter(has=page.get_by_label("Bounciness", exact=False)).first
    field = knob.get_by_role("textbox")
    enter(field, "2")
    at = pressed(page, "Take 1")
    assert at.evaluate("(at, knob) => knob.contains(at)", knob.element_handle())
    # Who points beside all controls wants none, also when the one goes that had the focus.
    enter(field, "2")
    button = page.get_by_role("button", name="Take 1").first
    button.focus()
    page.locator("header.top").click(position={"x": 1, "y": 1})
    button.evaluate("button => button.remove()")
    page.wait_for_timeout(300)  # three times as long as it takes to find that it is gone
    assert page.evaluate("() => document.activeElement === document.body")


def test_the_focus_stays_on_the_page_when_work_is_cancelled(page):
    page.goto("/?view=analyse&scenario=fig02&analyse.what=basins"
              "&analyse.angle_points=300&analyse.velocity_points=300&analyse.ask=1")  # fmt: skip
    page.get_by_role("progressbar").wait_for()
    at = pressed(page, "Cancel")
    assert at.evaluate("at => at.closest('.view') !== null")


# The element that has the focus, and whether one sees that.
FOCUS = """() => {
  const { activeElement: at } = document;
  if (at === document.body) return null;
  window.walked ??= new Map();
  if (!window.walked.has(at)) window.walked.set(at, window.walked.size);
  const { outlineStyle, outlineWidth } = getComputedStyle(at);
  return [window.walked.get(at), at.outerHTML.slice(0, 90),
    outlineStyle !== "none" && parseFloat(outlineWidth) >= 1];
}"""
MISSED = """() => [...document.querySelectorAll(
    "a[href], button, input, select, textarea, summary, [tabindex='0']")]
  .filter((each) => each.checkVisibility({ visibilityProperty: true }) && !each.disabled
    && each.tabIndex >= 0 && !window.walked.has(each))
  .map((each) => each.outerHTML.slice(0, 90))"""


@pytest.mark.parametrize("view", ["toy", "held", "map"])
def test_tab_reaches_every_control_and_shows_where_it_is(page, view):
    page.emulate_media(reduced_motion="reduce")
    open_view(page, QUERIES[view], view)
    page.locator(".brand").focus()
    page.keyboard.press("Shift+Tab")
    seen = []
    for _ in range(250):
        at = page.evaluate(FOCUS)
        if at is None:
            break
        number, name, is_visible = at
        assert number == len(seen), f"the focus went back to {name}"
        assert is_visible, name
        seen.append(name)
        page.keyboard.press("Tab")
    assert len(seen) < 250
    assert "skip" in seen[0]
    assert page.evaluate(MISSED) == []


@pytest.mark.parametrize("view", ["toy", "held", "map"])
def test_a_question_mark_lists_the_keys_that_a_view_binds(page, view):
    open_view(page, QUERIES[view], view)
    page.evaluate("() => document.activeElement.blur()")
    page.keyboard.press("?")
    dialog = page.get_by_role("dialog", name="Keys of this view")
    dialog.wait_for()
    keys = " ".join(dialog.locator("kbd").all_text_contents())
    listed = {
        "toy": "Space , . W ?",
        "held": "Space ↑ ↓ → ← D ⇧ D E ⇧ E P S R C",
        "map": "← → ↓ ↑ Enter C ⇧ C + =",
    }
    assert listed[view] in keys
    assert serious_faults(page) == []
    page.keyboard.press("r")  # the view behind waits
    page.keyboard.press("Escape")
    assert dialog.count() == 0
    if view != "map":
        page.get_by_text("Listen and read").click()
    page.get_by_role("button", name="Keys", exact=True).click()
    page.get_by_role("button", name="Close").click()
    assert dialog.count() == 0


def test_a_held_toy_leaves_keys_to_what_has_the_focus(page):
    open_view(page, TOY, view="held")
    page.keyboard.press("Space")
    page.get_by_role("link", name="Toy", exact=True).focus()
    page.keyboard.press("ArrowUp")  # scrolls there
    assert (
        page.evaluate("() => window.latolato.views.toy.hand.toy.controls.drive_amplitude") == 0.06
    )
    page.get_by_text("Listen and read").click()
    page.get_by_label("Describe").focus()
    page.keyboard.press("Space")
    assert page.get_by_label("Describe").is_checked()
    assert page.evaluate("() => window.latolato.views.toy.player.clock.playing === false")


@pytest.mark.parametrize("view", ["toy", "held"])
def test_a_described_view_is_accessible_and_fits_the_screen_also_enlarged(page, view):
    open_view(page, TOY if view == "toy" else AT_REST, view)
    if view == "held":
        # Contrast is checked of what is there: of a pressed button, too.
        page.locator(".trick button[aria-pressed=true]").first.wait_for()
    page.get_by_text("Listen and read").click()
    page.get_by_label("Describe").check()
    if view == "toy":
        page.get_by_label("Arrows").check()
    page.evaluate("() => document.activeElement.blur()")
    page.keyboard.press("w")
    assert page.locator(".narration").is_visible()
    page.evaluate("async () => (await import('./js/page/dom.js')).notify('A message.')")
    # The last is a window of 1366 pixels at 200 %.
    for width, height in ((1280, 900), (390, 900), (683, 384)):
        page.set_viewport_size({"width": width, "height": height})
        for scheme in ("light", "dark"):
            page.emulate_media(color_scheme=scheme)
            page.wait_for_timeout(200)
            assert serious_faults(page) == [], (width, scheme)
        assert page.evaluate("() => document.documentElement.scrollWidth") <= width
