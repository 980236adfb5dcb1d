"""Listens to a GameController, and answers it for the emulated robots of a link.

It stands where on a real robot the team's own program, or the GameController's library for NAO, listens.
"""

from __future__ import annotations

import logging
import math
import select
import socket
import time
from collections.abc import Callable, Sequence
from typing import Final, NamedTuple

import msgspec

from bridge.adapters.gamecontroller.packets import DATA_PORT, RobotStatus, decode_game, encode_status
from bridge.adapters.lola.address import Address
from bridge.errors import ConfigurationError, FrameError, LinkError
from bridge.link import keys
from bridge.link.query import ask
from bridge.link.robots import LinkRobots
from bridge.link.session import is_loopback, open_client
from bridge.messages import TruthFrame, decode, encode
from bridge.messages.game import GameReport
from bridge.messages.world import WORLD_COMMAND, ReportGame
from bridge.messages.world_state import WorldReply
from bridge.rotations import yaw
from bridge.types import Closing

SEARCH_INTERVAL: Final = 1.0
"""s between two searches for robots, and two return packets of a robot (`ALIVE_DELAY` of `GameCtrl.cpp`)."""
REPORT_INTERVAL: Final = 0.1
"""s between two reports to the robots, however many packets come; a GameController sends one in 0.5 s."""
CONTROLLER_TIMEOUT: Final = 2.0
"""s after a packet for which its sender counts as there (`GAMECONTROLLER_TIMEOUT` of `GameCtrl.cpp`)."""
NOTICE_INTERVAL: Final = 10.0
"""s between two notices of packets that are ignored."""
MAX_PACKETS: Final = 200
"""Packets of a socket that are read at a time."""
ANSWER_TIMEOUT: Final = 1.0
"""s that the robots may take for a report."""
LOOPBACK_BROADCAST: Final = "127.255.255.255"

logger = logging.getLogger(__name__)


def open_sockets(address: Address) -> list[socket.socket]:
    """UDP sockets at a host and port; at 127.0.0.1 another one takes what is broadcast on this machine.

    Other programs may listen at the same port, as a simulated team's robots do.

    Raises:
        ConfigurationError: no IPv4 address.
        LinkError: the system does not allow it.
    """
    if ":" in address.host:
        raise ConfigurationError(f"--listen {address} must be an IPv4 address, as in 127.0.0.1:{DATA_PORT}.")
    hosts = [address.host, LOOPBACK_BROADCAST] if is_loopback(address.host) else [address.host]
    opened = []
    for host in dict.fromkeys(hosts):
        one = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        opened.append(one)
        try:
            one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            one.setblocking(False)
            one.bind((host, address.port))
        except OSError as error:
            for each in opened:
                each.close()
            raise LinkError(f"Cannot listen on {host}:{address.port}: {error.strerror or error}.") from None
    return opened


class Served(msgspec.Struct):
    """Counts of a server."""

    packets: int = 0
    """Packets of a GameController."""
    ignored: int = 0
    """Other packets."""
    reports: int = 0
    """Reports that the robots took."""
    returned: int = 0
    """Return packets sent."""


class _Received(NamedTuple):
    """A packet of a GameController."""

    report: GameReport
    host: str
    """Address of its sender."""
    time: float
    """Time of its arrival, monotonic, s."""


