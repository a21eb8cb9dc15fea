"""Files of the run on show: its numbers, its picture, its animation and its scenario."""

from __future__ import annotations

import math
import re
import tempfile
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket

from latolato.app.answers import answered
from latolato.app.blocks import pack_files
from latolato.app.given import RunRequest, TooLargeError, check_size
from latolato.app.jobs import Job, serve_job
from latolato.core.errors import InputError, import_extra

if TYPE_CHECKING:
    import xarray as xr

    from latolato.scenario.scenario import Scenario

TYPES = {
    "csv": "text/csv",
    "contacts.csv": "text/csv",
    "nc": "application/x-netcdf",
    "png": "image/png",
    "svg": "image/svg+xml",
    "toml": "application/toml",
}
# Names of the address that are no options of a run.
_OF_PAGE = ("view", "token", "scenario")
# Samples of a run that is stored; as many as its default has, up to this number.
MOST_SAMPLES = 200_000
# Frames of an animation: three minutes, made in a minute or two.
MOST_FRAMES = 5400
FPS = 30.0
PICTURE_DPI = 200
# Figures share matplotlib's settings.
drawing_lock = threading.Lock()


def routes() -> list[BaseRoute]:
    """Return the routes of downloads."""
    return [
        Route("/download/run.{kind}", _download),
        WebSocketRoute("/ws/animation", _animation),
    ]


async def _download(request: Request) -> Response:
    wanted = request_of(dict(request.query_params))
    return await answered(request, file_response, wanted, request.path_params["kind"])


async def _animation(websocket: WebSocket) -> None:
    await serve_job(websocket, websocket.app.state.jobs, prepare_animation)


def request_of(query: Mapping[str, str]) -> RunRequest:
    """Return what an address of the page asks for; what belongs to its views is left out.

    Examples
    --------
    >>> request_of({"view": "play", "scenario": "fig02", "length": "1 m", "map.x": "damping"})
    RunRequest(scenario='fig02', options={'length': '1 m'})
    """
    options = {n: v for n, v in query.items() if n not in _OF_PAGE and "." not in n}
    return RunRequest(query.get("scenario") or None, options)


def file_response(request: RunRequest, kind: str) -> Response:
    """Return a file of the run that is asked for, to be stored by the browser.

    Raises
    ------
    InputError
        For bad input, an unknown kind and a run that is too large, before any work.
    """
    if kind not in TYPES:
        raise InputError(f"a run is stored as {', '.join(TYPES)}, not as {kind!r}")
    scenario = scenario_of(request)
    with tempfile.TemporaryDirectory(prefix="latolato-") as folder:
        content = _written(scenario, kind, Path(folder))
    disposition = f'attachment; filename="{file_name(scenario)}.{kind}"'
    return Response(content, media_type=TYPES[kind], headers={"Content-Disposition": disposition})


def scenario_of(request: RunRequest) -> Scenario:
    """Return the scenario of one run that is neither a map nor too large."""
    scenario = request.to_scenario()
    if scenario.varied:
        raise InputError(f"{scenario.name or 'this scenario'} is a map, not one run: open it there")
    check_size(scenario)
    return scenario


def file_name(scenario: Scenario) -> str:
    """Return what a file of a run is called, without its ending.

    Examples
    --------
    >>> from latolato import load_scenario
    >>> file_name(load_scenario("fig02"))
    'latolato_fig02'
    """
    from latolato.physics.drives import drives
    from latolato.physics.pendulum import systems

    name = scenario.name or f"{systems.name_of(scenario.system)}_{drives.name_of(scenario.drive)}"
    name = re.sub(r"[^A-Za-z0-9_-]+", "_", name).strip("_") or "run"
    return name if name.startswith("latolato") else f"latolato_{name}"


def simulate_for_file(scenario: Scenario) -> xr.Dataset:
    """Return the run as `Scenario.simulate` gives it, with at most 200000 samples."""
    import numpy as np

    from latolato.simulation.run import SAMPLES_PER_PERIOD

    end = float(scenario.run.get("duration") or 0.0)
    fastest = max(scenario.system.natural_frequency, scenario.drive.fastest_frequency)
    usual = math.ceil(SAMPLES_PER_PERIOD * end * fastest / (2.0 * math.pi)) + 1
    times = scenario.run.get("times")
    if times is not None and len(times) > MOST_SAMPLES:
        raise TooLargeError(
            f"must not exceed {MOST_SAMPLES} here", parameter="samples", value=len(times)
        )
    if times is None and usual > MOST_SAMPLES:
        return scenario.simulate(times=np.linspace(0.0, end, MOST_SAMPLES))
    return scenario.simulate()


