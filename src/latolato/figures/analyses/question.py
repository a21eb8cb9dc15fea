"""An analysis as a question: in whose words it is asked, when it can be, and what it costs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from latolato.core.errors import InputError
from latolato.figures.plot import module_of

if TYPE_CHECKING:
    import xarray as xr

LONG_RUN = "What does it do in the long run?"
BEGINNING = "How does it get going?"
REST = "When does rest become unstable?"
DISTURBANCE = "What do small disturbances do?"
# In the order of a page.
GROUPS = (LONG_RUN, BEGINNING, REST, DISTURBANCE)

# Says why a question does not suit a system and drive, None if it does.
Condition = Callable[[Any, Any], str | None]


@dataclass(frozen=True, kw_only=True)
class Cost:
    """What the time of an answer depends on.

    Attributes
    ----------
    counts : tuple of str
        Options that multiply the work.
    lengths : mapping of str to int
        How many values of a list are tried where none are given.
    most_shakes : int
        To so many drive periods the form lengthens a transient in which motion has not settled.
    decay_times : float
        So many decay times last the runs that the form begins with, if the drag is known.
    """

    counts: tuple[str, ...] = ()
    lengths: Mapping[str, int] = field(default_factory=dict)
    most_shakes: int = 0
    decay_times: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Question:
    """An analysis in the words of a page: what `QUESTION` is in the module of its picture.

    Attributes
    ----------
    group : str
        One of `GROUPS`.
    place : int
        Smaller ones come first in a group.
    title, reading : str
        The question, and what its picture shows and how to read it.
    term : str
        What physicists call it.
    first : tuple of str
        Options that are shown at once; others are folded.
    quick : mapping of str to str
        What options begin with here, where defaults are for a machine left alone; ``{ratios}``
        and ``{amplitudes}`` stand for usual ranges about those of the drive.
    conditions : tuple of callable
        What system and drive must have.
    cost : Cost
        What the time of an answer depends on.
    labels : mapping of str to str
        Of options that only this analysis has and that are no quantities.
    verdict : callable
        Returns the answer in one sentence.
    """

    group: str
    place: int = 100
    title: str
    term: str
    reading: str
    first: tuple[str, ...]
    quick: Mapping[str, str] = field(default_factory=dict)
    conditions: tuple[Condition, ...] = ()
    cost: Cost = field(default_factory=Cost)
    labels: Mapping[str, str] = field(default_factory=dict)
    verdict: Callable[[xr.Dataset], str]

    def unfit(self, system: Any, drive: Any) -> str | None:
        """Return why this cannot be asked of a system and a drive, None if it can."""
        return next((why for each in self.conditions if (why := each(system, drive))), None)


def question_of(name: str) -> Question:
    """Return the question of an analysis.

    Raises
    ------
    InputError
        If it has no picture, and so no words.
    """
    question: Question = module_of("analysis", name).QUESTION
    return question


def all_questions() -> dict[str, Question]:
    """Return the question of each analysis by its name, in the order in which a page lists them."""
    from latolato.analysis import analyses

    questions = {name: question_of(name) for name in analyses}
    order = sorted(questions, key=lambda n: (GROUPS.index(questions[n].group), questions[n].place))
    return {name: questions[name] for name in order}


def settles(system: Any, drive: Any) -> str | None:
    """Say whether there is a motion that lasts."""
    if system.is_linear:
        return "The Mathieu equation only grows or decays: choose a pendulum or a toy."
    return None


def is_shaken(system: Any, drive: Any) -> str | None:
    """Say whether the pivot repeats the same movement."""
    from latolato.physics.drives import PeriodicDrive

    if not isinstance(drive, PeriodicDrive) or drive.drive_frequency == 0.0:
        return "The pivot must be shaken evenly: choose the drive Harmonic or CrankSlider."
    return None


def is_even(system: Any, drive: Any) -> str | None:
    """Say whether the pivot rests or repeats the same movement."""
    return is_shaken(system, drive) if drive.moves else None


def ends_as_cosine(system: Any, drive: Any) -> str | None:
    """Say whether the pivot ends up moving as a cosine."""
    from latolato.analysis.shortest_protocol import last_cosine

    last = last_cosine(drive)
    if last is None or last.frequency == 0.0 or drive.moves_across:
        return "The pivot must end up moving as a cosine: choose the drive Harmonic."
    return None


def has_contacts(system: Any, drive: Any) -> str | None:
    """Say whether there are two balls."""
    if not system.has_contacts:
        return "This question needs two balls that collide: choose LatoLato or BallPair."
    return None


def on_rods(system: Any, drive: Any) -> str | None:
    """Say whether the balls hang on rods."""
    if system.suspension == "string":
        return "This question needs rods: on strings, more than angle and speed matters."
    return None


def drags_with_pivot(system: Any, drive: Any) -> str | None:
    """Say whether the air moves with the pivot."""
    from latolato.analysis.checks import check_drag

    try:
        check_drag(system)
    except InputError:
        return "This question needs air that moves with the pivot: choose that, or no damping."
    return None


def is_toy(system: Any, drive: Any) -> str | None:
    """Say whether it is the toy with two equal balls."""
    from latolato.physics.pendulum import LatoLato

    if not isinstance(system, LatoLato):
        return "This question needs two equal balls: choose LatoLato."
    return None


def _is_free(position: str) -> Condition:
    def check(system: Any, drive: Any) -> str | None:
        from latolato.analysis.linear import linearised

        if system.has_contacts:
            where = "hang straight down" if position == "hanging" else "stand upright"
            return f"This question needs one ball: two balls touch before they {where}."
        if position == "inverted" and system.is_linear:
            return "The Mathieu equation has no upright position: choose a pendulum."
        try:
            linearised(system, drive if drive.moves else None, position)
        except InputError as error:
            return f"{str(error)[:1].upper()}{str(error)[1:]}."
        return None

    return check


can_hang = _is_free("hanging")
can_stand = _is_free("inverted")
