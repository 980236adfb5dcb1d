"""A relay between a client and a robot that can be cut and delayed, in threads of the driver's process."""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from types import TracebackType


class Relay:
    """Passes TCP on to a port of this machine; a context manager.

    Args:
        port: of the robot, on loopback.
    """

    def __init__(self, port: int) -> None:
        self._port = port
        self._listener = socket.create_server(("127.0.0.1", 0))
        self._open: set[socket.socket] = set()
        self.port: int = self._listener.getsockname()[1]
        self.delay = 0.0
        """s by which every piece is late."""
        self.cut = False
        """Connections are broken off and refused."""
        threading.Thread(target=self._accept, daemon=True).start()

    def break_off(self) -> None:
        """End all connections, and refuse others until `cut` is false again."""
        self.cut = True
        for each in list(self._open):
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)

    def _accept(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                client, _ = self._listener.accept()
                if self.cut:
                    client.close()
                    continue
                try:
                    robot = socket.create_connection(("127.0.0.1", self._port), timeout=5.0)
                except OSError:
                    client.close()
                    continue
                robot.settimeout(None)
                self._open |= {client, robot}
                for source, sink in ((client, robot), (robot, client)):
                    threading.Thread(target=self._copy, args=(source, sink), daemon=True).start()

    def _copy(self, source: socket.socket, sink: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while data := source.recv(65536):
                if self.delay:
                    time.sleep(self.delay)
                sink.sendall(data)
        for each in (source, sink):
            with contextlib.suppress(OSError):
                each.shutdown(socket.SHUT_RDWR)
        self._open -= {source, sink}
        source.close()

    def __enter__(self) -> Relay:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.break_off()
        self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()
