"""Basins of attraction: which starts lead to which motion, found without naming any of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from latolato.analysis.checks import (
    AngleTolerance,
    LongestPeriod,
    TransientPeriods,
    check_span,
    checked_periodic,
)
from latolato.analysis.registry import analyses, labelled, note, warn
from latolato.analysis.rules import broken_analysis, said
from latolato.analysis.stroboscopic import QUANTITIES_HERE, settled_motion, wilson_interval
from latolato.core.errors import InputError
from latolato.core.quantities import Quantity, Range
from latolato.core.registry import checked_count
from latolato.observables.period import wrapped
from latolato.physics.drives import Drive
from latolato.physics.pendulum import BallPair, System
from latolato.simulation.start import DEFAULT_REST_SPEED, checked_contact, walls_of

if TYPE_CHECKING:
    import xarray as xr

    Floats = NDArray[np.float64]
    Labels = NDArray[np.int64]

# The label of starts whose motion was not assigned to an attractor.
UNRESOLVED = -1
# More attractors than this are not distinguished: the rest stays unresolved.
_MOST_ATTRACTORS = 200
# Aperiodic motions of fewer starts than this share of all count as unresolved.
_FEWEST_CHAOTIC = 0.002
# So do those of fewer starts than this share of what has not settled: the last of the same motion.
_TAIL = 0.1
_MOST_STARTS = 4_000_000
# Default range of initial angular velocities in natural frequencies, about the separatrix.
_SPEEDS = 3.0
# Attractors of two maps farther apart than this on average are not the same [rad].
_NEAREST = 0.5
# A wall is approached from inside by this much [rad].
_INSIDE = 1e-9
_OF_ATTRACTORS = ("response_period", "rotation_number", "mirror_residual", "largest_angle_watched")


@analyses.register("basins", checked_periodic)
def basins(
    system: System,
    drive: Drive | None = None,
    *,
    angle_low: Annotated[float | None, "rad"] = None,
    angle_high: Annotated[float | None, "rad"] = None,
    angle_points: int = 100,
    velocity_low: Annotated[float | None, "rad/s"] = None,
    velocity_high: Annotated[float | None, "rad/s"] = None,
    velocity_points: int = 100,
    asymmetry: Annotated[float, "rad"] = 0.0,
    transient_periods: TransientPeriods = 500.0,
    longest: LongestPeriod = 16,
    angle_tolerance: AngleTolerance = 1e-4,
    match_tolerance: AngleTolerance = 0.01,
    chaos_box: AngleTolerance = 0.1,
    entropy_box: int = 5,
    tolerance: float = 1e-6,
    check_tolerance: Annotated[float | None, "rad", Range(1e-15, 1e-2)] = None,
    rest_speed: float = DEFAULT_REST_SPEED,
    known: xr.Dataset | None = None,
) -> xr.Dataset:
    """Return which attractor each start leads to, the attractors, their shares [1] and entropies.

    ``basins_of_attraction`` and ``basins_fractions`` of Attractors.jl (Datseris & Wagemakers,
    2022); basin entropy by Daza et al. (2016).

    Parameters
    ----------
    system, drive
        The laws; the drive must have one period (harmonic or crank slider).
    angle_low, angle_high : float, optional
        Range of initial angles [rad]; by default between the walls, or -pi to pi without.
    angle_points : int
        Initial angles in that range.
    velocity_low, velocity_high : float, optional
        Range of initial angular velocities [rad/s]; by default -3 w0 to 3 w0.
    velocity_points : int
        Initial angular velocities in that range.
    asymmetry : float
        Of two balls, the left one starts at minus the right one's angle minus this [rad], and at
        minus its angular velocity.
    transient_periods : float
        Drive periods before the motion is watched, at least 0.
    longest : int
        Longest response period that is distinguished from chaos, 1 to 64 drive periods.
    angle_tolerance : float
        Distance below which two samples of one motion agree [rad], in (0, 1].
    match_tolerance : float
        Distance below which two motions are one [rad], in (0, 1].
    chaos_box : float
        Aperiodic motions that visit a common box of this size [rad] are one, in (0, 1].
    entropy_box : int
        Starts along each side of the boxes of the basin entropy.
    check_tolerance : float, optional
        Smaller tolerance at which every start is run once more [rad]; by default a tenth.
    known : xarray.Dataset, optional
        A former result, for a series of maps: an attractor near one of its attractors gets the
        same number, and so the same colour.
    tolerance, rest_speed
        As for `latolato.simulate`.

    Returns
    -------
    xarray.Dataset
        ``basin`` over (initial_angle, initial_angular_velocity): the number of the attractor, and
        -1 where none was assigned; ``uncertain``: 1 where `check_tolerance` leads to another
        attractor or to none, and ``uncertain_fraction``, the share of such starts. The attractor
        with the largest basin is number 0, unless `known` numbers it. Over ``attractor``:
        ``status`` ("rest", "periodic", "grazing", "aperiodic"), ``response_period``,
        ``rotation_number``, ``mirror_residual``, ``largest_angle_watched``, as in
        `response_period`, the ``basin_fraction`` [1] with the ends of its 95 % interval, and over
        ``sample`` the ``section_angle`` and ``section_angular_velocity`` of one motion
        on it. ``unresolved_fraction``, the share of starts without an attractor, of which
        ``not_settled_fraction`` were still on their way; ``basin_entropy``,
        ``boundary_basin_entropy`` [1].

    Raises
    ------
    InputError
        For bad input, ranges beyond the walls, a drive without a period, the linearised pendulum.

    Notes
    -----
    All starts are watched at the same drive phases. Periodic motions are one if their samples,
    ``(angle modulo 2 pi, angular velocity/w)``, agree within `match_tolerance` after a shift by
    whole drive periods. Aperiodic motions are one if their samples share a box of size
    `chaos_box`, directly or through others, as in recurrences on a grid. Motions of mirror
    symmetric partners are two attractors. Fractions are of the starts on the grid, which is
    centred in its cells; their intervals (Wilson, 1927) are those of as many starts drawn at
    random, and too wide for smooth basins.

    On a fractal boundary, or after a long chaotic transient, the attractor of a start depends on
    the numerical error. No tolerance settles such a start: its label is one of several that
    are possible, and only the shares mean something. The second run finds these starts; as it
    takes shorter steps, both take about 2.3 times as long as the first. Equal basins
    are numbered by rotation number, then by mean angle; so are those of two motions that are
    mirror images of each other, whose shares differ by such starts only. With `known` the pairs
    of attractors with the smallest mean distance between their samples are matched first, up to
    0.5 rad, as ``match_statespacesets!`` of Attractors.jl does; a number that has vanished is not
    given again.

    What it can miss: attractors whose basins are smaller than the grid's spacing or outside the
    range; motions still on their way after the transient. Those that die down, or have a period
    after twice the transient, are "not settled" and belong to no attractor, by a rule of thumb that
    also takes some chaos in bursts for that (see `response_period`) and so makes its basin smaller;
    chaos that ends later counts as chaos. Chaotic attractors that come nearer
    to each other than `chaos_box` are taken as one, and two periodic ones nearer than
    `match_tolerance`. Aperiodic motion of fewer than 0.2 % of the starts, or of fewer than
    a tenth of those that have not settled, is left unresolved.
    Two balls have four initial numbers, of which this is a plane.

    Examples
    --------
    >>> import latolato as ll
    >>> system = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    >>> drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.26)
    >>> result = basins(
    ...     system, drive, angle_points=6, velocity_points=6, velocity_low=-3.0, velocity_high=3.0
    ... )
    >>> result.status.values, result.basin_fraction.values, result.basin_entropy.item()
    (array(['periodic'], dtype='<U12'), array([1.]), 0.0)
    """
    drive = checked_periodic(system, drive)
    shape = (angle_points, velocity_points)
    if entropy_box > min(shape):
        raise broken_analysis(
            "entropy_box", {"points": min(shape)}, parameter="entropy_box", value=entropy_box
        )
    if math.prod(shape) > _MOST_STARTS:
        raise broken_analysis("most_starts", {"count": math.prod(shape), "limit": _MOST_STARTS})
    check_tolerance = _checked_finer(check_tolerance, tolerance)
    if known is not None:
        _check_known(known, system)
    angles, velocities = _starts(
        system, shape, (angle_low, angle_high), (velocity_low, velocity_high)
    )

    def look(error: float) -> dict[str, NDArray[Any]]:
        return settled_motion(
            system,
            drive,
            _axes(system, angles, velocities, asymmetry),
            drive.drive_frequency,
            longest=longest,
            angle_tolerance=angle_tolerance,
            transient_periods=transient_periods,
            tolerance=error,
            rest_speed=rest_speed,
        )

    motion, checked = look(tolerance), look(check_tolerance)
    samples = _samples(motion, system.angles, drive.drive_frequency)
    both, examples = find_attractors(
        np.concatenate([samples, _samples(checked, system.angles, drive.drive_frequency)]),
        np.concatenate([motion["response_period"], checked["response_period"]]),
        np.concatenate([motion["status"], checked["status"]]),
        match_tolerance=match_tolerance,
        chaos_box=chaos_box,
    )
    count = len(samples)
    examples, numbers, used, place = _numbered(
        samples, motion["rotation_number"], both[:count], examples, chaos_box, known
    )
    labels, others = place[both[:count]], place[both[count:]]
    uncertain = (labels != others).reshape(shape)
    doubt = None
    if uncertain.any():
        share = 100.0 * float(uncertain.mean())
        doubt = said("uncertain_basins", percent=share, tolerance=check_tolerance)
    unsettled = float((motion["status"] == "not settled").mean())
    if unsettled > 0.0:
        warn("unsettled_starts", percent=100.0 * unsettled, periods=transient_periods)
    table = np.append(numbers, UNRESOLVED)[labels].reshape(shape)
    places = ("initial_angle", "initial_angular_velocity")
    variables: dict[str, Any] = {
        "basin": (places, table),
        "uncertain": (places, uncertain.astype(np.int8)),
        **_of_attractors(motion, examples, labels, system.angles),
        "unresolved_fraction": float((labels == UNRESOLVED).mean()),
        "not_settled_fraction": unsettled,
        "uncertain_fraction": float(uncertain.mean()),
        **basin_entropy(table, entropy_box)._asdict(),
    }
    return labelled(
        variables,
        system=system,
        drive=drive,
        coordinates={
            "initial_angle": angles,
            "initial_angular_velocity": velocities,
            "attractor": numbers,
        },
        quantities=QUANTITIES_HERE | _QUANTITIES,
        settings={
            "check_tolerance": check_tolerance,
            "numbers_used": used,
            "message": note(doubt),
        },
    )


def _of_attractors(
    motion: Mapping[str, NDArray[Any]], examples: Labels, labels: Labels, balls: int
) -> dict[str, Any]:
    """Return the variables over the attractors: their motion and the shares of the starts."""
    counts = np.bincount(labels[labels >= 0], minlength=len(examples))
    share, low, high = wilson_interval(counts, labels.size)
    dims = ("attractor", "ball", "sample") if balls == 2 else ("attractor", "sample")
    return {
        **{name: ("attractor", motion[name][examples]) for name in (*_OF_ATTRACTORS, "status")},
        "basin_fraction": ("attractor", share),
        "basin_fraction_low": ("attractor", low),
        "basin_fraction_high": ("attractor", high),
        "section_angle": (dims, wrapped(motion["section_angle"][examples])),
        "section_angular_velocity": (dims, motion["section_angular_velocity"][examples]),
    }


_QUANTITIES: dict[str, Quantity] = {
    "basin": Quantity("1", "", "number of the attractor (-1 unresolved)"),
    "attractor": Quantity("1", "", "attractor"),
    "basin_fraction": Quantity("1", "F", "share of the starts"),
    "basin_fraction_low": Quantity("1", "", "share of the starts, low end"),
    "basin_fraction_high": Quantity("1", "", "share of the starts, high end"),
    "uncertain": Quantity("1", "", "whether the basin changes with the tolerance"),
    "uncertain_fraction": Quantity(
        "1", "F_u", "share of starts whose basin changes with tolerance"
    ),
    "unresolved_fraction": Quantity("1", "", "share of starts without attractor"),
    "not_settled_fraction": Quantity("1", "", "share of starts whose motion has not settled"),
    "basin_entropy": Quantity("1", "S_b", "basin entropy"),
    "boundary_basin_entropy": Quantity("1", "S_{bb}", "boundary basin entropy"),
    "boundary_share": Quantity("1", "", "share of boxes on a boundary"),
}


def _checked_finer(finer: float | None, tolerance: float) -> float:
    """Return the tolerance of the second run [rad]."""
    if finer is None:
        return max(0.1 * tolerance, 1e-15)
    if not finer < tolerance:
        raise broken_analysis(
            "finer_tolerance", {"tolerance": tolerance}, parameter="check_tolerance", value=finer
        )
    return finer


def _check_known(known: Any, system: System) -> None:
    """Raise if attractors cannot be compared with those of a former result."""
    attributes = getattr(known, "attrs", {})
    if attributes.get("analysis") != "basins":
        raise InputError(
            "must be a result of basins",
            parameter="known",
            value=type(known).__name__,
            way_out="give the dataset of a former map",
        )
    balls = known.sizes.get("ball", 1)
    if balls != system.angles:
        raise InputError(
            f"must be of a system with as many balls, not of {balls} instead of {system.angles}",
            parameter="known",
            way_out="give a map of the same kind of system",
        )


def _numbered(
    samples: Floats,
    rotation: Floats,
    labels: Labels,
    examples: Labels,
    chaos_box: float,
    known: xr.Dataset | None,
) -> tuple[Labels, Labels, int, Labels]:
    """Return the attractors in order: an example of each, its number, and how many are used.

    Also the place of each label in that order. Attractors without an example among the samples,
    which only the second run finds, have none: they make its starts differ.
    """
    shares = np.bincount(labels[labels >= 0], minlength=len(examples))
    own = np.flatnonzero((shares > 0) & (examples < len(samples)))
    states = samples[examples[own]]
    sizes = shares[own] + shares[own][_mirror_partners(states, chaos_box)]
    angles = states[:, :, 0].mean(axis=1).round(6)
    order = own[np.lexsort([angles, rotation[examples[own]], -sizes])]
    numbers, used = np.arange(len(order)), len(order)
    if known is not None:
        numbers, used = _known_numbers(samples[examples[order]], known)
        order, numbers = order[np.argsort(numbers)], np.sort(numbers)
    place = np.full(max(len(shares), 1) + 1, UNRESOLVED)  # the last is what -1 reads
    place[order] = np.arange(len(order))
    return examples[order], numbers, used, place


def _mirror_partners(samples: Floats, most: float) -> Labels:
    """Return the attractor that is the mirror image of each, up to `most` [rad]; else itself.

    Two such basins are equally large, but for starts whose fate is a matter of rounding.
    """
    # Angles and velocities change sign, and two balls change places.
    parts = samples.reshape(*samples.shape[:2], 2, samples.shape[2] // 2)
    mirrored = -parts[..., ::-1].reshape(samples.shape)
    apart = np.array([[_apart(one, other) for other in mirrored] for one in samples])
    itself = np.arange(len(samples))
    if not len(samples):
        return itself
    nearest = apart.argmin(axis=1)
    is_mutual = (nearest[nearest] == itself) & (apart.min(axis=1) <= most)
    return np.where(is_mutual, nearest, itself)


def _known_numbers(samples: Floats, known: xr.Dataset) -> tuple[Labels, int]:
    """Return the number of each attractor, that of the nearest known one, and how many are used."""
    old = _samples(known, known.sizes.get("ball", 1), float(known.attrs["drive_frequency"]))
    names = known["attractor"].values
    apart = np.array([[_apart(one, other) for other in old] for one in samples])
    apart = apart.reshape(len(samples), len(old))
    numbers = np.full(len(samples), UNRESOLVED, dtype=np.int64)
    while apart.size and apart.min() <= _NEAREST:
        new, former = np.unravel_index(int(apart.argmin()), apart.shape)
        numbers[new] = names[former]
        apart[new], apart[:, former] = math.inf, math.inf
    used = int(known.attrs["numbers_used"])
    fresh = numbers == UNRESOLVED
    numbers[fresh] = used + np.arange(fresh.sum())
    return numbers, used + int(fresh.sum())


def _apart(one: Floats, other: Floats) -> float:
    """Return the mean distance of the samples of two motions to the nearest of the other [rad]."""
    gap = one[:, None] - other[None]
    half = gap.shape[2] // 2
    gap[..., :half] = wrapped(gap[..., :half])
    distance = np.sqrt((gap**2).sum(axis=2))
    return float(max(distance.min(axis=0).mean(), distance.min(axis=1).mean()))


def _starts(
    system: System, shape: tuple[int, int], angles: tuple[Any, Any], velocities: tuple[Any, Any]
) -> tuple[Floats, Floats]:
    """Return the initial angles [rad] and angular velocities [rad/s], centred in their cells."""
    low, high = walls_of(system, checked_contact("exact", system))
    if isinstance(system, BallPair):  # of balls that start as mirror images
        low, high = 0.5 * low, 0.5 * high
    least, most = (low, high) if math.isfinite(low) else (-math.pi, math.pi)
    w0 = system.natural_frequency
    first = least if angles[0] is None else angles[0]
    last = most if angles[1] is None else angles[1]
    check_span(first, last, "angle_")
    if first < low - _INSIDE or last > high + _INSIDE:
        raise broken_analysis(
            "angles_between_walls", {"low": low, "high": high, "first": first, "last": last}
        )
    slow = -_SPEEDS * w0 if velocities[0] is None else velocities[0]
    fast = _SPEEDS * w0 if velocities[1] is None else velocities[1]
    check_span(slow, fast, "velocity_")

    def centres(start: float, end: float, count: int) -> Floats:
        return start + (np.arange(count) + 0.5) * (end - start) / count

    return centres(first, last, shape[0]), centres(slow, fast, shape[1])


def _axes(system: System, angles: Floats, velocities: Floats, shift: float) -> dict[str, Any]:
    """Return the axes of the sweep over starts."""
    if system.angles == 1:
        return {"initial_angle": angles, "initial_angular_velocity": velocities}
    return {
        "start_angle": {"initial_angle_right": angles, "initial_angle_left": -angles - shift},
        "start_velocity": {
            "initial_angular_velocity_right": velocities,
            "initial_angular_velocity_left": -velocities,
        },
    }


def _samples(motion: Mapping[Any, Any], balls: int, frequency: float) -> Floats:
    """Return the samples as angles, shape (start, sample, 2 per ball): angle, velocity over w."""
    parts = []
    for name, scale in (("angle", 1.0), ("angular_velocity", 1.0 / frequency)):
        values = np.asarray(motion[f"section_{name}"]) * scale
        parts.append(values.reshape(-1, balls, values.shape[-1]))
    return np.concatenate(parts, axis=1).transpose(0, 2, 1)


def find_attractors(
    samples: Floats,
    period: Floats,
    status: NDArray[Any],
    *,
    match_tolerance: float,
    chaos_box: float,
) -> tuple[Labels, Labels]:
    """Return the attractor of each start, largest basin first, and a start that leads to each.

    Parameters
    ----------
    samples : ndarray, shape (start, sample, component)
        Stroboscopic states [rad]; the first half of the components are angles, modulo 2 pi.
    period, status : ndarray, shape (start,)
        As in `latolato.analysis.response_period`.
    """
    raw = np.full(len(samples), UNRESOLVED, dtype=np.int64)
    regular = np.isin(status, ["rest", "periodic", "grazing"])
    examples: list[int] = []
    while len(examples) < _MOST_ATTRACTORS:
        left = np.flatnonzero(regular & (raw == UNRESOLVED))
        if not left.size:
            break
        template = int(left[0])
        cycle = int(period[template])
        same = _closest(samples[left], samples[template], cycle) <= match_tolerance
        same[0] = True
        raw[left[same]] = len(examples)
        examples.append(template)
    chaotic = np.flatnonzero(status == "aperiodic")
    settling = np.count_nonzero(status == "not settled")
    fewest = max(2.0, _FEWEST_CHAOTIC * len(samples), _TAIL * settling)
    for part in _overlapping(samples[chaotic], chaos_box):
        if len(part) < fewest and len(part) < len(samples):
            continue
        raw[chaotic[part]] = len(examples)
        examples.append(int(chaotic[part[0]]))
    counts = np.bincount(raw[raw >= 0], minlength=len(examples))
    order = np.argsort(-counts, kind="stable")
    rank = np.empty(len(order) + 1, dtype=np.int64)
    rank[order], rank[-1] = np.arange(len(order)), UNRESOLVED  # raw -1 reads the last
    return rank[raw], np.array(examples, dtype=np.int64)[order]


def _closest(samples: Floats, template: Floats, cycle: int) -> Floats:
    """Return the largest distance of each motion from a template at the best shift [rad]."""
    half = samples.shape[2] // 2
    # As many samples as remain after the largest shift.
    window = samples.shape[1] - cycle + 1
    best = np.full(len(samples), math.inf)
    for shift in range(cycle):
        apart = samples[:, :window] - template[shift : shift + window]
        apart[..., :half] = wrapped(apart[..., :half])
        best = np.minimum(best, abs(apart).max(axis=(1, 2)))
    return best


def _overlapping(samples: Floats, box: float) -> list[Labels]:
    """Return groups of motions that visit common boxes, directly or through others."""
    if not len(samples):
        return []
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    half = samples.shape[2] // 2
    places = samples.copy()
    places[..., :half] %= math.tau
    cells = np.floor(places / box).astype(np.int64).reshape(-1, samples.shape[2])
    _, visited = np.unique(cells, axis=0, return_inverse=True)
    visited = visited.ravel()
    motions = np.repeat(np.arange(len(samples)), samples.shape[1])
    # A graph of motions and boxes.
    size = len(samples) + int(visited.max()) + 1
    ones = np.ones(len(motions), dtype=np.int8)
    graph = coo_array((ones, (motions, len(samples) + visited)), shape=(size, size))
    _, group = connected_components(graph, directed=False)
    group = group[: len(samples)]
    return [np.flatnonzero(group == number) for number in np.unique(group)]


class BasinEntropy(NamedTuple):
    """Uncertainty of the final state within small boxes of starts.

    Attributes
    ----------
    basin_entropy : float
        Mean Gibbs entropy of all boxes [1].
    boundary_basin_entropy : float
        Mean over the boxes with more than one basin [1]; above ln 2 the boundary is fractal.
    boundary_share : float
        Share of such boxes [1].

    Examples
    --------
    Of four boxes two have one basin each, and two lie on the border:

    >>> import numpy as np
    >>> halves = np.zeros((10, 10), dtype=int)
    >>> halves[:, 7:] = 1
    >>> basin_entropy(halves, 5).boundary_share
    0.5
    """

    basin_entropy: float
    boundary_basin_entropy: float
    boundary_share: float


def basin_entropy(labels: Any, box: int = 5) -> BasinEntropy:
    """Return basin entropy and boundary basin entropy of a map of labels [1].

    Daza, Wagemakers, Georgeot, Guery-Odelin & Sanjuan (2016), Sci. Rep. 6, 31416, eqs. 3 and 6.

    Parameters
    ----------
    labels : array_like of int, shape (rows, columns)
        The attractor of each start; negative ones are left out.
    box : int
        Starts along each side of a box; rows and columns that fill no box are left out.

    Returns
    -------
    BasinEntropy
        NaN where no box has a label.

    Raises
    ------
    InputError
        For labels that are not a map, or a box larger than it.

    Notes
    -----
    ``S = -sum p ln p`` of each box with the shares p of its labels, ``S_b`` the mean over boxes,
    ``S_bb`` the mean over boxes with two labels and more (0 if there is none). ``S_bb > ln 2`` is
    sufficient for a fractal boundary if boxes are small and well filled, not necessary.

    Examples
    --------
    >>> import numpy as np
    >>> halves = np.zeros((10, 10), dtype=int)
    >>> halves[:, 2:] = 1
    >>> print(f"{basin_entropy(halves, 5).boundary_basin_entropy:.4f}")
    0.6730
    """
    table = np.asarray(labels)
    size = checked_count("box", box)
    if table.ndim != 2 or table.dtype.kind not in "iu":
        raise InputError(
            f"must be whole numbers in two dimensions, got shape {table.shape}", parameter="labels"
        )
    rows, columns = (n // size for n in table.shape)
    if not rows * columns:
        raise InputError(
            f"must fit into the map of {table.shape}",
            parameter="box",
            value=size,
            way_out="take a smaller",
        )
    whole = table[: rows * size, : columns * size].reshape(rows, size, columns, size)
    boxes = whole.transpose(0, 2, 1, 3).reshape(rows * columns, size * size)
    entropy = np.zeros(len(boxes))
    known = (boxes >= 0).sum(axis=1)
    kinds = np.zeros(len(boxes), dtype=np.int64)
    for label in np.unique(boxes[boxes >= 0]):
        count = (boxes == label).sum(axis=1)
        share = count / np.maximum(known, 1)
        entropy -= np.where(count > 0, share * np.log(np.where(count > 0, share, 1.0)), 0.0)
        kinds += count > 0
    if not (known > 0).any():
        return BasinEntropy(math.nan, math.nan, math.nan)
    entropy, kinds = entropy[known > 0], kinds[known > 0]
    mixed = kinds > 1
    border = float(entropy[mixed].mean()) if mixed.any() else 0.0
    return BasinEntropy(float(abs(entropy.mean())), border, float(mixed.mean()))
