"""A key-frame motion on an emulated robot in this process, and what came of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import msgspec

from bridge.body.joints import N_JOINTS
from bridge.messages import ActuatorFrame
from emulator.robot import EmulatedRobot
from walker.planning.motion import Motion, MotionPlayer, lying

LONGEST: Final = 30.0
"""s after which a motion is given up."""


class MotionResult(msgspec.Struct, frozen=True, kw_only=True):
    """The JSON of `nao-hil motion`."""

    motion: str
    began: str
    """What of the robot was below at the beginning: `back`, `front`, `left`, `right` or `upright`."""
    ended: str
    stands: bool
    """Upright on its feet at the end, by the ground truth."""
    time: float
    """Of the motion, s."""
    tries: int
    temperature: float
    """Of the hottest motor, degrees Celsius."""
    overlap: float
    """Deepest overlap of two limbs at any frame, m."""


def play(
    robot: EmulatedRobot,
    name: str,
    choose: Callable[[str], Motion | None],
    *,
    tries: int = 1,
    watch: Callable[[EmulatedRobot], None] | None = None,
) -> MotionResult:
    """Play the motion that fits how the robot lies, again until it stands, or as often as allowed.

    Args:
        robot: where it lies; moved.
        name: of the motion, for the result.
        choose: the motion for what is below; None: there is none.
        tries: at most.
        watch: called after each cycle.
    """
    began = lying(robot.frame.angle)
    start, count, overlap = robot.time, 0, 0.0
    for _ in range(tries):
        motion = choose(lying(robot.frame.angle))
        if motion is None:
            break
        count += 1
        player = MotionPlayer(motion, robot.body)
        for cycle in range(round(LONGEST / robot.body.cycle)):
            position = player.advance(robot.frame, robot.body.cycle)
            command = ActuatorFrame(
                reply_to=robot.seq, position=position, stiffness=(player.stiffness,) * N_JOINTS
            )
            robot.advance(command)
            if cycle % 10 == 0:
                overlap = max(overlap, robot.engine.robot.overlap())
            if watch is not None:
                watch(robot)
            if player.done:
                break
        if not robot.truth().fell:
            break
    return MotionResult(
        motion=name,
        began=began,
        ended=lying(robot.frame.angle),
        stands=not robot.truth().fell,
        time=robot.time - start,
        tries=count,
        temperature=max(robot.frame.temperature),
        overlap=overlap,
    )
