"""Analyses in the browser: each has a form, a result or a refusal, and lines that compute it."""

import inspect
import json
import re
import shlex
import warnings

import numpy as np
import pytest
import xarray as xr
from starlette.testclient import TestClient
from typer.testing import CliRunner

import latolato as ll
from app_pages import download, enter
from app_server import frames_of
from browser_checks import assert_panels_have_room, serious_faults
from latolato.analysis import analyses
from latolato.app.analyse.answer import compute, numbers_of
from latolato.app.analyse.forms import about_request, forms, label_of
from latolato.app.analyse.request import AnalysisRequest
from latolato.app.answers import message_of
from latolato.app.run_request import RunRequest
from latolato.app.server import Settings, make_app
from latolato.cli.main import app as command_line
from latolato.core.errors import Sentence
from latolato.core.language import speaking
from latolato.io.analysis_tables import to_csv
from latolato.io.files import load
from latolato.scenario.analysis_options import options_of
from marked_texts import MARKED, texts_of, unmarked
from page_blocks import unpack

HOME = "http://127.0.0.1:8000"
SOCKET = "ws://127.0.0.1:8000/ws/analyse"
# Enough for an answer of any kind.
SMALL = {
    "points": "5",
    "angle_points": "6",
    "velocity_points": "6",
    "transient_periods": "10",
    "trajectories": "8",
    "scan_points": "4",
    "longest": "4",
    "periods": "16",
    "phases": "1",
    "settling": "5",
    "refinements": "0",
    "low": "1.9",
    "high": "2.1",
    "dwell_time": "1, 2",
    "first_frequency_ratio": "2.5, 3",
    "push": "0.1, 0.5",
    "noise_strength": "0.5",
    "parameter": "frequency_ratio",
    "drive_amplitude": "0.02 : 0.4 : 2 m",
    "frequency_ratio": "1.9 : 2.1 : 2",
}
TIMES = "\N{MULTIPLICATION SIGN}"
# What has no answer without contacts.
OF_TWO = ("impact_map", "self_start", "pair_symmetry")
# Closed forms: they need no compiled kernel.
CLOSED = {"scenario": "fig02", "analysis": "tongue_edges", "settings": {"order": "1"}}


def small(name):
    """Return small sizes for an analysis."""
    fields = forms()[name]["options"]
    if name == "bifurcation_curve":
        return {"kind": "period_doubling", "low": "0, 1.9", "high": "0.1, 2.1", "points": "5"}
    return {
        n: v
        for n, v in SMALL.items()
        if n in fields
        and not (":" in v and not fields[n]["several"])
        and not (n == "push" and not fields[n]["several"])
    }


@pytest.fixture(scope="module")
def client():
    with TestClient(make_app(Settings()), base_url=HOME, headers={"origin": HOME}) as found:
        yield found


def ask(client, given):
    """Return all frames of the socket."""
    return frames_of(client, SOCKET, given)


def test_every_analysis_has_a_form_with_all_its_options():
    found = forms()
    assert set(found) == set(analyses)
    for name, form in found.items():
        own = options_of(analyses[name])
        assert set(form["options"]) | set(form["run"]) == set(own)
        assert form["summary"]
        assert set(form["first"]) <= set(form["options"])
        for option in form["options"].values():
            assert option["description"]
            assert option["default"] in option["choices"] or not option["choices"]


def test_every_analysis_and_option_has_a_label_in_words():
    found = forms()
    assert len({form["title"] for form in found.values()}) == len(found)
    for form in found.values():
        assert "_" not in form["title"]
        for option in form["options"].values():
            assert "_" not in option["label"] + option["description"]
            assert "SI unit" not in option["description"]  # a field has a unit of its own


def test_a_label_is_that_of_a_quantity_only_in_its_unit():
    options = forms()["floquet"]["options"]
    assert options["period"]["label"] == "Period"  # drive periods, and no period of small swings
    assert forms()["tongue_edges"]["options"]["drive_amplitude"]["label"] == "Driving amplitude"


