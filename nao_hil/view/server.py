"""The page's server: viser, behind our own check of who asks, with our own script in its page."""

from __future__ import annotations

import contextlib
import io
import logging
import os
import re
import socket
import ssl
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Final

from bridge.errors import ConfigurationError, LinkError
from nao_hil.view.access import Access, Answer, Asked

DEFAULT_HOST = "127.0.0.1"
DEFAULT_PORT = 8080
HEADERS: Final = (
    ("Cache-Control", "no-store"),
    ("Referrer-Policy", "no-referrer"),
    ("X-Content-Type-Options", "nosniff"),
    (
        "Content-Security-Policy",
        "default-src 'self' 'unsafe-inline' 'unsafe-eval' blob: data:; frame-ancestors 'none'",
    ),
)
"""The page asks no other site, and no other site shows it in a frame."""


def open_server(
    host: str, port: int, label: str, access: Access | None = None, tls: ssl.SSLContext | None = None
) -> Any:
    """A `viser.ViserServer`; its page loads nothing from beyond this machine.

    Args:
        host: Address to listen on.
        port: TCP port.
        label: Headline of the page.
        access: Who may open it; None: this machine's own browsers.
        tls: Serve it over TLS.

    Raises:
        ConfigurationError: viser is not installed, or too old.
        LinkError: the place cannot be listened on.
    """
    try:
        import viser
    except ModuleNotFoundError as error:
        if error.name != "viser":
            raise
        raise ConfigurationError(
            "The page needs viser, which is not installed: pip install 'nao-hil[view]'."
        ) from None
    _check_free(host, port)
    # viser announces itself on stdout, which belongs to `--json`.
    with _owndoor(access or Access(), _page(label), tls), contextlib.redirect_stdout(io.StringIO()):
        server = viser.ViserServer(host=host, port=port, label=label, verbose=False)
    # What a browser can ask for: a tunnel from viser's own site on the internet to this page.
    server.request_share_url = lambda *_, **__: None
    return server


def _check_free(host: str, port: int) -> None:
    """Say so where the server would take the next free port without a word."""
    try:
        with socket.create_server((host, port)):
            pass
    except (OSError, OverflowError) as error:
        reason = os.strerror(error.errno) if isinstance(error, OSError) and error.errno else str(error)
        raise LinkError(
            f"The page cannot be served at {host}:{port} ({reason}); give another --port."
        ) from None


@contextlib.contextmanager
def _owndoor(access: Access, page: str, tls: ssl.SSLContext | None) -> Iterator[None]:
    """While the server opens: its connections are checked, its only file is `page`, and it logs no probe."""
    from websockets.asyncio import server

    original: Callable[..., Any] = server.serve
    silent = logging.getLogger("nao_hil.view.connections")
    silent.setLevel(logging.CRITICAL)

    def serve(*arguments: Any, **options: Any) -> Any:
        own = {"process_request": door(access, page), "ssl": tls, "logger": silent}
        return original(*arguments, **(options | own))

    server.serve = serve  # type: ignore[misc, assignment]
    try:
        yield
    finally:
        server.serve = original  # type: ignore[misc, assignment]


def door(access: Access, page: str) -> Callable[[Any, Any], Any]:
    """What websockets asks about each request."""
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    def response(answer: Answer) -> Response:
        body = answer.text.encode()
        headers = dict([("Content-Type", "text/plain; charset=utf-8"), *HEADERS, *answer.headers])
        headers["Content-Length"] = str(len(body))
        return Response(answer.status.value, answer.status.phrase, Headers(headers), body)

    def check(_: Any, request: Any) -> Response | None:
        """The refusal of a request; None: it may pass."""

        def only(name: str) -> str:
            values = request.headers.get_all(name)
            return values[0] if len(values) == 1 else ""

        asked = Asked(request.path, only("Host"), only("Origin"), only("Cookie"), only("Upgrade"))
        answer = access.check(asked, page)
        return None if answer is None else response(answer)

    return check


def _page(title: str) -> str:
    """The page of viser with our title and script."""
    import viser

    file = Path(viser.__file__).with_name("client") / "build" / "index.html"
    text = file.read_text(encoding="utf-8")
    script = Path(__file__).with_name("page.js").read_text(encoding="utf-8")
    head = f"<title>{title}</title>\n<script>\n{script}</script>"
    return re.sub(r"<title>.*?</title>", lambda _: head, text, count=1)
