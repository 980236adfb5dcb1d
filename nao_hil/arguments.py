"""Arguments of the public functions: names, seeds, files and joint values, each checked with one sentence."""

from __future__ import annotations

import logging
import operator
import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import SupportsIndex, TypeAlias

import numpy as np

from bridge.body.joints import JOINTS, N_JOINTS, degrees_warning
from bridge.errors import ConfigurationError
from bridge.guard.output import require_numbers
from bridge.messages import ActuatorFrame


def whole_seed(seed: SupportsIndex) -> int:
    """A seed as a number of Python's own.

    Raises:
        ConfigurationError: no whole number from 0 on.
    """
    try:
        number = -1 if isinstance(seed, bool) else operator.index(seed)
    except TypeError:
        number = -1
    if number < 0:
        raise ConfigurationError(f"A seed is {seed!r}; a whole number from 0 on is expected.")
    return number


def require_names(**names: object) -> None:
    """See that arguments are names, whose default None would silently take.

    Raises:
        ConfigurationError: one is no text.
    """
    for argument, name in names.items():
        if not isinstance(name, str):
            raise ConfigurationError(f"{argument} is {name!r}; a name is expected, as text.")


def file_path(argument: str, path: str | Path) -> Path:
    """An argument as a path.

    Raises:
        ConfigurationError: it is none.
    """
    if not isinstance(path, str | os.PathLike):
        raise ConfigurationError(f"{argument} is {path!r}; the path of a file is expected.")
    return Path(path)


logger = logging.getLogger(__name__)

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
        FrameError: a number that is not finite, or a stiffness outside -1..1.
    """
    frame = ActuatorFrame(
        reply_to=reply_to,
        position=_by_joint("position", position),
        stiffness=_by_joint("stiffness", stiffness),
    )
    require_numbers(frame)
    return frame


def _by_joint(name: str, values: JointValues) -> tuple[float, ...]:
    try:
        if values is None:  # NumPy's nan
            raise TypeError
        plain = list(values) if isinstance(values, Iterable) and not hasattr(values, "__array__") else values
        array = np.asarray(plain, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        raise ConfigurationError(f"{name} is not made of numbers; give {N_JOINTS}, or one for all.") from None
    if array.shape not in ((), (N_JOINTS,)):
        given = f"{array.size} values" if array.ndim == 1 else f"the shape {array.shape}"
        raise ConfigurationError(
            f"{name} has {given}; give {N_JOINTS} in the order of nao_hil.JOINTS, or one for all."
        )
    return tuple(np.broadcast_to(array, N_JOINTS).tolist())


class UnreachableAngles:
    """Warns once of angles that no joint reaches: they are clipped, and may be meant in degrees."""

    def __init__(self) -> None:
        self._warned = False

    def warn(self, position: Sequence[float]) -> None:
        """Log the first one of all.

        Args:
            position: Joint angles, rad, 25 in the order of `nao_hil.JOINTS`.
        """
        if self._warned:
            return
        why = next(filter(None, map(degrees_warning, JOINTS, position)), "")
        if why:
            self._warned = True
            logger.warning("position of %s", why)
