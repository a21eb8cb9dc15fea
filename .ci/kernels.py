"""Compiles the package's pieces into LLVM bitcode, ``kernels.zip``: `make kernels`."""

from __future__ import annotations

import json
import os
import re
import sys
import tempfile
import zipfile
from collections.abc import Iterator

import llvmlite.binding as llvm

# Nothing is read from a cache: what numba compiled before has been optimised for a processor.
os.environ["LATOLATO_CACHE_DIR"] = tempfile.mkdtemp()

import latolato.analysis
from latolato.numerics import linking, pieces, shipped
from latolato.numerics.sources import digest_of_sources
from latolato.observables import Observable

_LLVM_TYPES = {"void": "void", "int64": "i64", "float64": "double"}


def observables(kind: type = Observable) -> Iterator[type]:
    """Yield every observable of the package."""
    for found in kind.__subclasses__():
        if found.__module__.startswith(latolato.__name__):
            yield found
        yield from observables(found)


def entry_of(text: str, kind: str) -> str:
    """Return the code of a function that has the types of a piece and calls numba's function."""
    returned, taken = kind.rstrip(")").split("(")
    types = [_LLVM_TYPES[name.strip()] for name in taken.split(",")]
    given = [f"{name} %a{i}" for i, name in enumerate(types)]
    # numba's function comes first; it writes its result and returns a status.
    numbas = re.search(r"^define .*?@([\w.]+)\(", text, re.MULTILINE)[1]
    called = ", ".join(["ptr %result", "ptr %status", *given])
    if returned == "void":
        end, result = "  ret void", "ptr"
    else:
        result = _LLVM_TYPES[returned]
        end = f"  %value = load {result}, ptr %result\n  ret {result} %value"
    return (
        f"\ndefine {_LLVM_TYPES[returned]} @{shipped.ENTRY}({', '.join(given)}) {{\n"
        f"  %result = alloca {result}\n  %status = alloca ptr\n"
        f"  call i32 @{numbas}({called})\n{end}\n}}\n"
    )


def bitcode_of(text: str, kind: str) -> bytes:
    """Return a piece's bitcode: its own entry and what this needs, without vectors."""
    module = llvm.parse_assembly(text + entry_of(text, kind))
    for each in (*module.functions, *module.global_variables):
        if not each.is_declaration and each.name != shipped.ENTRY:
            each.linkage = "internal"
    machine = llvm.Target.from_default_triple().create_target_machine(opt=2)
    tuning = llvm.create_pipeline_tuning_options(1)
    tuning.loop_vectorization = tuning.slp_vectorization = False
    builder = llvm.create_pass_builder(machine, tuning)
    builder.getModulePassManager().run(module, builder)
    return module.as_bitcode()


def main() -> None:
    """Compile all, write the archive."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    shipped.load = lambda key, kind: None
    linked = []
    plain = linking._Kernel._optimize_final_module

    def note(library: object) -> None:
        linked.append(str(library._final_module))
        plain(library)

    linking._Kernel._optimize_final_module = note
    compile_piece, names = None, {}
    from latolato.numerics import compiled

    compile_piece = compiled.compile_piece
    recipes = []

    def compile_noted(recipe: pieces.Recipe) -> pieces.Piece:
        recipes.append(recipe)
        return compile_piece(recipe)

    compiled.compile_piece = compile_noted
    with zipfile.ZipFile(shipped.ARCHIVE, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for make in pieces.every_piece(dict.fromkeys(observables())):
            linked.clear(), recipes.clear()
            make()
            for text, recipe in zip(linked, recipes, strict=True):
                name = f"{len(names):03}.bc"
                names[recipe.key] = name
                code = bitcode_of(text, recipe.kind)
                print(len(code), recipe.key, flush=True)
                archive.writestr(name, code)
        about = {"sources": digest_of_sources(), "pieces": names}
        archive.writestr("about.json", json.dumps(about, indent=1))
    print(f"{len(names)} pieces, {shipped.ARCHIVE.stat().st_size} bytes", file=sys.stderr)


if __name__ == "__main__":
    main()
