"""Runs by the clock that show what short ones do not: the rough test, the demo, a walk of twenty seconds."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from nao_hil.runs.demo import PARTS
from tests.chaos.__main__ import rough

pytestmark = pytest.mark.realtime


def test_a_rough_time_breaks_no_promise() -> None:
    """Of `tests/chaos`, from one seed."""
    report = rough(45.0, 1, "mujoco")
    assert not report.violations
    assert sum(report.events.values()) > 2 and report.recordings >= 2


def test_the_demo_shows_all_its_parts_and_the_robot_stands_at_its_end(
    start: Callable[..., Any], endpoint: str, tmp_path: Path
) -> None:
    """As `make demo` runs it but for the page."""
    command = start("demo", "--no-view", "--listen", endpoint, "--out", str(tmp_path / "run"), "--json")
    assert command.wait() == 0, command.stderr
    said = " ".join(command.stderr.split())
    at = [said.index(part.text) for part in PARTS]
    assert at == sorted(at)
    assert command.result["distance"] > 1.5
    assert command.result["heading_change"] > 3.0
    assert command.result["displacement"][2] > 3.0
