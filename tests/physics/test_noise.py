"""Velocity kicks: checked parameters with metadata, and the strength of thermal noise."""

import dataclasses
import math

import pytest

import latolato as ll
from latolato.core.errors import InputError
from latolato.core.quantities import QUANTITIES
from latolato.physics.noise import BOLTZMANN

TOY = ll.LatoLato(length=0.5, mass=0.2, radius=0.05, damping=0.01)


@pytest.mark.parametrize("law, prefix", [(ll.VelocityKicks, "noise"), (ll.ClampContact, "clamp")])
def test_every_field_carries_its_quantity_and_range(law, prefix):
    for field in dataclasses.fields(law):
        assert field.metadata["quantity"] is QUANTITIES[f"{prefix}_{field.name}"]
        assert field.metadata["description"]
        low, high = field.metadata["suggested"] or (1.0, 2.0)
        assert low in field.metadata["range"]
        assert high in field.metadata["range"]
        assert -1.0 not in field.metadata["range"]


def test_thermal_noise_balances_the_damping():
    # sigma^2 = 2 gamma k_B T / (m l^2) with gamma = C/(m l)
    found = ll.VelocityKicks.thermal(TOY, temperature=300, noise_seed=4)
    wanted = 2.0 * (0.01 / (0.2 * 0.5)) * BOLTZMANN * 300.0 / (0.2 * 0.5**2)
    assert found.strength == pytest.approx(math.sqrt(wanted), rel=1e-15)  # rounding of one root
    assert found.seed == 4


@pytest.mark.parametrize(
    "temperature, message",
    [
        ("300", "temperature must be a number in K, got '300'"),
        (-1.0, "temperature must lie in [0, inf) K, got -1"),
        (math.nan, "temperature must be finite, got nan"),
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
        ({"strength": None}, "strength must be a number in rad/s^(3/2), got None"),
        ({"strength": 1, "interval": 0}, "interval must lie in (0, inf) s, got 0"),
        ({"strength": 1, "interval": "1"}, "interval must be a number in s, got '1'"),
        ({"strength": 1, "seed": 1.5}, "seed must be a non-negative integer, got 1.5"),
        ({"strength": 1, "seed": -1}, "seed must be a non-negative integer, got -1"),
        ({"strength": 1, "seed": 2**63}, "seed must lie in [0, 2^63), got 9223372036854775808"),
        ({"strength": 1, "stream": True}, "stream must be a non-negative integer, got True"),
        ({"strength": 1, "stream": 2**53}, "stream must lie in [0, 2^53), got 9007199254740992"),
    ],
)
def test_wrong_parameters_are_refused(options, message):
    with pytest.raises(InputError) as refused:
        ll.VelocityKicks(**options)
    assert message in str(refused.value)


def test_the_noise_is_found_among_the_attributes_of_a_run(tmp_path):
    noise = ll.VelocityKicks(noise_strength=0.1, noise_seed=2**63 - 1)
    run = ll.simulate(TOY, initial_angle=0.5, duration=0.2, noise=noise)
    for found in (run, ll.load(ll.save(run, tmp_path / "run.nc"))):
        assert found.attrs["noise_strength"] == 0.1
        assert found.attrs["noise_seed"] == 2**63 - 1
        assert found.attrs["noise_interval"] == noise.spacing(TOY)  # the default, as used
    assert "noise_seed" not in ll.simulate(TOY, initial_angle=0.5, duration=0.2).attrs
