"""A real V6 becomes `nao/<robot>`: LoLA's packets as sensor frames, commands through the guard to LoLA.

Each connection to LoLA is a boot of its own: when it ends, the robot's token disappears, and when LoLA is back
the robot begins anew at `seq` 0, disarmed. LoLA itself keeps the last command it got.
"""

from __future__ import annotations

import logging
import math
import secrets
import threading
from typing import Final

import msgspec

from bridge.datasheet import Body, load_body
from bridge.datasheet.quantities import absent_joints
from bridge.errors import ConfigurationError, FrameError, LinkError
from bridge.guard import Guard, GuardSettings
from bridge.host import RobotHost
from bridge.link import RobotLink
from bridge.lola.address import Address
from bridge.lola.convert import Identity, identity_of, sensor_frame
from bridge.lola.device import SILENCE, LolaDevice, Packets
from bridge.lola.schema import CYCLE
from bridge.messages import ActuatorFrame, Info, SensorFrame
from bridge.observer import NoticeLog
from bridge.realtime import quiet_process

logger = logging.getLogger(__name__)

ANSWER: Final = 0.008
"""s of the 12 ms cycle in which the controller's answer to a packet is waited for, before the next is read."""
RESEND: Final = 0.2
"""s; how often a frame is repeated in lockstep while no answer comes."""
RETRY: Final = 0.5
"""s between two attempts to connect."""
_LOOK: Final = 0.1
"""s between two looks at whether to end."""
BODIES: Final = {"6": "nao-v6"}
"""Data sheet by the first part of `Body/Version`; LoLA runs on V6 only."""


class BridgeSettings(msgspec.Struct, frozen=True, kw_only=True):
    """How a robot is bridged."""

    robot: str
    """Id on the link."""
    listen: str
    """Zenoh endpoint."""
    body: str | None = None
    """Data sheet; None: by what the robot says it is."""
    mode: str = "real-time"
    """`lockstep`: at the other end is a served LoLA of a robot in lockstep, which waits for answers."""
    guard: GuardSettings = GuardSettings()
    dry_run: bool = False
    """Everything but the commands."""
    priority: int | None = None
    """SCHED_FIFO priority to ask for; None: none."""


class Bridged(msgspec.Struct, kw_only=True):
    """What was bridged; the JSON of `nao-hil bridge lola`."""

    connections: int = 0
    packets: int = 0
    left_out: int = 0
    """Packets that were overtaken by a newer one before they were read."""
    dropped_bytes: int = 0
    """Received from the robot, and part of no packet."""
    commands: int = 0
    """Sent to the robot."""
    missed: int = 0
    """Cycles that a controller was expected to serve and did not in time."""


