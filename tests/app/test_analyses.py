"""Analyses in the browser: each has a form, answers or refuses, and says how to ask it again."""

import inspect
import json
import shlex
import time

import numpy as np
import pytest
import xarray as xr
from starlette.testclient import TestClient
from typer.testing import CliRunner

from app_server import frames_of
from browser_checks import assert_panels_have_room, serious_faults
from latolato.analysis import analyses
from latolato.app.analyse.answer import compute, numbers_of, to_csv
from latolato.app.analyse.cost import check_work, seconds_of, steps_of, timing
from latolato.app.analyse.forms import about_request, forms, label_of, option_words
from latolato.app.analyse.request import AnalysisRequest
from latolato.app.analyse.routes import prepare
from latolato.app.analyse.timings import keep_timing
from latolato.app.blocks import unpack
from latolato.app.run_request import RunRequest, TooLargeError
from latolato.app.server import Settings, make_app
from latolato.cli.main import app as command_line
from latolato.core.cache import cache_directory
from latolato.core.errors import InputError
from latolato.core.quantities import QUANTITIES
from latolato.figures.analyses.question import GROUPS, question_of
from latolato.io.files import load
from latolato.scenario.analysis_options import options_of

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
# What has no answer without contacts.
OF_TWO = ("impact_map", "self_start", "pair_symmetry")
# Closed forms: they need no compiled kernel.
CLOSED = {"scenario": "fig02", "analysis": "tongue_edges", "settings": {"order": "1"}}


def small(name):
    """Return small sizes for an analysis."""
    fields = forms()[name]["options"]
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


def test_every_analysis_is_asked_in_words():
    found = forms()
    groups = [form["group"] for form in found.values()]
    assert list(dict.fromkeys(groups)) == list(GROUPS)
    for form in found.values():
        assert form["title"].endswith("?")
        assert form["term"]
        assert 40 < len(form["reading"]) < 240
        assert form["reading"].endswith(".")
        assert "_" not in form["title"] + form["term"] + form["reading"]
    for texts in ("title", "term", "reading"):
        assert len({form[texts] for form in found.values()}) == len(found)


def test_every_option_has_a_label_in_words_and_no_word_is_left_over():
    names = {name for form in forms().values() for name in form["options"]}
    assert set(option_words()) <= names
    assert not names - set(option_words()) - set(QUANTITIES)
    for form in forms().values():
        for option in form["options"].values():
            assert "_" not in option["label"] + option["description"]


@pytest.mark.parametrize("laws", ["fig02", "fig04a", "undriven", "mathieu", "schedule"])
def test_what_does_not_fit_a_system_is_said_before_it_is_asked(laws, tmp_path):
    pendulum = {"system": "pendulum", "length": "0.5 m", "mass": "0.1 kg"}
    options = {
        "undriven": {**pendulum, "duration": "6 s", "initial_angle": "0.2"},
        "mathieu": {"system": "mathieu", "length": "0.5 m", "mass": "0.1 kg", "drive": "harmonic",
                    "drive_amplitude": "1 cm", "drive_frequency": "9", "initial_angle": "0.2",
                    "duration": "6 s"},
        "schedule": {**pendulum, "drive": "chirp", "drive_amplitude": "1 cm", "duration": "6 s",
                     "drive_frequency": "9", "drive_frequency_final": "10", "sweep_time": "3",
                     "initial_angle": "0.2"},
    }  # fmt: skip
    scenario = None if laws in options else laws
    asked = {"scenario": scenario, "options": options.get(laws, {"duration": "6 s"})}
    about = about_request(RunRequest.from_json(asked))
    unfit = about["unfit"]
    assert unfit or laws == "fig04a"
    for name, why in unfit.items():
        assert why.endswith(".")
        with pytest.raises(InputError):
            compute({**asked, "analysis": name, "settings": about["quick"][name]}, tmp_path, print)


@pytest.mark.parametrize(
    "scenario, first",
    [("toy", "bifurcation_diagram"), ("kapitza", "inverted_limits"), ("zeno", "lyapunov_spectrum")],
)
def test_the_page_opens_on_a_question_that_can_be_asked(scenario, first):
    about = about_request(RunRequest(scenario, {}))
    assert about["first"] == first
    assert first not in about["unfit"]


