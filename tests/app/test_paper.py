"""The paper's claims are judged as the report judges them, and every link leads to a run."""

import json
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from latolato.app import report as paper
from latolato.app.blocks import unpack
from latolato.app.run_request import RunRequest, check_size
from latolato.app.server import Settings, make_app
from latolato.io.files import save
from latolato.scenario.scenario import scenarios
from quick_figures import EVIDENCE, quick_data

HOME = "http://127.0.0.1:8000"
SOCKET = "ws://127.0.0.1:8000/ws/paper"
# Made in a second or two.
QUICK = ("fig01", "fig03", "fig04", "text_decay", "text_model")


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """An empty place for what is made."""
    monkeypatch.setenv("LATOLATO_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(paper, "_place", lambda name: tmp_path / "paper" / f"{name}.block")
    monkeypatch.setattr(paper, "_known", {})
    return tmp_path / "paper"


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """What is told of the quick figures, and where their pictures are."""
    folder = tmp_path_factory.mktemp("made")
    return {name: paper.compute({"figure": name}, folder, print) for name in QUICK}, folder


def ask(client, given):
    """Return all frames of the socket."""
    with client.websocket_connect(SOCKET) as socket:
        socket.send_text(given if isinstance(given, str) else json.dumps(given))
        found = [socket.receive()]
        while found[-1]["type"] != "websocket.close":
            found.append(socket.receive())
    return found


def open_client(report=None):
    app = make_app(Settings(report=report))
    return TestClient(app, base_url=HOME, headers={"origin": HOME})


def test_every_claim_of_the_report_is_listed():
    entries = {entry["name"]: entry for entry in paper.contents()}
    assert list(entries) == list(EVIDENCE)
    for name, evidence in EVIDENCE.items():
        names = [statement["name"] for statement in entries[name]["statements"]]
        assert names == [statement.name for statement in evidence.statements]
        assert bool(entries[name]["caption"]) == name.startswith("fig")


def test_every_scenario_of_a_figure_has_its_link():
    linked = {name for entry in paper.contents() for name in entry["scenarios"]}
    assert linked == {name for name, scenario in scenarios().items() if scenario.figure}


@pytest.mark.parametrize("name", sorted({n for e in paper.contents() for n in e["scenarios"]}))
def test_every_link_to_a_scenario_leads_to_what_can_be_computed(name):
    scenario = RunRequest(name, {}).to_scenario()
    if scenario.varied:
        assert scenario.plan().size > 0
    else:
        check_size(scenario)
        run = RunRequest(name, {"duration": "0.5 s"}).to_scenario().record()
        assert run.attrs["status"] == "complete"


@pytest.mark.parametrize("name", QUICK)
def test_verdicts_are_those_of_the_report(made, name):
    told, folder = made
    wanted = EVIDENCE[name].judge(quick_data(name))
    assert [c["verdict"] for c in told[name]["claims"]] == [c.verdict.name for c in wanted]
    assert all(c["shape"] and c["says"] and c["criteria"] for c in told[name]["claims"])
    if name.startswith("fig"):
        root = ET.parse(folder / f"{name}.svg").getroot()
        assert root.tag.endswith("svg")


@pytest.mark.parametrize("name", QUICK)
def test_every_run_behind_a_figure_opens_as_it_was_computed(made, name):
    dataset = quick_data(name)
    cases = made[0][name]["cases"]
    assert len({case["label"] for case in cases}) == len(cases)
    if not cases:
        assert "scenario" not in dataset
        return
    texts = dataset["scenario"].values
    for case, text in zip(cases, texts, strict=True):
        wanted = json.loads(str(text))
        found = RunRequest(None, case["options"]).to_scenario().to_dict()
        assert found["system"] == wanted["system"]
        assert found["drive"] == wanted["drive"]
        assert "gravity" not in case["options"]  # what is usual would only lengthen addresses
        check_size(RunRequest(None, case["options"]).to_scenario())
    run = RunRequest(None, {**cases[-1]["options"], "duration": 0.5}).to_scenario().record()
    assert run.attrs["status"] == "complete"


def test_a_figure_is_made_once_and_then_kept(cache):
    with open_client() as client:
        *told, block, _ = ask(client, {"figure": "text_decay"})
        assert json.loads(told[0]["text"])["state"] == "waiting"
        about, arrays = unpack(block["bytes"])
        assert about["name"] == "text_decay"
        assert not arrays
        assert (cache / "text_decay.block").is_file()
        paper._known.clear()
        again, _ = ask(client, {"figure": "text_decay"})
        assert again["bytes"] == block["bytes"]
        kept = bytearray((cache / "text_decay.block").read_bytes())
        kept[len(kept) // 2] ^= 1
        (cache / "text_decay.block").write_bytes(kept)
        paper._known.clear()
        *told, block, _ = ask(client, {"figure": "text_decay"})
        assert told
        assert unpack(block["bytes"])[0]["claims"] == about["claims"]


def test_a_stored_report_is_shown_in_place_of_quick_figures(cache, tmp_path, made):
    told, folder = made
    save(quick_data("fig03"), tmp_path / "fig03.nc")
    (tmp_path / "fig03.svg").write_bytes((folder / "fig03.svg").read_bytes())
    with open_client(tmp_path) as client:
        block, _ = ask(client, {"figure": "fig03"})
        about, arrays = unpack(block["bytes"])
    assert about["source"] == "report"
    assert about["claims"] == told["fig03"]["claims"]
    assert arrays["svg"].tobytes() == (tmp_path / "fig03.svg").read_bytes()


def test_a_report_of_another_version_is_refused_with_one_line(cache, tmp_path):
    save(quick_data("fig03"), tmp_path / "fig02.nc")
    with open_client(tmp_path) as client:
        refused, _ = ask(client, {"figure": "fig02"})
    assert "make the report again" in json.loads(refused["text"])["error"]


@pytest.mark.parametrize(
    "given", [{}, {"figure": 3}, [], None, {"figure": "fig2"}, {"figure": "../x"}]
)
def test_an_unknown_figure_is_refused_with_one_line(cache, given):
    with open_client() as client:
        refused, closed = ask(client, given)
    assert json.loads(refused["text"])["error"]
    assert closed["type"] == "websocket.close"


def test_figures_that_need_a_film_say_what_is_missing(cache, monkeypatch):
    from latolato.paper import chain

    monkeypatch.setattr(chain, "is_missing", lambda: True)
    entry = next(e for e in paper.contents() if e["name"] == "fig07")
    assert entry["video"]
    assert ".[video]" in entry["missing"]
    with open_client() as client:
        refused, _ = ask(client, {"figure": "fig07"})
    assert ".[video]" in json.loads(refused["text"])["error"]


def test_a_folder_without_a_report_is_refused_before_the_server_starts(tmp_path):
    from latolato.app.serve import serve

    with pytest.raises(ValueError, match="latolato reproduce"):
        serve(port=0, browser=False, report=tmp_path)


def test_the_key_of_what_is_kept_changes_with_the_sources(monkeypatch):
    before = paper.made_with()
    read = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda path: read(path) + b" ")
    paper.made_with.cache_clear()
    after = paper.made_with()
    paper.made_with.cache_clear()
    assert after != before


def test_claims_stand_beside_their_figure_and_lead_to_play(page):
    page.goto("/?view=paper&paper.figure=fig03")
    plate = page.locator("#paper-fig03")
    picture = plate.get_by_role("img", name="Figure 3: On either side of the edge of resonance")
    picture.wait_for(timeout=240_000)
    size = picture.evaluate("async i => { await i.decode(); return [i.naturalWidth, i.width]; }")
    assert min(size) > 300
    assert plate.get_by_text("△ reproduced with an assumption").is_visible()
    plate.get_by_role("link", name="Open in Play: Resonance at 6 rad/s").click()
    page.wait_for_selector("[data-runs]", timeout=240_000)
    assert "scenario=fig03a" in page.url
    page.go_back()
    plate.get_by_label("Runs behind it (3):").select_option(index=1)
    plate.get_by_role("button", name="Open in Play").click()
    wanted = json.loads(str(quick_data("fig03")["scenario"].values[1]))
    page.wait_for_function(
        """wanted => window.latolato.views.play.player.motion.about.options.drive_frequency
          === wanted""",
        arg=wanted["drive"]["drive_frequency"],
    )


def test_a_figure_through_the_chain_is_made_on_a_click_only_and_says_what_was_filmed(page):
    page.goto("/?view=paper&paper.figure=fig08_chain")
    plate = page.locator("#paper-fig08_chain")
    button = plate.get_by_role("button", name="Make this figure")
    button.wait_for()
    inner, outer = button.bounding_box(), plate.bounding_box()
    assert outer["y"] < inner["y"]
    assert inner["y"] + inner["height"] < outer["y"] + outer["height"]
    assert plate.get_by_text("Not judged yet.").count() == 1
    assert plate.get_by_role("progressbar").count() == 0
    button.click()
    plate.get_by_text("samples that are simulated with the tracker").wait_for(timeout=240_000)
    assert plate.get_by_text("Not judged yet.").count() == 0
    plate.get_by_role("img", name="Figure 8 from a synthetic experiment").wait_for()
    assert button.count() == 0


def test_a_figure_that_waits_for_another_says_so_and_can_be_taken_out(page):
    asked = []

    def hold(route):  # a server that never answers, so that the first figure stays in the making
        route.on_message(lambda message: asked.append(json.loads(message)["figure"]))

    page.route_web_socket("**/ws/paper", hold)
    page.goto("/?view=paper&paper.figure=fig07")
    plate = page.locator("#paper-fig07")
    button = plate.get_by_role("button", name="Make this figure")
    button.wait_for()
    page.get_by_role("button", name="Judge everything now").click()
    page.wait_for_function("() => window.latolato.views.paper.making")
    making = page.evaluate("() => window.latolato.views.paper.making.entry.name")
    label = page.evaluate("() => window.latolato.views.paper.making.entry.label")
    assert making != "fig07"
    others = page.get_by_text("Waiting for its turn …")
    assert others.count() > 5
    for _ in range(2):
        button.click()
        assert plate.get_by_role("status").inner_text() == f"Waiting for {label} …"
        assert button.is_disabled()
        plate.get_by_role("button", name="Cancel").click()
        assert button.is_enabled()
        assert plate.get_by_role("status").count() == 0
    button.click()
    page.get_by_role("button", name="Judge everything now").click()
    assert button.is_disabled()  # what somebody asked for stays asked for
    page.evaluate(
        """() => { const { near, queue, making } = window.latolato.views.paper;
          near.disconnect();
          for (const other of [...queue, making])
            if (other.entry.name !== "fig07") other.job.stop(); }"""
    )
    plate.get_by_text("Waiting for other work to finish …").wait_for()
    assert plate.get_by_role("progressbar").is_visible()
    assert button.is_disabled()
    assert set(asked) >= {making, "fig07"}
    plate.get_by_role("button", name="Cancel").click()
    page.wait_for_function("() => !window.latolato.views.paper.making")
    assert button.is_enabled()
