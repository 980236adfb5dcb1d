"""ALNavigation and ALVisualCompass, by the odometry: no obstacle is seen, no view compared."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping
from typing import Annotated, Any, Final

from bridge.adapters.naoqi.core.cameras import CAMERAS
from bridge.adapters.naoqi.core.memory import stamp
from bridge.adapters.naoqi.core.sensing import VisionExtractor
from bridge.adapters.naoqi.core.served import ServedRobot, Service
from bridge.adapters.naoqi.declared import Pairs, Range, number, offers
from bridge.types import Vec2

logger = logging.getLogger(__name__)

MAX_DISTANCE: Final = 3.0
"""Longest way of `navigateTo`, m (vendor's page)."""


class Navigation(Service):
    """`ALNavigation`, and the walks of `ALVisualCompass`."""

    @property
    def _walks(self) -> Mapping[str, Callable[..., Any]]:
        return self._robot.walks

    @offers("ALNavigation.navigateTo", kind="walk", begins_walk=True)
    def navigate_to(self, x: float, y: float, config: Pairs | None = None) -> Any:
        """Walk to a place relative to the robot, m; false: too far, and no walk begins."""
        method = "ALNavigation.navigateTo"
        if math.hypot(x, y) >= MAX_DISTANCE:
            logger.warning("%s: (%g, %g) is not nearer than %g m; nothing is done", method, x, y, MAX_DISTANCE)
            return False
        factors = [number(value, f"{method}: {name}") for name, value in config or () if name == "SpeedFactor"]
        speed = [["MaxStepFrequency", min(1.0, max(0.0, factors[-1]))]] if factors else []
        return self._walks["moveTo"](x, y, 0.0, speed)

    @offers("ALVisualCompass.moveTo", kind="walk")
    def turn_and_go(self, x: Length, y: Length, theta: Length) -> Any:
        """Turn to a place, walk straight ahead to it, turn; m and rad relative to the robot."""
        distance = math.hypot(x, y)
        first = math.atan2(y, x) if distance else 0.0
        ways = [[0.0, 0.0, first], [distance, 0.0, 0.0], [0.0, 0.0, math.remainder(theta - first, math.tau)]]
        return self._walks["moveTo"]([way for way in ways if any(way)] or [[0.0, 0.0, 0.0]])

    @offers("ALVisualCompass.moveStraightTo", kind="walk", begins_walk=True)
    def _straight(self, distance: Length) -> Any:
        return self._walks["moveTo"](distance, 0.0, 0.0)


Length = Annotated[float, Range(-1e4, 1e4)]
"""m or rad"""


class VisualCompass(VisionExtractor):
    """`ALVisualCompass`: turn of the camera since its reference."""

    service = "ALVisualCompass"

    def __init__(self, robot: ServedRobot) -> None:
        super().__init__(robot)
        self._refreshes, self._ran, self._due = True, False, 0
        self._reference: Vec2 | None = None
        """Direction of the camera's axis at the reference."""

    def update(self, now: int) -> None:
        """Raise the event at the subscribers' period, in the cycle at `now` of the robot's clock, ms."""
        began, self._ran = self.running and not self._ran, self.running
        if began and (self._refreshes or self._reference is None):
            self._refer()
        if not self.processing or now < self._due or self._reference is None:
            return
        self._due = now + max(10, self.period)
        wy, wz = (now_ - then for now_, then in zip(self._direction(), self._reference, strict=True))
        deviation = [wy, math.remainder(wz, math.tau)]
        self._events.raise_event("VisualCompass/Deviation", [deviation, list(self._robot.place()), stamp()])

    def _direction(self) -> Vec2:
        """Direction of the camera's axis in FRAME_WORLD, rad: pitch down and heading."""
        x, y, z, _ = self._frames.transform(CAMERAS[self.camera], 1, True)[:, 0]
        return math.atan2(-z, math.hypot(x, y)), math.atan2(y, x)

    @offers("ALVisualCompass.setCurrentImageAsReference")
    def _refer(self) -> bool:
        self._reference = self._direction()
        return True

    @offers("ALVisualCompass.enableReferenceRefresh")
    def _refresh(self, enabled: bool) -> None:
        self._refreshes = enabled
