"""Lyapunov exponents, and whether two balls stay mirror images."""

import math

import numpy as np
import pytest

import latolato as ll
from hanging import growth_rate
from latolato.analysis.flow import Flow
from latolato.analysis.lyapunov_spectrum import lyapunov_spectrum
from latolato.analysis.pair_symmetry import as_pair, pair_symmetry
from latolato.core.errors import InputError

SHAKE = ll.Harmonic(drive_amplitude=0.15, drive_frequency=6.0)


def test_the_sum_is_that_of_drag_and_impacts():
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.05, restitution=0.97)
    strong = ll.Harmonic(drive_amplitude=0.3, drive_frequency=6.5)
    given = {"initial_angle": 0.6, "duration": 200.0, "transient": 50.0}
    found = lyapunov_spectrum(toy, strong, **given)
    assert abs(found.sum_rule_residual.item()) < 1e-12
    # Exponents and contacts of one run: the motion is chaotic, so no other has the same contacts.
    same = ll.sweep(
        toy, strong, axes={"initial_angle": [0.6]}, duration=200.0, transient=50.0,
        observables=["lyapunov_spectrum", "bottom_contacts", "top_contacts"],
    )  # fmt: skip
    impacts = same.bottom_contacts.item() + same.top_contacts.item()
    expected = -0.05 / 0.8 + 2.0 * impacts / 150.0 * math.log(0.97)
    assert same.lyapunov_exponents.sum().item() == pytest.approx(expected, abs=1e-9)


def test_exponents_at_a_fixed_point_are_those_of_floquet():
    from latolato.analysis.floquet import floquet

    system = ll.Pendulum(length=1.0, mass=0.8, damping=0.2)
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=8.0)
    period = math.tau / 8.0
    found = lyapunov_spectrum(
        system, drive, initial_angle=0.0, duration=1000 * period, transient=100 * period
    )
    expected = np.log(np.abs(floquet(system, drive).multipliers.values)) / period
    # The vectors turn once within the window of 900 periods: an error of about 1/(900 T).
    assert found.lyapunov_exponents.values == pytest.approx(expected, abs=2.0 / (900 * period))
    assert found.status.item() == "regular"


def test_a_toy_that_rests_forgets_its_past():
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.05, restitution=0.5)
    found = lyapunov_spectrum(toy, SHAKE, initial_offset=0.3, duration=60.0, transient=30.0)
    assert found.status.item() == "rest"
    assert np.all(found.lyapunov_exponents == -math.inf)
    assert found.rests.item() >= 1


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_an_instant_of_rest_leaves_the_exponent_between_rests(tolerance):
    # Starts within a micrometre: some rest for an instant before the end, the others do not.
    toy = ll.LatoLato(length=0.2, mass=0.05, radius=0.018, restitution=0.5, damping=0.001)
    drive = ll.Harmonic(drive_amplitude=0.094, drive_frequency=6.0 * math.pi)
    starts = math.radians(20.0) + 1e-6 * np.arange(16)
    found = ll.sweep(
        toy, drive, axes={"initial_angle": starts}, duration=300.0, transient=100.0,
        observables=["lyapunov_exponent"], tolerance=tolerance,
    )  # fmt: skip
    rests = found.rests > 0
    assert 0 < rests.sum() < 16
    assert np.all(np.isneginf(found.lyapunov_exponent) == rests)
    assert np.all(np.abs(found.exponent_between_rests - 2.0) < 0.8)
    same = found.where(~rests, drop=True)
    assert np.array_equal(same.exponent_between_rests, same.lyapunov_exponent)


def test_a_short_run_has_a_shorter_transient():
    system = ll.Pendulum(length=1.0, mass=0.8, damping=0.2)
    found = lyapunov_spectrum(system, SHAKE, initial_angle=0.1, duration=50.0)
    assert found.attrs["transient"] == 5.0
    with pytest.raises(InputError, match="system must be one of"):
        lyapunov_spectrum(5, SHAKE)


def test_a_static_conservative_pendulum_has_no_exponent():
    system = ll.Pendulum(length=1.0, mass=0.8)
    found = lyapunov_spectrum(system, None, initial_angle=1.0, duration=2000.0, transient=0.0)
    # Neighbours part linearly in time: ln(t)/t.
    assert abs(found.lyapunov_exponents.values).max() < 5e-3
    assert found.status.item() == "marginal"


def test_a_departure_from_the_mirror_image_grows_at_its_exponent():
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.9)
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=2.0 * math.sqrt(9.8))
    found = pair_symmetry(toy, drive, initial_offset=0.0, duration=100.0, transient=50.0)
    assert found.status.item() == "broken"
    # The toy rests, and swings as one pendulum under it: parametric resonance of both together.
    times = np.linspace(0.0, 100.0, 10_001)
    low = toy.contact_angle_low
    run = ll.simulate(as_pair(toy), drive, initial_angle=(low + 1e-9, -low + 1e-9), times=times)
    mean = np.abs(run.angle.sum("ball").values / 2.0)
    late = [mean[(times > a) & (times < a + 10.0)].max() for a in (50.0, 90.0)]
    grown = math.log(late[1] / late[0]) / 40.0
    assert grown == pytest.approx(found.transverse_exponent.item(), rel=0.03)  # beats of a window


