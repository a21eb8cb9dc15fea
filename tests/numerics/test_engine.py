"""The engine of modes and events against the trajectory functions that it is to replace."""

import itertools
import math
import random
from typing import NamedTuple

import numpy as np
import pytest

import latolato as ll
from latolato.numerics import integrate, records
from latolato.numerics.compiled import compile_kernel
from latolato.numerics.engine import record
from latolato.numerics.engine.events import Output
from latolato.numerics.engine.eyes import Eyes
from latolato.numerics.engine.laws import laws_of
from latolato.numerics.engine.loop import Timetable, make_engine
from latolato.numerics.watch import hooks_of, make_watch
from latolato.observables.deviations import Deviations
from latolato.physics.pendulum import potential_sine, restoring_linear, restoring_sine

DURATION = 3.0
TIMES = np.linspace(0.0, DURATION, 31)
WATCHED = [ll.Crossings(crossing_angle=1.0), Deviations()]
ROOM = 4000


class Case(NamedTuple):
    """One run: a system under a drive from a start, with its walls and kicks."""

    system: object
    drive: object
    angles: tuple
    velocities: tuple
    walls: tuple
    tolerance: float
    rest_speed: float
    kicks: dict


def drive_of(r):
    """A random drive of any kind."""
    a, w, other = r.choice([0.0, 0.02, 0.1, 0.3]), r.uniform(2.0, 15.0), r.uniform(2.0, 15.0)
    times = (0.0, 0.9, 2.1)
    return r.choice([
        ll.Static(),
        ll.Harmonic(drive_amplitude=a, drive_frequency=w, drive_phase=r.uniform(0.0, 6.0)),
        ll.CrankSlider(drive_amplitude=a, drive_frequency=w, connecting_rod_length=0.5),
        ll.Chirp(drive_amplitude=a, drive_frequency=w, drive_frequency_final=other, sweep_time=2.0),
        ll.FrequencySchedule(
            drive_amplitude=a, times=times, drive_frequencies=(w, other, w),
            ramp=r.choice([0.0, 0.5]), step_impulse=r.random() < 0.5,
        ),
        ll.Stages(
            times=times, drive_amplitudes=(a, 0.1, 0.2), drive_frequencies=(w, other, w),
            ramps=(1.0, 0.5, 0.7),
        ),
    ])  # fmt: skip


def case_of(number):
    """A random run of one ball or of two, with all kinds of drag, contact and kicks."""
    r = random.Random(number)
    drive, e = drive_of(r), r.choice([1.0, 0.9, 0.5, 0.2])
    rough = r.random() < 0.4

    def drags():
        return {
            "damping": r.choice([0.0, 0.02, 0.3]),
            "quadratic_damping": r.choice([0.0, 0.05]) if rough else 0.0,
            "coulomb_damping": r.choice([0.0, 0.05, 0.5]) if rough else 0.0,
        }

    def speed():
        return r.choice([0.0, r.uniform(-3.0, 3.0)])

    if r.random() < 0.4:
        balls = [
            ll.Ball(length=l, mass=r.choice([0.8, 0.3]), radius=0.1, **drags())
            for l in (1.0, r.choice([1.0, 0.95]))
        ]
        system = ll.BallPair(right=balls[0], left=balls[1], restitution=e)
        low = system.contact_separation
        walls = (low, math.tau - low)
        left = r.uniform(-1.5, -0.5 * low)
        angles = (left + low if r.random() < 0.2 else r.uniform(0.5 * low, 1.5), left)
        velocities = (speed(), speed())
    else:
        laws = {"length": 1.0, "mass": 0.8, **drags()}
        kind = r.choice([ll.LatoLato, ll.LatoLato, ll.Pendulum, ll.Mathieu])
        if kind is ll.LatoLato:
            system = ll.LatoLato(radius=0.1, restitution=e, **laws)
            walls = (system.contact_angle_low, system.contact_angle_high)
            angles = (r.choice([walls[0], r.uniform(*walls), r.uniform(0.2, 1.5), walls[1]]),)
        else:
            system, walls = kind(**laws), (-math.inf, math.inf)
            angles = (r.uniform(-0.3, 0.3) if kind is ll.Mathieu else r.uniform(-3.0, 3.0),)
        velocities = (speed(),)
    kicks = {}
    if r.random() < 0.25:
        kicks["kick_times"] = np.sort([r.uniform(0.0, DURATION) for _ in range(5)])
        kicks["kick_sizes"] = np.array(
            [[r.uniform(-0.5, 0.5) for _ in range(5)] for _ in range(system.angles)]
        )
    rest_speed = r.choice([1e-5, 1e-3])
    return Case(system, drive, angles, velocities, walls, r.choice([1e-6, 1e-8]), rest_speed, kicks)


