"""The service directory of the qi messaging protocol: the robot's services, and those of programs."""

from __future__ import annotations

import asyncio
import os
import uuid
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from bridge.adapters.naoqi.qi_connection import Connection
from bridge.adapters.naoqi.qi_values import QiError, decode, encode

Methods = dict[int, tuple[str, str, str]]
"""Action -> name, signature of the parameters, signature of the result."""
Signals = Mapping[int, tuple[str, str]]

_META: Final = (
    "({I(Issss[(ss)<MetaMethodParameter,name,description>]s)<MetaMethod,uid,returnSignature,name,"
    "parametersSignature,description,parameters,returnDescription>}{I(Iss)<MetaSignal,uid,name,signature>}"
    "{I(Iss)<MetaProperty,uid,name,signature>}s)<MetaObject,methods,signals,properties,description>"
)
REGISTER, UNREGISTER, META_OBJECT, TERMINATE, REGISTER_WITH_SIGNATURE = 0, 1, 2, 3, 8
OF_OBJECTS: Final[Methods] = {
    REGISTER: ("registerEvent", "(IIL)", "L"),
    UNREGISTER: ("unregisterEvent", "(IIL)", "v"),
    META_OBJECT: ("metaObject", "(I)", _META),
    TERMINATE: ("terminate", "(I)", "v"),
    REGISTER_WITH_SIGNATURE: ("registerEventWithSignature", "(IILs)", "L"),
}
"""Methods of every object."""
_INFO: Final = "(sIsI[s]ss)<ServiceInfo,name,serviceId,machineId,processId,endpoints,sessionId,objectUid>"
DIRECTORY: Final = 1
"""Number of the directory's own service."""
_ADDED, _REMOVED = 106, 107
MAX_MODULES: Final = 1000
"""Services that programs may register."""


def meta_object(methods: Methods, signals: Signals) -> bytes:
    """The description of an object, with the methods that every object has.

    Args:
        signals: action -> name, signature.
    """
    table = {
        action: [action, result, name, parameters, "", [], ""]
        for action, (name, parameters, result) in (OF_OBJECTS | methods).items()
    }
    named = {action: [action, name, signature] for action, (name, signature) in signals.items()}
    return encode(_META, [table, named, {}, ""])


@dataclass
class Service:
    """A service of the robot, or of a program at `connection`."""

    number: int
    name: str
    methods: Methods
    meta_object: bytes = b""
    connection: Connection | None = None
    info: list[Any] = field(default_factory=list)
    ready: bool = True
    actions: dict[str, list[tuple[int, str]]] = field(default_factory=dict)
    """Method -> action and signature of the parameters of each form; of a program's service after a query."""


