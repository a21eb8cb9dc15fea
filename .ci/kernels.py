"""Compiles the package's kernels: LLVM bitcode, ``kernels.zip``, and WebAssembly: `make kernels`.

``python .ci/kernels.py [FILE [FOLDER]]``; the file that the package reads and the folder that pages
read are the defaults. Nothing is done if both were made of these very sources, by no newer LLVM.
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

import wasm

from latolato.app import STATIC
from latolato.numerics import kernels, shipped
from latolato.numerics.abi import KernelSpec, digest_of_sources
from latolato.observables import Observable

# Functions of C that LLVM writes as instructions of its own.
_INTRINSICS = {
    "acos", "asin", "atan", "ceil", "cos", "exp", "fabs", "floor", "fma", "fmod", "log", "memcpy",
    "memmove", "memset", "pow", "sin", "sqrt", "tan",
}  # fmt: skip


class _LinkedError(BaseException):
    """All code is there; numba need not go on."""


def _observables(kind: type = Observable) -> Iterator[type]:
    """Yield every observable of the package."""
    for found in kind.__subclasses__():
        yield found
        yield from _observables(found)


def _specs() -> list[KernelSpec]:
    """Return what is compiled, the largest first."""
    every = kernels.every_spec(dict.fromkeys(_observables()))
    return list({spec.key: spec for spec in every}.values())


def _entry(text: str, signature: str, name: str) -> str:
    """Return the code of a function that has the types of a kernel and calls numba's function."""
    returned, taken = wasm.types_of(signature)
    given = [f"{type_} %a{i}" for i, type_ in enumerate(taken)]
    # numba's function comes first; it writes its result and returns a status.
    numbas = re.search(r"^define .*?@([\w.]+)\(", text, re.MULTILINE)[1]
    called = ", ".join(["ptr %result", "ptr %status", *given])
    if returned == "void":
        end, result = "  ret void", "ptr"
    else:
        end, result = f"  %value = load {returned}, ptr %result\n  ret {returned} %value", returned
    return (
        f'\ndefine {returned} @"{name}"({", ".join(given)}) {{\n'
        f"  %result = alloca {result}\n  %status = alloca ptr\n"
        f"  call i32 @{numbas}({called})\n{end}\n}}\n"
    )


def _bitcode(text: str, signature: str, name: str) -> tuple[bytes, list[str]]:
    """Return a kernel's bitcode, for any processor, and the functions of C that it calls."""
    module = llvm.parse_assembly(text + _entry(text, signature, name))
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
    """Return the name of a kernel."""
    return f"kernel_{number:03}"


def _compiled(number: int) -> tuple[bytes, list[str], dict[str, bytes]]:
    """Return one of them, compiled: what `_bitcode` returns, and object files for pages.

    There are none of these if no module for pages has the kernel.
    """
    from latolato.numerics.jit import compile_spec  # imports numba

    spec, linked = _specs()[number], []
    name, modules = wasm.place_of(spec)

    def note(text: str) -> None:
        linked.append(text)
        raise _LinkedError

    try:
        compile_spec(spec, note)
    except _LinkedError:
        (text,) = linked
    bitcode, called = _bitcode(text, spec.signature, _name(number))
    variants = wasm.VARIANTS if modules else {}
    code = text + _entry(text, spec.signature, name)
    return bitcode, called, {
        variant: wasm.object_of(code, name, features) for variant, features in variants.items()
    }  # fmt: skip


def _is_fresh(path: Path, folder: Path) -> bool:
    """Return whether all was made of these sources by this program, for an LLVM like ours."""
    try:
        with zipfile.ZipFile(path) as archive:
            damaged, about = archive.testzip(), json.loads(archive.read("about.json"))
        is_readable = about["llvm"] <= list(llvm.llvm_version_info)
        is_same = all(about[key] == value for key, value in _made_of().items())
        return is_readable and damaged is None and is_same and wasm.is_fresh(folder, _made_of())
    except Exception:  # no such file, or one of anything else
        return False


def _made_of() -> dict[str, str]:
    """Return digests of the sources and of this program."""
    digest = hashlib.sha256()
    for file in (__file__, wasm.__file__):
        digest.update(Path(file).read_bytes())
    return {"sources": digest_of_sources(), "builder": digest.hexdigest()}


def main() -> None:
    """Compile all, write the archive and the modules."""
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else shipped.ARCHIVE
    folder = Path(sys.argv[2]) if len(sys.argv) > 2 else STATIC / "kernels"
    if _is_fresh(path, folder):
        return
    wasm.check_linker()
    begin, specs = time.monotonic(), _specs()
    print(f"compiling {len(specs)} kernels: a minute or two", flush=True)
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    with tempfile.TemporaryDirectory() as empty:
        # What numba compiled before has been optimised for a processor.
        os.environ["LATOLATO_CACHE_DIR"] = empty
        with ProcessPoolExecutor(min(os.cpu_count() or 1, 8)) as processes:
            made = list(processes.map(_compiled, range(len(specs))))
    about = {
        **_made_of(),
        "llvm": llvm.llvm_version_info,
        "calls": sorted({name for _, called, _ in made for name in called}),
        "kernels": {spec.key: _name(i) for i, spec in enumerate(specs)},
    }
    handle, new = tempfile.mkstemp(suffix=".zip", dir=path.parent)
    os.close(handle)
    contents = [("about.json", json.dumps(about, indent=1).encode())]
    contents += [(_name(i), code) for i, (code, _, _) in enumerate(made)]
    with zipfile.ZipFile(new, "w") as archive:
        for name, content in contents:  # without the time of day: equal sources, equal files
            archive.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED, 9)
    os.chmod(new, 0o644)
    os.replace(new, path)
    objects: dict[str, dict[str, bytes]] = {variant: {} for variant in wasm.VARIANTS}
    for spec, (_, _, codes) in zip(specs, made, strict=True):
        for variant, code in codes.items():
            objects[variant][spec.key] = code
    for_pages = wasm.write(folder, _made_of(), wasm.modules_of(specs), objects)
    size, seconds = path.stat().st_size, time.monotonic() - begin
    print(
        f"{path}: {len(specs)} kernels, {size / 1e6:.2f} MB, for pages "
        f"{' or '.join(f'{each / 1e3:.0f}' for each in for_pages.values())} kB, in {seconds:.0f} s"
    )


if __name__ == "__main__":
    main()
