"""Pieces that come with the package as LLVM bitcode: made for this processor without numba.

`make kernels` compiles the pieces of `latolato.numerics.pieces.every_piece` into ``kernels.zip``,
with a digest of the sources that they were made of. Where these have been edited since, or on a
platform that LLVM does not know, numba compiles instead. Machine code is kept in the cache folder.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import json
import warnings
import zipfile
from pathlib import Path
from typing import Any

from latolato import cache
from latolato.numerics.pieces import Piece
from latolato.numerics.sources import digest_of_sources

ARCHIVE = Path(__file__).with_name("kernels.zip")
# What a module of the archive exports.
ENTRY = "piece"
_TYPES = {"void": None, "int64": ctypes.c_int64, "float64": ctypes.c_double}
# Mathematical functions that the code calls, where the process has them.
_MATHEMATICS = ("expm1", "log1p", "log", "exp", "pow", "sin", "cos", "sqrt")


def load(key: str, kind: str) -> Piece | None:
    """Return a piece of the package, None if numba must compile it.

    Parameters
    ----------
    key, kind : str
        Of its `pieces.Recipe`.
    """
    names = _contents()
    if key not in names:
        return None
    with zipfile.ZipFile(ARCHIVE) as archive:
        bitcode = archive.read(names[key])
    engine, address = _linked(bitcode)
    returned, *taken = kind.replace("(", ",").rstrip(")").split(",")
    types: list[Any] = [_TYPES[name.strip()] for name in (returned, *taken)]
    call: Any = ctypes.CFUNCTYPE(*types)(address)
    call.engine = engine  # the code goes when nobody refers to it
    return Piece(address, call)


@functools.cache
def _contents() -> dict[str, str]:
    """Return the names of the package's pieces in the archive, by key."""
    if not ARCHIVE.exists():
        return {}
    with zipfile.ZipFile(ARCHIVE) as archive:
        about = json.loads(archive.read("about.json"))
    if about["sources"] != digest_of_sources():
        return {}
    names: dict[str, str] = about["pieces"]
    return names


@functools.cache
def _machine() -> tuple[Any, str]:
    """Return what makes code for this processor, and a text that identifies it."""
    import llvmlite
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    for name in _MATHEMATICS:
        function = getattr(ctypes.pythonapi, name, None)
        if function is not None:
            llvm.add_symbol(name, ctypes.cast(function, ctypes.c_void_p).value)
    name, features = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    target = llvm.Target.from_default_triple()
    machine = target.create_target_machine(cpu=name, features=features, opt=3)
    return machine, f"{llvmlite.__version__} {target.triple} {name} {features}"


def _linked(bitcode: bytes) -> tuple[Any, int]:
    """Return an execution engine with a piece in it, and the piece's address."""
    import llvmlite.binding as llvm

    machine, about = _machine()
    digest = hashlib.sha256(about.encode() + bitcode).hexdigest()[:32]
    code = _kept(digest)
    if code is None:
        code = _compiled(bitcode, machine)
        _keep(digest, code)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    return engine, engine.get_function_address(ENTRY)


def _compiled(bitcode: bytes, machine: Any) -> bytes:
    """Return machine code for this processor."""
    import llvmlite.binding as llvm

    module = llvm.parse_bitcode(bitcode)
    tuning = llvm.create_pipeline_tuning_options(3)
    tuning.loop_vectorization = tuning.slp_vectorization = True
    builder = llvm.create_pass_builder(machine, tuning)
    builder.getModulePassManager().run(module, builder)
    code: bytes = machine.emit_object(module)
    return code


def _path(digest: str) -> Path:
    return cache.cache_directory() / "shipped" / f"{digest}.o"


def _kept(digest: str) -> bytes | None:
    """Return machine code from the cache folder, None if it has none that can be trusted."""
    try:
        return cache.read(_path(digest))
    except (OSError, ValueError):
        return None


def _keep(digest: str, code: bytes) -> None:
    """Keep machine code in the cache folder, or warn why every process has to make it."""
    try:
        cache.write(_path(digest), code)
    except OSError as error:
        warnings.warn(
            f"machine code cannot be kept ({error.strerror or error}), so every process makes it "
            "again; set LATOLATO_CACHE_DIR to a folder that only you can write to",
            RuntimeWarning,
            stacklevel=2,
        )
