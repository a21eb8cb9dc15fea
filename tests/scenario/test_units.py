"""Quantities with units become SI numbers."""

import math
import subprocess
import sys

import numpy as np
import pytest

from latolato.core.quantities import QUANTITIES
from latolato.scenario import units as module
from latolato.scenario.units import to_si, to_si_list

TURN = 2.0 * math.pi


@pytest.mark.parametrize(
    "text, unit, expected",
    [
        ("24.5 cm", "m", 0.245),
        ("24.5cm", "m", 0.245),
        ("20 mm", "m", 0.02),
        ("3 µm", "m", 3e-6),
        ("106 g", "kg", 0.106),
        ("250 ms", "s", 0.25),
        ("1.5 min", "s", 90.0),
        ("90 %", "1", 0.9),
        ("0.05 kg m/s", "kg*m/s", 0.05),
        ("5 g*m/s", "kg*m/s", 0.005),
        ("0.05 N s", "kg*m/s", 0.05),
        ("0.05 newton second", "kg*m/s", 0.05),
        ("9.81 m/s²", "m/s^2", 9.81),
        ("1 g_0", "m/s^2", 9.80665),
        ("1e-3", "m", 1e-3),
        (".5 rad", "rad", 0.5),
        ("0 deg", "rad", 0.0),
    ],
)
def test_decimal_units_convert_to_the_last_bit(text, unit, expected):
    assert to_si("x", text, unit) == expected


@pytest.mark.parametrize(
    "text, unit, expected",
    [
        ("20 deg", "rad", TURN / 18),
        ("20 degrees", "rad", TURN / 18),
        ("-25°", "rad", -TURN * 25 / 360),
        ("\N{MINUS SIGN}25 deg", "rad", -TURN * 25 / 360),
        ("1 turn", "rad", TURN),
        ("1.6 Hz", "rad/s", 1.6 * TURN),
        ("0.0016 kHz", "rad/s", 1.6 * TURN),
        ("96 rpm", "rad/s", 1.6 * TURN),
        ("96 rev/min", "rad/s", 1.6 * TURN),
        ("96 rev per minute", "rad/s", 1.6 * TURN),
        ("10 deg/s", "rad/s", TURN / 36),
    ],
)
def test_angular_units_carry_their_factor_of_two_pi(text, unit, expected):
    # one rounding of the decimal result and one of the expected product
    assert to_si("x", text, unit) == pytest.approx(expected, rel=4e-16)


@pytest.mark.parametrize("unit", sorted({q.unit for q in QUANTITIES.values()} - {"1"}))
def test_every_unit_of_the_glossary_is_known(unit):
    # the brackets keep the text from being taken for the unit as it is written there
    assert to_si("x", f"2 ({unit})", unit) == 2.0


def test_a_byte_order_mark_within_a_text_is_a_space():
    assert to_si("x", "\ufeff30 mm", "m") == 0.03


@pytest.mark.parametrize("value", [0.245, 3, True, None, [1.0], math.nan])
def test_what_is_not_text_is_left_to_the_checks_of_the_laws(value):
    assert to_si("x", value, "m") is value


@pytest.mark.parametrize(
    "text, unit",
    [
        ("24.5 kg", "m"),
        ("24.5 furlong", "m"),
        ("24.5 m^2", "m"),
        ("1.6 /s", "rad/s"),
        ("1.6 1/s", "rad/s"),
        ("3 m", "rad"),
        ("abc", "m"),
        ("", "m"),
        ("1,5 m", "m"),
        ("5 m)(", "m"),
        ("5 m**", "m"),
        ("5 ()", "m"),
        ("2 m^(1/0)", "m"),
        ("2 (lambda:1)", "m"),
        ("2 m.real", "m"),
        ("1 m-s", "m"),
    ],
)
def test_other_units_are_refused_in_one_line_with_the_rule(text, unit):
    with pytest.raises(ValueError, match="must be given in") as refused:
        to_si("length", text, unit)
    expected = f"length must be given in {unit} (or a unit that converts to it), got {text!r}"
    assert str(refused.value) == expected


@pytest.mark.parametrize(
    "text, unit, meant", [("2.4 hz", "rad/s", "Hz"), ("20 MM", "m", "mm"), ("1 KG", "kg", "kg")]
)
def test_capitals_that_are_wrong_lead_to_the_unit_that_was_meant(text, unit, meant):
    with pytest.raises(ValueError, match="must be given in") as refused:
        to_si("drive_frequency", text, unit)
    assert refused.value.way_out == f"did you mean '{meant}'?"


def test_a_pure_number_with_a_unit_is_refused():
    with pytest.raises(
        ValueError, match=r"restitution must be given as a plain number, got '0.9 kg'"
    ):
        to_si("restitution", "0.9 kg", "1")