class GameControllerServer(Closing):
    """Gives a GameController's reports to the robots of a link; close it, or use it as a context manager.

    Args:
        connect: Zenoh endpoint of the robots.
        sockets: At which packets arrive; closed with it.
        return_port: Of the GameController, for return packets.
        stopped: Ends `run`.

    Raises:
        ConfigurationError: bad endpoint.
        RobotSilent: no listener there.
    """

    def __init__(
        self,
        connect: str,
        sockets: Sequence[socket.socket],
        return_port: int,
        stopped: Callable[[], bool],
    ) -> None:
        self._sockets, self._return_port, self._stopped = sockets, return_port, stopped
        self._session = open_client(connect, role="world")
        self._robots = LinkRobots(connect)
        self._players: dict[str, TruthFrame] = {}
        """Newest ground truth of the robots that play, by name."""
        self._received: _Received | None = None
        self._waiting = False
        self._searched = self._reported = self._noticed = -NOTICE_INTERVAL
        self._unnoticed = 0
        self._served = Served()
        self._find_players()  # their ground truth comes from now on

    def run(self) -> Served:
        """Serve until stopped."""
        host, port = self._sockets[0].getsockname()
        players = ", ".join(f"`{name}`" for name in self._players) or "none yet"
        logger.info("a GameController is heard at %s:%d; robots that play: %s", host, port, players)
        while not self._stopped():
            ready, _, _ = select.select(self._sockets, [], [], REPORT_INTERVAL)
            now = time.monotonic()
            if now >= self._searched + SEARCH_INTERVAL:
                self._searched = now
                self._find_players()
                self._return(now)
            for one in ready:
                self._receive(one, now)
            if self._waiting and now >= self._reported + REPORT_INTERVAL:
                self._reported = now
                self._report()
        return self._served

    def _find_players(self) -> None:
        truths = {name: robot.truth for name, robot in self._robots.update().items()}
        self._players = {name: truth for name, truth in truths.items() if truth and truth.game.player}

    def _receive(self, one: socket.socket, now: float) -> None:
        for _ in range(MAX_PACKETS):
            try:
                packet, (host, _) = one.recvfrom(2048)
            except OSError:  # no more
                return
            try:
                report = decode_game(packet)
                self._require_players(report)
            except FrameError as error:
                self._ignore(f"{error} It came from {host}.", now)
                continue
            self._served.packets += 1
            self._received, self._waiting = _Received(report, host, now), True

    def _require_players(self, report: GameReport) -> None:
        """Refuse a game in which no robot plays."""
        present = sorted({truth.game.team for truth in self._players.values()})
        numbers = [team.number for team in report.teams]
        if not present:
            raise FrameError(
                "No robot of the link says that it plays: give it `team` and `player` in the file of --world, "
                "and let its world run."
            )
        if not set(present) & set(numbers):
            here = ", ".join(map(str, present))
            raise FrameError(
                f"A packet is of teams {numbers[0]} and {numbers[1]}; the robots of the link are of {here}."
            )

    def _ignore(self, why: str, now: float) -> None:
        """Count what is ignored; a flood gets a notice in ten seconds."""
        self._served.ignored += 1
        self._unnoticed += 1
        if now >= self._noticed + NOTICE_INTERVAL:
            logger.warning("ignored: %d, the last one: %s", self._unnoticed, why)
            self._noticed, self._unnoticed = now, 0

    def _report(self) -> None:
        """Give the newest report to the world, by one of its robots."""
        self._waiting = False
        if self._received is None or not self._players:
            return
        key = keys.key(next(iter(self._players)), WORLD_COMMAND)
        command = encode(ReportGame(game=self._received.report))
        try:
            answer = ask(self._session, key, command, ANSWER_TIMEOUT, FrameError)
        except FrameError as error:  # the world has a referee
            self._ignore(str(error), time.monotonic())
            return
        if answer is not None:
            decode(answer, WorldReply)
            self._served.reports += 1

    def _return(self, now: float) -> None:
        """Answer a GameController that is there, for each robot of its game."""
        if self._received is None or now > self._received.time + CONTROLLER_TIMEOUT:
            return
        for truth in self._players.values():
            if truth.game.state:
                try:
                    address = (self._received.host, self._return_port)
                    self._sockets[0].sendto(encode_status(robot_status(truth)), address)
                except OSError:  # the GameController has gone
                    return
                self._served.returned += 1

    def close(self) -> None:
        """Leave network and link."""
        self._robots.close()
        self._session.close()
        for one in self._sockets:
            one.close()


def robot_status(truth: TruthFrame) -> RobotStatus:
    """The report of a robot that knows its place and has not seen the ball."""
    (x, y, _), heading = truth.torso_position, float(yaw(truth.torso_orientation))
    if not truth.game.left:  # it attacks along the negative x axis
        x, y, heading = -x, -y, math.remainder(heading + math.pi, 2.0 * math.pi)
    return RobotStatus(truth.game.player, truth.game.team, truth.fell, (x, y, heading))
