"""Shaking the toy in a hand, with simulated sensors, in a real browser."""

from __future__ import annotations

import math
import time

import pytest

import latolato as ll
from app_pages import open_view, stored_run
from browser_checks import serious_faults
from held_pages import of_toy, open_held, wait_for_toy

# A phone that is shaken with 4 cm at 19 rad/s, along its y axis, or held otherwise. Its readings
# have the times at which they were made, however late a busy page gets them.
AMPLITUDE, FREQUENCY = 0.04, 19.0
PHONE = """([amplitude, frequency, sign, axis]) => {
  let next = performance.now();
  window.phone = setInterval(() => {
    for (; next <= performance.now(); next += 16) {
      const up = 9.8 - amplitude * frequency ** 2 * Math.cos(frequency * next / 1000);
      const felt = { x: 0, y: 0, z: 0, [axis]: sign * up };
      const reading = new DeviceMotionEvent("devicemotion",
        { accelerationIncludingGravity: felt, interval: 16 });
      Object.defineProperty(reading, "timeStamp", { value: next });
      window.dispatchEvent(reading);
    }
  }, 16);
}"""
STILL = "&scenario=fig12&drive=harmonic&drive_amplitude=0%20m&drive_frequency=6%20rad/s"


@pytest.fixture(autouse=True)
def sensors(page):
    """Let pages have sensors, as a visible browser does without being asked."""
    page.context.grant_permissions(["accelerometer", "gyroscope"])
    yield
    page.context.clear_permissions()


def shake(page, sign=1, axis="y"):
    page.evaluate(PHONE, [AMPLITUDE, FREQUENCY, sign, axis])
    page.get_by_role("button", name="Shake it").click()
    page.get_by_text("Hold the phone tight and shake it").wait_for()


def test_a_phone_shakes_the_pivot_and_the_balls_fly(page):
    open_held(page, STILL)
    shake(page, -1, "z")
    assert page.get_by_role("button", name="Shake it").get_attribute("aria-pressed") == "true"
    wait_for_toy(page, "toy.time > 5", timeout=30_000)
    seen = page.evaluate(
        """async () => {
          const { toy } = window.latolato.views.toy.hand;
          const begun = toy.time;
          let [sum, count] = [0, 0];
          while (toy.time < begun + 4) {
            await new Promise(requestAnimationFrame);
            sum += toy.pivot.acceleration ** 2;
            count += 1;
          }
          return { rms: Math.sqrt(sum / count), contacts: toy.contacts };
        }"""
    )
    # The page's timers are late now and then.
    assert seen["rms"] == pytest.approx(AMPLITUDE * FREQUENCY**2 / 2**0.5, rel=0.1)
    assert seen["contacts"] > 5
    page.get_by_role("button", name="Shake it").click()
    wait_for_toy(page, "!toy.isShaken && toy.drive.isSteady")
    assert of_toy(page, "drive.cosine.amplitude") == 0.0


def test_the_sensors_of_the_browser_shake_the_pivot(page):
    sensors = page.context.new_cdp_session(page)
    kinds = ("accelerometer", "linear-acceleration", "gyroscope")
    for kind in kinds:
        sensors.send(
            "Emulation.setSensorOverrideEnabled",
            {"enabled": True, "type": kind, "metadata": {"available": True}},
        )
    open_held(page, STILL)
    page.get_by_role("button", name="Shake it").click()
    begun, highest = time.monotonic(), 0.0
    while (passed := time.monotonic() - begun) < 4.0:
        motion = -AMPLITUDE * FREQUENCY**2 * math.cos(FREQUENCY * passed)
        for kind, y in zip(kinds, (9.8 + motion, motion, 0.0), strict=True):
            sensors.send(
                "Emulation.setSensorOverrideReadings",
                {"type": kind, "reading": {"xyz": {"x": 0, "y": y, "z": 0}}},
            )
        highest = max(highest, abs(of_toy(page, "pivot.height")))
    page.get_by_text("Hold the phone tight and shake it").wait_for()
    # Readings come from here at uneven times: it is the way that is tested, not the amplitude.
    assert 0.5 * AMPLITUDE < highest < 0.13
    assert of_toy(page, "contacts") > 2


def test_a_sensor_that_falls_silent_is_told_of(page):
    open_held(page)
    shake(page)
    page.wait_for_timeout(500)
    page.evaluate("() => clearInterval(window.phone)")
    page.get_by_text("The motion sensor fell silent").wait_for()
    wait_for_toy(page, "Math.abs(toy.pivot.height) < 1e-3 && Math.abs(toy.pivot.velocity) < 1e-2")
    page.get_by_role("button", name="High").click()  # whoever wants the motor gets it
    wait_for_toy(page, "!toy.isShaken")
    assert page.get_by_role("button", name="Shake it").get_attribute("aria-pressed") == "false"


def test_a_new_toy_is_shaken_on(page):
    open_held(page)
    shake(page)
    page.evaluate("() => { window.before = window.latolato.views.toy.hand.toy; }")
    page.get_by_role("button", name="Restart").click()
    wait_for_toy(page, "toy !== window.before && toy.isShaken && toy.time > 0.2")
    page.get_by_role("link", name="Report").click()
    assert not page.evaluate("() => window.latolato.views.toy.hand.shake.isOn")


