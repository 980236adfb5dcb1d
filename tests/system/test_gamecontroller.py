"""A GameController and a referee for robots on a link."""

from __future__ import annotations

import contextlib
import math
import socket
import threading
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Final

import pytest

import nao_hil
from bridge.adapters.gamecontroller.packets import RobotStatus, decode_game, decode_status, encode_game
from bridge.adapters.gamecontroller.referee import Call, Schedule, Team
from bridge.messages.game import RobotGame
from nao_hil.runs.monitor import Monitor
from tests.loops import TIMEOUT, repeat_while, until
from tests.ports import free_port

Start = Callable[..., Any]
WORLD: Final = """
[[robots]]
name = "home"
robot = "nao-v6"
at = [-1.0, 0.5]
team = 5
player = 1

[[robots]]
name = "away"
robot = "nao-v6"
seed = 1
at = [1.0, 0.25]
yaw = 180.0
team = 19
player = 4
"""
TEAMS: Final = (Team(number=5, colour="blue"), Team(number=19, colour="red"))


def world(tmp_path: Path) -> str:
    file = tmp_path / "world.toml"
    file.write_text(WORLD)
    return str(file)


def test_a_gamecontroller_reaches_the_robots_and_hears_from_them_among_a_flood_of_other_packets(
    start: Start, endpoint: str, tmp_path: Path
) -> None:
    robots = ("emulate", "--world", world(tmp_path), "--engine", "mujoco", "--listen", endpoint)
    emulate = start(*robots, "--out", str(tmp_path / "run"), "--json")
    controller = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    answers = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    with ExitStack() as opened, controller, answers:
        answers.bind(("127.0.0.1", 0))
        answers.setblocking(False)
        monitors = {name: opened.enter_context(Monitor(name, endpoint)) for name in ("home", "away")}
        until(lambda: all(monitor.connect() and monitor.truth for monitor in monitors.values()), "both robots")
        port = free_port()
        place = ("--listen", f"127.0.0.1:{port}", "--return-port", str(answers.getsockname()[1]))
        served = start("serve", "gamecontroller", *place, "--connect", endpoint, "--json")
        until(lambda: f"127.0.0.1:{port}" in served.stderr, "the address on the screen")
        called = Schedule(
            teams=TEAMS,
            calls=(
                Call(at=0.0, state="playing"),
                Call(at=0.0, team=19, player=4, penalty="player-pushing"),
                Call(at=0.0, goal=19),
            ),
        )
        good = encode_game(called.at(0.0), 0)
        strangers = encode_game(Schedule(teams=(Team(number=1, colour="blue"), TEAMS[0]), calls=()).at(0.0), 0)
        strangers = strangers[:18] + b"\x63" + strangers[19:68] + b"\x62" + strangers[69:]  # teams 99 and 98
        bad = (b"", b"RGme", good[:-1], good[:4] + b"\x0f" + good[5:], strangers)

        def game(name: str) -> RobotGame:
            truth = monitors[name].truth
            assert truth is not None
            return truth.game

        def shown() -> bool:
            for packet in bad * 20:
                controller.sendto(packet, ("127.0.0.1", port))
            controller.sendto(good, ("127.0.0.1", port))
            return {game(name).state for name in monitors} == {"playing"}

        until(shown, "the game", pause=0.1)
        home, away = game("home"), game("away")
        assert (home.team, home.player, home.score, home.penalty) == (5, 1, (0, 1), "none")
        assert (away.team, away.player, away.score, away.penalty) == (19, 4, (1, 0), "player-pushing")

        def answered() -> bool:
            """Sends on: who has not been heard for two seconds gets no answer."""
            shown()
            with contextlib.suppress(BlockingIOError):
                read = decode_status(answers.recv(2048))
                found[read.team] = read
            return len(found) == 2

        found: dict[int, RobotStatus] = {}
        until(answered, "an answer of both robots", pause=0.1)
        # x towards the goal of the opponents, and so turned for the second team
        assert found[5].pose == pytest.approx((-1.0, 0.5, 0.0), abs=0.1)
        assert found[19].pose[:2] == pytest.approx((-1.0, -0.25), abs=0.1)
        assert abs(math.sin(found[19].pose[2])) < 0.1 and math.cos(found[19].pose[2]) > 0.9
        assert {status.fallen for status in found.values()} == {False}
        assert {status.ball_age for status in found.values()} == {-1.0}
        served.interrupt()
        emulate.interrupt()
    counts = served.result
    assert counts["ignored"] >= 100 and counts["packets"] >= 1 and counts["reports"] >= 1
    assert served.stderr.count("ignored: ") < counts["ignored"] / 10  # one notice for many
    run = nao_hil.load(tmp_path / "run" / "away")["world/truth"]
    assert set(run["game.state"]) >= {"", "playing"} and "player-pushing" in set(run["game.penalty"])


def test_a_half_in_lockstep_is_the_same_twice_on_the_link_and_foreign_programs_get_its_packets(
    start: Start, endpoint: str, tmp_path: Path
) -> None:
    listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    with listener:
        port = free_port()
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(("0.0.0.0", port))  # as a robot's program does
        listener.settimeout(TIMEOUT)
        (tmp_path / "half.toml").write_text(
            f'send = "127.255.255.255:{port}"\n'
            'teams = [{ number = 5, colour = "blue" }, { number = 19, colour = "red" }]\n'
            'calls = [{ at = 0.4, state = "ready" }, { at = 1.1, state = "set" },\n'
            '{ at = 1.6, state = "playing" }]\n'
        )
        runs = []
        for number in range(2):
            out = tmp_path / str(number)
            command = start(
                *("emulate", "--world", world(tmp_path), "--game", str(tmp_path / "half.toml")),
                *(
                    "--engine",
                    "mujoco",
                    "--mode",
                    "lockstep",
                    "--listen",
                    endpoint,
                    "--out",
                    str(out),
                    "--json",
                ),
            )
            hold_both(endpoint, 200)  # 2.4 s
            command.interrupt()
            robots = command.result["robots"]
            truths = [nao_hil.load(out / name)["world/truth"] for name in ("home", "away")]
            states = [list(truth["game.state"]) for truth in truths]
            assert states[0] == states[1] and list(dict.fromkeys(states[0])) == [
                "initial",
                "ready",
                "set",
                "playing",
            ]
            lights = [truth["leds"].tolist() for truth in truths]
            runs.append(([robots[name]["frames_sha256"] for name in robots], states, lights))
            packets = [decode_game(listener.recv(2048)) for _ in range(5)]
            assert [packet.state for packet in packets] == ["initial", "ready", "ready", "set", "playing"]
        assert runs[0] == runs[1]


def hold_both(endpoint: str, cycles: int) -> None:
    """Hold both robots in their pose for so many cycles."""

    seen: dict[str, int] = {}
    with ExitStack() as opened:
        names = ("home", "away")
        robots = {
            name: opened.enter_context(nao_hil.connect(endpoint, robot=name, timeout=TIMEOUT)) for name in names
        }

        def hold(name: str) -> None:
            robot = robots[name]
            for _ in repeat_while(lambda: robot.frame.seq < cycles):
                robot.step(robot.first_target)
            seen[name] = robot.frame.seq

        threads = [threading.Thread(target=hold, args=(name,)) for name in names]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(TIMEOUT)
    assert seen == dict.fromkeys(names, cycles)
