"""ALNavigation and ALVisualCompass, by the odometry: no obstacle is seen, no view compared."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Sequence
from typing import Any, Final

from bridge.adapters.naoqi.arguments import flag, number
from bridge.adapters.naoqi.core.cameras import CAMERAS
from bridge.adapters.naoqi.core.frames import RobotFrames
from bridge.adapters.naoqi.core.memory import Events
from bridge.adapters.naoqi.core.sensing import VisionExtractor
from bridge.adapters.naoqi.methods import Table
from bridge.errors import NaoqiRefused
from bridge.types import Vec2

logger = logging.getLogger(__name__)

FARTHEST: Final = 3.0
"""m to which `navigateTo` goes (vendor's page)."""


def navigation_methods(walks: Table) -> Table:
    """Methods of `ALNavigation` that walk.

    Args:
        walks: those of `ALMotion`.
    """

    def navigate(x: Any, y: Any, config: Any = ()) -> Any:
        """Walk to a place, m from here; false and nothing happens if it is too far."""
        method = "ALNavigation.navigateTo"
        place = number(x, f"{method}: x"), number(y, f"{method}: y")
        if math.hypot(*place) >= FARTHEST:
            logger.warning("%s: (%g, %g) is not nearer than %g m; nothing is done", method, *place, FARTHEST)
            return False
        if not isinstance(config, list | tuple) or not all(isinstance(c, list) and len(c) == 2 for c in config):
            raise NaoqiRefused(f"{method}: {config!r:.60} was given; [[name, value], ...] is expected.")
        factors = [number(value, f"{method}: {name}") for name, value in config if name == "SpeedFactor"]
        speed = [["MaxStepFrequency", min(1.0, max(0.0, factors[-1]))]] if factors else []
        return walks["moveTo"](*place, 0.0, speed)

    return {name: walks[name] for name in ("move", "moveTo", "moveToward") if name in walks} | (
        {"navigateTo": navigate} if "moveTo" in walks else {}
    )


class VisualCompass:
    """`ALVisualCompass`: how far the camera has turned since its reference; not thread-safe, the caller locks.

    Args:
        frames: of the robot.
        events: to be raised.
        walks: methods of `ALMotion`.
        place: of the robot by the odometry, m and rad.
    """

    def __init__(
        self, frames: RobotFrames, events: Events, walks: Table, place: Callable[[], Sequence[float]]
    ) -> None:
        self._frames, self._events, self._walks, self._place = frames, events, walks, place
        self._extractor = VisionExtractor("ALVisualCompass", events, ["VisualCompass/Deviation"])
        self._refreshes, self._running, self._due = True, False, 0
        self._reference: Vec2 | None = None
        """Direction of the camera's axis then."""

    def update(self, now: int) -> None:
        """One cycle, at `now` of the robot's clock, ms; raises the event at the period that was asked for."""
        began = self._extractor.running and not self._running
        self._running = self._extractor.running
        if began and (self._refreshes or self._reference is None):
            self._refer()
        if not self._extractor.processing or now < self._due or self._reference is None:
            return
        self._due = now + max(10, self._extractor.period)
        wy, wz = (now_ - then for now_, then in zip(self._direction(), self._reference, strict=True))
        seconds, part = divmod(time.time(), 1.0)
        stamp = [int(seconds), int(1e6 * part)]
        deviation = [wy, math.remainder(wz, math.tau)]
        self._events.raise_event("VisualCompass/Deviation", [deviation, list(self._place()), stamp])

    def _direction(self) -> Vec2:
        """Of the camera's axis in FRAME_WORLD: down from the horizontal, and about the vertical, rad."""
        x, y, z, _ = self._frames.transform(CAMERAS[self._extractor.camera], 1, True)[:, 0]
        return math.atan2(-z, math.hypot(x, y)), math.atan2(y, x)

    def _refer(self) -> bool:
        self._reference = self._direction()
        return True

    def _refresh(self, enabled: Any) -> None:
        self._refreshes = flag(enabled, "ALVisualCompass.enableReferenceRefresh: refresh")

    def methods(self) -> Table:
        """Methods of the service that do not walk."""
        return self._extractor.methods() | {
            "enableReferenceRefresh": self._refresh,
            "setCurrentImageAsReference": self._refer,
        }

    def walking(self) -> Table:
        """Methods that walk."""
        if "moveTo" not in self._walks:
            return {}
        move_to = self._walks["moveTo"]

        def go(x: Any, y: Any, theta: Any) -> Any:
            """Turn to a place, go there straight ahead, turn; m and rad from here."""
            ahead, left, turn = (number(value, "ALVisualCompass.moveTo", -1e4, 1e4) for value in (x, y, theta))
            distance = math.hypot(ahead, left)
            first = math.atan2(left, ahead) if distance else 0.0
            ways = [[0.0, 0.0, first], [distance, 0.0, 0.0], [0.0, 0.0, math.remainder(turn - first, math.tau)]]
            return move_to([way for way in ways if any(way)] or [[0.0, 0.0, 0.0]])

        return {
            "moveTo": go,
            "moveStraightTo": lambda distance: move_to(distance, 0.0, 0.0),
            "waitUntilTargetReached": lambda: self._walks["waitUntilMoveIsFinished"](),
        }
