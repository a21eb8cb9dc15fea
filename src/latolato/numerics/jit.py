"""Compiles kernels with numba and keeps them on disk, keyed by everything they depend on.

numba's own cache looks only at the file of the outermost function. Ours hashes all sources of the
kernel layers together with the library versions, so an edit anywhere below a kernel recompiles it.

numba optimises every function that it compiles together with everything that it calls, and makes
machine code of it. The parts of a kernel are ten calls deep, so numba would process the same code
at every level: half of the compile time. Here a part stays as numba lowered it; the
kernel gathers what it calls, directly or not, and only then is optimised.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import pickle
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import CodeType
from typing import Any

import numba
from numba import types
from numba.core.caching import _Cache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompileResult
from numba.core.compiler_lock import global_compiler_lock
from numba.core.runtime.nrt import rtsys
from numba.core.serialize import dumps
from numba.core.sigutils import normalize_signature
from numba.extending import register_jitable

from latolato.core import cache
from latolato.core.scalar import for_each_formula
from latolato.numerics.abi import Kernel, KernelSpec, sources_hash
from latolato.numerics.compiler import tell_it_is_there

# Only kernels call parts: without entries for Python and C they compile in two thirds of the time.
_PART: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def _make_callable(function: Callable[..., Any]) -> None:
    """Make a formula callable from compiled code."""
    register_jitable(**_PART, forceinline=True)(function)  # small, and lanes need it


for_each_formula(_make_callable)
tell_it_is_there()


class _KernelCache(_Cache):
    """Keeps a kernel on disk, one file for each signature and processor.

    Trouble with the disk costs time and a warning, never the run.
    """

    def __init__(self, name: str, key: str) -> None:
        self._name, self._key = name, key

    @property
    def cache_path(self) -> str:
        """The folder of the kernels made from these sources."""
        return str(self._folder())

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Load a kernel without what only compiling needs: 0.2 s of imports, half of them SciPy."""
        import_module("numba.cpython.hashing")  # compiled code may call what lies in it
        try:
            path = self._path(sig, target_context.codegen())
            reduced = pickle.loads(cache.read(path))
            return CompileResult._rebuild(target_context, *reduced)  # type: ignore[no-untyped-call]
        except (FileNotFoundError, NotADirectoryError, cache.UntrustedFolderError):
            return None  # saving explains what is wrong with a folder
        except Exception as error:
            reason = cache.reason_of(error)
        with contextlib.suppress(OSError):
            path.unlink()
        cache.warn(f"a kernel kept in '{path.parent}' is not used ({reason}) and compiled again")
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Save a kernel, or warn why the next process will have to compile it again."""
        try:
            if data.library.has_dynamic_globals:  # as with NUMBA_OPT=0
                raise ValueError("their code holds addresses of this process")
            content = dumps(data._reduce())  # type: ignore[no-untyped-call]
            cache.write(self._path(sig, data.codegen), content)
            return
        except Exception as error:
            reason = cache.reason_of(error)
        cache.warn(
            f"compiled kernels cannot be kept ({reason}), so every process compiles them again; "
            "set LATOLATO_CACHE_DIR to a folder that only you can write to"
        )

    def enable(self) -> None:
        """Do nothing: the cache is always on."""

    def disable(self) -> None:
        """Do nothing: the cache is always on."""

    def flush(self) -> None:
        """Do nothing: files of other sources are never read."""

    def _folder(self) -> Path:
        return cache.cache_directory() / sources_hash()

    def _path(self, sig: Any, codegen: Any) -> Path:
        key = hashlib.sha256(repr((sig, codegen.magic_tuple(), self._key)).encode())
        return self._folder() / f"{self._name}-{key.hexdigest()[:32]}.kernel"


def law_key(*laws: Callable[..., Any]) -> str:
    """Return a text that identifies formulas: where they stand and what their code is."""
    parts = []
    for law in laws:
        body = hashlib.sha256(_code(law.__code__)).hexdigest()[:12]
        parts.append(f"{law.__module__}.{law.__qualname__}.{body}")
    return "+".join(parts)


def _code(code: CodeType) -> bytes:
    """Return a function's code, with that of functions within."""
    constants = [_code(c) if isinstance(c, CodeType) else repr(c).encode() for c in code.co_consts]
    return b" ".join([code.co_code, *constants])