class LolaBridge:
    """Connects, bridges, and connects again.

    Args:
        address: of LoLA's socket, or of its relay.
        settings: see there.
        software: for `Info`.
        stop: set when it is to end.

    Raises:
        ConfigurationError: a dry run in lockstep, no such body, or a body that LoLA does not run on.
    """

    def __init__(
        self, address: Address, settings: BridgeSettings, software: str, stop: threading.Event
    ) -> None:
        if settings.dry_run and settings.mode == "lockstep":
            raise ConfigurationError(
                "A robot in lockstep waits for commands; --dry-run would leave it waiting."
            )
        self._address, self._s, self._software, self._stop = address, settings, software, stop
        self._lockstep = settings.mode == "lockstep"
        self._named = _lola_body(settings.body) if settings.body is not None else None
        self._said = ""
        """Why the robot could not be bridged the last time."""
        self._result = Bridged()

    def run(self) -> Bridged:
        """Bridge until stopped.

        Raises:
            ConfigurationError: a robot that LoLA is not known to run on.
            LinkError: the endpoint cannot be listened on.
        """
        logger.info("waiting for LoLA at %s", self._address)
        while not self._stop.is_set():
            try:
                device = LolaDevice(self._address, math.inf if self._lockstep else SILENCE)
            except OSError:
                self._stop.wait(RETRY)
                continue
            with device:
                try:
                    self._bridge(device)
                finally:
                    self._result.dropped_bytes += device.dropped
        return self._result

    def _bridge(self, device: LolaDevice) -> None:
        """From a first packet to the end of the connection."""
        try:
            first = self._first(device)
            identity = identity_of(first.newest) if first is not None else None
        except (LinkError, FrameError) as error:
            if str(error) != self._said:
                self._said = str(error)
                logger.warning("%s Trying again.", self._said)
            self._stop.wait(RETRY)
            return
        if first is None or identity is None:
            return
        self._said = ""
        body = self._body(identity)
        self._result.connections += 1
        with RobotLink(self._info(body), self._s.listen) as link:
            guard = Guard(body, self._s.guard, armed=False, dry_run=self._s.dry_run)
            host = RobotHost(link, guard, [NoticeLog()], dry_run=self._s.dry_run)
            logger.info(
                "robot `%s` at %s: %s, %s", self._s.robot, self._s.listen, identity.body_id, guard.status.text
            )
            if not self._lockstep:
                quiet_process(self._s.priority)
            try:
                if self._lockstep:
                    self._in_lockstep(device, host, first)
                else:
                    self._in_real_time(device, host)
            except LinkError as error:
                logger.warning("%s The robot is gone until LoLA is back.", error)
            self._result.missed += host.missed

    def _first(self, device: LolaDevice) -> Packets | None:
        """The first packets, which say who the robot is; None when stopped before."""
        packets = None
        while packets is None and not self._stop.is_set():
            packets = device.packets(_LOOK)
        return packets

    def _body(self, identity: Identity) -> Body:
        if self._named is not None:
            return self._named
        name = BODIES.get(identity.body_version.partition(".")[0])
        if name is None:
            raise ConfigurationError(
                f"The robot at {self._address} says that its body is version {identity.body_version}; only V6 "
                "bodies are known to run LoLA. Name the data sheet with --robot if it is right."
            )
        return load_body(name)

    def _info(self, body: Body) -> Info:
        return Info(
            robot=self._s.robot,
            body=body.name,
            side="lola",
            mode=self._s.mode,
            cycle=CYCLE,
            absent=absent_joints(body),
            boot=secrets.randbits(47),
            software=self._software,
        )

    def _in_real_time(self, device: LolaDevice, host: RobotHost) -> None:
        seq = -1
        while not host.ends(self._stop):
            packets = device.packets(_LOOK)
            if packets is None:
                continue
            seq += packets.number
            frame = self._frame(packets, seq)
            if frame is not None:
                self._send(device, host.exchange(frame, wait=ANSWER))

    def _in_lockstep(self, device: LolaDevice, host: RobotHost, first: Packets) -> None:
        seq = -1
        packets: Packets | None = first  # no other comes before it is answered
        frame: SensorFrame | None = None
        last: ActuatorFrame | None = None
        while not host.ends(self._stop):
            packets = packets or device.packets(_LOOK if frame is None else 0.0)
            if packets is not None:
                seq += packets.number
                frame, packets = self._frame(packets, seq), None
                if frame is not None:
                    host.publish(msgspec.structs.replace(frame, command=host.in_force))
            if frame is None:
                continue
            given = self._alone(host, frame, last) if host.alone else self._answer(host, frame)
            if given is not None:
                self._send(device, given)
                frame, last = None, given

    def _alone(self, host: RobotHost, frame: SensorFrame, last: ActuatorFrame | None) -> ActuatorFrame | None:
        """What the guard does without a controller; the last command again, where it leaves that in force."""
        return host.decide(frame, None, owed=host.held) or last

    def _answer(self, host: RobotHost, frame: SensorFrame) -> ActuatorFrame | None:
        """The controller's answer to a frame; None, and the frame is sent again, while there is none."""
        command = host.link.wait_command(RESEND)
        if command is None:
            host.link.publish_sensors(frame)
        elif command.reply_to >= frame.seq:  # an older one answers a frame that was sent again
            accepted = host.admit(command, frame.seq)
            if accepted is not None:
                return host.decide(frame, accepted, owed=False)
        return None

    def _frame(self, packets: Packets, seq: int) -> SensorFrame | None:
        self._result.packets += packets.number
        self._result.left_out += packets.number - 1
        try:
            return sensor_frame(packets.newest, seq=seq)
        except FrameError as error:
            logger.warning("%s", error)
            return None

    def _send(self, device: LolaDevice, given: ActuatorFrame | None) -> None:
        if given is not None:
            device.send(given.position, given.stiffness)
            self._result.commands += 1


def _lola_body(name: str) -> Body:
    body = load_body(name)
    if not math.isclose(body.cycle, CYCLE):
        raise ConfigurationError(
            f"LoLA is spoken by a V6, every {1e3 * CYCLE:g} ms; {body.name} has a cycle of "
            f"{1e3 * body.cycle:g} ms: a V3 to V5 is reached with `nao-hil bridge naoqi`."
        )
    return body
