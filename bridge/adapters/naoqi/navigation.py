"""ALNavigation, ALVisualCompass and ALLocalization, by the odometry: no obstacle is seen, no view compared."""

from __future__ import annotations

import itertools
import logging
import math
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import Any, Final

from bridge.adapters.naoqi.arguments import flag, number, text
from bridge.adapters.naoqi.events import Events
from bridge.adapters.naoqi.extractor import VisionExtractor
from bridge.adapters.naoqi.frames import RobotFrames
from bridge.adapters.naoqi.methods import Table
from bridge.adapters.naoqi.vision import CAMERAS
from bridge.errors import NaoqiRefused
from bridge.rotations import planar_local
from bridge.types import Vec2, Vec3

logger = logging.getLogger(__name__)

FARTHEST: Final = 3.0
"""m to which `navigateTo` goes (vendor's page)."""
_OK, _NO_PANORAMA, _STOPPED, _NO_FOLDER = 0, 3, 9, 105
_CODES: Final = {
    _OK: "OK, the method was called successfully.",
    _NO_PANORAMA: "The panorama has not been set.",
    _STOPPED: "The robot has been interrupted by a stop.",
    _NO_FOLDER: "Directory not found.",
}
"""Return codes of `ALLocalization` (vendor's page)."""
MAX_SAVED: Final = 1000
_ALONG: Final = "ALNavigation.moveAlong"
MAX_WAYS: Final = 1000
_DEEPEST: Final = 10
"""Compositions within each other."""
_ARC: Final = 0.3
"""rad of a circle that one straight piece stands for."""
_WIDEST: Final = 100.0
"""rad of a circle at most."""


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
        {"navigateTo": navigate, "moveAlong": lambda path: walks["moveTo"](ways_along(path))}
        if "moveTo" in walks
        else {}
    )


def ways_along(trajectory: Any) -> list[list[float]]:
    """The ways that follow a trajectory of `ALNavigation.moveAlong`, each from the end of the one before.

    Args:
        trajectory: `["Holonomic", path, final theta, final time]` or `["Composed", trajectory, ...]`; a path is
            `["Line", [x, y]]`, `["Circle", [x, y], span]` about x, y, or `["Composed", path, ...]`; m, rad, s.
            Each begins where the one before ends (assumed: a trajectory with its heading, a path without).

    Returns:
        `[x, y, theta]` of each way, m and rad; the heading changes in proportion to the length.

    Raises:
        NaoqiRefused: it is none, or too long.
    """
    parts = _parts(trajectory, 0)
    ways: list[list[float]] = []
    for part in parts:
        if len(part) != 4 or part[0] != "Holonomic":
            raise _no_trajectory(part)
        turn = number(part[2], f"{_ALONG}: final theta", -math.tau, math.tau)
        number(part[3], f"{_ALONG}: final time", 0.0)
        steps = [step for path in _parts(part[1], 0) for step in _steps(path)]
        length = math.fsum(math.hypot(*step) for step in steps)
        heading = 0.0
        for step in steps:
            share = turn * (math.hypot(*step) / length if length else 1.0 / len(steps))
            ways.append([*planar_local((0.0, 0.0, heading), step), share])
            heading += share
        if len(ways) > MAX_WAYS:
            raise NaoqiRefused(f"{_ALONG}: the trajectory has more than {MAX_WAYS} pieces.")
    return ways


def _parts(whole: Any, depth: int) -> list[list[Any]]:
    """Pieces of a trajectory or a path, one after the other."""
    if not isinstance(whole, list | tuple) or not whole or depth > _DEEPEST or len(whole) > MAX_WAYS:
        raise _no_trajectory(whole)
    if whole[0] != "Composed":
        return [list(whole)]
    parts = [part for piece in whole[1:] for part in _parts(piece, depth + 1)]
    if not parts:
        raise _no_trajectory(whole)
    return parts


