"""The page's server: one HTML page, files to save, and a WebSocket that carries rows and orders."""

from __future__ import annotations

import contextlib
import json
import logging
import math
import os
import queue
import socket
import ssl
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from http import HTTPStatus
from typing import Any, Final, NamedTuple
from urllib.parse import urlsplit

from bridge.errors import ConfigurationError, LinkError, NaoHilError
from nao_hil.view.access import Access, Answer, Asked
from nao_hil.view.orders import MAX_ORDER_SIZE

HEADERS: Final = (
    ("Cache-Control", "no-store"),
    ("Referrer-Policy", "no-referrer"),
    ("X-Content-Type-Options", "nosniff"),
)
POLICY: Final = "default-src 'none'; frame-ancestors 'none'"
"""Content-Security-Policy of everything but the page, which has its own."""
HTML: Final = (("Content-Type", "text/html; charset=utf-8"),)
PING_INTERVAL: Final = 0.3
"""s between two questions to a browser whether it is there."""
CLOSE_TIMEOUT: Final = 0.5
"""s for the last message to reach the browsers."""
MAX_BACKLOG: Final = 300
"""Messages waiting for a browser; one that is further behind gets the run from its start again."""
HOST_PATH: Final = "/host"
"""Answered with the header `Host`: a page finds that a proxy changes it, for which its WebSocket is refused."""
URGENT_PREFIX: Final = b'{"do":"stop'
"""Beginning of an emergency stop: it waits for no order before it."""
KEPT: Final = {"answer", "caption", "ended"}
"""Fields of messages that no run from its start repeats: a browser that is behind gets them all."""

logger = logging.getLogger(__name__)

Whole = Callable[[], "bytes | None"]
Files = Callable[[str], "Answer | None"]


class Message(NamedTuple):
    """A message to a browser."""

    data: bytes | str
    kept: bool = False
    """No run from its start repeats it."""


class Browser:
    """One open page.

    Args:
        connection: Its WebSocket.
        whole: Gives the packed run from its start; None: there is none yet.
    """

    def __init__(self, connection: Any, whole: Whole) -> None:
        self._connection, self._whole = connection, whole
        self._queue: queue.Queue[Message | None] = queue.Queue()
        self._sender = threading.Thread(target=self._send, name="sender", daemon=True)
        self.seen = time.monotonic()
        """Time of its last sign of life, monotonic, s."""

    def start(self) -> None:
        """Send the run, and from then on each `put`."""
        self._begin()
        self._sender.start()

    def put(self, message: Message) -> None:
        """Send a message after those before it, or the run from its start to a browser that is behind."""
        if message.kept or self._queue.qsize() <= MAX_BACKLOG:
            self._queue.put(message)
        else:
            self._begin()

    def _begin(self) -> None:
        """Send the run from its start, after the waiting messages that it does not repeat."""
        waiting = []
        with contextlib.suppress(queue.Empty):
            while True:
                waiting.append(self._queue.get_nowait())
        for message in waiting:
            if message is None or message.kept:
                self._queue.put(message)
        if (run := self._whole()) is not None:
            self._queue.put(Message(run))

    def end(self, timeout: float = 0.0) -> None:
        """Send the messages before this call, for `timeout` s, and no more."""
        self._queue.put(None)
        self._sender.join(timeout)

    def _send(self) -> None:
        from websockets.exceptions import ConnectionClosed

        pong, asked = None, 0.0
        with contextlib.suppress(ConnectionClosed, OSError):
            while True:
                # The browser answers pings also where its tab is hidden, and its scripts sleep.
                if pong is None or pong.is_set():
                    self.seen = time.monotonic()
                    if self.seen - asked >= PING_INTERVAL:
                        pong, asked = self._connection.ping(), self.seen
                        self._connection.send("{}")  # for the page's script, which sees no ping
                with contextlib.suppress(queue.Empty):
                    if (message := self._queue.get(timeout=PING_INTERVAL)) is None:
                        return
                    self._connection.send(message.data)


