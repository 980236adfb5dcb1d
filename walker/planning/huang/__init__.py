"""The walking cycle of Huang et al. (2001): heel and toe, with a planned hip motion."""

from walker.planning.gait import GaitKind
from walker.planning.huang.gait import HuangGait
from walker.planning.huang.parameters import HuangParameters

KIND = GaitKind(HuangParameters, HuangGait)

__all__ = ["KIND", "HuangGait", "HuangParameters"]
