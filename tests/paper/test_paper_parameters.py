"""The shipped scenarios, the figures and the claims hold the same parameters, which all type."""

import math

import pytest

import latolato as ll
from latolato.paper import catalogue, fig05, fig11, text_resonance
from latolato.paper import systems as paper

CASES = {
    "fig02": (paper.PENDULUM, paper.DRIVE),
    "fig02_mathieu": (paper.LINEAR, paper.DRIVE),
    "fig04a": (paper.TOY, paper.STRONG_DRIVE),
    "fig04b": (paper.TOY, paper.WEAK_DRIVE),
    "fig06_push": (paper.TOY, paper.STRONG_DRIVE),
    "fig08": (paper.SINGLE, None),
    "fig12": (paper.COUPLED, None),
    "fig13a": (paper.LINEAR, paper.DRIVE),
    "fig13b": (paper.LINEAR_UNDAMPED, paper.DRIVE),
    "fig13c": (paper.PENDULUM, paper.DRIVE),
    "fig13d": (paper.UNDAMPED, paper.DRIVE),
}


@pytest.mark.parametrize("name", CASES)
def test_scenario_and_figure_agree(name):
    system, drive = CASES[name]
    scenario = ll.load_scenario(name)
    assert scenario.system == system
    if drive is not None:
        assert scenario.drive == drive


@pytest.mark.parametrize(
    "name, frequency", [("fig03a", paper.RESONANT_FREQUENCY), ("fig03b", paper.QUIET_FREQUENCY)]
)
def test_frequencies_on_either_side_of_the_edge_agree(name, frequency):
    assert ll.load_scenario(name).drive.drive_frequency == frequency


def test_assumed_values_agree():
    assert ll.load_scenario("fig08").drive.drive_amplitude == paper.SINGLE_AMPLITUDE
    assert ll.load_scenario("fig08").drive.drive_frequency == paper.SINGLE_FREQUENCY
    stepped = ll.load_scenario("fig12").drive
    assert stepped.drive_amplitude == paper.COUPLED_AMPLITUDE
    assert stepped.times == (0.0, paper.SWITCH_TIME)
    assert stepped.ramp == paper.LONGEST_RAMP
    ratios = [w / paper.COUPLED.natural_frequency for w in stepped.drive_frequencies]
    assert ratios == pytest.approx(paper.STAGE_RATIOS, rel=1e-15)  # two roundings


STATEMENTS = {s.name: s for each in catalogue.evidence().values() for s in each.statements}
PUSH = f"{paper.PUSH:g} rad above the contact angle"
PUSH_OF_FIG5 = f"{fig05.PUSH:g} rad above it"
PAIR = (
    f"r/l = {paper.COUPLED.radius / paper.COUPLED.length:g}, e = {paper.COUPLED.restitution:g} "
    f"and a start {fig11.START:g} rad above the wall"
)
ASSUMPTIONS = {
    "large-and-small-motion": PUSH,
    "power-decides-trend": PUSH,
    "small-dissipation": PUSH,
    "map-pair": PUSH_OF_FIG5,
    "map-pair-band": PUSH_OF_FIG5,
    "map-pair-amplitude": PUSH_OF_FIG5,
    "growth-and-saturation": (
        f"A0 = {1e3 * paper.SINGLE_AMPLITUDE:g} mm and a start at "
        f"{math.degrees(paper.SINGLE_START):.0f}°"
    ),
    "response-peaks": PAIR,
    "response-flanks": PAIR,
    "stepping-frequency": paper.COUPLED_WORDS,
    "transition-time": paper.COUPLED_WORDS,
}
LIMITS = [
    ("response-peaks", "first_peak", "low", paper.PEAK_RATIOS[0]),
    ("response-peaks", "last_peak", "high", paper.PEAK_RATIOS[1]),
    ("fig11-chain", "first", "low", paper.PEAK_RATIOS[0]),
    ("fig11-chain", "last", "high", paper.PEAK_RATIOS[1]),
    ("top-at-0.2", "most_tops", "low", paper.SWEEP_DURATION / 5.0),
    *(
        ("further-bands", f"factor_{order}", "high", text_resonance.SHOWING)
        for order in text_resonance.ORDERS
    ),
    ("growth-and-saturation", "largest", "high", math.pi),
    ("nonlinear-beats", "largest_c", "high", math.pi),
    ("nonlinear-beats", "largest_d", "high", math.pi),
    ("saturation-by-damping", "largest_d", "low", math.pi),
]


@pytest.mark.parametrize("name", ASSUMPTIONS)
def test_assumptions_name_the_values_that_are_computed_with(name):
    assert ASSUMPTIONS[name] in STATEMENTS[name].assumption


@pytest.mark.parametrize(
    "name, damping",
    [("fig7-chain", paper.SINGLE.damping), ("fig10-chain", paper.ONE_BALL.damping)],
)
def test_findings_name_the_damping_that_is_rendered(name, damping):
    assert f"rendered with C = {damping:g} kg m/s" in STATEMENTS[name].finding


@pytest.mark.parametrize("name, number, end, value", LIMITS)
def test_limits_are_the_values_that_are_drawn_and_computed_with(name, number, end, value):
    limits = {limit.number: limit for limit in STATEMENTS[name].limits}
    assert getattr(limits[number], end) == value
