"""Power of the drives: limits for a cycle and consumption in it, joint by joint as machine code."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bridge.types import Vec3
from emulator.compiled import compiled
from emulator.drives import put_in_force
from emulator.servo.heat import stiffness_factor

Vector = NDArray[np.float64]


@compiled
def set_power(drives: NDArray[Any], temperature: Vector, levels: Vec3) -> None:
    """Put the stiffness asked for, heat protection, `strength` and `backlash` in force.

    Args:
        drives: Of `DRIVE`, (n,); changed.
        temperature: Of the motors, (n,), degrees Celsius.
        levels: For `emulator.servo.heat.stiffness_factor`.
    """
    for i in range(len(drives)):
        drives[i].derating = stiffness_factor(temperature[i], levels)
        put_in_force(drives[i])


@compiled
def end_cycle(drives: NDArray[Any], steps: int) -> None:
    """Take stock of a cycle and begin the next.

    Args:
        drives: Of `DRIVE`, (n,); changed.
        steps: Of the cycle.
    """
    for i in range(len(drives)):
        drive = drives[i]
        drive.mean_square = drive.squares / steps
        # A motor on the fraction u of the full voltage draws u times its current: the heat in the armature's
        # resistance, and the work. Power that a driven motor returns is lost in its board (assumed).
        heat = drive.mean_square / (drive.stall_torque / drive.no_load_speed)
        drive.power = max(heat + drive.work / steps, 0.0)
        drive.squares = drive.work = 0.0
