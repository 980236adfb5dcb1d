"""The world around the robot: floor, terrain, boxes, pushes, and what happens in it when."""

from emulator.world.parameters import WorldParameters
from emulator.world.world import World

__all__ = ["World", "WorldParameters"]
