"""The omnidirectional gait: steps of a quarter of a second whose places follow from the capture point."""

from __future__ import annotations

from walker.gaits.gait import GaitKind
from walker.gaits.omni.gait import OmniGait
from walker.gaits.omni.parameters import OmniParameters

KIND = GaitKind(OmniParameters, OmniGait, max_delay=0.025)
