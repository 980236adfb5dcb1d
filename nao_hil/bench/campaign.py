"""Campaigns without walking: how fast null walks are handed out, and how many workers that keeps busy."""

from __future__ import annotations

import heapq
import math
import os
import time
from pathlib import Path
from typing import Any

import numpy as np

from nao_hil.runs.executors import Job, open_executor


def measure(
    walks: int = 20_000, cluster: str = "local:2", walk: float = 3.0, share: float = 0.95
) -> dict[str, Any]:
    """Null walks, streamed through an executor; this process is command and scheduler.

    Args:
        walks: Null walks.
        cluster: As `--cluster`: `local` or `local:N`.
        walk: Wall time of the walks whose workers are counted, s.
        share: Of the time in which a worker is to be busy.

    Returns:
        Null walks per second by the wall clock, and per second of this process' processor time, which the
        machine's load does not change; workers that the latter keeps busy, by `walk / (share * service)` and
        by simulation; memory of this process after a tenth of the walks and after all, MiB.
    """
    executor = open_executor(cluster)
    list(executor.run([Job("null", abs, 0)]))  # starts the workers
    begin, used, early = time.perf_counter(), time.process_time(), 0.0
    done = 0
    for _ in executor.run(Job("null", abs, k) for k in range(walks)):
        done += 1
        if done == walks // 10:
            early = _memory()
    wall, service = time.perf_counter() - begin, (time.process_time() - used) / walks
    late = _memory()
    executor.close()
    return {
        "walks": done,
        "per_second": walks / wall,
        "per_processor_second": 1.0 / service,
        "workers_on_paper": math.floor(walk / (share * service)),
        "workers_simulated": workers_kept_busy(service, walk, share),
        "memory_after_a_tenth": early,
        "memory": late,
        "load": os.getloadavg()[0],
    }


def workers_kept_busy(service: float, walk: float, share: float) -> int:
    """The largest number of workers that one scheduler keeps busy for a share of the time.

    Args:
        service: Time in which the scheduler hands out one walk, s.
        walk: Mean wall time of a walk, s; each takes 0.8 to 1.2 times as long.
        share: Of the time.
    """
    low, high = 1, math.ceil(2.0 * walk / service)
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if busy_share(middle, service, walk) >= share else (low, middle)
    return low


def busy_share(workers: int, service: float, walk: float, rounds: int = 30) -> float:
    """Share of the time in which simulated workers walk; the scheduler serves one after the other.

    Args:
        workers: Their number.
        service: As in `workers_kept_busy`.
        walk: As in `workers_kept_busy`.
        rounds: Walks of a worker.
    """
    generator = np.random.default_rng(0)
    idle = list(generator.uniform(0.0, walk, workers))  # when each asks next, s
    heapq.heapify(idle)
    free = waited = walked = 0.0
    for length in generator.uniform(0.8 * walk, 1.2 * walk, rounds * workers):
        asked = heapq.heappop(idle)
        free = max(asked, free) + service
        waited += free - asked
        walked += length
        heapq.heappush(idle, free + length)
    return walked / (walked + waited)


def _memory() -> float:
    """Resident set of this process, MiB."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 2**20
