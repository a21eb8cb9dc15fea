"""Samples of a trajectory and its energy ledger."""

from __future__ import annotations

import math

from latolato.core.scalar import formula
from latolato.numerics.engine.slack_step import radial_rate
from latolato.numerics.records import (
    S_CAPTURED,
    S_DAMPED,
    S_DISTANCE,
    S_IMPACT,
    S_MODE,
    S_NOISE,
    S_RETENSION,
    S_WORK,
)
from latolato.numerics.run_record import Output, Point, Run, State


@formula
def write_sample(
    run: Run, output: Output, points: list[Point], count: int, work: float, loss: float
) -> None:
    """Write the next sample: the state of the balls, then the ledger.

    Work and loss are those of the step up to the sample [J].
    """
    state, k, samples = run.state, run.state.sample, output.samples
    for i in range(count):
        samples[2 * i, k], samples[2 * i + 1, k] = points[i].angle, points[i].velocity
    samples[S_WORK, k] = state.drive_work + work
    samples[S_DAMPED, k] = state.damping_loss + loss
    samples[S_IMPACT, k], samples[S_CAPTURED, k] = state.impact_loss, state.capture_loss
    samples[S_NOISE, k], samples[S_MODE, k] = state.noise_work, state.mode
    state.sample += 1


@formula
def write_place(run: Run, output: Output, points: list[Point], count: int) -> None:
    """Write the rest of the next sample of a motion in the plane; before `write_sample`."""
    state, k, samples = run.state, run.state.sample, output.samples
    for i in range(count):
        row, is_slack = S_DISTANCE + 3 * i, state.is_slack[i] != 0
        distance = math.hypot(points[i].x, points[i].y)
        samples[row, k] = distance if is_slack else 1.0 / run.bodies[i].inverse_length
        samples[row + 1, k] = radial_rate(points[i]) if is_slack else 0.0
        samples[row + 2, k] = 1.0 if is_slack else 0.0
    samples[S_RETENSION, k] = state.retension_loss


@formula
def follow_ledger(state: State, energy: float) -> None:
    """Update the largest energy and the largest error of the ledger after a step [J]."""
    state.largest_energy = max(state.largest_energy, energy)
    gained = state.drive_work + state.noise_work - state.damping_loss
    gained -= state.impact_loss + state.capture_loss + state.retension_loss
    error = abs(energy - state.first_energy - gained)
    state.ledger_error = max(state.ledger_error, error)


# A run whose ledger closes worse than this many tolerances is repeated with half the step, unless
# it has been so often or had too many steps.
_LEDGER_MARGIN = 5.0
MOST_HALVINGS = 3
MOST_STEPS_TO_REPEAT = 20_000_000
# Below these shares of the largest energy and of all losses the ledger measures rounding, not the
# step.
_ROUNDING = 2e-12
_ROUNDING_OF_SUMS = 1e-13


@formula
def allowed_error(state: State, tolerance: float) -> float:
    """Error of the ledger up to which a run keeps its tolerance [J]."""
    gone = state.damping_loss + state.impact_loss + state.capture_loss + state.retension_loss
    share = max(_LEDGER_MARGIN * tolerance, _ROUNDING)
    return max(share * state.largest_energy, _ROUNDING_OF_SUMS * gone)
