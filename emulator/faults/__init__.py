"""Faults: what goes wrong between controller and robot, in its sensors and in its joints."""

from emulator.faults.faults import Faults

__all__ = ["Faults"]
