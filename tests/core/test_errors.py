"""An error of input is made of its parts."""

import pickle

import numpy as np

from latolato.core.errors import InputError
from latolato.scenario.tables import ForeignParameterError


def test_a_name_in_a_value_stays_as_it_is():
    error = InputError("must be a number", parameter="length", value="{parameter}")
    assert str(error) == "length must be a number, got '{parameter}'"
    whole = InputError("Ball needs '{parameter}' [m]", parameter="length", way_out="give it")
    assert str(whole) == "Ball needs 'length' [m]; give it"
    assert whole.worded("the length") == "Ball needs 'the length' [m]; give it"


def test_values_of_numpy_are_written_as_pythons_own():
    texts = [
        str(InputError("must be less", parameter="mass", value=value))
        for value in (np.array([1.0, 2.0]), np.int64(3), np.float32(0.5), (1, np.float64(2.5)))
    ]
    ends = "[1.0, 2.0]", "3", "0.5", "(1, 2.5)"
    assert texts == [f"mass must be less, got {end}" for end in ends]


def test_its_parts_survive_a_process():
    error = ForeignParameterError("must be less", parameter="mass", value=2.0)
    error.where = "toy.toml"
    again = pickle.loads(pickle.dumps(error))
    assert vars(again) == vars(error)
    assert type(again) is ForeignParameterError
    assert str(again) == "toy.toml: mass must be less, got 2"
