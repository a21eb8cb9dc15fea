"""Messages lead out: a typo to the name that was meant, a number to the values allowed."""

import dataclasses
import re

import numpy as np
import pint
import pytest
import xarray as xr

from latolato.core.errors import InputError
from latolato.core.quantities import ANY, POSITIVE, UNIT_INTERVAL, Range
from latolato.core.registry import checked_array, checked_number, suggest
from latolato.physics.drives import drives
from latolato.physics.pendulum import systems
from latolato.scenario.scenario import scenarios
from latolato.scenario.tables import RUN_OPTIONS

HARMONIC = [f.name for f in dataclasses.fields(drives["harmonic"])]
TOY = [f.name for f in dataclasses.fields(systems["latolato"]) if f.init]


@pytest.mark.parametrize(
    "typed, known, meant",
    [
        *((typed, list(systems), "latolato") for typed in ("latlato", "latolto", "lato-lato")),
        *((typed, list(systems), "latolato") for typed in ("Latolato", "latolatto", "lato")),
        *((typed, list(systems), "pendulum") for typed in ("pendulm", "pendelum", "pend")),
        *((typed, list(systems), "ballpair") for typed in ("pair", "ball_pair", "balpair")),
        *((typed, list(systems), "mathieu") for typed in ("matthieu", "mathiue")),
        *((typed, list(drives), "harmonic") for typed in ("harmonics", "harmnoic", "HARMONIC")),
        *(
            (typed, list(drives), "frequency_schedule")
            for typed in ("schedule", "frequencyschedule")
        ),
        *((typed, HARMONIC, "drive_phase") for typed in ("phase", "drive-phase", "drivephase")),
        *((typed, HARMONIC, "drive_amplitude") for typed in ("amplitude", "drive_amp")),
        *((typed, TOY, "length") for typed in ("lenght", "lengt", "Length")),
        *((typed, TOY, "damping") for typed in ("dampening", "dampnig")),
        *((typed, TOY, "restitution") for typed in ("resitution", "restituion")),
        *((typed, list(RUN_OPTIONS), "tolerance") for typed in ("tolerence", "tol")),
        *((typed, list(scenarios()), "fig04a") for typed in ("fig4a", "fig04", "Fig04a")),
    ],
)
def test_a_typo_leads_to_the_name_that_was_meant(typed, known, meant):
    assert suggest(typed, known) == f"did you mean '{meant}'?"


@pytest.mark.parametrize("known", [list(systems), list(drives), HARMONIC, TOY, list(RUN_OPTIONS)])
@pytest.mark.parametrize(
    "typed", ["friction", "omega", "voltage", "charge", "spring", "banana", "x", "", "theta", "e"]
)
def test_another_word_leads_to_what_is_known(typed, known):
    assert suggest(typed, known) == f"known are {', '.join(known)}"


def test_a_long_text_or_nothing_known_is_no_trouble():
    assert suggest("x" * 1_000_000, TOY).startswith("known are ")
    assert suggest("length", []) == "known are "


@pytest.mark.parametrize(
    "name, value, allowed, unit, message",
    [
        ("restitution", 1.5, UNIT_INTERVAL, "1", "in [0, 1], got 1.5; give at most 1"),
        ("restitution", -1, UNIT_INTERVAL, "1", "in [0, 1], got -1; give at least 0"),
        ("mass", 0, POSITIVE, "kg", "in (0, inf) kg, got 0; give more than 0"),
        ("share", 1, Range(0, 1, open_high=True), "1", "in [0, 1), got 1; give less than 1"),
    ],
)
def test_a_number_out_of_range_is_refused_with_a_way_out(name, value, allowed, unit, message):
    with pytest.raises(ValueError, match=f"^{re.escape(f'{name} must lie {message}')}$"):
        checked_number(name, value, allowed, unit)


def test_a_pure_number_has_no_unit_in_messages():
    with pytest.raises(InputError, match="restitution must be a number, got 'x'"):
        checked_number("restitution", "x", UNIT_INTERVAL, "1")


UNIT = pint.UnitRegistry()


@pytest.mark.parametrize(
    "quantity, unit, number",
    [
        (24.5 * UNIT.cm, "m", 0.245),
        (100 * UNIT.g, "kg", 0.1),
        (0.5 * UNIT.min, "s", 30.0),
        (90 * UNIT.deg, "rad", 0.5 * np.pi),
        (UNIT.Quantity(0.3, ""), "rad", 0.3),
        (UNIT.Quantity(20, "percent"), "1", 0.2),
        # To pint a hertz is 1/s and an angle has no dimension.
        (1.6 * UNIT.kHz, "rad/s", 3200.0 * np.pi),
        (144 * UNIT.rpm, "rad/s", 4.8 * np.pi),
        (2.0 / UNIT.s, "1/s", 2.0),
        (1.0 * UNIT.g * UNIT.cm / UNIT.s, "kg*m/s", 1e-5),
        (0.1 * UNIT.rad / UNIT.s**1.5, "rad/s^(3/2)", 0.1),
    ],
)
def test_quantities_become_numbers_in_the_unit(quantity, unit, number):
    assert checked_number("x", quantity, ANY, unit) == pytest.approx(number, rel=1e-15)


@pytest.mark.parametrize(
    "quantity, unit, text",
    [
        (3 * UNIT.s, "m", "must be given in m (or a unit that converts to it), got 3 second"),
        (2 / UNIT.s, "rad/s", "got 2 / second; give it in rad/s or Hz"),
        (2 * UNIT.Hz, "1/s", "must be given in 1/s"),
        (2 * UNIT.deg, "1", "must be given as a plain number, got 2 degree"),
        (20 * UNIT.deg, "m", "must be given in m"),
        (UNIT.Quantity(2, ""), "m", "got 2 dimensionless"),
        ([1, 2] * UNIT.m, "m", "must be a number in m, got [1, 2]"),
    ],
)
def test_quantities_of_another_kind_are_refused(quantity, unit, text):
    with pytest.raises(InputError, match=re.escape(text)):
        checked_number("x", quantity, ANY, unit)


@pytest.mark.parametrize(
    "values",
    [
        [10, 20] * UNIT.cm,
        [10 * UNIT.cm, 0.2 * UNIT.m],
        xr.DataArray([10, 20] * UNIT.cm),
        xr.DataArray([0.1, 0.2], attrs={"units": "m"}),
        np.ma.array([0.1, 0.2]),
        np.array([0.1, 0.2], dtype=object),
        (each / 10 for each in (1, 2)),
    ],
)
def test_rows_of_numbers_are_taken_in_many_forms(values):
    assert list(checked_array("x", values, unit="m")) == [0.1, 0.2]


def test_a_notebook_shows_systems_and_drives_as_tables_of_their_parameters():
    drive = drives["frequency_schedule"](
        drive_amplitude=0.02, times=[0.0, 1.0], drive_frequencies=[10.0, 12.0], drive_phase=0.5
    )
    table = drive._repr_html_()
    assert "<caption>FrequencySchedule</caption>" in table
    assert "<td>$A_0$</td><td><code>drive_amplitude</code></td><td>0.02 m</td>" in table
    assert "<code>times</code></td><td>2 values in s</td>" in table
    toy = systems["latolato"](length=0.2, mass=0.1, radius=0.02, suspension="string")
    assert "<code>suspension</code></td><td>string</td>" in toy._repr_html_()
