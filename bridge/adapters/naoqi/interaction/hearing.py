"""ALSpeechRecognition: recognizes words of its vocabulary in text."""

from __future__ import annotations

import re
from concurrent.futures import Future
from pathlib import Path
from typing import Annotated, Final

from bridge.adapters.naoqi.core.sensing import Extractor
from bridge.adapters.naoqi.core.served import ServedRobot
from bridge.adapters.naoqi.declared import OneOf, Parameters, Setting, offers
from bridge.adapters.naoqi.interaction.speech import LANGUAGES
from bridge.adapters.naoqi.robot_files import RobotFile
from bridge.errors import NaoqiRefused
from bridge.files import read_limited

MAX_WORDS: Final = 10_000
MAX_UTTERANCE: Final = 2000
"""Letters of an utterance."""
MAX_VOCABULARY: Final = 1 << 20
"""bytes of a vocabulary's file"""
_STATUS: Final = "ALSpeechRecognition/Status"
_PARAMETERS: Final = {"Sensitivity": (0.0, 1.0, 0.4), "NbHypotheses": (1.0, 10.0, 1.0)}
"""Parameter -> smallest, largest and initial value."""


class SpeechRecognition(Extractor):
    """Recognition of words, unless paused or without subscribers."""

    service, raised = "ALSpeechRecognition", ("WordRecognized", "LastWordRecognized", "SpeechDetected")
    language = Setting("ALSpeechRecognition.Language", "English", Annotated[str, OneOf("language", LANGUAGES)])
    parameters = Parameters("ALSpeechRecognition", _PARAMETERS)
    audio_expression = Setting("ALSpeechRecognition.AudioExpression", True, bool, inert=True)

    def __init__(self, robot: ServedRobot) -> None:
        super().__init__(robot)
        self._words: list[str] = []
        self._spots, self._paused = False, False
        self._pushed: list[tuple[list[str], bool]] = []
        """Stack of vocabularies."""

    def hear(self, said: str) -> list[str]:
        """Process an utterance of a person; the recognized words of the vocabulary, best first.

        Without word spotting the whole must be a word of the vocabulary; with it a part suffices.
        """
        if not self.running or self._paused:
            return []
        self._events.raise_event(_STATUS, "SpeechDetected")
        self._events.raise_event("SpeechDetected", True)
        plain = _plain(said[:MAX_UTTERANCE])
        known = {_plain(word): word for word in self._words}
        if self._spots:
            found = [word for key, word in known.items() if key and f" {key} " in f" {plain} "]
        else:
            found = [known[plain]] if plain in known else []
        found.sort(key=len, reverse=True)
        found = found[: round(self.parameters["NbHypotheses"])]
        if found:
            shown = [f"<...> {word} <...>" if self._spots else word for word in found]
            value = [item for i, word in enumerate(shown) for item in (word, 1.0 - 0.1 * i)]
            self._events.raise_event("WordRecognized", value)
            self._events.raise_event("LastWordRecognized", value)
        self._events.raise_event("SpeechDetected", False)
        self._events.raise_event(_STATUS, "EndOfProcess")
        return found

    @offers("ALSpeechRecognition.setVocabulary", "ALSpeechRecognition.setWordListAsVocabulary")
    def _set_words(self, words: list[str], spots: bool = False) -> None:
        if not words:
            raise NaoqiRefused("ALSpeechRecognition.setVocabulary: the list of words is empty.")
        if self.running and not self._paused and not self._pushed:
            raise NaoqiRefused(
                "ALSpeechRecognition.setVocabulary: it is running; pause(True) first, and pause(False) after."
            )
        self._spots = spots
        self._words = words[:MAX_WORDS]

    @offers("ALSpeechRecognition.loadVocabulary")
    def _load_words(self, path: RobotFile) -> Future[None]:

        def read(path: Path) -> list[str]:
            content = read_limited(path, MAX_VOCABULARY, "give a vocabulary (.lxd)").decode("utf-8", "replace")
            return re.findall(r'"([^"\n]+)"', content)

        return self.files.load(path, read, self._set_words)

    @offers("ALSpeechRecognition.pause")
    def _pause(self, paused: bool) -> None:
        self._paused = paused
        self._events.raise_event(_STATUS, "ListenOff" if self._paused else "ListenOn")

    @offers("ALSpeechRecognition.pushContexts")
    def _push(self) -> None:
        if len(self._pushed) < MAX_WORDS:
            self._pushed.append((self._words, self._spots))

    @offers("ALSpeechRecognition.popContexts")
    def _pop(self) -> None:
        if self._pushed:
            self._words, self._spots = self._pushed.pop()

    _get_available_languages = offers("ALSpeechRecognition.getAvailableLanguages")(lambda self: list(LANGUAGES))


def _plain(words: str) -> str:
    return " ".join(re.findall(r"\w+", words.casefold()))
