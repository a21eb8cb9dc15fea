"""Scenarios: a system, a drive and a start, written in TOML with units and run by name.

A scenario has the tables ``[system]``, ``[drive]``, ``[run]`` and ``[noise]``; with ``[sweep]`` it
is a sweep. Every run stores its own scenario in the attribute ``scenario``, in the same layout with
plain SI numbers, so that a result file can be run again.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, fields, is_dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, get_type_hints

from latolato.observables import Observable, observables
from latolato.physics.contacts import Clamp, contact_laws
from latolato.physics.drives import Drive, Static, drives
from latolato.physics.noise import VelocityKicks
from latolato.physics.pendulum import System, systems
from latolato.quantities import NON_NEGATIVE, POSITIVE
from latolato.registry import build, checked_number, describe, suggest
from latolato.units import to_si, to_si_list
from latolato.variation import known_quantities, read_axes, with_placeholders

if TYPE_CHECKING:
    import xarray as xr

    from latolato.sweep.plan import Plan

# Drive parameters that may be given as multiples of the natural frequency.
RATIOS = {
    "frequency_ratio": "drive_frequency",
    "frequency_ratios": "drive_frequencies",
    "frequency_ratio_final": "drive_frequency_final",
}


@dataclass(frozen=True)
class RunOption:
    """One entry of ``[run]``: its unit, what it does, and whether it holds several values."""

    unit: str
    description: str
    several: bool = False


RUN_OPTIONS = {
    "initial_angle": RunOption("rad", "angle at the start; of a ballpair right, left", True),
    "initial_angular_velocity": RunOption(
        "rad/s", "angular velocity at the start; of a ballpair right, left", True
    ),
    "initial_offset": RunOption("rad", "start this far above the low contact angle instead"),
    "duration": RunOption("s", "end of the run"),
    "times": RunOption("s", "instants of the samples, or a file that holds them", True),
    "samples": RunOption("", "number of evenly spaced samples instead of times"),
    "tolerance": RunOption("rad", "aimed-at error of the angle"),
    "contact": RunOption("", f"contact law: {', '.join(contact_laws)}"),
    "clamp_step": RunOption("s", "fixed step of contact 'clamp'"),
    "rest_speed": RunOption("rad/s", "impacts up to this speed begin rest"),
    "frame": RunOption("", "'both' adds the energy in the laboratory frame"),
    "contact_limit": RunOption("", "contacts after which the run stops"),
}

# Entries of ``[sweep]`` beside `axes`, `observables` and those of ``[run]``, with their units.
SWEEP_OPTIONS = {
    "transient": "s",
    "transient_periods": "1",
    "continuation": "",
    "direction": "",
    "chunk_size": "",
}
# Entries of ``[run]`` that may as well stand in ``[sweep]``.
_OF_RUN = ("duration", "tolerance")
# Entries of ``[run]`` that say how one run is sampled.
_OF_ONE_RUN = ("times", "frame")

# A new value of one of these takes the place of the others.
_ALTERNATIVES = (
    *({ratio, plain} for ratio, plain in RATIOS.items()),
    {"initial_angle", "initial_offset"},
    {"times", "samples"},
    {"times", "duration"},
)
# The field that a message is about: its first word, or what is missing.
_FIELD = re.compile(r"^\w+(?= |:|\[)|(?<= needs ')\w+")
_TABLES = ("system", "drive", "run", "noise", "sweep")
_TEXTS = ("title", "description", "figure")
DEFAULT_OBSERVABLES = ("mean_energy", "crossings", "largest_angle")

Tables = dict[str, Any]


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
        The further arguments of `latolato.simulate` by name.
    varied : mapping
        The arguments of `latolato.sweep` that ``[sweep]`` gives: `axes`, `observables` and more;
        empty for a scenario of one run.
    name, title, description : str
        What the scenario is called and what it shows, with every assumption made.
    figure : str
        The figure of the paper that it belongs to.
    """

    system: System
    drive: Drive = field(default_factory=Static)
    run: Mapping[str, Any] = field(default_factory=dict)
    varied: Mapping[str, Any] = field(default_factory=dict)
    name: str = ""
    title: str = ""
    description: str = ""
    figure: str = ""

    @classmethod
    def from_dict(cls, tables: Any, *, folder: Path | None = None) -> Scenario:
        """Return the scenario that nested tables describe, with or without units.

        Parameters
        ----------
        tables : mapping
            The tables `system`, `drive`, `run`, `noise` and `sweep`, and the texts `name`, `title`,
            `description` and `figure`.
        folder : Path, optional
            Where the names of data files begin.

        Raises
        ------
        TypeError, ValueError
            For unknown names, with the closest known one, wrong types, units and values.
        """
        known = [*_TABLES, "name", *_TEXTS]
        for name, value in _table(tables, "a scenario").items():
            if name not in known:
                raise ValueError(f"unknown entry '{name}': {suggest(name, known)}")
            if name not in _TABLES and not isinstance(value, str):
                raise TypeError(f"{name} must be a text, got {value!r}")
        if "system" not in tables:
            raise ValueError(f"a scenario needs [system] with a kind: {', '.join(systems)}")
        folder = folder or Path()
        varied: dict[str, Any] = {}
        if "sweep" in tables:
            tables, varied = _with_sweep(tables, folder)
        system = _law(tables["system"], systems, "system", folder)
        drive: Drive = Static()
        if "drive" in tables:
            plain = _without_ratios(_table(tables["drive"], "drive"), system)
            with _said_as({name: f"drive_{name}" for name in RUN_OPTIONS}):
                drive = _law(plain, drives, "drive", folder)
        run = _run_arguments(_table(tables.get("run", {}), "run"), folder)
        if "noise" in tables:
            table = _table(tables["noise"], "noise")
            with _said_as({f.name: f"noise_{f.name}" for f in fields(VelocityKicks)}):
                run["noise"] = _build(VelocityKicks, table, folder)
        texts = {name: tables[name].strip() for name in ("name", *_TEXTS) if name in tables}
        return cls(system=system, drive=drive, run=run, varied=varied, **texts)

    def to_dict(self) -> Tables:
        """Return the tables of this scenario as plain SI numbers, for JSON or TOML."""
        run = {k: list(v) if isinstance(v, tuple) else v for k, v in self.run.items()}
        noise, law = run.pop("noise", None), run.get("contact")
        if isinstance(law, Clamp):
            run.update(contact="clamp", clamp_step=law.step)
        tables: Tables = {
            "system": {"kind": systems.name_of(self.system), **describe(self.system)},
            "drive": {"kind": drives.name_of(self.drive), **describe(self.drive)},
            "run": run,
        }
        if noise is not None:
            tables["noise"] = describe(noise)
        if self.varied:
            tables["sweep"] = _plain_sweep(self.varied)
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
        from latolato.simulate import simulate

        if self.varied:
            name = self.name or "this scenario"
            raise ValueError(
                f"{name} is a sweep over {', '.join(self.varied['axes'])}, not one run: use "
                f"`latolato sweep {self.name or 'FILE'}`, or Scenario.sweep in Python"
            )
        given = {"system": self.system, "drive": self.drive, **self.run}
        return simulate(**_replaced(given, overrides))

    def sweep(self, **overrides: Any) -> xr.Dataset:
        """Return the map as a dataset; `overrides` replace arguments of `latolato.sweep`.

        Examples
        --------
        >>> import latolato as ll
        >>> few = {"drive_amplitude": [0.1, 0.2], "frequency_ratio": [1.5, 2.0]}
        >>> ll.load_scenario("fig03cd").sweep(axes=few, duration=2.0).mean_energy.shape
        (2, 2)
        """
        from latolato.sweep import sweep

        return sweep(**_replaced(self._sweep_arguments(), overrides))

    def plan(self) -> Plan:
        """Return the plan of the sweep.

        Raises
        ------
        TypeError, ValueError
            For bad input, naming value, rule and way out, and if nothing varies.
        """
        from latolato.sweep.plan import make_plan

        return make_plan(**{"observables": DEFAULT_OBSERVABLES} | self._sweep_arguments())

    def _sweep_arguments(self) -> dict[str, Any]:
        """Return the arguments of `latolato.sweep`."""
        if not self.varied.get("axes"):
            name = f"'{self.name}' names" if self.name else "there is"
            raise ValueError(
                f"{name} nothing to vary: give axes, for example "
                '--axis "drive_amplitude = 0 : 0.5 : 40 m"'
            )
        run = {k: v for k, v in self.run.items() if k not in _OF_ONE_RUN}
        if "duration" not in run:
            if "times" not in self.run:
                raise ValueError("a sweep needs a duration [s]")
            run["duration"] = self.run["times"][-1]
        drive = None if isinstance(self.drive, Static) else self.drive
        return {"system": self.system, "drive": drive, **run, **self.varied}


