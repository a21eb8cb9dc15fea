"""The report's page: one HTML file with everything in it, readable on paper and on a phone."""

from __future__ import annotations

import base64
import json
import platform
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from html import escape
from importlib import import_module
from importlib.resources import files
from pathlib import Path
from string import Template
from types import ModuleType
from typing import TYPE_CHECKING, Any

from latolato.core.quantities import QUANTITIES
from latolato.core.versions import version_of
from latolato.figures.style import pretty_unit
from latolato.paper.catalogue import title_of
from latolato.paper.claim import Claim, Verdict
from latolato.paper.powers import rewritten_powers

if TYPE_CHECKING:
    import xarray as xr

LIBRARIES = ("latolato", "numpy", "scipy", "numba", "xarray", "matplotlib")
# Left out of tables of parameters: what changes no number, and zeros of what is rarely used.
_OMITTED = ("frame",)
_OFTEN_ZERO = ("quadratic_damping", "coulomb_damping", "drive_phase", "initial_angular_velocity")
_CLASSES = {
    Verdict.REPRODUCED: "yes",
    Verdict.ASSUMED: "part",
    Verdict.NOT_AS_PRINTED: "no",
    Verdict.METHOD_CHECK: "check",
}


@dataclass(frozen=True, kw_only=True)
class Part:
    """One module's share of the report; `caption` is None for text without a picture.

    A result beyond the paper has `words` instead of claims: what was found, how it was checked.
    """

    name: str
    title: str
    caption: str | None
    dataset: xr.Dataset
    claims: tuple[Claim, ...]
    warnings: tuple[str, ...]
    words: tuple[str, str] | None = None


def render(
    paper: ModuleType,
    parts: Sequence[Part],
    folder: Path,
    *,
    quick: bool,
    left_out: Sequence[str] = (),
) -> str:
    """Return the page on a paper; pictures are read from `folder` and embedded."""
    from latolato import cite

    about = import_module(f"{paper.__name__}.about")
    claims = [claim for part in parts for claim in part.claims]
    template = Template(files("latolato.paper").joinpath("report.html").read_text("utf-8"))
    sections = ("claims", "later", "figures", "strings", "errata", "method", "rerun", "cite")
    names = (
        "Claims",
        "Still open",
        "Figures",
        "Strings",
        "Errata",
        "Method",
        "Compute again",
        "Cite",
    )
    contents = "".join(
        f'<li><a href="#{section}">{name}</a></li>'
        for section, name in zip(sections, names, strict=True)
    )
    kind = "A quick run: some scans have fewer points." if quick else "A full run."
    return template.substitute(
        style=files("latolato.report").joinpath("page.css").read_text("utf-8"),
        title=_text(about.TITLE),
        version=escape(version_of()),
        lead=_text(about.LEAD),
        meta=_text(
            f"latolato {version_of()}, {datetime.now(UTC):%Y-%m-%d}. {kind} {about.CONVENTIONS}"
        ),
        tally=_tally(claims),
        contents=contents,
        claims_note=_text(
            "A claim is reproduced if all its limits hold for the printed parameters. It is "
            "reproduced with an assumption if they hold once something unprinted is assumed, and "
            "not as printed otherwise. Where the paper prints too little to test its claim, we "
            "check only the method, on synthetic data or by calculation; such a check says "
            "nothing about the paper's measurements. ✓ marks limits that hold, ✗ limits that fail."
        ),
        claims=_claims(claims),
        deferred=_left_out(left_out) + _deferred(about.DEFERRED, {claim.name for claim in claims}),
        figures="".join(
            _figure(part, folder) for part in parts if part.caption is not None and not part.words
        ),
        strings="".join(_figure(part, folder) for part in parts if part.words),
        errata=_list(about.ERRATA),
        method=_method(parts, about.METHOD),
        rerun=_rerun(parts, paper.__name__),
        cite=escape(cite()),
        footer=_text(
            f"Written by latolato {version_of()}. This file is self-contained; the pictures and "
            "data next to it are for further use."
        ),
    )


def _text(text: str) -> str:
    """Return escaped text with subscripts, minus signs and powers of ten set."""
    minus = "\N{MINUS SIGN}"
    text = escape(text, quote=False)
    text = rewritten_powers(text, lambda power: f"<sup>{power.replace('-', minus)}</sup>")
    text = re.sub(r"(?<![A-Za-z_&#])(A|y)([0-9])(?![0-9A-Za-z_])", r"\1<sub>\2</sub>", text)
    text = re.sub(r"ω([0-9])(?![0-9]|\.[0-9])", r"ω<sub>\1</sub>", text)
    text = re.sub(r"θ(min|max)", r"θ<sub>\1</sub>", text).replace("m_rod", "m<sub>rod</sub>")
    # A hyphen before a number or between spaces is a minus.
    return re.sub(r"(?<![\w.>-])-(?=\d|[A-Zm]l? ?\w)|(?<= )-(?= )", minus, text)


