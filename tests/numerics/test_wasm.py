"""WebAssembly in Node.js and native code, from the same beginnings."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import warnings

import numpy as np
import pytest

import latolato as ll
from in_node import (
    MODULES,
    Case,
    from_parameters,
    in_node,
    map_case,
    read_layout,
    record_run,
    run_points_in_node,
)  # fmt: skip
from latolato.numerics.derived import BALL_ROWS
from latolato.numerics.records import INVALID
from latolato.physics.contacts import CONTACT_KINDS
from latolato.simulation.record import LEDGER
from latolato.simulation.start import DEFAULT_REST_SPEED
from latolato.sweeps.batches import run_fastest, run_scalar
from latolato.sweeps.chunk import run_chunk
from latolato.sweeps.plan import make_plan
from references import CASES, WITH_CONTACTS, bound_of, check, read
from watched import IN_LANES, WITHOUT_PERIODS

BODY = {"length": 1.0, "mass": 0.8}
DRAGS = {"damping": 0.03, "quadratic_damping": 0.02, "coulomb_damping": 0.01}
TOY = {**BODY, "radius": 0.1}
DURATION = 12.0
TIMES = np.linspace(0.0, DURATION, 241)


def drives(random):
    """Return a drive of every kind, with random parameters."""
    amplitude, frequency = random.uniform(0.02, 0.3), random.uniform(2.0, 9.0)
    harmonic = {"drive_amplitude": amplitude, "drive_phase": random.uniform(0.0, 6.0)}
    others = list(random.uniform(2.0, 9.0, 3))
    t = np.linspace(0.0, DURATION, 200)
    return {
        "static": None,
        "harmonic": ll.Harmonic(**harmonic, drive_frequency=frequency),
        "crank": ll.CrankSlider(
            **harmonic,
            drive_frequency=frequency,
            connecting_rod_length=random.uniform(1.5, 3.0) * amplitude,
            guide=random.choice(["above", "below"]),
        ),
        "chirp": ll.Chirp(
            **harmonic,
            drive_frequency=frequency,
            drive_frequency_final=others[0],
            sweep_time=random.uniform(5.0, 15.0),
        ),
        "schedule": ll.FrequencySchedule(
            **harmonic, times=(0.0, 3.0, 7.0), drive_frequencies=others, ramp=1.0
        ),
        "stages": ll.StagedHarmonic(
            times=(0.0, 3.0, 7.0),
            drive_amplitudes=random.uniform(0.02, 0.3, 3),
            drive_frequencies=others,
            ramps=(0.5, 1.0, 0.2),
        ),
        "measured": ll.MeasuredPivot(
            times=t, pivot_heights=0.3 * amplitude * np.cos(frequency * t)
        ),
    }


def systems(random):
    """Return a system of every kind, with random parameters, and how it is run."""
    body = {"length": random.uniform(0.5, 1.5), "mass": random.uniform(0.2, 1.0)}
    toy = {**body, "radius": random.uniform(0.05, 0.12) * body["length"]}
    drags = {name: random.uniform(0.0, 2.0) * value for name, value in DRAGS.items()}
    bounce = random.uniform(0.4, 0.95)
    ball, angle = ll.Ball(**toy), random.uniform(0.3, 1.2)
    heavy = ll.Ball(**{**toy, "mass": 1.2, "length": 1.05 * body["length"]}, **drags)
    one, two = {"initial_angle": angle}, {"initial_angle": (angle, -0.8 * angle)}
    noise = ll.VelocityKicks(noise_strength=0.05, noise_seed=int(random.integers(100)))
    return {
        "free": (ll.Pendulum(**body), one),
        "linear drag": (ll.Pendulum(**body, damping=drags["damping"]), one),
        "quadratic drag": (ll.Pendulum(**body, quadratic_damping=0.05), {**one, "noise": noise}),
        "friction": (ll.Pendulum(**body, coulomb_damping=0.05), one),
        "mathieu": (ll.Mathieu(**body, damping=drags["damping"]), one),
        "elastic walls": (ll.LatoLato(**toy), one),
        "walls": (ll.LatoLato(**toy, damping=drags["damping"], restitution=bounce), one),
        "walls, all drags": (ll.LatoLato(**toy, **drags, restitution=bounce), one),
        "clamp": (
            ll.LatoLato(**toy, damping=0.02),
            {**one, "contact": ll.ClampContact(clamp_step=1e-3)},
        ),
        "equal balls": (
            ll.BallPair(right=ball, left=ball, restitution=bounce),
            {"initial_angle": (angle, -angle)},
        ),
        "two balls": (ll.BallPair(right=heavy, left=ball, restitution=bounce), two),
    }


def random_runs():
    """Yield names and arguments of two runs for every kind of system and of drive."""
    any_random = np.random.default_rng(0)
    kinds = itertools.product(systems(any_random), drives(any_random), range(2))
    for seed, (system, drive, number) in enumerate(kinds):
        random = np.random.default_rng(seed)
        chosen, how = systems(random)[system]
        yield f"{system}, {drive}, {number}", chosen, drives(random)[drive], how


def plane_runs():
    """Yield names and arguments of runs on strings, of a pivot moved sideways and of still air."""
    toy, ball = {**TOY, "length": 0.5, "radius": 0.05}, {"length": 0.5, "mass": 0.2, "radius": 0.06}
    string = {"suspension": "string"}
    balls = {"right": ll.Ball(**ball, damping=0.01), "left": ll.Ball(**{**ball, "length": 0.53})}
    shaken = {"drive_frequency": 11.0}
    up = ll.Harmonic(drive_amplitude=0.12, **shaken)
    ellipse = ll.PlanarHarmonic(
        vertical_amplitude=0.08, horizontal_amplitude=0.05, horizontal_phase=0.7, **shaken
    )
    fast = {"initial_angle": 0.4, "initial_angular_velocity": 7.0}
    noise = ll.VelocityKicks(noise_strength=0.05, noise_seed=3)
    for bounce in (0.0, 0.6):
        hung = {**string, "string_restitution": bounce}
        yield f"free, {bounce}", ll.Pendulum(length=0.5, mass=0.2, **hung), None, fast
        drags = {"damping": 0.005, "quadratic_damping": 0.003, "coulomb_damping": 0.002}
        yield f"all drags, {bounce}", ll.Pendulum(length=0.5, mass=0.2, **drags, **hung), up, fast
        yield f"toy, {bounce}", ll.LatoLato(**toy, restitution=0.8, **hung), up, fast
        low = ll.LatoLato(**toy, restitution=0.8, damping=0.02, **hung)
        yield f"toy from rest, {bounce}", low, up, {"initial_offset": 0.0}
        yield f"ellipse, {bounce}", ll.Pendulum(length=0.5, mass=0.2, **hung), ellipse, fast
        pair = ll.BallPair(**balls, restitution=0.8, **hung)
        yield f"pair, {bounce}", pair, up, {"initial_angle": (0.5, -0.3)}
        yield f"pair, ellipse, {bounce}", pair, ellipse, {"initial_angle": (0.5, -0.3)}
    slack = {"initial_distance": 0.3, **fast}
    yield "slack", ll.Pendulum(length=0.5, mass=0.2, **string), None, {**slack, "noise": noise}
    yield "slack toy", ll.LatoLato(**toy, **string), up, slack
    rod = ll.Pendulum(length=0.5, mass=0.2, damping=0.02)
    yield "rod, ellipse", rod, ellipse, fast
    lab = dataclasses.replace(rod, drag_frame="lab")
    yield "rod, lab", lab, up, {**fast, "frame": "both"}
    yield "toy, lab", ll.LatoLato(**toy, damping=0.02, drag_frame="lab"), up, fast
    rods = ll.BallPair(**balls, restitution=0.8, drag_frame="lab")
    yield "pair, lab", rods, ellipse, {"initial_angle": (0.5, -0.3)}


def resting_runs():
    """Yield names and arguments of runs that bounce to rest, lift off and rest again."""

    def pushed(ratio, frequency=8.0, phase=0.0):
        amplitude = ratio * 9.8 / frequency**2
        return ll.Harmonic(drive_amplitude=amplitude, drive_frequency=frequency, drive_phase=phase)

    toy, soft = ll.LatoLato(**TOY), ll.LatoLato(**TOY, restitution=0.6)
    plastic, ball = ll.LatoLato(**TOY, restitution=0.0), ll.Ball(**TOY)
    pair, low = ll.BallPair(right=ball, left=ball, restitution=0.6), soft.contact_angle_low
    held = {"initial_offset": 0.0}
    yield "rest", soft, pushed(0.8), held
    yield "lift-off", soft, pushed(1.1, phase=-2.5), held
    yield "lift-off, hardly", soft, pushed(1.0 + 1e-5, phase=1.0), held
    yield "lift-off, at once", toy, pushed(2.0), held
    yield "lift-off, strong", plastic, pushed(50.0, phase=3.1), held
    yield "lift-off, two balls", pair, pushed(1.2, phase=3.1), {"initial_angle": (low, -low)}
    yield "rest at the top", toy, pushed(2.0), {"initial_angle": toy.contact_angle_high}
    top = {"initial_angle": 2.9, "initial_angular_velocity": 4.0}
    yield "plastic at the top", plastic, pushed(3.0, frequency=5.0, phase=-0.3), top
    yield "cascades", ll.LatoLato(**TOY, restitution=0.5), pushed(1.3, 5.0), {"initial_angle": 0.4}
    yield "Zeno", soft, None, {"initial_angle": 0.5 * np.pi}
    yield "Zeno, two balls", pair, None, {"initial_angle": (1.3, -1.3)}
    scenario = ll.load_scenario("zeno")
    yield "Zeno, built in", scenario.system, scenario.drive, {"initial_angle": 0.5 * np.pi}
    yield "contact limit", toy, pushed(1.5), {**held, "contact_limit": 20}
    # Angles and energies leave the range of floats.
    growing = ll.Mathieu(length=1.0, mass=0.8)
    strong = ll.Harmonic(drive_amplitude=3.0, drive_frequency=40.0)
    yield "growth", growing, strong, {"initial_angle": 0.1}


# What rounding does is judged by a run with gravity changed by this share. In the 168 runs of this
# file Node.js moves half as far at most; where energies reach 1e300, 1.5 times.
SHIFT, FACTOR = 1e-13, 2.0
# A motion is regular as long as that moves it by less [rad]; there angles agree to `CLOSE` [rad],
# or, where strings bounce, which adds up like contacts below, as far as that moves them.
REGULAR, CLOSE = 1e-11, 1e-12
# An angle's last digit, 1e-16 rad, is 1e-10 s at the speed of 1e-6 rad/s at which bounces come to
# rest. The times of bounces add up, of two balls to 1e-9 s and rad/s here, of a ball on a string to
# 1.3e-8 m/s.
CASCADE = 2e-8
# Observables of regular motions agree to this share of their size. The last bounces before a rest
# are as slow as the rest speed, and rounding spoils their times, and with them the exponent between
# rests, by one over it. Of 1,600 points of a map with `CRANK`, 972 of which rest, that exponent is
# moved by 5e-9 1/s at most with the usual rest speed of 1e-6 rad/s, by 1.3e-10 1/s with 1e-5 rad/s
# and by 2.2e-11 1/s with 1e-4 rad/s; where nothing rests, by 1.2e-11 1/s. So maps are compared with
# the last of these speeds.
OBSERVED = 1e-10
REST_SPEED = 1e-4


def shifted(system, share=SHIFT):
    return dataclasses.replace(system, gravity=system.gravity * (1.0 + share))


def are_regular(plan_of, system, expected, native=run_fastest):
    """Which points of a map move by little with gravity changed by `SHIFT` either way.

    Where a motion is chaotic, one of both may happen to end nearby.
    """
    moved = [run_chunk(plan_of(shifted(system, s)), 0, native)[0] for s in (SHIFT, -SHIFT)]
    sizes = [size for values in moved for size in apart(values, expected).values()]
    return np.max(sizes, axis=0) < REGULAR


def running_largest(rows):
    """The largest size in each row so far."""
    return np.maximum.accumulate(np.abs(np.nan_to_num(rows)), axis=-1)


@dataclasses.dataclass
class Twin:
    """What native code found, also with gravity shifted, and what Node.js found."""

    balls: int
    native: dict
    shifted: dict
    node: dict

    def moves(self, name, rows=np.s_[:]):
        """How far rows of this name have been moved so far: by the shift, and in Node.js."""
        native, others = self.native[name][rows], (self.shifted, self.node)
        return [running_largest(other[name][rows] - native) for other in others]

    @property
    def angles(self):
        return np.s_[: 2 * self.balls : 2]


@pytest.fixture(scope="module")
def twins():
    """All runs of this file by name; Node.js is started once."""
    pairs = {}
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "the run (stopped|failed)", RuntimeWarning)
        for name, system, drive, how in [*random_runs(), *plane_runs(), *resting_runs()]:
            arguments = {"times": TIMES, **how}
            pairs[name] = [
                record_run(each, drive, **arguments) for each in (system, shifted(system))
            ]
    result = in_node(native for native, _ in pairs.values())
    return {
        name: Twin(native.options["how"]["balls"], native.expected, other.expected, each)
        for (name, (native, other)), each in zip(pairs.items(), result, strict=True)
    }


def test_modules_are_of_these_sources_and_small():
    modules = read_layout()["modules"]
    assert set(modules) == {"one", "two", "plane_one", "plane_two", "lanes"}
    # The largest page, Map with its 1 MB, loads all of one variant that are not of the plane. The
    # bounds are those of the compiler that builds wheels, the oldest (353,292 and 292,688 bytes,
    # of 1.7 MB that a first visit loads); newer ones save 2 to 5 %.
    for variant in ("", "-scalar"):
        sizes = {name: (MODULES / f"{name}{variant}.wasm").stat().st_size for name in modules}
        in_plane = sizes.pop("plane_one") + sizes.pop("plane_two")
        assert sum(sizes.values()) <= 360_000
        assert in_plane <= 298_000


def test_angles_of_regular_motions_agree(twins):
    whole = 0
    for name, twin in twins.items():
        by_shift, in_node = twin.moves("samples", twin.angles)
        regular = by_shift.max(axis=0) < REGULAR
        assert np.all((in_node <= np.maximum(CLOSE, by_shift))[:, regular]), name
        whole += regular.all()
    assert whole >= 0.8 * len(twins)


def test_no_sample_moves_further_than_by_rounding(twins):
    for name, twin in twins.items():
        for what in ("samples", "pivot"):
            by_shift, in_node = twin.moves(what)
            assert np.all(in_node <= np.maximum(CLOSE, FACTOR * by_shift)), (name, what)


def test_energies_and_tensions_move_no_further_than_by_rounding(twins):
    rows = [BALL_ROWS.index(name) for name in BALL_ROWS if name not in ("lab_energy", "rod_power")]
    for name, twin in twins.items():
        if twin.native["failed"]:  # energies are beyond all floats
            continue
        by_shift, in_node = twin.moves("out", np.s_[:, rows])
        size = running_largest(twin.native["out"][:, rows])
        assert np.all(in_node <= np.maximum(CLOSE * (1.0 + size), FACTOR * by_shift)), name


def test_contacts_and_statuses_are_the_same(twins):
    seen = set()
    for name, twin in twins.items():
        native, node = twin.native, twin.node
        assert node["status"] == native["status"].split()[0], name
        kinds = [CONTACT_KINDS[int(kind)] for kind in node["contact_kinds"]]
        assert kinds == [CONTACT_KINDS[kind] for kind in native["contact_kinds"]], name
        for field in ("contacts", "grazes", "rests", "mode"):
            assert node["run"]["state"][field] == native["state"][field], (name, field)
        # A ball that turns where a step ends does so in that step or in one of its own; on strings,
        # whose motions differ by more than a rounding, that happens.
        unlike = node["run"]["state"]["total_steps"] - native["state"]["total_steps"]
        assert abs(unlike) <= (5 if native["state"]["string_impulse"] > 0.0 else 0), name
        if native["contact_times"].shape == twin.shifted["contact_times"].shape:
            for what in ("contact_times", "contact_values"):
                by_shift, in_node = twin.moves(what)
                assert np.all(in_node <= np.maximum(CASCADE, FACTOR * by_shift)), (name, what)
        seen |= {node["status"], *kinds}
    assert seen == {"complete", "stopped", "failed", *CONTACT_KINDS}


def test_runs_begin_from_parameters():
    random = np.random.default_rng(5)
    shaken = {name: drive for name, drive in drives(random).items() if name != "measured"}
    shaken["static"] = ll.FixedPivot()
    cases, names = [], []
    for system_name, drive_name in itertools.product(
        ("linear drag", "mathieu", "walls, all drags", "two balls"), shaken
    ):
        system, how = systems(random)[system_name]
        drive = shaken[drive_name]
        case = record_run(system, drive, times=TIMES, **how, tolerance=1e-10)
        arguments = {"angles": np.atleast_1d(how["initial_angle"]), "duration": DURATION}
        arguments |= {"tolerance": 1e-10, "rest_speed": DEFAULT_REST_SPEED}
        cases += [case, from_parameters(case, system, drive, **arguments)]
        names.append((system_name, drive_name))
    result = in_node(cases)
    for name, from_memory, alone in zip(names, result[::2], result[1::2], strict=True):
        assert alone["status"] == "complete"
        # What is prepared differs by fused multiply-adds: a last digit of the drive's phases, say.
        for what in ("samples", "contact_times"):
            np.testing.assert_allclose(
                alone[what], from_memory[what], rtol=0, atol=1e-9, err_msg=str(name)
            )


def test_a_page_repeats_with_half_the_step_where_python_does():
    pendulum = ll.Pendulum(**BODY, damping=0.5)
    noise = ll.VelocityKicks(noise_strength=30.0, noise_seed=4, noise_interval=0.5)
    arguments = {"angles": (0.5,), "duration": 20.0, "tolerance": 1e-10}
    times = np.linspace(0.0, 20.0, 101)
    case = record_run(pendulum, ll.FixedPivot(), initial_angle=0.5, noise=noise, times=times)
    (result,) = in_node([from_parameters(case, pendulum, ll.FixedPivot(), **arguments)])
    assert result["closes"]
    assert result["halvings"] > 0
    assert result["run"]["settings"]["step"][0] == pytest.approx(case.expected["step"], rel=1e-14)


def test_references_of_thirty_digits():
    cases = {}
    for name, case in CASES.items():
        system, drive, start, end = read(case)
        times = [float(state["time"]) for state in case["states"]]
        cases[name] = record_run(system, drive, **start, times=times, duration=end)
    for (name, run), node in zip(cases.items(), in_node(cases.values()), strict=True):
        case, balls = CASES[name], run.options["how"]["balls"]
        listed = case.get("contacts", [])
        assert [CONTACT_KINDS[int(kind)] for kind in node["contact_kinds"]] == [
            row["kind"] for row in listed
        ]
        for i, row in enumerate(listed):
            check(node["contact_times"][i], row["time"], WITH_CONTACTS, (name, "contact", i))
        energies = node["out"][:, : BALL_ROWS.index("potential_energy") + 1].sum(axis=1)
        for i, state in enumerate(case["states"]):
            now, bound = node["samples"][:, i], bound_of(case)
            where = name, state["time"]
            check(now[: 2 * balls : 2], state["angle"], bound, where)
            check(now[1 : 2 * balls : 2], state["angular_velocity"], bound, where)
            check(energies[:, i], state["energy"], bound, where)
            for ledger in ("drive_work", "damping_loss", "impact_loss"):
                check(now[LEDGER[ledger]], state[ledger], bound, (*where, ledger))


SWEEPS = {
    "walls": (ll.LatoLato(**TOY, damping=0.02, restitution=0.9), 0.4, ()),
    "elastic": (ll.LatoLato(**TOY), 0.4, ()),
    "free": (ll.Pendulum(**BODY, damping=0.02), 0.3, ()),
    "linear": (ll.Mathieu(**BODY, damping=0.02), 0.01, ()),
    "deviations": (ll.LatoLato(**TOY, damping=0.02), 0.4, ("lyapunov_spectrum",)),
}


def apart(values, others):
    """How far apart variables are at each point of a map, as shares of their size above 1."""
    result = {}
    for name, one in values.items():
        shape = others["status"].shape
        one, other = (x.reshape(*shape, -1).astype(float) for x in (one, others[name]))
        same = (one == other) | (np.isnan(one) & np.isnan(other))
        with np.errstate(invalid="ignore"):  # infinite ones
            far = np.where(same, 0.0, np.abs(one - other) / (1.0 + np.abs(np.nan_to_num(other))))
        result[name] = np.nan_to_num(far, nan=np.inf).max(axis=-1)
    return result


ROUGH = ll.LatoLato(**TOY, **DRAGS, restitution=0.9)
BALL = ll.Ball(**TOY, damping=0.02)
PAIR = ll.BallPair(right=BALL, left=BALL, restitution=0.9)
UNLIKE = dataclasses.replace(PAIR, left=dataclasses.replace(BALL, mass=1.1, **DRAGS))
FROM_PARAMETERS = {
    **SWEEPS,
    "rough": (ROUGH, 0.4, ()),
    "compression": (SWEEPS["walls"][0], 0.4, ("compression_fraction",)),
    "crank": (SWEEPS["walls"][0], 0.4, ("lyapunov_exponent",)),
    "clamp": (SWEEPS["walls"][0], 0.4, ()),
    "noise": (SWEEPS["walls"][0], 0.4, ()),
    "mirrored pair": (PAIR, (0.4, -0.4), ("transverse_exponent",)),
    "unlike pair": (UNLIKE, (0.4, -0.3), ("lyapunov_spectrum", "compression_fraction")),
    # Elastic: bounces that come to rest add up roundings, see `CASCADE`.
    "pair with noise": (dataclasses.replace(PAIR, restitution=1.0), (0.4, -0.4), ()),
}
CRANK = ll.CrankSlider(drive_amplitude=0.02, drive_frequency=9.0, connecting_rod_length=0.5)
NOISE = ll.VelocityKicks(noise_strength=0.05, noise_seed=3)
# Short where motion soon becomes chaotic.
HOW = {
    "clamp": {"contact": ll.ClampContact(clamp_step=1e-3)},
    "noise": {"noise": NOISE, "duration": 6.0},
    "unlike pair": {"duration": 10.0},
    "pair with noise": {"noise": dataclasses.replace(NOISE, noise_interval=0.07), "duration": 5.0},
}


@pytest.mark.parametrize("name", FROM_PARAMETERS)
def test_maps_agree_from_their_parameters_on(name):
    system, angle, further = FROM_PARAMETERS[name]
    lengths = ("length",) if system.angles == 1 else ("right_length", "left_length")
    arguments = {
        "axes": {
            "drive_amplitude": [0.0, 0.02, 0.1, 0.3],
            "frequency_ratio": [0.5, 1.0, 2.0, 3.0],
            "lengths": {key: [0.05, 0.5, 1.0] for key in lengths},  # a rod shorter than the ball
        },
        "duration": 20.0,
        "transient": 2.0,
        "observables": [*WITHOUT_PERIODS, "response_samples", "contact_word", *further],
        "initial_angle": angle,
        "tolerance": 1e-8,
        "rest_speed": REST_SPEED,
        **HOW.get(name, {}),
    }
    drive = CRANK if name == "crank" else None
    plan_of = functools.partial(make_plan, drive=drive, **arguments)
    plan = plan_of(system)
    expected, _ = run_chunk(plan, 0, run_fastest)
    regular = are_regular(plan_of, system, expected)
    node, scalar = in_node(map_case(plan, expected, variant) for variant in ("", "-scalar"))
    result = {name: node[name] for name in expected}
    for variable in expected:
        assert np.array_equal(node[variable], scalar[variable], equal_nan=True), variable
    status = expected["status"]
    assert np.array_equal(result["status"], status)
    assert np.any(status == INVALID) == system.has_contacts
    assert np.count_nonzero(regular & (status != INVALID)) >= 15
    sizes = apart(result, expected)
    assert sizes["final_angle"][regular].max() <= CLOSE
    for variable, size in sizes.items():
        assert size[regular].max() <= OBSERVED, variable


def test_noise_has_the_random_numbers_of_numpy():
    seeds = [(0, 0), (2**63 - 1, 2**53 - 1), (12345, 7)]
    arrays = {f"{seed} {stream}": np.zeros(100_000) for seed, stream in seeds}
    (result,) = in_node([Case({"module": "one", "normals": True}, arrays, arrays)])
    for seed, stream in seeds:
        key = np.array([seed, stream], dtype=np.uint64)
        expected = np.random.Generator(np.random.Philox(key=key)).standard_normal(100_000)
        assert np.abs(expected).max() > 4.0  # from the tail of the ziggurat too
        # The layers' widths come of one another, by 255 roundings.
        np.testing.assert_allclose(result[f"{seed} {stream}"], expected, rtol=0, atol=1e-13)


REFUSED = {
    "no observable is called largest": {"observables": [{"name": "largest"}]},
    "no observable is called toString": {"observables": [{"name": "toString"}]},
    "has no parameter level": {
        "observables": [{"name": "crossings", "parameters": {"level": 1.0}}]
    },
    "two observables both give crossings": {"observables": [{"name": "crossings"}] * 2},
    "must look at equally many": {
        "observables": [{"name": "poincare_section"}, {"name": "response_period"}]
    },
    "belongs to systems of 2 angles": {"observables": [{"name": "transverse_exponent"}]},
    "module for this map is two": {"angles": 2},
    "make noise_interval longer": {
        "noise": {"noise_strength": 0.1, "noise_interval": 1e-9},
        "parameters": {"gravity": 9.8, "balls.0.length": 1.0, "balls.0.mass": 1.0, "tolerance": 1},
    },
    "is_nonsmooth is found out": {"parameters": {"is_nonsmooth": 1}},
    "collides must be 0 or 1": {"parameters": {"collides": 0.5}},
    "knows no walls": {"parameters": {"collides": 1, "is_linear": 1}},
    "has no field mass": {"parameters": {"mass": 1.0}},
    "no drive is called hand": {"drive": {"kind": "hand", "parameters": {}}},
    "no drive has the parameter drive_amplitud": {
        "drive": {"kind": "harmonic", "parameters": {"drive_amplitud": 0.1}}
    },
    "transient must be at least 0 s": {"transient": -1.0},
    "grow": {"count": 600_000_000, "drive": {"kind": "fixed_pivot", "parameters": {}}},
}


def test_maps_that_make_no_sense_are_refused_and_leave_nothing_behind():
    usual = {
        "refused": True, "count": 2, "parameters": {}, "duration": 1.0,
        "drive": {"kind": "fixed_pivot", "parameters": {}}, "observables": [{"name": "crossings"}],
    }  # fmt: skip
    cases = [
        Case({"module": "lanes", "question": {**usual, **bad}}, {}) for bad in REFUSED.values()
    ]
    for words, result in zip(REFUSED, in_node(cases), strict=True):
        assert words in result["error"]
        assert result["left"] == 0, words


@pytest.mark.parametrize("in_lanes", [True, False], ids=["lanes", "one by one"])
@pytest.mark.parametrize("name", SWEEPS)
def test_points_of_a_map_agree(name, in_lanes):
    system, angle, further = SWEEPS[name]
    axes = {
        "drive_amplitude": np.linspace(0.01, 0.3, 10),
        "frequency_ratio": np.linspace(0.4, 4.0, 10),
    }
    arguments = {
        "axes": axes,
        "duration": 20.0,
        "transient": 5.0,
        "observables": [*IN_LANES, *further],
        "initial_angle": angle,
        "tolerance": 1e-8,
        "rest_speed": REST_SPEED,
    }
    native = run_fastest if in_lanes else run_scalar
    plan_of = functools.partial(make_plan, drive=None, **arguments)
    plan = plan_of(system)
    expected, _ = run_chunk(plan, 0, native)
    result, _ = run_chunk(plan, 0, run_points_in_node(in_lanes))
    assert np.array_equal(result["status"], expected["status"])
    regular = are_regular(plan_of, system, expected, native)
    assert np.count_nonzero(regular) >= 50
    sizes = apart(result, expected)
    assert sizes["final_angle"][regular].max() <= CLOSE
    for variable, size in sizes.items():
        assert size[regular].max() <= OBSERVED, variable
