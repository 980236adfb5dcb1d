"""The statically stable gait of the thesis (3.3.1)."""

from walker.planning.gait import GaitKind
from walker.planning.static.gait import StaticGait
from walker.planning.static.parameters import StaticParameters

KIND = GaitKind(StaticParameters, StaticGait, max_delay=0.025)
