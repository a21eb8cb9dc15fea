"""Velocity kicks: checked parameters with metadata, and the strength of thermal noise."""

import dataclasses
import math

import pytest

import latolato as ll
from latolato.core.errors import InputError
from latolato.core.quantities import QUANTITIES
from latolato.physics.noise import BOLTZMANN

TOY = ll.LatoLato(length=0.5, mass=0.2, radius=0.05, damping=0.01)


@pytest.mark.parametrize("law", [ll.VelocityKicks, ll.ClampContact])
def test_every_field_carries_its_quantity_and_range(law):
    for field in dataclasses.fields(law):
        assert field.metadata["quantity"] is QUANTITIES[field.name]
        assert field.metadata["description"]
        low, high = field.metadata["suggested"] or (1.0, 2.0)
        assert low in field.metadata["range"]
        assert high in field.metadata["range"]
        assert -1.0 not in field.metadata["range"]


def test_thermal_noise_balances_the_damping():
    # sigma^2 = 2 gamma k_B T / (m l^2) with gamma = C/(m l)
    result = ll.VelocityKicks.thermal(TOY, temperature=300, noise_seed=4)
    expected = 2.0 * (0.01 / (0.2 * 0.5)) * BOLTZMANN * 300.0 / (0.2 * 0.5**2)
    assert result.noise_strength == pytest.approx(
        math.sqrt(expected), rel=1e-15
    )  # rounding of one root
    assert result.noise_seed == 4


@pytest.mark.parametrize(
    "temperature, message",
    [
        ("300", "temperature must be a number in K, got '300'"),
        (-1.0, "temperature must lie in [0, inf) K, got -1"),
        (math.nan, "temperature must be a number in K, got nan"),
    ],
)
def test_a_wrong_temperature_is_refused(temperature, message):
    with pytest.raises(InputError) as refused:
        ll.VelocityKicks.thermal(TOY, temperature=temperature)
    assert message in str(refused.value)


def test_thermal_noise_needs_a_system():
    with pytest.raises(InputError, match="system must be a system such as LatoLato, got 3"):
        ll.VelocityKicks.thermal(3, temperature=300.0)


@pytest.mark.parametrize(
    "options, message",
    [
        ({"noise_strength": None}, "noise_strength must be a number in rad/s^(3/2), got None"),
        (
            {"noise_strength": 1, "noise_interval": 0},
            "noise_interval must lie in (0, inf) s, got 0",
        ),
        (
            {"noise_strength": 1, "noise_interval": "1"},
            "noise_interval must be a number in s, got '1'",
        ),
        (
            {"noise_strength": 1, "noise_seed": 1.5},
            "noise_seed must be a whole number, got 1.5",
        ),
        (
            {"noise_strength": 1, "noise_seed": -1},
            "noise_seed must lie in [0, 2^63), got -1",
        ),
        (
            {"noise_strength": 1, "noise_seed": 2**63},
            "noise_seed must lie in [0, 2^63), got 9223372036854775808",
        ),
        (
            {"noise_strength": 1, "noise_stream": True},
            "noise_stream must be a whole number, got True",
        ),
        (
            {"noise_strength": 1, "noise_stream": 2**53},
            "noise_stream must lie in [0, 2^53), got 9007199254740992",
        ),
    ],
)
def test_wrong_parameters_are_refused(options, message):
    with pytest.raises(InputError) as refused:
        ll.VelocityKicks(**options)
    assert message in str(refused.value)


def test_the_noise_is_found_among_the_attributes_of_a_run(tmp_path):
    noise = ll.VelocityKicks(noise_strength=0.1, noise_seed=2**63 - 1)
    run = ll.simulate(TOY, initial_angle=0.5, duration=0.2, noise=noise)
    for result in (run, ll.load(ll.save(run, tmp_path / "run.nc"))):
        assert result.attrs["noise_strength"] == 0.1
        assert result.attrs["noise_seed"] == 2**63 - 1
        assert result.attrs["noise_interval"] == noise.spacing(TOY)  # the default, as used
    assert "noise_seed" not in ll.simulate(TOY, initial_angle=0.5, duration=0.2).attrs
