"""ALAudioPlayer, ALAudioDevice and ALAudioRecorder without loudspeakers and microphones.

A file is played silently for its duration; recordings and buffers are silence.
"""

from __future__ import annotations

import itertools
import logging
import wave
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final
from weakref import WeakKeyDictionary

from bridge.adapters.naoqi.core.memory import stamp
from bridge.adapters.naoqi.core.motion_tasks import MotionTask
from bridge.adapters.naoqi.core.served import ServedRobot, Service
from bridge.adapters.naoqi.declared import Duration, Own, Range, Setting, number, offers, text
from bridge.adapters.naoqi.robot_files import NewFile, RobotFile, in_thread
from bridge.errors import NaoqiRefused

logger = logging.getLogger(__name__)

MAX_FILES: Final = 1000
_OWN_SOUNDS: Final = Path("/usr/share/naoqi/wav")
_OWN_SECONDS: Final = 5.0
"""Duration of each of the robot's own sounds, s (assumed)."""
_POLL_INTERVAL: Final = 50
"""ms between two checks for a stop."""


@dataclass
class _File:
    """A loaded file."""

    path: Path
    seconds: float = 0.0
    volume: float = 1.0
    place: float = 0.0
    """Present position, s."""
    playing: int = 0
    """Number of the call that plays it; 0: none."""
    paused: bool = False


Level = Annotated[float, Range(0.0, 1.0)]
Side = Annotated[float, Range(-1.0, 1.0)]
"""Panorama: -1 left, 1 right."""
Loaded = Annotated[_File, Own("_file")]
"""A file by its number of `loadFile`."""


