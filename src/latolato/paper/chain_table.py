"""Figures made through the chain, from a video to a number: a row for each clip or set of trials.

A row names its way through the chain, the module that computes and draws it: `chain_decay`,
`chain_motion`, `chain_map` or `chain_response`.
"""

from __future__ import annotations

import math
from functools import partial
from types import ModuleType

import numpy as np

from latolato import FrequencySchedule, Harmonic
from latolato.paper import chain_decay, chain_map, chain_motion, chain_response
from latolato.paper import systems as paper
from latolato.paper.chain import Clip
from latolato.paper.chain_trials import Trials
from latolato.paper.claim import Evidence


def _row(way: ModuleType, clip: Clip | Trials, *, title: str, caption: str) -> Evidence:
    """Return the figure that a way through the chain makes of a clip or of trials."""
    return Evidence(
        title=title,
        caption=caption,
        data=partial(way.data, clip, title),
        numbers=way.numbers,
        draw=way.draw,
        needs_video=True,
    )


def _scatter(low: float, high: float, *, sets: int, trials: int) -> list[tuple[float, ...]]:
    """Return frequency ratios of sets of trials, each up to 0.35 steps beside an even one."""
    random = np.random.default_rng(9)
    step = (high - low) / (trials - 1)
    even = np.linspace(low, high, trials)
    return [
        tuple((even + step * random.uniform(-0.35, 0.35, trials)).tolist()) for _ in range(sets)
    ]


_DEGREES_20 = (("initial_angle", math.radians(20.0)),)
# Paper: the amplitudes and starts of the trials are not printed.
_FIG9_AMPLITUDES = (0.012, 0.016, 0.020, 0.025, 0.030, 0.036)  # m
_FIG11_AMPLITUDES = (0.015, 0.020, 0.025, 0.030)  # m
_FIG12_START = 0.05  # rad above the low contact angle

FIGURES = {
    "fig07": _row(
        chain_decay,
        Clip(
            system=paper.SINGLE,
            start=_DEGREES_20,
            duration=40.0,
            size=(1280, 960),
            seed=7,
        ),
        title="Damping of the single pendulum, from a synthetic video",
        caption=(
            "A free decay from 20° with the printed l, m and C, rendered as a video, tracked and "
            "fitted. (a) A frame. (b) Angle, the full equation's fit, turning points and the "
            "envelope of eq13. (c) What the equation leaves."
        ),
    ),
    "fig08_chain": _row(
        chain_motion,
        Clip(
            system=paper.SINGLE,
            drive=Harmonic(
                drive_amplitude=paper.SINGLE_AMPLITUDE, drive_frequency=paper.SINGLE_FREQUENCY
            ),
            start=(("initial_angle", math.radians(2.0)),),
            duration=70.0,
            seed=8,
        ),
        title="The single pendulum, a synthetic experiment and its calculation",
        caption=(
            "A synthetic experiment with ω = 10.09 rad/s, A0 = "
            f"{1e3 * paper.SINGLE_AMPLITUDE:g} mm and a start at 2°, and the motion computed on "
            "the drive that is fitted to it: angles, their difference over twice the deviation "
            "that the fitted start leaves open, and the phase of one over the other."
        ),
    ),
    "fig09_chain": _row(
        chain_map,
        Trials(
            system=paper.SINGLE,
            sets=tuple(zip(_FIG9_AMPLITUDES, _scatter(1.80, 2.35, sets=6, trials=8), strict=True)),
            by_video=(2, 2, 1, 2, 2, 1),
            start=(("initial_angle", math.radians(10.0)),),
            duration=45.0,
            transient=30.0,
            sigmas=(("length", 5e-4), ("damping", 3e-5)),
        ),
        title="Synthetic trials of the single pendulum over the computed map",
        caption=(
            "Six sets of eight trials (A0 = 12 to 36 mm, a start at 10°, 45 s, the angle that "
            "lasts after 30 s), each a synthetic experiment with its drive fitted, classified and "
            "laid over the map of the same protocol. The white dashed line is the boundary between "
            "the trials. The agreement's interval allows for 0.5 mm of length and 3e-05 kg m/s of "
            "damping, the tracker's noise, and chance."
        ),
    ),
    "fig10": _row(
        chain_decay,
        Clip(
            system=paper.ONE_BALL,
            start=_DEGREES_20,
            duration=30.0,
            size=(1280, 960),
            scene=(
                ("ball_radius", paper.COUPLED.radius),
                ("parked_x", 0.8 * paper.ONE_BALL.length),
                ("parked_y", -0.45 * paper.ONE_BALL.length),
            ),
            seed=10,
        ),
        title="Damping of the coupled apparatus, from a synthetic video",
        caption=(
            "As Fig. 7 with l, m and C of the coupled apparatus; the other ball is parked aside, "
            "as in the paper's measurement."
        ),
    ),
    "fig11_chain": _row(
        chain_response,
        Trials(
            system=paper.COUPLED,
            sets=tuple((a, tuple(np.linspace(1.9, 3.1, 12).tolist())) for a in _FIG11_AMPLITUDES),
            by_video=(7, 6, 5, 4),
            start=(("initial_offset", 0.15),),
            duration=24.0,
            transient=16.0,
            fps=60.0,
            first_seed=100,
            sigmas=(("restitution", 0.005), ("damping", 5e-5)),
        ),
        title="Response curves of the colliding pair, synthetic trials and calculation",
        caption=(
            "Four sets of twelve trials (A0 = 15 to 30 mm, a start 0.15 rad above the wall, 24 s, "
            "the largest angle after 16 s), each a synthetic experiment, beside the computed "
            "curves (lines). Triangles: peaks with their deviation, that of the gap to the trial "
            "left of the cliff. Shaded: the paper's range."
        ),
    ),
    "fig12_chain": _row(
        chain_motion,
        Clip(
            system=paper.COUPLED,
            drive=FrequencySchedule(
                drive_amplitude=paper.COUPLED_AMPLITUDE,
                times=(0.0, paper.SWITCH_TIME),
                drive_frequencies=tuple(
                    ratio * paper.COUPLED.natural_frequency for ratio in paper.STAGE_RATIOS
                ),
            ),
            start=(("initial_offset", _FIG12_START),),
            duration=15.0,
            fps=60.0,
            seed=12,
        ),
        title="Stepping the frequency, a synthetic experiment and its calculation",
        caption=(
            f"A synthetic experiment with the stepped drive of Fig. 12, {paper.COUPLED_WORDS}, and "
            f"a start {_FIG12_START:g} rad above contact (from rest in contact the first hops are "
            "chaotic), and the motion computed on the drive that is fitted to it. The angle is "
            "half that between the balls."
        ),
    ),
}
