"""Every physical quantity that latolato names: unit, symbol and meaning, said once.

Fields of laws, sweep axes, dataset variables, command line options, forms and the glossary take
their unit, symbol and label from here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any


def in_brackets(unit: str) -> str:
    """Return the unit in brackets behind a name: nothing for texts and plain numbers."""
    return "" if unit in ("", "1") else f" [{unit}]"


@dataclass(frozen=True)
class Quantity:
    """A quantity's SI unit (as xarray and pint read it), its TeX symbol and what it is.

    `usual` is what a form begins with where a law has no default, the toy in the hand [SI], and
    `first_unit` the unit in which it is shown, "" for the usual one of its kind.
    """

    unit: str
    symbol: str
    long_name: str
    usual: Any = None
    first_unit: str = ""

    @property
    def shown_unit(self) -> str:
        """The unit in which people read it, on screens, in pictures and in text tables."""
        return self.first_unit or UNITS.get(self.unit, (self.unit,))[0]

    @property
    def label(self) -> str:
        """Axis label: name, symbol and unit."""
        return f"{self.long_name} ${self.symbol}${in_brackets(self.unit)}"

    @property
    def attributes(self) -> dict[str, str]:
        """What a dataset's variable says about itself: ``units``, ``long_name``, ``symbol``."""
        return {"units": self.unit, "long_name": self.long_name, "symbol": self.symbol}


# Units in which people read and write quantities of an SI unit, the usual one first.
UNITS: dict[str, tuple[str, ...]] = {
    "m": ("cm", "mm", "m", "in"),
    "kg": ("g", "kg"),
    "s": ("s", "ms", "min"),
    "rad": ("deg", "rad"),
    "rad/s": ("rad/s", "Hz", "rpm", "deg/s"),
    "m/s^2": ("m/s^2",),
    "1": ("1",),
}

# Products of ten numbers of these sizes are floats; a pendulum's are far from either.
SMALLEST, LARGEST = 1e-30, 1e30
# Beyond it, an angle is rounded by more than 1e-10 rad, the default tolerance of a run.
LARGEST_ANGLE = 1e6  # rad
# Ends of whole numbers, as people write them.
_POWERS = {2.0**53: "2^53", 2.0**63: "2^63"}


@dataclass(frozen=True)
class Limit:
    """One end of what a number may be, and the name of its rule with what stands in the gaps."""

    is_lower: bool
    end: float
    is_open: bool
    rule: str
    values: Mapping[str, str]

    def holds(self, value: Any) -> Any:
        """Return whether a value lies on the right side, element by element for an array."""
        if self.is_lower:
            return value > self.end if self.is_open else value >= self.end
        return value < self.end if self.is_open else value <= self.end


@dataclass(frozen=True)
class Range:
    """The values that a parameter may take; `open_low` and `open_high` exclude the ends."""

    low: float = float("-inf")
    high: float = float("inf")
    open_low: bool = False
    open_high: bool = False

    def __contains__(self, value: float) -> bool:
        above = value > self.low if self.open_low else value >= self.low
        return above and (value < self.high if self.open_high else value <= self.high)

    def __str__(self) -> str:
        left = "(" if self.open_low or self.low == float("-inf") else "["
        right = ")" if self.open_high or self.high == float("inf") else "]"
        return f"{left}{_text(self.low)}, {_text(self.high)}{right}"

    @lru_cache(maxsize=256)  # noqa: B019  (ranges are constants)
    def limits(self, unit: str) -> tuple[Limit, ...]:
        """Return the rules for a number in a unit, in the order in which they are checked.

        These are the ends of the range, and the sizes that can be computed with: what must be
        positive, such as a mass, is divided by and cannot be tiny.
        """
        tail = "" if unit == "1" else f" {unit}"
        largest = LARGEST_ANGLE if unit == "rad" else LARGEST
        least = "more_than" if self.open_low else "at_least"
        most = "less_than" if self.open_high else "at_most"
        low, high = ({"range": f"{self}{tail}", "end": _text(end)} for end in (self.low, self.high))
        ends = [
            Limit(True, self.low, self.open_low, least, low),
            Limit(False, self.high, self.open_high, most, high),
        ]
        rule = "turns" if unit == "rad" else "size"
        size = {"range": f"[{-largest if self.low < 0.0 else 0.0:g}, {largest:g}]{tail}"}
        if self.low < -largest:
            ends.append(Limit(True, -largest, False, rule, size))
        if self.high > largest:
            ends.append(Limit(False, largest, False, rule, size))
        if self.low == 0.0 and self.open_low:
            tiny = {"end": f"{SMALLEST:g}{tail}"}
            ends.append(Limit(True, SMALLEST, False, "tiny", tiny))
        return tuple(limit for limit in ends if math.isfinite(limit.end))


