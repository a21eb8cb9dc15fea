"""What a tracked video shows in sentences, with the numbers of its fits."""

import math

import numpy as np
import pytest

from latolato.app.experiment.finding import answer_of, finding_of, questions_of
from latolato.experiment.fits.registry import Apparatus
from latolato.experiment.track_table import track_table
from track_tables import decay_table


def value(number, sigma=0.0):
    return {"value": number, "sigma": sigma}


DECAY = {"values": {"natural_frequency": value(8.928, 0.019), "decay_rate": value(0.0182, 2e-4)}}
DRIVE = {"values": {"drive_amplitude": value(0.02, 1e-4), "drive_frequency": value(15.1, 0.02)}}
RESTITUTION = {"values": {"restitution": value(0.9, 0.02)}}
TRIAL = {
    "largest_angle": np.radians(62.0), "largest_angle_sigma": np.radians(1.0), "note": "",
    "class": "weak", "borderline": False,
}  # fmt: skip
ERROR = {"error": "the pivot is at rest"}


def told_of(*given):
    return " ".join(finding_of(*given))


def table(duration=6.0, balls=1, flag="ok", angle=0.6):
    """A swing of 1.2 s as a tracker sees it, with one flag for all frames."""
    one = decay_table(length=0.363, mass=0.1, duration=duration, angle=angle)
    columns = {"time": one.time.values}
    for ball in range(1, balls + 1):
        columns |= {
            f"angle_{ball}": one.angle_1.values, f"flag_{ball}": np.full(len(one.time), flag),
            f"angle_sigma_{ball}": one.angle_sigma_1.values,
        }  # fmt: skip
    return track_table(columns, {"length": 0.363})


def test_a_free_swing_says_how_often_and_how_fast_it_fades():
    told = told_of(table(), {"drive": ERROR, "decay": DECAY}, None)
    assert told.startswith(
        "It swings 1.421 ± 0.003 times a second and loses half of its swing every 38.1 ± 0.4 s. "
    )
    assert "±" in told


def test_a_swing_that_does_not_fade_says_so_and_what_to_do():
    values = {"natural_frequency": value(8.928, 0.019), "decay_rate": value(-1e-4, 2e-4)}
    told = told_of(table(), {"decay": {"values": values}}, None)
    assert "no decay of its swing was found: a longer record may show one." in told
    assert "every" not in told


@pytest.mark.parametrize(
    "more, words",
    [
        ({}, "out to 62.0 ± 1.0°. The swing lasts and goes beyond 45°."),
        (
            {"class": "strong", "borderline": True},
            "beyond 90°: strong motion. The uncertainty of the angle reaches across that limit.",
        ),
        ({"class": "none"}, "The swing ends below 45°."),
        ({"note": "not settled in the last part"}, "The motion has not settled in this record."),
    ],
)
def test_a_driven_swing_says_what_the_drive_is_and_how_far_it_goes(more, words):
    told = told_of(table(), {"drive": DRIVE, "decay": ERROR}, {**TRIAL, **more})
    assert told.startswith(
        "Shaken with an amplitude of 20.00 ± 0.10 mm, 2.403 ± 0.003 times a second, the ball swings"
    )
    assert told.endswith(words)


def test_an_axis_that_is_only_taken_as_vertical_is_said_to_be():
    words = "The axis of the drive is taken as vertical"
    for source, is_said in (("vertical drive", True), ("drive axis", False)):
        own = table().assign_attrs(gravity_source=source)
        assert (words in told_of(own, {"drive": DRIVE}, TRIAL)) == is_said


def test_without_a_trial_the_largest_angle_is_told():
    assert "out to ≈ 34°" in told_of(table(), {"drive": DRIVE}, None)


@pytest.mark.parametrize(
    "flag, angle, fits, words",
    [
        ("ok", 0.6, {}, "The balls were not seen to touch."),
        ("collision", 0.6, {}, "The balls touch, but the effect of a collision could not"),
        ("collision", 0.6, {"restitution": RESTITUTION},
         "The balls clack: a collision keeps 0.90 ± 0.02 of their speed. They meet below."),
        ("collision", 2.5, {"restitution": RESTITUTION}, "They meet below and above."),
    ],
)  # fmt: skip
def test_two_balls_say_what_their_collisions_do(flag, angle, fits, words):
    told = told_of(table(balls=2, flag=flag, angle=angle), {"drive": DRIVE, **fits}, TRIAL)
    assert "the balls swing out to 62.0 ± 1.0°." in told
    assert words in told


def test_without_a_fit_tracking_gives_the_period():
    period = 2.0 * np.pi * np.sqrt(0.363 / 9.8)
    told = told_of(table(duration=9.0, angle=0.05), {"drive": ERROR, "decay": ERROR}, None)
    assert told.startswith("One swing takes ")
    number, sigma = told.removeprefix("One swing takes ").removesuffix(" s.").split(" ± ")
    assert abs(float(number) - period) < 4.0 * float(sigma) + 2e-3


