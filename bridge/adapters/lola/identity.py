"""Ids and versions of a robot in its packets (`RobotConfig`)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from bridge.adapters.lola.codec import Map
from bridge.adapters.lola.schema import SENSORS
from bridge.errors import ConfigurationError, FrameError

_ID_LENGTH: Final = 20
_VERSION_LENGTH: Final = 5


@dataclass(frozen=True, slots=True)
class Identity:
    """Ids and versions of body and head, in the order of the packet."""

    body_id: str = "P0000000A00S00I00000"
    body_version: str = "6.0.0"
    head_id: str = "P0000000A00S00F00000"
    head_version: str = "6.0.0"

    def check(self) -> Identity:
        """Itself, if it fits into a packet.

        Raises:
            ConfigurationError: a text of another length would move everything behind it in the packet.
        """
        for name, text, length in (
            ("Body id", self.body_id, _ID_LENGTH),
            ("Body version", self.body_version, _VERSION_LENGTH),
            ("Head id", self.head_id, _ID_LENGTH),
            ("Head version", self.head_version, _VERSION_LENGTH),
        ):
            if len(text) != length or not text.isascii() or not text.isprintable():
                raise ConfigurationError(f"{name} {text!r} must have {length} printable ASCII characters.")
        return self


def identity_of(values: Map) -> Identity:
    """The robot that sent a packet.

    Raises:
        FrameError: `RobotConfig` is missing or is not four texts.
    """
    texts = values.get("RobotConfig")
    if not isinstance(texts, list) or len(texts) != SENSORS["RobotConfig"]:
        raise FrameError("LoLA packet refused: `RobotConfig` must hold four texts.")
    return Identity(*map(str, texts))
