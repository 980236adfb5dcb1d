"""Recordings: all frames of a run in one MCAP file that Foxglove and PlotJuggler open.

Messages are JSON with a JSON schema; their log and publish time is robot time. What is not the same in two
runs of one seed is left out: the wall-clock fields and the number of the lease. Two lockstep runs therefore
give byte-identical files. `bridge.playback` reads them back.
"""

from __future__ import annotations

import hashlib
from pathlib import Path
from types import TracebackType
from typing import Any, Final

import msgspec
from mcap.writer import CompressionType, Writer

from bridge.errors import ConfigurationError, LinkError
from bridge.jsonschema import object_schema
from bridge.messages import ActuatorFrame, Notice, SensorFrame, TruthFrame, WalkTelemetry

Recordable = SensorFrame | ActuatorFrame | TruthFrame | WalkTelemetry | Notice

TOPICS: Final[dict[type[Recordable], str]] = {
    SensorFrame: "sensors",
    ActuatorFrame: "actuators",
    TruthFrame: "world/truth",
    WalkTelemetry: "walk/telemetry",
    Notice: "notices",
}
"""Topic of each kind of message: the last part of its key on the wire."""

LEFT_OUT: Final = frozenset({"wall", "tick", "lease"})
"""Fields that differ between two runs of the same seed."""

METADATA: Final = "run"
"""Name of the metadata record that holds the run's configuration."""

_CHUNK: Final = 1_000_000_000
"""Robot time in a compressed chunk, ns, which is what a killed process loses at most.

The library keeps some 700 bytes about each chunk until the end: 2.6 MB an hour.
"""
_CHUNK_BYTES: Final = 1024 * 1024
"""Bytes in a chunk at most: more than a second's frames, less than a flood of them."""

_FIELDS: Final = {
    kind: tuple(name for name in kind.__struct_fields__ if name not in LEFT_OUT) for kind in TOPICS
}
_encoder = msgspec.json.Encoder()


def canonical_json(message: Recordable) -> bytes:
    """The message as it is recorded and hashed: a JSON object without the fields in `LEFT_OUT`.

    Fields stand in the order of the struct, floats are the shortest decimals that read back the same, and a
    number that is not finite, which no frame should have, is null.
    """
    return _encoder.encode({name: getattr(message, name) for name in _FIELDS[type(message)]})


def later_file(first: Path, number: int) -> Path:
    """Where the run after so many beginnings is recorded, 2 for the first reset; `first`: of the first run."""
    return first.with_name(f"{first.stem}-{number}{first.suffix}") if number > 1 else first


class FrameHash:
    """SHA-256 over sensor and actuator frames in order: a line of canonical JSON each, with its line feed."""

    def __init__(self) -> None:
        self._hash = hashlib.sha256()

    def sensor(self, frame: SensorFrame) -> None:
        """Add a sensor frame."""
        self.line(canonical_json(frame))

    def actuator(self, frame: ActuatorFrame) -> None:
        """Add an actuator frame."""
        self.line(canonical_json(frame))

    def line(self, canonical: bytes) -> None:
        """Add a frame in its canonical form."""
        self._hash.update(canonical)
        self._hash.update(b"\n")

    def hexdigest(self) -> str:
        """Hash of the frames so far, 64 hexadecimal digits."""
        return self._hash.hexdigest()


