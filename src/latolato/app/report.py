"""The reproduction report for the pages: claims judged and figures drawn on demand.

What has been computed once is kept on disk, under the hash of everything that it was made with.
"""

from __future__ import annotations

import hashlib
import json
import re
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket

from latolato.app.answers import answered
from latolato.app.blocks import pack_files
from latolato.app.jobs import Job, serve_job
from latolato.core import cache
from latolato.core.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from latolato.paper.claim import Claim, Evidence
    from latolato.scenario.scenario import Scenario

_MADE_WITH = ("numpy", "scipy", "numba", "matplotlib", "xarray", "av", "opencv-python-headless")
_NUMBER = re.compile(r"(?P<number>\d+)(?P<panel>[a-z]*)")
_INDEX = re.compile(r"(?<![A-Za-z_])([Ayωθ])([0-9])(?![0-9A-Za-z_.])")
_LOWERED = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
# A hyphen before a number or between spaces.
_MINUS = re.compile(r"(?<![\w.-])-(?=\d)|(?<= )-(?= )")
# Runs of one figure that a page offers to open, and options in the label of each.
_MOST_CASES = 120
_MOST_PARTS = 3
# Blocks by key, name and source; one figure is some 200 kB.
_known: dict[tuple[str, str], bytes] = {}


def routes() -> list[BaseRoute]:
    """Return the routes of the view Paper."""
    return [Route("/api/paper", _contents), WebSocketRoute("/ws/paper", _figure)]


async def _contents(request: Request) -> Response:
    request.app.state.jobs.warm()
    report = request.app.state.report
    return await answered(request, lambda: JSONResponse(contents(report)))


async def _figure(websocket: WebSocket) -> None:
    state = websocket.app.state
    await serve_job(websocket, state.jobs, lambda request: prepare(request, state.report))


def contents(report: Path | None = None) -> list[dict[str, Any]]:
    """The paper's claims, figure by figure, before anything is computed.

    Parameters
    ----------
    report : Path, optional
        Folder of a report that `latolato reproduce` wrote, whose figures are used where it has
        them.
    """
    from latolato.paper import catalogue, chain

    result = []
    for name, evidence in catalogue.evidence().items():
        needs_video = evidence.needs_video
        if report is not None and (report / f"{name}.nc").is_file():
            needs_video = False
        result.append(
            {
                "name": name,
                "label": catalogue.title_of(name) if name.startswith("fig") else "Text",
                "title": evidence.title,
                "caption": pretty(evidence.caption),
                "statements": [
                    {"name": s.name, "where": s.where, "words": pretty(s.words)}
                    for s in evidence.statements
                ],
                "video": needs_video,
                "missing": chain.MISSING if needs_video and chain.is_missing() else "",
                "scenarios": scenarios_of(name),
            }
        )
    return result


@lru_cache(maxsize=1)
def _scenarios_by_figure() -> dict[str, list[str]]:
    """Return the names of shipped scenarios by the figure that they belong to."""
    from latolato.paper import catalogue
    from latolato.scenario.scenario import scenarios

    known = catalogue.figures()
    result: dict[str, list[str]] = {}
    for name, scenario in scenarios().items():
        for part in filter(None, map(_NUMBER.fullmatch, scenario.figure.split(", "))):
            base = f"fig{int(part['number']):02d}"
            own = f"{base}{part['panel']}"
            places = result.setdefault(own if own in known else base, [])
            if name not in places:
                places.append(name)
    return result


def scenarios_of(figure: str) -> list[str]:
    """Return the names of the shipped scenarios that belong to a figure.

    Examples
    --------
    >>> scenarios_of("fig03"), scenarios_of("fig03cd"), scenarios_of("fig08_chain")
    (['fig03a', 'fig03b'], ['fig03cd'], ['fig08'])
    """
    return _scenarios_by_figure().get(figure.removesuffix("_chain"), [])


