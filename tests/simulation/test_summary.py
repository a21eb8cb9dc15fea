"""The numbers of a run and of a sweep that fit on a screen."""

import json

import latolato as ll
from latolato.simulation.summary import summarise, summarise_sweep
from latolato.sweeps import run_plan
from latolato.sweeps.plan import make_plan

TOY = {"length": 1.0, "mass": 0.8, "radius": 0.1, "restitution": 0.9}
BALL = ll.Ball(length=1.0, mass=0.8, radius=0.1)
SHAKE = ll.Harmonic(drive_amplitude=0.3, drive_frequency=9.0, drive_phase=3.0)


def told(run):
    return json.loads(json.dumps(summarise(run), allow_nan=False))


def test_a_run_on_strings_tells_of_slackness_and_one_on_rods_of_compression():
    toys = [ll.LatoLato(**TOY, suspension=each) for each in ("rod", "string")]
    rod, string = (told(ll.simulate(t, SHAKE, initial_offset=0.0, duration=3.0)) for t in toys)
    assert {"compression_time", "compression_fraction"} <= rod.keys()
    assert not {"first_slack", "slack_fraction", "largest_string_impulse"} & rod.keys()
    assert not {"compression_time", "compression_fraction"} & string.keys()
    assert 0.0 < string["first_slack"] < 3.0
    assert 0.0 < string["slack_fraction"] < 1.0
    assert string["largest_string_impulse"] > 0.0
    assert string["contacts"]["taut"] > 0


def test_strings_that_stay_taut_have_no_first_slackness_and_two_balls_a_list():
    pair = ll.BallPair(right=BALL, left=BALL, suspension="string")
    result = told(ll.simulate(pair, initial_angle=(0.5, -0.4), duration=2.0))
    assert result["first_slack"] == [None, None]
    assert result["slack_fraction"] == [0.0, 0.0]


def test_a_sweep_counts_what_tangled():
    axes = {"drive_amplitude": [0.1, 0.2], "drive_frequency": [8.0, 9.0]}
    plan = make_plan(
        ll.LatoLato(**TOY, suspension="string"),
        SHAKE,
        axes=axes,
        initial_offset=0.1,
        duration=1.0,
        observables=["slack_fraction"],
    )
    grid = run_plan(plan)
    grid.status[...] = [["converged", "outside_model"], ["outside_model", "converged"]]
    assert summarise_sweep(grid, plan)["status"] == {"converged": 2, "outside_model": 2}


def test_a_run_has_the_word_of_its_contacts_where_the_drive_repeats_itself():
    toy = ll.LatoLato(**TOY | {"restitution": 0.5})
    shake = ll.Harmonic(drive_amplitude=0.1, drive_frequency=12.0)
    run = ll.simulate(toy, shake, initial_offset=0.2, duration=40.0)
    grid = ll.sweep(
        toy, shake, axes={"gravity": [9.8]}, initial_offset=0.2, duration=40.0,
        observables=["contact_word"],
    )  # fmt: skip
    assert told(run)["contact_word"] == ll.contact_words(grid.contact_word).item()
    assert told(run)["contact_word"].strip("BR") == ""
    assert "contact_word" not in told(ll.simulate(toy, initial_offset=0.2, duration=1.0))
    assert told(ll.simulate(toy, shake, initial_offset=0.2, duration=1.0))["contact_word"] is None


def test_balls_that_stay_at_rest_have_the_word_of_rest():
    toy, weak = ll.LatoLato(**TOY), ll.Harmonic(drive_amplitude=0.01, drive_frequency=9.0)
    at_rest = ll.simulate(toy, weak, initial_offset=0.0, duration=20.0)
    assert told(at_rest)["contact_word"] == "R"
    pair = ll.BallPair(right=BALL, left=BALL, restitution=0.5)
    still = ll.simulate(pair, weak, initial_angle=(0.3, -0.3), duration=60.0)
    assert told(still)["contact_word"] == ["R", "R"]
    pendulum = ll.Pendulum(length=1.0, mass=0.8)
    hanging = ll.simulate(pendulum, weak, initial_angle=0.0, duration=20.0)
    assert told(hanging)["contact_word"] == "no contact"
