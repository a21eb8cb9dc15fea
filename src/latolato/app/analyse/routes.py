"""Analyses for the pages: asked as a form says, computed in a process of their own."""

from __future__ import annotations

import inspect
import math
import re
import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket

from latolato.app.analyse.forms import about_request, forms, label_of, own_options
from latolato.app.answers import answered, json_of
from latolato.app.blocks import pack_files
from latolato.app.given import MOST_LISTED, RunRequest, TooLargeError
from latolato.app.jobs import Job, serve_job
from latolato.app.lines import constructor, literal
from latolato.core.errors import InputError
from latolato.figures.analyses.question import question_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from latolato.core.parameters import Parameter

# Most steps of all motions together: minutes of work on two cores.
MOST_STEPS = 1e10
_STEPS_PER_PERIOD = 40.0
# Periods that are looked at after the transient, where no option says how many.
_WATCHED = 48.0
# How much longer a second run at a tenth of the tolerance makes the work.
_TWICE = 2.3
# Seconds that every answer takes, with its picture.
_LEAST_SECONDS = 1.0
_RANGE = re.compile(r"\s*[-+.\d][^:/\\]*:\s*[-+.\d][^:/\\]*:\s*(?P<count>\d{1,9})(?!\d)[^:/\\]*")
_OVER = re.compile(r"\(over (?P<dims>[^,)]*)(?P<rest>[^)]*)\)")
_PICTURE_DPI = 200
_BY = " \N{MULTIPLICATION SIGN} "


def routes() -> list[BaseRoute]:
    """Return the routes of the view Analyse."""
    return [
        Route("/api/analyses", _forms),
        Route("/api/analyses/about", _about, methods=["POST"]),
        Route("/api/analyses/cost", _cost, methods=["POST"]),
        WebSocketRoute("/ws/analyse", _analyse),
    ]


async def _forms(request: Request) -> Response:
    request.app.state.jobs.warm()
    return await answered(request, lambda: JSONResponse(forms()))


async def _about(request: Request) -> Response:
    body = await json_of(request)
    return await answered(request, lambda: JSONResponse(about_request(RunRequest.from_json(body))))


async def _cost(request: Request) -> Response:
    body = await json_of(request)

    def answer() -> Response:
        try:
            question = AnalysisRequest.from_json(body)
            arguments = question.arguments()
            check_work(question.function, arguments)
        except InputError as error:  # an answer as well: what is typed is unfinished
            return JSONResponse({"refused": str(error)})
        return JSONResponse({"seconds": round(seconds_of(question.function, arguments), 1)})

    return await answered(request, answer)


async def _analyse(websocket: WebSocket) -> None:
    await serve_job(websocket, websocket.app.state.jobs, prepare)


