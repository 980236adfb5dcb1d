"""No image has everything, the walker's has no physics: the command line must load without extras."""

from __future__ import annotations

import subprocess
import sys

from tests.loops import TIMEOUT

EXTRAS = (
    "pybullet",
    "mujoco",
    "numba",
    "control",
    "matplotlib",
    "psutil",
    "jinja2",
    "cryptography",
    "qi",
    "optuna",
    "websockets",
)
WITHOUT = f"""
import sys

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {EXTRAS}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Absent())
from nao_hil.cli.main import run
sys.exit(run(["--help"]))
"""


def test_the_command_line_loads_without_extras() -> None:
    """All commands: the help loads their modules."""
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT], capture_output=True, text=True, timeout=TIMEOUT, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "run-naoqi" in done.stdout
