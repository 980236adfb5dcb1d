"""A server of LoLA: any robot on `nao/<robot>` appears as a V6 to one client at a time.

In real time the server sends a packet every 12 ms, and each map of the client to the robot at once. In lockstep
it sends a packet for each cycle of LoLA's in robot time, and the robot waits for the client's answer: the first
map after it that names positions or stiffnesses. A client that sends none for a second gets the packet again
and again until it does.

A robot behind a network has its own clock. If its cycle is LoLA's, each packet follows its frame: `SEND_DELAY`
after the usual arrival, the median of the last frames, so that the client has neither the frames' jitter nor a
lasting delay from a few late ones. A packet waits up to `LATE_FRAME_WAIT` for a late frame. For a robot with
another cycle this machine's clock alone sets the times, and a packet holds the newest frame.
"""

from __future__ import annotations

import logging
import math
import select
import socket
import statistics
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Final

import msgspec

from bridge.adapters.lola.client import JOINT_KEYS, ClientGone, LolaClient
from bridge.adapters.lola.codec import CYCLE, Map
from bridge.adapters.lola.packets import HeatStatus, Identity, sensor_packet
from bridge.adapters.lola.robot_listener import Arrival, RobotListener
from bridge.link import ControllerLink
from bridge.messages import ActuatorFrame, Info, LedFrame, SensorFrame
from bridge.realtime import quiet_process

_NS_PER_S: Final = 1_000_000_000
PERIOD: Final = round(CYCLE * _NS_PER_S)
"""ns"""
SEND_DELAY: Final = 1_000_000
"""ns from a frame's usual arrival to its packet."""
LATE_FRAME_WAIT: Final = 1_000_000
"""ns that a packet waits for a late frame."""
_ARRIVAL_WINDOW: Final = 31
"""Frames whose median arrival the packets follow."""
_MAX_PHASE_STEP: Final = 100_000
"""ns by which the phase moves at most from one packet to the next."""
_CYCLE_TOLERANCE: Final = 1e-6
"""Rounding of the robot's cycle, s."""
logger = logging.getLogger(__name__)
_MAX_FRAME_AGE: Final = 100_000_000
"""ns; an older frame is not sent: the robot is paused, and its LoLA is silent."""
_REPEAT_TIME: Final = 30_000_000
"""ns after a client's last map in which its setpoints are repeated to a robot with another cycle."""
_LIMP_STIFFNESS: Final = 0.2
"""Largest stiffness of any joint of a robot that is down."""
_STOP_INTERVAL: Final = 0.2
"""s between two checks of the stop event."""
_FIRST_MAP_WAIT: Final = 1.0
"""s from the first packet to a client of a robot in lockstep; then it flows every cycle until the first map."""
_WARNING_DELAY: Final = 1.0
"""s that a robot in lockstep waits for an answer before a warning."""
_ROUNDING: Final = 1e-6
"""Tolerance of a cycle; robot time is a multiple of the cycle except for rounding."""


class PacketTimer:
    """Times of the packets.

    Args:
        cycle: of the robot, s.
        clock: monotonic clock, ns.
    """

    def __init__(self, cycle: float, clock: Callable[[], int] = time.monotonic_ns) -> None:
        self._clock = clock
        self.follows = abs(cycle - CYCLE) < _CYCLE_TOLERANCE
        """The robot's cycle is LoLA's."""
        self._deadline = clock() + PERIOD
        self._locked = self._fresh = False
        self._errors: deque[int] = deque(maxlen=_ARRIVAL_WINDOW)
        """Lateness of the last frames relative to the phase, ns."""
        self.skipped = 0
        """Packets left out by a late loop."""
        self.repeated = 0
        """Packets with the frame of the one before."""

    def frame(self, arrived: int) -> None:
        """Correct the phase by a frame.

        Args:
            arrived: monotonic clock, ns.
        """
        self._fresh = True
        if not self.follows:
            return
        error = arrived + SEND_DELAY - self._deadline
        error -= round(error / PERIOD) * PERIOD
        self._errors.append(error)
        middle = round(statistics.median(self._errors))
        step = max(-_MAX_PHASE_STEP, min(middle, _MAX_PHASE_STEP)) if self._locked else middle
        self._locked = True
        self._deadline += step
        self._errors = deque((earlier - step for earlier in self._errors), maxlen=_ARRIVAL_WINDOW)

    @property
    def wait(self) -> float:
        """Time until the next check of `due`, s."""
        return max(0.0, (self._end - self._clock()) / _NS_PER_S)

    @property
    def _end(self) -> int:
        return self._deadline + (LATE_FRAME_WAIT if self.follows and self._locked and not self._fresh else 0)

    def due(self) -> bool:
        """Whether to send a packet now; True counts it as sent."""
        now = self._clock()
        if now < self._end:
            return False
        passed = (now - self._deadline) // PERIOD
        self.skipped += passed
        self._deadline += (passed + 1) * PERIOD
        self.repeated += not self._fresh
        self._fresh = False
        return True


