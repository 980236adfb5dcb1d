"""The binary protocol of the RoboCup SPL GameController: struct version 18, return struct version 4.

Source: `game_controller_msgs/headers/RoboCupGameControlData.h` of github.com/RoboCup-SPL/GameController3,
commit e76b8b0, with the state `standby` of the rules since 2024. All numbers are little endian, as in
`control_message.rs` beside it; the C structs have no padding.
"""

from __future__ import annotations

import math
import struct
from typing import Final, NamedTuple, TypeVar, get_args

from bridge.errors import FrameError
from bridge.messages.game import (
    MAX_PLAYERS,
    GamePhase,
    GameReport,
    GameState,
    Penalty,
    PlayerReport,
    SetPlay,
    TeamColour,
    TeamReport,
)
from bridge.types import Vec2, Vec3

DATA_PORT: Final = 3838
"""UDP, from the GameController to the robots, broadcast."""
RETURN_PORT: Final = 3939
"""UDP, from a robot to the GameController."""
VERSION: Final = 18
RETURN_VERSION: Final = 4
HEADER: Final = b"RGme"
RETURN_HEADER: Final = b"RGrt"
_GAME: Final = struct.Struct("<4s10B2h")
_TEAM: Final = struct.Struct(f"<6B2H{2 * MAX_PLAYERS}B")
_RETURN: Final = struct.Struct("<4s4B6f")
_LARGEST: Final = 3e38
SIZE: Final = _GAME.size + 2 * _TEAM.size
"""bytes of `RoboCupGameControlData`."""
NO_TEAM: Final = 255
"""`KICKING_TEAM_NONE`."""
_STATES: Final = dict(enumerate(get_args(GameState)))
_PHASES: Final = dict(enumerate(get_args(GamePhase)))
_SET_PLAYS: Final = dict(enumerate(get_args(SetPlay)))
_COLOURS: Final = dict(enumerate(get_args(TeamColour)))
_PENALTIES: Final = dict(zip((*range(12), 14, 15), get_args(Penalty), strict=True))
"""Numbers 12 and 13 are of no penalty."""

T = TypeVar("T")


def encode_game(report: GameReport, number: int) -> bytes:
    """A packet of the GameController.

    Args:
        report: Its content.
        number: Of the packet; counts modulo 256.
    """
    packet = _GAME.pack(
        HEADER,
        VERSION,
        number & 255,
        report.players_per_team,
        report.playoff,
        0,  # COMPETITION_TYPE_NORMAL, the only one
        _code(_PHASES, report.phase),
        _code(_STATES, report.state),
        _code(_SET_PLAYS, report.set_play),
        report.first_half,
        NO_TEAM if report.kicking_team is None else report.kicking_team,
        report.seconds_remaining,
        report.secondary_seconds,
    )
    return packet + b"".join(map(_encode_team, report.teams))


def _encode_team(team: TeamReport) -> bytes:
    colours = _code(_COLOURS, team.colour), _code(_COLOURS, team.goalkeeper_colour)
    shots = team.score, team.penalty_shots, team.single_shots
    players = (value for one in team.players for value in (_code(_PENALTIES, one.penalty), one.seconds))
    return _TEAM.pack(team.number, *colours, team.goalkeeper, *shots, team.message_budget, *players)


def decode_game(packet: bytes) -> GameReport:
    """The content of a packet of the GameController.

    Raises:
        FrameError: no such packet, another version, or a value that the header does not know.
    """
    _check(packet, HEADER, VERSION, SIZE)
    _, _, _, per_team, playoff, _, *numbers = _GAME.unpack_from(packet)
    phase, state, set_play, first, kicking, left, secondary = numbers
    first_team, second_team = (_decode_team(packet, _GAME.size + i * _TEAM.size) for i in range(2))
    return GameReport(
        state=_word(_STATES, "state", state),
        phase=_word(_PHASES, "gamePhase", phase),
        set_play=_word(_SET_PLAYS, "setPlay", set_play),
        first_half=bool(first),
        playoff=bool(playoff),
        players_per_team=per_team,
        kicking_team=None if kicking == NO_TEAM else kicking,
        seconds_remaining=left,
        secondary_seconds=secondary,
        teams=(first_team, second_team),
    )


