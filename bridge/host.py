"""A robot behind its link: sensor frames out, the newest command in, through the guard. For every robot side.

A robot that sets the pace (LoLA, NAOqi, an emulator in real time) calls `exchange` once per cycle:

    with RobotLink(info, listen) as link:
        host = RobotHost(link, Guard(body, settings, armed=False))
        while not stop.is_set():
            frame = device.read()             # SensorFrame with seq = 0, 1, 2, ...; what it cannot read is NaN
            command = host.exchange(frame)    # publishes, takes the newest command, guards
            if command is not None:           # None: the command in force stays
                device.write(command.position, command.stiffness)

Lease, watchdog, arming, emergency stop and notices need no further calls. A robot that waits for its controller
(lockstep) calls `publish`, `admit` and `decide` itself.
"""

from __future__ import annotations

import logging
import secrets
import threading
import time
from collections.abc import Callable, Sequence
from typing import Final

import msgspec

from bridge.body import Body, sheet_of
from bridge.body.joints import JOINTS
from bridge.body.postures import POSTURES
from bridge.body.quantities import absent_joints, limits
from bridge.dcm.actuators import actuators
from bridge.errors import FrameError, LinkError
from bridge.guard import ArmRequest, Guard, StopRequest
from bridge.guard.output import Ranges
from bridge.link import RobotLink, keys
from bridge.link.lease import Holder
from bridge.messages import ActuatorFrame, Info, SensorFrame, TruthFrame, decode, encode
from bridge.messages.guard import GuardStatus
from bridge.messages.topics import TOPICS, Message
from bridge.recording.observer import Observer

CONFIRM_TIMEOUT: Final = 2.0
"""s for which a query waits until the loop has carried it out; its sender waits longer, and gets the reason."""
STATUS_INTERVAL: Final = 0.5
"""s of wall clock after which a status that has not changed is published again."""
DESCENT_TIMEOUT: Final = 60.0
"""s for the descent of a standing robot when its bridge ends."""

logger = logging.getLogger(__name__)


def robot_info(body: Body, *, robot: str, side: str, mode: str, software: str) -> Info:
    """The answer of a robot of a body to `info`; each call is a boot of its own.

    Args:
        body: data sheet.
        robot: id on the link.
        side: the device behind it: `emulator`, `lola` or `naoqi`.
        mode: `real-time` or `lockstep`.
        software: of the robot's side.
    """
    ranges, absent = Ranges(body), absent_joints(body)
    return Info(
        robot=robot,
        body=body.name,
        sheet=sheet_of(body),
        side=side,
        mode=mode,
        cycle=body.cycle,
        absent=absent,
        boot=secrets.randbits(47),
        software=software,
        limits=tuple((0.0, 0.0) if joint in absent else limits(body, joint) for joint in JOINTS),
        actuators=tuple(actuator.name for actuator in actuators(body)),
        stand=ranges.clip(POSTURES["StandInit"]),
        crouch=ranges.clip(POSTURES["Crouch"]),
    )


