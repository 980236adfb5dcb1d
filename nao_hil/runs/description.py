"""The URDF of a robot, and the scene that recordings show in Foxglove."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from bridge.body import Body
from bridge.recording.foxglove import RobotScene


def describe(body: Body) -> str:
    """The robot as URDF; friction is that of nominal drives."""
    # Imported late: the shapes of the links take time.
    from emulator.export.urdf import to_urdf
    from emulator.wear import load_wear

    return to_urdf(body, load_wear("nominal", body), f"{body.name}, by nao-hil")


def robot_scene(body: Body) -> Callable[[], RobotScene]:
    """Makes the scene of each file of a recording."""
    return partial(RobotScene, body, describe(body))
