"""The limits of a number, from which its check, its refusals and the rules of a page are made."""

import json
import math

import pytest

from latolato.app.forms import registry
from latolato.core.errors import InputError
from latolato.core.rules import RULES
from latolato.scenario.options import law_options
from latolato.simulation.parameters import SWEEP_PARAMETERS

NUMBERS = {
    name: option
    for name, option in (law_options() | SWEEP_PARAMETERS).items()
    if option.kind in (float, int)
}


@pytest.mark.parametrize("name", NUMBERS)
def test_a_number_is_refused_beyond_each_of_its_limits_and_in_its_words(name):
    option = NUMBERS[name]
    assert option.limits
    for limit in option.limits:
        step = 1 if option.kind is int else max(abs(limit.end), 1e-30)
        beyond = limit.end - step if limit.is_lower else limit.end + step
        first = next(each for each in option.limits if not each.holds(beyond))
        with pytest.raises(InputError) as refused:
            option.checked(beyond)
        rule, way_out = (text.format(**first.values) for text in RULES[first.rule])
        assert (refused.value.rule, refused.value.way_out) == (rule, way_out)
        assert (refused.value.parameter, refused.value.value) == (name, beyond)


@pytest.mark.parametrize("name", NUMBERS)
def test_a_limit_itself_is_taken_unless_it_is_open(name):
    option = NUMBERS[name]
    for limit in option.limits:
        is_first = all(each.holds(limit.end) for each in option.limits if each is not limit)
        if is_first and not limit.is_open:
            assert option.checked(limit.end) == limit.end
        else:
            with pytest.raises(InputError):
                option.checked(limit.end)


def test_pages_get_the_limits_of_every_option_as_data():
    options = json.loads(json.dumps(registry()["options"], allow_nan=False))
    assert options["duration"]["limits"][0] == {
        "is_lower": True,
        "end": 0.0,
        "is_open": True,
        "rule": "more_than",
        "values": {"range": "(0, inf) s", "end": "0"},
    }
    for name, option in law_options().items():
        assert len(options[name]["limits"]) == len(option.limits)
        assert all(math.isfinite(limit["end"]) for limit in options[name]["limits"])
