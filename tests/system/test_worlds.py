"""Several robots in one process on one link: each by its name, in lockstep and in real time."""

from __future__ import annotations

import contextlib
import random
import threading
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import Any, Final

import numpy as np
import zenoh

import nao_hil
from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.errors import RobotSilent
from bridge.guard import Guard
from bridge.link import RobotLink, keys
from bridge.link.client import GuardClient, WorldClient, link_robots
from bridge.link.session import open_client
from bridge.messages import ActuatorFrame, SensorFrame, decode
from bridge.messages.world import Pause, Reset, Resume, Step
from emulator.engine.settings import SETTINGS
from emulator.process import RobotSide, WorldProcess
from emulator.robot import EmulatedRobot
from emulator.scenarios import FLAT
from emulator.start import build_world
from emulator.timing import CycleTimer
from tests.frames import info_of_robot
from tests.loops import TIMEOUT, repeat_while, until
from tests.ports import free_endpoint

Start = Callable[..., Any]
BODY = load_body("nao-v6")
HEAD = INDEX["HeadYaw"]
ANGLES = {"nao1": 0.5, "nao2": -0.4}
CYCLES = 60


def turn_heads(endpoint: str, waits: bool) -> dict[str, list[SensorFrame]]:
    """Let a controller of each robot turn its head; the frames that each saw."""
    seen: dict[str, list[SensorFrame]] = {}
    with ExitStack() as opened:
        robots = {
            name: opened.enter_context(nao_hil.connect(endpoint, robot=name, timeout=TIMEOUT))
            for name in ANGLES
        }

        def control(name: str) -> None:
            robot = robots[name]
            position = list(robot.first_target)
            position[HEAD] = ANGLES[name]
            seen[name] = [robot.frame]

            def there() -> bool:
                """In real time a starved controller loses its robot for a while."""
                return waits or abs(robot.frame.position[HEAD] - ANGLES[name]) < 0.1

            for _ in repeat_while(lambda: robot.frame.seq < CYCLES or not there()):
                seen[name].append(robot.step(position))

        threads = [threading.Thread(target=control, args=(name,)) for name in ANGLES]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(TIMEOUT)
    assert all(abs(seen[name][-1].position[HEAD] - angle) < 0.1 for name, angle in ANGLES.items())
    return seen


def test_a_world_in_lockstep_waits_for_all_that_are_held_and_repeats(
    start: Start, endpoint: str, tmp_path: Path
) -> None:
    """The third robot, which nobody holds, runs along."""
    runs = []
    for number in range(2):
        command = start(
            *("emulate", "--robot", "nao-v6", "--engine", "mujoco", "--robots", "3", "--mode", "lockstep"),
            *("--seed", "5", "--listen", endpoint, "--out", str(tmp_path / str(number)), "--json"),
        )
        seen = turn_heads(endpoint, waits=True)
        command.interrupt()
        for frames in seen.values():
            assert [frame.seq for frame in frames] == list(range(CYCLES + 1))
            assert frames[-1].missed == 0
        robots = command.result["robots"]
        assert list(robots) == ["nao1", "nao2", "nao3"]
        assert len({robots[name]["cycles"] for name in robots}) == 1
        assert [robots[name]["config"]["seed"] for name in robots] == [5, 6, 7]
        runs.append([[(frame.position, frame.fsr) for frame in frames] for frames in seen.values()])
        assert (tmp_path / str(number) / "nao3" / "frames.mcap").exists()
    assert runs[0] == runs[1]


def test_robots_in_real_time_take_the_commands_of_their_name_and_begin_again_together() -> None:
    endpoint, stop = free_endpoint(), threading.Event()
    world = build_world("mujoco", SETTINGS, FLAT, 0)
    robots = [
        EmulatedRobot(BODY, seed=0, settle=0.1, name=name, at=(0.0, 0.8 * i, 0.0), world=world)
        for i, name in enumerate(ANGLES)
    ]
    world.start()
    with ExitStack() as opened:
        links: list[RobotLink] = []
        for name in ANGLES:
            info = info_of_robot(robot=name, body=BODY.name, mode="real-time", cycle=BODY.cycle)
            beside = links[0] if links else None
            links.append(opened.enter_context(RobotLink(info, endpoint, announced=False, beside=beside)))
        sides = [RobotSide(robot, link, Guard(BODY), []) for robot, link in zip(robots, links, strict=True)]
        process = WorldProcess(sides, stop)
        thread = threading.Thread(target=lambda: process.real_time(CycleTimer(BODY.cycle)))
        thread.start()
        try:
            turn_heads(endpoint, waits=False)
            with WorldClient("nao2", endpoint) as client:
                client.send(Pause())
                client.send(Reset())
                assert [robot.seq for robot in robots] == [0, 0]
                client.send(Step(cycles=50))
                client.send(Reset(scope="robot"))
                assert [robot.seq for robot in robots] == [50, 0]
                client.send(Resume())
                until(lambda: min(robot.seq for robot in robots) > 0, "the world to go on")
        finally:
            stop.set()
            thread.join(TIMEOUT)
    assert not thread.is_alive()


def test_a_world_file_lists_unlike_robots_and_an_unlike_cycle_is_refused(start: Start, tmp_path: Path) -> None:
    robots = '[[robots]]\nname = "red"\n[[robots]]\nname = "blue"\nrobot = "nao-v6"\nat = [1.0, 0.0]\n'
    file = tmp_path / "game.toml"
    file.write_text(robots)
    command = start("emulate", "--world", str(file), "--listen", free_endpoint(), "--out", str(tmp_path / "o"))
    assert command.wait() == 2
    assert "robots of one cycle share a world" in command.stderr
    command = start("emulate", "--world", str(file), "--robot", "nao-v5", "--listen", free_endpoint())
    assert command.wait() == 2
    assert "The file of --world gives each robot its robot" in command.stderr