def test_where_nothing_was_found_it_says_what_to_do():
    told = told_of(table(duration=0.8), {"drive": ERROR, "decay": ERROR}, None)
    assert told.startswith(
        "No swing was found. A record needs at least three swings: make it longer"
    )


def test_a_ball_that_was_hardly_seen_is_not_trusted():
    told = told_of(table(flag="lost"), {"decay": DECAY}, None)
    assert "was measured in only 0 % of the samples: do not trust the numbers" in told


def test_a_question_comes_before_every_number():
    own = table()
    slow = own.assign_coords(time=1e3 * own.time)
    values = {"natural_frequency": value(5.0e-3, 1e-5), "length": value(3.9e5, 1.0)}
    for cards in ({"decay": ERROR}, {"decay": {"values": values | DECAY["values"]}}):
        asked = questions_of(slow, cards)
        assert asked[0].startswith("This is the period of a pendulum of ")
        assert "is the clock in seconds" in asked[0]
        assert finding_of(slow, cards, None, asked)[0] == asked[0]
        assert answer_of(slow, cards, None, Apparatus(), asked) == []
    assert questions_of(own, {"decay": ERROR}) == []
    doubted = {"decay": {"error": "no", "doubt": "it fails"}}
    assert answer_of(own, doubted, None, Apparatus()) == []
    assert finding_of(own, doubted, None)[0] == "it fails"


def test_the_numbers_of_a_free_swing_are_period_frequency_fading_and_gravity():
    rate = math.sqrt(9.81 / (0.363 + 0.4 * 0.02**2 / 0.363))
    values = {"natural_frequency": value(rate, 1e-3 * rate), "decay_rate": value(0.035, 0.001)}
    cards = {"decay": {"values": values}}
    told = answer_of(table(), cards, None, Apparatus(length=0.363, radius=0.02))
    assert [each["name"] for each in told] == [
        "small_period", "small_frequency", "half_life", "gravity",
    ]  # fmt: skip
    numbers = {each["name"]: each for each in told}
    assert numbers["small_period"]["value"] == pytest.approx(math.tau / rate)
    assert numbers["gravity"]["value"] == pytest.approx(9.81)
    assert numbers["gravity"]["sigma"] == pytest.approx(math.hypot(2e-3, 1e-3 / 0.363) * 9.81)
    measured = Apparatus(length=0.363, length_sigma=3e-3, radius=0.02)
    gravity = answer_of(table(), cards, None, measured)[-1]
    assert gravity["sigma"] == pytest.approx(math.hypot(2e-3, 3e-3 / 0.363) * 9.81)
    assert gravity["given"]["sigma"] == pytest.approx(3.0)
    given = numbers["gravity"]["given"]
    assert given["length"] + 0.1 * given["more"] == pytest.approx(given["equivalent"])
    # With a pocket calculator, from the numbers that the page shows.
    length, period = (
        0.01 * round(given["equivalent"], 4),
        round(numbers["small_period"]["value"], 5),
    )
    assert 4.0 * math.pi**2 * length / period**2 == pytest.approx(9.81, abs=3e-4)
    assert numbers["half_life"]["value"] == pytest.approx(math.log(2.0) / 0.035)


def test_without_a_length_the_length_is_a_number_of_the_answer():
    values = {**DECAY["values"], "length": value(0.364, 1e-3)}
    told = answer_of(table(), {"decay": {"values": values}}, None, Apparatus())
    assert told[-1] == {
        "name": "length", "value": pytest.approx(36.4), "sigma": pytest.approx(0.1), "units": "cm",
        "given": {"gravity": 9.8},
    }  # fmt: skip
    values |= {"centre_length": value(0.363, 1e-3)}
    told = answer_of(table(), {"decay": {"values": values}}, None, Apparatus(radius=0.02))
    assert told[-1]["value"] == pytest.approx(36.3)
    assert told[-1]["given"] == {"gravity": 9.8, "radius": 20.0, "equivalent": 36.4,
        "more": pytest.approx(1.0)}  # fmt: skip


def test_the_numbers_of_a_driven_toy_are_those_of_pivot_swing_and_collisions():
    cards = {"drive": DRIVE, "restitution": RESTITUTION, "decay": ERROR}
    told = answer_of(table(balls=2), cards, TRIAL, Apparatus(length=0.363))
    assert [(each["name"], each["value"], each["units"]) for each in told] == [
        ("drive_amplitude", pytest.approx(20.0), "mm"),
        ("drive_frequency", pytest.approx(2.403, rel=1e-3), "Hz"),
        ("largest_angle", pytest.approx(62.0), "°"),
        ("restitution", pytest.approx(0.9), ""),
    ]


def test_without_a_fit_the_numbers_are_period_and_frequency_and_none_without_a_swing():
    errors = {"drive": ERROR, "decay": ERROR}
    period, frequency = answer_of(table(duration=9.0, angle=0.05), errors, None, Apparatus())
    assert period["value"] * frequency["value"] == pytest.approx(1.0)
    assert period["value"] == pytest.approx(math.tau * math.sqrt(0.363 / 9.8), rel=2e-3)
    assert answer_of(table(duration=0.8), errors, None, Apparatus()) == []
