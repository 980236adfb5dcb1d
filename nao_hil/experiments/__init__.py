"""Experiments: properties and abilities of the robot, measured on the emulated one."""
