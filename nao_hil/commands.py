"""Actuator frames from what a person has at hand: arrays, sequences, or one number for all joints."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeAlias

from bridge.body.joints import N_JOINTS
from bridge.errors import ConfigurationError
from bridge.messages import ActuatorFrame
from bridge.messages.codec import require_finite

JointValues: TypeAlias = "float | Iterable[float]"
"""25 numbers in the order of `nao_hil.JOINTS` (sequence or array), or one number for all joints."""


def actuator_frame(reply_to: int, position: JointValues, stiffness: JointValues) -> ActuatorFrame:
    """The frame that answers a sensor frame.

    Args:
        reply_to: `seq` of the sensor frame.
        position: Joint angles, rad (hands: 0 closed .. 1 open).
        stiffness: 0..1; negative: the motor is off.

    Raises:
        ConfigurationError: not 25 numbers.
        FrameError: a number that is not finite.
    """
    frame = ActuatorFrame(
        reply_to=reply_to,
        position=_by_joint("position", position),
        stiffness=_by_joint("stiffness", stiffness),
    )
    require_finite("position", frame.position)
    require_finite("stiffness", frame.stiffness)
    return frame


def _by_joint(name: str, values: JointValues) -> tuple[float, ...]:
    try:
        numbers = tuple(map(float, values)) if isinstance(values, Iterable) else (float(values),) * N_JOINTS
    except (TypeError, ValueError):
        raise ConfigurationError(f"{name} is not made of numbers; give {N_JOINTS}, or one for all.") from None
    if len(numbers) != N_JOINTS:
        raise ConfigurationError(
            f"{name} has {len(numbers)} values; give {N_JOINTS} in the order of nao_hil.JOINTS, or one for all."
        )
    return numbers
