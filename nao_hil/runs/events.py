"""Events of a walk: in the world, pushes in the stride, new velocities; and a load."""

from __future__ import annotations

import math
from typing import Final

import msgspec
import numpy as np

from bridge.body import TORSO, Body
from bridge.messages import WalkTelemetry
from bridge.messages.world import Push
from bridge.types import Vec3
from emulator.world.events import EventExecutor, WorldEvent
from walker.controller import Controller

_TIME_TOLERANCE: Final = 1e-9
"""s; an event is not put off by rounding."""


class StridePush(msgspec.Struct, frozen=True, kw_only=True):
    """A push at the torso's centre of mass, at a phase of the stride."""

    time: float
    """Time of the walk from which on a stride is waited for, s."""
    phase: float | None
    """Part of the stride (two steps) since the left foot's single support began, 0 to 1; None: at once."""
    impulse: float
    """N s"""
    direction: float = 0.0
    """Direction of the push, in the torso's heading, rad: 0 forward, pi/2 to the left."""
    duration: float = 0.1
    """Duration of the push, s."""

    def command(self) -> Push:
        """To the world."""
        x, y = math.cos(self.direction), math.sin(self.direction)
        return Push(impulse=(self.impulse * x, self.impulse * y, 0.0), duration=self.duration)


class TorsoLoad(msgspec.Struct, frozen=True, kw_only=True):
    """A point mass fixed to the torso, which the walker does not know of."""

    mass: float
    """Mass of the load, kg."""
    at: Vec3
    """In the Torso frame, m."""

    def on(self, body: Body) -> Body:
        """The data sheet of the robot that carries it: parallel axes, about the common centre of mass."""
        torso = body.links[TORSO]
        total = torso.mass + self.mass
        com = tuple((torso.mass * a + self.mass * b) / total for a, b in zip(torso.com, self.at, strict=True))
        inertia = np.array(torso.inertia)
        for mass, place in ((torso.mass, torso.com), (self.mass, self.at)):
            x, y, z = (a - b for a, b in zip(place, com, strict=True))
            inertia += mass * np.array([y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z])
        links = body.links | {
            TORSO: msgspec.structs.replace(torso, mass=total, com=com, inertia=tuple(inertia))
        }
        return msgspec.structs.replace(body, links=links)


class WalkEvents:
    """Lets the events of a walk happen, each at its time of the walk.

    Args:
        world_events: With their times, s.
        pushes: Of the torso.
        velocities: New ones with their times, s; m/s, m/s, rad/s.
        executor: Carries out events in the robot's world.
    """

    def __init__(
        self,
        world_events: tuple[tuple[float, WorldEvent], ...],
        pushes: tuple[StridePush, ...],
        velocities: tuple[tuple[float, Vec3], ...],
        executor: EventExecutor,
    ) -> None:
        self._world_events = sorted(world_events, key=lambda event: event[0])
        self._pushes = sorted(pushes, key=lambda push: push.time)
        self._velocities = sorted(velocities, key=lambda change: change[0])
        self._executor = executor
        self._phase = ""
        self._stride: tuple[float, float] | None = None
        """Beginning of the stride under way, and duration of the one before, s."""

    def follow(self, message: WalkTelemetry, time: float) -> None:
        """Note the beginnings of strides; called in each cycle."""
        if message.phase == "SSL" != self._phase:
            self._stride = time, time - self._stride[0] if self._stride else math.inf
        self._phase = message.phase

    def happen(self, time: float, controller: Controller) -> None:
        """Carry out the events due at a time of the walk, s."""
        while self._world_events and time >= self._world_events[0][0] - _TIME_TOLERANCE:
            self._executor.execute(self._world_events.pop(0)[1])
        while self._velocities and time >= self._velocities[0][0] - _TIME_TOLERANCE:
            controller.steer(self._velocities.pop(0)[1])
        while self._pushes and self._due(self._pushes[0], time):
            self._executor.execute(self._pushes.pop(0).command())

    def _due(self, push: StridePush, time: float) -> bool:
        if push.phase is None:
            return time >= push.time - _TIME_TOLERANCE
        if self._stride is None:
            return False
        began, length = self._stride
        return began >= push.time - _TIME_TOLERANCE and time >= began + push.phase * length - _TIME_TOLERANCE
