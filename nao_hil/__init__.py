"""nao-hil: an emulated NAO robot, a walking controller for it, and the link between them.

`Robot` is the emulated robot in this process, `Batch` many of them, `World` several in one world, `walk` a
whole walk. `connect` controls any robot on the link, emulated or real. `WalkClient` commands a walker,
`WorldClient` the world of an emulated robot. `load` gives a run as arrays. `JOINTS` names the 25 joints
in the order of all frames; the base of all errors, each with one sentence, is `NaoHilError`.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from bridge.body.joints import JOINTS
    from bridge.errors import NaoHilError
    from bridge.link.client import WalkClient, WorldClient
    from nao_hil.batch import Batch
    from nao_hil.connection import connect
    from nao_hil.robot import Robot, walk
    from nao_hil.runs.run import load
    from nao_hil.world import World

    __version__: str

__all__ = [
    "JOINTS",
    "Batch",
    "NaoHilError",
    "Robot",
    "WalkClient",
    "World",
    "WorldClient",
    "connect",
    "load",
    "walk",
]

_HOME: Final = {
    "JOINTS": "bridge.body.joints",
    "Batch": "nao_hil.batch",
    "NaoHilError": "bridge.errors",
    "Robot": "nao_hil.robot",
    "WalkClient": "bridge.link.client",
    "World": "nao_hil.world",
    "WorldClient": "bridge.link.client",
    "connect": "nao_hil.connection",
    "load": "nao_hil.runs.run",
    "walk": "nao_hil.robot",
}
"""Public name to the module that defines it; imported at the first use, so that `import nao_hil` is quick."""


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return _version()
    if name not in _HOME:
        raise AttributeError(f"module 'nao_hil' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("nao-hil")
    except PackageNotFoundError:  # run from a source tree that is not installed
        return "0+source"


def __dir__() -> list[str]:
    return sorted({*globals(), *_HOME})
