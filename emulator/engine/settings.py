"""Settings of every engine, in a module without Numba: `nao-hil up` checks a run without that half second."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from bridge.body import Body
from bridge.errors import ConfigurationError


@dataclass(frozen=True)
class PhysicsSettings:
    """Settings of every engine."""

    step: float = 0.001
    """Time of one physics and servo step, s (assumed)."""
    gravity: float = 9.81
    """Gravitational acceleration, m/s^2."""

    def steps(self, body: Body) -> int:
        """Number of steps in a cycle of a body.

        Raises:
            ConfigurationError: they do not fill the cycle.
        """
        steps = round(body.cycle / self.step)
        if steps < 1 or abs(steps * self.step - body.cycle) > 1e-9:
            raise ConfigurationError(
                f"A physics step of {self.step:g} s does not divide the {body.cycle:g} s cycle of {body.name}."
            )
        return steps


SETTINGS: Final = PhysicsSettings()