def _list(items: Iterable[str]) -> str:
    """Return an unordered list of plain texts."""
    return "<ul>" + "".join(f"<li>{_text(item)}</li>" for item in items) + "</ul>"


def _shape(verdict: Verdict) -> str:
    """Return the shape that stands for a verdict."""
    name = f"#shape-{_CLASSES[verdict]}"
    return f'<svg class="shape" aria-hidden="true"><use href="{name}"/></svg>'


def _tally(claims: Sequence[Claim]) -> str:
    """Return how many claims met each verdict."""
    items = []
    for verdict in Verdict:
        count = sum(claim.verdict is verdict for claim in claims)
        items.append(
            f'<li class="{_CLASSES[verdict]}"><b>{count}</b>{_shape(verdict)} '
            f"{escape(verdict.value)}</li>"
        )
    return f'<ul class="tally">{"".join(items)}</ul>'


def _claims(claims: Sequence[Claim]) -> str:
    """Return the table of claims."""
    rows = "".join(_claim(claim) for claim in claims)
    heads = ("Verdict", "The paper's words", "What we find", "Why")
    return f'<table class="claims">{_head(heads)}<tbody>{rows}</tbody></table>'


def _head(names: Iterable[str]) -> str:
    """Return the head of a table."""
    cells = "".join(f'<th scope="col">{escape(name)}</th>' for name in names)
    return f"<thead><tr>{cells}</tr></thead>"


def _claim(claim: Claim) -> str:
    """Return one row of the table of claims."""
    verdict = escape(claim.verdict.value)
    badge = (
        f'<span class="badge {_CLASSES[claim.verdict]}">{_shape(claim.verdict)}'
        f"<span>{verdict}</span></span>"
    )
    criteria = "".join(_criterion(text, held) for text, held in claim.criteria)
    cells = (
        f'<td class="place">{badge}<span class="where">{_text(claim.where)}</span></td>',
        f'<td class="quote" data-label="The paper\'s words"><q>{_text(claim.words)}</q></td>',
        f'<td data-label="What we find">{_text(claim.finding)}',
        f'<ul class="criteria">{criteria}</ul></td>',
        f'<td data-label="Why">{_assumed([claim.assumption])}',
        f'<p class="why">{_text(claim.why)}</p></td>',
    )
    return f'<tr id="{_anchor(claim)}">{"".join(cells)}</tr>'


def _criterion(text: str, held: bool) -> str:
    """Return one number beside its limit."""
    kind, mark, spoken = ("held", "✓", "held") if held else ("failed", "✗", "did not hold")
    sign = f'<span class="mark" role="img" aria-label="{spoken}">{mark}</span>'
    return f'<li class="{kind}">{sign}{_text(text)}</li>'


def _assumed(assumptions: Iterable[str]) -> str:
    """Return a paragraph for each assumption that no other one says in full."""
    texts = [text for text in dict.fromkeys(assumptions) if text]
    return "".join(
        f'<p class="assumed"><b>Assumed:</b> {_text(text)}</p>'
        for text in texts
        if not any(text in other for other in texts if other != text)
    )


def _anchor(claim: Claim) -> str:
    """Return the identifier of a claim's row."""
    return "claim-" + re.sub(r"[^a-z0-9]+", "-", claim.name.lower())


def _deferred(open_claims: Iterable[tuple[str, str, str, str]], judged: set[str]) -> str:
    """Return the list of claims that later work decides."""
    rows = "".join(
        f"<li><b>{_text(where)}</b>: {_text(words)}. <i>Needs {_text(needs)}.</i></li>"
        for name, where, words, needs in open_claims
        if name not in judged
    )
    return f"<ul>{rows}</ul>"


def _left_out(texts: Sequence[str]) -> str:
    """Return the list of figures that could not be made."""
    return f"<p>Left out of this report:</p>{_list(texts)}" if texts else ""


def _figure(part: Part, folder: Path) -> str:
    """Return one figure with its caption, parameters and files."""
    picture = base64.b64encode((folder / f"{part.name}.png").read_bytes()).decode("ascii")
    name = "" if part.words else f"{title_of(part.name)}: "
    source = f"data:image/png;base64,{picture}"
    links = ", ".join(
        f'<a href="{part.name}{suffix}">{part.name}{suffix}</a>'
        for suffix in (".png", ".svg", ".nc")
    )
    judged = ", ".join(
        f'<a href="#{_anchor(claim)}">{_text(claim.name.replace("-", " "))}</a> '
        f"({escape(claim.verdict.value)})"
        for claim in part.claims
    )
    claims = "" if part.words else f"Claims: {judged or 'none'}. "
    pieces = (
        f'<figure class="plate" id="{part.name}"><div class="paper">',
        f'<img alt="{name}{escape(part.title)}" src="{source}"></div><figcaption>',
        f"<h3>{name.replace(': ', '. ')}{_text(part.title)}</h3><p>{_text(part.caption or '')}</p>",
        _assumed(claim.assumption for claim in part.claims),
        _words(part.words),
        f'<p class="meta">{claims}{_ledger_sentence(part.dataset)}</p>',
        f"<details><summary>Parameters</summary>{_parameters(part.dataset)}</details>",
        f'<p class="files">Files beside this page: {links}</p></figcaption></figure>',
    )
    return "".join(pieces)


