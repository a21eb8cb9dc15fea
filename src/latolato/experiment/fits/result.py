"""What every fit returns: estimates with their uncertainty, a plain verdict and curves to draw."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from latolato.core.errors import InputError, Sentence, Word, as_read, joined
from latolato.core.quantities import QUANTITIES, Quantity
from latolato.core.registry import Registry, rebuild, suggest
from latolato.experiment.rules import said
from latolato.io.shown_units import SIZES
from latolato.physics.drives import Drive, drives
from latolato.physics.pendulum import System, systems
from latolato.simulation.summary import plain

if TYPE_CHECKING:
    import xarray as xr

# Half the width of a 95 percent interval in standard deviations.
TWO_SIDED = 1.959964
# The least and the largest value that an experiment is likely to have [SI].
USUAL_SIZES = {
    "length": (5e-3, 70.0),
    "drive_frequency": (0.05, 2e3),
    "drive_amplitude": (1e-5, 1.0),
}
# Numbers without a power of ten: that of their first digit. Share of a number below which a
# deviation is that of its rounding alone.
_PLAIN, _ROUNDING = (-3, 5), 1e-13
# Endings of the variables that go with an estimate.
_PARTS = {
    "sigma": "standard deviation of",
    "low": "low end of the 95 % interval of",
    "high": "high end of the 95 % interval of",
}


@dataclass(frozen=True)
class Estimate:
    """A fitted number with its standard deviation and 95 percent interval, in `unit`.

    Without an interval it is the value ± 1.96 standard deviations.

    Examples
    --------
    >>> print(Estimate(0.0027429, 4e-6, "kg*m/s"), Estimate(1.0, 1e-14, "m"), sep="; ")
    0.0027429 ± 0.0000040 kg m/s; 1 m
    """

    value: float
    sigma: float
    unit: str
    low: float = math.nan
    high: float = math.nan

    def __post_init__(self) -> None:
        if math.isnan(self.low):
            object.__setattr__(self, "low", self.value - TWO_SIDED * self.sigma)
        if math.isnan(self.high):
            object.__setattr__(self, "high", self.value + TWO_SIDED * self.sigma)

    def __str__(self) -> str:
        is_known = math.isfinite(self.value) and math.isfinite(self.sigma)
        if not is_known or self.sigma <= _ROUNDING * abs(self.value):
            text = as_read(f"{self.value:.6g}") if math.isfinite(self.value) else str(self.value)
        else:
            largest = math.floor(math.log10(max(abs(self.value), self.sigma)))
            # Small and large numbers as powers of ten.
            power = 0 if _PLAIN[0] <= largest <= _PLAIN[1] else largest
            value, sigma = (each / 10.0**power for each in (self.value, self.sigma))
            # Two digits of the deviation, and the value to the same place.
            places = max(1 - math.floor(math.log10(sigma)), 0)
            text = f"{as_read(f'{value:.{places}f}')} ± {sigma:.{places}f}"
            text = f"({text}) \N{MULTIPLICATION SIGN} {as_read(f'1e{power}')}" if power else text
        unit = self.unit.replace("*", " ").replace("^2", "²")
        return text if unit in ("", "1") else f"{text} {unit}"

    def shifted(self, by: float) -> Estimate:
        """Return the estimate of this quantity plus a known number."""
        return Estimate(self.value + by, self.sigma, self.unit, self.low + by, self.high + by)

    def widened(self, sigma: float) -> Estimate:
        """Return the estimate with another deviation, and its interval wider by the same factor."""
        wider = sigma / self.sigma if self.sigma > 0.0 else 1.0
        low, high = (self.value + wider * (end - self.value) for end in (self.low, self.high))
        return replace(self, sigma=sigma, low=low, high=high)

    def power(self, factor: float, exponent: int, unit: str) -> Estimate:
        """Return the estimate of a known factor times a power of this quantity, which is not 0."""
        value = factor * self.value**exponent
        sigma = abs(exponent * value / self.value) * self.sigma
        ends = sorted(
            factor * end**exponent if end * self.value > 0.0 else value
            for end in (self.low, self.high)
        )
        return Estimate(value, sigma, unit, *ends)

    def scaled(self, factor: float, unit: str) -> Estimate:
        """Return the estimate of this quantity times a known factor."""
        ends = sorted((self.low * factor, self.high * factor))
        return Estimate(self.value * factor, self.sigma * abs(factor), unit, *ends)


@dataclass(frozen=True)
class Adequacy:
    """Whether a model describes a record.

    Attributes
    ----------
    doubt : str
        Why not, as the first sentences of a verdict; "" if it does.
    kind : str
        What kind of break it looks like, "" without one.
    fails_at : float
        Where the model begins to fail [s], NaN if it does not or nowhere in particular.
    note : str
        What is worth knowing of a model that describes the record nearly, as a sentence.
    is_in_record : bool
        Whether a part of the record may do better; else the doubt names its way out.
    """

    doubt: str = ""
    kind: str = ""
    fails_at: float = math.nan
    note: str = ""
    is_in_record: bool = True

    @property
    def describes(self) -> bool:
        """Whether the model describes the record."""
        return not self.doubt

    @property
    def attributes(self) -> dict[str, Any]:
        """What a fit's dataset holds of it."""
        known = None if math.isnan(self.fails_at) else self.fails_at
        return {
            "describes": self.describes,
            "doubt": str(self.doubt) or None,
            "break": self.kind or None,
            "fails_at": known,
        }