def load_scenario(source: str | Path) -> Scenario:
    """Return a scenario that is shipped, written in a TOML file, or stored in a run's file.

    Parameters
    ----------
    source : str or Path
        A name listed by `scenarios`, or a file. A run's file gives its own scenario, sampled at
        the same instants.

    Raises
    ------
    FileNotFoundError
        If there is neither such a file nor such a name.
    TypeError, ValueError
        If the content is no scenario.
    """
    path = find(source)
    try:
        return Scenario.from_dict(read_tables(path), folder=path.parent)
    except (TypeError, ValueError) as error:
        kind = TypeError if isinstance(error, TypeError) else ValueError
        raise kind(f"{path.name}: {error}") from None


def scenarios() -> dict[str, Scenario]:
    """Return the shipped scenarios by name."""
    return {path.stem: load_scenario(path) for path in _shipped().values()}


def find(source: str | Path) -> Path:
    """Return the file of a scenario given by the name of a shipped one or by a path."""
    shipped = _shipped()
    if str(source) in shipped:
        return shipped[str(source)]
    path = Path(source)
    if path.is_file():
        return path
    hint = suggest(str(source), list(shipped))
    raise FileNotFoundError(f"there is no scenario or file '{source}': {hint}")


def read_tables(path: Path) -> Tables:
    """Return the tables of a scenario in a TOML file or of the run in a result file."""
    if path.suffix.lower() != ".toml":
        from latolato.files import load

        return tables_of(load(path), path.name)
    import tomllib

    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{path.name} is no TOML file: {error}") from None
    return {"name": path.stem, **tables}


