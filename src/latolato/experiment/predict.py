"""What a trial will do, given draws of what is not known: the probability of each class."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np

from latolato.analysis.stroboscopic import wilson_interval
from latolato.core.errors import InputError
from latolato.core.quantities import Range
from latolato.core.registry import checked_count
from latolato.experiment.fits.result import Fit
from latolato.experiment.trial_table import CLASSES
from latolato.observables.angles import MotionClass
from latolato.physics.drives import Drive, FixedPivot
from latolato.physics.noise import SEEDS
from latolato.physics.pendulum import System
from latolato.simulation.vary import parameters_of
from latolato.sweeps import sweep
from latolato.sweeps.chunk import STATUS
from latolato.sweeps.statuses import has_answer

if TYPE_CHECKING:
    import xarray as xr

# The axis of the draws.
_DRAW = "draw"
# Shares of runs without an end beyond which a probability is not stated.
_MOST_LOST = 0.02


def predict(
    posterior: Fit,
    drive: Drive | None = None,
    *,
    axes: Mapping[str, Any] | None = None,
    system: System | None = None,
    duration: Annotated[float, "s"] = 300.0,
    transient: Annotated[float, "s"] = 240.0,
    draws: Annotated[int, Range(20)] = 200,
    seed: int = 0,
    **options: Any,
) -> xr.Dataset:
    """Return the probability that a trial is strong, weak or neither, given a posterior.

    Each draw of the posterior is a system as the samples allow it. All of them are run under the
    drive, and the share that ends in each class of the paper is its probability. The class of two
    balls is that of the stronger motion.

    Parameters
    ----------
    posterior : Fit
        What `fit_posterior` returned.
    drive : Drive, optional
        How the pivot will move; by default the drive of the posterior, with what is not known of
        it.
    axes : mapping, optional
        Parameters over which the probability is a map, as in `sweep`.
    system : System, optional
        What will move, if it differs from what was measured in more than the unknown parameters.
    duration : float
        End of a trial [s].
    transient : float
        Time after which a weak motion must still be there [s].
    draws : int
        How many draws of the posterior are run, spread over all chains.
    seed : int
        Of their choice.
    **options
        Further ones of `sweep`: the start (``initial_offset``), ``tolerance``, ``executor``.

    Returns
    -------
    xarray.Dataset
        `probability_none`, `probability_weak` and `probability_strong` over the axes, each with
        the ends of the 95 percent interval that the number of draws leaves (``_low`` and
        ``_high``, by Wilson), and a sentence as the attribute ``verdict`` if there are no axes.

    Raises
    ------
    InputError
        If the posterior is none, or is not a result; if a drive is missing, an axis is one of the
        unknown parameters, or runs do not end.

    Notes
    -----
    The probability is about what the samples leave open. It takes the model for true, and the start
    for the one that is given.
    """
    import xarray as xr

    known = _draws_of(posterior)
    count = checked_count("draws", draws, Range(20))
    body = system if system is not None else posterior.system
    motion: Any = drive if drive is not None else posterior.drive
    if body is None:
        raise InputError("the posterior holds no system", way_out="give it as system")
    if motion is None:
        if posterior.dataset.attrs.get("drive") != "fixed_pivot":
            raise InputError(
                "must be given: the posterior's pivot moved as it was measured", parameter="drive"
            )
        motion = FixedPivot()
    axes = dict(axes or {})
    varied = _varied(known, body, motion if drive is None else None, axes)
    random = np.random.default_rng(checked_count("seed", seed, SEEDS))
    flat = known.stack({"one": ("chain", "draw")})
    chosen = random.choice(flat.sizes["one"], size=min(count, flat.sizes["one"]), replace=False)
    # A chain repeats a draw where it did not move on: one run stands for all of these.
    rows = np.column_stack([flat[name].values[chosen] for name in varied])
    rows, times = np.unique(rows, axis=0, return_counts=True)
    tied = dict(zip(varied, rows.T, strict=True))
    grid = sweep(
        body, motion, axes={**axes, _DRAW: tied}, duration=duration, transient=transient,
        observables=[MotionClass()], **options,
    )  # fmt: skip
    dimension = str(grid[STATUS].dims[-1])
    found = grid["motion_class"]
    if body.angles == 2:
        found = found.max("ball", skipna=False)
    ended = has_answer(grid[STATUS]) & np.isfinite(found.values)
    lost = float(np.max(~ended @ times)) / len(chosen)
    if lost > _MOST_LOST:
        raise InputError(
            f"{100.0 * lost:.2g} % of the runs did not end, which may be those of one class",
            way_out="raise contact_limit, or shorten the trial",
        )
    classes = np.where(ended, found.values, np.nan)
    runs = ended @ times
    kept = grid.drop_dims([dimension, "ball"], errors="ignore")
    variables = {}
    for number, name in reversed(list(enumerate(CLASSES))):
        share, low, high = wilson_interval((classes == number) @ times, runs)
        words = f"probability of {'no' if name == 'none' else name} motion"
        for part, values, kind in (
            ("", share, words),
            ("_low", low, f"low end of the {words}"),
            ("_high", high, f"high end of the {words}"),
        ):
            about = {"units": "1", "long_name": kind}
            variables[f"probability_{name}{part}"] = (tuple(axes), values, about)
    # The value that a sweep notes of an unknown parameter is that of no draw.
    about = {key: value for key, value in grid.attrs.items() if key not in ("plan", *varied)}
    result = xr.Dataset(variables, coords=kept.coords, attrs=about | {"prediction": "class"})
    result.attrs["draws"] = len(chosen)
    if not axes:
        result.attrs["verdict"] = _verdict(result)
    return result


def _draws_of(posterior: Any) -> xr.Dataset:
    """Return the draws of a posterior that is a result."""
    draws = posterior.draws if isinstance(posterior, Fit) else None
    if draws is None:
        raise InputError("must be what fit_posterior returns", parameter="posterior")
    if not posterior.describes:
        raise InputError(f"the posterior is no result: {posterior.doubt}")
    return draws


def _varied(
    known: xr.Dataset, system: System, drive: Drive | None, axes: Mapping[str, Any]
) -> list[str]:
    """Return the unknown parameters that trials have: of the system, and of an unknown drive."""
    of_system = parameters_of(system, drive if drive is not None else FixedPivot())
    names = [str(name) for name in known if name in of_system]
    clash = next((name for name in names if name in axes), None)
    if clash is not None:
        raise InputError(f"'{clash}' is unknown, and cannot be an axis", parameter="axes")
    if not names:
        raise InputError("no unknown parameter of the posterior acts on these trials")
    return names


def _verdict(result: xr.Dataset) -> str:
    """Return the probabilities in plain words."""
    parts = []
    for name in reversed(CLASSES):
        value, low, high = (
            float(result[f"probability_{name}{part}"]) for part in ("", "_low", "_high")
        )
        parts.append(f"P({name}) = {value:.2f} ({low:.2f} to {high:.2f})")
    return f"{', '.join(parts)}, by {result.attrs['draws']} draws of what is not known."
