"""Arguments of NAOqi's methods, checked: numbers, lists, and lists of lists; one sentence for each error."""

from __future__ import annotations

import math
import os
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from bridge.errors import NaoqiRefused

MAX_DURATION: Final = 3600.0
"""s that one interpolation may take."""
MIN_SPEED_FRACTION: Final = 1e-4
"""Fraction of the maximum speed at which a joint's whole range takes about an hour."""
ROBOT_HOME: Final = Path("/home/nao")
HOME: Final = Path(tempfile.gettempdir()) / "nao-hil-home"
"""The robot's home on a machine without one of that name."""


def number(value: Any, what: str, lower: float = -math.inf, upper: float = math.inf) -> float:
    """A finite number within a range.

    Raises:
        NaoqiRefused: anything else.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise NaoqiRefused(f"{what} is {value!r:.60}; a finite number is expected.")
    if not lower <= value <= upper:
        raise NaoqiRefused(f"{what} is {value:g}; a number from {lower:g} to {upper:g} is expected.")
    return float(value)


def fraction(value: Any, what: str) -> float:
    """A fraction of the maximum speed, above 0 and up to 1.

    Raises:
        NaoqiRefused: anything else, or less than `MIN_SPEED_FRACTION`.
    """
    speed = number(value, what, 0.0, 1.0)
    if speed < MIN_SPEED_FRACTION:
        raise NaoqiRefused(
            f"{what} is {speed:g}; a fraction above 0 ({MIN_SPEED_FRACTION:g} at least) "
            "and up to 1 is expected."
        )
    return speed


def flag(value: Any, what: str) -> bool:
    """True or False, also as 1 or 0.

    Raises:
        NaoqiRefused: anything else.
    """
    if value not in (True, False):
        raise NaoqiRefused(f"{what} is {value!r:.60}; True or False is expected.")
    return bool(value)


def text(value: Any, what: str) -> str:
    """A name.

    Raises:
        NaoqiRefused: anything else.
    """
    if not isinstance(value, str):
        raise NaoqiRefused(f"{what} is {value!r:.60}; a name is expected.")
    return value


def robot_file(value: Any, what: str) -> Path:
    """A path of the robot's: what is below its home is below `HOME` where this machine has no such folder."""
    file = Path(text(value, what))
    inside = file.is_relative_to(ROBOT_HOME) and ".." not in file.parts and "\0" not in str(file)
    return HOME / file.relative_to(ROBOT_HOME) if inside and not ROBOT_HOME.is_dir() else file


def new_file(value: Any, what: str) -> Path:
    """The absolute path of a file that may be written: its folder is there.

    Raises:
        NaoqiRefused: anything else.
    """
    file = robot_file(value, what)
    if file.is_relative_to(HOME):
        file.parent.mkdir(parents=True, exist_ok=True)
    if "\0" in str(file) or not file.is_absolute() or not os.path.isdir(file.parent):
        raise NaoqiRefused(f"{what} is {value!r:.80}; an absolute path in a folder that is there is expected.")
    return file


def pairs(value: Any, what: str) -> list[list[Any]]:
    """A list of names, each with its value.

    Raises:
        NaoqiRefused: anything else.
    """
    if not isinstance(value, list) or not all(isinstance(row, list) and len(row) == 2 for row in value):
        raise NaoqiRefused(f"{what}: {value!r:.60} was given; [[name, value], ...] is expected.")
    return value


def one_each(value: Any, count: int, what: str) -> list[float]:
    """A number for each joint: one for all, or a list of as many.

    Raises:
        NaoqiRefused: anything else.
    """
    if not isinstance(value, list):
        return [number(value, what)] * count
    if len(value) != count:
        raise NaoqiRefused(f"{what} has {len(value)} entries for {count} joints; one for each is expected.")
    return [number(entry, f"{what}[{i}]") for i, entry in enumerate(value)]


def lists_each(value: Any, count: int, what: str) -> list[list[float]]:
    """A list of numbers for each joint, out of one number, one list, or a list of numbers or lists.

    Raises:
        NaoqiRefused: anything else.
    """
    if not isinstance(value, list):
        return [[number(value, what)] for _ in range(count)]
    if count == 1 and not any(isinstance(entry, list) for entry in value):
        return [[number(entry, f"{what}[{i}]") for i, entry in enumerate(value)]]
    if len(value) != count:
        raise NaoqiRefused(f"{what} has {len(value)} entries for {count} joints; one for each is expected.")
    return [
        [number(item, f"{what}[{i}][{j}]") for j, item in enumerate(entry)]
        if isinstance(entry, list)
        else [number(entry, f"{what}[{i}]")]
        for i, entry in enumerate(value)
    ]


def require_times(times: Sequence[Sequence[float]], values: Sequence[Sequence[float]], method: str) -> None:
    """Times of each joint as many as its values, above 0 and increasing.

    Raises:
        NaoqiRefused: names the joint's place in the list.
    """
    for i, (moments, targets) in enumerate(zip(times, values, strict=True)):
        if len(moments) != len(targets) or not moments:
            raise NaoqiRefused(
                f"{method}: entry {i} has {len(targets)} values and {len(moments)} times; one time for each "
                "value is expected."
            )
        if any(a >= b for a, b in zip([0.0, *moments], moments, strict=False)) or moments[-1] > MAX_DURATION:
            raise NaoqiRefused(
                f"{method}: times of entry {i} are {moments!r:.60}; increasing ones above 0 and up to "
                f"{MAX_DURATION:g} s are expected."
            )
