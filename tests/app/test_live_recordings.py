"""Recordings of Live in a real browser: what they are in Play, what lasts, and files."""

from __future__ import annotations

import json

import pytest

import latolato as ll
from live_pages import PATIENCE, of_toy, open_live, wait_for_toy


def record(page, *, key=None, seconds=0.5):
    """Record the toy; a key is pressed meanwhile if asked."""
    page.get_by_role("button", name="Record").click()
    wait_for_toy(page, "toy.recording?.duration > 0.1")
    if key:
        page.keyboard.press(key)
    wait_for_toy(page, f"toy.recording?.duration > {seconds}")
    page.get_by_role("button", name="Stop").click()
    page.get_by_text("Recorded ").wait_for()


def end_of_play(page):
    """The last instant of the run that Play shows."""
    page.wait_for_selector("[data-runs]", timeout=PATIENCE)
    return page.evaluate("() => window.latolato.views.play.player.clock.end")


def test_a_recording_opens_in_play_as_a_run(page, tmp_path):
    open_live(page)
    record(page, key="2")
    page.get_by_text("reproduce the motion").wait_for()
    for button, name in (("CSV", "live.csv"), ("CSV of contacts", "live.contacts.csv")):
        with page.expect_download() as caught:
            page.get_by_role("button", name=button, exact=True).click()
        assert caught.value.suggested_filename == name
        caught.value.save_as(tmp_path / name)
    run = ll.load(tmp_path / "live.csv")
    assert run.attrs["drive"] == "staged_harmonic"
    page.get_by_role("button", name="Open in Play").click()
    page.wait_for_selector("[data-runs]", timeout=PATIENCE)
    assert "drive=staged_harmonic" in page.url
    end = page.evaluate("() => window.latolato.views.play.player.clock.end")
    assert end == pytest.approx(run["time"].values[-1])


def test_a_recording_with_a_push_opens_as_it_was_kept(page):
    open_live(page)
    record(page, key="p")
    page.get_by_text("A hand took part").wait_for()
    page.get_by_role("button", name="Open in Play").click()
    page.wait_for_selector("[data-runs]", timeout=PATIENCE)
    page.get_by_text("Energy and more curves").click()
    page.get_by_text("the hand", exact=True).wait_for()
    assert page.evaluate("() => window.latolato.views.play.player.motion.about.by_hand")
    # Whoever changes a parameter gets a run of these parameters.
    runs = page.locator("[data-runs]").get_attribute("data-runs")
    page.get_by_label("How far the hand moves, slider").press("ArrowRight")
    page.wait_for_function(
        "n => document.querySelector('[data-runs]').dataset.runs !== n", arg=runs
    )
    assert not page.evaluate("() => window.latolato.views.play.player.motion.about.by_hand")


def test_a_recording_ends_when_it_is_as_long_as_it_may_be(page):
    open_live(page)
    page.get_by_role("button", name="Record").click()
    wait_for_toy(page, "toy.recording?.duration > 0.1")
    page.evaluate(
        """() => Object.defineProperty(window.latolato.views.live.toy.recording, "isFull",
          { get: () => true })"""
    )
    page.get_by_role("button", name="Open in Play").wait_for()
    assert of_toy(page, "recording") is None


def test_a_recording_outlives_the_page(page):
    open_live(page)
    record(page, key="p")
    page.get_by_role("button", name="Open in Play").click()
    end = end_of_play(page)
    page.reload()
    assert end_of_play(page) == end
    assert page.evaluate("() => window.latolato.views.play.player.motion.about.by_hand")
    open_live(page)
    page.get_by_text("Recordings in this browser: 1").click()
    page.get_by_role("button", name="Open in Play").click()
    assert end_of_play(page) == end
    open_live(page)
    page.get_by_text("Recordings in this browser: 1").click()
    page.get_by_role("button", name="Delete").click()
    page.get_by_text("Recordings in this browser: 0").wait_for()
    assert not page.get_by_role("button", name="Open in Play").is_visible()


def test_a_recording_that_is_gone_leads_on_to_the_run(page):
    page.goto("/?view=play&scenario=fig02&play.recording=nothing")
    page.wait_for_selector("[data-runs]", timeout=PATIENCE)
    page.get_by_text("does not have that recording any more").wait_for()
    page.wait_for_function("() => !location.search.includes('play.recording')")
    page.get_by_role("button", name="Open Live").click()
    page.wait_for_selector("[data-ready]", timeout=PATIENCE)


