"""All pieces of compiled code by name, shipped with the package or compiled here.

A piece takes and returns numbers and addresses of arrays and records, as C has them. What calls it
knows its address and does not depend on the code behind it, so a sweep with other observables
only needs new pieces for these. Plain Python and GPUs call the same functions directly.

Nothing here imports a compiler: `latolato.numerics.shipped` has the package's own pieces, and
`latolato.numerics.compiled` is imported where a piece is not among them.
"""

from __future__ import annotations

import functools
import operator
import struct
import threading
from collections.abc import Iterable, Iterator, Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.numerics.callbacks import (
    OCCASIONS,
    ON_STEP,
    ON_TANGENT,
    Formulas,
    formulas_of,
    slots_of,
)
from latolato.numerics.derived_plane import PLANE_OBSERVED
from latolato.numerics.recipes import Formula, Piece, Recipe
from latolato.numerics.records import segment_dtype
from latolato.numerics.trajectory import motion_of
from latolato.observables import Observable

_lock = threading.RLock()


def piece_of(recipe: Recipe) -> Piece:
    """Return the piece of a recipe; threads that want the same one wait for it."""
    with _lock:
        return _made(recipe)


@functools.lru_cache(maxsize=512)
def _made(recipe: Recipe) -> Piece:
    from latolato.numerics import shipped

    result = shipped.load(recipe.key, recipe.kind)
    if result is not None:
        return result
    from latolato.numerics.compiled import compile_piece

    return compile_piece(recipe)


# ``rows(run, stop, most_steps)``, where `run` is an address; see `latolato.numerics.engine.loop`.
ENGINE = "int64(int64, float64, int64)"
# ``(words)`` of what a sweep works on.
SWEEP = "void(int64)"
# ``lanes that wait(workspace, table, kicks, drifts of a step)``
FLY = "float64(int64, int64, int64, int64)"
# ``(workspace, kicks, drifts, nodes, stages)``
LOCATE = "void(int64, int64, int64, int64, int64)"
# ``(slots, workspace, matrix, number of the restoring law)``
SHOW = "void(int64, int64, int64, int64)"
# ``(slots, index of the first one, distance of slots, words of what is shown)``
CALLBACK = "void(int64, int64, int64, int64)"


def engine_recipe(
    count: int, segment: np.dtype[Any], *laws: Formula, motion: str = "exact"
) -> Recipe:
    """Return the engine of `count` balls.

    Parameters
    ----------
    segment : dtype
        The layout of the drive's segments.
    laws : formulas
        Those of `trajectory.make_trajectory`.
    motion : str
        One of `trajectory.MOTIONS`.
    """
    settings = ("count", count), ("segment", segment)
    return Recipe("entry:make_entry", ENGINE, (motion_of(motion), *laws), settings)


# What prepares `prepare.Cases`, writes the segments of a `whole.Shaking`, makes the record of a
# `whole.Beginning`, and returns the error of the ledger that is allowed to the run at an address.
PREPARE = Recipe("entry:make_prepare_entry", SWEEP)
SHAKE = Recipe("entry:make_shake_entry", SWEEP)
BEGIN = Recipe("entry:make_begin_entry", SWEEP)
ALLOWED = Recipe("entry:make_allowed_entry", "float64(int64, float64)")


def many_recipe(balls: int, segment: np.dtype[Any]) -> Recipe:
    """Return the recipe of the kernel that runs points of `balls` balls one after the other."""
    settings = ("balls", balls), ("segment", segment)
    return Recipe("entry:make_many_entry", SWEEP, (), settings)


def lanes_recipe(segment: np.dtype[Any], *laws: Formula) -> Recipe:
    """Return the recipe of the kernel that runs points in lanes; laws as for `lanes.make_lanes`."""
    return Recipe("lanes:make_lanes", SWEEP, laws, (("segment", segment),))


