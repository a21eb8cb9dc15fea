"""The shipped scenarios and the figures hold the same parameters, which both must type."""

import pytest

import latolato as ll
from latolato.figures import paper

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
