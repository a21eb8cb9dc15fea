"""What a page asks of a map, and the plan of a sweep that it stands for."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from latolato.app.given import MOST_STEPS, RunRequest, TooLargeError, options_of
from latolato.app.map_choices import (
    Span,
    about_axis,
    moving_drive,
    spans_of,
    suggested_range,
    watched_of,
)
from latolato.core.errors import InputError
from latolato.core.quantities import ANY
from latolato.core.registry import checked_count, checked_number, suggest
from latolato.observables import Observable
from latolato.scenario.scenario import Scenario
from latolato.sweeps.axes import parameters_of
from latolato.sweeps.batches import has_lanes
from latolato.sweeps.plan import Plan
from latolato.sweeps.points import make_batch, stepper_of

MOST_CELLS = 500 * 500
MOST_ALONG = 1000
# Some ten minutes of two cores. A step of a single trajectory costs as much as several in lanes.
MOST_STEPS_OF_MAP = 1e10
SINGLE_COST = 5.0
USUAL_CELLS = 200
USUAL_TOLERANCE = 1e-6
# Points along each axis at which steps are counted before a map is begun.
_PROBES = 7
_POINT = "point"
_OF_RUN = ("times", "frame", "tolerance")


@dataclass(frozen=True, kw_only=True)
class MapRequest:
    """What a page asks for; None leaves the choice to what the scenario says."""

    request: RunRequest
    x: Span | None = None
    y: Span | None = None
    observable: str | None = None
    width: int = USUAL_CELLS
    height: int = USUAL_CELLS
    duration: float | None = None
    transient: float | None = None
    tolerance: float = USUAL_TOLERANCE

    @classmethod
    def from_json(cls, value: Any) -> MapRequest:
        """Return what a page asks for.

        Raises
        ------
        InputError
            For unknown entries and values of another kind.
        TooLargeError
            For more cells than are drawn.
        """
        request = RunRequest.from_json(value)
        names = [f.name for f in fields(cls) if f.name != "request"]
        given = {k: v for k, v in value.items() if v is not None}
        for name in given:
            if name not in (*names, "scenario", "options"):
                raise InputError(f"unknown entry '{name}' of a map: {suggest(name, names)}")
        results: dict[str, Any] = {"request": request}
        for which in ("x", "y"):
            if which in given:
                results[which] = Span.from_json(which, given[which])
        if "observable" in given:
            if not isinstance(given["observable"], str):
                raise InputError(
                    "must be a text", parameter="observable", value=given["observable"]
                )
            results["observable"] = given["observable"]
        for name in ("width", "height"):
            if name in given:
                results[name] = checked_count(name, given[name])
                if results[name] > MOST_ALONG:
                    raise TooLargeError(
                        f"must not exceed {MOST_ALONG}, got {results[name]}", parameter=name
                    )
        for name, unit in (("duration", "s"), ("transient", "s"), ("tolerance", "rad")):
            if name in given:
                results[name] = checked_number(name, given[name], ANY, unit)
        result = cls(**results)
        if result.width * result.height > MOST_CELLS:
            raise TooLargeError(
                f"width x height must not exceed {MOST_CELLS} cells, got "
                f"{result.width * result.height}"
            )
        return result


@dataclass(frozen=True)
class Map:
    """A map to be computed: the scenario, both axes, and what is gathered at every point."""

    request: MapRequest
    scenario: Scenario
    x: Span
    y: Span
    shown: str
    watched: tuple[str | Observable, ...]
    duration: float
    transient: float
    choices: dict[str, Any] = field(repr=False)

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.request.height, self.request.width

    @cached_property
    def grid(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Values along x and y."""
        return self.x.values(self.request.width), self.y.values(self.request.height)

    def plan_of(self, cells: NDArray[np.int64], chunk_size: int | None = None) -> Plan:
        """Return the plan of a sweep over these cells, numbered row by row from the bottom left.

        Noise is that of the same cell in a sweep over both axes.
        """
        x, y = self.grid
        row, column = np.divmod(cells, self.request.width)
        along = {self.x.name: x[column].tolist(), self.y.name: y[row].tolist()}
        noise = self.scenario.run.get("noise")
        if noise is not None and not {"noise_seed", "noise_stream"} & along.keys():
            along["noise_stream"] = (noise.noise_stream + cells).tolist()
        return self._plan({_POINT: along}, chunk_size)

    def plan_at(self, x: float, y: float) -> Plan:
        """Return the plan of the one point at these values."""
        return self._plan({_POINT: {self.x.name: [x], self.y.name: [y]}}, None)

    @cached_property
    def plan(self) -> Plan:
        """The whole map as one sweep, first the axis upwards."""
        x, y = self.grid
        return self._plan({self.y.name: y, self.x.name: x}, None)

    def _plan(self, axes: dict[str, Any], chunk_size: int | None) -> Plan:
        run = {k: v for k, v in self.scenario.run.items() if k not in _OF_RUN}
        if {"initial_angle", "initial_offset"} & {self.x.name, self.y.name}:
            run = {k: v for k, v in run.items() if k not in ("initial_angle", "initial_offset")}
        run |= {"duration": self.duration, "tolerance": self.request.tolerance}
        changed = {"axes": axes, **self.varied(chunk_size)}
        return replace(self.scenario, run=run, varied=changed).plan()

    def varied(self, chunk_size: int | None = None) -> dict[str, Any]:
        """Return what is gathered, and how."""
        varied: dict[str, Any] = {"observables": self.watched, "transient": self.transient}
        periods = self.scenario.varied.get("transient_periods")
        if periods and self.request.transient is None:
            varied["transient_periods"] = periods
        if chunk_size is not None:
            varied["chunk_size"] = chunk_size
        return varied

    def cost_of_point(self) -> float:
        """Return the mean cost of a point, in steps in lanes.

        Raises
        ------
        TooLargeError
            If the whole map, or one of its points, would take too long.
        InputError
            If no point can run, saying why.
        """
        height, width = self.shape
        rows = np.unique(np.linspace(0, height - 1, _PROBES).round().astype(int))
        columns = np.unique(np.linspace(0, width - 1, _PROBES).round().astype(int))
        plan = self.plan_of((rows[:, None] * width + columns).ravel())
        batch = make_batch(plan, np.arange(plan.size), stepper_of(plan))
        if not batch.valid.any():
            raise InputError(batch.reason)
        steps = plan.duration / batch.points.settings["step"][batch.valid]
        if steps.max() > MOST_STEPS:
            raise TooLargeError(
                f"a point of this map would take {steps.max():.2g} steps, the limit is "
                f"{MOST_STEPS:g}: shorten the duration, loosen the tolerance or slow the drive"
            )
        cost = float(steps.mean()) * (1.0 if has_lanes(plan) else SINGLE_COST)
        total = cost * width * height
        if total > MOST_STEPS_OF_MAP:
            raise TooLargeError(
                f"the map would take {total:.2g} steps, the limit is {MOST_STEPS_OF_MAP:g}: fewer "
                "points, a shorter duration or a looser tolerance"
            )
        return cost


