"""The process that draws the pictures of a robot's cameras, from the ground truth on the link.

It is apart from the robot's process and below it in priority, so that a picture costs no cycle, and idle until
the first request. Things and fixed objects are asked for `WORLD_RATE` times a second; robots and movable
objects are where the newest ground truth has them.
"""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import threading
import time
from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import msgspec
import numpy as np

from bridge.adapters.naoqi.core.cameras import Pipe
from bridge.body import Body
from bridge.body.joints import INDEX
from bridge.errors import LinkError, NaoHilError
from bridge.link.client import WorldClient
from bridge.link.robots import LinkRobots
from bridge.messages import TruthFrame
from bridge.messages.world import Status
from bridge.messages.world_state import Field, WorldReply
from emulator.camera.mesh import Mesh
from emulator.camera.picture import PaintedField, View, draw, hidden
from emulator.camera.scene import (
    RobotModel,
    encode_picture,
    facing_away,
    floor_of,
    objects_of,
    picture_file,
    thing_of,
)
from emulator.camera.shapes import NEAR

WORLD_RATE: Final = 5.0
"""Queries a second for the robots of the link and the world's objects."""
SIGHT_RATE: Final = 20.0
"""Reports a second of the things that the cameras see."""
_CONNECT: Final = 10.0
"""s to wait for the robot."""


class _Moment(NamedTuple):
    """The scene of one instant."""

    time: float
    """s since 1970"""
    truth: TruthFrame
    """Ground truth of the robot with the cameras."""
    world: WorldReply
    views: Sequence[View]
    """Views that its cameras are asked for."""
    robots: Sequence[Mesh]
    """All robots, that one without its head."""


class CameraProcess:
    """Draws on request, and reports visible things.

    Args:
        robot: id.
        endpoint: of the robot.
        pipe: to the requester of pictures.

    Raises:
        LinkError: the robot does not answer.
        ConfigurationError: it has a body that is not known.
    """

    def __init__(self, robot: str, endpoint: str, pipe: Pipe) -> None:
        self._pipe, self._robot = pipe, robot
        self._world: WorldReply | None = None
        self._field: Field | None = None
        self._painted: PaintedField | None = None
        self._robots, self._models = LinkRobots(endpoint), dict[str, RobotModel]()
        deadline = time.monotonic() + _CONNECT
        while robot not in self._robots.update():
            if time.monotonic() > deadline:
                raise LinkError(f"The robot `{robot}` at {endpoint} does not answer.")
            time.sleep(0.05)
        self._own = self._robots.found[robot]
        self._client = WorldClient(robot, endpoint)
        self._asked, self._watched = threading.Event(), threading.Event()
        """Whether a picture or sights were requested, and whether sights were."""
        for work in (self._ask_world, self._report):
            threading.Thread(target=work, daemon=True).start()

    def _ask_world(self) -> None:
        self._asked.wait()
        while True:
            with contextlib.suppress(NaoHilError):  # the robot is unreachable
                before, world = self._world, self._client.send(Status())
                if before is None or world.time < before.time:  # the ground is another one after a restart
                    terrain = self._client.send(Status(terrain=True)).terrain
                    self._field = terrain.field if terrain is not None else None
                    self._painted = None if self._field is None else PaintedField(self._field)
                self._world = world
                self._robots.update()
            time.sleep(1.0 / WORLD_RATE)

    def _now(self) -> _Moment | None:
        """The scene of now; None: the pose of the robot or the state of the world is unknown."""
        others = {self._robot: self._own} | self._robots.found
        robot = others.pop(self._robot)
        seen, world = robot.seen, self._world
        if seen is None or world is None:
            return None
        model, truth = self._model(self._robot, robot.body), seen[1]
        links = model.links(truth)
        meshes = [model.mesh(links, head=False)]
        for name, other in others.items():
            if (pose := other.truth) is not None:
                shown = self._model(name, other.body)
                meshes.append(shown.mesh(shown.links(pose)))
        fixed = {thing.name: thing for thing in world.objects if thing.mass <= 0.0}
        objects = fixed | {thing.name: thing for thing in truth.objects}
        world = msgspec.structs.replace(world, objects=tuple(objects.values()))
        return _Moment(seen[0], truth, world, [model.view(camera, links) for camera in (0, 1)], meshes)

    def _model(self, name: str, body: Body) -> RobotModel:
        if name not in self._models or self._models[name].body != body:
            self._models[name] = RobotModel(body)
        return self._models[name]

    def serve(self) -> None:
        """Answer requests until the other end closes: `[number, camera, ...]`; `[0]` begins the sights."""
        while (message := self._pipe.receive()) is not None:
            number, *request = message
            self._asked.set()
            if not number:
                self._watched.set()
                continue
            deadline = time.monotonic() + _CONNECT
            while (now := self._now()) is None and time.monotonic() < deadline:
                time.sleep(0.02)
            if now is None:
                self._pipe.send(
                    [
                        number,
                        False,
                        "The robot does not publish its pose; only an emulated one has cameras here.",
                    ]
                )
            else:
                self._pipe.send([number, True, [now.time, self._picture(now, *request)]])

    def _picture(self, now: _Moment, camera: int, width: int, height: int, space: int, file: str) -> bytes:
        white = self._field.goals if self._field is not None else ()
        solids = [*objects_of(now.world, white), *map(thing_of, now.world.things)]
        floor = floor_of(now.world, self._painted)
        rgb = draw(now.views[camera], floor, solids, width, height, now.robots)
        return picture_file(rgb, space, file) if file else encode_picture(rgb, space)

    def _report(self) -> None:
        told: list[Any] = []
        self._watched.wait()
        while True:
            time.sleep(1.0 / SIGHT_RATE)
            watched = self._world is not None and self._world.things
            now = self._now() if watched else None
            seen = [] if now is None else _picked_views(now)
            if seen or told:
                self._pipe.send([0, seen])
            told = seen


def _picked_views(now: _Moment) -> list[Any]:
    """Sights (see `bridge.adapters.naoqi.core.cameras`) of the things that nothing hides."""
    things, objects = now.world.things, objects_of(now.world)
    head = [now.truth.joints[INDEX[name]] for name in ("HeadYaw", "HeadPitch")]
    sightings = []
    for camera, view in enumerate(now.views):
        for thing in things:
            place = np.array(thing.position)
            before = [*objects, *(thing_of(t) for t in things if t is not thing)]
            if facing_away(thing, view.eye) or view.seen(place)[0] <= NEAR:
                continue
            if not hidden(place, view, before, now.robots):
                sightings.append([camera, thing.kind, thing.name, view.seen(place).tolist(), thing.size, head])
    return sightings


def main(robot: str, endpoint: str, descriptor: int) -> None:
    """Serve one robot's cameras."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the serving process ends this one
    pipe = Pipe(socket.socket(fileno=descriptor))
    try:
        cameras = CameraProcess(robot, endpoint, pipe)
        cameras.serve()
    except (NaoHilError, msgspec.MsgspecError) as error:
        pipe.send([-1, False, str(error)])
    os._exit(0)  # threads wait for messages
