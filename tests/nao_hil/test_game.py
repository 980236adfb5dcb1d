"""A game of the league in a world: a referee's calls, robots' lights, and a half that is the same twice."""

from __future__ import annotations

import hashlib
import socket
from pathlib import Path
from typing import Final

import msgspec
import pytest

import nao_hil
from bridge.adapters.gamecontroller.packets import decode_game
from bridge.adapters.gamecontroller.referee import Call, Referee, Schedule, Team, load_schedule
from bridge.body import load_body
from bridge.config import parse_toml
from bridge.dcm.actuators import led_names
from bridge.errors import ConfigurationError, FrameError
from bridge.messages import TruthFrame, encode
from bridge.messages.world import ReportGame
from emulator.robot import EmulatedRobot
from tests.loops import TIMEOUT

HALF: Final = """
half = 20.0
teams = [{ number = 5, colour = "blue" }, { number = 19, colour = "orange" }]

[[calls]]
at = 1.0
state = "ready"
kicking_team = 5

[[calls]]
at = 3.0
state = "set"

[[calls]]
at = 4.0
state = "playing"

[[calls]]
at = 6.0
team = 19
player = 2
penalty = "inactive-player"
seconds = 3

[[calls]]
at = 7.0
goal = 5

[[calls]]
at = 8.0
set_play = "corner-kick"
kicking_team = 19

[[calls]]
at = 11.0
state = "finished"
"""
LEDS: Final = led_names()
OFF, RED, GREEN, BLUE, YELLOW = (0, 0, 0), (255, 0, 0), (0, 255, 0), (0, 0, 255), (255, 255, 0)
WHITE, ORANGE = (255, 255, 255), (255, 128, 0)


def schedule(*calls: Call, **more: object) -> Schedule:
    teams = (Team(number=5, colour="blue"), Team(number=19, colour="red"))
    return msgspec.convert({"teams": teams, "calls": calls} | more, Schedule)


def lights(truth: TruthFrame, board: str) -> tuple[int, ...]:
    if not truth.leds:
        return OFF
    return tuple(truth.leds[LEDS.index(f"{board}/Led/{colour}")] for colour in ("Red", "Green", "Blue"))


def two(file: Path) -> nao_hil.World:
    world = nao_hil.World(engine="mujoco", game=file)
    world.add("nao-v6", name="first", seed=1, player=(5, 1))
    world.add("nao-v6", name="second", seed=2, at=(1.5, 0.0, 3.14), player=(19, 2))
    return world


@pytest.fixture
def half(tmp_path: Path) -> Path:
    file = tmp_path / "half.toml"
    file.write_text(HALF)
    return file


def test_a_half_is_in_the_truth_and_on_the_lights_and_is_the_same_twice(half: Path) -> None:
    """Colours by the league's rule book; the game reaches a robot within half a second, as a packet does."""
    hashes = []
    with two(half) as world:
        for _ in range(2):
            found: dict[float, dict[str, TruthFrame]] = {}
            digest = hashlib.sha256()
            for cycle in range(1000):  # 12 s
                frames = world.step()
                for name in world.names:
                    digest.update(encode(frames[name]))
                if cycle % 10 == 9:
                    truth = world.truth
                    for robot in truth.robots.values():
                        digest.update(encode(robot))
                    found[truth.time] = truth.robots
            hashes.append(digest.hexdigest())
            world.reset()
    assert hashes[0] == hashes[1]

    def at(time: float) -> tuple[TruthFrame, TruthFrame]:
        robots = found[min(found, key=lambda known: abs(known - time))]
        return robots["first"], robots["second"]

    expected = {  # time -> state, chest of both robots, right foot of the first
        0.7: ("initial", OFF, OFF, OFF),
        2.0: ("ready", BLUE, BLUE, WHITE),
        3.7: ("set", YELLOW, YELLOW, WHITE),
        5.0: ("playing", GREEN, GREEN, OFF),
        7.7: ("playing", GREEN, RED, OFF),
        9.7: ("playing", GREEN, GREEN, OFF),
        11.7: ("finished", OFF, OFF, OFF),
    }
    for time, (state, chest, other_chest, kick_off) in expected.items():
        first, second = at(time)
        assert first.game.state == second.game.state == state
        assert (lights(first, "ChestBoard"), lights(second, "ChestBoard")) == (chest, other_chest), time
        assert (lights(first, "LFoot"), lights(second, "LFoot")) == (BLUE, ORANGE)
        assert lights(first, "RFoot") == kick_off and lights(second, "RFoot") == OFF
    first, second = at(7.7)
    assert first.game.score == (1, 0) and second.game.score == (0, 1)
    assert first.game.penalty == "none" and second.game.penalty == "inactive-player"
    assert second.game.penalty_seconds == 2  # 1.5 s at the packet of 7.5 s, rounded up
    assert at(3.7)[0].game.seconds_remaining == 20  # the clock begins with the kick-off
    assert first.game.seconds_remaining == 17  # 16.5 s
    first, second = at(9.7)
    assert (first.game.set_play, first.game.kicking, second.game.kicking) == ("corner-kick", False, True)
    assert at(11.7)[0].game.seconds_remaining == 13  # it stands from 11 s on
    assert at(0.7)[0].game.left and not at(0.7)[1].game.left


