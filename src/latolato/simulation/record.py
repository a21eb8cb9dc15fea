"""What a run yields, by name: plain arrays that become a labelled dataset when one is wanted."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from latolato.core.quantities import QUANTITIES, Quantity
from latolato.core.registry import describe, flattened
from latolato.core.versions import version_of
from latolato.numerics import records
from latolato.numerics.derived import ACROSS_ROWS, BALL_ROWS, PIVOT_ROWS
from latolato.numerics.integrate import Floats, Trajectory
from latolato.physics.contacts import CONTACT_KINDS, contact_laws
from latolato.physics.drives import drives
from latolato.physics.pendulum import BallPair, LatoLato, System, systems
from latolato.simulation.plan import RunPlan
from latolato.simulation.sensitivity import DOUBTS

if TYPE_CHECKING:
    import xarray as xr

# The energy ledger: its variables and where a trajectory keeps them.
LEDGER = {
    "drive_work": records.S_WORK,
    "damping_loss": records.S_DAMPED,
    "impact_loss": records.S_IMPACT,
    "capture_loss": records.S_CAPTURED,
    "noise_work": records.S_NOISE,
    "retension_loss": records.S_RETENSION,
}
# What is known of each ball on a string, in the order of a ball's rows.
ON_STRINGS = ("distance", "radial_velocity", "slack")


# The coordinate of two balls, and what it is called.
BALLS, BALL = ("right", "left"), Quantity("1", "", "ball")
# Coordinates that are words.
_LABELS = {
    "ball": BALL,
    "parameter": Quantity("1", "", "parameter of the derivatives"),
    "parameter_unit": Quantity("1", "", "its unit"),
}
# Variables whose long name adds whether they belong to one ball or to both, and these words.
_OF_BALLS = {*BALL_ROWS, "total_energy", *LEDGER}
WHOSE = ("per ball", "both balls")
# Variables whose long name says what the ball hangs on.
_OF_RODS = ("tension", "rod_power")


class Variable(NamedTuple):
    """A variable of a record."""

    name: str
    dimensions: tuple[str, ...]
    values: Any
    attrs: dict[str, str]


@dataclass(frozen=True)
class Record:
    """A run as plain arrays, without xarray: enough for callers that only need the numbers.

    Attributes
    ----------
    system : System
        What moved.
    times : ndarray, shape (time,)
        The instants [s].
    variables : dict
        Dimensions and values of every variable, as `latolato.simulate` describes them.
    attrs : dict
        The attributes of the dataset.
    """

    system: System
    times: Floats
    variables: dict[str, tuple[tuple[str, ...], Any]]
    attrs: dict[str, Any]

    def __getitem__(self, name: str) -> Any:
        """Return the values of a variable."""
        return self.times if name == "time" else self.variables[name][1]

    def __contains__(self, name: object) -> bool:
        """Return whether the record has a variable of this name."""
        return name == "time" or name in self.variables

    def described(self) -> Iterator[Variable]:
        """Yield coordinates and variables with their units and names, as in the dataset."""
        two = self.system.angles == 2
        coordinates: dict[str, tuple[tuple[str, ...], Any]] = {"time": (("time",), self.times)}
        if two:
            coordinates["ball"] = (("ball",), np.array(BALLS))
        for name, (dimensions, values) in {**coordinates, **self.variables}.items():
            attrs = (_LABELS.get(name) or QUANTITIES[name]).attributes
            if name in _OF_RODS and self.system.suspension == "string":
                attrs["long_name"] = attrs["long_name"].replace("of the rod", "of the string")
            if (two or isinstance(self.system, LatoLato)) and name in _OF_BALLS:
                of_both = two and name in LEDGER
                attrs["long_name"] += f", {WHOSE[of_both]}"
            yield Variable(name, dimensions, np.asarray(values), attrs)

    def to_dataset(self) -> xr.Dataset:
        """Return the labelled variables, with units and names."""
        import xarray as xr

        result = {
            each.name: (each.dimensions, _with_any_length(each.values), each.attrs)
            for each in self.described()
        }
        along = ("time", "ball", "parameter", "parameter_unit")
        coordinates = {name: result.pop(name) for name in along if name in result}
        return xr.Dataset(result, coords=coordinates, attrs=self.attrs)


def _with_any_length(values: Any) -> Any:
    """Return words as text of any length, which Zarr specifies, unlike NumPy's of fixed width."""
    is_text = values.dtype.kind == "U"
    return values.astype(np.dtype("O", metadata={"element_type": str})) if is_text else values


def record_of(
    system: System,
    trajectory: Trajectory,
    quantities: dict[str, Floats],
    times: Floats,
    frame: str,
    attrs: dict[str, Any],
) -> Record:
    """Return the variables of a trajectory by name."""
    rows = trajectory.samples
    two = system.angles == 2
    per_ball = ("ball", "time") if two else ("time",)
    per_contact = ("ball", "contact") if two else ("contact",)

    def per_angle(values: Floats) -> Floats:
        return values if two else values[0]

    variables: dict[str, tuple[tuple[str, ...], Any]] = {
        "angle": (per_ball, per_angle(rows[0 : 2 * system.angles : 2])),
        "angular_velocity": (per_ball, per_angle(rows[1 : 2 * system.angles : 2])),
    }
    is_string = system.suspension == "string"
    if is_string:
        variables |= _on_strings(rows, per_ball, two)
    for name in (*PIVOT_ROWS, *ACROSS_ROWS):
        if name in quantities:
            variables[name] = (("time",), quantities[name])
    left_out = set() if frame == "both" else {"lab_energy", "rod_power"}
    if system.is_linear:  # the small-angle model has no such quantities
        left_out |= {"tension", "lab_energy", "rod_power"}
    for name in (*BALL_ROWS[:2], "total_energy", *BALL_ROWS[2:]):
        if name not in left_out:
            variables[name] = (per_ball, per_angle(quantities[name]))
    for name, row in LEDGER.items():
        if name == "retension_loss" and not is_string:
            continue
        if name != "noise_work" or np.nanmax(np.abs(rows[row]), initial=0.0) > 0.0:
            variables[name] = (("time",), rows[row])
    kinds = np.array(CONTACT_KINDS)[trajectory.contact_kinds]
    values = trajectory.contact_values
    variables["contact_time"] = (("contact",), trajectory.contact_times)
    variables["contact_kind"] = (("contact",), kinds)
    count, radial = system.angles, records.C_RADIAL
    around, along = values[: 2 * count], values[radial : radial + 2 * count]
    pairs = {"angular_velocity": around}
    if is_string:
        pairs["radial_velocity"] = along
    for name, both in pairs.items():
        variables[f"{name}_before"] = (per_contact, per_angle(both[:count]))
        variables[f"{name}_after"] = (per_contact, per_angle(both[count:]))
    if is_string and two:
        variables["contact_ball"] = (("contact",), values[records.C_BALL].astype(np.int8))
    return Record(system, times, variables, attrs)


