"""The contact word: which impacts, rests and slackness one period of the response consists of."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

from latolato.core.errors import InputError
from latolato.core.quantities import Quantity
from latolato.core.scalar import floor, formula
from latolato.observables.base import Outcome, Step, observables
from latolato.observables.period import REPEATS, Watched, marks_of
from latolato.physics.contacts import BOTTOM, REST, SLACK, TOP

# The letters in the order of their digits.
LETTERS = "BTRS"
# A word is a number in base 4, its letters' digits behind a leading 1: 26 letters fill 53 bits.
MOST_LETTERS = 26
_BASE = 4.0
# The codes without letters: contacts that go on and do not repeat, and none at all.
NO_WORD, EMPTY_WORD = 0.0, 1.0
_REST_WORD = _BASE + 2.0
_NAMES = {NO_WORD: "no word", EMPTY_WORD: "no contact"}

# Twice the longest word, so that it is seen to repeat.
_HELD_LETTERS = 2 * MOST_LETTERS
# Slots: the two parameters and the word; the times of the first and the last mark; whether the ball
# is held; how many letters are stored. Impacts on one side are not stored before another letter
# follows, because a rest would make one letter of them: their letter, their number, and the time
# and velocity of the first. Letters count from 1, so that 0 is none.
_LONGEST, _TOLERANCE, _WORD, _FIRST_MARK, _LAST_MARK, _HELD, _STORED = range(7)
_SIDE, _SAME, _FIRST_TIME, _FIRST_VELOCITY = range(7, 11)
# Then rings: letters, times and velocities of the stored; times and velocities of those impacts.
_RINGS = 11
_SLOTS = _RINGS + 5 * _HELD_LETTERS


@formula
def _place(ring: int, k: int) -> int:
    """Return the slot of entry k of a ring."""
    return _RINGS + ring * _HELD_LETTERS + k % _HELD_LETTERS


@formula
def _store(acc: Any, i: int, n: int, letter: float, t: float, velocity: float) -> None:
    """Store a letter."""
    k = int(acc[i + _STORED * n])
    acc[i + _place(0, k) * n] = letter
    acc[i + _place(1, k) * n] = t
    acc[i + _place(2, k) * n] = velocity
    acc[i + _STORED * n] = k + 1.0


@formula
def _store_repeats(acc: Any, i: int, n: int) -> None:
    """Store the impacts on one side, the last ones where there are many, and forget them."""
    repeats = int(acc[i + _SAME * n])
    for k in range(max(repeats - _HELD_LETTERS, 0), repeats):
        t, velocity = acc[i + _place(3, k) * n], acc[i + _place(4, k) * n]
        _store(acc, i, n, acc[i + _SIDE * n], t, velocity)
    acc[i + _SAME * n] = 0.0


@formula
def _store_first(acc: Any, i: int, n: int) -> None:
    """Store the first of the impacts on one side, if there are any, and forget them."""
    if acc[i + _SAME * n] > 0.0:
        first = acc[i + _FIRST_TIME * n], acc[i + _FIRST_VELOCITY * n]
        _store(acc, i, n, acc[i + _SIDE * n], first[0], first[1])
    acc[i + _SAME * n] = 0.0


@formula
def _last_letter(acc: Any, i: int, n: int) -> float:
    """Return the letter stored last, 0 without any."""
    k = int(acc[i + _STORED * n])
    return acc[i + _place(0, k - 1) * n] if k > 0 else 0.0


@formula
def _step(acc: Any, i: int, n: int, s: Step) -> None:
    """Note whether the ball is held."""
    acc[i + _HELD * n] = s.held


@formula
def _contact(
    acc: Any, i: int, n: int, t: float, kind: int, before: float, after: float, closing: float
) -> None:
    """Note an impact, a rest, which ends a chattering sequence, or slackness."""
    if kind in (BOTTOM, TOP):
        letter = 1.0 if kind == BOTTOM else 2.0
        if acc[i + _SIDE * n] != letter:
            _store_repeats(acc, i, n)
        k = int(acc[i + _SAME * n])
        if k == 0:
            acc[i + _SIDE * n] = letter
            acc[i + _FIRST_TIME * n], acc[i + _FIRST_VELOCITY * n] = t, before
        acc[i + _place(3, k) * n] = t
        acc[i + _place(4, k) * n] = before
        acc[i + _SAME * n] = k + 1.0
    elif kind == REST:
        _store_first(acc, i, n)
        if _last_letter(acc, i, n) != 3.0:
            _store(acc, i, n, 3.0, t, before)
    elif kind == SLACK:
        _store_repeats(acc, i, n)
        _store(acc, i, n, 4.0, t, before)


@formula
def _mark(acc: Any, i: int, n: int, number: int, t: float, angle: float, velocity: float) -> None:
    """Note when the watched drive periods begin and end."""
    if number == 0:
        acc[i + _FIRST_MARK * n] = t
    acc[i + _LAST_MARK * n] = t


@formula
def _start(acc: Any, i: int, n: int, angle: float) -> None:
    """Note that there are no marks yet."""
    acc[i + _FIRST_MARK * n] = math.nan


@formula
def _recurs(acc: Any, i: int, n: int, first: int, lag: int, period: float) -> bool:
    """Return whether all letters from entry `first` on recur so many letters later.

    They recur if the later one is the same letter, some drive periods later, and as fast.
    """
    last = int(acc[i + _STORED * n]) - 1
    span = acc[i + _place(1, last) * n] - acc[i + _place(1, last - lag) * n]
    periods = floor(span / period + 0.5)
    if not 1.0 <= periods <= acc[i + _LONGEST * n]:
        return False
    phase, tolerance = math.tau / period, acc[i + _TOLERANCE * n]
    for late in range(first + lag, last + 1):
        early = late - lag
        if acc[i + _place(0, late) * n] != acc[i + _place(0, early) * n]:
            return False
        apart = acc[i + _place(1, late) * n] - acc[i + _place(1, early) * n] - periods * period
        faster = acc[i + _place(2, late) * n] - acc[i + _place(2, early) * n]
        if max(abs(apart) * phase, abs(faster) / phase) > tolerance:
            return False
    return True


@formula
def _goes_on(acc: Any, i: int, n: int, lag: int, period: float, repeats: float) -> bool:
    """Return whether the letter after the last one, as the word has it, is not overdue.

    With `repeats` impacts on one side at the end, of which the last letter is the first, it is the
    next one that differs.
    """
    last = int(acc[i + _STORED * n]) - 1
    following = last - lag + 1
    while repeats > 0.0 and following < last:
        if acc[i + _place(0, following) * n] != acc[i + _place(0, last) * n]:
            repeats = 0.0
        else:
            following += 1
    gap = acc[i + _place(1, following) * n] - acc[i + _place(1, last - lag) * n]
    late = acc[i + _LAST_MARK * n] - acc[i + _place(1, last) * n] - gap
    return bool(late <= acc[i + _TOLERANCE * n] * period / math.tau)


@formula
def _least_code(acc: Any, i: int, n: int, length: int) -> float:
    """Return the least code of the last letters, over all letters with which they may begin."""
    stored = int(acc[i + _STORED * n])
    least = math.inf
    for begin in range(length):
        code = EMPTY_WORD
        for k in range(length):
            entry = stored - length + (begin + k) % length
            code = code * _BASE + acc[i + _place(0, entry) * n] - 1.0
        least = min(least, code)
    return least


@formula
def _code(acc: Any, i: int, n: int, period: float) -> float:
    """Return the code of the word."""
    begin, end = acc[i + _FIRST_MARK * n], acc[i + _LAST_MARK * n]
    repeats, last = acc[i + _SAME * n], -math.inf
    stored = int(acc[i + _STORED * n])
    if repeats > 0.0:
        last = acc[i + _place(3, int(repeats) - 1) * n]
    elif stored > 0:
        last = acc[i + _place(1, stored - 1) * n]
    if end - last > acc[i + _LONGEST * n] * period:
        if acc[i + _HELD * n] > 0.0:
            return _REST_WORD
        # A contact that was watched and did not come again is no word either.
        return EMPTY_WORD if last < begin else NO_WORD
    # Impacts on one side may be all that there is. Else they may end at rest, not seen yet.
    if stored > 0 and acc[i + _place(1, stored - 1) * n] >= begin:
        _store_first(acc, i, n)
    else:
        _store_repeats(acc, i, n)
        repeats = 0.0
    stored = int(acc[i + _STORED * n])
    first = max(stored - _HELD_LETTERS, 0)
    while first < stored and acc[i + _place(1, first) * n] < begin:
        first += 1
    for lag in range(1, min(MOST_LETTERS, (stored - first) // 2) + 1):
        if _recurs(acc, i, n, first, lag, period) and _goes_on(acc, i, n, lag, period, repeats):
            return _least_code(acc, i, n, lag)
    return NO_WORD


@formula
def _finish(acc: Any, i: int, n: int, end: Outcome) -> None:
    """Write the code of the word, NaN where the run is too short."""
    periods = marks_of(acc, i, n) - 1
    period = (acc[i + _LAST_MARK * n] - acc[i + _FIRST_MARK * n]) / periods
    acc[i + _WORD * n] = _code(acc, i, n, period) if period > 0.0 else math.nan


@observables.register("contact_word")
@dataclass(frozen=True, kw_only=True)
class ContactWord(Watched):
    """Which contacts one period of the response consists of, as a short word.

    The letters are B (impact at the bottom), T (impact at the top), R (coming to rest on contact)
    and S (a string goes slack; of two, either). A toy that clacks below and above once a period has
    the word ``BT``. Words of impacts are how return maps of vibro-impact systems are told apart
    (Bao et al., SIAM J. Appl. Dyn. Syst. 24, 2025).

    `3 longest` drive periods before the end are watched, as by `ResponsePeriod`. The word is the
    shortest one that all letters in them repeat (or the last 52 if there are more): the same
    letters, the same whole number of drive periods apart, at most `longest`, within
    `angle_tolerance` in the phase of the drive and in the angular velocity before the contact over
    the drive frequency. So a motion that repeats after two periods, with one impact in each, is
    ``BB``, not ``B``.

    A word has no beginning. It is written from the letter with which it comes first in the order
    B, T, R, S, so that it does not depend on the phase of the drive. The impacts on one side that
    end at rest are infinitely many in the model, chattering, and are written once: ``BR``. A ball
    that rests, or is held by friction, for the last `longest` drive periods without any letter has
    the word ``R``.

    The variable is a number: in base 4 the digits of the letters, B 0, T 1, R 2, S 3, behind a
    leading 1 (``BT`` is 17); `contact_words` reads it. 1 is the empty word: no contact in the drive
    periods watched. 0 is no word: contacts do not repeat, because the motion is chaotic,
    quasiperiodic or not settled yet, or its word is longer than 26 letters or its period than
    `longest`. NaN where the run is too short to watch.

    The word does not tell how many drive periods it takes: `ResponsePeriod` does.
    """

    variables: ClassVar[Any] = {"contact_word": Quantity("1", "", "contact word")}
    start: ClassVar[Any] = staticmethod(_start)
    step: ClassVar[Any] = staticmethod(_step)
    contact: ClassVar[Any] = staticmethod(_contact)
    mark: ClassVar[Any] = staticmethod(_mark)
    finish: ClassVar[Any] = staticmethod(_finish)

    @property
    def memory(self) -> int:
        """The word, and what is noted."""
        return _SLOTS - _WORD


def word_of_run(
    times: Sequence[float], kinds: Sequence[int], velocities: Sequence[float], *,
    drive_period: float, duration: float, held: bool,
) -> float:  # fmt: skip
    """Return the code of the word of a run from its contact table, as `ContactWord` finds it.

    A run of less than 48 drive periods is watched from its start, for words of at most a third of
    its periods; NaN for less than three.

    Parameters
    ----------
    times, kinds, velocities : sequences, shape (contact,)
        Instants [s], row kinds, and angular velocities of a ball before them [rad/s].
    drive_period, duration : float
        [s].
    held : bool
        Whether the ball is held at the end.
    """
    periods = math.floor(duration / drive_period * (1.0 + 1e-9))
    if periods < REPEATS:
        return math.nan
    word = ContactWord(longest=min(ContactWord.longest, periods // REPEATS))
    acc = [*word.parameters, *[0.0] * word.memory]
    for t, kind, velocity in zip(times, kinds, velocities, strict=True):
        _contact(acc, 0, 1, t, kind, velocity, 0.0, 0.0)
    acc[_HELD] = float(held)
    acc[_FIRST_MARK] = (periods - word.marks + 1) * drive_period
    acc[_LAST_MARK] = periods * drive_period
    return _code(acc, 0, 1, drive_period)


def contact_words(codes: Any) -> Any:
    """Return the words that numbers of `contact_word` stand for, in their shape.

    Parameters
    ----------
    codes : number, array or DataArray
        Numbers of the observable `contact_word`.

    Returns
    -------
    str, ndarray or DataArray
        Words over B, T, R, S; "no contact" for the empty word, "no word" where contacts do not
        repeat, an empty text for NaN.

    Raises
    ------
    InputError
        For a number that is no word.

    Examples
    --------
    >>> contact_words(17.0)
    'BT'
    >>> contact_words([4.0, 1.0, 0.0]).tolist()
    ['B', 'no contact', 'no word']
    """
    import numpy as np

    values = np.asarray(codes, dtype=np.float64)
    known: dict[float, str] = {}
    for code in np.unique(values[~np.isnan(values)]).tolist():
        if not (code.is_integer() and (code in _NAMES or _digits(code))):
            raise InputError("is no contact word", parameter="contact_word", value=code)
        known[code] = _NAMES.get(code) or "".join(LETTERS[d] for d in _digits(code))
    words = np.array([known.get(code, "") for code in values.ravel().tolist()], dtype=object)
    if hasattr(codes, "copy") and hasattr(codes, "dims"):
        return codes.copy(data=words.reshape(values.shape))
    return words.reshape(values.shape) if values.ndim else words[0]


def _digits(code: float) -> Sequence[int]:
    """Return the digits behind the leading 1, none if there is no such word."""
    left, digits = int(code), []
    while left >= 4:
        left, digit = divmod(left, 4)
        digits.append(digit)
    return digits[::-1] if left == 1 and len(digits) <= MOST_LETTERS else []
