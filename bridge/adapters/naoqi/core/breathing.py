"""ALMotion's breathing: the slow motion of an idle standing robot.

Source: vendor's page on idle.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Final

from bridge.adapters.naoqi.core.joint_motion import smooth
from bridge.adapters.naoqi.core.joints import actuator
from bridge.adapters.naoqi.core.postures import Postures
from bridge.adapters.naoqi.core.served import ServedRobot, Service
from bridge.adapters.naoqi.declared import OneOf, Pairs, number, offers
from bridge.errors import NaoqiRefused
from bridge.validation import unknown_name

PARTS: Final[Mapping[str, tuple[str, ...]]] = {
    "Body": ("Head", "LArm", "RArm", "Legs"),
    "Arms": ("LArm", "RArm"),
    **{part: (part,) for part in ("Head", "LArm", "RArm", "Legs")},
}
"""Chains that can breathe (confirmed: vendor's page), and the joints that move in each."""
MIN_BPM: Final = 5.0
MAX_BPM: Final = 30.0
"""Breaths a minute (confirmed: vendor's page)."""
_ARM_ANGLES: Final = {"ShoulderPitch": 0.035, "ShoulderRoll": 0.026, "ElbowRoll": -0.035}
_LEG_ANGLES: Final = {"HipPitch": -0.0175, "KneePitch": 0.035, "AnklePitch": -0.0175}
_INHALED: Final[Mapping[str, Mapping[str, float]]] = {
    "Head": {"HeadPitch": -0.026},
    "LArm": {f"L{joint}": angle for joint, angle in _ARM_ANGLES.items()},
    "RArm": {f"R{joint}": angle if joint.endswith("Pitch") else -angle for joint, angle in _ARM_ANGLES.items()},
    "Legs": {f"{side}{joint}": angle for side in "LR" for joint, angle in _LEG_ANGLES.items()},
}
"""Angles of joints from their resting ones at amplitude 0, rad (confirmed: under 5 degrees; the values:
assumed); twice as much at amplitude 1 (assumed). Torso and soles stay level."""
_MOVED_TOLERANCE: Final = 1e-3
"""rad from the last angle sent, beyond which the program has moved a joint."""
Chain = Annotated[str, OneOf("chain", PARTS)]


class Breathing(Service):
    """Breathing of a standing robot."""

    def __init__(self, robot: ServedRobot, postures: Postures) -> None:
        super().__init__(robot)
        self._postures = postures
        self._enabled: set[str] = set()
        self._bpm, self._amplitude = 12.0, 0.5  # confirmed: vendor's page
        self._ends: dict[str, int] = {}
        """Time of each part's present half breath, ms."""
        self._base: dict[str, float] = {}
        """Resting angles of the breathing joints, rad."""
        self._sent: dict[str, float] = {}
        """Their angles sent last, rad."""

    def update(self) -> None:
        """Update in a cycle in which the joints are the program's."""
        for part in sorted(self._enabled):
            if self._joints.now >= self._ends.get(part, 0):
                self._breathe(part)

    def _breathe(self, part: str) -> None:
        """Begin the next half breath, unless the program moves the part or the robot does not stand."""
        joints = _INHALED[part]
        if any(map(self._joints.waits, joints)) or self._postures.family() != "Standing":
            self._ends[part] = self._joints.now + 200  # next check
            return
        if self._is_moved(part):
            self._base |= {j: self._joints.commanded(j) for j in joints}
            self._sent |= {j: self._base[j] for j in joints}
        inhales = all(self._sent[j] == self._base[j] for j in joints)
        self._send(part, (1.0 + self._amplitude) if inhales else 0.0)

    def _is_moved(self, part: str) -> bool:
        """Whether the program has moved the part since the last half breath."""
        for joint in _INHALED[part]:
            waiting = self._joints.dcm.waiting(actuator(joint))
            if waiting:
                if abs(waiting[-1].time - self._ends.get(part, 0)) > 1:
                    return True
            elif abs(self._joints.commanded(joint) - self._sent.get(joint, math.inf)) > _MOVED_TOLERANCE:
                return True
        return False

    def _send(self, part: str, breadth: float) -> None:
        seconds = 30.0 / self._bpm
        for joint, angle in _INHALED[part].items():
            lower, upper, *_ = self._joints.limits(joint)
            target = min(max(self._base[joint] + breadth * angle, lower), upper)
            way = smooth(self._joints.commanded(joint), [target], [seconds])
            self._joints.put_position(joint, way)
            self._sent[joint] = target
        self._ends[part] = self._joints.now + round(1000.0 * seconds)

    @offers("ALMotion.setBreathEnabled")
    def _enable(self, chain: Chain, enabled: bool) -> None:
        for part in PARTS[chain]:
            if enabled:
                self._enabled.add(part)
            elif part in self._enabled:
                self._enabled.discard(part)
                if not self._is_moved(part):
                    self._send(part, 0.0)

    @offers("ALMotion.setBreathConfig")
    def _configure(self, config: Pairs) -> None:
        """`[["Bpm", 5 to 30], ["Amplitude", 0 to 1]]`; the amplitude of fast breaths is limited."""
        method = "ALMotion.setBreathConfig"
        for name, _ in config:
            if name not in ("Bpm", "Amplitude"):
                raise NaoqiRefused(f"{method}: {unknown_name('name', str(name), ('Bpm', 'Amplitude'))}.")
        given = dict(config)
        bpm = number(given.get("Bpm", self._bpm), f"{method}: Bpm", MIN_BPM, MAX_BPM)
        amplitude = number(given.get("Amplitude", self._amplitude), f"{method}: Amplitude", 0.0, 1.0)
        self._bpm, self._amplitude = bpm, min(amplitude, (MAX_BPM - bpm) / (MAX_BPM - MIN_BPM))

    @offers("ALMotion.getBreathEnabled")
    def _get_breath_enabled(self, chain: Chain) -> bool:
        return self._enabled >= set(PARTS[chain])

    _get_breath_config = offers("ALMotion.getBreathConfig")(
        lambda self: [["Bpm", self._bpm], ["Amplitude", self._amplitude]]
    )
