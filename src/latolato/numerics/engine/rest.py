"""Rest: one ball lies on a wall until gravity and drive pull it away."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from latolato.numerics.engine.compiling import Part, as_it_stands
from latolato.numerics.engine.held import Held
from latolato.numerics.engine.look import Look
from latolato.numerics.engine.modes import Mode
from latolato.numerics.engine.record import RELEASE, REST
from latolato.numerics.matrices import clear_matrix
from latolato.numerics.watch import Eyes


def make_rest(held: Held, look: Look, part: Part = as_it_stands) -> Mode:
    """Return the mode of one ball at rest; its step reaches to the release or to the goal."""

    @part
    def plan(run: Any) -> None:
        """Wait for the release."""
        state = run.state
        begin = max(run.t, min(state.held_until, run.goal))
        release = held.release_time(run, 0, state.side, run.now[0].angle, begin, run.goal)
        run.is_whole = 0
        run.t_end = run.goal
        if release <= run.goal:
            run.t_end, run.event = release, RELEASE
        run.length = run.t_end - run.t
        run.work = run.loss = run.work_inside = run.loss_inside = 0.0
        run.end[0] = run.now[0]
        run.inside[0] = run.now[0]

    @part
    def look_inside(run: Any, length: float) -> None:
        """Do nothing: the ball is where it is."""

    @part
    def note(run: Any, eyes: Eyes) -> None:
        """Note compression and the time at rest; the motion forgets its past."""
        if run.settings.follows_tension != 0 and run.settings.is_string == 0:
            held.note_compression(run, 0, run.now[0].angle)
        look.step(run, eyes, 0, 0.0, 0.0, 1.0)
        clear_matrix(run.jacobian, 2)
        look.matrix(run, eyes, 2, run.length, -math.inf)

    functions: tuple[Callable[..., Any], ...] = (plan, look_inside, note)
    return Mode(REST, *functions)
