"""ALMemory's events: raised by the robot and by programs, told to modules and to qi's signals."""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from bridge.adapters.naoqi.arguments import text
from bridge.adapters.naoqi.memory import MAX_DATA, Memory
from bridge.adapters.naoqi.methods import Table
from bridge.errors import NaoqiRefused

HISTORY: Final = 10
"""Values of an event that are kept (assumed)."""
Publish = Callable[[str, Any, list[list[Any]]], None]
"""Tells of an event: its name, its value, and `[module, method, message]` of each module to be called.

A list in place of the message is all that the method is called with.
"""


@dataclass(frozen=True)
class _EventSubscription:
    module: str
    method: str
    message: str


class Events:
    """Events of one robot; not thread-safe, the caller locks.

    Args:
        memory: keeps their values.
        publish: called for each event that is raised.
    """

    def __init__(self, memory: Memory, publish: Publish) -> None:
        self._memory, self._publish = memory, publish
        self._declared: dict[str, str] = {}
        """Event -> the extractor that raises it, or nothing."""
        self._micro: set[str] = set()
        self._subscriptions: dict[str, dict[str, _EventSubscription]] = {}
        """Event -> module -> what it asked for."""
        self._history: dict[str, deque[list[Any]]] = {}

    def declare(self, name: Any, extractor: Any = "", value: Any = None) -> None:
        """Make an event known before it is raised, with the value that it has until then, if any.

        Raises:
            NaoqiRefused: not a name, or too many.
        """
        self._know("declareEvent", name)
        self._declared[name] = text(extractor, "ALMemory.declareEvent: extractor")
        if value is not None:
            self._memory.put(name, value)

    def raise_event(self, name: Any, value: Any) -> None:
        """Store the value under the event's name and tell its subscribers.

        Raises:
            NaoqiRefused: not a name, or too many.
        """
        self._know("raiseEvent", name)
        self._memory.put(name, value)
        seconds, part = divmod(time.time(), 1.0)
        past = self._history.setdefault(name, deque(maxlen=HISTORY))
        past.append([value, [int(seconds), int(1e6 * part)]])
        told = self._subscriptions.get(name, {}).values()
        self._publish(name, value, [[one.module, one.method, one.message] for one in told])

    def raise_micro(self, name: Any, value: Any) -> None:
        """As `raise_event`; the event counts as a micro-event."""
        self.raise_event(name, value)
        self._micro.add(name)

    def _know(self, method: str, name: Any) -> None:
        if not isinstance(name, str) or (len(self._declared) >= MAX_DATA and name not in self._declared):
            raise NaoqiRefused(f"ALMemory.{method}: {name!r:.60} cannot be an event.")
        self._declared.setdefault(name, "")

    def subscribe(self, name: Any, module: Any, *rest: Any) -> None:
        """Have a module's method called as `method(event, value, message)`.

        Args:
            name: of the event.
            module: a service of this session; a program's own one, as a rule. That it is there and has the
                method is seen to in `qi_process`.
            rest: the method, or a message and the method.

        Raises:
            NaoqiRefused: not names.
        """
        if len(rest) not in (1, 2):
            raise NaoqiRefused(
                "ALMemory.subscribeToEvent takes (event, module, method) or (event, module, message, method)."
            )
        event = text(name, "ALMemory.subscribeToEvent: event")
        *message, method = (text(part, "ALMemory.subscribeToEvent: method") for part in rest)
        owner = text(module, "ALMemory.subscribeToEvent: module")
        self._know("subscribeToEvent", event)
        subscription = _EventSubscription(owner, method, message[0] if message else "")
        self._subscriptions.setdefault(event, {})[owner] = subscription

    def unsubscribe(self, name: Any, module: Any) -> None:
        """End a module's subscription, if there is one."""
        event = text(name, "ALMemory.unsubscribeToEvent: event")
        owner = text(module, "ALMemory.unsubscribeToEvent: module")
        self._subscriptions.get(event, {}).pop(owner, None)

    def forget_module(self, module: Any) -> None:
        """End all of a module's subscriptions."""
        owner = text(module, "ALMemory.unregisterModuleReference: module")
        for subscriptions in self._subscriptions.values():
            subscriptions.pop(owner, None)

    def subscribers(self, name: Any) -> list[str]:
        """Modules that subscribed to an event."""
        return sorted(self._subscriptions.get(text(name, "ALMemory.getSubscribers: event"), {}))

    def forget(self, name: Any) -> None:
        """Make an event unknown; its subscriptions end."""
        event = text(name, "ALMemory.removeEvent: event")
        self._declared.pop(event, None)
        self._subscriptions.pop(event, None)
        self._history.pop(event, None)
        self._micro.discard(event)

    def of_extractor(self, extractor: Any) -> list[str]:
        """Events that were declared for an extractor."""
        name = text(extractor, "ALMemory.getExtractorEvent: extractor")
        return sorted(event for event, owner in self._declared.items() if owner == name)

    def history(self, name: Any) -> list[list[Any]]:
        """`[[value, [s, us]], ...]` of the last values of an event, oldest first."""
        return list(self._history.get(text(name, "ALMemory.getEventHistory: event"), ()))

    def methods(self) -> Table:
        """Methods of `ALMemory` for events; `subscriber` is in `qi_process`."""
        return {
            "declareEvent": lambda name, extractor="": self.declare(name, extractor),
            "getEventList": lambda: sorted(self._declared),
            "getMicroEventList": lambda: sorted(self._micro),
            "raiseEvent": self.raise_event,
            "raiseMicroEvent": self.raise_micro,
            "removeEvent": self.forget,
            "removeMicroEvent": self.forget,
            "subscribeToEvent": self.subscribe,
            "subscribeToMicroEvent": self.subscribe,
            "unsubscribeToEvent": self.unsubscribe,
            "unsubscribeToMicroEvent": self.unsubscribe,
            "unregisterModuleReference": self.forget_module,
            "getSubscribers": self.subscribers,
            "getExtractorEvent": self.of_extractor,
            "getEventHistory": self.history,
        }
