"""The package qi, and addresses of its services."""

from __future__ import annotations

import importlib.util
import os
import platform
import re
import socket
import sys
from typing import Any, Final

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
    """Check that the address is free; qi itself would abort the process.

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
            f"Cannot listen on {url}: {(error.strerror or str(error)).lower()}; stop its listener, or take "
            "another port with --listen."
        ) from None


NEWEST_PYTHON: Final = (3, 12)
"""With a package of qi."""


def require_qi() -> None:
    """Check that qi is installed.

    Raises:
        LinkError: it is not; names the remedy.
    """
    if importlib.util.find_spec("qi") is not None:
        return
    here = f"Python {platform.python_version()} on {platform.system()} {platform.machine()}"
    available = (
        sys.version_info[:2] <= NEWEST_PYTHON and sys.platform == "linux" and platform.machine() == "x86_64"
    )
    remedy = (
        "pip install 'nao-hil[naoqi]'"
        if available
        else "it has packages for Python 3.8 to 3.12 on Linux x86-64 only, run it there"
    )
    raise LinkError(f"the package qi is not installed for {here}; {remedy}.")


def load_qi() -> Any:
    """The module `qi`, without its warning of a missing application.

    The warning would be on the standard output, among the results of a command.

    Raises:
        ImportError: it is not installed.
    """
    os.environ.setdefault("QI_LOG_FILTERS", "qi.path.sdklayout=error")
    import qi

    return qi