def _text(end: float) -> str:
    """Return the end of a range as it is written."""
    return _POWERS.get(end, f"{end:g}")


POSITIVE = Range(low=0.0, open_low=True)
NON_NEGATIVE = Range(low=0.0)
UNIT_INTERVAL = Range(low=0.0, high=1.0)
ANY = Range()
# Whole numbers that a file can hold.
COUNT = Range(1, 2**63, open_high=True)

QUANTITIES: dict[str, Quantity] = {
    # state
    "time": Quantity("s", "t", "time"),
    "angle": Quantity("rad", r"\theta", "angle from the downward vertical"),
    "angular_velocity": Quantity("rad/s", r"\dot\theta", "angular velocity"),
    "initial_angle": Quantity("rad", r"\theta_0", "initial angle", usual=0.35),
    "initial_angular_velocity": Quantity("rad/s", r"\dot\theta_0", "initial angular velocity"),
    "initial_offset": Quantity("rad", r"\delta_0", "initial angle above the low contact angle"),
    "duration": Quantity("s", "t_{end}", "duration", usual=20.0),
    "tolerance": Quantity("rad", r"\varepsilon", "tolerance", first_unit="rad"),
    "largest_angle": Quantity("rad", r"\theta_{max}", "largest angle"),
    "distance": Quantity("m", "R", "distance of a ball from the pivot"),
    "initial_distance": Quantity("m", "R_0", "distance from the pivot at the start"),
    "radial_velocity": Quantity("m/s", r"\dot R", "velocity along the string, outwards"),
    "slack": Quantity("1", "", "whether the string is slack"),
    # body
    "length": Quantity("m", "l", "pivot to ball centre", usual=0.245),
    "mass": Quantity("kg", "m", "mass of one ball", usual=0.1),
    "radius": Quantity("m", "r", "radius of one ball", usual=0.02, first_unit="mm"),
    "gravity": Quantity("m/s^2", "g", "gravitational acceleration"),
    "damping": Quantity("kg*m/s", "C", "linear damping coefficient"),
    "quadratic_damping": Quantity("kg*m", "C_2", "quadratic damping coefficient"),
    "coulomb_damping": Quantity("N", "C_0", "Coulomb friction force"),
    "restitution": Quantity("1", "e", "coefficient of restitution"),
    "string_restitution": Quantity("1", "e_s", "coefficient of restitution of a string"),
    "rod_mass": Quantity("kg", "m_{rod}", "mass of a uniform rod"),
    "period": Quantity("s", "T_0", "period of small swings"),
    "natural_frequency": Quantity("rad/s", r"\omega_0", "natural angular frequency"),
    "decay_rate": Quantity("1/s", "k", "amplitude decay rate C/(2ml)"),
    "contact_angle_low": Quantity("rad", r"\theta_{low}", "contact angle at the bottom"),
    "contact_angle_high": Quantity("rad", r"\theta_{high}", "contact angle at the top"),
    "contact_separation": Quantity("rad", r"\Theta", "angle between the balls at bottom contact"),
    "clamp_step": Quantity("s", "h", "fixed step of contact 'clamp'"),
    "rest_speed": Quantity(
        "rad/s", r"\dot\theta_{rest}", "speed below which touching balls stay together"
    ),
    # drive
    "drive_amplitude": Quantity("m", "A_0", "driving amplitude", usual=0.02, first_unit="mm"),
    "drive_frequency": Quantity("rad/s", r"\omega", "angular driving frequency", usual=15.1),
    "drive_frequency_final": Quantity(
        "rad/s", r"\omega_1", "angular driving frequency at the end", usual=20.0
    ),
    "drive_frequencies": Quantity(
        "rad/s", r"\omega_k", "angular driving frequency of each stage", usual=(19.8, 15.1)
    ),
    "drive_amplitudes": Quantity(
        "m", "A_k", "driving amplitude of each stage", usual=(0.034, 0.034)
    ),
    "drive_phase": Quantity("rad", r"\varphi", "driving phase at time zero"),
    "vertical_amplitude": Quantity(
        "m", "A_y", "vertical driving amplitude", usual=0.02, first_unit="mm"
    ),
    "horizontal_amplitude": Quantity(
        "m", "A_x", "horizontal driving amplitude", usual=0.005, first_unit="mm"
    ),
    "vertical_phase": Quantity("rad", r"\varphi_y", "vertical driving phase at time zero"),
    "horizontal_phase": Quantity("rad", r"\varphi_x", "horizontal driving phase at time zero"),
    "times": Quantity("s", "t_k", "instants", usual=(0.0, 4.0)),
    "ramp": Quantity("s", r"\tau", "time in which the frequency moves to a new stage"),
    "ramps": Quantity("s", r"\tau_k", "time of the change into each stage", usual=(0.1, 0.5)),
    "sweep_time": Quantity("s", "t_s", "time in which the frequency sweeps", usual=30.0),
    "connecting_rod_length": Quantity("m", "L", "length of the connecting rod", usual=0.1),
    "pivot_height": Quantity("m", "y_0", "height of the pivot", first_unit="mm"),
    "pivot_velocity": Quantity("m/s", r"\dot y_0", "velocity of the pivot"),
    "pivot_acceleration": Quantity("m/s^2", r"\ddot y_0", "acceleration of the pivot"),
    "pivot_across": Quantity("m", "x_0", "horizontal position of the pivot", first_unit="mm"),
    "pivot_across_velocity": Quantity("m/s", r"\dot x_0", "horizontal velocity of the pivot"),
    "pivot_across_acceleration": Quantity(
        "m/s^2", r"\ddot x_0", "horizontal acceleration of the pivot"
    ),
    "frequency_ratio": Quantity("1", r"\omega/\omega_0", "driving over natural frequency"),
    "amplitude_ratio": Quantity("1", "A_0/l", "driving amplitude over length"),
    "drive_acceleration_ratio": Quantity(
        "1", r"A_0\omega^2/g", "largest pivot acceleration over gravity"
    ),
    "mathieu_strength": Quantity("1", r"\gamma", "excitation strength of eq15"),
    "mathieu_a": Quantity("1", "a", "Mathieu parameter a"),
    "mathieu_q": Quantity("1", "b", "Mathieu parameter q (the paper's b)"),
    # contacts
    "angle_sensitivity": Quantity(
        "rad", r"\partial\theta/\partial p", "derivative of the angle, per unit of the parameter"
    ),
    "angular_velocity_sensitivity": Quantity(
        "rad/s",
        r"\partial\omega/\partial p",
        "derivative of the angular velocity, per unit of the parameter",
    ),
    "contact_time_sensitivity": Quantity(
        "s",
        r"\partial t_c/\partial p",
        "derivative of the time of contact, per unit of the parameter",
    ),
    "contact_time": Quantity("s", "t_c", "time of contact"),
    "contact_kind": Quantity("1", "", "kind of contact"),
    "angular_velocity_before": Quantity(
        "rad/s", r"\dot\theta^-", "angular velocity just before contact"
    ),
    "angular_velocity_after": Quantity(
        "rad/s", r"\dot\theta^+", "angular velocity just after contact"
    ),
    "contact_ball": Quantity("1", "", "ball whose string goes slack or taut, 1 is the right one"),
    "radial_velocity_before": Quantity(
        "m/s", r"\dot R^-", "velocity along the string just before contact"
    ),
    "radial_velocity_after": Quantity(
        "m/s", r"\dot R^+", "velocity along the string just after contact"
    ),
    # energy
    "kinetic_energy": Quantity("J", "T", "kinetic energy in the pivot frame"),
    "potential_energy": Quantity("J", "U", "potential energy above the hanging position"),
    "total_energy": Quantity("J", "E", "total energy in the pivot frame"),
    "drive_power": Quantity("W", "P_{in}", "power of the drive"),
    "damping_power": Quantity("W", "P_{diss}", "dissipated power"),
    "drive_work": Quantity("J", "W_{in}", "work of the drive"),
    "damping_loss": Quantity("J", "D", "energy lost to damping"),
    "impact_loss": Quantity("J", "D_e", "energy lost in impacts"),
    "capture_loss": Quantity("J", "D_c", "energy removed when bouncing ends in rest"),
    "retension_loss": Quantity("J", "D_s", "energy lost when strings become taut"),
    "noise_work": Quantity("J", "W_n", "work of the noise"),
    "energy_residual": Quantity("J", r"\Delta E", "largest error of the closed energy ledger"),
    "mean_energy": Quantity("J", r"\langle E\rangle", "time mean of the total energy"),
    "lab_energy": Quantity("J", "E_L", "total energy in the laboratory frame"),
    "rod_power": Quantity("W", "P_{rod}", "power of the rod on the ball in the laboratory frame"),
    "tension": Quantity("N", "F_T", "tension of the rod"),
    "compression_time": Quantity("s", "t_{comp}", "first time at which the rod is pushed"),
    "compression_fraction": Quantity("1", "", "fraction of time in which the rod is pushed"),
    "first_slack": Quantity("s", "t_{slack}", "first time at which a string goes slack"),
    "slack_fraction": Quantity("1", "", "fraction of time in which a string is slack"),
    "largest_string_impulse": Quantity("N*s", "J_{max}", "largest impulse of a string"),
    # maps
    "crossings": Quantity("1", "N", "how often a ball passes the crossing angle"),
    "crossing_angle": Quantity("rad", r"\theta_x", "crossing angle"),
    "growth_rate": Quantity("1/s", r"\mu", "exponential growth rate"),
    # analyses
    "first_passage": Quantity("s", "t_1", "time of the first passage through the threshold"),
    "threshold_angle": Quantity("rad", r"\theta_{thr}", "threshold angle"),
    "dwell_time": Quantity("s", "t_d", "time for which a driving frequency is held"),
    # noise
    "noise_strength": Quantity("rad/s^(3/2)", r"\sigma", "strength of velocity noise"),
    "noise_interval": Quantity("s", "t_n", "time between velocity kicks"),
    "noise_seed": Quantity("1", "s_n", "seed of the velocity kicks"),
    "noise_stream": Quantity("1", "k_n", "random stream of the velocity kicks"),
    # track tables
    "frame": Quantity("1", "n", "number of the decoded frame"),
    "pivot_x": Quantity("m", "x_0", "pivot to the right of its mean"),
    "pivot_y": Quantity("m", "y_0", "height of the pivot above its mean"),
    "ball_1_x": Quantity("m", "x_1", "right ball to the right of the mean pivot"),
    "ball_1_y": Quantity("m", "y_1", "right ball above the mean pivot"),
    "ball_2_x": Quantity("m", "x_2", "left ball to the right of the mean pivot"),
    "ball_2_y": Quantity("m", "y_2", "left ball above the mean pivot"),
    "pivot_2_x": Quantity("m", "x_{02}", "the left ball's own pivot, to the right of the other's"),
    "pivot_2_y": Quantity("m", "y_{02}", "the left ball's own pivot, above the other's"),
    "pivot_2_u": Quantity("pixel", "u_{02}", "column of the left ball's own pivot in the picture"),
    "pivot_2_v": Quantity("pixel", "v_{02}", "row of the left ball's own pivot in the picture"),
    "pivot_u": Quantity("pixel", "u_0", "column of the pivot in the picture"),
    "pivot_v": Quantity("pixel", "v_0", "row of the pivot in the picture"),
    "ball_1_u": Quantity("pixel", "u_1", "column of the right ball in the picture"),
    "ball_1_v": Quantity("pixel", "v_1", "row of the right ball in the picture"),
    "ball_2_u": Quantity("pixel", "u_2", "column of the left ball in the picture"),
    "ball_2_v": Quantity("pixel", "v_2", "row of the left ball in the picture"),
    "angle_1": Quantity("rad", r"\theta_1", "angle of the right ball"),
    "angle_2": Quantity("rad", r"\theta_2", "angle of the left ball"),
    "angle_sigma_1": Quantity("rad", r"\sigma_1", "standard deviation of the right ball's angle"),
    "angle_sigma_2": Quantity("rad", r"\sigma_2", "standard deviation of the left ball's angle"),
    "flag_1": Quantity("1", "", "flag of the right ball's sample"),
    "flag_2": Quantity("1", "", "flag of the left ball's sample"),
    # fits of measurements
    "angle_offset": Quantity("rad", r"\theta_g", "angle of the hanging ball in the table"),
    "pivot_error_x": Quantity("m", r"\Delta x_p", "pivot of the table, right of the real one"),
    "pivot_error_y": Quantity("m", r"\Delta y_p", "pivot of the table, above the real one"),
    "centre_length": Quantity("m", "l_c", "pivot to the centre of a solid ball"),
    "damping_envelope": Quantity("kg*m/s", "C_{env}", "damping coefficient by the envelope"),
    "decay_rate_envelope": Quantity("1/s", "k_{env}", "amplitude decay rate by the envelope"),
    "angle_fit": Quantity("rad", r"\theta_{fit}", "fitted angle"),
    "band_low": Quantity("rad", r"\theta_{2.5\,\%}", "low end of the 95 % band of the angle"),
    "band_high": Quantity("rad", r"\theta_{97.5\,\%}", "high end of the 95 % band of the angle"),
    "angle_residual": Quantity("rad", r"\Delta\theta", "measured minus fitted angle"),
    "is_outlier": Quantity("1", "", "whether a sample was left out"),
    "swing_time": Quantity("s", "t_n", "time of a turning point"),
    "swing_angle": Quantity("rad", r"\theta_n", "angle of a turning point"),
    "swing_angle_fit": Quantity("rad", r"\theta_{n,fit}", "fitted angle of a turning point"),
    "law": Quantity("1", "", "drag law"),
    "law_bic": Quantity("1", "BIC", "Schwarz's criterion of a drag law"),
    "crank_ratio": Quantity("1", r"\lambda", "crank over connecting rod, positive: guide above"),
    "amplitude_drift": Quantity("m/s", r"\dot A_0", "change of the driving amplitude"),
    "frequency_drift": Quantity("rad/s^2", r"\dot\omega", "change of the driving frequency"),
    "step_time": Quantity("s", "t_s", "time of the last step of the driving frequency"),
    "stage_start": Quantity("s", "t_k", "start of each stage of the drive"),
    "drive_frequencies_sigma": Quantity(
        "rad/s", r"\sigma_{\omega_k}", "standard deviation of each stage's frequency"
    ),
    "harmonic": Quantity("1", "n", "multiple of the driving frequency"),
    "harmonic_amplitude": Quantity("m", "A_n", "amplitude of a multiple of the driving frequency"),
    "harmonic_amplitude_sigma": Quantity(
        "m", r"\sigma_{A_n}", "standard deviation of the amplitude of a multiple"
    ),
    "pivot_height_fit": Quantity("m", r"y_{0,fit}", "fitted height of the pivot"),
    "pivot_across_fit": Quantity("m", r"x_{0,fit}", "fitted horizontal position of the pivot"),
    "pivot_height_residual": Quantity("m", r"\Delta y_0", "measured minus fitted height"),
    "ball_number": Quantity("1", "", "ball, 1 is the right one"),
    "window_start": Quantity("s", "t_w", "start of a window"),
    "restitution_each": Quantity("1", "e_k", "restitution of each impact"),
    "restitution_each_sigma": Quantity(
        "1", r"\sigma_{e_k}", "standard deviation of each impact's restitution"
    ),
    "separation": Quantity("rad", r"\Delta\theta", "angle between the balls, or of the one ball"),
    # trials and comparisons
    "largest_angle_sigma": Quantity(
        "rad", r"\sigma_{max}", "standard deviation of the largest angle"
    ),
    "largest_angle_after_transient": Quantity(
        "rad", r"\theta_{max,late}", "largest angle after the transient"
    ),
    "largest_angle_after_transient_sigma": Quantity(
        "rad", r"\sigma_{late}", "standard deviation of the largest angle after the transient"
    ),
    "drive_amplitude_sigma": Quantity(
        "m", r"\sigma_{A_0}", "standard deviation of the driving amplitude"
    ),
    "drive_frequency_sigma": Quantity(
        "rad/s", r"\sigma_\omega", "standard deviation of the angular driving frequency"
    ),
    "separation_at_contact": Quantity("rad", r"\Theta_k", "angle between the balls at an impact"),
}


