"""Sentences of rules that Python and the pages share."""

import pickle
import re
from inspect import signature
from string import Formatter

import pytest

from latolato.analysis import analyses
from latolato.analysis.checks import check_span
from latolato.analysis.rules import RULES as OF_ANALYSES
from latolato.analysis.rules import broken_analysis
from latolato.core.errors import InputError, Word, called, in_parts, joined
from latolato.core.faults import refusal_of
from latolato.core.parameters import flag_of
from latolato.core.rules import RULES, Rule, broken_rule, either_of, sentence
from latolato.experiment.importing import TARGETS, import_table
from latolato.experiment.parameters import VIDEO_PARAMETERS
from latolato.experiment.rules import RULES as OF_MEASUREMENTS
from latolato.experiment.rules import broken
from latolato.io.tables.rules import RULES as OF_TABLES
from latolato.physics.problems import PROBLEMS
from latolato.scenario.analysis_options import options_of
from latolato.scenario.options import law_options

SENTENCES = {
    **RULES,
    **OF_MEASUREMENTS,
    **OF_TABLES,
    **OF_ANALYSES,
    **{problem.name: (problem.rule, problem.way_out) for problem in PROBLEMS},
}
# What rules may name: parameters of functions, columns of tables, and the file of a run on the
# command line.
OPTIONS = {
    *law_options(),
    *VIDEO_PARAMETERS,
    *signature(import_table).parameters,
    *(name for analysis in analyses.values() for name in options_of(analysis)),
    *TARGETS,
    "balls",
    "from",
}


def on_the_command_line(error):
    """The text of an error where each parameter has a flag."""
    error.name_of = flag_of
    return refusal_of(error)


@pytest.mark.parametrize("name", SENTENCES)
def test_pages_can_fill_every_gap(name):
    for text in SENTENCES[name]:
        for _, gap, digits, conversion in Formatter().parse(text):
            if gap is None:
                continue
            parameter, _, value = gap.removeprefix("@").partition("=")
            assert re.fullmatch(r"\w+|@", gap) or (
                parameter in OPTIONS and re.fullmatch(r"\w*", value)
            )
            assert re.fullmatch(r"((\.\d+)?g)?", digits)
            assert conversion is None


@pytest.mark.parametrize("name", SENTENCES)
def test_rules_leave_it_to_each_surface_what_an_option_is_called(name):
    for text in SENTENCES[name]:
        assert "--" not in text


def test_names_of_which_one_is_meant_are_translated_one_by_one():
    names = in_parts(either_of(["pendulum", "latolato", "ballpair"]))
    assert (names["name"], names["values"]["other"]) == ("either_of", {"word": "ballpair"})
    first = names["values"]["first"]["values"]
    assert first == {"first": {"word": "pendulum"}, "other": {"word": "latolato"}}


def test_a_gap_may_hold_the_name_of_a_parameter():
    with pytest.raises(InputError, match="velocity_low must be less than velocity_high") as caught:
        check_span(2.0, 2.0, "velocity_")
    assert on_the_command_line(caught.value) == (
        "--velocity-low must be less than --velocity-high, got 2"
    )


def test_a_gap_may_hold_what_sets_a_parameter():
    assert str(broken_analysis("drag_of_pivot")).endswith("or give damping=0")
    strings = broken_analysis("needs_strings", parameter="kind", value="slack_onset")
    assert str(strings) == "kind needs strings, got 'slack_onset'; give suspension='string'"
    message = on_the_command_line(strings)
    assert message == "kind needs strings, got 'slack_onset'; give --suspension string"


def test_what_is_missing_is_called_as_its_reader_would_give_it():
    lacks = broken_rule("needed", {"law": "Chirp", "unit": " [m]"}, parameter="row_time")
    assert str(lacks) == "Chirp needs 'row_time' [m]"
    assert (
        lacks.worded("\u201ctime from row to row\u201d")
        == "Chirp needs \u201ctime from row to row\u201d [m]"
    )
    assert on_the_command_line(lacks) == "Chirp needs --row-time [m]"


def test_a_sentence_calls_parameters_as_its_reader_does():
    second = broken("second_ball", {"time": 1.5})
    assert str(second).endswith("point at both (balls=2), or use the part before that (end)")
    message = on_the_command_line(pickle.loads(pickle.dumps(second)))
    assert message.endswith("point at both (--balls 2), or use the part before that (--end)")
    # Also one within another.
    assert called(joined([second.way_out]), flag_of) in message


def test_a_broken_rule_has_the_parts_of_its_sentence():
    error = broken_rule("at_least", {"range": "[0, 1]", "end": "0"}, parameter="e", value=-1.0)
    assert (error.rule, error.way_out) == ("must lie in [0, 1]", "give at least 0")
    assert (error.parameter, error.value) == ("e", -1.0)
    assert str(error) == "e must lie in [0, 1], got -1; give at least 0"
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


def test_a_sentence_keeps_its_parts_in_another_process():
    inner = sentence("meant", name="length")
    text = joined([sentence("known", names=Word("one")), inner])
    assert text == "known are one did you mean 'length'?"
    copy = pickle.loads(pickle.dumps(text))
    parts = in_parts({"said": [copy]})["said"][0]
    assert parts["text"].format(**dict.fromkeys(parts["values"], "x")) == "x x"
    first, second = parts["values"].values()
    assert first["values"] == {"names": {"word": "one"}}
    assert (second["name"], second["values"]) == ("meant", {"name": "length"})


def test_values_may_name_the_parameter():
    names = {"names": "{parameter} and heights", "counts": "2 and 3"}
    error = broken_rule("one_length", names, parameter="times")
    assert str(error) == "times and heights must be of one length, got 2 and 3"


def test_a_given_way_out_takes_the_place_of_the_usual_one():
    error = broken_rule("at_least", {"range": "[0, 1]", "end": "0"}, way_out="ask")
    assert str(error) == "must lie in [0, 1]; ask"


def test_a_further_way_out_keeps_the_parts_of_both():
    error = broken_rule("shortest_stage", {"shortest": 0.5})
    error.add_way_out(sentence("meant", name="length"))
    assert error.parts()["way_out"]["name"] == "meant"
    error.add_way_out(sentence("meant", name="radius"))
    assert str(error).endswith("; did you mean 'length'?; did you mean 'radius'?")
    both = error.parts()["way_out"]["values"].values()
    assert [each["values"]["name"] for each in both] == ["length", "radius"]


def test_the_kind_of_an_error_can_be_another():
    class OddError(InputError):
        pass

    assert type(broken_rule("switch", parameter="x", value=2, kind=OddError)) is OddError


def test_sentences_write_numbers_as_people_do():
    times = "\N{MULTIPLICATION SIGN}"
    written = {8.2e-5: f"8.2 {times} 10⁻⁵", 3.63e7: f"3.6 {times} 10⁷", 260.0: "260", 0.25: "0.25"}
    for number, text in written.items():
        shown = sentence("cut", {"cut": Rule("at {number:.2g} m")}, number=number)
        assert shown == f"at {text} m"
