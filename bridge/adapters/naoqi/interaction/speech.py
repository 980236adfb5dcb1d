"""ALTextToSpeech and ALAnimatedSpeech: speech in the log and in events, with its duration.

Where espeak-ng is installed, this machine speaks. Animated speech plays the animations that its text starts.
"""

from __future__ import annotations

import itertools
import logging
import shutil
import subprocess
from collections.abc import Callable, Generator
from concurrent.futures import Future
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Final

import msgspec

from bridge.adapters.naoqi.core.motion_tasks import MotionTask
from bridge.adapters.naoqi.core.served import ServedRobot, Service
from bridge.adapters.naoqi.declared import OneOf, Parameters, Range, Setting, offers, text
from bridge.adapters.naoqi.interaction.utterance import SPEEDS, Function, Utterance, utterance
from bridge.adapters.naoqi.robot_files import NewFile, in_thread
from bridge.config import read_toml
from bridge.errors import NaoqiRefused
from bridge.validation import convert

PROGRAM: Final = "espeak-ng"
_WORDS_PER_MINUTE: Final = 150


class _Language(msgspec.Struct, frozen=True):
    voice: str
    """Name of a voice of espeak-ng."""
    code: str
    """In topics of dialogues (assumed: names of topics in public projects)."""


LANGUAGES: Final = convert(read_toml(Path(__file__).with_name("languages.toml")), dict[str, _Language])
"""By the name in NAOqi."""


class Voice:
    """Speech by espeak-ng; silent without it."""

    def __init__(self) -> None:
        self._program = shutil.which(PROGRAM)

    def speak(self, text: str, language: str, speed: float, volume: float) -> subprocess.Popen[bytes] | None:
        """Begin to speak; the process ends with the sound. None: no voice.

        Args:
            language: one of `LANGUAGES`.
            speed: per cent.
            volume: 0 to 1.
        """
        if self._program is None or not text:
            return None
        options = self._options(language, speed, volume)
        return subprocess.Popen(
            [self._program, *options, "--", text], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )

    def write(self, text: str, language: str, speed: float, volume: float, path: Path) -> None:
        """Write the speech to a WAV file."""
        if self._program is None:
            raise NaoqiRefused(f"ALTextToSpeech.sayToFile needs {PROGRAM}, which is not installed.")
        command = [self._program, *self._options(language, speed, volume), "-w", str(path), "--", text]
        done = subprocess.run(command, capture_output=True, timeout=60.0, check=False)
        if done.returncode or not path.is_file():
            raise NaoqiRefused(f"ALTextToSpeech.sayToFile: {path} cannot be written.")

    def _options(self, language: str, speed: float, volume: float) -> list[str]:
        rate = round(_WORDS_PER_MINUTE * speed / 100.0)
        return ["-v", LANGUAGES[language].voice, "-s", str(rate), "-a", str(round(100.0 * volume))]


logger = logging.getLogger(__name__)

VOICES: Final = ("naoenu", "naofrf", "Kenny22Enhanced", "Julie22Enhanced")
"""Names of the vendor's voices, all for the one voice."""
MAX_WAITING: Final = 100
"""Waiting sentences at most."""
MAX_TEXT: Final = 20_000
"""Letters of one text."""
_POLL_INTERVAL: Final = 50
"""ms between two checks for the end of the voice."""
_PARAMETERS: Final[dict[str, tuple[float, float, float]]] = {
    "speed": (*SPEEDS, 100.0),
    "defaultVoiceSpeed": (*SPEEDS, 100.0),
    "pitchShift": (0.0, 4.0, 0.0),
    "doubleVoice": (0.0, 4.0, 0.0),
    "doubleVoiceLevel": (0.0, 4.0, 0.0),
    "doubleVoiceTimeShift": (0.0, 0.5, 0.0),
}
"""Parameter -> smallest, largest and initial value (confirmed: vendor's page)."""
_MODES: Final = {0: "disabled", 1: "random", 2: "contextual"}
SPOKEN_PREFIX: Final = "the robot speaks:"
"""Beginning of the log's line of each text."""
_PREFIX: Final = "ALTextToSpeech"


Language = Annotated[str, OneOf("language", LANGUAGES)]


