"""`nao-hil run-naoqi` starts what does not run yet, and only that."""

from __future__ import annotations

import socket
from pathlib import Path

import pytest

from nao_hil.cli.run_naoqi import _missing


@pytest.mark.parametrize("endpoint", ["tcp/127.0.0.1:{}", "tls/127.0.0.1:{}#keys=keys/controller"])
def test_a_robot_that_runs_is_not_started_again(tmp_path: Path, endpoint: str) -> None:
    with socket.create_server(("127.0.0.1", 0)) as robot:
        place = endpoint.format(robot.getsockname()[1])
        assert [name for name, _ in _missing(None, "tcp://127.0.0.1:9559", place, tmp_path)] == ["server"]
    missing = _missing(None, "tcp://127.0.0.1:9559", place, tmp_path)
    assert [name for name, _ in missing] == ["robot", "server"]
    assert all(place in command for _, command in missing)
