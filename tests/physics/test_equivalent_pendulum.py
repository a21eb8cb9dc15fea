"""Rods with mass and balls with size as a point pendulum."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

import latolato as ll
from latolato.core.errors import InputError

sizes = st.floats(0.01, 5.0)


def change_of_frequency(**arguments):
    length, _ = ll.equivalent_pendulum(1.0, 1.0, **arguments)
    return math.sqrt(1.0 / length) - 1.0


def test_uniform_rod_of_a_tenth_of_all_mass_raises_the_frequency_by_089_percent():
    # PHYSICS section 1: rods of 1/10 of the mass: of the whole (rod and ball), m_rod/m = 1/9.
    assert change_of_frequency(rod_mass=1.0 / 9.0) == pytest.approx(0.0089, abs=5e-5)
    assert change_of_frequency(rod_mass=0.1) == pytest.approx(0.0080, abs=5e-5)


def test_solid_ball_of_radius_008_lowers_the_frequency_by_013_percent():
    assert change_of_frequency(radius=0.08) == pytest.approx(-0.0013, abs=5e-5)


def test_point_mass_on_a_massless_rod_is_itself():
    assert ll.equivalent_pendulum(0.7, 0.2) == pytest.approx((0.7, 0.2), rel=1e-15)


@given(length=sizes, mass=sizes, rod_mass=sizes, share=st.just(0.0) | st.floats(0.01, 0.9))
def test_inertia_and_static_moment_are_those_of_the_bodies(length, mass, rod_mass, share):
    radius = share * length
    result, heavy = ll.equivalent_pendulum(length, mass, rod_mass, radius)
    # Moment of inertia and static moment of the rod by quadrature along it.
    rod_inertia = quad(lambda s: s * s, 0.0, length)[0] * rod_mass / length
    rod_moment = quad(lambda s: s, 0.0, length)[0] * rod_mass / length
    # A solid sphere about its centre, by shells: 2/5 m r^2 = (8 pi/3) rho integral of s^4.
    own = 0.0
    if radius > 0.0:
        density = mass / (4.0 / 3.0 * math.pi * radius**3)
        own = quad(lambda s: 8.0 * math.pi / 3.0 * density * s**4, 0.0, radius)[0]
    inertia = mass * length**2 + own + rod_inertia
    assert heavy * result**2 == pytest.approx(inertia, rel=1e-9)
    assert heavy * result == pytest.approx(mass * length + rod_moment, rel=1e-9)


@pytest.mark.parametrize(
    "arguments",
    [
        {"length": -1.0, "mass": 1.0},
        {"length": 1.0, "mass": 0.0},
        {"length": 1.0, "mass": 1.0, "rod_mass": -0.1},
        {"length": 1.0, "mass": 1.0, "rod_mass": math.nan},
        {"length": 1.0, "mass": 1.0, "radius": 1.0},
        {"length": 1.0, "mass": 1.0, "rod_mass": math.inf},
    ],
)
def test_bad_input_is_refused(arguments):
    with pytest.raises(ValueError, match="must"):
        ll.equivalent_pendulum(**arguments)


@pytest.mark.parametrize("wrong", ["0.1", None])
def test_rod_mass_that_is_no_number_is_refused(wrong):
    with pytest.raises(InputError, match="rod_mass must be a number"):
        ll.equivalent_pendulum(1.0, 1.0, rod_mass=wrong)
