"""ALAudioPlayer and the volume of ALAudioDevice: files are not heard, and take the time that they last."""

from __future__ import annotations

import itertools
import logging
import wave
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final
from weakref import WeakKeyDictionary

from bridge.adapters.naoqi.arguments import MAX_DURATION, flag, number, robot_file
from bridge.adapters.naoqi.methods import Table
from bridge.adapters.naoqi.motion_tasks import MotionTask, MotionTasks
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
