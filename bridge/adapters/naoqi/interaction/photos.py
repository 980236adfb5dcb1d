"""ALPhotoCapture and ALVideoRecorder: pictures of the cameras as files (vendor's pages on both)."""

from __future__ import annotations

import os
import struct
from collections.abc import Sequence
from concurrent.futures import Future
from pathlib import Path
from typing import Annotated, Any, Final

from bridge.adapters.naoqi.core.motion_tasks import MotionTask
from bridge.adapters.naoqi.core.served import ServedRobot, Service
from bridge.adapters.naoqi.core.video import RESOLUTIONS
from bridge.adapters.naoqi.declared import OneOf, Range, Setting, offers
from bridge.adapters.naoqi.robot_files import in_thread
from bridge.errors import NaoqiRefused

FORMATS: Final = {
    **dict.fromkeys(("bmp", "dib"), "bmp"),
    **dict.fromkeys(("jpeg", "jpg", "jpe"), "jpeg"),
    **dict.fromkeys(("pbm", "pgm", "ppm"), "ppm"),
    **dict.fromkeys(("tiff", "tif"), "tiff"),
    "png": "png",
}
"""Extension of a file -> its kind."""
GREY, COLOUR = 0, 13
"""Colour spaces of files."""
MAX_PICTURES: Final = 9000
"""Most pictures of a call or a film."""


class _Pictures(Service):
    """Settings of pictures; the initial values are assumed."""

    camera = Setting(".CameraID", 0, Annotated[int, OneOf("camera", (0, 1))])
    resolution = Setting(".Resolution", 1, Annotated[int, OneOf("resolution", (0, 1, 2))])
    space = Setting(".ColorSpace", COLOUR, Annotated[int, OneOf("colour space", (GREY, COLOUR))])

    @property
    def size(self) -> tuple[int, int]:
        """Columns and rows."""
        width = RESOLUTIONS[self.resolution]
        return width, 3 * width // 4

    def file(self, folder: str, name: str, overwrite: bool, method: str) -> Path:
        """Path of a file to write; creates its folder below the robot's home."""
        where = f"{self.service}.{method}"
        path = self.files.new_file(f"{folder}/{name}")
        if os.path.exists(path) and not overwrite:
            raise NaoqiRefused(f"{where}: {path} is there already; another name or overwrite is expected.")
        return path


class PhotoCapture(_Pictures):
    """Methods of `ALPhotoCapture`."""

    service = "ALPhotoCapture"
    form = Setting("ALPhotoCapture.PictureFormat", "jpg", Annotated[str, OneOf("format", FORMATS)])
    interval = Setting("ALPhotoCapture.CaptureInterval", 200, Annotated[int, Range(0, 3.6e6, "ms")])
    half = Setting("ALPhotoCapture.HalfPressEnabled", False, bool, inert=True, reader="is", returns=True)

    @offers("ALPhotoCapture.takePicture")
    def _take(self, folder: str, name: str, overwrite: bool = True) -> Future[Any]:
        path = self.file(folder, f"{_bare(name, self.form)}.{self.form}", overwrite, "takePicture")
        return self._written(path, [str(path)])

    @offers("ALPhotoCapture.takePictures")
    def _take_some(
        self, count: Annotated[float, Range(1, MAX_PICTURES)], folder: str, name: str, overwrite: bool = True
    ) -> Future[Any]:
        series = round(count)
        bare, names = _bare(name, self.form), list[str]()

        def task() -> MotionTask:
            """Take one picture after the other at the interval."""
            for i in range(series):
                begun, file = self._now(), f"{bare}_{i}.{self.form}"
                path = self.file(folder, file, overwrite, "takePictures")
                done = self._written(path, None)
                while not done.done() or (i < series - 1 and self._now() - begun < self.interval):
                    yield self._now() + 1
                done.result()
                names.append(str(path))
            return [names]

        return self._others.begin(task())

    def _written(self, path: Path, result: Any) -> Future[Any]:
        """Take a picture and write it to a file; the result after the writing."""
        written: Future[Any] = Future()

        def write(taken: Future[Any]) -> None:
            """In the thread of the cameras."""
            error = taken.exception()
            if error is not None:
                written.set_exception(error)
                return
            try:
                path.write_bytes(taken.result()[1])
            except OSError as failure:
                written.set_exception(_unwritten("takePicture", path, failure))
            else:
                written.set_result(result)

        taken = self._robot.feed.picture(self.camera, *self.size, self.space, FORMATS[self.form])
        taken.add_done_callback(write)
        return written

    @offers("ALPhotoCapture.halfPress")
    def _half_press(self) -> bool:
        self.half = not self.half
        return True

    _is_half_pressed = offers("ALPhotoCapture.isHalfPressed")(lambda self: self.half)