class AudioPlayer(Service):
    """Silent player of WAV files of this machine."""

    master = Setting("ALAudioPlayer.MasterVolume", 1.0, Level, inert=True)
    output = Setting("ALAudioDevice.OutputVolume", 100, Annotated[int, Range(0.0, 100.0)], inert=True)

    def __init__(self, robot: ServedRobot) -> None:
        super().__init__(robot)
        self._files: dict[int, _File] = {}
        self._played_by: WeakKeyDictionary[Future[Any], int] = WeakKeyDictionary()
        """File of each call of `playFile`."""
        self._plays = itertools.count(1)
        self._muted = False

    @offers("ALAudioPlayer.loadFile")
    def load(self, path: RobotFile) -> Future[int]:
        """Load a file; its number. One that is missing or no WAV file has no duration, with a warning."""
        return self._load(path)[1]

    def _load(self, path: Path) -> tuple[int, Future[int]]:
        """Number of a file, and the end of its loading."""
        if len(self._files) >= MAX_FILES:
            raise NaoqiRefused(f"ALAudioPlayer: {MAX_FILES} files are loaded already; unload some.")
        key, file = next(self._robot.numbers), _File(path)
        self._files[key] = file
        if path.parent == _OWN_SOUNDS and not _OWN_SOUNDS.is_dir():
            file.seconds = _OWN_SECONDS
            loaded: Future[int] = Future()
            loaded.set_result(key)
            return key, loaded

        def store(seconds: float) -> int:
            file.seconds = seconds
            return key

        return key, self.files.load(path, _duration, store)

    def _file(self, key: Any) -> _File:
        if isinstance(key, bool) or not isinstance(key, int) or key not in self._files:
            raise NaoqiRefused(f"ALAudioPlayer: {key!r:.40} is no file that loadFile gave.")
        return self._files[key]

    @offers("ALAudioPlayer.play")
    @offers("ALAudioPlayer.playInLoop", loop=True)
    def play(
        self, file: Loaded, volume: Level = 1.0, panorama: Side = 0.0, *, loop: bool = False
    ) -> Future[Any]:
        """Play a loaded file from its present position; waits for its end or stop."""
        file.volume = volume
        return self._others.begin(self._played(file, loop))

    @offers("ALAudioPlayer.playFile")
    @offers("ALAudioPlayer.playFileInLoop", loop=True)
    def play_file(
        self, path: RobotFile, volume: Level = 1.0, panorama: Side = 0.0, *, loop: bool = False
    ) -> Future[Any]:
        """Load a file and play it."""
        return self.play_from(path, 0.0, volume, loop=loop)

    @offers("ALAudioPlayer.playFileFromPosition")
    @offers("ALAudioPlayer.playFileInLoopFromPosition", loop=True)
    def play_from(
        self,
        path: RobotFile,
        position: Duration,
        volume: Level = 1.0,
        panorama: Side = 0.0,
        *,
        loop: bool = False,
    ) -> Future[Any]:
        """Load a file and play it from a position, s."""
        key, loaded = self._load(path)
        file = self._files[key]
        file.volume, file.place = volume, position
        playing = self._others.begin(self._played(file, loop, loaded))
        self._played_by[playing] = key
        return playing

    def name_by_call(self, playing: Future[Any], number: int) -> None:
        """Also name a file by the number of its `playFile` call (confirmed: vendor's samples)."""
        if playing in self._played_by:
            self._files[number] = self._files[self._played_by.pop(playing)]

    def _played(self, file: _File, loop: bool, loaded: Future[int] | None = None) -> MotionTask:
        file.playing = mine = next(self._plays)
        file.paused = False
        while loaded is not None and not loaded.done():
            yield self._now() + 1
        logger.info("the robot would play %s", file.path)
        while file.playing == mine:
            before = self._now()
            left = round(1000.0 * (file.seconds - file.place))
            yield before + max(1, min(_POLL_INTERVAL, left))
            if not file.paused:
                file.place += 0.001 * (self._now() - before)
            if file.place >= file.seconds:
                file.place = 0.0
                if not loop or file.seconds == 0.0:
                    break
        if file.playing == mine:
            file.playing = 0
        return None

    @offers("ALAudioPlayer.pause")
    def _pause(self, file: Loaded) -> None:
        file.paused = not file.paused

    @offers("ALAudioPlayer.stop")
    def stop(self, key: Any) -> None:
        """Stop a file; calls that wait for it return."""
        file = self._file(key)
        file.playing, file.place = 0, 0.0

    @offers("ALAudioPlayer.stopAll")
    def stop_all(self) -> None:
        """Stop all files."""
        for key in self._files:
            self.stop(key)

    @offers("ALAudioPlayer.unloadFile")
    def _unload(self, key: Any) -> None:
        self.stop(key)
        del self._files[key]

    @offers("ALAudioPlayer.unloadAllFiles")
    def _unload_all(self) -> None:
        self.stop_all()
        self._files.clear()

    @offers("ALAudioPlayer.playSine", "ALAudioDevice.playSine")
    def _sine(
        self,
        frequency: Annotated[float, Range(0.0, 20_000.0)],
        gain: Annotated[float, Range(0.0, 100.0)],
        panorama: Side,
        duration: Duration,
    ) -> Future[Any]:

        def task() -> MotionTask:
            yield self._now() + round(1000.0 * duration)

        return self._others.begin(task())

    @offers("ALAudioPlayer.setVolume")
    def _set_volume(self, file: Loaded, volume: Level) -> None:
        file.volume = volume

    @offers("ALAudioPlayer.goTo")
    def _go_to(self, file: Loaded, place: Any) -> None:
        file.place = number(place, "ALAudioPlayer.goTo: position", 0.0, file.seconds)

    @offers("ALAudioPlayer.getFileLength")
    def _get_file_length(self, file: Loaded) -> float:
        return file.seconds

    @offers("ALAudioPlayer.getCurrentPosition")
    def _get_current_position(self, file: Loaded) -> float:
        return file.place

    @offers("ALAudioPlayer.getVolume")
    def _get_volume(self, file: Loaded) -> float:
        return file.volume

    @offers("ALAudioDevice.muteAudioOut")
    def _mute_audio_out(self, muted: bool) -> Any:
        self._muted = muted

    _get_loaded_files_ids = offers("ALAudioPlayer.getLoadedFilesIds")(lambda self: list(self._files))
    _get_loaded_files_names = offers("ALAudioPlayer.getLoadedFilesNames")(
        lambda self: [str(file.path) for file in self._files.values()]
    )
    _is_audio_out_muted = offers("ALAudioDevice.isAudioOutMuted")(lambda self: self._muted)


SAMPLES: Final = {48_000: 4096, 16_000: 1365}
"""Samples of a channel in one buffer by the rate, Hz: 85 ms."""
ALL_CHANNELS: Final = 4
"""Channels of the number 0; 1 to 4 are one each: left, right, front, rear."""
MAX_MODULES: Final = 100


@dataclass
class _Listener:
    channels: int = ALL_CHANNELS
    rate: int = 48_000
    due: float | None = None
    """Time of its next buffer, the robot's clock, ms; None: no subscription."""


