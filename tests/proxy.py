"""A reverse proxy that puts a server of this machine under a path, as nginx does with `location /PREFIX/`."""

from __future__ import annotations

import contextlib
import re
import socket
import threading
from collections.abc import Iterator


def _copy(source: socket.socket, sink: socket.socket) -> None:
    with contextlib.suppress(OSError):
        while data := source.recv(65536):
            sink.sendall(data)
    for end in (source, sink):
        with contextlib.suppress(OSError):
            end.shutdown(socket.SHUT_RDWR)


def _serve(client: socket.socket, prefix: str, port: int, host: str) -> None:
    """One connection; a request whose path is not under the prefix is not found, as in nginx."""
    with client:
        head = b""
        while b"\r\n\r\n" not in head and len(head) < 65536 and (data := client.recv(65536)):
            head += data
        if host:
            head = re.sub(rb"(?mi)^Host: .*?\r$", f"Host: {host}\r".encode(), head)
        method, target, rest = head.split(b" ", 2)
        if not target.startswith(prefix.encode()):
            client.sendall(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n")
            return
        with socket.create_connection(("127.0.0.1", port)) as server:
            server.sendall(b" ".join((method, b"/" + target[len(prefix) :], rest)))
            back = threading.Thread(target=_copy, args=(server, client), daemon=True)
            back.start()
            _copy(client, server)
            back.join()


@contextlib.contextmanager
def proxy(prefix: str, port: int, host: str = "") -> Iterator[str]:
    """The address at which a server appears meanwhile.

    Args:
        prefix: of every path, for example `/nao/`.
        port: of the server, on loopback.
        host: header `Host` in place of the browser's; empty: passed on.
    """
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def accept() -> None:
            with contextlib.suppress(OSError):
                while True:
                    client, _ = listener.accept()
                    threading.Thread(target=_serve, args=(client, prefix, port, host), daemon=True).start()

        thread = threading.Thread(target=accept, daemon=True)
        thread.start()
        yield f"http://127.0.0.1:{listener.getsockname()[1]}{prefix}"
        listener.shutdown(socket.SHUT_RDWR)
        thread.join()
