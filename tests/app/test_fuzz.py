"""Whatever pages read, they answer with one of their own sentences and go on.

Addresses, parameters and tables go to one process of Node.js.
"""

from __future__ import annotations

import json
import math
import subprocess
from contextlib import suppress
from pathlib import Path
from urllib.parse import urlencode

import hypothesis
import pytest
from hypothesis import strategies as st

import latolato as ll
from in_node import NODE
from latolato.app.forms import registry
from latolato.core.errors import InputError
from trial_texts import parse_trials


@pytest.fixture(scope="module")
def page(site):
    """A function that sends one input to the pages' modules and returns what they made of it."""
    command = [NODE, Path(__file__).with_name("fuzz_in_node.mjs"), site]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stdout is not None

        def answer(kind, given):
            process.stdin.write(json.dumps(encoded([kind, given])) + "\n")
            process.stdin.flush()
            found = json.loads(process.stdout.readline())
            assert "fault" not in found, found["fault"]
            assert not found["polluted"]
            return found

        yield answer
        process.stdin.close()


def encoded(value):
    """A value whose numbers JSON can hold."""
    if isinstance(value, float) and not math.isfinite(value):
        return {"number": "NaN" if math.isnan(value) else "-Infinity" if value < 0 else "Infinity"}
    if isinstance(value, list):
        return [encoded(each) for each in value]
    if isinstance(value, dict):
        return {name: encoded(each) for name, each in value.items()}
    return value


POLLUTION = ("__proto__", "constructor", "toString", "hasOwnProperty", "prototype")
HTML = ("<img src=x onerror=alert(1)>", "</script><script>alert(1)</script>", "javascript:alert(1)")
ABOUT = registry()
LAWS = [*ABOUT["systems"], *ABOUT["drives"], *ABOUT["contact_laws"], *ABOUT["scenarios"]]
NAMES = st.sampled_from([*ABOUT["options"], *POLLUTION, *HTML, "", "map.x", "__proto__.x"])
SPOILED = (
    "NaN", "Infinity", "1e999", "-0", "0x10", "1e-400", "1_000", "3 constructor", "3 m/__proto__",
    "1 m^1e9", "m", "1,,2", "2 kg, 3", "9" * 5000,
)  # fmt: skip
UNITS = ("", " m", " cm", " s", " Hz", " rad", " %")
TEXTS = st.one_of(
    st.sampled_from([*LAWS, *POLLUTION, *HTML, *SPOILED]),
    st.builds("{:g}{}".format, st.floats(), st.sampled_from(UNITS)),
    st.text(max_size=20),
)
ANYTHING = st.recursive(
    st.one_of(st.none(), st.booleans(), st.floats(), st.integers(), TEXTS),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(NAMES, inner, max_size=3),
    max_leaves=6,
)
OPTIONS = st.dictionaries(NAMES, ANYTHING, max_size=6)
SCENARIOS = st.sampled_from([*ABOUT["scenarios"], *POLLUTION, *HTML])
many = hypothesis.settings(max_examples=200, deadline=None)


@hypothesis.given(pairs=st.lists(st.tuples(NAMES | st.sampled_from(["view", "scenario"]), TEXTS)))
@hypothesis.example(pairs=[(name, "a\nb") for name in ("view", "scenario", "system", "gravity")])
@hypothesis.example(pairs=[("a\nb", ""), ("a\nb.c", ""), ("restitution", "\n\u2028" * 300)])
@many
def test_no_address_makes_a_page_stumble_and_something_readable_remains(pairs, page):
    answer = page("address", "?" + urlencode(pairs, errors="replace"))
    assert answer["same"]
    assert "\n" not in answer["ended"]
    assert answer["known"]
    assert answer["again"] == 0
    assert all(len(line) < 400 and "\n" not in line for line in answer["lines"])


@hypothesis.given(scenario=st.none() | SCENARIOS, options=OPTIONS)
@many
def test_no_parameters_make_a_page_stumble(scenario, options, page):
    assert "\n" not in page("request", {"scenario": scenario, "options": options})["ended"]


TRIALS = """# gravity: 9.81 m/s^2
drive_amplitude,drive_frequency,length,class,note
0.02 m,15,0.2,none,"with, comma"
30 mm,2 Hz,0.2,strong,"a ""word"" here"
"""
COLUMNS = [*ABOUT["trials"]["columns"], *POLLUTION, "", '"', "note"]
CELLS = st.sampled_from([*SPOILED, *POLLUTION, "none", "weak", "0.02", '"', '"a', "# gravity: m"])
ROWS = st.lists(st.lists(CELLS | TEXTS, max_size=6).map(",".join), max_size=6)


def read_as_in_python(text, page):
    """Check that the page reads a table of trials where Python does, and else says why."""
    answer = page("trials", text)
    assert answer["sound"]
    assert "\n" not in answer["ended"]
    if "\0" in text:  # which NumPy drops at the end of a class
        return
    try:
        parse_trials(text.removeprefix("\ufeff"))
    except InputError:
        assert answer["ended"] != "read", text
    else:
        assert answer["ended"] == "read", text


@hypothesis.given(data=st.data())
@many
def test_no_spoiled_table_of_trials_makes_a_page_stumble(data, page):
    start = data.draw(st.integers(0, len(TRIALS)))
    end = data.draw(st.integers(start, min(start + 30, len(TRIALS))))
    words = st.sampled_from(
        [*SPOILED, *POLLUTION, *HTML, '"', '""', ",", "\n", "\r", "\0", "#", ""]
    )
    spoiled = TRIALS[:start] + data.draw(words | st.text(max_size=10)) + TRIALS[end:]
    read_as_in_python(spoiled, page)


@hypothesis.given(names=st.lists(st.sampled_from(COLUMNS), max_size=6), rows=ROWS)
@hypothesis.example(names=["drive_amplitude", "constructor"], rows=["1,1"])
@hypothesis.example(names=["drive_amplitude", "length", "class"], rows=["1,-1,weak"])
@many
def test_no_table_makes_a_page_stumble(names, rows, page):
    read_as_in_python("\n".join([",".join(names), *rows]), page)


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    """A stored run, as pages store it, and where to put spoiled ones."""
    path = tmp_path_factory.mktemp("stored") / "run.csv"
    ll.save(ll.load_scenario("zeno").simulate(duration=0.05), path)
    return path.read_bytes(), path


@hypothesis.given(data=st.data())
@hypothesis.settings(max_examples=100, deadline=None)
def test_no_spoiled_recording_makes_the_reader_stumble(data, recording):
    whole, path = recording
    start = data.draw(st.integers(0, len(whole)))
    end = data.draw(st.integers(start, min(start + 50, len(whole))))
    with_words = st.sampled_from(
        [b"nan", b"1e999", b"__proto__", b"\x00", b"\xff", b"\n", b",", b""]
    )
    path.write_bytes(whole[:start] + data.draw(with_words | st.binary(max_size=20)) + whole[end:])
    with suppress(InputError):
        ll.load(path)
