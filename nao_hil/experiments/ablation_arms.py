"""Arms of the ablation: each mechanism alone, and each taken out of what a gait ships."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import msgspec

from nao_hil.experiments.context import Plates
from nao_hil.experiments.plates import drawn_plate
from walker.switches import NAMED, Switches

SHIPPED: Final = "as shipped"
THESIS: Final = "the thesis' alone"
NONE: Final = "none"


DEPENDENT: Final = (
    *("common_ankle_tilt", "attitude_correction", "gyroscope_lean"),
    *("foothold_feedback", "foot_placement", "capture_step", "heading_hold", "velocity_hold", "lean_feedback"),
    *("step_hold", "counterweight", "arm_counterweight"),
)
"""Switches that alone do nothing here: they act on another mechanism's offsets or input, or on `Plan.pendulum`,
which neither gait gives, or have no gains in these gaits."""


@dataclass(frozen=True)
class AblationTask:
    """What every arm is put to."""

    name: str
    gait: str
    switch: str
    """That the thesis' claim credits."""
    suspects: tuple[str, ...]
    """Switches that are taken out first, beside it."""
    duration: float
    """s"""
    plate_time: float | None = None
    """s of the walk at which a plate comes under the right foot; None: no plate."""
    plate_height: float = 0.01
    """m"""

    def plates(self, seed: int) -> Plates:
        """Of a seed."""
        if self.plate_time is None:
            return ()
        return ((self.plate_time, drawn_plate(seed, self.plate_height)),)


TASKS: Final = (
    AblationTask("R5: dynamic gait", "dynamic", "torso", ("gyroscope_damping",), duration=15.0),
    AblationTask(
        "R2: static gait", "static", "torso", ("swing_foot_orientation", "ground_tilt"), duration=30.0
    ),
    AblationTask(
        "R1: static gait, plate",
        "static",
        "leg_admittance",
        ("swing_foot_orientation", "ground_tilt"),
        duration=18.0,
        plate_time=3.0,
    ),
)
"""Shorter than R1, R2 and R5: a plate in the first single support and two strides after it, and flat ground for
the time in which the arms without control fall."""


class AblationArm(NamedTuple):
    """One choice of switches."""

    name: str
    switches: Switches
    stage: int
    """The lower, the sooner it is walked: a stop leaves the arms that decide most."""
    compared: str = ""
    """Arm that differs in one switch, to be read against; empty: none."""


def arms(task: AblationTask, shipped: Switches) -> list[AblationArm]:
    """All arms of a task.

    Args:
        task: Whose claim decides what is walked first.
        shipped: Switches of its gait.
    """
    thesis, none = NAMED["thesis"], NAMED["none"]
    found = [
        AblationArm(SHIPPED, shipped, 0),
        AblationArm(THESIS, thesis, 0),
        AblationArm(
            f"the thesis' without {task.switch}", _with(thesis, task.switch, _off(task.switch)), 1, THESIS
        ),
        AblationArm(NONE, none, 0),
        AblationArm("torso by the thesis' design", _with(shipped, "torso", "thesis"), 1, SHIPPED),
    ]
    for name in Switches.__struct_fields__:
        if getattr(shipped, name) != _off(name):
            out = _with(shipped, name, _off(name))
            stage = 0 if name == task.switch else 1 if name in task.suspects else 2
            found.append(AblationArm(f"without {name}", out, stage, SHIPPED))
    for name in (name for name in Switches.__struct_fields__ if name not in DEPENDENT):
        for value in ("thesis", "robust") if name == "torso" else (True,):
            title = f"torso = {value} alone" if name == "torso" else f"{name} alone"
            found.append(AblationArm(title, _with(none, name, value), 3, NONE))
    return found


def _off(name: str) -> Any:
    return getattr(NAMED["none"], name)


def _with(switches: Switches, name: str, value: Any) -> Switches:
    return msgspec.structs.replace(switches, **{name: value})