def _steps(path: list[Any]) -> list[Vec2]:
    """Straight pieces of a line or an arc, m."""
    if path[0] == "Line" and len(path) == 2:
        return [_point(path[1])]
    if path[0] != "Circle" or len(path) != 3:
        raise _no_trajectory(path)
    x, y = _point(path[1])
    span = number(path[2], f"{_ALONG}: span", -_WIDEST, _WIDEST)
    count = max(1, math.ceil(abs(span) / _ARC))
    ends = [
        (x - x * math.cos(a) + y * math.sin(a), y - x * math.sin(a) - y * math.cos(a))
        for a in (span * i / count for i in range(count + 1))
    ]
    return [(b[0] - a[0], b[1] - a[1]) for a, b in itertools.pairwise(ends)]


def _point(value: Any) -> Vec2:
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise NaoqiRefused(f"{_ALONG}: {value!r:.60} was given; a place [x, y] is expected.")
    return number(value[0], f"{_ALONG}: x", -1e3, 1e3), number(value[1], f"{_ALONG}: y", -1e3, 1e3)


def _no_trajectory(value: Any) -> NaoqiRefused:
    return NaoqiRefused(
        f'{_ALONG}: {value!r:.60} is no trajectory; ["Holonomic", path, theta, time] or ["Composed", ...] of '
        'these is expected, with paths ["Line", [x, y]], ["Circle", [x, y], span] or ["Composed", ...].'
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


class Localization:
    """`ALLocalization`: home is where it was learnt, by the odometry.

    Args:
        walks: methods of `ALMotion`.
    """

    def __init__(self, walks: Table) -> None:
        self._walks = walks
        self._home: Vec3 | None = None
        self._saved: dict[str, Vec3] = {}

    def _place(self) -> Vec3:
        """From home, or from the beginning of the odometry."""
        x, y, theta = self._walks["getRobotPosition"](True)
        home = self._home or (0.0, 0.0, 0.0)
        return *planar_local(home, (x, y)), math.remainder(theta - home[2], math.tau)

    def _learn(self) -> int:
        self._home = None
        self._home = self._place()
        return _OK

    def _go(self, target: Vec3) -> Any:
        """Walk to a place in the frame of home, m and rad; a return code."""
        if self._home is None:
            return _NO_PANORAMA
        here = self._place()
        way = (*planar_local(here, target), math.remainder(target[2] - here[2], math.tau))
        return _code_of(self._walks["moveTo"](*way))

    def _save(self, folder: Any) -> int:
        name = text(folder, "ALLocalization.save: directory")
        if self._home is None:
            return _NO_PANORAMA
        if len(self._saved) < MAX_SAVED:
            self._saved[name] = self._home
        return _OK

    def _load(self, folder: Any) -> int:
        home = self._saved.get(text(folder, "ALLocalization.load: directory"))
        if home is None:
            return _NO_FOLDER
        self._home = home
        return _OK

    def _clear(self, folder: Any) -> int:
        gone = self._saved.pop(text(folder, "ALLocalization.clear: directory"), None)
        return _NO_FOLDER if gone is None else _OK

    def methods(self) -> Table:
        """Methods of the service."""
        if "moveTo" not in self._walks:
            return {}
        return {
            "learnHome": self._learn,
            "goToHome": lambda: self._go((0.0, 0.0, 0.0)),
            "goToPosition": lambda theta: self._go(
                (*self._place()[:2], number(theta, "ALLocalization.goToPosition: theta", -math.tau, math.tau))
            ),
            "getRobotPosition": lambda active=False: list(self._place()),
            "getRobotOrientation": lambda active=False: [self._place()[2], True, 1.0, True],
            "isDataAvailable": lambda: self._home is not None,
            "isRelocalizationRequired": lambda: False,
            "stopAll": lambda: self._walks["stopMove"](),
            "save": self._save,
            "load": self._load,
            "clear": self._clear,
            "getMessageFromErrorCode": lambda code: _CODES.get(code, "") if isinstance(code, int) else "",
        }


def _code_of(walk: Future[Any]) -> Future[Any]:
    """The return code of a walk, at its end."""
    ended: Future[Any] = Future()

    def end(done: Future[Any]) -> None:
        error = done.exception()
        if error is None:
            ended.set_result(_OK if done.result() else _STOPPED)
        else:
            ended.set_exception(error)

    walk.add_done_callback(end)
    return ended
