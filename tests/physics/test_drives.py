"""Laws that every drive obeys, and what each of them is in a limit."""

import dataclasses
import functools
import itertools
import math

import mpmath as mp
import numpy as np
import pytest
import scipy.interpolate

import latolato as ll
from latolato.numerics.records import segment_records
from latolato.numerics.run_record import as_objects
from latolato.physics.drives import PeriodicDrive, drives

END = 10.0


@functools.lru_cache(maxsize=8)
def pieces(drive, end=END):
    """(begin, end, numbers) of each smooth segment within [0, end]."""
    records = segment_records(drive, end)
    edges = [*records["start"], end]
    return [
        (max(a, 0.0), b, p)
        for a, b, p in zip(edges, edges[1:], as_objects(records), strict=False)
        if b > max(a, 0.0)
    ]


def motion(drive, t, end=END):
    """Height, velocity, acceleration at `t`, in the segment that begins last before it."""
    p = [p for a, _, p in pieces(drive, end) if a <= t][-1]
    return drive.height(t, p), drive.velocity(t, p), drive.acceleration(t, p)


def difference(function, t, h):
    """Central difference of order 6: its error is h^6/140 of the seventh derivative."""
    return (
        45.0 * (function(t + h) - function(t - h))
        - 9.0 * (function(t + 2 * h) - function(t - 2 * h))
        + (function(t + 3 * h) - function(t - 3 * h))
    ) / (60.0 * h)


@pytest.mark.parametrize(
    "names",
    [
        ("height", "velocity", "acceleration"),
        ("across", "across_velocity", "across_acceleration"),
    ],
)
def test_velocity_and_acceleration_are_derivatives(drive, names):
    # h = 2e-3 s at up to 15 rad/s: (w h)^7/140 < 1e-12, rounding eps/h = 1e-13 of the scale.
    h = 2e-3
    scale = max(drive.fastest_frequency, 1.0)
    place, velocity, acceleration = (getattr(drive, name) for name in names)
    for begin, end, p in pieces(drive):
        size = max(abs(place(t, p)) for t in np.linspace(begin, end, 50)) + 1e-3
        for t in np.linspace(begin, end, 23):
            slope = difference(lambda s, p=p: place(s, p), t, h)
            bend = difference(lambda s, p=p: velocity(s, p), t, h)
            assert velocity(t, p) == pytest.approx(slope, abs=1e-9 * size * scale)
            assert acceleration(t, p) == pytest.approx(bend, abs=1e-9 * size * scale**2)


def test_only_a_drive_that_moves_across_leaves_the_vertical(drive):
    sides = [drive.across(t, p) for a, b, p in pieces(drive) for t in np.linspace(a, b, 50)]
    assert any(sides) == drive.moves_across


def test_the_pivots_place_is_continuous_where_stretches_meet(drive):
    result = pieces(drive)
    for (_, end, p), (_, _, q) in itertools.pairwise(result):
        assert drive.height(end, p) == pytest.approx(drive.height(end, q), abs=1e-14)
        assert drive.across(end, p) == pytest.approx(drive.across(end, q), abs=1e-14)


def test_starts_increase_and_the_first_covers_time_zero(drive):
    starts = [segment.start for segment in drive.segments(END)]
    assert starts[0] <= 0.0
    assert all(b > a for a, b in itertools.pairwise(starts))
    assert all(start <= END for start in starts)


def test_acceleration_never_exceeds_its_declared_bound(drive):
    # Rest is taken to last for ever where the bound is below gravity: it must be a bound.
    largest = max(
        math.hypot(drive.acceleration(t, p), drive.across_acceleration(t, p))
        for begin, end, p in pieces(drive)
        for t in np.linspace(begin, end, 400)
    )
    assert largest <= drive.largest_acceleration * (1.0 + 1e-12)


def test_every_field_of_a_stretch_is_a_number(drive):
    for segment in drive.segments(END):
        assert all(isinstance(number, float) for number in segment)


def test_fastest_frequency_is_not_below_the_rate_of_the_motion(drive):
    if drive.fastest_frequency == 0.0:
        assert isinstance(drive, ll.FixedPivot)
        return
    heights = np.array([motion(drive, t)[0] for t in np.linspace(0.0, END, 4001)])
    turns = np.count_nonzero(np.diff(np.sign(np.diff(heights))))
    # Each period has two turning points; a factor two is spared for sampled motions.
    assert 2.0 * drive.fastest_frequency * END / math.pi >= turns


