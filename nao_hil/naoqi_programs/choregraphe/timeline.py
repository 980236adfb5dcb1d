"""The timeline of a box: curves of joints, and diagrams at their frames; scripts move it on and back."""

from __future__ import annotations

import math
import threading
import time
from typing import Any, Final

from nao_hil.naoqi_programs.choregraphe.project import PARENT, Curve, LiveBox

_SHORTEST: Final = 0.04
"""s to the first key."""


class Timeline:
    """Plays along the wall clock."""

    def __init__(self, running: LiveBox) -> None:
        self._running, self._box = running, running.box
        self._changed = threading.Condition()
        self._order: tuple[float | None, bool] | None = None
        """Frame to jump to (None: the present one), and whether to play on."""
        self._stopped = self._started = self._moves = False
        self.loaded: set[int] = set()
        """Numbers of the diagrams at the present frame."""

    def go_to(self, frame: Any = None, plays: bool | None = None) -> None:
        """Continue from a frame, or rest there.

        Args:
            frame: its number or its name; None: the present one.
            plays: whether to play on; None: as now.

        Raises:
            RuntimeError: no frame has this name.
        """
        wanted = None if frame is None else self._box.frame_of(frame)
        with self._changed:
            before, moves = self._order or (None, self._moves)
            wanted, moves = before if wanted is None else wanted, moves if plays is None else plays
            self._order = wanted, moves
            idle = not self._started
            self._changed.notify_all()
        if idle and moves:
            self._running.player.start(lambda: self.play(self._box.start if wanted is None else wanted))

    def stop(self) -> None:
        """End it: the joints stay where they are."""
        with self._changed:
            self._stopped = True
            self._changed.notify_all()

    def play(self, frame: float, *signal: Any) -> None:
        """Play from a frame to the end, as scripts order on the way; the box is left at the end.

        Args:
            signal: input and value that start it; the diagrams there receive them.
        """
        with self._changed:
            played, self._started, self._stopped = self._started, True, False
            self._order = (frame, True) if played else None
            self._changed.notify_all()
        if not played:
            self.loaded = set()
            self._load(frame)
        for number in self.loaded if signal else ():
            self._running.follow(number, PARENT, *signal)
        if not played:
            self._play_pieces(frame)

    def _load(self, frame: float) -> None:
        """Load the diagrams at a frame: those that begin there, and those that were not there before."""
        frame = max(1.0, frame)
        before, self.loaded = self.loaded, self._box.diagrams_at(frame)
        for number in sorted(self.loaded):
            if number not in before or self._box.diagrams[number].frame == frame:
                self._running.enter(number)

    def _play_pieces(self, frame: float) -> None:
        self._moves = True
        while self._moves or not self._stopped:
            began = time.monotonic()
            ended = self._play_piece(frame, began) if self._moves else self._rest()
            if self._stopped or self._running.player.ended.is_set():
                break
            if ended:
                self._started = self._moves = False
                self._running.emit("onStopped")
                return
            here = frame + (time.monotonic() - began) * self._box.fps if self._moves else frame
            with self._changed:
                wanted, self._moves = self._order or (None, True)
                self._order = None
            frame = here if wanted is None else wanted
            if wanted is not None:
                self._load(wanted)
        self._started = self._moves = False
        self._end_motion()

    def _rest(self) -> bool:
        """Wait for an order."""
        self._end_motion()
        with self._running.player.resting(), self._changed:
            while self._order is None and not self._stopped and not self._running.player.ended.is_set():
                self._changed.wait(0.1)
        return False

    def _play_piece(self, frame: float, began: float) -> bool:
        """Play from a frame until the end (True) or an order; `began` is of the monotonic clock, s."""
        box, running = self._box, self._running
        moving = [curve for curve in (_behind(curve, frame) for curve in box.curves) if curve.frames]
        done = threading.Event()
        if moving:
            running.player.start(lambda: self._move(moving, frame, done))
        else:
            done.set()
        last = box.end or max((curve.frames[-1] for curve in moving), default=frame)
        for keyframe in sorted({diagram.frame for diagram in box.diagrams}):
            if max(1.0, frame) < keyframe <= (box.end or math.inf):
                if self._wait_until(began + (keyframe - frame) / box.fps):
                    return False
                self._load(keyframe)
        if self._wait_until(began + (last - frame) / box.fps):
            return False
        while not done.is_set():
            if self._wait_until(time.monotonic() + 0.05):
                return False
        return True

    def _wait_until(self, moment: float) -> bool:
        """Wait for a moment of the monotonic clock, s; whether an order or the end is earlier."""
        with self._changed:
            while self._order is None and not self._stopped and not self._running.player.ended.is_set():
                remaining = moment - time.monotonic()
                if remaining <= 0.0:
                    return False
                self._changed.wait(min(remaining, 0.1))
        return True

    def _move(self, curves: list[Curve], frame: float, done: threading.Event) -> None:
        """Send the joints along the curves from a frame on."""
        player, name = self._running.player, self._box.name
        try:
            known = set(player.services("ALMotion").getBodyNames("Body"))
            for curve in curves:
                if curve.actuator not in known:
                    player.cannot(f"the timeline of {name}: this robot has no {curve.actuator}")
            there = [curve for curve in curves if curve.actuator in known]
            if there:
                values = [[_angle(c.actuator, value) for value in c.values] for c in there]
                times = [[max(_SHORTEST, (f - frame) / self._box.fps) for f in c.frames] for c in there]
                player.services("ALMotion").angleInterpolation([c.actuator for c in there], values, times, True)
        except Exception as error:
            player.cannot(f"the timeline of {name}: {error}")
        done.set()

    def _end_motion(self) -> None:
        joints = [curve.actuator for curve in self._box.curves]
        motion: Any = self._running.player.services("ALMotion")
        known = set(motion.getBodyNames("Body"))
        if joints := [joint for joint in joints if joint in known]:
            motion.killTasksUsingResources(joints)


def _behind(curve: Curve, frame: float) -> Curve:
    """The keys of a curve behind a frame."""
    keys = [(f, v) for f, v in zip(curve.frames, curve.values, strict=True) if f > frame]
    return Curve(curve.actuator, tuple(f for f, _ in keys), tuple(v for _, v in keys))


def _angle(actuator: str, value: float) -> float:
    """A key's value for ALMotion: rad, or 0 to 1 of a hand, whose keys may be percent (assumed)."""
    if actuator.endswith("Hand"):
        return value / 100.0 if value > 1.0 else value
    return math.radians(value)
