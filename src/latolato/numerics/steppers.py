"""Symmetric splitting methods: kicks ``w += b h a(t, angle)`` between drifts with the exact drag.

Both methods are written kick first; their coefficients are palindromic, so they are symmetric in
time, and symplectic without drag.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Stepper:
    """Weights of a splitting method: ``stages + 1`` kicks around ``stages`` drifts.

    Attributes
    ----------
    order : int
        Declared order; the tests measure it.
    kicks, drifts, nodes : ndarray
        Shapes (stages + 1,), (stages,), (stages,); node i is the time after drift i.
    step_factor : float
        Step of equal error relative to `BLANES_MOAN_RKN`. Measured at equal steps: the error of
        `BLANES_MOAN_GENERAL` is 0.7 times as large in the median over the paper's map and 2 to
        13 times on growing and bouncing motions.
    """

    name: str
    order: int
    kicks: NDArray[np.float64]
    drifts: NDArray[np.float64]
    nodes: NDArray[np.float64]
    step_factor: float


def _palindrome(
    name: str, order: int, kicks: list[float], drifts: list[float], step_factor: float
) -> Stepper:
    """Return the method whose first kicks and drifts are given, up to the middle.

    The last given kick and drift are completed so that all add up to one.
    """
    stages = 2 * len(drifts) + (1 if len(drifts) == len(kicks) else 0)
    if len(drifts) == len(kicks):  # the middle is a drift
        b_last = 0.5 - sum(kicks)
        b = [*kicks, b_last]
        a = [*drifts, 1.0 - 2.0 * sum(drifts)]
        all_kicks = np.array(b + b[::-1])
        all_drifts = np.array(a + a[-2::-1])
    else:  # the middle is a kick
        a = [*drifts, 0.5 - sum(drifts)]
        b = [*kicks, 1.0 - 2.0 * sum(kicks)]
        stages = 2 * len(a)
        all_kicks = np.array(b + b[-2::-1])
        all_drifts = np.array(a + a[::-1])
    nodes = np.cumsum(all_drifts)
    nodes[-1] = 1.0
    if len(all_drifts) != stages or len(all_kicks) != stages + 1:
        raise AssertionError(name)
    return Stepper(name, order, all_kicks, all_drifts, nodes, step_factor)


# Blanes & Moan, J. Comput. Appl. Math. 142 (2002) 313, Table 3: SRKN 11, order 6, type b.
BLANES_MOAN_RKN = _palindrome(
    "SRKN 11 b",
    6,
    [0.0414649985182624, 0.198128671918067, -0.0400061921041533, 0.0752539843015807,
     -0.0115113874206879],
    [0.123229775946271, 0.290553797799558, -0.127049212625417, -0.246331761062075,
     0.357208872795928],
    1.0,
)  # fmt: skip

# The same paper, Table 2: S 10, order 6 for any two flows, with kicks and drifts exchanged.
# Nonlinear drag needs it: the Runge-Kutta-Nystrom method keeps order 6 for the motion but not
# for the works, whose triple commutator with the drag does not vanish.
BLANES_MOAN_GENERAL = _palindrome(
    "S 10",
    6,
    [0.0502627644003922, 0.413514300428344, 0.0450798897943977, -0.188054853819569,
     0.541960678450780],
    [0.148816447901042, -0.132385865767784, 0.067307604692185, 0.432666402578175],
    0.7,
)  # fmt: skip
