"""Experiment in a real browser: from a dropped table to a decay, mended by clicks where needed."""

import json
import re

import numpy as np
import pytest

import latolato as ll
from app_pages import download, enter
from browser_checks import assert_panels_have_room, serious_faults
from latolato.app import STATIC
from spreadsheets import workbook
from track_tables import noise

LENGTH = 0.5
TIME = np.arange(0.0, 16.0, 0.02)
DROP = "Drop a video or a table here, or choose one"


@pytest.fixture(scope="module")
def run():
    """A free swing; its angle [rad] and angular velocity [rad/s]."""
    swing = ll.Pendulum(length=LENGTH, mass=0.1, damping=0.004)
    return ll.simulate(swing, initial_angle=0.4, times=TIME)


@pytest.fixture(scope="module")
def angle(run):
    return run.angle.values + noise(len(TIME), seed=1)


def written(path, head, *columns, delimiter=","):
    np.savetxt(path, np.column_stack(columns), "%.6f", delimiter, header=head, comments="",
               encoding="utf-8")  # fmt: skip
    return path


def dropped(page, path, query=""):
    """Drop a file on the page and wait until it was looked at."""
    page.goto(f"/?view=measure{query}")
    page.locator("input[type=file]").set_input_files(path)
    page.locator("[data-state=setup]").wait_for()


def used(page, name="Use this table"):
    page.get_by_role("button", name=name).click()
    page.locator("[data-state=result]").wait_for()


def found_length(page):
    answer = page.locator("[data-answer=length]")
    return float(answer.get_attribute("data-value")) / 100.0


def refusal(page):
    return page.locator(".clip-form [role=alert]").filter(visible=True).first


def test_an_export_of_tracker_with_two_tracks_needs_no_click_but_the_pivot(page, angle, tmp_path):
    x, y = LENGTH * np.sin(angle), -LENGTH * np.cos(angle)
    head = "#multi:\n\tright ball\t\tleft ball\t\t\nt\tx\ty\tx\ty"
    path = written(tmp_path / "toy.txt", head, TIME, x, y, -x, y, delimiter="\t")
    page.set_viewport_size({"width": 390, "height": 844})
    page.goto("/?view=measure")
    # A file that is dragged onto the page, as with a mouse.
    page.get_by_label(DROP).wait_for()
    page.evaluate(
        """([text, name]) => {
          const given = new DataTransfer();
          given.items.add(new File([text], name));
          document.querySelector(".measure").dispatchEvent(
            new DragEvent("drop", { dataTransfer: given, bubbles: true, cancelable: true }));
        }""",
        [path.read_text("utf-8"), path.name],
    )
    page.get_by_text("Tracker export, 2 tracks: right ball, left ball").wait_for()
    page.locator("[data-state=setup]").wait_for()
    heads = page.locator(".recognised th select:visible")
    chosen = heads.evaluate_all("all => all.map((each) => each.selectedOptions[0].textContent)")
    assert [each for each in chosen if each not in ("s", "m")] == [
        "time", "x of ball 1", "y of ball 1", "x of ball 2", "y of ball 2",
    ]  # fmt: skip
    assert page.locator(".recognised tbody tr").count() == 5
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 390
    assert page.locator(".recognised .table-scroll").evaluate("e => e.scrollWidth > e.clientWidth")
    assert serious_faults(page) == []
    # No tool of a video is offered.
    for name in ("Track", "Start here", "As found"):
        assert page.get_by_role("button", name=name, exact=True).filter(visible=True).count() == 0

    page.get_by_role("button", name="Use this table").click()
    page.get_by_text("angles from positions need the pivot").wait_for()
    for axis in "xy":
        field = page.get_by_label(f"{axis} of the pivot", exact=True).filter(visible=True).last
        enter(field, "0")
    used(page)
    assert page.locator(".clip-box").filter(visible=True).count() == 0
    angles = page.evaluate(
        "() => [0, 1].map((b) => Array.from(window.latolato.views.measure.session.clip.track"
        ".values('angle', b)))"
    )
    np.testing.assert_allclose(angles, [angle, -angle], atol=1e-5)
    assert page.locator(".curves").filter(visible=True).locator("canvas").count() >= 1
    assert serious_faults(page) == []
    assert_panels_have_room(page)


