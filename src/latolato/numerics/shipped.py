"""Pieces that come with the package as LLVM bitcode: made for this processor without numba.

`make kernels` compiles the pieces of `latolato.numerics.pieces.every_recipe` into ``kernels.zip``,
with a digest of the sources that they were made of. Where these have been edited since, or where
the bitcode cannot be used, numba compiles instead. Machine code is kept in the cache folder.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import json
import warnings
import zipfile
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite
import llvmlite.binding as llvm

from latolato import cache
from latolato.numerics.pieces import Piece
from latolato.numerics.sources import digest_of_sources

ARCHIVE = Path(__file__).with_name("kernels.zip")
_TYPES = {"void": None, "int64": ctypes.c_int64, "float64": ctypes.c_double}


class Machine(NamedTuple):
    """A processor: LLVM's target, an engine that holds its code, and a text that identifies it."""

    target: Any
    engine: Any
    name: str


def load(key: str, kind: str) -> Piece | None:
    """Return a piece of the package, None if numba must compile it.

    Parameters
    ----------
    key, kind : str
        Of its `pieces.Recipe`.
    """
    names = _names()
    if key not in names:
        return None
    try:
        with zipfile.ZipFile(ARCHIVE) as archive:
            address = _address(names[key], archive.read(names[key]))
    except (OSError, RuntimeError, zipfile.BadZipFile) as error:
        _cannot_be_used(str(error) or type(error).__name__)
        return None
    returned, *taken = kind.replace("(", ",").rstrip(")").split(",")
    types: list[Any] = [_TYPES[name.strip()] for name in (returned, *taken)]
    return Piece(address, ctypes.CFUNCTYPE(*types)(address))


@functools.cache
def _names() -> dict[str, str]:
    """Return the pieces' names in the archive, by key; none if it is not that of these sources.

    A piece is a module of that name, which exports a function of that name.
    """
    try:
        with zipfile.ZipFile(ARCHIVE) as archive:
            about = json.loads(archive.read("about.json"))
    except FileNotFoundError:
        return {}
    except (OSError, KeyError, ValueError, zipfile.BadZipFile) as error:
        _cannot_be_used(f"{ARCHIVE.name}: {error}")
        return {}
    if about["sources"] != digest_of_sources():  # they were edited
        return {}
    _this_machine()  # from then on LLVM knows the functions of this process
    missing = [name for name in about["calls"] if not llvm.address_of_symbol(name)]
    if missing:
        _cannot_be_used(f"this process has no {', '.join(missing)}")
        return {}
    names: dict[str, str] = about["pieces"]
    return names


def _cannot_be_used(reason: str) -> None:
    """Say once why numba compiles."""
    _warn(
        "the compiled code that comes with latolato cannot be used here "
        f"({' '.join(reason.split())}), so numba compiles it, which takes up to a minute once"
    )


@functools.cache
def _warn(message: str) -> None:
    """Warn once in a process."""
    warnings.warn(message, RuntimeWarning, stacklevel=2)


@functools.cache
def _this_machine() -> Machine:
    """Return what makes and holds code for this processor."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    name, features = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    triple = llvm.Target.from_default_triple()
    target, of_engine = (
        triple.create_target_machine(cpu=name, features=features, opt=3) for _ in range(2)
    )
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), of_engine)
    return Machine(target, engine, f"{llvmlite.__version__} {triple.triple} {name} {features}")


def _address(name: str, bitcode: bytes) -> int:
    """Return the address of a piece, whose code is put into memory."""
    machine = _this_machine()
    path = Path("shipped", hashlib.sha256(machine.name.encode() + bitcode).hexdigest()[:32] + ".o")
    code = _kept(path)
    if code is None:
        code = machine_code(bitcode, machine.target)
        _keep(path, code)
    machine.engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    machine.engine.finalize_object()
    address: int = machine.engine.get_function_address(name)
    return address


def machine_code(bitcode: bytes, target: Any) -> bytes:
    """Return a piece as an object file for a target machine of LLVM."""
    module = llvm.parse_bitcode(bitcode)
    module.triple, module.data_layout = target.triple, str(target.target_data)
    tuning = llvm.create_pipeline_tuning_options(3)
    tuning.loop_vectorization = tuning.slp_vectorization = True
    builder = llvm.create_pass_builder(target, tuning)
    builder.getModulePassManager().run(module, builder)
    code: bytes = target.emit_object(module)
    return code


def _kept(path: Path) -> bytes | None:
    """Return machine code from the cache folder, None if it has none that can be trusted."""
    try:
        return cache.read(cache.cache_directory() / path)
    except (OSError, ValueError):
        return None


def _keep(path: Path, code: bytes) -> None:
    """Keep machine code in the cache folder, or warn why every process has to make it."""
    try:
        cache.write(cache.cache_directory() / path, code)
    except OSError as error:
        _warn(
            f"machine code cannot be kept ({error.strerror or error}), so every process makes it "
            "again; set LATOLATO_CACHE_DIR to a folder that only you can write to"
        )
