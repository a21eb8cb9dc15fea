"""Figs. 7 and 10: the damping of a filmed free decay, by the full equation and by its envelope."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from latolato.figures import style
from latolato.figures.fits import draw_curve, draw_residual, draw_turning_points
from latolato.paper import chain
from latolato.paper.cases import quantity, variable
from latolato.paper.claim import Numbers

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def data(clip: chain.Clip, title: str, quick: bool = False, full: bool = False) -> xr.Dataset:
    """Return the fit of a filmed decay, with a frame, and the damping that was rendered.

    A quick video is shorter, with fewer and smaller frames.
    """
    from latolato import fit_decay

    if quick:
        clip = replace(clip, duration=16.0, fps=24.0, size=(640, 480))
    table = chain.film(clip)
    frames = table.sizes["frame"]
    fit = fit_decay(table, mass=clip.system.mass, compare=not quick, profile=not quick)
    dataset = fit.dataset.assign(
        still=chain.still_of(clip),
        damping_rendered=quantity(
            "damping", (), clip.system.damping, long_name="damping that was rendered"
        ),
        frames=variable((), frames, units="1", long_name="frames of the video"),
        rms_error=chain.error_of(table),
    )
    made = f"One synthetic video of {frames} frames, tracked."
    filmed = clip.run().attrs["scenario"]
    dataset.attrs |= {"title": title, "chain": made, "scenario": filmed}
    return dataset


def numbers(dataset: xr.Dataset) -> Numbers:
    """Return the numbers that the statement of a decay names."""
    rendered = float(dataset.damping_rendered)
    damping, sigma = float(dataset.damping), float(dataset.damping_sigma)
    envelope = float(dataset.damping_envelope)
    return {
        "error": abs(damping / rendered - 1.0),
        "error_percent": 100.0 * abs(damping / rendered - 1.0),
        "error_envelope": abs(envelope / rendered - 1.0),
        "envelope_percent": 100.0 * abs(envelope / rendered - 1.0),
        "pull": abs(damping - rendered) / sigma,
        "damping_milli": 1e3 * damping,
        "sigma_milli": 1e3 * sigma,
        "envelope_milli": 1e3 * envelope,
        "frames": float(dataset.frames),
        "rms_milli": 1e3 * float(dataset.rms_error),
    }


@style.styled
def draw(dataset: xr.Dataset) -> Figure:
    """Return the frame, the tracked angle under its envelope, and what the equation leaves."""
    figure, panels = style.new_mosaic(
        [["still", "angle"], ["still", "residual"]],
        height=3.2, height_ratios=[1.9, 1.0], width_ratios=[1.0, 2.1],
    )  # fmt: skip
    chain.draw_still(panels["still"], dataset, "a")
    angle, residual = panels["angle"], panels["residual"]
    draw_curve(angle, dataset, "angle", "angle_fit")
    draw_turning_points(angle, dataset)
    angle.set_xlabel("")
    angle.legend(**style.ABOVE, ncols=3)
    style.panel_letter(angle, "b")
    draw_residual(residual, dataset, "angle_residual")
    style.panel_letter(residual, "c")
    for axes in (angle, residual):
        axes.set_xlim(0.0, float(dataset.time[-1]))
    return figure