# Multiply-adds may be fused: faster and rounded once less, but not to the bits of plain Python.
_OPTIONS: dict[str, Any] = {"error_model": "numpy", "nogil": True, "fastmath": {"contract"}}


def compile_spec(spec: KernelSpec, note: Callable[[str], None] | None = None) -> Kernel:
    """The kernel of a specification; it allocates nothing. See `_link_once` for `note`."""
    make = functools.partial(spec.make, **dict(spec.settings))
    kernel: Any = compile_kernel(make, spec.key, *spec.laws, allocates=False, note=note)
    arguments, _ = normalize_signature(spec.signature)  # type: ignore[no-untyped-call]
    kernel.compile(arguments)
    overload = kernel.overloads[arguments]
    address = overload.library.get_pointer_to_function(overload.fndesc.llvm_cfunc_wrapper_name)
    return Kernel(address, kernel)


def compile_kernel(
    make: Callable[..., Callable[..., Any]],
    name: str,
    *laws: Callable[..., Any],
    allocates: bool = True,
    note: Callable[[str], None] | None = None,
) -> Callable[..., Any]:
    """Return the kernel that `make` folds from laws, compiled, with a disk cache.

    ``make(*laws, compile_part)`` compiles its parts by the function it is given. Every part gets a
    name of its own kernel: libraries that two processes compiled may be loaded by a third, and
    parts of one name would be taken for each other there. A kernel that does not allocate arrays is
    faster if it says so: then nobody counts references to those it is given.
    """
    options = _OPTIONS if allocates else {**_OPTIONS, "_nrt": False}
    key = f"{name}:{law_key(*laws)}"
    suffix = hashlib.sha256(key.encode()).hexdigest()[:16]

    def rename(function: Callable[..., Any]) -> None:
        function.__qualname__ = f"{function.__qualname__}_{suffix}"

    parts: list[Any] = []

    def compile_part(function: Callable[..., Any], *, inline: bool = False) -> Any:
        rename(function)
        parts.append(numba.njit(**options, **_PART, forceinline=inline)(function))
        return parts[-1]

    function = make(*laws, compile_part)
    rename(function)
    dispatcher = numba.njit(**options)(function)
    dispatcher._cache = _KernelCache(function.__name__, key)
    _link_once(dispatcher, parts, note)
    compiled: Callable[..., Any] = dispatcher
    return compiled


class _Part(JITCodeLibrary):
    """The code of a part, which has no machine code of its own."""

    @property
    def codegen(self) -> Any:
        """Code generation without environments: no part is called from Python."""
        return _WithoutEnvironments(self._codegen)

    def finalize(self) -> None:
        """Do nothing more."""
        self._raise_if_finalized()  # type: ignore[no-untyped-call]
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0: there is no machine code."""
        return 0

    def _get_module_for_linking(self) -> Any:
        """Return the code with all that it calls, for one of numba's own functions."""
        result = super()._get_module_for_linking().clone()  # type: ignore[no-untyped-call]
        for library in _called(self):
            if library is not self:
                result.link_in(_code_of(library), preserve=True)
        return result


class _Whole(JITCodeLibrary):
    """The code of a kernel, into which all parts are linked."""

    note: Callable[[str], None] | None = None

    def finalize(self) -> None:
        """Link all that is called, directly or not, then optimise."""
        for library in _called(self):
            if library is not self:
                self._final_module.link_in(_code_of(library), preserve=True)
        self._linking_libraries: list[Any] = []
        if self.note is not None:
            self.note(str(self._final_module))
        super().finalize()  # type: ignore[no-untyped-call]