def test_a_periodic_drive_is_a_function_of_its_phase(drive):
    if not isinstance(drive, PeriodicDrive):
        return
    period = math.tau / drive.drive_frequency
    later = dataclasses.replace(drive, drive_phase=drive.drive_phase + math.pi / 2)
    for t in np.linspace(0.0, period, 23):
        height = motion(drive, t)[0]
        # Phases of some 10 rad are rounded to 1e-15.
        assert motion(drive, t + period)[0] == pytest.approx(height, abs=1e-14)
        assert motion(later, t + 0.75 * period)[0] == pytest.approx(height, abs=1e-14)
        if drive.is_cosine:
            cosine = math.cos(drive.drive_frequency * t + drive.drive_phase)
            assert height == pytest.approx(drive.drive_amplitude * cosine, abs=1e-14)


@pytest.mark.parametrize("name", [n for n in drives if n != "fixed_pivot"])
def test_zero_amplitude_is_a_pivot_at_rest(name):
    kind = drives[name]
    numbers = {
        "drive_amplitude": 0.0,
        "vertical_amplitude": 0.0,
        "horizontal_amplitude": 0.0,
        "drive_frequency": 5.0,
        "drive_frequency_final": 7.0,
        "sweep_time": 3.0,
        "connecting_rod_length": 0.1,
        "times": tuple(np.arange(0.0, 12.0)) if name == "measured_pivot" else (0.0, 1.0, 2.0),
        "drive_frequencies": (5.0, 3.0, 4.0),
        "drive_amplitudes": (0.0, 0.0, 0.0),
        "ramps": (0.1, 0.1, 0.1),
        "pivot_heights": (0.0,) * 12,
    }
    names = {f.name for f in dataclasses.fields(kind)}
    still = kind(**{k: v for k, v in numbers.items() if k in names})
    for t in np.linspace(0.0, END, 37):
        assert motion(still, t) == (0.0, 0.0, 0.0)
    assert still.largest_acceleration == 0.0


class TestHarmonic:
    def test_height_is_the_papers_cosine(self):
        drive = ll.Harmonic(drive_amplitude=0.2, drive_frequency=6.26, drive_phase=0.7)
        for t in (0.0, 0.3, 8.1):
            y, v, a = motion(drive, t)
            assert y == pytest.approx(0.2 * math.cos(6.26 * t + 0.7), abs=1e-15)
            assert v == pytest.approx(-0.2 * 6.26 * math.sin(6.26 * t + 0.7), abs=1e-14)
            assert a == pytest.approx(-0.2 * 6.26**2 * math.cos(6.26 * t + 0.7), abs=1e-13)


class TestPlanarHarmonic:
    def ellipse(self, **given):
        phases = {"vertical_phase": 0.7, "horizontal_phase": 2.5}
        sizes = {"vertical_amplitude": 0.02, "horizontal_amplitude": 0.03}
        return ll.PlanarHarmonic(drive_frequency=6.26, **{**phases, **sizes, **given})

    def test_both_directions_are_cosines_with_phases_of_their_own(self):
        drive = self.ellipse()
        (_, _, p), *others = pieces(drive)
        assert not others
        for t in (0.0, 0.3, 8.1):
            x, y = 6.26 * t + 2.5, 6.26 * t + 0.7
            result = [drive.across(t, p), drive.across_velocity(t, p)]
            # Phases of some 50 rad are rounded to 1e-14.
            assert result == pytest.approx([0.03 * math.cos(x), -0.1878 * math.sin(x)], abs=1e-14)
            assert motion(drive, t)[:2] == pytest.approx(
                [0.02 * math.cos(y), -0.1252 * math.sin(y)], abs=1e-14
            )

    @pytest.mark.parametrize("lead", [0.0, 0.4, 0.5 * math.pi, 2.0, math.pi])
    def test_the_bound_is_the_largest_acceleration_on_the_ellipse(self, lead):
        drive = self.ellipse(horizontal_phase=0.7 + lead)
        (_, _, p), *_ = pieces(drive)
        # At 2001 phases a maximum is missed by half a square of 2 pi/2000 in the phase.
        largest = max(
            math.hypot(drive.acceleration(t, p), drive.across_acceleration(t, p))
            for t in np.linspace(0.0, math.tau / 6.26, 2001)
        )
        assert drive.largest_acceleration == pytest.approx(largest, rel=1e-5)

    def test_without_a_horizontal_amplitude_it_is_the_harmonic_drive(self):
        drive = self.ellipse(horizontal_amplitude=0.0)
        same = ll.Harmonic(drive_amplitude=0.02, drive_frequency=6.26, drive_phase=0.7)
        assert drive.segments(END) == same.segments(END)
        assert drive.largest_acceleration == same.largest_acceleration == 0.02 * 6.26 * 6.26


