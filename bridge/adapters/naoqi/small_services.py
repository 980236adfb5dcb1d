"""Services of a few methods each: the DCM's own, and facts about the robot."""

from __future__ import annotations

import logging
from typing import Any

from bridge.adapters.naoqi.config import RobotConfig
from bridge.adapters.naoqi.joints import Joints
from bridge.adapters.naoqi.methods import Method, of_kind, refused
from bridge.dcm.requests import alias_request, set_alias_request, set_request
from bridge.errors import NaoqiRefused

logger = logging.getLogger(__name__)


def dcm_methods(joints: Joints) -> dict[str, Method]:
    """Methods of `DCM`."""
    dcm = joints.dcm

    def set_alias(*arguments: Any) -> None:
        command = arguments[0] if len(arguments) == 1 else list(arguments)
        dcm.set_alias(set_alias_request(_list("setAlias", command)))

    def create_alias(command: Any) -> list[str | list[str]]:
        return dcm.create_alias(alias_request(_list("createAlias", command)))

    def put(command: Any) -> None:
        dcm.set(set_request(_list("set", command)))

    def get_time(offset: Any) -> int:
        if isinstance(offset, bool) or not isinstance(offset, int):
            raise NaoqiRefused(
                f"DCM.getTime: {offset!r:.40} was given; an offset in ms, an integer, is expected."
            )
        return dcm.clock.shown(offset)

    return of_kind("joints", {"set": put, "setAlias": set_alias}) | of_kind(
        "read", {"createAlias": create_alias, "getTime": get_time, "getPrefix": dcm.prefixes}
    )


def small_services(config: RobotConfig, joints: Joints) -> dict[str, dict[str, Method]]:
    """Service -> methods.

    Args:
        config: facts about the robot.
        joints: of the robot; its newest frame has the battery.
    """
    tables: dict[str, dict[str, Any]] = {
        "ALSystem": {"systemVersion": lambda: config.naoqi_version, "robotName": lambda: config.name},
        "ALRobotModel": {
            "getRobotType": lambda: "Nao",
            "hasLegs": lambda: True,
            "hasArms": lambda: True,
            "hasHands": lambda: config.hands,
        },
        "ALBattery": {"getBatteryCharge": lambda: round(100.0 * joints.frame.battery[0])},
        "ALSonar": {"subscribe": _accept, "unsubscribe": _accept},
        "ALAutonomousLife": {
            "getState": lambda: "disabled",
            "setState": _require_disabled,
            "stopAll": lambda: None,
        },
        "ALTextToSpeech": {"say": _say, "setLanguage": _accept, "setVolume": _accept, "setParameter": _accept},
        "ALAnimatedSpeech": {"say": _say},
    }
    services = {name: of_kind("read", table) for name, table in tables.items()}
    services["ALAnimationPlayer"] = {name: refused("ALAnimationPlayer", name) for name in ("run", "runTag")}
    return services


def _list(method: str, command: Any) -> list[Any]:
    if not isinstance(command, list):
        raise NaoqiRefused(f"DCM.{method}: {command!r:.40} was given; a list is expected.")
    return command


def _accept(*_: Any) -> None:
    """Settings without effect: the sonar measures all the time, and there is one voice."""


def _say(sentence: Any, *_: Any) -> None:
    logger.info("the robot would say: %.500s", sentence)


def _require_disabled(state: Any) -> None:
    if state != "disabled":
        raise NaoqiRefused(f"ALAutonomousLife: {state!r:.40} was asked for; only `disabled` is there.")