def test_a_recording_of_phyphox_gives_the_angle_of_its_gyroscope(page, run, tmp_path):
    head = '"Time (s)","Gyroscope x (rad/s)","Gyroscope y (rad/s)"'
    rate = run.angular_velocity.values + noise(len(TIME), seed=2) + 0.02
    path = written(tmp_path / "phone.csv", head, TIME, noise(len(TIME), seed=3), rate)
    dropped(page, path)
    page.get_by_text("Phyphox export", exact=False).wait_for()
    # By the keyboard alone.
    role = page.get_by_label("what Gyroscope y is")
    role.focus()
    page.keyboard.type("angular")
    assert role.evaluate("e => e.value") == "angular_velocity_1"
    assert role.evaluate("e => e === document.activeElement")
    used(page)
    assert found_length(page) == pytest.approx(LENGTH, rel=0.01)
    # A fit is done again with other values, and the set-up changed after that.
    mass = page.get_by_label("mass of one ball", exact=False).first
    enter(mass, "100")
    page.locator("[data-fit=decay]").get_by_role("button", name="Fit again").click()
    damping = page.locator("[data-fit=decay] [data-name=damping]").first
    damping.wait_for()
    assert float(damping.get_attribute("data-value")) == pytest.approx(0.004, rel=0.1)
    page.get_by_role("button", name="Correct the set-up").click()
    page.locator(".recognised").filter(visible=True).wait_for()
    page.get_by_role("button", name="Back to the result").click()
    page.locator("[data-answer=length]").wait_for()


def test_a_german_table_without_units_is_mended_by_clicks(page, angle, tmp_path):
    from playwright.sync_api import expect

    path = written(tmp_path / "Messung.csv", "Nr;Zeit;Ausschlag", np.arange(len(TIME)), TIME,
                   np.degrees(angle), delimiter=";")  # fmt: skip
    path.write_text(path.read_text("utf-8").replace(".", ","), "utf-8")
    dropped(page, path)
    page.get_by_text(
        "is not clear which column is “angle of ball 1”; it has Nr, Zeit, Ausschlag."
    ).wait_for()
    assert page.get_by_label("what Zeit is").evaluate("e => e.value") == "time"
    assert page.get_by_label("what Nr is").evaluate("e => e.value") == ""
    page.get_by_label("what Ausschlag is").select_option("angle of ball 1")
    page.get_by_text("Choose the unit of “Zeit”, “Ausschlag” in the table first.").wait_for()
    assert page.get_by_role("button", name="Use this table").is_disabled()
    # A role that another column takes is taken from the first.
    page.get_by_label("what Nr is").select_option("time")
    assert page.get_by_label("what Zeit is").evaluate("e => e.value") == ""
    page.get_by_label("what Zeit is").select_option("time")
    page.get_by_label("unit of Zeit").select_option("s")
    page.get_by_label("unit of Ausschlag").select_option("deg")
    use = page.get_by_role("button", name="Use this table")
    chosen = page.locator(".pick[aria-pressed=true]")
    chosen.hover()
    expect(chosen).to_have_css("color", use.evaluate("e => getComputedStyle(e).color"))
    # Whoever uses the keyboard does not lose their place when the button goes.
    focused = use.evaluate("e => { e.click(); return document.activeElement.textContent; }")
    assert focused == "Cancel"
    page.locator("[data-state=result]").wait_for()
    # The first control after the one that went.
    expect(page.get_by_label("pivot to ball centre").first).to_be_focused()
    assert page.get_by_role("alert").filter(visible=True).count() == 0
    assert found_length(page) == pytest.approx(LENGTH, rel=2e-3)
    assert page.locator("[data-fit=decay]").count() == 1
    page.locator("summary", has_text="Python and command line").filter(visible=True).click()
    lines = page.locator(".clip-exports pre").all_inner_texts()
    assert "'time': 'Zeit [s]', 'angle_1': 'Ausschlag [deg]'" in lines[0]
    assert lines[1].startswith("latolato import Messung.csv --column 'time=Zeit [s]'")
    stored = download(page.get_by_role("link", name="Table (CSV)"), tmp_path)
    assert stored.name == "Messung.track.csv"
    assert page.get_by_text("Video with overlay").count() == 0
    page.get_by_role("button", name="Open in Toy").click()
    page.wait_for_selector("[data-runs]")
    options = page.evaluate("() => window.latolato.views.toy.player.motion.about.options")
    assert options["length"] == pytest.approx(LENGTH, rel=2e-3)


