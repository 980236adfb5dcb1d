"""The module `naoqi` of the vendor's Python SDK, over qi: `ALProxy`, `ALBroker` and `ALModule`.

Any address leads to the robot that `nao-hil run-naoqi` serves.
"""

from __future__ import annotations

import inspect
import os
import sys
import threading
from collections.abc import Callable
from typing import Any

import qi

from bridge.validation import unknown_name
from nao_hil.naoqi_programs.errors import print_error
from nao_hil.naoqi_programs.pictures import SERVICE, VideoProxy

__all__ = ["ALBroker", "ALModule", "ALProxy"]

URL = os.environ.get("NAO_HIL_NAOQI", "tcp://127.0.0.1:9559")
_lock = threading.RLock()
_open: dict[str, Any] = {}
"""The session, once somebody needed it, and under `listening` that it takes calls."""


def _session() -> Any:
    with _lock:
        if "session" not in _open:
            _open["session"] = qi.Session()
            _open["session"].connect(URL)
        return _open["session"]


class _Post:
    """Calls of a proxy that do not wait: each gives the number of the call."""

    def __init__(self, service: Any) -> None:
        self._service = service

    def __getattr__(self, method: str) -> Callable[..., int]:
        return lambda *arguments: int(self._service.pCall([method, *arguments]))


class ALProxy:
    """A service of the robot; its methods are called as the vendor's pages say.

    Args:
        name: of the service.
        address: without effect, as is the port: address and port, or a broker.

    Raises:
        RuntimeError: there is no such service.
    """

    def __init__(self, name: str, *address: Any) -> None:
        try:
            service = _session().service(name)
            self._service = VideoProxy(service) if name == SERVICE else service
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
        return found(*(a.decode() if isinstance(a, bytes) else a for a in arguments))  # qi sends no bytes


class ALBroker:
    """Connects the program's modules; one is enough.

    Args:
        name: of the broker.
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


class ALModule:
    """A module of a program: a service of its own, whose methods ALMemory calls for events.

    Args:
        name: of the module, under which `subscribeToEvent` finds it.
    """

    def __init__(self, name: str) -> None:
        self._module_name = name
        session = _session()
        with _lock:
            if "listening" not in _open:
                session.listen("tcp://127.0.0.1:0")
                _open["listening"] = True
        methods = {
            method: _forward(getattr(self, method))
            for method in dir(type(self))
            if not method.startswith("_") and callable(getattr(type(self), method))
        }
        self._number = session.registerService(name, qi.multiThreaded()(type(name, (), methods))())

    def getName(self) -> str:
        """Name of the module."""
        return self._module_name

    def exit(self) -> None:
        """Take the module out of the session."""
        _session().unregisterService(self._number)


def _forward(method: Callable[..., Any]) -> Callable[..., Any]:
    """A method of an event and its value is called without the message, one of sound with bytes."""
    parameters = inspect.signature(method).parameters.values()
    named = [p for p in parameters if p.kind is inspect.Parameter.POSITIONAL_OR_KEYWORD]
    most = 2 if len(named) == len(parameters) == 2 else None
    sound = method.__name__ == "processRemote"

    def call(_: Any, *arguments: Any) -> Any:
        try:
            return method(*map(_as_bytes, arguments[:most]) if sound else arguments[:most])
        except Exception as error:  # of the program; ALMemory, which called, has nobody to tell of it
            print_error(error, str(getattr(sys.modules["__main__"], "__file__", "")))
            raise

    return call


def _as_bytes(argument: Any) -> Any:
    """Sound as a robot sends it, where the server sends text for bytes."""
    return argument.encode("latin-1") if isinstance(argument, str) else argument
