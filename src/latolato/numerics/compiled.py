"""Compiles kernels with numba and keeps them on disk, keyed by everything they depend on.

numba's own cache looks only at the file of the outermost function. Ours hashes all sources of the
kernel layers together with the library versions, so an edit anywhere below a kernel recompiles it.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import pickle
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from types import CodeType
from typing import Any

import numba
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps
from numba.core.sigutils import normalize_signature
from numba.extending import register_jitable

from latolato.core import cache
from latolato.core.scalar import for_each_formula
from latolato.numerics.compiler import tell_it_is_there
from latolato.numerics.linking import link_once
from latolato.numerics.recipes import Piece, Recipe
from latolato.numerics.sources import sources_hash

# Only kernels call parts: without entries for Python and C they compile in two thirds of the time.
_PART: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def _make_callable(function: Callable[..., Any]) -> None:
    """Let compiled code call a formula."""
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


def compile_piece(recipe: Recipe, note: Callable[[str], None] | None = None) -> Piece:
    """Return the piece of a recipe; it allocates nothing. See `link_once` for `note`."""
    module, _, name = recipe.maker.partition(":")
    maker = getattr(import_module(f"latolato.numerics.{module}"), name)
    make = functools.partial(maker, **dict(recipe.settings))
    kernel: Any = compile_kernel(make, recipe.key, *recipe.laws, allocates=False, note=note)
    arguments, _ = normalize_signature(recipe.kind)  # type: ignore[no-untyped-call]
    kernel.compile(arguments)
    overload = kernel.overloads[arguments]
    address = overload.library.get_pointer_to_function(overload.fndesc.llvm_cfunc_wrapper_name)
    return Piece(address, kernel)


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
    link_once(dispatcher, parts, note)
    compiled: Callable[..., Any] = dispatcher
    return compiled