def _written(scenario: Scenario, kind: str, folder: Path) -> bytes:
    """Return what a file of a run holds."""
    if kind == "toml":
        return to_toml(scenario).encode()
    run = simulate_for_file(scenario)
    if kind == "contacts.csv" and run.attrs.get("contact", "none") == "none":
        raise InputError("no ball can touch anything in this run: it has no table of contacts")
    path = folder / f"run.{kind.rpartition('.')[2]}"
    if kind in ("png", "svg"):
        from latolato.figures.plot import plot
        from latolato.figures.style import save_figure

        with drawing_lock:
            save_figure(plot(run), path, dpi=PICTURE_DPI)
    else:
        from latolato.io.files import save

        save(run, path)
    return path.with_name(f"run.{kind}").read_bytes()


def to_toml(scenario: Scenario) -> str:
    """Return a scenario as a TOML file that `latolato simulate` takes, in SI units.

    Raises
    ------
    InputError
        Without the extra `app`.
    """
    from latolato.app.lines import command_line

    tomli_w = import_extra("tomli_w", "app", "TOML")

    tables = {k: v for k, v in without_none(scenario.to_dict()).items() if k != "name"}
    head = f"# SI units. Run it: latolato simulate {file_name(scenario)}.toml"
    return f"{head}\n# The same on one line: {command_line(scenario)}\n\n{tomli_w.dumps(tables)}"


def without_none(tables: Any) -> Any:
    """Return tables as plain Python values without entries that are None, which TOML lacks."""
    if hasattr(tables, "tolist"):
        tables = tables.tolist()
    if isinstance(tables, Mapping):
        return {k: without_none(v) for k, v in tables.items() if v is not None}
    if isinstance(tables, (list, tuple)):
        return [without_none(v) for v in tables]
    return tables


def prepare_animation(body: Any) -> Job:
    """Return the job that animates what a page asks for: ``{"scenario", "options", "speed"}``.

    Raises
    ------
    InputError
        For bad input.
        Without the extra `video`.
    """
    from latolato.figures.animate import check_target

    request = RunRequest.from_json(body)
    speed = body.get("speed", 1.0)
    if isinstance(speed, bool) or not isinstance(speed, (int, float)):
        raise InputError("must be a number", parameter="speed", value=speed)
    check_target("run.mp4", float(speed), FPS)
    scenario = scenario_of(request)
    check_frames(scenario, float(speed))

    def finish(about: dict[str, Any], folder: Path) -> bytes:
        about = {**about, "name": f"{file_name(scenario)}.mp4", "type": "video/mp4"}
        return pack_files(about, {"file": folder / "run.mp4"})

    run = {"scenario": request.scenario, "options": dict(request.options or {})}
    return Job("animate", {**run, "speed": speed}, finish)


def check_frames(scenario: Scenario, speed: float) -> None:
    """Refuse an animation that nobody would wait for.

    Raises
    ------
    TooLargeError
        With the number of frames, the limit and the speed that keeps it.
    """
    times = scenario.run.get("times")
    end = float(scenario.run.get("duration") or (times[-1] if times else 0.0))
    frames = math.floor(end * FPS / speed) + 1
    if frames > MOST_FRAMES:
        raise TooLargeError(
            f"the animation would have {frames} frames, the limit is {MOST_FRAMES}: choose a speed "
            f"of {math.ceil(end * FPS / MOST_FRAMES)} or more, or shorten the duration"
        )


def compute(
    request: Mapping[str, Any], folder: Path, progress: Callable[[float], None]
) -> dict[str, Any]:
    """Write ``run.mp4`` into a folder: what the job `animate` does in its process."""
    from latolato.figures.animate import animate

    scenario = scenario_of(RunRequest.from_json(request))
    run = simulate_for_file(scenario)
    animate(run, folder / "run.mp4", speed=request["speed"], fps=FPS, progress=progress)
    return {}
