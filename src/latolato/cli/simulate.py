"""What `latolato simulate` does once its options are read, and `latolato plot` with a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from latolato.cli.options import named_values
from latolato.core.errors import InputError
from latolato.io.progress import bar
from latolato.scenario.options import changes
from latolato.scenario.scenario import Scenario, changed_tables, find

if TYPE_CHECKING:
    import xarray as xr


def scenario_of(source: str | None, rerun: Path | None, given: Mapping[str, Any]) -> Scenario:
    """Return the scenario named by the command line with the options put in."""
    if source is not None and rerun is not None:
        raise InputError("give either a scenario or --from, not both")
    changed = changes(given)
    path = rerun or (find(source) if source is not None else None)
    tables, folder = changed_tables(path, changed)
    return Scenario.from_dict(tables, folder=folder)


@dataclass(frozen=True)
class Animation:
    """The animation that a command is asked to write."""

    path: Path | None
    speed: float
    fps: float

    def check(self) -> None:
        """Raise before any work if it cannot be written."""
        if self.path is not None:
            from latolato.core.atomic import check_folder
            from latolato.figures.animate import check_target

            check_folder(self.path)
            check_target(self.path, self.speed, self.fps)

    def write(self, run: xr.Dataset) -> list[Path]:
        """Write it, where asked for, and return its name."""
        if self.path is None:
            return []
        from latolato.figures.animate import animate

        with bar("animating") as progress:
            return [animate(run, self.path, speed=self.speed, fps=self.fps, progress=progress)]


def selection_of(texts: Sequence[str], dataset: xr.Dataset) -> dict[str, Any]:
    """Return the values of dimensions that options name, in SI units."""
    from latolato.scenario.units import to_si

    values: dict[str, Any] = {}
    for name, value in named_values("--select", texts, "NAME=VALUE, as restitution=0.9").items():
        is_text = name not in dataset.coords or dataset[name].dtype.kind not in "iuf"
        unit = "1" if is_text else str(dataset[name].attrs.get("units", "1"))
        values[name] = value if is_text and not value.isdigit() else to_si(name, value, unit)
    return values


def lines_of(summary: Mapping[str, Any]) -> dict[str, str]:
    """Return a run's summary as names and texts for reading."""
    contacts = ", ".join(f"{count} {kind}" for kind, count in summary["contacts"].items())
    # None where there is no number.
    angle, energy = summary["largest_angle"], summary["largest_energy"]
    residual = summary["energy_residual"]
    known = residual is not None and energy is not None
    return {
        "run": f"{summary['system']}, drive {summary['drive']}, {summary['duration']:g} s",
        "status": summary["status"],
        "largest angle": f"{angle:.6g} rad" if angle is not None else "unknown",
        "contacts": contacts or "none",
        "energy residual": f"{residual:.2g} J of {energy:.3g} J" if known else "unknown",
        "wall time": f"{summary['wall_time']:.2f} s",
    }
