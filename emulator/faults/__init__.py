"""Faults of the way between controller and robot, of sensors and of joints."""

from emulator.faults.faults import Faults

__all__ = ["Faults"]
