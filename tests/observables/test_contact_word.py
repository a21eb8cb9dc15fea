"""The word of contacts: sequences by hand, known motions, executors, codes and a run's summary."""

import math

import numpy as np
import pytest

import latolato as ll
from latolato import ContactWord, contact_words
from latolato.core.errors import InputError
from latolato.observables.word import MOST_LETTERS, word_of_run
from latolato.physics.contacts import BOTTOM, RELEASE, REST, SLACK, TAUT, TOP
from latolato.sweeps.batches import run_scalar
from latolato.sweeps.chunk import run_chunk
from latolato.sweeps.plan import make_plan

TOY = ll.LatoLato(length=0.245, mass=0.10644, radius=0.0196, restitution=0.9, damping=0.00506)
BALL = ll.Ball(length=0.245, mass=0.10644, radius=0.0196, damping=0.00506)
PAIR = ll.BallPair(right=BALL, left=BALL, restitution=0.9)
KINDS = {"B": BOTTOM, "T": TOP, "R": REST, "S": SLACK, "t": TAUT, "r": RELEASE}
PERIODS = 60
# Motions of the toy: amplitude [m], frequency ratio, start [rad], word and response period. None of
# them changes with gravity by a part in 1e5.
MOTIONS = (
    (0.03, 2.4, 0.2, "B", 1.0),
    (0.0636, 1.763, 0.2, "BB", 1.0),
    (0.08051282051282051, 2.2966101694915255, 2.0, "BB", 2.0),
    (0.0467, 4.5847, 0.2, "BBB", 3.0),
    (0.1, 3.8, 0.2, "BT", 1.0),
    (0.0974, 2.144, 0.2, "BTBT", 2.0),
    (0.0888, 1.6864, 0.2, "BR", 1.0),
    (0.024, 1.686, 0.2, "R", 1.0),
    (0.1031, 1.839, 0.2, "no word", math.nan),
)
RATTLE, CLACK, CHATTER, STILL = (MOTIONS[k][:2] for k in (0, 4, 6, 7))


def word(letters, *, lasts=1, until=PERIODS, period=1.0, held=False, start=0.1, speeds=None):
    """The word of letters that take so many drive periods, over and over, until the run's end.

    All letters lie evenly in that time and are as fast, unless `speeds` has a value for each.
    """
    count = len(letters)
    number = int((until - start) / lasts * count) + 1
    times = [period * (start + lasts * k / count) for k in range(number)]
    kinds = [KINDS[letters[k % count]] for k in range(number)]
    velocities = [-1.0 if speeds is None else speeds[k % len(speeds)] for k in range(number)]
    code = word_of_run(
        times, kinds, velocities, drive_period=period, duration=period * PERIODS, held=held
    )
    return contact_words(code)


@pytest.mark.parametrize(
    "letters, expected",
    [
        ("B", "B"),
        ("T", "T"),
        ("BT", "BT"),
        ("TB", "BT"),  # a word has no beginning
        ("TBB", "BBT"),
        ("BBTB", "BBBT"),
        ("BtTr", "BT"),  # what is no letter
        ("BTS", "BTS"),
        ("SBT", "BTS"),
        ("BSTR", "BSTR"),
        ("SS", "SS"),
    ],
)
def test_a_word_is_what_repeats_and_begins_with_its_least_letter(letters, expected):
    assert word(letters, speeds=range(1, len(letters) + 1)) == expected


def test_a_letter_that_comes_again_alike_is_one_word():
    # Two impacts a period that are alike but for half a drive period are still two.
    assert word("B") == "B"
    assert word("BB", lasts=2) == "B"
    assert word("BB", lasts=2, speeds=[1.0, 2.0]) == "BB"
    assert word("B", lasts=2) == "B"
    assert word("BB", lasts=1) == "BB"


@pytest.mark.parametrize("apart, expected", [(0.9e-4, "B"), (1.1e-4, "BB")])
def test_speeds_are_compared_over_the_frequency_of_the_drive(apart, expected):
    period = 0.4
    speeds = [1.0, 1.0 + apart * math.tau / period]
    assert word("BB", lasts=2, period=period, speeds=speeds) == expected


