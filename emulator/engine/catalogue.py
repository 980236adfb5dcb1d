"""The engines by name."""

from __future__ import annotations

from importlib.util import find_spec
from typing import TYPE_CHECKING, Final

from bridge.errors import ConfigurationError
from bridge.validation import unknown_name

if TYPE_CHECKING:  # a name is chosen without Numba, which takes a second
    from emulator.engine.base import Engine
    from emulator.engine.values import PhysicsSettings

ENGINES: Final = ("pybullet", "mujoco")
"""The first is the default, where it is installed."""
WITHOUT_PYBULLET: Final = "PyBullet is not installed; the physics is MuJoCo's."
"""Notice where the default is missing; its wheels are for Python up to 3.11 on x86-64 Linux."""
MISSING: Final = {
    "pybullet": "PyBullet is not installed: pip install 'nao-hil[emulator]' brings it where it has a wheel "
    "(Python up to 3.11 on x86-64 Linux); --engine mujoco does without.",
    "mujoco": "MuJoCo is not installed: pip install 'nao-hil[emulator]' brings the emulated robot.",
}
"""Error of a missing engine."""
AUTO: Final = "auto"
"""PyBullet where it is installed, else MuJoCo."""


def choose_engine(name: str = AUTO) -> str:
    """The engine that a name means on this machine.

    Args:
        name: One of `ENGINES`, or `AUTO`.

    Raises:
        ConfigurationError: no such engine.
    """
    if name == AUTO:
        return ENGINES[0] if find_spec(ENGINES[0]) else ENGINES[1]
    if name not in ENGINES:
        raise ConfigurationError(unknown_name("engine", name, ENGINES))
    return name


def require_engine(name: str) -> None:
    """Raises ConfigurationError where an engine (by its own name) is not installed."""
    if find_spec(name) is None:
        raise ConfigurationError(MISSING[name])


def open_engine(name: str, settings: PhysicsSettings) -> Engine:
    """An engine with an empty world.

    Args:
        name: One of `ENGINES`, or `AUTO`.
        settings: Of the physics.

    Raises:
        ConfigurationError: no such engine, or it is not installed.
    """
    name = choose_engine(name)
    require_engine(name)
    if name == "mujoco":
        from emulator.engine.mujoco.engine import MujocoEngine

        return MujocoEngine(settings)
    from emulator.engine.pybullet.engine import BulletEngine

    return BulletEngine(settings)
