"""The page's server: viser, on this machine only, without the parts of its page that ask the internet."""

from __future__ import annotations

import contextlib
import io
import os
import re
import socket
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

from bridge.errors import ConfigurationError, LinkError

DEFAULT_HOST = "127.0.0.1"
DEFAULT_PORT = 8080


class _Folder(type(Path())):  # type: ignore[misc]
    """A folder that a path of a request cannot leave, with a page of our own in place of its index."""

    index: Path

    def __truediv__(self, name: Any) -> Any:
        root = Path(self).resolve()
        if str(name) == "index.html":
            return self.index
        asked = (root / str(name)).resolve()
        return asked if asked.is_file() and asked.is_relative_to(root) else root / "no-such-file"


HIDDEN: Final = "button:has(.tabler-icon-share) { display: none }"
"""The button that shares the page on the internet; hidden by viser itself it breaks the page on a phone."""


def open_server(host: str, port: int, label: str) -> Any:
    """A `viser.ViserServer`; its page loads nothing from beyond this machine.

    Args:
        host: Address to listen on.
        port: TCP port.
        label: Headline of the page.

    Raises:
        ConfigurationError: viser is not installed.
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
    with _own_page(label), contextlib.redirect_stdout(io.StringIO()):
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
def _own_page(title: str) -> Iterator[None]:
    """While the server opens: its files come from a folder that cannot be left, and its index asks nobody.

    viser's index loads a visitor counter from the internet, and its server hands out any file of the machine
    to who asks for a path with enough `..` in it.
    """
    from viser import infra

    original = infra.WebsockServer

    def with_folder(*arguments: Any, **options: Any) -> Any:
        folder = _Folder(options["http_server_root"])
        text = (Path(options["http_server_root"]) / "index.html").read_text(encoding="utf-8")
        folder.index = _index(text, title)
        return original(*arguments, **(options | {"http_server_root": folder}))

    infra.WebsockServer = with_folder
    try:
        yield
    finally:
        infra.WebsockServer = original


def _index(text: str, title: str) -> Path:
    """The page without the scripts that ask the internet, with our own; in a file."""
    text = re.sub(r"<!--.*?-->", "", text, flags=re.DOTALL)
    text = re.sub(r"<script(?![^>]*type=\"module\").*?</script>", "", text, flags=re.DOTALL)
    script = Path(__file__).with_name("page.js").read_text(encoding="utf-8")
    head = f"<title>{title}</title>\n<style>{HIDDEN}</style>\n<script>\n{script}</script>"
    text = re.sub(r"<title>.*?</title>", lambda _: head, text)
    folder = Path(tempfile.mkdtemp(prefix="nao-hil-page-"))
    (folder / "index.html").write_text(text, encoding="utf-8")
    return folder / "index.html"