def _mode(mode: Any, _: str = "") -> int:
    """A mode of body language by its number or its name."""
    for code, name in _MODES.items():
        if mode == name or (mode == code and not isinstance(mode, bool)):
            return code
    raise NaoqiRefused(f"ALAnimatedSpeech: {mode!r:.40} is no mode; {', '.join(_MODES.values())} are.")


Mode = Annotated[int, _mode]


class Speech(Service):
    """Speech of one text after the other.

    Args:
        animate: begins an animation or a behaviour by its name; done at its end, None: its end is not known.
    """

    language = Setting("ALTextToSpeech.Language", "English", Language)
    volume = Setting("ALTextToSpeech.Volume", 1.0, Annotated[float, Range(0.0, 1.0)])
    voice = Setting(
        "ALTextToSpeech.Voice",
        VOICES[0],
        Annotated[str, OneOf("voice", VOICES)],
    )

    parameters = Parameters("ALTextToSpeech", _PARAMETERS)

    def __init__(self, robot: ServedRobot, animate: Callable[[str], Future[Any] | None]) -> None:
        super().__init__(robot)
        self._animate = animate
        self._voice = Voice()
        self._numbers = itertools.count(1)
        self._waiting: list[int] = []
        """Numbers of the present text and the waiting ones."""
        self._mode = 2
        self._notifies = True

    @offers("ALTextToSpeech.say")
    def say(self, sentence: Any, language: Language | None = None) -> Future[Any]:
        """Speak a text; waits for its end."""
        spoken = self._text(sentence, "ALTextToSpeech.say")
        return self._begin(replace(spoken, functions=()), language or self.language)

    def answer(self, sentence: str) -> Future[Any]:
        """Speak an answer of a dialogue with its animations."""
        return self._begin(self._text(sentence, "ALDialog"), self.language)

    @offers("ALAnimatedSpeech.say")
    def say_animated(self, sentence: Any, settings: Any = None) -> Future[Any]:
        """Speak a text and play the animations that `^start` and `^run` in it name; waits for its end."""
        spoken = self._text(sentence, "ALAnimatedSpeech.say")
        if settings is not None and not isinstance(settings, dict):
            raise NaoqiRefused(
                f"ALAnimatedSpeech.say: {settings!r:.60} was given; a configuration as "
                '{"bodyLanguageMode": "disabled"} is expected.'
            )
        if settings and "bodyLanguageMode" in settings:
            _mode(settings["bodyLanguageMode"])
        return self._begin(spoken, self.language, "ALAnimatedSpeech/EndOfAnimatedSpeech")

    def _text(self, sentence: Any, method: str) -> Utterance:
        spoken = text(str(sentence) if isinstance(sentence, int | float) else sentence, f"{method}: text")
        if len(spoken) > MAX_TEXT or len(self._waiting) >= MAX_WAITING:
            raise NaoqiRefused(
                f"{method} takes {MAX_TEXT} letters at once, and {MAX_WAITING} texts that wait to be spoken."
            )
        return utterance(spoken, self.parameters["speed"])

    def _begin(self, spoken: Utterance, language: str, event: str = "") -> Future[Any]:
        number_ = next(self._numbers)
        self._waiting.append(number_)
        self._raise("Status", [number_, "enqueued"])
        return self._others.begin(self._spoken(number_, spoken, language, event))

    def _spoken(self, number_: int, spoken: Utterance, language: str, event: str) -> MotionTask:
        while self._waiting and self._waiting[0] != number_ and number_ in self._waiting:
            yield self._now() + _POLL_INTERVAL
        if number_ not in self._waiting:
            return None
        if spoken.plain:
            logger.info("%s %.500r", SPOKEN_PREFIX, spoken.plain)
        self._raise("CurrentSentence", spoken.plain)
        self._raise("TextStarted", 1)
        self._raise("Status", [number_, "started"])
        process = self._voice.speak(spoken.plain, language, self.parameters["speed"], self.volume)
        try:
            ended = yield from self._words(number_, spoken, process)
        finally:
            if process is not None and process.poll() is None:
                process.kill()
            if number_ in self._waiting:
                self._waiting.remove(number_)
        self._raise("TextDone" if ended else "TextInterrupted", 1)
        self._raise("Status", [number_, "done" if ended else "stopped"])
        if event:
            self._events.raise_event(event, number_)
        return None

    def _words(
        self, number_: int, spoken: Utterance, process: subprocess.Popen[bytes] | None
    ) -> Generator[int, None, bool]:
        """Raise the words' events at their times; False after a stop."""
        began = self._now()
        played: dict[str, Future[Any] | None] = {}
        for i, word in enumerate((*spoken.words, None)):
            for function in (f for f in spoken.functions if f.place == i):
                awaited, paused = self._perform(function, played), self._now()
                while awaited is not None and not awaited.done():
                    yield self._now() + _POLL_INTERVAL
                    if number_ not in self._waiting:
                        return False
                began += self._now() - paused
            if word is None:
                break
            due = began + round(1000.0 * word.begin)
            while self._now() < due:
                yield min(due, self._now() + _POLL_INTERVAL)
                if number_ not in self._waiting:
                    return False
            if word.bookmark is not None:
                self._raise("CurrentBookMark", word.bookmark)
            self._raise("CurrentWord", word.text)
            self._raise("PositionOfCurrentWord", word.place)
        end = began + round(1000.0 * spoken.seconds)
        while self._sounds(process, end):
            yield self._now() + _POLL_INTERVAL
            if number_ not in self._waiting:
                return False
        return True

    def _perform(self, function: Function, played: dict[str, Future[Any] | None]) -> Future[Any] | None:
        """Carry out a function of a text; the animation that the text waits for."""
        kind, name = function.name.removesuffix("Tag"), function.argument
        if kind != function.name:
            name = f"animations/Stand/Gestures/{name}"
        if kind in ("start", "run"):
            played[name] = self._animate(name)
        return played.get(name) if kind in ("run", "wait") else None

    def _sounds(self, process: subprocess.Popen[bytes] | None, end: int) -> bool:
        """Whether the voice still speaks; without a working one, whether it would."""
        state = None if process is None else process.poll()
        return self._now() < end if process is None or state else state is None

    def _raise(self, event: str, value: Any) -> None:
        if self._notifies:
            self._events.raise_event(f"{_PREFIX}/{event}", value)

    @offers("ALTextToSpeech.sayToFile")
    def _to_file(self, sentence: Any, path: NewFile) -> Future[Any]:
        spoken = self._text(sentence, "ALTextToSpeech.sayToFile")
        settings = (self.language, self.parameters["speed"], self.volume)
        return in_thread(lambda: self._voice.write(spoken.plain, *settings, path))

    @offers("ALTextToSpeech.stopAll")
    def stop_all(self) -> None:
        """Stop the present text and drop the waiting ones; their calls return."""
        self._waiting.clear()

    def _notify(self, enabled: bool) -> None:
        self._notifies = enabled

    @offers("ALAnimatedSpeech.setBodyLanguageMode", "ALAnimatedSpeech.setBodyLanguageModeFromStr")
    def _set_body_language_mode(self, mode: Mode) -> None:
        self._mode = mode

    @offers("ALAnimatedSpeech.setBodyLanguageEnabled", "ALAnimatedSpeech.setBodyTalkEnabled")
    def _set_body_language_enabled(self, enabled: bool) -> Any:
        self._mode = 2 if enabled else 0

    _get_supported_languages = offers(
        "ALTextToSpeech.getSupportedLanguages", "ALTextToSpeech.getAvailableLanguages"
    )(lambda self: list(LANGUAGES))
    _get_available_voices = offers("ALTextToSpeech.getAvailableVoices")(lambda self: list(VOICES))
    _reset_speed = offers("ALTextToSpeech.resetSpeed")(lambda self: self.parameters.update(speed=100.0))
    _locale = offers("ALTextToSpeech.locale")(lambda self: LANGUAGES[self.language].voice)
    _enable_notifications = offers("ALTextToSpeech.enableNotifications")(lambda self: self._notify(True))
    _disable_notifications = offers("ALTextToSpeech.disableNotifications")(lambda self: self._notify(False))
    _get_body_language_mode = offers("ALAnimatedSpeech.getBodyLanguageMode")(lambda self: self._mode)
    _get_body_language_mode_to_str = offers("ALAnimatedSpeech.getBodyLanguageModeToStr")(
        lambda self: _MODES[self._mode]
    )
    _is_body_language_enabled = offers(
        "ALAnimatedSpeech.isBodyLanguageEnabled", "ALAnimatedSpeech.isBodyTalkEnabled"
    )(lambda self: self._mode != 0)
