"""Tables of a scenario: what they may hold, and which laws and arguments they stand for."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import MISSING, fields, is_dataclass, replace
from inspect import signature
from pathlib import Path
from typing import Any

from latolato.core.errors import InputError, Word, name_gap
from latolato.core.parameters import Parameter, law_parameters
from latolato.core.quantities import NON_NEGATIVE
from latolato.core.registry import checked_number, suggest, types_of
from latolato.core.rules import broken_rule, each_of, either_of
from latolato.observables import Observable, observables
from latolato.physics.contacts import contact_laws
from latolato.physics.drives import Drive, drives
from latolato.physics.pendulum import System
from latolato.scenario.units import to_si, to_si_list
from latolato.scenario.variation import known_quantities, read_axes, with_placeholders
from latolato.simulation.parameters import RUN_PARAMETERS, SWEEP_PARAMETERS
from latolato.simulation.run import simulate

# Drive parameters that may be given as multiples of the natural frequency.
RATIOS = {
    "frequency_ratio": "drive_frequency",
    "frequency_ratios": "drive_frequencies",
    "frequency_ratio_final": "drive_frequency_final",
}


_SIMULATE = signature(simulate).parameters
# The entries of ``[run]``, with the defaults of `latolato.simulate`.
RUN_OPTIONS = {
    name: replace(parameter, default=getattr(_SIMULATE.get(name), "default", None))
    for name, parameter in RUN_PARAMETERS.items()
}
# Entries of ``[run]`` that may as well stand in ``[sweep]``.
_OF_RUN = ("duration", "tolerance")

Tables = dict[str, Any]


class ForeignParameterError(InputError):
    """A parameter of another law than the one that it is given for."""


def run_options() -> dict[str, Parameter]:
    """Return the entries of ``[run]`` by name, the parameters of contact laws among them."""
    contact = replace(RUN_OPTIONS["contact"], choices=tuple(contact_laws))
    own = (p for law in contact_laws.values() for p in law_parameters(law, "run"))
    return RUN_OPTIONS | {parameter.name: parameter for parameter in (contact, *own)}


def _with_contact(run: Tables) -> Tables:
    """Return entries of ``[run]`` with a contact law in place of its name and parameters."""
    if isinstance(run.get("contact"), str):
        contact_laws[run["contact"]]  # names unknown ones, also where no contact can be
    owners: dict[str, list[str]] = {}
    for kind, law in contact_laws.items():
        for parameter in law_parameters(law, "run"):
            owners.setdefault(parameter.name, []).append(kind)
    own = {name: value for name, value in run.items() if name in owners}
    for name in own:
        if run.get("contact") not in owners[name]:
            contact = run.get("contact", RUN_OPTIONS["contact"].default) or "none"
            raise broken_rule(
                "foreign",
                {
                    "part": Word("contact"),
                    "owners": either_of(owners[name]),
                    "kind": Word(contact),
                },
                parameter=name,
                kind=ForeignParameterError,
            )
    if not own:
        return run
    law = contact_laws[run["contact"]](**own)
    return {name: value for name, value in run.items() if name not in own} | {"contact": law}


def checked_table(value: Any, name: str) -> Mapping[str, Any]:
    """Return a table, or raise if it is something else."""
    if not isinstance(value, Mapping):
        raise InputError("must be a table of names and values", parameter=name, value=value)
    for key in value:
        if not isinstance(key, str):
            raise InputError(f"the names in {name} must be texts", value=key)
    return value


def law_from(value: Any, registry: Any, part: str, folder: Path) -> Any:
    """Return the system or drive that a table describes."""
    table = dict(checked_table(value, part))
    if "kind" not in table:
        raise InputError(f"[{part}] needs a kind: {', '.join(registry)}")
    kind = table.pop("kind")
    if not isinstance(kind, str):
        raise broken_rule("kind_of_law", {"part": part}, value=kind)
    for name, inner in table.items():
        _check_owner(name, inner, registry, part, kind)
    return build_from(registry[kind], table, folder)


def _check_owner(name: str, value: Any, registry: Any, part: str, kind: str) -> None:
    """Raise InputError if an entry of a table belongs to other laws of the registry only."""
    owners = [k for k, law in registry.items() if name in {f.name for f in fields(law) if f.init}]
    hints = types_of(registry[kind])
    own = {f.name for f in fields(registry[kind])}
    of_parts = {f.name for n in own if is_dataclass(hints[n]) for f in fields(hints[n])}
    if not owners or name in own | of_parts:
        return
    inner = next(iter(value), "") if isinstance(value, Mapping) else ""
    raise broken_rule(
        "foreign_part" if inner in own else "foreign",
        {
            "part": Word(part),
            "owners": either_of(owners),
            "kind": Word(kind),
            "name": name_gap(inner),
        },
        parameter=f"{name}_{inner}" if inner else name,
        kind=ForeignParameterError,
    )


@contextmanager
def renamed(names: Mapping[str, str]) -> Iterator[None]:
    """Name a law's fields in errors as options and attributes of a run do, e.g. right_length."""
    try:
        yield
    except InputError as error:
        error.parameter = names.get(error.parameter or "", error.parameter)
        raise


