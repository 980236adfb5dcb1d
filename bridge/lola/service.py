"""Any robot on `nao/<robot>` poses as a V6: packets of 896 bytes out, a client's maps in.

In real time a packet goes out every 12 ms (`pace`), and whatever the client sends reaches the robot at once. In
lockstep a packet goes out for each cycle of LoLA's in robot time, and the robot waits for the client's answer:
the first map after it that names positions or stiffnesses.
"""

from __future__ import annotations

import logging
import math
import select
import socket
import threading
import time
from collections.abc import Sequence
from typing import Final

import msgspec

from bridge.link import ControllerLink
from bridge.lola.client import ClientGone, LolaClient
from bridge.lola.convert import Identity, sensor_packet
from bridge.lola.demand import JOINT_KEYS, Demand, Fault
from bridge.lola.feed import Arrival, RobotFeed
from bridge.lola.pace import Pace
from bridge.lola.schema import CYCLE
from bridge.lola.wire import Map
from bridge.messages import ActuatorFrame, Info, SensorFrame
from bridge.realtime import quiet_process

logger = logging.getLogger(__name__)

STALE: Final = 100_000_000
"""ns; an older frame is not sent any more: the robot stands still, and its LoLA is silent."""
LIVE: Final = 30_000_000
"""ns since its last map for which a client's demand is repeated to a robot with other cycles than LoLA's."""
WEAK: Final = 0.2
"""A robot that a client leaves with no more stiffness than that in any joint is down already."""
_IDLE: Final = 0.2
"""s between two looks at whether to end."""
_ROUNDING: Final = 1e-6
"""Of a cycle; robot time is a multiple of the cycle but for the last bits."""


class Served(msgspec.Struct, frozen=True, kw_only=True):
    """What was served; the JSON of `nao-hil serve lola`."""

    clients: int
    packets: int
    maps: int
    """Received from clients."""
    dropped_bytes: int
    """Received from clients, and part of no map."""
    commands: int
    """Sent to the robot."""
    skipped: int
    """Packets left out because this process was held up."""
    repeated: int
    """Packets that held the same frame as the one before, because no newer had come."""


