"""What a walker makes of gaps in its sensor frames: after a long one the robot is where its guard left it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import msgspec
import pytest

from bridge.body import Body
from bridge.errors import LinkError, WalkRefused
from bridge.guard import GuardSettings
from bridge.messages import SensorFrame
from nao_hil.runs.build import controller_maker
from nao_hil.runs.config import RunConfig
from tests.frames import standing_frame
from walker.controller import Controller
from walker.process import WalkerProcess

FRAME = standing_frame()


class Link:
    """A robot whose frames have the given numbers; it stays the same robot throughout."""

    robot, endpoint, lease = "nao", "tcp/127.0.0.1:7447", 1

    def __init__(self, numbers: list[int], mode: str) -> None:
        self.numbers, self.mode = numbers, mode
        self.sent: list[Any] = []

    def wait_robot(self, stop: Any, timeout: float | None = None) -> Any:
        return (
            None
            if stop()
            else SimpleNamespace(body="nao-v3", sheet="", boot=7, cycle=0.01, mode=self.mode, robot="nao")
        )

    def latest(self, _: float) -> SensorFrame:
        return msgspec.structs.replace(FRAME, seq=self.numbers.pop(0))

    next = latest

    def acquire(self) -> None:
        """It is given."""

    release = acquire

    def query(self, _: str) -> bytes:
        raise LinkError("This one has no guard.")

    def upper_body(self) -> None:
        """Nobody commands the head and the arms."""

    def notices(self) -> list[Any]:
        return []

    def send(self, frame: Any) -> None:
        self.sent.append(frame)

    publish = send


GUARDED = GuardSettings().watchdog.silence_cycles + GuardSettings().watchdog.hold_cycles


@pytest.mark.parametrize(
    ("numbers", "mode", "walks"),
    [
        ([0, 1, 2, 3], "real-time", 1),
        ([0, 1, 1 + GUARDED, 2 + GUARDED], "real-time", 1),
        ([0, 1, 2 + GUARDED, 3 + GUARDED, 4 + GUARDED], "real-time", 2),
        ([0, 1, 2 + GUARDED, 3 + GUARDED], "lockstep", 1),
    ],
)
def test_a_walk_begins_anew_after_a_gap_in_which_a_guard_takes_the_robot_over(
    numbers: list[int], mode: str, walks: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[Controller] = []

    def make(body: Body, cycle: float) -> Controller:
        made.append(controller_maker(RunConfig(steps=0))(body, cycle))
        return made[-1]

    monkeypatch.setattr("walker.process.quiet_process", lambda _: None)
    link = Link(numbers, mode)
    WalkerProcess(link, make, None, lambda: not link.numbers).run()  # type: ignore[arg-type]
    assert len(made) == walks


def test_a_walk_of_a_robot_that_hangs_is_refused_before_its_first_step() -> None:
    frames = [msgspec.structs.replace(FRAME, fsr=(0.0,) * 8, seq=i, time=0.01 * i) for i in range(2000)]

    class Hanging(Link):
        def latest(self, _: float) -> SensorFrame:
            return frames[self.numbers.pop(0)]

        next = latest

    link: Any = Hanging(list(range(2000)), "lockstep")
    with pytest.raises(WalkRefused, match="hangs"):
        WalkerProcess(link, controller_maker(RunConfig()), None, lambda: not link.numbers).run()
    assert link.numbers
