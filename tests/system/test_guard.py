"""The guard in processes: a controller killed, an emergency stop, arming; judged by what the robot says."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

import nao_hil
from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.errors import LeaseRefused
from bridge.guard import Guard, GuardStatus
from bridge.link import ControllerLink
from bridge.link.client import GuardClient
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear
from nao_hil.runs.build import controller_maker
from nao_hil.runs.config import RunConfig
from nao_hil.runs.monitor import Monitor
from tests.loops import TIMEOUT, repeat_while, until
from tests.system.test_lola_service import Client, pack

Start = Callable[..., Any]


def words(text: str) -> str:
    return " ".join(text.split())


def rests(guard: GuardClient) -> Callable[[], GuardStatus | None]:
    def look() -> GuardStatus | None:
        status = guard.status()
        return status if status.state == "rest" else None

    return look


def walked(monitor: Monitor, steps: int) -> Callable[[], bool]:
    def look() -> bool:
        telemetry = monitor.telemetry
        return telemetry is not None and telemetry.step >= steps

    return look


def standing_height(monitor: Monitor) -> float:
    assert monitor.truth is not None
    return monitor.truth.torso_position[2]


@pytest.mark.parametrize(
    ("mode", "steps"), [("lockstep", 3), pytest.param("real-time", 6, marks=pytest.mark.realtime)]
)
def test_a_robot_whose_walker_is_killed_rests_and_the_next_walker_takes_it_over(
    mode: str, steps: int, start: Start, endpoint: str, tmp_path: Any
) -> None:
    emulate = ["emulate", "--engine", "mujoco", "--listen", endpoint, "--mode", mode]
    robot = start(*emulate, "--out", str(tmp_path / "run"), "--json")
    walk = ["walk", "--connect", endpoint, "--gait", "dynamic"]
    with Monitor("nao", endpoint) as monitor, GuardClient("nao", endpoint, TIMEOUT) as guard:
        until(monitor.connect, "the robot")
        assert guard.status().state == "idle"
        walker = start(*walk, "--steps", "0", "--controller", "doomed")
        until(walked(monitor, steps), "the walk")
        status = until(lambda: monitor.status if monitor.walk else None, "the robot's report")
        assert (status.state in ("approach", "active"), status.holder) == (True, "doomed")
        high = standing_height(monitor)
        walker.kill()
        status = until(rests(guard), "the robot to rest")
        assert status.reason == "silence"
        assert monitor.truth is not None and not monitor.truth.fell
        # What the sensors say lags by a cycle, and in lockstep no cycle follows the one that ended the descent.
        until(lambda: monitor.sensors and max(monitor.sensors.stiffness) < 0.15, "the joints to let go")
        until(lambda: monitor.status and monitor.status.state == "rest", "the robot to report it")
        assert monitor.telemetry is not None and monitor.telemetry.state == "walk"  # the walker's last word
        assert monitor.walk is None and monitor.status is not None and not monitor.status.holder
        assert standing_height(monitor) < high - 0.03  # a crouch is 5 cm lower than the walk
        last = start(*walk, "--steps", "2", "--json")
        if mode == "lockstep":  # in real time a busy machine may make the walk itself fall
            assert last.wait() == 0, last.stderr
            assert last.result["steps"] == 2
        else:
            until(lambda: guard.status().state == "active", "the next walker to be obeyed")
            last.interrupt()
    robot.interrupt()
    assert robot.process.returncode == 0
    assert "Traceback" not in robot.stderr


def test_a_program_that_paused_asks_for_the_robot_that_its_guard_took(start: Start, endpoint: str) -> None:
    start("emulate", "--robot", "nao-v6", "--engine", "mujoco", "--start", "hang", "--listen", endpoint)
    with (
        nao_hil.connect(endpoint, timeout=TIMEOUT) as robot,
        GuardClient("nao", endpoint, TIMEOUT) as guard,
    ):
        position = list(robot.first_target)
        position[INDEX["HeadYaw"]] = 0.5
        robot.step(robot.first_target)
        until(lambda: guard.status().reason == "silence" and not guard.status().holder, "the guard to take it")
        until(lambda: robot.step(position).position[INDEX["HeadYaw"]] > 0.4, "the head to turn", pause=0.0)


def test_a_program_that_paused_is_told_who_took_the_robot_meanwhile(start: Start, endpoint: str) -> None:
    start("emulate", "--robot", "nao-v6", "--engine", "mujoco", "--start", "hang", "--listen", endpoint)
    with nao_hil.connect(endpoint, timeout=TIMEOUT) as robot, ControllerLink("nao", endpoint, "bert") as other:
        robot.step(robot.first_target)
        assert other.wait_robot(timeout=TIMEOUT)

        def refused() -> str:
            """Sentence of a step while the other one has the robot, which it loses where it is starved."""
            try:
                other.acquire()
            except LeaseRefused:  # the paused program has it still, or again
                return ""
            try:
                robot.step(robot.first_target)
            except LeaseRefused as error:
                return str(error)
            return ""

        assert "held by controller `bert`" in until(refused, "the refusal", pause=0.0)


def test_an_emergency_stop_takes_the_robot_down_until_it_is_armed(
    start: Start, endpoint: str, tmp_path: Any
) -> None:
    where = ["--connect", endpoint]
    emulate = ["emulate", "--engine", "mujoco", "--listen", endpoint, "--mode", "lockstep"]
    start(*emulate, "--out", str(tmp_path / "run"))
    walker = start("walk", *where, "--gait", "static", "--steps", "0", "--json")
    with Monitor("nao", endpoint) as monitor, GuardClient("nao", endpoint, TIMEOUT) as guard:
        until(monitor.connect, "the robot")
        until(lambda: monitor.sensors and monitor.sensors.command > 200, "the walk")
        stop = start("stop", *where, "--json")
        assert stop.wait() == 0, stop.stderr
        assert (stop.result["reason"], stop.result["armed"]) == ("stop", False)
        until(rests(guard), "the robot to rest")
        assert walker.wait() == 3  # who arms the robot again does not ask for this walk to go on
        assert "nao-hil arm" in words(walker.stderr)
        assert walker.result["ticks"] > 0  # the walk so far is told all the same
        assert "engine" not in walker.result["config"]  # the robot's own, which the walker does not know
        unsure = start("arm", *where)
        assert unsure.wait() == 2
        assert "say --yes" in words(unsure.stderr)
        assert not guard.status().armed
        arm = start("arm", "--yes", *where, "--json")
        assert arm.wait() == 0, arm.stderr
        assert arm.result["armed"] is True
        again = start("walk", *where, "--steps", "0")
        until(lambda: guard.status().state == "active", "the next walk")
    again.interrupt()
    assert "Traceback" not in walker.stderr + again.stderr


def test_a_robot_that_starts_disarmed_and_in_a_dry_run_moves_for_nobody(
    start: Start, endpoint: str, tmp_path: Any
) -> None:
    emulate = ["emulate", "--engine", "mujoco", "--listen", endpoint, "--disarmed", "--dry-run"]
    robot = start(*emulate, "--out", str(tmp_path / "run"))
    walker = start("walk", "--connect", endpoint, "--steps", "0")
    with Monitor("nao", endpoint) as monitor, GuardClient("nao", endpoint, TIMEOUT) as guard:
        until(monitor.connect, "the robot")
        until(lambda: "nao-hil arm" in words(walker.stderr), "the walker to be told")
        assert guard.arm("a test").armed
        status = until(lambda: guard.status() if guard.status().state == "active" else None, "commands")
        assert status.dry_run
        seq = monitor.sensors.seq if monitor.sensors else 0
        until(lambda: monitor.sensors and monitor.sensors.seq > seq + 100, "some cycles")
        assert monitor.sensors is not None and monitor.sensors.command == -1
    walker.interrupt()
    robot.interrupt()


def test_a_lola_client_in_lockstep_gets_its_packets_after_an_emergency_stop(
    start: Start, endpoint: str, tmp_path: Any, request: pytest.FixtureRequest
) -> None:
    emulate = ["emulate", "--engine", "mujoco", "--robot", "nao-v6", "--listen", endpoint, "--mode", "lockstep"]
    start(*emulate, "--out", str(tmp_path / "run"))
    path = str(tmp_path / "lola")
    served = start("serve", "lola", "--connect", endpoint, "--socket", path)
    until(lambda: (tmp_path / "lola").exists(), "the socket")
    client = Client(path)
    request.addfinalizer(client.socket.close)
    held = client.read()["Position"]

    def cycles(count: int) -> dict[str, Any]:
        for _ in range(count):
            client.send(pack(Position=held, Stiffness=[0.8] * 25))
            packet = client.read()
        return packet

    cycles(20)
    with GuardClient("nao", endpoint, TIMEOUT) as guard:
        guard.stop()
        until(lambda: cycles(10) and guard.status().state == "rest", "the robot to rest")
        before = guard.status()
        assert max(cycles(200)["Stiffness"]) < 0.15
        assert guard.status() == before  # nothing of it was done
        guard.arm()
        assert max(cycles(100)["Stiffness"]) > 0.7
    assert "Traceback" not in served.stderr


@pytest.mark.parametrize(("gait", "steps"), [("static", 2), ("dynamic", 6)])
def test_every_command_of_a_walk_passes_unchanged(gait: str, steps: int) -> None:
    body = load_body("nao-v3")
    guard = Guard(body)
    controller = controller_maker(RunConfig(gait=gait, steps=steps))(body, body.cycle)
    with EmulatedRobot(body, seed=0, engine="mujoco", wear=load_wear("nominal")) as robot:
        for _ in repeat_while(lambda: not controller.done):
            command = guard.check(controller.tick(robot.frame), robot.frame.seq)
            given = guard.cycle(robot.frame, command)
            assert given == command, robot.frame.seq
            robot.advance(given)
        assert controller.telemetry.step == steps
    assert [notice.code for notice in guard.take_notices()] == ["guard-active"]