class _File:
    """One MCAP file.

    Args:
        path: file to write; an existing one is replaced.
        config: the run's configuration as JSON text.

    Raises:
        ConfigurationError: the file cannot be created.
    """

    def __init__(self, path: Path, config: str) -> None:
        self.path = path
        try:
            self._file = path.open("wb")
        except OSError as error:
            raise ConfigurationError(
                f"{path}: a recording cannot be written there ({error.strerror}); give a writable place."
            ) from None
        self._chunk_began = 0
        self._sequence = dict.fromkeys(TOPICS, 0)
        self._writer = Writer(self._file, chunk_size=_CHUNK_BYTES, compression=CompressionType.ZSTD)
        # The library's own default would write its version into every file.
        self._writer.start(profile="", library="nao-hil")
        self._writer.add_metadata(METADATA, {"config": config})
        self._channels = {kind: self._register(kind, topic) for kind, topic in TOPICS.items()}
        self._file.flush()

    def _register(self, kind: type[Recordable], topic: str) -> int:
        schema = msgspec.json.encode(object_schema(kind, LEFT_OUT))
        schema_id = self._writer.register_schema(f"nao.{kind.__name__}", "jsonschema", schema)
        channel: int = self._writer.register_channel(topic, "json", schema_id)
        return channel

    def write(self, message: Recordable, time: int) -> None:
        """Record a message at a robot time, ns."""
        kind = type(message)
        data = canonical_json(message)
        try:
            self._writer.add_message(
                self._channels[kind],
                log_time=time,
                data=data,
                publish_time=time,
                sequence=self._sequence[kind],
            )
            if not 0 <= time - self._chunk_began < _CHUNK:
                self._writer.flush()
                self._chunk_began = time
        except OSError as error:
            raise self._broken(error) from None
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
            raise self._broken(error) from None

    def _broken(self, error: OSError) -> LinkError:
        return LinkError(f"{self.path}: the recording broke off ({error.strerror}).")


class Recorder:
    """Writes a recording; also a `bridge.observer.Observer`.

    Frames without a time of their own get the time of the last sensor frame written before them. One file is
    one run: when the robot begins anew (a sensor frame with a smaller `seq`), the file is closed and the next
    one begun beside it, `frames-2.mcap` after `frames.mcap`.

    Args:
        path: file to write; an existing one is replaced.
        config: configuration of the run with its seed, anything msgspec can turn into JSON. For
            byte-identical recordings it holds nothing that differs between two equal runs, such as paths.

    Raises:
        ConfigurationError: the file cannot be created.
    """

    def __init__(self, path: str | Path, config: Any) -> None:
        self._config = msgspec.json.encode(config, order="deterministic").decode()
        self._time = 0
        self._seq = -1
        self._file = _File(Path(path), self._config)
        self.paths = [self._file.path]
        """Files written so far."""

    def write_sensor(self, frame: SensorFrame) -> None:
        """Record a sensor frame; its time is the time of what follows."""
        if frame.seq < self._seq:
            self._begin_anew()
        self._seq = frame.seq
        self._time = round(frame.time * 1e9)
        self._write(frame)

    def _begin_anew(self) -> None:
        self._file.close()
        first = self.paths[0]
        path = later_file(first, len(self.paths) + 1)
        self._file = _File(path, self._config)
        self.paths.append(path)

    def write_actuator(self, frame: ActuatorFrame) -> None:
        """Record an actuator frame."""
        self._write(frame)

    def write_truth(self, frame: TruthFrame) -> None:
        """Record the ground truth."""
        self._write(frame)

    def write_telemetry(self, message: WalkTelemetry) -> None:
        """Record what the walker says of its walk."""
        self._write(message)

    def write_notice(self, message: Notice) -> None:
        """Record a notice."""
        self._write(message)

    def sensors(self, frame: SensorFrame, truth: TruthFrame) -> None:
        """As an observer: record both."""
        self.write_sensor(frame)
        self.write_truth(truth)

    def command(self, frame: ActuatorFrame) -> None:
        """As an observer: record the command in force."""
        self.write_actuator(frame)

    def telemetry(self, message: WalkTelemetry) -> None:
        """As an observer: record it."""
        self.write_telemetry(message)

    def notice(self, message: Notice) -> None:
        """As an observer: record it."""
        self.write_notice(message)

    def _write(self, message: Recordable) -> None:
        self._file.write(message, self._time)

    def close(self) -> None:
        """Write the index and close the file; further calls do nothing.

        Raises:
            LinkError: the rest cannot be written; the file is closed and readable up to there.
        """
        self._file.close()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()
