"""Impacts in lanes, located on the step itself, together.

The quintic through both ends of a step gives the share of it at which a wall is met, a step of that
share is taken, and what is missing to the wall is a short glide.
"""

from __future__ import annotations

from collections.abc import Callable

from latolato.core.scalar import cosine, formula
from latolato.numerics import lane_rows as r
from latolato.numerics.parts import Part
from latolato.numerics.pointers import array_at
from latolato.numerics.records import Floats

# An impact is corrected along the parabola over this share of a step, times its squared angle;
# the velocity's error is then about 1e-3 of the tolerance.
EXTENDABLE = 2.4e-4
_MOST_LANDINGS = 4
_MOST_TRIALS = 5

# The largest drag per step that `reach_series` is good for.
MOST_DRAG = 0.5


@formula
def reach_series(x: float) -> float:
    """Return (1 - exp(-x))/x for |x| < 0.2, to 1e-15; without branches, for vectors."""
    total = 1.0
    for n in range(11, 1, -1):
        total = 1.0 - x / n * total
    return total


def make_lane_locate(
    restoring: Callable[..., float], part: Part, *, damped: bool, works: bool
) -> Callable[..., None]:
    """Return the kernel that corrects each share of a step until a short glide is left.

    `DONE` is then 1, or not if the impact is no ordinary one.
    """
    numbers_at = array_at()

    @part
    def solve_quintics(z: Floats) -> None:
        """Find the shares of the step at which the quintics through both ends meet the walls.

        A ball that starts on the wall meets it again where the quintic over the share vanishes.
        """
        E = r.IMPACTS
        for e in range(E):
            d = z[r.IX1 * E + e] - z[r.IX0 * E + e]
            b1, c1 = z[r.IV0 * E + e], 0.5 * z[r.IA0 * E + e]
            r0, r1 = d - b1 - c1, z[r.IV1 * E + e] - b1 - 2.0 * c1
            r2 = 0.5 * z[r.IA1 * E + e] - c1
            z[r.IB * E + e], z[r.IC2 * E + e] = b1, c1
            z[r.IC3 * E + e] = 10.0 * r0 - 4.0 * r1 + r2
            z[r.IC4 * E + e] = -15.0 * r0 + 7.0 * r1 - 2.0 * r2
            z[r.IC5 * E + e] = 6.0 * r0 - 3.0 * r1 + r2
            gap = z[r.IWALL * E + e] - z[r.IX0 * E + e]
            on_wall = -2.0 * b1 / (z[r.IA0 * E + e] if z[r.IA0 * E + e] != 0.0 else 1.0)
            guess = on_wall if gap == 0.0 else gap / d
            z[r.ILOW * E + e], z[r.IHIGH * E + e] = 0.0, 1.0
            z[r.IU * E + e] = guess if (guess > 0.0) & (guess < 1.0) else 0.5
        for _ in range(_MOST_TRIALS):
            for e in range(E):
                u, far = z[r.IU * E + e], z[r.IFAR * E + e]
                c2, c3, c4 = z[r.IC2 * E + e], z[r.IC3 * E + e], z[r.IC4 * E + e]
                c5, b1 = z[r.IC5 * E + e], z[r.IB * E + e]
                gap = z[r.IWALL * E + e] - z[r.IX0 * E + e]
                q = b1 + u * (c2 + u * (c3 + u * (c4 + u * c5)))
                dq = c2 + u * (2.0 * c3 + u * (3.0 * c4 + u * 4.0 * c5))
                on_wall = gap == 0.0
                value = q if on_wall else u * q - gap
                slope = dq if on_wall else q + u * dq
                beyond = value * far >= 0.0
                low = z[r.ILOW * E + e] if beyond else u
                high = u if beyond else z[r.IHIGH * E + e]
                trial = u - value / (slope if slope != 0.0 else 1.0)
                inside = (trial >= low) & (trial <= high)
                z[r.ILOW * E + e], z[r.IHIGH * E + e] = low, high
                z[r.IU * E + e] = trial if inside else 0.5 * (low + high)

    @part
    def fly_to_shares(z: Floats, kicks: Floats, drifts: Floats, nodes: Floats, stages: int) -> None:
        """Take from every start the step of the share that was found."""
        E = r.IMPACTS
        for e in range(E):
            z[r.IX * E + e], z[r.IV * E + e] = z[r.IX0 * E + e], z[r.IV0 * E + e]
            z[r.IS * E + e] = restoring(z[r.IX0 * E + e])
            driven = z[r.ISCALE * E + e] * cosine(z[r.IPHASE * E + e])
            z[r.IDRIVEN * E + e] = driven
            z[r.IWORK * E + e] = 0.0
            z[r.ILOSS * E + e] = 0.0
        for i in range(stages):
            b, a, c = kicks[i], drifts[i], nodes[i]
            for e in range(E):
                u = z[r.IU * E + e]
                s, driven = z[r.IS * E + e], z[r.IDRIVEN * E + e]
                v = z[r.IV * E + e]
                change = b * u * (z[r.IG * E + e] + driven) * s
                if works:
                    z[r.IWORK * E + e] += b * u * driven * s * (v + 0.5 * change)
                v += change
                reach = a * u
                slower = v
                if damped:
                    reach *= reach_series(z[r.IDRAG * E + e] * reach)
                    slower = v - v * (z[r.IDRAG * E + e] * reach)
                    if works:
                        z[r.ILOSS * E + e] += 0.5 * (v - slower) * (v + slower)
                x = z[r.IX * E + e] + v * reach
                z[r.IX * E + e], z[r.IV * E + e] = x, slower
                z[r.IS * E + e] = restoring(x)
                turn = z[r.IPHASE * E + e] + z[r.ITURN * E + e] * (c * u)
                z[r.IDRIVEN * E + e] = z[r.ISCALE * E + e] * cosine(turn)
        b = kicks[stages]
        for e in range(E):
            driven, s, v = z[r.IDRIVEN * E + e], z[r.IS * E + e], z[r.IV * E + e]
            u = z[r.IU * E + e]
            force = (z[r.IG * E + e] + driven) * s
            change = b * u * force
            if works:
                z[r.IWORK * E + e] += b * u * driven * s * (v + 0.5 * change)
            z[r.IV * E + e] = v + change
            z[r.IF * E + e] = force

    def locate(
        impacts: int, kick_weights: int, drift_weights: int, nodes_at: int, stages: int
    ) -> None:
        E, z = r.IMPACTS, numbers_at(impacts, r.IMPACT_ROWS * r.IMPACTS)
        kicks, drifts = numbers_at(kick_weights, stages + 1), numbers_at(drift_weights, stages)
        nodes = numbers_at(nodes_at, stages)
        solve_quintics(z)
        for e in range(E):
            z[r.DONE * E + e] = 0.0
        for _ in range(_MOST_LANDINGS):
            fly_to_shares(z, kicks, drifts, nodes, stages)
            rest = 0.0
            for e in range(E):
                v, far, u = z[r.IV * E + e], z[r.IFAR * E + e], z[r.IU * E + e]
                a = z[r.IF * E + e] - z[r.IDRAG * E + e] * v
                comes = v * far > 0.0
                missing = (z[r.IWALL * E + e] - z[r.IX * E + e]) / (v if comes else 1.0)
                missing -= 0.5 * a * missing * missing / (v if comes else 1.0)
                z[r.IMISS * E + e] = missing
                lands = comes & (abs(missing) <= z[r.INEAR * E + e])
                moved = u + missing
                moves = comes & (not lands) & (moved > 0.0) & (moved < 1.0)
                z[r.IU * E + e] = moved if moves else u
                z[r.DONE * E + e] = 1.0 if lands else 0.0
                rest += 1.0 if moves else 0.0
            if rest == 0.0:
                return

    return locate
