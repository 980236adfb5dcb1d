"""The cameras of an emulated robot, drawn by a process of their own.

Messages, over a pipe: to it `[number, camera, width, height, colour space, file]`; from it `[number, true,
[time, bytes]]` or `[number, false, sentence]`, and `[0, sights]`. A sight is `[camera, kind, name, place,
diameter, head]`: the place in the camera's frame (x along its axis, y left, z up), m, and the angles of HeadYaw
and HeadPitch then, rad.
"""

from __future__ import annotations

import contextlib
import os
import socket
import struct
import subprocess
import sys
import threading
from collections.abc import Sequence
from concurrent.futures import Future
from typing import Any, Final

import msgspec

from bridge.errors import NaoqiRefused

_LENGTH_PREFIX: Final = struct.Struct("!I")
MAX_MESSAGE: Final = 1 << 24
"""bytes"""


class Unsendable(Exception):
    """A message that the other end cannot read; one sentence."""


class Pipe:
    """One end; any thread may send, one receives."""

    def __init__(self, end: socket.socket) -> None:
        self._socket = end
        self._stream = end.makefile("rb")
        self._lock = threading.Lock()
        self._encoder = msgspec.msgpack.Encoder()
        self._decoder = msgspec.msgpack.Decoder()

    def send(self, message: list[Any]) -> None:
        """Send one message; without the other end do nothing.

        Raises:
            Unsendable: something in it is no number, text, list or map, or it is too large or too deep.
        """
        try:
            payload = self._encoder.encode(message)
        except (TypeError, ValueError, OverflowError, RecursionError) as error:
            raise Unsendable(f"{error}") from None
        if len(payload) > MAX_MESSAGE:
            raise Unsendable(f"{len(payload)} bytes are more than {MAX_MESSAGE}")
        with self._lock:
            try:
                self._socket.sendall(_LENGTH_PREFIX.pack(len(payload)) + payload)
            except OSError:
                return

    def receive(self) -> list[Any] | None:
        """The next readable message; None without the other end."""
        while True:
            payload = self._payload()
            if payload is None:
                return None
            try:
                message: list[Any] = self._decoder.decode(payload)
            except (msgspec.DecodeError, ValueError, RecursionError):
                continue  # not in UTF-8, or a level deeper than fits on the stack of this end
            return message

    def _payload(self) -> bytes | None:
        try:
            head = self._stream.read(_LENGTH_PREFIX.size)
            if len(head) < _LENGTH_PREFIX.size:
                return None
            (length,) = _LENGTH_PREFIX.unpack(head)
            payload = self._stream.read(length) if length <= MAX_MESSAGE else b""
        except (OSError, ValueError):  # ValueError: this end is closed
            return None
        return payload if len(payload) == length else None

    def close(self) -> None:
        """Close this end; a `receive` in another thread ends."""
        with contextlib.suppress(OSError):
            self._socket.shutdown(socket.SHUT_RDWR)
        self._socket.close()


CAMERAS: Final = ("CameraTop", "CameraBottom")
"""By NAOqi's number."""
NO_CAMERAS_REASON: Final = "only an emulated robot has cameras here; this one's are read on the robot itself"
_END_TIMEOUT: Final = 3.0
"""s that the process may take to end."""


class CameraFeed:
    """Pictures of a robot's cameras; here of one without cameras."""

    def picture(self, camera: int, width: int, height: int, space: int, file: str = "") -> Future[Any]:
        """A picture of now: `[time in s since 1970, bytes]`.

        Args:
            camera: 0 top, 1 bottom.
            space: NAOqi's number of the colour space.
            file: `bmp`, `jpeg`, `png`, `ppm` or `tiff`: the bytes are a file; empty: they are pixels.

        Raises:
            NaoqiRefused: there are no cameras.
        """
        raise NaoqiRefused(f"ALVideoDevice: {NO_CAMERAS_REASON}.")

    def sights(self) -> Sequence[Sequence[Any]]:
        """Things in the cameras' newest views, which may be some cycles old."""
        return ()


class DrawnCameraFeed(CameraFeed):
    """Feed of an emulated robot, by a drawing process, idle until the first call; thread-safe, close it."""

    def __init__(self, robot: str, endpoint: str) -> None:
        self._command = [sys.executable, "-m", "emulator.camera", robot, endpoint]
        self._lock = threading.Lock()
        self._pipe: Pipe | None = None
        self._process: subprocess.Popen[bytes] | None = None
        self._number = 0
        self._waiting: dict[int, Future[Any]] = {}
        self._sights: Sequence[Sequence[Any]] = ()
        self._watching = False
        """Whether the process reports sights."""

    def start(self) -> None:
        """Start the process, which takes some seconds on a busy machine."""
        with self._lock:
            self._started()

    def picture(self, camera: int, width: int, height: int, space: int, file: str = "") -> Future[Any]:
        """As `CameraFeed`."""
        done: Future[Any] = Future()
        with self._lock:
            pipe = self._started()
            self._number += 1
            number = self._number
            self._waiting[number] = done
        pipe.send([number, camera, width, height, space, file])
        return done

    def sights(self) -> Sequence[Sequence[Any]]:
        """As `CameraFeed`."""
        with self._lock:
            pipe, watching, self._watching = self._started(), self._watching, True
        if not watching:
            pipe.send([0])
        return self._sights

    def _started(self) -> Pipe:
        if self._pipe is None:
            ours, theirs = socket.socketpair()
            self._process = subprocess.Popen(
                [*self._command, str(theirs.fileno())],
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
                start_new_session=True,
            )
            theirs.close()
            self._pipe = Pipe(ours)
            threading.Thread(target=self._read, args=(self._pipe,), name="cameras", daemon=True).start()
        return self._pipe

    def _read(self, pipe: Pipe) -> None:
        reason = "The process that draws the cameras' pictures has ended; ask again."
        while (message := pipe.receive()) is not None:
            number, second, *rest = message
            if number == 0:
                self._sights = second
            elif number < 0:
                reason = rest[0]
            else:
                with self._lock:
                    done = self._waiting.pop(number)
                if second:
                    done.set_result(rest[0])
                else:
                    done.set_exception(NaoqiRefused(rest[0]))
        with self._lock:
            waiting, self._waiting, self._pipe, self._sights = self._waiting, {}, None, ()
            self._watching = False
        for done in waiting.values():
            done.set_exception(NaoqiRefused(reason))

    def close(self) -> None:
        """End the process."""
        with self._lock:
            pipe, process = self._pipe, self._process
        if pipe is not None and process is not None:
            pipe.close()
            try:
                process.wait(_END_TIMEOUT)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