def test_ranges_hold_the_drive_of_the_scenario():
    about = about_request(RunRequest("kapitza", {}))
    ratio = 21.43
    limits = about["parameters"]["frequency_ratio"]
    assert float(limits["low"]) < ratio < float(limits["high"])
    low, high, _ = about["first"]["first_push"]["frequency_ratio"].split(":")
    assert float(low) < ratio < float(high)


@pytest.mark.parametrize("name", analyses)
def test_what_forms_begin_with_can_be_computed(name):
    about = about_request(RunRequest("fig04a_push", {}))
    form = forms()[name]["options"]
    first = about["first"][name]
    assert set(first) <= set(form)
    given = {"analysis": name, "scenario": "fig04a_push", "settings": first}
    assert "system" in AnalysisRequest.from_json(given).arguments()


@pytest.mark.parametrize("name", analyses)
def test_every_analysis_answers_in_the_language_of_the_page(name, tmp_path):
    given = {"analysis": name, "options": {"duration": "6 s"}, "settings": small(name)}
    if name == "pair_symmetry":
        given["settings"] |= {"duration": "9", "transient": "3"}
    scenario = "toy" if name in OF_TWO else "fig02"
    with warnings.catch_warnings(record=True) as caught, speaking(MARKED):
        warnings.simplefilter("always", RuntimeWarning)
        told, files = compute({**given, "scenario": scenario}, tmp_path, print)
    # Pages translate a sentence by its rule.
    doubts = [each.message.args[0] for each in caught if each.category is RuntimeWarning]
    assert [each for each in doubts if not isinstance(each, Sentence)] == []
    result = load(tmp_path / "result.nc")
    assert result.attrs["analysis"] == name
    # Whether something holds is a number, which the table of numbers puts in words.
    asked = {
        each.dtype.kind
        for each in result.variables.values()
        if str(each.attrs.get("long_name")).startswith("whether ")
    }
    assert asked <= set("bif")
    assert len(told["lines"]) > 0
    assert not any("_" in label for label, _ in told["lines"])
    assert files["png"].tobytes().startswith(b"\x89PNG")
    assert f"# analysis: {name}" in files["csv"].tobytes().decode()
    texts = texts_of(files["svg"].tobytes())
    assert len(texts) > 5
    assert unmarked([*texts, *(text for row in told["lines"] for text in row)]) == set()


def test_a_two_stage_start_that_cannot_help_says_why_and_shows_where_pushes_lead(tmp_path):
    first = about_request(RunRequest("toy", {}))["first"]["shortest_protocol"]
    given = {
        "analysis": "shortest_protocol",
        "scenario": "toy",
        "settings": {**first, "push": "1, 7"},
    }
    with pytest.warns(RuntimeWarning, match="leads to a larger motion than rest"):
        told, _ = compute(given, tmp_path, print)
    found = load(tmp_path / "result.nc")
    assert np.isfinite(found["angle_after_push"]).all()
    # What does not exist has no unit either.
    assert dict(told["lines"])["Smallest push that reaches it"] == "none"


@pytest.mark.parametrize("name", OF_TWO)
def test_an_analysis_of_contacts_is_refused_for_a_pendulum_in_one_line(client, name):
    given = {"analysis": name, "scenario": "fig02", "settings": small(name)}
    text = json.loads(ask(client, given)[-2]["text"])["error"]
    assert "\n" not in text
    assert "Pendulum" in text or "pendulum" in text


