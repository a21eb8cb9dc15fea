"""The search for a two-stage start: the paper's step, its answer run in full, and dead ends."""

import math

import numpy as np
import pytest

import latolato as ll
from latolato.analysis import Protocol, shortest_protocol
from latolato.figures.analyses.shortest_protocol import draw

TOY = ll.LatoLato(length=0.245, mass=0.10644, damping=0.00506, radius=0.0196, restitution=0.9)
BALL = ll.Ball(length=0.245, mass=0.10644, damping=0.00506, radius=0.0196)
PAIR = ll.BallPair(right=BALL, left=BALL, restitution=0.9)
W0 = TOY.natural_frequency
DRIVE = ll.Harmonic(drive_amplitude=0.03, drive_frequency=2.389 * W0)
QUICK = {"phases": 4, "push": [0.2, 1.5, 3.0], "dwell_time": [0.5, 1.0, 2.0, 4.166]}


def found_for(system=TOY, drive=DRIVE, **changed):
    return shortest_protocol(system, drive, **(QUICK | changed))


@pytest.mark.parametrize("ramp", [0.0, 0.5])
def test_the_papers_step_reaches_what_rest_does_not(ramp):
    result = found_for(first_frequency_ratio=[2.6, 3.136, 3.6], ramp=ramp)
    assert result.status.item() == "found"
    # Paper Fig. 12 with the assumed amplitude, radius and restitution: 42 against 4.6 degrees
    assert np.rad2deg(result.upper_angle.item()) == pytest.approx(42.0, abs=0.1)
    assert result.angle_from_rest.item() == TOY.contact_angle_low
    # below lift-off, A0 w^2 = g at 2.858 w0, a first stage does nothing
    assert np.all(result.success_share.sel(first_frequency_ratio=2.6) == 0.0)
    assert result.success_share.sel(first_frequency_ratio=3.136, dwell_time=4.166) > 0.5
    assert result.lead_time.item() == pytest.approx(result.best_dwell_time.item() + ramp)
    assert draw(result).axes
    # the answer as a drive of its own, at all phases of the search
    steps = Protocol.of_ratios(
        TOY,
        frequency_ratios=[result.best_first_ratio.item(), 2.389],
        dwells=[result.best_dwell_time.item()],
        ramp=ramp,
    )
    lasting = []
    for phase in np.arange(4) * math.tau / 4:
        run = ll.simulate(
            TOY, steps.drive(0.03, phase), initial_offset=0.0,
            times=np.linspace(34.0, 41.0, 1401), tolerance=1e-8,
        )  # fmt: skip
        lasting.append(float(run.angle.max()) > result.threshold_angle.item())
    assert np.mean(lasting) == result.checked_share.item()


def test_the_smallest_push_is_weighed_for_both_balls():
    result = found_for(first_frequency_ratio=[3.136])
    push = result.smallest_push.item()
    assert push in (1.5, 3.0)
    assert result.push_share.values[0] == 0.0  # none: at rest for good
    energy = 2.0 * 0.5 * 0.10644 * (0.245 * push) ** 2
    assert result.smallest_push_energy.item() == pytest.approx(energy, rel=1e-12)


def test_two_balls_are_searched_as_the_mirror_pair_is():
    settings = {"first_frequency_ratio": [3.6], "dwell_time": [0.5, 2.0], "phases": 2}
    one, two = (found_for(system, **settings) for system in (TOY, PAIR))
    for name in ("best_dwell_time", "smallest_push", "smallest_push_energy"):
        assert two[name].item() == pytest.approx(one[name].item(), rel=1e-12), name
    assert two.upper_angle.item() == pytest.approx(one.upper_angle.item(), rel=1e-3)


def test_a_pendulum_is_carried_down_the_softening_branch_from_its_tongue():
    # 1.8 lies left of the tongue, which begins at 1.910 w0: a small start dies there
    pendulum = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
    result = shortest_protocol(
        pendulum, ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.0), frequency_ratio=1.8,
        first_frequency_ratio=[1.7, 1.95], dwell_time=[5.0, 40.0, 60.0, 80.0],
        push=[0.5, 2.0, 4.0, 5.0], phases=4, settling=250.0, initial_angle=0.02,
        required_share=0.25,
    )  # fmt: skip
    assert result.status.item() == "found"
    assert result.best_first_ratio.item() == 1.95
    assert result.best_dwell_time.item() > 5.0
    assert result.angle_from_rest.item() < 1e-3
    # the branch at 1.8 w0, as `hysteresis` finds it on the way down
    assert result.upper_angle.item() == pytest.approx(1.456, abs=0.002)


def test_dead_ends_say_so():
    with pytest.warns(
        RuntimeWarning, match="no push up to 0.2 rad/s leads to a larger motion than rest"
    ):
        result = found_for(push=[0.2], first_frequency_ratio=[3.136])
    assert result.status.item() == "no upper branch"
    assert math.isnan(result.lead_time.item())
    assert np.isnan(result.push_share).all()
    # What was not searched has no empty panel: the settled angles say why.
    assert result.angle_after_push.values == pytest.approx([TOY.contact_angle_low] * 2)
    (axes,) = draw(result).axes
    assert axes.lines[0].get_ydata() == pytest.approx(result.angle_after_push.values)
    assert axes.get_ylabel().endswith("[°]")
    with pytest.warns(RuntimeWarning, match="no protocol succeeds for 50 % of the drive phases"):
        result = found_for(first_frequency_ratio=[2.5, 2.7])
    assert result.status.item() == "not reached"
    assert result.success_share.max() == 0.0


def test_no_protocol_is_needed_where_the_toy_starts_by_itself():
    result = found_for(frequency_ratio=3.4, threshold_angle=0.12, first_frequency_ratio=[3.6])
    assert result.status.item() == "reached from rest"
    assert result.lead_time.item() == 0.0


@pytest.mark.parametrize(
    "system, drive, changed, message",
    [
        (TOY, None, {}, "no drive has no stages"),
        (TOY, DRIVE, {"dwell_time": [2.0, 1.0]}, "dwell_time must increase strictly"),
        (TOY, DRIVE, {"push": [0.0]}, r"push\[0\] must lie in"),
        (TOY, DRIVE, {"required_share": 1.5}, r"required_share must lie in \(0, 1\]"),
        (TOY, DRIVE, {"phases": 0}, "phases must lie in"),
        (TOY, DRIVE, {"initial_angular_velocity": (2.0, 1.0)}, "must be one number in rad/s"),
        (ll.Mathieu(length=1.0, mass=0.8), DRIVE, {}, "must have motion that settles"),
    ],
)
def test_bad_input_is_refused(system, drive, changed, message):
    with pytest.raises(ValueError, match=message):
        found_for(system, drive, **changed)
