"""What kernels do at addresses: read records, arrays and bundles, and call other kernels."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Iterator
from itertools import count
from typing import Any

import numba
import numpy as np
from llvmlite import ir
from numba import types
from numba.core.datamodel import models
from numba.core.imputils import lower_getattr_generic
from numba.core.sigutils import normalize_signature
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import intrinsic, register_model
from numba.np.numpy_support import from_dtype

_WORD = ir.IntType(64)
_DOUBLE = np.dtype(np.float64)
# Of arrays whose end a kernel does not look for.
ANY_SIZE = 1 << 40


def _constant(number: int) -> Any:
    """Return a word."""
    return ir.Constant(_WORD, number)


def _address_of(typing_context: Any, memory: Any) -> Any:
    """Return the address of a record or an array."""

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

    result: Any = at
    return result


def array_at(layout: np.dtype[Any] = _DOUBLE, *further: int) -> Callable[[int, int], Any]:
    """Return the function ``(address, size)`` of the array that lies there, row by row.

    `further` are the sizes of all dimensions but the first.
    """
    kind = types.Array(from_dtype(layout), 1 + len(further), "C")
    row = layout.itemsize * math.prod(further)
    strides = [row // math.prod(further[:i]) for i in range(1 + len(further))]

    @intrinsic
    def at(typing_context: Any, address: Any, size: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            shape = [args[1], *(_constant(n) for n in further)]
            steps = [_constant(n) for n in strides]
            return _array(context, builder, kind, args[0], shape, steps)

        return kind(types.int64, types.int64), generate

    result: Any = at
    return result


def kind_of(value: Any) -> Any:
    """Return the type that compiled code sees a value as: a number, an array, a tuple of these."""
    key = _key_of(value)
    if key not in _kinds:  # a tuple with many layouts takes numba some milliseconds
        _kinds[key] = numba.typeof(value)  # type: ignore[no-untyped-call]
    return _kinds[key]


_kinds: dict[Any, Any] = {}


def _key_of(value: Any) -> Any:
    """Return the key of a value's type."""
    if isinstance(value, tuple):
        return type(value), *map(_key_of, value)
    if isinstance(value, np.ndarray):
        return value.dtype, value.ndim, value.flags.c_contiguous, value.flags.f_contiguous
    return type(value)


class Bundle(types.Type):
    """The type of a named tuple of arrays and integers that is passed as the address of its words.

    Compiled code reads a field where it needs it; to pass the tuple itself would be to pass the
    hundred numbers that describe its arrays, from part to part.
    """

    def __init__(self, kind: Any) -> None:
        self.kind = kind
        digest = hashlib.sha256(str(kind).encode()).hexdigest()[:16]
        super().__init__(name=f"{kind.instance_class.__name__}_{digest}")


@register_model(Bundle)
class _BundleModel(models.PrimitiveModel):
    """An address."""

    def __init__(self, manager: Any, kind: Bundle) -> None:
        super().__init__(manager, kind, _WORD)  # type: ignore[no-untyped-call]


@infer_getattr
class _BundleFields(AttributeTemplate):
    """Types of the fields."""

    key = Bundle

    def generic_resolve(self, bundle: Any, name: str) -> Any:  # type: ignore[override]
        """Return the type of a field, `None` if there is none of that name."""
        if name not in bundle.kind.fields:
            return None
        kind = bundle.kind[bundle.kind.fields.index(name)]
        return Bundle(kind) if isinstance(kind, types.BaseNamedTuple) else kind


def _size_of(kind: Any) -> int:
    """Return how many words there are of a value of this type."""
    if isinstance(kind, types.BaseTuple):
        kinds: Any = kind
        return sum(map(_size_of, kinds))
    return 1 + 2 * kind.ndim if isinstance(kind, types.Array) else 1


def _read(context: Any, builder: Any, kind: Any, words: Any, places: Iterator[int]) -> Any:
    """Return a value of this type from words at these places."""

    def following(size: int) -> list[Any]:
        result = [builder.load(builder.gep(words, [_constant(next(places))])) for _ in range(size)]
        for load in result:  # a kernel never changes words it was given, so one reading will do
            load.set_metadata("invariant.load", builder.module.add_metadata([]))
        return result

    if isinstance(kind, types.BaseTuple):
        kinds: Any = kind
        result = [_read(context, builder, inner, words, places) for inner in kinds]
        return context.make_tuple(builder, kind, result)
    if isinstance(kind, types.Array):
        address, shape = following(1)[0], following(kind.ndim)
        return _array(context, builder, kind, address, shape, following(kind.ndim))
    return builder.bitcast(following(1)[0], context.get_value_type(kind))


