"""The commands as processes: `up`, `emulate`, `walk`; started in any order, killed, interrupted, misused."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from bridge.errors import LeaseRefused, WalkRefused
from bridge.link import ControllerLink
from bridge.link.client import GuardClient, WalkClient
from bridge.messages import SensorFrame
from bridge.messages.walk import WalkCommand
from bridge.recording.playback import read_recording
from nao_hil.analysis.inspection import inspect
from nao_hil.cli.main import run
from nao_hil.runs.announcer import WALKER_ENDED
from nao_hil.runs.monitor import Monitor
from tests.loops import until

Start = Callable[..., Any]

WITHOUT_PYBULLET = """
import sys
sys.modules.update(dict.fromkeys(("pybullet", "pybullet_data", "pybullet_utils")))
from nao_hil.cli.main import main
main()
"""
SLOW_TO_LOAD = """
import contextlib, sys, time

class Slow:
    def find_spec(self, name, path=None, target=None):
        if name == "{module}":
            print("loading", file=sys.stderr, flush=True)
            with contextlib.suppress(KeyboardInterrupt):  # as in a destructor
                time.sleep(30.0)

sys.meta_path.insert(0, Slow())
from nao_hil.cli.__main__ import main
main()
"""


@pytest.fixture
def monitor(endpoint: str) -> Iterator[Monitor]:
    with Monitor("nao", endpoint) as monitor:
        yield monitor


def heard(monitor: Monitor, condition: Callable[[SensorFrame], bool]) -> Callable[[], SensorFrame | None]:
    """Whether the newest sensor frame is as wanted."""

    def look() -> SensorFrame | None:
        monitor.connect()
        frame = monitor.sensors
        return frame if frame is not None and condition(frame) else None

    return look


def one_sentence(said: str) -> str:
    """The one error in a command's stderr."""
    assert "Traceback" not in said, said
    (error,) = [line for line in said.splitlines() if line.startswith("error: ")]
    return error


