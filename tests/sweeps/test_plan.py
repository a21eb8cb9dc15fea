"""The plan of a sweep: its hash, its chunks, and one clear message for every mistake."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import latolato as ll
from latolato.core.errors import InputError
from latolato.observables import Crossings, MotionClass, PoincareSection
from latolato.physics.contacts import ClampContact
from latolato.sweeps.axes import Axis
from latolato.sweeps.labels import Memory
from latolato.sweeps.plan import Plan, make_plan
from latolato.sweeps.points import columns_of

PENDULUM = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
TOY = ll.LatoLato(length=1.0, mass=0.8, radius=0.1)
PAIR = ll.BallPair(
    right=ll.Ball(length=1.0, mass=0.8, radius=0.1), left=ll.Ball(length=1.0, mass=0.8, radius=0.1)
)
STRINGS = dataclasses.replace(TOY, suspension="string")
DRIVE = ll.Harmonic(drive_amplitude=0.05, drive_frequency=6.0)
UPRIGHT = ll.PlanarHarmonic(vertical_amplitude=0.05, horizontal_amplitude=0.0, drive_frequency=6.0)
SETTINGS = {
    "axes": {"drive_amplitude": [0.0, 0.1], "drive_frequency": [5.0, 6.0]},
    "initial_angle": 0.4,
    "duration": 3.0,
    "observables": ["crossings", "largest_angle"],
    "executor": "reference",
}


def planned(system=TOY, drive=DRIVE, **changed):
    arguments = {k: v for k, v in (SETTINGS | changed).items() if k != "executor"}
    return make_plan(system, drive, **arguments)


CHANGES = {
    "nothing": {},
    "mass": {"system": dataclasses.replace(TOY, mass=0.9)},
    "restitution": {"system": dataclasses.replace(TOY, restitution=0.9)},
    "gravity": {"system": dataclasses.replace(TOY, gravity=9.81)},
    "system": {"system": PENDULUM},
    "suspension": {"system": STRINGS},
    "string_restitution": {"system": dataclasses.replace(STRINGS, string_restitution=0.9)},
    "drag_frame": {"system": dataclasses.replace(TOY, drag_frame="lab")},
    "initial_distance": {"system": STRINGS, "initial_distance": 0.5},
    "drive_phase": {"drive": dataclasses.replace(DRIVE, drive_phase=0.1)},
    "drive": {
        "drive": ll.CrankSlider(
            drive_amplitude=0.05, drive_frequency=6.0, connecting_rod_length=0.2
        )
    },
    "values": {"axes": {"drive_amplitude": [0.0, 0.1], "drive_frequency": [5.0, 6.5]}},
    "order of values": {"axes": {"drive_amplitude": [0.1, 0.0], "drive_frequency": [5.0, 6.0]}},
    "order of axes": {"axes": {"drive_frequency": [5.0, 6.0], "drive_amplitude": [0.0, 0.1]}},
    "zip": {"axes": {"case": {"drive_amplitude": [0.0, 0.1], "drive_frequency": [5.0, 6.0]}}},
    "initial_angle": {"initial_angle": 0.41},
    "initial_offset": {"initial_angle": None, "initial_offset": 0.4},
    "initial_angular_velocity": {"initial_angular_velocity": 1e-9},
    "duration": {"duration": 3.5},
    "transient": {"transient": 1.0},
    "transient_periods": {"transient_periods": 1.0},
    "tolerance": {"tolerance": 1e-7},
    "contact": {"contact": None},
    "clamp": {"contact": "clamp"},
    "clamp_step": {"contact": ClampContact(clamp_step=1e-4)},
    "rest_speed": {"rest_speed": 1e-6},
    "contact_limit": {"contact_limit": 10},
    "noise": {"noise": ll.VelocityKicks(noise_strength=0.1, noise_seed=1)},
    "seed": {"noise": ll.VelocityKicks(noise_strength=0.1, noise_seed=2)},
    "stream": {"noise": ll.VelocityKicks(noise_strength=0.1, noise_seed=1, noise_stream=1)},
    "continuation": {"continuation": "drive_frequency"},
    "direction": {"continuation": "drive_frequency", "direction": "down"},
    "both": {"continuation": "drive_frequency", "direction": "both"},
    "chunk_size": {"chunk_size": 3},
    "observables": {"observables": ["largest_angle", "crossings"]},
    "an observable": {"observables": ["crossings"]},
    "crossing_angle": {"observables": [Crossings(crossing_angle=1.0), "largest_angle"]},
    "unwrapped": {"observables": [Crossings(unwrapped=True), "largest_angle"]},
}


class TestHash:
    def test_every_parameter_changes_it(self):
        hashes = {name: planned(**changed).hash for name, changed in CHANGES.items()}
        repeated = {n: h for n, h in hashes.items() if list(hashes.values()).count(h) > 1}
        assert not repeated

    def test_every_field_of_a_plan_is_changed_above(self):
        plain = planned()
        for field in dataclasses.fields(Plan):
            different = [
                name
                for name, changed in CHANGES.items()
                if getattr(planned(**changed), field.name) != getattr(plain, field.name)
            ]
            assert different, field.name

    def test_it_is_the_same_however_the_same_is_said(self):
        plain = planned()
        alike = [
            planned(observables=("crossings", "largest_angle")),
            planned(observables=[Crossings(), "largest_angle"]),
            planned(observables=[Crossings(unwrapped=False, crossing_angle=2), "largest_angle"]),
            planned(axes={k: np.array(v) for k, v in SETTINGS["axes"].items()}),
            planned(axes={k: iter(v) for k, v in SETTINGS["axes"].items()}),
            planned(initial_angle=np.float64(0.4), duration=3),
            planned(system=ll.LatoLato(radius=0.1, mass=0.8, length=1)),
        ]
        assert {plan.hash for plan in alike} == {plain.hash}
        watched = [MotionClass(strong_angle=1.0, weak_angle=0.5), "crossings"]
        other = [MotionClass(weak_angle=0.5, strong_angle=1.0), Crossings()]
        assert planned(observables=watched).hash == planned(observables=other).hash

    def test_it_is_that_of_maps_stored_before_there_were_strings(self):
        assert planned().hash == "1c5f26ab11657aa28c311e339d4c935a"
        pair = planned(system=PAIR, initial_angle=(0.4, -0.4))
        assert pair.hash == "901168c2578ae5fc00ed850f27479889"

    @pytest.mark.parametrize("name", CHANGES)
    def test_a_plan_comes_back_from_its_description(self, name):
        plan = planned(**CHANGES[name])
        assert Plan.from_description(plan.describe()) == plan


@st.composite
def plans(draw):
    """A plan of any shape, chunk size and continuation."""
    names = ("a", "b", "c", "d")[: draw(st.integers(1, 4))]
    axes = tuple(
        Axis(name, (name,), (tuple(float(i) for i in range(draw(st.integers(1, 9)))),))
        for name in names
    )
    followed = draw(st.sampled_from(["", *names]))
    direction = draw(st.sampled_from(["up", "down", "both"])) if followed else "up"
    return dataclasses.replace(
        planned(),
        axes=axes,
        continuation=followed,
        direction=direction,
        chunk_size=draw(st.integers(1, 3000)),
    )


class TestChunks:
    @settings(max_examples=300, deadline=None)  # shapes are cheap; machines differ in speed
    @given(plan=plans())
    def test_they_cover_the_grid_once(self, plan):
        covered = np.zeros(plan.shape, dtype=int)
        for number in range(plan.chunks):
            covered[plan.block(number)] += 1
        assert (covered == 1).all()

    @settings(max_examples=300, deadline=None)
    @given(plan=plans())
    def test_they_hold_at_most_the_chunk_size_but_never_cut_a_continuation(self, plan):
        line = plan.shape[plan.dims.index(plan.continuation)] if plan.continuation else 1
        assert math.prod(plan.chunk_shape) <= max(plan.chunk_size, line)
        if plan.continuation:
            assert plan.chunk_shape[plan.dims.index(plan.continuation)] == line
        if plan.direction == "both":
            assert plan.chunk_shape[0] == 1  # the two ways differ

    def test_by_default_there_are_enough_for_workers_and_none_is_large(self):
        def chunked(n):
            return planned(
                axes={"initial_offset": list(np.linspace(0.0, 1.0, n))}, initial_angle=None
            )

        assert chunked(100).chunks == 1
        assert chunked(2000).chunks == 4
        assert chunked(40_000).chunk_size == 4096


MISTAKES = {
    "unknown axis": ({"axes": {"drive_amplitud": [0.1]}}, "did you mean 'drive_amplitude'"),
    "axis of another system": (
        {"system": PENDULUM, "axes": {"radius": [0.1]}},
        "unknown parameter 'radius' in axes",
    ),
    "no axes": ({"axes": {}}, "axes must name at least one parameter"),
    "axes as a list": ({"axes": ["drive_amplitude"]}, "axes must map names of parameters"),
    "empty axis": ({"axes": {"mass": []}}, "mass must hold at least 1 value"),
    "empty array": ({"axes": {"mass": np.array([])}}, "mass must hold at least 1 value"),
    "empty zip": ({"axes": {"case": {}}}, "axis case must name at least one parameter"),
    "repeated value": ({"axes": {"mass": [1.0, 2.0, 1.0]}}, "got 1 twice"),
    "repeated point of a zip": (
        {"axes": {"case": {"mass": [1.0, 1.0], "length": [1.0, 1.0]}}},
        "got 1, 1 twice",
    ),
    "unequal zip": (
        {"axes": {"case": {"mass": [1.0, 2.0], "length": [1.0]}}},
        "must be equally many, got mass 2, length 1",
    ),
    "zip under the name of a parameter": (
        {"axes": {"mass": {"length": [1.0], "radius": [0.1]}}},
        "needs a name that is not a parameter",
    ),
    "the same thing twice": (
        {"axes": {"drive_frequency": [1.0], "frequency_ratio": [1.0]}},
        "drive_frequency and frequency_ratio both set drive_frequency",
    ),
    "one amplitude by two ratios": (
        {"axes": {"amplitude_ratio": [0.1], "case": {"drive_acceleration_ratio": [1.0]}}},
        "both set drive_amplitude",
    ),
    "two starts": (
        {"axes": {"initial_angle": [0.4], "initial_offset": [0.1]}},
        "initial_angle and initial_offset both set initial_angle",
    ),
    "reserved name": ({"axes": {"sample": {"mass": [1.0]}}}, "axis name 'sample' is taken"),
    "name of an observable": (
        {"axes": {"mean_energy": {"mass": [1.0]}}, "observables": ["mean_energy"]},
        "axis name 'mean_energy' is that of an observable",
    ),
    "name of the status": ({"axes": {"status": {"mass": [1.0]}}}, "axis name 'status' is taken"),
    "name that is no name": ({"axes": {"a/b": {"mass": [1.0]}}}, "letters, digits and underscores"),
    "misspelt, without a drive": (
        {"drive": None, "axes": {"drive_amplitud": [0.1], "frequency_ratio": [2.0]}},
        "unknown parameter 'drive_amplitud' in axes: did you mean 'drive_amplitude'",
    ),
    "acceleration of stages": (
        {
            "drive": ll.FrequencySchedule(
                drive_amplitude=0.1, times=(0.0, 5.0), drive_frequencies=(3.0, 4.0)
            ),
            "axes": {"drive_acceleration_ratio": [1.0]},
        },
        "unknown parameter 'drive_acceleration_ratio' in axes",
    ),
    "an angle beside an axis of offsets": (
        {"axes": {"initial_offset": [0.1]}, "initial_angle": 0.4},
        "give only one of initial_angle and an axis initial_offset",
    ),
    "an offset beside an axis of angles": (
        {"axes": {"initial_angle": [0.4]}, "initial_angle": None, "initial_offset": 0.1},
        "give only one of initial_offset and an axis initial_angle",
    ),
    "no array": ({"axes": {"mass": np.array(1.0)}}, "mass must be a sequence of numbers in kg"),
    "two dimensions": ({"axes": {"mass": np.ones((2, 2))}}, "must be one-dimensional"),
    "text as values": ({"axes": {"mass": "heavy"}}, "mass must be a sequence of numbers in kg"),
    "durations": ({"axes": {"drive_phase": np.array([1], "m8[ms]")}}, "values of type timedelta64"),
    "text as a value": ({"axes": {"mass": [1.0, "heavy"]}}, r"mass\[1\] must be a number in kg"),
    "one number": ({"axes": {"mass": 1.0}}, "mass must be a sequence of numbers in kg"),
    "NaN": ({"axes": {"mass": [1.0, math.nan]}}, r"mass\[1\] must be a number"),
    "out of range": ({"axes": {"restitution": [0.5, 1.5]}}, r"restitution\[1\] must lie in .0, 1."),
    "no drive": ({"drive": None, "axes": {"drive_phase": [0.0]}}, "needs a drive"),
    "half a drive": ({"drive": None, "axes": {"drive_amplitude": [0.1]}}, "needs a drive"),
    "negative duration": ({"duration": -1.0}, "duration must lie in"),
    "no duration": ({"duration": 0.0}, "duration must lie in"),
    "text as duration": ({"duration": "long"}, "duration must be a number in s"),
    "negative transient": ({"transient": -1.0}, "transient must lie in"),
    "long transient": ({"transient": 3.0}, r"transient must be shorter than duration \(3 s\)"),
    "tolerance": ({"tolerance": 0.1}, "tolerance must lie in"),
    "contact_limit": ({"contact_limit": 0}, "contact_limit must lie in"),
    "chunk_size": ({"chunk_size": 2.5}, "chunk_size must be a whole number"),
    "unknown observable": ({"observables": ["crossing"]}, "did you mean 'crossings'"),
    "no observables": ({"observables": []}, "observables must name at least one"),
    "observable as a number": ({"observables": [3]}, "must be a name or an instance, got 3"),
    "observables as a number": ({"observables": 3}, "must be names or instances, got 3"),
    "observable twice": (
        {"observables": ["crossings", Crossings(crossing_angle=1.0)]},
        "two observables both give 'crossings'",
    ),
    "unknown contact": ({"contact": "soft"}, "unknown contact law 'soft'"),
    "unknown executor": ({"executor": "thread"}, "did you mean 'threads'"),
    "unknown direction": ({"direction": "sideways"}, "direction must be 'up', 'down' or 'both'"),
    "direction alone": ({"direction": "both"}, "needs a continuation"),
    "unknown continuation": (
        {"continuation": "drive_frequenc"},
        "did you mean 'drive_frequency'",
    ),
    "unsorted continuation": (
        {"axes": {"drive_frequency": [5.0, 7.0, 6.0]}, "continuation": "drive_frequency"},
        "must increase or decrease steadily",
    ),
    "continuation of starts": (
        {"axes": {"initial_angle": [0.4, 0.5]}, "continuation": "initial_angle"},
        "is impossible",
    ),
    "continuation with noise": (
        {"continuation": "drive_frequency", "noise": ll.VelocityKicks(noise_strength=0.1)},
        "continuation and noise exclude each other",
    ),
    "string_restitution of rods": (
        {"axes": {"string_restitution": [0.0, 0.9]}},
        "string_restitution is for balls on strings: a rod",
    ),
    "distances of rods": (
        {"axes": {"initial_distance": [0.5, 0.9]}},
        "initial_distance is for balls on strings: a rod",
    ),
    "a distance of rods": ({"initial_distance": 0.5}, "initial_distance is for balls on strings"),
    "a distance beside an axis of distances": (
        {"system": STRINGS, "axes": {"initial_distance": [0.5]}, "initial_distance": 0.4},
        "initial_distance is given as a value and varied along an axis, got 0.4; drop one",
    ),
    "distances beside axes of both": (
        {
            "system": dataclasses.replace(PAIR, suspension="string"),
            "axes": {"initial_distance_right": [0.5], "initial_distance_left": [0.6]},
            "initial_angle": (0.4, -0.4),
            "initial_distance": (0.5, 0.6),
        },
        "initial_distance is given as a value and varied along an axis",
    ),
    "no distance": (
        {"system": STRINGS, "initial_distance": 0.0},
        "initial_distance must lie in .0, inf. m, got 0",
    ),
    "quadratic drag relative to the room": (
        {
            "system": dataclasses.replace(TOY, drag_frame="lab"),
            "axes": {"quadratic_damping": [0.0, 0.1]},
        },
        "drag_frame must be 'pivot' with quadratic_damping",
    ),
    "suspension as an axis": (
        {"axes": {"suspension": ["rod", "string"]}},
        "suspension is 'rod' or 'string', but an axis varies numbers only; run one sweep for each",
    ),
    "drag_frame among parameters of an axis": (
        {"axes": {"both": {"drag_frame": ["pivot", "lab"], "mass": [0.7, 0.8]}}},
        "drag_frame is 'pivot' or 'lab', but an axis varies numbers only",
    ),
    "a pivot that moves sideways along an axis": (
        {"drive": UPRIGHT, "axes": {"horizontal_amplitude": [0.0, 0.02]}},
        "breaks the mirror symmetry of a LatoLato: drive must be vertical, .* use a BallPair",
    ),
    "one that moves a linear pendulum": (
        {
            "system": ll.Mathieu(length=1.0, mass=0.8),
            "drive": UPRIGHT,
            "axes": {"both": {"horizontal_amplitude": [0.0, 0.02], "mass": [0.7, 0.8]}},
        },
        "which a Mathieu does not describe: drive must be vertical",
    ),
    "compression of strings": (
        {"system": STRINGS, "observables": ["compression_fraction"]},
        "compression_fraction is for balls on rods: a string never pushes, it goes slack; ask for "
        "slack_fraction, or give suspension='rod'",
    ),
    "slackness of rods": (
        {"observables": ["slack_fraction"]},
        "slack_fraction is for balls on strings: a rod keeps its ball at its length",
    ),
    "clamped strings": ({"system": STRINGS, "contact": "clamp"}, "for rods .* not for strings"),
    "system": ({"system": "toy"}, "system must be one of"),
    "drive": ({"drive": 0.1}, "drive must be None or one of"),
    "noise": ({"noise": 0.1}, "noise must be VelocityKicks or None"),
    "no start": ({"initial_angle": None}, "initial_angle is needed"),
    "angle and offset": ({"initial_offset": 0.1}, "only one of initial_angle and initial_offset"),
    "offset of a pendulum": (
        {"system": PENDULUM, "initial_angle": None, "initial_offset": 0.1},
        "initial_offset counts from",
    ),
    "one angle for two balls": ({"system": PAIR}, "must be two numbers"),
    "workers of plain Python": ({"workers": 2}, "executor 'reference' does not know workers"),
    "a client of threads": (
        {"executor": "threads", "client": "tcp://here"},
        "executor 'threads' does not know client, it takes only workers",
    ),
    "no workers": ({"executor": "threads", "workers": 0}, "workers must lie in"),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_has_one_clear_message(mistake):
    changed, message = MISTAKES[mistake]
    arguments = SETTINGS | changed
    system, drive = arguments.pop("system", TOY), arguments.pop("drive", DRIVE)
    with pytest.raises(InputError, match=message) as caught:
        ll.sweep(system, drive, **arguments)
    assert type(caught.value) is InputError
    assert "\n" not in str(caught.value)


def test_an_unknown_option_leaves_no_store_behind(tmp_path):
    with pytest.raises(ValueError, match="does not know workers"):
        ll.sweep(TOY, DRIVE, **SETTINGS, workers=2, store=tmp_path / "map.zarr")
    assert list(tmp_path.iterdir()) == []


UNSTEADY = [
    ll.Chirp(drive_amplitude=0.05, drive_frequency=5.0, drive_frequency_final=7.0, sweep_time=2.0),
    ll.FrequencySchedule(drive_amplitude=0.05, times=[0.0, 1.0], drive_frequencies=[5.0, 6.0]),
]


@pytest.mark.parametrize("drive", UNSTEADY, ids=lambda d: type(d).__name__)
def test_a_drive_without_one_period_is_neither_followed_nor_sampled(drive):
    axes = {"drive_amplitude": [0.0, 0.1]}
    with pytest.raises(ValueError, match="continuation needs a drive that goes on"):
        planned(drive=drive, axes=axes, continuation="drive_amplitude")
    with pytest.raises(ValueError, match="no single period that a stroboscope could follow"):
        planned(drive=drive, axes=axes, observables=[PoincareSection()])


def test_values_keep_their_order():
    plan = planned(axes={"drive_frequency": [6.0, 5.0, 7.0]})
    columns = columns_of(plan, np.arange(3))
    np.testing.assert_array_equal(columns["drive_frequency"], [6.0, 5.0, 7.0])


def test_a_variable_stands_for_its_observable():
    names = [type(o).__name__ for o in planned(observables=["drive_work"]).observables]
    assert names == ["EnergyLedger"]


def test_amplitude_and_frequency_need_no_drive():
    plan = planned(drive=None, axes={"amplitude_ratio": [0.1], "frequency_ratio": [2.0]})
    assert isinstance(plan.drive, ll.Harmonic)


def test_balls_vary_one_by_one():
    plan = planned(
        system=PAIR, axes={"right_mass": [0.5, 1.0], "initial_angle_left": [-0.5, -1.0]},
        initial_angle=(0.7, 0.0),
    )  # fmt: skip
    columns = columns_of(plan, np.arange(4))
    np.testing.assert_array_equal(columns["right_mass"], [0.5, 0.5, 1.0, 1.0])
    np.testing.assert_array_equal(columns["left_mass"], 0.8)
    np.testing.assert_array_equal(columns["initial_angle_left"], [-0.5, -1.0, -0.5, -1.0])
    np.testing.assert_array_equal(columns["initial_angle_right"], 0.7)


def test_a_map_too_large_is_refused_with_its_size_and_a_way_out(monkeypatch):
    amplitudes, frequencies = np.linspace(0.0, 0.1, 40_000), np.linspace(1.0, 2.0, 40_000)
    axes = {"drive_amplitude": amplitudes, "drive_frequency": frequencies}
    with pytest.raises(InputError, match=r"40000 x 40000 points .* take 26 GB; take fewer values"):
        planned(axes=axes)

    def full(*_, **__):
        raise MemoryError("Unable to allocate 1 TiB")

    monkeypatch.setattr(np, "full", full)
    with pytest.raises(InputError, match=r"of 4 points do not fit .* allocate 1 TiB; give a store"):
        Memory(planned(), "host")


def test_a_sweep_has_no_derivatives():
    with pytest.raises(InputError, match=r"^sensitivity_to is for single runs: .*; call simulate"):
        ll.sweep(
            TOY, axes={"restitution": [0.5, 0.9]}, duration=1.0, initial_offset=0.3,
            sensitivity_to=["length"],
        )  # fmt: skip
