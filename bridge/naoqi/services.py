"""The services of a served robot: which module has which method, and who may call it when."""

from __future__ import annotations

import inspect
import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from threading import RLock
from typing import Any, Final, Literal

import msgspec

from bridge.config import load_toml
from bridge.dcm.requests import alias_request, set_alias_request, set_request
from bridge.errors import NaoqiRefused
from bridge.messages import SensorFrame
from bridge.naoqi.config import RobotConfig
from bridge.naoqi.joints import Joints
from bridge.naoqi.leds import Leds
from bridge.naoqi.memory import Memory
from bridge.naoqi.motion import Motion
from bridge.naoqi.moving import Moving
from bridge.naoqi.posture import Postures
from bridge.naoqi.switches import ABILITIES, MOTION, Switches
from bridge.naoqi.tasks import Tasks, gone

logger = logging.getLogger(__name__)

Kind = Literal["read", "joints", "posture", "walk"]
"""`read` needs nothing; `joints` commands them, refused during a walk; `posture` ends a walk for it; `walk` is
for the walker."""


@dataclass(frozen=True)
class Method:
    """One method of a service."""

    call: Callable[..., Any]
    kind: Kind
    signature: inspect.Signature


class _Vendor(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    ALMotion: list[str]
    ALMemory: list[str]
    DCM: list[str]
    ALRobotPosture: list[str]
    ALLeds: list[str]
    ALSonar: list[str]


VENDOR: Final[dict[str, list[str]]] = msgspec.structs.asdict(
    load_toml(Path(__file__).with_name("methods.toml"), _Vendor)
)
"""Module -> methods that the real one has."""


class Services:
    """All services of one robot, from its first frame on.

    Args:
        config: what the robot is.
        frame: its first one.
        lock: held while joints and memory are touched.
        moving: walks, and hands the joints back and forth.
        require_lease: raises `NaoHilError` unless the joints may be commanded.
        commanded: told, with the lock held, that a call may have changed what the joints are to do.
        publish: told of each event of ALMemory.
    """

    def __init__(
        self,
        config: RobotConfig,
        frame: SensorFrame,
        lock: RLock,
        moving: Moving,
        require_lease: Callable[[], None],
        commanded: Callable[[], None],
        publish: Callable[[str, Any], None],
    ) -> None:
        self._config, self._lock, self._moving = config, lock, moving
        self._require_lease, self._commanded = require_lease, commanded
        self.joints = Joints(config.body, frame)
        self._tasks = Tasks()
        self.motion = Motion(self.joints, self._tasks, config)
        self._postures = Postures(self.joints, self.motion, self._tasks)
        self.memory = Memory(config.body, lambda: self.joints.dcm, config.keys(), publish)
        self.memory.update(frame)
        self._table = self._build()

    def cycle(self, frame: SensorFrame) -> None:
        """A new frame; the lock is held."""
        self.joints.cycle(frame)
        self.memory.update(frame)
        self._tasks.run(self.joints.dcm.clock.previous)

    def abandon(self) -> None:
        """The robot is gone, and with it what calls wait for; the lock is held."""
        self._tasks.end(gone())

    def names(self) -> dict[str, list[str]]:
        """Service -> methods, those included that only refuse."""
        return {name: list(methods) for name, methods in self._table.items()}

    def call(self, service: str, method: str, arguments: list[Any]) -> Any:
        """Carry out a call: its result, or a future of it.

        Raises:
            NaoHilError: it cannot be carried out; one sentence.
        """
        entry = self._table.get(service, {}).get(method)
        if entry is None:
            raise NaoqiRefused(f"{service}.{method} is not known here.")
        try:
            entry.signature.bind(*arguments)
        except TypeError as error:
            raise NaoqiRefused(
                f"{service}.{method}: {len(arguments)} arguments do not fit ({error})."
            ) from None
        return self._carry_out(entry, arguments)

    def _carry_out(self, entry: Method, arguments: list[Any]) -> Any:
        if entry.kind == "walk":
            return entry.call(*arguments)
        if entry.kind == "read":
            with self._lock:
                return entry.call(*arguments)

        def command() -> Any:
            with self._lock:
                self._require_lease()
                result = entry.call(*arguments)
                self._commanded()
                return result

        if self._moving.has_robot:
            return self._moving.with_joints(command, stop=entry.kind == "posture")
        return command()

    def _build(self) -> dict[str, dict[str, Method]]:
        switches = Switches()
        table: dict[str, dict[str, Method]] = {
            "ALMotion": self._motion_methods(switches),
            "ALMemory": _methods("read", self.memory.methods()),
            "DCM": self._dcm_methods(),
            "ALRobotPosture": _methods("read", self._postures.methods())
            | _methods(
                "posture",
                {
                    "goToPosture": self._postures.go_to,
                    "applyPosture": self._postures.apply,
                    "stopMove": self.motion.end_all,
                },
            ),
            "ALLeds": _methods("read", Leds(self.joints, self._tasks).methods()),
            "ALSonar": _methods("read", {"subscribe": _accept, "unsubscribe": _accept}),
            **self._small(),
        }
        table |= {name: _methods("read", switches.methods(name, of)) for name, of in ABILITIES.items()}
        for name, methods in table.items():
            common = _methods("read", self._common(name, methods))
            refused = {m: _refusal(name, m) for m in VENDOR.get(name, ()) if m != "subscriber"}
            table[name] = refused | common | methods
        return table

    def _motion_methods(self, switches: Switches) -> dict[str, Method]:
        postures: dict[str, Callable[..., Any]] = {
            "wakeUp": self._postures.wake_up,
            "rest": lambda *_: self._postures.rest(),
        }
        ending: dict[str, Callable[..., Any]] = {
            "killAll": self.motion.end_all,
            "killTasksUsingResources": lambda _names: self.motion.end_all(),
            "stop": lambda _number: self.motion.end_all(),
        }
        reading = self.motion.reading() | {"robotIsWakeUp": lambda: self._postures.awake}
        return (
            _methods("read", reading | switches.methods("ALMotion", MOTION) | switches.arms())
            | _methods("joints", self.motion.moving())
            | _methods("posture", postures | ending)
            | _methods("walk", self._moving.methods())
        )

    def _dcm_methods(self) -> dict[str, Method]:
        dcm = self.joints.dcm

        def set_alias(*arguments: Any) -> None:
            command = arguments[0] if len(arguments) == 1 else list(arguments)
            dcm.set_alias(set_alias_request(_list("setAlias", command)))

        def create_alias(command: Any) -> list[str | list[str]]:
            return dcm.create_alias(alias_request(_list("createAlias", command)))

        def put(command: Any) -> None:
            dcm.set(set_request(_list("set", command)))

        return _methods("joints", {"set": put, "setAlias": set_alias}) | _methods(
            "read",
            {"createAlias": create_alias, "getTime": self._get_time, "getPrefix": dcm.prefixes},
        )

    def _get_time(self, offset: Any) -> int:
        if isinstance(offset, bool) or not isinstance(offset, int):
            raise NaoqiRefused(
                f"DCM.getTime: {offset!r:.40} was given; an offset in ms, an integer, is expected."
            )
        return self.joints.dcm.clock.shown(offset)

    def _small(self) -> dict[str, dict[str, Method]]:
        """Modules of a few methods each."""
        config, frame = self._config, self.joints
        return {
            "ALSystem": _methods(
                "read", {"systemVersion": lambda: config.naoqi_version, "robotName": lambda: config.name}
            ),
            "ALRobotModel": _methods(
                "read",
                {
                    "getRobotType": lambda: "Nao",
                    "hasLegs": lambda: True,
                    "hasArms": lambda: True,
                    "hasHands": lambda: config.hands,
                },
            ),
            "ALBattery": _methods("read", {"getBatteryCharge": lambda: round(100.0 * frame.frame.battery[0])}),
            "ALAutonomousLife": _methods(
                "read", {"getState": lambda: "disabled", "setState": _require_disabled, "stopAll": lambda: None}
            ),
            "ALTextToSpeech": _methods(
                "read",
                {"say": _say, "setLanguage": _accept, "setVolume": _accept, "setParameter": _accept},
            ),
            "ALAnimatedSpeech": _methods("read", {"say": _say}),
            "ALAnimationPlayer": {name: _refusal("ALAnimationPlayer", name) for name in ("run", "runTag")},
        }

    def _common(self, service: str, methods: Mapping[str, Method]) -> dict[str, Callable[..., Any]]:
        """What every module has."""
        return {
            "ping": lambda: True,
            "version": lambda: self._config.naoqi_version,
            "getBrokerName": lambda: "naoqi",
            "getMethodList": lambda: sorted(methods),
            "getModuleHelp": lambda: [f"{service}, served by nao-hil", []],
            "isRunning": lambda _number: False,
            "wait": lambda *_: True,
        }


def _methods(kind: Kind, table: Mapping[str, Callable[..., Any]]) -> dict[str, Method]:
    return {name: Method(call, kind, inspect.signature(call)) for name, call in table.items()}


def _refusal(service: str, method: str) -> Method:
    def refuse(*_: Any) -> None:
        raise NaoqiRefused(f"{service}.{method} is not offered by nao-hil; docs/naoqi.md lists what is.")

    return Method(refuse, "read", inspect.signature(refuse))


def _list(method: str, command: Any) -> list[Any]:
    if not isinstance(command, list):
        raise NaoqiRefused(f"DCM.{method}: {command!r:.40} was given; a list is expected.")
    return command


def _accept(*_: Any) -> None:
    """What is always so: the sonar measures all the time, and there is one voice."""


def _say(sentence: Any, *_: Any) -> None:
    logger.info("the robot would say: %.500s", sentence)


def _require_disabled(state: Any) -> None:
    if state != "disabled":
        raise NaoqiRefused(f"ALAutonomousLife: {state!r:.40} was asked for; only `disabled` is there.")
