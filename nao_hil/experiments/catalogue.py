"""The experiments by name. Each is a declaration in a module, which is imported when it is run."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any, Final, NamedTuple

if TYPE_CHECKING:  # the list alone needs no physics
    from nao_hil.experiments.experiment import Experiment

ALL: Final = "all"
"""In place of a name: those of the thesis, in one report."""


class Entry(NamedTuple):
    """One experiment."""

    declaration: str
    """A name in a module of `nao_hil.experiments`, after a dot; or the full name of both."""
    question: str
    """For people."""
    seeds: int
    """Default."""
    thesis: bool = False
    """Part of `all`."""
    any_gait: bool = False
    """Takes `--gait`."""
    gaits: bool = False
    """Takes several, separated by commas."""

    def load(self) -> Experiment[Any]:
        """The declaration."""
        module, _, name = self.declaration.rpartition(".")
        path = module if "." in module else f"nao_hil.experiments.{module}"
        experiment: Experiment[Any] = getattr(importlib.import_module(path), name)
        return experiment


EXPERIMENTS: Final[dict[str, Entry]] = {
    "static-walk": Entry(
        "planned_walks.STATIC_WALK", "the static gait, planned and walked (figure 3.4)", 3, True
    ),
    "obstacle": Entry(
        "obstacle.OBSTACLE",
        "R1: a board of 1 cm under the swing foot, leg admittance (4.1, 4.2, 4.8)",
        20,
        True,
    ),
    "torso-drift": Entry(
        "torso_control.TORSO_DRIFT", "R2: the static gait, torso control on and off (4.9)", 20, True
    ),
    "torso-step": Entry(
        "torso_step.TORSO_STEP", "R3: the torso's answer to steps of the ankle (4.10)", 5, True
    ),
    "torso-design": Entry("torso_design.TORSO_DESIGN", "R4: three torso controllers (4.11 to 4.15)", 1, True),
    "dynamic-walk": Entry(
        "planned_walks.DYNAMIC_WALK", "the dynamic gait, planned and walked (3.6, 3.7)", 3, True
    ),
    "dynamic-torso": Entry(
        "torso_control.DYNAMIC_TORSO", "R5: the dynamic gait, torso control on and off, 60 s (4.16)", 20, True
    ),
    "slope": Entry("slope.SLOPE", "R6: the steepest slope in four directions", 20, True, True),
    "spring": Entry("spring.SPRING", "the spring of the leg admittance and its pole (4.7)", 20, True),
    "ablation": Entry("mechanisms.ABLATION", "each mechanism alone, and each taken out, on R1, R2 and R5", 20),
    "huang-margin": Entry("huang_margin.HUANG_MARGIN", "Huang's hip motion, searched against badly chosen", 20),
    "get-up": Entry("get_up.GET_UP", "dropped limp, any side first: does the robot get up", 100),
    "sit": Entry("sit.SIT", "sits down by order and stands up again", 100),
    "velocity": Entry("velocity.VELOCITY", "commanded and measured velocity, odometry", 20, any_gait=True),
    "push-map": Entry(
        "push_map.PUSH_MAP", "push at which half fall, by direction and phase", 10, any_gait=True
    ),
    "terrain": Entry(
        "terrain.TERRAIN", "unknown grounds, a load and wear, gait against gait", 20, any_gait=True
    ),
    "feedback": Entry("mechanisms.FEEDBACK", "each feedback of a gait switched off in turn", 50, any_gait=True),
    "falls": Entry(
        "falls.FALLS", "pushed in a walk: falls foreseen, how hard, got up again", 20, any_gait=True
    ),
    "policies": Entry(
        "policies.POLICIES", "gaits and learned policies on the same courses", 20, any_gait=True, gaits=True
    ),
    "real-robots": Entry("real_robots.REAL_ROBOTS", "every figure of real robots, and of the emulated one", 5),
    "tracking": Entry("real_robots.TRACKING", "tracking errors of the legs in a walk", 5),
    "knee-hold": Entry("real_robots.KNEE_HOLD", "error of a knee that holds its leg out", 5),
    "imu-noise": Entry("real_robots.IMU_NOISE", "noise of inertial unit and encoders at rest", 5),
    "force-cells": Entry("real_robots.FORCE_CELLS", "noise and sum of the force cells", 5),
    "currents": Entry("real_robots.CURRENTS", "motor currents of a standing V3", 5),
    "engines": Entry("engines.ENGINES_COMPARED", "walks, drives, get-up and the thesis on both engines", 20),
}
"""In the order of the thesis."""
