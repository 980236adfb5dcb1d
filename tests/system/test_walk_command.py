"""Walk commands over Zenoh to `nao-hil walk --serve`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from bridge.errors import LinkError, WalkRefused
from bridge.link.walk_client import WalkClient


@pytest.fixture
def client(start: Callable[..., Any], endpoint: str, until: Callable[..., Any]) -> Iterator[WalkClient]:
    robot = start("emulate", "--mode", "lockstep", "--name", "served", "--listen", endpoint)
    walker = start("walk", "--serve", "--name", "served", "--connect", endpoint, "--json")

    def answers(client: WalkClient) -> bool:
        try:
            client.status()
        except (LinkError, WalkRefused):
            assert robot.process.poll() is None, robot.said
            assert walker.process.poll() is None, walker.said
            return False
        return True

    with WalkClient("served", endpoint, patience=60.0) as client:
        until(lambda: answers(client), "a walker that serves")
        client.walker = walker  # type: ignore[attr-defined]
        yield client


def test_a_walker_that_serves_walks_on_command(client: WalkClient, until: Callable[..., Any]) -> None:
    assert client.walk((0.015, 0.0, 0.0), distance=0.05).gait == "static"

    def stands_beyond(x: float) -> bool:
        status = client.status()
        return status.state == "stand" and status.position[0] > x

    until(lambda: stands_beyond(0.0), "the stand after the walk")
    assert client.status().position == pytest.approx((0.05, 0.0, 0.0), abs=1e-9)
    with pytest.raises(WalkRefused, match="would do"):
        client.walk((0.1, 0.0, 0.0))
    client.walk(gait="dynamic", hold=2.0)
    until(lambda: stands_beyond(0.051), "the end of a walk that nobody holds")
    walker = client.walker  # type: ignore[attr-defined]
    walker.interrupt()
    assert walker.process.returncode == 0
    assert walker.result["fell"] is False
    with pytest.raises(LinkError, match="--serve"):
        client.status()
