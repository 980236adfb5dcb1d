"""The process that draws the pictures of a robot's cameras, from the ground truth on the link.

It is apart from the robot's process and below it in priority, so that a picture costs no cycle, and idle until
the first request. Boxes and things are asked for `WORLD_RATE` times a second; the robot itself is where the
newest ground truth has it.
"""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import threading
import time
from typing import Any, Final

import msgspec
import numpy as np

from bridge.adapters.naoqi.core.cameras import Pipe
from bridge.body import body_of
from bridge.body.joints import INDEX
from bridge.errors import FrameError, LinkError, NaoHilError
from bridge.link import keys
from bridge.link.client import WorldClient
from bridge.link.query import ask
from bridge.link.session import open_client, subscribe
from bridge.messages import Info, TruthFrame, decode
from bridge.messages.world import Status
from bridge.messages.world_state import Field, WorldReply
from bridge.types import Array
from emulator.camera.picture import PaintedField, draw, hidden
from emulator.camera.scene import (
    CameraScene,
    encode_picture,
    facing_away,
    floor_of,
    objects_of,
    picture_file,
    thing_of,
)
from emulator.camera.shapes import NEAR

WORLD_RATE: Final = 5.0
"""Queries of the world's objects per second."""
SIGHT_RATE: Final = 20.0
"""Reports a second of the things that the cameras see."""
_CONNECT: Final = 10.0
"""s to wait for the robot."""


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
        self._pipe = pipe
        self._truth: tuple[float, bytes] | None = None
        self._world: WorldReply | None = None
        self._field: Field | None = None
        self._painted: PaintedField | None = None
        self._session = open_client(endpoint, _CONNECT)
        answer = ask(self._session, keys.key(robot, keys.INFO), b"", _CONNECT, LinkError)
        if answer is None:
            raise LinkError(f"The robot `{robot}` at {endpoint} does not answer.")
        info = decode(answer, Info)
        self._scene = CameraScene(body_of(info.body, info.sheet))
        subscribe(self._session, keys.topic_key(robot, TruthFrame), self._note_truth)
        self._client = WorldClient(robot, endpoint)
        self._asked, self._watched = threading.Event(), threading.Event()
        """Whether a picture or sights were requested, and whether sights were."""
        for work in (self._ask_world, self._report):
            threading.Thread(target=work, daemon=True).start()

    def _note_truth(self, payload: bytes) -> None:
        self._truth = time.time(), payload

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
            time.sleep(1.0 / WORLD_RATE)

    def _now(self) -> tuple[float, TruthFrame, WorldReply] | None:
        """Arrival of the newest ground truth (s since 1970), and the state of the world; None: unknown."""
        if self._truth is None or self._world is None:
            return None
        moment, payload = self._truth
        try:
            return moment, decode(payload, TruthFrame), self._world
        except FrameError:
            return None

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
                moment, truth, world = now
                links = self._scene.links(truth)
                self._pipe.send([number, True, [moment, self._picture(links, world, *request)]])

    def _picture(
        self,
        links: dict[str, Array],
        world: WorldReply,
        camera: int,
        width: int,
        height: int,
        space: int,
        file: str,
    ) -> bytes:
        white = self._field.goals if self._field is not None else ()
        solids = [*self._scene.limbs(links), *objects_of(world, white), *map(thing_of, world.things)]
        rgb = draw(self._scene.view(camera, links), floor_of(world, self._painted), solids, width, height)
        return picture_file(rgb, space, file) if file else encode_picture(rgb, space)

    def _report(self) -> None:
        told: list[Any] = []
        self._watched.wait()
        while True:
            time.sleep(1.0 / SIGHT_RATE)
            now = self._now()
            seen = [] if now is None else self._picked_views(*now[1:])
            if seen or told:
                self._pipe.send([0, seen])
            told = seen

    def _picked_views(self, truth: TruthFrame, world: WorldReply) -> list[Any]:
        """Sights (see `bridge.adapters.naoqi.core.cameras`) of the things that nothing hides."""
        if not world.things:
            return []
        links = self._scene.links(truth)
        others = [*self._scene.limbs(links), *objects_of(world)]
        head = [truth.joints[INDEX[name]] for name in ("HeadYaw", "HeadPitch")]
        sightings = []
        for camera in (0, 1):
            view = self._scene.view(camera, links)
            for thing in world.things:
                place = np.array(thing.position)
                before = [*others, *(thing_of(t) for t in world.things if t is not thing)]
                if facing_away(thing, view.eye) or view.seen(place)[0] <= NEAR or hidden(place, view, before):
                    continue
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
