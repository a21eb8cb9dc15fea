"""The report on the paper is a page of its own, beside the pages and linked with them."""

import ast
import re
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from unittest import mock

import pytest
from starlette.testclient import TestClient
from typer.testing import CliRunner

import latolato.paper
from app_pages import new_context
from app_server import start_server, stop_server
from latolato.app import serve as app_serve
from latolato.app.server import Settings, make_app
from latolato.cli.main import app
from latolato.paper import catalogue, report
from latolato.paper.claim import Verdict
from latolato.paper.page_words import CLAIMS_NOTE, INDONESIAN
from quick_figures import picture_of, quick_data

HOME = "http://127.0.0.1:8000"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A report of two figures: one of runs, one that is a map."""

    def shared(name):
        entry = catalogue.figures()[name]
        return replace(
            entry, data=lambda *, quick: quick_data(name), draw=lambda _: picture_of(name)
        )

    folder = tmp_path_factory.mktemp("made") / "report"
    entries = {name: shared(name) for name in ("fig03", "fig03cd")}
    with (
        mock.patch.object(catalogue, "evidence", return_value=entries),
        mock.patch.object(catalogue, "results", return_value={}),
    ):
        report.reproduce(folder, quick=True)
    return folder


@pytest.fixture(scope="module")
def address(folder):
    """The address of a server with this report."""
    server = start_server("--report", str(folder))
    yield server.address
    stop_server(server)


def test_the_server_serves_the_files_of_a_report_and_no_others(folder):
    server = make_app(Settings(report=folder))
    with TestClient(server, base_url=HOME) as client:
        page = client.get("/report/index.html")
        assert page.content == (folder / "index.html").read_bytes()
        assert "style-src 'unsafe-inline'" in page.headers["content-security-policy"]
        assert "script-src" not in page.headers["content-security-policy"]
        assert client.get("/report/fig03.nc").content == (folder / "fig03.nc").read_bytes()
        assert client.get("/report/none.nc").status_code == 404
        assert client.get("/report/%2e%2e/secret").status_code == 404
        assert client.get("/registry.json").json()["report"] is True


def test_a_folder_without_a_report_is_refused_before_the_server_starts(tmp_path):
    with pytest.raises(ValueError, match="latolato reproduce"):
        app_serve.serve(port=0, browser=False, report=tmp_path)


def test_the_report_in_the_usual_folder_is_served_without_being_named(tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr(app_serve, "serve", lambda *_, report, **__: asked.append(report))
    monkeypatch.chdir(tmp_path)
    CliRunner().invoke(app, ["app"], catch_exceptions=False)
    Path("latolato-report").mkdir()
    Path("latolato-report", "index.html").touch()
    CliRunner().invoke(app, ["app"], catch_exceptions=False)
    CliRunner().invoke(app, ["app", "--report", "another"], catch_exceptions=False)
    assert asked == [None, Path("latolato-report"), Path("another")]


def test_without_a_report_the_page_says_how_to_build_one(page):
    for query in ("view=report", "view=paper&paper.figure=fig03"):
        page.goto(f"/?{query}")
        page.get_by_text("into the folder latolato-report. It takes two to five minutes").wait_for()
        assert page.get_by_text("latolato reproduce --quick").is_visible()
        assert page.locator(".message:visible").count() == 0
        page.wait_for_url("**/?view=report")


def test_the_bar_and_old_addresses_lead_to_the_report(browser, address):
    context = new_context(browser)
    page = context.new_page()
    faults = []
    page.on("console", lambda m: m.type == "error" and faults.append(m.text))
    page.goto(address)
    page.get_by_role("link", name="Report", exact=True).click()
    page.wait_for_url("**/report/index.html")
    page.goto(f"{address}?view=paper&paper.figure=fig03cd")
    page.wait_for_url("**/report/index.html#fig03cd")
    for part in ("", "&paper.figure=fig03cd"):
        page.goto(f"{address}?view={'paper' if part else 'report'}{part}&lang=id")
        page.wait_for_url(f"**/report/index.html#id-{'fig03cd' if part else 'top'}")
    page.goto(f"{address}?view=paper&paper.figure=fig03cd&lang=en")
    page.wait_for_url("**/report/index.html#fig03cd")
    picture = page.locator("#fig03 img")
    assert picture.evaluate("i => i.decode().then(() => i.naturalWidth)") > 300
    # The styles of the page are used, and nothing is refused.
    assert page.locator("#fig03").evaluate("f => getComputedStyle(f).borderRadius") == "12px"
    page.get_by_role("link", name="Back to the toy").click()
    page.wait_for_selector("[data-runs]")
    assert faults == []
    context.close()


def test_the_frame_of_the_report_has_indonesian_words():
    text = files(latolato.paper).joinpath("report.html").read_text("utf-8")
    frame = text[text.index("{% macro list") :]
    # Texts begin with a capital, but for heads of columns; labels of attributes are no text.
    heads = re.findall(r"numbers\(\(([^)]+)\)", frame)
    wanted = set(re.findall(r'(?<!d=)"([A-Z][^"#{}<>]*)"', frame))
    wanted |= {each for head in heads for each in re.findall(r'"([^"]+)"', head)} - {", "}
    wanted |= {CLAIMS_NOTE, *(verdict.value for verdict in Verdict)}
    for path in Path(latolato.paper.__file__).parent.glob("*.py"):
        for call in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(call, ast.Call) and getattr(call.func, "id", "") == "tr":
                wanted |= {each.value for each in ast.walk(call) if isinstance(each, ast.Constant)}
    assert len(wanted) > 40
    assert wanted - {"Site", "Contents"} <= INDONESIAN.keys()


def test_the_report_opens_in_indonesian_and_stays_so(browser, address):
    context = new_context(browser)
    page = context.new_page()
    page.goto(f"{address}?view=toy&lang=id")
    page.get_by_role("link", name="Laporan", exact=True).click()
    page.wait_for_url("**/report/index.html#id-top")
    page.get_by_role("heading", name="dihitung ulang").wait_for()
    page.get_by_text("berbahasa Inggris, seperti makalahnya").wait_for()
    for name in ("Claims", "Verdict", "Back to the toy", "How to cite"):
        assert page.get_by_text(name, exact=True).filter(visible=True).count() == 0
    page.get_by_role("link", name="Pernyataan", exact=True).click()
    page.wait_for_url("**#id-claims")
    page.wait_for_function(
        "() => document.querySelector('#id-claims').getBoundingClientRect().top < 100"
    )
    page.get_by_role("heading", name="Pernyataan").wait_for()
    claim = page.locator("figure .meta a.id").first
    claim.click()
    page.get_by_role("columnheader", name="Penilaian").wait_for()
    assert "#id-claim-" in page.url
    page.set_viewport_size({"width": 390, "height": 844})
    page.get_by_text("Yang kami temukan").filter(visible=True).first.wait_for()
    page.get_by_role("link", name="English").click()
    page.get_by_role("heading", name="recalculated").wait_for()
    assert page.get_by_text("Penilaian", exact=True).filter(visible=True).count() == 0
    context.close()


def test_links_of_the_indonesian_report_open_the_pages_in_indonesian(browser, address):
    context = new_context(browser)
    page = context.new_page()
    page.goto(f"{address}report/index.html#id-top")
    page.locator("details").evaluate_all("all => all.forEach((each) => { each.open = true; })")
    ways = page.locator('a[href^="../"]').filter(visible=True)
    addresses = ways.evaluate_all("all => all.map((each) => each.getAttribute('href'))")
    assert len(addresses) > 5
    assert all(each.endswith("lang=id") for each in addresses)
    page.get_by_role("link", name="Buka di Peta: ").first.wait_for()
    page.get_by_role("link", name="Buka di Mainan: Resonansi pada 6 rad/s").click()
    page.wait_for_selector("[data-runs]")
    assert "scenario=fig03a" in page.url
    assert page.evaluate("() => document.documentElement.lang") == "id"
    context.close()


def test_who_chose_english_in_the_report_keeps_it(browser, address):
    context = new_context(browser, locale="id-ID")
    page = context.new_page()
    spoken = "() => document.documentElement.lang"
    page.goto(address)
    page.get_by_role("link", name="Laporan", exact=True).click()
    page.get_by_role("link", name="English").click()
    page.get_by_role("link", name="Open in Toy: Resonance at 6 rad/s").click()
    page.wait_for_selector("[data-runs]")
    assert page.evaluate(spoken) == "en"
    page.get_by_role("link", name="Report", exact=True).click()
    page.get_by_role("link", name="Back to the toy").click()
    page.wait_for_selector("[data-runs]")
    assert page.evaluate(spoken) == "en"
    context.close()


@pytest.mark.parametrize(
    "figure, name, ready, wanted",
    [
        ("fig03", "Open in Toy: Resonance at 6 rad/s", "[data-runs]", "scenario=fig03a"),
        ("fig03", "quiet: angular driving", "[data-runs]", "drive_frequency=5.9"),
        ("fig03cd", "Open in Map: ", "[data-done]", "view=map&lang=en&map.scenario=fig03cd"),
        ("fig03cd", "undamped", "[data-done]", "map.x=frequency_ratio"),
    ],
)
def test_links_at_a_figure_open_its_runs(browser, address, figure, name, ready, wanted):
    context = new_context(browser)
    page = context.new_page()
    page.goto(f"{address}report/index.html")
    plate = page.locator(f"#{figure}")
    plate.locator("details", has_text="behind it").evaluate_all(
        "all => all.forEach((each) => { each.open = true; })"
    )
    plate.get_by_role("link", name=name).click()
    page.wait_for_selector(ready)
    assert wanted in page.url
    assert page.locator(":is(.message, .error):visible").all_inner_texts() == []
    context.close()
