"""A key-frame motion on an emulated robot in this process, and its result."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import msgspec

from bridge.body.joints import N_JOINTS
from bridge.guard import Guard
from bridge.guard.config import FallSettings, GuardSettings
from bridge.messages import ActuatorFrame
from bridge.motion import GetUp, MotionPlayer, lying
from emulator.robot import EmulatedRobot

MAX_MOTION_TIME: Final = 60.0
"""s after which a motion is given up."""

START_POSES: Final = {
    "back": "lie-back",
    "front": "lie-front",
    "left": "lie-side",
    "right": "lie-side",
    "upright": "stand",
}
"""Start pose of a motion, by the side on which the robot lies."""


class MotionResult(msgspec.Struct, frozen=True, kw_only=True):
    """The JSON of `nao-hil motion`."""

    motion: str
    began: str
    """Side on which the robot lay at the beginning: `back`, `front`, `left`, `right` or `upright`."""
    ended: str
    stands: bool
    """Upright on its feet at the end, by the ground truth."""
    time: float
    """Duration of the motion, s."""
    tries: int
    temperature: float
    """Temperature of the hottest motor at any time, degrees Celsius."""
    current: float
    """Largest of any motor at any time, as a share of its stall current."""
    overlap: float
    """Deepest overlap of two limbs at any frame, m."""


def play(
    robot: EmulatedRobot,
    name: str,
    player: MotionPlayer | GetUp,
    *,
    longest: float = MAX_MOTION_TIME,
    watch: Callable[[EmulatedRobot], None] | None = None,
) -> MotionResult:
    """Play a motion to its end, through the guard.

    Args:
        robot: at its start pose; moved.
        name: of the motion, for the result.
        player: at its beginning.
        longest: time after which it is given up, s.
        watch: called after each cycle.
    """
    # a single motion may lie down, as ordered; getting up must not look like a fall
    guard = Guard(robot.body, GuardSettings(fall=FallSettings(enabled=isinstance(player, GetUp))))
    began = lying(robot.frame.angle)
    start, overlap = robot.time, 0.0
    temperature = current = 0.0
    for cycle in range(round(longest / robot.body.cycle)):
        frame = robot.frame
        position = player.advance(frame, robot.body.cycle)
        if player.done:
            break
        stiffness = (player.stiffness,) * N_JOINTS
        command = ActuatorFrame(reply_to=robot.seq, position=position, stiffness=stiffness)
        robot.advance(guard.cycle(frame, guard.check(command, robot.seq), supervised=True))
        temperature = max(temperature, *robot.frame.temperature)
        current = max(current, float((robot.servo.current() / robot.servo.stall_current).max()))
        if cycle % 10 == 0:
            overlap = max(overlap, robot.engine.overlap(robot.multibody, robot.multibody))
        if watch is not None:
            watch(robot)
    truth = robot.truth()
    return MotionResult(
        motion=name,
        began=began,
        ended=lying(robot.frame.angle),
        stands=not truth.fell and truth.left.force[2] + truth.right.force[2] > 0.0,  # 0 on a hook
        time=robot.time - start,
        tries=len(player.began) if isinstance(player, GetUp) else 1,
        temperature=temperature,
        current=current,
        overlap=overlap,
    )