class Microphones(Service):
    """Buffers of silence for each module."""

    def __init__(self, robot: ServedRobot) -> None:
        super().__init__(robot)
        self._listeners: dict[str, _Listener] = {}

    def update(self, now: int) -> None:
        """Send the buffers due at `now` of the robot's clock, ms."""
        for module, one in self._listeners.items():
            if one.due is None or now < one.due:
                continue
            samples = SAMPLES[one.rate]
            one.due = max(one.due, now - 1000.0) + 1000.0 * samples / one.rate
            sound = bytes(2 * one.channels * samples)
            self._robot.publish("", None, [[module, "processRemote", [one.channels, samples, stamp(), sound]]])

    def _of(self, module: Any, method: str) -> _Listener:
        name = text(module, f"ALAudioDevice.{method}: module")
        if name not in self._listeners and len(self._listeners) >= MAX_MODULES:
            raise NaoqiRefused(f"ALAudioDevice.{method}: {MAX_MODULES} modules listen already.")
        return self._listeners.setdefault(name, _Listener())

    @offers("ALAudioDevice.setClientPreferences")
    def _prefer(self, module: Any, rate: Any, channels: Any, *_: Any) -> None:
        if rate not in list(SAMPLES) or channels not in list(range(ALL_CHANNELS + 1)):
            raise NaoqiRefused(
                f"ALAudioDevice.setClientPreferences: {rate!r:.40} and {channels!r:.40} were given; a rate of "
                "16000 or 48000 Hz, and channels 0 (all) to 4 are expected."
            )
        listener = self._of(module, "setClientPreferences")
        listener.rate, listener.channels = int(rate), 1 if channels else ALL_CHANNELS

    @offers("ALAudioDevice.subscribe")
    def _subscribe(self, module: Any) -> None:
        self._of(module, "subscribe").due = 0.0

    @offers("ALAudioDevice.unsubscribe")
    def _unsubscribe(self, module: str) -> None:
        self._listeners.pop(module, None)


def _duration(path: Path) -> float:
    """Duration of a WAV file, s; 0 with a warning: there is none."""
    try:
        if path.exists() and not path.is_file():
            raise wave.Error
        with wave.open(str(path), "rb") as sound:
            return sound.getnframes() / max(1, sound.getframerate())
    except (OSError, ValueError, wave.Error, EOFError) as error:
        reason = getattr(error, "strerror", None) or "no WAV file"
        logger.warning("ALAudioPlayer: %.80s is left out (%s)", path, reason)
        return 0.0


_ALLOWED_FORMATS: Final = ((4, 48_000), (1, 16_000))
"""Channels and rate, Hz (vendor's page)."""
MAX_SECONDS: Final = 600.0
"""Longest silence of a file, s."""


@dataclass(frozen=True)
class _Recording:
    path: Path
    channels: int
    rate: int
    began: int
    """The robot's clock, ms."""


class Recorder(Service):
    """Methods of `ALAudioRecorder` and of `ALAudioDevice`."""

    def __init__(self, robot: ServedRobot) -> None:
        super().__init__(robot)
        self._recording: _Recording | None = None

    @offers("ALAudioRecorder.startMicrophonesRecording")
    def _start(self, path: NewFile, kind: Any, rate: Any, channels: Any) -> None:
        method = "startMicrophonesRecording"
        if self._recording is not None:
            raise NaoqiRefused(f"{method}: {self._recording.path} is being recorded; stop that first.")
        if kind != "wav":
            raise NaoqiRefused(f"{method}: {kind!r:.40} is not written; wav is.")
        count = sum(map(bool, channels)) if isinstance(channels, list) else 0
        if (count, rate) not in _ALLOWED_FORMATS:
            raise NaoqiRefused(
                f"{method} takes 4 channels at 48000 Hz or one of [left, right, front, rear] at 16000 Hz."
            )
        self._recording = _Recording(path, count, rate, self._now())

    @offers("ALAudioDevice.startMicrophonesRecording")
    def _start_all(self, path: NewFile) -> None:
        self._start(path, "wav", 48_000, [1, 1, 1, 1])

    @offers("ALAudioRecorder.stopMicrophonesRecording", "ALAudioDevice.stopMicrophonesRecording")
    def _stop(self) -> Future[Any] | None:
        recording, self._recording = self._recording, None
        if recording is None:
            return None
        seconds = min(MAX_SECONDS, 0.001 * (self._now() - recording.began))
        return in_thread(lambda: _write(recording, seconds))


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
