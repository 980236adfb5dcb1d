"""Campaigns on a dask cluster that is hurt: a worker killed, the scheduler restarted, the network cut.

Scheduler and command are in one network namespace, the workers in another; needs root and iproute2.
"""

from __future__ import annotations

import contextlib
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

import pyarrow.dataset as pads

from nao_hil.network_emulation import NetworkConditions, Site
from nao_hil.network_emulation.site import ROBOT_ADDRESS, WALKER_ADDRESS
from nao_hil.runs.dataset.journal import SUFFIX
from nao_hil.runs.dataset.parts import PATTERN

_SCHEDULER: Final = f"tcp://{WALKER_ADDRESS}:8786"
_TIMEOUT: Final = 600.0
"""s for a campaign."""
_CAMPAIGN: Final = """
seeds = {walks}
duration = 0.2
[base]
engine = "mujoco"
gait = "static"
"""


def measure(tries: int = 2, walks: int = 24, cut: float = 10.0) -> dict[str, Any]:
    """One campaign a try, with all three faults in its middle.

    Args:
        tries: Campaigns.
        walks: Of a campaign, 0.2 s each.
        cut: Length of the cut, s.

    Returns:
        In how many tries all walks are there, each once; of each try the rows, their distinct seeds, and s.
    """
    found = []
    for _ in range(tries):
        begin = time.monotonic()
        rows, seeds = _attempt(walks, cut)
        found.append({"rows": rows, "seeds": seeds, "seconds": time.monotonic() - begin})
        print(f"  {found[-1]}", flush=True)
    whole = sum(each["rows"] == each["seeds"] == walks for each in found)
    return {"tries": tries, "walks": walks, "cut": cut, "all there, each once": whole, "each": found}


def _attempt(walks: int, cut: float) -> tuple[int, int]:
    """A campaign; gives its rows and their distinct seeds."""
    with tempfile.TemporaryDirectory() as name, Site() as site, contextlib.ExitStack() as stack:
        folder = Path(name)
        (folder / "campaign.toml").write_text(_CAMPAIGN.format(walks=walks))

        def start(prefix: Sequence[str], module: str, *arguments: str) -> subprocess.Popen[bytes]:
            """A module as a process, killed at the end."""
            with (folder / "log").open("ab") as log:
                process = subprocess.Popen(
                    [*prefix, sys.executable, "-m", module, *arguments], cwd=folder, stdout=log, stderr=log
                )
            stack.callback(process.wait)
            stack.callback(process.kill)
            return process

        def scheduler() -> subprocess.Popen[bytes]:
            return start(site.walker, "dask", "scheduler", "--host", WALKER_ADDRESS, "--no-dashboard")

        def workers(number: int) -> list[subprocess.Popen[bytes]]:
            options = ("--host", ROBOT_ADDRESS, "--nthreads", "1", "--no-dashboard", "--no-nanny")
            return [start(site.robot, "dask", "worker", _SCHEDULER, *options) for _ in range(number)]

        def wait(rows: int) -> None:
            """Until so many walks are done, or none will be."""
            end = time.monotonic() + _TIMEOUT
            while campaign.poll() is None and _rows(folder) < rows and time.monotonic() < end:
                time.sleep(0.05)

        first, beginning = scheduler(), workers(2)
        while first.poll() is None and b"Scheduler at" not in (folder / "log").read_bytes():
            time.sleep(0.05)
        campaign = start(
            site.walker, "nao_hil.cli", "campaign", "campaign.toml", "--cluster", _SCHEDULER, "--out", "out"
        )
        wait(walks // 6)
        beginning[0].kill()
        workers(1)
        wait(walks // 3)
        first.kill()
        first.wait()
        scheduler()
        workers(2)
        wait(walks * 2 // 3)
        under_way = campaign.poll() is None
        site.link.set(NetworkConditions(outage=True))
        time.sleep(cut)
        site.link.set(NetworkConditions())
        with contextlib.suppress(subprocess.TimeoutExpired):
            campaign.wait(_TIMEOUT)
        if campaign.returncode != 0 or not under_way:
            print((folder / "log").read_text()[-3000:])
        parts = sorted(map(str, (folder / "out" / "walks").glob(PATTERN)))
        found = pads.dataset(parts).to_table(["seed"]).column("seed").to_pylist() if parts else []
        return len(found), len(set(found))


def _rows(folder: Path) -> int:
    """Walks in the journal of a campaign."""
    return sum(path.read_bytes().count(b"\n") for path in folder.glob(f"out/walks/journal/*{SUFFIX}"))
