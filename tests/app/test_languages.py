"""Other languages of the pages are complete, and pages in them show no English.

What a language lacks is named as JSON to fill in: see docs/how-to/translate.md.
"""

from __future__ import annotations

import ast
import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator, Mapping
from itertools import chain
from pathlib import Path
from typing import Any

import pytest

from app_pages import enter, new_context, open_view
from latolato.analysis.rules import RULES as OF_ANALYSES
from latolato.analysis.time_crystal import CAUTION
from latolato.app import STATIC
from latolato.app.analyse.forms import forms as analyses
from latolato.app.analyse.forms import label_of
from latolato.app.experiment.description import fields, fit_kinds
from latolato.app.experiment.finding import FINDINGS
from latolato.app.forms import registry
from latolato.app.rules import RULES as OF_WORK
from latolato.core.quantities import QUANTITIES
from latolato.core.rules import RULES
from latolato.experiment.fits.decay import LAWS
from latolato.experiment.fits.result import quantity_of
from latolato.experiment.rules import RULES as OF_MEASUREMENTS
from latolato.figures.map_title import OF_VARIABLE
from latolato.figures.run import ENERGIES, LEDGER
from latolato.io.tables.cells import DELIMITER_NAMES
from latolato.io.tables.kinds import KINDS
from latolato.io.tables.rules import RULES as OF_TABLES
from latolato.physics.problems import PROBLEMS
from latolato.simulation.record import WHOSE

NODE = Path(sys.executable).parent / "node"
PAPER = STATIC.parents[1] / "paper"
ENGLISH = STATIC / "languages" / "en.json"
FILES = sorted(set(ENGLISH.parent.glob("*.json")) - {ENGLISH})
GAP = re.compile(r"\{(@|@?\w+(?:=\w+)?)\}")
# How numbers are written, at the end of a gap; a translation leaves that to the English sentence.
DIGITS = re.compile(r":(\.\d+)?g\}")
# What the tables of stories hold that readers see.
TOLD = ("title", "summary", "text", "question", "answer", "label")
# Words that stand in the gaps of refusals.
WORDS = (
    "contact", "contact law", "drag_frame 'lab'", "drive", "got", "observable", "option",
    "parameter", "strings", "system", "value",
    # of fits, of the largest videos, and of tables
    *LAWS, "s", "pixels", "frames", "bytes", "table", "tables",
    *(kind.name for kind in KINDS), *DELIMITER_NAMES.values(),
)  # fmt: skip
# Words in results of analyses: what became of them, kinds of events, balls, systems.
RESULTS = (
    "all at once", "any push", "aperiodic", "ballpair", "bifurcation", "bottom", "branch point",
    "broad", "broken",
    "chaotic", "closed", "complete", "contradicted", "converged", "cusp", "degenerate",
    "degenerate pitchfork", "down", "drifting", "end of range", "event limit", "failed", "fold",
    "fold flip", "found", "generalised flip", "grazing", "hysteresis", "interrupted", "invalid",
    "inverted", "latolato", "left", "lift off", "locked", "longer period", "lost", "marginal",
    "mathieu", "meets flip", "meets fold", "neutral", "never stable", "no answer", "no hysteresis",
    "no impacts", "no motion", "no subharmonic", "no upper branch", "no upper edge",
    "no upper limit", "none passed", "not exponential", "not found", "not reached", "not settled",
    "out of reach", "outside model", "passed", "pendulum", "period doubling", "periodic",
    "point limit", "push", "reached from rest", "regular", "release", "resonance 1:1",
    "resonance 1:2", "rest", "rest ends", "right", "self-start", "singular", "slack", "slack onset",
    "slackens", "stable", "symmetry breaking", "taut", "top", "torus", "transient", "undecided",
    "unresolved", "unstable", "up", "valid", "without value", "yes", "no", "unknown",
)  # fmt: skip
# Quantities that analyses return, and what code calls others by parts.
RETURNED = (
    "angle", "angular_velocity", "angular_velocity_after", "distance", "growth_rate",
    "radial_velocity", "slack", "threshold_angle", "time", "dwell_time",
)  # fmt: skip
COMPOSED = (
    *WHOSE,
    *(name.replace("_", " ") for name in (*ENERGIES, *LEDGER, *chain(*OF_VARIABLE.values()))),
    "drive phase at the next impact", "drive periods after the transient",
    *(f"first push ({push})" for push in ("angular velocity", "angle")),
    *(f"share of {cells}{end}" for cells in ("all cells", "the cells not at rest")
      for end in ("", ", low end", ", high end")),
    *(f"initial {name} there{ball}" for name in ("angle", "angular velocity")
      for ball in ("", ", right", ", left")),
)  # fmt: skip
# Numbers that fits give, and columns that they need.
NUMBERS = (
    "amplitude_drift", "angle_1", "angle_2", "angle_offset", "centre_length", "coulomb_damping",
    "crank_ratio", "damping", "damping_envelope", "decay_rate", "decay_rate_envelope",
    "drive_frequency_final", "drive_phase", "frequency_drift", "horizontal_amplitude",
    "horizontal_phase", "initial_angle", "initial_angular_velocity", "length",
    "natural_frequency", "period", "pivot_error_x", "pivot_error_y", "pivot_y",
    "quadratic_damping", "ramp", "restitution", "step_time",
)  # fmt: skip
# Return the texts of a language that are not translated, and its texts that nothing needs.
_COMPARE = """
import { setLanguage, tr } from "TABLE";
const { needed, texts } = JSON.parse(await new Response(process.stdin).text());
const keys = Object.keys(texts);
const marked = Object.fromEntries(keys.map((text, i) => [text, `<${i}>`]));
setLanguage("xx", { name: "", strings: {}, texts: marked, rules: {} });
const missing = needed.filter((text) => !tr(text).startsWith("<"));
const used = new Set(needed.map(tr));
console.log(JSON.stringify({ missing, unused: keys.filter((text) => !used.has(marked[text])) }));
"""


