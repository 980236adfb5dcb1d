"""The experiments by name. Each is a module with `experiment(context) -> Outcome`, imported when it is run."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Final, NamedTuple

from nao_hil.analysis.report.render import Outcome

if TYPE_CHECKING:  # the list alone needs no physics
    from nao_hil.experiments.context import Context

ALL: Final = "all"
"""In place of a name: those of the thesis, in one report."""


class Entry(NamedTuple):
    """One experiment."""

    module: str
    """Of `nao_hil.experiments`, or a full name; after a colon the function and its further arguments."""
    what: str
    """Measured quantity, for people."""
    seeds: int
    """Default."""
    thesis: bool = True
    """Part of `all`."""
    any_gait: bool = False
    """Takes `--gait`."""

    def load(self) -> Callable[[Context], Outcome]:
        """The function that does it."""
        module, _, call = self.module.partition(":")
        name, *arguments = (call or "experiment").split()
        path = module if "." in module else f"nao_hil.experiments.{module}"
        function: Callable[..., Outcome] = getattr(importlib.import_module(path), name)
        return lambda context: function(context, *arguments)


EXPERIMENTS: Final[dict[str, Entry]] = {
    "static-walk": Entry(
        "planned_walks:static_walk", "the statically stable gait, planned and walked (figure 3.4)", 3
    ),
    "obstacle": Entry(
        "obstacle", "R1: a board of 1 cm under the swing foot, leg admittance (4.1, 4.2, 4.8)", 20
    ),
    "torso-drift": Entry(
        "torso_control:torso_drift",
        "R2: the static gait with admittance, without and with torso control (4.9)",
        20,
    ),
    "torso-step": Entry(
        "torso_step", "R3: the torso's answer to steps of the stance ankle, and its plant (4.10)", 5
    ),
    "torso-design": Entry(
        "torso_design", "R4: the thesis' torso controllers and a robust one (4.11 to 4.15)", 1
    ),
    "dynamic-walk": Entry(
        "planned_walks:dynamic_walk", "the dynamically stable gait, planned and walked (3.6, 3.7)", 3
    ),
    "dynamic-torso": Entry(
        "torso_control:dynamic_torso", "R5: the dynamic gait without and with torso control, 60 s (4.16)", 20
    ),
    "slope": Entry("slope", "R6: the steepest slope in four directions", 20, any_gait=True),
    "spring": Entry("spring", "the spring of the leg admittance and its pole (4.7)", 20),
    "ablation": Entry(
        "ablation", "each mechanism of the stabiliser alone, and each taken out, on R1, R2 and R5", 20, False
    ),
    "huang-margin": Entry(
        "huang_margin", "Huang's gait: searched against badly chosen hip motion, a known step", 20, False
    ),
    "get-up": Entry("get_up", "dropped limp, any side first: does the robot get up", 100, False),
    "sit": Entry("sit", "sits down by order and stands up again", 100, False),
    "velocity": Entry(
        "velocity", "commanded and measured velocity, odometry, random commands", 20, False, True
    ),
    "push-map": Entry(
        "push_map", "impulse at which half fall, by direction and phase of the stride", 10, False, True
    ),
    "terrain": Entry(
        "terrain", "slopes, tiles, plates, low friction, a load and wear, gait against gait", 20, False, True
    ),
    "feedback": Entry(
        "feedback", "each feedback of a gait switched off in turn: pushes, grounds, wear", 50, False, True
    ),
    "falls": Entry(
        "falls", "pushed in a walk: falls foreseen, how hard, got up and walked on", 20, False, True
    ),
    "real-robots": Entry("real_robots", "every figure of real robots, and of the emulated one", 5, False),
    "tracking": Entry("real_robots:experiment tracking", "tracking errors of the legs in a walk", 5, False),
    "knee-hold": Entry("real_robots:experiment knee_hold", "error of a knee that holds its leg out", 5, False),
    "imu-noise": Entry(
        "real_robots:experiment imu_noise", "noise of inertial unit and encoders at rest", 5, False
    ),
    "force-cells": Entry("real_robots:experiment force_cells", "noise and sum of the force cells", 5, False),
    "currents": Entry("real_robots:experiment currents", "motor currents of a standing V3", 5, False),
    "servo-table": Entry("servo_table", "speed, delay, backlash, torque and heat of every leg drive", 1, False),
    "engines": Entry(
        "engines", "torso step, drives, walks, R1, R2, R5, get-up: PyBullet and MuJoCo", 20, False
    ),
}
"""In the order of the thesis."""
