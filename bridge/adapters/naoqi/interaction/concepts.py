"""Concepts of ALDialog that programs set: words in place of those of a topic."""

from __future__ import annotations

from typing import Any, Final

from bridge.adapters.naoqi.declared import offers, text
from bridge.adapters.naoqi.interaction.qichat import Pattern, Topic, codes, of_words
from bridge.errors import NaoqiRefused

MAX_CONCEPTS: Final = 1000


class Concepts:
    """Words by concept and language; not thread-safe, the caller locks."""

    def __init__(self) -> None:
        self._words: dict[tuple[str, str], list[str]] = {}
        self._patterns: dict[tuple[str, str], Pattern] = {}

    def of(self, topic: Topic) -> dict[str, Pattern]:
        """Concepts of a topic by their lower-case names, with those of programs in its language."""
        own = {
            name.casefold(): pattern
            for (name, language), pattern in self._patterns.items()
            if topic.language in codes(language)
        }
        return topic.concepts | own

    def _key(self, concept: Any, language: Any) -> tuple[str, str]:
        key = text(concept, "ALDialog: concept"), text(language, "ALDialog: language")
        if key not in self._words and len(self._words) >= MAX_CONCEPTS:
            raise NaoqiRefused(f"ALDialog: {MAX_CONCEPTS} concepts are kept already.")
        return key

    @offers("ALDialog.setConcept")
    def _set_concept(self, concept: Any, language: Any, words: list[str], *_: Any) -> None:
        key = self._key(concept, language)
        self._store_concept(key, words[:MAX_CONCEPTS])

    def _store_concept(self, key: tuple[str, str], words: list[str]) -> None:
        self._words[key] = words
        self._patterns[key] = Pattern("choice", parts=tuple(of_words(word) for word in words))

    @offers("ALDialog.addToConcept")
    def _add_to_concept(self, concept: Any, language: Any, words: list[str]) -> None:
        key = self._key(concept, language)
        kept = self._words.get(key, [])
        self._store_concept(key, [*kept, *(word for word in words if word not in kept)][:MAX_CONCEPTS])

    @offers("ALDialog.clearConcepts")
    def _clear_concepts(self) -> None:
        self._words.clear()
        self._patterns.clear()

    @offers("ALDialog.getConcept")
    def _get_concept(self, concept: Any, language: Any) -> Any:
        return self._words.get(self._key(concept, language), [])
