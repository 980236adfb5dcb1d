"""Messages for tests."""

from __future__ import annotations

from typing import Any, Final

import msgspec

from bridge.body.joints import N_JOINTS
from bridge.body.postures import POSTURES
from bridge.messages import Contact, Info, SensorFrame, TruthFrame, WalkTelemetry
from bridge.messages.walk import WalkStatus
from bridge.messages.world_state import WorldReply

STANDING: Final = SensorFrame(
    seq=0,
    time=0.0,
    position=POSTURES["StandInit"],
    stiffness=(1.0,) * N_JOINTS,
    current=(0.1,) * N_JOINTS,
    temperature=(38.0,) * N_JOINTS,
    fsr=(4.905,) * 8,
    accelerometer=(0.0, 0.0, 9.81),
    gyroscope=(0.0, 0.0, 0.0),
    angle=(0.0, 0.0),
    touch=(0.0,) * 14,
    battery=(0.9, -1.5, 0.0, 30.0),
    sonar=(0.5, 0.6),
)
"""A robot that stands upright in StandInit, stiff, 2 kg on each foot."""


def standing_frame(seq: int = 0, **changes: Any) -> SensorFrame:
    """The robot of `STANDING` in another cycle of 10 ms, with some fields changed."""
    return msgspec.structs.replace(STANDING, **({"seq": seq, "time": 0.01 * seq} | changes))


def info_of_robot(**changes: Any) -> Info:
    """Description of an emulated V3 in real time, with some fields changed."""
    fields: dict[str, Any] = {"robot": "nao", "body": "nao-v3", "side": "emulator", "mode": "real-time"}
    return Info(**(fields | {"cycle": 0.01, "absent": (), "boot": 1, "software": "test"} | changes))


def walk_telemetry(seq: int = 0, **changes: Any) -> WalkTelemetry:
    """Telemetry of a walk with the feet side by side, with some fields changed."""
    fields: dict[str, Any] = {"state": "walk", "phase": "DSL", "step": 0, "steps": 0}
    feet = {"left": (0.0, 0.05, 0.0, 0.0, 0.0, 0.0), "right": (0.0, -0.05, 0.0, 0.0, 0.0, 0.0)}
    return WalkTelemetry(seq=seq, **(fields | {"zmp": (0.0, 0.0), "com": (0.0, 0.0)} | feet | changes))


def walk_status(**changes: Any) -> WalkStatus:
    """Answer of a walker of the static gait at rest, with some fields changed."""
    fields: dict[str, Any] = {"text": "", "seq": 0, "state": "stand", "gait": "static", "torso": "none"}
    fields |= {"admittance": True, "velocity": (0.0, 0.0, 0.0), "steps": 0, "distance": 0.0}
    return WalkStatus(**(fields | {"position": (0.0, 0.0, 0.0)} | changes))


def truth_frame(seq: int = 0, **changes: Any) -> TruthFrame:
    """Ground truth of a robot at rest in the air, in a cycle of 10 ms, with some fields changed."""
    nothing = Contact(force=(0.0, 0.0, 0.0), cop=None)
    zero = (0.0, 0.0, 0.0)
    fields: dict[str, Any] = {"seq": seq, "time": 0.01 * seq, "torso_position": (0.0, 0.0, 0.33), "com": zero}
    fields |= {
        "torso_orientation": (0.0, 0.0, 0.0, 1.0),
        "torso_velocity": zero,
        "torso_angular_velocity": zero,
    }
    fields |= {"joints": (0.0,) * N_JOINTS, "zmp": None, "left": nothing, "right": nothing, "fell": False}
    return TruthFrame(**(fields | changes))


def world_reply(**changes: Any) -> WorldReply:
    """An empty, level world that runs, with some fields changed."""
    fields: dict[str, Any] = {"text": "", "seq": 0, "time": 0.0, "paused": False, "floor": (0.0, 0.0)}
    return WorldReply(**(fields | {"friction": 0.8, "objects": (), "things": (), "faults": ()} | changes))