class TestSwept:
    def test_frequency_at_an_instant_is_that_of_the_stage(self):
        drive = ll.FrequencySchedule(
            drive_amplitude=0.03, times=[0.0, 4.0], drive_frequencies=[19.83, 15.11], ramp=0.5
        )
        # The phase grows by the integral of the frequency: trapezoids are exact for a ramp.
        phase = 4.0 * 19.83 + 0.5 * (19.83 + 15.11) / 2.0 + 1.5 * 15.11
        assert motion(drive, 6.0)[0] == pytest.approx(0.03 * math.cos(phase), abs=1e-14)
        middle = 4.0 * 19.83 + 0.25 * (19.83 + (19.83 + 15.11) / 2.0) / 2.0
        y, v, _ = motion(drive, 4.25)
        assert y == pytest.approx(0.03 * math.cos(middle), abs=1e-14)
        assert v == pytest.approx(-0.03 * (19.83 + 15.11) / 2.0 * math.sin(middle), abs=1e-13)

    def test_step_without_ramp_keeps_the_phase(self):
        drive = ll.FrequencySchedule(
            drive_amplitude=0.03, times=[0.0, 4.166], drive_frequencies=[19.83, 15.11]
        )
        phase = 4.166 * 19.83 + (9.0 - 4.166) * 15.11
        assert motion(drive, 9.0)[0] == pytest.approx(0.03 * math.cos(phase), abs=1e-14)

    def test_one_stage_is_the_harmonic_drive(self):
        one = ll.FrequencySchedule(
            drive_amplitude=0.1, times=[0.0], drive_frequencies=[6.0], drive_phase=0.4
        )
        same = ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.0, drive_phase=0.4)
        for t in np.linspace(0.0, END, 29):
            assert motion(one, t) == pytest.approx(motion(same, t), abs=1e-13)

    def test_short_ramp_tends_to_the_step(self):
        arguments = {"drive_amplitude": 0.03, "times": [0.0, 2.0], "drive_frequencies": [9.0, 5.0]}
        step = ll.FrequencySchedule(**arguments)
        y = motion(step, 6.0)[0]
        gaps = [
            abs(motion(ll.FrequencySchedule(**arguments, ramp=ramp), 6.0)[0] - y)
            for ramp in (1e-2, 1e-3)
        ]
        # The phase differs by (9 - 5) ramp / 2.
        assert gaps[0] < 0.03 * 2.0 * 1e-2
        assert gaps[1] < 0.03 * 2.0 * 1e-3

    def test_chirp_is_a_schedule_with_one_long_ramp(self):
        chirp = ll.Chirp(
            drive_amplitude=0.02, drive_frequency=4.0, drive_frequency_final=9.0, sweep_time=5.0
        )
        y, v, _ = motion(chirp, 5.0 - 1e-12)
        phase = 5.0 * 6.5
        assert y == pytest.approx(0.02 * math.cos(phase), abs=1e-12)
        assert v == pytest.approx(-0.02 * 9.0 * math.sin(phase), abs=1e-10)
        assert motion(chirp, 7.0)[0] == pytest.approx(0.02 * math.cos(phase + 18.0), abs=1e-14)

    def test_transmitted_jump_is_the_pivots_velocity_jump(self):
        arguments = {
            "drive_amplitude": 0.03,
            "times": [0.0, 2.0, 5.0],
            "drive_frequencies": [9, 5, 8],
        }
        step = ll.FrequencySchedule(**arguments, step_impulse=True)
        result = pieces(step)
        for (_, end, p), (_, _, q) in itertools.pairwise(result):
            jump = step.velocity(end, q) - step.velocity(end, p)
            assert q.jump == pytest.approx(jump, abs=1e-13)
            assert q.jump != 0.0
        for unlike in ({}, {"ramp": 0.5, "step_impulse": True}):
            none = ll.FrequencySchedule(**arguments, **unlike)
            assert {segment.jump for segment in none.segments(END)} == {0.0}

    def test_starts_increase_where_a_ramp_fills_its_stage(self):
        # Rounding of start + ramp must not put a knot behind the next stage.
        rng = np.random.default_rng(3)
        for _ in range(300):
            times = np.cumsum(np.round(rng.uniform(0.1, 2.0, 4), 1)).round(1)
            times = [0.0, *map(float, times)]
            ramp = min(b - a for a, b in itertools.pairwise(times))
            drive = ll.FrequencySchedule(
                drive_amplitude=0.03,
                times=times,
                drive_frequencies=[5.0, 6.0, 4.0, 7.0, 5.0],
                ramp=ramp,
            )
            starts = [s.start for s in drive.segments(100.0)]
            assert all(b > a for a, b in itertools.pairwise(starts)), (times, ramp)


