"""Reading of recordings, whole or cut off."""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, Final, NamedTuple

import lz4.frame
import msgspec
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.exceptions import EndOfFile, McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, McapRecord, Message, Metadata, Statistics
from mcap.stream_reader import StreamReader
from zstandard import ZstdError

from bridge.body import Body, body_of, load_body
from bridge.errors import ConfigurationError
from bridge.files import open_file
from bridge.recording.canonical import RECORDED
from bridge.recording.mcap_file import METADATA

_MAGIC: Final = b"\x89MCAP0\r\n"
_RECORD: Final = struct.Struct("<BQ")
"""Head of every MCAP record: kind, and the length of the rest."""
MAX_RECORD_SIZE: Final = 1 << 26
"""bytes of a record, packed and unpacked; a second of the longest frames has a hundredth of it."""
_MAX_RATIO: Final = 50
"""Bytes that a byte of the file unpacks to at most, over the whole file; in our recordings 4."""
_FREE_SIZE: Final = MAX_RECORD_SIZE
"""bytes that a short file may unpack to, whatever its length."""
_READERS: Final[dict[int, Callable[[ReadDataStream, int], McapRecord]]] = {
    Opcode.MESSAGE: Message.read,
    Opcode.CHANNEL: lambda stream, _: Channel.read(stream),
    Opcode.METADATA: lambda stream, _: Metadata.read(stream),
    Opcode.STATISTICS: lambda stream, _: Statistics.read(stream),
}
"""By the kind of the record."""

_decoders = {topic: msgspec.json.Decoder(kind) for kind, topic in RECORDED.items()}


class Ending(NamedTuple):
    """How the file of a recording ends."""

    complete: bool
    """Not cut off by a killed process or a full disk."""
    after: int
    """Bytes behind its end, which are not read: of a second file joined to it, for example."""


class Recorded(NamedTuple):
    """One message of a recording."""

    topic: str
    time: float
    """Robot time, s."""
    message: Any
    """Fields that recordings leave out have their defaults."""


def read_recording(path: str | Path) -> Iterator[Recorded]:
    """The messages of a recording in their order in the file.

    A file whose end is missing is read to its last whole record. Topics that are not in
    `bridge.recording.canonical.RECORDED` are passed over.

    Raises:
        ConfigurationError: no such file, not an MCAP file, damaged, or a message that does not fit its topic;
            the first two are raised by the call itself, the others during the iteration.
    """
    _open(path).close()
    return (
        Recorded(topic, message.log_time * 1e-9, _typed(path, topic, message.data))
        for topic, message in _messages(path)
    )


def recorded_config(path: str | Path) -> Any:
    """Configuration of the recorded run, as plain JSON values; None: the recording has none.

    Raises:
        ConfigurationError: as `read_recording`, or it holds one that is no JSON.
    """
    try:
        return msgspec.json.decode(_metadata(path).get("config", "null"))
    except (msgspec.MsgspecError, ValueError, RecursionError) as error:
        raise ConfigurationError(f"{path}: its configuration is no JSON: {error}.") from None


def _metadata(path: str | Path) -> dict[str, str]:
    for record in mcap_records(path):
        if isinstance(record, Metadata) and record.name == METADATA:
            return dict(record.metadata)
    return {}


def recorded_body(path: str | Path, named: str | None = None) -> Body:
    """The body that is named, else the recorded one.

    Raises:
        ConfigurationError: as `recorded_config`, neither is given, or one that is not known.
    """
    config = recorded_config(path)
    name = named or (config.get("robot") if isinstance(config, dict) else None)
    if not isinstance(name, str):
        raise ConfigurationError(f"{path}: does not say which body was recorded; name it with --robot.")
    return load_body(name) if named else body_of(name, _metadata(path).get("sheet", ""))


def recording_end(path: str | Path) -> Ending:
    """How the file of a recording ends.

    Raises:
        ConfigurationError: no such file, or not an MCAP file.
    """
    with _open(path) as file:
        size = os.fstat(file.fileno()).st_size
        while len(head := file.read(_RECORD.size)) == _RECORD.size:
            kind, length = _RECORD.unpack(head)
            end = file.tell() + length
            if end > size:
                break
            file.seek(end)
            if kind == Opcode.FOOTER and file.read(len(_MAGIC)) == _MAGIC:
                return Ending(complete=True, after=size - file.tell())
    return Ending(complete=False, after=0)


def _typed(path: str | Path, topic: str, data: bytes) -> Any:
    try:
        return _decoders[topic].decode(data)
    except (msgspec.MsgspecError, ValueError, RecursionError) as error:
        raise ConfigurationError(f"{path}: a message on `{topic}` does not fit its type: {error}.") from None


