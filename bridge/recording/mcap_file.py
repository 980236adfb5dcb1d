"""Writing one MCAP file: channels with JSON schemas, compressed chunks, the run's configuration.

JSON schema of a message in the plain form that plotting tools read: types, properties, items.

msgspec's own schemas use `$ref`, `anyOf` and `prefixItems`, which those tools do not read.
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import msgspec
import msgspec.inspect as mi
from mcap.writer import CompressionType, Writer

from bridge.errors import ConfigurationError, LinkError
from bridge.messages.topics import Message
from bridge.recording.canonical import LEFT_OUT, RECORDED, canonical_json
from bridge.recording.foxglove import SHOWN, Shown

_JSON_TYPES: dict[type[mi.Type], str] = {
    mi.BoolType: "boolean",
    mi.IntType: "integer",
    mi.FloatType: "number",
    mi.StrType: "string",
    mi.LiteralType: "string",
}
METADATA: Final = "run"
"""Name of the metadata record that holds the run's configuration."""
_CHUNK_TIME: Final = 250_000_000
"""Robot time in a compressed chunk, ns: as much as a killed process loses.

The cycle that ends a chunk compresses it: 0.7 ms, and 2 ms if it were a second's. The library keeps some 700
bytes about each chunk until the end: 10 MB an hour.
"""
_CHUNK_BYTES: Final = 1024 * 1024
"""Bytes in a chunk at most: more than a second's frames, less than a flood of them."""


def object_schema(kind: type[msgspec.Struct], without: frozenset[str] = frozenset()) -> dict[str, Any]:
    """Schema of a struct as a JSON object.

    An optional value has the schema of the value alone: viewers take one type per field, and show a null as
    no value.

    Args:
        kind: the struct; its fields are numbers, strings, booleans, structs, and tuples of one of these.
        without: names of fields that are left out.
    """
    info = mi.type_info(kind)
    assert isinstance(info, mi.StructType)
    fields = [field for field in info.fields if field.name not in without]
    return {
        "title": kind.__name__,
        "type": "object",
        "properties": {field.encode_name: _schema(field.type) for field in fields},
        "required": [field.encode_name for field in fields if field.required],
    }


def _schema(info: mi.Type) -> dict[str, Any]:
    if isinstance(info, mi.StructType):
        return object_schema(info.cls)
    if isinstance(info, mi.UnionType):
        (value,) = (t for t in info.types if not isinstance(t, mi.NoneType))
        return _schema(value)
    if isinstance(info, mi.TupleType):
        n, item = len(info.item_types), _schema(info.item_types[0])
        if any(_schema(t) != item for t in info.item_types):
            raise TypeError(f"{info} mixes types; one type per array is expected")
        return {"type": "array", "items": item, "minItems": n, "maxItems": n}
    if isinstance(info, mi.VarTupleType):
        bounds = {"minItems": info.min_length, "maxItems": info.max_length}
        return {"type": "array", "items": _schema(info.item_type)} | {
            key: bound for key, bound in bounds.items() if bound is not None
        }
    try:
        return {"type": _JSON_TYPES[type(info)]}
    except KeyError:
        raise TypeError(f"{info} has no plain JSON schema") from None


class McapFile:
    """One MCAP file that is open for writing.

    Args:
        path: file to write; an existing one is replaced.
        metadata: texts by name: the run's configuration (`config`, JSON), a data sheet (`sheet`, JSON).

    Raises:
        ConfigurationError: the file cannot be created, or has no room for its head.
    """

    def __init__(self, path: Path, metadata: dict[str, str]) -> None:
        self.path = path
        try:
            self._file = path.open("wb")
        except OSError as error:
            raise ConfigurationError(
                f"{path}: a recording cannot be written there ({error.strerror}); give a writable place."
            ) from None
        self._chunk_began = 0
        self._sequence: dict[type, int] = dict.fromkeys((*RECORDED, *SHOWN), 0)
        self._writer = Writer(self._file, chunk_size=_CHUNK_BYTES, compression=CompressionType.ZSTD)
        self._channels: dict[type, int] = {}
        try:
            self._begin(metadata)
        except OSError as error:
            with contextlib.suppress(OSError):  # closing flushes again
                self._file.close()
            if path.is_file():
                path.unlink()  # half a head is no recording
            raise ConfigurationError(
                f"{path}: a recording cannot be begun there ({error.strerror}); give a place with room."
            ) from None

    def _begin(self, metadata: dict[str, str]) -> None:
        # The library's own default would write its version into every file.
        self._writer.start(profile="", library="nao-hil")
        self._writer.add_metadata(METADATA, metadata)
        for kind, topic in RECORDED.items():
            self._channels[kind] = self._register(kind, topic, f"nao.{kind.__name__}")
        self._file.flush()

    def show(self, kinds: Mapping[type[Shown], str]) -> None:
        """Add channels for Foxglove's drawings: kind of message -> topic."""
        self._channels |= {
            kind: self._register(kind, topic, f"foxglove.{kind.__name__}") for kind, topic in kinds.items()
        }

    def _register(self, kind: type[msgspec.Struct], topic: str, name: str) -> int:
        schema = msgspec.json.encode(object_schema(kind, LEFT_OUT))
        schema_id = self._writer.register_schema(name, "jsonschema", schema)
        channel: int = self._writer.register_channel(topic, "json", schema_id)
        return channel

    def write(self, message: Message | Shown, time: int) -> None:
        """Record a message.

        Args:
            message: of one of the `RECORDED` kinds, or of one of the kinds that are shown.
            time: robot time, ns.
        """
        kind = type(message)
        data = msgspec.json.encode(message) if isinstance(message, Shown) else canonical_json(message)
        try:
            self._writer.add_message(
                self._channels[kind], log_time=time, data=data, publish_time=time, sequence=self._sequence[kind]
            )
            if not 0 <= time - self._chunk_began < _CHUNK_TIME:
                self._writer.flush()
                self._chunk_began = time
        except OSError as error:
            raise self._interrupted(error) from None
        self._sequence[kind] += 1

    def close(self) -> None:
        """Write the index and close the file; further calls do nothing.

        Raises:
            LinkError: the rest cannot be written; the file is closed and readable up to there.
        """
        if self._file.closed:
            return
        try:
            with self._file:
                self._writer.finish()
        except OSError as error:
            raise self._interrupted(error) from None

    def _interrupted(self, error: OSError) -> LinkError:
        return LinkError(f"{self.path}: the recording was interrupted ({error.strerror}).")
