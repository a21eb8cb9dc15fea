"""Options that set the entries of a scenario, made from the registries: one for each parameter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass
from functools import lru_cache
from typing import Any

from latolato.core.quantities import Quantity
from latolato.core.registry import types_of
from latolato.physics.drives import drives
from latolato.physics.noise import VelocityKicks
from latolato.physics.pendulum import systems
from latolato.scenario.tables import RATIOS, RUN_OPTIONS
from latolato.scenario.units import to_si_list


@dataclass(frozen=True)
class LawOption:
    """An option of the command line that sets one entry of a scenario's table."""

    name: str
    path: tuple[str, ...]
    kind: Any
    description: str
    unit: str = ""
    several: bool = False

    def value(self, given: Any) -> Any:
        """Return what the table gets; names of data files begin in the working directory."""
        return to_si_list(self.name, given, self.unit) if self.several else given


@lru_cache(maxsize=1)
def law_options() -> dict[str, LawOption]:
    """Return the options that set system, drive, run and noise, by name."""
    found = {
        "system": LawOption("system", ("system", "kind"), str, f"one of {', '.join(systems)}"),
        "drive": LawOption("drive", ("drive", "kind"), str, f"one of {', '.join(drives)}"),
    }
    for table, registry in {"system": systems, "drive": drives}.items():
        for law in registry.values():
            found |= {o.name: o for o in _options_of(law, table) if o.name not in found}
    for ratio, plain in RATIOS.items():
        text = f"instead of {plain.replace('_', '-')}, in natural frequencies"
        found[ratio] = LawOption(ratio, ("drive", ratio), str, text, "1", ratio.endswith("s"))
    for name, entry in RUN_OPTIONS.items():
        kind: Any = str if entry.unit or name in ("contact", "frame") else int
        several = name == "times"
        found[name] = LawOption(name, ("run", name), kind, entry.description, entry.unit, several)
    return found | {o.name: o for o in _options_of(VelocityKicks, "noise")}


def _options_of(law: type, table: str) -> Iterator[LawOption]:
    """Yield an option for each field of a law, and of the laws that it is made of."""
    hints = types_of(law)
    for field in fields(law):
        if not field.init:
            continue
        if is_dataclass(hints[field.name]):
            for part in _options_of(hints[field.name], table):
                name = f"{field.name}_{part.name}"
                path = (table, field.name, part.path[-1])
                text = f"{part.description}, {field.name} ball"
                yield LawOption(name, path, part.kind, text, part.unit, part.several)
            continue
        quantity: Quantity | None = field.metadata.get("quantity")
        # A drive's `times` are not the instants of the samples.
        is_taken = field.name in RUN_OPTIONS
        name = f"{table}_{field.name}" if is_taken else field.name
        several = bool(field.metadata.get("array"))
        kind = hints[field.name] if quantity is None or hints[field.name] is int else str
        text = field.metadata.get("description", field.name.replace("_", " "))
        choices = field.metadata.get("choices")
        yield LawOption(
            name,
            (table, field.name),
            kind,
            f"{text}: {' or '.join(choices)}" if choices else text,
            quantity.unit if quantity else "",
            several,
        )


def changes(given: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the tables of a scenario's changes that options ask for, those not given left out."""
    found: dict[str, dict[str, Any]] = {}
    for name, option in law_options().items():
        if given.get(name) is None:
            continue
        table, *inner, key = option.path
        place = found.setdefault(table, {})
        for part in inner:
            place = place.setdefault(part, {})
        place[key] = option.value(given[name])
    return found