@pytest.mark.parametrize("scenario", ["toy", "fig02", "fig02_mathieu", "fig12", "toy_strings"])
def test_what_an_analysis_cannot_treat_is_known_before_anybody_asks(scenario, tmp_path):
    refused = about_request(RunRequest(scenario, {}))["refused"]
    assert 0 < len(refused) < len(analyses)
    for name, message in refused.items():
        needed = {"frequency_ratio": "2", "drive_amplitude": "0.02"}
        settings = {n: v for n, v in needed.items() if n in forms()[name]["options"]}
        given = {"analysis": name, "scenario": scenario, "settings": settings | small(name)}
        with pytest.raises(ll.InputError) as caught:
            compute(given, tmp_path, print)
        assert message_of(caught.value) == message


def test_a_page_says_at_once_what_an_analysis_cannot_treat(page):
    page.goto("/?view=analyse&scenario=toy&analyse.what=tongue_edges&analyse.ask=1")
    refusal = page.get_by_text("balls with a radius touch before they hang straight down")
    refusal.wait_for()
    assert refusal.count() == 1
    compute_button = page.get_by_role("button", name="Compute")
    assert not compute_button.is_visible()
    page.get_by_label("Analysis", exact=True).select_option("basins")
    compute_button.wait_for()
    assert not refusal.is_visible()


@pytest.mark.parametrize(
    "address, given",
    [
        ("scenario=fig12&analyse.what=floquet", "got “FrequencySchedule”"),
        ("scenario=fig12&analyse.what=floquet&lang=id", "tetapi diberikan “Frekuensi bertahap”"),
        ("scenario=kapitza&analyse.what=pair_symmetry&lang=id", "tetapi diberikan “Bandul”"),
    ],
)
def test_what_an_analysis_cannot_treat_has_its_name_on_the_page(page, address, given):
    page.goto(f"/?view=analyse&{address}")
    page.get_by_text(given).wait_for()


@pytest.mark.parametrize("scenario", ["toy", "ballpair_asymmetric"])
def test_the_motion_in_which_the_run_settles_is_a_press_away(page, scenario):
    page.goto(f"/?view=analyse&scenario={scenario}&analyse.what=floquet&analyse.ask=1")
    elsewhere = page.get_by_text("does not settle on this motion")
    elsewhere.wait_for()
    angle = re.search(r"its angle is \D?([.\d]+)°", elsewhere.inner_text())[1]
    page.get_by_role("button", name="Analyse that motion").click()
    page.wait_for_selector("[data-answers='2']")
    assert elsewhere.count() == 0
    # In the same unit, and to most of the same digits.
    assert angle[:5] in page.locator("tr", has_text="Initial angle").first.inner_text()
    assert page.locator("tr", has_text="Status").inner_text().split() == ["Status", "stable"]
    assert "initial_angular_velocity=" in page.url


def test_an_analysis_of_contacts_works_for_a_pair(tmp_path):
    given = {"analysis": "self_start", "scenario": "fig04a", "settings": {}}
    told, _ = compute(given, tmp_path, print)
    assert dict(told["lines"])["Status"] == "found"


def test_the_answer_is_what_python_gives_and_its_lines_ask_the_same(client, tmp_path):
    given = {**CLOSED, "options": {"length": "50 cm"}}
    *told, block, _ = ask(client, given)
    assert json.loads(told[0]["text"])["state"] == "waiting"
    about, arrays = unpack(block["bytes"])
    assert {"nc", "csv", "png", "svg"} <= set(arrays)
    path = tmp_path / "result.nc"
    path.write_bytes(arrays["nc"].tobytes())
    found = load(path)

    names: dict = {}
    lines = about["python"].splitlines()
    exec("\n".join(lines[:-1]), names)
    xr.testing.assert_equal(found, names["result"])

    output = tmp_path / "again.nc"
    words = [*shlex.split(about["command"])[1:], "--output", str(output)]
    told = CliRunner().invoke(command_line, words)
    assert told.exit_code == 0, told.output
    xr.testing.assert_equal(found, load(output))


