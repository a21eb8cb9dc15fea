"""Words for options of analyses that are no quantities, and for numbers in sentences."""

from __future__ import annotations

import math

# Labels of options. Those that are missing are quantities, whose names their registry knows.
OPTION_WORDS = {
    "angle_high": "Angles at the start, to",
    "angle_low": "Angles at the start, from",
    "angle_points": "Number of angles at the start",
    "angle_tolerance": "Two samples are the same within",
    "asymmetry": "Left ball differs from the mirror image by",
    "chaos_box": "Size of boxes that tell chaotic motions apart",
    "check": "Check with simulated runs",
    "direction": "Which way it is followed",
    "drive_amplitude": "Amplitude of the drive",
    "drive_phase": "Phase of the drive at the push",
    "duration": "How long each run lasts",
    "dwell_time": "Times in the first stage",
    "entropy_box": "Starts along a box of the basin entropy",
    "first_frequency_ratio": "Drive speeds of the first stage, ω/ω₀",
    "frequency_ratio": "Drive speed, ω/ω₀",
    "high": "To",
    "largest_amplitude_ratio": "Search up to the amplitude A₀/l",
    "largest_push": "Largest push that is tried",
    "least_jump": "A jump is a change of at least",
    "least_motion": "Smallest swing that is kept alive",
    "longest": "Longest repetition that is looked for, in shakes",
    "low": "From",
    "check_tolerance": "Tolerance of the second run, which finds uncertain starts",
    "match_tolerance": "Two motions are the same within",
    "method": "Method of calculation",
    "noise_interval": "Time between random kicks",
    "noise_seed": "Seed of the random numbers",
    "noise_strength": "Strength of the random kicks",
    "order": "Number of the tongue (1 at ω = 2ω₀)",
    "parameter": "What is changed",
    "period": "Repeats after how many shakes",
    "periods": "Shakes that are watched",
    "phases": "Drive phases that are tried",
    "points": "How many values",
    "position": "Position of the ball",
    "push": "What the push gives",
    "ramp": "Time to change the speed",
    "refinements": "Rounds of refinement",
    "required_share": "Share of the phases that must succeed",
    "scan_points": "Number of pushes that are tried",
    "section_phase": "Phase of the drive at which one looks",
    "settling": "Time to settle afterwards",
    "sustained_angle": "It counts as going beyond",
    "threshold_angle": "Angle that counts",
    "trajectories": "How many repetitions",
    "transient": "Time that is left out at the beginning",
    "transient_periods": "Shakes that are left out at the beginning",
    "velocity_high": "Speeds at the start, to",
    "velocity_low": "Speeds at the start, from",
    "velocity_points": "Number of speeds at the start",
}
# Beyond this angle [rad] one ball at rest stands upright.
UPRIGHT = 0.75 * math.pi
_MINUS = "\N{MINUS SIGN}"
_TIMES = "\N{MULTIPLICATION SIGN}"


def number(value: float, digits: int = 3) -> str:
    """Return a number as it stands in a sentence.

    Examples
    --------
    >>> number(0.25), number(1234.5678), number(2.0e6).split()[0]
    ('0.25', '1230', '2')
    """
    if not math.isfinite(value):
        return f"{_MINUS if value < 0 else ''}∞" if math.isinf(value) else "no value"
    if value != 0.0 and not 1e-4 <= abs(value) < 1e6:
        figures, _, power = f"{value:.{digits - 1}e}".partition("e")
        raised = str(int(power)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        figures = figures.rstrip("0").rstrip(".") if "." in figures else figures
        return f"{figures} {_TIMES} 10{raised}".replace("-", _MINUS)
    place = digits - 1 - math.floor(math.log10(abs(value))) if value else 0
    text = f"{round(value, place):.{max(place, 0)}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return text.replace("-", _MINUS)


def plus_minus(value: float, error: float) -> str:
    """Return a number with its uncertainty, of which one digit is told, or two from 10 to 19.

    Examples
    --------
    >>> plus_minus(0.38381, 0.0383), plus_minus(1.5, 0.0)
    ('0.38 ± 0.04', '1.5')
    """
    if not (error > 0.0 and math.isfinite(error)) or not math.isfinite(value):
        return number(value)
    places = max(-math.floor(math.log10(error)) + (1 if f"{error:.0e}"[0] == "1" else 0), 0)
    return f"{value:.{places}f} ± {error:.{places}f}".replace("-", _MINUS)


def degrees(angle: float) -> str:
    """Return an angle in degrees.

    Examples
    --------
    >>> degrees(0.5), degrees(3e-4)
    ('29°', '0.017°')
    """
    size = math.degrees(angle)
    return f"{number(round(size) if abs(size) >= 10 else size, 3 if abs(size) >= 100 else 2)}°"


def millimetres(length: float) -> str:
    """Return a length in millimetres.

    Examples
    --------
    >>> millimetres(0.0234567)
    '23.5 mm'
    """
    return f"{number(1e3 * length)} mm"


def percent(share: float) -> str:
    """Return a share in per cent.

    Examples
    --------
    >>> percent(0.8206), percent(0.004)
    ('82 %', '0.4 %')
    """
    size = 100.0 * share
    return f"{number(round(size) if size >= 10.0 else size, 3 if size >= 99.5 else 2)} %"


def shakes(count: float) -> str:
    """Return so many drive periods in words.

    Examples
    --------
    >>> shakes(1), shakes(2), shakes(7)
    ('every shake', 'every second shake', 'every 7 shakes')
    """
    return {1: "every shake", 2: "every second shake"}.get(
        round(count), f"every {count:.0f} shakes"
    )


def times(count: float, what: str) -> str:
    """Return a number of things.

    Examples
    --------
    >>> times(1, "impact"), times(2.5, "impact")
    ('1 impact', '2.5 impacts')
    """
    shown = number(count)
    return f"{shown} {what}{'' if shown == '1' else 's'}"


def listed(parts: list[str], last: str = "and") -> str:
    """Return a list in words.

    Examples
    --------
    >>> listed(["a", "b", "c"])
    'a, b and c'
    """
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} {last} {parts[-1]}"
