"""A referee on the time of a world: it keeps the game by a schedule, so that a half is the same every time.

It stands in for the GameController, whose clock is that of the wall. Twice a second of the world's time it
sends the GameController's packet, and the robots of its world get the same content at that boundary.

The clock of the half runs as in a round-robin game of the GameController: from the first `playing` on, also in
`ready` and `set`.
"""

from __future__ import annotations

import logging
import math
import socket
from pathlib import Path
from typing import Final

import msgspec

from bridge.adapters.gamecontroller.packets import decode_game, encode_game
from bridge.adapters.lola.address import parse_address
from bridge.config import load_toml
from bridge.errors import ConfigurationError
from bridge.link.session import is_loopback
from bridge.messages.game import (
    MAX_PLAYERS,
    Byte,
    GameReport,
    GameState,
    Penalty,
    PlayerNumber,
    PlayerReport,
    SetPlay,
    TeamColour,
    TeamReport,
)
from bridge.types import NotNegative

PERIOD: Final = 0.5
"""s between two packets (`SEND_INTERVAL` of the GameController)."""
BROADCAST: Final = "127.255.255.255:3838"
"""Reaches every program of this machine that listens on all addresses, as a robot's does."""
MESSAGE_BUDGET: Final = 1200
"""Messages of a team in a game (the Champions Cup of 2024)."""
_ROUNDING: Final = 1e-6

logger = logging.getLogger(__name__)


