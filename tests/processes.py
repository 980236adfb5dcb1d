"""Programs that tests run and load."""

from __future__ import annotations

import importlib.util
import os
import subprocess
import sys
from pathlib import Path
from typing import Any, Final

from tests.loops import TIMEOUT

REPOSITORY: Final = Path(__file__).parents[1]


def python(*arguments: str | Path, **more: Any) -> subprocess.CompletedProcess[str]:
    """Run Python in the repository to its end, with what it says as text; `more` goes to `subprocess.run`."""
    command = [sys.executable, *map(str, arguments)]
    given = {"cwd": REPOSITORY, "capture_output": True, "text": True, "timeout": TIMEOUT} | more
    return subprocess.run(command, check=False, **given)


def module_of(file: Path) -> Any:
    """A program as a module, without being installed as one."""
    spec = importlib.util.spec_from_file_location(file.stem, file)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def memory(pid: int) -> int:
    """Resident memory of a process, bytes (Linux)."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")
