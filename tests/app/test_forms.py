"""The registry that pages build their forms from."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from latolato.app.forms import registry
from latolato.core.quantities import QUANTITIES
from latolato.figures import style
from latolato.io.shown_units import SIZES, read_texts


def test_the_registry_names_units_and_ranges_of_every_number():
    entries = registry()
    numbers = [o for o in entries["options"].values() if o["unit"] not in ("", "1")]
    assert numbers
    for option in numbers:
        assert option["units"], option
        assert any(unit["size"] == 1.0 for unit in option["units"]), option
    for law in [*entries["systems"].values(), *entries["drives"].values()]:
        for name in law["options"]:
            option = entries["options"][name]
            has_start = option["default"] is not None or option["usual"] is not None
            assert has_start or name in ("pivot_heights", "pivot_across"), (
                f"a form cannot begin with {name}"
            )


@pytest.mark.parametrize(
    "name", ["angle", "initial_angle", "drive_amplitude", "length", "mass", "drive_frequency"]
)
def test_pages_pictures_and_tables_read_a_quantity_in_the_same_unit(name):
    entries = registry()
    described = entries["quantities"][name]
    shown = entries["options"].get(name, {}).get("units", [{"name": described["shown_unit"]}])[0]
    assert shown["name"] == described["shown_unit"] == QUANTITIES[name].shown_unit
    if "size" in shown and shown["name"] in SIZES:
        assert read_texts(["1"], shown["name"]) == [shown["size"]]
    axis = Figure().subplots().yaxis
    variable = xr.DataArray(np.zeros(2), name=name, attrs=QUANTITIES[name].attributes)
    style.show_unit(axis, variable)
    assert axis.get_label_text().endswith(f"[{style.pretty_unit(shown['name'])}]")


def test_ticks_of_a_picture_stand_at_round_numbers_of_the_unit_on_show():
    axes = Figure().subplots()
    axes.set_ylim(0.0, 0.05)
    variable = xr.DataArray(
        np.zeros(2), name="drive_amplitude", attrs=QUANTITIES["drive_amplitude"].attributes
    )
    style.show_unit(axes.yaxis, variable)
    texts = [text.get_text() for text in axes.get_yticklabels()]
    assert texts == [f"{1000 * tick:g}" for tick in axes.get_yticks()]
    assert "20" in texts


def test_an_option_is_described_by_its_own_parameter_and_no_namesake():
    options = registry()["options"]
    # A quantity of the tracker and a field of some drives bear the same names.
    assert (options["frame"]["label"], options["frame"]["unit"]) == ("frame", "")
    assert options["drive_times"]["several"]
    assert options["drive_times"]["description"] == "stage starts"
    assert options["noise_seed"]["default"] == 0
    assert options["noise_seed"]["high"] == 2**63


def test_forms_choose_between_rods_and_strings():
    entries = registry()
    assert entries["options"]["suspension"]["choices"] == ["rod", "string"]
    assert entries["options"]["drag_frame"]["choices"] == ["pivot", "lab"]
    for name, system in entries["systems"].items():
        assert ("suspension" in system["options"]) == (name != "mathieu")
