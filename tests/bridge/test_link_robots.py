"""The robots of a link, as the page and the cameras draw them."""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest

from bridge.link import ControllerLink, RobotLink, session
from bridge.link.robots import LinkRobots
from bridge.link.session import Search
from nao_hil.runs.capture import Capture
from tests.frames import info_of_robot, truth_frame
from tests.loops import TIMEOUT, until
from tests.ports import free_endpoint


def test_the_robots_of_a_link_come_and_go_with_their_newest_truth() -> None:
    endpoint = free_endpoint()
    robots = LinkRobots(endpoint)
    assert robots.update() == {}
    with RobotLink(info_of_robot(robot="nao10"), endpoint) as first:
        until(robots.update, "the first robot")
        with RobotLink(info_of_robot(robot="nao2", body="nao-v4"), endpoint, beside=first) as second:
            until(lambda: list(robots.update()) == ["nao2", "nao10"], "the second robot")
            assert robots.found["nao2"].body.name == "nao-v4" and robots.found["nao2"].truth is None

            def shows(seq: int) -> bool:
                """Whether a truth that is published arrives, also where the first one is too early for it."""
                second.publish(truth_frame(seq))
                truth = robots.found["nao2"].truth
                return truth is not None and truth.seq == seq

            for seq in (1, 2):
                until(lambda seq=seq: shows(seq), "its newest truth")  # type: ignore[misc]
            assert robots.found["nao10"].truth is None
        until(lambda: list(robots.update()) == ["nao10"], "the end of the second one")
    robots.close()


def test_who_waits_for_a_robot_that_is_not_there_is_told_once_who_is(caplog: pytest.LogCaptureFixture) -> None:
    """Of the controllers, a recorder and ROS: each keeps waiting."""
    endpoint = free_endpoint()

    def ends(reports: int) -> Callable[[], bool]:
        """Stops some looks after this many reports."""
        looks, end = 0, time.monotonic() + TIMEOUT

        def stop() -> bool:
            nonlocal looks
            looks += len(caplog.records) >= reports
            return looks > 20 or time.monotonic() > end

        return stop

    with RobotLink(info_of_robot(robot="blue"), endpoint), ControllerLink("red", endpoint) as link:
        assert link.wait_robot(ends(1)) is None
        with Capture("green", endpoint) as capture:
            assert capture.wait_robot(ends(2)) is None
    texts = [record.getMessage() for record in caplog.records]
    assert len(texts) == 2 and all("`blue`" in text for text in texts)
    assert "`red`" in texts[0] and "`green`" in texts[1]


def test_who_waits_without_any_robot_is_told_how_to_start_one(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    clock = iter((0.0, 3.0, 6.0, 9.0))
    monkeypatch.setattr(session.time, "monotonic", lambda: next(clock))
    search = Search("red", "tcp/127.0.0.1:1")
    for _ in range(3):
        search.failed(None)
    (text,) = (record.getMessage() for record in caplog.records)
    assert "`red`" in text and "nao-hil emulate" in text