def test_places_of_ball_and_pivot_are_known_by_their_names(page, angle, tmp_path):
    x, y = 100.0 * LENGTH * np.sin(angle) + 12.0, 50.0 - 100.0 * LENGTH * np.cos(angle)
    still = np.full_like(TIME, 12.0), np.full_like(TIME, 50.0)
    head = "t (s),x ball (cm),y ball (cm),x pivot (cm),y pivot (cm)"
    dropped(page, written(tmp_path / "places.csv", head, TIME, x, y, *still))
    chosen = page.locator(".recognised th select:visible").evaluate_all(
        "all => all.map((each) => each.selectedOptions[0].textContent)"
    )
    assert [each for each in chosen if each not in ("s", "cm")] == [
        "time", "x of ball 1", "y of ball 1", "x of the pivot", "y of the pivot",
    ]  # fmt: skip
    used(page)
    assert found_length(page) == pytest.approx(LENGTH, rel=2e-3)


@pytest.mark.parametrize("width, language", [(1366, "en"), (390, "id")])
def test_a_table_of_times_alone_cannot_be_used(page, angle, tmp_path, width, language):
    path = STATIC / "languages" / f"{language}.json"
    texts = json.loads(path.read_text("utf-8"))["strings"]
    page.set_viewport_size({"width": width, "height": 844})
    table = written(tmp_path / "places.csv", "t (s),u (cm),v (cm)", TIME, angle, angle)
    dropped(page, table, f"&lang={language}")
    use = page.get_by_role("button", name=texts["sheetUse"])
    page.get_by_text(texts["rolesMissing"]).wait_for()
    assert use.is_disabled()
    # One coordinate of a ball is not enough.
    page.get_by_label(texts["roleOf"].replace("{name}", "u")).select_option("ball_1_x")
    name = f"\u201c{texts['role_ball_1_y']}\u201d"
    page.get_by_text(texts["roleMissing"].replace("{names}", name)).wait_for()
    assert use.is_disabled()
    page.get_by_label(texts["roleOf"].replace("{name}", "v")).select_option("ball_1_y")
    assert use.is_enabled()
    assert page.evaluate("() => document.documentElement.scrollWidth") <= width
    assert serious_faults(page) == []


@pytest.mark.parametrize("width, language", [(1366, "en"), (390, "id")])
def test_a_question_about_units_stands_before_the_numbers(page, angle, tmp_path, width, language):
    page.set_viewport_size({"width": width, "height": 844})
    texts = json.loads((STATIC / "languages" / f"{language}.json").read_text("utf-8"))["strings"]
    for scale, unit, words in (
        (1.0, 180.0 / np.pi, "unit wrong?" if language == "en" else "satuannya salah?"),
        (1e3, 1.0, "milliseconds?" if language == "en" else "milisekon?"),
    ):
        path = written(tmp_path / "swing.csv", "t (s),angle (rad)", scale * TIME, unit * angle)
        dropped(page, path, f"&lang={language}")
        used(page, texts["sheetUse"])
        assert page.locator(".finding strong").inner_text().endswith(words)
        assert page.locator("[data-answer]").count() == 0
        assert page.evaluate("() => document.documentElement.scrollWidth") <= width


