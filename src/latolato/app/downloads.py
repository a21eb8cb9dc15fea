"""Files of the run on show that pages do not write themselves: NetCDF, pictures, animations."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from latolato.app.blocks import content_of
from latolato.app.run_request import MOST_SAMPLES, RunRequest
from latolato.app.runs import sampled, scenario_of
from latolato.app.worker import Result
from latolato.core.errors import InputError

TYPES = {
    "csv": "text/csv",
    "nc": "application/x-netcdf",
    "png": "image/png",
    "svg": "image/svg+xml",
    "mp4": "video/mp4",
}
FPS = 30.0
PICTURE_DPI = 200


def compute(request: Mapping[str, Any], folder: Path, progress: Callable[[float], None]) -> Result:
    """Make a file of a run, ``{"kind", "scenario", "options", "speed"}``; only films have a speed.

    A run has the samples of `Scenario.simulate`, but at most 200000.

    Raises
    ------
    InputError
        For bad input, and if the extra `video` is missing.
    """
    kind = request["kind"]
    if kind not in TYPES:
        raise InputError(f"a run is stored as {', '.join(TYPES)}, not as {kind!r}")
    path = folder / f"run.{kind}"
    if kind == "mp4":
        from latolato.figures.animate import animate, check_target

        speed = float(request["speed"])
        check_target(str(path), speed, FPS)
    scenario = scenario_of(RunRequest.from_json(request))
    run = scenario.simulate(**sampled(scenario, MOST_SAMPLES))
    if kind == "mp4":
        animate(run, path, speed=speed, fps=FPS, progress=progress)
    elif kind in ("png", "svg"):
        from latolato.figures.plot import plot
        from latolato.figures.style import save_figure

        save_figure(plot(run), path, dpi=PICTURE_DPI)
    else:
        from latolato.io.files import save

        save(run, path)
    return {"type": TYPES[kind]}, {"file": content_of(path)}