class Served(msgspec.Struct, kw_only=True):
    """Counts of a server; the JSON of `nao-hil serve lola`."""

    clients: int = 0
    packets: int = 0
    maps: int = 0
    """Received from clients."""
    dropped_bytes: int = 0
    """Received from clients outside maps."""
    commands: int = 0
    """Sent to the robot."""
    skipped: int = 0
    """Packets left out by a late process."""
    repeated: int = 0
    """Packets with the frame of the one before, for want of a newer one."""


class LolaServer:
    """Serves one client at a time on a listening socket.

    Args:
        priority: SCHED_FIFO priority to ask for against a robot in real time; None: none.
    """

    def __init__(
        self,
        link: ControllerLink,
        listener: socket.socket,
        identity: Identity,
        stop: threading.Event,
        priority: int | None = None,
    ) -> None:
        self._priority = priority
        self._link, self._listener, self._identity, self._stop = link, listener, identity, stop
        self._heat = HeatStatus()
        self._client: LolaClient | None = None
        self._unsent = False
        """Whether setpoints wait for the lease."""
        self._served = Served()

    def run(self) -> Served:
        """Serve until stopped, also over restarts of robots.

        Raises:
            FrameError: the robot speaks another version of the contract.
        """
        logger.info("waiting for robot `%s` at %s", self._link.robot, self._link.endpoint)
        while not self._stop.is_set():
            info = self._link.wait_robot(self._stop.is_set)
            if info is None:
                break
            logger.info("robot `%s` found: %s, %s", info.robot, info.body, info.mode)
            lockstep = info.mode == "lockstep"
            if not lockstep:
                quiet_process(self._priority)
            with RobotListener(self._link, lockstep=lockstep) as robot:
                if lockstep:
                    self._in_lockstep(robot)
                else:
                    self._in_real_time(robot, info)
                self._disconnect(robot)
        return self._served

    def _in_real_time(self, robot: RobotListener, info: Info) -> None:
        timer = PacketTimer(info.cycle)
        seen: Arrival | None = None
        last_map = answered = 0
        while not self._stop.is_set() and not robot.lost:
            maps = self._wait(robot, min(timer.wait, _STOP_INTERVAL))
            newest = robot.newest
            if newest is None:
                continue
            repeat = False
            if newest is not seen:
                seen = newest
                timer.frame(newest.at)
                repeat = not timer.follows and newest.at - last_map < _REPEAT_TIME
                answered = newest.frame.seq if repeat else answered
            if maps:
                last_map = time.monotonic_ns()
                self._update(maps, newest.frame, robot)
            if maps or repeat or self._unsent:
                self._command(answered, robot)
            if timer.due() and time.monotonic_ns() - newest.at < _MAX_FRAME_AGE:
                self._send(newest.frame, robot)
                answered = newest.frame.seq
        self._served.skipped += timer.skipped
        self._served.repeated += timer.repeated

    def _in_lockstep(self, robot: RobotListener) -> None:
        seen: Arrival | None = None
        sent: tuple[LolaClient | None, int] = (None, -1)
        """Client and number of the frame sent last."""
        sent_at = 0.0
        cycle, answered, commanded = -1, True, True
        while not self._stop.is_set() and not robot.lost:
            silent = self._client is not None and self._client.setpoints is None
            maps = self._wait(robot, CYCLE if silent else _STOP_INTERVAL)
            newest = robot.newest
            if newest is None:
                continue
            frame = newest.frame
            if newest is not seen:
                if seen is None or frame.seq != seen.frame.seq:
                    now = math.floor(frame.time / CYCLE + _ROUNDING)
                    answered, cycle = now == cycle, now
                seen, commanded = newest, False
            client = self._client
            answered = answered and client is not None and client.setpoints is not None
            if not answered and client is not None and sent != (client, frame.seq):
                self._send(frame, robot)
                sent, sent_at = (client, frame.seq), time.monotonic()
            waited = time.monotonic() - sent_at > _FIRST_MAP_WAIT
            if silent and waited and not maps and client is not None and client.has_read:
                self._send(frame, robot)  # it may read several packets before it sends
            if maps:
                self._update(maps, frame, robot)
                answered = answered or any(key in values for values in maps for key in JOINT_KEYS)
            if answered and not commanded:
                commanded = self._command(frame.seq, robot)
            if not answered and client is not None and time.monotonic() - sent_at > _WARNING_DELAY:
                client.warn(
                    "waiting", "the robot is in lockstep and waits for a map with `Position` or `Stiffness`."
                )

    def _wait(self, robot: RobotListener, timeout: float) -> list[Map]:
        """Wait for the robot, the client or a new client, up to `timeout` s; the client's maps."""
        client = self._client
        waiting: list[LolaClient | socket.socket] = [robot.wakeup]
        if client is None:
            waiting.append(self._listener)
        if client is not None and robot.newest is not None:  # maps wait for the first frame
            waiting.append(client)
        ready = select.select(waiting, [], [], timeout)[0]
        if robot.wakeup in ready:
            robot.clear_wakeup()
        maps: list[Map] = []
        if client is not None and client in ready:
            try:
                maps = client.receive()
            except ClientGone:
                self._disconnect(robot)
        if self._listener in ready:
            self._disconnect(robot)
            self._client = LolaClient(self._listener.accept()[0])
            self._served.clients += 1
            logger.info("a client connected")
        return maps

    def _disconnect(self, robot: RobotListener) -> None:
        """Close the connection, if there is one, and release the robot; the guard brings down a stiff one."""
        setpoints = self._client.setpoints if self._client is not None else None
        robot.abandoned = setpoints is not None and max(setpoints.stiffness) > _LIMP_STIFFNESS
        robot.lease_wanted = False
        if self._client is not None:
            self._client.close()
            self._served.packets += self._client.packets
            self._served.maps += self._client.maps
            self._served.dropped_bytes += self._client.dropped
            self._client = None
            logger.info("the client is gone")

    def _send(self, frame: SensorFrame, robot: RobotListener) -> None:
        client = self._client
        if client is None:
            return
        try:
            status = self._heat.update(frame.temperature)
            client.send(sensor_packet(frame, self._identity, status))
        except ClientGone:
            self._disconnect(robot)

    def _update(self, maps: list[Map], frame: SensorFrame, robot: RobotListener) -> None:
        if self._client is not None:
            before = tuple(self._client.leds)
            self._client.update(maps, frame)
            if (leds := tuple(self._client.leds)) != before:
                self._link.publish(LedFrame(leds=leds))
            robot.lease_wanted = self._client.setpoints is not None

    def _command(self, answered: int, robot: RobotListener) -> bool:
        """Send the client's setpoints to the robot; False while the lease is not held.

        Args:
            answered: number of the answered frame.
        """
        setpoints = self._client.setpoints if self._client is not None else None
        self._unsent = setpoints is not None and not (self._link.lease and robot.held)
        if setpoints is None or self._unsent:
            return False
        position = setpoints.position(robot.held)
        self._link.send(ActuatorFrame(reply_to=answered, position=position, stiffness=setpoints.stiffness))
        self._served.commands += 1
        return True