@dataclass(frozen=True)
class Fit:
    """The result of a fit, kept in one dataset, which can be saved to a file.

    ``fit["damping"]`` is an `Estimate`, ``fit.verdict`` a sentence for people, ``fit.drive`` and
    ``fit.system`` are the laws that were found (or None), and ``fit.dataset`` holds everything
    with the fitted curves: for an estimate `name` the variables `name`, ``name_sigma``,
    ``name_low`` and ``name_high``.
    """

    dataset: xr.Dataset
    # Verdict, doubt and refusal with their parts; files hold texts alone.
    sentences: Mapping[str, str] = field(default_factory=dict, repr=False)

    @property
    def kind(self) -> str:
        """The name of the fit in `latolato.experiment.fits.fits`."""
        return str(self.dataset.attrs["fit"])

    @property
    def verdict(self) -> str:
        """The result in plain words."""
        return self.sentences.get("verdict", str(self.dataset.attrs["verdict"]))

    @property
    def describes(self) -> bool:
        """Whether the model describes the record; if not, no number of the fit is a result."""
        return bool(self.dataset.attrs.get("describes", True))

    @property
    def doubt(self) -> str:
        """Why the model does not describe the record, "" if it does."""
        return self.sentences.get("doubt", str(self.dataset.attrs.get("doubt", "")))

    @property
    def refusal(self) -> str:
        """The doubt with what to do about it, for who is shown no number; "" without a doubt."""
        return self.sentences.get("refusal", self.doubt)

    @property
    def estimates(self) -> dict[str, Estimate]:
        """All estimates by name."""
        names = [str(n) for n in self.dataset.data_vars if f"{n}_sigma" in self.dataset]
        return {name: self[name] for name in names if self.dataset[name].ndim == 0}

    @property
    def draws(self) -> xr.Dataset | None:
        """Draws of the unknown parameters by name, on chain and draw; None but for a posterior."""
        names = [str(name) for name in self.estimates if f"{name}_draw" in self.dataset]
        found = self.dataset[[f"{name}_draw" for name in names]]
        return found.rename({f"{name}_draw": name for name in names}) if names else None

    @property
    def drive(self) -> Drive | None:
        """The drive that was found or given, None for a pivot at rest."""
        drive: Drive | None = self._law("drive_description", drives)
        return drive

    @property
    def system(self) -> System | None:
        """The system with its fitted parameters, None if the fit does not determine all of them."""
        system: System | None = self._law("system_description", systems)
        return system

    def _law(self, attribute: str, registry: Registry[Any]) -> Any:
        """Return the law that an attribute describes, None without one."""
        text = self.dataset.attrs.get(attribute)
        if not text:
            return None
        described = json.loads(text)
        return rebuild(registry[described.pop("kind")], described)

    def __contains__(self, name: str) -> bool:
        return f"{name}_sigma" in self.dataset and self.dataset[name].ndim == 0

    def __getitem__(self, name: str) -> Estimate:
        if name not in self:
            known = list(self.estimates)
            raise KeyError(f"the fit has no '{name}': {suggest(name, known)}")
        variable = self.dataset[name]
        sigma, *ends = (float(self.dataset[f"{name}_{part}"]) for part in _PARTS)
        return Estimate(float(variable), sigma, variable.attrs["units"], *ends)

    def to_dict(self) -> dict[str, Any]:
        """Return estimates, verdict and attributes as JSON types; NaN becomes None."""
        return {
            "fit": self.kind,
            "verdict": self.verdict,
            "describes": self.describes,
            "values": {
                name: {
                    "value": plain(estimate.value),
                    "sigma": plain(estimate.sigma),
                    "low": plain(estimate.low),
                    "high": plain(estimate.high),
                    "units": estimate.unit,
                }
                for name, estimate in self.estimates.items()
            },
            "attributes": {str(key): plain(value) for key, value in self.dataset.attrs.items()},
        }

    def save(self, path: str | Path) -> Path:
        """Write the fit as a NetCDF file and return its path."""
        from latolato.io.files import check_suffix, save

        check_suffix(path, (".nc",), "the result of a fit")
        return save(self.dataset, path)


