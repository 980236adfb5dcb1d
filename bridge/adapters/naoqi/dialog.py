"""ALDialog on a robot to which nobody talks: topics are loaded and activated, and nothing is heard."""

from __future__ import annotations

import re
from typing import Any, Final

from bridge.adapters.naoqi.arguments import number, robot_file, text
from bridge.adapters.naoqi.methods import Table
from bridge.adapters.naoqi.voice import LANGUAGES
from bridge.errors import NaoqiRefused
from bridge.validation import unknown_name

_NAME: Final = re.compile(r"^\s*topic\s*:\s*~(\w+)\s*\(", re.MULTILINE)
_LANGUAGE: Final = re.compile(r"^\s*language\s*:\s*(\w+)", re.MULTILINE)
_THREE: Final = {"English": "enu", "French": "frf", "German": "ged", "Italian": "iti", "Spanish": "spe"}
"""Codes of topics' languages (assumed but for the first two)."""
MAX_TOPICS: Final = 1000
MAX_TOPIC: Final = 1 << 20
"""Bytes of a topic."""


class Dialog:
    """Methods of the service; not thread-safe, the caller locks."""

    def __init__(self) -> None:
        self._topics: dict[str, str] = {}
        """Topic -> its language, as its file has it."""
        self._active: list[str] = []
        self._concepts: dict[tuple[str, str], list[str]] = {}
        self._focus, self._language, self._threshold = "", "English", 0.5

    def _load_file(self, path: Any) -> str:
        file = robot_file(path, "ALDialog.loadTopic: path")
        try:
            with file.open("rb") as source:
                content = source.read(MAX_TOPIC + 1)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise NaoqiRefused(f"ALDialog.loadTopic: {str(path)!r:.80} cannot be read ({reason}).") from None
        return self._load(content.decode("utf-8", "replace"))

    def _load(self, content: Any) -> str:
        source = text(content, "ALDialog.loadTopicContent: content")
        found = _NAME.search(source[:MAX_TOPIC])
        if found is None:
            raise NaoqiRefused("ALDialog: this is no topic; `topic: ~name()` is expected in it.")
        if len(self._topics) >= MAX_TOPICS:
            raise NaoqiRefused(f"ALDialog: {MAX_TOPICS} topics are loaded already; unload some.")
        language = _LANGUAGE.search(source[:MAX_TOPIC])
        self._topics[found[1]] = language[1] if language else "enu"
        return found[1]

    def _loaded(self, name: Any) -> str:
        topic = text(name, "ALDialog: topic")
        if topic not in self._topics:
            raise NaoqiRefused(f"ALDialog: {unknown_name('topic', topic, self._topics)}.")
        return topic

    def _activate(self, name: Any) -> None:
        if self._loaded(name) not in self._active:
            self._active.append(name)

    def _deactivate(self, name: Any) -> None:
        if self._loaded(name) in self._active:
            self._active.remove(name)

    def _unload(self, name: Any) -> None:
        self._deactivate(name)
        del self._topics[name]

    def _set_focus(self, name: Any) -> None:
        self._focus = self._loaded(name)

    def _set_language(self, language: Any) -> None:
        if text(language, "ALDialog.setLanguage: language") not in LANGUAGES:
            raise NaoqiRefused(f"ALDialog.setLanguage: {unknown_name('language', language, LANGUAGES)}.")
        self._language = language

    def _set_threshold(self, value: Any, *_: Any) -> None:
        self._threshold = number(value, "ALDialog.setASRConfidenceThreshold: threshold", 0.0, 1.0)

    def _key(self, concept: Any, language: Any) -> tuple[str, str]:
        key = text(concept, "ALDialog: concept"), text(language, "ALDialog: language")
        if key not in self._concepts and len(self._concepts) >= MAX_TOPICS:
            raise NaoqiRefused(f"ALDialog: {MAX_TOPICS} concepts are kept already.")
        return key

    def _set_concept(self, concept: Any, language: Any, words: Any, *_: Any) -> None:
        self._concepts[self._key(concept, language)] = _words(words)

    def _add_to_concept(self, concept: Any, language: Any, words: Any) -> None:
        kept = self._concepts.setdefault(self._key(concept, language), [])
        kept += [word for word in _words(words) if word not in kept][: MAX_TOPICS - len(kept)]

    def methods(self) -> Table:
        """Methods of the service."""
        return {
            "loadTopic": self._load_file,
            "loadTopicContent": self._load,
            "unloadTopic": self._unload,
            "activateTopic": self._activate,
            "deactivateTopic": self._deactivate,
            "getAllLoadedTopics": lambda: list(self._topics),
            "getLoadedTopics": lambda language: [t for t, of in self._topics.items() if of in _codes(language)],
            "getActivatedTopics": lambda: list(self._active),
            "subscribe": lambda name: text(name, "ALDialog.subscribe: name") and None,
            "unsubscribe": lambda name: text(name, "ALDialog.unsubscribe: name") and None,
            "getFocus": lambda: self._focus,
            "setFocus": self._set_focus,
            "setLanguage": self._set_language,
            "getASRConfidenceThreshold": lambda: self._threshold,
            "setASRConfidenceThreshold": self._set_threshold,
            "getConcept": lambda concept, language: self._concepts.get(self._key(concept, language), []),
            "setConcept": self._set_concept,
            "addToConcept": self._add_to_concept,
        }


def _words(words: Any) -> list[str]:
    if not isinstance(words, list) or not all(isinstance(word, str) for word in words):
        raise NaoqiRefused(f"ALDialog: {words!r:.60} was given; a list of words is expected.")
    return words[:MAX_TOPICS]


def _codes(language: Any) -> set[str]:
    """How topics name a language: by its name, or by a code."""
    name = text(language, "ALDialog.getLoadedTopics: language")
    return {name, _THREE.get(name, name)}
