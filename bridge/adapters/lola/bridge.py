"""A bridge from a real V6 to `nao/<robot>`: LoLA's packets as sensor frames, guarded commands to LoLA."""

from __future__ import annotations

import logging
import math
import select
import threading
import time
from collections.abc import Sequence
from typing import Final, NamedTuple

import msgspec

from bridge.adapters.lola.address import Address, connect
from bridge.adapters.lola.codec import CYCLE, SENSORS, Map, MapStream
from bridge.adapters.lola.packets import Identity, actuator_map, identity_of, sensor_frame
from bridge.adapters.robot_bridge import BridgeCounts, BridgeSettings, Retry, hosted
from bridge.body import Body, load_body
from bridge.errors import ConfigurationError, FrameError, LinkError
from bridge.host import RobotHost
from bridge.messages import ActuatorFrame, SensorFrame
from bridge.types import Closing

PACKET_TIMEOUT: Final = 1.0
"""s of waiting for a packet after which the connection to LoLA ends."""
_CONNECT_TIMEOUT: Final = 1.0
"""s an attempt to connect may take."""
_SEND_TIMEOUT: Final = 0.2
"""s a command may take, after which the connection ends."""
_READ_SIZE: Final = 65536
logger = logging.getLogger(__name__)
_ANSWER_TIMEOUT: Final = 0.008
"""s of the 12 ms cycle in which the bridge waits for the controller's answer to a packet."""
_RESEND_INTERVAL: Final = 0.2
"""s after which a frame without an answer is repeated in lockstep."""
_STOP_INTERVAL: Final = 0.1
"""s between two checks of the stop event."""
_BODIES: Final = {"6": "nao-v6"}
"""Data sheet by the first part of `Body/Version`; LoLA runs on V6 only."""


class Packets(NamedTuple):
    """Packets since the last call."""

    newest: Map
    number: int


class LolaDevice(Closing):
    """An open connection; close it, or use it as a context manager.

    Args:
        address: of LoLA's socket, or of its relay.
        silence: s without a packet after which the connection is given up.

    Raises:
        OSError: no listener there.
    """

    def __init__(self, address: Address, silence: float = PACKET_TIMEOUT) -> None:
        self.address, self._silence = address, silence
        self._peer = connect(address, _CONNECT_TIMEOUT)
        self._peer.settimeout(_SEND_TIMEOUT)
        self._stream = MapStream(SENSORS)
        self._silent = 0.0
        """s waited since the last packet; not the time in which this process itself stood still."""
        self._has_received = False

    def packets(self, timeout: float) -> Packets | None:
        """The received packets, waiting up to `timeout` s for the first; None: none.

        Raises:
            LinkError: the connection has ended, or has been silent for too long.
        """
        deadline = time.monotonic() + timeout
        while True:
            left = max(0.0, deadline - time.monotonic())
            if select.select([self._peer], [], [], left)[0]:
                maps = self._stream.feed(self._received())
                if maps:
                    self._silent, self._has_received = 0.0, True
                    return Packets(maps[-1], len(maps))
                continue
            self._silent += timeout
            if self._silent > self._silence:
                end = "." if self._has_received else "; is another client connected?"
                raise LinkError(f"LoLA at {self.address} has been silent for {self._silence:g} s{end}")
            return None

    @property
    def dropped(self) -> int:
        """Bytes so far outside packets."""
        return self._stream.dropped

    def send(self, position: Sequence[float], stiffness: Sequence[float]) -> None:
        """Send a command of all joints.

        Raises:
            LinkError: the connection has ended.
        """
        try:
            self._peer.sendall(actuator_map(position, stiffness))
        except OSError as error:
            raise self._ended(error) from None

    def _received(self) -> bytes:
        try:
            data = self._peer.recv(_READ_SIZE)
        except OSError as error:
            raise self._ended(error) from None
        if not data:
            raise self._ended(None)
        return data

    def _ended(self, error: OSError | None) -> LinkError:
        why = f" ({error.strerror or error})" if error else ""
        return LinkError(f"LoLA at {self.address} closed the connection{why}.")

    def close(self) -> None:
        """End the connection."""
        self._peer.close()


class LolaCounts(BridgeCounts, kw_only=True):
    """Counts of a bridge; the JSON of `nao-hil bridge lola`."""

    packets: int = 0
    dropped_bytes: int = 0
    """Received from the robot outside packets."""


