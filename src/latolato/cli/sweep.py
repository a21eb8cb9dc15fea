"""`latolato sweep`: many trajectories, and the progress of a store of them."""

from __future__ import annotations

import inspect
import json
import shutil
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from latolato.cli.options import (
    SAMPLE_OPTIONS,
    JsonOption,
    PlotOption,
    ScenarioArgument,
    with_law_options,
)
from latolato.cli.output import Targets, elapsed_since, in_columns, print_summary
from latolato.core.errors import InputError
from latolato.scenario.options import changes
from latolato.scenario.scenario import changed_scenario, changed_tables, find, read_tables
from latolato.scenario.variation import merged_axes, parse_axes, parse_observable, tables_of_plan
from latolato.simulation.parameters import SWEEP_PARAMETERS

if TYPE_CHECKING:
    from latolato.sweeps.plan import Plan

STORE_SUFFIX = ".zarr"
# So many contact words are counted one by one.
_MOST_WORDS = 8
Changes = dict[str, dict[str, Any]]


@with_law_options(without=SAMPLE_OPTIONS, further=SWEEP_PARAMETERS.values())
def sweep(
    scenario: ScenarioArgument = None,
    rerun: Annotated[
        Path | None,
        typer.Option("--from", help="Repeat or resume the sweep of a store or a .nc file."),
    ] = None,
    status: Annotated[
        Path | None,
        typer.Option(help="Only print the progress of the sweep in this store."),
    ] = None,
    verify: Annotated[
        Path | None,
        typer.Option(
            metavar="STORE",
            help="Read a whole store and list damaged files; exit code 1 if there are any.",
        ),
    ] = None,
    axis: Annotated[
        list[str] | None,
        typer.Option(
            help='Axis to vary: "drive_amplitude = 0 : 0.5 : 400 m", "frequency_ratio = 1.9, 2", '
            '"radius = 1 mm : 1 cm : 20 log", or several together: "case: length = 0.2 m, 0.3 m; '
            'radius = 2 cm, 3 cm". May be given several times.',
            rich_help_panel="Sweep",
        ),
    ] = None,
    observable: Annotated[
        list[str] | None,
        typer.Option(
            help='Result to compute: "mean_energy", "crossings(crossing_angle = 90 deg)". May be '
            "given several times.",
            rich_help_panel="Sweep",
        ),
    ] = None,
    executor: Annotated[
        str, typer.Option(help="threads, dask, cuda or reference", rich_help_panel="Where it runs")
    ] = "threads",
    workers: Annotated[
        int | None,
        typer.Option(
            help="threads, or processes of a local Dask cluster", rich_help_panel="Where it runs"
        ),
    ] = None,
    address: Annotated[
        str | None,
        typer.Option(
            help="scheduler of a Dask cluster, tcp://HOST:8786", rich_help_panel="Where it runs"
        ),
    ] = None,
    output: Annotated[
        Path | None,
        typer.Option(help="Result: map.nc, or map.zarr, a store.", rich_help_panel="Output"),
    ] = None,
    store: Annotated[
        Path | None,
        typer.Option(
            help="Zarr store, written while the sweep runs and resumed if it exists.",
            rich_help_panel="Output",
        ),
    ] = None,
    plot: PlotOption = None,
    variable: Annotated[
        str | None,
        typer.Option(
            help="Variable to plot. Default: the first observable.",
            rich_help_panel="Output",
        ),
    ] = None,
    as_json: JsonOption = False,
    **values: Any,
) -> None:
    """Run a map of many trajectories over any parameters, and write its files.

    Options replace what the scenario says: an axis one that varies the same thing, a value one
    that it fixes. A store is resumed; other existing files are replaced. Ctrl-C stops.
    """
    if status is not None or verify is not None:
        _check_alone(
            {
                "--status": status,
                "--verify": verify,
                "a scenario": scenario,
                "--from": rerun,
                "--axis": axis,
                "--output": output,
            }
        )
    if status is not None:
        print_status(status, as_json)
        return
    if verify is not None:
        if print_verification(verify, as_json):
            raise typer.Exit(1)
        return
    if scenario is not None and rerun is not None:
        raise InputError("give either a scenario or --from, not both")
    table = {name: values.pop(name) for name in SWEEP_PARAMETERS}
    plan = plan_of(
        scenario,
        rerun,
        changes(values),
        {name: value for name, value in table.items() if value is not None},
        axis or [],
        observable or [],
    )
    options = {"workers": workers, "client": address}
    run(
        plan,
        executor,
        {name: value for name, value in options.items() if value is not None},
        SweepTargets(output, store, plot, variable),
        as_json=as_json,
    )


def _check_alone(options: Mapping[str, Any]) -> None:
    """Raise if more than the first option is set: it only looks at a store."""
    first, *others = (name for name, value in options.items() if value)
    if others:
        raise InputError(f"{first} only looks at a store", way_out=f"leave out {', '.join(others)}")


