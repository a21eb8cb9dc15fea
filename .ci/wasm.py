"""The package's kernels as WebAssembly modules, for pages: a part of `make kernels`.

The code that numba wrote for this processor is given another target, optimised and linked. What
calls the modules is ``src/latolato/app/static/js/kernels``; it knows where everything lies from
``layout.json``, which is made here from the layouts that Python and compiled code share.
"""

from __future__ import annotations

import importlib.util
import inspect
import json
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import fields
from itertools import product
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import numpy as np

from latolato.numerics import (
    batch,
    callbacks,
    derived,
    host_entry,
    kernels,
    lane_rows,
    prepare,
    records,
    run_record,
)
from latolato.numerics.abi import Formula, KernelSpec
from latolato.numerics.engine import loop, samples
from latolato.numerics.integrate import LARGEST, STEPS_PER_CALL
from latolato.numerics.steppers import BLANES_MOAN_GENERAL, BLANES_MOAN_RKN, Stepper
from latolato.observables.base import observables
from latolato.physics.contacts import CONTACT_KINDS
from latolato.physics.problems import PROBLEMS
from latolato.simulation.record import LEDGER, ON_STRINGS
from latolato.sweeps.plan import make_plan
from latolato.sweeps.points import LAST_PERIOD

LAYOUT = "layout.json"
_LINKER = "ziglang"

# Every browser has had these since 2021; nearly every one has had `simd128`, of which lanes are
# made, since 2023. Others load the modules of the second kind.
_FEATURES = ("bulk-memory", "bulk-memory-opt", "nontrapping-fptoint", "sign-ext")
VARIANTS = {"": ("simd128", *_FEATURES), "-scalar": _FEATURES}
# Functions of C that modules take from a page's `Math`, which has them under the same names. Both
# err by about a unit in the last place. The sine of the equation of motion is not one of them: see
# `latolato.core.scalar`.
_MATH = (
    "acos", "asin", "atan", "atan2", "cos", "exp", "expm1", "hypot", "log", "log1p", "pow", "sin",
    "tan",
)  # fmt: skip
# It lies before all data, so that a run which needed more would end in an error.
_STACK = 256 * 1024
# What pages call; all other kernels are called by these.
_CALLED = (
    "engine", "clamp", "observer", "batch", "lanes", "shake", "begin", "allowed", "prepare",
)  # fmt: skip
_TYPES = {"void": "void", "int64": "i64", "float64": "double"}
_NARROW = {"i64": "i32"}
# Laws of an engine without those for the plane, and what makes its motion.
_UPRIGHT = 4
# What shows an observable the steps, or the matrices, of all lanes.
_FOR_LANES = {
    callbacks.ON_STEP: "step_report",
    callbacks.ON_TANGENT: "jacobian_report",
}

# Records, and tuples whose words compiled code is given, by the names that pages know them by.
_USUAL = records.segment_dtype()
_RECORDS = {
    "run": run_record.run_dtype(),
    "state": run_record.STATE,
    "settings": records.SETTINGS,
    "body": records.BODY,
    "point": run_record.POINT,
    "segment": _USUAL,
    "ball": records.BALL,
    "case": records.CASE,
    "problem": records.PROBLEM,
}
_BUNDLES = {
    "arguments": loop.empty_arguments(_USUAL),
    "observation": derived.empty_observation(_USUAL),
    "job": batch.empty_job(_USUAL),
    "task": batch.empty_task(_USUAL),
    "shaking": host_entry.empty_shaking(),
    "beginning": host_entry.empty_beginning(),
    "cases": prepare.empty_cases(),
}


def check_linker() -> None:
    """Exit if the linker is missing."""
    if importlib.util.find_spec(_LINKER) is None:
        sys.exit(f"WebAssembly needs a linker, wasm-ld: pip install {_LINKER}")