def add_sensitivities(record: Record, plan: RunPlan, trajectories: Sequence[Trajectory]) -> None:
    """Add derivatives with respect to parameters to the record of a run.

    Each of the trajectories is that of the run, differentiated by some of the plan's parameters.
    """
    two, size = plan.system.angles == 2, 2 * plan.system.angles
    angles, velocities, delays = [], [], []
    for trajectory in trajectories:
        count = len(trajectory.contact_values) - records.CONTACT_ROWS
        rows = trajectory.samples[-size * count :].reshape(count, size, -1)
        angles.append(rows[:, 0::2])
        velocities.append(rows[:, 1::2])
        delays.append(trajectory.contact_values[records.CONTACT_ROWS :])
    per_ball = ("parameter", "ball", "time") if two else ("parameter", "time")
    for name, values in (("angle", angles), ("angular_velocity", velocities)):
        joined = np.concatenate(values)
        record.variables[f"{name}_sensitivity"] = per_ball, joined if two else joined[:, 0]
    late = ("parameter", "contact"), np.concatenate(delays)
    record.variables["contact_time_sensitivity"] = late
    names = np.array([parameter.name for parameter in plan.sensitivity_to])
    units = np.array([parameter.quantity.unit for parameter in plan.sensitivity_to])
    record.variables["parameter"] = ("parameter",), names
    record.variables["parameter_unit"] = ("parameter",), units
    first = min(trajectories, key=lambda trajectory: trajectory.doubted_since)
    record.attrs["sensitivity_status"] = "known"
    if first.doubt:
        since, reason = first.doubted_since, DOUBTS[first.doubt]
        record.attrs["sensitivity_status"] = f"unknown from {since:.6g} s on: {reason}"


def _on_strings(
    rows: Floats, dimensions: tuple[str, ...], two: bool
) -> dict[str, tuple[tuple[str, ...], Any]]:
    """Return the variables of balls on strings, from the rows of samples."""
    result: dict[str, tuple[tuple[str, ...], Any]] = {}
    for k, name in enumerate(ON_STRINGS):
        values = rows[records.S_DISTANCE + k : records.S_RETENSION : len(ON_STRINGS)]
        if name == "slack":  # a run that failed knows nothing more: taut
            values = np.nan_to_num(values).astype(np.int8)
        result[name] = (dimensions, values if two else values[0])
    return result


def attributes_of(plan: RunPlan) -> dict[str, Any]:
    """Return the run's parameters, flat for reading and as JSON for running it again."""
    system, drive, start, noise = plan.system, plan.drive, plan.start, plan.noise
    many = system.angles == 2
    scenario: dict[str, Any] = {
        "system": systems.described(system),
        "drive": drives.described(drive),
        "run": {
            "initial_angle": list(start.angles) if many else start.angles[0],
            "initial_angular_velocity": list(start.velocities) if many else start.velocities[0],
            "duration": plan.end,
            "contact": contact_laws.name_of(plan.law),
            **describe(plan.law),
            "tolerance": plan.tolerance,
            "rest_speed": plan.rest_speed,
            "frame": plan.frame,
            "contact_limit": plan.contact_limit,
        },
    }
    if start.distances:
        distances = list(start.distances)
        scenario["run"]["initial_distance"] = distances if many else distances[0]
    if noise is not None:
        scenario["noise"] = describe(noise)
    attributes: dict[str, Any] = {
        "title": f"latolato run of {systems.name_of(system)}",
        "latolato_version": version_of(),
        "numpy_version": np.__version__,
        "numba_version": version_of("numba"),
        "system": systems.name_of(system),
        "drive": drives.name_of(drive),
    }
    for part in ("system", "drive", "run"):
        attributes |= flattened(scenario[part])
    for name in ("natural_frequency", "contact_angle_low", "contact_angle_high"):
        if hasattr(system, name):
            attributes[name] = getattr(system, name)
    if isinstance(system, BallPair):
        attributes["contact_separation"] = system.contact_separation
    if noise is not None:
        attributes.update(
            noise_strength=noise.noise_strength,
            noise_interval=noise.spacing(system),
            noise_seed=noise.noise_seed,
            noise_stream=noise.noise_stream,
        )
    if plan.sensitivity_to:
        scenario["run"]["sensitivity_to"] = [parameter.name for parameter in plan.sensitivity_to]
        if plan.offset is not None:  # such a start moves with its wall
            del scenario["run"]["initial_angle"]
            scenario["run"]["initial_offset"] = plan.offset
    attributes["scenario"] = json.dumps(scenario)
    return attributes