def observer_recipe(segment: np.dtype[Any], *laws: Formula) -> Recipe:
    """Return the recipe of the kernel that fills an `observe.Observation`.

    Laws are those of `derived.make_observer`, or all those of `derived_plane.make_plane_observer`.
    """
    in_plane = len(laws) == PLANE_OBSERVED
    maker = "entry:make_plane_observer_entry" if in_plane else "entry:make_observer_entry"
    return Recipe(maker, SWEEP, laws, (("segment", segment),))


def fly_recipe(
    restoring: Formula, *, damped: bool, walled: bool, works: bool, tangents: bool
) -> Recipe:
    """Return the step of all lanes.

    Parameters
    ----------
    damped, walled, works, tangents : bool
        Whether any point has drag, whether any has walls, whether works and matrices are asked for.
    """
    settings = ("damped", damped), ("walled", walled), ("works", works), ("tangents", tangents)
    return Recipe("lane_flight:make_fly", FLY, (restoring,), settings)


def locate_recipe(restoring: Formula, *, damped: bool, works: bool) -> Recipe:
    """Return the recipe of the kernel that locates impacts of lanes; flags as for `fly_recipe`."""
    settings = ("damped", damped), ("works", works)
    return Recipe("lane_locate:make_locate", LOCATE, (restoring,), settings)


# What observables may name among their needs that is found for all of them together.
SHARED = ("energy", "turn")


def survey_recipe(needs: frozenset[str], restoring: Formula, potential: Formula) -> Recipe:
    """Return the recipe of the kernel for values that observables share of every lane's step."""
    settings = tuple((name, name in needs) for name in SHARED)
    return Recipe("lane_flight:make_survey", SHOW, (restoring, potential), settings)


def show_recipe(
    formula: Formula, needs: frozenset[str], restoring: Formula, potential: Formula
) -> Recipe:
    """Return the recipe of the kernel that reports every lane's step to an observable."""
    settings = tuple((name, name in needs) for name in SHARED)
    return Recipe("lane_flight:make_show", SHOW, (formula, restoring, potential), settings)


def follow_recipe(formula: Formula) -> Recipe:
    """Return the recipe of the kernel that reports every lane's Jacobian to an observable."""
    return Recipe("lane_flight:make_follow", SHOW, (formula,))


def callback_recipe(occasion: int, formula: Formula) -> Recipe:
    """Return the recipe of the callback of an observable on an occasion."""
    return Recipe("callback_kernels:make_callback", CALLBACK, (formula,), (("occasion", occasion),))


def callback_table(pieces: Sequence[Sequence[tuple[int, Piece]]]) -> NDArray[np.int64]:
    """Return the table of pieces that compiled code walks through, with their first slots.

    For each occasion it says where its pieces begin: pairs of address and first slot, up to an
    address of zero.
    """
    begins: list[int] = []
    pairs: list[int] = []
    for formulas in pieces:
        begins.append(len(pieces) + len(pairs))
        for first, piece in formulas:
            pairs += [piece.address, first]
        pairs += [0]
    return np.array(begins + pairs, dtype=np.int64)


def pieces_of(formulas: tuple[Formulas, ...]) -> list[list[tuple[int, Piece]]]:
    """Return for each occasion the pieces of `callbacks.formulas_of` with their first slots."""
    return [
        [(first, piece_of(callback_recipe(occasion, formula))) for first, formula in formulas]
        for occasion, formulas in enumerate(formulas)
    ]


def lane_pieces(watched: Sequence[Observable], *laws: Formula) -> list[list[tuple[int, Piece]]]:
    """Return the pieces that pass the lanes' steps and matrices on, with their first slots.

    Laws are the restoring factor and its potential. What several observables need comes first.
    """
    watching = [
        (block.first, observable.step, observable.needs)
        for block, observable in zip(slots_of(watched), watched, strict=True)
        if observable.step is not None
    ]
    needs = frozenset[str]().union(*(needs for _, _, needs in watching)) & frozenset(SHARED)
    shared = [(0, piece_of(survey_recipe(needs, *laws)))] if needs else []
    steps = [(first, piece_of(show_recipe(step, own, *laws))) for first, step, own in watching]
    matrices = formulas_of(watched)[ON_TANGENT]
    return [
        [*shared, *steps],
        [(first, piece_of(follow_recipe(formula))) for first, formula in matrices],
    ]