def build_from(law: type, table: Mapping[str, Any], folder: Path) -> Any:
    """Return a law from a table whose values may carry units."""
    hints = types_of(law)
    known = {f.name: f for f in fields(law)}
    parts = [name for name in known if is_dataclass(hints[name])]
    plain: dict[str, Any] = {}
    # Of a part that is missing its own parameters are what to give.
    needed: dict[str, Any] = {name: {} for name in parts if known[name].default is MISSING}
    own = {name: value for name, value in table.items() if name not in parts}
    for name, value in (own | needed | dict(table)).items():
        if name in parts:
            with renamed({f.name: f"{name}_{f.name}" for f in fields(hints[name])}):
                plain[name] = build_from(hints[name], checked_table(value, name), folder)
        elif name not in known:
            if any(name in hints[part].__dataclass_fields__ for part in parts):
                each = each_of([f"{part}_{name}" for part in parts])
                raise broken_rule(
                    "of_each_part", {"law": Word(law.__name__), "parts": each}, parameter=name
                )
            plain[name] = value  # the law names it together with the closest known one
        elif "quantity" in known[name].metadata:
            convert = to_si_list if known[name].metadata.get("array") else to_si
            where = {"folder": folder} if known[name].metadata.get("array") else {}
            plain[name] = convert(name, value, known[name].metadata["quantity"].unit, **where)
        elif hints[name] is bool and not isinstance(value, bool):
            raise broken_rule("switch", parameter=name, value=value)
        else:
            plain[name] = value
    return law(**plain)


def drive_from(value: Any, system: System, folder: Path) -> Drive:
    """Return the drive that a table describes; errors name its entries as they are written."""
    table = checked_table(value, "drive")
    names = {name: f"drive_{name}" for name in RUN_OPTIONS}
    with renamed(names | {plain: ratio for ratio, plain in RATIOS.items() if ratio in table}):
        drive: Drive = law_from(without_ratios(table, system), drives, "drive", folder)
    return drive


def without_ratios(table: Mapping[str, Any], system: System) -> Tables:
    """Return the table of a drive with frequency ratios turned into angular frequencies."""
    plain = dict(table)
    for ratio, name in RATIOS.items():
        if ratio not in plain:
            continue
        if name in plain:
            raise broken_rule("either", {"name": name_gap(name)}, parameter=ratio)
        value = plain.pop(ratio)
        several = name == "drive_frequencies"
        ratios = to_si_list(ratio, value, "1") if several else [to_si(ratio, value, "1")]
        if not isinstance(ratios, list):
            raise broken_rule("numbers", parameter=ratio, value=value)
        result = [
            checked_number(ratio, number, NON_NEGATIVE, "1") * system.natural_frequency
            for number in ratios
        ]
        plain[name] = result if several else result[0]
    return plain