@dataclass(frozen=True)
class AnalysisRequest:
    """An analysis, what it is of, and the options that were typed for it."""

    name: str
    request: RunRequest
    settings: Mapping[str, str]

    @classmethod
    def from_json(cls, value: Any) -> AnalysisRequest:
        """Return what a page asks: ``{"analysis", "scenario", "options", "settings": texts}``.

        Raises
        ------
        InputError
            For another form, and for unknown analyses and options.
        """
        from latolato.analysis import analyses
        from latolato.core.registry import suggest

        request = RunRequest.from_json(value)
        name, settings = value.get("analysis"), value.get("settings") or {}
        if not isinstance(name, str):
            raise InputError("must be a name", parameter="analysis", value=name)
        function = analyses[name]
        if not isinstance(settings, Mapping) or not all(
            isinstance(v, str) for v in settings.values()
        ):
            raise InputError("must be an object of texts", parameter="settings")
        own, _ = own_options(function)
        for option in settings:
            if option not in own:
                raise InputError(
                    f"has no option '{option}': {suggest(option, list(own))}", parameter=name
                )
        return cls(name, request, {n: v.strip() for n, v in settings.items() if v.strip()})

    @property
    def function(self) -> Callable[..., Any]:
        """The analysis."""
        from latolato.analysis import analyses

        return analyses[self.name]

    def arguments(self) -> dict[str, Any]:
        """Return what the analysis is called with, as `latolato analyse` would.

        Raises
        ------
        InputError
            For wrong values and units, and for what the analysis needs and nobody gave.
        """
        from latolato.scenario.analysis_call import AnalysisCall
        from latolato.scenario.analysis_options import options_of

        own = options_of(self.function)
        typed = {name: _typed(own[name], text) for name, text in self.settings.items()}
        scenario = self.request.to_scenario()
        call = AnalysisCall(self.name, self.function, own)
        try:
            return call.arguments(None, typed, scenario.to_dict())
        except InputError as error:
            if scenario.varied:
                error.add_way_out(
                    f"{scenario.name or 'this scenario'} is a map: take a point of it"
                )
            raise

    def python(self, arguments: Mapping[str, Any]) -> str:
        """Return a Python program that asks the same."""
        parameters = inspect.signature(self.function).parameters
        lines = [
            "import latolato as ll",
            f"from latolato.analysis import {self.name}",
            "",
            f"system = {constructor(arguments['system'])}",
        ]
        texts = ["system"]
        if arguments.get("drive") is not None:
            lines.append(f"drive = {constructor(arguments['drive'])}")
            texts.append("drive")
        for name, value in arguments.items():
            if name in ("system", "drive") or value == parameters[name].default:
                continue
            is_law = hasattr(value, "__dataclass_fields__")
            texts.append(f"{name}={constructor(value) if is_law else literal(value)}")
        call = f"result = {self.name}({', '.join(texts)})"
        return "\n".join([*lines, call, f'll.plot(result).savefig("{self.name}.png")'])

    def command(self) -> str:
        """Return the command that asks the same, quoted for a shell."""
        from latolato.scenario.analysis_call import unfit_options
        from latolato.scenario.analysis_options import options_of
        from latolato.scenario.options import law_options

        own = options_of(self.function)
        unfit = set(unfit_options(self.function, own))
        words = ["latolato", "analyse", self.name.replace("_", "-")]
        if self.request.scenario:
            words.append(self.request.scenario)
        laws = law_options()
        request = {n: v for n, v in (self.request.options or {}).items() if v is not None}
        run = {n: v for n, v in request.items() if n in own and own[n].owner == "run"}
        law = {n: v for n, v in request.items() if n not in unfit and n not in run}
        for name, value in {**law, **run, **self.settings}.items():
            is_switch = own[name].kind is bool if name in own else laws[name].kind is bool
            flag = "--" + name.replace("_", "-")
            if is_switch:
                is_on = str(value).lower() == "true"
                if is_on or name in own:
                    words.append(flag if is_on else f"--no-{flag[2:]}")
                continue
            listed = isinstance(value, (list, tuple))
            text = ", ".join(map(str, value)) if listed else str(value)
            words += [f"{flag}={text}"] if text.startswith("-") else [flag, text]
        return shlex.join(words)


def _typed(option: Parameter, text: str) -> Any:
    """Return what the text of an option stands for; it never names a file.

    Raises
    ------
    InputError
        If it is of another kind.
    """
    if option.several:
        if ":" in text:
            match = _RANGE.fullmatch(text)
            if match is None or Path(text).is_file():
                raise InputError("must be low : high : count", parameter=option.name, value=text)
            if int(match["count"]) > MOST_LISTED:
                raise TooLargeError(f"{option.name} may have {MOST_LISTED} values at most")
            return text
        parts = [part.strip() for part in text.split(",") if part.strip()]
        if len(parts) > MOST_LISTED:
            raise TooLargeError(f"{option.name} may have {MOST_LISTED} values at most")
        return parts[0] if option.or_one and len(parts) == 1 else parts
    if option.kind is bool:
        if text.lower() not in ("true", "false"):
            raise InputError("must be true or false", parameter=option.name, value=text)
        return text.lower() == "true"
    if option.kind is int:
        if not re.fullmatch(r"[-+]?\d{1,18}", text):
            raise InputError("must be a whole number", parameter=option.name, value=text)
        return int(text)
    return text