def test_the_rate_of_a_departure_is_that_of_the_matrix():
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.9)
    pair, start = as_pair(toy), np.array([0.6, 0.0, -0.6, 0.0])
    grid = ll.sweep(
        pair, SHAKE, axes={"initial_angle_right": [0.6]}, initial_angle=(0.6, -0.6), duration=2.0,
        observables=["transverse_exponent"], tolerance=1e-12,
    )  # fmt: skip
    flow = Flow(pair, SHAKE).follow(start, 2.0)
    assert flow.impacts > 0
    both = flow.matrix @ np.array([1.0, 0.0, 1.0, 0.0])  # both angles deviate alike
    grown = math.log(math.hypot(both[0], both[1]))
    # the tolerance of both runs, magnified by their impacts
    assert 2.0 * grid.transverse_exponent.item() == pytest.approx(grown, abs=1e-9)


@pytest.mark.parametrize("duration", [100.0, 600.0])
def test_the_rate_of_a_departure_does_not_depend_on_how_long_it_is_followed(duration):
    # At rest both balls swing as one pendulum of the length l cos(contact angle): its Hill rate.
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02, restitution=0.9)
    drive = ll.Harmonic(drive_amplitude=0.05, drive_frequency=2.0 * math.sqrt(9.8))
    period = math.tau / drive.drive_frequency
    found = pair_symmetry(toy, drive, initial_offset=0.0, duration=duration, transient=20 * period)
    cosine = math.sqrt(1.0 - 0.1**2)
    # S'' + gamma S' + (g + y0'') cos(contact angle)/l S = 0
    expected = growth_rate(
        drive_amplitude=0.05, drive_frequency=drive.drive_frequency, length=1.0 / cosine, mass=0.8,
        damping=0.02 / cosine,
    )  # fmt: skip
    # The velocity's direction turns within a period: 1/time.
    assert found.largest_angle_after_transient.item() == pytest.approx(math.asin(0.1), rel=1e-12)
    assert found.transverse_exponent.item() == pytest.approx(float(expected), abs=5e-3)
    assert found.status.item() == "broken"


def test_a_validity_map_has_both_axes():
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.05, restitution=0.9)
    found = pair_symmetry(
        toy, None, initial_offset=0.2, drive_amplitude=[0.03, 0.1], frequency_ratio=[1.0, 2.0, 3.0],
        duration=100.0, transient=20.0,
    )  # fmt: skip
    assert found.transverse_exponent.dims == ("drive_amplitude", "frequency_ratio")
    assert found.status.sel(frequency_ratio=2.0, drive_amplitude=0.03).item() == "broken"
    assert found.status.sel(frequency_ratio=3.0, drive_amplitude=0.03).item() != "broken"


def test_the_motion_of_a_broken_symmetry_is_still_the_mirrored_one():
    toy = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, damping=0.02)
    drive = ll.Harmonic(drive_amplitude=0.2, drive_frequency=6.26)
    found = pair_symmetry(toy, drive, initial_offset=0.2, duration=300.0)
    assert found.status.item() == "broken"
    assert found.largest_angle_after_transient.item() <= toy.contact_angle_high + 1e-9


def test_a_departure_is_asked_of_mirrored_equal_balls_only():
    ball, other = (ll.Ball(length=1.0, mass=mass, radius=0.1) for mass in (0.8, 0.4))
    asked = {
        "duration": 5.0, "observables": ["transverse_exponent"], "initial_angle": (0.5, -0.5),
        "axes": {"initial_angle_right": [0.5, 0.6]},
    }  # fmt: skip
    with pytest.warns(RuntimeWarning, match="mirror images"):
        grid = ll.sweep(ll.BallPair(right=ball, left=ball), SHAKE, **asked)
    assert np.isfinite(grid.transverse_exponent.values).tolist() == [True, False]
    with pytest.warns(RuntimeWarning, match="mirror images"):
        ll.sweep(ll.BallPair(right=ball, left=other), SHAKE, **asked)


def test_other_systems_have_no_mirror_symmetry():
    with pytest.raises(InputError, match="must be a LatoLato, whose one-ball model"):
        pair_symmetry(ll.Pendulum(length=1.0, mass=0.8), SHAKE, initial_angle=0.1)
    with pytest.raises(ValueError, match="systems of 2 angles"):
        ll.sweep(
            ll.Pendulum(length=1.0, mass=0.8), SHAKE, axes={"initial_angle": [0.1]}, duration=5.0,
            observables=["transverse_exponent"],
        )  # fmt: skip
