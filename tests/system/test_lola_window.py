"""The time that a client of a served LoLA has for its answer, in real time."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bridge.adapters.lola.codec import SENSOR_BYTES
from bridge.adapters.lola.packets import actuator_map
from bridge.body.postures import POSTURES
from bridge.realtime import ROBOT_PRIORITY, quiet_process
from tests.loops import TIMEOUT, until

START = 100
"""Packets in which the server finds the phase of the frames."""
PACKETS = 500


@pytest.mark.realtime
def test_an_answer_seven_milliseconds_after_its_packet_is_in_time(
    start: Callable[..., Any], endpoint: str, tmp_path: Path
) -> None:
    """Of a robot whose drives delay requests by a cycle or more, as a real one's do. Before frames left on
    their boundary nearly all such answers were a cycle late; a tenth leaves room for the machine's stalls."""
    path = str(tmp_path / "robocup")
    robot = start(
        *("emulate", "--robot", "nao-v6", "--listen", endpoint, "--json", "--out", str(tmp_path / "run"))
    )
    start("serve", "lola", "--socket", path, "--connect", endpoint)
    until(lambda: Path(path).exists(), "the socket")
    answer = actuator_map(POSTURES["StandInit"], (1.0,) * 25)
    with socket.socket(socket.AF_UNIX) as peer:
        peer.settimeout(TIMEOUT)
        peer.connect(path)
        quiet_process(ROBOT_PRIORITY)
        for number in range(START + PACKETS):
            assert len(peer.recv(SENSOR_BYTES, socket.MSG_WAITALL)) == SENSOR_BYTES
            time.sleep(0.007 if number >= START else 0.0)
            peer.sendall(answer)
    robot.interrupt()
    assert robot.result["cycles_missed"] <= 0.1 * PACKETS
