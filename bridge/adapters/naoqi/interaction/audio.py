"""ALAudioPlayer, ALAudioDevice and ALAudioRecorder without loudspeakers and microphones.

A file is silent and takes as long as it lasts; recordings and buffers are silence.
"""

from __future__ import annotations

import itertools
import logging
import time
import wave
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final
from weakref import WeakKeyDictionary

from bridge.adapters.naoqi.arguments import MAX_DURATION, flag, new_file, number, robot_file, text
from bridge.adapters.naoqi.core.memory import Publish
from bridge.adapters.naoqi.core.motion_tasks import MotionTask, MotionTasks
from bridge.adapters.naoqi.methods import Table
from bridge.errors import NaoqiRefused

logger = logging.getLogger(__name__)

MAX_FILES: Final = 1000
_OWN_SOUNDS: Final = Path("/usr/share/naoqi/wav")
_OWN_SECONDS: Final = 5.0
"""Of each sound that comes with a robot (assumed)."""
_POLL: Final = 50
"""ms between two looks whether a file was stopped."""


@dataclass
class _File:
    """A loaded file."""

    path: Path
    seconds: float
    volume: float = 1.0
    place: float = 0.0
    """Where it is, s."""
    playing: int = 0
    """Number of the call that plays it; 0: none."""
    paused: bool = False


