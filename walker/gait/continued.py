"""One walk after another in one walk frame."""

from __future__ import annotations

from dataclasses import replace

from walker.gait.reference import Foot, Gait, Reference


class ContinuedGait:
    """A gait that begins where the last walk ended.

    Args:
        gait: in its initial stand.
        x: where the feet stand, m.
        step: number of steps that were completed before.
    """

    def __init__(self, gait: Gait, x: float, step: int = 0) -> None:
        self._gait, self._x, self._step = gait, x, step
        self.name = gait.name
        self.quasi_static = gait.quasi_static

    def stand(self) -> Reference:
        """As of the gait."""
        return self._moved(self._gait.stand())

    def advance(self, dt: float, *, go_on: bool) -> Reference:
        """As of the gait."""
        return self._moved(self._gait.advance(dt, go_on=go_on))

    def _moved(self, plan: Reference) -> Reference:
        x = self._x
        return replace(
            plan,
            step=plan.step + self._step,
            left=_moved(plan.left, x),
            right=_moved(plan.right, x),
            com=(plan.com[0] + x, plan.com[1]),
            zmp=(plan.zmp[0] + x, plan.zmp[1]),
        )


def _moved(foot: Foot, x: float) -> Foot:
    return replace(foot, x=foot.x + x)