class TestStages:
    def test_one_stage_is_the_harmonic_drive(self):
        one = ll.StagedHarmonic(
            times=[0.0], drive_amplitudes=[0.1], drive_frequencies=[6.0], ramps=[1.0],
            drive_phase=0.4,
        )  # fmt: skip
        same = ll.Harmonic(drive_amplitude=0.1, drive_frequency=6.0, drive_phase=0.4)
        for t in np.linspace(0.0, END, 29):
            assert motion(one, t) == pytest.approx(motion(same, t), abs=1e-13)
        assert one.largest_acceleration == pytest.approx(same.largest_acceleration, rel=1e-14)

    def test_equal_amplitudes_are_a_frequency_schedule(self):
        times, rates = [0.0, 4.0, 7.0], [19.83, 15.11, 17.0]
        stages = ll.StagedHarmonic(
            times=times, drive_amplitudes=[0.03] * 3, drive_frequencies=rates, ramps=[0.5] * 3
        )
        same = ll.FrequencySchedule(
            drive_amplitude=0.03, times=times, drive_frequencies=rates, ramp=0.5
        )
        for t in np.linspace(0.0, END, 61):
            assert motion(stages, t) == pytest.approx(motion(same, t), abs=1e-12)

    def test_velocity_is_continuous_also_where_changes_overlap(self):
        stages = ll.StagedHarmonic(
            times=[0.0, 1.0, 1.1, 1.15],
            drive_amplitudes=[0.0, 0.04, 0.01, 0.05],
            drive_frequencies=[10.0, 20.0, 5.0, 12.0],
            ramps=[0.3, 0.3, 0.3, 0.3],
        )
        for (_, end, p), (_, _, q) in itertools.pairwise(pieces(stages)):
            assert stages.velocity(end, p) == pytest.approx(stages.velocity(end, q), abs=1e-13)

    def test_bound_covers_a_sudden_change_of_frequency_from_rest(self):
        # With phase pi/2 the acceleration is A phase'' = A 6/0.1 at first, and A 6^2 later.
        drive = ll.StagedHarmonic(
            times=(0.0, 1.0), drive_amplitudes=(0.1, 0.1001), drive_frequencies=(0.0, 6.0),
            ramps=(0.1, 0.1), drive_phase=0.5 * math.pi,
        )  # fmt: skip
        assert abs(motion(drive, 1.0 + 1e-9, 3.0)[2]) == pytest.approx(6.0, rel=0.05)
        assert drive.largest_acceleration >= 6.0

    def test_bound_covers_the_end_of_a_change_that_cuts_another_short(self):
        # At 6 s the amplitude is 0.5 m and grows by 0.15 m/s. The cubic from there to 0.8 m in
        # 3 s has no bend at first and ends with A'' = -2 0.15/3; the first change has 6/10^2.
        drive = ll.StagedHarmonic(
            times=(0.0, 1.0, 6.0), drive_amplitudes=(0.0, 1.0, 0.8),
            drive_frequencies=(0.0, 0.0, 0.0), ramps=(1.0, 10.0, 3.0),
        )  # fmt: skip
        assert motion(drive, 9.0 - 1e-9, 12.0)[2] == pytest.approx(-0.1, abs=1e-9)
        assert drive.largest_acceleration == pytest.approx(0.1, rel=1e-14)

    def test_a_stage_ends_with_its_amplitude_and_frequency(self):
        stages = ll.StagedHarmonic(
            times=[0.0, 2.0], drive_amplitudes=[0.01, 0.03], drive_frequencies=[9.0, 12.0],
            ramps=[0.1, 0.1],
        )  # fmt: skip
        phase = 2.0 * 9.0 + 0.1 * 10.5 + (5.0 - 2.1) * 12.0
        y, v, a = motion(stages, 5.0)
        assert y == pytest.approx(0.03 * math.cos(phase), abs=1e-14)
        assert v == pytest.approx(-0.03 * 12.0 * math.sin(phase), abs=1e-13)
        assert a == pytest.approx(-0.03 * 144.0 * math.cos(phase), abs=1e-12)

    def test_a_stage_without_a_frequency_is_refused(self):
        with pytest.raises(ValueError, match="drive_frequencies must hold at least 1 value"):
            ll.StagedHarmonic(
                times=[0.0], drive_amplitudes=[0.1], drive_frequencies=[], ramps=[1.0]
            )


