"""Compiles the package's pieces into LLVM bitcode, ``kernels.zip``: `make kernels`.

``python .ci/kernels.py [FILE]``; the file that the package reads is the default. Nothing is done
if it was made of these very sources, by no newer LLVM.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import sys
import tempfile
import time
import zipfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import llvmlite.binding as llvm

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "src"))

from latolato.numerics import pieces, shipped
from latolato.numerics.sources import digest_of_sources
from latolato.observables import Observable

# Functions of C that LLVM writes as instructions of its own.
_INTRINSICS = {
    "acos", "asin", "atan", "ceil", "cos", "exp", "fabs", "floor", "fma", "fmod", "log", "memcpy",
    "memmove", "memset", "pow", "sin", "sqrt", "tan",
}  # fmt: skip
_LLVM_TYPES = {"void": "void", "int64": "i64", "float64": "double"}


class _LinkedError(BaseException):
    """All code is there; numba need not go on."""


def _observables(kind: type = Observable) -> Iterator[type]:
    """Yield every observable of the package."""
    for found in kind.__subclasses__():
        yield found
        yield from _observables(found)


def _recipes() -> list[pieces.Recipe]:
    """Return what is compiled, the largest pieces first."""
    every = pieces.every_recipe(dict.fromkeys(_observables()))
    return list({recipe.key: recipe for recipe in every}.values())


def _entry(text: str, kind: str, name: str) -> str:
    """Return the code of a function that has the types of a piece and calls numba's function."""
    returned, taken = kind.rstrip(")").split("(")
    types = [_LLVM_TYPES[name.strip()] for name in taken.split(",")]
    given = [f"{type_} %a{i}" for i, type_ in enumerate(types)]
    # numba's function comes first; it writes its result and returns a status.
    numbas = re.search(r"^define .*?@([\w.]+)\(", text, re.MULTILINE)[1]
    called = ", ".join(["ptr %result", "ptr %status", *given])
    if returned == "void":
        end, result = "  ret void", "ptr"
    else:
        result = _LLVM_TYPES[returned]
        end = f"  %value = load {result}, ptr %result\n  ret {result} %value"
    return (
        f"\ndefine {_LLVM_TYPES[returned]} @{name}({', '.join(given)}) {{\n"
        f"  %result = alloca {result}\n  %status = alloca ptr\n"
        f"  call i32 @{numbas}({called})\n{end}\n}}\n"
    )


def _bitcode(text: str, kind: str, name: str) -> tuple[bytes, list[str]]:
    """Return a piece's bitcode, for any processor, and the functions of C that it calls."""
    module = llvm.parse_assembly(text + _entry(text, kind, name))
    for each in (*module.functions, *module.global_variables):
        if not each.is_declaration and each.name != name:
            each.linkage = "internal"
    machine = llvm.Target.from_default_triple().create_target_machine(opt=2)
    tuning = llvm.create_pipeline_tuning_options(1)
    # How wide vectors are is left to the processor that will run this.
    tuning.loop_vectorization = tuning.slp_vectorization = False
    builder = llvm.create_pass_builder(machine, tuning)
    builder.getModulePassManager().run(module, builder)
    called = [f.name for f in module.functions if f.is_declaration]
    return module.as_bitcode(), [name for name in map(_function_of, called) if name]


def _function_of(name: str) -> str | None:
    """Return the function of C behind a declaration, None where LLVM needs none.

    A processor may have an instruction for some of them.
    """
    if not name.startswith("llvm."):
        return name
    inner = name.split(".")[1]
    return inner if inner in _INTRINSICS else None


def _name(number: int) -> str:
    """Return the name of a piece."""
    return f"piece_{number:03}"


def _piece(number: int) -> tuple[bytes, list[str]]:
    """Return one of the recipes, compiled."""
    from latolato.numerics.compiled import compile_piece  # imports numba

    recipe, linked = _recipes()[number], []

    def note(text: str) -> None:
        linked.append(text)
        raise _LinkedError

    try:
        compile_piece(recipe, note)
    except _LinkedError:
        return _bitcode(linked[0], recipe.kind, _name(number))
    raise AssertionError(recipe.key)


def _is_fresh(path: Path) -> bool:
    """Return whether the file was made of these sources by this program, for an LLVM like ours."""
    try:
        with zipfile.ZipFile(path) as archive:
            damaged, about = archive.testzip(), json.loads(archive.read("about.json"))
        is_readable = about["llvm"] <= list(llvm.llvm_version_info)
        sources = about["builder"], about["sources"]
    except Exception:  # no such file, or one of anything else
        return False
    return is_readable and damaged is None and sources == (_builder(), digest_of_sources())


def _builder() -> str:
    """Return a digest of this program."""
    return hashlib.sha256(Path(__file__).read_bytes()).hexdigest()


def main() -> None:
    """Compile all, write the archive."""
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else shipped.ARCHIVE
    if _is_fresh(path):
        return
    begin, recipes = time.monotonic(), _recipes()
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    with tempfile.TemporaryDirectory() as empty:
        # What numba compiled before has been optimised for a processor.
        os.environ["LATOLATO_CACHE_DIR"] = empty
        with ProcessPoolExecutor(min(os.cpu_count() or 1, 8)) as processes:
            made = list(processes.map(_piece, range(len(recipes))))
    about = {
        "sources": digest_of_sources(),
        "builder": _builder(),
        "llvm": llvm.llvm_version_info,
        "calls": sorted({name for _, called in made for name in called}),
        "pieces": {recipe.key: _name(i) for i, recipe in enumerate(recipes)},
    }
    handle, new = tempfile.mkstemp(suffix=".zip", dir=path.parent)
    os.close(handle)
    contents = [("about.json", json.dumps(about, indent=1).encode())]
    contents += [(_name(i), code) for i, (code, _) in enumerate(made)]
    with zipfile.ZipFile(new, "w") as archive:
        for name, content in contents:  # without the time of day: equal sources, equal files
            archive.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED, 9)
    os.chmod(new, 0o644)
    os.replace(new, path)
    size, seconds = path.stat().st_size, time.monotonic() - begin
    print(f"{path}: {len(recipes)} pieces, {size / 1e6:.2f} MB, in {seconds:.0f} s")


if __name__ == "__main__":
    main()
