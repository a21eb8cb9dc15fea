"""What a hand keeps of the last minute, in a real browser."""

from __future__ import annotations

import pytest

from app_pages import PLAYER, next_run, stored_run
from held_pages import open_held, wait_for_toy


def keep(page, *, key=None, seconds=0.5):
    """Keep what the toy did; a key is pressed before if asked."""
    if key:
        page.keyboard.press(key)
    wait_for_toy(page, f"toy.time > {seconds}")
    page.get_by_role("button", name="Keep the last minute").click()
    page.get_by_text("the motion of the last").wait_for()
    page.wait_for_function(f"() => !{PLAYER}.clock.lead && {PLAYER}.motion")


def test_what_knobs_did_is_a_run_with_a_link(page, tmp_path):
    open_held(page)
    keep(page, key="2", seconds=1)
    page.get_by_text("Its parameters and its link reproduce it").wait_for()
    assert "drive=staged_harmonic" in page.url
    # In the units that fields show first.
    assert "drive_amplitudes=3.4+cm%2C+3.4+cm&" in page.url
    assert "toy.hand" not in page.url
    page.wait_for_selector("[data-runs]")
    end = page.evaluate(f"() => {PLAYER}.motion.end")
    run = stored_run(page, tmp_path)
    assert run.attrs["drive"] == "staged_harmonic"
    assert float(run["time"][-1]) == pytest.approx(end)
    page.reload()
    page.wait_for_selector("[data-runs]")
    assert page.evaluate(f"() => {PLAYER}.motion.end") == pytest.approx(end)


def test_what_a_hand_did_is_shown_as_it_was(page, tmp_path):
    open_held(page)
    keep(page, key="p", seconds=1)
    page.get_by_text(
        "A hand took part, so neither parameters nor a link can reproduce it"
    ).wait_for()
    assert page.evaluate(f"() => {PLAYER}.motion.about.by_hand")
    page.get_by_text("Energy and more curves").click()
    page.get_by_text("the hand", exact=True).wait_for()
    run = stored_run(page, tmp_path)
    assert float(run["noise_work"][-1]) > 0
    # What would be another run is not offered.
    assert not page.get_by_role("button", name="Scenario", exact=False).is_visible()
    assert not page.get_by_role("button", name="NetCDF").is_visible()
    # Whoever changes a parameter gets a run of these parameters.
    with next_run(page):
        page.get_by_label("How far the hand moves, slider").press("ArrowRight")
    assert not page.evaluate(f"() => {PLAYER}.motion.about.by_hand")


def test_no_link_from_a_motion_by_hand_opens_another_motion_in_silence(page):
    open_held(page)
    keep(page, key="p", seconds=1)
    link = page.url
    assert "drive_amplitude" in link
    warning = page.get_by_text("no link can reproduce. This is another motion")
    # Another motion here is no other one than was asked for.
    with next_run(page):
        page.get_by_role("button", name="Reset").click()
    page.wait_for_function("() => !location.search.includes('toy.kept')")
    assert not page.get_by_text("the motion of the last").is_visible()
    assert not warning.is_visible()
    # This page still has it.
    page.go_back()
    page.get_by_text("the motion of the last").wait_for()
    page.wait_for_function(f"() => {PLAYER}.motion.about.by_hand")
    assert not warning.is_visible()
    page.goto("about:blank")
    page.goto(link)
    page.wait_for_selector("[data-runs]")
    warning.wait_for()
    page.wait_for_function("() => !location.search.includes('toy.kept')")
    with next_run(page):
        page.get_by_label("How far the hand moves, slider").press("ArrowRight")
    warning.wait_for(state="detached")


def test_a_reset_leads_from_a_kept_run_to_the_toy(page):
    open_held(page)
    keep(page, seconds=1)
    page.wait_for_selector("[data-runs]")
    assert "drive=staged_harmonic" in page.url or "drive=harmonic" in page.url
    with next_run(page):
        page.get_by_role("button", name="Reset").click()
    assert page.get_by_label("How far the hand moves, slider").is_visible()


def test_what_was_kept_can_be_pinned_and_taken_again(page):
    open_held(page)
    keep(page, key="p", seconds=1)
    page.wait_for_selector("[data-runs]")
    page.get_by_role("button", name="Pin this run").click()
    page.get_by_role("button", name="Hold it yourself").click()
    wait_for_toy(page, "toy?.time > 0.3")
    page.get_by_role("button", name="Hold it yourself").click()
    page.wait_for_function(f"() => !{PLAYER}.clock.lead && {PLAYER}.pinned?.about.by_hand")


def test_a_second_thing_that_is_kept_takes_the_place_of_the_first(page):
    open_held(page)
    keep(page, key="p", seconds=1)
    page.get_by_text("A hand took part").wait_for()
    page.get_by_role("button", name="Hold it yourself").click()
    wait_for_toy(page, "toy?.time > 0.3")
    page.get_by_role("button", name="Keep the last minute").click()
    page.get_by_text("Its parameters and its link reproduce it").wait_for()
    page.wait_for_function(f"() => {PLAYER}.motion && !{PLAYER}.motion.about.by_hand")


def test_a_run_that_is_refused_leaves_no_hand_on_the_stage(page):
    open_held(page)
    page.evaluate(
        """() => {
          const { page: { store } } = window.latolato.views.toy;
          const { "toy.hand": _, ...extra } = store.state.extra;
          store.set({ options: { ...store.state.options, radius: "90 cm" }, extra });
        }"""
    )
    page.locator(".message.bad").wait_for()
    assert not page.get_by_role("button", name="Push").is_visible()
