"""The dynamically stable gait of the thesis (3.3.2)."""

from walker.planning.dynamic.gait import DynamicGait
from walker.planning.dynamic.step import DynamicParameters
from walker.planning.gait import GaitKind

KIND = GaitKind(DynamicParameters, DynamicGait, max_delay=0.025)