def load_fit(path: str | Path) -> Fit:
    """Return a fit from a file that `Fit.save` wrote.

    Raises
    ------
    InputError
        If the file holds something else.
    """
    from latolato.io.files import load

    dataset = load(path)
    if "fit" not in dataset.attrs:
        raise InputError(f"'{path}' contains no fit")
    return Fit(dataset)


def quantity_of(name: str) -> Quantity:
    """Return a quantity by name; of one ball of a pair as in ``right_length``."""
    if name in QUANTITIES:
        return QUANTITIES[name]
    side, _, inner = name.partition("_")
    quantity = QUANTITIES[inner]
    return replace(quantity, long_name=f"{quantity.long_name}, {side} ball")


def make_fit(
    kind: str,
    estimates: Mapping[str, Estimate],
    verdict: str,
    curves: Mapping[str, tuple[str, Any]],
    attributes: Mapping[str, Any],
    drive: Drive | None = None,
    system: System | None = None,
    adequacy: Adequacy = Adequacy(),
) -> Fit:
    """Return a fit made of its parts.

    Where the model does not describe the record, the verdict is why, and nothing else.

    Parameters
    ----------
    kind : str
        What was fitted.
    estimates : mapping of str to Estimate
        Named as in `latolato.core.quantities`.
    verdict : str
        The result in plain words.
    curves : mapping of str to (str, array_like)
        Dimension and values of further variables, named as in `latolato.core.quantities`.
    attributes : mapping
        Numbers and texts; None is left out.
    drive, system : Drive, System, optional
        The fitted laws of the pivot and of what swings.
    adequacy : Adequacy
        Whether the model describes the record.
    """
    import xarray as xr

    variables: dict[str, Any] = {}
    refusal = ""
    for name, estimate in estimates.items():
        quantity = quantity_of(name)
        shared = {**quantity.attributes, "units": estimate.unit}
        variables[name] = ((), estimate.value, shared)
        for part, words in _PARTS.items():
            meaning = {**shared, "long_name": f"{words} {quantity.long_name}"}
            variables[f"{name}_{part}"] = ((), getattr(estimate, part), meaning)
    for name, (dimension, values) in curves.items():
        variables[name] = (dimension, values, QUANTITIES[name].attributes)
    kept = {
        key: int(value) if isinstance(value, bool) else value
        for key, value in {**attributes, **adequacy.attributes}.items()
        if value is not None
    }
    if drive is not None:
        kept["drive_description"] = json.dumps(drives.described(drive))
    if system is not None:
        kept["system_description"] = json.dumps(systems.described(system))
    if not adequacy.describes:
        withheld = said("withheld_whole" if adequacy.is_in_record else "withheld")
        refusal = joined([adequacy.doubt, withheld])
        verdict = joined([refusal, said("inspected")])
    elif adequacy.note:
        verdict = joined([verdict, adequacy.note])
    dataset = xr.Dataset(variables, attrs={"fit": kind, "verdict": str(verdict), **kept})
    return Fit(dataset, {"verdict": verdict, "doubt": adequacy.doubt, "refusal": refusal})


def named(name: str, estimate: Estimate) -> Sentence:
    """Return a number with the name of its quantity."""
    return joined([Word(quantity_of(name).long_name), str(shown(name, estimate))])


def shown(name: str, estimate: Estimate) -> Estimate:
    """Return an estimate of a quantity in the unit in which people read that."""
    quantity = quantity_of(name)
    size = SIZES.get(quantity.shown_unit)
    if size is None or estimate.unit != quantity.unit:
        return estimate
    return estimate.scaled(1.0 / float(size), quantity.shown_unit)


def size_questions(numbers: Mapping[str, float]) -> list[Sentence]:
    """Return questions about those of some numbers that no experiment has, in SI units."""
    return [
        said(f"unusual_{name}", value=value)
        for name, value in numbers.items()
        if not USUAL_SIZES[name][0] <= abs(value) <= USUAL_SIZES[name][1]
    ]
