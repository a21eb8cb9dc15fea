"""Compiled pieces that call each other by address: none is compiled into another one.

A piece takes and returns numbers and addresses of arrays and records, as C has them. What calls it
knows its address and nothing of its contents, so that a sweep with other observables, or another
mode of calling the engine, compiles what is new and nothing else. Plain Python and GPUs call the
same functions directly instead.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core.typing.templates import Signature
from numba.extending import intrinsic
from numba.np.numpy_support import from_dtype

_WORD = ir.IntType(64)
_DOUBLE = np.dtype(np.float64)


def _address_of(typing_context: Any, memory: Any) -> Any:
    """Return where a record or an array lies."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        at = args[0]
        if isinstance(memory, types.Array):
            at = context.make_array(memory)(context, builder, at).data
        return builder.ptrtoint(at, _WORD)

    return types.int64(memory), generate


address_of: Any = intrinsic(_address_of)


def record_at(layout: np.dtype[Any]) -> Callable[[int], Any]:
    """Return the function ``(address)`` of the record of this layout that lies there."""
    kind = from_dtype(layout)

    @intrinsic
    def at(typing_context: Any, address: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            return builder.inttoptr(args[0], context.get_value_type(kind))

        return kind(types.int64), generate

    found: Any = at
    return found


def array_at(layout: np.dtype[Any] = _DOUBLE) -> Callable[[int, int], Any]:
    """Return the function ``(address, size)`` of the array that lies there."""
    kind = types.Array(from_dtype(layout), 1, "C")

    @intrinsic
    def at(typing_context: Any, address: Any, size: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            item = ir.Constant(_WORD, layout.itemsize)
            return _array(context, builder, kind, args[0], [args[1]], [item])

        return kind(types.int64, types.int64), generate

    found: Any = at
    return found


def _table_at(typing_context: Any, address: Any, rows: Any, columns: Any, stride: Any) -> Any:
    """Return the table of floats that lies there; rows are `stride` bytes apart."""
    kind = types.Array(types.float64, 2, "A")

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        address, rows, columns, stride = args
        strides = [stride, ir.Constant(_WORD, 8)]
        return _array(context, builder, kind, address, [rows, columns], strides)

    return kind(types.int64, types.int64, types.int64, types.int64), generate


table_at: Any = intrinsic(_table_at)


def _array(
    context: Any, builder: Any, kind: Any, address: Any, shape: list[Any], strides: list[Any]
) -> Any:
    """Return an array of memory that somebody else owns."""
    from numba.np.arrayobj import populate_array  # needed by compiling only, and slow to import

    found = context.make_array(kind)(context, builder)
    item = context.get_constant(types.intp, context.get_abi_sizeof(found.data.type.pointee))
    populate_array(  # type: ignore[no-untyped-call]
        found,
        data=builder.inttoptr(address, found.data.type),
        shape=shape,
        strides=strides,
        itemsize=item,
        meminfo=None,
    )
    return found._getvalue()


def caller_of(kind: Signature) -> Callable[..., Any]:
    """Return what compiled code calls as ``call(address, (argument, ...))``.

    `kind` is the signature of pieces, in numba's types; arguments are converted to them.
    """

    @intrinsic
    def call(typing_context: Any, address: Any, given: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            kinds = [context.get_value_type(argument) for argument in kind.args]
            function = ir.FunctionType(context.get_value_type(kind.return_type), kinds)
            values = [
                context.cast(builder, builder.extract_value(args[1], i), was, wanted)
                for i, (was, wanted) in enumerate(zip(given.types, kind.args, strict=True))
            ]
            found = builder.call(builder.inttoptr(args[0], function.as_pointer()), values)
            return context.get_dummy_value() if kind.return_type == types.void else found

        return kind.return_type(types.int64, given), generate

    found: Callable[..., Any] = call
    return found
