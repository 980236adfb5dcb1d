"""The statically stable gait of the thesis (3.3.1)."""

from __future__ import annotations

from walker.gaits.gait import GaitKind
from walker.gaits.thesis.static.gait import StaticGait, StaticParameters

KIND = GaitKind(StaticParameters, StaticGait, max_delay=0.025)
