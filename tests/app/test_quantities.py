"""Pages read quantities as Python does, in addresses and in fields."""

from __future__ import annotations

import math

import pytest

from latolato.app.experiment.description import fields
from latolato.app.forms import registry
from latolato.core.errors import InputError
from latolato.scenario.units import to_si

TEXTS = [
    ("250 um", "m"), ("250 µm", "m"), ("100 grams", "kg"), ("20 degrees", "rad"),
    ("0.1 turn", "rad"), ("25 centimetres", "m"), ("0.3 km", "m"), ("24.5cm", "m"),
    ("0.003 kg m/s", "kg*m/s"), ("0.003 kg·m/s", "kg*m/s"), ("3 g*m/s", "kg*m/s"),
    ("0.05 newton second", "kg*m/s"), ("9.81 m/s²", "m/s^2"), ("20 °/s", "rad/s"),
    ("96 rev per minute", "rad/s"), ("2 rad/s³ᐟ²", "rad/s^(3/2)"), ("0.4 1/s", "1/s"),
    ("\u221220 °", "rad"), ("\u22121.5e\u22123 m", "m"), ("+.5 in", "m"), ("90 %", "1"),
    ("0.3", "m"), ("1e3", "s"), ("nan", "m"), ("inf m", "m"), ("-Infinity", "m"), ("20 kg", "m"),
    ("1.6 hz", "rad/s"), ("1.6 /s", "rad/s"), ("much", "m"), ("3 1", "1"), ("1 2 cm", "m"),
    ("", "m"), ("cm", "m"), ("--3 m", "m"),
]  # fmt: skip

# What a hand holds [m, rad/s, kg*m/s, 1].
CONTROLS = {
    "drive_amplitude": 0.03,
    "drive_frequency": 15.1,
    "damping": 0.00274,
    "restitution": 0.9,
}


def _with_units(options):
    """Return a text in every unit in which pages show a number, by its name and as it is shown."""
    return [
        ("1.5", unit["name"], option["unit"])
        for option in options
        for unit in option["units"]
        if unit["name"] != "1"
    ]


@pytest.fixture(scope="module")
def units():
    """Every unit of the pages with the SI unit that it stands for."""
    known = registry()
    variables = [v for each in known["observables"].values() for v in each["variables"].values()]
    described = [*known["options"].values(), *known["axes"].values(), *variables]
    return sorted({*_with_units(described), *_with_units(fields().values())})


@pytest.fixture(scope="module")
def answers(units, ask_node):
    """What pages read, of `TEXTS` and then of every unit; Node.js is started once."""
    requests = {
        "registry": registry(),
        "texts": TEXTS,
        "units": units,
        "controls": CONTROLS,
    }
    return ask_node("quantities_in_node.mjs", requests)


def _in_python(text, unit):
    """Return what Python reads, or its refusal."""
    try:
        return to_si("given", text, unit)
    except InputError as error:
        return str(error)


def test_pages_read_a_text_as_python_does(answers):
    for (text, unit), answer in zip(TEXTS, answers["model"], strict=True):
        wanted = _in_python(text, unit)
        if isinstance(wanted, float):
            # pi is rounded before the product there and after it here
            wanted = pytest.approx(wanted, rel=4e-16, abs=0, nan_ok=True)
            answer = float(answer)
        assert answer == wanted, text


def test_fields_take_what_addresses_take_but_infinity_and_nan(answers):
    for (text, unit), answer in zip(TEXTS, answers["fields"], strict=True):
        wanted = _in_python(text, unit)
        if isinstance(wanted, float) and math.isfinite(wanted):
            assert answer == pytest.approx(wanted, rel=4e-16, abs=0), text
        else:
            assert answer is None, text


def test_every_unit_that_pages_show_is_read_by_pages_and_by_python(units, answers):
    for (number, unit, si_unit), shown in zip(units, answers["units"], strict=True):
        wanted = to_si("given", f"{number} {unit}", si_unit)
        assert shown["values"] == [pytest.approx(wanted, rel=4e-16)] * 2, unit
        assert to_si("given", shown["text"], si_unit) == wanted, shown["text"]


def test_fields_read_what_a_hand_writes_into_the_address(answers):
    assert answers["controls"] == CONTROLS
