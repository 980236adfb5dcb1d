"""The Zenoh link: robot side and controller side of the contract."""

from bridge.link.controller_side import ControllerLink
from bridge.link.keys import DEFAULT_ENDPOINT, DEFAULT_ROBOT
from bridge.link.robot_side import RobotLink

__all__ = ["DEFAULT_ENDPOINT", "DEFAULT_ROBOT", "ControllerLink", "RobotLink"]
