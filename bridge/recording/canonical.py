"""The form in which messages are recorded and hashed: JSON that is the same for two runs of one seed."""

from __future__ import annotations

import hashlib
from typing import Any, Final

import msgspec

from bridge.messages import ActuatorFrame, SensorFrame
from bridge.messages.topics import TOPICS, Message

RECORDED: Final[dict[type[Any], str]] = {kind: topic.suffix for kind, topic in TOPICS.items() if topic.recorded}
"""Name in a recording of each kind of message that is recorded."""

LEFT_OUT: Final = frozenset({"wall", "tick", "lease"})
"""Fields that differ between two runs of the same seed."""

_FIELDS: Final = {
    kind: tuple(name for name in kind.__struct_fields__ if name not in LEFT_OUT) for kind in RECORDED
}
_encoder = msgspec.json.Encoder()


def canonical_json(message: Message) -> bytes:
    """The message as it is recorded and hashed: a JSON object without the fields in `LEFT_OUT`.

    Fields stand in the order of the struct, floats are the shortest decimals that read back the same, and a
    number that is not finite, which no frame should have, is null.
    """
    return _encoder.encode({name: getattr(message, name) for name in _FIELDS[type(message)]})


class FrameHash:
    """SHA-256 over sensor and actuator frames in order: a line of canonical JSON each, with its line feed."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()

    def add(self, frame: SensorFrame | ActuatorFrame) -> None:
        """Add a frame."""
        self._hash.update(canonical_json(frame))
        self._hash.update(b"\n")

    def hexdigest(self) -> str:
        """Hash of the frames so far, 64 hexadecimal digits."""
        return self._hash.hexdigest()
