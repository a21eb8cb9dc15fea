"""The dataset of a sweep: labels, attributes, and the arrays that chunks are put into."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.core.errors import InputError
from latolato.core.quantities import Quantity
from latolato.core.registry import flattened
from latolato.core.versions import version_of
from latolato.numerics.records import STATUS_NAMES
from latolato.physics.drives import drives
from latolato.physics.pendulum import LatoLato, systems
from latolato.simulation.record import BALL, BALLS, WHOSE
from latolato.simulation.vary import DERIVED, parameters_of
from latolato.sweeps.chunk import STATUS, Values, status_counts
from latolato.sweeps.plan import Plan
from latolato.sweeps.statuses import FLAGS, with_words

if TYPE_CHECKING:
    import xarray as xr


def dims_of(plan: Plan, name: str) -> tuple[str, ...]:
    """Return the dimensions of a variable."""
    extra: tuple[str, ...] = ()
    if name != STATUS:
        observable = next(o for o in plan.observables if name in o.variables)
        if plan.system.angles == 2 and not observable.is_joint:
            extra += ("ball",)
        if observable.dimension and name not in observable.plain:
            extra += (observable.dimension,)
    return plan.dims + extra


def lengths_of(plan: Plan) -> dict[str, int]:
    """Return the length of every dimension."""
    lengths = dict(zip(plan.dims, plan.shape, strict=True))
    return lengths | {
        "ball": plan.system.angles,
        "sample": max((o.marks for o in plan.observables), default=0),
        "exponent": 2 * plan.system.angles,
    }


def template(plan: Plan) -> dict[str, tuple[tuple[str, ...], Any, float | int]]:
    """Return dimensions, type and fill value of every variable."""
    result: dict[str, tuple[tuple[str, ...], Any, float | int]] = {
        name: (dims_of(plan, name), np.dtype("f8"), float("nan"))
        for observable in plan.observables
        for name in observable.variables
    }
    result[STATUS] = (dims_of(plan, STATUS), np.dtype("i1"), -1)
    return result


def attributes_of_variables(plan: Plan) -> dict[str, dict[str, Any]]:
    """Return the attributes of every variable and coordinate."""
    known = parameters_of(plan.system, plan.drive, plan.noise)
    quantities = {p: known[p].quantity for axis in plan.axes for p in axis.parameters}
    per_ball = plan.system.angles == 2 or isinstance(plan.system, LatoLato)
    result: dict[str, dict[str, Any]] = {}
    for observable in plan.observables:
        quantities |= observable.variables
    joint = {name for o in plan.observables if o.is_joint for name in o.variables}
    energies = {n for o in plan.observables for n, q in o.variables.items() if q.unit == "J"}
    for name, quantity in quantities.items():
        result[name] = quantity.attributes
        if per_ball and name in energies:
            both = plan.system.angles == 2 and name in joint
            result[name]["long_name"] += f", {WHOSE[both]}"
    result["ball"] = BALL.attributes
    result["direction"] = Quantity("1", "", "way along the continuation").attributes
    result[STATUS] = {
        **Quantity("1", "", "status of the point").attributes,
        **FLAGS,
    }
    return result


def coordinates_of(plan: Plan) -> dict[str, tuple[tuple[str, ...], Any]]:
    """Return the coordinates: the varied parameters, `direction`, `ball`."""
    result: dict[str, tuple[tuple[str, ...], Any]] = {}
    if plan.direction == "both":
        result["direction"] = (("direction",), np.array(["up", "down"]))
    for axis in plan.axes:
        for name, values in zip(axis.parameters, axis.values, strict=True):
            result[name] = ((axis.name,), np.array(values))
    if plan.system.angles == 2:
        result["ball"] = (("ball",), np.array(BALLS))
    return result


def attributes_of(plan: Plan, rounding: str) -> dict[str, Any]:
    """Return the attributes of the dataset: parameters, provenance and the plan itself.

    `rounding` is a value of `executors.ROUNDING`.
    """
    from latolato.numerics.abi import sources_hash

    described = plan.describe()
    flat: dict[str, Any] = {
        "title": f"latolato sweep of {systems.name_of(plan.system)}",
        "latolato_version": version_of(),
        "numpy_version": np.__version__,
        "numba_version": version_of("numba"),
        "kernel_sources": sources_hash(),
        "rounding": rounding,
        "system": systems.name_of(plan.system),
        "drive": drives.name_of(plan.drive),
    }
    # What varies under another name has no value of its own either.
    varied = plan.varied | {DERIVED[name] for name in plan.varied & DERIVED.keys()}
    for part in ("system", "drive", "start"):
        flat |= flattened(described[part])
    for name in ("duration", "transient", "transient_periods", "tolerance", "rest_speed"):
        flat[name] = described[name]
    flat["contact"] = described["contact"]["kind"]
    if plan.noise is not None:
        flat |= flattened(described["noise"])
        if plan.own_streams:
            flat["noise_streams"] = "noise_stream + number of the point in C order"
    if plan.continuation:
        flat |= {"continuation": plan.continuation, "continuation_direction": plan.direction}
    for observable in described["observables"]:
        flat |= flattened(observable)
    flat = {name: value for name, value in flat.items() if name not in varied}
    return flat | {"plan": json.dumps(described), "plan_hash": plan.hash}


def in_order(counts: Mapping[str, int]) -> dict[str, int]:
    """Return counts of statuses in the order of these, whatever that of the chunks was."""
    return {name: counts[name] for name in STATUS_NAMES if counts.get(name)}


class Results:
    """A sweep's results: the missing chunks, and the results of the points in the others.

    Attributes
    ----------
    missing : sequence of int
        Chunks that have to be computed, known once the results are entered.
    points_done : int
        Points of the other chunks.
    """

    def __init__(self, plan: Plan, rounding: str) -> None:
        self.plan = plan
        self.rounding = rounding
        self.missing: Sequence[int] = range(plan.chunks)
        self.points_done = 0
        self._counts: Counter[str] = Counter()
        self._reasons: dict[int, str] = {}

    def status_counts(self) -> dict[str, int]:
        """Return how many points of the finished chunks have each status that occurs."""
        return in_order(self._counts)

    def _add(self, number: int, counts: Mapping[str, int], reason: str) -> None:
        """Take note of a finished chunk, or of points that begin with this one."""
        self._counts.update(counts)
        self._reasons[number] = reason

    @property
    def _reason(self) -> str:
        """Why points have no answer; the same whatever the order in which chunks came."""
        return next((reason for _, reason in sorted(self._reasons.items()) if reason), "")


class Memory(Results):
    """A sweep's results in memory."""

    def __init__(self, plan: Plan, rounding: str) -> None:
        super().__init__(plan, rounding)
        lengths = lengths_of(plan)
        try:
            self.arrays = {
                name: np.full([lengths[d] for d in dims], fill, dtype=dtype)
                for name, (dims, dtype, fill) in template(plan).items()
            }
        except MemoryError as error:
            raise InputError(
                f"the results of {plan.size:,} points do not fit into memory: {error}",
                way_out="give a store, which is written chunk by chunk, or take fewer points",
            ) from None

    def __enter__(self) -> Memory:
        return self

    def __exit__(self, *_: object) -> None:
        """Nothing has to be closed."""

    def write(self, number: int, values: Values, reason: str) -> None:
        """Put the values of a chunk in their place."""
        block = self.plan.block(number)
        for name, array in self.arrays.items():
            array[block] = values[name]
        self._add(number, status_counts(values[STATUS]), reason)

    def dataset(self) -> xr.Dataset:
        """Return the labelled dataset."""
        import xarray as xr

        about = attributes_of_variables(self.plan)
        coordinates = coordinates_of(self.plan)
        dataset = xr.Dataset(
            {n: (dims_of(self.plan, n), array, about[n]) for n, array in self.arrays.items()},
            coords={n: (*entry, about.get(n, {})) for n, entry in coordinates.items()},
            attrs=attributes_of(self.plan, self.rounding),
        )
        if self._reason:
            dataset.attrs["first_invalid"] = self._reason
        return with_words(dataset)
