"""A dask cluster of processes of its own: workers killed, a scheduler restarted, sources that differ."""

from __future__ import annotations

import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from distributed import Client

import nao_hil.runs.executors.dask as executors_dask
from bridge.errors import LinkError
from nao_hil.runs import store
from nao_hil.runs.campaign import Campaign
from nao_hil.runs.config import RunConfig
from nao_hil.runs.executors import Job, WorkerRefused, base, open_executor
from nao_hil.runs.walk import Walk
from tests.loops import until
from tests.ports import free_port
from walker.switches import switch_changes

pytestmark = pytest.mark.usefixtures("connections_left_open")
BARE = switch_changes("none")
HERE = Path(__file__).parent
ENVIRONMENT = os.environ | {"PYTHONPATH": str(HERE.parents[2]), "PYTHONWARNINGS": "ignore"}


class Cluster:
    """A scheduler and workers on loopback."""

    def __init__(self, folder: Path) -> None:
        self.address = f"tcp://127.0.0.1:{free_port()}"
        self._folder = folder
        self.workers: list[subprocess.Popen[bytes]] = []
        self.start(2)

    def start(self, workers: int) -> None:
        """A scheduler with workers."""
        port = self.address.rpartition(":")[2]
        self.scheduler = self._start("scheduler", "--host", "127.0.0.1", "--port", port, "--no-dashboard")
        until(lambda: _listens(int(port)), "the scheduler")
        command = ("worker", self.address, "--nthreads", "1", "--no-dashboard", "--no-nanny")
        self.workers += [self._start(*command) for _ in range(workers)]

    def _start(self, *arguments: str) -> subprocess.Popen[bytes]:
        with (self._folder / "log").open("ab") as log:
            return subprocess.Popen(
                [sys.executable, "-m", "dask", *arguments],
                env=ENVIRONMENT, cwd=self._folder, stdout=log, stderr=log, start_new_session=True,
            )  # fmt: skip

    def close(self) -> None:
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


def _listens(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    """One for all tests; the last one leaves it without workers."""
    found = Cluster(tmp_path_factory.mktemp("cluster"))
    yield found
    found.close()


def short(seed: int) -> Walk:
    config = RunConfig(engine="mujoco", wear="nominal", gait="static", seed=seed, controller=BARE)
    return Walk(name="short", config=config, duration=0.2, keep_track=False)


def test_the_same_walks_on_a_cluster_and_here_row_for_row(cluster: Cluster, tmp_path: Path) -> None:
    sheet = tmp_path / "mine.toml"
    sheet.write_bytes((Path(store.__file__).parents[2] / "emulator/wear/worn.toml").read_bytes())
    mine = RunConfig(engine="mujoco", wear=str(sheet), gait="static", controller=BARE)
    walks = [short(0), Walk(name="mine", config=mine, duration=0.2, keep_track=False)]
    with Campaign(tmp_path / "inline", cluster="inline") as campaign:
        here = campaign.walk(walks)
    with Campaign(tmp_path / "there", cluster=cluster.address) as campaign:
        there = campaign.walk(walks)
    assert [each.end for each in here] == [each.end for each in there]


def test_a_worker_with_other_sources_refuses_in_one_sentence(
    cluster: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(base.Versions, "here", classmethod(lambda cls: cls("0" * 64, ())))
    executor = open_executor(cluster.address)
    with pytest.raises(WorkerRefused, match=r"has sources \w{12}, the command 000000000000: install the same"):
        list(executor.run([Job("a", abs, -1)]))
    executor.close()


def test_a_worker_that_rounds_differently_refuses_in_one_sentence(
    cluster: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = base.Versions.here()
    libraries = tuple((name, "0" if name == "numerics" else version) for name, version in here.libraries)
    monkeypatch.setattr(base.Versions, "here", classmethod(lambda cls: cls(here.sources, libraries)))
    executor = open_executor(cluster.address)
    with pytest.raises(WorkerRefused, match=r"has numerics \w{16}, the command 0: its processor or C library"):
        list(executor.run([Job("a", abs, -1)]))
    executor.close()


def test_a_killed_worker_and_a_restarted_scheduler_lose_no_job_and_double_none(cluster: Cluster) -> None:
    said: list[str] = []
    executor = open_executor(cluster.address, notify=said.append)
    found = []
    for each in executor.run(Job(f"job {k}", time.sleep, 0.1) for k in range(40)):
        assert each.error is None
        found.append(each.place)
        if len(found) == 10:
            cluster.workers[0].send_signal(signal.SIGKILL)
        if len(found) == 25:
            cluster.scheduler.kill()
            cluster.scheduler.wait()
            time.sleep(1.0)
            cluster.start(1)
    executor.close()
    assert sorted(found) == list(range(40))
    assert f"The scheduler at {cluster.address} is gone; it is looked for, 300 s at most." in said


def test_a_result_that_dies_with_the_last_worker_ends_the_run_in_one_sentence(
    cluster: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The job is done, its result still there: dask alone waits for another worker for ever."""
    gather = Client.gather

    def killed_before(*arguments: Any, **more: Any) -> Any:
        for worker in cluster.workers:
            worker.kill()
            worker.wait()
        monkeypatch.setattr(executors_dask, "MAX_LOST_TIME", 0.2)
        monkeypatch.setattr(executors_dask, "COUNT_INTERVAL", 0.1)
        return gather(*arguments, **more)

    monkeypatch.setattr(Client, "gather", killed_before)
    said: list[str] = []
    executor = open_executor(cluster.address, notify=said.append)
    with pytest.raises(LinkError, match=r"the scheduler at tcp://.* has had no worker for"):
        list(executor.run([Job("a", abs, -1)]))
    executor.close()
    assert said
    assert all(text.startswith(f"{cluster.address} has no worker; one is waited for, ") for text in said)
