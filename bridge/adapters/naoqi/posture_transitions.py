"""Transitions between families of postures: getting up, sitting down and lying down by key-frame motions."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final, Literal

from bridge.adapters.naoqi.joints import Joints
from bridge.adapters.naoqi.motion_tasks import MotionTask
from bridge.adapters.naoqi.names import slot
from bridge.body.joints import N_JOINTS
from bridge.body.quantities import HANDS
from bridge.errors import NaoqiRefused
from bridge.motion import GetUp, Motion, MotionPlayer, get_up_motions, lying, motion_for
from bridge.stance import stands

Family = Literal["Standing", "Sitting", "LyingBelly", "LyingBack", "Unknown"]
_LYING: Final[dict[str, Family]] = {"front": "LyingBelly", "back": "LyingBack"}
_STEPS: Final[dict[str, tuple[Family, str]]] = {
    "Sitting": ("Standing", "sit-down"),
    "LyingBelly": ("Standing", "lie-down-front"),
    "LyingBack": ("Sitting", "lie-down-back"),
}
"""Family -> the one that the transition begins in, and the motion from there; all lead by a stand."""


class PostureTransitions:
    """Transitions of one robot; not thread-safe, the caller locks.

    Args:
        joints: of the robot.
    """

    def __init__(self, joints: Joints) -> None:
        self._joints = joints
        self.under_way = False
        """The torso leans because a motion wants it to."""

    def family(self) -> Family:
        """What the robot does, by the fused angle and the legs; on a side it is `Unknown`."""
        frame = self._joints.frame
        below = lying(frame.angle)
        if below == "upright":
            return "Standing" if stands(self._joints.body, frame) else "Sitting"
        return _LYING.get(below, "Unknown")

    def to(self, family: Family) -> MotionTask:
        """The task of going to a family; whether the robot is in it then.

        Raises:
            NaoqiRefused: a motion is missing for this body.
        """
        return self._play_all(self._players(family), family)

    def _players(self, family: Family) -> list[GetUp | MotionPlayer]:
        """What has to be played from here on."""
        body, here = self._joints.body, self.family()
        if here == family:
            return []
        if family == "Standing":
            motions = get_up_motions(body)
            if lying(self._joints.frame.angle) not in motions:
                raise NaoqiRefused(f"ALRobotPosture.goToPosture: no motion gets a {body.name} up from here.")
            return [GetUp(motions, body)]
        before, kind = _STEPS[family]
        motion: Motion | None = motion_for(kind, body)
        if motion is None:
            raise NaoqiRefused(
                f"ALRobotPosture.goToPosture: no motion brings a {body.name} from {before} to {family}; "
                "applyPosture moves the joints there as they are."
            )
        return [*self._players(before), MotionPlayer(motion, body)]

    def _play_all(self, players: list[GetUp | MotionPlayer], family: Family) -> MotionTask:
        try:
            for player in players:
                self.under_way = True
                yield from self._play(player)
                if player.failed:
                    break
        finally:
            self.under_way = False
        return self.family() == family

    def _play(self, player: GetUp | MotionPlayer) -> Iterator[int]:
        joints, before = self._joints, self._joints.frame.time
        while True:
            frame = joints.frame
            position = list(player.advance(frame, frame.time - before))
            before = frame.time
            if player.done:
                return
            for hand in HANDS:
                position[slot(hand)] = frame.position[slot(hand)]
            joints.dcm.put_frame(position, (player.stiffness,) * N_JOINTS)
            yield joints.now