class PageServer:
    """Serves the page until `close`.

    Raises:
        ConfigurationError: websockets is not installed.
        LinkError: the place cannot be listened on.
    """

    def __init__(self, host: str, port: int, access: Access, tls: ssl.SSLContext | None = None) -> None:
        try:
            from websockets.sync.server import serve
        except ModuleNotFoundError as error:
            raise ConfigurationError(
                f"The page needs {error.name}, which is not installed: pip install 'nao-hil[view]'."
            ) from None
        self._lock = threading.Lock()
        self._browsers: set[Browser] = set()
        self._seen = -math.inf
        self._page = Answer(HTTPStatus.SERVICE_UNAVAILABLE)
        self._files: Files = lambda _: None
        self._whole: Whole = lambda: None
        self._order: Callable[[str | bytes], tuple[str, bool]] = lambda _: ("There is no robot yet.", False)
        self._workers = {urgent: ThreadPoolExecutor(1, "orders") for urgent in (True, False)}
        silent = logging.getLogger("nao_hil.view.connections")
        silent.setLevel(logging.CRITICAL)
        try:
            self._server = serve(
                self._handle,
                sock=socket.create_server((host, port)),
                ssl=tls,
                process_request=door(access, self._file),
                compression=None,
                max_size=MAX_ORDER_SIZE,
                logger=silent,
            )
        except (OSError, OverflowError) as error:
            reason = os.strerror(error.errno) if isinstance(error, OSError) and error.errno else str(error)
            raise LinkError(
                f"The page cannot be served at {host}:{port} ({reason}); give another --port."
            ) from None
        self._thread = threading.Thread(target=self._server.serve_forever, name="page", daemon=True)
        self._thread.start()

    def show(self, page: str, policy: str) -> None:
        """Serve this page, HTML, under this Content-Security-Policy."""
        headers = (*HTML, ("Content-Security-Policy", f"{policy}; frame-ancestors 'none'"))
        self._page = Answer(HTTPStatus.OK, page.encode(), headers)

    def feed(self, whole: Whole, order: Callable[[str | bytes], tuple[str, bool]], files: Files) -> None:
        """Fill the page with a live run.

        Args:
            whole: Gives the packed run up to now.
            order: Carries out an order; returns a sentence and whether the order is carried out.
            files: Answers to paths other than the page's.
        """
        self._whole, self._order, self._files = whole, order, files
        with self._lock:
            for browser in self._browsers:
                browser._begin()

    @property
    def absence(self) -> float:
        """Time since the last sign of life of a browser, s."""
        with self._lock:
            self._seen = max([self._seen, *(browser.seen for browser in self._browsers)])
        return time.monotonic() - self._seen

    def publish(self, message: bytes | dict[str, Any]) -> None:
        """Send rows, or an object as JSON, to all browsers."""
        if isinstance(message, bytes):
            sent = Message(message)
        else:
            sent = Message(json.dumps(message), kept=not KEPT.isdisjoint(message))
        with self._lock:
            for browser in self._browsers:
                browser.put(sent)

    def close(self, last: str = "", *, run: bool = False) -> None:
        """End all connections, after a last sentence for those who watch; `run`: the run has ended as well."""
        self.publish({"ended": last, "run": run})
        with self._lock:
            browsers = list(self._browsers)
        until = time.monotonic() + CLOSE_TIMEOUT
        for browser in browsers:
            browser.end(max(until - time.monotonic(), 0.0))
        for worker in self._workers.values():
            worker.shutdown(wait=False, cancel_futures=True)
        self._server.shutdown()
        self._thread.join(2.0)

    def _handle(self, connection: Any) -> None:
        browser = Browser(connection, lambda: self._whole())
        with self._lock:
            browser.start()
            self._browsers.add(browser)
        try:
            for text in connection:
                urgent = (text.encode() if isinstance(text, str) else text).startswith(URGENT_PREFIX)
                self._workers[urgent].submit(self._answer, browser, text, urgent)
        finally:
            with self._lock:
                self._seen = max(self._seen, browser.seen)
                self._browsers.discard(browser)
            browser.end()

    def _answer(self, browser: Browser, text: str | bytes, urgent: bool) -> None:
        try:
            sentence, done = self._order(text)
        except Exception as error:  # the worker's pool would keep it, and the page wait for an answer
            logger.exception("an order of the page failed")
            sentence, done = f"The order failed, a fault of nao-hil: {error!r}.", False
        browser.put(Message(json.dumps({"answer": sentence, "done": done, "urgent": urgent}), kept=True))

    def _file(self, path: str) -> Answer:
        if path in ("/", "/index.html"):
            return self._page
        try:
            found = self._files(path)
        except (NaoHilError, OSError) as error:
            return Answer(HTTPStatus.NOT_FOUND, f"{error}\n".encode())
        return found or Answer(HTTPStatus.NOT_FOUND, b"There is nothing here; the page is at /.\n")


def door(access: Access, file: Callable[[str], Answer]) -> Callable[[Any, Any], Any]:
    """Gives the response to a request; None: the WebSocket opens."""

    def check(_: Any, request: Any) -> Any:
        """Refuse a request from elsewhere, or answer it with a file; None: a WebSocket may open."""

        def only(name: str) -> str:
            values = request.headers.get_all(name)
            return values[0] if len(values) == 1 else ""

        asked = Asked(request.path, only("Host"), only("Origin"), only("Cookie"), only("Upgrade"))
        answer = access.check(asked)
        if answer is None and asked.target == HOST_PATH:
            answer = Answer(HTTPStatus.OK, asked.host.encode(errors="replace"))
        if answer is None and asked.upgrade:
            return None
        return _response(answer or file(urlsplit(asked.target).path))

    return check


def _response(answer: Answer) -> Any:
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    first = (("Content-Type", "text/plain; charset=utf-8"), ("Content-Security-Policy", POLICY))
    headers = dict([*first, *HEADERS, *answer.headers])
    headers["Content-Length"] = str(len(answer.body))
    return Response(answer.status.value, answer.status.phrase, Headers(headers), answer.body)
