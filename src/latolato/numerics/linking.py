"""Links and optimises a kernel once, with all its parts.

numba optimises every function that it compiles together with everything that it calls, and makes
machine code of it. The parts of a kernel are ten calls deep, so numba would process the same code
at every level: half of the compile time. Here a part stays as numba lowered it; the
kernel gathers what it calls, directly or not, and only then is optimised.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

from numba import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_lock import global_compiler_lock
from numba.core.runtime.nrt import rtsys


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


class _Kernel(JITCodeLibrary):
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
            if isinstance(now, (_Part, _Kernel)):
                waiting += [(each, False) for each in now._linking_libraries]
    return list(result)[::-1]


def _code_of(library: Any) -> Any:
    """Return the code of one library, without that of parts which it calls."""
    return JITCodeLibrary._get_module_for_linking(library)  # type: ignore[no-untyped-call]


def link_once(dispatcher: Any, parts: list[Any], note: Callable[[str], None] | None = None) -> None:
    """Let a kernel be linked and optimised once; its parts are given back when it is compiled.

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
    """Let numba keep the code of the kernel of that name and of its parts as above."""

    def library(codegen: Any, name: str) -> Any:
        if name != kernel:
            return _Part(codegen, name)  # type: ignore[no-untyped-call]
        result = _Kernel(codegen, name)  # type: ignore[no-untyped-call]
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
    """Let numba find the types of a sum of two floats once, not at every plus sign.

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
    types.Record.__repr__ = cache(describe)  # type: ignore[method-assign]
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