def _check_times(duration: float, transient: float) -> None:
    """Raise InputError unless runs last and something of them is left."""
    if not duration > 0.0:
        raise InputError(f"each run must last longer than 0 s, got {duration:g} s")
    if not transient >= 0.0:
        raise InputError(f"what is left out must be at least 0 s, got {transient:g} s")
    if transient >= duration:
        raise InputError(
            f"what is left out must be shorter than a run of {duration:g} s, got {transient:g} s"
        )


def make_map(request: MapRequest) -> Map:
    """Return the map that a page asks for.

    Raises
    ------
    InputError
        For bad input.
    """
    scenario = request.request.to_scenario()
    scenario = replace(scenario, drive=moving_drive(scenario))
    run, system, varied = scenario.run, scenario.system, scenario.varied
    known = parameters_of(system, scenario.drive, run.get("noise"))
    times = run.get("times")
    duration = run.get("duration") or (times[-1] if times else 60.0)
    if request.duration is not None:
        duration = request.duration
    transient = varied.get("transient", 0.0) if request.transient is None else request.transient
    _check_times(float(duration), float(transient))
    watched, shown, variables = watched_of(varied, request.observable, system.angles)
    spans = spans_of(known, scenario, (request.x, request.y))
    choices = {
        "axes": [
            about_axis(name, known[name], suggested_range(name, known, scenario)) for name in known
        ],
        "variables": variables,
        "x": vars(spans[0]),
        "y": vars(spans[1]),
        "observable": shown,
        "duration": float(duration),
        "transient": float(transient),
        "tolerance": request.tolerance,
        "options": options_of(scenario),
        "scenario": scenario.name,
        "title": scenario.title,
        "description": scenario.description,
    }
    return Map(
        request=request,
        scenario=scenario,
        x=spans[0],
        y=spans[1],
        shown=shown,
        watched=watched,
        duration=float(duration),
        transient=float(transient),
        choices=choices,
    )
