"""Orders of the page: each is decoded, carried out, and answered with one sentence."""

from __future__ import annotations

import json
import sys
import threading
from collections.abc import Callable
from typing import Annotated, Any, Final, Literal

import msgspec

from bridge.body import Body
from bridge.errors import FrameError, NaoHilError
from bridge.messages.walk import WalkCommand
from bridge.messages.world import Pause, Reset, Resume, Step, WorldCommand
from bridge.types import Finite, Vec3
from nao_hil.view.driving import Driving
from nao_hil.view.hand import Hand
from nao_hil.view.live import Commands

RESTART: Final = "restart"
"""Key of the line on stdout by which the page asks the command that started it for another run."""
LARGEST: Final = 65_536
"""Of an order, bytes."""


class _Order(msgspec.Struct, frozen=True, tag_field="do", forbid_unknown_fields=True):
    pass


class Walk(_Order, frozen=True, tag="walk"):
    """A command to the walker."""

    command: WalkCommand


class World(_Order, frozen=True, tag="world"):
    """A command to the emulator."""

    command: WorldCommand


class Key(_Order, frozen=True, tag="key"):
    """A key of `nao-hil drive`."""

    key: Annotated[str, msgspec.Meta(max_length=1)]


class Steer(_Order, frozen=True, tag="steer"):
    """Walk at a velocity, m/s, m/s, rad/s; zeros stop."""

    velocity: Vec3


class Stop(_Order, frozen=True, tag="stop"):
    """Emergency stop."""

    how: Literal["crouch", "limp"]


class Arm(_Order, frozen=True, tag="arm"):
    """Take commands again."""


class Slow(_Order, frozen=True, tag="slow"):
    """Robot time per time of the clock."""

    speed: Annotated[float, msgspec.Meta(gt=0.0, le=1.0)]


class Hold(_Order, frozen=True, tag="hold"):
    """Take the joints, or give them back."""

    on: bool


class Joints(_Order, frozen=True, tag="joints"):
    """Wanted angles of a robot that the page holds, rad."""

    angles: dict[str, Finite]


class Restart(_Order, frozen=True, tag="restart"):
    """Begin a new run with these settings of `nao-hil up`; what is left out stays."""

    settings: dict[str, str]


Order = Walk | World | Key | Steer | Stop | Arm | Slow | Hold | Joints | Restart
_DECODER: Final = msgspec.json.Decoder(Order)


class Orders:
    """Carries out what the page asks for.

    Args:
        commands: Clients of the robot.
        driving: The driver that all who look at the page share.
        hand: Holds the joints; None: they cannot be held.
        body: Of the robot.
        supervised: Whether a command is there that can begin another run.
    """

    def __init__(
        self, commands: Commands, driving: Driving, hand: Hand | None, body: Body, supervised: bool
    ) -> None:
        self._commands, self._driving, self._hand = commands, driving, hand
        self.body, self.supervised = body, supervised
        self._slow = SlowMotion(commands.world, body.cycle)

    def carry_out(self, text: str | bytes) -> tuple[str, bool]:
        """One order.

        Args:
            text: JSON.

        Returns:
            A sentence, and whether the order was carried out.
        """
        try:
            order = _DECODER.decode(text)
            return self._do(order), True
        except msgspec.MsgspecError as error:
            return f"This is no order of the page: {error}.", False
        except NaoHilError as error:
            return str(error), False

    def _do(self, order: Order) -> str:
        if isinstance(order, Key | Steer):
            return self._drive(order)
        resets = isinstance(order, World) and isinstance(order.command, Reset)
        if resets or isinstance(order, Walk | Stop | Arm):
            self._driving.let_go()
        if isinstance(order, World):
            return self._world(order.command)
        if isinstance(order, Walk):
            return self._commands.walk(order.command).text
        if isinstance(order, Stop):
            return (self._commands.stop() if order.how == "crouch" else self._commands.limp()).text
        if isinstance(order, Arm):
            return self._commands.arm().text
        if isinstance(order, Slow):
            return self._slow.set_speed(order.speed)
        if isinstance(order, Restart):
            return self._restart(order.settings)
        return self._joints(order)

    def _drive(self, order: Key | Steer) -> str:
        if isinstance(order, Key):
            return self._driving.press(order.key)
        return self._driving.steer(order.velocity)

    def _world(self, command: Any) -> str:
        if isinstance(command, Pause | Resume | Step | Reset):
            self._slow.stop()
        return self._commands.world(command).text

    def _joints(self, order: Hold | Joints) -> str:
        if self._hand is None:
            raise FrameError("The joints of a real robot are not moved from the page.")
        if isinstance(order, Joints):
            return self._hand.move(order.angles)
        return self._hand.take() if order.on else self._hand.let_go()

    def _restart(self, settings: dict[str, str]) -> str:
        if not self.supervised:
            raise FrameError("This page did not begin the run; start `nao-hil up` with other options.")
        print(json.dumps({RESTART: settings}), flush=True, file=sys.stdout)
        return "The run begins again; the page follows."

    def end(self) -> None:
        """Leave a world that goes on and a robot that is free."""
        self._slow.end()
        if self._hand is not None:
            self._hand.let_go()


class SlowMotion:
    """Steps the world, one cycle at a time.

    Args:
        send: Carries a world command out.
        cycle: The robot's cycle, s.
    """

    def __init__(self, send: Callable[[WorldCommand], object], cycle: float) -> None:
        self._send, self._cycle = send, cycle
        self._end = threading.Event()
        self._pace: threading.Thread | None = None

    def set_speed(self, speed: float) -> str:
        """Go on at this speed; 1: as fast as before.

        Returns:
            What was done, in a sentence.

        Raises:
            FrameError: refused.
            LinkError: no robot answers.
        """
        self.stop()
        if speed >= 1.0:
            self._send(Resume())
            return "The robot's time goes on at full speed."
        self._send(Pause())
        self._end.clear()
        self._pace = threading.Thread(target=self._run, args=(self._cycle / speed,), name="slow", daemon=True)
        self._pace.start()
        return f"The robot's time goes at {speed:g} of its speed."

    def end(self) -> None:
        """The page ends: a world that it slowed down goes on. Raises as `set_speed`."""
        if self._pace is not None:
            self.set_speed(1.0)

    def stop(self) -> None:
        """Step no more, once a step that is under way is done; the world stays as it is."""
        pace, self._pace = self._pace, None
        if pace is not None:
            self._end.set()
            pace.join()

    def _run(self, pause: float) -> None:
        while not self._end.wait(pause):
            try:
                self._send(Step())
            except NaoHilError:  # the robot is gone, or was told to go on
                return
