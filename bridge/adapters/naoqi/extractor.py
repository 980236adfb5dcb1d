"""Services that measure or perceive while somebody has subscribed to them (the vendor's extractors)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

from bridge.adapters.naoqi.arguments import flag, number, text
from bridge.adapters.naoqi.events import Events
from bridge.adapters.naoqi.methods import Table
from bridge.errors import NaoqiRefused

QUIET: Final = {
    "ALPeoplePerception": "PeoplePerception/PeopleDetected",
    "ALSoundDetection": "SoundDetected",
    "ALSoundLocalization": "ALSoundLocalization/SoundLocated",
}
"""Service that perceives nothing, since there is nobody and no sound -> its event."""
QUIET_VISION: Final = {
    "ALBarcodeReader": "BarcodeReader/BarcodeDetected",
    "ALDarknessDetection": "DarknessDetection/DarknessDetected",
    "ALMovementDetection": "MovementDetection/MovementDetected",
    "ALVisionRecognition": "PictureDetected",
}
"""As `QUIET`, of services that look through a camera."""
MAX_SUBSCRIBERS = 1000
_LONGEST = 3_600_000
"""ms"""


class Extractor:
    """Subscriptions of one service; not thread-safe, the caller locks.

    Args:
        service: its name.
        events: that it raises are declared there.
        raised: names of its events.
        keys: further keys of ALMemory that it writes.
        period: between two results, ms, of a subscriber that gives none.
    """

    def __init__(
        self, service: str, events: Events, raised: Sequence[str], keys: Sequence[str] = (), period: int = 100
    ) -> None:
        self._service, self._events = service, events
        self._raised, self._keys, self._period = tuple(raised), tuple(keys), period
        self._subscribers: dict[str, tuple[int, float]] = {}
        """Name -> period (ms) and precision."""
        for event in raised:
            events.declare(event, service, [] if service in QUIET | QUIET_VISION else None)

    @property
    def running(self) -> bool:
        """Whether anybody subscribed to the service, or to one of its events."""
        return bool(self._subscribers) or any(self._events.subscribers(event) for event in self._raised)

    @property
    def period(self) -> int:
        """Between two results, ms: the shortest that was asked for."""
        return min((period for period, _ in self._subscribers.values()), default=self._period)

    def subscribe(self, name: Any, period: Any = None, precision: Any = 1.0) -> None:
        """Start the service for a subscriber.

        Args:
            name: of the subscriber.
            period: between two results, ms.
            precision: 0 to 1; without effect.
        """
        subscriber = self._name(name, "subscribe")
        milliseconds = self._period if period is None else self._milliseconds(period, "subscribe")
        fine = number(precision, f"{self._service}.subscribe: precision", 0.0, 1.0)
        if subscriber in self._subscribers or len(self._subscribers) < MAX_SUBSCRIBERS:
            self._subscribers[subscriber] = (milliseconds, fine)

    def unsubscribe(self, name: Any) -> None:
        """End a subscription, if there is one; the last one stops the service."""
        self._subscribers.pop(self._name(name, "unsubscribe"), None)

    def _name(self, name: Any, method: str) -> str:
        return text(name, f"{self._service}.{method}: name")

    def _milliseconds(self, period: Any, method: str) -> int:
        return round(number(period, f"{self._service}.{method}: period", 0, _LONGEST))

    def _set_period(self, name: Any, period: Any) -> None:
        milliseconds = self._milliseconds(period, "updatePeriod")
        subscriber = self._name(name, "updatePeriod")
        if subscriber in self._subscribers:
            self._subscribers[subscriber] = (milliseconds, self._subscribers[subscriber][1])

    def _set_precision(self, name: Any, precision: Any) -> None:
        fine = number(precision, f"{self._service}.updatePrecision: precision", 0.0, 1.0)
        subscriber = self._name(name, "updatePrecision")
        if subscriber in self._subscribers:
            self._subscribers[subscriber] = (self._subscribers[subscriber][0], fine)

    def methods(self) -> Table:
        """Methods of every such service."""
        of = self._subscribers
        return {
            "subscribe": self.subscribe,
            "unsubscribe": self.unsubscribe,
            "updatePeriod": self._set_period,
            "updatePrecision": self._set_precision,
            "getCurrentPeriod": lambda: self.period,
            "getCurrentPrecision": lambda: max((fine for _, fine in of.values()), default=1.0),
            "getMyPeriod": lambda name: of.get(self._name(name, "getMyPeriod"), (0, 0.0))[0],
            "getMyPrecision": lambda name: of.get(self._name(name, "getMyPrecision"), (0, 0.0))[1],
            "getSubscribersInfo": lambda: [[name, *values] for name, values in of.items()],
            "getOutputNames": lambda: [*self._raised, *self._keys],
            "getEventList": lambda: list(self._raised),
            "getMemoryKeyList": lambda: list(self._keys),
        }


class VisionExtractor(Extractor):
    """An extractor that looks through a camera; not thread-safe, the caller locks."""

    def __init__(self, service: str, events: Events, raised: Sequence[str], period: int = 100) -> None:
        super().__init__(service, events, raised, period=period)
        self.camera = 0
        """0 top, 1 bottom."""
        self._paused = False
        self._kept: dict[str, Any] = {"FrameRate": 5, "Resolution": 1}
        """Settings without effect here, with the values before they are set (assumed)."""

    @property
    def processing(self) -> bool:
        """Whether it runs, and is not paused."""
        return self.running and not self._paused

    def _set_camera(self, camera: Any) -> bool:
        self.camera = round(number(camera, f"{self._service}.setActiveCamera: camera", 0, 1))
        return True

    def _pause(self, paused: Any) -> None:
        self._paused = flag(paused, f"{self._service}.pause: paused")

    def _keep(self, name: str, values: Sequence[Any], most: float) -> bool:
        """Remember a value, which comes alone or behind a subscriber's name."""
        method = f"{self._service}.set{name}"
        if len(values) not in (1, 2):
            raise NaoqiRefused(f"{method} takes a value, or a name and a value.")
        self._kept[name] = round(number(values[-1], method, 0, most))
        return True

    def methods(self) -> Table:
        """Methods of every service that looks through a camera."""
        return super().methods() | {
            "getActiveCamera": lambda: self.camera,
            "setActiveCamera": self._set_camera,
            "isPaused": lambda: self._paused,
            "pause": self._pause,
            "isProcessing": lambda: self.processing,
            "getFrameRate": lambda: self._kept["FrameRate"],
            "setFrameRate": lambda *values: self._keep("FrameRate", values, 30),
            "getResolution": lambda: self._kept["Resolution"],
            "setResolution": lambda *values: self._keep("Resolution", values, 8),
            "setParameter": lambda name, value: text(name, f"{self._service}.setParameter: name") and None,
        }
