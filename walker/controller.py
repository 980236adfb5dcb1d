"""The controller: a pure function of its state and a sensor frame.

One tick: estimate, advance the gait's phase machine, turn the plan into foot poses relative to the torso,
inverse kinematics, joint limits, one actuator frame. No clock, no I/O: the same object runs in a test, in
lockstep, in real time and on a robot.
"""

from __future__ import annotations

import math
from typing import Literal

import msgspec

from bridge.datasheet import Body
from bridge.joints import N_JOINTS
from bridge.messages import ActuatorFrame, SensorFrame, WalkTelemetry
from walker.approach import Approach
from walker.gait import Gait, Reference
from walker.pose import PoseMaker

State = Literal["approach", "walk", "stopping", "stand", "fallen"]

FALL_ANGLE = math.radians(45.0)
"""Torso roll or pitch that counts as a fall (the field's usual bound)."""
LIMP = 0.1
"""Stiffness after a fall: weak enough to yield, strong enough not to flop."""


class WalkOrder(msgspec.Struct, frozen=True, kw_only=True):
    """How far to walk: by steps, by time, or without end."""

    steps: int = 0
    """Steps to walk, the closing step included; 0: no bound. At least 2 when bounded."""
    duration: float = math.inf
    """s of walking after which the robot closes its feet and stands."""
    settle: float = 1.0
    """s to stand before the order counts as done."""


class Controller:
    """Walks by a gait.

    Args:
        body: data sheet of the robot.
        gait: phase machine in its initial stand.
        order: how far to walk.
        cycle: of the robot, s.
    """

    def __init__(self, body: Body, gait: Gait, order: WalkOrder, cycle: float) -> None:
        self._gait = gait
        self._order = order
        self._cycle = cycle
        self._reference = gait.stand()
        self._pose = PoseMaker(body, self._reference)
        self._approach: Approach | None = None
        self._state: State = "approach"
        self._seq: int | None = None
        self._walked = 0.0
        self._stood = 0.0
        self._command = (0.0,) * N_JOINTS
        self._stiffness = 1.0
        self._last_seq = 0

    @property
    def state(self) -> State:
        """What the controller is doing."""
        return self._state

    @property
    def done(self) -> bool:
        """The order is carried out (standing again, settled), or the robot fell and lies still."""
        return self._state in ("stand", "fallen") and self._stood >= self._order.settle

    @property
    def telemetry(self) -> WalkTelemetry:
        """The last tick's plan."""
        r = self._reference
        return WalkTelemetry(
            seq=self._last_seq,
            state=self._state,
            phase=r.phase,
            step=r.step,
            steps=self._order.steps,
            zmp=r.zmp,
            com=r.com,
            left=(r.left.x, r.left.y, r.left.z),
            right=(r.right.x, r.right.y, r.right.z),
        )

    def tick(self, frame: SensorFrame) -> ActuatorFrame:
        """One cycle.

        Args:
            frame: newest sensor frame; frames that were lost in between are made up for in the plan's time.
        """
        dt = self._cycle * (frame.seq - self._seq) if self._seq is not None else 0.0
        self._seq = self._last_seq = frame.seq
        self._detect_fall(frame)
        if self._state == "approach":
            self._tick_approach(frame, dt)
        elif self._state in ("walk", "stopping"):
            self._tick_walk(dt)
        else:
            self._stood += dt
        return ActuatorFrame(
            reply_to=frame.seq,
            position=self._command,
            stiffness=(self._stiffness,) * N_JOINTS,
        )

    def _detect_fall(self, frame: SensorFrame) -> None:
        if self._state != "fallen" and max(abs(frame.angle[0]), abs(frame.angle[1])) > FALL_ANGLE:
            self._state = "fallen"
            self._stood = 0.0
            self._command = frame.position
            self._stiffness = LIMP

    def _tick_approach(self, frame: SensorFrame, dt: float) -> None:
        if self._approach is None:
            self._approach = Approach(frame.position, self._pose.angles(self._reference))
        self._command = self._approach.advance(dt)
        if self._approach.done:
            self._state = "walk"

    def _tick_walk(self, dt: float) -> None:
        self._walked += dt
        enough = bool(self._order.steps) and self._reference.step >= self._order.steps - 1
        go_on = not enough and self._walked < self._order.duration
        if not go_on:
            self._state = "stopping"
        self._reference = self._gait.advance(dt, go_on=go_on)
        self._command = self._pose.angles(self._reference)
        if not go_on and self._reference.phase == "stand":
            self._state = "stand"
            self._stood = 0.0


def planned_reference(controller: Controller) -> Reference:
    """The plan of the last tick, for figures and tests."""
    return controller._reference