def prepare(request: Any, report: Path | None = None) -> Job:
    """Return the job that makes a figure and judges its claims: ``{"figure": name}``.

    Raises
    ------
    InputError
        For an unknown name.
        If the figure goes through a video and the extra `video` is missing.
    """
    from latolato.core.registry import suggest
    from latolato.paper import catalogue, chain

    name = request.get("figure") if isinstance(request, Mapping) else None
    if not isinstance(name, str):
        raise InputError("a request must name a figure", value=request)
    known = catalogue.evidence()
    if name not in known:
        raise InputError(f"there is no figure '{name:.40}': {suggest(name, list(known))}")

    def finish(about: dict[str, Any], folder: Path) -> bytes:
        block = pack_files(about, {"svg": folder / f"{name}.svg"})
        _keep(name, block)
        return block

    ready = stored(name, report) if report is not None else None
    ready = ready or _kept(name)
    if ready is None and known[name].needs_video and chain.is_missing():
        raise InputError(chain.MISSING)
    return Job("figure", {"figure": name}, finish, ready)


def compute(
    request: Mapping[str, Any], folder: Path, progress: Callable[[float], None]
) -> dict[str, Any]:
    """Draw a figure quickly and judge its claims: what the job `figure` does in its process."""
    from latolato.figures import style
    from latolato.paper import catalogue

    name = request["figure"]
    evidence = catalogue.evidence()[name]
    dataset = evidence.data(quick=True)
    if evidence.draw:
        style.save_figure(evidence.draw(dataset), folder / f"{name}.svg")
    return {"name": name, "source": "quick", **about_figure(evidence, dataset)}


def stored(name: str, report: Path) -> bytes | None:
    """Return the block of a figure of a stored report, None if the report lacks it.

    Raises
    ------
    InputError
        If the file is not of this version.
    """
    from latolato.io.files import load
    from latolato.paper import catalogue

    path = report / f"{name}.nc"
    if not path.is_file():
        return None
    key = (f"{path.resolve()} {path.stat().st_mtime_ns}", name)
    if key not in _known:
        try:
            about = about_figure(catalogue.evidence()[name], load(path))
        except (AttributeError, KeyError) as error:
            raise InputError(
                f"'{path}' is not of this version ({error})", way_out="make the report again"
            ) from None
        about = {"name": name, "source": "report", **about}
        _known[key] = pack_files(about, {"svg": report / f"{name}.svg"})
    return _known[key]


def about_figure(evidence: Evidence, dataset: xr.Dataset) -> dict[str, Any]:
    """Return the claims that a dataset decides, the runs behind it and what was filmed for it."""
    claims = [claim_of(claim) for claim in evidence.judge(dataset)]
    made = pretty(str(dataset.attrs.get("chain", "")))
    return {"claims": claims, "cases": cases_of(dataset), "made": made}


def claim_of(claim: Claim) -> dict[str, Any]:
    """Return a judged claim as JSON knows it; powers of ten are written as people do."""
    from latolato.paper.report import SHAPES

    return {
        "name": claim.name,
        "where": claim.where,
        "words": pretty(claim.words),
        "finding": pretty(claim.finding),
        "criteria": [[pretty(text), held] for text, held in claim.criteria],
        "assumption": pretty(claim.assumption),
        "verdict": claim.verdict.name,
        "says": claim.verdict.value,
        "shape": SHAPES[claim.verdict],
        "why": pretty(claim.why),
    }


def pretty(text: str) -> str:
    """Return a text of the report as a page shows it: powers, indices and minus signs.

    Examples
    --------
    >>> pretty("A0 is at least 1e-09 m, 2-3 times l0")
    'A₀ is at least 10⁻⁹ m, 2-3 times l0'
    """
    from latolato.paper.report import plain

    text = _INDEX.sub(lambda match: match[1] + match[2].translate(_LOWERED), plain(text))
    return _MINUS.sub("\N{MINUS SIGN}", text)


