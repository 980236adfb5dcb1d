"""Executors: every result with its job, failures with the name of theirs, a stop that does not wait."""

from __future__ import annotations

import math
import os
import threading
import time
from collections.abc import Iterator
from typing import Any

import dask
import pytest
from distributed import Client

from bridge.errors import ConfigurationError, LinkError
from nao_hil.runs.executors import Executor, Job, RunFailed, open_executor

pytestmark = pytest.mark.usefixtures("connections_left_open")


@pytest.fixture(scope="module")
def processes() -> Iterator[Executor]:
    opened = open_executor("local:2")
    yield opened
    opened.close()


@pytest.fixture(params=["inline", "local:2"])
def executor(request: pytest.FixtureRequest) -> Executor:
    found: Executor = (
        request.getfixturevalue("processes") if request.param != "inline" else open_executor("inline")
    )
    return found


def test_each_job_gets_its_own_result(executor: Executor) -> None:
    jobs = [Job(f"job {k}", math.factorial, k) for k in range(12)]
    found = list(executor.run(jobs))
    assert {each.place: each.result for each in found} == {k: math.factorial(k) for k in range(12)}
    assert len(found) == 12
    # and again with the same processes
    assert [each.result for each in executor.run(jobs[4:5])] == [24]


def test_jobs_are_taken_only_a_little_ahead_of_those_that_are_done(executor: Executor) -> None:
    taken = done = most = 0

    def jobs() -> Iterator[Job]:
        nonlocal taken
        for k in range(100):
            taken += 1
            yield Job(f"job {k}", abs, k)

    for _ in executor.run(jobs()):
        done += 1
        most = max(most, taken - done)
    assert done == 100
    assert most < 30


def test_a_client_that_closes_is_replaced_and_no_job_is_lost(
    processes: Executor, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As after a scheduler that did not answer for long."""
    submissions = []
    submit = Client.map

    def closed_before(client: Client, *arguments: Any, **more: Any) -> Any:
        submissions.append(arguments)
        if len(submissions) == 2:
            client.close()
        return submit(client, *arguments, **more)

    monkeypatch.setattr(Client, "map", closed_before)
    places = [each.place for each in processes.run(Job(f"job {k}", abs, k) for k in range(40))]
    assert sorted(places) == list(range(40))


def test_a_failure_names_its_run_and_the_others_go_on(executor: Executor) -> None:
    jobs = [Job("obstacle, with (seed 4)", math.sqrt, -1.0), Job("seed 5", math.sqrt, 4.0)]
    found = {each.place: each for each in executor.run(jobs)}
    assert found[1].result == 2.0
    assert isinstance(found[0].error, RunFailed)
    assert "obstacle, with (seed 4) failed: ValueError" in str(found[0].error)


def test_a_run_that_kills_its_process_is_named_and_the_others_go_on() -> None:
    """Even where a process takes longer to start again than dask waits for it, as on a busy machine."""
    settings = {"distributed.deploy.lost-worker-timeout": "1 ms", "distributed.scheduler.allowed-failures": 1}
    with dask.config.set(settings):
        executor = open_executor("local:1")
        found = {each.place: each for each in executor.run([Job("seed 7", os._exit, 3), Job("b", abs, -1)])}
        executor.close()
    assert "seed 7: its process died, on each of 2 workers" in str(found[0].error)
    assert found[1].result == 1


def test_a_stop_gives_up_what_is_under_way() -> None:
    stop = threading.Event()
    executor = open_executor("local:1", stop)
    found = []
    for each in executor.run([Job("short", math.sqrt, 4.0), Job("long", time.sleep, 3600.0)]):
        found.append((each.place, each.result))
        stop.set()
    executor.close()
    assert found == [(0, 2.0)]


@pytest.mark.parametrize("cluster", ["local:0", "4", "udp://a:1", "tcp://a", "locally"])
def test_a_cluster_that_is_none_is_one_sentence(cluster: str) -> None:
    with pytest.raises(ConfigurationError, match=r"must be `inline`, `local`, `local:N`, `tcp://HOST:PORT`"):
        open_executor(cluster)


def test_a_scheduler_that_is_not_there_is_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("nao_hil.runs.executors.dask.ANSWER_TIMEOUT", 0.5)
    with pytest.raises(LinkError, match=r"no dask scheduler answers at tcp://127\.0\.0\.1:9"):
        list(open_executor("tcp://127.0.0.1:9").run([Job("a", abs, 1)]))