def test_a_unit_of_something_else_is_chosen_before_the_table_is_used(page, angle, tmp_path):
    path = written(tmp_path / "mass.csv", "t (s),theta (kg)", TIME, angle)
    dropped(page, path)
    page.get_by_text("Choose the unit of “theta” in the table first.").wait_for()
    assert page.get_by_role("button", name="Use this table").is_disabled()
    units = page.get_by_label("unit of theta")
    assert units.locator("option:checked").inner_text() == "unit?"
    assert "kg" not in units.inner_text()
    assert page.locator("th").get_by_text("[kg]").is_visible()
    # German for degrees, elsewhere for gons.
    path = written(tmp_path / "swing.csv", "t (s),Winkel (Grad)", TIME, np.degrees(angle))
    dropped(page, path)
    page.get_by_text("Choose the unit of “Winkel” in the table first.").wait_for()
    assert page.get_by_label("unit of Winkel").get_attribute("aria-invalid") == "true"
    page.get_by_label("unit of Winkel").select_option("deg")
    used(page)
    assert found_length(page) == pytest.approx(LENGTH, rel=2e-3)


def test_a_table_that_is_refused_calls_its_columns_as_the_page_does(page, angle, tmp_path):
    x, y = LENGTH * np.sin(angle), -LENGTH * np.cos(angle)
    path = written(tmp_path / "places.csv", "t (s),x (m),y (m)", TIME, x, y)
    dropped(page, path)
    page.get_by_role("button", name="Use this table").click()
    page.get_by_text(
        "angles from positions need the pivot; give x and y of the “pivot”, or its columns “x of "
        "the pivot” and “y of the pivot”"
    ).wait_for()


def test_frames_ask_for_their_rate_and_directions_for_theirs(page, angle, tmp_path):
    head = "frame,theta (deg)"
    path = written(tmp_path / "frames.csv", head, 50.0 * TIME, np.degrees(angle) - 90.0)
    dropped(page, path)
    page.get_by_text("It has frame numbers and no time.").wait_for()
    rate = page.get_by_label("frames per second")
    enter(rate, "50")
    page.get_by_label("angles counted from").select_option("the x axis")
    used(page)
    assert found_length(page) == pytest.approx(LENGTH, rel=2e-3)


def test_a_doubt_about_a_table_calls_columns_and_choices_as_the_page_does(page, angle, tmp_path):
    path = written(tmp_path / "above.csv", "t (s),theta (deg)", TIME, np.degrees(angle) + 180.0)
    dropped(page, path)
    used(page)
    page.get_by_text(
        "“angle of ball 1” is above the pivot in most rows: is it counted from the x axis (“angles "
        "counted from”)?"
    ).wait_for()


def test_a_spreadsheet_of_frames_without_numbers_asks_for_their_rate(page, angle, tmp_path):
    pytest.importorskip("python_calamine", reason="needs the extra 'tables'")
    rows = [["theta (deg)", "remark"], *([float(each), "ok"] for each in np.degrees(angle))]
    path = tmp_path / "swing.xlsx"
    path.write_bytes(workbook(Sheet1=rows))
    dropped(page, path)
    page.get_by_text("is not clear which column is “time”; it has").wait_for()
    rate = page.get_by_label("frames per second")
    enter(rate, "50")
    used(page)
    assert found_length(page) == pytest.approx(LENGTH, rel=2e-3)


def test_the_decimal_sign_is_asked_where_the_file_is_refused_without_it(page, angle, tmp_path):
    path = tmp_path / "whole.csv"  # of milliseconds and degrees, without names
    whole = [[round(1e3 * t), round(d)] for t, d in zip(TIME, np.degrees(angle), strict=True)]
    path.write_text("".join(f"{t},{d}\n" for t, d in whole), "utf-8")
    page.goto("/?view=measure")
    page.locator("input[type=file]").set_input_files(path)
    refusal = page.get_by_role("alert").filter(has_text="delimiter and decimal sign at once")
    refusal.wait_for()
    page.get_by_label("decimal sign").filter(visible=True).select_option("point")
    page.locator("[data-state=setup]").wait_for()
    page.get_by_label("what 1 is").wait_for()
    assert refusal.filter(visible=True).count() == 0
    assert serious_faults(page) == []