class TestCrankSlider:
    def test_a_long_rod_makes_it_a_cosine(self):
        crank = ll.CrankSlider(drive_amplitude=0.1, drive_frequency=6.0, connecting_rod_length=1e6)
        assert crank.fastest_frequency == pytest.approx(6.0, rel=1e-6)
        assert 3.6 <= crank.largest_acceleration <= 1.02 * 3.6

    def test_a_rod_as_long_as_the_crank_has_strong_overtones(self):
        crank = ll.CrankSlider(drive_amplitude=0.6, drive_frequency=5.0, connecting_rod_length=1.0)
        assert crank.fastest_frequency == pytest.approx(5.0 / 0.8 * 1.6, rel=1e-14)

    @pytest.mark.parametrize("guide", ["below", "above"])
    def test_long_rod_is_harmonic(self, guide):
        same = ll.Harmonic(drive_amplitude=0.02, drive_frequency=15.0, drive_phase=0.3)
        for rod in (10.0, 1e3):
            crank = ll.CrankSlider(
                drive_amplitude=0.02,
                drive_frequency=15.0,
                drive_phase=0.3,
                connecting_rod_length=rod,
                guide=guide,
            )
            lam = 0.02 / rod
            gaps = [
                abs(motion(crank, t)[2] - motion(same, t)[2]) for t in np.linspace(0.0, 2.0, 200)
            ]
            # The overtone of the acceleration is lam of the whole (PHYSICS section 7).
            assert max(gaps) == pytest.approx(0.02 * 15.0**2 * lam, rel=0.02)

    @pytest.mark.parametrize("guide,side", [("below", -1), ("above", 1)])
    @pytest.mark.parametrize("lam", [0.1, 0.5, 0.95])
    def test_formulas_agree_with_mpmaths_derivatives(self, guide, side, lam):
        a, w, phase = 0.02, 15.0, 0.4
        rod = a / lam
        crank = ll.CrankSlider(
            drive_amplitude=a,
            drive_frequency=w,
            drive_phase=phase,
            connecting_rod_length=rod,
            guide=guide,
        )

        def height(t):
            p = w * t + phase
            root = mp.sqrt(mp.mpf(rod) ** 2 - mp.mpf(a) ** 2 * mp.sin(p) ** 2)
            return a * mp.cos(p) + side * (root - rod)

        with mp.workdps(40):
            for t in (0.0, 0.1, 0.234, 0.31):
                exact = [float(mp.diff(height, mp.mpf(t), n)) for n in (0, 1, 2)]
                result = motion(crank, t)
                size = crank.largest_acceleration
                for order, (mine, true) in enumerate(zip(result, exact, strict=True)):
                    assert mine == pytest.approx(true, abs=1e-13 * max(size / w ** (2 - order), a))

    @pytest.mark.parametrize("guide", ["below", "above"])
    def test_stroke_is_twice_the_crank(self, guide):
        crank = ll.CrankSlider(
            drive_amplitude=0.02, drive_frequency=2.0, connecting_rod_length=0.05, guide=guide
        )
        heights = [motion(crank, t)[0] for t in np.linspace(0.0, math.pi, 2001)]
        assert max(heights) == pytest.approx(0.02, abs=1e-12)
        assert min(heights) == pytest.approx(-0.02, abs=1e-8)

    def test_guide_below_lingers_at_the_top(self):
        # The piston below the crank has its larger acceleration at the bottom dead centre.
        crank = ll.CrankSlider(
            drive_amplitude=0.02, drive_frequency=2.0, connecting_rod_length=0.05, guide="below"
        )
        top, bottom = motion(crank, 0.0)[2], motion(crank, math.pi / 2.0)[2]
        assert abs(top) == pytest.approx(0.02 * 4.0 * (1.0 - 0.4), rel=1e-12)
        assert abs(bottom) == pytest.approx(0.02 * 4.0 * (1.0 + 0.4), rel=1e-12)

    @pytest.mark.parametrize("lam", [0.05, 0.3, 0.6, 0.8, 0.9, 0.99, 0.9999])
    def test_bound_holds_up_to_the_jamming_crank(self, lam):
        crank = ll.CrankSlider(
            drive_amplitude=0.02, drive_frequency=2.0, connecting_rod_length=0.02 / lam
        )
        (_, _, p), *_ = pieces(crank)
        largest = max(abs(crank.acceleration(t, p)) for t in np.linspace(0.0, math.pi, 20001))
        assert largest <= crank.largest_acceleration * (1.0 + 1e-12)