class RobotHost:
    """Publishes a robot's frames and returns the guarded commands; one thread calls it, the robot's loop.

    Serves the queries `guard`, `stop` and `arm`, and publishes the guard's status.

    Args:
        link: open link, robot side.
        guard: of this robot.
        observers: get the commands and notices; the frames, which need the truth, only from an emulated robot.
        dry_run: commands are guarded and observed, but not returned.
        emulated: a holder that serves another robot's protocol is followed as that robot follows it.
    """

    def __init__(
        self,
        link: RobotLink,
        guard: Guard,
        observers: Sequence[Observer] = (),
        *,
        dry_run: bool = False,
        emulated: bool = False,
    ) -> None:
        self.link, self.guard = link, guard
        self._observers, self._dry_run, self._emulated = observers, dry_run, emulated
        self._asked: Holder | None = None
        self._deadline: float | None = None
        self._reported: GuardStatus | None = None
        self._report_due = 0.0
        self.in_force = -1
        """`reply_to` of the command in force; -1: none yet."""
        self.missed = 0
        """Expected answers that were not in time, cycles."""
        link.serve(keys.GUARD, lambda _: self._reply())
        link.serve(keys.STOP, self._on_stop)
        link.serve(keys.ARM, self._on_arm)

    @property
    def status(self) -> GuardStatus:
        """State of the robot, and who holds it."""
        holder = self.link.holder
        return msgspec.structs.replace(self.guard.status, holder=holder.name if holder else "")

    def report(self) -> None:
        """Publish a status that is new or `STATUS_INTERVAL` old."""
        now, status = time.monotonic(), self.status
        if status != self._reported or now >= self._report_due:
            self._reported, self._report_due = status, now + STATUS_INTERVAL
            self.link.publish(status)

    def exchange(self, frame: SensorFrame, *, wait: float = 0.0) -> ActuatorFrame | None:
        """One cycle of a robot that sets the pace: publish its frame, return its command.

        Args:
            frame: the robot's measurements, an unreadable number as NaN; its `command` and `missed` are filled
                in here.
            wait: s to wait for the answer to this very frame. 0: the newest command so far is taken, which
                answers the frame before.

        Returns:
            The command put in force; None: the one in force stays.
        """
        frame = self.guard.sense(frame)
        if wait > 0.0:
            self._publish_counted(frame)
            command = self.admit(self._answers(frame.seq, wait), frame.seq)
            self._count(command, frame.seq)
        else:
            command = self.admit(self.link.commands(), frame.seq)
            self._count(command, frame.seq - 1)
            self._publish_counted(frame)
        return self.decide(frame, command, supervised=self.supervised)

    def should_end(self, stop: threading.Event) -> bool:
        """Whether a bridge's loop ends now: after a stop, once the robot is down or its time is over.

        Args:
            stop: set when the loop is to end; the robot is brought down then.
        """
        if not stop.is_set():
            return False
        if self._dry_run or self.guard.state in ("idle", "rest"):
            return True
        if self._deadline is None:
            logger.info("bringing the robot down; Ctrl-C again ends at once and leaves it as it is")
            self.guard.stop("crouch", "the end of the bridge")
            self._deadline = time.monotonic() + DESCENT_TIMEOUT
        return time.monotonic() > self._deadline

    def _publish_counted(self, frame: SensorFrame) -> None:
        self.publish(msgspec.structs.replace(frame, command=self.in_force, missed=self.missed))

    def _answers(self, seq: int, wait: float) -> list[ActuatorFrame]:
        """The commands by the time that one answers frame `seq`, or that the wait is over."""
        commands, deadline = self.link.commands(), time.monotonic() + wait
        while not commands or commands[-1].reply_to < seq:
            remaining = deadline - time.monotonic()
            if remaining <= 0.0:
                break
            command = self.link.wait_command(remaining)
            commands += [command] if command is not None else []
        return commands

    def _count(self, command: ActuatorFrame | None, seq: int) -> None:
        if self.expected and (command is None or command.reply_to < seq):
            self.missed += 1

    @property
    def expected(self) -> bool:
        """An answer to the newest frame is expected: one controller has held the robot since then."""
        return self._asked is not None and self._asked == self.link.holder

    @property
    def supervised(self) -> bool:
        """A controller holds the robot, or died holding it: the watchdog counts."""
        return self.link.holder is not None or self.link.leases.abandoned

    @property
    def needs_cycle(self) -> bool:
        """The guard has to go on without a controller, also on a robot that waits for answers (lockstep)."""
        moving = self.guard.state not in ("idle", "rest")
        return self.guard.busy or (self.link.leases.abandoned and moving)

    def publish(self, frame: SensorFrame, truth_of: Callable[[], TruthFrame] | None = None) -> None:
        """Publish a frame, and after it the truth of the same instant where there is one.

        Args:
            frame: the robot's measurements.
            truth_of: computes the truth; called after the publication, because the controller waits for it.
        """
        self._asked = self.link.holder
        self.link.publish(frame)
        if truth_of is not None:
            truth = truth_of()
            self.link.publish(truth)
            for observer in self._observers:
                observer.sensors(frame, truth)

    def admit(self, commands: Sequence[ActuatorFrame], seq: int) -> ActuatorFrame | None:
        """The newest command that the guard does not refuse, inside the joints' ranges; None: there is none.

        A notice reports each refusal and each clipped angle.

        Args:
            commands: those of a cycle, in order.
            seq: of the newest sensor frame.
        """
        newest = None
        for command in commands:
            try:
                newest = self.guard.check(command, seq)
            except FrameError as error:
                self.link.refuse("frame-refused", str(error))
                continue
            if self.guard.clipped:
                self.link.notice("clipped", self.guard.clipped)
        return newest

    def decide(
        self, frame: SensorFrame, command: ActuatorFrame | None, *, supervised: bool
    ) -> ActuatorFrame | None:
        """The command of the cycle that begins at `frame`; None: the one in force stays.

        Args:
            frame: of the present boundary.
            command: as `admit` gave it.
            supervised: whether the watchdog counts; in real time the property `supervised`.
        """
        for telemetry in self.link.telemetry():
            for observer in self._observers:
                observer.message(telemetry)
        holder = self.link.holder
        direct = self._emulated and holder is not None and holder.direct
        given = self.guard.cycle(frame, command, supervised=supervised, direct=direct)
        if command is None and holder is None and not self.link.leases.abandoned:
            self.guard.released(frame.seq)
        if given is not None:
            for observer in self._observers:
                observer.command(given)
        self._publish_notices()
        if self.guard.take_revocation():
            self.link.leases.revoke()
        if self._dry_run:
            return None
        self.in_force = given.reply_to if given is not None else self.in_force
        return given

    def rest_released(self, seq: int) -> None:
        """Have the guard act on a release since `seq`, for which a robot in lockstep would wait in vain."""
        if self.link.holder is None and not self.link.leases.abandoned:
            self.guard.released(seq)
            self._publish_notices()

    def _publish_notices(self) -> None:
        """Pass on the guard's status and notices."""
        self.report()
        for notice in self.guard.take_notices():
            self.emit(notice)

    def emit(self, message: Message) -> None:
        """Publish a message of the robot, and pass it to the observers if it is recorded."""
        self.link.publish(message)
        if TOPICS[type(message)].recorded:
            for observer in self._observers:
                observer.message(message)

    def _on_stop(self, payload: bytes) -> bytes:
        request = decode(payload, StopRequest) if payload else StopRequest()
        return self._confirmed(self.guard.stop(request.how, request.who))

    def _on_arm(self, payload: bytes) -> bytes:
        request = decode(payload, ArmRequest) if payload else ArmRequest()
        return self._confirmed(self.guard.arm(request.who))

    def _confirmed(self, done: threading.Event) -> bytes:
        self.link.wake()
        if not done.wait(CONFIRM_TIMEOUT):
            raise LinkError(
                f"The robot's loop did not run within {CONFIRM_TIMEOUT:g} s; its next cycle carries this out."
            )
        return self._reply()

    def _reply(self) -> bytes:
        """The status, and the targets in force."""
        return encode(msgspec.structs.replace(self.status, position=self.guard.position or ()))
