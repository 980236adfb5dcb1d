"""Recordings: all frames of a run in one MCAP file that Foxglove and PlotJuggler open.

Messages are JSON with a JSON schema, and so is the robot for Foxglove's 3-D panel (`foxglove`); their log and
publish time is robot time. Whatever differs between two runs of one seed is left out: the wall-clock fields and
the number of the lease. Two lockstep runs therefore give byte-identical files. `bridge.recording.playback`
reads them back.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec

from bridge.body import sheet_of
from bridge.messages import ActuatorFrame, SensorFrame, TruthFrame
from bridge.messages.topics import Message
from bridge.recording.foxglove import SHOWN, RobotScene
from bridge.recording.mcap_file import McapFile
from bridge.recording.observer import Observer
from bridge.types import Closing


def later_file(first: Path, number: int) -> Path:
    """File of a later run of the same process.

    Args:
        first: file of the first run.
        number: of the run; 2 after the first reset.
    """
    return first.with_name(f"{first.stem}-{number}{first.suffix}") if number > 1 else first


class Recorder(Observer, Closing):
    """Writes a recording; also a `bridge.recording.observer.Observer`.

    Frames without a time of their own get the time of the last sensor frame written before them. One file is
    one run: after a restart of the robot (a sensor frame with a smaller `seq`) the next file begins in the
    same folder, `frames-2.mcap` after `frames.mcap`.

    Args:
        path: file to write; an existing one is replaced.
        config: configuration of the run with its seed, anything msgspec can turn into JSON. For
            byte-identical recordings it holds nothing that differs between two equal runs, such as paths.
        scene: makes the objects of Foxglove's 3-D panel, for each file a new one; a body that is not shipped
            is recorded with its data sheet. None: nothing.

    Raises:
        ConfigurationError: the file cannot be created.
    """

    def __init__(self, path: str | Path, config: Any, scene: Callable[[], RobotScene] | None = None) -> None:
        self._config = msgspec.json.encode(config, order="deterministic").decode()
        self._time = 0
        self._seq = -1
        self._make_scene = scene
        self._file = self._open(Path(path))
        self.paths = [self._file.path]
        """Files written so far."""

    def _open(self, path: Path) -> McapFile:
        self._scene = self._make_scene() if self._make_scene is not None else None
        sheet = sheet_of(self._scene.body) if self._scene is not None else ""
        file = McapFile(path, {"config": self._config} | ({"sheet": sheet} if sheet else {}))
        if self._scene is not None:
            file.show(SHOWN)
        return file

    def write(self, message: Message) -> None:
        """Record a message; the time of a sensor frame is also the time of the messages that follow."""
        if isinstance(message, SensorFrame):
            if message.seq < self._seq:
                self._file.close()
                self._file = self._open(later_file(self.paths[0], len(self.paths) + 1))
                self.paths.append(self._file.path)
            self._seq = message.seq
            self._time = round(message.time * 1e9)
        self._file.write(message, self._time)
        if self._scene is not None:
            for shown in self._scene.add(message):
                self._file.write(shown, self._time)

    def sensors(self, frame: SensorFrame, truth: TruthFrame) -> None:
        """As an observer: record both."""
        self.write(frame)
        self.write(truth)

    def command(self, frame: ActuatorFrame) -> None:
        """As an observer: record the command in force."""
        self.write(frame)

    def message(self, message: Message) -> None:
        """As an observer: record it."""
        self.write(message)

    def close(self) -> None:
        """Write the index and close the file; further calls do nothing.

        Raises:
            LinkError: the rest cannot be written; the file is closed and readable up to there.
        """
        self._file.close()
