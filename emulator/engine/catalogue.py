"""The engines by name."""

from __future__ import annotations

from typing import Final

from bridge.errors import ConfigurationError
from bridge.validation import unknown_name
from emulator.engine.base import Engine
from emulator.engine.values import PhysicsSettings

ENGINES: Final = ("pybullet",)
"""The first is the default."""


def open_engine(name: str, settings: PhysicsSettings) -> Engine:
    """An engine with an empty world.

    Args:
        name: One of `ENGINES`.
        settings: Of the physics.

    Raises:
        ConfigurationError: no such engine, or it is not installed.
    """
    if name not in ENGINES:
        raise ConfigurationError(unknown_name("engine", name, ENGINES))
    from emulator.engine.pybullet.engine import BulletEngine

    return BulletEngine(settings)
