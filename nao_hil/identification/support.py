"""Whether a recorded robot stands on its feet or hangs."""

from __future__ import annotations

from typing import Final

import numpy as np

from bridge.body import Body
from bridge.body.quantities import GRAVITY, total_mass
from nao_hil.identification.signals import Signals

_UNLOADED: Final = 0.3
"""Fraction of the weight below which the feet carry nothing."""
_WATCHED: Final = 1.0
"""Time at the beginning that is looked at, s."""


def hangs(body: Body, signals: Signals) -> bool | None:
    """The feet carry next to nothing at the beginning; None: their forces were not recorded."""
    fsr = signals.fsr[: round(_WATCHED / signals.cycle)]
    if not np.isfinite(fsr).all():
        return None
    return float(fsr.sum(axis=1).mean()) < _UNLOADED * GRAVITY * total_mass(body)
