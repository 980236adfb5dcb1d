"""A recorded run as a video: an exported page draws it in a headless Chromium, which encodes it."""

from __future__ import annotations

import base64
import shutil
import struct
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from bridge.errors import ConfigurationError
from nao_hil import __version__
from nao_hil.files import write_bytes
from nao_hil.view.page import recorded_page

if TYPE_CHECKING:
    from nao_hil.runs.campaign import Progress

MILLISECOND: Final = 1_000_000
"""ns; the unit of times in the file."""
WRITING_APP: Final = f"nao-hil {__version__}".encode()
CHROMIUM: Final = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
SOFTWARE: Final = ("--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")
"""Options for drawing without a graphics card."""
SIZE: Final = (1280, 720)
"""Pixels."""
PICTURE_RATE: Final = 30
"""Pictures per second."""
BIT_RATE: Final = 3_000_000
"""Per second of the video."""
BATCH_SIZE: Final = 15
"""Pictures between two reports of the progress."""


class EncodedPicture(NamedTuple):
    """One encoded picture."""

    time: int
    """In the video, ms."""
    key: bool
    """Needs no other one; the first must be one."""
    data: bytes


def webm(pictures: Sequence[EncodedPicture], size: tuple[int, int], rate: float) -> bytes:
    """The file.

    Args:
        pictures: VP9, in order of time.
        size: Width and height, pixels.
        rate: Pictures per second.
    """
    head = _element(
        "1A45DFA3",
        _number("4286", 1) + _number("42F7", 1) + _number("42F2", 4) + _number("42F3", 8),
        _element("4282", b"webm") + _number("4287", 2) + _number("4285", 2),
    )
    duration = pictures[-1].time + 1e3 / rate
    info = _element(
        "1549A966",
        _number("2AD7B1", MILLISECOND) + _element("4489", struct.pack(">d", duration)),
        _element("4D80", WRITING_APP) + _element("5741", WRITING_APP),
    )
    video = _element("E0", _number("B0", size[0]) + _number("BA", size[1]))
    entry = _number("D7", 1) + _number("73C5", 1) + _number("9C", 0) + _number("83", 1)
    entry += _element("86", b"V_VP9") + _number("23E383", round(1e9 / rate)) + video
    tracks = _element("1654AE6B", _element("AE", entry))
    starts = [i for i, picture in enumerate(pictures) if picture.key]
    groups = [pictures[a:b] for a, b in zip(starts, [*starts[1:], len(pictures)], strict=True)]
    clusters = [_cluster(group) for group in groups]
    times = [group[0].time for group in groups]
    place = len(info) + len(tracks) + len(_cues(times, [0] * len(times)))  # positions have a fixed length
    places = [place + sum(map(len, clusters[:i])) for i in range(len(clusters))]
    return head + _element("18538067", info, tracks, _cues(times, places), *clusters)


def _cluster(group: Sequence[EncodedPicture]) -> bytes:
    """A key picture and those that need it."""
    begin = group[0].time
    blocks = [
        _element("A3", struct.pack(">BhB", 0x81, p.time - begin, 0x80 if p.key else 0) + p.data) for p in group
    ]
    return _element("1F43B675", _number("E7", begin), *blocks)


def _cues(times: Sequence[int], places: Sequence[int]) -> bytes:
    """Starts of the clusters."""
    points = [
        _element("BB", _number("B3", time) + _element("B7", _number("F7", 1) + _number("F1", place)))
        for time, place in zip(times, places, strict=True)
    ]
    return _element("1C53BB6B", *points)


def _element(name: str, *contents: bytes) -> bytes:
    content = b"".join(contents)
    return bytes.fromhex(name) + struct.pack(">Q", 1 << 56 | len(content)) + content


def _number(name: str, value: int) -> bytes:
    return _element(name, struct.pack(">Q", value))


def write_video(
    recording: Path, file: Path, begin: float, end: float | None, speed: float, progress: Progress
) -> None:
    """Write a stretch of a recording as WebM (VP9).

    Args:
        recording: The recording.
        file: To write.
        begin: Robot time of the first picture, s.
        end: Of the last; None: the end of the recording.
        speed: Robot time per time of the video.
        progress: Receives the batches of pictures that are drawn.

    Raises:
        ConfigurationError: not a recording, nothing in that stretch, or no Chromium here.
    """
    with _browser() as browser, tempfile.TemporaryDirectory() as folder:
        page_file = Path(folder) / "run.html"
        page_file.write_text(recorded_page([recording])[0], encoding="utf-8")
        page = browser.new_page()
        page.goto(page_file.as_uri())
        page.wait_for_selector("body[data-ready]")
        first, last = page.evaluate("[player.first, player.last]")
        times = np.arange(max(begin, first), last if end is None else min(end, last), speed / PICTURE_RATE)
        if not len(times):
            raise ConfigurationError(f"{recording} goes from {first:g} s to {last:g} s; --from, --to miss it.")
        width, height = SIZE
        options = {"width": width, "height": height, "rate": PICTURE_RATE, "bits": BIT_RATE, "theme": "dark"}
        page.evaluate("options => { window.video = new Video(player, options); }", options)
        parts = np.array_split(times, -(-len(times) // BATCH_SIZE))
        progress.expect(len(parts))
        pictures = []
        for part in parts:
            for when, key, data in page.evaluate("times => video.add(times)", part.tolist()):
                pictures.append(EncodedPicture(round(1e-3 * when), key, base64.b64decode(data)))
            progress.done("", "")
    write_bytes(file, webm(pictures, SIZE, PICTURE_RATE))


@contextmanager
def _browser() -> Iterator[Any]:
    try:
        from playwright.sync_api import sync_playwright
    except ModuleNotFoundError as error:
        raise ConfigurationError(f"A video needs {error.name}: pip install 'nao-hil[video]'.") from None
    chromium = next((path for name in CHROMIUM if (path := shutil.which(name))), None)
    if chromium is None:
        raise ConfigurationError("A video needs Chromium; on Debian or Ubuntu: apt-get install chromium.")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=list(SOFTWARE))
        yield browser
        browser.close()
