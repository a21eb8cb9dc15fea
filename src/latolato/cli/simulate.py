"""What `latolato simulate` does once its options are read, and `latolato plot` with a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from latolato.core.errors import InputError
from latolato.io.progress import bar
from latolato.scenario.options import changes
from latolato.scenario.scenario import Scenario, changed_tables, find
from latolato.simulation.record import Record

if TYPE_CHECKING:
    import xarray as xr

PICTURES = (".png", ".svg", ".pdf")


def scenario_of(source: str | None, rerun: Path | None, given: Mapping[str, Any]) -> Scenario:
    """Return the scenario named by the command line with the options put in."""
    if source is not None and rerun is not None:
        raise InputError("give either a scenario or --from, not both")
    changed = changes(given)
    path = rerun or (find(source) if source is not None else None)
    tables, folder = changed_tables(path, changed)
    return Scenario.from_dict(tables, folder=folder)


def check_targets(
    output: Path | None, plot: Path | None, animate: Path | None, speed: float, fps: float
) -> None:
    """Raise before any work if a file that is asked for cannot be written."""
    from latolato.core.atomic import check_folder
    from latolato.io import files

    for path in (output, plot, animate):
        if path is not None:
            check_folder(path)
    if output is not None:
        files.check_target(output)
    if plot is not None:
        files.check_suffix(plot, PICTURES, "the name of a picture")
    if animate is not None:
        from latolato.figures.animate import check_target

        check_target(animate, speed, fps)


def write(
    run: xr.Dataset | Record,
    output: Path | None,
    plot: Path | None,
    animate: Path | None,
    speed: float,
    fps: float,
) -> list[Path]:
    """Write the files that are asked for and return their names."""
    written = []
    if output is not None:
        from latolato.io.files import save

        written.append(save(run, output))
    if plot is None and animate is None:
        return written
    shown = run.to_dataset() if isinstance(run, Record) else run
    if plot is not None:
        from latolato.figures.plot import plot as draw
        from latolato.figures.style import save_figure

        written.append(save_figure(draw(shown), plot))
    if animate is not None:
        from latolato.figures import animate as movie

        with bar("animating") as progress:
            written.append(movie.animate(shown, animate, speed=speed, fps=fps, progress=progress))
    return written


def selection_of(texts: Sequence[str], dataset: xr.Dataset) -> dict[str, Any]:
    """Return the values of dimensions that options name, in SI units."""
    from latolato.scenario.units import to_si

    found: dict[str, Any] = {}
    for text in texts:
        name, equals, value = (part.strip() for part in text.partition("="))
        name = name.replace("-", "_")
        if not equals or not value:
            raise InputError(f"--select must be NAME=VALUE, such as restitution=0.9, got {text!r}")
        is_text = name not in dataset.coords or dataset[name].dtype.kind not in "iuf"
        unit = "1" if is_text else str(dataset[name].attrs.get("units", "1"))
        found[name] = value if is_text and not value.isdigit() else to_si(name, value, unit)
    return found


def as_text(found: Mapping[str, Any]) -> str:
    """Return a summary as lines for reading."""
    contacts = ", ".join(f"{count} {kind}" for kind, count in found["contacts"].items())
    energy, angle = found["largest_energy"], found["largest_angle"]  # None if there is no number
    residual = found["energy_residual"]
    known = residual is not None and energy is not None
    lines = {
        "run": f"{found['system']}, drive {found['drive']}, {found['duration']:g} s",
        "status": found["status"],
        "largest angle": f"{angle:.6g} rad" if angle is not None else "unknown",
        "contacts": contacts or "none",
        "energy residual": f"{residual:.2g} J of {energy:.3g} J" if known else "unknown",
        "wall time": f"{found['wall_time']:.2f} s",
        "written": ", ".join(found["files"]) or "nothing; name a file with --output",
    }
    return "\n".join(f"{name:16} {text}" for name, text in lines.items())