def test_two_runs_of_a_seed_are_the_same_byte_for_byte_and_the_same_in_process(
    start: Start, endpoint: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = []
    walk = ["--engine", "mujoco", "--gait", "dynamic", "--seed", "3", "--steps", "2", "--json"]
    for name in ("a", "b"):
        folder = tmp_path / name
        command = start("up", "--mode", "lockstep", *walk, "--listen", endpoint, "--out", str(folder))
        assert command.wait() == 0, command.stderr
        runs.append((command.result, (folder / "frames.mcap").read_bytes()))
        assert inspect(folder / "frames.mcap").frames_sha256 == command.result["frames_sha256"]
    (first, recording), (second, again) = runs
    assert first["frames_sha256"] == second["frames_sha256"]
    assert recording == again
    assert (first["fell"], first["steps"], first["cycles_missed"]) == (False, 2, 0)

    folder = tmp_path / "in-process"
    assert run(["up", "--mode", "in-process", *walk, "--out", str(folder)]) == 0
    result = json.loads(capsys.readouterr().out)
    assert result["frames_sha256"] == first["frames_sha256"]
    assert inspect(folder / "frames.mcap").frames_sha256 == first["frames_sha256"]
    shared = set(result) - {"real_time_factor", "config"}
    assert {name: result[name] for name in shared} == {name: first[name] for name in shared}


def test_without_pybullet_a_walker_starts_first_and_a_robot_goes_on_with_mujoco_unless_pybullet_was_asked_for(
    start: Start, endpoint: str, tmp_path: Path
) -> None:
    walk = ("walk", "--connect", endpoint, "--gait", "dynamic", "--steps", "2", "--json")
    walker = start(*walk, script=WITHOUT_PYBULLET)
    emulate = ["emulate", "--listen", endpoint, "--out", str(tmp_path / "run"), "--json"]
    refused = start(*emulate, "--engine", "pybullet", script=WITHOUT_PYBULLET)
    assert refused.wait() == 2
    assert "PyBullet is not installed: pip install 'nao-hil[emulator]'" in one_sentence(refused.stderr)

    robot = start(*emulate, "--mode", "lockstep", script=WITHOUT_PYBULLET)
    assert walker.wait() == 0, walker.stderr
    assert walker.result["steps"] == 2 and not walker.result["fell"]
    robot.interrupt()
    assert robot.process.returncode == 0, robot.stderr
    assert "PyBullet is not installed; the physics is MuJoCo's." in robot.stderr
    assert (robot.result["engine"], robot.result["steps"]) == ("mujoco", 2)
    assert "Traceback" not in walker.stderr + robot.stderr
    assert inspect(tmp_path / "run" / "frames.mcap").frames_sha256 == robot.result["frames_sha256"]


def test_a_walker_goes_on_with_a_robot_that_was_killed_and_restarted(
    start: Start, endpoint: str, tmp_path: Path, monitor: Monitor
) -> None:
    emulate = ["emulate", "--engine", "mujoco", "--listen", endpoint, "--mode", "lockstep"]
    emulate += ["--out", str(tmp_path / "run")]
    robot = start(*emulate)
    walker = start("walk", "--connect", endpoint, "--steps", "0", "--json")
    until(heard(monitor, lambda frame: frame.command > 200), "the walk")
    robot.kill()
    until(lambda: "the robot is gone" in " ".join(walker.stderr.split()), "the walker to notice")
    cut_off = list(read_recording(tmp_path / "run" / "frames.mcap"))
    assert cut_off[-1].time > 0.5

    restarted = time.time_ns()
    start(*emulate, "--overwrite")
    until(heard(monitor, lambda frame: frame.wall > restarted and frame.command > 200), "the new walk")
    walker.interrupt()
    assert walker.process.returncode == 130
    assert "Traceback" not in walker.stderr


@pytest.mark.realtime
def test_a_robot_keeps_its_cycle_while_walkers_come_and_go(
    start: Start, endpoint: str, tmp_path: Path, monitor: Monitor
) -> None:
    robot = start("emulate", "--listen", endpoint, "--out", str(tmp_path / "run"), "--json")
    walk = ["walk", "--connect", endpoint, "--steps", "0", "--controller"]
    first = start(*walk, "first")
    until(heard(monitor, lambda frame: frame.command > 0), "the first walker")

    second = start(*walk, "second")
    assert second.wait() == 3
    assert "held by controller `first`" in one_sentence(second.stderr)

    monitor.take_notices()
    first.kill()
    # first that the controller is gone, then what the guard does about it
    told = ("controller-gone", "guard-hold", "guard-crouch", "guard-rest")
    until(lambda: any(n.code in told for n in monitor.take_notices()), "the robot's notice")
    before = monitor.sensors
    assert before is not None
    until(heard(monitor, lambda frame: frame.seq > before.seq + 50), "the robot's next cycles")
    idle = monitor.sensors
    assert idle is not None and idle.command <= before.seq  # nobody's command since

    third = start(*walk, "third")
    until(heard(monitor, lambda frame: frame.command > idle.seq), "the third walker")
    third.interrupt()
    robot.interrupt()
    assert (third.process.returncode, robot.process.returncode) == (130, 0)
    assert "Traceback" not in third.stderr + robot.stderr + first.stderr
    assert inspect(tmp_path / "run" / "frames.mcap").frames_sha256 == robot.result["frames_sha256"]


def test_ctrl_c_ends_both_sides_with_their_recording_closed(
    start: Start, endpoint: str, tmp_path: Path, monitor: Monitor
) -> None:
    folder = tmp_path / "run"
    command = start(
        *("up", "--engine", "mujoco", "--mode", "lockstep", "--steps", "0", "--listen", endpoint),
        *("--out", str(folder), "--json"),
    )
    until(heard(monitor, lambda frame: frame.command > 100), "the walk")
    children = command.children()
    assert len(children) == 2
    command.interrupt()
    assert command.process.returncode == 130
    assert not any(Path(f"/proc/{pid}").exists() for pid in children)
    assert "Traceback" not in command.stderr
    assert "Interrupted" in command.stderr and "stands" not in command.stderr
    assert inspect(folder / "frames.mcap").frames_sha256 == command.result["frames_sha256"]
    assert command.result["cycles"] > 100


@pytest.mark.parametrize(
    ("command", "module"),
    [
        *(
            ("walk --connect", m)
            for m in ("bridge.errors", "nao_hil.cli.main", "nao_hil.cli.walk", "walker.process")
        ),
        ("up --listen", "nao_hil.runs.build"),
        ("up --listen", "emulator.engine.catalogue"),
    ],
)
def test_ctrl_c_while_the_libraries_load_leaves_no_traceback(
    start: Start, endpoint: str, command: str, module: str
) -> None:
    loads = start(*command.split(), endpoint, script=SLOW_TO_LOAD.format(module=module))
    until(lambda: "loading\n" in loads.stderr, "the command")
    loads.interrupt()
    assert (loads.process.returncode, loads.stderr) == (130, "loading\n")


def test_both_sides_end_with_an_up_that_is_killed(
    start: Start, endpoint: str, tmp_path: Path, monitor: Monitor
) -> None:
    folder = tmp_path / "run"
    command = start(
        *("up", "--engine", "mujoco", "--mode", "lockstep", "--steps", "0", "--listen", endpoint),
        *("--out", str(folder)),
    )
    until(heard(monitor, lambda frame: frame.command > 0), "the walk")
    children = [Path(f"/proc/{pid}/cmdline") for pid in command.children()]
    assert len(children) == 2
    command.kill()
    # A dead process that nobody has waited for has no command line.
    until(lambda: not any(child.exists() and child.read_bytes() for child in children), "both sides to end")
    summary = json.loads((folder / "summary.json").read_text())
    assert inspect(folder / "frames.mcap").frames_sha256 == summary["frames_sha256"]


@pytest.mark.parametrize("side", ["robot", "walker"])
def test_a_side_that_is_killed_ends_up_with_one_sentence(
    start: Start, endpoint: str, tmp_path: Path, monitor: Monitor, side: str
) -> None:
    command = start(
        *("up", "--engine", "mujoco", "--mode", "lockstep", "--steps", "0", "--listen", endpoint),
        *("--out", str(tmp_path / "run")),
    )
    until(heard(monitor, lambda frame: frame.command > 0), "the walk")
    (victim,) = command.children_with("emulate" if side == "robot" else "walk")
    os.kill(victim, signal.SIGKILL)
    assert command.wait() == 3
    assert f"the {side}'s process failed: it was killed by SIGKILL" in one_sentence(command.stderr)


def test_a_served_robot_whose_walker_is_killed_stays_and_gets_a_new_one_three_times_in_a_minute(
    start: Start, endpoint: str, tmp_path: Path, monitor: Monitor
) -> None:
    up = ["up", "--serve", "--engine", "mujoco", "--mode", "lockstep", "--listen", endpoint]
    command = start(*up, "--out", str(tmp_path / "run"), "--json")

    def walkers() -> list[int]:
        return command.children_with("walk")

    def killed() -> int:
        """The walker that was killed."""
        (victim,) = until(walkers, "a walker")
        os.kill(victim, signal.SIGKILL)
        until(lambda: victim not in walkers(), "its end")
        return int(victim)

    until(heard(monitor, lambda frame: frame.command > 5), "the walker")
    killed()
    lost = monitor.sensors
    assert lost is not None
    until(heard(monitor, lambda frame: frame.command > lost.seq + 5), "the next walker")
    monitor.take_notices()

    def given_up() -> bool:
        for walker in walkers():
            with contextlib.suppress(ProcessLookupError):
                os.kill(walker, signal.SIGKILL)
        return "is not started again" in command.stderr

    until(given_up, "the sentence")
    told = " ".join(command.stderr.split())
    assert told.count("The walker ended: it was killed by SIGKILL. A new one starts") >= 3
    assert "The walker ended 4 times within a minute, at last because it was killed by SIGKILL" in told
    until(
        lambda: [n for n in monitor.take_notices() if n.code == WALKER_ENDED and "4 times" in n.text],
        "a notice",
    )
    until(lambda: monitor.status and monitor.status.state == "rest", "the robot to rest")
    assert walkers() == [] and command.process.poll() is None
    command.interrupt()
    assert command.process.returncode == 3
    assert command.result["walker"] is None and not command.result["fell"]
    assert "Traceback" not in command.stderr


def test_a_port_in_use_is_one_sentence_and_leaves_the_folder_as_it_was(
    endpoint: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "emulate").mkdir()
    (tmp_path / "emulate" / "frames.mcap").write_text("old")
    with socket.create_server(("127.0.0.1", int(endpoint.rpartition(":")[2]))):
        for command in ("emulate", "up"):
            options = ["--engine", "mujoco", "--listen", endpoint, "--mode", "lockstep"]
            assert run([command, *options, "--out", str(tmp_path / command)]) == 3
            said = capfd.readouterr().err
            assert f"Cannot listen on {endpoint}: Address already in use" in one_sentence(said)
    assert (tmp_path / "emulate" / "frames.mcap").read_text() == "old"


def test_a_walker_that_waits_for_a_robot_hears_ctrl_c(start: Start, endpoint: str) -> None:
    # A signal that comes before the handler is in place ends the process too, with the same code.
    script = WITHOUT_PYBULLET.replace("main()", "print('ready', file=sys.stderr, flush=True)\nmain()")
    walker = start("walk", "--connect", endpoint, script=script)
    until(lambda: "ready\n" in walker.stderr, "the walker")
    walker.interrupt()
    assert walker.process.returncode == 130
    assert "Traceback" not in walker.stderr


def test_a_stranger_who_takes_the_robot_of_an_open_link_ends_nothing_and_the_walker_takes_it_back(
    start: Start, endpoint: str, tmp_path: Path, monitor: Monitor
) -> None:
    served = ["--serve", "--engine", "mujoco", "--mode", "lockstep", "--listen", endpoint]
    command = start("up", *served, "--out", str(tmp_path / "run"))
    log = tmp_path / "run" / "walker.log"
    until(heard(monitor, lambda frame: frame.command > 5), "the walker")
    with (
        GuardClient("nao", endpoint) as guard,
        ControllerLink("nao", endpoint, "thief") as thief,
        WalkClient("nao", endpoint) as walker,
    ):
        assert thief.wait_robot() is not None

        def taken() -> bool:
            guard.stop()
            guard.arm()
            with contextlib.suppress(LeaseRefused):  # the walker was first
                thief.acquire()
                return True
            return False

        until(taken, "the thief to be first")
        until(lambda: "held by controller `thief`" in log.read_text(), "the walker to say who has the robot")
        until(lambda: monitor.status and monitor.status.holder == "thief", "the robot to say so")
        with pytest.raises(WalkRefused, match="held by controller `thief`"):
            walker.send(WalkCommand(op="walk"))
        assert command.process.poll() is None
        thief.release()
        until(lambda: monitor.status and monitor.status.holder == "walker", "the walker to take it back")
        until(lambda: monitor.status and monitor.status.under_command, "the robot to obey it")
    command.interrupt()
    assert command.process.returncode == 0, command.stderr


def test_a_pause_of_all_processes_is_told_and_the_run_goes_on(
    start: Start, endpoint: str, tmp_path: Path, monitor: Monitor
) -> None:
    command = start(
        *(
            "up",
            "--serve",  # a robot that walks in real time falls where it is starved
            "--engine",
            "mujoco",
            "--listen",
            endpoint,
            "--out",
            str(tmp_path / "run"),
            "--json",
        )
    )
    before = until(heard(monitor, lambda frame: frame.command > 50), "the walker")
    assert before is not None
    pids = [command.process.pid, *command.children()]
    for pid in pids:
        os.kill(pid, signal.SIGSTOP)
    time.sleep(1.5)
    for pid in pids:
        os.kill(pid, signal.SIGCONT)
    until(heard(monitor, lambda frame: frame.command > before.seq + 50), "the walker after the pause")
    command.interrupt()
    told = " ".join(command.stderr.split())
    assert re.search(r"the robot says: The robot's process stood still for \d", told)
    log = " ".join((tmp_path / "run" / "walker.log").read_text().split())
    assert re.search(r"this process stood still for \d", log)
    assert "The run did not keep real time" in told
    assert "The run did not keep real time" in command.result["starved"]


@pytest.mark.parametrize("command", ["up --steps 2", "walk", "serve lola"])
def test_without_loopback_a_command_says_so_at_once(command: str, tmp_path: Path) -> None:
    alone = ["unshare", "--map-root-user", "--net"]
    if subprocess.run([*alone, "true"], capture_output=True, check=False).returncode != 0:
        pytest.skip("this machine gives no network of its own")
    nao_hil = [sys.executable, "-m", "nao_hil.cli", *command.split()]
    ended = subprocess.run(
        [*alone, *nao_hil], cwd=tmp_path, capture_output=True, text=True, timeout=100, check=False
    )
    assert ended.returncode == 3
    assert "loopback interface is down, `ip link set lo up` starts it" in one_sentence(ended.stderr)
