"""Blocks of arrays survive the way to the page."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays_of

from latolato.app.blocks import TYPES, pack
from page_blocks import unpack

SHAPES = arrays_of.array_shapes(min_dims=1, max_dims=3, min_side=0, max_side=5)
ARRAYS = st.dictionaries(
    st.text(min_size=1, max_size=8),
    st.sampled_from(TYPES).flatmap(lambda kind: arrays_of.arrays(np.dtype(kind), SHAPES)),
    max_size=4,
)


@given(ARRAYS, st.dictionaries(st.text(max_size=5), st.integers() | st.text(max_size=5)))
def test_what_is_packed_is_unpacked(arrays, about):
    about.pop("arrays", None)
    block = pack(about, arrays)
    assert len(block) % 8 == 0
    found_about, result = unpack(block)
    assert found_about == about
    assert result.keys() == arrays.keys()
    for name, values in arrays.items():
        assert result[name].dtype == values.dtype
        np.testing.assert_array_equal(result[name], values)


@given(
    st.floats(-1e6, 1e6), st.floats(1e-6, 1e6), st.integers(3, 3000), st.sampled_from([0, 1, -1])
)
def test_evenly_spaced_numbers_are_sent_as_their_ends(first, width, count, broken):
    times = np.linspace(first, first + width, count)
    if broken:
        times[1] = np.nextafter(times[1], broken * np.inf)
    block = pack({}, {"time": times})
    np.testing.assert_array_equal(unpack(block)[1]["time"], times)
    assert (b'"even"' in block) == (not broken)


def test_numbers_that_json_lacks_become_null():
    about, _ = unpack(pack({"worst": float("nan"), "all": [np.float64(1.0), np.inf]}, {}))
    assert about == {"worst": None, "all": [1.0, None]}


def test_an_array_that_pages_cannot_read_is_refused():
    with pytest.raises(ValueError, match="angle is of type complex128"):
        pack({}, {"angle": np.array([1j])})