def words_of(value: Any, example: Any) -> list[int]:
    """Return the words of a value, from which compiled code reads it; see `addresses.Bundle`.

    A value is a number, an array, or a tuple of values. An array's words are its address, its
    shape and its strides.

    Raises
    ------
    TypeError
        If something is not of the kind that it has in `example`, for which the code was compiled.
    """
    if isinstance(example, tuple):
        pairs = zip(value, example, strict=True)
        return [word for part, like in pairs for word in words_of(part, like)]
    if isinstance(example, np.ndarray):
        _check_array(value, example)
        return [value.ctypes.data, *value.shape, *value.strides]
    if isinstance(example, float):
        return list(struct.unpack("q", struct.pack("d", value)))
    return [operator.index(value)]


def _check_array(value: Any, example: NDArray[Any]) -> None:
    """Raise unless a value is an array that compiled code can take for `example`."""
    if not isinstance(value, np.ndarray):
        raise TypeError(f"compiled code expects an array, got {type(value).__name__}")
    is_contiguous = value.flags.c_contiguous or not example.flags.c_contiguous
    if value.dtype != example.dtype or value.ndim != example.ndim or not is_contiguous:
        raise TypeError(
            f"compiled code expects a contiguous array of {example.dtype} in {example.ndim} "
            f"dimensions, got {value.dtype} in {value.ndim} with strides {value.strides}"
        )


def every_recipe(observables: Iterable[type[Observable]]) -> Iterator[Recipe]:
    """Yield each piece that the package's laws and these kinds of observables need."""
    from latolato.physics.drives.segment import (
        pivot_acceleration,
        pivot_across,
        pivot_across_acceleration,
        pivot_across_velocity,
        pivot_height,
        pivot_velocity,
        rotation,
    )
    from latolato.physics.pendulum import (
        potential_sine,
        restoring_linear,
        restoring_sine,
    )

    usual, laws = segment_dtype(), (restoring_sine, potential_sine)
    for count, motion in ((1, "exact"), (2, "exact"), (1, "clamp")):
        yield engine_recipe(count, usual, pivot_acceleration, *laws, motion=motion)
    yield from (PREPARE, SHAKE, BEGIN, ALLOWED)
    for balls in (1, 2):
        yield many_recipe(balls, usual)
    yield lanes_recipe(usual, pivot_acceleration, *laws, rotation)
    yield observer_recipe(usual, pivot_height, pivot_velocity, pivot_acceleration, *laws)
    across = pivot_across_acceleration, pivot_velocity, pivot_across_velocity
    for count in (1, 2):
        yield engine_recipe(count, usual, pivot_acceleration, *laws, *across)
    yield observer_recipe(
        usual, pivot_height, pivot_velocity, pivot_acceleration, pivot_across,
        pivot_across_velocity, pivot_across_acceleration,
    )  # fmt: skip
    answers = (False, True)
    for damped, works in product(answers, answers):
        yield locate_recipe(restoring_sine, damped=damped, works=works)
        for restoring, walled in (
            (restoring_sine, True), (restoring_sine, False), (restoring_linear, False),
        ):  # fmt: skip
            for tangents in answers:
                yield fly_recipe(
                    restoring, damped=damped, works=works, walled=walled, tangents=tangents
                )
    for shared in ({"energy"}, {"turn"}, {"energy", "turn"}):
        yield survey_recipe(frozenset(shared), *laws)
    for observable in observables:
        for occasion, name in enumerate(OCCASIONS):
            formula = getattr(observable, name)
            if formula is None:
                continue
            yield callback_recipe(occasion, formula)
            if occasion == ON_STEP:
                yield show_recipe(formula, observable.needs, *laws)
            if occasion == ON_TANGENT:
                yield follow_recipe(formula)
