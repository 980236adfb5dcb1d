"""Control of any robot on the link, emulated or real, cycle by cycle."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress

from bridge.errors import LinkError, RobotSilent
from bridge.link import DEFAULT_ENDPOINT, DEFAULT_ROBOT, ControllerLink
from bridge.link.session import require_seconds
from bridge.messages import Info, SensorFrame
from nao_hil.arguments import JointValues, UnreachableAngles, actuator_frame

logger = logging.getLogger(__name__)


class Connection:
    """A robot on the link that this program controls, made by `connect`.

    Args:
        link: Open link that holds the lease.
        info: Description of the robot.
        timeout: Time to wait for a sensor frame, s.
    """

    def __init__(self, link: ControllerLink, info: Info, timeout: float) -> None:
        self._link, self._timeout = link, timeout
        self._unreachable = UnreachableAngles()
        self.info = info
        """Description of the robot: its body, its cycle time (s), the joints that it does not have."""
        self.frame = self._receive()
        """The newest sensor frame."""
        self.first_target = link.held() or self.frame.position
        """Joint angles that the robot held when this program took control, rad: a safe first command. They are
        those commanded last; before any command the measured ones, which are lower by the sag of the joints: a
        program that commands measured angles at each start makes the robot sink a little every time."""

    def step(self, position: JointValues, stiffness: JointValues = 1.0) -> SensorFrame:
        """Answer the newest sensor frame and wait for the next.

        A program that was silent for 50 cycles of real time has lost the robot to its guard; this asks for it
        again, and the guard moves slowly to the next commands.

        Args:
            position: Joint angles, rad, 25 in the order of `nao_hil.JOINTS`.
            stiffness: 0..1, 25 or one for all joints; negative: the motor is off.

        Returns:
            The next sensor frame. In real time frames that arrive too fast to be answered are left out.

        Raises:
            RobotSilent: the robot is no longer there.
            LeaseRefused: the lease was lost, and another controller holds the robot.
            ConfigurationError: not 25 numbers.
            FrameError: a number that is not finite, or a stiffness outside -1..1.
        """
        command, frame = actuator_frame(self.frame.seq, position, stiffness), self.frame
        self._unreachable.warn(command.position)
        while frame.seq == command.reply_to:  # in lockstep the robot repeats a frame until its answer is there
            self._link.send(command)
            frame = self._receive()
            self._keep_lease()
        self.frame = frame
        return frame

    def _keep_lease(self) -> None:
        """Ask for the lease again where the robot says that it has ended; its holder gets the same one."""
        if any(notice.code == "no-lease" for notice in self._link.notices()):
            lost = self._link.lease
            with suppress(RobotSilent):  # a robot that is there says it again
                self._link.acquire()
            if self._link.lease != lost:
                logger.warning("the robot had been taken from this program, which was silent; it has it again")

    def _receive(self) -> SensorFrame:
        receive = self._link.next if self.info.mode == "lockstep" else self._link.latest
        deadline = time.monotonic() + self._timeout
        while time.monotonic() < deadline and self._link.lease:
            frame = receive(deadline - time.monotonic())
            if frame is not None:
                return frame
        raise RobotSilent(f"Robot `{self._link.robot}` at {self._link.endpoint} sends no sensor frames.")


@contextmanager
def connect(
    endpoint: str = DEFAULT_ENDPOINT,
    *,
    robot: str = DEFAULT_ROBOT,
    name: str = "python",
    timeout: float = 10.0,
) -> Iterator[Connection]:
    """Take control of a robot on the link for as long as the context lasts.

    Example:
        ```python
        with nao_hil.connect("tcp/192.168.1.7:7447") as robot:
            stand = robot.first_target
            while robot.frame.time < 5.0:
                robot.step(stand, 0.8)
        ```

    Args:
        endpoint: Zenoh endpoint of the robot.
        robot: Id of the robot.
        name: Name of this controller, shown to others.
        timeout: Time to wait for the robot, s.

    Raises:
        ConfigurationError: bad id, name, endpoint or timeout.
        LinkError: no robot there.
        LeaseRefused: another controller holds it.
    """
    require_seconds("timeout", timeout)
    with ControllerLink(robot, endpoint, name) as link:
        deadline = time.monotonic() + timeout
        info = link.wait_robot(timeout=timeout)
        if info is None:
            raise LinkError(f"No robot `{robot}` answered at {endpoint}.")
        while not link.lease:
            try:
                link.acquire()
            except RobotSilent:  # a busy robot answers late
                if time.monotonic() > deadline:
                    raise
        try:
            yield Connection(link, info, timeout)
        finally:
            link.release()
