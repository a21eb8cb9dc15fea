"""Processes for long work: kept or for one job, ended when nobody waits, none left behind."""

import signal
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import anyio
import pytest

from latolato.app.processes import EndedError, JobError, Workers

UNKNOWN = {"do": "dance", "path": "/clip", "name": "swing.mp4"}


def in_loop(function):
    """Run in a thread of its own: a browser of other tests may have its loop in this one."""
    with ThreadPoolExecutor(1) as pool:
        pool.submit(anyio.run, function).result()


@pytest.mark.parametrize("once, kept", [(False, 1), (True, 0)])
def test_a_process_is_kept_for_the_next_job_unless_it_is_for_one(tmp_path, once, kept):
    async def run():
        workers = Workers(1, once)
        numbers = []
        for _ in range(2):
            heard = []
            with pytest.raises(JobError, match=r"internal error \(KeyError\)"):
                await workers.do("clip", UNKNOWN, tmp_path, heard.append)
            assert heard[0] == {"begun": len(numbers) == 1 and kept == 1}
            assert len(workers.idle) == kept
            numbers += [worker.process.pid for worker in workers.idle]
        assert len(set(numbers)) == kept
        assert not workers.busy
        workers.close()

    in_loop(run)


def test_a_process_that_ends_in_its_job_tells_how(tmp_path):
    async def run():
        workers = Workers(1, once=True)

        def hear(message):
            (worker,) = workers.busy
            worker.process.send_signal(signal.SIGTERM)

        with pytest.raises(EndedError) as caught:
            await workers.do("clip", UNKNOWN, tmp_path, hear)
        assert caught.value.code == (1 if sys.platform == "win32" else -signal.SIGTERM)

    in_loop(run)


@pytest.mark.parametrize("delay", [0.0, 0.001, 0.01, 0.1])
def test_whenever_a_job_is_cancelled_its_process_has_ended(tmp_path, delay):
    async def run():
        workers = Workers(1)
        with anyio.move_on_after(delay) as scope:
            await workers.do("clip", UNKNOWN, tmp_path, started.append)
        assert scope.cancelled_caught
        deadline = time.monotonic() + 5.0
        while workers.busy and time.monotonic() < deadline:
            await anyio.sleep(0.01)
        assert not workers.busy
        assert not workers.idle

    started = []
    in_loop(run)
