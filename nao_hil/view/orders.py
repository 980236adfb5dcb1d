"""Orders of the page: decoded, carried out, answered with one sentence; driving, and joints by hand."""

from __future__ import annotations

import contextlib
import json
import sys
import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import msgspec
import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX, JOINTS
from bridge.errors import FrameError, NaoHilError, WalkRefused
from bridge.messages.walk import WalkCommand
from bridge.messages.world import Pause, Reset, Resume, Step, WorldCommand
from bridge.types import Finite, Vec3
from nao_hil.connection import connect
from nao_hil.drive.session import Session, Walker
from nao_hil.runs.config import run_config
from nao_hil.view.live import Commands

ABSENCE_TIMEOUT: Final = 2.5
"""s without a viewer after which the robot that the page drives is stopped."""
JOINT_RATE: Final = 1.0
"""Speed of a joint towards its slider's angle, rad/s."""
CONNECT_TIMEOUT: Final = 3.0
"""s for a robot to answer."""
RESTART: Final = "restart"
"""Key of the line on stdout by which the page asks the command that started it for another run."""
MAX_ORDER_SIZE: Final = 65_536
"""Largest size of an order, bytes."""


class Driving:
    """The one driver of all viewers of the page.

    Args:
        walker: Gives the walker to drive; raises LinkError without one.
        absence: Time since a browser last showed the page, s: after `ABSENCE_TIMEOUT` the robot is stopped; if
            this process dies, its walk ends by itself (`nao_hil.drive.driver.HOLD`).
    """

    def __init__(self, walker: Callable[[], Walker], absence: Callable[[], float]) -> None:
        self._walker, self._absence = walker, absence
        self._lock = threading.Lock()
        self._session: Session | None = None

    def press(self, key: str) -> str:
        """Act on a key of `nao-hil drive`.

        Returns:
            A sentence on the result.

        Raises:
            LinkError: no walker takes commands.
            WalkRefused: the walker has no robot.
        """
        return self._execute(lambda session: session.take([key]))

    def steer(self, velocity: Vec3) -> str:
        """Walk at a velocity, forward and to the left, m/s, and turn, rad/s; returns and raises as `press`."""
        return self._execute(lambda session: session.steer(velocity))

    def order(self, command: WalkCommand) -> str:
        """Carry out a command of another form; returns and raises as `press`."""
        with self._lock:
            return self._opened().order(command)

    def _execute(self, act: Callable[[Session], None]) -> str:
        with self._lock:
            session = self._opened()
            refused = session.refused
            act(session)
            if session.refused > refused:
                raise WalkRefused(session.reply)
            return session.reply

    def _opened(self) -> Session:
        session = self._session or Session(self._walker())
        self._session = session
        return session

    def release(self) -> None:
        """Drop the target and its keepalive: the robot is stopped, or begins again.

        Without the lock: a walker that does not answer holds it for seconds, and no emergency stop waits.
        """
        self._session = None

    def keep_alive(self) -> None:
        """Send a keepalive if one is due, or the stop; call it every second or oftener."""
        with self._lock:
            if (session := self._session) is None:
                return
            with contextlib.suppress(NaoHilError):  # a walker that does not answer in time is asked again
                if self._absence() < ABSENCE_TIMEOUT:
                    session.take([])
                    return
                if session.walks:
                    with contextlib.suppress(WalkRefused):  # the walker has lost its robot
                        session.order(WalkCommand(op="stop"))
                self._session = None


class Hand:
    """Holds the joints while the page wants to.

    Args:
        body: Whose ranges they have.
        robot: Id of the robot.
        endpoint: Zenoh endpoint of the robot.
        notify: Called with a sentence when the robot is lost.
    """

    def __init__(self, body: Body, robot: str, endpoint: str, notify: Callable[[str], None]) -> None:
        self._body, self._robot, self._endpoint, self._notify = body, robot, endpoint, notify
        self._end: threading.Event | None = None
        self._held = threading.Event()
        self._wanted = np.zeros(len(JOINTS))

    @property
    def holds(self) -> bool:
        """Whether the page holds the robot."""
        return self._held.is_set()

    def move(self, angles: Mapping[str, float]) -> str:
        """Want these angles, rad; the joints approach them at `JOINT_RATE`.

        Raises:
            FrameError: no such joint, or the page does not hold the robot.
        """
        if not self.holds:
            raise FrameError("The page does not hold the robot; take the joints first.")
        for name, angle in angles.items():
            if name not in self._body.joints:
                raise FrameError(f"`{name}` is no joint of {self._body.name}.")
            joint = self._body.joints[name]
            self._wanted[INDEX[name]] = min(max(angle, joint.lower), joint.upper)
        return ""

    def take(self) -> str:
        """Take the robot's lease and hold its joints where they are."""
        if self._end is None:
            self._end = threading.Event()
            threading.Thread(target=self._hold, args=(self._end,), name="hand", daemon=True).start()
        return "The page asks for the robot."

    def release(self) -> str:
        """Give the robot back."""
        if self._end is not None:
            self._end.set()
        return "The robot is free."

    def _hold(self, end: threading.Event) -> None:
        try:
            with connect(self._endpoint, robot=self._robot, name="page", timeout=CONNECT_TIMEOUT) as robot:
                target = np.array(robot.first_target)
                self._wanted[:] = target
                self._held.set()
                self._notify("The page holds the robot; its joints go where the sliders are.")
                step = JOINT_RATE * self._body.cycle
                while not end.is_set():
                    target += np.clip(self._wanted - target, -step, step)
                    robot.step(target)
        except NaoHilError as error:
            self._notify(str(error))
        self._held.clear()
        self._end = None


