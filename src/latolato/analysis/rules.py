"""Rules that analyses check, each with the one sentence that refuses input.

The pages translate a sentence by the name of its rule, as those of `latolato.core.rules`.
"""

from __future__ import annotations

from functools import partial
from typing import Any

from latolato.core.errors import Sentence
from latolato.core.rules import Rule, broken_rule, sentence

_NO_WALLS = (
    "choose the system Pendulum, which has no walls, with the length, mass and damping of one ball"
)
RULES = {
    # of the laws
    "settling_motion": Rule(
        "must have motion that settles, but that of the linearised Mathieu only grows or decays",
        "use Pendulum, or mathieu_growth_rate",
    ),
    "repeating_drive": Rule("must repeat itself with a single period", "give one such as Harmonic"),
    "vertical_drive": Rule(
        "moves the pivot sideways, which this analysis does not describe: {parameter} must be "
        "vertical",
        "use Harmonic, or simulate and sweep",
    ),
    "continued_rods": Rule(
        "must be 'rod' here: each motion continues from an angle and an angular velocity, but a "
        "slack ball also has a distance and a radial velocity",
        "sweep starts instead, or give {@suspension=rod}",
    ),
    "drag_of_pivot": Rule(
        "must be 'pivot' here: this is computed for drag relative to the pivot",
        "use floquet or a sweep, or give {@damping=0}",
    ),
    "unclamped": Rule(
        "must be exact or none here: a clamped motion depends on its step, so small perturbations "
        "have no meaning"
    ),
    "upright_rod": Rule(
        "must be 'rod' for a ball that stands upright: a string does not push",
        "give {@suspension=rod}",
    ),
    "inverted_mathieu": Rule(
        "a Mathieu system is linearised about hanging and has no inverted position; use ll.Pendulum"
    ),
    "linear_friction": Rule(
        "must be 0",
        "dry friction holds the ball near the position, whose stability is then no linear "
        "question: simulate with a push instead",
    ),
    "hanging_points": Rule(
        "must be 0", f"balls with a radius touch before they hang straight down: {_NO_WALLS}"
    ),
    "upright_points": Rule(
        "must be 0", f"balls with a radius touch before they stand upright: {_NO_WALLS}"
    ),
    "lossless_balls": Rule(
        "must be 1",
        f"balls that lose energy whenever they meet follow no linear equation: {_NO_WALLS}",
    ),
    "one_drag_rate": Rule(
        "the balls must have one drag rate damping/mass, or their meetings mix two motions",
        _NO_WALLS,
    ),
    "walls_of_map": Rule(
        "an impact map needs walls, and {law} has none; use LatoLato or BallPair, or "
        "poincare_section"
    ),
    "mirror_symmetric": Rule(
        "must be a LatoLato, whose one-ball model is tested: other systems have no "
        "mirror-symmetric motion"
    ),
    "wall_to_start": Rule(
        "a {law} has no wall to start from; use a LatoLato or BallPair, or threshold_amplitude "
        "for growth from hanging"
    ),
    "lifting_radius": Rule(
        "balls without a radius rest straight below the pivot, where nothing lifts them; give a "
        "radius or use threshold_amplitude"
    ),
    "alike_lengths": Rule(
        "must be 'rod' for balls of so different lengths: where they rest on each other, the upper "
        "one would have to be held by a push",
        "make the lengths more alike, or give {@suspension=rod}",
    ),
    "taut_hanging": Rule(
        "must be smaller for a ball that hangs still on a taut string: at {frequency:g} rad/s the "
        "pivot falls faster than the ball",
        "lower it or give {@suspension=rod}",
    ),
    "taut_orbit": Rule(
        "must be 'rod' for this orbit: a string goes slack {time:.6g} s after time zero, and "
        "orbits are followed on taut strings only",
        "shake less, begin at another orbit, or give {@suspension=rod}",
    ),
    "accumulating_impacts": Rule("must lie in [0, 1) for impacts to accumulate"),
    "drive_of_stages": Rule(
        "{law} drive has no stages: give a Harmonic one or a FrequencySchedule"
    ),
    "smooth_drive": Rule(
        "the drive's waveform has more than {count} overtones: it is not smooth enough for this "
        "analysis; a crank must be shorter than its connecting rod by more"
    ),
    # of arguments
    "needed_by_analysis": Rule("this analysis needs {@}{unit}"),
    "value_of_each": Rule("give one value for each parameter, with commas between"),
    "such_values": Rule("give values such as 0 : 1 : 11, which are 11 from 0 to 1"),
    "no_repeat": Rule("must not repeat a value", "remove one"),
    "low_to_high": Rule("{@} must be less than {high}"),
    "low_to_high_of": Rule("{@} must be less than {@high} for {name}"),
    "entropy_box": Rule(
        "must be at most the points of either axis, {points}", "take a smaller box or more points"
    ),
    "most_starts": Rule(
        "{count} starts exceed the limit of {limit}; lower {@angle_points} or {@velocity_points}"
    ),
    "finer_tolerance": Rule(
        "must be below the tolerance of {tolerance:g} rad",
        "give a smaller one, or none for a tenth",
    ),
    "angles_between_walls": Rule(
        "the angle range must lie between the contact angles [{low:.6g}, {high:.6g}] rad, got "
        "[{first:.6g}, {last:.6g}]: the balls would overlap"
    ),
    "start_above_wall": Rule(
        "must lie above the low wall {low:.6g} rad and not above the high one {high:.6g} rad",
        "a ball at rest on the low wall stays there",
    ),
    "first_orbit": Rule(
        "{@low} and {@high} must enclose the {name} of the first orbit, {begun:.9g}, got [{low:g}, "
        "{high:g}]"
    ),
    "two_parameters": Rule("must be two parameters that do not set the same thing"),
    "end_of_each": Rule("must be a value for each of both parameters"),
    "touching_balls": Rule(
        "needs balls that can touch", "use LatoLato or BallPair, with exact contact"
    ),
    "needs_strings": Rule("needs strings", "give {@suspension=string}"),
    "needs_mirror": Rule(
        "needs a motion that equals its image in a mirror, and this one has none",
        "try fold or period_doubling",
    ),
    "kind_of_point": Rule(
        "is of the kind {kind}, which no curve follows", "give a point of another kind"
    ),
    "special_point": Rule(
        "must be a special point of continue_orbit",
        "give branch.special[0], and the drive of the branch",
    ),
    "point_of_other": Rule(
        "is of a branch whose {name} is {there}, but here it is {here}",
        "give the system and the drive of the branch",
    ),
    "brought_by_point": Rule("comes with the special point that at gives", "leave out one of both"),
    "start_below_threshold": Rule(
        "the start must lie below {@threshold_angle} {threshold:g} rad; give a larger one"
    ),
    "slowest_orbit": Rule(
        "must be at least {ratio:g} natural frequencies for an orbit", "raise {@drive_frequency}"
    ),
    "slowest_drive": Rule(
        "must be at least {share:g} of the natural frequency {frequency:g} rad/s"
    ),
    "first_guess": Rule(
        "is needed [rad]: a motion between walls has no natural first guess",
        "give a start on the attractor, from a run",
    ),
    "two_values": Rule("must hold at least 2 values"),
    "points_of_section": Rule(
        "the only point would be the start: take more periods or a transient"
    ),
    "one_dwell_fewer": Rule(
        "must be one fewer than the {count} drive_frequencies", "the last stage goes on"
    ),
    "alike_trajectories": Rule(
        "{count} trajectories without noise are all the same: give {@noise_strength} or one"
    ),
    # of texts in the form of a page
    "range_of_values": Rule("must be low : high : count"),
    "most_values": Rule("may have {limit} values at most"),
    "true_or_false": Rule("must be true or false"),
    # doubts about results
    "unsettled_starts": Rule(
        "{percent:.3g} % of the starts lead to motion that has not settled after {periods:g} drive "
        "periods: they belong to no attractor; raise {@transient_periods}"
    ),
    "uncertain_basins": Rule(
        "{percent:.3g} % of the starts lead elsewhere at a tolerance of {tolerance:.1g} rad: their "
        "basin is uncertain"
    ),
    "passing_difference": Rule(
        "at {count} of {of} points both ways differ only for a while, or do not settle: these do "
        "not count as two answers"
    ),
    "cut_off_below": Rule(
        "there are still two answers at {@frequency_ratio} {ratio:g}, where the sweep begins: "
        "begin lower to see the whole range"
    ),
    "cut_off_above": Rule(
        "there are still two answers at {@frequency_ratio} {ratio:g}, where the sweep ends: end "
        "higher to see the whole range"
    ),
    "value_of": Rule("{name} = {value:.6g}{unit}"),
    "no_bifurcation": Rule(
        "no {kind} of a motion of one drive period was found near {where}, nor where one of the "
        "parameters varies alone; widen {@low} and {@high}, choose another {@kind}, or begin with "
        "another motion"
    ),
    "no_bifurcation_of_several": Rule(
        "no {kind} of a motion of {period} drive periods was found near {where}, nor where one of "
        "the parameters varies alone; widen {@low} and {@high}, choose another {@kind}, or begin "
        "with another motion"
    ),
    "met_near_guess": Rule(
        "no {asked} was found near {where}: this is the {kind} that the motion near the guess "
        "meets at {place}, where that parameter varies alone"
    ),
    "met_where_settled": Rule(
        "no {asked} was found near {where}: this is the {kind} that the motion in which the run "
        "from the guess settles meets at {place}, where that parameter varies alone"
    ),
    "other_bifurcation": Rule(
        "no {kind} was found near {where}, where {nearest} is the nearest bifurcation of the "
        "motion: choose that as {@kind}"
    ),
    "two_bifurcations": Rule(
        "two bifurcations fall on one point near {where}, or it is no {kind}; begin at other values"
    ),
    "branch_not_found": Rule("the branch was not found; try a start on the attractor"),
    "branch_lost": Rule(
        "the branch was lost at {where}: Newton's method fails with the shortest steps"
    ),
    "branch_lost_by": Rule("the branch was lost at {where}, by {kind}"),
    "none_reached": Rule(
        "no trajectory of {count} reached {angle:g} rad within {duration:g} s: the mean is "
        "unknown; wait longer or raise {@noise_strength}"
    ),
    "slack_threshold": Rule(
        "at {@frequency_ratio} {ratio:g} the string goes slack at a drive that leaves hanging "
        "stable; choose a slower one or give {@suspension=rod}"
    ),
    "no_threshold": Rule(
        "no drive up to {largest:g} length makes hanging unstable at {@frequency_ratio} "
        "{ratio:g}; raise {@largest_amplitude_ratio} or choose a ratio nearer to 2/n"
    ),
    "slack_tongue": Rule(
        "at {@drive_amplitude} {amplitude:g} m the pivot falls faster than a ball on a slack "
        "string before the tongue ends; lower it or give {@suspension=rod}"
    ),
    "closed_tongue": Rule(
        "the tongue of order {order} is closed at {@drive_amplitude} {amplitude:g} m; raise it or "
        "lower the damping"
    ),
    "no_push_helps": Rule(
        "no push up to {push:.3g} rad/s leads to a larger motion than rest: nothing to recommend"
    ),
    "no_protocol": Rule(
        "no protocol succeeds for {percent:.3g} % of the drive phases: nothing to recommend"
    ),
    "never_lifted": Rule(
        "no amplitude below {share:g} of the drive's largest lifts the balls at "
        "{@frequency_ratio} {ratio:g}; raise it or lengthen a crank's {@connecting_rod_length}"
    ),
    "no_orbit": Rule(
        "no motion of period {period} was found from this start (defect {defect:.2g}); try a "
        "start on the attractor, or another period{string}"
    ),
    "taut_start": Rule("; strings must be taut at time zero"),
    "doubtful_multipliers": Rule(
        "the multipliers are doubtful ({status}): an impact is nearly missed, or the determinant "
        "or finite differences disagree"
    ),
    "shorter_period": Rule(
        "the motion repeats after {smallest:g} of {period} drive periods already; another start "
        "may lead to one of period {period}, if there is any"
    ),
    "run_elsewhere": Rule(
        "the run from the guess does not settle on this motion: after {periods} drive periods its "
        "angle is {angle} and its angular velocity {velocity}; to analyse the motion of "
        "that run give these as {@initial_angle} and {@initial_angular_velocity}"
    ),
    "no_lower_limit": Rule(
        "no lower limit was found up to {@drive_amplitude} {largest:g} m; raise "
        "{@largest_amplitude_ratio} or {@frequency_ratio}"
    ),
    "no_upper_limit": Rule(
        "no upper limit was found up to {@drive_amplitude} {largest:g} m; raise "
        "{@largest_amplitude_ratio} or {@frequency_ratio}"
    ),
    "aperiodic_run": Rule(
        "no period up to {longest}: the closest recurrence leaves {left:.2g} rad after "
        "{periods:g} drive periods of transient; try a longer one"
    ),
    "still_changing": Rule(
        "after {periods:g} drive periods the motion is still changing: try {@transient_periods} "
        "of {longer:g}"
    ),
    "grazing_period": Rule(
        "an impact is nearly grazing: the period may change with the smallest change"
    ),
    "ended_run": Rule("the run ended with status {status}: there is no answer"),
}

broken_analysis = partial(broken_rule, table=RULES)


def said(rule: str, /, **values: Any) -> Sentence:
    """The sentence of a rule alone, such as a warning."""
    return sentence(rule, RULES, **values)
