"""Encoded pictures as a WebM file that can be wound to any place (Matroska, RFC 9559; WebM's subset of it)."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from typing import Final, NamedTuple

from nao_hil import __version__

MILLISECOND: Final = 1_000_000
"""ns; the unit of times in the file."""
MAKER: Final = f"nao-hil {__version__}".encode()


class EncodedPicture(NamedTuple):
    """One encoded picture."""

    time: int
    """In the video, ms."""
    key: bool
    """It needs no other one; the first must be one."""
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
        _element("4D80", MAKER) + _element("5741", MAKER),
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
    """Where the clusters begin."""
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
