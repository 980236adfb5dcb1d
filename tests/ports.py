"""Ports and endpoints of this machine that a test has to itself until its process ends.

They lie below the ports that the system gives to outgoing connections. An abstract Unix socket reserves each:
no test beside this one, of this run or of another, is given the same.
"""

from __future__ import annotations

import random
import socket
from pathlib import Path
from typing import Final

LOWEST: Final = 10_240
EPHEMERAL: Final = int(Path("/proc/sys/net/ipv4/ip_local_port_range").read_text().split()[0])
_CHOICE: Final = random.SystemRandom()
_reserved: Final[list[socket.socket]] = []


def free_port(count: int = 1) -> int:
    """The first of so many free TCP ports of loopback in a row, which no other test is given."""
    for _ in range(1000):
        port = _CHOICE.randrange(LOWEST, EPHEMERAL - count)
        if all(_reserve(each) for each in range(port, port + count)):
            return port
    raise AssertionError("no port of this machine is free")


def _reserve(port: int) -> bool:
    reservation = socket.socket(socket.AF_UNIX)
    try:
        reservation.bind(f"\0nao-hil-test-port-{port}")
        with socket.create_server(("127.0.0.1", port)):
            pass
    except OSError:
        reservation.close()
        return False
    _reserved.append(reservation)
    return True


def free_endpoint() -> str:
    """A Zenoh endpoint at such a port."""
    return f"tcp/127.0.0.1:{free_port()}"