def in_node(program: str, given: Any = None) -> Any:
    """Return what a program prints in Node.js."""
    program = program.replace("TABLE", (STATIC / "js" / "strings.js").as_uri())
    done = subprocess.run(
        [NODE, "--input-type=module", "-e", program],
        input=json.dumps(given), capture_output=True, text=True, timeout=60,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def english():
    """The texts of the pages by their names."""
    return json.loads(ENGLISH.read_text(encoding="utf-8"))["strings"]


def forms_of(text: Any) -> list[str]:
    """Return the plural forms of a text."""
    return list(text.values()) if isinstance(text, dict) else [text]


def texts_of_registry() -> Iterator[str]:
    """Yield the texts that the registry brings to Play, Live and Map."""
    about = registry()
    for part in ("systems", "drives", "contact_laws"):
        for law in about[part].values():
            yield law["description"]
    for part in ("systems", "drives"):
        yield from (law["title"] for law in about[part].values())
    for drive in about["drives"].values():
        if drive["amplitude_limit"]:
            yield drive["amplitude_limit"][1]
    for option in about["options"].values():
        yield from (option["label"], option["description"], *option["choices"])
    yield from (axis["label"] for axis in about["axes"].values())
    for observable in about["observables"].values():
        yield observable["description"]
        for variable in observable["variables"].values():
            yield from (variable["label"], *(name for name, _ in variable["classes"]))
    for part in about["curves"].values():
        yield from (each["label"] for each in part.values())
    for scenario in about["scenarios"].values():
        yield from (
            scenario[key] for key in ("title", "question", "description") if key in scenario
        )


def texts_of_analyses() -> Iterator[str]:
    """Yield the texts of analyses and their options on pages, and of what diagrams vary."""
    for form in analyses().values():
        yield from (form[part] for part in ("title", "summary", "notes", "reading"))
        for option in form["options"].values():
            yield from [option["label"], option["description"], *option["labels"].values()]
    for name, axis in registry()["axes"].items():
        yield label_of(name, axis["unit"])


def texts_of_results() -> Iterator[str]:
    """Yield what tables of analyses, and pictures, say."""
    # The report has words of its own: `test_the_frame_of_the_report_has_indonesian_words`.
    for path in set(STATIC.parents[1].rglob("*.py")) - set(PAPER.rglob("*.py")):
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(call, ast.Call) and isinstance(call.func, ast.Name):
                is_label = call.func.id == "Quantity" and path.parent.name == "analysis"
                said = call.args[2:3] if is_label else call.args[: call.func.id == "tr"]
                yield from texts_in(said)
    yield from (*RESULTS, *COMPOSED, CAUTION, *(QUANTITIES[name].long_name for name in RETURNED))


def texts_in(said: list[ast.expr]) -> Iterator[str]:
    """Yield the texts of an argument, which may choose between two."""
    for each in said:
        for part in (each.body, each.orelse) if isinstance(each, ast.IfExp) else (each,):
            if isinstance(part, ast.Constant) and isinstance(part.value, str):
                yield part.value


def texts_of_measure() -> Iterator[str]:
    """Yield what Measure calls its fields, its fits and the numbers that it shows first."""
    for field in fields().values():
        yield from (field["label"], field["description"])
    for kind in fit_kinds():
        yield from (kind["title"], kind["hint"])
        yield from (quantity_of(name).long_name for name in kind["headline"])
    yield from (quantity_of(name).long_name for name in NUMBERS)


def texts_of_stories(part: Any) -> Iterator[str]:
    """Yield what a story, or a part of one, says."""
    parts = part.items() if isinstance(part, dict) else enumerate(part)
    for key, value in parts:
        if isinstance(value, dict | list):
            yield from texts_of_stories(value)
        elif key in TOLD:
            yield value


def sentences_of_rules() -> dict[str, dict[str, str]]:
    """Return the sentences of all rules that pages know, by the names of the rules."""
    problems = {problem.name: (problem.rule, problem.way_out) for problem in PROBLEMS}
    tables: tuple[Mapping[str, Any], ...] = (
        RULES, OF_WORK, OF_ANALYSES, OF_MEASUREMENTS, OF_TABLES, FINDINGS, problems,
    )  # fmt: skip
    names = [name for table in tables for name in table]
    assert len(set(names)) == len(names)
    return {
        name: {part: text for part, text in zip(("rule", "way_out"), texts, strict=True) if text}
        for table in tables
        for name, texts in table.items()
        if any(texts)
    }


def sentences_of_pages() -> dict[str, dict[str, str]]:
    """Return the English sentences of all rules as pages say them."""
    own = json.loads(ENGLISH.read_text(encoding="utf-8"))["rules"]
    return {name: parts | own.get(name, {}) for name, parts in sentences_of_rules().items()}


def one_line(text: str) -> str:
    """Return a text without its line breaks."""
    return " ".join(text.split())


def needed_texts() -> list[str]:
    """Return every text that is born as data, once."""
    stories = [tomllib.loads(path.read_text("utf-8")) for path in STATIC.glob("stories/*.toml")]
    texts = [
        *texts_of_registry(),
        *texts_of_analyses(),
        *texts_of_results(),
        *texts_of_measure(),
        *texts_of_stories(stories),
        *WORDS,
    ]
    return list(dict.fromkeys(line for line in map(one_line, texts) if re.search("[A-Za-z]", line)))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_language_has_every_text_and_no_other(path, english):
    table = json.loads(path.read_text(encoding="utf-8"))
    compared = in_node(_COMPARE, {"needed": needed_texts(), "texts": table["texts"]})
    rules = sentences_of_rules()
    missing = {
        "strings": {name: english[name] for name in english if name not in table["strings"]},
        "rules": {
            name: parts
            for name, parts in rules.items()
            if parts.keys() != table["rules"].get(name, {}).keys()
        },
        "texts": {text: text for text in compared["missing"]},
    }
    unknown = [name for name in table["strings"] if name not in english] + compared["unused"]
    unknown += [name for name in table["rules"] if name not in rules]
    named = json.dumps(missing, ensure_ascii=False, indent=2)
    if any(missing.values()):
        pytest.fail(f"{path.name} lacks what stands here in English:\n{named}", pytrace=False)
    assert not unknown, f"nothing needs these of {path.name}"


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_translations_have_the_gaps_of_the_english_texts(path, english):
    table = json.loads(path.read_text(encoding="utf-8"))
    pairs = [(english[name], text) for name, text in table["strings"].items() if name in english]
    pairs += table["texts"].items()
    rules = sentences_of_pages()
    pairs += [
        (DIGITS.sub("}", rules[name][part]), text)
        for name, parts in table["rules"].items()
        for part, text in parts.items()
    ]
    wrong = {
        form: sorted(gaps)
        for source, text in pairs
        for form in forms_of(text)
        if (gaps := set(GAP.findall(str(forms_of(source))))) != set(GAP.findall(form))
    }
    assert not wrong, f"{path.name}: these should have the gaps beside them"
    assert all("other" in text for _, text in pairs if isinstance(text, dict))


def test_english_pages_say_in_their_own_words_only_sentences_that_there_are():
    known = sentences_of_rules()
    for name, parts in json.loads(ENGLISH.read_text(encoding="utf-8"))["rules"].items():
        for part, text in parts.items():
            own = DIGITS.sub("}", known[name][part])
            assert text != own
            # A page names what it has; values come with the rule.
            values = {gap for gap in GAP.findall(text) if not gap.startswith("@")}
            assert values <= set(GAP.findall(own))


def test_analyses_break_every_rule_of_theirs():
    texts = {path: path.read_text() for path in (STATIC.parents[1]).rglob("*.py")}
    broken = re.findall(r'broken_analysis\(\s*"(\w+)"', "".join(texts.values()))
    own = "".join(text for path, text in texts.items() if path.parent.name == "analysis")
    warned = re.findall(r'\b(?:said|warn|note)\(\s*"(\w+)"', own)
    # Chosen by the position of the balls, the kind of an option, the period, and a status.
    chosen = {"hanging_points", "upright_points", "value_of_each", "such_values",
              "no_bifurcation", "no_bifurcation_of_several", "no_upper_limit"}  # fmt: skip
    assert OF_ANALYSES.keys() == {*broken, *warned, *chosen}


# The views that are read, and what they show.
VIEWS = {
    "toy": "",
    "held": "",
    "map": "&map.scenario=fig05_push&map.duration=20&map.size=12",
}
# What a reader sees or hears of a page, each text once, without code, symbols and marked English.
_READ = """() => {
  const aside = "script, style, noscript, code, pre, sub, #language, [lang=en]";
  const texts = [];
  const walk = document.createTreeWalker(document.documentElement, NodeFilter.SHOW_ALL);
  for (let node = walk.nextNode(); node; node = walk.nextNode()) {
    const element = node instanceof Element ? node : node.parentElement;
    if (!element || element.closest(aside)) continue;
    if (node instanceof Text) texts.push(node.data);
    else if (node instanceof Element)
      for (const name of ["aria-label", "title", "alt", "placeholder"])
        texts.push(node.getAttribute(name) ?? "");
  }
  return [...new Set(texts.map((text) => text.replace(/\\s+/g, " ").trim()))];
}"""


def english_shapes(english: dict[str, Any], table: dict[str, Any]) -> list[re.Pattern[str]]:
    """Return what English texts look like that a language puts in other words."""
    pairs = [
        (form, table["strings"].get(name)) for name in english for form in forms_of(english[name])
    ]
    shapes = []
    for text, other in [*pairs, *table["texts"].items()]:
        letters = re.findall(r"[A-Za-z]{3,}", GAP.sub(" ", text))
        if other != text and letters:
            parts = GAP.split(text)[::2]
            shapes.append(re.compile(".+?".join(map(re.escape, parts))))
    return shapes


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_views_show_no_english_and_fit_a_phone(page, path, view, english):
    table = json.loads(path.read_text(encoding="utf-8"))
    page.set_viewport_size({"width": 390, "height": 844})
    open_view(page, f"{VIEWS[view]}&lang={path.stem}", view)
    for summary in page.locator("main summary").filter(visible=True).all():
        summary.click()
    assert page.evaluate("() => document.documentElement.lang") == path.stem
    shown = page.evaluate(_READ)
    shapes = english_shapes(english, table)
    names = registry()["axes"]  # shown as hints
    left = [
        text
        for text in shown
        if text not in names and any(shape.fullmatch(text) for shape in shapes)
    ]
    assert left == []
    assert table["strings"]["view_toy"] in shown
    assert page.evaluate("() => document.documentElement.scrollWidth") <= 390


def spoken(page: Any) -> str:
    """Return the language of a page that is ready."""
    page.wait_for_selector("[data-runs]")
    return str(page.evaluate("() => document.documentElement.lang"))


def test_a_reader_chooses_a_language_and_keeps_it(page):
    page.goto("/?view=toy&scenario=fig02&duration=5%20s")
    assert spoken(page) == "en"
    names = page.locator("#language option").all_inner_texts()
    assert names == ["English", "Bahasa Indonesia (beta)"]
    with page.expect_navigation():
        page.get_by_label("Language").select_option("id")
    assert spoken(page) == "id"
    # What was on show is still there, and links say its language.
    assert "scenario=fig02" in page.url
    assert "duration=5+s" in page.url
    assert "lang=id" in page.url
    assert "lang=id" in page.locator("#views a").nth(1).get_attribute("href")
    page.goto("/?view=toy")
    assert spoken(page) == "id"
    assert page.url.endswith("?view=toy")
    # A link has the last word, for this once.
    page.goto("/?view=toy&lang=en")
    assert spoken(page) == "en"
    page.goto("/?view=toy")
    assert spoken(page) == "id"


def test_a_browser_says_what_its_reader_prefers(browser, server):
    context = new_context(browser, base_url=server.address, locale="id-ID")
    page = context.new_page()
    page.goto("/?view=toy")
    assert spoken(page) == "id"
    context.close()


def test_an_unknown_language_is_named_and_left_out(page):
    page.goto("/?view=toy&lang=xx")
    page.get_by_text("the language “xx”, which is not here. The page is in English.").wait_for()
    assert spoken(page) == "en"
    page.get_by_label("How far the hand moves, slider").press("ArrowRight")
    page.wait_for_function("() => location.search.includes('drive_amplitude')")
    assert "lang" not in page.url


def test_a_refusal_stands_in_the_language_of_the_page(page):
    page.goto("/?view=toy&lang=id")
    spoken(page)
    page.get_by_text("Parameter lain", exact=True).click()
    field = page.get_by_label("jari-jari satu bola", exact=False).first
    enter(field, "2000")
    page.get_by_text(
        "“jari-jari satu bola” harus sedikitnya 0 mm dan di bawah panjang 200 mm, "
        "tetapi diberikan 2000"
    ).first.wait_for()


def test_a_language_is_one_file(page):
    """A third language is found by its file, and the page speaks it."""
    about = registry() | {"server": True}
    about["languages"] = {**about["languages"], "eo": {"name": "Esperanto", "beta": True}}
    table = {
        "name": "Esperanto",
        "strings": {"view_map": "Mapo"},
        "rules": {},
        "texts": {"gravitational acceleration": "gravita akcelo"},
    }
    page.route("**/registry.json", lambda route: route.fulfill(json=about))
    page.route("**/languages/eo.json", lambda route: route.fulfill(json=table))
    page.goto("/?view=toy&lang=eo")
    assert spoken(page) == "eo"
    page.get_by_role("link", name="Mapo").wait_for()
    page.get_by_text("More parameters", exact=True).click()
    page.get_by_label("gravita akcelo g", exact=True).wait_for()


def test_english_comes_with_the_page_and_once(page):
    asked = []
    page.on("request", lambda request: asked.append(request.url.rpartition("/")[2]))
    page.goto("/?view=toy")
    spoken(page)
    assert asked.count("en.json") == 1
    assert asked.index("en.json") < asked.index("strings.js")
    assert "id.json" not in asked


def test_a_language_whose_texts_do_not_come_is_told(page, watch):
    page.route("**/languages/id.json", lambda route: route.abort())
    page.goto("/?view=toy&lang=id")
    page.get_by_text("The texts in Bahasa Indonesia could not be loaded").wait_for()
    assert spoken(page) == "en"
    watch.faults[:] = [fault for fault in watch.faults if "ERR_FAILED" not in fault]


def test_a_table_of_languages_is_made_of_the_files():
    languages = registry()["languages"]
    assert languages.keys() == {"en", *(path.stem for path in FILES)}
    assert languages["en"] == {"name": "English", "beta": False}
    assert languages["id"] == {"name": "Bahasa Indonesia", "beta": True}


@pytest.mark.parametrize("code", ["en", "id"])
def test_no_text_of_a_language_stands_twice(code):
    def checked(pairs):
        names = [name for name, _ in pairs]
        assert len(set(names)) == len(names), sorted({n for n in names if names.count(n) > 1})
        return dict(pairs)

    text = (STATIC / "languages" / f"{code}.json").read_text(encoding="utf-8")
    json.loads(text, object_pairs_hook=checked)
