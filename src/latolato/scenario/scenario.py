"""Scenarios: a system, a drive and a start, written in TOML with units and run by name.

A scenario has the tables ``[system]``, ``[drive]``, ``[run]`` and ``[noise]``; with ``[sweep]`` it
is a sweep. Every run stores its own scenario in the attribute ``scenario``, in the same layout with
plain SI numbers, so that a result file can be run again.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from latolato.core.errors import InputError, python_name, reading
from latolato.core.registry import describe, suggest
from latolato.core.rules import broken_rule
from latolato.core.versions import FORMAT, check_format
from latolato.physics.contacts import ContactLaw, contact_laws
from latolato.physics.drives import Drive, FixedPivot, drives
from latolato.physics.noise import VelocityKicks
from latolato.physics.pendulum import System, systems
from latolato.scenario.tables import (
    RATIOS,
    RUN_OPTIONS,
    Tables,
    build_from,
    checked_table,
    drive_from,
    law_from,
    plain_sweep,
    run_arguments,
    with_sweep,
)
from latolato.sweeps.axes import is_replaced, names_in

if TYPE_CHECKING:
    import xarray as xr

    from latolato.simulation.record import Record
    from latolato.sweeps.plan import Plan

# Entries of ``[run]`` that say how one run is sampled.
_OF_ONE_RUN = ("times", "frame", "sensitivity_to")

# A new value of one of these takes the place of the others.
ALTERNATIVES = (
    *({ratio, plain} for ratio, plain in RATIOS.items()),
    {"initial_angle", "initial_offset"},
    {"times", "samples"},
    {"times", "duration"},
)
_TABLES = ("system", "drive", "run", "noise", "sweep")
_TEXTS = ("title", "question", "description", "figure")


@dataclass(frozen=True, kw_only=True)
class Scenario:
    """What to run, ready for `latolato.simulate`, or for `latolato.sweep` if something varies.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive
        How the pivot moves.
    run : mapping
        The other arguments of `latolato.simulate` by name.
    varied : mapping
        The arguments of `latolato.sweep` that ``[sweep]`` gives: `axes`, `observables` and more;
        empty for a scenario of one run.
    name, title : str
        Name and title of the scenario.
    question : str
        A question that the motion raises; pages show it as a headline.
    description : str
        What it shows, with every assumption made.
    figure : str
        The figure of the paper that it belongs to.
    """

    system: System
    drive: Drive = field(default_factory=FixedPivot)
    run: Mapping[str, Any] = field(default_factory=dict)
    varied: Mapping[str, Any] = field(default_factory=dict)
    name: str = ""
    title: str = ""
    question: str = ""
    description: str = ""
    figure: str = ""

    @classmethod
    def from_dict(cls, tables: Any, *, folder: Path | None = None) -> Scenario:
        """Return the scenario that nested tables describe, with or without units.

        Parameters
        ----------
        tables : mapping
            The tables `system`, `drive`, `run`, `noise` and `sweep`, the texts `name`, `title`,
            `question`, `description` and `figure`, and `format`, by default 1.
        folder : Path, optional
            Where the names of data files begin.

        Raises
        ------
        InputError
            For unknown names, with the closest known one, wrong types, units and values.
        """
        known = [*_TABLES, "name", *_TEXTS, "format"]
        for name, value in checked_table(tables, "a scenario").items():
            if name not in known:
                raise InputError(f"unknown entry '{name}': {suggest(name, known)}")
            if name == "format":
                check_format(value, "a scenario")
            elif name not in _TABLES and not isinstance(value, str):
                raise InputError("must be a text", parameter=name, value=value)
        if "system" not in tables:
            raise InputError(f"a scenario needs [system] with a kind: {', '.join(systems)}")
        folder = folder or Path()
        varied: dict[str, Any] = {}
        if "sweep" in tables:
            tables, varied = with_sweep(tables, folder)
        system = law_from(tables["system"], systems, "system", folder)
        drive: Drive = FixedPivot()
        if "drive" in tables:
            drive = drive_from(tables["drive"], system, folder)
        run = run_arguments(checked_table(tables.get("run", {}), "run"), folder)
        if "noise" in tables:
            table = checked_table(tables["noise"], "noise")
            run["noise"] = build_from(VelocityKicks, table, folder)
        _check_ratios(tables.get("drive", {}), run.get("sensitivity_to", ()))
        texts = {name: tables[name].strip() for name in ("name", *_TEXTS) if name in tables}
        return cls(system=system, drive=drive, run=run, varied=varied, **texts)

    def to_dict(self) -> Tables:
        """Return the tables of this scenario as plain SI numbers, for JSON or TOML."""
        run = {k: list(v) if isinstance(v, tuple) else v for k, v in self.run.items()}
        noise, law = run.pop("noise", None), run.get("contact")
        if isinstance(law, ContactLaw):
            run |= {"contact": contact_laws.name_of(law), **describe(law)}
        tables: Tables = {
            "format": FORMAT,
            "system": systems.described(self.system),
            "drive": drives.described(self.drive),
            "run": run,
        }
        if noise is not None:
            tables["noise"] = describe(noise)
        if self.varied:
            tables["sweep"] = plain_sweep(self.varied)
        texts = {name: getattr(self, name) for name in ("name", *_TEXTS)}
        return {name: text for name, text in texts.items() if text} | tables

    def simulate(self, **overrides: Any) -> xr.Dataset:
        """Return the run as a dataset; `overrides` replace arguments of `latolato.simulate`.

        Examples
        --------
        >>> import latolato as ll
        >>> run = ll.load_scenario("fig02").simulate(duration=2.0)
        >>> float(run.time[-1])
        2.0
        """
        from latolato.simulation.run import simulate

        return simulate(**self._run_arguments(overrides))

    def record(self, **overrides: Any) -> Record:
        """Return the run as plain arrays; `overrides` as for `simulate`.

        Examples
        --------
        >>> import latolato as ll
        >>> float(ll.load_scenario("fig02").record(duration=2.0)["time"][-1])
        2.0
        """
        from latolato.simulation.run import record

        return record(**self._run_arguments(overrides))

    def _run_arguments(self, overrides: Mapping[str, Any]) -> dict[str, Any]:
        """Return the arguments of `latolato.simulate`."""
        if self.varied:
            name = self.name or "this scenario"
            axes, file = ", ".join(self.varied["axes"]), self.name or "FILE"
            raise broken_rule("one_run", {"name": name, "axes": axes, "file": file})
        return _replaced({"system": self.system, "drive": self.drive, **self.run}, overrides)

    def sweep(self, **overrides: Any) -> xr.Dataset:
        """Return the map as a dataset; `overrides` replace arguments of `latolato.sweep`.

        An axis takes the place of the value that ``[run]`` gives.

        Examples
        --------
        >>> import latolato as ll
        >>> few = {"drive_amplitude": [0.1, 0.2], "frequency_ratio": [1.5, 2.0]}
        >>> ll.load_scenario("fig03cd").sweep(axes=few, duration=2.0).mean_energy.shape
        (2, 2)
        """
        from latolato.sweeps import sweep

        return sweep(**self._sweep_arguments(overrides))

    def plan(self) -> Plan:
        """Return the plan of the sweep.

        Raises
        ------
        InputError
            For bad input, naming value, rule and way out, and if nothing varies.
        """
        from latolato.sweeps.plan import make_plan

        return make_plan(**self._sweep_arguments({}))

    def _sweep_arguments(self, overrides: Mapping[str, Any]) -> dict[str, Any]:
        """Return the arguments of `latolato.sweep`, without values that axes take the place of."""
        if not self.varied.get("axes"):
            name = f"'{self.name}' names" if self.name else "there is"
            raise InputError(
                f"{name} nothing to vary",
                way_out='give axes, for example --axis "drive_amplitude = 0 : 0.5 : 40 m"',
            )
        run = {k: v for k, v in self.run.items() if k not in _OF_ONE_RUN}
        if "duration" not in run:
            if "times" not in self.run:
                raise InputError("a sweep needs a duration [s]")
            run["duration"] = self.run["times"][-1]
        drive = self.drive if self.drive.moves else None
        arguments = {"system": self.system, "drive": drive, **run, **self.varied}
        arguments = _replaced(arguments, overrides)
        varied = names_in(arguments["axes"])
        replaced = {name for name in run if is_replaced(name, self.system, varied)}
        return {k: v for k, v in arguments.items() if k in overrides or k not in replaced}


def entry_of(parameter: str, value: str = "") -> str:
    """Return what a scenario's file calls a parameter, with its table where that is in its name.

    Examples
    --------
    >>> entry_of("right_length"), entry_of("drive_times"), entry_of("suspension", "rod")
    ('right.length', 'drive.times', "suspension='rod'")
    """
    from latolato.scenario.options import law_options

    option = law_options().get(parameter)
    for path in (option.path, (option.owner, *option.path)) if option else ():
        if "_".join(path) == parameter:
            return python_name(".".join(path), value)
    return python_name(parameter, value)


def load_scenario(source: str | Path) -> Scenario:
    """Return a shipped scenario, one from a TOML file, or the one stored in a run's file.

    Parameters
    ----------
    source : str or Path
        A name listed by `scenarios`, or a file. A run's file gives its own scenario, sampled at
        the same instants.

    Raises
    ------
    FileNotFoundError
        If there is neither such a file nor such a name.
    InputError
        If the content is no scenario.
    """
    path = find(source)
    try:
        with reading(path.name, gives_values=True):
            return Scenario.from_dict(read_tables(path), folder=path.parent)
    except InputError as error:
        error.name_of = entry_of
        raise


def scenarios() -> dict[str, Scenario]:
    """Return the shipped scenarios by name."""
    return {path.stem: load_scenario(path) for path in shipped().values()}


def find(source: str | Path) -> Path:
    """Return the file of a scenario given by the name of a shipped one or by a path."""
    known = shipped()
    if str(source) in known:
        return known[str(source)]
    from latolato.core.atomic import checked_path

    path = checked_path("scenario", source)
    if path.is_file():
        return path
    if path.exists():
        raise InputError("must be a file", parameter="scenario", value=str(source))
    hint = suggest(str(source), list(known))
    raise FileNotFoundError(f"there is no scenario or file '{source}': {hint}")


def read_tables(path: Path) -> Tables:
    """Return the tables of a scenario in a TOML file or of the run in a result file."""
    if path.suffix.lower() != ".toml":
        from latolato.io.files import load

        return tables_of(load(path), path.name)
    import tomllib

    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise InputError(f"{path.name} is no TOML file: {error}") from None
    except RecursionError:
        raise InputError(f"{path.name} is nested too deep for a scenario") from None
    return {"name": path.stem, **tables}


def tables_of(run: xr.Dataset, name: str = "this dataset") -> Tables:
    """Return the tables that run a dataset again, at the same instants."""
    if "scenario" not in run.attrs or "time" not in run:
        raise InputError(f"{name} holds no run of latolato: it has no attribute 'scenario'")
    tables: Tables = json.loads(run.attrs["scenario"])
    table = checked_table(tables.get("run", {}), "run")
    return {**tables, "run": {**table, "times": run["time"].values.tolist()}}


def overridden(tables: Tables, changes: Mapping[str, Mapping[str, Any]]) -> Tables:
    """Return the tables of a scenario with some entries replaced.

    A new kind of system or drive keeps the entries that it knows too. A value that excludes
    others, such as `frequency_ratio` and `drive_frequency`, takes their place.
    """
    merged = dict(tables)
    for part, new in changes.items():
        old = dict(checked_table(tables.get(part, {}), part))
        kind = new.get("kind")
        if kind is not None and not isinstance(kind, str):
            raise broken_rule("kind_of_law", {"part": part}, value=kind)
        if part in ("system", "drive") and kind is not None and kind != old.get("kind"):
            law = (systems if part == "system" else drives)[kind]
            known = {f.name for f in fields(law)}
            old = {k: v for k, v in old.items() if RATIOS.get(k, k) in known}
        if part == "run" and new.get("contact", old.get("contact")) != old.get("contact"):
            old = {k: v for k, v in old.items() if k in RUN_OPTIONS}
        for group in ALTERNATIVES:
            if group & new.keys():
                old = {k: v for k, v in old.items() if k not in group}
        for name, value in new.items():
            both = isinstance(value, Mapping) and isinstance(old.get(name), Mapping)
            old[name] = {**old[name], **value} if both else value
        merged[part] = old
    return merged


def _replaced(arguments: dict[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of `simulate` with some replaced, and those that exclude them gone."""
    kept = arguments
    for group in ALTERNATIVES:
        if group & overrides.keys():
            kept = {k: v for k, v in kept.items() if k not in group}
    return {**kept, **overrides}


