"""Ground truth, which no controller receives."""

from __future__ import annotations

import math
from typing import Final

from bridge.messages import Contact, TruthFrame
from bridge.stance import FALLEN_TILT
from bridge.types import Vec3
from emulator.engine.values import FootLoad, GroundContacts, TorsoState

FALLEN_HEIGHT: Final = 0.5


def truth_frame(
    seq: int,
    time: float,
    torso: TorsoState,
    contacts: GroundContacts,
    joints: tuple[float, ...],
    com: Vec3,
    height: float,
    leds: tuple[int, ...] = (),
) -> TruthFrame:
    """Ground truth of one boundary.

    Args:
        seq: Number of the boundary.
        time: Robot time, s.
        torso: Its true state.
        contacts: Ground reactions.
        joints: True angles in frame order, rad.
        com: Centre of mass, world frame, m.
        height: Of the torso over the floor, as a fraction of that with the legs straight.
        leds: Brightness of each LED, 0 to 255; empty: all are dark.
    """
    return TruthFrame(
        seq=seq,
        time=time,
        torso_position=torso.position,
        torso_orientation=torso.orientation,
        torso_velocity=torso.velocity,
        torso_angular_velocity=torso.angular_velocity,
        joints=joints,
        com=com,
        zmp=contacts.zmp,
        left=_contact(contacts.feet["L"]),
        right=_contact(contacts.feet["R"]),
        fell=bool(contacts.touching) or not upright(torso) or height < FALLEN_HEIGHT,
        leds=leds,
    )


def upright(torso: TorsoState) -> bool:
    """Whether the torso leans by less than the tilt of a fallen robot."""
    return bool(torso.rotation[8] >= math.cos(FALLEN_TILT))


def _contact(load: FootLoad) -> Contact:
    return Contact(force=load.force, cop=load.cop)
