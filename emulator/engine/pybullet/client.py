"""Import of PyBullet, and its clients."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator

from bridge.errors import LinkError


@contextlib.contextmanager
def _silent() -> Iterator[None]:
    """Suppress output of compiled code on the standard streams: PyBullet prints its build time."""
    kept: dict[int, int] = {}
    for descriptor in (1, 2):
        with contextlib.suppress(OSError):  # closed by the parent
            kept[descriptor] = os.dup(descriptor)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        for descriptor in kept:
            os.dup2(nowhere, descriptor)
        yield
    finally:
        for descriptor, copy in kept.items():
            os.dup2(copy, descriptor)
            os.close(copy)
        os.close(nowhere)


with _silent():
    import pybullet as bullet

__all__ = ["bullet", "connect", "disconnect"]


def connect() -> int:
    """A physics client of its own, without a window.

    Raises:
        LinkError: PyBullet has no client left (it allows about a thousand per process).
    """
    client = int(bullet.connect(bullet.DIRECT))
    if client < 0:
        raise LinkError("PyBullet gave no physics client; close robots that are no longer needed.")
    return client


def disconnect(client: int) -> None:
    """Free a client; no effect on one that is freed already."""
    if bullet.isConnected(client):
        bullet.disconnect(client)
