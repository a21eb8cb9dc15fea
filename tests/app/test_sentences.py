"""What pages say of a motion in sentences: it is what Python's run of it does."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.signal import find_peaks

import latolato as ll

# In real time and, as in slow motion, swing by swing. The chaotic run is Python's up to 15 s: later
# rounding decides.
RUNS = [
    (name, end, step)
    for name, end in {
        "toy": 20.0,
        "fig02": 120.0,
        "fig12": 30.0,
        "kapitza": 20.0,
        "chaos": 15.0,
        "zeno": 8.0,
        "ballpair_asymmetric": 30.0,
        "first_push": 20.0,
    }.items()
    for step in (3.0, 0.3)
]
# Sentences give whole degrees, or two digits of small angles.
ROUNDING = {"abs": 0.51, "rel": 0.06}


@pytest.fixture(scope="module")
def told(ask_node):
    """What is said of each run; Node.js is started once."""
    requests = [{"scenario": name, "end": end, "step": step} for name, end, step in RUNS]
    answers = ask_node("sentences_in_node.mjs", requests)
    return {run[::2]: answer for run, answer in zip(RUNS, answers, strict=True)}


class Seen:
    """What Python's run shows: contacts by kind and heights of swings, as (time, degrees)."""

    def __init__(self, name: str) -> None:
        self.run = ll.load_scenario(name).simulate()
        self.time = self.run.time.values
        angle = np.degrees(np.atleast_2d(self.run.angle.values))
        self.turned = angle
        self.away = np.abs((angle + 180.0) % 360.0 - 180.0)
        kinds = self.run.contact_kind.values if "contact" in self.run.sizes else np.array([])
        times = self.run.contact_time.values if kinds.size else np.array([])
        names = ["bottom", "top", "rest", "release"]
        self.contacts = {k: times[kinds == (k if kinds.dtype.kind in "UO" else i)]
                         for i, k in enumerate(names)}  # fmt: skip
        self.peaks = []
        for row, way in zip(self.away, np.diff(angle), strict=True):
            found = find_peaks(row)[0]
            found = found[way[found - 1] * way[found] <= 0]  # others pass the top
            left, middle, right = row[found - 1], row[found], row[found + 1]
            bend = left - 2 * middle + right
            self.peaks.append((self.time[found], middle - (right - left) ** 2 / (8 * bend)))

    def count(self, kind: str, start: float, stop: float) -> int:
        """Contacts of a kind after one instant, up to another one."""
        times = self.contacts[kind]
        return int(np.sum((times > start) & (times <= stop)))

    def heights(self, start: float, stop: float, ball: int | None = None) -> list[float]:
        """Peaks in a stretch, of one ball or of the one that swings highest."""
        each = [heights[(times > start) & (times <= stop)] for times, heights in self.peaks]
        if ball is not None:
            return list(each[ball])
        return list(max(each, key=lambda heights: heights.max(initial=0.0)))

    def passes_bottom(self, start: float, stop: float) -> np.ndarray:
        """Number of full turns from hanging at the samples of a stretch."""
        inside = (self.time > start) & (self.time <= stop)
        return np.floor(self.turned[0][inside] / 360.0)


