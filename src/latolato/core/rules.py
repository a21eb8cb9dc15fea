"""Rules that both Python and the pages check, each with the one sentence that refuses input.

Pages load the table with the registry, so their sentences are those of Python, and translate a
sentence by the name of its rule. What only Python checks has its sentence where it is checked.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import reduce
from typing import Any, NamedTuple

from latolato.core.errors import NOT_GIVEN, InputError, NamedRule, Sentence, Word, name_gap


class Rule(NamedTuple):
    """The rule and the way out of an `InputError`, with gaps as in Python's format strings.

    ``{parameter}`` stands for the parameter at fault as the input calls it, ``{@}`` for what a
    user calls it, and ``{@end}`` for what a user calls the parameter `end`: an option on the
    command line, a field of a page. ``{@frame=lab}`` is what sets a parameter to a word or a
    number. No gap has a format but ``g``.
    """

    rule: str
    way_out: str = ""


RULES = {
    # of numbers, words and lists
    "number": Rule("must be a number"),
    "number_in_unit": Rule("must be a number in {unit}"),
    "whole_number": Rule("must be a whole number"),
    "quantity_of_unit": Rule("must be given in {unit} (or a unit that converts to it)"),
    "plain_number": Rule("must be given as a plain number"),
    "numbers": Rule("must be a sequence of numbers"),
    "numbers_in_unit": Rule("must be a sequence of numbers in {unit}"),
    "list_length": Rule("must hold at least {least} {values}, got {count}"),
    "units_of_list": Rule("must carry a unit on every value or on none"),
    "quantities": Rule("must be a list of quantities"),
    "text_or_number": Rule("must be a text or a number"),
    "increasing": Rule(
        "must increase strictly, got {after:g} after {before:g} at position {place}",
        "sort them and remove repeats",
    ),
    "switch": Rule("must be true or false"),
    "choice": Rule("must be {words} or {last}"),
    "one_of": Rule("must be one of {names}"),
    # the ends of a range, and the sizes that can be computed with
    "at_least": Rule("must lie in {range}", "give at least {end}"),
    "more_than": Rule("must lie in {range}", "give more than {end}"),
    "at_most": Rule("must lie in {range}", "give at most {end}"),
    "less_than": Rule("must lie in {range}", "give less than {end}"),
    "size": Rule("must lie in {range}", "check its order of magnitude"),
    "turns": Rule("must lie in {range}", "leave out whole turns"),
    "tiny": Rule("must be at least {end}", "check its order of magnitude"),
    # of names
    "meant": Rule("did you mean '{name}'?"),
    "known": Rule("known are {names}"),
    "unknown": Rule("unknown {kind} '{name}': {hint}"),
    "unknown_scenario": Rule("there is no scenario '{name}': {hint}"),
    "kind_of_law": Rule("the kind of {part} must be a text"),
    "what_to_run": Rule(
        "name what to run: a scenario (`latolato scenarios` lists them), a TOML file, "
        "the file of a run ({@from}) or {@system} with one of {systems}"
    ),
    "one_run": Rule(
        "{name} is a sweep over {axes}, not one run",
        "use `latolato sweep {file}`, or Scenario.sweep in Python",
    ),
    # of the parameters of laws
    "needed": Rule("{law} needs '{@}'{unit}"),
    "of_each_part": Rule("{law} has no '{parameter}' of its own: give {parts}"),
    "foreign": Rule(
        "belongs to {part} {owners}, not to {kind}", "leave it out or change the {part}"
    ),
    "foreign_part": Rule(
        "belongs to {part} {owners}, not to {kind}", "use {name} or change the {part}"
    ),
    "either_of": Rule("{first} or {other}"),
    "each_of": Rule("{first} and {other}"),
    "either": Rule("give either {name} or {parameter}, got both"),
    "rigid_rod": Rule(
        "must be 0 with suspension 'rod', as a rod never goes slack",
        "give 0, or {@suspension=string}",
    ),
    "lab_drag": Rule(
        "must be 'pivot' with {@quadratic_damping}, as drag relative to the room is described for "
        "linear damping only",
        "give {@quadratic_damping=0} for 'lab'",
    ),
    "mirrored_pivot": Rule(
        "moves the pivot sideways, which breaks the mirror symmetry of a {law}: {parameter} must "
        "be vertical",
        "use a BallPair",
    ),
    "vertical_pivot": Rule(
        "moves the pivot sideways, which a {law} does not describe: {parameter} must be vertical",
        "use a Pendulum",
    ),
    "amplitude_limit": Rule("must be less than {name} {end:g}, or {otherwise}"),
    "one_length": Rule("{names} must be of one length, got {counts}"),
    "first_stage": Rule("must begin with 0, the start of the first stage"),
    "shortest_stage": Rule("must not exceed the shortest stage {shortest:g} s"),
    "meeting_balls": Rule(
        "{parameter} '{name}' is for balls that meet, and a {law} has none", "leave it out"
    ),
    "clamped_toy": Rule(
        "{parameter} 'clamp' exists for the mirror-symmetric LatoLato only",
        "use 'exact' for a BallPair",
    ),
    "clamped_rods": Rule(
        "{parameter} '{name}' is described for rods and for drag relative to the pivot only, not "
        "for {what}",
        "use 'exact' or 'none'",
    ),
    # of the start and the instants of a run
    "angle_needed": Rule("is needed [rad] (a LatoLato also accepts {@initial_offset})"),
    "angle_or_offset": Rule("give only one of {parameter} and {@initial_offset}"),
    "offset_of_toy": Rule(
        "counts from the low contact angle of a LatoLato",
        "use {@initial_angle} for other systems",
    ),
    "one_number": Rule("must be one number in {unit} for one angle"),
    "two_numbers": Rule("of a BallPair must be two numbers (right, left)"),
    "of_strings": Rule(
        "is for balls on strings: a rod keeps its ball at its length and never goes slack",
        "leave it out, or give {@suspension=string} to a Pendulum, LatoLato or BallPair",
    ),
    "of_rods": Rule(
        "is for balls on rods: a string never pushes, it goes slack",
        "ask for slack_fraction, or give {@suspension=rod}",
    ),
    "no_friction": Rule(
        "must be 0 for {what} on strings: dry friction ends at once where a string goes slack",
        "leave it out, or give {@suspension=rod}",
    ),
    "duration_needed": Rule("is needed: give the end of the run in s, or times"),
    "duration_of_samples": Rule("needs a duration"),
    "later_times": Rule(
        "must reach beyond 0 s, where a run begins, got {last:g} as the last",
        "add a later instant or give duration",
    ),
    "times_of_run": Rule("must lie in [0, duration = {end:g}] s"),
    "clamp_step": Rule(
        "must not exceed the duration {end:g} s", "a thousandth of a second is usual"
    ),
    "default_samples": Rule(
        "{count:.3g} default samples exceed the limit of {limit}; shorten the duration or name "
        "fewer instants with times"
    ),
    # how a run ended, and its warnings
    "left_numbers": Rule("failed at t = {time:.9g} s: the motion left the range of numbers"),
    "left_model": Rule(
        "stopped at t = {time:.9g} s: a string ran into a ball, or balls rested on each other on a "
        "slack string, which is not described"
    ),
    "contact_limit": Rule("stopped at t = {time:.9g} s by {@contact_limit} = {limit}"),
    "ended_early": Rule("the run {status}; there are no values after that"),
    "open_ledger": Rule(
        "the energy ledger closes only to {residual:.3g} J, {share:.2g} of the largest energy: "
        "tolerance {tolerance:g} was not reached with step {step:.3g} s"
    ),
    "no_sample": Rule(
        "the run {status}; no sample and no contact is known", "ask for earlier times"
    ),
    # of maps
    "axis_needed": Rule(
        "{name} is needed [rad], as a value or an axis (a LatoLato also accepts {@initial_offset})"
    ),
    "streams": Rule(
        "{count} points need as many streams from {first} on, but streams lie in [0, 2^53): begin "
        "with a smaller one"
    ),
    "single_period": Rule("a {name} drive has no single period that a stroboscope could follow"),
    "exact_contact": Rule(
        "{name} needs exact contact: a clamped motion depends on its step, so small perturbations "
        "have no meaning there"
    ),
    "overlay_axes": Rule(
        "overlays and points need a map of amplitude ({amplitudes}) and frequency ({frequencies})"
    ),
    "overlay_drag": Rule(
        "must be 'pivot' here: overlays are computed for drag relative to the pivot, and that of "
        "this map is relative to the room",
        "leave them out",
    ),
    "overlay_parameter": Rule("this map does not say its {parameter}, which overlays need"),
    "other_system": Rule(
        "this curve is of another system than the map: its {name} is {there}, that of the map "
        "{here}"
    ),
    "tongue": Rule(
        "must be below 2 m l w0 for a tongue to exist, got {damping:g} ({ratio:.3g} times that)",
        "use growth_rate for overdamped cases",
    ),
    "lift_off": Rule("overlay lift_off needs a system with contact: nothing rests on a wall"),
    # of tables of trials
    "columns": Rule("it holds no columns"),
    "cells_of_row": Rule(
        "row {row} has {cells} cells below {names} column names",
        "separate cells by commas, and write numbers with a decimal point",
    ),
    "renamed_column": Rule("the column {former} is now called {name}", "rename it, and its _sigma"),
    "trial_columns": Rule(
        "a trial table needs the columns drive_amplitude, drive_frequency or frequency_ratio, and "
        "class or largest_angle and largest_angle_after_transient"
    ),
    "trial_extremes": Rule(
        "a trial table without class needs largest_angle and largest_angle_after_transient"
    ),
    "positive": Rule("must be positive and finite"),
    "positive_in_row": Rule("must be positive and finite in row {row}"),
    # of pages only
    "beyond_page": Rule(
        "the {parameter} {name} is computed by the installed program, not in a page"
    ),
    "law_beyond_page": Rule(
        "the {parameter} law {name} is computed by the installed program, not in a page"
    ),
    "beyond_notebook": Rule(
        "players in notebooks leave out the code for {parameter} {name}, to stay small",
        "compute the run in Python and show it with ll.play",
    ),
}


def sentence(rule: str, table: Mapping[str, Rule] = RULES, /, **values: Any) -> Sentence:
    """The sentence of a rule alone, such as a warning."""
    return Sentence(NamedRule(rule, *table[rule], values))


def either_of(names: Sequence[str]) -> str:
    """Return names of which one is meant.

    Examples
    --------
    >>> print(either_of(["pendulum", "latolato"]))
    pendulum or latolato
    """
    return _listed("either_of", [Word(name) for name in names])


def each_of(parameters: Sequence[str]) -> str:
    """Return what its reader calls parameters that are all needed.

    Examples
    --------
    >>> print(each_of(["right_length", "left_length"]))
    right_length and left_length
    """
    return _listed("each_of", [name_gap(parameter) for parameter in parameters])


def _listed(rule: str, names: Sequence[str]) -> str:
    """Return names joined by a rule, pair by pair."""
    return reduce(lambda a, b: sentence(rule, first=a, other=b), names)


def broken_rule(
    name: str,
    values: Mapping[str, Any] | None = None,
    *,
    parameter: str | None = None,
    value: Any = NOT_GIVEN,
    way_out: str | None = None,
    kind: type[InputError] = InputError,
    table: Mapping[str, Rule] = RULES,
) -> InputError:
    """Return the error of input that breaks a rule.

    Parameters
    ----------
    name : str
        One of the table.
    values : mapping, optional
        What stands in the gaps of its sentence.
    parameter, value, way_out
        Those of `InputError`; a way out that is given takes the place of the rule's.
    kind : type
        `InputError`, or a kind of it.
    table : mapping
        `RULES`, or rules that only Python checks.

    Examples
    --------
    >>> print(broken_rule("shortest_stage", {"shortest": 0.5}, parameter="ramp", value=2.0))
    ramp must not exceed the shortest stage 0.5 s, got 2
    """
    named = NamedRule(name, *table[name], values or {})
    usual = Sentence(named, "way_out")
    return kind(Sentence(named), parameter=parameter, value=value, way_out=way_out or usual or None)
