"""`goToPosture` on an emulated robot: its answer against the ground truth."""

from __future__ import annotations

import math
from collections.abc import Iterator
from concurrent.futures import Future
from typing import Any

import pytest

from bridge.body import load_body
from bridge.guard import Guard
from bridge.messages.world import Push
from emulator.queries import carry_out
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear
from tests.bridge.adapters.naoqi.served import Robot
from tests.loops import repeat_while

V6 = load_body("nao-v6")


class PhysicalRobot(Robot):
    """Served by NAOqi's services, moved by physics."""

    def __init__(self, robot: EmulatedRobot) -> None:
        self.robot, self._guard = robot, Guard(robot.body)
        super().__init__(robot.frame, robot.body.name)

    def step(self) -> None:
        command = self._guard.check(self.services.joints.answer(), self.robot.seq)
        self.robot.advance(self._guard.cycle(self.robot.frame, command, supervised=True, direct=True))
        self.frame = self.robot.frame
        self.services.cycle(self.frame)

    def go_to(self, posture: str) -> Future[Any]:
        done: Future[Any] = self.call("ALRobotPosture", "goToPosture", posture, 0.8)
        return done

    def end(self, done: Future[Any]) -> Any:
        for _ in repeat_while(lambda: not done.done(), 3000):
            self.step()
        return done.result(0.0)

    def now(self) -> tuple[str, str]:
        """Posture and family."""
        return self.call("ALRobotPosture", "getPosture"), self.call("ALRobotPosture", "getPostureFamily")

    def tilt(self) -> float:
        """Of the torso by the ground truth, degrees."""
        x, y, _, _ = self.robot.truth().torso_orientation
        return math.degrees(math.acos(1.0 - 2.0 * (x * x + y * y)))


@pytest.fixture
def sitting() -> Iterator[PhysicalRobot]:
    pytest.importorskip("mujoco")
    with EmulatedRobot(V6, seed=1, wear=load_wear("nominal"), engine="mujoco", start="sit") as robot:
        yield PhysicalRobot(robot)


def test_a_robot_sits_with_its_knees_up_and_stays_so(sitting: PhysicalRobot) -> None:
    """It rolled onto its back a second after the call had said true."""
    assert sitting.end(sitting.go_to("Sit")) is True
    for _ in range(100):
        sitting.step()
    assert sitting.now() == ("Sit", "Sitting")
    assert sitting.tilt() < 25.0


def test_a_robot_that_is_pushed_over_on_the_way_says_so(sitting: PhysicalRobot) -> None:
    """Neither true, nor nothing as of a motion that somebody stopped."""
    done = sitting.go_to("Sit")
    for _ in range(300):
        sitting.step()
    assert not done.done()
    carry_out(sitting.robot, Push(impulse=(-2.0, 0.0, 0.0)))
    assert sitting.end(done) is False
    assert sitting.tilt() > 70.0
    assert sitting.now() == ("Unknown", "Unknown")
