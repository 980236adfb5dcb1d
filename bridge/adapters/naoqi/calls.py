"""Calls of NAOqi programs, answered by threads of the serving process; qi itself runs in `qi_process`."""

from __future__ import annotations

import logging
import os
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from typing import Any, Final

from bridge.adapters.naoqi.pipe import Pipe, Unsendable
from bridge.errors import LinkError, NaoHilError

logger = logging.getLogger(__name__)

_START: Final = 30.0
"""s that the qi process may take to listen."""
_END: Final = 3.0
"""s that it may take to end."""


class CallServer:
    """Starts the qi process, and answers the calls that it passes on.

    Args:
        url: where qi listens.
        services: service -> methods.
        call: carries out a call (service, method, arguments): its result, or a future of it.
        priority: SCHED_FIFO priority of the qi process; 0: none.

    Raises:
        LinkError: qi could not listen.
    """

    def __init__(
        self,
        url: str,
        services: Mapping[str, Sequence[str]],
        call: Callable[[str, str, list[Any]], Any],
        priority: int,
    ) -> None:
        self._call = call
        self.calls = 0
        """Received so far."""
        ours, theirs = socket.socketpair()
        arguments = [url, str(theirs.fileno()), str(priority)]
        self._process = subprocess.Popen(
            [sys.executable, "-m", "bridge.adapters.naoqi.qi_process", *arguments],
            pass_fds=[theirs.fileno()],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
            start_new_session=True,
        )
        theirs.close()
        self._pipe = Pipe(ours)
        self._pipe.send([services])
        ours.settimeout(_START)
        first = self._pipe.receive()
        ours.settimeout(None)
        if first is None or not first[1]:
            self.close()
            raise LinkError(str(first[2]) if first else f"The qi process could not listen on {url}.")
        threading.Thread(target=self._answer_calls, name="calls", daemon=True).start()

    def check(self) -> None:
        """Raises LinkError when the qi process has ended."""
        if self._process.poll() is not None:
            raise LinkError(
                f"The qi process ended with exit code {self._process.returncode}; start the command again."
            )

    def publish(self, event: str, value: Any, callbacks: list[list[Any]]) -> None:
        """Tell the subscribers of an event of ALMemory.

        Args:
            event: its name.
            value: its value, of types that msgpack has.
            callbacks: as of `events.Publish`.
        """
        self._pipe.send([0, event, value, callbacks])

    def close(self) -> None:
        """End the qi process."""
        self._pipe.close()
        try:
            self._process.wait(_END)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def _answer_calls(self) -> None:
        while (message := self._pipe.receive()) is not None:
            number, service, method, arguments = message
            self.calls += 1
            try:
                result = self._call(service, method, arguments)
            except Exception as error:
                self._fail(number, error)
                continue
            if isinstance(result, Future):
                result.add_done_callback(self._reply(number))
            else:
                self._succeed(number, result)

    def _reply(self, number: int) -> Callable[[Future[Any]], None]:
        def reply(done: Future[Any]) -> None:
            error = done.exception()
            if error is None:
                self._succeed(number, done.result())
            else:
                self._fail(number, error)

        return reply

    def _succeed(self, number: int, result: Any) -> None:
        try:
            self._pipe.send([number, True, result])
        except Unsendable as error:
            self._pipe.send([number, False, f"The result cannot be passed on ({error})."])

    def _fail(self, number: int, error: BaseException) -> None:
        """Send the sentence of an error that a user can cause; any other is a fault, and is logged."""
        if isinstance(error, NaoHilError):
            self._pipe.send([number, False, str(error)])
        else:
            logger.error("a call failed", exc_info=error)
            self._pipe.send([number, False, f"This is a fault of nao-hil itself: {error!r}; please report it."])
