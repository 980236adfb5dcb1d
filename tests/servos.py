"""Drives on their own, joint by joint led by a test."""

from __future__ import annotations

import numpy as np

from bridge.types import Array
from emulator.drives import run_drives, take_over
from emulator.servo.servo import Servo


def torques(servo: Servo, position: Array, velocity: Array) -> Array:
    """Torques (n,), N m, of one step for joint angles (n,), rad, and velocities (n,), rad/s."""
    servo.advance(1)
    if servo.drives.change == 0:
        take_over(servo.drives.records)
    found = np.zeros(len(position))
    run_drives(servo.drives.records, position, velocity, found)
    return found