def is_fresh(folder: Path, made_of: dict[str, Any]) -> bool:
    """Return whether a folder has all modules, made of just that."""
    layout = json.loads((folder / LAYOUT).read_text())
    files = product(layout["modules"], VARIANTS)
    is_whole = all((folder / f"{module}{variant}.wasm").exists() for module, variant in files)
    return is_whole and all(layout[key] == value for key, value in made_of.items())


def types_of(signature: str) -> tuple[str, list[str]]:
    """Return LLVM's names of what a kernel of this signature returns and takes."""
    returned, *taken = (_TYPES[name] for name in re.findall(r"\w+", signature))
    return returned, taken


# Of one ball and of two, the same in the plane, and maps of one ball.
_MODULES = ("one", "two", "plane_one", "plane_two", "lanes")
_RUNS = _MODULES[:4]
# Those that run points of maps; `one` leaves them to `lanes`.
_MAPS = _MODULES[1:]


def modules_of(specs: Sequence[KernelSpec]) -> dict[str, dict[str, KernelSpec]]:
    """Return the kernels of each module by the names that pages know them by."""
    found: dict[str, dict[str, KernelSpec]] = {name: {} for name in _MODULES}
    for spec in specs:
        name, modules = place_of(spec)
        for module in modules:
            if name in found[module]:
                raise ValueError(f"two kernels of {module} have the name {name}")
            found[module][name] = spec
    return found


def place_of(spec: KernelSpec) -> tuple[str, tuple[str, ...]]:
    """Return what a kernel is called on pages, and the modules that have it."""
    settings, laws = dict(spec.settings), [law.__name__ for law in spec.laws]
    if spec.make is kernels.engine:
        if laws[0] == "make_clamped":
            return "clamp", ("one", "lanes")
        if laws[0] == "make_sensitive":  # pages differentiate nothing
            return "sensitive", ()
        if len(laws) > _UPRIGHT:
            return "engine", ("plane_one",) if settings["count"] == 1 else ("plane_two",)
        return "engine", ("one", "lanes") if settings["count"] == 1 else ("two",)
    if spec.make is kernels.batch:
        return "batch", ("lanes", "plane_one") if settings["balls"] == 1 else ("two", "plane_two")
    if spec.make is kernels.plane_observer:
        return "observer", ("plane_one", "plane_two")
    if spec.make in (kernels.lane_step, kernels.lane_locate):
        # A step that follows drag and works also does what those without them do, to the same
        # digits. Maps without drag take 16 to 23 % longer for it, with drag 3 %; the steps for
        # all these cases would add 140 kB.
        kept = ("lanes",) if settings["damped"] and settings["works"] else ()
        flags = [flag for flag in ("walled", "tangents") if settings.get(flag)]
        return "_".join([spec.name, *laws, *flags]), kept
    if spec.make is kernels.shared_values:  # the one that finds everything serves all maps
        found = [name for name in kernels.SHARED if settings[name]]
        return "_".join([spec.name, *found]), ("lanes",) if found == [*kernels.SHARED] else ()
    if spec.make in (kernels.step_report, kernels.jacobian_report):
        return callback_name(spec.laws[0], spec.name), ("lanes",)
    if spec.make is kernels.callback:
        occasion = callbacks.OCCASIONS[settings["occasion"]]
        return callback_name(spec.laws[0], occasion), _MAPS
    return spec.name, _MODULES_OF[spec.make]


# Of kernels that there are once.
_MODULES_OF = {
    kernels.observer: ("one", "two"),
    kernels.shake: (*_RUNS, "lanes"),
    kernels.begin: _RUNS,
    kernels.allowed: _RUNS,
    kernels.prepare: _MAPS,
    kernels.lanes: ("lanes",),
}


def callback_name(formula: Formula, how: str) -> str:
    """Return the name of the kernel that calls a formula of an observable.

    `how` is an occasion, or ``step_report`` or ``jacobian_report`` for all lanes together.
    """
    return f"{formula.__module__.rpartition('.')[2]}.{formula.__name__.strip('_')}.{how}"


