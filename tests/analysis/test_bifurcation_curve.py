"""Curves of bifurcations in two parameters: closed forms, both sides, and ends that are said."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

import latolato as ll
from hanging import tongue_edges
from latolato.analysis.bifurcation_curve import _both_ways, bifurcation_curve
from latolato.analysis.conditions import Condition, Plane, Solution
from latolato.analysis.curve import Curve
from latolato.analysis.starts import hanging_angles
from latolato.core.errors import InputError

NATURAL = math.sqrt(9.8)
PENDULUM = ll.Pendulum(length=1.0, mass=0.8, damping=0.05)
TOY = ll.LatoLato(length=0.245, mass=0.106, damping=0.005, radius=0.02, restitution=0.85)


def shake(ratio, amplitude, system=PENDULUM):
    return ll.Harmonic(drive_amplitude=amplitude, drive_frequency=ratio * system.natural_frequency)


def hanging_tongue(**options):
    return bifurcation_curve(
        PENDULUM, shake(1.91, 0.05), kind="period_doubling",
        **({"low": (0.0, 1.7), "high": (0.2, 2.3)} | options),
    )  # fmt: skip


def test_hanging_still_doubles_its_period_along_the_tongue():
    curve = hanging_tongue()
    assert curve.status.item() == "complete"
    assert list(curve.end_reason.values) == ["end of range"] * 2
    for amplitude, ratio in zip(curve.drive_amplitude, curve.frequency_ratio, strict=True):
        edges = tongue_edges(drive_amplitude=float(amplitude), length=1.0, mass=0.8, damping=0.05)
        assert min(abs(float(ratio) - edge) for edge in edges) < 1e-8
    # The critical multiplier is minus one, and the other one is what damping leaves: an edge.
    assert np.abs(curve.multipliers.values + 1.0).min(axis=1).max() < 1e-9
    assert curve.is_edge.values.all()


def test_the_order_of_the_parameters_does_not_matter():
    one = hanging_tongue()
    other = hanging_tongue(
        parameters=("frequency_ratio", "drive_amplitude"), low=(1.7, 0.0), high=(2.3, 0.2)
    )
    amplitudes = np.linspace(0.02, 0.15, 5)
    for edge in (1, -1):
        ratios = []
        for curve in (one, other):
            side = curve.isel(point=np.flatnonzero(edge * (curve.frequency_ratio.values - 2.0) > 0))
            order = np.argsort(side.drive_amplitude.values)
            x, y = side.drive_amplitude.values[order], side.frequency_ratio.values[order]
            ratios.append(np.interp(amplitudes, x, y))
        # Both lines between points: their chords differ by what the curve bends between them.
        np.testing.assert_allclose(*ratios, atol=2e-3)


@pytest.mark.parametrize(
    "names",
    [("drive_acceleration_ratio", "frequency_ratio"), ("amplitude_ratio", "frequency_ratio")],
)
@pytest.mark.parametrize("turned", [False, True])
def test_ratios_of_both_parameters_are_set_in_the_order_in_which_they_depend(names, turned):
    low, high = {"frequency_ratio": 1.7}, {"frequency_ratio": 2.3}
    low[names[0]], high[names[0]] = 0.0, 0.8
    names = names[::-1] if turned else names
    curve = hanging_tongue(
        parameters=names, low=[low[n] for n in names], high=[high[n] for n in names], points=20
    )
    for i in range(0, 20, 4):
        ratio = float(curve.frequency_ratio[i])
        lifted = float(curve[names[turned]][i])
        amplitude = lifted / ratio**2 if "drive_acceleration_ratio" in names else lifted
        edges = tongue_edges(drive_amplitude=amplitude, length=1.0, mass=0.8, damping=0.05)
        assert min(abs(ratio - edge) for edge in edges) < 1e-8


def test_a_curve_that_begins_beyond_the_box_begins_at_its_border():
    # The doubling nearest to the start lies at a larger amplitude than the box allows.
    curve = bifurcation_curve(PENDULUM, shake(1.905, 0.05), low=(0.0, 1.7), high=(0.05, 2.3))
    assert curve.attrs["bifurcation"] == "period_doubling"  # by default the nearest
    assert curve.drive_amplitude.values.max() == pytest.approx(0.05, abs=1e-9)
    assert curve.drive_amplitude.values.max() <= 0.05 + 1e-12
    assert list(curve.end_reason.values) == ["end of range"] * 2
    assert curve.sizes["point"] > 20


@pytest.mark.parametrize("kind", ["fold", "period_doubling"])
def test_a_bouncing_ball_begins_and_doubles_as_on_a_flat_wall(kind):
    # One bounce a period, no drag, a fast drive: pi (1 - e)/(1 + e), and its flip, of g.
    def known(e):
        begins = math.pi * (1.0 - e) / (1.0 + e)
        flips = math.hypot(begins, 2.0 * (1.0 + e * e) / (1.0 + e) ** 2)
        return begins if kind == "fold" else flips

    ratio, restitution = 1e4, 0.8
    ball = ll.LatoLato(length=1.0, mass=0.8, radius=math.sin(0.1), restitution=restitution)
    w = ratio * NATURAL
    speed = 9.8 * math.sin(0.1) * math.pi / w  # of a bounce that lasts a drive period
    curve = bifurcation_curve(
        ball, ll.Harmonic(drive_amplitude=known(0.8) * 9.8 / w**2, drive_frequency=w), kind=kind,
        parameters=("restitution", "drive_acceleration_ratio"), low=(0.3, 0.05), high=(0.95, 3.0),
        initial_angle=ball.contact_angle_low + 1e-13,
        initial_angular_velocity=speed * (1.0 if kind == "fold" else 0.9),
    )  # fmt: skip
    assert list(curve.end_reason.values) == ["end of range"] * 2
    assert set(curve.word.values) == {"B"}
    expected = [known(e) for e in curve.restitution.values]
    # What the wall's bend leaves at this ratio.
    np.testing.assert_allclose(curve.drive_acceleration_ratio.values, expected, atol=5e-7)
    assert np.ptp(curve.restitution.values) == pytest.approx(0.65)


def swinging_fold(**options):
    return bifurcation_curve(
        PENDULUM, shake(1.0457, 0.05), period=2, initial_angle=2.195,
        initial_angular_velocity=2.518,
        **({"low": (0.0, 0.9), "high": (0.06, 2.3)} | options),
    )  # fmt: skip


def test_swings_begin_at_a_fold_that_merges_with_the_tongue():
    fold = swinging_fold()
    assert sorted(fold.end_reason.values) == ["end of range", "merges"]
    tip = {name: float(fold[name].values[int(np.argmin(fold.largest_angle.values))]) for name in
           ("drive_amplitude", "frequency_ratio", "largest_angle")}  # fmt: skip
    assert tip["largest_angle"] < 1e-3
    edges = tongue_edges(drive_amplitude=tip["drive_amplitude"], length=1.0, mass=0.8, damping=0.05)
    assert min(abs(tip["frequency_ratio"] - edge) for edge in edges) < 1e-6


def test_a_tongue_is_steep_on_the_left_and_soft_on_the_right_and_changes_where_swings_fold():
    tongue, fold = hanging_tongue(), swinging_fold()
    (flip,) = np.flatnonzero(tongue.special_kind.values == "generalised_flip")
    tip = int(np.argmin(fold.largest_angle.values))
    for name in ("drive_amplitude", "frequency_ratio"):
        # The fold meets the tongue along a tangent: the place is known to the root of an error.
        there = float(tongue[f"special_{name}"][flip])
        assert there == pytest.approx(float(fold[name][tip]), abs=3e-6)
    left = tongue.frequency_ratio.values < float(tongue.special_frequency_ratio[flip])
    np.testing.assert_array_equal(tongue.is_supercritical.values, ~left)
    # Runs just inside the tongue: the swing begins small at the soft edge, and jumps at the other.
    edges = tongue_edges(drive_amplitude=0.05, length=1.0, mass=0.8, damping=0.05)
    for inside, expected in ((edges[0] + 1e-3, False), (edges[1] - 1e-3, True)):
        drive = shake(inside, 0.05)
        times = np.linspace(1990.0, 2000.0, 1001) * math.tau / drive.drive_frequency
        late = ll.simulate(PENDULUM, drive, times=times, initial_angle=1e-3).angle.values
        assert (np.abs(late).max() < 0.3) == expected


def test_the_doubled_bounce_is_stable_where_its_curve_is_supercritical():
    box = {"low": (0.02, 4.0), "high": (0.04, 6.0), "points": 24}
    curve = bifurcation_curve(
        TOY, shake(4.73, 0.03, TOY), kind="period_doubling", initial_angle=0.0849,
        initial_angular_velocity=0.658, **box,
    )  # fmt: skip
    assert set(curve.is_supercritical.values) == {1}
    i = int(np.argmin(np.abs(curve.drive_amplitude.values - 0.03)))
    # Just inside, a run ends in a motion of two periods, near the one that doubled.
    for share in (1.001, 0.999):
        drive = shake(share * float(curve.frequency_ratio[i]), float(curve.drive_amplitude[i]), TOY)
        times = np.arange(1997, 2001) * math.tau / drive.drive_frequency
        late = ll.simulate(
            TOY, drive, times=times, initial_angle=float(curve.initial_angle[i]),
            initial_angular_velocity=1.001 * float(curve.initial_angular_velocity[i]),
        ).angular_velocity.values  # fmt: skip
        if abs(late[1] - late[0]) > 1e-4:
            break
    assert late[2:] == pytest.approx(late[:2], abs=1e-5)
    assert 1e-4 < abs(late[1] - late[0]) < 0.2


def test_swings_exist_on_one_side_of_their_fold_only():
    fold = swinging_fold()
    large = np.flatnonzero(fold.largest_angle.values > 0.3)  # smaller ones are nearly at the tongue
    for i in large[5:-1:25]:
        point = fold.isel(point=i)
        found = []
        for factor in (1.001, 0.999):
            drive = shake(float(point.frequency_ratio), factor * float(point.drive_amplitude))
            orbit = ll.analysis.floquet(
                PENDULUM, drive, period=2, initial_angle=float(point.initial_angle),
                initial_angular_velocity=float(point.initial_angular_velocity),
            )  # fmt: skip
            near = abs(float(orbit.initial_angle) - float(point.initial_angle)) < 0.3
            swings = abs(float(orbit.initial_angle)) > 1e-3
            found.append(orbit.status.item() != "not found" and near and swings)
        assert found == [True, False]


def bouncing_graze():
    return bifurcation_curve(
        TOY, shake(4.573, 0.03, TOY), kind="grazing", low=(0.01, 3.0), high=(0.08, 6.0),
        initial_angle=0.08174, initial_angular_velocity=0.0132,
    )  # fmt: skip


def test_a_bounce_grazes_the_wall_again_on_one_side_of_its_curve():
    graze = bouncing_graze()
    assert list(graze.end_reason.values) == ["end of range"] * 2
    assert set(graze.word.values) == {"B"}
    for i in range(3, graze.sizes["point"], 9):
        point = graze.isel(point=i)
        clearances = []
        for factor in (0.9999, 1.0, 1.0001):
            drive = shake(factor * float(point.frequency_ratio), float(point.drive_amplitude), TOY)
            period = math.tau / drive.drive_frequency
            run = ll.simulate(
                TOY, drive, initial_angle=float(point.initial_angle),
                initial_angular_velocity=float(point.initial_angular_velocity),
                times=np.linspace(0.0, period, 4001),
            )  # fmt: skip
            angle = run.angle.values
            inner = np.flatnonzero((angle[1:-1] <= angle[:-2]) & (angle[1:-1] <= angle[2:])) + 1
            clearances.append(np.sort(angle[inner] - TOY.contact_angle_low))
        # At the curve itself two approaches of the wall are closer than a millionth of a radian:
        # the bounce and the graze.
        assert clearances[1][0] < 1e-6


def test_a_ball_at_rest_lifts_off_where_the_pivot_falls_as_fast_as_it():
    curve = bifurcation_curve(
        TOY, shake(2.8, 0.03, TOY), kind="lift_off", low=(0.005, 1.0), high=(0.1, 8.0),
        initial_angle=TOY.contact_angle_low,
    )  # fmt: skip
    lifted = curve.drive_amplitude * (curve.frequency_ratio * TOY.natural_frequency) ** 2
    np.testing.assert_allclose(lifted.values, 9.8, rtol=1e-10)
    assert set(curve.word.values) == {"R"}


def test_dry_friction_holds_a_ball_longer():
    rough = ll.LatoLato(
        length=0.245, mass=0.106, radius=0.02, restitution=0.85, coulomb_damping=0.01
    )
    curve = bifurcation_curve(
        rough, shake(2.9, 0.035, rough), kind="lift_off", low=(0.005, 1.0), high=(0.1, 8.0),
        initial_angle=rough.contact_angle_low,
    )  # fmt: skip
    i = curve.sizes["point"] // 2
    start = ll.analysis.self_start(rough, float(curve.frequency_ratio[i]))
    assert float(curve.drive_amplitude[i]) == pytest.approx(float(start.drive_amplitude), rel=1e-6)


def test_two_different_balls_lift_off_together_or_swing_as_one_first():
    right = ll.Ball(length=0.245, mass=0.106, damping=0.005, radius=0.02)
    left = ll.Ball(length=0.24, mass=0.15, damping=0.004, radius=0.025)
    pair = ll.BallPair(right=right, left=left, restitution=0.85)
    curve = bifurcation_curve(
        pair, shake(2.8, 0.03, pair), kind="lift_off", low=(0.005, 1.0), high=(0.1, 8.0),
        initial_angle=hanging_angles(pair),
    )  # fmt: skip
    lifted = curve.drive_amplitude * (curve.frequency_ratio * pair.natural_frequency) ** 2
    np.testing.assert_allclose(lifted.values, 9.8, rtol=1e-10)
    assert set(curve.word.values) == {"R"}
    # In the tongue of their common swing rest ends there before, elsewhere at lift-off.
    assert {0, 1} == set(curve.is_edge.values)
    for i in range(5, curve.sizes["point"], 15):
        ratio, amplitude = float(curve.frequency_ratio[i]), float(curve.drive_amplitude[i])
        separations, swings = [], []
        for share in (0.999, 1.001):
            drive = shake(ratio, share * amplitude, pair)
            for push in (0.0, 1e-8):
                times = np.arange(41) * math.tau / drive.drive_frequency
                run = ll.simulate(
                    pair, drive, times=times, initial_angle=hanging_angles(pair),
                    initial_angular_velocity=(push, push),
                )  # fmt: skip
                right_angle, left_angle = run.angle.values
                apart = np.ptp(right_angle - left_angle)
                separations += [apart] if push == 0.0 else []
                swings += [np.ptp(right_angle[-3:])] if push and share < 1.0 else []
        assert separations[0] < 1e-12 < 1e-9 < separations[1]
        # A push of both dies out, or grows.
        assert (swings[0] < 1e-7) == bool(curve.is_edge[i])


def test_a_hanging_string_goes_slack_where_its_pivot_falls_freely():
    string = ll.Pendulum(length=1.0, mass=0.8, damping=0.05, suspension="string")
    curve = bifurcation_curve(
        string, shake(2.2, 0.2), kind="slack_onset", low=(0.05, 1.0), high=(0.5, 4.0)
    )
    lifted = curve.drive_amplitude * (curve.frequency_ratio * NATURAL) ** 2
    np.testing.assert_allclose(lifted.values, 9.8, rtol=1e-9)
    # It crosses the tongue, inside which hanging still is unstable.
    assert list(curve.special_kind.values) == ["meets_flip", "meets_flip"]
    for ratio, amplitude in zip(
        curve.special_frequency_ratio, curve.special_drive_amplitude, strict=True
    ):
        edges = tongue_edges(drive_amplitude=float(amplitude), length=1.0, mass=0.8, damping=0.05)
        assert min(abs(float(ratio) - edge) for edge in edges) < 1e-7


def test_a_swinging_string_first_goes_slack_at_the_horizontal():
    string = ll.Pendulum(length=1.0, mass=0.8, damping=0.05, suspension="string")
    curve = bifurcation_curve(
        string, shake(1.978, 0.197), kind="slack_onset", low=(0.1, 1.8), high=(0.3, 2.2), period=2,
        initial_angle=0.0484, initial_angular_velocity=4.393, points=20,
    )  # fmt: skip
    assert curve.sizes["point"] == 20
    np.testing.assert_allclose(curve.largest_angle, math.pi / 2, atol=1e-9)


def test_a_special_point_of_a_branch_is_where_a_curve_begins():
    drive = shake(1.85, 0.05)
    branch = ll.analysis.continue_orbit(PENDULUM, drive, low=1.8, high=2.2)
    curve = bifurcation_curve(
        PENDULUM, drive, at=branch.special[1], low=(0.0, 1.7), high=(0.2, 2.3), points=20
    )
    assert curve.attrs["bifurcation"] == "period_doubling"
    apart = np.abs(curve.frequency_ratio.values - float(branch.special_value[1]))
    i = int(np.argmin(apart + np.abs(curve.drive_amplitude.values - 0.05)))
    assert float(curve.drive_amplitude[i]) == pytest.approx(0.05, abs=1e-4)
    assert apart[i] < 1e-3
    with pytest.raises(InputError, match=r"must be a special point of continue_orbit"):
        bifurcation_curve(PENDULUM, drive, at=branch, low=(0.0, 1.7), high=(0.2, 2.3))
    # The range of frequencies changes no law, but another amplitude does, and so does another mass.
    other = ll.Pendulum(length=1.0, mass=0.9, damping=0.05)
    for system, shaken, message in (
        (PENDULUM, shake(2.1, 0.06), "whose drive_amplitude is 0.05, but here it is 0.06"),
        (other, drive, "whose mass is 0.8, but here it is 0.9"),
        (ll.Pendulum(length=1.0, mass=0.8, damping=0.05, suspension="string"), drive, "suspension"),
        (TOY, drive, "whose system is pendulum, but here it is latolato"),
    ):
        for analysis in (bifurcation_curve, ll.analysis.continue_orbit):
            pair = analysis is bifurcation_curve
            box = {"low": (0.0, 1.7), "high": (0.2, 2.3)} if pair else {"low": 1.7, "high": 2.3}
            with pytest.raises(InputError, match=message):
                analysis(system, shaken, at=branch.special[1], **box)


@pytest.mark.parametrize(
    "name, value",
    [("kind", "fold"), ("period", 2), ("initial_angle", 0.0), ("initial_angular_velocity", 0.1)],
)
def test_what_a_special_point_brings_is_not_given_beside_it(name, value):
    drive = shake(1.85, 0.05)
    branch = ll.analysis.continue_orbit(PENDULUM, drive, low=1.8, high=2.2, points=60)
    point, message = branch.special[0], f"{name} comes with the special point that at gives"
    with pytest.raises(InputError, match=message):
        bifurcation_curve(
            PENDULUM, drive, at=point, low=(0.0, 1.7), high=(0.2, 2.3), **{name: value}
        )
    if name != "kind":
        with pytest.raises(InputError, match=message):
            ll.analysis.continue_orbit(
                PENDULUM, drive, at=point, low=1.8, high=2.2, **{name: value}
            )


def test_ends_of_the_ranges_may_have_units(tmp_path):
    pint = pytest.importorskip("pint")
    unit = pint.UnitRegistry()
    box = {"low": (5 * unit.mm, 1.8), "high": (10 * unit.cm, 2.2), "points": 6}
    curve = hanging_tongue(**box)
    ll.save(curve, tmp_path / "curve.nc")
    stored = ll.load(tmp_path / "curve.nc")
    np.testing.assert_allclose(stored.attrs["low"], [0.005, 1.8], rtol=1e-15)
    np.testing.assert_allclose(stored.attrs["high"], [0.1, 2.2], rtol=1e-15)
    plain = hanging_tongue(low=(0.005, 1.8), high=(0.1, 2.2), points=6)
    np.testing.assert_array_equal(curve.drive_amplitude, plain.drive_amplitude)
    with pytest.raises(InputError, match="low \\(drive_amplitude\\) must be given in m"):
        hanging_tongue(**(box | {"low": (5 * unit.s, 1.8)}))


def test_two_equal_balls_double_their_period_as_their_mirror_image_does(tmp_path):
    ball = ll.Ball(length=0.245, mass=0.106, damping=0.005, radius=0.02)
    pair = ll.BallPair(right=ball, left=ball, restitution=0.85)
    box = {"low": (0.02, 4.0), "high": (0.04, 6.0), "points": 12}
    drive = shake(4.73, 0.03, TOY)
    branch = ll.analysis.continue_orbit(
        pair, drive, low=4.5, high=5.0, initial_angle=(0.0849, -0.0849),
        initial_angular_velocity=(0.658, -0.658),
    )  # fmt: skip
    ll.save(branch, tmp_path / "branch.nc")
    special = ll.load(tmp_path / "branch.nc").special[0]
    two = bifurcation_curve(pair, drive, at=special, **box)
    one = bifurcation_curve(
        TOY, drive, kind="period_doubling", initial_angle=0.0849, initial_angular_velocity=0.658,
        **box,
    )  # fmt: skip
    assert two.attrs["bifurcation"] == "period_doubling"
    order = np.argsort(one.drive_amplitude.values)
    x, y = one.drive_amplitude.values[order], one.frequency_ratio.values[order]
    inside = (two.drive_amplitude.values > x[0]) & (two.drive_amplitude.values < x[-1])
    assert inside.sum() > 3
    near = np.interp(two.drive_amplitude.values[inside], x, y)
    # Chords of a curve that bends between points.
    np.testing.assert_allclose(two.frequency_ratio.values[inside], near, atol=3e-3)
    angles = two.initial_angle.values
    np.testing.assert_allclose(angles[:, 0], -angles[:, 1], atol=1e-8)


def test_undamped_motions_are_neutral_on_both_sides_of_a_tongue():
    free = ll.Pendulum(length=1.0, mass=0.8)
    curve = bifurcation_curve(
        free, shake(1.9, 0.05), kind="period_doubling", low=(0.01, 1.7), high=(0.2, 1.99), points=40
    )
    assert curve.is_edge.values.all()
    # Without losses the other multiplier is minus one all along, which is no resonance.
    assert not curve.sizes["special"]


def test_a_second_doubling_is_told_with_its_period():
    drive = shake(2.2, 0.03, TOY)
    bounce = ll.analysis.continue_orbit(
        TOY, drive, low=0.5, high=6.0, initial_angle=0.3177, initial_angular_velocity=5.398
    )
    twice = ll.analysis.continue_orbit(
        TOY, drive, low=0.5, high=6.0, at=bounce.special[0], points=60
    )
    assert twice.attrs["period"] == 2
    curve = bifurcation_curve(
        TOY, drive, at=twice.special[0], low=(0.02, 4.5), high=(0.04, 6.0), points=10
    )
    assert curve.attrs["period"] == 2
    i = curve.sizes["point"] // 2
    orbit = ll.analysis.floquet(
        TOY, shake(float(curve.frequency_ratio[i]), float(curve.drive_amplitude[i]), TOY),
        period=curve.attrs["period"], initial_angle=float(curve.initial_angle[i]),
        initial_angular_velocity=float(curve.initial_angular_velocity[i]),
    )  # fmt: skip
    assert np.min(np.abs(orbit.multipliers.values + 1.0)) < 1e-6


def test_a_point_that_no_curve_follows_is_refused():
    branch = ll.analysis.continue_orbit(
        TOY, shake(2.7, 0.03, TOY), low=2.5, high=3.0, initial_offset=0.0, points=30
    )
    assert list(branch.special_kind.values) == ["lift_off"]
    other = branch.special[0].assign_coords(special_kind="rest_ends")
    with pytest.raises(InputError, match="is of the kind rest_ends, which no curve follows"):
        bifurcation_curve(TOY, shake(2.7, 0.03, TOY), at=other, low=(0.0, 1.0), high=(0.1, 6.0))


@pytest.mark.filterwarnings("error")
def test_from_far_away_the_curve_is_that_of_the_bifurcation_which_the_motion_meets_first():
    box = {"low": (0.0, 1.4), "high": (0.4, 3.2)}
    inside = ll.load_scenario("fig02")  # of the tongue, at ratio 2
    tongue = bifurcation_curve(inside.system, inside.drive, points=60, **box)
    assert tongue.attrs["bifurcation"] == "period_doubling"
    for amplitude, ratio in zip(
        tongue.drive_amplitude[::9], tongue.frequency_ratio[::9], strict=True
    ):
        edges = ll.analysis.tongue_edges(inside.system, drive_amplitude=float(amplitude))
        assert np.min(np.abs([edges.low - ratio, edges.high - ratio])) < 1e-8
    upright = ll.load_scenario("kapitza")
    box = {"low": (0.0, 10.7), "high": (0.08, 32.1)}
    start = {"initial_angle": np.radians(160.0)}
    kapitza = bifurcation_curve(upright.system, upright.drive, points=60, **box, **start)
    assert kapitza.attrs["bifurcation"] == "symmetry_breaking"
    for amplitude, ratio in zip(
        kapitza.drive_amplitude[::9], kapitza.frequency_ratio[::9], strict=True
    ):
        limits = ll.analysis.inverted_limits(upright.system, frequency_ratio=float(ratio))
        assert abs(limits.low.item() - amplitude) < 1e-8


def test_from_a_start_that_runs_away_the_motion_is_that_of_the_run():
    toy = ll.load_scenario("toy")
    curve = bifurcation_curve(
        toy.system, toy.drive, low=(0.0, 1.4), high=(0.09, 3.2), points=20,
        initial_angle=toy.run["initial_angle"],
    )  # fmt: skip
    assert curve.attrs["bifurcation"] == "period_doubling"
    assert curve.largest_angle.min() > 2.5  # it swings to the top, as the toy does
    # It says so, and where the curve begins; the laws are those that were given.
    message = curve.attrs["message"]
    assert message.startswith("no bifurcation was found near drive_amplitude = 0.06 m, ")
    assert "the motion in which the run from the guess settles meets at" in message
    assert curve.attrs["drive_amplitude"] == toy.drive.drive_amplitude


def test_a_string_goes_slack_where_the_motion_near_the_guess_meets_that():
    system = ll.Pendulum(length=0.3, mass=0.1, damping=0.02, suspension="string")
    drive = ll.Harmonic(drive_amplitude=0.0201, drive_frequency=1.9 * system.natural_frequency)
    curve = bifurcation_curve(
        system, drive, kind="slack_onset", parameters=("amplitude_ratio", "frequency_ratio"),
        low=(0.01, 1.7), high=(0.4, 2.2), points=10,
    )  # fmt: skip
    assert curve.attrs["bifurcation"] == "slack_onset"
    assert curve.sizes["point"] == 10
    assert "no slack onset was found near amplitude_ratio = 0.067" in curve.attrs["message"]
    # The ball hangs still: its string goes slack where the drive accelerates as gravity does.
    assert np.abs(curve.largest_angle).max() < 1e-12
    np.testing.assert_allclose(curve.amplitude_ratio * curve.frequency_ratio**2, 1.0, atol=1e-9)


@pytest.mark.parametrize("kind", ["fold", None])
def test_no_bifurcation_near_a_start_is_said(kind):
    why = f"no {kind or 'bifurcation'} of a motion of one drive period was found"
    with pytest.warns(RuntimeWarning, match=why):
        curve = bifurcation_curve(
            TOY, shake(2.2, 0.03, TOY), kind=kind, low=(0.029, 2.19), high=(0.031, 2.21),
            initial_angle=0.3177, initial_angular_velocity=5.398,
        )  # fmt: skip
    assert curve.status.item() == "not found"
    assert curve.sizes["point"] == 0


def test_a_fold_asked_for_where_a_symmetry_breaks_is_singular():
    box = {"low": (0.05, 0.5), "high": (0.5, 1.5)}
    why = (
        "no fold was found near drive_amplitude = 0.2955 m, frequency_ratio = 0.9897, where "
        "symmetry breaking is the nearest bifurcation of the motion: choose that as kind"
    )
    with pytest.warns(RuntimeWarning, match=why):
        curve = bifurcation_curve(PENDULUM, shake(0.9897, 0.2955), kind="fold", **box)
    assert curve.status.item() in ("singular", "not found")
    broken = bifurcation_curve(PENDULUM, shake(0.9897, 0.2955), **box)
    assert broken.attrs["bifurcation"] == "symmetry_breaking"
    assert broken.status.item() == "complete"
    assert np.abs(broken.multipliers.values + 1.0).min(axis=1).max() < 1e-9


class Circle(Condition):
    """Both parameters lie on a circle, whatever the motion."""

    def __init__(self):
        self.plane = Plane(None, ("drive_amplitude", "frequency_ratio"), -np.ones(2), np.ones(2))
        self.measure = np.ones(1)

    def at(self, unknowns):
        state, values = unknowns[:1], unknowns[1:] * self.plane.width
        residual = np.append(state, values @ values - 0.25)
        passage = SimpleNamespace(slack_time=math.inf, impacts=0)
        return Solution(residual, None, state, 0.0, passage, np.eye(1), values)

    def tests(self, solution):
        return {"resonance_1_1": float(solution.values[0])}

    def others(self, solution):
        return np.zeros(0, dtype=complex)

    def duration(self, flow):
        return 1.0

    def size_of(self, solution):
        return self.measure


@pytest.mark.parametrize("most, is_closed", [(200, True), (40, False)])
def test_a_curve_that_closes_is_followed_once_round(most, is_closed):
    curve = Curve(Circle())
    first = curve.begin(np.array([0.0, 0.25, 0.01]))
    points, specials, ends = _both_ways(curve, first, most, None)
    values = np.array([each.solution.values for each in points])
    np.testing.assert_allclose(np.linalg.norm(values, axis=1), 0.5, atol=1e-9)
    turned = np.ptp(np.unwrap(np.arctan2(values[:, 1], values[:, 0])))
    assert ends == (["closed"] * 2 if is_closed else ["point limit"] * 2)
    assert (0.95 * math.tau < turned < 1.05 * math.tau) == is_closed
    # Both parameters turn back at no point, and one vanishes at two.
    assert [each.kind for each in specials] == ["resonance_1_1"] * (2 if is_closed else 0)


def test_a_curve_can_be_stopped_and_keeps_what_it_has():
    def stop(share):
        if share > 0.1:
            raise KeyboardInterrupt

    curve = hanging_tongue(progress=stop)
    assert curve.status.item() == "interrupted"
    assert 10 < curve.sizes["point"] < 40


@pytest.mark.parametrize(
    "options, message",
    [
        ({"parameters": ("drive_amplitude",)}, "must be two parameters"),
        ({"parameters": ("frequency_ratio", "drive_frequency")}, "must be two parameters"),
        ({"parameters": ("drive_amplitud", "frequency_ratio")}, "did you mean"),
        ({"parameters": None}, "must be two parameters"),
        ({"low": (0.06, 1.7)}, "must enclose the drive_amplitude"),
        ({"low": (0.3, 1.7)}, "low must be less than high for drive_amplitude, got 0.3"),
        ({"low": (0.0,)}, "must be a value for each of both"),
        ({"kind": "grazing"}, "needs balls that can touch"),
        ({"kind": "slack_onset"}, "needs strings"),
        ({"kind": "folds"}, "kind"),
    ],
)
def test_bad_input_is_refused_with_the_reason(options, message):
    with pytest.raises(InputError, match=message):
        hanging_tongue(**options) if "kind" not in options else bifurcation_curve(
            PENDULUM, shake(1.91, 0.05), low=(0.0, 1.7), high=(0.2, 2.3), **options
        )
