"""The registry that pages build their forms from."""

from latolato.app.forms import registry


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
            assert has_start or name == "pivot_heights", f"a form cannot begin with {name}"


def test_an_option_is_described_by_its_own_parameter_and_no_namesake():
    options = registry()["options"]
    # A quantity of the tracker and a field of some drives bear the same names.
    assert (options["frame"]["label"], options["frame"]["unit"]) == ("frame", "")
    assert options["drive_times"]["several"]
    assert options["drive_times"]["description"] == "stage starts"
    assert options["noise_seed"]["default"] == 0
    assert options["noise_seed"]["high"] == 2**63
