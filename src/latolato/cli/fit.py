"""What `latolato fit` and `latolato import` do once their options are read."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from latolato.cli.options import (
    EachOptionOnce,
    JsonOption,
    PlotOption,
    named_values,
    with_law_options,
)
from latolato.core.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from latolato.experiment.fits.result import Fit

TableArgument = Annotated[
    Path, typer.Argument(help="Track table: .csv, .parquet or .nc.", show_default=False)
]
ColumnOption = Annotated[
    list[str] | None,
    typer.Option(
        # Round brackets: square ones are taken for markup.
        help='Column of another program\'s table: time="t (s)", angle_1="theta (deg)". '
        "May be given several times.",
        show_default=False,
        rich_help_panel="Table",
    ),
]
LengthOption = Annotated[
    str | None, typer.Option(help="Pivot to ball centre, in m.", show_default=False)
]
MassOption = Annotated[
    str | None, typer.Option(help="Mass of the ball, in kg.", show_default=False)
]
RadiusOption = Annotated[
    str | None, typer.Option(help="Radius of the ball, in m.", show_default=False)
]
GravityOption = Annotated[
    str | None, typer.Option(help="Gravity, in m/s^2; 9.8 by default.", show_default=False)
]
StartOption = Annotated[
    str | None,
    typer.Option(help="First instant used, in s.", show_default=False, rich_help_panel="Table"),
]
EndOption = Annotated[
    str | None,
    typer.Option(help="Last instant used, in s.", show_default=False, rich_help_panel="Table"),
]
OutputOption = Annotated[
    Path | None, typer.Option(help="Result file: .nc.", rich_help_panel="Output")
]
BallOption = Annotated[int, typer.Option(help="Ball of the table, 1 is the right one.")]

fit_app = typer.Typer(help="Fit physics to a track table: decay, drive, restitution, model.")


@fit_app.callback(invoke_without_command=True)
def _list_fits(context: typer.Context) -> None:
    if context.invoked_subcommand is None:
        print(context.get_help())


@fit_app.command(cls=EachOptionOnce)
def decay(
    table: TableArgument,
    length: LengthOption = None,
    mass: MassOption = None,
    radius: RadiusOption = None,
    gravity: GravityOption = None,
    method: Annotated[str, typer.Option(help="both, equation or envelope.")] = "both",
    law: Annotated[
        str, typer.Option(help="Drag: linear, quadratic, coulomb, sums with +, or best.")
    ] = "linear",
    ball: BallOption = 1,
    start: StartOption = None,
    end: EndOption = None,
    column: ColumnOption = None,
    output: OutputOption = None,
    plot: PlotOption = None,
    as_json: JsonOption = False,
) -> None:
    """Damping, length and drag law from a ball that swings freely on a pivot at rest."""
    given = {"length": length, "mass": mass, "radius": radius, "gravity": gravity}
    given |= {"start": start, "end": end}

    def fit(track: xr.Dataset) -> Fit:
        from latolato.experiment.fits.decay import fit_decay

        return fit_decay(track, method=method, law=law, ball=ball, **_si(given))

    run(table, column, fit, output, plot, as_json=as_json)


@fit_app.command(cls=EachOptionOnce)
def drive(
    table: TableArgument,
    stages: Annotated[
        int | None, typer.Option(help="Stages of constant frequency; found by default.")
    ] = None,
    start: StartOption = None,
    end: EndOption = None,
    column: ColumnOption = None,
    output: OutputOption = None,
    plot: PlotOption = None,
    as_json: JsonOption = False,
) -> None:
    """Amplitude, frequency, overtones, drift and steps of the pivot's motion."""

    def fit(track: xr.Dataset) -> Fit:
        from latolato.experiment.fits.drive import fit_drive

        return fit_drive(track, stages=stages, **_si({"start": start, "end": end}))

    run(table, column, fit, output, plot, as_json=as_json)