def _decode_team(packet: bytes, at: int) -> TeamReport:
    number, colour, keeper_colour, keeper, score, shots, singles, budget, *players = _TEAM.unpack_from(
        packet, at
    )
    if keeper > MAX_PLAYERS:
        raise FrameError(f"`goalkeeper` of team {number} is {keeper}; player numbers end at {MAX_PLAYERS}.")
    return TeamReport(
        number=number,
        colour=_word(_COLOURS, "fieldPlayerColour", colour),
        goalkeeper_colour=_word(_COLOURS, "goalkeeperColour", keeper_colour),
        goalkeeper=keeper,
        score=score,
        penalty_shots=shots,
        single_shots=singles,
        message_budget=budget,
        players=tuple(
            PlayerReport(_word(_PENALTIES, "penalty", penalty), seconds)
            for penalty, seconds in zip(players[::2], players[1::2], strict=True)
        ),
    )


class RobotStatus(NamedTuple):
    """Report of a robot to the GameController, about once a second."""

    player: int
    """From 1."""
    team: int
    fallen: bool
    pose: Vec3
    """x and y, m, and heading, rad; origin in the middle of the field, x towards the opponents' goal."""
    ball_age: float = -1.0
    """Time since it saw the ball, s; -1: it has not."""
    ball: Vec2 = (0.0, 0.0)
    """Place of the ball in front and to the left of it, m."""


def encode_status(status: RobotStatus) -> bytes:
    """A return packet, lengths in mm; those beyond the range of a C float are cut off."""
    x, y, heading = status.pose
    player, team, fallen = status.player, status.team, status.fallen
    ball = (1e3 * part for part in status.ball)
    numbers = (1e3 * x, 1e3 * y, heading, status.ball_age, *ball)
    cut = (max(-_LARGEST, min(number, _LARGEST)) for number in numbers)
    return _RETURN.pack(RETURN_HEADER, RETURN_VERSION, player, team, fallen, *cut)


def decode_status(packet: bytes) -> RobotStatus:
    """The content of a return packet, checked as the GameController does (`status_message.rs`).

    Raises:
        FrameError: no such packet, another version, or an impossible value.
    """
    _check(packet, RETURN_HEADER, RETURN_VERSION, _RETURN.size)
    _, _, player, team, fallen, *numbers = _RETURN.unpack(packet)
    if not 1 <= player <= MAX_PLAYERS:
        raise FrameError(f"`playerNum` is {player}; 1 to {MAX_PLAYERS} are right.")
    if fallen > 1:
        raise FrameError(f"`fallen` is {fallen}; 0 and 1 are right.")
    if not all(map(math.isfinite, numbers)):
        raise FrameError("A number of the pose or of the ball is not finite.")
    x, y, heading, age, ahead, beside = numbers
    pose, ball = (1e-3 * x, 1e-3 * y, heading), (1e-3 * ahead, 1e-3 * beside)
    return RobotStatus(player, team, bool(fallen), pose, age, ball)


def _check(packet: bytes, header: bytes, version: int, size: int) -> None:
    """Refuse a packet by its first bytes and its length."""
    if packet[:4] != header:
        raise FrameError(f"A packet begins with {packet[:4]!r}, not with {header!r}.")
    if len(packet) > 4 and packet[4] != version:
        raise FrameError(f"A packet has version {packet[4]} of the struct; {version} is read.")
    if len(packet) != size:
        raise FrameError(f"A packet has {len(packet)} bytes; version {version} has {size}.")


def _word(words: dict[int, T], field: str, code: int) -> T:
    if code not in words:
        raise FrameError(f"`{field}` is {code}; known are {', '.join(map(str, words))}.")
    return words[code]


def _code(words: dict[int, T], word: T) -> int:
    return next(code for code, known in words.items() if known == word)
