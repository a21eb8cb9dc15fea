"""The Dask executor: the numbers of threads, on clusters that lose workers, or are not there."""

import importlib
import os
import signal
import sys
import time

import distributed
import numpy as np
import pytest

import latolato as ll
from latolato.core.errors import InputError
from latolato.sweeps import run_plan
from latolato.sweeps.executors.dask import execute
from latolato.sweeps.labels import Memory
from latolato.sweeps.plan import make_plan

LOCAL = {"threads_per_worker": 1, "host": "127.0.0.1", "dashboard_address": "127.0.0.1:0"}
EXECUTOR = importlib.import_module("latolato.sweeps.executors.dask")


@pytest.fixture(scope="module")
def client():
    """A cluster of two processes that every test may hurt: it starts new ones."""
    with (
        distributed.LocalCluster(n_workers=2, **LOCAL) as cluster,
        distributed.Client(cluster, set_as_default=False) as connected,
    ):
        yield connected


@pytest.fixture(scope="module")
def plan():
    """60 points of which some are chaotic, in 12 chunks."""
    return make_plan(
        ll.LatoLato(length=1.0, mass=0.8, damping=0.02, radius=0.1, restitution=0.9),
        axes={
            "drive_amplitude": np.linspace(0.0, 0.5, 12),
            "frequency_ratio": np.linspace(0.5, 4.0, 5),
        },
        initial_offset=0.2,
        duration=600.0,
        observables=["mean_energy", "bottom_contacts", "final_angle"],
        chunk_size=5,
    )


@pytest.fixture(scope="module")
def expected(plan):
    """What threads find; this compiles the kernel, which workers then load."""
    return run_plan(plan, executor="threads")


def test_results_are_those_of_threads_bit_by_bit(client, plan, expected):
    result = run_plan(plan, executor="dask", client=client)

    assert result.identical(expected)


def test_address_serves_as_client(client, plan, expected):
    result = run_plan(plan, executor="dask", client=client.scheduler.address)

    assert result.identical(expected)
    assert client.status == "running"


def test_cluster_of_its_own_is_started_and_closed(plan, expected):
    result = run_plan(plan, executor="dask", workers=1)

    assert result.identical(expected)


def test_killed_worker_is_survived(client, plan, expected):
    victim = next(iter(client.run(os.getpid).values()))
    results = Memory(plan, "compiled")
    came = []

    for number, (values, reason) in execute(plan, range(plan.chunks), client=client):
        if not came:
            os.kill(victim, getattr(signal, "SIGKILL", signal.SIGTERM))
        came.append(number)
        results.write(number, values, reason)

    assert victim not in client.run(os.getpid, on_error="return").values()
    assert sorted(came) == list(range(plan.chunks))
    assert results.dataset().identical(expected)


def test_closing_cancels_what_waits_and_leaves_the_cluster(client, plan, monkeypatch):
    monkeypatch.setattr(EXECUTOR, "_PATIENCE", 0.02)  # it waits in vain before the first comes
    results = execute(plan, range(plan.chunks), client=client)
    next(results)

    results.close()

    held = [None]
    for _ in range(100):  # what is released travels to the scheduler without an answer
        held = client.run_on_scheduler(lambda dask_scheduler: list(dask_scheduler.tasks))
        if not held:
            break
        time.sleep(0.05)
    assert held == []
    assert client.status == "running"


def test_worker_with_other_sources_is_refused(client, plan, monkeypatch):
    monkeypatch.setattr(EXECUTOR, "sources_hash", lambda: "another")

    with pytest.raises(InputError, match="install the same versions"):
        list(execute(plan, [0], client=client))


def test_cluster_without_workers_is_an_error(plan, monkeypatch):
    monkeypatch.setattr(EXECUTOR, "_WORKERLESS", 0.1)

    with (
        distributed.LocalCluster(n_workers=0, **LOCAL) as cluster,
        distributed.Client(cluster, set_as_default=False) as client,
        pytest.raises(InputError, match="has no workers"),
    ):
        list(execute(plan, [0], client=client))


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "127.0.0.1:1", "nonsense"])
def test_a_wrong_address_is_named_in_one_line(plan, monkeypatch, address):
    monkeypatch.setattr(EXECUTOR, "_PATIENCE", 0.5)

    with pytest.raises(
        ConnectionError, match=f"no Dask scheduler answers at '{address}'"
    ) as caught:
        list(execute(plan, [0], client=address))

    assert "\n" not in str(caught.value)


def test_bad_options_are_refused(plan, client):
    with pytest.raises(ValueError, match="only one of workers and client"):
        list(execute(plan, [0], client=client, workers=2))
    with pytest.raises(InputError, match="or an address"):
        list(execute(plan, [0], client=5))


def test_missing_dask_names_the_extra(monkeypatch):
    monkeypatch.delitem(sys.modules, EXECUTOR.__name__)
    monkeypatch.setitem(sys.modules, "distributed", None)

    with pytest.raises(InputError, match=r'pip install "\.\[dask\]"'):
        importlib.import_module(EXECUTOR.__name__)