@pytest.mark.parametrize("text", ["nan", "inf", "-inf m", "1e400 cm"])
def test_numbers_that_are_not_finite_pass_to_the_checks_of_the_laws(text):
    assert not math.isfinite(to_si("x", text, "m"))


def test_plain_numbers_and_si_units_do_not_load_pint():
    code = (
        "import sys; from latolato.scenario.units import to_si\n"
        "to_si('x', '0.5', 'm'), to_si('x', '0.05 kg m/s', 'kg*m/s')\n"
        "sys.exit('pint' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_list_is_converted_part_by_part():
    assert to_si_list("times", "0, 250 ms, 0.5 min", "s") == [0.0, 0.25, 30.0]
    assert to_si_list("times", ["0 s", 1.5, "2 s"], "s") == [0.0, 1.5, 2.0]
    assert to_si_list("times", "3 s", "s") == [3.0]


def test_a_list_with_units_on_some_values_only_is_refused():
    with pytest.raises(ValueError, match="every value or on none, got '20 deg, -25'"):
        to_si_list("initial_angle", "20 deg, -25", "rad")


def test_a_file_of_one_column_is_read(tmp_path):
    (tmp_path / "times.txt").write_text("# seconds\n0\n0.5\n1e1\n")
    assert to_si_list("times", "times.txt", "s", tmp_path) == [0.0, 0.5, 10.0]


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
@pytest.mark.parametrize("column", ["height", "2"])
def test_a_column_of_a_table_is_read_by_name_or_number(tmp_path, separator, column):
    rows = [("time", "height"), ("0", "0.1"), ("1", "-0.2")]
    text = "".join(separator.join(row) + "\n" for row in rows)
    (tmp_path / "pivot.csv").write_text(f"# a comment, with a comma\n{text}")
    found = to_si_list("pivot_heights", f"pivot.csv:{column}", "m", tmp_path)
    assert found == [0.1, -0.2]


def test_a_column_in_the_unit_of_its_title_is_read_in_si_units(tmp_path):
    (tmp_path / "map.csv").write_text("drive_amplitude [mm],crossings\n20,3\n34,5\n")
    for column in ("drive_amplitude [mm]", "1"):
        found = to_si_list("drive_amplitude", f"map.csv:{column}", "m", tmp_path)
        assert found == [0.02, 0.034]


@pytest.mark.parametrize("column", ["drive_frequency [Hz]", "drive_frequency", "2"])
def test_any_unit_of_a_title_is_converted_and_a_wrong_one_is_refused(tmp_path, column):
    (tmp_path / "trials.csv").write_text("class,drive_frequency [Hz],length [kg]\n1,1.6,1\n")
    found = to_si_list("drive_frequency", f"trials.csv:{column}", "rad/s", tmp_path)
    assert found == [to_si("drive_frequency", "1.6 Hz", "rad/s")]
    with pytest.raises(ValueError, match=r"column 'length \[kg\]' .*length must be given in m"):
        to_si_list("length", "trials.csv:length", "m", tmp_path)


@pytest.mark.parametrize(
    "name, message",
    [
        ("pivot.csv", "has 2 columns; name one, as in pivot.csv:time"),
        ("pivot.csv:heigth", "has no column 'heigth': did you mean 'height'?"),
        ("broken.csv:time", "cannot be read as numbers"),
        ("missing.csv", "got 'missing.csv'; there is no file of that name either"),
        ("binary.nc", "binary.nc' is not a text file"),
        ("empty.txt", "empty.txt' holds no numbers"),
    ],
)
def test_a_file_that_cannot_be_read_is_refused_with_its_name(tmp_path, name, message):
    (tmp_path / "pivot.csv").write_text("time,height\n0,0\n1,0\n")
    (tmp_path / "binary.nc").write_bytes(b"\x89HDF\xff")
    (tmp_path / "empty.txt").write_text("# only this\n")
    (tmp_path / "broken.csv").write_text("time,height\n0,0\nhm,0\n")
    with pytest.raises(ValueError, match="times") as refused:
        to_si_list("times", name, "s", tmp_path)
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


def test_arrays_pass_unchanged():
    values = np.array([0.0, 1.0])
    assert to_si_list("times", values, "s") is values


@pytest.mark.parametrize("given, unit", module._COMMON)
def test_common_conversions_are_those_of_pint(given, unit, monkeypatch):
    random = np.random.default_rng(3)
    texts = [f"{number!r} {given}" for number in map(float, random.lognormal(0.0, 5.0, 200))]
    texts += [f"{number} {given}" for number in ("24.5", "-0.1", "1e-3", "360", "nan", "inf")]
    quickly = [to_si("quantity", text, unit) for text in texts]
    monkeypatch.setattr(module, "_COMMON", {})
    np.testing.assert_array_equal(quickly, [to_si("quantity", text, unit) for text in texts])
