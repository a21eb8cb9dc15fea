"""The report: complete, self-contained, well-formed, and never half-written."""

import errno
import html
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace
from typing import ClassVar
from unittest import mock

import numpy as np
import pytest

from latolato.cli.reproduce import print_result
from latolato.core.language import Language, speaking
from latolato.figures import style
from latolato.io.files import load
from latolato.paper import about, catalogue, page, report
from latolato.paper.claim import Verdict
from latolato.paper.links import links_to_maps, links_to_presets, links_to_runs
from latolato.paper.page_words import LANGUAGES
from quick_figures import EVIDENCE, RESULTS, picture_of, quick_data

VOID = {"meta", "img", "br", "hr", "path", "circle", "rect", "use", "link", "input"}


class Reader(HTMLParser):
    """Collects identifiers and addresses, and checks that tags are closed in order."""

    def __init__(self):
        super().__init__()
        self.open, self.ids, self.links, self.sources, self.text = [], [], [], [], []

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.ids += [values["id"]] if "id" in values else []
        self.links += [values["href"]] if "href" in values else []
        self.sources += [values[key] for key in ("src", "srcset", "data") if key in values]
        assert tag not in ("script", "iframe", "link", "object"), f"<{tag}> may load something"
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text.append(data)


def shared(name, evidence):
    """Return evidence whose quick data and picture are those that all tests share."""

    def data(*, quick):
        assert quick
        return quick_data(name)

    def draw(dataset):
        assert dataset is quick_data(name)
        return picture_of(name)

    return replace(evidence, data=data, draw=draw if evidence.draw else None)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    fractions = []
    folder = tmp_path_factory.mktemp("report") / "out"
    everything = {name: shared(name, each) for name, each in EVIDENCE.items()}
    results = {name: shared(name, each) for name, each in RESULTS.items()}
    with (
        mock.patch.object(catalogue, "evidence", return_value=everything),
        mock.patch.object(catalogue, "results", return_value=results),
    ):
        result = report.reproduce(folder, quick=True, progress=fractions.append)
    return result, fractions


@pytest.fixture(scope="module")
def read(made):
    reader = Reader()
    reader.feed(made[0].index.read_text(encoding="utf-8"))
    reader.close()
    return reader


@pytest.fixture
def one_figure(monkeypatch):
    """Only the drawing of the model, which needs no run."""
    only = {"fig01": catalogue.figures()["fig01"]}
    monkeypatch.setattr(catalogue, "evidence", lambda paper: only)
    monkeypatch.setattr(catalogue, "results", lambda paper: {})
    return only


def test_all_files_are_written(made):
    folder = made[0].index.parent
    expected = {"index.html"} | {f"{name}.nc" for name in (*catalogue.evidence(), *RESULTS)}
    pictures = (*catalogue.figures(), *RESULTS)
    expected |= {f"{name}{s}" for name in pictures for s in (".png", ".svg")}
    assert {path.name for path in folder.iterdir()} == expected
    assert {path.name for path in folder.parent.iterdir()} == {folder.name}


def test_results_say_what_was_found_and_how_it_was_checked(made, read):
    # A subscript is an element of its own, yet belongs to its word.
    text = re.sub(r"\s+", " ", "".join(read.text))
    for name, each in RESULTS.items():
        assert name in read.ids
        part = text.split(each.title)[1]
        assert part.index(each.finding.split("{")[0][:30]) < part.index("Checked:")
    assert "Claims: none." not in text.split("Beyond the paper")[1].split("Errata")[0]


def test_the_result_holds_index_and_claims(made):
    result = made[0]
    names = [s.name for each in catalogue.evidence().values() for s in each.statements]
    assert result.index.name == "index.html"
    assert [claim.name for claim in result.claims] == names
    assert Path(result) == result.index


def test_progress_rises_from_zero_to_one(made):
    fractions = made[1]
    assert fractions[0] == 0.0
    assert fractions[-1] == 1.0
    assert np.all(np.diff(fractions) >= 0.0)


def test_the_page_is_well_formed(read):
    assert read.open == []
    assert len(read.ids) == len(set(read.ids))


def test_links_have_indonesian_words(made):
    class Noting(dict):
        """Texts that note which of them are missing."""

        missing: ClassVar = set()

        def get(self, text, default):
            self.missing |= set() if text in self else {text}
            return super().get(text, default)

    with speaking(Language(Noting(LANGUAGES["id"].texts), ",")):
        for name in (*EVIDENCE, *RESULTS):
            dataset = quick_data(name)
            links = links_to_presets(name) + links_to_runs(dataset) + links_to_maps(dataset)
            assert all(not re.search(r"\d\.\d", link.text) for link in links)
    # What is left has numbers and letters only, such as "eq10", "1.9000" and "a".
    words = {text for text in Noting.missing if re.search(r"[A-Za-z]{3}", text)}
    assert words == set()


