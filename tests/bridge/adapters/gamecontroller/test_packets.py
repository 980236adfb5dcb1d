"""The GameController's packets, against its header laid out by C's rules.

The structures below repeat the fields of `RoboCupGameControlData.h` (github.com/RoboCup-SPL/GameController3,
commit e76b8b0, `GAMECONTROLLER_STRUCT_VERSION` 18, `GAMECONTROLLER_RETURN_STRUCT_VERSION` 4) with C's types;
ctypes lays them out as a C compiler does. The numbers of states and penalties are the header's too.
"""

from __future__ import annotations

import ctypes
import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bridge.adapters.gamecontroller.packets import (
    RobotStatus,
    decode_game,
    decode_status,
    encode_game,
    encode_status,
)
from bridge.errors import FrameError

U8, U16, I16 = ctypes.c_uint8, ctypes.c_uint16, ctypes.c_int16
PENALTIES = (*range(12), 14, 15)


class RobotInfo(ctypes.LittleEndianStructure):
    _fields_ = [("penalty", U8), ("secsTillUnpenalised", U8)]


class TeamInfo(ctypes.LittleEndianStructure):
    _fields_ = [
        ("teamNumber", U8),
        ("fieldPlayerColour", U8),
        ("goalkeeperColour", U8),
        ("goalkeeper", U8),
        ("score", U8),
        ("penaltyShot", U8),
        ("singleShots", U16),
        ("messageBudget", U16),
        ("players", RobotInfo * 20),
    ]


class ControlData(ctypes.LittleEndianStructure):
    _fields_ = [
        ("header", ctypes.c_char * 4),
        ("version", U8),
        ("packetNumber", U8),
        ("playersPerTeam", U8),
        ("competitionPhase", U8),
        ("competitionType", U8),
        ("gamePhase", U8),
        ("state", U8),
        ("setPlay", U8),
        ("firstHalf", U8),
        ("kickingTeam", U8),
        ("secsRemaining", I16),
        ("secondaryTime", I16),
        ("teams", TeamInfo * 2),
    ]


class ReturnData(ctypes.LittleEndianStructure):
    _fields_ = [
        ("header", ctypes.c_char * 4),
        ("version", U8),
        ("playerNum", U8),
        ("teamNum", U8),
        ("fallen", U8),
        ("pose", ctypes.c_float * 3),
        ("ballAge", ctypes.c_float),
        ("ball", ctypes.c_float * 2),
    ]


def packet(**fields: int) -> ControlData:
    """A packet in which team 5 plays team 19."""
    data = ControlData(header=b"RGme", version=18, firstHalf=1, kickingTeam=255, playersPerTeam=7)
    data.teams[0].teamNumber, data.teams[1].teamNumber = 5, 19
    for name, value in fields.items():
        setattr(data, name, value)
    return data


def test_a_packet_written_byte_by_byte_is_read_and_written_again() -> None:
    data = bytearray(118)
    data[0:4] = b"RGme"
    data[4:14] = bytes((18, 201, 7, 1, 0, 2, 3, 4, 0, 19))  # version ... kickingTeam
    data[14:18] = struct.pack("<hh", -3, 25)  # secsRemaining, secondaryTime
    data[18:28] = bytes((5, 0, 2, 1, 3, 1)) + struct.pack("<HH", 0x0102, 1199)
    data[28 + 2 * 3 : 28 + 2 * 3 + 2] = bytes((2, 44))  # player 4: pushing, 44 s
    data[68:78] = bytes((19, 9, 3, 0, 1, 0)) + struct.pack("<HH", 0, 7)
    data[78 + 2 * 19 :] = bytes((15, 0))  # player 20: manual
    report = decode_game(bytes(data))
    assert (report.state, report.set_play, report.phase) == ("playing", "kick-in", "overtime")
    assert (report.playoff, report.first_half, report.kicking_team) == (True, False, 19)
    assert (report.seconds_remaining, report.secondary_seconds, report.players_per_team) == (-3, 25, 7)
    first, second = report.teams
    assert (first.number, first.colour, first.goalkeeper_colour, first.goalkeeper) == (5, "blue", "yellow", 1)
    assert (first.score, first.penalty_shots, first.single_shots, first.message_budget) == (3, 1, 0x0102, 1199)
    assert (first.players[3].penalty, first.players[3].seconds) == ("player-pushing", 44)
    assert (second.number, second.colour, second.goalkeeper, second.score) == (19, "gray", 0, 1)
    assert second.players[19].penalty == "manual"
    assert {one.penalty for one in (*first.players[:3], *second.players[:19])} == {"none"}
    assert encode_game(report, 201) == bytes(data)
    own = report.for_player(5, 4)
    assert own is not None and (own.penalty, own.score, own.kicking, own.left) == (
        "player-pushing",
        (3, 1),
        False,
        True,
    )
    other = report.for_player(19, 20)
    assert other is not None and (other.penalty, other.score, other.kicking) == ("manual", (1, 3), True)
    assert report.for_player(6, 1) is None


