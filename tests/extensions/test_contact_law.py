"""A mode of motion that a user brings: walls that push back like springs, in place of impacts."""

import json
import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

import latolato as ll
from latolato.analysis.flow import Flow
from latolato.app.forms import registry
from latolato.cli.main import app as command_line
from latolato.core.scalar import formula
from latolato.numerics.engine.balls import GAP
from latolato.numerics.engine.events import Event
from latolato.numerics.engine.forces import tension_at
from latolato.numerics.engine.loop import make_engine, usual_events, usual_modes
from latolato.numerics.integrate import Start, choose_step, integrate
from latolato.numerics.run_record import CONTACT, FLIGHT, RELEASE, SETTLE
from latolato.numerics.trajectory import MOTIONS
from latolato.physics.contacts import ContactLaw, contact_laws
from latolato.scenario.scenario import changed_tables
from latolato.scenario.variation import tables_of_plan

IN_WALL = 3


@dataclass(frozen=True)
class SoftWall(ContactLaw):
    """Beyond the contact angle a spring accelerates the ball back."""

    motion: ClassVar[str] = "soft wall"
    stores_energy: ClassVar[bool] = True
    stiffness: float = 2000.0  # 1/s^2

    @property
    def numbers(self):
        return self.stiffness, 0.0

    @property
    def fastest_rate(self):
        return math.sqrt(self.stiffness)

    def check_system(self, system):
        if any(b.quadratic_damping or b.coulomb_damping for b in system.balls) or system.angles > 1:
            raise ll.InputError("a soft wall is for one ball with linear damping; use 'exact'")


@formula
def depth(angle, run):
    wall = run.settings.low if run.state.side < 0.0 else run.settings.high
    return angle - wall if run.state.mode == IN_WALL else 0.0


@formula
def push(angle, run):
    return -run.settings.law[0] * depth(angle, run)


@formula
def push_slope(angle, run):
    return -run.settings.law[0] if run.state.mode == IN_WALL else 0.0


@formula
def push_potential(angle, run):
    return 0.5 * run.settings.law[0] * depth(angle, run) ** 2


def modes(kit):
    flight, *_ = usual_modes(kit)
    balls, part = kit.balls, kit.part

    @part
    def plan(run):
        """Swing in the wall, up to the end of the step or of the wall."""
        side = run.state.side
        wall = run.settings.low if side < 0.0 else run.settings.high
        balls.plan_length(run)
        balls.fly_by(run, run.length, run.end)
        if (balls.gap(run.end) - wall) * side < 0.0:
            begin = 0.0
            if balls.gap(run.now) == wall:
                begin = balls.leave(run, wall, -side, run.length)
            balls.shorten(run, balls.locate(run, GAP, wall, begin, run.length))
            balls.fly_by(run, run.length, run.end)
            balls.place(run, run.end, wall, balls.gap_rate(run.end))
            run.event = RELEASE
        body, end = run.bodies[0], run.end[0]
        run.work, run.loss = body.inertia * end.work, body.inertia * end.loss
        end.tension = tension_at(
            end.angle,
            end.velocity,
            end.pivot_acceleration,
            run.settings.gravity,
            body.inverse_length,
        )

    return flight, flight._replace(number=IN_WALL, plan=plan)


def events(kit):
    turn, *_ = usual_events(kit)
    balls, part = kit.balls, kit.part

    @part
    def enter(run, output, accumulators):
        run.state.mode, run.state.side = IN_WALL, run.side
        balls.settle(run)

    @part
    def leave(run, output, accumulators):
        run.state.mode, run.state.touch = FLIGHT, run.state.side
        balls.settle(run)

    return turn, Event(CONTACT, enter), Event(SETTLE, enter), Event(RELEASE, leave)


def make_soft_wall(laws, count, callbacks, part):
    pushed = laws._replace(push=push, push_slope=push_slope, push_potential=push_potential)
    return make_engine(pushed, count, callbacks, part, make_modes=modes, make_all_events=events)


TOY = ll.LatoLato(length=1.0, mass=0.8, damping=0.02, radius=0.1, restitution=0.9)
SHAKEN = ll.Harmonic(drive_amplitude=0.05, drive_frequency=5.0)
SOFT = SoftWall()