def _words(words: tuple[str, str] | None) -> str:
    """Return the paragraph on a result beyond the paper."""
    if words is None:
        return ""
    finding, check = words
    return f"<p>{_text(finding)}</p><p><b>Checked:</b> {_text(check)}</p>"


def _scenarios(dataset: xr.Dataset) -> list[dict[str, Any]]:
    """Return the runs' parameters as flat dictionaries."""
    if "scenario" not in dataset:
        return []
    runs = []
    for text in dataset.scenario.values:
        flat: dict[str, Any] = {}
        for part, entries in json.loads(str(text)).items():
            for name, value in entries.items():
                flat[f"{part} kind" if name == "kind" else name] = value
        runs.append(flat)
    return runs


def _sweeps(dataset: xr.Dataset) -> list[dict[str, Any]]:
    """Return the sweeps' parameters as flat dictionaries, an axis as the words for its values."""
    if "plan" not in dataset:
        return []
    sweeps = []
    for text in dataset.plan.values:
        plan = json.loads(str(text))
        flat: dict[str, Any] = {}
        for part in ("system", "drive", "contact", "start"):
            for name, value in plan[part].items():
                flat[f"{part} kind" if name == "kind" else name] = value
        named = [
            (name, values)
            for axis in plan["axes"]
            for name, values in zip(axis["parameters"], axis["values"], strict=True)
        ]
        if any(name == "frequency_ratio" for name, _ in named):
            flat.pop("drive_frequency", None)
        for name, values in named:
            flat[name] = f"{len(values)} from {min(values):.4g} to {max(values):.4g}"
        for name in ("duration", "transient", "tolerance"):
            flat[name] = plan[name]
        if plan["continuation"]:
            flat["followed along"] = _meaning(plan["continuation"])
        sweeps.append(flat)
    return sweeps


def _parameters(dataset: xr.Dataset) -> str:
    """Return the table of parameters: one value each, or the values over the runs."""
    runs = _scenarios(dataset) + _sweeps(dataset)
    rows = []
    if not runs:
        scalars = [
            (str(name), dataset[name]) for name in dataset.data_vars if not dataset[name].dims
        ]
        rows = [(name, [value.item()]) for name, value in scalars]
    else:
        names = dict.fromkeys(name for run in runs for name in run)
        for name in names:
            values = list(dict.fromkeys(json.dumps(run.get(name)) for run in runs))
            if name not in _OMITTED and not (
                name in _OFTEN_ZERO and set(values) <= {"0.0", "null"}
            ):
                rows.append((name, [json.loads(value) for value in values]))
    body = (
        f'<tr><th scope="row">{_text(_meaning(name))}</th>'
        f"<td>{_text(_values(name, values))}</td></tr>"
        for name, values in rows
    )
    return _scrolled(("parameter", "value"), body)


def _scrolled(heads: Iterable[str], rows: Iterable[str]) -> str:
    """Return a table of numbers that scrolls on a narrow screen."""
    body = f"{_head(heads)}<tbody>{''.join(rows)}</tbody>"
    return f'<div class="scroll"><table class="numbers">{body}</table></div>'


def _row(cells: Iterable[str]) -> str:
    """Return a row of a table."""
    return "<tr>" + "".join(f"<td>{_text(cell)}</td>" for cell in cells) + "</tr>"


def _meaning(name: str) -> str:
    """Return the description of a parameter."""
    return QUANTITIES[name].long_name if name in QUANTITIES else name.replace("_", " ")


def _values(name: str, values: list[Any]) -> str:
    """Return the values of a parameter with their unit, a range where there are many."""
    unit = pretty_unit(QUANTITIES[name].unit) if name in QUANTITIES else ""
    unit = "" if unit in ("", "1") else f" {unit}"
    known = [value for value in values if value is not None]
    if len(known) > 8 and all(isinstance(value, (int, float)) for value in known):
        return f"{len(known)} values from {min(known):.6g} to {max(known):.6g}{unit}"
    if len(known) > 8:
        return f"{_value(known[0])} … {_value(known[-1])}{unit} ({len(known)} values)"
    return ", ".join(_value(value) for value in known) + unit


