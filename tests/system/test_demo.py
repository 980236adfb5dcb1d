"""The demo, as `make demo` runs it but for the page."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from nao_hil.runs.demo import PARTS

pytestmark = pytest.mark.realtime


def test_the_demo_shows_all_its_parts_and_the_robot_stands_at_its_end(
    start: Callable[..., Any], endpoint: str, tmp_path: Path
) -> None:
    command = start("demo", "--no-view", "--listen", endpoint, "--out", str(tmp_path / "run"), "--json")
    assert command.wait() == 0, command.stderr
    said = " ".join(command.stderr.split())
    at = [said.index(part.text) for part in PARTS]
    assert at == sorted(at)
    assert command.result["distance"] > 1.5
    assert command.result["heading_change"] > 3.0
    assert command.result["displacement"][2] > 3.0
