"""The parameters of runs and sweeps that are no fields of a law: what each may be, and its unit."""

from __future__ import annotations

import math
from typing import Any

from latolato.core.parameters import Parameter
from latolato.core.quantities import (
    ANY,
    COUNT,
    NON_NEGATIVE,
    POSITIVE,
    QUANTITIES,
    Quantity,
    Range,
)
from latolato.numerics.integrate import TOLERANCES

# More samples than this would fill the memory: ask for `times` then.
MOST_SAMPLES = 20_000_000


def _of(owner: str, name: str, description: str, **more: Any) -> Parameter:
    """Return a parameter; a number without a unit of its own is the quantity of this name."""
    kind, unit = more.pop("kind", float), more.pop("unit", "")
    own = unit or kind is not float
    quantity = Quantity(unit, "", name.replace("_", " ")) if own else QUANTITIES[name]
    return Parameter(
        name=name, owner=owner, path=(name,), kind=kind, description=description,
        quantity=quantity, **more,
    )  # fmt: skip


_PARAMETERS = (
    _of(
        "run", "initial_angle", "initial angle; for a ballpair: right, left",
        allowed=ANY, for_each_ball=True, suggested=(-math.pi, math.pi),
    ),
    _of(
        "run", "initial_angular_velocity",
        "initial angular velocity; for a ballpair: right, left",
        allowed=ANY, for_each_ball=True, suggested=(-20.0, 20.0),
    ),
    _of(
        "run", "initial_offset", "start this far above the low contact angle instead",
        allowed=NON_NEGATIVE, suggested=(0.0, 1.5),
    ),
    _of(
        "run", "initial_distance",
        "initial distance from the pivot, less than the length if the string is slack; for a "
        "ballpair: right, left",
        allowed=POSITIVE, for_each_ball=True, suggested=(0.05, 2.0),
    ),
    _of("run", "duration", "end of the run", allowed=POSITIVE, suggested=(1.0, 300.0)),
    _of(
        "run", "times", "sample times, or a file that contains them",
        allowed=NON_NEGATIVE, several=True,
    ),
    _of(
        "run", "samples", "number of evenly spaced samples instead of times",
        kind=int, allowed=Range(2, MOST_SAMPLES),
    ),
    _of("run", "tolerance", "target error of the angle", allowed=Range(*TOLERANCES)),
    _of("run", "contact", "contact law", kind=str),
    _of("run", "rest_speed", "impacts up to this speed begin rest", allowed=NON_NEGATIVE),
    _of(
        "run", "frame", "'both' adds the energy in the laboratory frame",
        kind=str, choices=("pivot", "both"),
    ),
    _of(
        "run", "contact_limit", "number of contacts after which the run stops",
        kind=int, allowed=COUNT,
    ),
    _of(
        "run", "sensitivity_to",
        "parameter by which the motion is differentiated, such as length; may be given several "
        "times",
        kind=str, several=True,
    ),
    _of(
        "sweep", "transient", "time after which observables begin",
        unit="s", allowed=NON_NEGATIVE,
    ),
    _of(
        "sweep", "transient_periods", "the same in drive periods; the two are added",
        unit="1", allowed=NON_NEGATIVE,
    ),
    _of(
        "sweep", "continuation", "axis along which each point starts where its neighbour ended",
        kind=str,
    ),
    _of("sweep", "direction", "way along it", kind=str, choices=("up", "down", "both")),
    _of("sweep", "chunk_size", "points computed and stored at once", kind=int, allowed=COUNT),
)  # fmt: skip
RUN_PARAMETERS = {p.name: p for p in _PARAMETERS if p.owner == "run"}
SWEEP_PARAMETERS = {p.name: p for p in _PARAMETERS if p.owner == "sweep"}
