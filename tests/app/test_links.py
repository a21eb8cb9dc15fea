"""Links with parts that cannot be used, and messages on the stage, in a real browser."""

from __future__ import annotations

import pytest

from app_pages import enter, open_view

READY = "[data-runs], [data-ready], [data-pictures], [data-form]"
# Links with one part that is unknown, which comes last.
BROKEN = [
    "scenario=fig99", "lenght=1 m", "strange.thing=1", "play.speed=2", "toy.thing=1",
    "report.figur=fig02", "story.nme=why_twice", "system=rocket", "drive=rocket", "preset=fig02",
]  # fmt: skip
# Links with a value that cannot be used, or not beside the others, and words of its refusal; the
# sentences of all refusals are compared elsewhere.
REFUSED = {
    "length=3 kg": "“pivot to ball centre”", "scenario=fig02&restitution=0.5": "restitution",
    "scenario=toy&radius=40 cm": "must be at least 0 cm and below the length of 20 cm, got 40 cm",
}  # fmt: skip


# All views read links with the same code: each opens a share of the broken ones.
VIEWS = ("toy", "map", "analyse")


@pytest.mark.parametrize("view", VIEWS)
def test_a_view_names_what_it_leaves_out_of_a_link_and_shows_the_rest(page, view):
    for query in BROKEN[VIEWS.index(view) :: len(VIEWS)]:
        page.goto(f"/?view={view}&{query}&map.size=8")
        part = query.split("&")[-1]
        page.locator(".message").get_by_text(f"leaves it out: “{part}”.").wait_for()
        page.wait_for_selector(READY)
        assert page.locator(".message.bad").count() == 0, query
        assert page.locator(".error").filter(visible=True).count() == 0, query


def test_a_value_of_a_link_that_cannot_be_used_is_refused_with_a_way_back(page):
    for query, words in REFUSED.items():
        page.goto(f"/?view=toy&{query}")
        page.locator(".message.bad").get_by_text(words).wait_for()
        assert page.locator(".play").is_disabled()
        page.get_by_role("button", name="Reset to the preset").click()
        page.wait_for_selector("[data-runs]")
        assert page.locator(".play").is_enabled()
        assert page.locator(".message").count() == 0


@pytest.mark.parametrize(
    "query, words, remedy",
    [
        ("system=pendulum", "Pendulum needs “pivot to ball centre”.", "Take usual values"),
        ("system=ballpair", "Ball needs “pivot to ball centre”.", "Take usual values"),
        ("system=pendulum&length=1&mass=1", "“duration” is needed", "Take usual values"),
        (
            "system=mathieu&suspension=string",
            "belongs to system Pendulum or LatoLato or BallPair, not to Mathieu",
            "Leave it out",
        ),
        (
            "system=mathieu&suspension=string&lang=id",
            "hanya berlaku untuk sistem Bandul atau Lato-lato atau Sepasang bola, bukan Mathieu",
            "Hilangkan",
        ),
        (
            "system=latolato&length=0.2&mass=0.1&radius=0.02&duration=2&clamp_step=1ms",
            "belongs to contact clamp, not to exact",
            "Leave it out",
        ),
        (
            "system=pendulum&lang=id",
            "Bandul memerlukan “jarak titik gantung ke pusat bola”.",
            "Pakai nilai biasa",
        ),
    ],
)
def test_a_link_that_lacks_options_or_has_too_many_is_mended(page, query, words, remedy):
    page.goto(f"/?view=toy&{query}")
    page.locator(".message").get_by_text(words).wait_for()
    page.get_by_role("button", name=remedy).click()
    page.wait_for_selector("[data-runs]")
    assert page.locator(":is(.message, .error):visible").count() == 0


def test_one_sentence_names_all_parts(page):
    page.goto("/?view=nowhere&scenario=fig99&strange.thing=1.2&lenght=1")
    page.wait_for_selector("[data-runs]")
    message = page.locator(".message")
    assert message.count() == 1
    for part in ("view=nowhere", "scenario=fig99", "strange.thing=1.2", "lenght=1"):
        assert f"“{part}”" in message.inner_text()
    page.wait_for_function("() => location.search === '?view=toy'")


def test_a_sweep_opens_in_map(page):
    page.goto("/?view=toy&scenario=fig05")
    page.wait_for_function("() => location.search.includes('map.scenario=fig05')")
    page.wait_for_selector("[data-pictures]")


def test_a_message_can_be_dismissed_and_goes_when_something_else_is_chosen(page):
    for leave in (
        lambda: page.get_by_role("button", name="Dismiss this message").click(),
        lambda: page.get_by_label("Begin with").select_option("fig02"),
    ):
        open_view(page, "&lenght=1")
        leave()
        page.locator(".message").wait_for(state="detached")


@pytest.mark.parametrize(
    "query, name, text, problem, nearest",
    [
        ("", "Bounciness", "2", "“Bounciness” must be between 0 and 1, got 2", "1"),
        ("", "How far the hand moves", "99999", "must be between 0 mm and 900 mm", "900 mm"),
        ("&toy.hand=1", "Bounciness", "-1", "must be between 0 and 1", "0"),
    ],
)
def test_what_is_typed_beyond_its_range_is_refused_and_the_nearest_value_offered(
    page, query, name, text, problem, nearest
):
    page.goto(f"/?view=toy&scenario=toy&duration=4 s{query}")
    page.wait_for_selector("[data-runs], [data-ready]")
    before = page.url
    field = page.get_by_role("textbox", name=name)
    enter(field, text)
    line = page.locator(".knobs").get_by_text(problem)
    line.wait_for()
    assert field.get_attribute("aria-invalid") == "true"
    assert page.url == before
    page.get_by_role("button", name=f"Take {nearest}").click()
    line.wait_for(state="hidden")
    page.wait_for_function("(before) => location.href !== before", arg=before)
    assert field.input_value() == nearest.split()[0]
    assert field.get_attribute("aria-invalid") == "false"
    assert page.locator(".message").count() == 0


@pytest.mark.parametrize(
    "former, view", [("play", "toy"), ("live", "toy"), ("experiment", "measure")]
)
def test_a_view_of_an_older_version_goes_by_its_new_name(page, former, view):
    page.goto(f"/?view={former}")
    page.wait_for_url(f"**/?view={view}*")