def test_ranges_hold_the_drive_of_the_scenario():
    about = about_request(RunRequest("kapitza", {}))
    ratio = 21.43
    limits = about["parameters"]["frequency_ratio"]
    assert float(limits["low"]) < ratio < float(limits["high"])
    low, high, _ = about["quick"]["first_push"]["frequency_ratio"].split(":")
    assert float(low) < ratio < float(high)


def test_motion_that_settles_slowly_is_given_the_time_to_do_so():
    quick = {name: about_request(RunRequest(name, {}))["quick"] for name in ("toy", "kapitza")}
    assert "transient_periods" not in quick["toy"]["response_period"]  # 500 shakes are enough
    # 8 decay times of 20 s at 42 ms a shake
    assert quick["kapitza"]["response_period"]["transient_periods"] == "3900"
    assert float(quick["kapitza"]["lyapunov_spectrum"]["duration"]) >= 600.0
    assert quick["kapitza"]["growth_rate"]["position"] == "inverted"


@pytest.fixture
def no_timings(tmp_path, monkeypatch):
    """A cache folder in which no answer was timed yet, for this process and its workers."""
    folder = tmp_path / "timed"
    folder.mkdir(mode=0o700)
    kernels = cache_directory()
    for each in kernels.iterdir() if kernels.is_dir() else ():
        if each.name != "timings":
            (folder / each.name).symlink_to(each)
    monkeypatch.setenv("LATOLATO_CACHE_DIR", str(folder))


def timed(name, scenario, settings, seconds, rest=0.0):
    """Keep an answer as if it had taken so long; return its function and arguments."""
    given = {"analysis": name, "scenario": scenario, "settings": settings}
    question = AnalysisRequest.from_json(given)
    arguments = question.arguments()
    keep_timing(*timing(question.function, arguments, seconds, rest))
    return question.function, arguments


@pytest.mark.parametrize("name", [name for name in analyses if name not in OF_TWO])
def test_no_time_is_told_before_one_was_measured(name, no_timings):
    given = {"analysis": name, "scenario": "fig02", "settings": small(name)}
    question = AnalysisRequest.from_json(given)
    arguments = question.arguments()
    assert seconds_of(question.function, arguments) is None
    timed(name, "fig02", small(name), 3.0, rest=0.5)
    assert seconds_of(question.function, arguments) == pytest.approx(3.5)


def test_a_larger_question_takes_longer_by_its_steps(no_timings):
    size = {"angle_points": "10", "velocity_points": "10"}
    function, arguments = timed("basins", "fig04a", size, 2.0, rest=1.0)
    larger = {**arguments, "angle_points": 30, "velocity_points": 20}
    assert seconds_of(function, larger) == pytest.approx(1.0 + 6.0 * 2.0)
    # Of far larger ones nothing is predicted: small ones spend their time on other things.
    assert seconds_of(function, {**arguments, "angle_points": 101}) is None
    timed("basins", "fig04a", {**size, "angle_points": "2"}, 1.5, rest=1.0)
    assert seconds_of(function, larger) == pytest.approx(1.0 + 6.0 * 2.0)
    # Of another system nothing is known yet: a step may take ten times as long there.
    other = {"analysis": "basins", "scenario": "fig04a", "options": {"restitution": "0.5"}}
    question = AnalysisRequest.from_json({**other, "settings": size})
    assert seconds_of(question.function, question.arguments()) is None


def test_only_the_latest_answers_count_and_a_damaged_file_counts_as_none(no_timings):
    for seconds in (100.0, *[2.0] * 8):
        function, arguments = timed("basins", "fig04a", {}, seconds)
    assert seconds_of(function, arguments) == pytest.approx(2.0)
    (file,) = (cache_directory() / "timings").iterdir()
    file.write_bytes(b"damaged")
    assert seconds_of(function, arguments) is None


