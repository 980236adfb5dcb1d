"""World commands from outside: for people's tools, viewers and campaigns; never for a controller."""

from __future__ import annotations

from typing import Final

from bridge.errors import FrameError, LinkError
from bridge.link import keys
from bridge.link.client import Client
from bridge.messages import decode, encode
from bridge.messages.world import COMMAND, WorldCommand
from bridge.messages.world_state import WorldReply

_CONNECT_TIMEOUT: Final = 10.0
"""s to wait for somebody to listen there."""


class WorldClient(Client):
    """Commands the world of one emulated robot; close it, or use it as a context manager.

    Example:
        from bridge.messages.world import Push
        with nao_hil.WorldClient() as world:
            print(world.send(Push(impulse=(0.0, 1.5, 0.0), duration=0.1)).text)

    Args:
        robot: Id of the robot.
        connect: Zenoh endpoint of the robot.
    """

    def __init__(self, robot: str = keys.DEFAULT_ROBOT, connect: str = keys.DEFAULT_ENDPOINT) -> None:
        super().__init__(robot, connect, _CONNECT_TIMEOUT, "world")

    def send(self, command: WorldCommand, timeout: float = 5.0) -> WorldReply:
        """Carry out a command, and say how the world is then.

        Args:
            command: To carry out.
            timeout: s to wait; a `Step` is answered when its cycles have run.

        Raises:
            FrameError: the robot refused the command; its own sentence.
            LinkError: nobody answered: no robot there, or one that has no world.
        """
        reply = self._ask(COMMAND, encode(command), timeout, FrameError)
        if reply is not None:
            return decode(reply, WorldReply)
        others = self._other_robots()
        raise LinkError(f"No emulated robot `{self._robot}` at {self._endpoint} answered{others}.")