# Kernels that are called once a run, or that take fixed steps: small rather than fast.
_SMALL = ("allowed", "begin", "clamp", "prepare")


def object_of(text: str, name: str, features: Sequence[str]) -> bytes:
    """Return a kernel as an object file.

    Parameters
    ----------
    text : str
        Its code before anything was optimised.
    name : str
        The function in it that has the types of a kernel.
    features : sequence of str
        What browsers must know beyond the first WebAssembly.
    """
    module = llvm.parse_assembly(_with_instructions(text))
    for each in (*module.functions, *module.global_variables):
        if not each.is_declaration and each.name != name:
            each.linkage = "internal"
    if name in _SMALL:
        for function in module.functions:
            function.add_function_attribute("optsize")
    # Engines gain 8 % by the third level; lanes gain nothing and are 2 % smaller without.
    return _optimised(
        module, features, speed=3 if name == "engine" else 2, loops=name not in _SMALL
    )


def _with_instructions(text: str) -> str:
    """Return code that calls LLVM's square root for C's.

    The one is an instruction; LLVM 20 leaves the other to a library that pages do not have.
    """
    intrinsic = "declare double @llvm.sqrt.f64(double)"
    text = re.sub(r"^declare double @sqrt\(.*", "", text, flags=re.MULTILINE)
    text = text.replace("@sqrt(", "@llvm.sqrt.f64(")
    return text if intrinsic in text else f"{text}\n{intrinsic}\n"


def _optimised(
    module: Any, features: Sequence[str], speed: int = 2, *, loops: bool = True
) -> bytes:
    """Return code as an object file.

    `speed` is LLVM's level of optimisation, `loops` says whether loops become vectors: small code
    does without, and LLVM 20 checks there, with an assertion, where ``optsize`` stands.
    """
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    target = llvm.Target.from_triple("wasm32-unknown-unknown").create_target_machine(
        cpu="mvp", features=",".join(f"+{feature}" for feature in features), opt=speed
    )
    module.triple, module.data_layout = target.triple, str(target.target_data)
    tuning = llvm.create_pipeline_tuning_options(speed)
    tuning.loop_vectorization, tuning.slp_vectorization = loops, True
    builder = llvm.create_pass_builder(target, tuning)
    builder.getModulePassManager().run(module, builder)
    code: bytes = target.emit_object(module)
    return code


def linked(
    chosen: dict[str, KernelSpec], objects: dict[str, bytes], features: Sequence[str]
) -> bytes:
    """Return a module of kernels, whose object files are given by their keys.

    The linker refuses objects that use other features.
    """
    with tempfile.TemporaryDirectory() as name:
        folder, files = Path(name), []
        codes = [objects[spec.key] for spec in chosen.values()]
        for number, code in enumerate([_exports(chosen, features), *codes]):
            files.append(folder / f"{number}.o")
            files[-1].write_bytes(code)
        imported, made = folder / "imported.txt", folder / "module.wasm"
        imported.write_text("\n".join(_MATH))
        command = [
            *("--no-entry", "--gc-sections", "--strip-all", "-O2"),
            f"--features={','.join(features)}",
            *("--export=kernels", "--export=__heap_base", f"--allow-undefined-file={imported}"),
            *("--stack-first", "-z", f"stack-size={_STACK}", "-o", str(made), *map(str, files)),
        ]
        subprocess.run([sys.executable, "-m", _LINKER, "wasm-ld", *command], check=True)
        return made.read_bytes()


def _exports(chosen: dict[str, KernelSpec], features: Sequence[str]) -> bytes:
    """Return the object file that exports a list of all kernels, and those that pages call.

    In WebAssembly the address of a function is its place in the module's table of functions.
    """
    listed = ", ".join(f'ptr @"{name}"' for name in chosen)
    lines = [f"@kernels = constant [{len(chosen)} x ptr] [{listed}]"]
    for name, spec in chosen.items():
        returned, taken = types_of(spec.signature)
        lines.append(f'declare {returned} @"{name}"({", ".join(taken)})')
        if name in _CALLED:
            lines += _for_pages(name, returned, taken)
    return _optimised(llvm.parse_assembly("\n".join(lines)), features)