class Team(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A team of a game."""

    number: Byte
    colour: TeamColour
    goalkeeper_colour: TeamColour = "black"
    goalkeeper: PlayerNumber = 1


class Call(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A call of the referee: a state, a set play, a goal or a penalty."""

    at: NotNegative
    """Time of the world, s."""
    state: GameState | None = None
    set_play: SetPlay | None = None
    kicking_team: Byte | None = None
    """Number of the team that has the kick-off or the set play from now on."""
    goal: Byte | None = None
    """Number of the team that scores."""
    team: Byte | None = None
    """Team of the player that is penalized."""
    player: PlayerNumber | None = None
    penalty: Penalty | None = None
    """`none` ends the one in force."""
    seconds: Byte = 0
    """For which the penalty lasts, s; 0: until a call ends it."""

    def __post_init__(self) -> None:
        """Raises ValueError for half a penalty, or an empty call."""
        parts = (self.team, self.player, self.penalty)
        if any(part is not None for part in parts) != all(part is not None for part in parts):
            raise ValueError("a penalty needs `team`, `player` and `penalty`")
        if all(part is None for part in (*parts, self.state, self.set_play, self.kicking_team, self.goal)):
            raise ValueError(
                f"the call at {self.at:g} s says nothing; give a state, a set play, a goal or a penalty"
            )


class Schedule(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A half, or less, of a game."""

    teams: tuple[Team, Team]
    """The first one defends the goal on the negative x axis."""
    calls: tuple[Call, ...]
    half: NotNegative = 600.0
    """Length, s."""
    first_half: bool = True
    players_per_team: PlayerNumber = 7
    send: str = BROADCAST
    """Where packets go, HOST:PORT on this machine; empty: nowhere."""

    def __post_init__(self) -> None:
        """Raises ValueError for a team that does not play, or packets for other machines."""
        numbers = [team.number for team in self.teams]
        if numbers[0] == numbers[1]:
            raise ValueError(f"both teams have number {numbers[0]}; give each a number of its own")
        for call in self.calls:
            for number in (call.kicking_team, call.goal, call.team):
                if number is not None and number not in numbers:
                    raise ValueError(f"team {number} does not play; {numbers[0]} and {numbers[1]} do")
        if self.send:
            try:
                host = parse_address(self.send).host
            except ConfigurationError as error:
                raise ValueError(str(error)) from None
            if not is_loopback(host):  # a packet on a network would command the robots there
                raise ValueError(f"`send` is {self.send}; the referee sends to 127.0.0.0/8 alone")

    def at(self, time: float) -> GameReport:
        """The game at a time of the world, s."""
        state: GameState = "initial"
        set_play: SetPlay = "none"
        kicking: int | None = None
        score = dict.fromkeys((team.number for team in self.teams), 0)
        penalties: dict[tuple[int, int], tuple[Penalty, float]] = {}
        clock = before = 0.0
        for call in sorted(self.calls, key=lambda call: call.at):
            if call.at > time + _ROUNDING:
                break
            clock, before = clock + _counted(state, clock, call.at - before), call.at
            if call.state is not None and call.state != state:
                state, set_play = call.state, "none"
            set_play = call.set_play or set_play
            kicking = kicking if call.kicking_team is None else call.kicking_team
            if call.goal is not None:
                score[call.goal] += 1
            if call.team is not None and call.player is not None and call.penalty is not None:
                end = call.at + call.seconds if call.seconds else math.inf
                penalties[call.team, call.player] = (call.penalty, end)
        clock += _counted(state, clock, time - before)

        def player(team: int, number: int) -> PlayerReport:
            penalty, end = penalties.get((team, number), ("none", 0.0))
            left = end - time
            if penalty == "none" or left <= _ROUNDING:
                return PlayerReport()
            return PlayerReport(penalty, _whole(left) if math.isfinite(left) else 0)

        first, second = (
            TeamReport(
                number=team.number,
                colour=team.colour,
                goalkeeper_colour=team.goalkeeper_colour,
                goalkeeper=team.goalkeeper,
                score=min(score[team.number], 255),
                message_budget=MESSAGE_BUDGET,
                players=tuple(player(team.number, 1 + i) for i in range(MAX_PLAYERS)),
            )
            for team in self.teams
        )
        return GameReport(
            state=state,
            set_play=set_play,
            first_half=self.first_half,
            players_per_team=self.players_per_team,
            kicking_team=kicking,
            seconds_remaining=max(-(2**15), min(_whole(self.half - clock), 2**15 - 1)),
            teams=(first, second),
        )


def _counted(state: GameState, clock: float, time: float) -> float:
    """Time that the clock of the half counts of a stretch in one state, s."""
    runs = state == "playing" or (state in ("ready", "set") and clock > 0.0)
    return time if runs else 0.0


def _whole(seconds: float) -> int:
    """Seconds as the GameController rounds them (`get_duration`): up."""
    return math.ceil(seconds - _ROUNDING)


class Referee:
    """Reports the game of a schedule, and sends it as the GameController does.

    Args:
        schedule: Of the game.
        sends: Packets go out too; otherwise it only reports.
    """

    def __init__(self, schedule: Schedule, *, sends: bool) -> None:
        self._schedule = schedule
        self._sent = -1
        self._to = parse_address(schedule.send) if sends and schedule.send else None
        self._socket: socket.socket | None = None
        if self._to is not None:
            self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
            self._socket.setblocking(False)

    def __call__(self, time: float) -> GameReport | None:
        """The game as of the packet that is due at a time of the world, s; None: none is.

        An earlier time than before begins a world again.
        """
        number = math.floor(time / PERIOD + _ROUNDING)
        if number == self._sent:
            return None
        self._sent = number
        packet = encode_game(self._schedule.at(time), number)
        if self._socket is not None and self._to is not None:
            try:
                self._socket.sendto(packet, (self._to.host, self._to.port))
            except OSError as error:  # the game goes on without listeners
                logger.warning("packet %d of the referee was not sent to %s: %s", number, self._to, error)
        return decode_game(packet)

    def close(self) -> None:
        """Close its socket."""
        if self._socket is not None:
            self._socket.close()


def load_schedule(path: str | Path) -> Schedule:
    """Read a schedule from a TOML file.

    Raises:
        ConfigurationError: no such file, an unknown key, or an impossible value.
    """
    return load_toml(path, Schedule)
