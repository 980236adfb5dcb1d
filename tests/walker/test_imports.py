"""The walker's process loads no library that only designs need."""

from __future__ import annotations

import subprocess
import sys

from tests.loops import TIMEOUT

CONTROLLERS = """
import sys

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
print([name for name in ("control", "optuna", "scipy.optimize", "matplotlib") if name in sys.modules])
"""


def test_controllers_of_all_gaits_and_methods_need_no_design_library() -> None:
    done = subprocess.run(
        [sys.executable, "-c", CONTROLLERS], capture_output=True, text=True, timeout=TIMEOUT, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "[]"