def engine_of(system, drive, *, compiled):
    """The engine for these laws, with the observables that are watched here."""
    hooks = hooks_of(WATCHED)

    def make(pivot_acceleration, compile_part=None):
        return make_engine(
            laws_of(pivot_acceleration, restoring_sine, potential_sine, compile_part),
            system.angles,
            make_watch(hooks, compile_part),
            compile_part=compile_part,
        )

    if compiled:
        return compile_kernel(make, f"engine of {system.angles}", drive.acceleration)
    return make(drive.acceleration)


def step_of(case, start):
    """The step of a run [s]."""
    stepper = integrate.choose_stepper(case.system)
    return integrate.choose_step(case.system, case.drive, start, case.tolerance, stepper)


def run_engine(case, *, compiled=False):
    """The record, output and accumulators after a run of the engine."""
    system, drive = case.system, case.drive
    start = integrate.Start(case.angles, case.velocities)
    stepper = integrate.choose_stepper(system)
    runs = np.zeros(1, record.run_dtype())
    rows, offsets = integrate.body_rows(system, case.walls)
    runs["bodies"][0, : len(rows)] = records.bodies(*rows)
    linear = system.restoring is restoring_linear
    runs["settings"][0] = (
        *integrate.settings_values(
            gravity=system.gravity, walls=case.walls,
            restitution=getattr(system, "restitution", 1.0), rest_speed=case.rest_speed,
            step=step_of(case, start), lift_bound=drive.largest_acceleration,
            rate=integrate.fastest_rate(system, drive, start), offsets=offsets,
            follows_tension=not linear, follows_ledger=True,
        ),
        int(linear),
    )  # fmt: skip
    stages = len(stepper.drifts)
    runs["stages"] = stages
    runs["kicks"][0, : stages + 1] = stepper.kicks
    runs["drifts"][0, :stages], runs["nodes"][0, :stages] = stepper.drifts, stepper.nodes
    state = runs["state"]
    state["mode"], state["slack_start"] = record.UNSETTLED, np.nan
    state["angle"][0, : system.angles] = case.angles
    state["velocity"][0, : system.angles] = case.velocities
    stretches, starts = records.stretch_records(drive, DURATION)
    samples = np.full((records.SAMPLE_ROWS, len(TIMES)), np.nan)
    columns = [[v for o in WATCHED for v in o.initial(np.array(x))] for x in case.angles]
    acc = np.array(columns, dtype=float).T.ravel()
    output = Output(
        TIMES, samples, np.empty(ROOM), np.empty(ROOM, dtype=np.int64), np.zeros((4, ROOM))
    )
    run = runs[0] if compiled else record.as_objects(runs)[0]
    timetable = Timetable(
        stretches if compiled else record.as_objects(stretches),
        starts,
        np.array(drive.velocity_jumps(DURATION)),
        case.kicks.get("kick_times", np.empty(0)),
        case.kicks.get("kick_sizes", np.empty((system.angles, 0))),
    )
    carry_on = engine_of(system, drive, compiled=compiled)
    carry_on(run, timetable, output, Eyes(acc, 0, system.angles), DURATION, 1_000_000)
    return (runs.view(np.recarray)[0] if compiled else run), output, acc.reshape(-1, system.angles)


@pytest.mark.parametrize("number", range(60))
def test_the_engine_moves_balls_as_the_trajectory_functions_do(number):
    case = case_of(number)
    start = integrate.Start(case.angles, case.velocities)
    old = integrate.integrate(
        case.system, case.drive, start, TIMES, DURATION, walls=case.walls,
        step=step_of(case, start), rest_speed=case.rest_speed, compiled=False, watched=WATCHED,
        **case.kicks,
    )  # fmt: skip
    run, output, acc = run_engine(case)
    rows = 2 * case.system.angles
    # Equal formulas in another order: some roundings per step, which impacts enlarge.
    np.testing.assert_allclose(output.samples[:rows], old.samples[:rows], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(output.samples[4:9], old.samples[4:9], rtol=1e-9, atol=1e-9)
    assert run.rows == len(old.contact_times)
    np.testing.assert_array_equal(output.contact_kinds[: run.rows], old.contact_kinds)
    np.testing.assert_allclose(output.contact_times[: run.rows], old.contact_times, atol=1e-9)
    # The functions for one ball leave the matrix of an impact at time zero out.
    if case.system.angles == 2 or case.angles[0] not in case.walls or case.velocities == (0.0,):
        np.testing.assert_allclose(acc, old.slots, rtol=1e-6, atol=1e-6)
    assert run.state.ledger_error == pytest.approx(old.state[records.RESIDUAL], abs=1e-12)


@pytest.mark.parametrize("balls", [1, 2])
def test_the_compiled_engine_is_the_one_in_plain_python(balls):
    numbers = (n for n in itertools.count() if case_of(n).system.angles == balls)
    for number in itertools.islice(numbers, 20):
        case = case_of(number)
        plain, expected, slots = run_engine(case)
        run, output, acc = run_engine(case, compiled=True)
        assert run.rows == plain.rows
        # Compiled code rounds once where Python rounds twice.
        np.testing.assert_allclose(output.samples[:9], expected.samples[:9], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(acc, slots, rtol=1e-6, atol=1e-6)