def quantity_of(name: str, unit: str) -> Quantity:
    """Return the quantity of a variable, by its name if it is known."""
    known = QUANTITIES.get(name)
    return known if known is not None and known.unit == unit else Quantity(unit, "", name)


def quantity_field(
    name: str,
    allowed: Range = ANY,
    *,
    description: str = "",
    suggested: tuple[float, float] | None = None,
    is_later: bool = False,
    **options: Any,
) -> Any:
    """Return a dataclass field that carries a quantity of `QUANTITIES` and its range.

    `suggested` is the interval in which sliders and examples move; `options` go to
    `dataclasses.field`. A field that `is_later` joined a law of which there are stored runs:
    `latolato.core.registry.describe` leaves out its default, which must never change.
    """
    quantity = QUANTITIES[name]
    metadata = {
        "quantity": quantity,
        "range": allowed,
        "description": description or quantity.long_name,
        "suggested": suggested,
        "is_later": is_later,
    }
    return field(metadata=metadata, **options)


def choice_field(
    choices: tuple[str, ...], *, default: str, description: str, is_later: bool = False
) -> Any:
    """Return a dataclass field that holds one of some words; `is_later` as in `quantity_field`."""
    metadata = {"choices": choices, "description": description, "is_later": is_later}
    return field(default=default, metadata=metadata)


def array_field(name: str, allowed: Range = ANY, *, description: str, **options: Any) -> Any:
    """Return a dataclass field that carries a list of one quantity of `QUANTITIES`.

    `options` go to `dataclasses.field`.
    """
    metadata = {
        "quantity": QUANTITIES[name],
        "range": allowed,
        "array": True,
        "description": description,
    }
    return field(metadata=metadata, **options)