class LolaService:
    """Serves one client at a time on a listening socket.

    Args:
        link: to the robot, controller side.
        listener: listening socket.
        identity: whom the packets name.
        stop: set when it is to end.
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
        self._client: LolaClient | None = None
        self._demand: Demand | None = None
        self._unsent = False
        self._said: set[str] = set()
        """What was wrong with the present client's maps and has been told."""
        self._clients = self._packets = self._maps = self._dropped = self._commands = 0
        self._skipped = self._repeated = 0

    def run(self) -> Served:
        """Serve until stopped; robots may go and come back.

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
            with RobotFeed(self._link, lockstep=lockstep) as feed:
                if lockstep:
                    self._in_lockstep(feed)
                else:
                    self._in_real_time(feed, info)
                self._part(feed)
        return Served(
            clients=self._clients,
            packets=self._packets,
            maps=self._maps,
            dropped_bytes=self._dropped,
            commands=self._commands,
            skipped=self._skipped,
            repeated=self._repeated,
        )

    def _in_real_time(self, feed: RobotFeed, info: Info) -> None:
        pace = Pace(info.cycle)
        seen: Arrival | None = None
        spoke = answers = 0
        while not self._stop.is_set() and not feed.gone:
            maps = self._meet(feed, min(pace.wait, _IDLE))
            newest = feed.newest
            if newest is None:
                continue
            between = False
            if newest is not seen:
                seen = newest
                pace.frame(newest.at)
                between = not pace.follows and newest.at - spoke < LIVE
                answers = newest.frame.seq if between else answers
            if maps:
                spoke = time.monotonic_ns()
                self._heed(maps, newest.frame, feed)
            if maps or between or self._unsent:
                self._command(answers)
            if pace.due() and time.monotonic_ns() - newest.at < STALE:
                self._send(newest.frame, feed)
                answers = newest.frame.seq
        self._skipped += pace.skipped
        self._repeated += pace.repeated

    def _in_lockstep(self, feed: RobotFeed) -> None:
        seen: Arrival | None = None
        offered: tuple[LolaClient | None, int] = (None, -1)
        cycle, answered, commanded = -1, True, True
        while not self._stop.is_set() and not feed.gone:
            maps = self._meet(feed, _IDLE)
            newest = feed.newest
            if newest is None:
                continue
            frame = newest.frame
            if newest is not seen:
                if seen is None or frame.seq != seen.frame.seq:
                    now = math.floor(frame.time / CYCLE + _ROUNDING)
                    answered, cycle = now == cycle, now
                seen, commanded = newest, False
            answered = answered and self._demand is not None  # another client has answered nothing yet
            if not answered and self._client is not None and offered != (self._client, frame.seq):
                self._send(frame, feed)
                offered = (self._client, frame.seq)
            if maps:
                self._heed(maps, frame, feed)
                answered = answered or any(key in values for values in maps for key in JOINT_KEYS)
            if answered and not commanded:
                commanded = self._command(frame.seq)

    def _meet(self, feed: RobotFeed, timeout: float) -> list[Map]:
        """Wait for the robot, the client or a new client; the maps that the client sent."""
        client = self._client
        waiting: list[LolaClient | socket.socket] = [feed.bell]
        if client is None or client.deaf:
            waiting.append(self._listener)
        if client is not None:
            waiting.append(client)
        ready = select.select(waiting, [], [], timeout)[0]
        if feed.bell in ready:
            feed.heard()
        maps: list[Map] = []
        if client is not None and client in ready:
            try:
                maps = client.receive()
            except ClientGone:
                self._part(feed)
        if self._listener in ready:
            self._part(feed)
            self._client = LolaClient(self._listener.accept()[0])
            self._clients += 1
            self._said.clear()
            logger.info("a client came")
        return maps

    def _part(self, feed: RobotFeed) -> None:
        """The client is gone: the robot is free."""
        self._ignore(feed)
        if self._client is not None:
            self._client.close()
            self._packets += self._client.packets
            self._maps += self._client.maps
            self._dropped += self._client.dropped
            self._client = None
            logger.info("the client is gone")

    def _ignore(self, feed: RobotFeed) -> None:
        """What the client wants does not count any more; a robot it leaves stiff is left to the guard."""
        feed.deserted = self._demand is not None and max(self._demand.stiffness) > WEAK
        feed.wanted = False
        self._demand = None

    def _send(self, frame: SensorFrame, feed: RobotFeed) -> None:
        client = self._client
        if client is None or client.deaf:
            return
        try:
            client.send(sensor_packet(frame, self._identity))
        except ClientGone:
            self._part(feed)
            return
        if client.deaf:
            logger.warning("the client does not read and is ignored until it connects again")
            self._ignore(feed)

    def _heed(self, maps: list[Map], frame: SensorFrame, feed: RobotFeed) -> None:
        for values in maps:
            if self._demand is None:
                if not any(key in values for key in JOINT_KEYS):
                    continue
                self._demand = Demand(frame.position, frame.stiffness)
            self._complain(self._demand.take(values))
        feed.wanted = self._demand is not None

    def _command(self, answers: int) -> bool:
        """Send the client's demand in answer to a frame; False while the lease is not held."""
        self._unsent = self._demand is not None and not self._link.lease
        if self._demand is None or self._unsent:
            return False
        self._link.send(
            ActuatorFrame(reply_to=answers, position=self._demand.position, stiffness=self._demand.stiffness)
        )
        self._commands += 1
        return True

    def _complain(self, faults: Sequence[Fault]) -> None:
        """Tell each kind of fault once per client."""
        for fault in faults:
            if fault.kind not in self._said:
                self._said.add(fault.kind)
                logger.warning("the client's %s", fault.text)