def cases_of(dataset: xr.Dataset) -> list[dict[str, Any]]:
    """Return the runs behind a figure: what tells each from the others, and all its options."""
    from latolato.app.run_request import options_of
    from latolato.scenario.scenario import Scenario

    if "scenario" not in dataset or "case" not in dataset.coords:
        return []
    runs, short = [], []
    for text in dataset["scenario"].values.ravel()[:_MOST_CASES]:
        scenario = Scenario.from_dict(json.loads(str(text)))
        runs.append(options_of(scenario))
        short.append(_short_options(scenario) | _end_of(scenario, dataset))
    names = dict.fromkeys(name for run in runs for name in run)
    differing = [n for n in names if len({json.dumps(run.get(n)) for run in runs}) > 1]
    labels = dataset["case"].values.tolist() if "case" in dataset.coords else []
    return [
        {
            "label": _case_label(labels[i] if i < len(labels) else "", run, differing),
            "options": short[i],
        }
        for i, run in enumerate(runs)
    ]


def _short_options(scenario: Scenario) -> dict[str, Any]:
    """Return the options of a scenario without those that say what holds anyway."""
    from inspect import signature

    from latolato.app.lines import defaults_of
    from latolato.app.run_request import options_of
    from latolato.simulation.run import simulate

    usual = {name: p.default for name, p in signature(simulate).parameters.items()}
    usual |= defaults_of(scenario)
    if not scenario.system.has_contacts:
        usual["contact"] = "none"
    options = options_of(scenario)
    return {n: v for n, v in options.items() if n in ("system", "drive") or usual.get(n, ...) != v}


def _end_of(scenario: Scenario, dataset: xr.Dataset) -> dict[str, float]:
    """Return the duration of a run whose scenario lists its instants."""
    if "duration" in scenario.run or "time" not in dataset:
        return {}
    return {"duration": float(dataset["time"].values[-1])}


def _case_label(label: Any, run: Mapping[str, Any], differing: list[str]) -> str:
    """The label of a run, with the first values in which it differs from the others."""
    from latolato.figures.style import pretty_unit
    from latolato.scenario.options import law_options

    parts = []
    for name in differing:
        value = run.get(name)
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            unit = law_options()[name].unit
            unit = "" if unit in ("", "1") else f" {pretty_unit(unit)}"
            parts.append(f"{name.replace('_', ' ')} {value:.6g}{unit}")
        elif isinstance(value, str):
            parts.append(f"{name} {value}".replace("_", " "))
    words = str(label).replace("_", " ")
    return f"{words}: {', '.join(parts[:_MOST_PARTS])}" if parts else words


@lru_cache(maxsize=1)
def made_with() -> str:
    """Return a digest of all sources and libraries that figures are made with."""
    digest = hashlib.sha256(sys.version.encode())
    root = Path(__file__).resolve().parents[1]
    for path in sorted(path for path in root.rglob("*") if path.suffix in (".py", ".toml")):
        digest.update(path.relative_to(root).as_posix().encode())
        digest.update(path.read_bytes())
    for name in _MADE_WITH:
        with suppress(PackageNotFoundError):
            digest.update(f"{name} {version(name)}".encode())
    return digest.hexdigest()[:24]


def _place(name: str) -> Path:
    """The path of a figure's cached block."""
    return cache.cache_directory() / "paper" / made_with() / f"{name}.block"


def _kept(name: str) -> bytes | None:
    """Return the block of a figure that was made before, None if there is none."""
    if ("", name) in _known:
        return _known["", name]
    with suppress(OSError, ValueError):
        block = cache.read(_place(name))
        _known["", name] = block
        return block
    return None


def _keep(name: str, block: bytes) -> None:
    """Keep the block of a figure; where the disk is full it is computed again next time."""
    _known["", name] = block
    with suppress(OSError):
        cache.write(_place(name), block)
