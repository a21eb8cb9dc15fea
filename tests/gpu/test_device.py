"""The CUDA executor with and without a device."""

import importlib
import importlib.util
import sys

import numpy as np
import pytest

import latolato as ll
from latolato.core.errors import InputError

if not importlib.util.find_spec("numba_cuda"):
    pytest.skip("needs numba-cuda, which has no packages for macOS", allow_module_level=True)

TOY = ll.LatoLato(length=1.0, mass=0.8, damping=0.02, radius=0.1, restitution=0.9)


def sweep(executor, **options):
    """Gentle motion against one wall: far from chaos, so that rounding stays rounding."""
    return ll.sweep(
        TOY,
        axes={
            "drive_amplitude": np.linspace(0.005, 0.02, 8),
            "frequency_ratio": np.linspace(0.3, 0.7, 8),
        },
        initial_offset=0.05,
        duration=10.0,
        observables=["mean_energy", "largest_angle", "bottom_contacts", "final_angle"],
        executor=executor,
        **options,
    )


def test_cuda_without_a_device_is_an_error(monkeypatch):
    monkeypatch.setattr("numba.cuda.is_available", lambda: False)

    with pytest.raises(InputError, match=r"needs an NVIDIA GPU.*executor='threads'"):
        sweep("cuda")


def test_missing_numba_cuda_names_the_extra(monkeypatch):
    monkeypatch.delitem(sys.modules, "latolato.sweeps.executors.cuda", raising=False)
    monkeypatch.setitem(sys.modules, "numba_cuda", None)

    with pytest.raises(InputError, match=r'pip install "\.\[cuda\]"'):
        importlib.import_module("latolato.sweeps.executors.cuda")


@pytest.mark.gpu
def test_cuda_agrees_with_threads_on_regular_motion():
    from numba import cuda

    if not cuda.is_available():
        pytest.skip("no CUDA device on this machine")
    expected = sweep("threads")

    result = sweep("cuda", chunk_size=16)

    np.testing.assert_array_equal(result.status, expected.status)
    np.testing.assert_array_equal(result.bottom_contacts, expected.bottom_contacts)
    # Multiply-adds are contracted in other places; ten seconds of bounces enlarge that a little.
    for name in ("mean_energy", "largest_angle", "final_angle"):
        np.testing.assert_allclose(result[name], expected[name], rtol=1e-9, atol=1e-10)
