"""Twenty seconds of walking by the clock: what a short walk does not show."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.realtime
def test_walking_needs_no_more_memory_than_its_first_seconds(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "nao_hil.cli", "experiment", "soak", "--duration", "20"]
    soak = subprocess.run([*command, "--out", str(tmp_path / "soak")], capture_output=True, text=True)
    logs = "\n".join(log.read_text() for log in (tmp_path / "soak").glob("*/*.log"))
    assert soak.returncode == 0, f"{soak.stdout}{soak.stderr}{logs}"
