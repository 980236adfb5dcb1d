"""Programs that know LoLA alone, on a served robot in processes of their own."""

from __future__ import annotations

import contextlib
import math
import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import msgspec
import pytest

from bridge.adapters.lola.codec import SENSOR_BYTES, SENSORS, Map, MapStream
from bridge.adapters.lola.packets import actuator_map, sensor_frame
from bridge.body import load_body
from bridge.body.joints import JOINTS
from bridge.body.postures import POSTURES
from bridge.messages import ActuatorFrame, SensorFrame, TruthFrame
from bridge.messages.world import StartName
from bridge.motion import load_motion
from bridge.realtime import ROBOT_PRIORITY, leave_real_time, quiet_process
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear
from nao_hil.runs.build import build_robot, controller_maker
from nao_hil.runs.config import RunConfig, run_config
from tests.loops import TIMEOUT, until
from tests.processes import REPOSITORY, module_of
from tests.system.lola_robot import LolaSocket

WEIGHT = 53.0
"""N, of a V6 (data sheet: 5.4 kg)."""
LET_GO = 60
"""Cycles in which a robot that is laid down is limp."""
LIMP = tuple(0.0 if name[1:].startswith(("Shoulder", "Elbow", "Wrist", "Hand")) else 1.0 for name in JOINTS)
CYCLES = 600
STANDING = 40
"""Cycles in which the robot stands as it is before it walks."""
START = 100
"""Packets in which the server finds the phase of the frames."""
PACKETS = 500


@pytest.fixture
def served(
    start: Callable[..., Any], endpoint: str, tmp_path: Path
) -> Iterator[Callable[..., tuple[Any, socket.socket]]]:
    """Starts a V6 with options and serves it; gives the robot's command and a connected socket."""
    with contextlib.ExitStack() as stack:

        def begin(*options: str) -> tuple[Any, socket.socket]:
            path = tmp_path / "robocup"
            where = ("--listen", endpoint, "--out", str(tmp_path / "run"), "--json")
            robot = start("emulate", "--robot", "nao-v6", *options, *where)
            start("serve", "lola", "--socket", str(path), "--connect", endpoint)
            until(path.exists, "the socket")
            peer = stack.enter_context(socket.socket(socket.AF_UNIX))
            peer.settimeout(TIMEOUT)
            peer.connect(str(path))
            return robot, peer

        yield begin


def tilt(truth: TruthFrame) -> float:
    """Of the torso, degrees: the z axis of the world against its own."""
    x, y, _, _ = truth.torso_orientation
    return math.degrees(math.acos(1.0 - 2.0 * (x * x + y * y)))


def stands(truth: TruthFrame) -> bool:
    return not truth.fell and tilt(truth) < 10.0 and on_feet(truth) > 0.9


def on_feet(truth: TruthFrame) -> float:
    """Share of the weight."""
    return (truth.left.force[2] + truth.right.force[2]) / WEIGHT


def test_the_motions_of_a_day_through_lola() -> None:
    """Up from back, front and side, down to the seat, up from it, and a crouch; one robot, in lockstep."""
    pytest.importorskip("mujoco")
    body = load_body("nao-v6")
    example = module_of(REPOSITORY / "examples" / "lola_motion.py")
    wear = load_wear("nominal")
    with EmulatedRobot(body, seed=1, engine="mujoco", wear=wear, start="lie-back") as robot:
        lola = LolaSocket(robot)
        packet = example.exchange(lola, {})

        def after(*names: str) -> TruthFrame:
            nonlocal packet
            for name in names:
                packet = example.play(lola, load_motion(name), packet)
            return robot.truth()

        def lie(pose: StartName) -> None:
            """Somebody lays the robot down, and the client lets go of it."""
            nonlocal packet
            robot.lay_down(pose)
            for _ in range(LET_GO):
                packet = example.exchange(lola, {"Stiffness": [0.0] * 25})

        assert stands(after("get-up-back"))
        seated = after("sit-down")
        assert tilt(seated) < 25.0 and on_feet(seated) < 0.3
        assert stands(after("stand-up"))
        assert stands(after("crouch"))
        lie("lie-front")
        assert stands(after("get-up-front"))
        lie("lie-side")
        assert stands(after("roll-from-side", "get-up-back"))


def settings() -> RunConfig:
    return run_config(None, engine="mujoco", robot="nao-v6", wear="ideal", gait="dynamic", steps=12, seed=3)


class Program:
    """Stands where it finds the robot, then walks, and looks to its left with a head that was limp."""

    def __init__(self) -> None:
        self._walk = controller_maker(settings())
        self._controller: Any = None
        self._stand: tuple[float, ...] | None = None

    def answer(self, frame: SensorFrame) -> ActuatorFrame:
        if frame.seq < STANDING:
            self._stand = self._stand or frame.position
            stiffness = (0.0, *LIMP[1:])
            return ActuatorFrame(reply_to=frame.seq, position=self._stand, stiffness=stiffness)
        if self._controller is None:
            self._controller = self._walk(load_body("nao-v6"), 0.012)
        command = self._controller.tick(frame)
        position = (0.5, *command.position[1:])
        return msgspec.structs.replace(command, position=position, stiffness=LIMP)


def packet(peer: socket.socket, stream: MapStream) -> Map:
    for _ in range(100):
        if maps := stream.feed(peer.recv(896)):
            return maps[0]
    raise EOFError


def in_process() -> float:
    """Distance walked without a link, m."""
    program = Program()
    with build_robot(settings()) as robot:
        begun = robot.truth().torso_position[0]
        for _ in range(CYCLES):
            robot.advance(program.answer(robot.frame))
        return robot.truth().torso_position[0] - begun


def test_a_walk_with_limp_arms_is_as_fast_through_lola_as_in_process(served: Any) -> None:
    lockstep = ("--engine", "mujoco", "--wear", "ideal", "--mode", "lockstep")
    robot, peer = served(*lockstep, "--seed", "3")
    program, stream = Program(), MapStream(SENSORS)
    for seq in range(CYCLES):
        command = program.answer(sensor_frame(packet(peer, stream), seq=seq))
        peer.sendall(actuator_map(command.position, command.stiffness))
    peer.close()
    robot.interrupt()
    expected = in_process()
    assert expected > 0.3
    assert robot.result["distance"] == pytest.approx(expected, rel=0.05)


@pytest.mark.realtime
def test_an_answer_seven_milliseconds_after_its_packet_is_in_time(served: Any) -> None:
    """Of a robot whose drives delay requests by a cycle or more, as a real one's do. Before frames left on
    their boundary nearly all such answers were a cycle late; a tenth leaves room for the machine's stalls."""
    robot, peer = served()
    answer = actuator_map(POSTURES["StandInit"], (1.0,) * 25)
    quiet_process(ROBOT_PRIORITY)
    for number in range(START + PACKETS):
        assert len(peer.recv(SENSOR_BYTES, socket.MSG_WAITALL)) == SENSOR_BYTES
        time.sleep(0.007 if number >= START else 0.0)
        peer.sendall(answer)
    leave_real_time()
    peer.close()
    robot.interrupt()
    assert robot.result["cycles_missed"] <= 0.1 * PACKETS