@pytest.fixture(autouse=True)
def known(monkeypatch, forget):
    """One entry in each table."""
    forget()
    monkeypatch.setitem(MOTIONS, SoftWall.motion, make_soft_wall)
    monkeypatch.setitem(contact_laws._entries, "soft wall", SoftWall)


def peer(angle, times, velocity=0.0):
    """SciPy's answer, to 1e-12 a step, with steps that end at the wall."""
    low, rate = TOY.contact_angle_low, TOY.damping / (TOY.mass * TOY.length)

    def slopes(t, y):
        lift = -SHAKEN.drive_amplitude * SHAKEN.drive_frequency**2
        pulled = -(9.8 + lift * np.cos(SHAKEN.drive_frequency * t)) * np.sin(y[0]) - rate * y[1]
        return y[1], pulled - (SOFT.stiffness * (y[0] - low) if y[0] < low else 0.0)

    t, y, result = 0.0, np.array([angle, velocity]), []

    def at_wall(t, y):
        return y[0] - low

    at_wall.terminal = True
    for stop in times:
        while t < stop:
            part = solve_ivp(
                slopes, (t, stop), y, "DOP853", rtol=1e-12, atol=1e-13, events=at_wall,
                first_step=min(1e-4, stop - t),
            )  # fmt: skip
            t, y = part.t[-1], part.y[:, -1]
            if part.status == 1:  # a hair beyond, so that the event is not met again at once
                y = np.array([low + np.copysign(1e-15, y[1]), y[1]])
        result.append(y[0])
    return np.array(result)


def test_it_moves_as_the_peer_does():
    times = np.linspace(0.5, 6.0, 12)
    run = ll.simulate(TOY, SHAKEN, initial_angle=0.6, times=times, tolerance=1e-10, contact=SOFT)
    assert run.angle.min() < TOY.contact_angle_low  # it was in the wall
    np.testing.assert_allclose(run.angle, peer(0.6, times), rtol=0, atol=1e-8)


def test_its_energy_is_accounted_for():
    start = Start((0.6,), (0.0,))
    step = choose_step(TOY, SHAKEN, start, 1e-10, SOFT)
    run = integrate(TOY, SHAKEN, start, np.zeros(0), 20.0, step=step, law=SOFT)
    assert run.state.ledger_error < 1e-9
    assert run.state.largest_energy > 1.0


def test_kicks_in_the_wall_leave_no_gap_in_the_ledger():
    kicks = ll.VelocityKicks(noise_strength=1.0, noise_interval=0.05, noise_seed=1)
    run = ll.simulate(TOY, SHAKEN, initial_angle=0.6, duration=5.0, contact=SOFT, noise=kicks)
    assert run.attrs["energy_residual"] < 1e-8


@pytest.mark.parametrize("system", [
    ll.LatoLato(length=1.0, mass=0.8, radius=0.1, coulomb_damping=0.3),
    ll.BallPair(right=ll.Ball(length=1.0, mass=1.0, radius=0.1),
                left=ll.Ball(length=1.0, mass=1.0, radius=0.1)),
])  # fmt: skip
def test_it_says_which_systems_it_is_for(system):
    angle = (0.6, -0.6) if system.angles == 2 else 0.6
    with pytest.raises(ll.InputError, match="for one ball with linear damping"):
        ll.simulate(system, SHAKEN, initial_angle=angle, duration=1.0, contact=SOFT)


def test_a_law_whose_motion_nobody_knows_is_refused():
    class Lost(SoftWall):
        motion = "soft wal"

    with pytest.raises(ll.InputError, match="did you mean 'soft wall'"):
        ll.simulate(TOY, SHAKEN, initial_angle=0.6, duration=1.0, contact=Lost())


def test_a_hard_spring_is_an_elastic_impact():
    elastic = ll.LatoLato(length=1.0, mass=0.8, radius=0.1, restitution=1.0)
    arguments = {"initial_angle": 0.6, "times": np.linspace(0.05, 2.0, 40), "tolerance": 1e-8}
    hard = ll.simulate(elastic, SHAKEN, contact=SoftWall(stiffness=1e8), **arguments)
    walls = ll.simulate(elastic, SHAKEN, contact="exact", **arguments)
    # The ball stays in the wall for pi/sqrt(stiffness), a third of a millisecond, a few times.
    assert float(abs(hard.angle - walls.angle).max()) < 5e-3