@pytest.mark.parametrize("name", analyses)
def test_python_lines_pass_each_argument_once(name):
    scenario = "toy" if name in OF_TWO else "fig02"
    given = {"analysis": name, "scenario": scenario, "options": {}, "settings": small(name)}
    question = AnalysisRequest.from_json(given)
    lines = question.python(question.arguments()).splitlines()
    calls = []
    function = inspect.signature(question.function)
    names = {name: lambda *values, **named: calls.append(function.bind(*values, **named))}
    exec("\n".join(line for line in lines[:-1] if not line.startswith("from ")), names)
    (call,) = calls
    assert isinstance(call.arguments["system"], ll.Pendulum | ll.LatoLato)


@pytest.mark.parametrize("name", ["basins", "bifurcation_diagram", "first_push", "growth_rate"])
def test_the_command_on_show_has_the_arguments_of_the_answer(name, monkeypatch):
    options = {"length": "50 cm", "tolerance": "1e-7", "initial_angle": "-0.1 rad"}
    given = {"analysis": name, "scenario": "fig02", "options": options, "settings": small(name)}
    question = AnalysisRequest.from_json(given)
    seen = {}

    def catch(*_, **arguments):
        seen.update(arguments)
        raise ValueError("caught")

    from latolato.cli import analyse as analyse_command

    run = analyse_command.run
    monkeypatch.setattr(
        analyse_command,
        "run",
        lambda q, *a, **k: run(analyse_command.AnalysisCall(q.name, catch, q.own), *a, **k),
    )
    monkeypatch.setattr(
        inspect,
        "signature",
        lambda f, **k: inspect.Signature.from_callable(analyses[name] if f is catch else f, **k),
    )
    CliRunner().invoke(command_line, shlex.split(question.command())[1:])
    wanted = question.arguments()
    assert seen == wanted


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_curve_without_a_point_has_no_rows_of_nothing(tmp_path):
    settings = {"kind": "fold", "low": "0.059, 2.68", "high": "0.061, 2.7", "points": "5"}
    given = {
        "analysis": "bifurcation_curve",
        "scenario": "toy",
        "options": {},
        "settings": settings,
    }
    told, _ = compute(given, tmp_path, print)
    assert told["points"] == 0
    assert dict(told["lines"])["Status"] == "not found"
    assert "none" not in [text for _, text in told["lines"]]


def test_tables_of_an_answer_hold_its_numbers():
    found = xr.Dataset(
        {
            "share": ("kind", [0.25, 0.75], {"units": "1"}),
            "angle": (("kind", "sample"), [[1.0, 2.0], [3.0, np.nan]], {"units": "rad"}),
            "status": ((), "found"),
        },
        coords={"kind": ["a", "b"]},
        attrs={"analysis": "none"},
    )
    blocks = to_csv(found).split("\n\n")
    assert blocks[0] == "# analysis: none"
    assert blocks[1] == "# over nothing\nstatus\nfound"
    assert blocks[2] == "# over kind\nkind,share\na,0.25\nb,0.75"
    assert blocks[3].splitlines()[1:3] == ["kind,sample,angle [rad]", "a,0,1.0"]


@pytest.mark.parametrize(
    "given, words",
    [
        ({"analysis": "tongues", "scenario": "fig02"}, "unknown analysis"),
        ({**CLOSED, "settings": {"order": "one"}}, "order must be a whole number"),
        ({**CLOSED, "settings": {"drive_amplitude": "3 kg"}}, "drive_amplitude"),
        ({**CLOSED, "scenario": "nothing"}, "there is no scenario"),
        ({**CLOSED, "options": {"length": "-1 m"}}, "length"),
        ({"analysis": "self_start", "scenario": "fig04a", "settings": {"check": "yes"}}, "true or"),
        (
            {"analysis": "first_push", "scenario": "fig04a"},
            "needs frequency_ratio; give values such as 0 : 1 : 11",
        ),
        (
            {
                "analysis": "first_push",
                "scenario": "fig04a",
                "settings": {"frequency_ratio": "1 : 2 : 1000000"},
            },
            "values at most",
        ),
    ],
)
def test_a_bad_question_is_refused_in_one_line(client, given, words):
    *_, refused, closed = ask(client, given)
    text = json.loads(refused["text"])["error"]
    assert words in text
    assert "\n" not in text
    assert closed["type"] == "websocket.close"