JOINTS: Final = {"red": "HeadYaw", "blue": "LWristYaw", "green": "RWristYaw"}
"""The joint that each robot is told to turn; a limp arm or head leaves them at 0."""
PATTERN = """
import math, sys
import nao_hil
from bridge.body.joints import INDEX
endpoint, name, joint = sys.argv[1:]
with nao_hil.connect(endpoint, robot=name, timeout=60.0) as robot:
    position = list(robot.first_target)
    while True:
        position[INDEX[joint]] = 0.6 + 0.2 * math.sin(5.0 * robot.frame.time)
        robot.step(position)
"""


def until_there(endpoint: str, count: int) -> None:
    """Wait for so many robots of a link."""

    def there() -> bool:
        with contextlib.suppress(RobotSilent):
            return len(link_robots(endpoint, 0.0)) == count
        return False

    until(there, "the robots")


def world_of_three(folder: Path) -> Path:
    """Unlike robots that hang: commands that cross are seen, and none falls."""
    file = folder / "game.toml"
    file.write_text(
        "".join(
            f'[[robots]]\nname = "{name}"\nrobot = "nao-v6"\nwear = "{wear}"\nseed = {i}\n'
            f'start = "hang"\nat = [{float(i)}, 0.0]\n'
            for i, (name, wear) in enumerate(zip(JOINTS, ("nominal", "worn", "ensemble:1"), strict=True))
        )
    )
    return file


def test_commands_never_cross_while_clients_are_killed_and_doubled_and_frames_copied(
    start: Start, endpoint: str, tmp_path: Path
) -> None:
    """Frames sent to one robot are sent to the others too, and again to itself."""
    chance, out = random.Random(3), tmp_path / "run"
    emulate = ("emulate", "--world", str(world_of_three(tmp_path)), "--engine", "mujoco", "--listen", endpoint)
    command = start(*emulate, "--out", str(out), "--json")

    def client(name: str) -> Any:
        return start(endpoint, name, JOINTS[name], script=PATTERN)

    until_there(endpoint, len(JOINTS))
    with ExitStack() as opened:
        guards = [opened.enter_context(GuardClient(name, endpoint, TIMEOUT)) for name in JOINTS]
        session = opened.enter_context(open_client(endpoint))

        def copy(sample: zenoh.Sample) -> None:
            seal = sample.attachment.to_bytes() if sample.attachment else b""
            if seal in seals:  # a copy itself
                return
            heard.append(seal)
            if len(heard) % 5:  # more are too many for a busy machine
                return
            seals.add(seal)
            for name in JOINTS:
                session.put(keys.topic_key(name, ActuatorFrame), sample.payload.to_bytes(), attachment=seal)

        def commanded(name: str, guard: GuardClient) -> bool:
            if (
                clients[name].process.poll() is not None
            ):  # the robot had not noticed yet that the one before died
                clients[name] = client(name)
            with contextlib.suppress(RobotSilent):  # by a machine without time for it
                return guard.status().state == "active"
            return False

        def until_commanded() -> None:
            for name, guard in zip(JOINTS, guards, strict=True):
                until(lambda: commanded(name, guard), f"commands to {name}")  # noqa: B023

        def see(sample: zenoh.Sample) -> None:
            name = str(sample.key_expr).split("/")[1]
            angle = decode(sample.payload.to_bytes(), SensorFrame).position[INDEX[JOINTS[name]]]
            highest[name] = max(highest[name], angle)

        seals, heard, highest = set[bytes](), list[bytes](), dict.fromkeys(JOINTS, 0.0)
        opened.enter_context(session.declare_subscriber(keys.topic_key("*", ActuatorFrame), copy))
        opened.enter_context(session.declare_subscriber(keys.topic_key("*", SensorFrame), see))
        clients = {name: client(name) for name in JOINTS}
        for _ in range(4):
            until_commanded()
            victim, doubled = chance.sample(list(JOINTS), 2)
            pair = [client(doubled), clients[doubled]]
            until(lambda: any(each.process.poll() is not None for each in pair), "the end of one of two")  # noqa: B023
            ended = [each for each in pair if each.process.poll() is not None]
            # the second one, unless a starved first one was silent for so long that it lost the robot
            assert all("LeaseRefused" in each.stderr or "RobotSilent" in each.stderr for each in ended)
            clients[doubled] = next((each for each in pair if each not in ended), pair[0])
            clients[victim].kill()
            clients[victim] = client(victim)
        until_commanded()
        until(lambda: min(highest.values()) > 0.6 and len(seals) > 40, "each joint to swing, and copies")
        for each in clients.values():
            each.kill()
    command.interrupt()
    for name, joint in JOINTS.items():
        assert command.result["robots"][name]["commands_refused"] > 20
        run = nao_hil.load(out / name)
        measured, commands = run["sensors"]["position"], run["actuators"]
        others = [INDEX[other] for other in JOINTS.values() if other != joint]
        assert measured[:, INDEX[joint]].max() > 0.6
        assert np.abs(measured[:, others]).max() < 0.3
        # one frame of another robot would let these joints jump by 0.09 rad, which the guard allows in a cycle
        steady = (cycles := np.diff(commands["reply_to"])) > 0
        steady &= cycles <= 3  # no new client
        assert steady.sum() > 50
        assert np.abs(np.diff(commands["position"][:, others], axis=0))[steady].max() < 0.02
