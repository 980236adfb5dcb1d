"""The server's lease: what another controller's does to it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import msgspec
import pytest

from bridge.adapters.naoqi.declared import VENDOR_METHODS
from bridge.adapters.naoqi.server import NaoqiServer
from bridge.errors import LeaseRefused, NaoqiRefused
from bridge.messages import Notice
from tests.bridge.adapters.naoqi.served import Robot
from tests.docs import naoqi_methods
from tests.frames import standing_frame
from tests.ports import free_port


class Link:
    """A link whose robot withdrew the lease, and gave it to somebody else until `free`."""

    free = False

    def notices(self) -> list[Notice]:
        return [Notice(seq=1, level="warning", code="no-lease", text="No controller holds the robot.")]

    def held(self) -> tuple[float, ...]:
        return HELD

    def acquire(self) -> None:
        if not self.free:
            raise LeaseRefused("The robot is held by controller `other`.")


HELD = (0.02,) * 25


def test_stiff_joints_hold_their_targets_and_limp_ones_their_angles() -> None:
    """Measured angles sag: a program that holds them at each start would lower the robot."""
    stiffness = (1.0,) * 24 + (0.0,)
    robot = Robot(msgspec.structs.replace(standing_frame(), stiffness=stiffness, position=(0.01,) * 25))
    robot.services.hold(HELD)
    held = [robot.services.joints.commanded(joint) for joint in ("LKneePitch", "RHand")]
    assert held == pytest.approx([0.02, 0.01], abs=0.002)


def test_a_lost_lease_refuses_the_calls_and_ends_no_server() -> None:
    link: Any = Link()
    nothing: Any = None
    server = NaoqiServer(
        link, f"tcp://127.0.0.1:{free_port()}", "omni", nothing, nothing, lambda: False, Path("/nonexistent")
    )
    server._commanding = True
    server._read_notices()
    with pytest.raises(LeaseRefused, match="other"):
        server._require_lease()
    link.free = True
    server._require_lease()
    assert server._commanding


def test_a_call_that_comes_after_the_robot_went_away_fails_at_once() -> None:
    """It would wait for cycles that never come."""
    robot = Robot()
    robot.services.abandon()
    for service, method, arguments in (
        ("ALTextToSpeech", "say", ["hello"]),
        ("ALMotion", "angleInterpolation", ["HeadYaw", 0.1, 1.0, True]),
    ):
        with pytest.raises(NaoqiRefused, match="The robot went away"):
            robot.call(service, method, *arguments)


ANEW = "write it anew: python -m tests.docs.naoqi_methods"


def test_the_page_has_the_table_of_the_code() -> None:
    assert naoqi_methods.PAGE.read_text() == naoqi_methods.page(), ANEW


def test_a_reason_belongs_to_a_method_that_is_refused() -> None:
    for service, refused in VENDOR_METHODS.items():
        assert refused.no.keys() - {"*"} <= set(refused.refused), service