def test_a_text_never_names_a_file(client, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ratios.csv").write_text("1.5\n2\n")
    for text in ("ratios.csv", str(tmp_path / "ratios.csv"), "ratios.csv:ratio"):
        given = {
            "analysis": "first_push",
            "scenario": "fig04a",
            "settings": {"frequency_ratio": text},
        }
        with pytest.raises(ValueError, match="frequency_ratio"):
            AnalysisRequest.from_json(given).arguments()


def test_an_analysis_is_chosen_from_the_list_and_its_result_is_shown(page, tmp_path):
    page.goto("/?view=analyse&scenario=fig02")
    page.get_by_role("heading", name="Choose an analysis").wait_for()
    page.get_by_role("link", name="Tongue edges").click()
    page.get_by_role("button", name="Compute").click()
    picture = page.get_by_role("img", name="Tongue edges")
    picture.wait_for()
    assert picture.evaluate("async i => { await i.decode(); return i.naturalWidth; }") > 300
    asked = AnalysisRequest.from_json({**CLOSED, "options": {}})
    wanted = asked.function(**asked.arguments())
    row = page.get_by_role("row", name="Lower edge of the tongue")
    assert row.inner_text().split()[-1] == f"{wanted.low:.6g}"
    path = download(page.get_by_role("button", name="NetCDF"), tmp_path)
    xr.testing.assert_equal(load(path), wanted)
    order = page.get_by_label("Order", exact=True)
    enter(order, "none")
    page.get_by_role("alert").filter(has_text="“none” is not a number").wait_for()
    assert "none" not in page.url
    assert "analyse.what=tongue_edges" in page.url
    # What is on show is of the first tongue, which the page says once the form asks for another.
    assert not page.locator(".stale").count()
    order.fill("2")
    order.press("Tab")
    page.locator(".stale").wait_for()
    order.press("Enter")
    page.wait_for_selector("[data-answers='2']")
    assert not page.locator(".stale").count()


@pytest.mark.parametrize("scenario", ["toy", "ballpair_asymmetric"])
def test_every_analysis_has_its_fields_on_the_page(page, scenario):
    page.goto(f"/?view=analyse&scenario={scenario}")
    page.get_by_role("heading", name="Choose an analysis").wait_for()
    for name, form in forms().items():
        page.get_by_label("Analysis", exact=True).select_option(name)
        page.get_by_role("heading", name=form["title"], exact=True).wait_for()
        # The fields of a pair stand in one of their own.
        fields = page.locator(".settings .field:not(.field .field)")
        assert fields.count() == len(form["options"]), name


def test_a_link_computes_at_once(page):
    page.goto("/?view=analyse&scenario=kapitza&analyse.what=inverted_limits&analyse.ask=1")
    page.get_by_role("img", name="Inverted limits").wait_for()
    page.get_by_role("button", name="Compute").click()
    page.wait_for_selector("[data-answers='2']")


def test_both_parameters_of_a_curve_are_chosen_by_their_labels(page):
    curve = "/?view=analyse&scenario=fig03a&analyse.what=bifurcation_curve"
    page.goto(f"{curve}&lang=id")
    page.get_by_label("Parameter kedua").wait_for()
    page.goto(f"{curve}&lang=en")
    first, second = (page.get_by_label(f"{which} parameter") for which in ("First", "Second"))
    first.wait_for()
    shown = [each.locator("option:checked").inner_text() for each in (first, second)]
    assert shown == ["Driving amplitude", "Driving over natural frequency"]
    second.select_option("damping")
    page.wait_for_url("**analyse.parameters=drive_amplitude*damping**")
    # Other parameters have limits of their own.
    damping = float(page.get_by_label("High", exact=True).input_value().split(",")[1])
    assert 0.0 < damping < 1.0
    first.select_option("damping")
    page.get_by_role("button", name="Compute").click()
    page.get_by_text("got “Linear damping coefficient”, “Linear damping coefficient”").wait_for()


def test_a_bifurcation_curve_begins_with_the_kind_that_its_motion_is_near(page):
    page.goto("/?view=analyse&scenario=fig03a&analyse.what=bifurcation_curve&analyse.points=10"
              "&analyse.ask=1")  # fmt: skip
    page.wait_for_selector("[data-answers='1']")
    kind = page.get_by_label("Kind", exact=True)
    assert kind.locator("option:checked").inner_text() == "automatic"
    assert page.get_by_role("row", name="Status").inner_text().split()[-1] == "complete"
    reading = page.get_by_text("On the curve one periodic motion is at a bifurcation")
    assert reading.is_visible()
    kind.select_option("fold")
    page.get_by_role("button", name="Compute").click()
    page.wait_for_selector("[data-answers='2']")
    page.get_by_text("“Driving amplitude” = 0.05 m, “Driving over natural frequency” = 1.91663, "
                     "where period doubling is the nearest bifurcation of the motion: choose that "
                     "as “Kind”").wait_for()  # fmt: skip
    assert reading.count() == 0


TOPS = """places => places.map(place => {
  const found = document.querySelector(place);
  return found?.checkVisibility() ? found.getBoundingClientRect().top : null;
})"""


@pytest.mark.parametrize("width", [1366, 390])
def test_the_picture_comes_first_then_how_to_read_it_then_numbers(page, width):
    page.set_viewport_size({"width": width, "height": 844})
    page.goto("/?view=analyse&scenario=fig02&analyse.what=tongue_edges")
    page.get_by_text("Its picture will appear here").wait_for()
    page.get_by_role("button", name="Compute").click()
    page.wait_for_selector("[data-answers]")
    places = page.evaluate(TOPS, [".picture", ".reading-of", ".numbers"])
    assert places == sorted(places)
    room = "e => e.getBoundingClientRect().right - e.parentElement.getBoundingClientRect().right"
    assert page.locator(".picture img").evaluate(room) <= 0
    if width == 390:  # below the form, but in view
        assert 0 <= places[0] < 844
    assert serious_faults(page) == []
    assert_panels_have_room(page)


def test_an_unknown_analysis_and_setting_of_the_address_are_told_and_left_out(page):
    page.goto("/?view=analyse&scenario=kapitza&analyse.what=nonsense&analyse.wrong=1")
    page.get_by_text("leaves it out: “analyse.what=nonsense”, “analyse.wrong=1”.").wait_for()
    page.get_by_role("heading", name="Choose an analysis").wait_for()


def test_a_second_press_asks_for_nothing_else(page):
    page.goto("/?view=analyse&scenario=fig02&analyse.what=floquet")
    page.get_by_role("button", name="Compute").dblclick()
    page.wait_for_selector("[data-answered=floquet]")


def test_a_value_that_a_field_offers_is_taken(page, watch):
    page.goto("/?view=analyse&scenario=fig02&analyse.what=basins&analyse.angle_tolerance=7"
              "&analyse.ask=1")  # fmt: skip
    field = page.get_by_role("textbox", name="Angle tolerance")
    page.wait_for_selector(".error:visible")
    watch.faults.clear()  # the server refuses the request
    enter(field, "1e9")
    page.get_by_text("must be above 0° and at most 57.29°, got").wait_for()
    page.get_by_role("button", name="Take 57.29°").click()
    assert field.input_value() == "57.29"


def test_work_that_was_stopped_leaves_no_result(page):
    page.goto("/?view=analyse&scenario=fig02&analyse.what=basins"
              "&analyse.angle_points=300&analyse.velocity_points=300&analyse.ask=1")  # fmt: skip
    page.get_by_role("progressbar").wait_for()
    page.get_by_role("button", name="Cancel").click()
    page.get_by_text("Its picture will appear here").wait_for()
    assert not page.get_by_role("progressbar").is_visible()


def test_a_refusal_stands_beside_its_field_in_the_words_of_the_page(page):
    page.goto("/?view=analyse&scenario=fig02&analyse.what=basins&analyse.angle_tolerance=7"
              "&analyse.ask=1")  # fmt: skip
    alert = page.get_by_role("alert").filter(
        has_text="“Angle tolerance” must be above 0° and at most 57.29°, got 401.07"
    )
    alert.wait_for()
    field = page.get_by_role("textbox", name="Angle tolerance")
    assert field.get_attribute("aria-invalid") == "true"
    assert field.is_visible()  # though rare settings are folded


@pytest.mark.parametrize(
    "query, text",
    [
        ("lang=en&scenario=kapitza&analyse.what=self_start&analyse.ask=1",
         "use a LatoLato or BallPair"),
        ("lang=en&scenario=toy&length=1.5+cm",
         "“radius of one ball” must be at least 0 mm and below the length of 15 mm, got "
         "18 mm"),
        ("lang=id&scenario=fig02&analyse.what=impact_map&analyse.ask=1",
         "Peta tumbukan membutuhkan dinding, dan Bandul tidak punya; pakai Lato-lato"),
        ("lang=id&scenario=fig04a&analyse.what=growth_rate&analyse.ask=1&restitution=0.9",
         "bola yang punya jari-jari bersentuhan sebelum menggantung lurus ke bawah"),
        ("lang=en&scenario=toy&analyse.what=growth_rate&analyse.ask=1",
         "must be 0, got 18 mm; balls with a radius touch before they hang straight down: choose "
         "the system Pendulum, which has no walls, with the length, mass and damping of one ball"),
        ("lang=en&scenario=kapitza&analyse.what=self_start&analyse.ask=1",
         "or “Threshold amplitude” for growth from hanging"),
        ("lang=en&analyse.what=first_push&analyse.frequency_ratio= &analyse.ask=1",
         "This analysis needs “Driving over natural frequency”; give values such as 0 : 1 : 11"),
        ("lang=id&scenario=toy&length=1.5+cm",
         "di bawah panjang 15 mm, tetapi diberikan 18 mm"),
    ],
)  # fmt: skip
def test_refusals_are_in_the_words_and_the_language_of_the_page(page, query, text, watch):
    page.goto(f"/?view=analyse&{query}")
    page.locator(".error, .notice").filter(has_text=text, visible=True).first.wait_for()
    watch.faults.clear()  # the server refuses the request


def test_a_limit_of_a_diagram_that_is_none_is_told_at_its_field(page):
    page.goto("/?view=analyse&analyse.what=bifurcation_diagram")
    page.wait_for_selector("[data-form]")
    field = page.locator(".settings").get_by_label("Low", exact=True)
    before = field.input_value()
    enter(field, "1e300")
    line = page.locator(".settings").get_by_role("alert").filter(visible=True)
    line.get_by_text("“Low” is too large to compute with").wait_for()
    enter(field, "-5")
    line.get_by_text("“Low” must be at least 0, got -5").wait_for()
    assert field.get_attribute("aria-invalid") == "true"
    enter(field, before)
    assert line.count() == 0
    field = page.locator(".settings").get_by_label("Low", exact=True)
    for limit, text in (("9", "“Low” must be less than “High”"), ("0", "“Low” must be above 0")):
        enter(field, limit)
        page.get_by_role("button", name="Compute").click()
        line.get_by_text(text).wait_for()
        assert field.get_attribute("aria-invalid") == "true"


def test_what_is_typed_for_an_analysis_stays_when_the_system_is_told(page):
    page.goto("/?view=analyse&scenario=fig02&analyse.what=lyapunov_spectrum")
    page.wait_for_selector("[data-form=lyapunov_spectrum]")
    field = page.locator(".settings").get_by_role("textbox").first
    before = field.input_value()
    with page.expect_response("**/api/analyses/about"):
        page.evaluate(
            "() => window.latolato.views.analyse.page.store.option('gravity', '9.7 m/s^2')"
        )
        field.press_sequentially("1")
    page.wait_for_timeout(300)
    assert field.input_value() in (f"{before}1", f"1{before}")
    assert field.evaluate("input => input === document.activeElement")


def test_fields_show_the_units_of_the_other_views(page):
    page.goto("/?view=analyse&scenario=toy&analyse.what=first_push&analyse.sustained_angle=0.5")
    lasting, phases = (
        page.locator(".settings").get_by_label(label_of(name, "rad"), exact=True)
        for name in ("sustained_angle", "drive_phase")
    )
    # An address without a unit is in radians.
    assert lasting.input_value() == "28.6479"
    enter(lasting, "400")
    page.get_by_text("must be above 0° and at most 180°").wait_for()
    enter(lasting, "45,5")
    page.wait_for_url("**analyse.sustained_angle=45.5+deg**")
    for typed, asked, shown, read in (
        ("0 : 0.5 rad : 3", "0 deg : 0.5 rad : 3", "0 : 28.6479 : 3", [0.0, 0.25, 0.5]),
        ("0, 90", "0 deg, 90 deg", "0, 90", [0.0, np.pi / 2]),
    ):
        enter(phases, typed)
        page.wait_for_function(
            "(text) => new URLSearchParams(location.search).get('analyse.drive_phase') === text",
            arg=asked,
        )
        assert phases.input_value() == shown
        settings = {"drive_phase": asked, "frequency_ratio": "2", "push": "initial_angle"}
        given = {"analysis": "first_push", "scenario": "toy", "options": {}, "settings": settings}
        assert AnalysisRequest.from_json(given).arguments()["drive_phase"] == pytest.approx(read)
    page.goto("/?view=analyse&scenario=fig02&analyse.what=tongue_edges")
    amplitude = page.locator(".settings").get_by_label(label_of("drive_amplitude", "m"), exact=True)
    enter(amplitude, "50")
    page.wait_for_url("**analyse.drive_amplitude=50+mm**")


def test_questions_among_the_numbers_are_answered_in_words():
    about = {"long_name": "whether both ways differ"}
    for given, shown in ((1, "yes"), ([0, 1], "no, yes"), ([1] * 9 + [0, np.nan, -1],
                         "1 no, 2 unknown, 9 yes")):  # fmt: skip
        dims = "ratio" if isinstance(given, list) else ()
        found = xr.Dataset({"differ": (dims, np.array(given), about)}, attrs={"analysis": "none"})
        assert ("Whether both ways differ", shown) in numbers_of(found)


def test_numbers_of_an_answer_are_told_without_names_of_variables():
    found = xr.Dataset(
        {"angle": (("initial_angle", "way_there"), np.ones((1, 12)), {"units": "rad"})},
        coords={"initial_angle": [0.5]},
        attrs={"analysis": "none", "system": "pendulum"},
    )
    assert ("Angle", "57.2958° (12 values)") in numbers_of(found)
    lifted = found.assign(drive_amplitude=((), 0.0276, {"units": "m"}))
    assert ("Drive amplitude", "27.6 mm") in numbers_of(lifted)
    small = found.assign(defect=((), 4.5e-12, {}), step=((), 3e20, {}), rate=((), -0.0, {}))
    rows = {("Defect", f"4.5 {TIMES} 10⁻¹²"), ("Step", f"3 {TIMES} 10²⁰"), ("Rate", "0")}
    assert rows <= set(numbers_of(small))
