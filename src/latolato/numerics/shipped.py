"""Kernels that come with the package as LLVM bitcode: compiled for this processor without numba.

`make kernels` compiles those of `latolato.numerics.kernels.every_spec` into ``kernels.zip``,
with a digest of their sources. If the sources have changed since, or the bitcode cannot be used,
numba compiles instead. Machine code is kept in the cache folder.
"""

from __future__ import annotations

import ctypes
import functools
import hashlib
import io
import json
import zipfile
from pathlib import Path
from typing import Any, NamedTuple

import llvmlite
import llvmlite.binding as llvm

from latolato.core import cache
from latolato.numerics.abi import Kernel, KernelSpec, digest_of_sources, sources_hash

ARCHIVE = Path(__file__).with_name("kernels.zip")
# LLVM's model of a processor that takes 512 bits at once.
_WIDE = "znver4"
_TYPES = {"void": None, "int64": ctypes.c_int64, "float64": ctypes.c_double}


class Machine(NamedTuple):
    """A processor: LLVM's target, an engine that holds its code, and a text that identifies it."""

    target: Any
    engine: Any
    name: str


class Processor(NamedTuple):
    """A processor as LLVM knows it: the name that it schedules for, and what it can do."""

    name: str
    features: str


class Archive(NamedTuple):
    """The package's kernels, read whole: the file may be replaced while a process runs.

    Attributes
    ----------
    content : ZipFile
        A kernel is a module, which exports a function of its own name.
    names : dict
        The kernels' names in it by `KernelSpec.key`.
    """

    content: zipfile.ZipFile
    names: dict[str, str]


def load(spec: KernelSpec) -> Kernel | None:
    """The package's kernel of a specification, None if numba must compile it."""
    try:
        archive = _archive()
        if archive is None or spec.key not in archive.names:
            return None
        name = archive.names[spec.key]
        machine = _this_machine(for_lanes=spec.for_lanes)
        address = _address(name, archive.content.read(name), machine)
    except Exception as error:  # zlib, zipfile and LLVM have many, and numba needs none of them
        _cannot_be_used(cache.reason_of(error))
        return None
    returned, *taken = spec.signature.replace("(", ",").rstrip(")").split(",")
    types: list[Any] = [_TYPES[name.strip()] for name in (returned, *taken)]
    return Kernel(address, ctypes.CFUNCTYPE(*types)(address))


@functools.cache
def _archive() -> Archive | None:
    """The package's kernels, None if there are none of these very sources."""
    try:
        content = zipfile.ZipFile(io.BytesIO(ARCHIVE.read_bytes()))
    except FileNotFoundError:
        return None
    about = json.loads(content.read("about.json"))
    if about["sources"] != digest_of_sources():  # they were edited
        return None
    _this_machine(for_lanes=False)  # from then on LLVM knows the functions of this process
    missing = [name for name in about["calls"] if not llvm.address_of_symbol(name)]
    if missing:
        raise LookupError(f"this process has no {', '.join(missing)}")
    return Archive(content, about["kernels"])


def _cannot_be_used(reason: str) -> None:
    """Warn once why numba compiles."""
    cache.warn(
        f"the compiled code that comes with latolato cannot be used here ({reason}), so numba "
        "compiles it, which takes up to a minute"
    )


def target_for(triple: str, name: str = "", features: str = "") -> Any:
    """Return LLVM's target machine for code that is loaded into a running process."""
    # With tables of addresses, one for each object file, the first would be taken for all.
    reloc = "static" if triple.startswith("x86_64") else "default"
    target = llvm.Target.from_triple(triple)
    return target.create_target_machine(name, features, opt=3, reloc=reloc, jit=True)


@functools.cache
def this_processor() -> Processor:
    """Return the processor of this machine."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    try:
        features = llvm.get_host_cpu_features().flatten()
    except RuntimeError:  # LLVM does not know this processor's
        features = ""
    return Processor(llvm.get_host_cpu_name(), features)


def tuned_for_lanes(processor: Processor) -> Processor:
    """Return the processor that code for lanes is scheduled for; see docs/numerics.md.

    For Intel's processors with vectors of 512 bits LLVM prefers 256, which lanes do not: they are
    nothing but long loops. The features remain, so the instructions are those of this processor.
    """
    known = processor.features.split(",")
    is_wide = "+avx512f" in known and "+avx512vl" in known
    if not is_wide or processor.name.startswith("znver"):
        return processor
    return processor._replace(name=_WIDE)


@functools.cache
def _this_machine(*, for_lanes: bool) -> Machine:
    """Return the compiler for this processor and its engine, which owns the code."""
    processor, triple = this_processor(), llvm.get_process_triple()
    if for_lanes:
        processor = tuned_for_lanes(processor)
    target, of_engine = (target_for(triple, *processor) for _ in range(2))
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), of_engine)
    words = llvmlite.__version__, target.triple, *processor
    return Machine(target, engine, " ".join(words))


def _address(name: str, bitcode: bytes, machine: Machine) -> int:
    """The address of a kernel, whose code is put into memory."""
    digest = hashlib.sha256(machine.name.encode() + bitcode).hexdigest()[:32]
    path = Path(sources_hash(), f"{name}-{digest}.o")
    code = _kept(path)
    if code is None:
        code = machine_code(bitcode, machine.target)
        _keep(path, code)
    machine.engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    machine.engine.finalize_object()
    address: int = machine.engine.get_function_address(name)
    return address


def machine_code(bitcode: bytes, target: Any) -> bytes:
    """A kernel as an object file for a target machine of LLVM."""
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
        cache.warn(
            f"machine code cannot be kept ({cache.reason_of(error)}), so every process makes it "
            "again; set LATOLATO_CACHE_DIR to a folder that only you can write to"
        )
