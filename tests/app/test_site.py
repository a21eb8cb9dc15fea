"""The site of files, served by a plain file server from a folder of a web space."""

from __future__ import annotations

import json
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import pytest
from typer.testing import CliRunner

from latolato.app.forms import registry
from latolato.app.site import write_site
from latolato.cli.main import app

MAPS = [name for name, each in registry()["scenarios"].items() if each["sweep"]]
RUNS = [name for name, each in registry()["scenarios"].items() if not each["sweep"]]
PATIENCE = 60_000
MINE = """<!doctype html><title>mine</title><link rel="icon" href="icon.svg">
<script type="module" src="latolato-player.js"></script>
<latolato-player scenario="zeno" duration="2 s"></latolato-player>
"""


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *args):
        pass


@pytest.fixture(scope="module")
def web(tmp_path_factory):
    """The address of a site in a folder of a web space, and the folder."""
    space = tmp_path_factory.mktemp("web")
    folder = space / "school" / "toy"
    write_site(folder)
    (folder / "mine.html").write_text(MINE)
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=space))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/school/toy/", folder
    server.shutdown()
    server.server_close()


@pytest.fixture
def visit(browser, web):
    """A page of the site; what went wrong on it and whom it asked are lists."""
    context = browser.new_context(viewport={"width": 1366, "height": 768})
    page = context.new_page()
    page.faults, page.hosts = [], set()
    page.on("pageerror", lambda error: page.faults.append(str(error)))
    page.on("console", lambda m: m.type == "error" and page.faults.append(m.text))
    page.on("request", lambda request: page.hosts.add(request.url.split("/")[2]))
    yield page
    context.close()


def test_every_scenario_runs_without_a_server_that_computes(visit, web):
    address, _ = web
    for name in RUNS:
        visit.goto(f"{address}?view=play&scenario={name}")
        visit.wait_for_selector("[data-runs]", timeout=PATIENCE)
        assert visit.locator(".error:visible").all_inner_texts() == [], name
    assert visit.faults == []
    assert visit.hosts == {address.split("/")[2]}


@pytest.mark.parametrize("view", ["live", "map", "paper", "experiment", "analyse"])
def test_every_view_is_there_or_says_what_it_needs(visit, web, view):
    visit.goto(f"{web[0]}?view={view}")
    visit.locator("h1").first.wait_for(state="attached")
    visit.wait_for_timeout(500)
    assert visit.faults == []
    if view in ("experiment", "analyse"):
        visit.get_by_text("latolato app").wait_for()


@pytest.mark.parametrize("name", MAPS)
def test_every_sweep_is_computed_without_a_server_that_computes(visit, web, name):
    visit.goto(f"{web[0]}?view=map&map.scenario={name}&map.size=10")
    visit.wait_for_selector("[data-done]", timeout=PATIENCE)
    visit.wait_for_selector("[data-runs]", timeout=PATIENCE)
    assert visit.locator(".error:visible").all_inner_texts() == []
    visit.get_by_text("Download", exact=True).click()
    with visit.expect_download() as waiting:
        visit.get_by_role("button", name="CSV").click()
    assert waiting.value.suggested_filename == f"latolato_map_{name}.csv"
    visit.get_by_text("The installed program also stores NetCDF").wait_for()
    assert visit.faults == []


def test_a_stored_map_is_left_to_the_program(visit, web):
    visit.goto(f"{web[0]}?view=map&map.stored=own.zarr")
    visit.get_by_role("alert").get_by_text("Stored maps are opened by the installed").wait_for()
    assert visit.faults == []


def test_the_site_opens_without_a_network_after_the_first_visit(visit, web):
    visit.goto(web[0])
    visit.wait_for_selector("[data-runs]", timeout=PATIENCE)
    visit.evaluate("() => navigator.serviceWorker.ready")
    visit.context.set_offline(True)
    for query in ("?view=play&scenario=kapitza", "?view=live"):
        visit.goto(web[0] + query)
        visit.wait_for_selector("[data-runs], [data-ready]", timeout=PATIENCE)
    assert visit.faults == []


def test_an_embedded_page_has_no_way_to_other_views_and_stays_embedded(visit, web):
    visit.goto(f"{web[0]}?view=play&scenario=fig02&embed=1")
    visit.wait_for_selector("[data-runs]", timeout=PATIENCE)
    assert not visit.get_by_role("navigation", name="Views").is_visible()
    field = visit.get_by_label("driving amplitude", exact=False).first
    field.fill("31")
    field.press("Enter")
    visit.wait_for_function("() => location.search.includes('drive_amplitude=31')")
    assert "embed=1" in visit.url


def test_the_player_is_an_element_of_any_page(visit, web):
    visit.goto(f"{web[0]}mine.html")
    player = visit.locator("latolato-player")
    player.locator("canvas").first.wait_for()
    computed = "() => new Promise(done => { const p = document.querySelector('latolato-player');"
    computed += " p.addEventListener('computed', () => done(p.player.motion.end), { once: true });"
    assert visit.evaluate(computed + " p.setAttribute('duration', '3 s'); })") == 3.0
    visit.evaluate(computed + " p.setAttribute('initial-angle', '1 m'); })")
    text = player.locator("[role=alert]").inner_text()
    assert text == "initial_angle must be given in rad (or a unit that converts to it), got '1 m'"
    assert visit.faults == []


def test_files_that_are_kept_are_those_of_the_pages(web):
    _, folder = web
    text = (folder / "files.js").read_text().removeprefix("self.SITE = ").rstrip(";\n")
    paths = json.loads(text)["paths"]
    assert {"index.html", "latolato.js", "registry.json", "kernels/one.wasm"} <= set(paths)
    assert all((folder / path).is_file() for path in paths)
    pages = sum((folder / path).stat().st_size for path in paths)
    assert pages < 2_500_000, "the first visit loads all of this"


def test_what_makes_no_site_is_refused(tmp_path):
    file = tmp_path / "file"
    file.write_text("")
    empty = tmp_path / "empty"
    empty.mkdir()
    report = tmp_path / "report"
    report.mkdir()
    (report / "index.html").write_text("<title>report</title>")
    run = partial(CliRunner().invoke, app)
    for arguments, words in (
        (["site", str(file), "--report", str(report)], "a site needs a folder"),
        (["site", str(tmp_path / "out"), "--report", str(empty)], "holds no report"),
        (["site", str(file), "--report", str(report), "--docs", str(empty)], "no documentation"),
    ):
        answer = run(arguments)
        assert answer.exit_code != 0
        assert words in str(answer.exception) + answer.output
    done = run(["site", str(tmp_path / "out"), "--report", str(report), "--json"])
    assert done.exit_code == 0, done.output
    assert json.loads(done.output)["files"] == [str(tmp_path / "out" / "index.html")]
    assert (tmp_path / "out" / "report" / "index.html").is_file()