def test_an_answer_tells_how_far_it_is_and_is_timed(no_timings, tmp_path):
    shares = []
    given = {"analysis": "basins", "scenario": "fig02", "settings": small("basins")}
    with pytest.warns(RuntimeWarning):  # few shakes: hardly anything has settled
        compute(given, tmp_path, shares.append)
    assert shares == sorted(shares)
    assert all(0.0 < share < 1.0 for share in shares)
    assert shares
    (file,) = (cache_directory() / "timings").iterdir()
    assert b"basins " in file.read_bytes()


def test_the_cost_of_a_question_is_told_without_asking_it(client, no_timings):
    def cost(**given):
        asked = {"analysis": "basins", "scenario": "fig04a", "settings": given}
        return client.post("/api/analyses/cost", json=asked)

    assert cost().json() == {"seconds": None}  # nothing was timed yet
    size = {**small("basins"), "angle_points": "20", "velocity_points": "20"}
    ask(client, {"analysis": "basins", "scenario": "fig04a", "settings": size})
    few, many = (cost(**{**size, "angle_points": n}).json()["seconds"] for n in ("4", "100"))
    assert 0.0 < few < many
    assert cost(**{**size, "angle_points": "300"}).json() == {"seconds": None}
    assert "steps at most" in cost(angle_points="900000").json()["refused"]
    wrong = cost(angle_points="ten").json()["refused"]
    assert wrong.startswith("angle_points must be a whole number")
    assert "must be an object" in client.post("/api/analyses/cost", json=[]).json()["refused"]


DISTANCE = "the distance between neighbouring starts"


@pytest.mark.parametrize(
    "status, words",
    [
        ("chaotic", f"Yes: {DISTANCE} grows by a factor of e every 2 s: chaos."),
        ("regular", f"No: {DISTANCE} shrinks by a factor of e every 2 s."),
        ("marginal", "The run is too short to tell"),
        ("failed", "There is no answer: the computation failed."),
    ],
)
def test_a_verdict_says_what_the_status_and_the_number_mean(status, words):
    largest = 0.5 if status == "chaotic" else -0.5
    found = xr.Dataset({"status": status, "lyapunov_exponents": ("exponent", [largest, -1.0])})
    verdict = question_of("lyapunov_spectrum").verdict(found)
    assert verdict.startswith(words)


@pytest.mark.parametrize(
    "rests, words", [(3, f"Between such rests {DISTANCE} grows by a factor of e every 2 s"),
                     (100, "No: the balls come to rest on each other")],
)  # fmt: skip
def test_a_verdict_tells_chaos_with_rare_rests_from_lasting_rest(rests, words):
    found = xr.Dataset(
        {
            "status": "rest",
            "lyapunov_exponents": ("exponent", [-np.inf, -np.inf]),
            "exponent_between_rests": 0.5,
            "rests": rests,
        },
        attrs={"duration": 300.0, "transient": 100.0},
    )
    assert words in question_of("lyapunov_spectrum").verdict(found)


@pytest.mark.parametrize("name", analyses)
def test_what_forms_begin_with_is_a_question_that_can_be_asked(name):
    about = about_request(RunRequest("fig04a_push", {}))
    form = forms()[name]["options"]
    quick = about["quick"][name]
    assert set(quick) <= set(form)
    job = prepare({"analysis": name, "scenario": "fig04a_push", "settings": quick})
    assert job.name == "analyse"


@pytest.mark.filterwarnings("ignore::RuntimeWarning")  # few points and short runs
@pytest.mark.parametrize("name", [name for name in analyses if name not in OF_TWO])
def test_every_analysis_answers(name, tmp_path):
    given = {"analysis": name, "options": {"duration": "6 s"}, "settings": small(name)}
    told = compute({**given, "scenario": "fig02"}, tmp_path, print)
    assert load(tmp_path / "result.nc").attrs["analysis"] == name
    assert told["verdict"].endswith(".")
    assert "_" not in told["verdict"]
    assert "nan" not in told["verdict"]
    assert "no value" not in told["verdict"]
    assert len(told["lines"]) > 0
    assert not any("_" in label for label, _ in told["lines"])
    assert (tmp_path / "result.svg").stat().st_size > 1000
    assert (tmp_path / "result.png").read_bytes().startswith(b"\x89PNG")
    assert f"# analysis: {name}" in (tmp_path / "result.csv").read_text(encoding="utf-8")