def test_plain_python_moves_the_same():
    result = [
        Flow(TOY, SHAKEN, contact=SOFT, tolerance=1e-8, compiled=compiled)
        .follow(np.array([0.6, 0.0]), 3.0)
        for compiled in (True, False)
    ]  # fmt: skip
    np.testing.assert_allclose(result[0].end, result[1].end, rtol=0, atol=1e-12)


def test_a_sweep_carries_it():
    starts = np.linspace(0.3, 0.9, 4)
    result = ll.sweep(
        TOY, SHAKEN, axes={"initial_angle": starts}, duration=5.0, contact=SOFT,
        observables=["final_angle"], tolerance=1e-8,
    )  # fmt: skip
    alone = [
        float(ll.simulate(TOY, SHAKEN, initial_angle=x, duration=5.0, tolerance=1e-8, contact=SOFT)
              .angle[-1])
        for x in starts
    ]  # fmt: skip
    np.testing.assert_allclose(result.final_angle, alone, rtol=0, atol=1e-12)


# The matrix of rough steps is that of the numbers that are computed, too, but where the wall begins
# it is that of the exact motion: what a step is off by there counts.
@pytest.mark.parametrize("tolerance, error", [(1e-11, 1e-6), (1e-4, 2e-5)])
def test_small_deviations_are_followed_through_it(tolerance, error):
    flow, start = Flow(TOY, SHAKEN, contact=SOFT, tolerance=tolerance), np.array([0.6, 0.1])
    result = flow.follow(start, 4.0)
    h = 1e-6
    differences = [
        (flow.follow(start + h * unit, 4.0).end - flow.follow(start - h * unit, 4.0).end) / (2 * h)
        for unit in np.eye(2)
    ]
    np.testing.assert_allclose(result.matrix, np.array(differences).T, rtol=error, atol=error)
    rate = TOY.damping / (TOY.mass * TOY.length)
    assert np.linalg.det(result.matrix) == pytest.approx(np.exp(-rate * 4.0), rel=1e-9)


def test_scenarios_the_command_line_and_the_app_know_it_by_name(tmp_path):
    alone = ll.simulate(TOY, SHAKEN, initial_angle=0.6, duration=5.0, contact=SOFT)
    again = ll.Scenario.from_dict(json.loads(alone.attrs["scenario"])).simulate()
    np.testing.assert_array_equal(alone.angle, again.angle)
    file = tmp_path / "run.nc"
    words = (
        "simulate fig02 --system latolato --radius 0.1 --initial-angle 0.6 --duration 5 --contact"
    )
    result = CliRunner().invoke(command_line, [*words.split(), "soft wall", "--output", str(file)])
    assert result.exit_code == 0, result.output
    assert ll.load(file).attrs["contact"] == "soft wall"


def test_its_parameters_stay_with_runs_and_sweeps():
    hard = ll.simulate(
        TOY, SHAKEN, initial_angle=0.6, duration=5.0, contact=SoftWall(stiffness=1e4)
    )
    assert hard.attrs["stiffness"] == 1e4
    again = ll.Scenario.from_dict(json.loads(hard.attrs["scenario"]))
    np.testing.assert_array_equal(hard.angle, again.simulate().angle)
    tables = again.to_dict()
    assert tables["run"]["stiffness"] == 1e4
    sweep = {"axes": {"initial_angle": [0.3, 0.6]}, "observables": ["final_angle"]}
    run = {k: v for k, v in tables["run"].items() if k not in ("initial_angle", "frame")}
    plan = ll.Scenario.from_dict({**tables, "run": run, "sweep": sweep}).plan()
    assert tables_of_plan(plan)["run"]["stiffness"] == 1e4


def test_another_law_takes_none_of_its_parameters():
    run = {"initial_angle": 0.6, "duration": 5.0, "contact": "soft wall", "stiffness": 1e4}
    tables = {"system": {"kind": "latolato", "length": 1.0, "mass": 0.8, "radius": 0.1}, "run": run}
    changed = changed_tables(None, {"run": {"contact": "exact"}}, tables)
    assert "stiffness" not in changed["run"]
    with pytest.raises(ll.InputError, match="stiffness belongs to contact soft wall, not to exact"):
        ll.Scenario.from_dict({**tables, "run": {**run, "contact": "exact"}})


def test_the_application_lists_it():
    assert "soft wall" in registry()["options"]["contact"]["choices"]