def _messages(path: str | Path) -> Iterator[tuple[str, Message]]:
    topics: dict[int, str] = {}
    count = 0
    for record in mcap_records(path):
        if isinstance(record, Channel) and record.message_encoding == "json" and record.topic in _decoders:
            topics[record.id] = record.topic
        elif isinstance(record, Message):
            count += 1
            if record.channel_id in topics:
                yield topics[record.channel_id], record
        elif isinstance(record, Statistics) and record.message_count != count:
            raise _damaged(path, f"{count} of {record.message_count} messages can be read")


def mcap_records(path: str | Path) -> Iterator[McapRecord]:
    """All records of any MCAP file up to the footer, or to the last whole one of an incomplete file.

    Raises:
        ConfigurationError: no such file, not an MCAP file, damaged, or one that unpacks to too much.
    """
    with _open(path) as file:
        size = os.fstat(file.fileno()).st_size
        budget = _FREE_SIZE + _MAX_RATIO * size
        while len(head := file.read(_RECORD.size)) == _RECORD.size:
            kind, length = _RECORD.unpack(head)
            if kind == Opcode.FOOTER:
                return
            if file.tell() + length > size:
                file.seek(-len(_MAGIC), os.SEEK_END)
                if file.read() == _MAGIC:
                    raise _damaged(path, "a record is longer than the file")
                return
            if length > MAX_RECORD_SIZE:
                raise _damaged(path, f"a record of more than {MAX_RECORD_SIZE} bytes")
            data = file.read(length)
            if kind == Opcode.CHUNK:
                data = _unpacked(path, data)
                if (budget := budget - len(data)) < 0:
                    raise _damaged(path, f"it unpacks to more than {_MAX_RATIO} times of its length")
                yield from _in_chunk(path, data)
                continue
            try:  # the index too, although it is not used: it is damaged where the file is
                yield from StreamReader(BytesIO(head + data), skip_magic=True).records
            except EndOfFile:
                continue
            except (McapError, struct.error, ValueError, OverflowError) as error:
                raise _damaged(path, error) from None


def _unpacked(path: str | Path, content: bytes) -> bytes:
    """The records in a chunk, one after the other."""
    limit = f"a chunk that unpacks to more than {MAX_RECORD_SIZE} bytes"
    try:
        chunk = Chunk.read(ReadDataStream(BytesIO(content)))
        if chunk.uncompressed_size > MAX_RECORD_SIZE:
            raise _damaged(path, limit)
        if chunk.compression == "zstd":
            data = zstandard.ZstdDecompressor().stream_reader(chunk.data).read(MAX_RECORD_SIZE + 1)
        elif chunk.compression == "lz4":
            data = lz4.frame.LZ4FrameDecompressor().decompress(chunk.data, max_length=MAX_RECORD_SIZE + 1)
        elif not chunk.compression:
            data = chunk.data
        else:
            raise _damaged(path, f"a chunk of the unknown compression `{chunk.compression[:20]}`")
    except (McapError, ZstdError, struct.error, ValueError, RuntimeError, OverflowError) as error:
        raise _damaged(path, error or type(error).__name__) from None
    if len(data) > MAX_RECORD_SIZE:
        raise _damaged(path, limit)
    if len(data) != chunk.uncompressed_size:
        raise _damaged(path, "a chunk has another length than it declares")
    if chunk.uncompressed_crc and zlib.crc32(data) != chunk.uncompressed_crc:
        raise _damaged(path, "a chunk's checksum is another one")
    return data


def _in_chunk(path: str | Path, data: bytes) -> Iterator[McapRecord]:
    """The records in a chunk, but for those that no reader here takes; a cut one ends them."""
    raw, place = BytesIO(data), 0
    stream = ReadDataStream(raw)
    while place + _RECORD.size <= len(data):
        kind, length = _RECORD.unpack_from(data, place)
        begin, place = place + _RECORD.size, place + _RECORD.size + length
        if not kind:
            raise _damaged(path, "a record of kind 0, which MCAP does not have")
        if place > len(data):
            return
        if kind in _READERS:
            raw.seek(begin)
            try:
                yield _READERS[kind](stream, length)
            except EndOfFile:
                return
            except (McapError, struct.error, ValueError, OverflowError) as error:
                raise _damaged(path, error) from None


def _damaged(path: str | Path, how: object) -> ConfigurationError:
    return ConfigurationError(
        f"{path}: is damaged ({how}); make the recording again, or take the readable part from it with "
        "the command `mcap recover` of the MCAP project."
    )


def _open(path: str | Path) -> BinaryIO:
    file = open_file(path, "give the path of a recording (.mcap)")
    if file.read(len(_MAGIC)) != _MAGIC:
        file.close()
        raise ConfigurationError(f"{path}: is not an MCAP file; give the path of a recording (.mcap).")
    return file
