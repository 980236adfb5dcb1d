"""hiroz, an independent implementation of rmw_zenoh's format, reads and drives a robot; see docs/testing.md."""

from __future__ import annotations

import json
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bridge.link import keys
from bridge.link.client import WalkClient
from bridge.link.session import open_client, subscribe
from bridge.messages import SensorFrame, decode
from tests.loops import until
from tests.system.conftest import Command

PROBE = Path(__file__).with_name("ros_probe") / "target" / "release" / "ros-probe"
pytestmark = [
    pytest.mark.realtime,
    pytest.mark.skipif(not PROBE.exists(), reason="the probe is not built, see docs/testing.md"),
]


def probe(endpoint: str, *words: str) -> dict[str, Any]:
    done = subprocess.run([PROBE, endpoint, *words], capture_output=True, text=True, timeout=60.0, check=True)
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1]) if done.stdout else {}
    return found


def test_hiroz_reads_the_robot_and_its_lost_connection_stops_the_walk(endpoint: str, tmp_path: Path) -> None:
    folders = [tmp_path / name for name in ("up", "ros")]
    for folder in folders:
        folder.mkdir()
    options = ["--serve", "--robot", "nao-v6", "--engine", "mujoco", "--listen", endpoint, "--out"]
    up = Command(["up", *options, str(tmp_path / "run")], folders[0], None)
    ros = Command(["ros", "--connect", endpoint], folders[1], None)
    try:
        until(lambda: "is on ROS 2" in " ".join(ros.stderr.split()), "the robot on ROS 2")
        with WalkClient("nao", endpoint) as walker:
            until(lambda: _state(walker) == "stand", "a stand")
            with plain_zenoh(endpoint) as late:
                states = probe(endpoint, "read", "10")
            print(states, "plain Zenoh p99", np.percentile(late, 99), "ms")
            assert states["p99_ms"] < np.percentile(late, 99) + 2.0
            assert states["rate"] == pytest.approx(1.0 / 0.012, rel=0.02)
            assert (states["joints"], states["first"]) == (26, "HeadYaw")
            assert states["gravity"] == pytest.approx(9.81, abs=0.5)
            assert probe(endpoint, "describe")["characters"] > 10_000
            probe(endpoint, "drive", "0.1", "10")
            assert walker.status().distance > 0.5
            ended = time.monotonic()
            until(lambda: _state(walker) == "stand", "a stand")
            assert time.monotonic() - ended < 3.0
    finally:
        ros.interrupt()
        up.interrupt()


@contextmanager
def plain_zenoh(endpoint: str) -> Iterator[list[float]]:
    """Ages of the robot's frames at a subscriber of Zenoh, ms."""
    late: list[float] = []
    with open_client(endpoint) as session:
        subscriber = subscribe(
            session,
            keys.topic_key("nao", SensorFrame),
            lambda data: late.append(1e-6 * (time.time_ns() - decode(data, SensorFrame).wall)),
        )
        yield late
        subscriber.undeclare()


def _state(walker: WalkClient) -> str:
    try:
        return walker.status().state
    except Exception:
        return ""
