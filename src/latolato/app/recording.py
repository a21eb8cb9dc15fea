"""What happened live, kept as a run: the same motion computed anew, or the samples themselves."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from latolato.app.blocks import pack
from latolato.app.runs import USUAL_COLUMNS, about, arrays_of
from latolato.numerics.integrate import Floats, Start, Trajectory
from latolato.numerics.observe import BALL_ROWS, PIVOT_ROWS
from latolato.numerics.prepare import choose_stepper
from latolato.physics.contacts import contact_laws
from latolato.physics.drives import Drive, Harmonic, StagedHarmonic, Stretch
from latolato.physics.pendulum import System
from latolato.scenario.scenario import Scenario
from latolato.simulation.record import attributes_of, record_of

if TYPE_CHECKING:
    import xarray as xr

MOST_SECONDS = 300.0
# A run computed anew that stays this close to what was seen is that run.
SAME = 1e-6  # rad


@dataclass
class Recording:
    """Samples and contacts of a live motion, and the changes of its drive.

    Attributes
    ----------
    system : System
        The system at the start.
    begun : float
        When the recording began, on the clock of the motion [s].
    stage : Stretch
        The drive then, without a change under way.
    run : dict
        The start and the contact law, as arguments of `latolato.simulate`.
    by_hand : bool
        Whether anything but the drive was changed: a push, a drag, damping or restitution.
    """

    system: System
    begun: float
    stage: Stretch
    run: dict[str, Any]
    by_hand: bool = False
    changes: list[tuple[float, float, float, float]] = field(default_factory=list)
    times: list[Floats] = field(default_factory=list)
    samples: list[Floats] = field(default_factory=list)
    pivot: list[Floats] = field(default_factory=list)
    seen: list[Floats] = field(default_factory=list)
    contacts: list[tuple[Floats, Any, Floats]] = field(default_factory=list)

    @property
    def duration(self) -> float:
        """How long it is by now [s]."""
        return float(self.times[-1][-1]) - self.begun if self.times else 0.0

    @property
    def is_full(self) -> bool:
        """Whether it is as long as a recording may be."""
        return self.duration >= MOST_SECONDS

    def add(self, instants: Floats, samples: Floats, pivot: Floats, seen: Floats) -> None:
        """Keep the samples of a tick."""
        self.times.append(instants.copy())
        self.samples.append(samples.copy())
        self.pivot.append(pivot.copy())
        self.seen.append(seen.copy())

    def add_contacts(self, times: Floats, kinds: Any, values: Floats) -> None:
        """Keep rows of the contact table."""
        self.contacts.append((times.copy(), kinds.copy(), values.copy()))

    def steer(self, time: float, amplitude: float, frequency: float, ramp: float) -> None:
        """Keep a change of the drive; of several at one instant the last counts."""
        if self.changes and self.changes[-1][0] == time:
            self.changes.pop()
        self.changes.append((time, amplitude, frequency, ramp))

    def drive(self) -> Drive:
        """Return the drive as a law, its time beginning with the recording."""
        phase = self.stage.phase % (2.0 * math.pi)
        if not self.changes:
            return Harmonic(
                drive_amplitude=self.stage.c0,
                drive_frequency=self.stage.frequency,
                drive_phase=phase,
            )
        rows = [(0.0, self.stage.c0, self.stage.frequency, 1.0)]
        first = [change for change in self.changes if change[0] > self.begun]
        if len(first) < len(self.changes):  # a change at the very start: it cannot be a stage
            self.by_hand = True
        rows += [(time - self.begun, a, w, ramp) for time, a, w, ramp in first]
        times, amplitudes, frequencies, ramps = zip(*rows, strict=True)
        return StagedHarmonic(
            times=times,
            drive_amplitudes=amplitudes,
            drive_frequencies=frequencies,
            ramps=ramps,
            drive_phase=phase,
        )

    def scenario(self) -> Scenario:
        """Return the run that has this start and this drive."""
        run = {**self.run, "duration": self.duration}
        if self.system.has_contacts is False:
            run["contact"] = "none"
        return Scenario(system=self.system, drive=self.drive(), run=run)

    def to_dataset(self) -> xr.Dataset:
        """Return the samples themselves as a dataset that looks like a run."""
        times = np.concatenate(self.times) - self.begun
        seen = np.concatenate(self.seen, axis=2)
        result: dict[str, Any] = {}
        result.update(zip(PIVOT_ROWS, np.concatenate(self.pivot, axis=1), strict=True))
        result.update({name: seen[:, row] for row, name in enumerate(BALL_ROWS)})
        result["total_energy"] = result["kinetic_energy"] + result["potential_energy"]
        none = (np.empty(0), np.empty(0, dtype=np.int64), np.empty((4, 0)))
        rows = [none, *self.contacts]
        trajectory = Trajectory(
            samples=np.concatenate(self.samples, axis=1),
            contact_times=np.concatenate([r[0] for r in rows]) - self.begun,
            contact_kinds=np.concatenate([r[1] for r in rows]),
            contact_values=np.concatenate([r[2] for r in rows], axis=1),
            state=None,
            reached=float(times[-1]),
            step=math.nan,
            stepper=choose_stepper(self.system),
            status="complete",
            failed=False,
            slots=np.empty((0, 1)),
        )
        angles, velocities = self.run["initial_angle"], self.run["initial_angular_velocity"]
        if self.system.angles == 1:
            angles, velocities = (angles,), (velocities,)
        law = contact_laws[self.run["contact"]]()
        start = Start(tuple(angles), tuple(velocities))
        run = {"rest_speed": self.run["rest_speed"]}
        attrs = attributes_of(self.system, self.drive(), law, None, start, float(times[-1]), run)
        # It would make another motion: hands are no part of a scenario.
        del attrs["scenario"]
        attrs.update(status="complete", contacts=len(trajectory.contact_times))
        dataset = record_of(self.system, trajectory, result, times, "pivot", attrs).to_dataset()
        if "noise_work" in dataset:
            dataset["noise_work"].attrs["long_name"] = "work of the hand"
        return dataset


@dataclass(frozen=True)
class Kept:
    """A recording that has become a run.

    Attributes
    ----------
    run : xarray.Dataset
        The run.
    about : dict
        What the pages tell of it; its entry ``reproduces`` says whether the scenario makes it.
    scenario : Scenario
        System, drive and start.
    """

    run: xr.Dataset
    about: dict[str, Any]
    scenario: Scenario

    def block(self) -> bytes:
        """Return the run as a block, as those of Play are."""
        return pack(self.about, arrays_of(self.scenario, self.run, USUAL_COLUMNS))


def keep(recording: Recording) -> Kept:
    """Return the run that a recording is.

    If only the drive was changed, the run is computed anew with the drive as a law: the same
    motion as was seen, or, where it is chaotic, one that parts from it, which is told.
    """
    samples = recording.to_dataset()
    scenario = recording.scenario()
    gap, run = math.nan, samples
    if not recording.by_hand:
        again = scenario.simulate(times=samples["time"].values.copy())
        gap = float(np.abs(again["angle"].values - samples["angle"].values).max())
        if gap <= SAME:
            run = again
    reproduces = run is not samples
    told = about(scenario, run)
    if not reproduces:
        told.update(python="", command="")
        run.attrs["note"] = (
            "recorded live: it holds what a hand did, and no scenario makes it again"
            if recording.by_hand
            else "recorded live: the motion is chaotic, and computed anew it parts from this one"
        )
    told.update(
        title="live", warnings=[], wall_time=0.0, recorded=True, reproduces=reproduces,
        by_hand=recording.by_hand, gap=gap, note=run.attrs.get("note", ""),
    )  # fmt: skip
    return Kept(run, told, scenario)
