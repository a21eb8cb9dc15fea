"""Which of the paper's figures would notice if the air rested in the room, not with the pivot.

Runs every exact damped run behind the paper's figures again with ``drag_frame="lab"``, and prints
how its largest angle, mean energy and angle at equal times change. Beside them stand the largest
changes that starts moved by up to 1e-8 rad make: where these are as large, the motion is chaotic,
and only its statistics could tell. Then makes the figures' data again (``--full``: on their full
grids), and prints each number that a claim of the paper is judged by and that moves by more than
1e-3, and each verdict that moves. Figs. 5, 7 and 10 have no drag or no drive and cannot notice.
Fig. 4 is judged by its runs alone, as its clamped contacts know the paper's drag only.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from typing import Any
from unittest.mock import patch

import numpy as np

from latolato.paper import catalogue
from latolato.paper import systems as paper
from latolato.scenario.scenario import Scenario

RUNS = ("fig02", "fig03", "fig04", "fig06", "fig08", "fig12", "fig13")
JUDGED = ("fig02", "fig03", "fig03cd", "fig06", "fig08", "fig09", "fig11", "fig12", "fig13")
SYSTEMS = ("PENDULUM", "UNDAMPED", "TOY", "SINGLE", "COUPLED")
MAPPED = {"crossings": 0.0, "motion_class": 0.5}  # variables of maps, and what divides them
SAMPLES = 8001
MOVED = 1e-9 * np.arange(1, 11)  # rad
NOTICED = 1e-3


@contextmanager
def air_in_the_room() -> Iterator[None]:
    """Give every system of the paper drag relative to the room."""
    with ExitStack() as stack:
        for name in SYSTEMS:
            system = replace(getattr(paper, name), drag_frame="lab")
            stack.enter_context(patch.object(paper, name, system))
        yield


def changes(one: Any, two: Any) -> tuple[float, float, float]:
    """Return the relative changes of largest angle, mean energy and angle at equal times."""
    largest = [float(np.abs(run.angle).max()) for run in (one, two)]
    energy = [float(run.total_energy.mean()) for run in (one, two)]
    angle = float(np.abs(one.angle - two.angle).max()) / max(largest)
    return largest[1] / largest[0] - 1.0, energy[1] / energy[0] - 1.0, angle


def print_runs() -> None:
    """Print the changes of each run, and those that a moved start makes."""
    columns = f"{'largest angle':>14} {'mean energy':>14} {'angle(t)':>10}"
    print(f"{'figure':8} {'case':14} {columns} | start moved: {columns}")
    for name in RUNS:
        dataset = catalogue.evidence()[name].data(quick=True)
        for case, text in zip(dataset.case.values, dataset.scenario.values, strict=True):
            document = json.loads(str(text))
            scenario = Scenario.from_dict(document)
            system, run = scenario.system, scenario.run
            is_clamped = document["run"]["contact"] == "clamp"
            if system.is_linear or system.balls[0].damping == 0.0 or is_clamped:
                continue
            room = replace(scenario, system=replace(system, drag_frame="lab"))
            times = np.linspace(0.0, run["duration"], SAMPLES)
            one, two = (each.simulate(times=times) for each in (scenario, room))
            if np.ptp(two.angle.values) == 0.0:  # an elastic ball a little above a wall never rests
                print(f"{name:8} {case:14} at rest in both")
                continue
            moved = [
                changes(one, replace(scenario, run=start).simulate(times=times))
                for start in ({**run, "initial_angle": run["initial_angle"] + by} for by in MOVED)
            ]
            cells = [
                f"{a:14.1e} {b:14.1e} {c:10.1e}"
                for a, b, c in (changes(one, two), np.abs(moved).max(axis=0))
            ]
            print(f"{name:8} {case:14} {cells[0]} |              {cells[1]}", flush=True)


def print_judged(quick: bool) -> None:
    """Print the judged numbers and the verdicts that move."""
    for name in JUDGED:
        evidence = catalogue.evidence()[name]
        one = evidence.data(quick)
        with air_in_the_room():
            two = evidence.data(quick)
        before, after = (evidence.numbers(each) for each in (one, two))
        limits = {each.number for one in evidence.statements for each in one.limits}
        change = {key: after[key] / before[key] - 1.0 for key in sorted(limits) if before[key]}
        moved = {key: value for key, value in change.items() if abs(value) > NOTICED}
        print(f"{name}: {len(moved)} of {len(limits)} judged numbers move by more than {NOTICED:g}")
        for key, value in moved.items():
            print(f"    {key}: {before[key]:.6g} to {after[key]:.6g} ({value:+.1e})")
        for key, floor in MAPPED.items():
            for case in one.case.values if key in one else ():
                above = [each[key].sel(case=case).values > floor for each in (one, two)]
                changed = float((above[0] != above[1]).mean())
                print(f"    {case}: {key} passes {floor:g} only in one frame at {changed:.2%}")
        for each in evidence.statements:
            verdicts = [each.judge(numbers).verdict.value for numbers in (before, after)]
            if verdicts[0] != verdicts[1]:
                print(f"    verdict of {each.name}: {verdicts[0]} to {verdicts[1]}", flush=True)


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--full", action="store_true", help="on the full grids of the figures")
    options = parser.parse_args()
    print_runs()
    print_judged(quick=not options.full)


if __name__ == "__main__":
    main()