class _Order(msgspec.Struct, frozen=True, kw_only=True, tag_field="do", forbid_unknown_fields=True):
    robot: str = ""
    """That the page showed with the button; empty: the one that is shown now."""


class Choose(_Order, frozen=True, tag="choose"):
    """Show this robot."""


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


class StopAll(_Order, frozen=True, tag="stop-all"):
    """Emergency stop of all robots."""


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


class RestartSettings(msgspec.Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Settings that the page may change."""

    robot: str | None = None
    wear: str | None = None
    scenario: str | None = None


class Restart(_Order, frozen=True, tag="restart"):
    """Begin a new run with these settings of `nao-hil up`; the others stay."""

    settings: RestartSettings


RobotOrder = Walk | World | Key | Steer | Stop | Arm | Slow | Hold | Joints | Restart
Order = RobotOrder | Choose | StopAll


_DECODER: Final = msgspec.json.Decoder(Order)


def answered(text: str | bytes, execute: Callable[[Order], str]) -> tuple[str, bool]:
    """Decode an order and carry it out.

    Args:
        text: JSON.
        execute: Carries it out; returns a sentence.

    Returns:
        A sentence, and whether the order is carried out.
    """
    try:
        return execute(_DECODER.decode(text)), True
    except msgspec.MsgspecError as error:
        return f"This is no order of the page: {error}.", False
    except NaoHilError as error:
        return str(error), False


class Orders:
    """Carries out the orders of the page to one robot.

    Args:
        commands: Clients of the robot.
        driving: The driver of all viewers of the page.
        hand: Holds the joints; None: they cannot be held.
        body: Of the robot.
        config: Gives the configuration file of the run, where a command is there that can begin another one;
            None: there is none.
        slow: Of the robot's world; None: one of its own.
    """

    def __init__(
        self,
        commands: Commands,
        driving: Driving,
        hand: Hand | None,
        body: Body,
        config: Callable[[], Path] | None,
        slow: SlowMotion | None = None,
    ) -> None:
        self._commands, self._driving, self._hand = commands, driving, hand
        self.body, self._config = body, config
        self._slow = slow or SlowMotion(commands.world, body.cycle)

    def execute(self, order: RobotOrder) -> str:
        """Carry out one order.

        Returns:
            A sentence on the result.

        Raises:
            NaoHilError: refused, or no answer.
        """
        if isinstance(order, Key | Steer):
            return self._drive(order)
        resets = isinstance(order, World) and isinstance(order.command, Reset)
        if resets or isinstance(order, Stop | Arm):
            self._driving.release()
        if isinstance(order, World):
            return self._world(order.command)
        if isinstance(order, Walk):
            return self._driving.order(order.command)
        if isinstance(order, Stop):
            return (self._commands.stop() if order.how == "crouch" else self._commands.limp()).text
        if isinstance(order, Arm):
            return self._commands.arm().text
        if isinstance(order, Slow):
            return self._slow.set_speed(order.speed)
        if isinstance(order, Restart):
            return self._restart(order.settings)
        return self._joints(order)

    def keep_alive(self, absence: float) -> None:
        """Release the joints and end the slow motion after an `absence`, s, of all viewers."""
        if absence < ABSENCE_TIMEOUT:
            return
        if self._hand is not None and self._hand.holds:
            self._hand.release()
        with contextlib.suppress(NaoHilError):  # the robot is lost
            self._slow.end()

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
        return self._hand.take() if order.on else self._hand.release()

    @property
    def supervised(self) -> bool:
        """Whether a command is there that can begin another run."""
        return self._config is not None

    def _restart(self, settings: RestartSettings) -> str:
        """Ask for another run, unless it could not begin: the present one continues then."""
        if self._config is None:
            raise FrameError("This page did not begin the run; start `nao-hil up` with other options.")
        from nao_hil.runs.build import check_run  # imported late: most pages restart nothing

        changes = msgspec.to_builtins(settings)
        check_run(run_config(self._config(), **changes))
        print(json.dumps({RESTART: changes}), flush=True, file=sys.stdout)
        return "The run begins again; the page follows."

    def end(self) -> None:
        """Leave the world running and the robot free."""
        self._slow.end()
        if self._hand is not None:
            self._hand.release()


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
        self._speed = 1.0

    @property
    def speed(self) -> float:
        """Robot time per time of the clock; 1: it is not slowed down."""
        pace = self._pace
        return self._speed if pace is not None and pace.is_alive() else 1.0

    def set_speed(self, speed: float) -> str:
        """Set the speed of the world; 1: as fast as before.

        Returns:
            A sentence on the result.

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
        self._speed = speed
        self._pace = threading.Thread(target=self._run, args=(self._cycle / speed,), name="slow", daemon=True)
        self._pace.start()
        return f"The robot's time goes at {speed:g} of its speed."

    def end(self) -> None:
        """End the page: a world that it slowed down runs on. Raises as `set_speed`."""
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
            except NaoHilError:  # the robot is lost, or resumed by another client
                return
