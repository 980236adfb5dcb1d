"""World commands from outside: for people's tools, viewers and campaigns; never for a controller."""

from __future__ import annotations

from types import TracebackType

from bridge.errors import FrameError, LinkError
from bridge.link import keys
from bridge.link.session import open_client
from bridge.messages import decode, encode
from bridge.world import COMMAND, WorldCommand, WorldReply


class WorldClient:
    """Commands the world of one emulated robot; close it, or use it as a context manager.

    Args:
        robot: Id of the robot.
        connect: Zenoh endpoint of the robot.
    """

    def __init__(self, robot: str = keys.DEFAULT_ROBOT, connect: str = keys.DEFAULT_ENDPOINT) -> None:
        self._key = keys.key(keys.check_name("Robot id", robot), COMMAND)
        self._endpoint = connect
        self._session = open_client(connect, role="world")

    def send(self, command: WorldCommand, timeout: float = 5.0) -> WorldReply:
        """Carry out a command, and say how the world is then.

        Args:
            command: What to do.
            timeout: s to wait; a `Step` is answered when its cycles have run.

        Raises:
            FrameError: the robot refused the command; its own sentence.
            LinkError: nobody answered: no robot there, or one that has no world.
        """
        for reply in self._session.get(self._key, payload=encode(command), timeout=timeout):
            if reply.ok is not None:
                return decode(reply.ok.payload.to_bytes(), WorldReply)
            if reply.err is not None:
                text = reply.err.payload.to_bytes().decode(errors="replace")
                if text and text != "Timeout":  # Zenoh's own word for no answer
                    raise FrameError(text)
        raise LinkError(f"No emulated robot at {self._endpoint} answered within {timeout:g} s.")

    def close(self) -> None:
        """Leave the network."""
        self._session.close()

    def __enter__(self) -> WorldClient:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