@dataclass(frozen=True)
class SweepTargets:
    """What is to be written: a result file or store, a store, a picture and of what."""

    output: Path | None
    store: Path | None
    plot: Path | None
    variable: str | None

    @property
    def folder(self) -> Path | None:
        """The store, also where it is the result that was asked for."""
        return self.output if self.output and self.output.suffix == STORE_SUFFIX else self.store

    @property
    def files(self) -> Targets:
        """The NetCDF file and the picture."""
        return Targets(None if self.output is self.folder else self.output, self.plot)

    def check(self, plan: Plan) -> None:
        """Raise before any work if one of them cannot be written."""
        if self.folder is self.output is not None and self.store not in (None, self.output):
            raise InputError(
                "give one store",
                value=[str(self.store), str(self.output)],
                way_out="--output may be a .nc file beside the store",
            )
        if self.folder is not None and not self.folder.parent.is_dir():
            raise FileNotFoundError(
                f"the folder '{self.folder.parent}' does not exist; create it first"
            )
        self.files.check("the name of a map", (".nc", STORE_SUFFIX))
        if self.plot is not None:
            from latolato.figures.map import check_drawable

            check_drawable(plan, self.variable)
        elif self.variable is not None:
            raise InputError("--variable names what --plot shows", way_out="give --plot too")


def plan_of(
    source: str | None,
    rerun: Path | None,
    changed: Changes,
    table: Mapping[str, Any],
    axes: Sequence[str],
    observables: Sequence[str],
) -> Plan:
    """Return the plan of a scenario, or of a sweep that is there, with the options put in.

    Parameters
    ----------
    source, rerun
        A scenario's name or file; a store or the NetCDF file of a sweep.
    changed, table : mapping
        Changed entries of the scenario's tables, and of ``[sweep]``.
    axes, observables : sequence of str
        As they are given.
    """
    tables: Mapping[str, Any] | None = None
    path = find(source) if source is not None else None
    if rerun is not None:
        if rerun.suffix == ".toml":
            raise InputError(
                "--from takes a store or a .nc file", way_out="give a scenario without --from"
            )
        from latolato.io.plans import plan_from_store

        plan = plan_from_store(rerun)
        if not (changed or table or axes or observables):
            return plan
        tables = tables_of_plan(plan)
    elif path is not None:
        tables = read_tables(path)
    elif "kind" in changed.get("system", {}):
        tables = {}
    new = parse_axes(axes)
    sweep = dict(table)
    if observables:
        sweep["observables"] = [parse_observable(text) for text in observables]
    if "transient" in table or "transient_periods" in table:
        # One given alone takes the place of both, which add up.
        sweep = {"transient": 0.0, "transient_periods": 0.0} | sweep
    plain = changed_tables(path, changed | ({"sweep": sweep} if sweep else {}), tables)
    old = plain.get("sweep", {})
    if isinstance(old, Mapping) and (new or old.get("axes")):
        known_axes = old.get("axes", {})
        if isinstance(known_axes, Mapping):
            plain["sweep"] = {**old, "axes": merged_axes(known_axes, new, changed)}
        _move(plain, changed)
    return changed_scenario(path, plain).plan()


def _move(tables: dict[str, Any], changed: Changes) -> None:
    """Drop entries of ``[sweep]`` that options of the run replace."""
    for name in ("duration", "tolerance"):
        if name in changed.get("run", {}):
            tables["sweep"].pop(name, None)


def run(
    plan: Plan, executor: str, options: Mapping[str, Any], targets: SweepTargets, *, as_json: bool
) -> None:
    """Run a plan, write its files and print a summary."""
    from latolato.io.progress import SweepProgress
    from latolato.simulation.summary import summarise_sweep
    from latolato.sweeps import run_plan
    from latolato.sweeps.executors import ROUNDING

    begun = time.perf_counter()
    _check_executor(executor, options)
    targets.check(plan)
    store = targets.folder
    was_there = store is not None and store.exists()
    with SweepProgress() as progress:
        try:
            grid = run_plan(plan, executor=executor, store=store, progress=progress, **options)
        except KeyboardInterrupt:
            _tell_way_on(progress, store, ROUNDING[executor])
            raise
        except Exception:
            if store is not None and not was_there:
                _remove_if_empty(store)
            raise
    files = [store] if store is not None else []
    files += targets.files.write(grid, targets.variable)
    summary = summarise_sweep(grid, plan) | {
        "wall_time": elapsed_since(begun),
        "files": [str(path) for path in files],
    }
    print_summary(summary, lines_of(summary), as_json=as_json)


def print_status(store: Path, as_json: bool) -> None:
    """Print how far the sweep in a store is."""
    from latolato.sweeps.store import store_status

    state = store_status(store)
    if as_json:
        print(json.dumps(state))
        return
    lines = _state_lines(state)
    if not state["complete"] and not state["writer_active"]:
        lines["go on with"] = _way_on(store, state["rounding"])
    print(in_columns(lines))


