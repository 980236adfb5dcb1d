"""The dynamically stable gait of the thesis (3.3.2)."""

from __future__ import annotations

from walker.gaits.gait import GaitKind
from walker.gaits.thesis.dynamic.gait import DynamicGait
from walker.gaits.thesis.dynamic.step import DynamicParameters

KIND = GaitKind(DynamicParameters, DynamicGait, max_delay=0.025)
