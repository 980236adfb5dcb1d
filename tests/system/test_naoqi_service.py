"""`nao-hil serve naoqi` in its own process, with programs that know only qi; and what it does without them."""

from __future__ import annotations

import json
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.loops import TIMEOUT
from tests.ports import free_endpoint, free_port
from tests.system.naoqi_robot import ObedientRobot, obedient_robot, serve, wait_for

pytest.importorskip("qi")

HERE = Path(__file__).parent


class Served:
    """A robot without physics, and the process that serves it."""

    def __init__(self, robot: ObedientRobot, process: subprocess.Popen[bytes], url: str, log: Path) -> None:
        self.robot, self.process, self.url, self.log = robot, process, url, log

    def client(self) -> subprocess.Popen[str]:
        return subprocess.Popen(
            [sys.executable, str(HERE / "naoqi_client.py"), self.url],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def result(self, client: subprocess.Popen[str]) -> dict[str, Any]:
        out, said = client.communicate(timeout=TIMEOUT)
        assert client.returncode == 0, said
        result: dict[str, Any] = json.loads(out.splitlines()[-1])
        return result


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    endpoint, url = free_endpoint(), f"tcp://127.0.0.1:{free_port()}"
    log = tmp_path_factory.mktemp("served") / "log"
    with obedient_robot("nao-v5", endpoint) as robot:
        process = serve(url, endpoint, log)
        try:
            wait_for("is served at", log)
            yield Served(robot, process, url, log)
        finally:
            process.kill()
            process.wait()


def test_the_requests_of_the_social_interaction_cloud_are_served(served: Served) -> None:
    client = served.client()
    assert client.stdout is not None
    assert any(line == "subscribed\n" for line in client.stdout)  # qi itself writes there, too
    served.robot.touch = (1.0, *[0.0] * 13)
    result = served.result(client)
    served.robot.touch = (0.0,) * 14
    assert result["type"] == "Nao"
    assert result["stiffness"] == pytest.approx([0.6] * 6, abs=1e-3)
    assert result["angles"][0] == pytest.approx(1.21, abs=0.01)
    assert result["smart"] is True
    assert result["velocity"] == [0.0, 0.0, 0.0]
    assert result["posture"] is True
    assert "this gait walks straight only" in result["sideways"]
    assert result["life"] == "disabled"
    assert result["intensity"] == pytest.approx(0.5, abs=0.01)
    assert result["touched"] == [[["ChestBoard/Button", True]]]
    assert result["rested"] == ["Crouch", False]
    assert result["woke"] == ["StandInit", True]


def test_a_port_in_use_is_told_in_a_sentence_before_qi_can_abort(served: Served, tmp_path: Path) -> None:
    process = serve(served.url, "tcp/127.0.0.1:9", tmp_path / "log")
    assert process.wait(TIMEOUT) == 3
    said = (tmp_path / "log").read_text()
    assert f"error: Cannot listen on {served.url}: address already in use; " in said


def test_a_termination_ends_it_in_good_order(served: Served) -> None:
    """The last one here: the lease is given back and nothing listens any more."""
    served.process.send_signal(signal.SIGTERM)
    assert served.process.wait(TIMEOUT) == 0
    host, port = served.url.removeprefix("tcp://").split(":")
    with socket.socket() as probe:
        assert probe.connect_ex((host, int(port))) != 0
    assert "Traceback" not in served.log.read_text()
