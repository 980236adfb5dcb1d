"""A robot without physics, in real time: each joint is where it was last sent."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import msgspec

from bridge.body import load_body
from bridge.body.quantities import absent_joints
from bridge.link import RobotLink
from bridge.messages import Info
from tests.frames import standing_frame
from tests.loops import repeat_while

CYCLE = 0.01


class ObedientRobot:
    """Runs in a thread; `frame` is the newest one, `touch` and others may be set between two."""

    def __init__(self, body: str, endpoint: str) -> None:
        self._stop = threading.Event()
        self.info = Info(
            robot="nao",
            body=body,
            side="emulator",
            mode="real-time",
            cycle=CYCLE,
            absent=absent_joints(load_body(body)),
            boot=1,
            software="test",
        )
        self._endpoint = endpoint
        self.frame = standing_frame(gyroscope=(0.01, 0.02, 0.03), angle=(0.01, -0.02))
        self.touch = self.frame.touch
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        with RobotLink(self.info, self._endpoint) as link:
            deadline = time.monotonic()
            for _ in repeat_while(lambda: not self._stop.is_set(), 100_000):
                link.publish_sensors(self.frame)
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
        self._thread.join(20.0)
        assert not self._thread.is_alive()


@contextmanager
def obedient_robot(body: str, endpoint: str) -> Iterator[ObedientRobot]:
    robot = ObedientRobot(body, endpoint)
    try:
        yield robot
    finally:
        robot.close()
