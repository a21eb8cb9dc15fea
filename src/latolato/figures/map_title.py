"""The lines above a picture of a sweep: its system and what does not vary."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from latolato.core.language import spoken, tr
from latolato.core.quantities import QUANTITIES
from latolato.figures import overlays as marks
from latolato.figures import style

if TYPE_CHECKING:
    import xarray as xr

# Parameters that the lines name.
_PARAMETERS = (
    *("length", "mass", "radius", "restitution", "string_restitution", "damping"),
    *("quadratic_damping", "coulomb_damping", "initial_angle", "initial_offset"),
    *("initial_distance", "drive_amplitude", "vertical_amplitude", "horizontal_amplitude"),
    *("connecting_rod_length", "frequency_ratio", "drive_frequency", "duration", "transient"),
)
# Parameters of observables, which the lines name with these only.
OF_VARIABLE = {
    "crossings": ("crossing_angle",),
    "motion_class": ("strong_angle", "weak_angle"),
    "self_start": ("least_motion",),
}
# Parameters of observables that are angles.
_ANGLES = {"strong_angle", "weak_angle", "least_motion"}


def title_of(grid: xr.Dataset, selection: Mapping[str, str], variable: str) -> list[str]:
    """Return the title of a variable's picture, in lines; `selection` is in words."""
    attributes = grid.attrs
    varied = {str(name) for name, c in grid.coords.items() if c.dims}
    varied.add(attributes.get("parameter", ""))  # that a branch is followed along
    if attributes.get("analysis") == "bifurcation_curve":
        varied |= set(attributes["parameters"])
    words = [tr(str(attributes.get("system", "sweep")))]
    if attributes.get("suspension") == "string":
        words[0] = tr("{system} on strings", system=words[0])
    if attributes.get("drag_frame") == "lab":
        words.append(tr("in air at rest in the room"))
    targets = {"drive_amplitude": marks.AMPLITUDES, "drive_frequency": marks.FREQUENCIES}
    others = []
    for name in (*_PARAMETERS, *OF_VARIABLE.get(variable, ())):
        value = attributes.get(name)
        if not isinstance(value, (int, float)) or name in selection or name in varied:
            continue
        if varied & set(targets.get(name, ())) or set(selection) & set(targets.get(name, ())):
            continue
        if value == 0.0 and name not in ("damping", "initial_offset"):
            continue
        others.append(in_words(grid, name, float(value)))
    if attributes.get("contact") == "clamp":
        words.append(tr("a fixed-step artefact"))
    if attributes.get("continuation"):
        words.append(tr("following {name}", name=attributes["continuation"]))
    first = ", ".join([*words, *selection.values()])
    lines, line = [], first
    for word in others:
        if len(plain_text(line)) + len(plain_text(word)) > 84:
            lines.append(line)
            line = word
        else:
            line = f"{line}, {word}"
    return [*lines, line]


def plain_text(text: str) -> str:
    """Return roughly what mathematics looks like, to measure its length."""
    return text.replace("$", "").replace("\\", "").replace("{", "").replace("}", "")


def in_words(grid: xr.Dataset, name: str, value: float) -> str:
    """Return a parameter and its value in the unit in which people read it: ``$A_0$ = 20 mm``."""
    quantity = QUANTITIES.get(name)
    about = grid[name].attrs if name in grid.coords else {}
    symbol = about.get("symbol") or (quantity.symbol if quantity else "")
    unit = about.get("units") or (quantity.unit if quantity else "1")
    if name in _ANGLES:
        unit = "rad"
    if name == "transient":
        unit = "s"
    head = f"${symbol}$" if symbol else spoken(name)
    return f"{head} = {style.shown_value(name, value, unit)}"
