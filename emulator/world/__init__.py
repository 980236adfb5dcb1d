"""The world around the robot: floor, terrain, boxes, pushes, and the events that change them."""

from emulator.world.world import World

__all__ = ["World"]
