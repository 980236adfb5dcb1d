"""Reading of recordings, whole or cut off."""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any, BinaryIO, Final, NamedTuple

import msgspec
import zstandard
from mcap.exceptions import EndOfFile, McapError
from mcap.opcode import Opcode
from mcap.records import Channel, McapRecord, Message, Metadata, Statistics
from mcap.stream_reader import CRCValidationError, StreamReader
from zstandard import ZstdError

from bridge.body import Body, body_of, load_body
from bridge.errors import ConfigurationError
from bridge.recording.canonical import RECORDED
from bridge.recording.mcap_file import METADATA

_MAGIC: Final = b"\x89MCAP0\r\n"
_RECORD: Final = struct.Struct("<BQ")
"""Head of every MCAP record: kind, and the length of the rest."""
_CHUNK: Final = struct.Struct("<16xQII")
"""Of a chunk: its times, its length unpacked, a checksum, and the length of the name of its compression."""
MAX_RECORD_SIZE: Final = 1 << 26
"""bytes of a record, packed and unpacked; a second of the longest frames has a hundredth of it."""

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
    for record in _records(path):
        if isinstance(record, Metadata) and record.name == METADATA:
            return dict(record.metadata)
    return {}


def recorded_body(path: str | Path, named: str | None = None, default: str | None = None) -> Body:
    """The body that is named, else the recorded one, else the default.

    Raises:
        ConfigurationError: as `recorded_config`, none of them is given, or one that is not known.
    """
    config = recorded_config(path)
    name = named or (config.get("robot", default) if isinstance(config, dict) else default)
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
    for record in _records(path):
        if isinstance(record, Channel) and record.message_encoding == "json" and record.topic in _decoders:
            topics[record.id] = record.topic
        elif isinstance(record, Message):
            count += 1
            if record.channel_id in topics:
                yield topics[record.channel_id], record
        elif isinstance(record, Statistics) and record.message_count != count:
            raise _damaged(path, f"{count} of {record.message_count} messages can be read")


def _records(path: str | Path) -> Iterator[McapRecord]:
    """All records up to the footer, or to the last whole one of an incomplete file."""
    with _open(path) as file:
        size = os.fstat(file.fileno()).st_size
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
            yield from _parse(path, head + file.read(length))


def _parse(path: str | Path, record: bytes) -> list[McapRecord]:
    """The record, or when it is a chunk, those within."""
    records = []
    if record[0] == Opcode.CHUNK and _unpacked_size(record[_RECORD.size :]) > MAX_RECORD_SIZE:
        raise _damaged(path, f"a chunk that unpacks to more than {MAX_RECORD_SIZE} bytes")
    try:
        for item in StreamReader(BytesIO(record), skip_magic=True, validate_crcs=True).records:
            records.append(item)
    except EndOfFile:
        return records
    except (McapError, ZstdError, CRCValidationError, struct.error, ValueError, OverflowError) as error:
        raise _damaged(path, error) from None
    return records


def _unpacked_size(chunk: bytes) -> int:
    """Bytes of a decompressed chunk, by its header and by its frame."""
    try:
        size, _, length = _CHUNK.unpack_from(chunk)
        begin = _CHUNK.size + length + 8
        packed = zstandard.frame_content_size(chunk[begin:]) if chunk[_CHUNK.size :][:length] == b"zstd" else 0
    except (struct.error, ZstdError):
        return 0  # cut off, or damaged: reading it raises the error
    return int(max(size, packed))


def _damaged(path: str | Path, how: object) -> ConfigurationError:
    return ConfigurationError(
        f"{path}: is damaged ({how}); make the recording again, or take the readable part from it with "
        "the command `mcap recover` of the MCAP project."
    )


def _open(path: str | Path) -> BinaryIO:
    try:
        if Path(path).exists() and not Path(path).is_file():
            raise ConfigurationError(f"{path}: is no file; give the path of a recording (.mcap).")
        file = Path(path).open("rb")  # noqa: SIM115 (the caller closes it)
    except OSError as error:
        raise ConfigurationError(
            f"{path}: cannot be read ({error.strerror}); give the path of a recording (.mcap)."
        ) from None
    if file.read(len(_MAGIC)) != _MAGIC:
        file.close()
        raise ConfigurationError(f"{path}: is not an MCAP file; give the path of a recording (.mcap).")
    return file