class VideoRecorder(_Pictures):
    """Methods of `ALVideoRecorder`."""

    service = "ALVideoRecorder"

    def __init__(self, robot: ServedRobot) -> None:
        super().__init__(robot)
        self._rate = 15
        self._path: Path | None = None
        self._taken: list[Future[Any]] = []

    @offers("ALVideoRecorder.startRecording")
    def _start(self, folder: str, name: str, overwrite: bool = True) -> None:
        if self._path is not None:
            raise NaoqiRefused(f"ALVideoRecorder: {self._path} is being recorded; stop that first.")
        path = self.file(folder, f"{_bare(name, 'avi')}.avi", overwrite, "startRecording")
        self._taken = [self._shot()]
        self._path = path
        self._others.begin(self._recording(path, self._rate))

    def _shot(self) -> Future[Any]:
        return self._robot.feed.picture(self.camera, *self.size, self.space, "jpeg")

    def _recording(self, path: Path, rate: int) -> MotionTask:
        begun, taken = self._now(), self._taken
        while self._path is path and len(taken) < MAX_PICTURES:
            yield begun + round(1000.0 * len(taken) / rate)
            if self._path is path and taken[-1].done():
                taken.append(self._shot())
            elif self._path is path:
                taken.append(taken[-1])  # the drawing is late: repeat the picture

    @offers("ALVideoRecorder.stopRecording")
    def _stop(self) -> Future[Any]:
        path, self._path = self._path, None
        if path is None:
            raise NaoqiRefused(
                "ALVideoRecorder.stopRecording: nothing is being recorded; startRecording begins."
            )
        taken, size, rate = list(self._taken), self.size, self._rate
        return in_thread(lambda: _write_film(path, taken, size, rate))

    @offers("ALVideoRecorder.setVideoFormat")
    def _set_format(self, form: Any) -> None:
        if form != "MJPG":
            raise NaoqiRefused(f"ALVideoRecorder.setVideoFormat: {form!r:.40} is not written; MJPG is.")

    @offers("ALVideoRecorder.setFrameRate")
    def _set_rate(self, rate: Annotated[float, Range(3, 30)]) -> None:
        if self._path is not None:
            raise NaoqiRefused("ALVideoRecorder.setFrameRate: a recording runs; stop that first.")
        self._rate = round(rate)

    _is_recording = offers("ALVideoRecorder.isRecording")(lambda self: self._path is not None)
    _get_frame_rate = offers("ALVideoRecorder.getFrameRate")(lambda self: self._rate)


def _bare(name: str, extension: str) -> str:
    """A file's name without the extension."""
    return name.removesuffix(f".{extension}")


def _unwritten(method: str, path: Path, error: OSError) -> NaoqiRefused:
    return NaoqiRefused(f"{method}: {path} cannot be written ({error.strerror}).")


def _write_film(path: Path, taken: Sequence[Future[Any]], size: tuple[int, int], rate: int) -> list[Any]:
    """Write a film after its last picture; `[pictures, path]`."""
    pictures = [one.result(_PICTURE_TIMEOUT)[1] for one in taken]
    try:
        path.write_bytes(avi(pictures, size, rate))
    except OSError as error:
        raise _unwritten("stopRecording", path, error) from None
    return [len(pictures), str(path)]


_PICTURE_TIMEOUT: Final = 60.0
"""s that a picture may take."""


def avi(pictures: Sequence[bytes], size: tuple[int, int], rate: int) -> bytes:
    """A film in motion JPEG (AVI RIFF, Microsoft's reference: `avih`, `strh`, `strf`, `movi`, `idx1`)."""
    width, height = size
    count, most = len(pictures), max(map(len, pictures))
    film = struct.pack(
        "<14I", 1_000_000 // rate, most * rate, 0, 0x10, count, 0, 1, most, width, height, 0, 0, 0, 0
    )
    stream = struct.pack(
        "<4s4s10I4H", b"vids", b"MJPG", 0, 0, 0, 1, rate, 0, count, most, 0xFFFFFFFF, 0, 0, 0, width, height
    )
    format_ = struct.pack("<IiiHH4sIiiII", 40, width, height, 1, 24, b"MJPG", 3 * width * height, 0, 0, 0, 0)
    head = _list(
        b"hdrl", _chunk(b"avih", film), _list(b"strl", _chunk(b"strh", stream), _chunk(b"strf", format_))
    )
    chunks = [_chunk(b"00dc", picture) for picture in pictures]
    index, place = b"", 4
    for picture, chunk in zip(pictures, chunks, strict=True):
        index += struct.pack("<4sIII", b"00dc", 0x10, place, len(picture))
        place += len(chunk)
    body = b"AVI " + head + _list(b"movi", *chunks) + _chunk(b"idx1", index)
    return _chunk(b"RIFF", body)


def _chunk(name: bytes, data: bytes) -> bytes:
    return name + struct.pack("<I", len(data)) + data + b"\0" * (len(data) % 2)


def _list(name: bytes, *chunks: bytes) -> bytes:
    return _chunk(b"LIST", name + b"".join(chunks))
