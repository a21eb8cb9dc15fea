"""Kernels compile for a device that is not there: laws, observables and trajectories alike."""

import importlib.util
from types import SimpleNamespace

import numpy as np
import pytest

from latolato.core.errors import extra_command
from latolato.numerics.batch import make_progress
from latolato.numerics.callbacks import blank_slots
from latolato.sweeps.points import make_batch, stepper_of

if not importlib.util.find_spec("numba_cuda"):
    pytest.skip("needs numba-cuda, which has no packages for macOS", allow_module_level=True)

HOPPER = (9, 0)


@pytest.fixture(autouse=True)
def _no_device(monkeypatch):
    """Let numba-cuda take device functions as meant for Hopper where it would ask a device."""
    monkeypatch.setattr(
        "numba.cuda.dispatcher.get_current_device",
        lambda: SimpleNamespace(compute_capability=HOPPER),
    )


@pytest.fixture(autouse=True)
def _compiler():
    """Say what to install where CUDA's compiler libraries are missing."""
    import cuda.pathfinder as pathfinder

    for library in ("nvvm", "nvrtc"):
        try:
            pathfinder.load_nvidia_dynamic_lib(library)
        except pathfinder.DynamicLibNotFoundError:
            pytest.fail(f"CUDA's lib{library} is not installed; {extra_command('cuda')}")


def test_kernel_compiles_to_ptx_in_double_precision(plan):
    import numba
    from numba import cuda

    from latolato.sweeps.executors.cuda import device_kernel_of, kernel_arguments

    stepper = stepper_of(plan)
    batch = make_batch(plan, np.arange(plan.size))
    slots = blank_slots(plan.observables, plan.size * plan.system.angles)
    progress = make_progress(batch.states, slots.ravel())
    order = np.arange(plan.size)
    cancel = np.zeros(1, dtype=np.int64)
    arguments = (*kernel_arguments(batch, stepper, order, progress), cancel)
    kernel = device_kernel_of(plan)
    records = [a for a in arguments if isinstance(a, np.ndarray) and a.dtype.names]
    assert records
    assert all(a.dtype.isalignedstruct for a in records)  # others are read byte by byte

    ptx, _ = cuda.compile_ptx(
        kernel.py_func,
        tuple(numba.typeof(a) for a in arguments),
        device=False,
        cc=HOPPER,
        opt=False,  # faster; what is tested is that everything has a translation
    )

    assert ".target sm_90" in ptx
    assert ".visible .entry" in ptx
    assert "cvt.rn.f32" not in ptx  # NVIDIA's own functions compare high words as float32