def test_a_two_stage_start_that_cannot_help_says_why_and_shows_where_pushes_lead(tmp_path):
    quick = about_request(RunRequest("toy", {}))["quick"]["shortest_protocol"]
    given = {
        "analysis": "shortest_protocol",
        "scenario": "toy",
        "settings": {**quick, "push": "1, 7"},
    }
    with pytest.warns(RuntimeWarning, match="leads to a larger motion than rest"):
        told = compute(given, tmp_path, print)
    assert told["verdict"] == (
        "It cannot help: no push up to 7 rad/s leads beyond the 175° from rest."
    )
    found = load(tmp_path / "result.nc")
    assert np.isfinite(found["angle_after_push"]).all()
    # What does not exist has no unit either.
    assert dict(told["lines"])["Smallest push that reaches it"] == "none"


@pytest.mark.parametrize("name", OF_TWO)
def test_a_question_about_contacts_is_refused_for_a_pendulum_in_one_line(client, name):
    given = {"analysis": name, "scenario": "fig02", "settings": small(name)}
    text = json.loads(ask(client, given)[-2]["text"])["error"]
    assert "\n" not in text
    assert "Pendulum" in text or "pendulum" in text


def test_a_question_about_contacts_is_answered_for_a_pair(tmp_path):
    told = compute(
        {"analysis": "self_start", "scenario": "fig04a", "settings": {}}, tmp_path, print
    )
    assert dict(told["lines"])["What was found"] == "found"
    assert "the balls part by themselves from" in told["verdict"]


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
        ([], "must be an object"),
        ({}, "analysis must be a name"),
        ({"analysis": "tongues", "scenario": "fig02"}, "unknown analysis"),
        ({**CLOSED, "settings": {"order": 1}}, "object of texts"),
        ({**CLOSED, "settings": {"ordre": "1"}}, "has no option 'ordre'"),
        ({**CLOSED, "settings": {"order": "one"}}, "order must be a whole number"),
        ({**CLOSED, "settings": {"drive_amplitude": "3 kg"}}, "drive_amplitude"),
        ({**CLOSED, "scenario": "nothing"}, "there is no scenario"),
        ({**CLOSED, "options": {"length": "-1 m"}}, "length"),
        ({"analysis": "self_start", "scenario": "fig04a", "settings": {"check": "yes"}}, "true or"),
        ({"analysis": "first_push", "scenario": "fig04a"}, "needs frequency_ratio"),
        (
            {"analysis": "basins", "scenario": "fig04a", "settings": {"angle_points": "900000"}},
            "steps at most",
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
def test_a_bad_question_is_refused_before_any_work(client, given, words):
    refused, closed = ask(client, given)
    text = json.loads(refused["text"])["error"]
    assert words in text
    assert "\n" not in text
    assert closed["type"] == "websocket.close"


def test_a_text_never_names_a_file(client, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ratios.csv").write_text("1.5\n2\n")
    (tmp_path / "1:2:3").write_text("1.5\n2\n")
    for text in ("ratios.csv", str(tmp_path / "ratios.csv"), "ratios.csv:ratio", "1:2:3"):
        given = {
            "analysis": "first_push",
            "scenario": "fig04a",
            "settings": {"frequency_ratio": text},
        }
        with pytest.raises(ValueError, match="frequency_ratio"):
            prepare(given)


def test_work_is_estimated_from_all_that_multiplies_it():
    def steps(**given):
        question = AnalysisRequest.from_json(
            {"analysis": "basins", "scenario": "fig04a", "settings": given}
        )
        return steps_of(question.function, question.arguments())

    few = steps(angle_points="10", velocity_points="10")
    assert steps(angle_points="20", velocity_points="30") == pytest.approx(6.0 * few)
    given = {"transient_periods": "1e9"}
    question = AnalysisRequest.from_json(
        {"analysis": "basins", "scenario": "fig04a", "settings": given}
    )
    with pytest.raises(TooLargeError, match="steps at most"):
        check_work(question.function, question.arguments())


def test_a_page_that_goes_ends_the_computation(client):
    given = {"analysis": "basins", "scenario": "fig02", "settings": {"transient_periods": "8000"}}
    with client.websocket_connect(SOCKET) as socket:
        socket.send_json(given)
        while json.loads(socket.receive()["text"])["state"] in ("waiting", "starting"):
            pass
        (worker,) = client.app.state.jobs.busy
    begun = time.monotonic()
    assert worker.process.wait(timeout=30) != 0
    assert time.monotonic() - begun < 30
    assert ask(client, CLOSED)[-2]["bytes"]


def test_a_worker_ends_with_its_input():
    from latolato.app.processes import Worker

    worker = Worker()
    worker.process.stdin.close()
    assert worker.process.wait(timeout=30) == 0
    worker.kill()


def test_points_of_a_picture_stand_for_the_values_of_its_axes(tmp_path):
    given = {"analysis": "bifurcation_diagram", "scenario": "fig02", "settings": small("basins") | {
        "parameter": "frequency_ratio", "low": "1.8", "high": "2.2", "points": "5",
        "transient_periods": "10", "longest": "4"}}  # fmt: skip
    given["settings"] = {n: v for n, v in given["settings"].items()
                      if n in forms()["bifurcation_diagram"]["options"]}  # fmt: skip
    panels = compute(given, tmp_path, print)["panels"]
    assert len(panels) == 2  # stroboscopic angles and largest angles, over one axis
    for panel in panels:
        assert panel["x"]["name"] == "frequency_ratio"
        assert panel["x"]["ends"] == pytest.approx([1.8, 2.2])
        assert panel["y"] is None
        left, top, right, bottom = panel["box"]
        assert 0 <= left < right <= 1
        assert 0 <= top < bottom <= 1


def test_points_of_a_picture_stand_for_values_in_the_unit_of_its_axis(tmp_path):
    axes = {"drive_amplitude": "20 : 60 : 5 mm", "frequency_ratio": "2 : 4 : 5"}
    given = {"analysis": "pair_symmetry", "scenario": "toy", "settings": axes}
    (panel,) = compute({**given, "options": {"duration": "60 s"}}, tmp_path, print)["panels"]
    assert panel["y"]["name"] == "drive_amplitude"
    assert panel["y"]["unit"] == "m"
    # SI units under an axis in millimetres, to the edges of the cells
    assert panel["y"]["ends"] == pytest.approx([0.015, 0.065])


def test_a_question_is_asked_by_choosing_it_and_its_answer_is_shown(page, tmp_path):
    page.goto("/?view=analyse&scenario=fig02")
    page.get_by_role("button", name="At which speeds does hanging still").click()
    picture = page.get_by_role("img", name="At which speeds does hanging still")
    picture.wait_for(timeout=240_000)
    assert picture.evaluate("async i => { await i.decode(); return i.naturalWidth; }") > 300
    given = {**CLOSED, "options": {}}
    question = AnalysisRequest.from_json(given)
    wanted = question.function(**question.arguments())
    verdict = f"unstable from ω/ω₀ = {wanted.low:.5g} to {wanted.high:.5g}."
    assert page.locator(".finding").inner_text().endswith(verdict)
    row = page.get_by_role("row", name="Lower edge of the tongue")
    assert row.inner_text().split()[-1] == f"{wanted.low:.6g}"
    with page.expect_download() as caught:
        page.get_by_role("button", name="NetCDF").click()
    path = tmp_path / "result.nc"
    caught.value.save_as(path)
    xr.testing.assert_equal(load(path), wanted)
    page.get_by_text("Settings of this question").click()
    page.get_by_label("Number of the tongue").fill("none")
    page.get_by_label("Number of the tongue").press("Enter")
    words = "“none” is not a number"
    page.get_by_role("alert").filter(has_text=words).wait_for()
    # The answer on show is still that of the settings in the address.
    assert page.get_by_role("img", name="At which speeds").count()
    assert "none" not in page.url
    assert "analyse.what=tongue_edges" in page.url


def test_the_view_opens_with_an_answer(page):
    page.goto("/?view=analyse&scenario=kapitza")
    page.locator(".finding").filter(has_text="it stands upright with an amplitude of").wait_for(
        timeout=240_000
    )
    page.get_by_role("heading", name="Can it stand on its head?").wait_for()


TOPS = """places => places.map(place => {
  const found = document.querySelector(place);
  return found?.checkVisibility() ? found.getBoundingClientRect().top : null;
})"""


@pytest.mark.parametrize("width", [1366, 390])
def test_the_answer_comes_first_then_its_picture_then_numbers(page, width):
    page.set_viewport_size({"width": width, "height": 844})
    page.goto("/?view=analyse&scenario=fig02&analyse.what=tongue_edges")
    page.locator(".finding.waiting").filter(has_text="The answer will appear here").wait_for()
    places = [".asks", ".finding", ".picture", ".reading-of"]
    before = page.evaluate(TOPS, places)
    assert before == sorted(before)
    page.locator(".finding strong").wait_for(timeout=240_000)
    after = page.evaluate(TOPS, [*places, ".numbers"])
    assert after == sorted(after)
    assert after[2] - before[2] < 60  # a longer sentence moves the picture by a line or two
    sizes = "e => parseFloat(getComputedStyle(e).fontSize)"
    assert page.locator(".finding strong").evaluate(sizes) >= 20
    assert not page.get_by_label("Number of the tongue").is_visible()
    if width == 390:
        (settings,) = page.evaluate(TOPS, [".settings-of"])
        assert settings > after[-1]
    assert serious_faults(page) == []
    assert_panels_have_room(page)


def test_an_unknown_question_and_setting_of_the_address_are_told_and_left_out(page):
    page.goto("/?view=analyse&scenario=kapitza&analyse.what=nonsense&analyse.wrong=1")
    page.get_by_text("There is no question “nonsense”").wait_for()
    page.get_by_text("“wrong” is not a setting of this question").wait_for()
    page.get_by_role("heading", name="Can it stand on its head?").wait_for()


def test_a_question_about_two_balls_offers_a_toy(page):
    page.goto("/?view=analyse&scenario=kapitza&analyse.what=self_start")
    page.get_by_text("This question needs two balls that collide").wait_for()
    page.get_by_role("button", name="Ask about a toy").click()
    page.locator(".finding").filter(has_text="the balls part by themselves").wait_for(
        timeout=240_000
    )
    assert "system=latolato" in page.evaluate("() => location.search")


def test_what_takes_long_says_how_long_and_waits(page):
    page.goto("/?view=analyse&scenario=fig02&analyse.what=basins"
              "&analyse.angle_points=300&analyse.velocity_points=300")  # fmt: skip
    page.get_by_text("takes about").wait_for()
    assert not page.get_by_role("progressbar").is_visible()


def test_a_point_of_the_picture_shows_its_run_and_opens_in_play(page):
    page.goto(
        "/?view=analyse&scenario=fig02&duration=5 s&analyse.what=bifurcation_diagram"
        "&analyse.points=5&analyse.transient_periods=10&analyse.longest=4&analyse.low=1.8&analyse.high=2.2"
    )
    picture = page.get_by_role("application", name="What happens when I turn one knob?")
    picture.wait_for(timeout=240_000)
    picture.press("ArrowRight")
    picture.press("Enter")
    page.get_by_text("Drive speed, ω/ω₀: 2.004. This run").wait_for()
    page.wait_for_selector(".point[data-runs]", timeout=240_000)
    page.get_by_role("link", name="Open in Toy").click()
    page.wait_for_selector("[data-runs] .player", timeout=240_000)
    page.wait_for_function("() => window.latolato.views.toy?.player.motion")
    found = page.evaluate("() => window.latolato.views.toy.player.motion.about.options")
    asked = RunRequest("fig02", {"frequency_ratio": "2.004", "duration": "5 s"}).to_scenario()
    assert found["drive_frequency"] == asked.drive.drive_frequency


def test_the_map_of_a_point_takes_its_frequency_out_of_the_options(page):
    page.goto("/?view=analyse&scenario=fig02&drive_frequency=6 rad/s")
    found = page.evaluate(
        """async () => { const { withOptions } = await import("/js/shared/links.js");
          return withOptions({ drive_frequency: "6 rad/s", length: "1 m" },
            { frequency_ratio: "2" }); }"""
    )
    assert found == {"length": "1 m", "frequency_ratio": "2"}


def test_a_refusal_stands_beside_its_field_in_the_words_of_the_page(page):
    page.goto("/?view=analyse&scenario=fig02&analyse.what=basins&analyse.angle_tolerance=7")
    alert = page.get_by_role("alert").filter(
        has_text="“Two samples are the same within” must be above 0° and at most 57.2958°"
    )
    alert.wait_for(timeout=240_000)
    field = page.get_by_label("Two samples are the same within")
    assert field.get_attribute("aria-invalid") == "true"
    assert field.is_visible()  # though rare settings are folded
    steps = page.get_by_role("alert").filter(has_text="steps at most")
    page.get_by_label("Shakes to leave out").fill("1e7")
    page.get_by_label("Shakes to leave out").press("Enter")
    page.get_by_text("Two samples are the same within").first.wait_for()
    field.fill("")
    page.get_by_role("button", name="Compute").click()
    steps.wait_for()


@pytest.mark.parametrize(
    "typed, problem",
    [("1e300", "“From” must lie between -1e+30 and 1e+30"), ("", "A number belongs here, such as")],
)
def test_a_limit_of_a_diagram_that_is_none_is_told_at_its_field(page, typed, problem):
    page.goto("/?view=analyse&analyse.what=bifurcation_diagram")
    page.wait_for_selector("[data-form]")
    page.locator(".settings-of > summary").click()
    field = page.locator(".settings").get_by_label("From", exact=True)
    before = field.input_value()
    field.fill(typed)
    field.press("Enter")
    line = page.locator(".settings").get_by_role("alert").filter(visible=True)
    line.get_by_text(problem).wait_for()
    assert field.get_attribute("aria-invalid") == "true"
    field.fill(before)
    field.press("Enter")
    assert line.count() == 0


def test_fields_show_the_units_of_the_other_views(page):
    page.goto("/?view=analyse&scenario=toy&analyse.what=first_push&analyse.sustained_angle=0.5")
    page.get_by_text("Settings of this question").click()
    lasting, phases = (
        page.get_by_label(label_of(name)) for name in ("sustained_angle", "drive_phase")
    )
    # An address without a unit is in radians.
    assert lasting.input_value() == "28.6479"
    lasting.fill("400")
    lasting.press("Enter")
    page.get_by_text("must be above 0° and at most 180°").wait_for()
    lasting.fill("45,5")
    lasting.press("Enter")
    page.wait_for_url("**analyse.sustained_angle=45.5+deg**")
    for typed, asked, shown, read in (
        ("0 : 0.5 rad : 3", "0 deg : 0.5 rad : 3", "0 : 28.6479 : 3", [0.0, 0.25, 0.5]),
        ("0, 90", "0 deg, 90 deg", "0, 90", [0.0, np.pi / 2]),
    ):
        phases.fill(typed)
        phases.press("Enter")
        page.wait_for_function(
            "(text) => new URLSearchParams(location.search).get('analyse.drive_phase') === text",
            arg=asked,
        )
        assert phases.input_value() == shown
        settings = {"drive_phase": asked, "frequency_ratio": "2", "push": "initial_angle"}
        given = {"analysis": "first_push", "scenario": "toy", "options": {}, "settings": settings}
        assert AnalysisRequest.from_json(given).arguments()["drive_phase"] == pytest.approx(read)
    page.goto("/?view=analyse&scenario=fig02&analyse.what=tongue_edges")
    page.get_by_text("Settings of this question").click()
    amplitude = page.get_by_label(label_of("drive_amplitude"))
    amplitude.fill("50")
    amplitude.press("Enter")
    page.wait_for_url("**analyse.drive_amplitude=50+mm**")


def test_numbers_of_an_answer_are_told_without_names_of_variables():
    found = xr.Dataset(
        {"angle": (("initial_angle", "way_there"), np.ones((1, 12)), {"units": "rad"})},
        coords={"initial_angle": [0.5]},
        attrs={"analysis": "none", "system": "pendulum"},
    )
    assert ("Angle", "57.2958 to 57.2958 ° (12 values)") in numbers_of(found)
