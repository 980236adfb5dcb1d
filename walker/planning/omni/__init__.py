"""The omnidirectional gait: steps of a quarter of a second whose places follow from the capture point."""

from walker.planning.gait import GaitKind
from walker.planning.omni.gait import OmniGait
from walker.planning.omni.parameters import OmniParameters

KIND = GaitKind(OmniParameters, OmniGait, max_delay=0.025)