class LolaBridge:
    """Connects to LoLA and bridges, again after each connection.

    Args:
        address: of LoLA's socket, or of its relay.

    Raises:
        ConfigurationError: a dry run in lockstep, no such body, or a body without LoLA.
    """

    def __init__(self, address: Address, settings: BridgeSettings, stop: threading.Event) -> None:
        self._lockstep = settings.mode == "lockstep"
        if settings.dry_run and self._lockstep:
            raise ConfigurationError(
                "A robot in lockstep waits for commands; --dry-run would leave it waiting."
            )
        self._address, self._settings, self._stop = address, settings, stop
        self._named_body = _lola_body(settings.body) if settings.body is not None else None
        self._retry = Retry(stop)
        self._counts = LolaCounts()

    def run(self) -> LolaCounts:
        """Bridge until stopped.

        Raises:
            ConfigurationError: a robot not known to run LoLA.
            LinkError: the endpoint cannot be listened on.
        """
        logger.info("waiting for LoLA at %s", self._address)
        while not self._stop.is_set():
            try:
                device = LolaDevice(self._address, math.inf if self._lockstep else PACKET_TIMEOUT)
            except OSError as error:
                self._retry.wait(f"No LoLA answers at {self._address} ({error.strerror or error}).")
                continue
            with device:
                try:
                    self._bridge(device)
                finally:
                    self._counts.dropped_bytes += device.dropped
        return self._counts

    def _bridge(self, device: LolaDevice) -> None:
        """Serve one connection to its end."""
        try:
            first = self._first(device)
            identity = identity_of(first.newest) if first is not None else None
        except (LinkError, FrameError) as error:
            self._retry.wait(error)
            return
        if first is None or identity is None:
            return
        self._retry.succeeded()
        body = self._named_body or self._body(identity)
        logger.info("LoLA at %s: body id %s", self._address, identity.body_id)
        with hosted(self._settings, body, self._counts, "lola") as host:
            if self._lockstep:
                self._in_lockstep(device, host, first)
            else:
                self._in_real_time(device, host)

    def _first(self, device: LolaDevice) -> Packets | None:
        """The first packets, which name the robot; None after a stop."""
        packets = None
        while packets is None and not self._stop.is_set():
            packets = device.packets(_STOP_INTERVAL)
        return packets

    def _body(self, identity: Identity) -> Body:
        name = _BODIES.get(identity.body_version.partition(".")[0])
        if name is None:
            raise ConfigurationError(
                f"The robot at {self._address} reports body version {identity.body_version}; only V6 "
                "bodies are known to run LoLA. Name the data sheet with --robot if it is right."
            )
        return load_body(name)

    def _in_real_time(self, device: LolaDevice, host: RobotHost) -> None:
        seq = -1
        command: ActuatorFrame | None = None
        while not host.should_end(self._stop):
            packets = device.packets(_STOP_INTERVAL)
            if packets is None:
                continue
            seq += packets.number
            # Repeated: the relay takes the silence of a client for its death.
            command = host.exchange(self._frame(packets, seq), wait=_ANSWER_TIMEOUT) or command
            self._send(device, command)

    def _in_lockstep(self, device: LolaDevice, host: RobotHost, first: Packets) -> None:
        seq = -1
        packets: Packets | None = first  # the robot sends no other before the answer
        frame: SensorFrame | None = None
        last: ActuatorFrame | None = None
        while not host.should_end(self._stop):
            packets = packets or device.packets(_STOP_INTERVAL if frame is None else 0.0)
            if packets is not None:
                seq += packets.number
                frame, packets = host.guard.sense(self._frame(packets, seq)), None
                host.publish(msgspec.structs.replace(frame, command=host.in_force))
            if frame is None:
                continue
            if host.needs_cycle:  # the guard acts without a controller, or leaves the last command in force
                command = host.decide(frame, None, supervised=host.supervised) or last
            else:
                command = self._answer(host, frame)
            if command is not None:
                self._send(device, command)
                frame, last = None, command

    def _answer(self, host: RobotHost, frame: SensorFrame) -> ActuatorFrame | None:
        """The controller's answer to a frame; None: none yet, and the frame is repeated."""
        command = host.link.wait_command(_RESEND_INTERVAL)
        if command is None:
            host.link.publish(frame)
        elif command.reply_to >= frame.seq:  # an older one answers a repeated frame
            accepted = host.admit([command], frame.seq)
            if accepted is not None:
                return host.decide(frame, accepted, supervised=False)
        return None

    def _frame(self, packets: Packets, seq: int) -> SensorFrame:
        self._counts.packets += packets.number
        self._counts.left_out += packets.number - 1
        return sensor_frame(packets.newest, seq=seq)

    def _send(self, device: LolaDevice, command: ActuatorFrame | None) -> None:
        if command is not None:
            device.send(command.position, command.stiffness)
            self._counts.commands += 1


def _lola_body(name: str) -> Body:
    body = load_body(name)
    if not math.isclose(body.cycle, CYCLE):
        raise ConfigurationError(
            f"LoLA runs on a V6, every {1e3 * CYCLE:g} ms; {body.name} has a cycle of "
            f"{1e3 * body.cycle:g} ms: a V3 to V5 is reached with `nao-hil bridge naoqi`."
        )
    return body