def test_the_page_is_self_contained(made, read):
    assert read.sources
    assert all(source.startswith("data:image/png;base64,") for source in read.sources)
    inner = {f"#{name}" for name in read.ids}
    beside = {path.name for path in made[0].index.parent.iterdir()}
    for link in read.links:
        is_ours = link in inner or link in beside or link.startswith("../?view=")
        is_ours = is_ours or link in ("../?lang=en", "../?lang=id")
        assert is_ours, f"{link} leads out of the report"
    text = made[0].index.read_text(encoding="utf-8")
    assert not re.search(r"url\(|@import", text)
    assert "$" not in "".join(read.text)  # no placeholder is left


def test_every_claim_is_on_the_page_with_its_verdict_in_words(made, read):
    text = re.sub(r"\s+", " ", " ".join(read.text))
    assert len([name for name in read.ids if name.startswith("claim-")]) == len(made[0].claims)
    for verdict in Verdict:
        assert text.count(verdict.value) >= sum(c.verdict is verdict for c in made[0].claims)
    for claim in made[0].claims:
        assert claim.where.split(",")[0] in text


def test_no_figure_warns_of_anything(made):
    # The page lists warnings of runs; any other one is an error in all tests.
    assert "Warnings of the runs" not in made[0].index.read_text(encoding="utf-8")


def test_nothing_of_the_machine_is_on_the_page(made):
    text = made[0].index.read_text(encoding="utf-8")
    for secret in (str(made[0].index.parent), "/home/", "/root/", "/tmp/"):
        assert secret not in text


def test_open_claims_are_listed_until_they_are_judged():
    first, *others = about.DEFERRED
    assert page._open_claims(about.DEFERRED, set()) == [first, *others]
    assert page._open_claims(about.DEFERRED, {first[0]}) == others


@pytest.mark.parametrize(
    "text, html",
    [
        ("ω0 and 2ω0/n, ω/ω0.", "ω<sub>0</sub> and 2ω<sub>0</sub>/n, ω/ω<sub>0</sub>."),
        ("A0ω²/g, y0, ω1²", "A<sub>0</sub>ω²/g, y<sub>0</sub>, ω<sub>1</sub>²"),
        ("A0 = -0.5 m", "A<sub>0</sub> = \N{MINUS SIGN}0.5 m"),
        ("-Cθ', E - U", "\N{MINUS SIGN}Cθ', E \N{MINUS SIGN} U"),
        ("0-40 s, θ-t curve, self-start", "0-40 s, θ-t curve, self-start"),
        ("at most 1e-09 rad", "at most 10<sup>\N{MINUS SIGN}9</sup> rad"),
        ("0e+00 or 1e+16", "0 or 10<sup>16</sup>"),
        ("<b> & c", "&lt;b&gt; &amp; c"),
    ],
)
def test_symbols_are_set(text, html):
    assert page.typeset(text) == html


def test_small_factors_keep_their_digits():
    assert page.typeset("7.3e-14").replace("\N{NO-BREAK SPACE}", " ") == (
        "7.3 \N{MULTIPLICATION SIGN} 10<sup>\N{MINUS SIGN}14</sup>"
    )


def test_a_failed_report_leaves_an_earlier_one_as_it_was(one_figure, tmp_path, monkeypatch):
    folder = tmp_path / "out"
    report.reproduce(folder, quick=True)
    (folder / "notes.txt").write_text("mine")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}

    def fails(*_, **__):
        raise OSError("disk full")

    monkeypatch.setattr(page, "render", fails)
    with pytest.raises(OSError, match="disk full"):
        report.reproduce(folder, quick=True)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_a_second_report_replaces_the_first_and_keeps_other_files(one_figure, tmp_path):
    folder = tmp_path / "deep" / "out"
    report.reproduce(folder, quick=True)
    (folder / "notes.txt").write_text("mine")
    (folder / "fig01.png").write_bytes(b"old")
    report.reproduce(folder, quick=True)
    assert (folder / "notes.txt").read_text() == "mine"
    assert (folder / "fig01.png").read_bytes().startswith(b"\x89PNG")


def test_a_file_in_the_way_is_refused(tmp_path):
    target = tmp_path / "out"
    target.write_text("mine")
    with pytest.raises(NotADirectoryError, match="name a folder"):
        report.reproduce(target, quick=True)
    assert target.read_text() == "mine"


def test_warnings_of_runs_are_on_the_page(one_figure, tmp_path):
    import warnings

    figure = one_figure["fig01"]

    def data(quick=False):
        warnings.warn("the ledger is open", RuntimeWarning, stacklevel=2)
        return figure.data(quick)

    one_figure["fig01"] = replace(figure, data=data)
    result = report.reproduce(tmp_path / "out", quick=True)
    assert "the ledger is open" in result.index.read_text(encoding="utf-8")


