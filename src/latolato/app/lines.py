"""The lines of Python and of the command line that reproduce what a page shows."""

from __future__ import annotations

import shlex
from dataclasses import MISSING, fields
from inspect import signature
from typing import Any

from latolato.app.given import options_of
from latolato.scenario.scenario import Scenario
from latolato.simulation.run import simulate


def python_line(scenario: Scenario) -> str:
    """Return a Python program that makes the run of a scenario.

    Examples
    --------
    >>> from latolato import load_scenario
    >>> print(python_line(load_scenario("fig02")))
    import latolato as ll
    <BLANKLINE>
    system = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.26)
    run = ll.simulate(system, drive, initial_angle=0.001, duration=300.0)
    """
    lines = ["import latolato as ll", "", f"system = {constructor(scenario.system)}"]
    arguments = ["system"]
    if scenario.drive.moves:
        lines.append(f"drive = {constructor(scenario.drive)}")
        arguments.append("drive")
    defaults = {name: p.default for name, p in signature(simulate).parameters.items()}
    for name, value in scenario.run.items():
        if value == defaults[name]:
            continue
        shown = constructor(value) if hasattr(value, "__dataclass_fields__") else literal(value)
        arguments.append(f"{name}={shown}")
    return "\n".join([*lines, f"run = ll.simulate({', '.join(arguments)})"])


def constructor(law: Any) -> str:
    """Return the call that makes a law; values that are the default are left out."""
    parts = []
    # What a law inherits, such as gravity, is said last.
    own = sorted(fields(law), key=lambda f: f.name == "gravity")
    for f in own:
        value = getattr(law, f.name)
        if not f.init or (f.default is not MISSING and value == f.default):
            continue
        shown = constructor(value) if hasattr(value, "__dataclass_fields__") else literal(value)
        parts.append(f"{f.name}={shown}")
    return f"ll.{type(law).__name__}({', '.join(parts)})"


def literal(value: Any) -> str:
    """Return a value as Python writes it; tuples as lists."""
    return repr(list(value)) if isinstance(value, tuple) else repr(value)


def command_line(scenario: Scenario, command: str = "simulate") -> str:
    """Return the command that makes the run of a scenario, quoted for a shell.

    Examples
    --------
    >>> from latolato import load_scenario
    >>> command_line(load_scenario("zeno"))[:40]
    'latolato simulate --system latolato --dr'
    """
    words = ["latolato", command]
    defaults = defaults_of(scenario)
    for name, value in options_of(scenario).items():
        if defaults.get(name, MISSING) == value:
            continue
        words.append("--" + name.replace("_", "-"))
        if isinstance(value, bool):
            continue
        listed = isinstance(value, (list, tuple))
        words.append(", ".join(f"{v:.17g}" for v in value) if listed else _text(value))
    return shlex.join(words)


def _text(value: Any) -> str:
    """Return one value of an option."""
    return repr(value) if isinstance(value, float) else str(value)


def defaults_of(scenario: Scenario) -> dict[str, Any]:
    """Return the options of a scenario's laws that have a default, and that default."""
    return {
        f.name: f.default
        for law in (scenario.system, scenario.drive)
        for f in fields(law)
        if f.default is not MISSING
    }
