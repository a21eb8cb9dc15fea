"""Files of the run on show that pages do not write themselves: NetCDF, pictures, animations."""

from __future__ import annotations

import re
import tempfile
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from starlette.responses import Response

from latolato.app.blocks import content_of
from latolato.app.run_request import MOST_SAMPLES, RunRequest
from latolato.app.runs import sampled, scenario_of
from latolato.app.worker import Result
from latolato.core.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from latolato.scenario.scenario import Scenario

TYPES = {"nc": "application/x-netcdf", "png": "image/png", "svg": "image/svg+xml"}
# Names of the address that are no options of a run.
_OF_PAGE = ("view", "scenario")
FPS = 30.0
PICTURE_DPI = 200
# Figures share matplotlib's settings.
drawing_lock = threading.Lock()


def request_of(query: Mapping[str, str]) -> RunRequest:
    """The run that the page's address asks for, without the options of its views.

    Examples
    --------
    >>> request_of({"view": "toy", "scenario": "fig02", "length": "1 m", "map.x": "damping"})
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


def file_name(scenario: Scenario) -> str:
    """The name of a run's file, without its ending.

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
    return scenario.simulate(**sampled(scenario, MOST_SAMPLES))


def _written(scenario: Scenario, kind: str, folder: Path) -> bytes:
    """The content of a run's file: a dataset or a picture."""
    run = simulate_for_file(scenario)
    path = folder / f"run.{kind}"
    if kind == "nc":
        from latolato.io.files import save

        save(run, path)
    else:
        from latolato.figures.plot import plot
        from latolato.figures.style import save_figure

        with drawing_lock:
            save_figure(plot(run), path, dpi=PICTURE_DPI)
    return path.read_bytes()


def compute(request: Mapping[str, Any], folder: Path, progress: Callable[[float], None]) -> Result:
    """Animate what a page asks for: ``{"scenario", "options", "speed"}``.

    Raises
    ------
    InputError
        For bad input, and if the extra `video` is missing.
    """
    from latolato.figures.animate import animate, check_target

    speed, path = float(request["speed"]), folder / "run.mp4"
    check_target(str(path), speed, FPS)
    scenario = scenario_of(RunRequest.from_json(request))
    animate(simulate_for_file(scenario), path, speed=speed, fps=FPS, progress=progress)
    about = {"name": f"{file_name(scenario)}.mp4", "type": "video/mp4"}
    return about, {"file": content_of(path)}
