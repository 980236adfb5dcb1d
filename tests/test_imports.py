"""What is loaded where: no machine needs a library for what it does not do, and no command waits for one."""

from __future__ import annotations

import pytest

from tests.processes import python

CONTROLLERS = """
import walker.process
from bridge.body import load_body
from walker.controller import Controller
from walker.parameters import controller_parameters
from walker.gaits import GAITS, gait_parameters, make_gait

for name in ("nao-v3", "nao-v6"):  # cycles of 10 and 12 ms
    body = load_body(name)
    for gait in GAITS:
        phases = make_gait(gait, gait_parameters(gait), body)
        for torso in ("none", "thesis", "robust"):
            parameters = controller_parameters(gait, {"switches": {"torso": torso}})
            Controller(body, phases, None, body.cycle, parameters)
"""
HELP = "from nao_hil.cli.main import run; run(['--help'])"
OF_ONE_COMMAND = "mujoco numba matplotlib websockets qi optuna control cryptography walker.gaits"
EXTRAS = ["pybullet", "mujoco", "numba", "control", "matplotlib", "psutil", "jinja2"]
EXTRAS += ["qi", "optuna", "websockets"]
WITHOUT = f"""
import sys

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {EXTRAS}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

sys.meta_path.insert(0, Absent())
{HELP}
"""


@pytest.mark.parametrize(
    ("code", "heavy"),
    [
        ("import nao_hil", "numpy scipy pybullet zenoh msgspec bridge"),
        ("import nao_hil.view.follow", "numba pybullet mujoco matplotlib"),
        (HELP, f"{OF_ONE_COMMAND} pybullet"),  # which the walker's machine does not have
        (CONTROLLERS, "control optuna scipy.optimize matplotlib"),
    ],
    ids=["package", "page", "help", "controllers of all gaits and methods"],
)
def test_no_library_is_loaded_that_is_not_needed(code: str, heavy: str) -> None:
    done = python("-c", f"{code}\nimport sys\nprint([name for name in {heavy.split()} if name in sys.modules])")
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "[]"


def test_the_command_line_loads_without_extras() -> None:
    """No image has everything, the walker's has no physics. The help loads the modules of all commands."""
    done = python("-c", WITHOUT)
    assert done.returncode == 0, done.stderr
    assert "run-naoqi" in done.stdout