@pytest.mark.parametrize("chatter", [1, 2, 25, 26, 27, 52, 53, 200])
@pytest.mark.parametrize("start", [0.1, 0.77])
def test_chattering_is_one_letter_however_many_impacts_it_has(chatter, start):
    """At its end a run may be in flight, in the middle of the chattering, or at rest."""
    letters = "B" * chatter + "Rr" + "T"
    assert word(letters, start=start) == "BRT"
    assert word(letters.replace("T", ""), start=start) == "BR"


def test_impacts_that_do_not_end_at_rest_are_letters_each():
    for start in np.linspace(0.0, 1.0, 11, endpoint=False):
        assert word("BBBTT", speeds=range(5), start=start) == "BBBTT"
        assert word("BBSB", speeds=range(4), start=start) == "BBBS"


def test_the_longest_word_is_held_and_no_longer_one():
    longest = "BT" * (MOST_LETTERS // 2)
    speeds = range(1, MOST_LETTERS + 1)
    assert word(longest, lasts=2, speeds=speeds) == longest
    assert word(longest + "T", lasts=2, speeds=range(MOST_LETTERS + 1)) == "no word"
    one_side = "B" * MOST_LETTERS
    assert word(one_side, lasts=2, speeds=speeds) == one_side
    assert word(one_side + "B", lasts=2, speeds=range(MOST_LETTERS + 1)) == "no word"


def test_the_longest_period_is_that_of_the_observable():
    assert word("BT", lasts=16, speeds=[1.0, 2.0]) == "BT"
    assert word("BT", lasts=17, speeds=[1.0, 2.0]) == "no word"


def test_contacts_that_do_not_repeat_have_no_word():
    rng = np.random.default_rng(1)
    assert word("B", speeds=rng.uniform(1.0, 2.0, 1000)) == "no word"
    assert word("B", lasts=math.sqrt(1.3)) == "no word"  # not a whole number of drive periods


def test_contacts_that_have_ended_are_not_a_word():
    assert word("BT", until=59.6) == "BT"
    for until in (59.0, 45.0):
        assert word("BT", until=until) == "no word"
        assert word("BR", until=until, held=True) == "no word"
    # Watched are the last 48 of 60 periods: what ended in them may come again.
    assert word("BT", until=40.0) == "no word"
    assert word("BT", until=11.0) == "no contact"
    assert word("BR", until=40.0, held=True) == "R"


def test_what_is_before_the_watched_periods_does_not_count():
    speeds = np.ones(1000)
    speeds[:5] = 2.0
    assert word("B", speeds=speeds) == "B"
    speeds[20] = 2.0
    assert word("B", speeds=speeds) == "no word"


def test_short_runs_are_watched_from_their_start():
    def short(periods):
        times = np.arange(0.5, periods)
        return word_of_run(
            times, [BOTTOM] * len(times), -np.ones(len(times)), drive_period=1.0,
            duration=periods, held=False,
        )  # fmt: skip

    # One impact in the first of three periods.
    once = word_of_run([0.5], [BOTTOM], [-1.0], drive_period=1.0, duration=3.0, held=False)
    assert contact_words(once) == "no word"
    assert math.isnan(short(2.9))
    assert contact_words(short(3.0)) == contact_words(short(47.0)) == "B"


def test_codes_are_numbers_in_base_four_behind_a_one():
    codes = np.array([[0.0, 1.0, 4.0, 5.0], [6.0, 7.0, 0b01_00_01_10_11, math.nan]])
    codes[1, 2] = int("10123", 4)
    assert contact_words(codes).tolist() == [
        ["no word", "no contact", "B", "T"],
        ["R", "S", "BTRS", ""],
    ]
    longest = float(int("1" + "3" * MOST_LETTERS, 4))
    assert longest == 2.0**53 - 1.0
    assert contact_words(longest) == "S" * MOST_LETTERS


@pytest.mark.parametrize("code", [2.0, 3.0, 8.0, 4.5, -1.0, math.inf, 4.0**27])
def test_numbers_that_are_no_words_are_refused(code):
    with pytest.raises(InputError, match="is no contact word"):
        contact_words([4.0, code])


@pytest.fixture(scope="module")
def plan():
    """All motions."""
    names = "drive_amplitude", "frequency_ratio", "initial_offset"
    motions = zip(names, list(zip(*MOTIONS, strict=True))[:3], strict=True)
    return make_plan(
        TOY, axes={"motion": dict(motions)}, duration=300.0,
        observables=["contact_word", "response_period"],
    )  # fmt: skip


@pytest.fixture(scope="module")
def fast(plan):
    from latolato.sweeps import run_plan

    return run_plan(plan)


def test_motions_of_the_toy_have_the_words_of_their_contacts(fast):
    assert contact_words(fast.contact_word).values.tolist() == [word for *_, word, _ in MOTIONS]
    np.testing.assert_array_equal(fast.response_period, [period for *_, period in MOTIONS])


def test_lanes_and_single_trajectories_find_the_same_words(plan, fast):
    alone, _ = run_chunk(plan, 0, run_scalar)
    assert alone["contact_word"].tolist() == fast.contact_word.values.tolist()


@pytest.mark.parametrize(
    "name, motion, duration", [("B", RATTLE, 25.0), ("BR", CHATTER, 60.0), ("R", STILL, 25.0)]
)
def test_plain_python_finds_the_same_words(name, motion, duration):
    amplitude, ratio = motion
    drive = ll.Harmonic(drive_amplitude=amplitude, drive_frequency=ratio * TOY.natural_frequency)
    result = ll.sweep(
        TOY, drive, axes={"gravity": [9.8]}, initial_offset=0.2, tolerance=1e-6, duration=duration,
        observables=[ContactWord(longest=2, angle_tolerance=1e-2)], executor="reference",
    )  # fmt: skip
    assert contact_words(result.contact_word).item() == name


def test_two_equal_balls_have_the_words_of_their_mirror_symmetric_model():
    # There the mirrored motion attracts: its transverse exponents are -0.09 and -0.08 1/s. At CLACK
    # that is 0.04 1/s, and any rounding that is not mirrored leads away from it.
    amplitudes, ratios = zip(RATTLE, (0.11, CLACK[1]), strict=True)
    result = ll.sweep(
        PAIR, axes={"motion": {"drive_amplitude": amplitudes, "frequency_ratio": ratios}},
        duration=150.0, initial_angle=(0.28, -0.28), observables=["contact_word"],
    )  # fmt: skip
    assert contact_words(result.contact_word).values.tolist() == [["B"] * 2, ["BT"] * 2]


def test_a_string_that_goes_slack_once_a_period_is_a_letter():
    strings = ll.LatoLato(
        length=0.186, mass=0.03, radius=0.012, restitution=0.822, damping=8.928e-4,
        suspension="string", string_restitution=0.3,
    )  # fmt: skip
    result = ll.sweep(
        strings, axes={"drive_amplitude": [0.02], "drive_frequency": [13.75, 17.5, 25.0]},
        duration=60.0, initial_angle=0.35, observables=["contact_word"],
    )  # fmt: skip
    assert contact_words(result.contact_word).values.ravel().tolist() == ["R", "B", "BS"]


def test_a_free_pendulum_has_no_contacts_whether_it_repeats_or_not():
    pendulum = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    result = ll.sweep(
        pendulum, axes={"drive_amplitude": [0.05, 0.5], "frequency_ratio": [2.0]},
        initial_angle=0.1, duration=900.0, observables=["contact_word", "response_period"],
    )  # fmt: skip
    assert contact_words(result.contact_word).values.ravel().tolist() == ["no contact"] * 2
    assert np.isfinite(result.response_period.values).ravel().tolist() == [True, False]


def test_a_run_too_short_to_watch_has_no_value():
    result = ll.sweep(
        TOY, ll.Harmonic(drive_amplitude=0.03, drive_frequency=15.0), axes={"gravity": [9.8]},
        duration=20.0, initial_offset=0.2, observables=["contact_word"],
    )  # fmt: skip
    assert np.isnan(result.contact_word.item())
