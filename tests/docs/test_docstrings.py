"""The examples of a file can be run alone."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize("name", ["analysis/floquet", "observables/period"])
def test_examples_of_one_file_are_collected_without_the_rest(name):
    command = [sys.executable, "-m", "pytest", "-q", "--collect-only", "--doctest-modules"]
    result = subprocess.run(
        [*command, "-p", "no:cacheprovider", f"src/latolato/{name}.py"],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert result.returncode in (0, 5), result.stdout  # 5: the file has no examples