def _for_pages(name: str, returned: str, taken: Sequence[str]) -> Iterator[str]:
    """Yield the code of a function that calls a kernel with integers of 32 bits.

    JavaScript has these as plain numbers, as it has floats.
    """
    given = ", ".join(f"{_NARROW.get(type_, type_)} %a{i}" for i, type_ in enumerate(taken))
    yield f'define {_NARROW.get(returned, returned)} @"call_{name}"({given})'
    yield f'  "wasm-export-name"="{name}" {{'
    passed = []
    for i, type_ in enumerate(taken):
        if type_ in _NARROW:
            yield f"  %w{i} = zext {_NARROW[type_]} %a{i} to {type_}"
        passed.append(f"{type_} %{'w' if type_ in _NARROW else 'a'}{i}")
    call = f'call {returned} @"{name}"({", ".join(passed)})'
    if returned == "void":
        yield f"  {call}\n  ret void\n}}"
    elif returned not in _NARROW:
        yield f"  %found = {call}\n  ret {returned} %found\n}}"
    else:
        yield f"  %found = {call}\n  %narrow = trunc {returned} %found to {_NARROW[returned]}"
        yield f"  ret {_NARROW[returned]} %narrow\n}}"


def layout_of(modules: dict[str, dict[str, KernelSpec]]) -> dict[str, Any]:
    """Return what pages must know about the modules and of the memory that these work on.

    Types are ``f8``, ``i8`` or the name of a record. Of lists the place of a name is its number.
    """
    return {
        "records": {name: _record_layout(dtype) for name, dtype in _RECORDS.items()},
        "bundles": {name: list(_fields(value)) for name, value in _BUNDLES.items()},
        "modules": {name: list(chosen) for name, chosen in modules.items()},
        "observables": {name: _observable(kind) for name, kind in observables.items()},
        "shared_needs": kernels.SHARED,
        "occasions": callbacks.OCCASIONS,
        "sample_rows": {**LEDGER, "mode": records.S_MODE},  # behind two for each of two balls
        "rows": {
            "upright": _rows(records.SAMPLE_ROWS, loop.SPARE_ROWS, derived.PIVOT_ROWS),
            "plane": _rows(
                records.PLANE_ROWS,
                loop.SPARE_IN_PLANE,
                (*derived.PIVOT_ROWS, *derived.ACROSS_ROWS),
            ),
        },
        "string_rows": {name: records.S_DISTANCE + k for k, name in enumerate(ON_STRINGS)},
        "ball_rows": derived.BALL_ROWS,
        "contact_rows": {
            "count": records.CONTACT_ROWS,
            "radial": records.C_RADIAL,
            "ball": records.C_BALL,
        },
        "contact_kinds": CONTACT_KINDS,
        "statuses": records.STATUS_NAMES,
        "problems": [problem._asdict() for problem in PROBLEMS],
        "drives": [
            {
                "name": name,
                "rotates": kind.rotation is not None,
                "amplitude_limit": getattr(kind, "amplitude_limit", None),
            }
            for name, kind in host_entry.WRITTEN.items()
        ],
        "steppers": {
            "smooth": _stepper(BLANES_MOAN_RKN),
            "nonsmooth": _stepper(BLANES_MOAN_GENERAL),
        },
        "lanes": {
            name.lower(): getattr(lane_rows, name)
            for name in ("LANES", "ROWS", "TABLE_ROWS", "IMPACTS", "IMPACT_ROWS")
        },
        "scratch_contacts": len(batch.make_scratch().contact_times),
        "largest": LARGEST,
        "contact_limit": inspect.signature(make_plan).parameters["contact_limit"].default,
        "last_period": LAST_PERIOD,
        "steps_per_call": STEPS_PER_CALL,
        "most_halvings": samples.MOST_HALVINGS,
        "most_steps_to_repeat": samples.MOST_STEPS_TO_REPEAT,
    }


