"""The picture of a stroboscopic section: points of the phase plane."""

from __future__ import annotations

from typing import TYPE_CHECKING

from latolato.core.language import tr
from latolato.figures import style
from latolato.figures.analyses.drawings import draw_points

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

READING = (
    "Every dot is the state once per drive period: the angle to the right, the speed upwards."
    " A few dots mean a periodic motion, a closed curve two rhythms that do not fit together,"
    " a layered cloud chaos."
)
FIRST = {"periods": "", "section_phase": ""}

# Panels are no narrower [rad]: the points of a periodic motion differ by rounding errors.
_LEAST = 1e-3


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the points of the section, of two balls in two colours."""
    figure, axes = style.new_figure(width=0.6 * style.PAGE, height=3.4)
    panel = axes[0, 0]
    draw_points(panel, dataset["angle"], dataset["angular_velocity"], dataset.get("ball"))
    style.keep_span(panel, x=_LEAST, y=_LEAST * dataset.attrs["drive_frequency"])
    count, phase = dataset.sizes["time"], dataset.attrs["section_phase"]
    text = tr(
        "{count} drive periods, at drive phase {phase} rad", count=count, phase=f"{phase:.4g}"
    )
    panel.set_title(text, fontsize=style.SMALL)
    if "ball" in dataset:
        figure.legend(loc="outside lower center", ncols=2, markerscale=2.0)
    return figure
