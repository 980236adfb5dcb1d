"""ALPhotoCapture and ALVideoRecorder: names, returns and files by the vendor's pages."""

from __future__ import annotations

import socket
import struct
from concurrent.futures import Future
from pathlib import Path
from typing import Any

import pytest

from bridge.adapters.naoqi.core.cameras import MAX_MESSAGE, CameraFeed, Pipe, Unsendable
from bridge.adapters.naoqi.interaction.photos import avi
from bridge.errors import NaoqiRefused
from tests.bridge.adapters.naoqi.served import Robot


class Painter(CameraFeed):
    """Cameras that draw at once: the bytes of a picture say what was asked for."""

    def __init__(self) -> None:
        self.asked: list[tuple[Any, ...]] = []

    def picture(self, *asked: Any) -> Future[Any]:
        self.asked.append(asked)
        done: Future[Any] = Future()
        done.set_result([1.0, repr(asked).encode()])
        return done


@pytest.fixture
def robot(tmp_path: Path) -> Robot:
    return Robot(feed=Painter(), home=tmp_path)


def test_a_picture_is_the_file_that_is_named(robot: Robot, tmp_path: Path) -> None:
    robot.call("ALPhotoCapture", "setCameraID", 1)
    robot.call("ALPhotoCapture", "setResolution", 2)
    robot.call("ALPhotoCapture", "setColorSpace", 0)
    robot.call("ALPhotoCapture", "setPictureFormat", "png")
    file = tmp_path / "one.png"
    assert robot.wait(robot.call("ALPhotoCapture", "takePicture", "/home/nao", "one")) == [str(file)]
    assert file.read_text() == "(1, 640, 480, 0, 'png')"
    with pytest.raises(NaoqiRefused, match="already"):
        robot.call("ALPhotoCapture", "takePicture", "/home/nao", "one", False)
    robot.wait(robot.call("ALPhotoCapture", "takePicture", "/home/nao/", "one.png"))


def chunks(data: bytes) -> list[tuple[bytes, bytes]]:
    """Names and contents of the chunks of a RIFF file; each begins at an even place."""
    if not data:
        return []
    name, size = struct.unpack("<4sI", data[:8])
    return [(name, data[8 : 8 + size]), *chunks(data[8 + size + size % 2 :])]


def test_a_film_is_an_avi_file_with_its_pictures_and_an_index() -> None:
    """Microsoft's AVI RIFF reference: places in `idx1` count from the list's type `movi`."""
    pictures = [b"one", b"two!", b"three"]
    ((riff, content),) = chunks(avi(pictures, (320, 240), 10))
    assert (riff, content[:4]) == (b"RIFF", b"AVI ")
    (_, head), (_, movi), (_, index) = chunks(content[4:])
    main, stream = chunks(head[4:])
    assert struct.unpack("<14I", main[1])[:1] == (100_000,)
    assert struct.unpack("<14I", main[1])[4] == 3 and struct.unpack("<14I", main[1])[8:10] == (320, 240)
    (strh, header), (strf, form) = chunks(stream[1][4:])
    assert (strh, header[:8], len(header)) == (b"strh", b"vidsMJPG", 56)
    assert (strf, form[16:20], struct.unpack("<Iii", form[:12])) == (b"strf", b"MJPG", (40, 320, 240))
    assert chunks(movi[4:]) == [(b"00dc", picture) for picture in pictures]
    for i, picture in enumerate(pictures):
        _, flags, place, size = struct.unpack("<4sIII", index[16 * i : 16 * i + 16])
        assert flags == 0x10 and movi[place + 8 : place + 8 + size] == picture


def nested(depth: int) -> list[object]:
    value: list[object] = []
    for _ in range(depth):
        value = [value]
    return value


@pytest.mark.parametrize("argument", ["x" * MAX_MESSAGE, nested(100_000), object(), 1 << 70])
def test_what_cannot_be_read_is_not_sent_and_the_next_message_arrives(argument: object) -> None:
    ours, theirs = socket.socketpair()
    here, there = Pipe(ours), Pipe(theirs)
    with pytest.raises(Unsendable):
        here.send([1, "ALMemory", "insertData", ["key", argument]])
    here.send([2, "ALMemory", "ping", []])
    assert there.receive() == [2, "ALMemory", "ping", []]
    here.close()
    assert there.receive() is None
    there.close()


def test_a_message_that_is_none_is_passed_over() -> None:
    ours, theirs = socket.socketpair()
    here, there = Pipe(ours), Pipe(theirs)
    for payload in (b"\xc1", b"\xa1\xff", b"\x91" * 100_000):
        ours.sendall(struct.pack("!I", len(payload)) + payload)
    here.send([3])
    assert there.receive() == [3]
    here.close()
    there.close()