def check(seen: Seen, each: dict) -> None:
    """Fail if a sentence is not true of what Python's run shows."""
    start, stop, values = each["from"], each["to"], each["values"]
    name, _, variant = each["name"].partition("_")
    below, above = seen.count("bottom", start, stop), seen.count("top", start, stop)
    if name == "tellFirst":
        assert seen.count(variant, start, stop) > 0
        assert seen.count(variant, -1.0, start) == 0
    elif name == "tellOnce":
        assert seen.count(variant, start, stop) > 0
    elif name == "tellInTurn":
        order = sorted([(t, k) for k in ("bottom", "top") for t in seen.contacts[k]
                        if start < t <= stop])  # fmt: skip
        assert all(one[1] != other[1] for one, other in pairwise(order))
        assert values["rate"] == f"{seen.run.attrs['drive_frequency'] / (2 * np.pi):.1f}"
    elif name == "tellMixed":
        assert (below, above) == (values["below"], values["above"])
    elif name == "tellRest":
        assert seen.count("rest", start, stop) > 0
        assert seen.contacts["rest"][seen.contacts["rest"] <= stop].max() > max(
            (t for t in seen.contacts["release"] if t <= stop), default=-1.0
        )
    elif name == "tellHang":
        assert below == above == seen.count("release", start, stop) == 0
    elif name == "tellRelease":
        assert seen.count("release", start, stop) > 0
    elif name == "tellCatches":
        assert seen.count("rest", start, stop) > 2
    elif name == "tellRattle":
        assert max(seen.heights(start, stop)) < np.degrees(seen.run.attrs["contact_angle_low"]) + 2
    elif name == "tellUpright":
        inside = (seen.time > start) & (seen.time <= stop)
        assert (180.0 - seen.away[0][inside]).max() <= values["angle"] + 0.1
    elif name in ("tellFirstTurn", "tellTumbles", "tellTurns"):
        turns = np.floor(seen.turned[0] / 360.0)
        begun = turns[seen.time <= start]
        assert len(set(begun[-1:]) | set(seen.passes_bottom(start, stop))) > 1
        if name == "tellFirstTurn":
            assert np.ptp(begun) <= 1  # back and forth over the lowest place
    elif name == "tellPeak":
        heights = seen.heights(-1.0, stop, 1 if variant == "left" else 0)
        assert float(values["angle"]) == pytest.approx(heights[-1], **ROUNDING)
    elif name == "tellDip":
        assert not seen.heights(start, stop)
    else:
        assert name in ("tellClack", "tellSwing")
        assert (below > 0) == (name == "tellClack")
        heights, pattern = seen.heights(start, stop), variant.split("_")[-1]
        steps = np.diff(heights)
        assert float(values["high"]) == pytest.approx(max(heights), **ROUNDING)
        assert float(values["low"]) == pytest.approx(min(heights), **ROUNDING)
        assert float(values["angle"]) == pytest.approx(heights[-1], **ROUNDING)
        close = 0.04 * max(heights) + 0.1
        if pattern == "steady":
            assert np.ptp(heights) <= close
        elif pattern == "grows":
            assert steps.min() > -close
            assert heights[-1] > heights[0]
        elif pattern == "dies":
            assert steps.max() < close
            assert heights[-1] < heights[0]
        else:
            assert np.ptp(heights) > 0.5 * close


@pytest.mark.parametrize("name", dict.fromkeys(name for name, _, _ in RUNS))
def test_every_sentence_is_true_of_the_run_of_python(told, name):
    seen = Seen(name)
    for step in (3.0, 0.3):
        said = told[name, step]["told"]
        assert said
        for each in said:
            try:
                check(seen, each)
            except AssertionError as error:
                raise AssertionError(f"{each['from']} s: {each['text']}") from error
    curve = told[name, 3.0]["curve"]
    if name == "chaos":
        return  # rounding decides where it goes
    angles = seen.turned
    if "contact_angle_low" in seen.run.attrs:
        angles = np.concatenate([angles, -angles])
    assert float(curve["values"]["high"]) == pytest.approx(angles.max(), **ROUNDING)
    assert float(curve["values"]["low"]) == pytest.approx(angles.min(), **ROUNDING)


def names_of(answer):
    return [each["name"] for each in answer["told"]]


def test_what_matters_in_a_motion_is_said(told):
    def said(name, step=3.0):
        return names_of(told[name, step])

    assert said("toy")[:2] == ["tellFirst_top", "tellInTurn"]
    assert said("fig02").count("tellSwing_ball_grows") > 10
    assert said("fig12")[0] == "tellRelease"
    assert said("fig12")[-1] == said("first_push")[-1] == "tellClack_steady"
    assert set(said("kapitza")) == {"tellUpright_ball"}
    assert said("zeno") == ["tellFirst_bottom", "tellRest_bottom"]
    # Described swing by swing, a run says how high each one goes.
    assert "tellPeak_both" in said("zeno", 0.3)
    assert {"tellPeak_right", "tellPeak_left"} <= set(said("ballpair_asymmetric", 0.3))


def test_only_chaos_has_no_pattern(told):
    wild = {name for (name, _), answer in told.items()
            if any(each.endswith("_wild") for each in names_of(answer))}  # fmt: skip
    assert wild <= {"chaos"}
    assert "tellFirstTurn_ball" in names_of(told["chaos", 3.0])


def test_a_start_is_told_with_the_hand_in_centimetres(told):
    answer = told["toy", 3.0]
    assert answer["start"]["name"] == "start_balls_shakes"
    assert answer["start"]["values"] == {"way": "6", "rate": "3.0"}
    assert [each["name"] for each in answer["places"]] == [
        "place_right_right", "place_left_left", "hand_above"]  # fmt: skip
    assert told["fig12", 3.0]["start"]["name"] == "start_balls_moves"
    assert told["zeno", 3.0]["start"]["name"] == "start_balls_still"
