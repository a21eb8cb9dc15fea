"""The protocol as an object: its times and its drive."""

import math

import pytest

import latolato as ll
from latolato.analysis import Protocol

TOY = ll.LatoLato(length=0.245, mass=0.10644, damping=0.00506, radius=0.0196, restitution=0.9)


def test_stages_follow_each_other_with_ramps_between():
    steps = Protocol(drive_frequencies=[20.0, 18.0, 15.0], dwells=[4.0, 2.0], ramp=0.5)
    assert steps.times == (0.0, 4.0, 6.5)
    assert steps.lead_time == 7.0
    drive = steps.drive(0.03, drive_phase=1.0)
    assert isinstance(drive, ll.FrequencySchedule)
    # constant, ramp, constant, ramp, constant: knots of the frequency by hand
    knots = [(s.start, s.frequency, s.rate) for s in drive.segments(100.0)]
    assert knots == [
        (0.0, 20.0, 0.0), (4.0, 20.0, -4.0), (4.5, 18.0, 0.0), (6.5, 18.0, -6.0), (7.0, 15.0, 0.0)
    ]  # fmt: skip
    assert drive.drive_phase == 1.0


def test_ratios_are_in_natural_frequencies():
    steps = Protocol.of_ratios(TOY, frequency_ratios=[3.136, 2.389], dwells=[4.166])
    w0 = math.sqrt(9.8 / 0.245)
    assert steps.drive_frequencies == pytest.approx((3.136 * w0, 2.389 * w0), rel=1e-15)


def test_one_stage_is_a_steady_drive():
    assert Protocol(drive_frequencies=[6.0], dwells=[]).lead_time == 0.0


@pytest.mark.parametrize(
    "changed, message",
    [
        ({"dwells": []}, "dwells must be one fewer than the 2 drive_frequencies"),
        ({"dwells": [0.0]}, r"dwells\[0\] must lie in \(0, inf\) s"),
        ({"drive_frequencies": [20.0, -1.0]}, r"drive_frequencies\[1\] must lie in"),
        ({"ramp": -1.0}, r"ramp must lie in \[0, inf\) s"),
        ({"drive_frequencies": [], "dwells": []}, "hold at least 1 value, got 0"),
    ],
)
def test_bad_stages_are_refused(changed, message):
    with pytest.raises(ValueError, match=message):
        Protocol(**({"drive_frequencies": [20.0, 15.0], "dwells": [4.0]} | changed))
