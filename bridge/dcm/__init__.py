"""The DCM: NAOqi's timed commands, aliases and interpolation, without physics; and its messages (`wire`).

On either side: an emulated robot has one in its cycle, and a served robot that has none gets one in front.
"""

from bridge.dcm.unit import Dcm, Targets

__all__ = ["Dcm", "Targets"]
