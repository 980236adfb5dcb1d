"""The command side of the DCM: timed commands, aliases, interpolation; no physics in here."""

from emulator.dcm.queries import DcmQueries
from emulator.dcm.unit import Dcm, Targets

__all__ = ["Dcm", "DcmQueries", "Targets"]