class Directory:
    """All services, of which it is the first one."""

    def __init__(self, connections: Iterable[Connection]) -> None:
        self._connections = connections
        self.names: dict[str, Service] = {}
        self.services: dict[int, Service] = {}
        self._last = 0
        self._calls: dict[str, Callable[..., Any]] = {
            "service": self._service,
            "services": lambda to: [self._info(to, one) for one in self.services.values() if one.ready],
            "registerService": self._register,
            "unregisterService": lambda by, number: self._remove(self._own(by, number)),
            "serviceReady": self._ready,
            "updateServiceInfo": lambda *_: None,
            "machineId": lambda _: machine_id(),
        }
        methods: Methods = {
            100: ("service", "(s)", _INFO),
            101: ("services", "()", f"[{_INFO}]"),
            102: ("registerService", f"({_INFO})", "I"),
            103: ("unregisterService", "(I)", "v"),
            104: ("serviceReady", "(I)", "v"),
            105: ("updateServiceInfo", f"({_INFO})", "v"),
            108: ("machineId", "()", "s"),
        }
        self.add(
            "ServiceDirectory",
            methods,
            {_ADDED: ("serviceAdded", "(Is)"), _REMOVED: ("serviceRemoved", "(Is)")},
        )

    def add(self, name: str, methods: Methods, signals: Signals | None = None) -> None:
        """Add a service of the robot."""
        service = Service(0, name, methods, meta_object(methods, signals or {}))
        for action, (method, parameters, _) in methods.items():
            service.actions.setdefault(method, []).append((action, parameters))
        self._put(name, service)

    def _put(self, name: str, service: Service) -> int:
        self._last += 1
        service.number = self._last
        self.names[name] = self.services[service.number] = service
        return service.number

    def call(self, connection: Connection, method: str, arguments: list[Any]) -> Any:
        """Carry out a method of the directory.

        Raises:
            QiError: no such service, or a taken name.
        """
        return self._calls[method](connection, *arguments)

    def _info(self, connection: Connection, service: Service) -> list[Any]:
        """The entry of a service; the robot's have the client's own address of the directory."""
        number, endpoints = service.number, [connection.endpoint]
        return service.info or [service.name, number, machine_id(), os.getpid(), endpoints, "0", ""]

    def _service(self, connection: Connection, name: str) -> list[Any]:
        service = self.names.get(name)
        if service is None or not service.ready:
            raise QiError(f"Cannot find service '{name}' in index: nao-hil does not offer it")
        return self._info(connection, service)

    def _register(self, connection: Connection, info: list[Any]) -> int:
        name = info[0]
        if name in self.names:
            raise QiError(f"service {name!r:.60} is registered already")
        if sum(service.connection is not None for service in self.services.values()) >= MAX_MODULES:
            raise QiError(f"programs have registered {MAX_MODULES} services already")
        service = Service(0, name, {}, connection=connection, ready=False)
        number = self._put(name, service)
        service.info = [name, number, *info[2:]]
        return number

    def _own(self, connection: Connection, number: int) -> Service:
        service = self.services.get(number)
        if service is None or service.connection is not connection:
            raise QiError(f"this program has registered no service {number}")
        return service

    def _ready(self, connection: Connection, number: int) -> None:
        service = self._own(connection, number)
        service.ready = True
        self._send_event(_ADDED, service)

    def _remove(self, service: Service) -> None:
        del self.services[service.number], self.names[service.name]
        if service.ready:
            self._send_event(_REMOVED, service)

    def forget(self, connection: Connection) -> None:
        """Remove the services of a disconnected client."""
        for service in [s for s in self.services.values() if s.connection is connection]:
            self._remove(service)

    def _send_event(self, action: int, service: Service) -> None:
        payload = encode("(Is)", [service.number, service.name])
        for connection in self._connections:
            connection.event((DIRECTORY, 1, action), payload)

    async def module(self, name: str) -> Service:
        """A service that takes calls, with its methods: a program's or the robot's own.

        Raises:
            QiError: no such service that takes calls.
        """
        service = self.names.get(name)
        if service is not None and service.connection is None:
            return service
        # until it is ready, libqi has not bound it and refuses calls
        if (
            service is None
            or service.connection is None
            or not (service.ready and service.connection.takes_calls)
        ):
            raise QiError(f"module {name} is no service of this session; register it first")
        if not service.actions:
            try:
                reply = await service.connection.call(service.number, META_OBJECT, encode("(I)", [0]))
            except asyncio.CancelledError:
                raise QiError(f"module {name} is gone") from None
            for action, (_, _, method, parameters, *_) in decode(_META, reply)[0].items():
                service.actions.setdefault(method, []).append((action, parameters))
        return service

    async def call_module(self, name: str, method: str, arguments: list[Any]) -> None:
        """Call a method of a program's service, without waiting for it.

        Raises:
            QiError: no method takes these arguments.
        """
        service = await self.module(name)
        assert service.connection is not None
        fault = QiError(f"module {name} has no method {method}")
        for action, parameters in service.actions.get(method, []):
            try:
                payload = _arguments(parameters, arguments)
            except QiError as error:
                fault = error
                continue
            # a call, not a post: libqi prints the error of a post on the program's standard output
            answer = asyncio.ensure_future(service.connection.call(service.number, action, payload))
            answer.add_done_callback(_forget)
            return
        raise fault


def _forget(answer: asyncio.Future[Any]) -> None:
    """Ignore an error, which the program itself reports."""
    if not answer.cancelled():
        answer.exception()


def _arguments(signature: str, arguments: list[Any]) -> bytes:
    """The arguments of a call; for `m`, of a function with any number, a dynamic tuple of dynamic values."""
    if signature != "m":
        return encode(signature, arguments)
    members = f"({'m' * len(arguments)})"
    return encode("s", members) + encode(members, arguments)


def machine_id() -> str:
    """This machine's number in libqi: a client on the same machine connects by loopback."""
    kept = Path.home() / ".config" / "qimessaging" / "machine_id"
    try:
        return kept.read_text().strip()
    except OSError:
        return str(uuid.UUID(int=uuid.getnode()))
