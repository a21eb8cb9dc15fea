"""Which of the paper's figures would notice if the air rested in the room, not with the pivot.

Runs every exact damped run behind the paper's figures again with ``drag_frame="lab"``, and the
damped map of Fig. 9 and the response curve of Fig. 11, and prints the largest changes: of the
largest angle and of the mean energy, both relative, and of the angle at equal times. Chaotic motion
changes its angles whatever else changes; there only the first two say something.
"""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np

import latolato as ll
from latolato.figures import catalogue
from latolato.figures import paper_systems as paper
from latolato.scenario.scenario import Scenario

FIGURES = ("fig02", "fig03", "fig04", "fig06", "fig08", "fig12", "fig13")
SAMPLES = 8001


def changes(text: str) -> tuple[float, float, float] | None:
    """Return the three changes of a run, None where the frame plays no part in it."""
    scenario = Scenario.from_dict(json.loads(text))
    system = scenario.system
    is_clamped = scenario.run.get("contact", "exact") != "exact"
    if system.is_linear or system.balls[0].damping == 0.0 or is_clamped:
        return None
    other = replace(scenario, system=replace(system, drag_frame="lab"))
    times = np.linspace(0.0, scenario.run["duration"], SAMPLES)
    one, two = (each.simulate(times=times) for each in (scenario, other))
    largest = [float(np.abs(run.angle).max()) for run in (one, two)]
    energy = [float(run.total_energy.mean()) for run in (one, two)]
    angle = float(np.abs(one.angle - two.angle).max()) / max(largest)
    return (largest[1] / largest[0] - 1.0, energy[1] / energy[0] - 1.0, angle)


def responses() -> dict[str, tuple[float, float]]:
    """Return how the small colliding pair's response changes: peak and its place, relative."""
    ratios = np.linspace(1.4, 3.4, 201)
    peaks = []
    for system in (paper.COUPLED, replace(paper.COUPLED, drag_frame="lab")):
        grid = ll.sweep(
            system,
            ll.Harmonic(drive_amplitude=paper.COUPLED_AMPLITUDE, drive_frequency=1.0),
            axes={"frequency_ratio": ratios},
            duration=300.0,
            transient=200.0,
            initial_offset=0.2,
            observables=["largest_angle_after_transient"],
        )
        angle = grid.largest_angle_after_transient.values
        peaks.append((float(angle.max()), float(ratios[np.argmax(angle)]), angle))
    moved = float(np.median(np.abs(peaks[1][2] - peaks[0][2])))
    return {"peak": peaks[0][:2], "peak in the room": peaks[1][:2], "median change": (moved, 0.0)}


def main() -> None:
    """Print the table."""
    print(f"{'figure':8} {'case':16} {'largest angle':>14} {'mean energy':>14} {'angle(t)':>10}")
    for name in FIGURES:
        dataset = catalogue.evidence()[name].data(quick=True)
        for case, text in zip(dataset.case.values, dataset.scenario.values, strict=True):
            found = changes(str(text))
            if found:
                print(f"{name:8} {case:16} {found[0]:14.1e} {found[1]:14.1e} {found[2]:10.1e}")
    for name, values in responses().items():
        print(name, *values)


if __name__ == "__main__":
    main()
