"""`latolato simulate`: one run."""

from __future__ import annotations

import gc
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from latolato.cli.options import JsonOption, PlotOption, ScenarioArgument, with_law_options
from latolato.cli.output import Animation, Targets, elapsed_since, print_summary
from latolato.core.errors import InputError
from latolato.io.progress import bar
from latolato.scenario.options import SENSITIVITY, changes
from latolato.scenario.scenario import Scenario, changed_scenario, changed_tables, find


@with_law_options(further=[SENSITIVITY])
def simulate(
    scenario: ScenarioArgument = None,
    rerun: Annotated[
        Path | None,
        typer.Option("--from", help="Repeat the run of a result file, at the same instants."),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(help="Result file: .nc, .csv or .parquet.", rich_help_panel="Output"),
    ] = None,
    plot: PlotOption = None,
    animate: Annotated[
        Path | None, typer.Option(help="Animation: .mp4 or .gif.", rich_help_panel="Output")
    ] = None,
    speed: Annotated[
        float, typer.Option(help="Playback speed; 1 is real time.", rich_help_panel="Output")
    ] = 1.0,
    fps: Annotated[float, typer.Option(help="Frames per second.", rich_help_panel="Output")] = 30.0,
    as_json: JsonOption = False,
    **values: Any,
) -> None:
    """Run one scenario, or a system given by options, and write its files.

    Options replace what the scenario says. Quantities may carry a unit: "24.5 cm", "20 deg",
    "1.6 Hz"; without one they are in SI units. Existing files are replaced.
    """
    begun = time.perf_counter()
    targets = Targets(output, plot)
    animation = Animation(animate, speed, fps)
    with _uncollected():
        ready = scenario_of(scenario, rerun, values)
        targets.check("the name of a result file", (".nc", ".csv", ".parquet"))
        animation.check()
        with bar("simulating") as progress:
            run = ready.record(progress=progress)
        files = targets.save(run)
    if plot is not None or animate is not None:
        dataset = run.to_dataset()
        files += targets.draw(dataset) + animation.write(dataset)
    from latolato.simulation.summary import summarise

    summary = summarise(run) | {
        "wall_time": elapsed_since(begun),
        "files": [str(path) for path in files],
    }
    print_summary(summary, lines_of(summary), as_json=as_json)


def scenario_of(source: str | None, rerun: Path | None, values: Mapping[str, Any]) -> Scenario:
    """Return the scenario named by the command line with the options put in."""
    if source is not None and rerun is not None:
        raise InputError("give either a scenario or --from, not both")
    changed = changes(values)
    path = rerun or (find(source) if source is not None else None)
    return changed_scenario(path, changed_tables(path, changed))


def lines_of(summary: Mapping[str, Any]) -> dict[str, str]:
    """Return a run's summary as names and texts for reading."""
    contacts = ", ".join(f"{count} {kind}" for kind, count in summary["contacts"].items())
    # None where there is no number.
    angle, energy = summary["largest_angle"], summary["largest_energy"]
    residual = summary["energy_residual"]
    known = residual is not None and energy is not None
    lines = {
        "run": f"{summary['system']}, drive {summary['drive']}, {summary['duration']:g} s",
        "status": summary["status"],
        "largest angle": f"{angle:.6g} rad" if angle is not None else "unknown",
        "contacts": contacts or "none",
        "energy residual": f"{residual:.2g} J of {energy:.3g} J" if known else "unknown",
        "wall time": f"{summary['wall_time']:.2f} s",
    }
    word = summary.get("contact_word")
    if contacts and word:
        words = [word] if isinstance(word, str) else word
        lines["contact word"] = ", ".join(dict.fromkeys(map(str, words)))
    if "sensitivity_status" in summary:
        lines["derivatives"] = summary["sensitivity_status"]
    return lines


@contextmanager
def _uncollected() -> Iterator[None]:
    """Turn off garbage collection, a sixth of a short command's time while modules load."""
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