def print_verification(store: Path, as_json: bool) -> bool:
    """Read everything in a store, print what is damaged, and return whether anything is."""
    from latolato.sweeps.store import verify_store

    state = verify_store(store)
    damaged = state["damaged"]
    if as_json:
        print(json.dumps(state))
        return bool(damaged)
    lines = _state_lines(state)
    lines["files"] = f"{state['files']} read, {len(damaged) or 'none'} damaged or missing"
    for number, each in enumerate(damaged):
        again = "" if each["number"] is None else f", part of chunk {each['number']} of the sweep"
        what = f"chunk {each['chunk']} of {each['variable']}" if each["chunk"] else each["file"]
        lines["damaged" if number == 0 else " " * number] = f"{what}{again}"
    if damaged:
        lines["repair with"] = _way_on(store, state["rounding"])
    print(in_columns(lines))
    return bool(damaged)


def _state_lines(state: Mapping[str, Any]) -> dict[str, str]:
    """Return the contents of a store and the progress of its sweep, as text."""
    counts = state["status_counts"]
    writer = "a process is writing it" if state["writer_active"] else "no process is writing it"
    state_text = "complete" if state["complete"] else f"unfinished, {writer}"
    return {
        "store": state["store"],
        "sweep": f"{state['system']}, drive {state['drive']}, {state['duration']:g} s",
        "axes": _axes_text(state["axes"]),
        "state": state_text,
        "chunks": f"{state['chunks_done']} of {state['chunks']} done",
        "points": f"{state['points_done']} of {state['points']} done",
        "status": _counts_text(counts, state["first_invalid"]),
    }


def _check_executor(executor: str, options: Mapping[str, Any]) -> None:
    """Raise unless the executor is there and takes these options."""
    from latolato.sweeps.executors import executor_named

    known = inspect.signature(executor_named(executor)).parameters
    for name, flag, others in (
        ("workers", "--workers", "threads or dask"),
        ("client", "--address", "dask"),
    ):
        if name in options and name not in known:
            raise InputError(f"{flag} belongs to executor {others}, not to {executor}")


def _tell_way_on(progress: Any, store: Path | None, rounding: str) -> None:
    """Say on standard error what a stopped sweep leaves and how to go on."""
    progress.__exit__(None, None, None)
    way = (
        f"go on with: {_way_on(store, rounding)}"
        if store is not None
        else "nothing is kept; --store keeps"
    )
    print(
        f"latolato: stopped after {progress.done} of {progress.total} points; {way}",
        file=sys.stderr,
    )


def _way_on(store: Path, rounding: str) -> str:
    """Return the command that resumes a store."""
    import shlex

    from latolato.sweeps.executors import ROUNDING

    name = shlex.quote(str(store))
    command = f"latolato sweep --from {name} --store {name}"
    executor = next(name for name, family in ROUNDING.items() if family == rounding)
    return command if executor == "threads" else f"{command} --executor {executor}"


def _remove_if_empty(store: Path) -> None:
    """Remove a store that this call began and that holds no result."""
    from latolato.sweeps.store import store_status

    try:
        state = store_status(store)
    except (OSError, InputError):
        return
    if state["chunks_done"] == 0 and not state["writer_active"]:
        shutil.rmtree(store)


def lines_of(summary: Mapping[str, Any]) -> dict[str, str]:
    """Return a sweep's summary as names and texts for reading."""
    rate = summary["points"] / max(summary["wall_time"], 1e-9)
    lines = {
        "sweep": f"{summary['system']}, drive {summary['drive']}, {summary['duration']:g} s",
        "axes": _axes_text(summary["axes"]),
        "points": str(summary["points"]),
        "status": _counts_text(summary["status"], summary["first_invalid"]),
    }
    for name, (low, high) in summary["ranges"].items():
        lines[name] = "no finite value" if low is None else f"{low:.6g} to {high:.6g}"
    if summary.get("contact_words"):
        lines["contact_word"] = _words_text(summary["contact_words"])
    lines["wall time"] = f"{summary['wall_time']:.2f} s ({rate:.3g} points/s, start included)"
    return lines


def _axes_text(axes: Mapping[str, int]) -> str:
    """Return axes as ``drive_amplitude 40 x frequency_ratio 40``."""
    return " x ".join(f"{name} {count}" for name, count in axes.items())


def _words_text(counts: Mapping[str, int]) -> str:
    """Return how many points have each of the commonest words, and all others together."""
    texts = [f"{count} {word}" for word, count in counts.items()]
    further = sum(list(counts.values())[_MOST_WORDS:])
    return ", ".join([*texts[:_MOST_WORDS], *([f"{further} others"] if further else [])])


def _counts_text(counts: Mapping[str, int], reason: str) -> str:
    """Return how many points have each status, and why the first one is invalid."""
    text = ", ".join(f"{n} {name.replace('_', ' ')}" for name, n in counts.items()) or "none yet"
    return f"{text} ({reason})" if reason else text
