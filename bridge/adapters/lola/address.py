"""Address of LoLA's socket: a unix socket on this machine, or host and port of its relay."""

from __future__ import annotations

import contextlib
import os
import socket
import stat
from dataclasses import dataclass, replace

from bridge.errors import ConfigurationError, LinkError


@dataclass(frozen=True, slots=True)
class Address:
    """A place to listen or connect: a unix socket's path, or a host and a port."""

    path: str = ""
    host: str = ""
    port: int = 0

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return self.path or f"{host}:{self.port}"

    def of(self, number: int, robot: str) -> Address:
        """That of one of several robots: `PATH-ROBOT`, or the port after so many others."""
        if self.path:
            return replace(self, path=f"{self.path}-{robot}")
        return replace(self, port=self.port + number)


def parse_address(text: str, *, path: bool = True) -> Address:
    """An address from `PATH` or `HOST:PORT`.

    Args:
        text: as a user writes it.
        path: a path is allowed.

    Raises:
        ConfigurationError: neither.
    """
    host, _, port = text.rpartition(":")
    if "/" in text and path:
        return Address(path=text)
    if "/" not in host and host and port.isdecimal() and 0 < int(port) < 65536:
        return Address(host=host.strip("[]"), port=int(port))
    paths = "a path with a `/`, as in /tmp/robocup, or " if path else ""
    raise ConfigurationError(f"Address {text!r} must be {paths}HOST:PORT, as in 192.168.1.7:10000.")


def listen(address: Address) -> socket.socket:
    """A listening socket; it replaces a dead server's at the path.

    Raises:
        LinkError: it has a listener already, something else is there, or the system does not allow it.
    """
    try:
        return _listen_unix(address) if address.path else _listen_tcp(address)
    except OSError as error:
        raise LinkError(f"Cannot listen on {address}: {error.strerror or error}.") from None


def _listen_unix(address: Address) -> socket.socket:
    with contextlib.suppress(FileNotFoundError):
        if not stat.S_ISSOCK(os.stat(address.path).st_mode):
            raise LinkError(
                f"Cannot listen on {address}: a file is there that is no socket; name another path."
            )
        with socket.socket(socket.AF_UNIX) as probe, contextlib.suppress(ConnectionRefusedError):
            probe.connect(address.path)
            raise LinkError(f"Cannot listen on {address}: another server does; stop it, or name another path.")
    listener = socket.socket(socket.AF_UNIX)
    ready = f"{address.path}.{os.getpid()}"
    try:
        listener.bind(ready)
        listener.listen()
        os.rename(ready, address.path)  # a client that sees the path can connect
    except OSError:
        listener.close()
        with contextlib.suppress(OSError):
            os.unlink(ready)
        raise
    return listener


def _listen_tcp(address: Address) -> socket.socket:
    family = socket.AF_INET6 if ":" in address.host else socket.AF_INET
    return socket.create_server((address.host, address.port), family=family)


def remove(address: Address) -> None:
    """Remove the path of a unix socket."""
    if address.path:
        with contextlib.suppress(FileNotFoundError):
            os.unlink(address.path)


def connect(address: Address, timeout: float) -> socket.socket:
    """A connection without delay of small packets.

    Args:
        timeout: s for the attempt; the connection itself then blocks for ever.

    Raises:
        OSError: no listener there.
    """
    if address.path:
        peer = socket.socket(socket.AF_UNIX)
        try:
            peer.settimeout(timeout)
            peer.connect(address.path)
        except BaseException:
            peer.close()
            raise
    else:
        peer = socket.create_connection((address.host, address.port), timeout=timeout)
    peer.settimeout(None)
    send_at_once(peer)
    return peer


def send_at_once(peer: socket.socket) -> None:
    """Switch off Nagle's algorithm, which delays small packets by up to 40 ms."""
    if peer.family != socket.AF_UNIX:
        peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
