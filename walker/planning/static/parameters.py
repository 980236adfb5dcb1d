"""Parameters of the statically stable gait."""

from __future__ import annotations

from typing import ClassVar, Literal

from bridge.types import Positive
from walker.planning.parameters import GaitParameters, PeriodicStep


class StaticParameters(GaitParameters, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Symbols of the thesis, SI units."""

    LENGTH: ClassVar = "l_SW"

    T_DSP: Positive
    """Double support phase, s."""
    T_SSP: Positive
    """Single support phase, s."""
    l_SW: Positive
    """Step length: distance of the feet along x in double support, m."""
    l_FA: Positive
    """Step width: distance of the ankles along y, m."""
    l_lift: Positive
    """Lift of the swing foot at the middle of the single support, m."""
    l_GH: Positive
    """Gait height: ankle to hip joint along z, m."""
    first_swing: Literal["L", "R"] = "R"
    """The foot that makes the first step."""

    @property
    def periodic_step(self) -> PeriodicStep:
        """One double and one single support."""
        return PeriodicStep(self.l_SW, self.T_DSP + self.T_SSP)
