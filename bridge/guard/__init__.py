"""The guard between the controller and the motors, on the robot's side, emulated or real."""

from bridge.guard.config import GuardSettings
from bridge.guard.guard import Guard
from bridge.messages.guard import ArmRequest, GuardStatus, Reason, State, StopRequest

__all__ = ["ArmRequest", "Guard", "GuardSettings", "GuardStatus", "Reason", "State", "StopRequest"]