def check_work(function: Callable[..., Any], arguments: Mapping[str, Any]) -> None:
    """Refuse, before any work, a question that would take very long.

    Raises
    ------
    TooLargeError
        With the number of steps and the limit.
    """
    steps = steps_of(function, arguments)
    if steps > MOST_STEPS:
        raise TooLargeError(
            f"this would take some {steps:.1g} steps, the limit is {MOST_STEPS:.0e}: ask for fewer "
            "points, values or periods"
        )


def steps_of(function: Callable[..., Any], arguments: Mapping[str, Any]) -> float:
    """Return roughly how many steps of motion an analysis takes, 0 if it does not say."""
    from latolato.scenario.analysis_options import options_of

    own, cost = options_of(function), question_of(function.__name__).cost
    known = {n: p.default for n, p in inspect.signature(function).parameters.items()}
    known |= arguments
    drive, system = known.get("drive"), known["system"]
    natural = float(system.natural_frequency)
    fastest = max(natural, float(drive.fastest_frequency) if drive is not None else 0.0)
    period = 2.0 * math.pi / float(getattr(drive, "drive_frequency", natural) or natural)

    def number(name: str, otherwise: float) -> float:
        value = known.get(name)
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        return abs(float(value)) if is_number else otherwise  # type: ignore[arg-type]

    if "transient_periods" in known:
        watched = number("periods", 3.0 * number("longest", _WATCHED / 3.0))
        span = (number("transient_periods", 0.0) + watched) * period
    elif "duration" in known:
        span = number("duration", 0.0)
    elif "settling" in known:
        span = number("settling", 0.0)
    else:
        return 0.0
    many = math.prod(max(number(name, 1.0), 1.0) for name in cost.counts)
    if "check_tolerance" in known:
        many *= _TWICE
    for name, option in own.items():
        value = known.get(name)
        if option.several and option.owner != "run" and isinstance(value, (list, tuple)):
            many *= max(len(value), 1)
        elif value is None:
            many *= cost.lengths.get(name, 1)
    return many * span * fastest / (2.0 * math.pi) * _STEPS_PER_PERIOD


def seconds_of(function: Callable[..., Any], arguments: Mapping[str, Any]) -> float:
    """Return roughly how long an answer takes [s], once its kernels are compiled."""
    rate = question_of(function.__name__).cost.steps_per_second
    return _LEAST_SECONDS + steps_of(function, arguments) / rate


def prepare(body: Any) -> Job:
    """Return the job that answers a page's question.

    Raises
    ------
    InputError
        For bad input, and for a question that would take very long.
    """
    question = AnalysisRequest.from_json(body)
    arguments = question.arguments()
    check_work(question.function, arguments)

    def finish(about: dict[str, Any], folder: Path) -> bytes:
        lines = {"python": question.python(arguments), "command": question.command()}
        return pack_files({**about, **lines}, {p.suffix[1:]: p for p in folder.iterdir()})

    request = question.request
    sent: dict[str, Any] = {"scenario": request.scenario, "options": dict(request.options or {})}
    sent |= {"analysis": question.name, "settings": question.settings}
    return Job("analyse", sent, finish)


def compute(
    request: Mapping[str, Any], folder: Path, progress: Callable[[float], None]
) -> dict[str, Any]:
    """Answer a question and write the result: what the job `analyse` does in its process."""
    import warnings

    from latolato.figures.plot import plot
    from latolato.figures.style import save_figure
    from latolato.io.files import save

    question = AnalysisRequest.from_json(request)
    result = question.function(**question.arguments())
    save(result, folder / "result.nc")
    (folder / "result.csv").write_text(to_csv(result), encoding="utf-8")
    panels: list[dict[str, Any]] = []
    try:
        figure = plot(result)
    except InputError as error:  # without a picture
        warnings.warn(str(error), RuntimeWarning, stacklevel=1)
    else:
        save_figure(figure, folder / "result.png", dpi=_PICTURE_DPI)
        save_figure(figure, folder / "result.svg")
        panels = panels_of(figure, result)
    words = question_of(question.name)
    return {
        "analysis": question.name,
        "verdict": words.verdict(result),
        "lines": numbers_of(result),
        "panels": panels,
    }