def save(page, path):
    """Save the chosen recording as a file."""
    with page.expect_download() as caught:
        page.get_by_role("button", name="Save", exact=True).click()
    assert caught.value.suggested_filename.startswith("latolato 20")
    caught.value.save_as(path)


def open_file(page, path):
    page.locator("input[type=file]").set_input_files(path)


def test_a_file_of_a_recording_opens_as_it_was(page, tmp_path):
    open_live(page)
    record(page, key="p")
    path = tmp_path / "recording.json"
    save(page, path)
    block = """async () => {
      const { shelf } = await import("./js/shared/storage.js");
      const [{ id }] = await shelf.list();
      const { about, arrays, shapes } = await shelf.block(id);
      return JSON.stringify([about, shapes, Object.entries(arrays).map(([name, values]) =>
        [name, values.constructor.name, [...values].map(String)])]);
    }"""
    before = json.loads(page.evaluate(block))
    page.get_by_role("button", name="Delete").click()
    page.get_by_text("Recordings in this browser: 0").wait_for()
    open_file(page, path)
    page.get_by_text("“recording.json” is now among the recordings.").wait_for()
    about, *arrays = json.loads(page.evaluate(block))
    assert arrays == before[1:]
    assert {**before[0], **about} == before[0]
    page.get_by_role("button", name="Open in Play").click()
    end_of_play(page)
    page.get_by_text("A hand took part").wait_for()


def test_a_file_of_a_recording_that_is_a_run_opens_as_this_run(page, tmp_path):
    open_live(page)
    record(page)
    path = tmp_path / "recording.json"
    save(page, path)
    open_file(page, path)
    page.get_by_text("is now among the recordings.").wait_for()
    page.get_by_role("button", name="Open in Play").click()
    end_of_play(page)
    assert "drive=harmonic" in page.url


def test_files_that_are_no_recordings_are_refused_in_a_sentence(page, tmp_path):
    open_live(page)
    record(page)
    good = tmp_path / "good.json"
    save(page, good)
    text = good.read_text()
    data = json.loads(text)
    without = {name: array for name, array in data["arrays"].items() if name != "angle"}
    shorter = {**data["arrays"], "time": {"shape": [2], "values": [0, 1]}}
    for content, sentence in {
        "a,b\n1,2\n": "It is not a recording of latolato.",
        '{"name": "latolato"}': "It is not a recording of latolato.",
        "": "It is not a recording of latolato.",
        text[: len(text) // 2]: "but part of it is missing",
        json.dumps({**data, "arrays": without}): "but part of it is missing",
        json.dumps({**data, "arrays": shorter}): "but part of it is missing",
        json.dumps({**data, "about": None}): "but part of it is missing",
        json.dumps({**data, "format": 99}): "It was made by a newer latolato.",
    }.items():
        path = tmp_path / "bad.json"
        path.write_text(content)
        open_file(page, path)
        page.get_by_text("“bad.json” was not opened.").filter(has_text=sentence).wait_for()
        page.evaluate("() => { window.latolato.views.live.keeper.text.textContent = ''; }")
    page.get_by_text("Recordings in this browser: 1").wait_for()


def test_a_browser_that_keeps_nothing_says_so(page):
    page.add_init_script("Object.defineProperty(window, 'indexedDB', { value: undefined })")
    open_live(page)
    record(page, key="p")
    page.get_by_text("This browser did not keep it").wait_for()
    page.get_by_text("Recordings in this browser: 1").wait_for()
    page.get_by_role("button", name="Open in Play").click()
    end_of_play(page)
    page.get_by_text("A hand took part").wait_for()


def test_the_oldest_recordings_make_room(page):
    open_live(page)
    record(page, key="p")
    page.evaluate(
        """async () => {
          const { MOST_KEPT, shelf } = await import("./js/shared/storage.js");
          const block = await shelf.block((await shelf.list())[0].id);
          for (let k = 1; k < MOST_KEPT; k += 1)
            await shelf.put({ created: k, duration: k, options: null }, block);
        }"""
    )
    record(page)
    page.get_by_text("The oldest recordings were deleted").wait_for()
    page.get_by_text("Recordings in this browser: 20").wait_for()
    oldest = page.evaluate(
        """async () => {
          const { MOST_BYTES, shelf } = await import("./js/shared/storage.js");
          const block = await shelf.block((await shelf.list())[0].id);
          const large = { ...block, arrays: { time: new Float64Array(MOST_BYTES / 16) } };
          for (const created of [1e13, 2e13, 3e13])
            await shelf.put({ created, duration: 1, options: null }, large);
          return (await shelf.list()).map(({ created }) => created);
        }"""
    )
    assert oldest == [3e13, 2e13]
