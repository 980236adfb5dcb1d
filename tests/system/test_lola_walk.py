"""A program that knows LoLA alone and walks at once after standing, its arms limp: as fast as in process."""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest

from bridge.adapters.lola.codec import SENSORS, Map, MapStream
from bridge.adapters.lola.packets import actuator_map, sensor_frame
from bridge.body import load_body
from bridge.body.joints import JOINTS
from bridge.messages import ActuatorFrame, SensorFrame
from nao_hil.runs.build import build_robot, controller_maker
from nao_hil.runs.config import RunConfig, run_config
from tests.loops import TIMEOUT, until

LIMP = tuple(0.0 if name[1:].startswith(("Shoulder", "Elbow", "Wrist", "Hand")) else 1.0 for name in JOINTS)
CYCLES = 600
STANDING = 40
"""Cycles in which the robot stands as it is before it walks."""


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


def test_a_walk_with_limp_arms_is_as_fast_through_lola_as_in_process(
    start: Callable[..., Any], endpoint: str, tmp_path: Path
) -> None:
    path = str(tmp_path / "robocup")
    emulate = ["emulate", "--engine", "mujoco", "--robot", "nao-v6", "--wear", "ideal", "--mode", "lockstep"]
    where = ["--listen", endpoint, "--out", str(tmp_path / "run")]
    robot = start(*emulate, "--seed", "3", *where, "--json")
    start("serve", "lola", "--socket", path, "--connect", endpoint)
    until(lambda: Path(path).exists(), "the socket")
    program, stream = Program(), MapStream(SENSORS)
    with contextlib.closing(socket.socket(socket.AF_UNIX)) as peer:
        peer.settimeout(TIMEOUT)
        peer.connect(path)
        for seq in range(CYCLES):
            command = program.answer(sensor_frame(packet(peer, stream), seq=seq))
            peer.sendall(actuator_map(command.position, command.stiffness))
    robot.interrupt()
    expected = in_process()
    assert expected > 0.3
    assert robot.result["distance"] == pytest.approx(expected, rel=0.05)
