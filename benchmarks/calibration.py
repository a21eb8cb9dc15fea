"""Checks that posteriors are calibrated: the truth must fall on every rank of the draws alike.

Simulation-based calibration (Talts et al. 2018): parameters are drawn from their prior, a track is
made of them, and the draws of its posterior are counted that are smaller than the truth. If the
density, its gradient and the sampler are right, that rank is uniform. One hundred tracks each of a
colliding pair, whose contacts come in another order or not at all as parameters change, and of a
driven swing; the noise of neighbouring samples is correlated in half of them. Run
``PYTHONPATH=tests/shared python benchmarks/calibration.py [tracks] [picture]``; prints, for each
parameter, the p-value of the ranks and the share of truths within the central 50 and 90 percent.
"""

from __future__ import annotations

import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import chisquare, kstest

import latolato as ll
from latolato.experiment.fits.model import described
from latolato.experiment.fits.posterior import Density, sampled
from latolato.figures import style
from track_tables import motion_table

# Draws that a rank is counted among, after thinning, and bars of the picture.
RANKS, BARS = 99, 10
TOY = ll.LatoLato(length=0.245, mass=0.106, damping=0.005, radius=0.02, restitution=0.85)
SWING = ll.Pendulum(length=0.363, mass=0.108, damping=0.00274)
CASES: dict[str, dict[str, Any]] = {
    "pair": {
        "system": TOY,
        "drive": ll.Harmonic(drive_amplitude=0.03, drive_frequency=15.1),
        "prior": {"length": 2e-3, "damping": 1e-3, "restitution": 0.03},
        "angles": (0.1, 0.7),
        "duration": 2.0,
    },
    "swing": {
        "system": SWING,
        "drive": ll.Harmonic(drive_amplitude=0.02, drive_frequency=10.09),
        "prior": {"length": 2e-3, "damping": 5e-4},
        "angles": (0.1, 0.6),
        "duration": 3.0,
    },
}


def ranks_of(task: tuple[str, int]) -> dict[str, int] | None:
    """Return the rank of each true parameter among the draws of its posterior."""
    case, seed = task
    about = CASES[case]
    system, drive, prior = about["system"], about["drive"], about["prior"]
    random = np.random.default_rng(7000 + seed)
    truth = {
        name: getattr(system, name) + sigma * random.standard_normal()
        for name, sigma in prior.items()
    }
    table = motion_table(
        replace(system, **truth), drive, initial_angle=random.uniform(*about["angles"]),
        duration=about["duration"], seed=seed, correlation=0.6 * (seed % 2),
    )  # fmt: skip
    found = described(
        table, system, drive, list(prior), ball=None, start=None, end=None, window=None,
        prior=prior, fits_pivot=True,
    )  # fmt: skip
    density = Density(found)
    values, broken = sampled(density, 200, 2, seed)
    flat = values.reshape(-1, values.shape[-1])
    thin = np.random.default_rng(seed).permutation(len(flat))[:RANKS]
    ranks = {
        name: int(np.sum(flat[thin, density.names.index(name)] < value))
        for name, value in truth.items()
    }
    return ranks | {"divergences": int(broken.sum()), "windows": len(found.model.windows)}


def main() -> None:
    """Print the table, and draw the ranks."""
    tracks = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    found: dict[str, list[dict[str, int]]] = {}
    with ProcessPoolExecutor() as pool:
        for case in CASES:
            found[case] = list(pool.map(ranks_of, [(case, seed) for seed in range(tracks)]))
            report(case, found[case])
    if len(sys.argv) > 2:
        draw(found, Path(sys.argv[2]))


def report(case: str, ranks: list[dict[str, int]]) -> None:
    """Print how uniform the ranks of a case are."""
    divergences = sum(each["divergences"] for each in ranks)
    pieces = sum(each["windows"] > 1 for each in ranks)
    print(f"{case}: {len(ranks)} tracks, {divergences} divergences, {pieces} in several pieces")
    for name in CASES[case]["prior"]:
        places = (np.array([each[name] for each in ranks]) + 0.5) / (RANKS + 1)
        counts, _ = np.histogram(places, BARS, (0.0, 1.0))
        middle, most = (float(np.mean(np.abs(places - 0.5) < 0.5 * share)) for share in (0.5, 0.9))
        print(
            f"  {name:12} chi-square p {chisquare(counts).pvalue:.3f}, Kolmogorov p "
            f"{kstest(places, 'uniform').pvalue:.3f}, within 50 %: {middle:.2f}, 90 %: {most:.2f}",
            flush=True,
        )


def draw(found: dict[str, list[dict[str, int]]], path: Path) -> None:
    """Draw the histograms of all ranks, with what chance alone leaves."""
    panels = [(case, name) for case in found for name in CASES[case]["prior"]]
    with style.use_style():
        figure, axes = style.new_figure(1, len(panels), height=1.9, sharey=True)
        for place, (axis, (case, name)) in enumerate(zip(axes[0], panels, strict=True)):
            ranks = [each[name] for each in found[case]]
            usual = len(ranks) / BARS
            width = 2.0 * np.sqrt(usual * (1.0 - 1.0 / BARS))
            axis.axhspan(usual - width, usual + width, color=style.PALE_GREY, lw=0.0)
            axis.axhline(usual, color=style.GREY, lw=style.THIN)
            axis.hist(ranks, BARS, (0, RANKS + 1), color=style.BLUE, rwidth=0.85)
            axis.set_title(f"{case}: {name}")
            axis.set_xlabel("rank of the truth")
            if not place:
                axis.set_ylabel("tracks")
        style.save_figure(figure, path)


if __name__ == "__main__":
    main()
