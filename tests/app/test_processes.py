"""Jobs in processes of their own: ended when nobody waits, and when they crash."""

import os
import signal
import time
from concurrent.futures import ThreadPoolExecutor
from functools import partial

import anyio
import pytest

from latolato.app.jobs import Job, _result
from latolato.app.worker import _Report, status_in
from latolato.core.errors import InputError


def dance(request, folder, progress):
    """Say which process this is, and do what is asked for."""
    (folder / "process").write_text(str(os.getpid()))
    if request["do"] == "wait":
        time.sleep(60.0)
    if request["do"] == "crash":
        os.kill(os.getpid(), signal.SIGKILL)
    return {"process": os.getpid()}, {}


def test_a_stage_is_told_at_once_and_a_share_of_it_now_and_then(tmp_path):
    report = _Report(tmp_path)
    told = []
    for share, stage in ((0.0, "tracking"), (0.5, "tracking"), (1.0, "tracking"), (0.0, "fitting")):
        report.progress(share, stage)
        told.append(status_in(tmp_path))
    assert told == [{"state": "tracking", "progress": 0.0}] * 3 + [
        {"state": "fitting", "progress": 0.0}
    ]


def test_a_job_says_once_that_it_compiles_and_then_names_the_stage_that_goes_on(tmp_path):
    report = _Report(tmp_path)
    report.progress(0.5, "fitting")
    told = []
    for call in (report.compiling, report.compiled, report.compiling, report.compiled):
        call()
        told.append(status_in(tmp_path))
    fitting = {"state": "fitting", "progress": 0.5}
    assert told == [{"state": "compiling"}, fitting, fitting, fitting]
    report.progress(0.0, "drawing")
    assert status_in(tmp_path) == {"state": "drawing", "progress": 0.0}


def result_of(do, folder):
    return _result(Job(dance, {"do": do}), folder)


def in_loop(function, *given):
    """Run in a thread of its own: a browser of other tests may have its loop in this one."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(anyio.run, partial(function, *given)).result()


def test_a_process_is_kept_for_the_next_job_and_replaced_if_it_crashes(tmp_path):
    async def run():
        first, _ = await result_of("answer", tmp_path)
        second, _ = await result_of("answer", tmp_path)
        assert first == second
        with pytest.raises(InputError, match="too little memory, or a file is broken"):
            await result_of("crash", tmp_path)
        third, _ = await result_of("answer", tmp_path)
        assert third["process"] != first["process"]

    in_loop(run)


@pytest.mark.parametrize("delay", [0.0, 0.001, 0.1, 3.0])
def test_whenever_a_job_is_cancelled_its_process_has_ended(tmp_path, delay):
    async def run():
        with anyio.move_on_after(delay) as scope:
            await result_of("wait", tmp_path)
        assert scope.cancelled_caught

    begun = time.monotonic()
    in_loop(run)
    assert time.monotonic() - begun < 30.0
    if (tmp_path / "process").exists():
        with pytest.raises(ProcessLookupError):
            os.kill(int((tmp_path / "process").read_text()), 0)
