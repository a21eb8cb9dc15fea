"""What every observable offers: numbers gathered while a trajectory runs, without storing it.

An observable owns some *slots* of an accumulator array: first its parameters, in the order of its
fields, then its variables, then anything else it has to remember. The engine calls its formulas at
the start, at every step, contact and mark, and at the end, with the accumulator, the index `i` of
its first slot and the distance `n` between slots: slot m is ``acc[i + m * n]``. They run as plain
Python, compiled, in SIMD lanes, on a GPU and in a web page, so they use :mod:`math` only; write
`step` without branches around assignments (use ``a if condition else b``), then lanes stay fast.

Examples
--------
The time that a ball spends above an angle::

    @formula
    def _step(acc, i, n, segment):
        acc[i + n] += max(segment.t1 - segment.t0, 0.0) if segment.x1 > acc[i] else 0.0

    @observables.register("time_above")
    @dataclass(frozen=True, kw_only=True)
    class TimeAbove(Observable):
        variables = {"time_above": Quantity("s", "t_a", "time above an angle")}
        step = staticmethod(_step)

        angle: float = quantity_field("initial_angle", Range(), default=1.0)
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

from latolato.core.errors import InputError
from latolato.core.quantities import Quantity
from latolato.core.registry import Registry, check_fields

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

observables: Registry[type] = Registry("observable")

# Numbers of the state of two balls: two angles and two angular velocities.
STATE_SIZE = 4


class Step(NamedTuple):
    """One accepted step of one ball: its ends, numbered 0 and 1.

    Times [s], angles [rad], angular velocities [rad/s], angular accelerations [rad/s^2], total
    energies over the moment of inertia [1/s^2] and their time derivatives [1/s^3]; `held` is 1 in
    sticking contact or where friction holds the ball, else 0; `turn` is the angle at which the
    velocity passes zero within the step, the angle at its end if it does not.
    """

    t0: float
    t1: float
    x0: float
    x1: float
    v0: float
    v1: float
    a0: float
    a1: float
    e0: float
    e1: float
    p0: float
    p1: float
    held: float
    turn: float


class Outcome(NamedTuple):
    """State, works and times of a ball at the end of a run.

    Works and losses [J] are those of the observed time, for both balls of a `BallPair`.
    """

    angle: float  # rad
    velocity: float  # rad/s
    observed_time: float  # time after the transient [s]
    inertia: float  # kg m^2
    drive_work: float
    damping_loss: float
    impact_loss: float
    capture_loss: float
    retension_loss: float
    compression_time: float  # time in which the rod was pushed [s]
    slack_time: float  # time in which the string was slack [s]
    first_slack: float  # when it was first slack in the observed time [s], NaN if never
    string_impulse: float  # the largest impulse of any string [N s]
    balls: int


@dataclass(frozen=True, kw_only=True)
class Observable:
    """Base of all observables; subclasses are final and registered by name.

    Attributes
    ----------
    variables : mapping of str to Quantity
        The variables of the dataset, in the order of their slots: one each, or as many as the
        further dimension is long, but always four for exponents.
    needs : set of str
        What costs extra: ``"energy"`` and ``"turn"`` of a `Step`, which sweeps find faster if
        you name them here, ``"works"``, ``"compression"``.
    start : formula ``(acc, i, n, angle)``
        Before the run; all slots behind the parameters are zero.
    step : formula ``(acc, i, n, segment)``
        After every step, and after a time at rest, which is one segment.
    contact : formula ``(acc, i, n, t, kind, before, after, closing)``
        At every row of the contact table; `closing` is the relative speed before.
    mark : formula ``(acc, i, n, number, t, angle, velocity)``
        At the instants that `marks` asks for.
    restart : formula ``(acc, i, n, angle, velocity)``
        When the transient ends; by default the slots keep their values.
    tangent : formula ``(acc, i, n, size, time, spread, jacobian)``
        After every step and event, with the matrix ``jacobian[row, column]`` by which it changes
        perturbations of the `size` numbers of the state (angle and angular velocity of the
        right, then of the left ball), the time that it took [s] and the logarithm of the
        determinant that the laws of motion give it. Columns 4 to 6 are free for scratch. It is
        called for the first ball only, and needs a contact law without a fixed step.
    finish : formula ``(acc, i, n, outcome)``
        At the end, with an `Outcome`; by default the variables' slots hold their values already.
    dimension : str
        A further dimension of the variables: ``sample`` (one for each mark), ``exponent`` (one for
        each number of the state) or none.
    angles : int
        How many angles the system must have; 0 for any number.
    plain : set of str
        The variables that do not have that dimension.
    mirrored : bool
        Whether it belongs to the mirror-symmetric motion of two equal balls; rounding is then
        kept from breaking the symmetry.
    of_strings : bool
        Whether the system must hang on strings.
    is_joint : bool
        Whether the variables belong to both balls of a pair together; those of the first count.
    """

    variables: ClassVar[Mapping[str, Quantity]] = {}
    needs: ClassVar[frozenset[str]] = frozenset()
    start: ClassVar[Callable[..., None] | None] = None
    step: ClassVar[Callable[..., None] | None] = None
    contact: ClassVar[Callable[..., None] | None] = None
    mark: ClassVar[Callable[..., None] | None] = None
    restart: ClassVar[Callable[..., None] | None] = None
    tangent: ClassVar[Callable[..., None] | None] = None
    finish: ClassVar[Callable[..., None] | None] = None
    dimension: ClassVar[str] = ""
    angles: ClassVar[int] = 0
    mirrored: ClassVar[bool] = False
    plain: ClassVar[frozenset[str]] = frozenset()
    of_strings: ClassVar[bool] = False
    is_joint: ClassVar[bool] = False

    def __post_init__(self) -> None:
        check_fields(self)
        for field in fields(self):
            value = getattr(self, field.name)
            if not isinstance(value, (bool, int, float)):
                raise InputError(
                    "must be a number, true or false: an observable keeps its parameters in slots",
                    parameter=field.name, value=value,
                )  # fmt: skip

    @property
    def marks(self) -> int:
        """How many ends of the last drive periods to mark."""
        return 0

    @property
    def memory(self) -> int:
        """Number of slots after the parameters, including those of the variables.

        The formulas must not use more; a sweep tries them out before it begins.
        """
        return 0

    @property
    def slots(self) -> int:
        """How many slots it owns: parameters, variables, and anything else it has to remember."""
        return len(self.parameters) + max(self.memory, sum(self.widths.values()))

    @property
    def parameters(self) -> list[float]:
        """The values of the fields as numbers, which the first slots hold."""
        return [float(getattr(self, field.name)) for field in fields(self)]

    @property
    def widths(self) -> dict[str, int]:
        """How many slots each variable has."""
        width = {"sample": self.marks, "exponent": STATE_SIZE}.get(self.dimension, 1)
        return {name: 1 if name in self.plain else width for name in self.variables}

    def check_memory(self) -> None:
        """Try all formulas out on a list that ends with the last slot.

        Raises
        ------
        InputError
            If one of them uses a slot beyond it.
        """
        import numpy as np

        acc = [*self.parameters, *[0.0] * (self.slots - len(self.parameters))]
        nothing, end = Step(*[0.0] * len(Step._fields)), Outcome._make([*[0.0] * 13, 1])
        calls: dict[str, tuple[Any, ...]] = {
            "start": (0.0,), "step": (nothing,), "contact": (0.0, 0, 0.0, 0.0, 0.0),
            "mark": (max(self.marks - 1, 0), 0.0, 0.0, 0.0), "restart": (0.0, 0.0),
            "tangent": (STATE_SIZE, 0.0, 0.0, np.eye(STATE_SIZE, 7)), "finish": (end,),
        }  # fmt: skip
        for name, given in calls.items():
            formula = getattr(self, name)
            try:
                if formula is not None:
                    formula(acc, 0, 1, *given)
            except IndexError:
                raise InputError(
                    f"{type(self).__name__}.{name} uses more than the {self.slots} slots of its "
                    "parameters and its `memory`: give it more"
                ) from None
            except (ArithmeticError, ValueError):
                pass  # of a run that lasts no time

    def read(self, contents: Floats, balls: int) -> dict[str, Floats]:
        """Return the variables of points of shape (point,), or (point, sample or exponent).

        Parameters
        ----------
        contents : ndarray, shape (slot, point)
            Of the slots, at the end of the runs.
        balls : int
            Angles of the state; there are twice as many exponents.
        """
        result, first = {}, len(self.parameters)
        for name, width in self.widths.items():
            rows = contents[first : first + width]
            first += width
            if not self.dimension or name in self.plain:
                result[name] = rows[0]
            else:
                result[name] = rows[: 2 * balls].T if self.dimension == "exponent" else rows.T
        return result
