"""Recordings of the microphones, which an emulated robot does not have: WAV files of silence."""

from __future__ import annotations

import wave
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from bridge.adapters.naoqi.arguments import new_file
from bridge.adapters.naoqi.methods import Table
from bridge.errors import NaoqiRefused

_ALLOWED: Final = ((4, 48_000), (1, 16_000))
"""Channels and rate, Hz (vendor's page)."""
MAX_SECONDS: Final = 600.0
"""s of silence that are written."""


@dataclass(frozen=True)
class _Recording:
    path: Path
    channels: int
    rate: int
    began: int
    """The robot's clock, ms."""


class Recorder:
    """Methods of `ALAudioRecorder` and of `ALAudioDevice`; not thread-safe, the caller locks.

    Args:
        now: the robot's clock, ms.
    """

    def __init__(self, now: Callable[[], int]) -> None:
        self._now = now
        self._recording: _Recording | None = None
        self._writer = ThreadPoolExecutor(1, "recorder")

    def _start(self, path: Any, kind: Any, rate: Any, channels: Any) -> None:
        method = "startMicrophonesRecording"
        file = new_file(path, f"{method}: path")
        if self._recording is not None:
            raise NaoqiRefused(f"{method}: {self._recording.path} is being recorded; stop that first.")
        if kind != "wav":
            raise NaoqiRefused(f"{method}: {kind!r:.40} is not written; wav is.")
        count = sum(map(bool, channels)) if isinstance(channels, list) else 0
        if (count, rate) not in _ALLOWED:
            raise NaoqiRefused(
                f"{method} takes 4 channels at 48000 Hz or one of [left, right, front, rear] at 16000 Hz."
            )
        self._recording = _Recording(file, count, rate, self._now())

    def _start_all(self, path: Any) -> None:
        self._start(path, "wav", 48_000, [1, 1, 1, 1])

    def _stop(self) -> Future[Any] | None:
        recording, self._recording = self._recording, None
        if recording is None:
            return None
        seconds = min(MAX_SECONDS, 0.001 * (self._now() - recording.began))
        return self._writer.submit(_write, recording, seconds)

    def methods(self) -> Table:
        """Methods of `ALAudioRecorder`."""
        return {"startMicrophonesRecording": self._start, "stopMicrophonesRecording": self._stop}

    def device_methods(self) -> Table:
        """Methods of `ALAudioDevice`."""
        return {
            "startMicrophonesRecording": self._start_all,
            "stopMicrophonesRecording": self._stop,
            "enableEnergyComputation": lambda: None,
            "disableEnergyComputation": lambda: None,
            **{f"get{place}MicEnergy": lambda: 0.0 for place in ("Front", "Rear", "Left", "Right")},
        }


def _write(recording: _Recording, seconds: float) -> None:
    try:
        with wave.open(str(recording.path), "wb") as file:
            file.setnchannels(recording.channels)
            file.setsampwidth(2)
            file.setframerate(recording.rate)
            second = bytes(2 * recording.channels * recording.rate)
            for _ in range(int(seconds)):
                file.writeframes(second)
            rest = round((seconds % 1.0) * recording.rate)
            file.writeframes(second[: 2 * recording.channels * rest])
    except OSError as error:
        raise NaoqiRefused(
            f"stopMicrophonesRecording: {recording.path} cannot be written ({error.strerror})."
        ) from None
