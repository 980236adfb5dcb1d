"""Walk commands over Zenoh to `nao-hil walk --serve`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from bridge.config import from_dict
from bridge.errors import FrameError, LinkError, WalkRefused
from bridge.link.client import WalkClient, WorldClient
from bridge.messages.world import Push, StandUp
from nao_hil.runs.config import RunConfig
from nao_hil.runs.monitor import Monitor
from tests.loops import TIMEOUT, until


@pytest.fixture
def client(start: Callable[..., Any], endpoint: str) -> Iterator[WalkClient]:
    emulate = ["emulate", "--engine", "mujoco", "--mode", "lockstep"]
    robot = start(*emulate, "--name", "served", "--listen", endpoint)
    walker = start("walk", "--serve", "--gait", "static", "--name", "served", "--connect", endpoint, "--json")

    def answers(client: WalkClient) -> bool:
        try:
            client.status()
        except (LinkError, WalkRefused):
            assert robot.process.poll() is None, robot.stderr
            assert walker.process.poll() is None, walker.stderr
            return False
        return True

    with WalkClient("served", endpoint, connect_timeout=TIMEOUT) as client:
        until(lambda: answers(client), "a walker that serves")
        client.walker = walker  # type: ignore[attr-defined]
        yield client


def test_a_walker_that_serves_walks_on_command(
    client: WalkClient, start: Callable[..., Any], endpoint: str
) -> None:
    assert client.walk((0.015, 0.0, 0.0), distance=0.05).gait == "static"

    def has_walked() -> bool:
        status = client.status()
        return status.state == "stand" and status.position[0] > 0.02

    until(has_walked, "the stand after the walk")
    x, y, yaw = client.status().position
    assert (x, y) == pytest.approx((0.05, 0.0), abs=0.02)
    assert abs(yaw) < 0.05  # a V3 knows its heading by its hips alone, which have 0.021 rad of backlash each
    with pytest.raises(WalkRefused, match="would do"):
        client.walk((0.1, 0.0, 0.0))
    crouch = start("motion", "crouch", "--name", "served", "--connect", endpoint, "--json")
    assert crouch.wait() == 0
    assert crouch.result == {"motion": "crouch", "state": "rest", "stands": False}
    walker = client.walker  # type: ignore[attr-defined]
    walker.interrupt()
    assert walker.process.returncode == 0
    assert walker.result["fell"] is False
    with pytest.raises(LinkError, match="--serve"):
        client.status()


def test_a_robot_that_fell_under_the_walker_is_put_up_stands_and_walks_again(
    client: WalkClient, endpoint: str
) -> None:
    until(lambda: client.status().state == "stand", "the stand")
    client.walk(gait="dynamic")
    until(lambda: client.status().steps > 2, "the walk")
    with WorldClient("served", endpoint) as world:
        with pytest.raises(FrameError, match="on its feet"):
            world.send(StandUp())
        world.send(Push(impulse=(0.0, 4.0, 0.0)))
        until(lambda: client.status().state == "fallen", "the fall")
        fell = client.status().seq
        until(lambda: client.status().seq > fell + 300, "the robot that lies")
        with pytest.raises(WalkRefused, match="stand-up"):
            client.walk()
        up = world.send(StandUp())
        until(lambda: client.status().seq > up.seq + 250, "two seconds on its feet")
        assert client.status().state == "stand"
        begun = client.walk(steps=6)

        def walked_on() -> bool:
            """Asked by the place: the steps of before the fall still count until the walk begins."""
            status = client.status()
            return status.state == "stand" and math.dist(status.position[:2], begun.position[:2]) > 0.1

        until(walked_on, "the end of the walk after the fall")


def test_ctrl_c_in_a_walk_closes_the_feet(start: Callable[..., Any], endpoint: str) -> None:
    robot = start("emulate", "--engine", "mujoco", "--mode", "lockstep", "--listen", endpoint)
    walker = start("walk", "--velocity", "0.2", "0", "0.3", "--steps", "0", "--connect", endpoint, "--json")
    with Monitor("nao", endpoint) as monitor:
        until(lambda: monitor.connect(), "the robot")
        until(lambda: monitor.telemetry is not None and monitor.telemetry.step > 6, "the walk")
        walker.interrupt()
    assert robot.process.poll() is None
    assert walker.process.returncode == 130
    assert (walker.result["state"], walker.result["fell"]) == ("stand", False)
    config = from_dict(walker.result["config"], "config", RunConfig)
    assert (config.robot, config.gait, config.velocity, config.steps) == ("nao-v3", "omni", (0.2, 0.0, 0.3), 0)
    assert "closing the feet" in walker.stderr
