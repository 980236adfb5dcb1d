"""Workers: every result with its job, failures with the name of theirs, a stop that does not wait."""

import math
import os
import threading
import time

import pytest

from bridge.errors import ConfigurationError
from emulator.wear import load_wear
from nao_hil.runs.executor import Job, RunFailed, WorkerPool


@pytest.mark.parametrize("workers", [1, 3])
def test_each_job_gets_its_own_result(workers: int) -> None:
    jobs = [Job(f"job {k}", math.factorial, k) for k in range(12)]
    with WorkerPool(workers) as pool:
        assert dict(pool.run(jobs)) == {k: math.factorial(k) for k in range(12)}
        # and again with the same workers
        assert dict(pool.run(jobs[:2])) == {0: 1, 1: 1}


def test_an_exception_names_its_run() -> None:
    jobs = [Job("obstacle, with (seed 4)", math.sqrt, -1.0)]
    with WorkerPool(1) as pool, pytest.raises(RunFailed, match=r"obstacle, with \(seed 4\) failed: ValueError"):
        list(pool.run(jobs))


def test_a_process_that_dies_names_its_run() -> None:
    with WorkerPool(2) as pool, pytest.raises(RunFailed, match=r"seed 7: its process died \(exit code 3\)"):
        list(pool.run([Job("seed 7", os._exit, 3)]))


def test_a_users_mistake_stays_one_sentence() -> None:
    with WorkerPool(1) as pool, pytest.raises(ConfigurationError, match="unknown wear profile 'rusty'"):
        list(pool.run([Job("seed 0", load_wear, "rusty")]))


def test_a_stop_gives_up_what_is_under_way() -> None:
    stop = threading.Event()
    jobs = [Job("short", math.sqrt, 4.0), Job("long", time.sleep, 3600.0)]
    found = []
    with WorkerPool(2, stop) as pool:
        for result in pool.run(jobs):
            found.append(result)
            stop.set()
    assert found == [(0, 2.0)]