def _check_ratios(drive: Mapping[str, Any], names: Any) -> None:
    """Raise InputError if it is open whether a drive given by a ratio moves with a parameter."""
    named = names if isinstance(names, (list, tuple)) else [names]
    moving = [name for name in named if name in ("length", "right_length", "gravity")]
    for ratio, plain in RATIOS.items():
        if ratio in drive and moving and ratio not in named and plain not in named:
            raise InputError(
                f"names {moving[0]}, which sets the natural frequency, and the drive is given by "
                f"{ratio}",
                parameter="sensitivity_to",
                way_out=f"name {ratio} too to keep the ratio, or {plain} to keep the frequency"
                if ratio == "frequency_ratio"
                else f"give {plain} instead",
            )


@lru_cache(maxsize=1)
def shipped() -> dict[str, Path]:
    """Return the files of the shipped scenarios by name."""
    folder = Path(__file__).parent / "built_in"
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def changed_tables(
    path: Path | None, changed: dict[str, dict[str, Any]], tables: Mapping[str, Any] | None = None
) -> dict[str, Any]:
    """Return the tables of a scenario with the options put in."""
    if path is None and tables is None and "kind" not in changed.get("system", {}):
        raise broken_rule("what_to_run", {"systems": ", ".join(systems)})
    if tables is None:
        tables = read_tables(path) if path else {}
    if "drive" in changed and tables.get("drive", {}).get("kind", "fixed_pivot") == "fixed_pivot":
        changed["drive"].setdefault("kind", "harmonic")
    return overridden(dict(tables), changed)


def changed_scenario(path: Path | None, tables: Tables) -> Scenario:
    """Return the scenario in tables into which options were put.

    What is wrong in its file alone, where it has one, names the file.
    """
    try:
        return Scenario.from_dict(tables, folder=path.parent if path else None)
    except InputError as error:
        if path is not None:
            _refuse_alike(path, error)
        raise


def _refuse_alike(path: Path, error: InputError) -> None:
    """Raise the error of a file if it is another one's, with the same value."""
    try:
        load_scenario(path)
    except InputError as own:
        both = [(str(each.rule), each.parameter, str(each.value)) for each in (own, error)]
        if both[0] == both[1]:
            raise own from None