@fit_app.command(cls=EachOptionOnce)
def restitution(
    table: TableArgument,
    length: LengthOption = None,
    radius: RadiusOption = None,
    gravity: GravityOption = None,
    start: StartOption = None,
    end: EndOption = None,
    column: ColumnOption = None,
    output: OutputOption = None,
    plot: PlotOption = None,
    as_json: JsonOption = False,
) -> None:
    """Coefficient of restitution of every impact that is seen, and of all together."""
    given = {"length": length, "radius": radius, "gravity": gravity, "start": start, "end": end}

    def fit(track: xr.Dataset) -> Fit:
        from latolato.experiment.fits.restitution import fit_restitution

        return fit_restitution(track, **_si(given))

    run(table, column, fit, output, plot, as_json=as_json)


def model(
    table: TableArgument,
    vary: Annotated[
        list[str] | None,
        typer.Option(
            help="Parameter that is fitted; may be given several times. By default length, "
            "damping and, with contacts, restitution.",
            show_default=False,
        ),
    ] = None,
    ball: Annotated[int | None, typer.Option(help="Ball of the table.", show_default=False)] = None,
    window: Annotated[
        str | None,
        typer.Option(help="Time after which the motion begins afresh, in s.", show_default=False),
    ] = None,
    start: StartOption = None,
    end: EndOption = None,
    column: ColumnOption = None,
    output: OutputOption = None,
    plot: PlotOption = None,
    as_json: JsonOption = False,
    **given: Any,
) -> None:
    """Parameters of a whole system, with the measured pivot as its drive unless one is given.

    The system's values are first guesses of what varies.
    """
    times = {"start": start, "end": end, "window": window}
    system, moving = _laws(given)
    names = [part.strip().replace("-", "_") for each in vary or () for part in each.split(",")]

    def fit(track: xr.Dataset) -> Fit:
        from latolato.experiment.fits.model import fit_model

        return fit_model(track, system, moving, names or None, ball=ball, **_si(times))

    run(table, column, fit, output, plot, as_json=as_json)


def model_command() -> Callable[..., None]:
    """Return the command `model` with an option for each parameter of systems and drives."""
    from latolato.scenario.options import law_options

    of_runs = [o.name for o in law_options().values() if o.owner in ("run", "noise")]
    return with_law_options(model, without=of_runs)


fit_app.command("model", cls=EachOptionOnce)(model_command())


def import_(
    file: Annotated[Path, typer.Argument(help="Text table of another program.")],
    column: ColumnOption = None,
    length: LengthOption = None,
    radius: RadiusOption = None,
    pivot: Annotated[
        str | None,
        typer.Option(help='Where the pivot is in the file: "x, y", in m.', show_default=False),
    ] = None,
    angle_from: Annotated[
        str, typer.Option(help="Where angles count from: down, or right (the x axis).")
    ] = "down",
    y_axis: Annotated[str, typer.Option(help="Way in which y grows: up or down.")] = "up",
    angle_sigma: Annotated[
        str | None, typer.Option(help="Uncertainty of the angles, in rad.", show_default=False)
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(help="Track table; by default beside the file, as .track.csv."),
    ] = None,
) -> None:
    """Make a track table of another program's table: Tracker's exports, phones' sensors."""
    from latolato.experiment.importing import import_table
    from latolato.experiment.table import write_table
    from latolato.scenario.units import to_si, to_si_list

    target = output or file.with_suffix(".track.csv")
    table = import_table(
        file,
        mapping_of(column),
        length=to_si("length", length, "m"),
        radius=to_si("radius", radius, "m"),
        pivot=to_si_list("pivot", pivot, "m") if pivot is not None else None,
        angle_from=angle_from,
        y_axis=y_axis,
        angle_sigma=to_si("angle_sigma", angle_sigma, "rad"),
    )
    write_table(table, target)
    print(about(table, target))