def _rows(samples: int, spare: int, pivot: Sequence[str]) -> dict[str, Any]:
    """Return how many rows samples have and contacts to spare, and what those of the pivot are."""
    return {"samples": samples, "spare": spare, "pivot": pivot}


def _stepper(stepper: Stepper) -> dict[str, Any]:
    """Return a stepper's weights."""
    found = {name: getattr(stepper, name).tolist() for name in ("kicks", "drifts", "nodes")}
    return {"order": stepper.order, "step_factor": stepper.step_factor, **found}


def _record_layout(dtype: np.dtype[Any]) -> dict[str, Any]:
    """Return the size of a record in bytes, and where its fields begin."""
    fields = {}
    for name in dtype.names:
        inner, at = dtype.fields[name][:2]
        if 0 not in inner.shape:  # arrays for which a run has no room on pages
            fields[name] = {"at": at, "type": _type_of(inner.base), "shape": inner.shape}
    return {"size": dtype.itemsize, "fields": fields}


def _type_of(dtype: np.dtype[Any]) -> str:
    """Return the name of the type of an array's items."""
    found = next((name for name, known in _RECORDS.items() if known == dtype), dtype.str[1:])
    if found not in (*_RECORDS, "f8", "i8"):
        raise TypeError(f"pages do not read {dtype}")
    return found


def _fields(value: Any, name: str = "") -> Iterator[dict[str, Any]]:
    """Yield what the words of a value say, in their order; see `abi.words_of`."""
    if isinstance(value, tuple):
        for field, part in zip(value._fields, value, strict=True):
            yield from _fields(part, f"{name}.{field}" if name else field)
    elif isinstance(value, np.ndarray):
        yield {"name": name, "type": _type_of(value.dtype), "dimensions": value.ndim}
    else:
        yield {"name": name, "type": "f8" if isinstance(value, float) else "i8"}


def _observable(kind: Any) -> dict[str, Any]:
    """Return what pages must know about an observable whose parameters are the usual ones."""
    usual = kind()
    return {
        "parameters": dict(zip([f.name for f in fields(kind)], usual.parameters, strict=True)),
        "dimension": kind.dimension,
        "angles": kind.angles,
        "widths": usual.widths,
        "marks": usual.marks,
        "slots": usual.slots,
        "needs": sorted(kind.needs),
        "plain": sorted(kind.plain),
        "joint": kind.is_joint,
        "mirrored": kind.mirrored,
        "of_strings": kind.of_strings,
        "callbacks": _callbacks_of(kind),
    }


def _callbacks_of(observable: type) -> dict[str, str]:
    """Return the kernels that show an observable something."""
    found = {}
    for occasion, name in enumerate(callbacks.OCCASIONS):
        formula = getattr(observable, name)
        if formula is not None:
            found[name] = callback_name(formula, name)
            if occasion in _FOR_LANES:
                found[_FOR_LANES[occasion]] = callback_name(formula, _FOR_LANES[occasion])
    return found


def write(
    folder: Path,
    about: dict[str, Any],
    modules: dict[str, dict[str, KernelSpec]],
    objects: dict[str, dict[str, bytes]],
) -> dict[str, int]:
    """Write the modules and then their layout; return the size of each variant in bytes.

    Parameters
    ----------
    about : dict
        What they were made of; it becomes a part of the layout.
    objects : dict
        The kernels as object files, by variants and by their keys.
    """
    folder.mkdir(exist_ok=True)
    (folder / LAYOUT).unlink(missing_ok=True)
    sizes = dict.fromkeys(VARIANTS, 0)
    for (module, chosen), (variant, features) in product(modules.items(), VARIANTS.items()):
        code = linked(chosen, objects[variant], features)
        (folder / f"{module}{variant}.wasm").write_bytes(code)
        sizes[variant] += len(code)
    (folder / LAYOUT).write_text(json.dumps({**about, **layout_of(modules)}))
    return sizes