class AudioPlayer:
    """Plays WAV files of this machine without a sound; not thread-safe, the caller locks.

    Args:
        tasks: for calls that end when the file does.
        now: the robot's clock, ms.
        numbers: for files; none is a call's.
    """

    def __init__(self, tasks: MotionTasks, now: Callable[[], int], numbers: Iterator[int]) -> None:
        self._tasks, self._now = tasks, now
        self._files: dict[int, _File] = {}
        self._played_by: WeakKeyDictionary[Future[Any], int] = WeakKeyDictionary()
        """File that a call of `playFile` plays."""
        self._numbers, self._plays = numbers, itertools.count(1)
        self._master = 1.0
        self._output, self._muted = 100, False

    def load(self, path: Any) -> int:
        """Load a file; its number. One that is missing or no WAV file lasts no time, with a warning."""
        file = robot_file(path, "ALAudioPlayer: file")
        if len(self._files) >= MAX_FILES:
            raise NaoqiRefused(f"ALAudioPlayer: {MAX_FILES} files are loaded already; unload some.")
        try:
            if file.parent == _OWN_SOUNDS and not _OWN_SOUNDS.is_dir():
                seconds = _OWN_SECONDS
            else:
                with wave.open(str(file), "rb") as sound:
                    seconds = sound.getnframes() / max(1, sound.getframerate())
        except (OSError, ValueError, wave.Error, EOFError) as error:
            seconds = 0.0
            reason = getattr(error, "strerror", None) or "no WAV file"
            logger.warning("ALAudioPlayer: %.80s is left out (%s)", file, reason)
        key = next(self._numbers)
        self._files[key] = _File(file, seconds)
        return key

    def _file(self, key: Any) -> _File:
        if isinstance(key, bool) or not isinstance(key, int) or key not in self._files:
            raise NaoqiRefused(f"ALAudioPlayer: {key!r:.40} is no file that loadFile gave.")
        return self._files[key]

    def play(self, key: Any, volume: Any = 1.0, panorama: Any = 0.0, *, loop: bool = False) -> Future[Any]:
        """Play a loaded file from where it is; waits for its end, or for its stop."""
        file = self._file(key)
        file.volume = number(volume, "ALAudioPlayer: volume", 0.0, 1.0)
        number(panorama, "ALAudioPlayer: panorama", -1.0, 1.0)
        return self._tasks.begin(self._played(file, loop))

    def play_file(
        self, path: Any, volume: Any = 1.0, panorama: Any = 0.0, *, loop: bool = False
    ) -> Future[Any]:
        """Load a file and play it."""
        key = self.load(path)
        playing = self.play(key, volume, panorama, loop=loop)
        self._played_by[playing] = key
        return playing

    def begun(self, playing: Future[Any], number: int) -> None:
        """A call of `playFile` got a number: the file has that name, too (confirmed: vendor's samples)."""
        if playing in self._played_by:
            self._files[number] = self._files[self._played_by.pop(playing)]

    def _from(self, path: Any, place: Any, loop: bool, *levels: Any) -> Future[Any]:
        seconds = number(place, "ALAudioPlayer: position", 0.0, MAX_DURATION)
        key = self.load(path)
        self._files[key].place = min(seconds, self._files[key].seconds)
        return self.play(key, *levels, loop=loop)

    def _played(self, file: _File, loop: bool) -> MotionTask:
        file.playing = mine = next(self._plays)
        file.paused = False
        logger.info("the robot would play %s", file.path)
        while file.playing == mine:
            before = self._now()
            left = round(1000.0 * (file.seconds - file.place))
            yield before + max(1, min(_POLL, left))
            if not file.paused:
                file.place += 0.001 * (self._now() - before)
            if file.place >= file.seconds:
                file.place = 0.0
                if not loop or file.seconds == 0.0:
                    break
        if file.playing == mine:
            file.playing = 0
        return None

    def _pause(self, key: Any) -> None:
        file = self._file(key)
        file.paused = not file.paused

    def stop(self, key: Any) -> None:
        """Stop a file; calls that wait for it return."""
        file = self._file(key)
        file.playing, file.place = 0, 0.0

    def stop_all(self) -> None:
        """Stop all files."""
        for key in self._files:
            self.stop(key)

    def _unload(self, key: Any) -> None:
        self.stop(key)
        del self._files[key]

    def _unload_all(self) -> None:
        self.stop_all()
        self._files.clear()

    def _sine(self, frequency: Any, gain: Any, panorama: Any, duration: Any) -> Future[Any]:
        number(frequency, "playSine: frequency", 0.0, 20_000.0)
        number(gain, "playSine: gain", 0.0, 100.0)
        number(panorama, "playSine: pan", -1.0, 1.0)
        seconds = number(duration, "playSine: duration", 0.0, MAX_DURATION)

        def task() -> MotionTask:
            yield self._now() + round(1000.0 * seconds)

        return self._tasks.begin(task())

    def _set_volume(self, key: Any, volume: Any) -> None:
        self._file(key).volume = number(volume, "ALAudioPlayer.setVolume: volume", 0.0, 1.0)

    def _set_master(self, volume: Any) -> None:
        self._master = number(volume, "ALAudioPlayer.setMasterVolume: volume", 0.0, 1.0)

    def _go_to(self, key: Any, place: Any) -> None:
        file = self._file(key)
        file.place = number(place, "ALAudioPlayer.goTo: position", 0.0, file.seconds)

    def methods(self) -> Table:
        """Methods of `ALAudioPlayer`."""
        return {
            "loadFile": self.load,
            "unloadFile": self._unload,
            "unloadAllFiles": self._unload_all,
            "getLoadedFilesIds": lambda: list(self._files),
            "getLoadedFilesNames": lambda: [str(file.path) for file in self._files.values()],
            "play": lambda key, *levels: self.play(key, *_levels(levels)),
            "playInLoop": lambda key, *levels: self.play(key, *_levels(levels), loop=True),
            "playFile": lambda path, *levels: self.play_file(path, *_levels(levels)),
            "playFileInLoop": lambda path, *levels: self.play_file(path, *_levels(levels), loop=True),
            "playFileFromPosition": lambda path, at, *levels: self._from(path, at, False, *_levels(levels)),
            "playFileInLoopFromPosition": lambda path, at, *levels: self._from(
                path, at, True, *_levels(levels)
            ),
            "pause": self._pause,
            "stop": self.stop,
            "stopAll": self.stop_all,
            "goTo": self._go_to,
            "getFileLength": lambda key: self._file(key).seconds,
            "getCurrentPosition": lambda key: self._file(key).place,
            "setVolume": self._set_volume,
            "getVolume": lambda key: self._file(key).volume,
            "setMasterVolume": self._set_master,
            "getMasterVolume": lambda: self._master,
            "playSine": self._sine,
            "getInstalledSoundSetsList": _no_sets,
            "getLoadedSoundSetsList": _no_sets,
        }

    def device_methods(self) -> Table:
        """Methods of `ALAudioDevice`."""

        def put(volume: Any) -> None:
            self._output = round(number(volume, "ALAudioDevice.setOutputVolume: volume", 0.0, 100.0))

        def mute(muted: Any) -> None:
            self._muted = flag(muted, "ALAudioDevice.muteAudioOut: muted")

        return {
            "setOutputVolume": put,
            "getOutputVolume": lambda: self._output,
            "muteAudioOut": mute,
            "isAudioOutMuted": lambda: self._muted,
            "playSine": self._sine,
        }


