"""The server's lease: what another controller's does to it."""

from __future__ import annotations

from typing import Any

import pytest

from bridge.adapters.naoqi.server import NaoqiServer
from bridge.errors import LeaseRefused
from bridge.messages import Notice
from tests.ports import free_port


class Link:
    """A link whose robot withdrew the lease, and gave it to somebody else until `free`."""

    free = False

    def notices(self) -> list[Notice]:
        return [Notice(seq=1, level="warning", code="no-lease", text="Nobody holds the robot.")]

    def acquire(self) -> None:
        if not self.free:
            raise LeaseRefused("The robot is held by controller `other`.")


def test_a_lost_lease_refuses_the_calls_and_ends_no_server() -> None:
    link: Any = Link()
    nothing: Any = None
    server = NaoqiServer(
        link, f"tcp://127.0.0.1:{free_port()}", "omni", nothing, nothing, nothing, (), lambda: False, None
    )
    server._commanding = True
    server._read_notices()
    with pytest.raises(LeaseRefused, match="held by controller `other`"):
        server._require_lease()
    link.free = True
    server._require_lease()
    assert server._commanding
