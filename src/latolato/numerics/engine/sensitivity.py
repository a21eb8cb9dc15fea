"""Derivatives of a motion with respect to parameters, carried along with it.

A parameter changes the numbers that a run reads: of bodies, walls, gravity and drive (`Change`).
The derivative ``s`` of the state with respect to it, at a fixed time, obeys the variational
equation: a step or an event with the tangent map ``M`` makes ``s`` into ``M s + g``, where the
forcing ``g`` is what the parameter does within it. A step's forcing belongs to the very splitting
step (`forces.py`). At an event whose guard ``q(x, t, p) = 0`` the parameter also changes the
instant, by ``dt = -(q_x s + q_p)/(dq/dt)``; a state that is reset there by ``x+ = R(x-, p)`` gains
``R_p + (R_x f- - f+) dt``, with the rates f before and after (Hiskens & Pai, IEEE Trans. Circuits
Syst. I 47 (2000) 204). The part of this that is linear in ``s`` is the saltation matrix, which the
event knows; the delays are found in `parameter_delays.py`, and what remains is written in
`parameter_forcing.py`.

All this holds no more once the motion depends on a parameter in a way that has no derivative, or
one that cannot be trusted: all derivatives are unknown from there on (`doubts.py`).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from latolato.numerics.engine.balls import Balls
from latolato.numerics.engine.doubts import make_doubts
from latolato.numerics.engine.laws import Laws
from latolato.numerics.engine.parameter_delays import make_parameter_delays
from latolato.numerics.engine.parameter_forcing import (
    make_contact_changes,
    make_impact_forcing,
    make_joint_forcing,
    make_segment_forcing,
)
from latolato.numerics.engine.taut_step import TautStep
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import Output, Run


class Sensitivity(NamedTuple):
    """The functions of derivatives; see `make_sensitivity`. No-ops where nothing asks for them."""

    write_sample: Callable[..., None]
    write_delays: Callable[..., None]
    forget_delays: Callable[..., None]
    doubt: Callable[..., None]
    check_start: Callable[..., None]
    check_graze: Callable[..., None]
    reach_contact: Callable[..., None]
    reach_release: Callable[..., None]
    add_contact: Callable[..., None]
    add_impact: Callable[..., None]
    begin_joint: Callable[..., None]
    finish_joint: Callable[..., None]
    note_rates: Callable[..., None]
    add_segment: Callable[..., None]
    check_slack_segment: Callable[..., None]


def _nothing(run: Run, *rest: object) -> None:
    """Do nothing."""


def make_output(
    count: int, part: Part = as_it_stands
) -> tuple[Callable[..., None], Callable[..., None]]:
    """Make the functions that write derivatives at samples and delays of contacts."""
    size = 2 * count

    @part
    def write_sample(run: Run, output: Output, first: int) -> None:
        """Write the derivatives at the next sample, from row `first` on, and forget the forcing.

        Map and forcing are those from the beginning of the step to the sample.
        """
        k = run.state.sample
        for p in range(run.parameters):
            for row in range(size):
                value = run.forcing[row, p]
                for column in range(size):
                    value += run.jacobian[row, column] * run.sensitivity[column, p]
                output.samples[first + size * p + row, k] = value
            for row in range(size):
                run.forcing[row, p] = 0.0

    @part
    def write_delays(run: Run, output: Output, first: int) -> None:
        """Write by how much the present contact is later, from row `first` of the table on."""
        for p in range(run.parameters):
            output.contact_values[first + p, run.rows] = run.delay[p]

    return write_sample, write_delays


def make_sensitivity(
    swing: TautStep, balls: Balls, laws: Laws, count: int, part: Part = as_it_stands
) -> Sensitivity:
    """Make the functions of derivatives of `count` balls, if the laws have their own."""
    if len(laws.changes) == 0:
        return Sensitivity(*[part(_nothing)] * len(Sensitivity._fields))
    write_sample, write_delays = make_output(count, part)
    contacts = make_contact_changes(count, part)
    doubts = make_doubts(balls, contacts.gap_change, count, part)
    delays = make_parameter_delays(swing, contacts.gap_change, count, part)
    impacts = make_impact_forcing(contacts.offsets, count, part)
    joint = make_joint_forcing(contacts.offsets, impacts.add_contact, part)
    segments = make_segment_forcing(balls, doubts.doubt, count, part)
    return Sensitivity(
        write_sample=write_sample,
        write_delays=write_delays,
        **doubts._asdict(),
        **delays._asdict(),
        **impacts._asdict(),
        **joint._asdict(),
        **segments._asdict(),
    )
