"""The module `naoqi` of the vendor's Python SDK, over qi: `ALProxy`, `ALBroker`, `ALModule` and `ALBehavior`.

Any address leads to the robot that `nao-hil run-naoqi` serves. `import *` brings the names of the SDK.
"""

from __future__ import annotations

import ctypes  # noqa: F401
import inspect
import logging
import os
import sys
import threading
import weakref  # noqa: F401
from collections.abc import Callable
from types import ModuleType
from typing import Any

import qi

from bridge.validation import unknown_name
from nao_hil.naoqi_programs.modules import motion  # noqa: F401
from nao_hil.naoqi_programs.python2 import is_converted, of_robot
from nao_hil.naoqi_programs.services import Service, print_error, sendable

__all__ = [
    *(
        "ALBehavior",
        "ALBroker",
        "ALDocable",
        "ALModule",
        "ALProxy",
        "allog",
        "autoBind",
        "createModule",
        "ctypes",
    ),
    *("inaoqi", "inspect", "logging", "motion", "os", "qi", "sys", "weakref"),
]

URL = os.environ.get("NAO_HIL_NAOQI", "tcp://127.0.0.1:9559")
_lock = threading.RLock()
_open: dict[str, Any] = {}
"""The session, once it has been needed, and under `listening` that it takes calls."""


def _session() -> Any:
    with _lock:
        if "session" not in _open:
            _open["session"] = qi.Session()
            _open["session"].connect(URL)
        return _open["session"]


class _Post:
    """Calls of a proxy that do not wait: each returns its number, and errors are logged by the robot."""

    def __init__(self, service: Any) -> None:
        self._service = service

    def __getattr__(self, method: str) -> Callable[..., int]:
        return lambda *arguments: int(self._service.pCall([method, *arguments]))


class ALProxy:
    """A service of the robot; its methods are called as in the vendor's pages.

    Raises:
        RuntimeError: there is no such service.
    """

    def __init__(self, name: str, *address: Any) -> None:
        try:
            self._service = Service(_session().service(sendable(name)))
        except RuntimeError as error:
            known = ", ".join(sorted(s["name"] for s in _session().services() if s["name"][:1] == "A"))
            raise RuntimeError(f"ALProxy: there is no service {name} ({error}); there are {known}.") from None
        self._name = name
        self.post = _Post(self._service)

    def __getattr__(self, method: str) -> Callable[..., Any]:
        if method.startswith("__"):
            raise AttributeError(method)
        return lambda *arguments: self.call(method, *arguments)

    def call(self, method: str, *arguments: Any) -> Any:
        """Call a method by its name.

        Raises:
            RuntimeError: it is refused, or there is none of this name; one sentence.
        """
        found = getattr(self._service, method, None)
        if found is None:
            known = self._service.getMethodList()
            raise RuntimeError(f"{self._name}: {unknown_name('method', method, known)}.")
        return found(*arguments)

    def pCall(self, method: str, *arguments: Any) -> int:
        """As `post`."""
        return int(self._service.pCall([method, *arguments]))


class ALBroker:
    """Connects the program's modules; one is enough.

    Args:
        address: without effect: own address and port, the robot's address and port.
    """

    def __init__(self, name: str, *address: Any) -> None:
        self._name = name
        _session()

    def getName(self) -> str:
        """Name of the broker."""
        return self._name

    def shutdown(self) -> None:
        """Leave the robot."""
        with _lock:
            session = _open.pop("session", None)
            _open.clear()
        if session is not None:
            session.close()


class ALDocable:
    """A class that can be bound: all are."""

    def BIND_PYTHON(self, *_: Any) -> None:
        """Make a method callable by NAOqi: all are."""

    def __getattr__(self, name: str) -> Any:
        if name in _BINDING:
            return lambda *_: None
        raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")


_BINDING = {
    *("functionName", "addParam", "bindMethod", "setModuleDescription", "registerToBroker", "setReturn"),
    *("bindWithParam", "addMethodExample", "setMethodDescription", "unregisterFromBroker"),
}
"""Methods of the SDK's modules that describe them."""


class ALModule(ALDocable):
    """A module of a program: a service of its own, whose methods ALMemory calls for events.

    Args:
        name: of the module, under which `subscribeToEvent` finds it.
    """

    def __init__(self, name: str, *_: Any) -> None:
        self._module_name = name
        self.logger = logging.getLogger(name)
        self._number = register(name, self)

    def getName(self) -> str:
        """Name of the module."""
        return self._module_name

    def exit(self) -> None:
        """Take the module out of the session."""
        _session().unregisterService(self._number)


class ALBehavior(ALModule):
    """A module that Choregraphe makes of a box."""

    def log(self, message: Any) -> None:
        """Log a message."""
        self.logger.info(message)


def register(name: str, module: Any) -> int:
    """Offer the public methods of an object as a service of the session; its number."""
    session = _session()
    with _lock:
        if "listening" not in _open:
            session.listen("tcp://127.0.0.1:0")
            _open["listening"] = True
    own = [m for m in dir(type(module)) if not m.startswith("_") and callable(getattr(type(module), m))]
    methods = {method: _forward(getattr(module, method)) for method in own}
    return int(session.registerService(name, qi.multiThreaded()(type(name, (), methods))()))


def autoBind(*_: Any) -> None:
    """Bind the methods of a class: all are."""


def createModule(name: str) -> ALModule:
    """A module without methods of its own."""
    return ALModule(name)


inaoqi = ModuleType("inaoqi")
vars(inaoqi).update(broker=ALBroker, module=ALModule, proxy=ALProxy, behavior=ALBehavior)
allog = ModuleType("allog")
for _level in ("debug", "info", "warning", "error", "fatal"):
    setattr(allog, _level, lambda text, *_, _level=_level: print(text, file=sys.stderr))
sys.modules.update(inaoqi=inaoqi, allog=allog)


def _forward(method: Callable[..., Any]) -> Callable[..., Any]:
    """A method of an event and its value is called without the message, one of sound with bytes."""
    parameters = inspect.signature(method).parameters.values()
    named = [p for p in parameters if p.kind is inspect.Parameter.POSITIONAL_OR_KEYWORD]
    required = [p for p in named if p.default is inspect.Parameter.empty]
    most = len(named) if len(named) == len(parameters) and len(named) <= 2 else None
    sound = method.__name__ == "processRemote"
    old = is_converted(method)

    def call(_: Any, *arguments: Any) -> Any:
        """Call the method with as many of the arguments as it takes."""
        taken = list(arguments if len(arguments) == len(required) else arguments[:most])
        if sound:
            taken = [
                a.encode("latin-1") if isinstance(a, str) else a for a in taken
            ]  # the server has sent text
        try:
            return sendable(method(*map(of_robot, taken) if old else taken))
        except Exception as error:  # of the program; ALMemory, which called, cannot pass it on
            print_error(error, str(getattr(sys.modules["__main__"], "__file__", "")))
            raise

    return call
