"""Time from `moveToward` to the first step of a robot that a program has just woken or posed."""

from __future__ import annotations

import itertools
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any, Final

from bridge.errors import LinkError
from bridge.link import keys
from bridge.link.session import open_client, subscribe
from bridge.messages import TruthFrame, decode
from nao_hil.runs.supervisor import Child
from tests.bench.pictures import TIMEOUT, await_server
from tests.ports import free_endpoint

TRIALS: Final = 20
CALLS_BEFORE: Final = ("wakeUp", "rest", "StandInit", "Stand", "Crouch")
"""The program's last call before the move, in turn; `rest` is followed by `wakeUp`."""
WALK_TIME: Final = 1.5
"""s of each walk."""
PROMISED_TIME: Final = 0.7
"""s"""
LIFTED_FORCE: Final = 5.0
"""N; a foot that carries less is in its first step."""
_ROOT: Final = Path(__file__).parents[2]


def measure(trials: int = TRIALS, before: tuple[str, ...] = CALLS_BEFORE) -> dict[str, Any]:
    """A V5 on MuJoCo, in real time.

    Returns:
        Seconds that each call took, and from its beginning to the first step (a foot without load, by the
        ground truth), with the call before it; how many steps began within `PROMISED_TIME`.

    Raises:
        LinkError: a process failed, or a step is missing.
    """
    endpoint, url = free_endpoint(), "tcp://" + free_endpoint().removeprefix("tcp/")
    with tempfile.TemporaryDirectory() as name:
        emulate = ["emulate", "--robot", "nao-v5", "--engine", "mujoco", "--listen", endpoint, "--out", name]
        robot = Child("robot", emulate, Path(name))
        server = Child("serve", ["serve", "naoqi", "--listen", url, "--connect", endpoint], Path(name))
        try:
            await_server(server)
            given = f"{url!r}, {endpoint!r}, {trials}, {before!r}"
            code = f"from tests.bench.first_step import program; program({given})"
            done = subprocess.run([sys.executable, "-c", code], cwd=_ROOT, stdout=subprocess.PIPE, text=True)
        finally:
            server.end(5.0)
            robot.end(5.0)
    rows = [line.split() for line in done.stdout.splitlines() if line.startswith("trial ")]
    if done.returncode:
        raise LinkError(f"the program that walks the robot failed after {len(rows)} moves.")
    steps = [float(row[3]) for row in rows]
    return {
        "trials": [{"after": row[1], "call": float(row[2]), "step": float(row[3])} for row in rows],
        "median": statistics.median(steps),
        "within": sum(step <= PROMISED_TIME for step in steps),
    }


class _Feet:
    """Reports when a foot leaves the ground."""

    def __init__(self, endpoint: str) -> None:
        self._session = open_client(endpoint)
        self.lifted = threading.Event()
        self.at = 0.0
        key = keys.topic_key(keys.DEFAULT_ROBOT, TruthFrame)
        self._subscriber = subscribe(self._session, key, self._update)

    def _update(self, data: bytes) -> None:
        truth = decode(data, TruthFrame)
        if not self.lifted.is_set() and min(truth.left.force[2], truth.right.force[2]) < LIFTED_FORCE:
            self.at = time.monotonic()
            self.lifted.set()


def program(url: str, endpoint: str, trials: int, calls: tuple[str, ...]) -> None:
    """The NAOqi program, a process of its own: a line `trial CALLS_BEFORE CALL STEP` for each move."""
    import os

    import qi

    session = qi.Session()
    session.connect(url)
    motion, posture = session.service("ALMotion"), session.service("ALRobotPosture")
    feet = _Feet(endpoint)
    for before in itertools.islice(itertools.cycle(calls), trials):
        if before == "rest":
            motion.rest()
        if before in ("rest", "wakeUp"):
            motion.wakeUp()
        else:
            posture.goToPosture(before, 0.8)
        feet.lifted.clear()
        begin = time.monotonic()
        motion.moveToward(1.0, 0.0, 0.0)
        called = time.monotonic() - begin
        if not feet.lifted.wait(TIMEOUT):
            os._exit(1)
        print(f"trial {before} {called:.3f} {feet.at - begin:.3f}", flush=True)
        time.sleep(WALK_TIME)
        motion.stopMove()
    os._exit(0)