def test_the_schedule_of_the_documentation_is_one() -> None:
    page = (Path(__file__).parents[2] / "docs" / "worlds.md").read_text()
    (text,) = (block for block in page.split("```toml\n") if block.startswith("half"))
    game = parse_toml(text.split("```")[0], "worlds.md", Schedule)
    assert game.at(100.0).teams[1].players[1].penalty == "player-pushing"
    assert (game.at(130.0).teams[0].score, game.at(660.0).state) == (1, "finished")


def test_the_clock_of_a_half_runs_on_in_ready_and_set_after_the_first_kick_off() -> None:
    """As the timer of the GameController with its condition `MainTimer` does in a game that is not long."""
    calls = [
        (0.0, "ready"),
        (45.0, "set"),
        (60.0, "playing"),
        (100.0, "ready"),
        (145.0, "set"),
        (150.0, "playing"),
    ]
    game = schedule(*(msgspec.convert({"at": at, "state": state}, Call) for at, state in calls))
    assert [game.at(time).seconds_remaining for time in (0, 59.9, 60.4, 61.0, 130.0, 660.0, 661.5)] == (
        [600, 600, 600, 599, 530, 0, -1]
    )


def test_packets_of_the_referee_come_twice_a_second_of_the_world(tmp_path: Path) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.bind(("127.0.0.1", 0))
        listener.settimeout(TIMEOUT)
        game = schedule(Call(at=0.6, state="ready"), send=f"127.0.0.1:{listener.getsockname()[1]}")
        referee = Referee(game, sends=True)
        reports = [report for i in range(200) if (report := referee(0.01 * i)) is not None]
        packets = [listener.recv(2048) for _ in range(4)]
        referee.close()
        listener.setblocking(False)
        with pytest.raises(BlockingIOError):
            listener.recv(2048)
    assert [packet[5] for packet in packets] == [0, 1, 2, 3]
    assert [decode_game(packet) for packet in packets] == reports
    assert [report.state for report in reports] == ["initial", "initial", "ready", "ready"]


@pytest.mark.parametrize(
    ("old", "new", "names"),
    [
        ("number = 19", "number = 5", "number 5"),
        ("goal = 5", "goal = 6", "team 6"),
        ('penalty = "inactive-player"', "", "`team`, `player` and `penalty`"),
        ('state = "set"', 'state = "sett"', "sett"),
        ('state = "set"', "", "says nothing"),
        ("half = 20.0", 'send = "192.168.1.255:3838"', "192.168.1.255"),
        ("half = 20.0", 'send = "here"', "HOST:PORT"),
    ],
)
def test_a_wrong_schedule_is_refused_by_its_fault(half: Path, old: str, new: str, names: str) -> None:
    load_schedule(half)
    assert old in HALF
    half.write_text(HALF.replace(old, new, 1))
    with pytest.raises(ConfigurationError, match=names):
        load_schedule(half)


def test_a_world_with_a_referee_takes_no_other_report_and_one_without_does(half: Path) -> None:
    report = schedule(Call(at=0.0, state="standby")).at(0.0)
    with two(half) as world, pytest.raises(FrameError, match="referee"):
        world.send(ReportGame(game=report))
    with nao_hil.World(engine="mujoco") as world:
        world.add("nao-v6", name="plays", player=(5, 3))
        world.add("nao-v6", name="other", at=(1.0, 0.0, 0.0), player=(7, 3))
        world.add("nao-v6", name="none", at=(2.0, 0.0, 0.0))
        world.send(ReportGame(game=report), "none")
        robots = world.truth.robots
        assert [robots[name].game.state for name in world.names] == ["standby", "", ""]
        assert [robots[name].game.player for name in world.names] == [3, 3, 0]
        assert lights(robots["plays"], "ChestBoard") == (0, 255, 255) and not robots["other"].leds


@pytest.mark.parametrize("player", [(5, 1), (5, 21), (5, 0), (256, 1), (5,), "5 1"])
def test_a_player_needs_a_number_of_its_own_that_there_is(player: tuple[int, int]) -> None:
    with nao_hil.World(engine="mujoco") as world:
        world.add("nao-v6", name="first", player=(5, 1))
        with pytest.raises(ConfigurationError, match="player"):
            world.add("nao-v6", name="second", at=(1.0, 0.0, 0.0), player=player)


def test_lights_that_a_controller_sets_stay_its_own() -> None:
    report = schedule(Call(at=0.0, state="playing")).at(0.0)
    robot = EmulatedRobot(load_body("nao-v6"), seed=0, engine="mujoco", settle=0.1, player=(5, 1))
    robot.report_game(report)
    assert lights(robot.truth(), "ChestBoard") == GREEN
    own = [0] * len(LEDS)
    own[LEDS.index("ChestBoard/Led/Red")] = 200
    robot.dcm.light(own)
    robot.report_game(report)
    assert robot.truth().leds == tuple(own)
    robot.restart()
    robot.report_game(report)
    assert lights(robot.truth(), "ChestBoard") == GREEN
    robot.close()
