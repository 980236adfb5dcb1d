"""The process that speaks qi for a served robot: it passes each call on to the serving process.

qi calls Python under the interpreter's lock, so whatever computes here would hold up every client; the robot's
cycle and all logic are in the process that started this one. Each call becomes a message, its answer a promise
kept, so that a call that waits (an interpolation, a walk) holds up no other.

Started by `calls` as `python -m bridge.adapters.naoqi.qi_process URL DESCRIPTOR PRIORITY`.
"""

from __future__ import annotations

import os
import queue
import signal
import socket
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from bridge.adapters.naoqi.pipe import Pipe, Unsendable
from bridge.adapters.naoqi.qi_library import load_qi
from bridge.realtime import request_real_time

SUBSCRIBING: Final = ("subscribeToEvent", "subscribeToMicroEvent")
"""Methods of ALMemory that name a module and its method."""


class CallForwarder:
    """Services that pass calls on to the serving process.

    Args:
        qi: the package; needed by this process only.
        pipe: to the served robot.
    """

    def __init__(self, qi: Any, pipe: Pipe) -> None:
        self._qi, self._pipe = qi, pipe
        self._lock = threading.Lock()
        self._number = 0
        self._waiting: dict[int, Any] = {}
        self._signals: dict[str, Any] = {}
        self._session: Any = None
        self._callbacks: queue.SimpleQueue[tuple[str, Any, list[list[Any]]]] = queue.SimpleQueue()

    def listen(self, url: str, services: Mapping[str, Sequence[str]]) -> None:
        """Open the directory, register the services and say so."""
        session = self._qi.Session()
        with self._lock:  # the first call comes after the first message, however fast a client is
            session.listenStandalone(url)
            for name, methods in services.items():
                session.registerService(name, self._service(name, methods))
            self._pipe.send([0, True, session.endpoints()])
        self._session = session
        threading.Thread(target=self._call_modules, name="modules", daemon=True).start()

    def _service(self, name: str, methods: Sequence[str]) -> Any:
        members: dict[str, Any] = {method: self._method(name, method) for method in methods}
        if name == "ALMemory":
            members["subscriber"] = lambda _, event: self._subscriber(event)
        return self._qi.multiThreaded()(type(name, (), members))()

    def _method(self, service: str, method: str) -> Callable[..., Any]:
        # `*arguments`: qi exports no default arguments, and ALMotion's methods have many forms.
        return lambda _, *arguments: self._call(service, method, arguments)

    def _call(self, service: str, method: str, arguments: Sequence[Any]) -> Any:
        promise = self._qi.Promise()
        if service == "ALMemory" and method in SUBSCRIBING:
            fault = self._callback_fault(arguments)
            if fault:
                promise.setError(f"{service}.{method}: {fault}.")
                return promise.future()
        with self._lock:
            self._number += 1
            number = self._number
            self._waiting[number] = promise
        try:
            self._pipe.send([number, service, method, arguments])
        except Unsendable as error:
            self._waiting.pop(number)
            promise.setError(f"{service}.{method}: an argument cannot be passed on ({error}).")
        return promise.future()

    def _callback_fault(self, arguments: Sequence[Any]) -> str:
        """What keeps ALMemory from calling the method of `(event, module, [message,] method)`, or nothing."""
        names = list(arguments[1:2]) + list(arguments[-1:])
        if len(arguments) not in (3, 4) or not all(isinstance(name, str) for name in names):
            return ""  # the served robot refuses them
        module, method = names
        try:
            found = self._session.service(module)
        except RuntimeError:
            return f"module {module} is no service of this session; register it first"
        return "" if hasattr(found, method) else f"module {module} has no method {method}"

    def _subscriber(self, event: str) -> Any:
        """The object whose `signal` tells of an event; the same for all who ask."""
        if not isinstance(event, str):
            raise RuntimeError(
                f"ALMemory.subscriber: {event!r:.60} was given; the name of an event is expected."
            )
        with self._lock:
            if event not in self._signals:
                self._signals[event] = type("Subscriber", (), {})()
                self._signals[event].signal = self._qi.Signal("m")
            return self._signals[event]

    def run(self) -> None:
        """Keep promises until the served robot is gone."""
        while (message := self._pipe.receive()) is not None:
            number, second, third, *callbacks = message
            if number == 0:
                subscriber = self._signals.get(second)
                if subscriber is not None:
                    subscriber.signal(third)
                if callbacks[0]:
                    self._callbacks.put((second, third, callbacks[0]))
                continue
            promise = self._waiting.pop(number)
            if second:
                promise.setValue(_with_text(third))
            else:
                promise.setError(third)

    def _call_modules(self) -> None:
        """Call the modules that subscribed to events, in the order of the events; one that is gone is left out.

        In a thread of its own: to ask where a module is takes a while.
        """
        modules: dict[str, Any] = {}
        while True:
            event, value, callbacks = self._callbacks.get()
            for name, method, message in callbacks:
                try:
                    if name not in modules:
                        modules[name] = self._session.service(name)
                    arguments = [event, value, message] if isinstance(message, str) else _with_text(message)
                    getattr(modules[name], method)(*arguments, _async=True)
                except (RuntimeError, AttributeError):
                    modules.pop(name, None)


def _with_text(value: Any) -> Any:
    """A result without bytes, which qi's package for Python cannot send: a character for each instead."""
    if isinstance(value, list):
        return [part.decode("latin-1") if isinstance(part, bytes) else part for part in value]
    return value


def main(url: str, descriptor: int, priority: int) -> None:
    """Serve until the other end of the pipe is closed; with SCHED_FIFO unless the priority is 0."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the served robot ends this process
    pipe = Pipe(socket.socket(fileno=descriptor))
    table = pipe.receive()
    if table is None:
        return
    try:
        qi = load_qi()
    except ImportError:
        pipe.send([0, False, "qi is not installed; pip install 'nao-hil[naoqi]'."])
        return
    forwarder = CallForwarder(qi, pipe)
    try:
        forwarder.listen(url, table[0])
    except RuntimeError as error:
        pipe.send([0, False, f"qi cannot listen on {url}: {str(error).splitlines()[0]}"])
        # qi aborts when a session that failed to listen is taken apart.
        os._exit(1)
    if priority:
        request_real_time(priority)
    forwarder.run()
    os._exit(0)  # taking qi apart can take seconds while clients are connected


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3]))
