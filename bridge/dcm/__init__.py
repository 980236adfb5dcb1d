"""The DCM (Device Communication Manager): NAOqi's timed commands, aliases and interpolation, without physics.

An emulated robot has one in its cycle. The NAOqi adapter puts one before a robot that has none.
"""

from bridge.dcm.unit import Dcm, Targets

__all__ = ["Dcm", "Targets"]