def numbers_of(dataset: xr.Dataset) -> list[tuple[str, str]]:
    """Return what an analysis found as rows of a table: what it is, and its value with unit."""
    from latolato.analysis.summary import as_lines

    rows = []
    for name, text in as_lines(dataset.squeeze()).items():
        if name == "analysis":
            continue
        variable = dataset.variables.get(name)
        label = str(variable.attrs.get("long_name") or name) if variable is not None else name
        rows.append((label[:1].upper() + label[1:].replace("_", " "), _OVER.sub(_counted, text)))
    return rows


def _counted(match: re.Match[str]) -> str:
    """Return how many values a range is of, for a text that names their dimensions."""
    sizes = re.findall(r"(?<=\w )\d+(?= x |$)", match["dims"])
    return f"({_BY.join(sizes)} values{match['rest']})"


def panels_of(figure: Figure, dataset: xr.Dataset) -> list[dict[str, Any]]:
    """Return the panels on which a point stands for parameters or for a start.

    Returns
    -------
    list of dict
        ``box``: left, top, right and bottom as shares of the picture; ``x`` and ``y``: the option,
        its unit and its values at both ends, None where an axis is of something else.
    """
    panels = []
    for axes in figure.axes:
        x = _axis_of(dataset, axes, "x")
        y = _axis_of(dataset, axes, "y")
        if x is None and y is None:
            continue
        place = axes.get_position()
        box = [place.x0, 1.0 - place.y1, place.x1, 1.0 - place.y0]
        panels.append({"box": [float(side) for side in box], "x": x, "y": y})
    return panels


def _axis_of(dataset: xr.Dataset, axes: Any, side: str) -> dict[str, Any] | None:
    """Return the option along a straight axis of a picture, by the label of a coordinate."""
    from latolato.figures.style import label
    from latolato.scenario.options import law_options

    if getattr(axes, f"get_{side}scale")() != "linear":
        return None
    shared = getattr(axes, f"get_shared_{side}_axes")().get_siblings(axes)
    texts = {getattr(each, f"get_{side}label")() for each in [axes, *shared]} - {""}
    for name, variable in dataset.coords.items():
        if name not in law_options() or (
            str(name).startswith("initial") and "ball" in dataset.dims
        ):
            continue
        if texts & {label(variable), label(variable, short=True)}:
            low, high = getattr(axes, f"get_{side}lim")()
            unit = str(variable.attrs.get("units", "1"))
            return {
                "name": str(name),
                "unit": "" if unit == "1" else unit,
                "label": label_of(str(name)),
                "ends": [float(low), float(high)],
            }
    return None


def to_csv(dataset: xr.Dataset) -> str:
    """Return an analysis as text: its labels, its single numbers, a table for each shape."""
    import csv
    import io

    import numpy as np

    from latolato.io.files import without_complex

    plain = without_complex(dataset)
    text = io.StringIO()
    write = csv.writer(text, lineterminator="\n").writerow
    for key, value in plain.attrs.items():
        print(f"# {key}: {' '.join(str(value).split())}", file=text)
    tables: dict[tuple[str, ...], list[str]] = {}
    for name, variable in plain.data_vars.items():
        tables.setdefault(tuple(map(str, variable.dims)), []).append(str(name))
    for dims, names in sorted(tables.items(), key=lambda item: len(item[0])):
        print(f"\n# over {', '.join(dims) or 'nothing'}", file=text)
        shape = tuple(plain.sizes[dim] for dim in dims)
        grids = np.meshgrid(*(plain[dim].values for dim in dims), indexing="ij")
        columns = [grid.ravel() for grid in grids]
        columns += [np.broadcast_to(plain[name].values, shape).ravel() for name in names]
        write([*dims, *(_headed(plain, name) for name in names)])
        for row in zip(*(column.tolist() for column in columns), strict=True):
            write(row)
    return text.getvalue()


def _headed(dataset: xr.Dataset, name: str) -> str:
    """Return the head of a column, with its unit."""
    unit = str(dataset[name].attrs.get("units", "1"))
    return name if unit in ("", "1") else f"{name} [{unit}]"
