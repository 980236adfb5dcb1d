"""A server of the qi messaging protocol: calls of the robot's services, and events of its memory.

It passes each call on in its own thread, without logic of the robot's. Sources of the protocol: libqi's code,
and messages of libqi 3.1.5.
"""

from __future__ import annotations

import asyncio
import itertools
import logging
import threading
import time
from collections.abc import Callable, Coroutine, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any, Final

from bridge.adapters.naoqi.qi_connection import MAIN, Connection, Message
from bridge.adapters.naoqi.qi_directory import (
    DIRECTORY,
    META_OBJECT,
    OF_OBJECTS,
    REGISTER,
    REGISTER_WITH_SIGNATURE,
    TERMINATE,
    UNREGISTER,
    Directory,
    Methods,
    Service,
    meta_object,
)
from bridge.adapters.naoqi.qi_library import check_url
from bridge.adapters.naoqi.qi_values import ObjectReference, QiError, encode
from bridge.adapters.naoqi.robot_files import in_thread
from bridge.errors import LinkError, NaoHilError

LOG_MANAGER: Final = "LogManager"
_LEVEL: Final = "(i)<LogLevel,level>"
_TIME: Final = "(L)<TimePoint,ns>"
_MESSAGE: Final = (
    f"(s{_LEVEL}sssI{_TIME}{_TIME})<LogMessage,source,level,category,location,message,id,date,systemDate>"
)
METHODS: Final[Methods] = {
    100: ("log", f"([{_MESSAGE}])", "v"),
    101: ("createListener", "()", "o"),
    102: ("getListener", "()", "o"),
}
_ON_MESSAGE: Final = 103
_LISTENER: Final = meta_object(
    {
        100: ("setLevel", f"({_LEVEL})", "v"),
        101: ("setCategory", f"(s{_LEVEL})", "v"),
        102: ("clearFilters", "()", "v"),
    },
    {_ON_MESSAGE: ("onLogMessage", f"({_MESSAGE})")},
)
_LEVELS: Final = {logging.CRITICAL: 1, logging.ERROR: 2, logging.WARNING: 3, logging.INFO: 4, logging.DEBUG: 6}


class LogEvents(logging.Handler):
    """Sends the log of this process as events of the listeners; their settings have no effect.

    Args:
        send: an event's payload, in any thread.
    """

    def __init__(self, send: Callable[[bytes], None]) -> None:
        super().__init__(logging.INFO)
        self._send = send
        self._number = 0

    def emit(self, record: logging.LogRecord) -> None:
        """See `logging.Handler`."""
        self._number += 1
        source = f"{record.filename}:{record.funcName}:{record.lineno}"
        level = [_LEVELS.get(record.levelno, 4)]
        now: list[Any] = [int(1e9 * record.created)]
        since_start = [time.monotonic_ns()]
        text = record.getMessage()
        message = [source, level, record.name, "nao-hil", text, self._number, since_start, now]
        self._send(encode(f"({_MESSAGE})", [message]))


logger = logging.getLogger(__name__)

SUBSCRIBING: Final = ("subscribeToEvent", "subscribeToMicroEvent")
"""Methods of ALMemory that name a module and its method."""
_MEMORY: Final = "ALMemory"
_FIRST_METHOD: Final = 100
_SIGNAL: Final = 100
"""Action of a subscriber's signal."""
_SUBSCRIBER: Final = meta_object({}, {_SIGNAL: ("signal", "(m)")})
MAX_SIGNAL_OBJECTS: Final = 10_000
_LONG_PAYLOAD: Final = 1 << 17
"""bytes whose decoding would delay other calls: over 20 ms"""
_START_TIMEOUT: Final = 10.0
"""s that the server's thread may take to begin or to end"""


@dataclass(frozen=True)
class _SignalObject:
    """An object with one signal; libqi needs one for each call that returns it (replies are sorted by it)."""

    connection: Connection
    service: int
    number: int
    signal: int
    """Action of the signal."""
    meta: bytes

    def send(self, payload: bytes) -> None:
        """Send the signal to the client that has the object."""
        self.connection.event((self.service, self.number, self.signal), payload)