@lower_getattr_generic(Bundle)  # type: ignore[no-untyped-call]
def _read_field(context: Any, builder: Any, bundle: Bundle, address: Any, name: str) -> Any:
    """Return the value of a field."""
    number = bundle.kind.fields.index(name)
    kind, first = bundle.kind[number], sum(map(_size_of, bundle.kind.types[:number]))
    if isinstance(kind, types.BaseNamedTuple):
        return builder.add(address, _constant(8 * first))
    words = builder.inttoptr(address, _WORD.as_pointer())
    return _read(context, builder, kind, words, count(first))


def bundle_at(kind: Any) -> Callable[[int], Any]:
    """Return the function ``(address)`` of the bundle whose words lie there."""

    @intrinsic
    def at(typing_context: Any, address: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            return args[0]

        return Bundle(kind)(types.int64), generate

    result: Any = at
    return result


def value_at(kind: Any) -> Callable[[int], Any]:
    """Return the function ``(address)`` of the value of this type whose words lie there."""

    @intrinsic
    def at(typing_context: Any, address: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            words = builder.inttoptr(args[0], _WORD.as_pointer())
            return _read(context, builder, kind, words, count())

        return kind(types.int64), generate

    result: Any = at
    return result


def writer_of(target: Any) -> Callable[[int, Any], None]:
    """Return the function ``(address, value)`` that writes the words of a value of this type."""

    @intrinsic
    def write(typing_context: Any, address: Any, value: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            words, places = builder.inttoptr(args[0], _WORD.as_pointer()), count()

            def store(word: Any) -> None:
                builder.store(word, builder.gep(words, [_constant(next(places))]))

            def write(value: Any, kind: Any, target: Any) -> None:
                if isinstance(target, types.BaseTuple):
                    inner: Any = target
                    for i, part in enumerate(inner):
                        write(builder.extract_value(value, i), kind[i], part)
                elif isinstance(target, types.Array):
                    array = context.make_array(kind)(context, builder, value)
                    store(builder.ptrtoint(array.data, _WORD))
                    for sizes in (array.shape, array.strides):
                        for i in range(kind.ndim):
                            store(builder.extract_value(sizes, i))
                else:
                    store(builder.bitcast(context.cast(builder, value, kind, target), _WORD))

            write(args[1], value, target)
            return context.get_dummy_value()

        return types.void(types.int64, value), generate

    result: Any = write
    return result


def _array(
    context: Any, builder: Any, kind: Any, address: Any, shape: list[Any], strides: list[Any]
) -> Any:
    """Return an array of memory that somebody else owns."""
    from numba.np.arrayobj import populate_array  # needed by compiling only, and slow to import

    result = context.make_array(kind)(context, builder)
    item = context.get_constant(types.intp, context.get_abi_sizeof(result.data.type.pointee))
    populate_array(  # type: ignore[no-untyped-call]
        result,
        data=builder.inttoptr(address, result.data.type),
        shape=shape,
        strides=strides,
        itemsize=item,
        meminfo=None,
    )
    return result._getvalue()


def caller_of(what: str) -> Callable[..., Any]:
    """Return the intrinsic that compiled code calls as ``call(address, (argument, ...))``.

    `what` is the `abi.KernelSpec.signature` of such kernels; arguments are converted to it.
    """
    arguments, returned = normalize_signature(what)  # type: ignore[no-untyped-call]
    kind: Any = returned(*arguments)

    @intrinsic
    def call(typing_context: Any, address: Any, values: Any) -> Any:
        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            kinds = [context.get_value_type(argument) for argument in kind.args]
            returned = (
                ir.VoidType()  # numba's own is a pointer, which WebAssembly tells from nothing
                if kind.return_type == types.void
                else context.get_value_type(kind.return_type)
            )
            function = ir.FunctionType(returned, kinds)
            casts = [
                context.cast(builder, builder.extract_value(args[1], i), was, becomes)
                for i, (was, becomes) in enumerate(zip(values.types, kind.args, strict=True))
            ]
            result = builder.call(builder.inttoptr(args[0], function.as_pointer()), casts)
            return context.get_dummy_value() if kind.return_type == types.void else result

        return kind.return_type(types.int64, values), generate

    result: Callable[..., Any] = call
    return result
