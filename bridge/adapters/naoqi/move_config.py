"""The vendor's move configuration: limits of the steps, and the velocities that they stand for.

Names, limits and the formula of the velocity: vendor's page on locomotion control; order: printed by robots.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from typing import Any, Final, NamedTuple

from bridge.adapters.naoqi.arguments import number, text
from bridge.errors import NaoqiRefused
from bridge.types import Vec3
from bridge.validation import unknown_name

logger = logging.getLogger(__name__)

_DEFAULT: Final = {
    "MaxStepX": 0.04,
    "MaxStepY": 0.14,
    "MaxStepTheta": 0.349066,
    "MaxStepFrequency": 1.0,
    "StepHeight": 0.02,
    "TorsoWx": 0.0,
    "TorsoWy": 0.0,
}
_LIMITS: Final = {
    "MaxStepX": (0.001, 0.08),
    "MaxStepY": (0.101, 0.16),
    "MaxStepTheta": (0.001, 0.524),
    "MaxStepFrequency": (0.0, 1.0),
    "StepHeight": (0.005, 0.04),
    "TorsoWx": (-math.radians(7.0), math.radians(7.0)),
    "TorsoWy": (-math.radians(7.0), math.radians(7.0)),
}
_FEET: Final = ("Left", "Right")
_KINDS: Final = ("Default", "Min", "Max")
_BACKWARD: Final = 0.04
"""Longest step backwards, m."""
_APART: Final = 0.1
_NEAREST: Final = 0.088
"""Distance of the feet at rest, and the least one, m."""
_SLOWEST: Final = 0.6
QUICKEST: Final = 0.42
"""s of a step."""


def move_config(kind: Any) -> list[list[Any]]:
    """`getMoveConfig`: `[[name, value], ...]` of `Default`, `Min` or `Max`.

    Raises:
        NaoqiRefused: another word.
    """
    if text(kind, "ALMotion.getMoveConfig: config") not in _KINDS:
        raise NaoqiRefused(f"ALMotion.getMoveConfig: {unknown_name('config', kind, _KINDS)}.")
    end = kind == "Max"
    return [[name, _DEFAULT[name] if kind == "Default" else _LIMITS[name][end]] for name in _DEFAULT]


class FullSpeed(NamedTuple):
    """Velocities of the longest steps."""

    ahead: float
    """m/s"""
    back: float
    """m/s"""
    across: float
    """m/s"""
    turn: float
    """rad/s"""

    def of(self, fractions: Vec3) -> Vec3:
        """The velocity of fractions forward, to the left and of the turn: m/s, m/s, rad/s."""
        x, y, turn = fractions
        return x * (self.ahead if x > 0.0 else self.back), y * self.across, turn * self.turn

    def clipped(self, velocity: Vec3) -> Vec3:
        """A velocity, m/s, m/s, rad/s, within these."""
        x, y, turn = velocity
        return (
            max(-self.back, min(self.ahead, x)),
            max(-self.across, min(self.across, y)),
            max(-self.turn, min(self.turn, turn)),
        )

    def towards(self, target: Vec3) -> Vec3:
        """The fastest velocity along the way to a target, m, m, rad, which is not here."""
        x, y, turn = target
        duration = self.duration(target)
        return x / duration, y / duration, turn / duration

    def duration(self, target: Vec3) -> float:
        """S of the way to a target, m, m, rad."""
        x, y, turn = target
        return max(x / self.ahead, -x / self.back, abs(y) / self.across, abs(turn) / self.turn)


def full_speed(method: str, configs: Sequence[Any], frequency: Any = 1.0) -> FullSpeed:
    """The velocities of the longest steps of a configuration.

    Args:
        method: for the errors.
        configs: `[[name, value], ...]` each; a number, the duration of `moveTo`, is passed over, and an unknown
            name is left out with a line in the log. A foot's own value counts for its steps.
        frequency: of the steps, 0 to 1.

    Raises:
        NaoqiRefused: not such a list, or a value beyond its limits.
    """
    given: dict[str, float] = {}
    for config in configs:
        if isinstance(config, list):
            given |= _given(method, config)
    quickness = number(given.pop("Frequency", frequency), f"{method}: Frequency", 0.0, 1.0)
    feet = [_DEFAULT | given | {n: given[foot + n] for n in _DEFAULT if foot + n in given} for foot in _FEET]
    periods = [_SLOWEST + quickness * of["MaxStepFrequency"] * (QUICKEST - _SLOWEST) for of in feet]
    across = [of["MaxStepY"] - max(_NEAREST, 2.0 * _APART - of["MaxStepY"]) for of in feet]
    both = sum(periods)
    return FullSpeed(
        sum(of["MaxStepX"] for of in feet) / both,
        2.0 * _BACKWARD / both,
        0.5 * sum(across) / both,
        sum(of["MaxStepTheta"] for of in feet) / both,
    )


def _given(method: str, config: list[Any]) -> Mapping[str, float]:
    values = {}
    for row in config:
        if not isinstance(row, list) or len(row) != 2:
            raise NaoqiRefused(f"{method}: {config!r:.60} was given; [[name, value], ...] is expected.")
        full_name = text(row[0], f"{method}: name of the configuration")
        name = full_name.removeprefix("Left").removeprefix("Right")
        if name != "Frequency" and name not in _LIMITS:
            logger.warning("%s: %.40s of the configuration is not known and left out", method, row[0])
            continue
        limits = _LIMITS.get(name, (0.0, 1.0))
        values[full_name] = number(_as_number(row[1]), f"{method}: {row[0]}", *limits)
    return values


def _as_number(value: Any) -> Any:
    """A number that is given as text, as the vendor's example of `ALNavigation.moveTo` does."""
    try:
        return float(value) if isinstance(value, str) else value
    except ValueError:
        return value
