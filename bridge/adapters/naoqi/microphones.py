"""Sound for modules that subscribed to ALAudioDevice (vendor's page): silence, as there are no microphones."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any, Final

from bridge.adapters.naoqi.arguments import text
from bridge.adapters.naoqi.events import Publish
from bridge.adapters.naoqi.methods import Table
from bridge.errors import NaoqiRefused

SAMPLES: Final = {48_000: 4096, 16_000: 1365}
"""Samples of a channel in one buffer by the rate, Hz: 85 ms."""
ALL: Final = 4
"""Channels that the number 0 stands for; 1 to 4 are one each: left, right, front, rear."""
MAX_MODULES: Final = 100


@dataclass
class _Listener:
    channels: int = ALL
    rate: int = 48_000
    due: float | None = None
    """When it gets its next buffer, the robot's clock, ms; None: it has not subscribed."""


class Microphones:
    """Buffers of silence for each module; not thread-safe, the caller locks.

    Args:
        publish: calls the modules.
    """

    def __init__(self, publish: Publish) -> None:
        self._publish = publish
        self._listeners: dict[str, _Listener] = {}

    def update(self, now: int) -> None:
        """One cycle, at `now` of the robot's clock, ms."""
        for module, one in self._listeners.items():
            if one.due is None or now < one.due:
                continue
            samples = SAMPLES[one.rate]
            one.due = max(one.due, now - 1000.0) + 1000.0 * samples / one.rate
            seconds, part = divmod(time.time(), 1.0)
            stamp, sound = [int(seconds), int(1e6 * part)], bytes(2 * one.channels * samples)
            self._publish("", None, [[module, "processRemote", [one.channels, samples, stamp, sound]]])

    def _of(self, module: Any, method: str) -> _Listener:
        name = text(module, f"ALAudioDevice.{method}: module")
        if name not in self._listeners and len(self._listeners) >= MAX_MODULES:
            raise NaoqiRefused(f"ALAudioDevice.{method}: {MAX_MODULES} modules listen already.")
        return self._listeners.setdefault(name, _Listener())

    def _prefer(self, module: Any, rate: Any, channels: Any, *_: Any) -> None:
        if rate not in list(SAMPLES) or channels not in list(range(ALL + 1)):
            raise NaoqiRefused(
                f"ALAudioDevice.setClientPreferences: {rate!r:.40} and {channels!r:.40} were given; a rate of "
                "16000 or 48000 Hz, and channels 0 (all) to 4 are expected."
            )
        listener = self._of(module, "setClientPreferences")
        listener.rate, listener.channels = int(rate), 1 if channels else ALL

    def _subscribe(self, module: Any) -> None:
        self._of(module, "subscribe").due = 0.0

    def _unsubscribe(self, module: Any) -> None:
        self._listeners.pop(text(module, "ALAudioDevice.unsubscribe: module"), None)

    def methods(self) -> Table:
        """Methods of `ALAudioDevice`."""
        return {
            "setClientPreferences": self._prefer,
            "subscribe": self._subscribe,
            "unsubscribe": self._unsubscribe,
        }