class _WithoutEnvironments:
    """A code generator that does not look for a function's environment."""

    def __init__(self, codegen: Any) -> None:
        self._codegen = codegen

    def __getattr__(self, name: str) -> Any:
        return getattr(self._codegen, name)

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing."""


def _called(library: Any) -> list[Any]:
    """Return a library and all that it calls, each once and behind all that call it.

    Libraries of numba's own functions already hold what these call. LLVM leaves out what nothing
    before it calls: a library may be named by a part whose call was never made.
    """
    result: dict[Any, None] = {}
    waiting = [(library, False)]
    while waiting:
        now, is_done = waiting.pop()
        if is_done:
            result[now] = None
        elif now not in result:
            waiting.append((now, True))
            if isinstance(now, (_Part, _Whole)):
                waiting += [(each, False) for each in now._linking_libraries]
    return list(result)[::-1]


def _code_of(library: Any) -> Any:
    """Return the code of one library, without that of parts which it calls."""
    return JITCodeLibrary._get_module_for_linking(library)  # type: ignore[no-untyped-call]


def _link_once(
    dispatcher: Any, parts: list[Any], note: Callable[[str], None] | None = None
) -> None:
    """Link and optimise a kernel once, and release its parts when it is compiled.

    `note` is called with all its code, as LLVM's assembly, before anything is optimised.
    """
    plain, kernel = dispatcher.compile, dispatcher.py_func.__qualname__

    def compile(signature: Any) -> Any:
        codegen, typing = dispatcher.targetctx.codegen(), dispatcher.typingctx
        rtsys.initialize(dispatcher.targetctx)  # numba's own code is linked as ever
        with global_compiler_lock, _libraries(codegen, kernel, note), _remembered(typing):
            entry = plain(signature)
            for overload in dispatcher.overloads.values():
                overload.library._linking_libraries.clear()
            for part in parts:
                part._make_finalizer()()
                part._reset_overloads()
        return entry

    for part in parts:
        _compile_directly(part)
    dispatcher.compile = compile


@contextmanager
def _libraries(codegen: Any, kernel: str, note: Callable[[str], None] | None) -> Iterator[None]:
    """Make numba keep the code of a kernel and its parts in `_Whole` and `_Part`."""

    def library(codegen: Any, name: str) -> Any:
        if name != kernel:
            return _Part(codegen, name)  # type: ignore[no-untyped-call]
        result = _Whole(codegen, name)  # type: ignore[no-untyped-call]
        result.note = note
        return result

    library._unserialize = JITCodeLibrary._unserialize  # type: ignore[attr-defined]
    codegen._library_class = library
    try:
        yield
    finally:
        del codegen._library_class


@contextmanager
def _remembered(typing: Any) -> Iterator[None]:
    """Resolve the types of a function call once, such as a sum of two floats, not at every use.

    It also describes the types of all arguments before each of its passes: records, whose
    description is as long as themselves, are described once.
    """
    known: dict[Any, Any] = {}
    plain, describe = typing.resolve_function_type, types.Record.__repr__

    def resolve(function: Any, args: Any, kws: Any) -> Any:
        if not isinstance(function, types.Function):
            return plain(function, args, kws)
        key = function, tuple(args), tuple(kws.items())
        if key not in known:
            known[key] = plain(function, args, kws)
        return known[key]

    typing.resolve_function_type = resolve
    types.Record.__repr__ = functools.cache(describe)  # type: ignore[method-assign]
    try:
        yield
    finally:
        del typing.resolve_function_type
        types.Record.__repr__ = describe  # type: ignore[method-assign]


def _compile_directly(part: Any) -> None:
    """Leave out what numba does around compiling a part: caches, timers that watch all others.

    Numbers that stand in the code have the same types as others.
    """

    def compile(args: tuple[Any, ...]) -> None:
        if args not in part.overloads:
            part.add_overload(part._compiler.compile(args, None))

    def get_call_template(args: Any, kws: Any) -> Any:
        plain: Any = type(part).get_call_template
        unliteral: Any = types.unliteral
        named = {name: unliteral(kind) for name, kind in kws.items()}
        return plain(part, tuple(map(unliteral, args)), named)

    part.compile, part.get_call_template = compile, get_call_template