def test_a_device_without_a_sensor_offers_the_pivot(page):
    open_held(page)
    page.get_by_role("button", name="Shake it").click()
    page.get_by_text("No motion sensor responds here.").wait_for()
    assert page.get_by_role("button", name="Shake it").get_attribute("aria-pressed") == "false"
    assert serious_faults(page) == []


def test_a_refused_sensor_is_explained(page):
    open_held(page)
    button = page.get_by_role("button", name="Shake it")
    refused, none = "is not allowed here", "No motion sensor responds here."
    for script, sentence in (
        ("DeviceMotionEvent.requestPermission = async () => 'denied'", refused),
        ("delete window.DeviceMotionEvent", none),
        (
            "window.DeviceMotionEvent = { requestPermission: async () => { throw new Error(); } }",
            refused,
        ),
        ("Object.defineProperty(window, 'isSecureContext', { value: false })", "secure pages only"),
    ):
        page.evaluate(script)
        button.click()
        page.get_by_text(sentence).wait_for()
    wait_for_toy(page, "!toy.isShaken")


def test_a_setting_against_sensors_is_explained(page):
    page.add_init_script(
        "delete DeviceMotionEvent.requestPermission;"
        "Permissions.prototype.query = async () => ({ state: 'denied' })"
    )
    open_held(page)
    page.get_by_role("button", name="Shake it").click()
    page.get_by_text("is not allowed here").wait_for()


def test_a_granted_sensor_shakes_and_the_screen_stays_on(page):
    page.add_init_script(
        """DeviceMotionEvent.requestPermission = async () => "granted";
        window.locks = 0;
        const release = async () => { window.locks -= 1; };
        const request = async () => { window.locks += 1; return { release }; };
        Object.defineProperty(navigator, "wakeLock", { value: { request } });"""
    )
    open_held(page)
    shake(page)
    wait_for_toy(page, "toy.isShaken")
    assert page.evaluate("() => window.locks") == 1
    page.keyboard.press("s")
    wait_for_toy(page, "!toy.isShaken")
    assert page.evaluate("() => window.locks") == 0


def test_the_hand_can_be_dragged_and_the_cursor_says_so(page):
    open_held(page, STILL)
    box = page.get_by_role("application").bounding_box()
    x, y, size = page.evaluate(
        """() => {
          const { player: { scene }, motion } = window.latolato.views.toy.hand;
          const ratio = window.devicePixelRatio;
          return [...scene.place(0, motion.toy.pivot.height), scene.scale().size]
            .map((each) => each / ratio);
        }"""
    )
    cursor = "() => getComputedStyle(window.latolato.views.toy.player.scene.canvas).cursor"
    page.mouse.move(box["x"] + 10, box["y"] + box["height"] - 10)
    assert page.evaluate(cursor) == "auto"
    page.mouse.move(box["x"] + x, box["y"] + y)
    assert page.evaluate(cursor) == "grab"
    page.mouse.down()
    assert page.evaluate(cursor) == "grabbing"
    page.mouse.move(box["x"] + x, box["y"] + y - 0.06 * size)
    wait_for_toy(page, "Math.abs(toy.pivot.height - 0.06) < 3e-3")
    for k in range(40):
        page.mouse.move(box["x"] + x, box["y"] + y + (0.05 if k % 2 else -0.05) * size)
        page.wait_for_timeout(80)
    assert of_toy(page, "contacts") > 0
    page.mouse.move(box["x"] + x, box["y"] + y - 3 * size)
    page.get_by_text("The pivot moves at most 12 cm up and down").wait_for()
    page.mouse.up()
    wait_for_toy(page, "!toy.isShaken && Math.abs(toy.pivot.height) < 1e-3")


def test_what_is_kept_of_a_shaken_toy_has_the_motion_of_its_pivot(page, tmp_path):
    open_held(page)
    shake(page)
    wait_for_toy(page, "toy.time > 3", timeout=30_000)
    page.get_by_role("button", name="Keep the last minute").click()
    page.get_by_text(
        "The pivot was shaken, so neither parameters nor a link can reproduce it"
    ).wait_for()
    page.wait_for_selector("[data-runs]")
    run = stored_run(page, tmp_path)
    assert run.attrs["drive"] == "measured_pivot"
    assert "the pivot was shaken" in run.attrs["note"]
    height = run["pivot_height"]
    assert 0.02 < float(abs(height).max()) < 0.13
    # The heights make the same motion in Python, as long as it is regular.
    pivot = ll.MeasuredPivot(times=run["time"].values, pivot_heights=height.values)
    assert len(pivot.pivot_heights) == run.sizes["time"]
    assert page.evaluate("() => window.latolato.views.toy.player.motion.about.options.drive") == (
        "measured_pivot"
    )


@pytest.mark.parametrize("language", ["en", "id"])
def test_a_message_leaves_the_picture_of_a_phone_free(page, language):
    page.set_viewport_size({"width": 390, "height": 844})
    page.add_init_script("DeviceMotionEvent.requestPermission = async () => 'denied'")
    open_view(page, f"&lenght=1&lang={language}", view="held")
    page.evaluate("() => window.latolato.views.toy.hand.shake.toggle()")
    page.locator(".message").nth(1).wait_for()
    picture = page.locator("canvas.scene").bounding_box()
    messages = page.locator(".stage-messages").bounding_box()
    assert messages["y"] >= picture["y"] + picture["height"] - 1
    assert messages["height"] <= 0.25 * 844  # so much of the window, whatever they say