@given(st.data())
def test_every_packet_of_the_header_is_read_and_written_again(draw: st.DataObject) -> None:
    def number(last: int, first: int = 0) -> int:
        return draw.draw(st.integers(first, last))

    data = packet(packetNumber=number(255), playersPerTeam=number(255), competitionPhase=number(1))
    data.gamePhase, data.state, data.setPlay = number(3), number(5), number(5)
    data.firstHalf, data.kickingTeam = number(1), number(255)
    data.secsRemaining, data.secondaryTime = number(2**15 - 1, -(2**15)), number(2**15 - 1, -(2**15))
    for team in data.teams:
        team.teamNumber, team.score, team.penaltyShot = number(255), number(255), number(255)
        team.fieldPlayerColour, team.goalkeeperColour, team.goalkeeper = number(9), number(9), number(20)
        team.singleShots, team.messageBudget = number(2**16 - 1), number(2**16 - 1)
        player = team.players[number(19)]
        player.penalty, player.secsTillUnpenalised = draw.draw(st.sampled_from(PENALTIES)), number(255)
    report = decode_game(bytes(data))
    assert encode_game(report, data.packetNumber) == bytes(data)
    assert [len(team.players) for team in report.teams] == [20, 20]


@pytest.mark.parametrize(
    ("bad", "names"),
    [
        (b"", "RGme"),
        (b"RGTD" + bytes(packet())[4:], "RGTD"),
        (bytes(packet(version=15)), "version 15"),
        (bytes(packet())[:-1], "117 bytes"),
        (bytes(packet()) + b"\0", "119 bytes"),
        (bytes(packet(state=6)), "`state` is 6"),
        (bytes(packet(setPlay=6)), "`setPlay` is 6"),
        (bytes(packet(gamePhase=4)), "`gamePhase` is 4"),
        (bytes(packet())[:28] + b"\x0c" + bytes(packet())[29:], "`penalty` is 12"),
    ],
)
def test_a_packet_that_is_none_is_refused_by_its_fault(bad: bytes, names: str) -> None:
    with pytest.raises(FrameError, match=names):
        decode_game(bad)


def test_a_return_packet_has_the_bytes_of_the_header_in_mm() -> None:
    status = RobotStatus(3, 19, True, (1.25, -0.5, math.pi / 2), 2.0, (0.1, -0.2))
    data = ReturnData.from_buffer_copy(encode_status(status))
    assert (data.header, data.version, data.playerNum, data.teamNum, data.fallen) == (b"RGrt", 4, 3, 19, 1)
    assert list(data.pose) == pytest.approx([1250.0, -500.0, math.pi / 2])
    assert data.ballAge == 2.0 and list(data.ball) == pytest.approx([100.0, -200.0])
    read = decode_status(bytes(data))
    assert read[:3] == status[:3] and read.pose == pytest.approx(status.pose)


@pytest.mark.parametrize(
    "changes", [{"playerNum": 0}, {"playerNum": 21}, {"fallen": 2}, {"version": 3}, {"ballAge": math.nan}]
)
def test_a_return_packet_that_the_gamecontroller_refuses_is_refused(changes: dict[str, float]) -> None:
    data = ReturnData(header=b"RGrt", version=4, playerNum=1, teamNum=5)
    decode_status(bytes(data))
    for name, value in changes.items():
        setattr(data, name, value)
    with pytest.raises(FrameError):
        decode_status(bytes(data))
