"""What of a run can be varied, by name: numbers of its laws and of its start."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from latolato.core.parameters import Parameter, law_parameters
from latolato.core.quantities import NON_NEGATIVE, QUANTITIES
from latolato.physics.noise import KEY, STREAMS
from latolato.simulation.parameters import RUN_PARAMETERS

# Parameters that stand for another one, which is set from them.
DERIVED = {
    "frequency_ratio": "drive_frequency",
    "amplitude_ratio": "drive_amplitude",
    "drive_acceleration_ratio": "drive_amplitude",
}
# Parameters that set the same thing.
TARGETS = {**DERIVED, "initial_offset": "initial_angle"}


def parameters_of(system: Any, drive: Any, noise: Any = None) -> dict[str, Parameter]:
    """Return every number that can be varied, by name.

    Parameters
    ----------
    system : System, or its class
    drive : Drive, or its class
    noise : VelocityKicks, or its class, optional
    """
    laws = {"system": system, "drive": drive} | ({"noise": noise} if noise is not None else {})
    result = {
        parameter.name: parameter
        for owner, law in laws.items()
        for parameter in law_parameters(law, owner)
        if parameter.is_number
    }
    for name, target in DERIVED.items():
        if target in result:
            result[name] = replace(
                result[target], name=name, kind=float, quantity=QUANTITIES[name],
                allowed=NON_NEGATIVE,
            )  # fmt: skip
    if "drive_frequency" not in result:  # stages have several accelerations
        result.pop("drive_acceleration_ratio", None)
    sides = ("",) if system.angles == 1 else ("_right", "_left")
    starts = ["initial_angle", "initial_angular_velocity"]
    if "suspension" in system.__dataclass_fields__:
        starts.append("initial_distance")
    for name in starts:
        result |= {name + side: replace(RUN_PARAMETERS[name], name=name + side) for side in sides}
    if system.has_contacts and system.angles == 1:
        result["initial_offset"] = RUN_PARAMETERS["initial_offset"]
    for name in result.keys() & set(KEY):
        # Floats hold every whole number up to here, also of seeds.
        result[name] = replace(result[name], allowed=STREAMS)
    return result


def replaced(law: Any, values: Mapping[tuple[str, ...], Any]) -> Any:
    """Return a law with other values where these paths lead: to its own fields or its parts'."""
    changed: dict[str, Any] = {}
    for (name, *inner), value in values.items():
        if inner:
            changed.setdefault(name, {})[inner[0]] = value
        else:
            changed[name] = value
    parts = {n: replace(getattr(law, n), **v) for n, v in changed.items() if isinstance(v, dict)}
    return replace(law, **changed | parts) if changed else law
