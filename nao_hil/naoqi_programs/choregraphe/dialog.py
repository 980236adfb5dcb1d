"""The box of a dialogue: ALDialog answers by its topics; outputs are variables of them, inputs events."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from bridge.errors import ConfigurationError
from bridge.files import read_limited
from nao_hil.naoqi_programs.choregraphe.project import LiveBox

MAX_SIZE = 1 << 20
"""bytes of a topic or of the list of them."""


class DialogBox:
    """In the place of a script: Choregraphe makes one for each dialogue."""

    def __init__(self, running: LiveBox) -> None:
        self._running, self._player = running, running.player
        self._name = f"choregraphe {id(self)}"
        self._topics: list[str] = []
        """Loaded ones."""

    def onLoad(self) -> None:
        """Listen to the variables of the outputs."""
        for output in self._running.box.outputs.values():
            self._player.subscribe(output, partial(self._set, output))
        self._player.subscribe("Dialog/Answered", lambda _: None)  # a conversation is something that runs

    def _set(self, output: str, value: Any) -> None:
        if not self._topics:
            return
        if output == "onStopped":
            self.onUnload()
        self._running.emit(output, value)

    def onInput_onStart(self) -> None:
        """Let the topic of the present language answer; those of others may have its name."""
        dialog = self._player.services("ALDialog")
        language = self._player.services("ALTextToSpeech").getLanguage()
        for text in topics(self._player.folder / self._running.box.dialog):
            topic = dialog.loadTopicContent(text)
            if topic in dialog.getLoadedTopics(language):
                self._topics.append(topic)
                dialog.activateTopic(topic)
                break
            dialog.unloadTopic(topic)
        else:
            self._player.cannot(f"the dialogue {self._running.box.name} has no topic in {language}")
        dialog.subscribe(self._name)
        self._raise("onStart", None)

    def onInput_onStop(self) -> None:
        """End it."""
        self.onUnload()
        self._running.emit("onStopped")

    def onUnload(self) -> None:
        """Take the topics out."""
        topics, self._topics = self._topics, []
        if topics:
            dialog = self._player.services("ALDialog")
            dialog.unsubscribe(self._name)
            for topic in topics:
                dialog.unloadTopic(topic)

    def _raise(self, event: str, value: Any) -> None:
        self._player.services("ALMemory").raiseEvent(event, 1 if value is None else value)

    def __getattr__(self, name: str) -> Callable[[Any], None]:
        """Another input: rules answer it as an event."""
        if not name.startswith("onInput_"):
            raise AttributeError(name)

        def stimulated(value: Any) -> None:
            self._raise(name.removeprefix("onInput_"), value)

        return stimulated


def topics(file: Path) -> list[str]:
    """Contents of the topics of a dialogue, one for each language.

    Args:
        file: `.dlg`, each line of which names a language and a file.

    Raises:
        ConfigurationError: a file is missing, or it names none.
    """
    files = re.findall(r"^\s+\w+:(.+?)\s*$", _read(file), re.MULTILINE)
    if not files:
        raise ConfigurationError(f"{file}: it names no topic.")
    return [_read(file.parent / name) for name in files]


def _read(file: Path) -> str:
    data = read_limited(file, MAX_SIZE, f"give a dialogue of at most {MAX_SIZE} bytes")
    return data.decode("utf-8-sig", "replace")