def run_arguments(table: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the arguments of `simulate` that ``[run]`` describes."""
    plain: dict[str, Any] = {}
    known = run_options()
    for name, value in table.items():
        if name not in known:
            raise InputError(
                f"unknown entry '{{parameter}}' of [run]: {suggest(name, list(known))}",
                parameter=name,
            )
        option = known[name]
        if value is None or not option.unit:
            plain[name] = value
        elif name == "times":
            instants = to_si_list(name, value, option.unit, folder)
            plain[name] = tuple(instants) if isinstance(instants, list) else instants
        elif option.for_each_ball and (isinstance(value, list) or "," in str(value)):
            plain[name] = tuple(to_si_list(name, value, option.unit))
        else:
            plain[name] = to_si(name, value, option.unit)
    plain = _with_contact(plain)
    if "samples" in plain:
        plain["times"] = _even_times(plain.pop("samples"), plain)
    return plain


def with_sweep(tables: Tables, folder: Path) -> tuple[Tables, dict[str, Any]]:
    """Return the tables that single runs share, and the arguments of a sweep."""
    table = dict(checked_table(tables["sweep"], "sweep"))
    run = dict(checked_table(tables.get("run", {}), "run"))
    for name in _OF_RUN:
        if name in table:
            if name in run:
                raise InputError("give {parameter} either in [run] or in [sweep]", parameter=name)
            run[name] = table.pop(name)
    parts = {part: checked_table(tables.get(part, {}), part) for part in ("system", "drive")}
    kinds = {part: parts[part].get("kind") for part in parts}
    varied: dict[str, Any] = {}
    for name, value in table.items():
        if name == "axes":
            known = known_quantities(kinds["system"], kinds["drive"])
            varied[name] = read_axes(value, known, folder)
        elif name == "observables":
            entries = [value] if isinstance(value, str) else value
            if not isinstance(entries, (list, tuple)):
                raise InputError(
                    "must be a list of names or tables", parameter="observables", value=value
                )
            varied[name] = tuple(_observable(each, folder) for each in entries)
        elif name in SWEEP_PARAMETERS:
            unit = SWEEP_PARAMETERS[name].unit
            varied[name] = to_si(name, value, unit) if unit else value
        else:
            known_names = ["axes", "observables", *SWEEP_PARAMETERS, *_OF_RUN]
            raise InputError(
                f"unknown entry '{{parameter}}' of [sweep]: {suggest(name, known_names)}",
                parameter=name,
            )
    system, drive = with_placeholders({**tables, **parts}, varied.get("axes", {}))
    shared = {**tables, "system": system, "run": run}
    return (shared | {"drive": drive} if "drive" in tables else shared), varied


def _observable(value: Any, folder: Path) -> Any:
    """Return an observable, from a table with its kind and parameters; names are left as such."""
    if not isinstance(value, Mapping):
        return value
    table = dict(value)
    kind = table.pop("kind", None)
    if not isinstance(kind, str):
        raise InputError(f"an observable's table needs a kind: {', '.join(observables)}")
    return build_from(observables[kind], table, folder)


def plain_sweep(varied: Mapping[str, Any]) -> Tables:
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
            observables.described(each) if isinstance(each, Observable) else each
            for each in plain["observables"]
        ]
    return plain


def _even_times(samples: Any, run: Mapping[str, Any]) -> tuple[float, ...]:
    """Return evenly spaced instants from 0 to the duration of a run [s]."""
    import numpy as np

    count = RUN_PARAMETERS["samples"].checked(samples)
    if "times" in run:
        raise broken_rule("either", {"name": name_gap("times")}, parameter="samples")
    if "duration" not in run:
        raise broken_rule("duration_of_samples", parameter="samples")
    duration = RUN_PARAMETERS["duration"].checked(run["duration"])
    return tuple(np.linspace(0.0, duration, count).tolist())
