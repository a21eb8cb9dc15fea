"""The report's page: one HTML file with everything in it, readable on paper and on a phone."""

from __future__ import annotations

import base64
import json
import platform
import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from functools import partial
from html import escape
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from markupsafe import Markup

import latolato.paper
from latolato.core.language import speaking, tr
from latolato.core.quantities import QUANTITIES
from latolato.core.versions import version_of
from latolato.figures.style import pretty_unit
from latolato.paper.catalogue import title_of
from latolato.paper.claim import Claim, Verdict
from latolato.paper.links import (
    PAGES,
    Link,
    flat_scenarios,
    in_language,
    links_to_maps,
    links_to_presets,
    links_to_runs,
    meaning,
)
from latolato.paper.page_words import CLAIMS_NOTE, ENGLISH_PARTS, LANGUAGES, link, words
from latolato.paper.powers import rewritten_powers
from latolato.report.templates import environment

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
    pages = environment("paper", "report")
    pages.filters |= {
        "typeset": typeset,
        "kind": _CLASSES.__getitem__,
        "words": partial(words, set_text=typeset),
        "link": lambda text, target: link(target, text, typeset),
    }
    claims = [claim for part in parts for claim in part.claims]
    judged = {claim.name for claim in claims}
    pictures = [part for part in parts if part.caption is not None]
    versions = ", ".join(f"{name} {version_of(name)}" for name in LIBRARIES)
    return pages.get_template("report.html").render(
        version=version_of(),
        back=_in_languages(lambda: [Link(text=tr("Back to the toy"), address=PAGES)]),
        title=typeset(about.TITLE),
        about=about,
        meta=f"latolato {version_of()}, {datetime.now(UTC):%Y-%m-%d}.",
        kind_of_run="A quick run: some scans have fewer points." if quick else "A full run.",
        english_parts=ENGLISH_PARTS,
        tally=[(each, sum(claim.verdict is each for claim in claims)) for each in Verdict],
        claims_note=CLAIMS_NOTE,
        claims=[_row_of(claim) for claim in claims],
        left_out=left_out,
        deferred=_open_claims(about.DEFERRED, judged),
        plates=[_plate(paper, part, folder) for part in pictures],
        runs_of_texts=[
            (part.title, links)
            for part in parts
            if part.caption is None and (links := _in_languages(links_to_runs, part.dataset))
        ],
        runs=_runs(parts),
        maps=_maps(parts),
        warnings=[f"{part.name}: {text}" for part in parts for text in part.warnings],
        versions=f"Python {platform.python_version()}, {versions}.",
        package=paper.__name__,
        example=next((p.name for p in pictures if flat_scenarios(p.dataset)), pictures[0].name),
        cite=cite(),
    )


def typeset(text: str) -> Markup:
    """Return escaped text with subscripts, minus signs and powers of ten set."""
    minus = "\N{MINUS SIGN}"
    text = escape(text, quote=False)
    text = rewritten_powers(text, lambda power: f"<sup>{power.replace('-', minus)}</sup>")
    text = re.sub(r"(?<![A-Za-z_&#])(A|y)([0-9])(?![0-9A-Za-z_])", r"\1<sub>\2</sub>", text)
    text = re.sub(r"ω([0-9])(?![0-9]|\.[0-9])", r"ω<sub>\1</sub>", text)
    text = re.sub(r"θ(min|max)", r"θ<sub>\1</sub>", text).replace("m_rod", "m<sub>rod</sub>")
    # A hyphen before a number or between spaces is a minus.
    return Markup(re.sub(r"(?<![\w.>-])-(?=\d|[A-Zm]l? ?\w)|(?<= )-(?= )", minus, text))


def _open_claims(
    deferred: Iterable[tuple[str, str, str, str]], judged: set[str]
) -> list[tuple[str, str, str, str]]:
    """Return the claims that later work decides."""
    return [row for row in deferred if row[0] not in judged]


def _row_of(claim: Claim) -> dict[str, Any]:
    return {**vars(claim), "anchor": _anchor(claim)}


def _anchor(claim: Claim) -> str:
    return "claim-" + re.sub(r"[^a-z0-9]+", "-", claim.name.lower())


def _assumptions(claims: Iterable[Claim]) -> list[str]:
    """Return the assumptions of claims, each once and none that another one says in full."""
    texts = [text for text in dict.fromkeys(claim.assumption for claim in claims) if text]
    return [text for text in texts if not any(text in other for other in texts if other != text)]


def _plate(paper: ModuleType, part: Part, folder: Path) -> dict[str, Any]:
    """The picture, texts, claims and links of one figure on the page."""
    picture = (folder / f"{part.name}.png").read_bytes()
    return {
        "name": part.name,
        "label": "" if part.words else f"{title_of(part.name)}: ",
        "title": part.title,
        "picture": base64.b64encode(picture).decode("ascii"),
        "caption": part.caption or "",
        "assumptions": _assumptions(part.claims),
        "words": part.words,
        "claims": [_row_of(claim) for claim in part.claims],
        "ledger": _ledger_sentence(part.dataset),
        "parameters": _parameters(part.dataset),
        # Shipped scenarios belong to figures of the paper that latolato began with.
        "presets": _in_languages(links_to_presets, part.name) if paper is latolato.paper else {},
        "runs": _in_languages(links_to_runs, part.dataset),
        "maps": _in_languages(links_to_maps, part.dataset),
    }


def _in_languages(make: Callable[..., list[Link]], *given: Any) -> dict[str, list[Link]]:
    """Return links in each language of the page, none if there are none."""
    made = {}
    for code, language in LANGUAGES.items():
        with speaking(language):
            links = make(*given)
        made[code] = [replace(each, address=in_language(each.address, code)) for each in links]
    return made if made["en"] else {}


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
                flat[part if name == "kind" else name] = value
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
            flat["followed along"] = meaning(plan["continuation"])
        sweeps.append(flat)
    return sweeps


def _parameters(dataset: xr.Dataset) -> list[tuple[str, str]]:
    """Return the parameters with their values, one each or those over the runs."""
    runs = flat_scenarios(dataset) + _sweeps(dataset)
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
    return [(meaning(name), _values(name, values)) for name, values in rows]


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
    exact = [run.get("contact") != "clamp" for run in flat_scenarios(dataset)]
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
        return str(dataset.attrs["chain"])
    if "plan" in dataset:
        points, lost = int(dataset.points.sum()), int(dataset.unanswered.sum())
        return f"{_grouped(points)} runs, of which {lost or 'none'} ended without an answer."
    count, worst = _ledger(dataset)
    if count == 0:
        return "Nothing is integrated here."
    runs = "The run's" if count == 1 else f"Of {count} runs the worst"
    return f"{runs} energy ledger closes to {worst:.0e} of the largest energy."


def _runs(parts: Sequence[Part]) -> list[tuple[str, ...]]:
    """Return the exact runs of each part: tolerances, steps, contacts and the worst residual."""
    rows: list[tuple[str, ...]] = []
    for part in parts:
        count, worst = _ledger(part.dataset)
        if count == 0:
            continue
        runs = flat_scenarios(part.dataset)
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
        rows.append(cells)
    return rows


def _maps(parts: Sequence[Part]) -> list[tuple[str, ...]]:
    """Return the sweeps of each part."""
    rows: list[tuple[str, ...]] = []
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
            rows.append(cells)
    return rows
