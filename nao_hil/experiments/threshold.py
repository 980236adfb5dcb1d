"""The strength of a stimulus at which half of the trials fail, by few trials, each where the last ones point.

Bayesian adaptive estimation on a grid (Watson and Pelli, QUEST, Perception & Psychophysics 33, 1983), with the
slope as a second unknown. The chance of a failure at the strength s is Phi(ln(s / m) / w), mixed with a chance
for trials that fail or stand whatever happens.
"""

from __future__ import annotations

from typing import Final

import msgspec
import numpy as np
from scipy.stats import norm

from bridge.types import Vec2

LAPSE: Final = 0.02
"""Chance that the strength does not matter in a trial."""
_SPREADS: Final = np.array([0.05, 0.1, 0.2, 0.4])
"""w, each as likely as the others before the trials."""


class Threshold(msgspec.Struct, frozen=True, kw_only=True):
    """The strength at which half fail."""

    value: float
    """Median of what is known of it."""
    interval: Vec2
    """95 %, credible."""


class ThresholdSearch:
    """What is known of a threshold; all within the range are as likely as each other, by their logarithm.

    Args:
        low: Smallest strength.
        high: Largest one.
    """

    def __init__(self, low: float, high: float) -> None:
        self._strengths = np.geomspace(low, high, 121)
        self._weights = np.ones((len(self._strengths), len(_SPREADS)))
        self.trials: list[tuple[float, bool]] = []
        """Strength, and whether it failed."""

    def tell(self, strength: float, failed: bool) -> None:
        """One trial."""
        distance = np.log(strength / self._strengths)[:, None] / _SPREADS
        chance = 0.5 * LAPSE + (1.0 - LAPSE) * norm.cdf(distance)
        self._weights = self._weights * (chance if failed else 1.0 - chance)
        self._weights /= self._weights.sum()
        self.trials.append((strength, failed))

    @property
    def threshold(self) -> Threshold:
        """As far as it is known."""
        total = np.cumsum(self._weights.sum(axis=1))
        low, middle, high = np.interp((0.025, 0.5, 0.975), total / total[-1], self._strengths).tolist()
        return Threshold(value=middle, interval=(low, high))