def test_figures_that_need_videos_are_left_out_plainly(tmp_path, monkeypatch):
    from latolato.paper import chain

    only = {name: catalogue.figures()[name] for name in ("fig01", "fig07")}
    monkeypatch.setattr(catalogue, "evidence", lambda paper: only)
    monkeypatch.setattr(catalogue, "results", lambda paper: {})
    monkeypatch.setattr(chain, "is_missing", lambda: True)
    result = report.reproduce(tmp_path / "out", quick=True)
    (text,) = result.left_out
    assert text.startswith("Figure 7: it needs the extra video")
    assert 'pip install ".[video]"' in html.unescape(result.index.read_text())
    assert not (tmp_path / "out" / "fig07.png").exists()
    with pytest.raises(ValueError, match="films every trial"):
        report.reproduce(tmp_path / "out", full=True)


def test_a_report_is_quick_or_full(tmp_path):
    with pytest.raises(ValueError, match="quick or full"):
        report.reproduce(tmp_path / "out", quick=True, full=True)


def test_errors_name_the_folder_of_the_caller(one_figure, tmp_path, monkeypatch):
    folder = tmp_path / "rep"

    def full(path, *_, **__):
        raise OSError(errno.ENOSPC, "No space left on device", str(path))

    monkeypatch.setattr(style, "save_figure", lambda _, path, **__: full(path))
    for _ in range(2):  # a new folder, then one that exists
        with pytest.raises(OSError, match="No space left on device") as caught:
            report.reproduce(folder, quick=True)
        assert caught.value.filename == str(folder)
        folder.mkdir(exist_ok=True)
        assert list(folder.iterdir()) == []


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="needs a folder nobody can write to")
def test_a_folder_that_cannot_be_made_is_named():
    with pytest.raises(OSError, match="No such file or directory") as caught:
        report.reproduce("/proc/x", quick=True)
    assert caught.value.filename == "/proc/x"


@pytest.mark.parametrize("here", [".", "../there"])
def test_the_current_folder_may_be_named(one_figure, tmp_path, monkeypatch, here):
    folder = tmp_path / "there"
    folder.mkdir()
    monkeypatch.chdir(folder)
    report.reproduce(here, quick=True)
    assert (folder / "index.html").is_file()
    assert [path.name for path in tmp_path.iterdir()] == ["there"]


def test_an_assumption_within_another_is_stated_once():
    texts = ["A0 is 15 mm.", "A0 is 15 mm. It rests.", "", "A0 is 15 mm."]
    claims = [SimpleNamespace(assumption=text) for text in texts]
    assert page._assumptions(claims) == ["A0 is 15 mm. It rests."]


def test_captions_state_their_assumptions_once(read):
    """No two sentences of one caption share a run of six words."""
    text = re.sub(r"\s+", " ", " ".join(read.text))
    for number in ("6", "8"):
        caption = text.split(f"Figure {number}.")[1].split("Claims:")[0]
        words = re.findall(r"[\w.=]+", caption)
        runs = [tuple(words[i : i + 6]) for i in range(len(words) - 5)]
        assert len(runs) == len(set(runs)), f"Fig. {number} repeats itself"
        assert "Assumed" in caption


def test_the_terminal_shows_numbers_as_people_write_them(made):
    for claim in made[0].claims:
        text = report.plain(claim.finding)
        assert not re.search(r"\de[+-]\d", text), text
        assert not re.search(r"(?<![\d.])0\.0+(?!\d| %)", text), text


@pytest.mark.parametrize(
    "text, expected",
    [
        ("rise 0e+00 rad", "rise 0 rad"),
        ("of 1e+16.", "of 10¹⁶."),
        ("1.6e-04 of", "1.6 \N{MULTIPLICATION SIGN} 10⁻⁴ of"),
    ],
)
def test_powers_of_ten_are_raised_in_the_terminal(text, expected):
    assert report.plain(text).replace("\N{NO-BREAK SPACE}", " ") == expected


def test_the_settled_amplitude_has_the_same_digits_everywhere(made):
    claim = next(claim for claim in made[0].claims if claim.name == "saturation")
    figure = catalogue.figures()["fig02"].draw(load(made[0].index.parent / "fig02.nc"))
    (label,) = (t.get_text() for t in figure.axes[0].texts if t.get_text().startswith("0.8"))
    assert label == "0.8515 rad"
    assert label in claim.finding
    assert label in claim.why
    assert claim.numbers["lasting"] == pytest.approx(0.8514711, abs=5e-8)


def test_the_terminal_shows_every_claim_and_the_path(made, capsys):
    print_result(made[0], as_json=False)
    output = capsys.readouterr().out
    assert str(made[0].index) in output.replace("\n", "")
    words = " ".join(output.split())
    assert words.count("Assumed:") == sum(bool(claim.assumption) for claim in made[0].claims)
    assert "what the paper says" in words
    for verdict in Verdict:
        count = sum(claim.verdict is verdict for claim in made[0].claims)
        assert output.count(report.SHAPES[verdict]) == count
