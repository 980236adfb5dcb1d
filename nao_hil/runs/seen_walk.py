"""A walk as the ground truth shows it, for controllers that say nothing of theirs."""

from __future__ import annotations

from typing import Final, Literal

from bridge.messages import TruthFrame

LOADED: Final = 5.0
"""N on a foot that stands."""
SWINGING: Final = 1.0
"""N up to which a foot is in the air."""
SWING_TIME: Final = 0.05
"""s that a foot must be in the air for a step: shorter ones are a sole that rocks."""
PAUSE: Final = 1.0
"""s without a foot in the air after which a walk is over."""

Event = Literal["", "lifted", "step", "over"]


class SeenWalk:
    """Counts steps: a foot leaves the ground while the other one stands, and comes back."""

    def __init__(self) -> None:
        self._lifted: dict[str, float] = {}
        self._last: float | None = None
        """Time of the last step of the present walk, or of its first lift; s."""

    def update(self, truth: TruthFrame) -> Event:
        """One cycle.

        Returns:
            `lifted`: a walk began; `step`: a foot came down; `over`: the walk ended with the last step.
        """
        if truth.fell:
            self._lifted.clear()
            return self._end()
        for foot, other in (("left", "right"), ("right", "left")):
            here, there = getattr(truth, foot).force[2], getattr(truth, other).force[2]
            if here < SWINGING and there > LOADED:
                self._lifted.setdefault(foot, truth.time)
                if self._last is None and truth.time - self._lifted[foot] >= SWING_TIME:
                    self._last = truth.time
                    return "lifted"
            elif here > LOADED and truth.time - self._lifted.pop(foot, truth.time) >= SWING_TIME:
                self._last = truth.time
                return "step"
            elif there < SWINGING:
                self._lifted.pop(foot, None)  # the robot was lifted off the ground
        if self._last is not None and not self._lifted and truth.time - self._last > PAUSE:
            return self._end()
        return ""

    def _end(self) -> Event:
        began, self._last = self._last, None
        return "" if began is None else "over"
