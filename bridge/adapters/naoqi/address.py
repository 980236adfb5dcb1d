"""Where a qi service listens."""

from __future__ import annotations

import re
import socket
from typing import Final

from bridge.errors import ConfigurationError, LinkError

DEFAULT_URL: Final = "tcp://127.0.0.1:9559"
_URL: Final = re.compile(r"tcp://(\d+\.\d+\.\d+\.\d+|localhost|[A-Za-z0-9.-]+):(\d{1,5})")


def check_url(url: str) -> tuple[str, int]:
    """Host and port of a qi address.

    Raises:
        ConfigurationError: not `tcp://HOST:PORT`.
    """
    found = _URL.fullmatch(url)
    if found is None or not 0 < int(found[2]) < 65536:
        raise ConfigurationError(f"Address {url!r} must look like tcp://127.0.0.1:9559.")
    return found[1], int(found[2])


def require_free(url: str) -> None:
    """See that nobody listens there: qi itself would abort the whole process.

    Raises:
        ConfigurationError: not an address.
        LinkError: it cannot be listened on.
    """
    host, port = check_url(url)
    try:
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind((host, port))
            probe.listen(1)
    except OSError as error:
        raise LinkError(
            f"Cannot listen on {url}: {(error.strerror or str(error)).lower()}; stop what is there, or take "
            "another port with --listen."
        ) from None
