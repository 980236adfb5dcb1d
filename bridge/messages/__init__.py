"""The messages of the contract, typed, in msgpack: one module for each family.

Arrays have fixed orders and lengths; units are SI; angles are radians. `docs/protocol.md` specifies the same
for other languages.
"""

from bridge.messages.codec import decode, decode_command, encode
from bridge.messages.frames import (
    MAX_PAYLOAD,
    SCHEMA_VERSION,
    ActuatorFrame,
    Info,
    LedFrame,
    Notice,
    SensorFrame,
)
from bridge.messages.guard import LeaseReply, LeaseRequest
from bridge.messages.walk import WalkTelemetry
from bridge.messages.world_state import Contact, TruthFrame

__all__ = [
    "MAX_PAYLOAD",
    "SCHEMA_VERSION",
    "ActuatorFrame",
    "Contact",
    "Info",
    "LeaseReply",
    "LeaseRequest",
    "LedFrame",
    "Notice",
    "SensorFrame",
    "TruthFrame",
    "WalkTelemetry",
    "decode",
    "decode_command",
    "encode",
]
