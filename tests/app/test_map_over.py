"""What pages draw over maps is what Python draws: curves of theory, trials, contour lines."""

from __future__ import annotations

import json
import math
import re
import subprocess
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import latolato as ll
from hanging import threshold_amplitude, tongue_edges
from in_node import NODE
from latolato.analysis import linear
from latolato.analysis.boundary import contour_lines
from latolato.app import CURVES, STATIC
from latolato.app.forms import registry
from latolato.core.errors import InputError
from latolato.experiment.trial_table import CLASSES, write_trials
from latolato.figures import overlays
from latolato.figures.overlays import AMPLITUDES, FREQUENCIES, Context
from latolato.io.analysis_tables import read_curves
from shipped_curves import SHIPPED
from trial_texts import parse_trials


def over_in_node(cases):
    """Return what pages make of cases, each with the ``name`` of what is asked for."""
    done = subprocess.run(
        [NODE, Path(__file__).with_name("over_in_node.mjs")],
        input=json.dumps({"registry": registry(), "cases": list(cases)}),
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def numbers(values):
    """Return numbers of which some are texts; `float` reads those of JavaScript too."""
    return np.array([float(value) for value in values])


def made(function, *given):
    """Return what a function returns, or what it refuses, as `over_in_node` says it."""
    try:
        with np.errstate(all="ignore"):
            return function(*given)
    except InputError as error:
        return {"error": str(error)}


def damping_of(zeta):
    return 2.0 * zeta  # of length, mass and gravity 1


def test_the_edges_of_the_tongue_are_those_of_hills_determinant():
    amplitudes = [1e-6, 0.003, 0.05, 0.3, 0.453, 0.455, 1.0, 2.2, 3.5, 3.79]
    cases = [(a, zeta) for a in amplitudes for zeta in (0.0, 1e-7, 1e-3, 0.02, 0.2, 0.7, 0.97)]
    # Little beyond where the damped tongue opens, and where it has ended.
    for zeta in (1e-3, 0.1, 0.5):
        tip = threshold_amplitude(
            frequency_ratio=2.0, length=1.0, mass=1.0, gravity=1.0, damping=damping_of(zeta)
        )
        cases += [(1.001 * tip, zeta), (0.9 * tip, zeta)]
    cases += [(0.0, 0.0), (0.0, 0.1), (3.9, 0.0), (3.9, 0.1)]
    pages = over_in_node([{"name": "edges", "q": 2.0 * a, "zeta": zeta} for a, zeta in cases])
    kinds = set()
    for (amplitude, zeta), found in zip(cases, pages, strict=True):
        wanted = tongue_edges(
            drive_amplitude=amplitude, length=1.0, mass=1.0, gravity=1.0, damping=damping_of(zeta)
        )
        # Both err by roundings, which grow where the tongue's lower edge rises to infinity.
        np.testing.assert_allclose(numbers(found), wanted, rtol=1e-12)
        kinds.add(tuple(np.isfinite(wanted)))
    assert kinds == {(True, True), (True, False), (False, False)}


LENGTH, MASS, DAMPING, GRAVITY = 0.3, 0.1, 0.02, 9.8
NATURAL = math.sqrt(GRAVITY / LENGTH)
SPANS = {
    "drive_amplitude": (0.0, 0.2), "amplitude_ratio": (0.01, 3.0),
    "drive_acceleration_ratio": (0.0, 4.0),
    "drive_frequency": (0.0, 25.0), "frequency_ratio": (0.4, 4.0),
}  # fmt: skip
ONE = {"length": LENGTH, "mass": MASS, "damping": DAMPING, "gravity": GRAVITY,
       "quadratic_damping": 0.0, "coulomb_damping": 0.0}  # fmt: skip
TWO = {"gravity": GRAVITY} | {
    f"{side}_{name}": value * factor
    for side, factor in (("right", 1.0), ("left", 1.1))
    for name, value in ONE.items()
    if name != "gravity"
}


def without(parameters, name):
    return {key: value for key, value in parameters.items() if key != name}


MAPS = [
    *((f, a, ONE, True) for f in FREQUENCIES for a in AMPLITUDES),
    *((a, f, ONE, True) for f in FREQUENCIES for a in AMPLITUDES),
    ("frequency_ratio", "drive_amplitude", TWO, True),
    ("frequency_ratio", "drive_amplitude", ONE, False),
    ("frequency_ratio", "drive_amplitude", ONE | {"damping": 0.0}, True),
    ("drive_frequency", "drive_amplitude", ONE | {"damping": 3.0}, True),
    ("frequency_ratio", "drive_amplitude", ONE | {"damping": 0.3}, True),
    ("frequency_ratio", "restitution", ONE, True),
    ("damping", "drive_amplitude", ONE, True),
    ("frequency_ratio", "drive_amplitude", without(ONE, "length"), True),
    ("frequency_ratio", "drive_amplitude", without(TWO, "right_mass"), True),
    ("frequency_ratio", "drive_amplitude", ONE | {"drag_frame": "lab"}, True),
    ("frequency_ratio", "drive_amplitude", ONE | {"drag_frame": "lab", "damping": 0.0}, True),
]  # fmt: skip


def grid_of(x, y, parameters, has_contact):
    """Return what a page knows of a map."""
    spans = [list(SPANS.get(name, (0.0, 1.0))) for name in (x, y)]
    return {
        "x": {"name": x, "edges": spans[0]}, "y": {"name": y, "edges": spans[1]},
        "about": {
            "parameters": parameters, "laws": parameters, "has_contact": bool(has_contact),
        },
    }  # fmt: skip


def context_of(x, y, parameters, has_contact):
    """Return what Python knows of a map."""
    contact = {"contact": "exact"} if has_contact else {}
    return Context.of(xr.Dataset(attrs=parameters | contact), x, y)


def curve_of(each, name):
    x, y, *_ = each
    return overlays.curve(context_of(*each), name, SPANS.get(x), SPANS.get(y))


# Python draws every seventh point of a tongue here, each by its slower formula.
EVERY = 7
# Where a damped tongue opens towards infinite frequencies, its edges there are roundings.
FAR = 1e3


@pytest.mark.parametrize("name", ["tongue", "lift_off"])
def test_curves_lie_where_python_draws_them_or_are_refused_alike(name, monkeypatch):
    every = EVERY if name == "tongue" else 1
    monkeypatch.setattr(overlays, "_SAMPLES", 1 + 399 // every)
    monkeypatch.setattr(linear, "tongue", cache(linear.tongue))
    pages = over_in_node([{"name": name, "grid": grid_of(*each)} for each in MAPS])
    refused = 0
    for each, found in zip(MAPS, pages, strict=True):
        wanted = made(curve_of, each, name)
        if isinstance(wanted, dict):
            assert found == wanted
            refused += 1
            continue
        assert found["name"] == {"lift_off": "lift"}.get(name, name)
        for values, expected in zip((found["xs"], found["ys"]), wanted, strict=True):
            ours = np.concatenate([part[::every] for part in np.split(numbers(values), 2)])
            both = np.minimum(np.stack([ours, expected]), FAR)
            np.testing.assert_allclose(*both, rtol=1e-7, atol=1e-12)
            # Only the tip of the tongue, in the middle, errs by the root of a rounding.
            count = both.shape[1]
            beside = np.abs(np.arange(count) - 0.5 * (count - 1)) > 1.0
            np.testing.assert_allclose(*both[:, beside], rtol=1e-10)
    assert refused == 6


TABLES = [
    "drive_amplitude,frequency_ratio,class\n100 mm,2,strong\n0.2,3,None\n90 cm,2,weak\n",
    "class, drive_frequency ,drive_amplitude\r\nweak,1.6 Hz,2 cm\r\n\r\nnone,100 deg/s,1 in\r\n",
    "\ufeff# gravity: 9.81\n# column x [m]: y\ndrive_amplitude,drive_frequency,length,class\n"
    "12 mm,10,24.5 cm,strong\n12 mm,10,,weak\n# in between\n12 mm,11,nan,weak\n",
    "# gravity: 3.7 m/s^2\ndrive_amplitude,frequency_ratio,length,class\n1 cm,2,20 cm,weak\n",
    'note,drive_amplitude,frequency_ratio,class\n"a, ""b""\nand c",1 cm,2,weak\n"",1 cm,2,none\n',
    "drive_amplitude,frequency_ratio,largest_angle,largest_angle_after_transient,swings,other\n"
    "0.1,2,95 deg,30 deg,4,x\n0.1,2,89 deg,45 deg,5,y\n0.1,2,44 deg,44 deg,6,\n0.1,2,2,2,3,z\n",
    "drive_amplitude,frequency_ratio,drive_frequency,class,set,largest_angle_sigma\n"
    "0.1,2,,weak,a,1 deg\n",
    "drive_amplitude,frequency_ratio,drive_frequency,class\n0.1,2,12,weak\n",
    "drive_amplitude [mm] ,frequency_ratio [1],length [cm],class\n12,2,,weak\n9,2,20,none\n",
    "drive_amplitude [kg],frequency_ratio,class\n0.1,2,weak\n",
    "drive_amplitude [mm],frequency_ratio,class\n1 cm,2,weak\n",
    "", "# only a comment", "a,b\n1,2\n", "\0\n,,,", "drive_amplitude,frequency_ratio,class\n",
    "drive_amplitude,frequency_ratio,class\n0.1,2\n",
    "drive_amplitude,frequency_ratio,class\n0.1,2,wild\n",
    "drive_amplitude,frequency_ratio,class\n0.1,2,\n",
    "drive_amplitude,frequency_ratio,class\n3 s,2,weak\n",
    "drive_amplitude,frequency_ratio,class\n0.1,2,weak\n0.1,2 Hz,weak\n",
    "drive_amplitude,frequency_ratio,class\n0.1,2,weak\n-0.1,2,weak\n",
    "drive_amplitude,frequency_ratio,class\n0.1,nan,weak\n",
    "drive_amplitude,frequency_ratio,class\n0.1,,weak\n0.1,2,weak\n",
    "drive_amplitude,frequency_ratio\n0.1,2\n", "class,frequency_ratio\nweak,2\n",
    "drive_amplitude,frequency_ratio,stabilised_angle\n0.1,2,3\n",
    "drive_amplitude,frequency_ratio,largest_angle,largest_angle_after_transient\n0.1,2,1,\n",
    "# gravity: heavy\ndrive_amplitude,frequency_ratio,class\n0.1,2,weak\n",
    "drive_amplitude,frequency_ratio,class,length\n0.1,2,weak,long\n",
    "drive_amplitude,frequency,class\n0.1,2,weak\n",
    "drive_amplitude;frequency_ratio;class\n0,1;2;weak\n",
]  # fmt: skip


@pytest.mark.parametrize("x", FREQUENCIES)
def test_trials_are_those_of_python_in_the_coordinates_of_the_map(x, tmp_path):
    written = write_trials(parse_trials(TABLES[5]), tmp_path / "trials.csv")
    texts = [*TABLES, written.read_text()]
    here = x, "amplitude_ratio", ONE, True
    pages = over_in_node([{"name": "trials", "text": t, "grid": grid_of(*here)} for t in texts])
    context = context_of(*here)
    read = 0
    for text, found in zip(texts, pages, strict=True):
        table = made(parse_trials, text.removeprefix("\ufeff"))
        if isinstance(table, dict):
            assert found == table
            continue
        read += 1
        ratio, plain = table.frequency_ratio.values, table.drive_frequency.values
        by_ratio = ratio * context.natural_frequency
        first, second = (plain, by_ratio) if x == "drive_frequency" else (by_ratio, plain)
        frequency = np.where(np.isfinite(first), first, second)
        places = np.array(context.place(table.drive_amplitude.values, frequency))
        ours = [numbers(found["trials"][key]) for key in ("xs", "ys")]
        np.testing.assert_allclose(ours, places, rtol=1e-14)
        kinds = [CLASSES.index(name) for name in table["class"].values]
        assert found["trials"]["kinds"] == kinds
        low, high = np.transpose([SPANS[x], SPANS["amplitude_ratio"]])[:, :, np.newaxis]
        assert found["outside"] == np.sum(((places < low) | (places > high)).any(axis=0))
    assert read == 10


def test_the_hint_of_the_page_names_the_columns_of_a_trial_table():
    texts = json.loads((STATIC / "languages" / "en.json").read_text(encoding="utf-8"))
    hint = texts["strings"]["mapTrialsHint"]
    named = re.search(r"\(columns (.+)\)", hint)[1]
    sample = {"drive_amplitude": "0.1", "class": "weak", "drive_frequency": "12"}
    names = re.split(r", and | or |, ", named)
    assert set(names) == {*sample, "frequency_ratio"}
    parse_trials(f"{','.join(sample)}\n{','.join(sample.values())}\n")


def test_trials_that_are_refused_name_the_trial_and_what_is_needed():
    head = "drive_amplitude,frequency_ratio,class\n"
    texts = {
        f"{head}0.1,2,weak\n1,2,0\n": "trial 2: class must be 'none', 'weak' or 'strong', got '0'",
        "a,b\n1,2\n": "largest_angle and largest_angle_after_transient",
        f"{head.replace(',', ';')}0,1;2;weak\n": "write numbers with a decimal point",
    }
    grid = grid_of("frequency_ratio", "drive_amplitude", ONE, True)
    found = over_in_node({"name": "trials", "text": text, "grid": grid} for text in texts)
    for answer, end in zip(found, texts.values(), strict=True):
        assert answer["error"].endswith(end)


PAIR = {
    "system": "latolato", "gravity": 9.8, "length": 0.245, "mass": 0.10644, "damping": 0.00506,
    "quadratic_damping": 0.0, "coulomb_damping": 0.0, "radius": 0.0196, "restitution": 0.9,
    "drive": "harmonic", "drive_phase": 1.0, "contact": "exact",
}  # fmt: skip
# Axes of maps, and how the laws of these differ from those of the shipped curves.
UNDER = [
    *(((f, a), {}) for f in FREQUENCIES for a in AMPLITUDES),
    *(((a, f), {}) for f in FREQUENCIES for a in AMPLITUDES),
    (("frequency_ratio", "drive_amplitude"), {"mass": 0.10644 * (1.0 + 1e-12)}),
    (("frequency_ratio", "drive_amplitude"), {"restitution": 0.85}),
    (("frequency_ratio", "drive_amplitude"), {"contact": "none"}),
    (("frequency_ratio", "drive_amplitude"), {"suspension": "string"}),
    (("frequency_ratio", "drive_amplitude"), {"drive": "crank_slider", "length": 0.3}),
    (("frequency_ratio", "drive_amplitude"), {"system": "pendulum"}),
    (("restitution", "drive_amplitude"), {"drive_frequency": 12.0}),
    (("initial_angle", "drive_amplitude"), {"drive_frequency": 12.0}),
]


def test_bifurcation_curves_lie_where_python_draws_them_or_are_refused_alike():
    text = (CURVES / "fig11.csv").read_text(encoding="utf-8")
    laws = [{**without(without(PAIR, x), y), **other} for (x, y), other in UNDER]
    grids = [grid_of(*sides, each, True) for (sides, _), each in zip(UNDER, laws, strict=True)]
    for grid, each in zip(grids, laws, strict=True):
        grid["about"]["laws"] = each
    pages = over_in_node({"name": "curves", "text": text, "grid": grid} for grid in grids)
    refused = []
    for (sides, _), each, found in zip(UNDER, laws, pages, strict=True):
        curves = read_curves(text)
        wanted = made(lambda e=each, s=sides, c=curves: [
            overlays.places_of(xr.Dataset(attrs=e), s, curve) for curve in c
        ])  # fmt: skip
        if isinstance(wanted, dict):
            assert found == wanted
            refused.append(wanted["error"])
            continue
        for drawn, places, curve in zip(found, wanted, curves, strict=True):
            np.testing.assert_allclose([drawn["xs"], drawn["ys"]], places, rtol=1e-14)
            assert drawn["kind"] == curve.attrs["bifurcation"]
            assert drawn["edges"] == curve.is_edge.values.astype(bool).tolist()
            assert drawn["words"] == curve.word.values.tolist()
            np.testing.assert_array_equal(np.ravel(drawn["angles"]), curve.initial_angle)
    assert len(refused) == 7
    assert "its restitution is 0.9, that of the map 0.85" in refused[0]
    assert "its suspension is rod, that of the map string" in refused[2]


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_curves_lie_over_the_map_of_their_scenario(name):
    text = (CURVES / f"{name}.csv").read_text(encoding="utf-8")
    axes = {"drive_amplitude": [0.01, 0.02], "frequency_ratio": [2.0, 3.0]}
    system = ll.load_scenario(name).system
    made = ll.sweep(system, axes=axes, initial_angle=0.3, duration=0.1)
    laws = {key: value for key, value in made.attrs.items() if isinstance(value, (str, int, float))}
    grid = grid_of("frequency_ratio", "drive_amplitude", laws, system.has_contacts)
    grid["about"]["laws"] = laws
    ((*found,),) = over_in_node([{"name": "curves", "text": text, "grid": grid}])
    for drawn, curve in zip(found, read_curves(text), strict=True):
        x, y = overlays.places_of(made, ("frequency_ratio", "drive_amplitude"), curve)
        np.testing.assert_array_equal([drawn["xs"], drawn["ys"]], [x, y])


def test_a_point_of_an_edge_says_whether_it_is_soft_or_steep():
    axes = {"drive_amplitude": [0.01, 0.02], "frequency_ratio": [2.0, 3.0]}
    system = ll.load_scenario("fig09").system
    made = ll.sweep(system, axes=axes, initial_angle=0.3, duration=0.1)
    laws = {key: value for key, value in made.attrs.items() if isinstance(value, (str, int, float))}
    grid = grid_of("frequency_ratio", "drive_amplitude", laws, False)
    text = (CURVES / "fig09.csv").read_text(encoding="utf-8")
    # Kinds of curves without it, and files of older versions, have no such column.
    older = text.replace("is_supercritical", "something_else")
    (left, right), (plain, _) = over_in_node(
        {"name": "curve_texts", "text": each, "grid": grid} for each in (text, older)
    )
    assert all("steep edge: the motion jumps" in each for each in left)
    assert all("soft edge: the new motion begins small" in each for each in right)
    assert not any(" edge" in each for each in plain)


# Two balls, of which each has a start, and special points on the way.
SPLIT = """\
# system: ballpair
# drive: harmonic
# bifurcation: fold
# period: 2
# analysis: bifurcation_curve
# parameters: ('drive_amplitude', 'frequency_ratio')

# over special
special,special_drive_amplitude [m],special_frequency_ratio,special_kind
0,0.02,1.5,cusp

# over point
point,drive_amplitude [m],frequency_ratio,largest_angle [rad],impacts,word,is_edge
0,0.01,1.0,1.2,2,BT,1
1,0.02,2.0,1.3,0,no contact,0

# over point, ball
point,ball,initial_angle [rad],initial_angular_velocity [rad/s]
0,0,0.1,1.0
0,1,-0.2,-2.0
1,0,0.3,3.0
1,1,-0.4,-4.0
"""


def test_a_curve_of_two_balls_has_a_start_for_each():
    laws = {"system": "ballpair", "drive": "harmonic"}
    grid = grid_of("drive_amplitude", "frequency_ratio", {}, True)
    grid["about"]["laws"] = laws
    ((found,),) = over_in_node([{"name": "curves", "text": SPLIT, "grid": grid}])
    assert found["angles"] == [[0.1, -0.2], [0.3, -0.4]]
    assert found["velocities"] == [[1.0, -2.0], [3.0, -4.0]]
    assert found["marks"] == [{"x": 0.02, "y": 1.5, "kind": "cusp", "mark": "v"}]
    (curve,) = read_curves(SPLIT)
    np.testing.assert_array_equal(curve.initial_angle, found["angles"])
    assert curve.initial_angle.dims == ("point", "ball")
    (missing,) = over_in_node(
        [{"name": "curves", "text": SPLIT.replace("word", "words"), "grid": grid}]
    )
    assert missing == {"error": "a bifurcation curve needs “word” in its table"}


def sides_of(lines):
    """Return the straight parts of lines, whatever their order and direction."""
    parts = [
        tuple(sorted([tuple(a), tuple(b)]))
        for line in lines
        for a, b in pairwise(np.round(line, 9) + 0.0)
    ]
    return sorted(parts)


def test_contour_lines_are_those_of_contourpy():
    random = np.random.default_rng(1)
    fields = []
    for k in range(300):
        shape = random.integers(2, 9, 2)
        # Whole numbers meet levels at points, where rules decide.
        values = random.integers(0, 4, shape).astype(float) if k % 2 else random.normal(size=shape)
        values[random.random(shape) < random.choice([0.0, 0.1, 0.3])] = np.nan
        fields.append((values, float(random.choice([0.0, 1.0, 2.0, 0.5, 0.3]))))
    y, x = np.mgrid[0:60, 0:80] / 8.0
    fields.append((np.sin(x) * np.cos(y) + 0.2 * np.sin(0.3 * x * y), 0.1))
    pages = over_in_node(
        {"name": "lines", "level": level, "width": values.shape[1],
         "values": [str(value) for value in values.ravel().tolist()]}
        for values, level in fields
    )  # fmt: skip
    closed = 0
    for (values, level), found in zip(fields, pages, strict=True):
        columns, rows = (np.arange(float(n)) for n in values.shape[::-1])
        wanted = contour_lines(columns, rows, values, level)
        assert len(found) == len(wanted)
        assert sides_of(found) == sides_of(wanted)
        closed += sum(line[0] == line[-1] for line in found)
    assert closed > 100
