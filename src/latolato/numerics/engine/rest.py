"""Rest: one ball lies on a wall until gravity and drive pull it away."""

from __future__ import annotations

import math

from latolato.numerics.callbacks import Accumulators
from latolato.numerics.engine.modes import Mode
from latolato.numerics.engine.report import Report
from latolato.numerics.engine.sensitivity import Sensitivity
from latolato.numerics.engine.stiction import Stiction
from latolato.numerics.matrices import clear_matrix
from latolato.numerics.parts import Part, as_it_stands
from latolato.numerics.run_record import RELEASE, REST, Run


def make_rest(
    stiction: Stiction, report: Report, sensitivity: Sensitivity, part: Part = as_it_stands
) -> Mode:
    """Make the mode of one ball at rest; its step reaches to the release or to the goal."""
    add_contact = sensitivity.add_contact

    @part
    def plan(run: Run) -> None:
        """Wait for the release."""
        state = run.state
        begin = max(run.t, min(state.held_until, run.goal))
        release = stiction.release_time(run, 0, state.side, run.now[0].angle, begin, run.goal)
        run.is_whole = 0
        run.t_end = run.goal
        if release <= run.goal:
            run.t_end, run.event = release, RELEASE
        run.length = run.t_end - run.t
        run.work = run.loss = run.work_inside = run.loss_inside = 0.0
        run.end[0] = run.now[0]
        run.inside[0] = run.now[0]

    @part
    def write_tangent(run: Run, length: float) -> None:
        """Write that nothing of a perturbation remains; the ball moves with the wall."""
        clear_matrix(run.jacobian, 2)
        add_contact(run, run.state.side)

    @part
    def evaluate_inside(run: Run, length: float) -> None:
        """Do nothing: the ball is where it is."""

    @part
    def note(run: Run, accumulators: Accumulators) -> None:
        """Note compression and the time at rest; the motion forgets its past."""
        if run.settings.follows_tension != 0 and run.settings.is_string == 0:
            stiction.note_compression(run, 0, run.now[0].angle)
        report.step(run, accumulators, 0, 0.0, 0.0, 1.0)
        write_tangent(run, run.length)
        report.matrix(run, accumulators, 2, run.length, -math.inf)

    return Mode(REST, plan, evaluate_inside, note, write_tangent)