def _no_sets() -> list[str]:
    return []


def _levels(levels: tuple[Any, ...]) -> tuple[Any, ...]:
    if len(levels) > 2:
        raise NaoqiRefused("ALAudioPlayer takes a volume and a panorama at most.")
    return levels


SAMPLES: Final = {48_000: 4096, 16_000: 1365}
"""Samples of a channel in one buffer by the rate, Hz: 85 ms."""
ALL: Final = 4
"""Channels that the number 0 stands for; 1 to 4 are one each: left, right, front, rear."""
MAX_MODULES: Final = 100


@dataclass
class _Listener:
    channels: int = ALL
    rate: int = 48_000
    due: float | None = None
    """When it gets its next buffer, the robot's clock, ms; None: it has not subscribed."""


class Microphones:
    """Buffers of silence for each module; not thread-safe, the caller locks.

    Args:
        publish: calls the modules.
    """

    def __init__(self, publish: Publish) -> None:
        self._publish = publish
        self._listeners: dict[str, _Listener] = {}

    def update(self, now: int) -> None:
        """One cycle, at `now` of the robot's clock, ms."""
        for module, one in self._listeners.items():
            if one.due is None or now < one.due:
                continue
            samples = SAMPLES[one.rate]
            one.due = max(one.due, now - 1000.0) + 1000.0 * samples / one.rate
            seconds, part = divmod(time.time(), 1.0)
            stamp, sound = [int(seconds), int(1e6 * part)], bytes(2 * one.channels * samples)
            self._publish("", None, [[module, "processRemote", [one.channels, samples, stamp, sound]]])

    def _of(self, module: Any, method: str) -> _Listener:
        name = text(module, f"ALAudioDevice.{method}: module")
        if name not in self._listeners and len(self._listeners) >= MAX_MODULES:
            raise NaoqiRefused(f"ALAudioDevice.{method}: {MAX_MODULES} modules listen already.")
        return self._listeners.setdefault(name, _Listener())

    def _prefer(self, module: Any, rate: Any, channels: Any, *_: Any) -> None:
        if rate not in list(SAMPLES) or channels not in list(range(ALL + 1)):
            raise NaoqiRefused(
                f"ALAudioDevice.setClientPreferences: {rate!r:.40} and {channels!r:.40} were given; a rate of "
                "16000 or 48000 Hz, and channels 0 (all) to 4 are expected."
            )
        listener = self._of(module, "setClientPreferences")
        listener.rate, listener.channels = int(rate), 1 if channels else ALL

    def _subscribe(self, module: Any) -> None:
        self._of(module, "subscribe").due = 0.0

    def _unsubscribe(self, module: Any) -> None:
        self._listeners.pop(text(module, "ALAudioDevice.unsubscribe: module"), None)

    def methods(self) -> Table:
        """Methods of `ALAudioDevice`."""
        return {
            "setClientPreferences": self._prefer,
            "subscribe": self._subscribe,
            "unsubscribe": self._unsubscribe,
        }


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