class QiServer:
    """Listens in a thread of its own until it is closed.

    Args:
        url: `tcp://HOST:PORT`.
        services: service -> methods.
        call: (service, method, arguments) -> result, or a future of it.

    Raises:
        LinkError: it cannot listen there.
    """

    def __init__(
        self, url: str, services: Mapping[str, Sequence[str]], call: Callable[[str, str, list[Any]], Any]
    ) -> None:
        self._call = call
        self.calls = 0
        """Calls of the robot's services so far."""
        self._connections: set[Connection] = set()
        self._directory = Directory(self._connections)
        for name, methods in services.items():
            table: Methods = {_FIRST_METHOD + i: (method, "m", "m") for i, method in enumerate(methods)}
            if name == _MEMORY:
                table[_FIRST_METHOD + len(table)] = ("subscriber", "(s)", "o")
            self._directory.add(name, table)
        self._directory.add(LOG_MANAGER, METHODS)
        self._objects: dict[int, _SignalObject] = {}
        """By number."""
        self._object_numbers = itertools.count(MAIN + 1)
        self._subscribers: dict[tuple[str, str], set[int]] = {}
        """Service and event -> numbers of the objects with its signal."""
        self._loop = asyncio.new_event_loop()
        self._modules: asyncio.Queue[tuple[str, Any, list[list[Any]]]] = asyncio.Queue()
        self._tasks: set[asyncio.Task[None]] = set()
        started: Future[None] = Future()
        self._thread = threading.Thread(target=self._run, args=(url, started), name="qi", daemon=True)
        self._thread.start()
        started.result(_START_TIMEOUT)

    def _run(self, url: str, started: Future[None]) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            server = self._loop.run_until_complete(self._loop.create_server(self._connect, *check_url(url)))
        except OSError as error:
            self._loop.close()
            reason = (error.strerror or str(error)).lower()
            started.set_exception(
                LinkError(f"Cannot listen on {url}: {reason}; stop its listener, or take another --listen.")
            )
            return
        self._spawn(self._call_modules())
        log = LogEvents(lambda payload: self._soon(self._send_signal, LOG_MANAGER, "", payload))
        logging.getLogger("bridge").addHandler(log)
        started.set_result(None)
        self._loop.run_forever()
        logging.getLogger("bridge").removeHandler(log)
        server.close()
        for task in self._tasks:
            task.cancel()
        for connection in list(self._connections):
            connection.close()
        self._loop.run_until_complete(asyncio.sleep(0.0))
        self._loop.close()

    def _connect(self) -> Connection:
        connection = Connection(self)
        self._connections.add(connection)
        return connection

    def _spawn(self, work: Coroutine[Any, Any, None]) -> None:
        task = self._loop.create_task(work)
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def close(self) -> None:
        """End the server and its connections."""
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(_START_TIMEOUT)

    def publish(self, event: str, value: Any, callbacks: list[list[Any]]) -> None:
        """Send an event of ALMemory to its subscribers; any thread may call this.

        Args:
            callbacks: as for `memory.Publish`.
        """
        if self.has_signal(event) or callbacks:
            self._soon(self._publish, event, value, callbacks)

    def has_signal(self, event: str) -> bool:
        """Whether a client has the signal of an event of ALMemory; any thread may call this."""
        return (_MEMORY, event) in self._subscribers

    def _soon(self, function: Callable[..., None], *arguments: Any) -> None:
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(function, *arguments)

    def _publish(self, event: str, value: Any, callbacks: list[list[Any]]) -> None:
        if self.has_signal(event):
            self._send_signal(_MEMORY, event, encode("(m)", [value]))
        if callbacks:
            self._modules.put_nowait((event, value, callbacks))

    def _send_signal(self, service: str, event: str, payload: bytes) -> None:
        for number in self._subscribers.get((service, event), ()):
            self._objects[number].send(payload)

    async def _call_modules(self) -> None:
        """Call the modules with subscriptions, in the events' order; lost modules are left out."""
        while True:
            event, value, callbacks = await self._modules.get()
            for name, method, message in callbacks:
                arguments = [event, value, message] if isinstance(message, str) else message
                own = self._directory.names.get(name)
                try:
                    if own is not None and own.connection is None:
                        self._call(name, method, arguments)
                    else:
                        await self._directory.call_module(name, method, arguments)
                except (QiError, NaoHilError) as error:
                    logger.debug("%s", error)

    def disconnected(self, connection: Connection) -> None:
        """Forget a client and its services."""
        self._connections.discard(connection)
        self._directory.forget(connection)
        for number in [n for n, one in self._objects.items() if one.connection is connection]:
            self._remove_object(number)

    def handle(self, connection: Connection, message: Message) -> None:
        """Carry out a call of a client.

        Raises:
            QiError: no such service or method, or the arguments do not fit.
        """
        service = self._directory.services.get(message.service)
        if service is None or service.connection is not None:
            raise QiError(f"there is no service {message.service} here")
        if message.action in OF_OBJECTS:
            connection.reply(message, self._of_object(connection, service, message))
            return
        if service.name == LOG_MANAGER and message.object in self._objects:
            connection.reply(message, b"")
            return
        if message.object != MAIN or message.action not in service.methods:
            raise QiError(f"{service.name} has no method {message.action} on object {message.object}")
        _, parameters, _ = service.methods[message.action]
        if len(message.payload) > _LONG_PAYLOAD:
            self._spawn(self._handle_long(connection, message, service))
        else:
            self._carry_out(connection, message, service, message.values(parameters))

    async def _handle_long(self, connection: Connection, message: Message, service: Service) -> None:
        """Decode a long message in a thread of its own, then carry the call out."""
        _, parameters, _ = service.methods[message.action]
        try:
            arguments = await asyncio.wrap_future(in_thread(lambda: message.values(parameters)))
            self._carry_out(connection, message, service, arguments)
        except QiError as error:
            connection.fail(message, f"qi: {error}.")

    def _carry_out(
        self, connection: Connection, message: Message, service: Service, arguments: list[Any]
    ) -> None:
        name, _, result = service.methods[message.action]
        if service.number == DIRECTORY:
            connection.reply(message, encode(result, self._directory.call(connection, name, arguments)))
        elif service.name == LOG_MANAGER and result == "o":
            listener = self._new_object(connection, service, "", _ON_MESSAGE, _LISTENER)
            connection.reply(message, encode(result, listener))
        elif service.name == LOG_MANAGER:
            connection.reply(message, b"")
        elif result == "o":
            subscriber = self._new_object(connection, service, arguments[0], _SIGNAL, _SUBSCRIBER)
            connection.reply(message, encode(result, subscriber))
        elif service.name == _MEMORY and name in SUBSCRIBING:
            self._spawn(self._subscribe(connection, message, name, arguments))
        else:
            self._call_robot(connection, message, service.name, name, arguments)

    def _of_object(self, connection: Connection, service: Service, message: Message) -> bytes:
        _, parameters, result = OF_OBJECTS[message.action]
        arguments = message.values(parameters)
        if message.action == META_OBJECT:
            if message.object == MAIN:
                return service.meta_object
            found = self._objects.get(message.object)
            if found is None or found.service != service.number:
                raise QiError(f"{service.name} has no object {message.object}")
            return found.meta
        if message.action in (REGISTER, REGISTER_WITH_SIGNATURE):
            connection.link(arguments[2], (service.number, message.object, arguments[1]))
            return encode(result, arguments[2])
        if message.action == UNREGISTER:
            connection.unlink(arguments[2])
        elif message.action == TERMINATE:
            found = self._objects.get(message.object)
            if found is not None and found.connection is connection:
                self._remove_object(message.object)
        return b""

    def _new_object(
        self, connection: Connection, service: Service, event: str, signal: int, meta: bytes
    ) -> ObjectReference:
        """An object of one client with the signal of an event.

        Raises:
            QiError: there are too many.
        """
        if len(self._objects) >= MAX_SIGNAL_OBJECTS:
            raise QiError(f"{MAX_SIGNAL_OBJECTS} events have subscribers already")
        number = next(self._object_numbers)
        self._objects[number] = _SignalObject(connection, service.number, number, signal, meta)
        self._subscribers.setdefault((service.name, event), set()).add(number)
        return ObjectReference(meta, service.number, number)

    def _remove_object(self, number: int) -> None:
        del self._objects[number]
        for key, numbers in list(self._subscribers.items()):
            numbers.discard(number)
            if not numbers:
                del self._subscribers[key]

    async def _subscribe(
        self, connection: Connection, message: Message, method: str, arguments: list[Any]
    ) -> None:
        """Subscribe by `(event, module, [message,] method)`, after a check of the module's method.

        Robots take a name without a module too; public programs give such ones, and read the event's key.
        """
        try:
            names = arguments[1:2] + arguments[-1:]
            named = len(arguments) in (3, 4) and all(isinstance(name, str) for name in names)
            if named and names[0] not in self._directory.names:
                logger.warning("%s.%s: no module %.60s is registered", _MEMORY, method, names[0])
            elif named:
                module = await self._directory.module(names[0])
                if names[1] not in module.actions:
                    raise QiError(f"module {names[0]} has no method {names[1]}")
        except QiError as error:
            connection.fail(message, f"{_MEMORY}.{method}: {error}.")
        else:
            self._call_robot(connection, message, _MEMORY, method, arguments)

    def _call_robot(
        self, connection: Connection, message: Message, service: str, method: str, arguments: list[Any]
    ) -> None:
        self.calls += 1
        try:
            result = self._call(service, method, arguments)
        except Exception as error:
            _fail(connection, message, error)
            return
        if isinstance(result, Future):
            result.add_done_callback(lambda done: self._soon(_settle, connection, message, done))
        else:
            _answer(connection, message, result)


def _settle(connection: Connection, message: Message, done: Future[Any]) -> None:
    error = done.exception()
    if error is None:
        _answer(connection, message, done.result())
    else:
        _fail(connection, message, error)


def _answer(connection: Connection, message: Message, result: Any) -> None:
    try:
        connection.reply(message, encode("m", result))
    except QiError as error:
        connection.fail(message, f"The result cannot be sent: {error}.")


def _fail(connection: Connection, message: Message, error: BaseException) -> None:
    """Send the sentence of an error that a user can cause; any other is logged as a fault."""
    if isinstance(error, NaoHilError):
        connection.fail(message, str(error))
    else:
        logger.error("a call failed", exc_info=error)
        connection.fail(message, f"This is a fault of nao-hil itself: {error!r}; please report it.")
