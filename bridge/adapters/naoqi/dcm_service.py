"""The service `DCM`: timed commands of actuators."""

from __future__ import annotations

from typing import Any

from bridge.adapters.naoqi.joints import Joints
from bridge.adapters.naoqi.methods import Method, of_kind
from bridge.body.joints import INDEX_WITH_MIRROR
from bridge.dcm import Dcm
from bridge.dcm.requests import alias_request, set_alias_request, set_request
from bridge.errors import NaoqiRefused


def dcm_methods(joints: Joints) -> dict[str, Method]:
    """Methods of `DCM`."""
    dcm = joints.dcm

    def set_alias(*arguments: Any) -> None:
        command = arguments[0] if len(arguments) == 1 else list(arguments)
        dcm.set_alias(set_alias_request(_list("setAlias", command)))
        joints.guarded.difference_update(moved_joints(dcm, command))

    def create_alias(command: Any) -> list[str | list[str]]:
        return dcm.create_alias(alias_request(_list("createAlias", command)))

    def put(command: Any) -> None:
        dcm.set(set_request(_list("set", command)))
        joints.guarded.difference_update(moved_joints(dcm, command))

    def get_time(offset: Any) -> int:
        if isinstance(offset, bool) or not isinstance(offset, int):
            raise NaoqiRefused(
                f"DCM.getTime: {offset!r:.40} was given; an offset in ms, an integer, is expected."
            )
        return dcm.clock.shown(offset)

    return of_kind("joints", {"set": put, "setAlias": set_alias}) | of_kind(
        "read", {"createAlias": create_alias, "getTime": get_time, "getPrefix": dcm.prefixes}
    )


def moved_joints(dcm: Dcm, command: Any) -> list[str]:
    """Joints whose actuators `set` or `setAlias` writes to.

    Args:
        dcm: that knows the aliases.
        command: its first argument: the name of an actuator or an alias, or a list that begins with it.
    """
    name = command[0] if isinstance(command, list) and command else command
    written = dcm.names_of(name) if isinstance(name, str) else ()
    parts = (actuator.split("/")[0] for actuator in written)
    return [part for part in parts if part in INDEX_WITH_MIRROR]


def _list(method: str, command: Any) -> list[Any]:
    if not isinstance(command, list):
        raise NaoqiRefused(f"DCM.{method}: {command!r:.40} was given; a list is expected.")
    return command
