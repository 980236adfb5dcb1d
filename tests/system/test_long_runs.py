"""Runs by the clock that show what short ones do not: the rough test, the demo, a walk of twenty seconds."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from nao_hil.runs.demo import PARTS
from tests.chaos.__main__ import rough

pytestmark = pytest.mark.realtime


def test_rough_minutes_break_no_promise() -> None:
    """Of `tests/chaos`, from one seed."""
    report = rough(90.0, 1, "mujoco")
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


def test_walking_needs_no_more_memory_than_its_first_seconds(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "tests.measure", "soak", "--duration", "20"]
    soak = subprocess.run([*command, "--out", str(tmp_path / "soak")], capture_output=True, text=True)
    logs = "\n".join(log.read_text() for log in (tmp_path / "soak").glob("*/*.log"))
    assert soak.returncode == 0, f"{soak.stdout}{soak.stderr}{logs}"
