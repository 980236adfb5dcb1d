"""No image has everything, the walker's has no physics: the command line must load without extras."""

from __future__ import annotations

import subprocess
import sys

import pytest

WITHOUT = """
import sys

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] == sys.argv[1]:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Absent())
from nao_hil.cli.main import run
sys.exit(run(["--version"]))
"""
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
    "viser",
)


@pytest.mark.parametrize("extra", EXTRAS)
def test_the_command_line_loads_without(extra: str) -> None:
    done = subprocess.run([sys.executable, "-c", WITHOUT, extra], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("nao-hil ")