def _value(value: Any) -> str:
    """Return one value as text."""
    if isinstance(value, float):
        return f"{value:.8g}"
    if isinstance(value, list):
        return "[" + ", ".join(_value(each) for each in value) + "]"
    return str(value)


def _ledger(dataset: xr.Dataset) -> tuple[int, float]:
    """Return the number of exact runs and the worst residual of their energy ledgers, relative."""
    if "energy_residual" not in dataset:
        return 0, 0.0
    exact = [run.get("contact") != "clamp" for run in _scenarios(dataset)]
    relative = (dataset.energy_residual / dataset.largest_energy).values[exact]
    count, worst = len(relative), float(relative.max())
    if "scan_runs" in dataset:
        count += int(dataset.scan_runs)
        worst = max(worst, float(dataset.scan_residual))
    return count, worst


def _grouped(count: int) -> str:
    """Return a count with its thousands apart."""
    return f"{count:,}".replace(",", "\N{NARROW NO-BREAK SPACE}")


def _ledger_sentence(dataset: xr.Dataset) -> str:
    """Return how well the energy ledger closes, in words."""
    if "chain" in dataset.attrs:
        return _text(str(dataset.attrs["chain"]))
    if "plan" in dataset:
        points, lost = int(dataset.points.sum()), int(dataset.unanswered.sum())
        return _text(f"{_grouped(points)} runs, of which {lost or 'none'} ended without an answer.")
    count, worst = _ledger(dataset)
    if count == 0:
        return "Nothing is integrated here."
    runs = "The run's" if count == 1 else f"Of {count} runs the worst"
    return _text(f"{runs} energy ledger closes to {worst:.0e} of the largest energy.")


def _method(parts: Sequence[Part], words: str) -> str:
    """Return how the numbers were made, with each part's residuals and the versions."""
    rows = []
    for part in parts:
        count, worst = _ledger(part.dataset)
        if count == 0:
            continue
        runs = _scenarios(part.dataset)
        tolerances = sorted({run["tolerance"] for run in runs})
        steps = part.dataset.step.values
        contacts = int((part.dataset.bottom_contacts + part.dataset.top_contacts).sum())
        cells = (
            part.name,
            part.title,
            str(count),
            ", ".join(f"{tolerance:.0e}" for tolerance in tolerances),
            " to ".join(dict.fromkeys(f"{1e3 * step:.3g}" for step in (steps.min(), steps.max()))),
            _grouped(contacts),
            f"{worst:.0e}",
        )
        rows.append(_row(cells))
    heads = ("part", "", "exact runs", "tolerance [rad]", "step [ms]", "contacts", "worst residual")
    versions = ", ".join(f"{name} {version_of(name)}" for name in LIBRARIES)
    notes = [f"{part.name}: {text}" for part in parts for text in part.warnings]
    return (
        "<p>"
        + _text(words)
        + f"</p>{_scrolled(heads, rows)}{_method_of_maps(parts)}"
        + (f"<p>Warnings of the runs:</p>{_list(notes)}" if notes else "")
        + f'<p class="meta">{_text(f"Python {platform.python_version()}, {versions}.")}</p>'
    )


def _method_of_maps(parts: Sequence[Part]) -> str:
    """Return the table of the sweeps."""
    rows = []
    for part in parts:
        for label, flat, points, lost in zip(
            part.dataset.get("sweep", ()),
            _sweeps(part.dataset),
            part.dataset.get("points", ()),
            part.dataset.get("unanswered", ()),
            strict=True,
        ):
            cells = (
                part.name,
                str(label.item()),
                _grouped(int(points)),
                f"{flat['duration']:g}",
                f"{1e3 * flat['step']:g} ms steps"
                if "step" in flat
                else f"{flat['tolerance']:.0e}",
                str(int(lost)),
            )
            rows.append(_row(cells))
    if not rows:
        return ""
    heads = ("part", "sweep", "runs", "duration [s]", "tolerance [rad]", "without an answer")
    return _scrolled(heads, rows)


def _rerun(parts: Sequence[Part], package: str) -> str:
    """Return how to make the report, one figure and one run again."""
    pictures = [part for part in parts if part.caption is not None]
    example = next((part.name for part in pictures if _scenarios(part.dataset)), pictures[0].name)
    code = (
        f"from {package} import {example}\n"
        "from latolato.figures.style import save_figure\n\n"
        f"dataset = {example}.data()          # an xarray.Dataset, also in {example}.nc\n"
        f'save_figure({example}.draw(dataset), "{example}.svg")'
    )
    return (
        "<p>The whole report, then one figure:</p><pre>latolato reproduce</pre>"
        f"<pre>{escape(code)}</pre><p>"
        + _text(
            "Each data file contains the scenario of each run as JSON: system, drive, start. The "
            "files of maps contain the plan of each sweep."
        )
        + "</p>"
    )
