"""The walking cycle of Huang et al. (2001): heel and toe, with a planned hip motion."""

from __future__ import annotations

from walker.gaits.gait import GaitKind
from walker.gaits.huang.gait import HuangGait
from walker.gaits.huang.parameters import HuangParameters

KIND = GaitKind(HuangParameters, HuangGait)

__all__ = ["KIND", "HuangGait", "HuangParameters"]