def test_times_on_a_clock_need_no_unit(page, angle, tmp_path):
    body = "".join(
        f"0:{int(t) // 60:02d}:{t % 60:06.3f};{d:.4f}\n"
        for t, d in zip(TIME, np.degrees(angle), strict=True)
    )
    path = tmp_path / "clock.csv"
    path.write_text("time;theta (deg)\n" + body, "utf-8")
    dropped(page, path)
    assert page.get_by_label("unit of time").filter(visible=True).count() == 0
    assert page.get_by_label("frames per second").filter(visible=True).count() == 0
    used(page)
    assert found_length(page) == pytest.approx(LENGTH, rel=2e-3)


def test_a_file_that_is_no_table_is_refused_in_words(page, tmp_path):
    path = tmp_path / "notes.csv"
    path.write_text("We measured on Monday.\nIt rained.\n")
    page.goto("/?view=measure")
    page.get_by_label(DROP).set_input_files(path)
    page.get_by_role("alert").filter(has_text="notes.csv: it has no rows of numbers").wait_for()
    assert page.locator(".clip-form h2").inner_text() == "notes.csv"
    page.get_by_role("button", name="Remove notes.csv").click()
    page.locator("[data-state=empty]").wait_for()


def test_an_empty_file_is_refused_with_a_way_on(page, watch, tmp_path):
    path = tmp_path / "empty.csv"
    path.touch()
    page.goto("/?view=measure")
    page.get_by_label(DROP).set_input_files(path)
    page.get_by_role("alert").filter(has_text="it is empty; choose another file").wait_for()
    assert page.get_by_label(DROP).is_visible()
    watch.faults.clear()  # the server refuses the upload


def test_a_refused_fit_names_fields_that_fit_a_part(page, angle, tmp_path):
    broken = np.where(TIME < 6.0, angle, angle[::-1])
    dropped(page, written(tmp_path / "two.csv", "t (s),theta (rad)", TIME, broken))
    used(page)
    page.get_by_text("give “fit from” and “fit up to” to fit a part").wait_for()
    assert not page.get_by_text("kept for inspection").is_visible()
    page.get_by_role("button", name="Correct the set-up").click()
    enter(page.get_by_label("fit up to", exact=True), "5.9")
    used(page)
    assert found_length(page) == pytest.approx(LENGTH, rel=1e-2)


def test_a_doubted_record_shows_the_doubt_first(page, angle, tmp_path):
    kept = (TIME < 8.0) | (TIME > 8.73)
    time = np.where(TIME < 8.0, TIME, TIME - 0.73)[kept]
    dropped(page, written(tmp_path / "cut.csv", "t (s),theta (rad)", time, angle[kept]))
    used(page)
    answer = page.locator(".finding")
    assert "does not describe" in answer.locator("strong").inner_text()
    assert page.locator("[data-fit=decay]").count() == 0


def test_a_table_is_shown_in_another_language(page, angle, tmp_path):
    texts = json.loads((STATIC / "languages" / "id.json").read_text("utf-8"))["strings"]
    path = written(tmp_path / "swing.csv", "t (s),theta (rad)", TIME, angle)
    page.set_viewport_size({"width": 390, "height": 844})
    dropped(page, path, "&lang=id")
    assert page.locator(".recognised h2").inner_text() == "Tabel"
    head = page.get_by_label(texts["roleOf"].replace("{name}", "theta"))
    assert head.evaluate("e => e.selectedOptions[0].textContent") == texts["role_angle_1"]
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 390
    used(page, texts["sheetUse"])
    assert found_length(page) == pytest.approx(LENGTH, rel=2e-3)
    finding = page.locator(".finding").inner_text()
    assert re.match(r"Bandul berayun \d,\d+\s±\s0,\d+ kali per sekon dan kehilangan", finding)
    assert page.locator("[data-fit=decay] h2").inner_text() == "Peluruhan"
    assert page.get_by_label("ketidakpastian panjang").first.is_visible()
