"""The engines by name."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Final, NamedTuple

from bridge.errors import ConfigurationError
from bridge.validation import unknown_name

if TYPE_CHECKING:  # a name is chosen without Numba, which takes a second
    from emulator.engine.base import Engine
    from emulator.engine.settings import PhysicsSettings


class Listed(NamedTuple):
    """An engine of the catalogue; its name is that of its library."""

    module: str
    kind: str
    """Class in the module, which takes `PhysicsSettings`."""
    missing: str
    """Error where the library is not installed."""
    parallel: bool = False
    """Several of them run in threads at the same time."""


ENGINES: Final = {
    "pybullet": Listed(
        "emulator.engine.pybullet.engine",
        "BulletEngine",
        "PyBullet is not installed: pip install 'nao-hil[emulator]' brings it where it has a wheel "
        "(Python up to 3.11 on x86-64 Linux); --engine mujoco does without.",
    ),
    "mujoco": Listed(
        "emulator.engine.mujoco.engine",
        "MujocoEngine",
        "MuJoCo is not installed: pip install 'nao-hil[emulator]' brings the emulated robot.",
        parallel=True,
    ),
}
"""The first one that is installed is the default."""
WITHOUT_PYBULLET: Final = "PyBullet is not installed; the physics is MuJoCo's."
"""Notice where the first is missing; its wheels are for Python up to 3.11 on x86-64 Linux."""
AUTO: Final = "auto"
"""The default engine."""


def choose_engine(name: str = AUTO) -> str:
    """The engine that a name means on this machine.

    Args:
        name: One of `ENGINES`, or `AUTO`.

    Raises:
        ConfigurationError: no such engine.
    """
    if name == AUTO:
        return next(filter(find_spec, ENGINES), next(reversed(ENGINES)))
    if name not in ENGINES:
        raise ConfigurationError(unknown_name("engine", name, ENGINES))
    return name


def require_engine(name: str) -> None:
    """Raises ConfigurationError where an engine (by its own name) is not installed."""
    if find_spec(name) is None:
        raise ConfigurationError(ENGINES[name].missing)


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
    engine: Engine = getattr(import_module(ENGINES[name].module), ENGINES[name].kind)(settings)
    return engine