def tables_of(run: xr.Dataset, name: str = "this dataset") -> Tables:
    """Return the tables that run a dataset again, at the same instants."""
    if "scenario" not in run.attrs or "time" not in run:
        raise ValueError(f"{name} holds no run of latolato: it has no attribute 'scenario'")
    tables: Tables = json.loads(run.attrs["scenario"])
    tables["run"]["times"] = run["time"].values.tolist()
    return tables


def overridden(tables: Tables, changes: Mapping[str, Mapping[str, Any]]) -> Tables:
    """Return the tables of a scenario with some entries replaced.

    A new kind of system or drive keeps the entries that it knows too. A value that excludes
    others, such as `frequency_ratio` and `drive_frequency`, takes their place.
    """
    merged = dict(tables)
    for part, new in changes.items():
        old = dict(_table(tables.get(part, {}), part))
        kind = new.get("kind")
        if part in ("system", "drive") and kind is not None and kind != old.get("kind"):
            law = (systems if part == "system" else drives)[kind]
            known = {f.name for f in fields(law)}
            old = {k: v for k, v in old.items() if RATIOS.get(k, k) in known}
        if new.get("contact", "clamp") != "clamp":
            old.pop("clamp_step", None)
        for group in _ALTERNATIVES:
            if group & new.keys():
                old = {k: v for k, v in old.items() if k not in group}
        for name, value in new.items():
            both = isinstance(value, Mapping) and isinstance(old.get(name), Mapping)
            old[name] = {**old[name], **value} if both else value
        merged[part] = old
    return merged


def _replaced(given: dict[str, Any], overrides: Mapping[str, Any]) -> dict[str, Any]:
    """Return the arguments of `simulate` with some replaced, and those that exclude them gone."""
    kept = given
    for group in _ALTERNATIVES:
        if group & overrides.keys():
            kept = {k: v for k, v in kept.items() if k not in group}
    return {**kept, **overrides}


@lru_cache(maxsize=1)
def _shipped() -> dict[str, Path]:
    """Return the files of the shipped scenarios by name."""
    folder = Path(__file__).parent / "scenarios"
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def _table(value: Any, name: str) -> Mapping[str, Any]:
    """Return a table, or raise if it is something else."""
    if not isinstance(value, Mapping):
        raise TypeError(f"{name} must be a table of names and values, got {value!r}")
    for key in value:
        if not isinstance(key, str):
            raise TypeError(f"the names in {name} must be texts, got {key!r}")
    return value