def about(table: xr.Dataset, path: Path) -> str:
    """Return what an imported table holds, as lines that show a wrong unit or column."""
    from math import degrees

    from latolato.experiment.table import balls_of

    time = table["time"].values
    lines = {"table": f"{len(time)} rows, {time[-1] - time[0]:.6g} s"}
    for ball in range(1, balls_of(table) + 1):
        angle = table[f"angle_{ball}"]
        missing = int(angle.isnull().sum())
        lines[f"angle {ball}"] = (
            f"{degrees(float(angle.min())):.4g} to {degrees(float(angle.max())):.4g} deg"
            + (f", missing in {missing} rows" if missing else "")
        )
    height = table["pivot_y"]
    if height.notnull().any():
        low, high = 1e3 * float(height.min()), 1e3 * float(height.max())
        lines["pivot"] = f"{low:.4g} to {high:.4g} mm high"
    lines["written"] = str(path)
    return "\n".join(f"{name:16} {text}" for name, text in lines.items())


def run(
    path: Path,
    column: Sequence[str] | None,
    fit: Callable[[xr.Dataset], Fit],
    output: Path | None,
    plot: Path | None,
    *,
    as_json: bool,
) -> None:
    """Read a table, fit it, write what is asked for and print what was found."""
    from latolato.cli.simulate import check_targets
    from latolato.experiment.importing import import_table
    from latolato.experiment.table import read_table
    from latolato.io.files import check_suffix, check_target

    if output is not None:
        check_suffix(output, (".nc",), "the result of a fit")
        check_target(output)
    check_targets(None, plot, None, 1.0, 30.0)
    mapping = mapping_of(column)
    found = fit(import_table(path, mapping) if mapping else read_table(path))
    written = [] if output is None else [found.save(output)]
    if plot is not None:
        from latolato.figures.fits import draw_fit
        from latolato.figures.style import save_figure

        written.append(save_figure(draw_fit(found.dataset), plot))
    if as_json:
        print(json.dumps(found.to_dict() | {"files": [str(each) for each in written]}))
    else:
        print(as_text(found, written))


def mapping_of(columns: Sequence[str] | None) -> dict[str, str] | None:
    """Return the column mapping that options give, None without any."""
    found = named_values("--column", columns, "NAME=COLUMN, as in time='t [s]'")
    return found or None


def as_text(found: Fit, written: Sequence[Path]) -> str:
    """Return a fit as lines for reading."""
    lines = {"fit": f"{found.kind}: {found.verdict}"}
    for name, each in found.estimates.items():
        lines[name] = f"{each} (95 %: {each.low:.6g} to {each.high:.6g})"
    about = found.dataset.attrs
    if "autocorrelation" in about:
        lines["residuals"] = (
            f"scatter {about['scatter']:.3g}, neighbours correlated by "
            f"{about['autocorrelation']:.2f}, {about['effective_samples']:.0f} effective samples"
        )
    lines["written"] = ", ".join(map(str, written)) or "nothing; name a file with --output"
    width = max(16, *map(len, lines))
    return "\n".join(f"{name:{width}} {text}" for name, text in lines.items())


def _si(given: Mapping[str, str | None]) -> dict[str, Any]:
    """Return the options that are given, in SI units."""
    from latolato.core.quantities import QUANTITIES
    from latolato.scenario.units import to_si

    units = {"start": "s", "end": "s", "window": "s"}
    return {
        name: to_si(name, value, units.get(name) or QUANTITIES[name].unit)
        for name, value in given.items()
        if value is not None
    }


def _laws(given: Mapping[str, Any]) -> tuple[Any, Any]:
    """Return the system, and the drive if one is given."""
    from latolato.physics.drives import drives
    from latolato.physics.pendulum import systems
    from latolato.scenario.options import changes
    from latolato.scenario.tables import law_from, without_ratios

    named = given.get("drive")
    plain = {k: v for k, v in given.items() if not (k == "drive" and v == "measured")}
    changed = changes(plain)
    if "kind" not in changed.get("system", {}):
        raise InputError(f"name the system: --system with one of {', '.join(systems)}")
    system = law_from(changed["system"], systems, "system", Path())
    if "drive" not in changed:
        return system, named
    changed["drive"].setdefault("kind", "harmonic")
    table = without_ratios(changed["drive"], system)
    return system, law_from(table, drives, "drive", Path())
