"""The messages of the contract, typed, in msgpack: one module for each family.

Arrays have fixed orders and lengths; units are SI; angles are radians. `docs/protocol.md` specifies the same
for other languages.
"""

from bridge.messages.codec import decode, decode_command, encode
from bridge.messages.frames import ActuatorFrame, LedFrame, SensorFrame
from bridge.messages.info import Info
from bridge.messages.lease import LeaseReply, LeaseRequest
from bridge.messages.notice import Notice
from bridge.messages.schema import MAX_PAYLOAD, SCHEMA_VERSION
from bridge.messages.truth import Contact, TruthFrame
from bridge.messages.walk import WalkTelemetry

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