class TestMeasuredPivot:
    def sampled_cosine(self, rate, **arguments):
        times = np.arange(0.0, 5.0 + 0.5 / rate, 1.0 / rate)
        return ll.MeasuredPivot(times=times, pivot_heights=0.02 * np.cos(15.0 * times), **arguments)

    def test_the_fastest_frequency_is_that_of_a_cosine(self):
        assert self.sampled_cosine(120.0).fastest_frequency == pytest.approx(15.0, rel=0.02)

    def test_sampled_cosine_is_close_to_harmonic(self):
        # A quintic spline's second derivative is of order h^4: two rates differ by 16.
        same = ll.Harmonic(drive_amplitude=0.02, drive_frequency=15.0)
        gaps = []
        for rate in (120.0, 240.0):
            drive = self.sampled_cosine(rate)
            inner = np.linspace(1.0, 4.0, 301)
            gaps.append(max(abs(motion(drive, t, 5.0)[2] - motion(same, t, 5.0)[2]) for t in inner))
        assert gaps[0] < 1e-4 * 0.02 * 15.0**2
        assert gaps[0] / gaps[1] == pytest.approx(16.0, rel=0.2)

    def test_heights_pass_through_the_samples(self):
        drive = self.sampled_cosine(60.0)
        for t, y in zip(drive.times, drive.pivot_heights, strict=True):
            assert motion(drive, t, 5.0)[0] == pytest.approx(y, abs=1e-15)

    def test_acceleration_is_smooth_across_samples(self):
        drive = self.sampled_cosine(60.0)
        joints = pieces(drive, 5.0)
        for (_, end, p), (_, _, q) in itertools.pairwise(joints):
            assert drive.acceleration(end, p) == pytest.approx(drive.acceleration(end, q), abs=1e-9)

    def test_smoothing_takes_the_noise_away(self):
        rng = np.random.default_rng(1)
        times = np.arange(0.0, 5.0, 1.0 / 120.0)
        clean = 0.02 * np.cos(15.0 * times)
        noisy = clean + 1e-4 * rng.standard_normal(times.size)
        rough = ll.MeasuredPivot(times=times, pivot_heights=noisy)
        smooth = ll.MeasuredPivot(times=times, pivot_heights=noisy, height_sigma=1e-4)
        inner = np.linspace(1.0, 4.0, 301)

        def error(result):
            gaps = [motion(result, t, 4.9)[2] + 15.0**2 * 0.02 * math.cos(15.0 * t) for t in inner]
            return float(np.sqrt(np.mean(np.square(gaps))))

        assert error(smooth) < 0.05 * error(rough)
        residual = [motion(smooth, t, 4.9)[0] - y for t, y in zip(times[:-3], noisy, strict=False)]
        assert np.std(residual) == pytest.approx(1e-4, rel=0.1)

    @pytest.mark.parametrize("sigmas", [(0.0, 0.0), (1e-4, 2e-4), (0.0, 2e-4)])
    def test_both_directions_follow_splines_of_their_own(self, sigmas):
        rng = np.random.default_rng(2)
        times = np.arange(0.0, 5.01, 0.05)
        up = 0.02 * np.cos(9.0 * times) + 1e-4 * rng.standard_normal(times.size)
        across = 0.005 * np.sin(4.0 * times) + 2e-4 * rng.standard_normal(times.size)
        drive = ll.MeasuredPivot(
            times=times, pivot_heights=up, pivot_across=across,
            height_sigma=sigmas[0], across_sigma=sigmas[1],
        )  # fmt: skip
        assert drive.moves_across
        for values, sigma, names in (
            (up, sigmas[0], ("height", "velocity", "acceleration")),
            (across, sigmas[1], ("across", "across_velocity", "across_acceleration")),
        ):
            spline = scipy.interpolate.make_interp_spline(times, values, k=5)
            if sigma:
                weights = np.full(times.size, 1.0 / sigma)
                spline = scipy.interpolate.UnivariateSpline(times, values, w=weights, k=5)
            for a, b, p in pieces(drive, 5.0):
                for t in (a, 0.3 * a + 0.7 * b):
                    for order, name in enumerate(names):
                        exact = spline.derivative(order)(t) if order else spline(t)
                        # A coefficient of power k is rounded by eps of 1e-2 m/(0.05 s)^k.
                        assert getattr(drive, name)(t, p) == pytest.approx(
                            float(exact), abs=1e-14 * 20.0**order
                        )

    def test_heights_alone_leave_the_pivot_on_the_vertical(self):
        drive = self.sampled_cosine(60.0, pivot_across=None)
        assert not drive.moves_across
        assert not self.sampled_cosine(60.0, pivot_across=np.zeros(301)).moves_across

    def test_horizontal_positions_of_another_length_are_refused(self):
        with pytest.raises(ValueError, match="times and pivot_across must be of one length, got"):
            self.sampled_cosine(60.0, pivot_across=np.zeros(300))

    def test_noise_of_horizontal_positions_without_any_is_refused(self):
        with pytest.raises(ValueError, match="across_sigma is that of horizontal positions, and"):
            self.sampled_cosine(60.0, across_sigma=1e-3)

    @pytest.mark.parametrize("height", [0.0, 0.03])
    def test_the_fastest_frequency_on_an_ellipse_is_that_of_its_cosines(self, height):
        times = np.arange(601) / 120.0
        drive = ll.MeasuredPivot(
            times=times,
            pivot_heights=height * np.cos(15.0 * times),
            pivot_across=0.02 * np.sin(15.0 * times),
        )
        assert drive.fastest_frequency == pytest.approx(15.0, rel=0.02)

    def test_a_gap_across_which_the_curve_swings_far_out_is_named(self):
        # It leaves 1 s with 2 pi cm/s and comes back to the same motion at 6 s: 5.2 cm beyond the
        # heights, of whose range of 2 cm twice as much is allowed.
        times = np.concatenate([np.arange(21) / 20.0, 6.0 + np.arange(21) / 20.0])
        heights = 0.01 * np.sin(2.0 * math.pi * times)
        with pytest.raises(ValueError, match="leave a gap from 1 to 6 s in which the curve"):
            ll.MeasuredPivot(times=times, pivot_heights=heights)

    def test_run_outside_the_samples_is_refused(self):
        drive = self.sampled_cosine(60.0)
        with pytest.raises(ValueError, match="cover 0 to 5 s, but the run goes from 0 to 6 s"):
            drive.segments(6.0)
        late = ll.MeasuredPivot(times=np.arange(0.5, 6.0, 0.5), pivot_heights=[0.0] * 11)
        with pytest.raises(ValueError, match=r"cover 0\.5 to 5\.5 s, but the run goes"):
            late.segments(5.0)
