"""The site of files, served by a plain file server from a folder of a web space."""

from __future__ import annotations

import json
import re
import shutil
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from typer.testing import CliRunner

from app_pages import download, enter, launch, new_context
from browser_checks import serious_faults
from firefox import firefox_page
from latolato.app.forms import registry
from latolato.app.site import write_site
from latolato.cli.main import app
from same_runs import check_same, in_python

DOCS = Path(__file__).parents[2] / "docs"
RUNS = [name for name, each in registry()["scenarios"].items() if not each["sweep"]]
AROUND = """<!doctype html><title>around</title><link rel="icon" href="icon.svg">
<iframe src="./?view=toy&scenario=fig02" width="800" height="300"></iframe>
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
    (folder / "around.html").write_text(AROUND)
    # What runs on pages of the documentation, which is built elsewhere.
    (folder / "docs" / "how-to").mkdir(parents=True)
    for name in ("how-to/in-your-page", "gallery"):
        text = (DOCS / f"{name}.md").read_text(encoding="utf-8")
        parts = re.findall(r"```{raw} html\n(.*?)```", text, re.DOTALL)
        icon = f'<link rel="icon" href="{"../" * (name.count("/") + 1)}icon.svg">'
        (folder / "docs" / f"{name}.html").write_text(
            '<!doctype html><html lang="en"><title>examples</title>' + icon + "".join(parts)
        )
    shutil.copytree(DOCS / "_static", folder / "docs" / "_static")
    server = ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=space))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    yield f"http://127.0.0.1:{server.server_port}/school/toy/", folder
    server.shutdown()
    server.server_close()


@pytest.fixture
def visit(browser, web):
    """A page of the site, on which nothing goes wrong and which asks no other server."""
    context = new_context(browser, viewport={"width": 1366, "height": 768})
    page = context.new_page()
    page.faults, hosts = [], set()
    page.on("pageerror", lambda error: page.faults.append(str(error)))
    page.on("console", lambda m: m.type == "error" and page.faults.append(m.text))
    page.on("request", lambda request: hosts.add(urlsplit(request.url).netloc))
    yield page
    context.close()
    assert page.faults == []
    assert hosts - {""} == {urlsplit(web[0]).netloc}


@pytest.mark.parametrize("view", ["toy", "map", "report", "measure", "analyse"])
def test_every_view_is_there_or_says_what_it_needs(visit, web, view):
    visit.goto(f"{web[0]}?view={view}")
    visit.locator("h1").first.wait_for(state="attached")
    visit.wait_for_timeout(500)
    if view in ("measure", "analyse"):
        visit.get_by_text("latolato app").wait_for()
    if view == "report":
        visit.get_by_text("latolato site FOLDER").wait_for()


@pytest.mark.parametrize("name", ["fig03cd", "fig05"])
def test_a_sweep_is_computed_without_a_server_that_computes(visit, web, name, tmp_path):
    visit.goto(f"{web[0]}?view=map&map.scenario={name}&map.size=10")
    visit.wait_for_selector("[data-done]")
    visit.wait_for_selector("[data-runs]")
    assert visit.locator(":is(.message, .error):visible").all_inner_texts() == []
    visit.get_by_text("Download", exact=True).click()
    path = download(visit.get_by_role("button", name="CSV"), tmp_path)
    assert path.name == f"latolato_map_{name}_10x10.csv"
    visit.get_by_text("The installed program also stores NetCDF").wait_for()


def test_a_stored_map_is_left_to_the_program(visit, web):
    visit.goto(f"{web[0]}?view=map&map.stored=own.zarr")
    visit.locator(".message").get_by_text("The installed program opens stored maps").wait_for()


OFFLINE = {
    "view=toy&scenario=kapitza": "[data-runs]",
    "view=toy&toy.hand=1": "[data-ready]",
    "view=map&map.size=10": "[data-done]",
    "view=report": "h1",
    "view=analyse": "h1",
}


def _code(folder, is_scalar):
    """Return the files of compiled code that one browser runs."""
    files = (folder / "kernels").glob("*.wasm")
    return sorted(path.name for path in files if path.stem.endswith("-scalar") is is_scalar)


# Which of them a browser keeps.
KEPT_CODE = """async () => {
  const [name] = await caches.keys();
  const paths = (await (await caches.open(name)).keys()).map(({ url }) => new URL(url).pathname);
  return paths.filter((path) => path.endsWith(".wasm")).map((path) => path.split("/").at(-1))
    .sort();
}"""


def _take_offline(visit):
    """Take the network away, also from the worker, which may hear of it a little later."""
    visit.context.set_offline(True)
    [worker] = visit.context.service_workers
    while worker.evaluate(
        "() => fetch('files.js', { cache: 'no-store' }).then(() => true, () => false)"
    ):
        visit.wait_for_timeout(50)


def test_the_site_opens_without_a_network_after_the_first_visit(visit, web):
    visit.goto(web[0])
    visit.wait_for_selector("[data-runs]")
    visit.evaluate("() => navigator.serviceWorker.ready")
    assert visit.evaluate(KEPT_CODE) == _code(web[1], is_scalar=False)
    _take_offline(visit)
    for query, ready in OFFLINE.items():
        visit.goto(f"{web[0]}?{query}")
        visit.wait_for_selector(ready)


def test_a_page_that_was_never_read_says_so_without_a_network(visit, web):
    visit.goto(web[0])
    visit.locator("#language").select_option("id")
    visit.get_by_role("button", name="Bagikan").wait_for()
    visit.evaluate("() => navigator.serviceWorker.ready")
    _take_offline(visit)
    visit.goto(f"{web[0]}docs/gallery.html")
    visit.locator(".message").get_by_text("belum tersimpan di perangkat ini").wait_for()
    visit.wait_for_selector("[data-runs]")
    visit.context.set_offline(False)
    visit.goto(f"{web[0]}docs/gallery.html")
    _take_offline(visit)
    visit.goto(f"{web[0]}docs/gallery.html")
    assert visit.title() == "examples"


COLUMNS = """async ([address, scenario, options]) => {
  const { simulate } = await import(address);
  const run = await simulate({ scenario, ...options });
  const plain = (value) => (ArrayBuffer.isView(value) ? Array.from(value)
    : Array.isArray(value) ? value.map(plain) : value);
  return Object.fromEntries(Object.entries(run).map(([name, value]) => [name, plain(value)]));
}"""


def test_numbers_of_a_browser_are_those_of_python(visit, web):
    visit.goto(f"{web[0]}?view=report")
    for name in RUNS:
        options = {"duration": 4.0, "samples": 201}
        answer = visit.evaluate(COLUMNS, [f"{web[0]}latolato.js", name, options])
        check_same(in_python(name, options), answer, name, options)


# How many colours the first picture of a view has.
COLOURS = """() => {
  const canvas = document.querySelector("main canvas");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  return new Set(new Uint32Array(data.buffer)).size;
}"""
NO_WEBGL = """const get = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
  return kind.startsWith("webgl") ? null : get.call(this, kind, ...rest);
};"""
PHONE = {"width": 390, "height": 844}
DEVICES = {
    "phone": {"viewport": PHONE, "has_touch": True, "is_mobile": True, "color_scheme": "dark"},
    "zoomed": {"viewport": {"width": 683, "height": 384}, "device_scale_factor": 2},
    "calm, without WebGL": {"reduced_motion": "reduce"},
    "slow": {"viewport": PHONE},
}


@pytest.mark.parametrize("device", DEVICES)
def test_a_toy_and_one_in_a_hand_work_on(browser, web, device):
    context = new_context(browser, **DEVICES[device])
    page = context.new_page()
    faults = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.add_init_script(NO_WEBGL if "WebGL" in device else "")
    if device == "slow":
        context.new_cdp_session(page).send("Emulation.setCPUThrottlingRate", {"rate": 4})
    for query, ready in (("", "[data-runs]"), ("&toy.hand=1", "[data-ready]")):
        page.goto(f"{web[0]}?view=toy{query}")
        page.wait_for_selector(ready)
        page.wait_for_function(f"() => ({COLOURS})() > 3")
        seen = page.locator("main canvas").first.bounding_box()
        size = page.viewport_size
        assert seen["x"] + seen["width"] <= size["width"]
        if device == "zoomed":
            assert min(seen["y"] + seen["height"], size["height"]) - max(seen["y"], 0) > 100
        if device == "phone":
            page.get_by_role("button", name=re.compile("^(Play|Pause)$")).first.tap()
        else:
            page.keyboard.press("Space")
        clock = "() => window.latolato.views.toy.player.clock"
        if not query:
            page.wait_for_function(f"{clock}.time > 0")
        else:  # it moves by itself, unless motion is to be reduced
            assert page.evaluate(f"{clock}.playing") is ("calm" in device)
        if device in ("phone", "zoomed"):
            assert serious_faults(page) == []
    assert faults == []
    context.close()


def test_a_browser_without_simd_takes_the_scalar_modules(browser, web):
    other = launch(browser.browser_type, "--js-flags=--no-enable-sse4-1")
    page = other.new_page()
    loaded = set()
    page.on("request", lambda request: loaded.add(request.url.rpartition("/")[2]))
    page.goto(f"{web[0]}?view=toy&scenario=toy")
    page.wait_for_selector("[data-runs]")
    page.evaluate("() => navigator.serviceWorker.ready")
    kept = page.evaluate(KEPT_CODE)
    other.close()
    assert {name for name in loaded if name.endswith(".wasm")} == {"one-scalar.wasm"}
    assert kept == _code(web[1], is_scalar=True)


@pytest.mark.slow
def test_firefox_runs_the_site(web):
    with firefox_page(f"{web[0]}?view=toy&scenario=fig04a_push&duration=3 s") as evaluate:
        evaluate("new Promise((done) => { const look = () => (document.querySelector('[data-runs]')"
                 " ? done() : setTimeout(look, 50)); look(); })")  # fmt: skip
        colours = evaluate(f"({COLOURS})()")
        assert colours > 3
        end = evaluate("window.latolato.views.toy.player.motion.values('angle').at(-1)")
    run = in_python("fig04a_push", {"duration": 3.0})
    assert end == pytest.approx(run["angle"][-1], abs=1e-9)


IMAGE = "<img src=x onerror=alert(1)>"
# Broken addresses, and what their pages say; `test_fuzz.py` has many more, for the modules alone.
BROKEN = {
    f"view={IMAGE}": f"“view={IMAGE}”",
    f"view=toy&scenario={IMAGE}": f"“scenario={IMAGE}”",
    "view=toy&__proto__=1&scenario=toy": "“__proto__=1”",
    "view=toy&scenario=toy&length=3 constructor": "must be a number in cm, got '3 constructor'",
    f"view=toy&scenario={'x' * 5000}": "“scenario=xxx",
    "view=map&format=99": "made by a newer latolato",
}


def test_an_address_that_is_broken_is_named_and_harmless(visit, web):
    for query, words in BROKEN.items():
        visit.goto(f"{web[0]}?{query}")
        visit.locator(".message").filter(has_text=words).wait_for()
        assert visit.locator("main img").count() == 0


@pytest.mark.parametrize("view", ["toy", "toy&toy.hand=1", "map"])
def test_a_long_text_in_an_address_does_not_widen_the_page(visit, web, view):
    visit.goto(f"{web[0]}?view={view}&map.size=10&length={'x' * 3000}")
    visit.locator(".message").filter(has_text="xxx").wait_for()
    wider = visit.evaluate("() => document.scrollingElement.scrollWidth - innerWidth")
    assert wider <= 0


def test_a_site_in_a_frame_leaves_the_back_button_to_the_page_around_it(visit, web):
    visit.goto(f"{web[0]}around.html")
    frame = visit.frame_locator("iframe")
    field = frame.get_by_label("How far the hand moves A0")
    field.wait_for()
    entries = visit.evaluate("() => history.length")
    enter(field, "31")
    inside = next(each for each in visit.frames if "scenario=fig02" in each.url)
    inside.wait_for_function("() => location.search.includes('drive_amplitude=31')")
    assert visit.evaluate("() => history.length") == entries


def test_the_examples_of_the_documentation_run_in_the_site(visit, web):
    visit.goto(f"{web[0]}docs/how-to/in-your-page.html")
    visit.locator("latolato-player canvas").first.wait_for()
    visit.get_by_text("The run is complete").wait_for()
    assert not visit.get_by_text("do not run here").is_visible()
    visit.get_by_label("duration").last.fill("3")
    visit.get_by_label("restitution").fill("2")
    visit.get_by_role("button", name="Run", exact=True).click()
    visit.get_by_text("restitution must lie in [0, 1], got 2").wait_for()
    assert "  restitution: 2," in visit.locator("#latolato-program").inner_text()
    visit.get_by_label("drive-amplitude").fill('1 cm"><b>')
    visit.get_by_role("button", name="Show").click()
    assert 'drive-amplitude="1 cm&quot;><b>"' in visit.locator("#latolato-markup").inner_text()
    visit.get_by_text("drive-amplitude must be given in m").wait_for()
    assert serious_faults(visit) == []


def test_the_toy_of_the_gallery_moves_in_the_site(visit, web):
    visit.goto(f"{web[0]}docs/gallery.html")
    visit.locator("latolato-player canvas").first.wait_for()
    assert visit.get_by_text("does not move here").count() == 0


def test_examples_of_documentation_built_alone_say_what_they_need(visit, web):
    visit.route("**/latolato*.js", lambda route: route.fulfill(status=404))
    visit.goto(f"{web[0]}docs/how-to/in-your-page.html")
    visit.get_by_text("they need the site around the documentation").wait_for()
    visit.wait_for_load_state("networkidle")
    assert visit.locator("form input").count() == 0
    assert all("404" in fault for fault in visit.faults)
    visit.faults.clear()


def test_files_that_are_kept_are_those_of_the_pages(web):
    _, folder = web
    text = (folder / "files.js").read_text().removeprefix("self.SITE = ").rstrip(";\n")
    paths = json.loads(text)["paths"]
    assert {"index.html", "latolato.js", "registry.json", "kernels/one.wasm"} <= set(paths)
    assert {"languages/en.json", "languages/id.json"} <= set(paths)
    assert {"stories/contents.json", "stories/why_twice.toml"} <= set(paths)
    styles = re.findall(r'rel="stylesheet" href="(.+?)"', (folder / "index.html").read_text())
    assert styles
    assert set(styles) <= set(paths)
    # A site has no code of views that need Python.
    assert not [path for path in paths if path.startswith(("js/measure", "js/analyse"))]
    assert all((folder / path).is_file() for path in paths)
    sizes = {path: (folder / path).stat().st_size for path in paths}
    for is_scalar in (False, True):
        left_out = _code(folder, not is_scalar)
        first = sum(size for path, size in sizes.items() if Path(path).name not in left_out)
        assert first < 2_000_000, "the first visit loads all of this"


# Without its report a server that begins all the same ends at once.
@pytest.mark.parametrize("command", ["app --report none", "site out"])
def test_commands_without_code_for_pages_say_how_to_make_it(command, tmp_path, monkeypatch):
    monkeypatch.setattr("latolato.app.STATIC", tmp_path)
    monkeypatch.chdir(tmp_path)
    answer = CliRunner().invoke(app, command.split())
    assert "compiled code is missing; in a clone, run: make kernels" in str(answer.exception)


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
        (["site", str(tmp_path / "out"), "--report", str(empty)], "contains no report"),
        (["site", str(file), "--report", str(report), "--docs", str(empty)], "no documentation"),
    ):
        answer = run(arguments)
        assert answer.exit_code != 0
        assert words in str(answer.exception) + answer.output
    done = run(["site", str(tmp_path / "out"), "--report", str(report), "--json"])
    assert done.exit_code == 0, done.output
    assert json.loads(done.output)["files"] == [str(tmp_path / "out" / "index.html")]
    assert (tmp_path / "out" / "report" / "index.html").is_file()
    assert json.loads((tmp_path / "out" / "registry.json").read_text())["report"] is True
