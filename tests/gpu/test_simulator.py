"""The CUDA executor equals the reference in numba's simulator, which runs kernels as Python."""

import importlib.util
import os
import pickle
import subprocess
import sys

import numpy as np
import pytest

from latolato.sweeps import run_plan

if not importlib.util.find_spec("numba_cuda"):
    pytest.skip("needs numba-cuda, which has no packages for macOS", allow_module_level=True)

# The simulator is chosen when numba is imported, so it needs a process of its own.
CHILD = """
import pickle, sys
from latolato.sweeps import run_plan
plan = pickle.load(sys.stdin.buffer)
grid = run_plan(plan, executor="cuda")
pickle.dump({name: a.values for name, a in grid.data_vars.items()}, sys.stdout.buffer)
"""


def test_cuda_in_the_simulator_equals_the_reference(plan):
    expected = run_plan(plan, executor="reference")

    child = subprocess.run(
        [sys.executable, "-c", CHILD],
        input=pickle.dumps(plan),
        capture_output=True,
        env=os.environ | {"NUMBA_ENABLE_CUDASIM": "1"},
        check=False,
    )

    assert child.returncode == 0, child.stderr.decode()
    result = pickle.loads(child.stdout)
    assert result.keys() == set(expected.data_vars)
    for name, values in result.items():  # the same operations in the same order: to the last bit
        np.testing.assert_array_equal(values, expected[name].values, err_msg=name)
