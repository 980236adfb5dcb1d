"""A served robot without a link: it goes where it is sent at once."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from pathlib import Path
from threading import RLock
from types import SimpleNamespace
from typing import Any

import msgspec
import pytest

from bridge.adapters.naoqi.core.cameras import CameraFeed
from bridge.adapters.naoqi.core.robot_facts import RobotConfig
from bridge.adapters.naoqi.core.served import ServedRobot
from bridge.adapters.naoqi.declared import offers
from bridge.adapters.naoqi.services import Services
from bridge.body import load_body
from bridge.config import read_toml
from bridge.messages import SensorFrame
from tests.frames import standing_frame
from tests.loops import TIMEOUT

ALIASES = ("move", "moveTo", "moveToward")
BEGINNING = ("move", "moveTo", "moveToward", "navigateTo", "moveStraightTo")


class Standing:
    """Of the walking side: no walker."""

    handover = SimpleNamespace(has_robot=False)

    def steps_ahead(self) -> list[list[Any]]:
        return [[], []]


def walking(walks: dict[str, Callable[..., Any]]) -> Any:
    """A walking side with these methods of ALMotion."""

    def offered(name: str, walk: Callable[..., Any]) -> Any:
        def method(_: Any, *arguments: Any) -> Any:
            return walk(*arguments)

        names = [f"{service}.{name}" for service in ("ALMotion", *["ALNavigation"] * (name in ALIASES))]
        return offers(*names, kind="walk", begins_walk=name in BEGINNING)(method)

    return type("Walking", (Standing,), {name: offered(name, walk) for name, walk in walks.items()})()


class Robot:
    """A served robot that goes where it is sent at once."""

    def __init__(
        self,
        frame: SensorFrame | None = None,
        body: str = "nao-v5",
        walks: dict[str, Callable[..., Any]] | None = None,
        feed: CameraFeed | None = None,
        home: Path = Path("/nonexistent"),
    ) -> None:
        frame = self.frame = frame or standing_frame()
        self.events: list[tuple[str, Any]] = []
        self.signals: set[str] = set()
        """Events whose signal a client has."""
        self.commanded = 0
        served = ServedRobot(
            RobotConfig(load_body(body), "nao"),
            frame,
            RLock(),
            walking(walks or {}),
            lambda event, value, callbacks: self.events.append((event, value)),
            home,
            feed,
            lambda event: event in self.signals,
        )
        self.services = Services(served, lambda: None, self.count)

    def count(self) -> None:
        self.commanded += 1

    def run(self, seconds: float, **changes: Any) -> list[tuple[float, ...]]:
        """Positions sent in each of the next cycles."""
        sent = []
        for _ in range(round(100.0 * seconds)):
            command = self.services.joints.answer()
            self.frame = msgspec.structs.replace(
                self.frame,
                seq=self.frame.seq + 1,
                time=self.frame.time + 0.01,
                position=command.position,
                stiffness=command.stiffness,
                **changes,
            )
            self.services.cycle(self.frame)
            sent.append(self.services.joints.answer().position)
        return sent

    def call(self, service: str, method: str, *arguments: Any) -> Any:
        return self.services.call(service, method, list(arguments))

    def wait(self, done: Any, seconds: float = 10.0) -> Any:
        """The result of a call that takes time, which must end within so many seconds of the robot's time."""
        for _ in range(round(20.0 * seconds)):
            for reader in threading.enumerate():
                if reader.name == "file":  # it takes this machine's time and none of the robot's
                    reader.join(TIMEOUT)
            if done.done():
                break
            self.run(0.05)
        return done.result(TIMEOUT)

    def result(self, call: str, *arguments: Any) -> Any:
        """The result of `Service.method`, at its end."""
        value = self.call(*call.split("."), *arguments)
        return self.wait(value, 20.0) if isinstance(value, Future) else value

    def motion(self, method: str, *arguments: Any) -> Any:
        return self.call("ALMotion", method, *arguments)

    def angle(self, joint: str) -> float:
        angle: float = self.motion("getAngles", joint, True)[0]
        return angle


TABLE = read_toml(Path(__file__).parent / "data" / "calls.toml")


def same(expected: Any = None) -> Callable[[Any], bool]:
    """Equal and of the same type; numbers, m, rad or 0 to 1, within 0.01."""
    about = pytest.approx(expected, abs=0.01) if isinstance(expected, float) else expected
    if isinstance(expected, list) and all(isinstance(x, float) for x in expected):
        about = pytest.approx(expected, abs=0.01)
    return lambda value: type(value) is type(expected) and value == about