def _law(value: Any, registry: Any, part: str, folder: Path) -> Any:
    """Return the system or drive that a table describes."""
    table = dict(_table(value, part))
    if "kind" not in table:
        raise ValueError(f"[{part}] needs a kind: {', '.join(registry)}")
    kind = table.pop("kind")
    if not isinstance(kind, str):
        raise TypeError(f"the kind of {part} must be a text, got {kind!r}")
    for name, inner in table.items():
        _check_owner(name, inner, registry, part, kind)
    return _build(registry[kind], table, folder)


def _check_owner(name: str, value: Any, registry: Any, part: str, kind: str) -> None:
    """Raise ValueError if an entry of a table belongs to other laws of the registry only."""
    owners = [k for k, law in registry.items() if name in {f.name for f in fields(law) if f.init}]
    hints = get_type_hints(registry[kind])
    own = {f.name for f in fields(registry[kind])}
    of_parts = {f.name for n in own if is_dataclass(hints[n]) for f in fields(hints[n])}
    if not owners or name in own | of_parts:
        return
    inner = next(iter(value), "") if isinstance(value, Mapping) else ""
    raise ValueError(
        f"{f'{name}_{inner}' if inner else name} belongs to {part} {' or '.join(owners)}, not to "
        f"{kind}: {f'use {inner}' if inner in own else 'leave it out'} or change the {part}"
    )


@contextmanager
def _said_as(names: Mapping[str, str]) -> Iterator[None]:
    """Name a law's fields in messages as options and attributes of a run do, e.g. clamp_step."""
    try:
        yield
    except (TypeError, ValueError) as error:
        kind = TypeError if isinstance(error, TypeError) else ValueError
        said = _FIELD.sub(lambda found: names.get(found[0], found[0]), str(error))
        raise kind(said) from None


def _build(law: type, table: Mapping[str, Any], folder: Path) -> Any:
    """Return a law from a table whose values may carry units."""
    hints = get_type_hints(law)
    known = {f.name: f for f in fields(law)}
    parts = [name for name in known if is_dataclass(hints[name])]
    plain: dict[str, Any] = {}
    for name, value in table.items():
        if name in parts:
            with _said_as({f.name: f"{name}_{f.name}" for f in fields(hints[name])}):
                plain[name] = _build(hints[name], _table(value, name), folder)
        elif name not in known:
            if any(name in hints[part].__dataclass_fields__ for part in parts):
                each = " and ".join(f"{part}.{name}" for part in parts)
                raise ValueError(f"{law.__name__} has no '{name}' of its own: give {each}")
            plain[name] = value  # `build` names it together with the closest known one
        elif "quantity" in known[name].metadata:
            convert = to_si_list if known[name].metadata.get("array") else to_si
            where = {"folder": folder} if known[name].metadata.get("array") else {}
            plain[name] = convert(name, value, known[name].metadata["quantity"].unit, **where)
        elif hints[name] is bool and not isinstance(value, bool):
            raise TypeError(f"{name} must be true or false, got {value!r}")
        else:
            plain[name] = value
    return build(law, plain)


def _without_ratios(table: Mapping[str, Any], system: System) -> Tables:
    """Return the table of a drive with frequency ratios turned into angular frequencies."""
    plain = dict(table)
    for ratio, name in RATIOS.items():
        if ratio not in plain:
            continue
        if name in plain:
            raise ValueError(f"give either {name} or {ratio}, got both")
        value = plain.pop(ratio)
        several = name == "drive_frequencies"
        ratios = to_si_list(ratio, value, "1") if several else [to_si(ratio, value, "1")]
        if not isinstance(ratios, list):
            raise TypeError(f"{ratio} must be a sequence of numbers, got {value!r}")
        found = [
            checked_number(ratio, number, NON_NEGATIVE, "times the natural frequency")
            * system.natural_frequency
            for number in ratios
        ]
        plain[name] = found if several else found[0]
    return plain


