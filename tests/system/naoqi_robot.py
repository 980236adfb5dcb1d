"""A robot without physics, in real time: each joint is where it was last sent; and a process that serves it."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec

from bridge.body import load_body
from bridge.body.quantities import absent_joints
from bridge.link import RobotLink
from bridge.messages import encode
from bridge.messages.world import WORLD_COMMAND
from bridge.messages.world_state import WorldThing
from tests.frames import info_of_robot, standing_frame, truth_frame, world_reply
from tests.loops import TIMEOUT, repeat_while, until

CYCLE = 0.01


class ObedientRobot:
    """Runs in a thread; `frame` is the newest one, `touch` and others may be set between two.

    It stands at the origin of a world with `things` to be seen.
    """

    def __init__(self, body: str, endpoint: str, things: tuple[WorldThing, ...] = ()) -> None:
        self._things = things
        self._stop = threading.Event()
        self.info = info_of_robot(body=body, cycle=CYCLE, absent=absent_joints(load_body(body)))
        self._endpoint = endpoint
        self.frame = standing_frame(gyroscope=(0.01, 0.02, 0.03), angle=(0.01, -0.02))
        self.touch = self.frame.touch
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        with RobotLink(self.info, self._endpoint) as link:
            link.serve(WORLD_COMMAND, lambda _: encode(world_reply(things=self._things)))
            deadline = time.monotonic()
            for _ in repeat_while(lambda: not self._stop.is_set(), 1 << 30):
                link.publish(self.frame)
                link.publish(truth_frame(self.frame.seq, joints=self.frame.position, com=(0.0, 0.0, 0.2)))
                deadline = max(deadline + CYCLE, time.monotonic() - CYCLE)
                time.sleep(max(0.0, deadline - time.monotonic()))
                command = next(reversed(link.commands()), None)
                changes = {"position": command.position, "stiffness": command.stiffness} if command else {}
                seq = self.frame.seq + 1
                self.frame = msgspec.structs.replace(
                    self.frame, seq=seq, time=CYCLE * seq, touch=self.touch, **changes
                )

    def close(self) -> None:
        self._stop.set()
        self._thread.join(TIMEOUT)
        assert not self._thread.is_alive()


@contextmanager
def obedient_robot(body: str, endpoint: str, things: tuple[WorldThing, ...] = ()) -> Iterator[ObedientRobot]:
    robot = ObedientRobot(body, endpoint, things)
    try:
        yield robot
    finally:
        robot.close()


def serve(url: str, endpoint: str, log: Path) -> subprocess.Popen[bytes]:
    command = [
        "serve",
        "naoqi",
        "--listen",
        url,
        "--connect",
        endpoint,
        "--no-realtime-priority",
        "--gait",
        "dynamic",
        "--home",
        str(log.parent / "home"),
    ]
    with log.open("w") as file:
        return subprocess.Popen(
            [sys.executable, "-m", "nao_hil.cli", *command],
            cwd=Path(__file__).parents[2],
            stdout=file,
            stderr=file,
            stdin=subprocess.DEVNULL,
            env=os.environ | {"COLUMNS": "200"},
        )


def wait_for(text: str, log: Path) -> None:
    until(lambda: text in log.read_text(), f"{text!r} in {log}")