def _run_arguments(table: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the arguments of `simulate` that ``[run]`` describes."""
    plain: dict[str, Any] = {}
    for name, value in table.items():
        if name not in RUN_OPTIONS:
            raise ValueError(f"unknown entry '{name}' of [run]: {suggest(name, list(RUN_OPTIONS))}")
        option = RUN_OPTIONS[name]
        if value is None or not option.unit:
            plain[name] = value
        elif name == "times":
            instants = to_si_list(name, value, option.unit, folder)
            plain[name] = tuple(instants) if isinstance(instants, list) else instants
        elif option.several and (isinstance(value, list) or "," in str(value)):
            plain[name] = tuple(to_si_list(name, value, option.unit))
        else:
            plain[name] = to_si(name, value, option.unit)
    if isinstance(plain.get("contact"), str):
        contact_laws[plain["contact"]]  # names unknown ones, also where no contact can be
    if "clamp_step" in plain:
        if plain.get("contact") != "clamp":
            raise ValueError(f"clamp_step needs contact 'clamp', got {plain.get('contact')!r}")
        with _said_as({"step": "clamp_step"}):
            plain["contact"] = Clamp(step=plain.pop("clamp_step"))
    if "samples" in plain:
        plain["times"] = _even_times(plain.pop("samples"), plain)
    return plain


def _with_sweep(tables: Tables, folder: Path) -> tuple[Tables, dict[str, Any]]:
    """Return the tables that single runs share, and the arguments of a sweep."""
    table = dict(_table(tables["sweep"], "sweep"))
    run = dict(_table(tables.get("run", {}), "run"))
    for name in _OF_RUN:
        if name in table:
            if name in run:
                raise ValueError(f"give {name} either in [run] or in [sweep], got both")
            run[name] = table.pop(name)
    parts = {part: _table(tables.get(part, {}), part) for part in ("system", "drive")}
    kinds = {part: parts[part].get("kind") for part in parts}
    varied: dict[str, Any] = {}
    for name, value in table.items():
        if name == "axes":
            known = known_quantities(kinds["system"], kinds["drive"])
            varied[name] = read_axes(value, known, folder)
        elif name == "observables":
            given = [value] if isinstance(value, str) else value
            if not isinstance(given, (list, tuple)):
                raise TypeError(f"observables must be a list of names or tables, got {value!r}")
            varied[name] = tuple(_observable(each, folder) for each in given)
        elif name in SWEEP_OPTIONS:
            unit = SWEEP_OPTIONS[name]
            varied[name] = to_si(name, value, unit) if unit else value
        else:
            known_names = ["axes", "observables", *SWEEP_OPTIONS, *_OF_RUN]
            raise ValueError(f"unknown entry '{name}' of [sweep]: {suggest(name, known_names)}")
    system, drive = with_placeholders({**tables, **parts}, varied.get("axes", {}))
    shared = {**tables, "system": system, "run": run}
    return (shared | {"drive": drive} if "drive" in tables else shared), varied


def _observable(given: Any, folder: Path) -> Any:
    """Return an observable, from a table with its kind and parameters; names are left as such."""
    if not isinstance(given, Mapping):
        return given
    table = dict(given)
    kind = table.pop("kind", None)
    if not isinstance(kind, str):
        raise ValueError(f"an observable's table needs a kind: {', '.join(observables)}")
    return _build(observables[kind], table, folder)


def _plain_sweep(varied: Mapping[str, Any]) -> Tables:
    """Return the table ``[sweep]`` as plain values."""
    plain = dict(varied)
    if "axes" in plain:
        plain["axes"] = {
            name: {p: list(v) for p, v in values.items()}
            if isinstance(values, Mapping)
            else list(values)
            for name, values in plain["axes"].items()
        }
    if "observables" in plain:
        plain["observables"] = [
            {"kind": observables.name_of(each), **describe(each)}
            if isinstance(each, Observable)
            else each
            for each in plain["observables"]
        ]
    return plain


def _even_times(samples: Any, run: Mapping[str, Any]) -> tuple[float, ...]:
    """Return evenly spaced instants from 0 to the duration of a run [s]."""
    import numpy as np

    from latolato.simulate import MOST_DEFAULT_SAMPLES

    if isinstance(samples, bool) or not isinstance(samples, int) or samples < 2:
        raise ValueError(f"samples must be a whole number of at least 2, got {samples!r}")
    if samples > MOST_DEFAULT_SAMPLES:
        raise ValueError(f"samples must not exceed {MOST_DEFAULT_SAMPLES}, got {samples}")
    if "times" in run:
        raise ValueError("give either times or samples, got both")
    if "duration" not in run:
        raise ValueError("samples needs a duration")
    duration = checked_number("duration", run["duration"], POSITIVE, "s")
    return tuple(np.linspace(0.0, duration, samples).tolist())
