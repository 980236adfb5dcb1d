"""ALDialog: topics in QiChat, whose rules answer speech and events."""

from __future__ import annotations

import logging
import re
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from pathlib import Path
from typing import Annotated, Any, Final

from bridge.adapters.naoqi.core.served import ServedRobot, Service
from bridge.adapters.naoqi.declared import Range, offers, text
from bridge.adapters.naoqi.interaction.qichat import (
    Pattern,
    Rule,
    Steps,
    Topic,
    captures,
    codes,
    of_words,
    parse,
    with_kept,
    words_of,
)
from bridge.adapters.naoqi.interaction.speech import LANGUAGES
from bridge.adapters.naoqi.robot_files import RobotFile
from bridge.errors import NaoHilError, NaoqiRefused
from bridge.files import read_limited
from bridge.validation import unknown_name

logger = logging.getLogger(__name__)

MAX_TOPICS: Final = 100
MAX_TOPIC: Final = 1 << 16
"""Letters of a topic."""
MAX_ANSWER: Final = 2000
"""Letters of an answer."""
_MAX_JUMPS: Final = 20
"""`^goto` and its like in one answer."""
_JUMP: Final = re.compile(
    r"\^goto(?:Reactivate|(?P<random>Random))?\(\s*(?P<tag>\w+)\s*\)|\^(?P<move>same|next|previous)Proposal\b"
)
_MOVES: Final = {"previous": -2, "same": -1, "next": 0}
"""From the proposal that would be next."""
_SILENT: Final = re.compile(r"%\w+|\^(?!(?:start|run|wait)(?:Tag)?\()\w+(?:\([^)]*\))?")
"""Tags, and functions other than those of animations."""
_FUNCTION: Final = re.compile(r"\^\w+\([^)]*\)")
_CHOICE: Final = re.compile(r"(\^\w+)?\s*\[([^\[\]]*)\]")
_SETS: Final = re.compile(r'\$([\w/]+)=(?!=)(?:"([^"]*)"|(\S+))')
_OPTION: Final = re.compile(r'"([^"]*)"|(\S+)')


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


class Dialog(Service):
    """Methods of the service, its input and its events.

    Args:
        speak: speaks an answer; done at its end.
    """

    def __init__(self, robot: ServedRobot, speak: Callable[[str], Future[Any]]) -> None:
        super().__init__(robot)
        self._speak = speak
        robot.listeners.append(self.answer_event)
        self._topics: dict[str, Topic] = {}
        self._active: list[str] = []
        self._subscribers: set[str] = set()
        self.concepts = Concepts()
        """Concepts that programs have defined."""
        self._blocked: set[tuple[str, str]] = set()
        """Topic and tag of each disabled proposal."""
        self._within: tuple[str, list[Rule]] = ("", [])
        """Topic and rules with priority after the last answer."""
        self._turns: Counter[tuple[str, ...]] = Counter()
        """Number of uses of each answer with alternatives."""
        self._answers = False
        self._focus, self._language, self._threshold = "", "English", 0.5

    def hear(self, said: str) -> None:
        """Answer an utterance of a person, if there is a subscriber."""
        if self._subscribers:
            self._input(said)

    def answer_event(self, event: str, value: Any) -> None:
        """Answer an event by the rules for it."""
        if not self._subscribers or self._answers:
            return
        for topic, rule in self._rules():
            wanted = [equals for name, equals in rule.events if name == event]
            if any(str(value) == equals if equals else bool(value) for equals in wanted) and self._holds(rule):
                self._answer(topic, rule, ())
                return

    def _rules(self) -> Iterator[tuple[Topic, Rule]]:
        """Rules of the active topics, by priority."""
        name, within = self._within
        order = [name for name in self._active if name == self._focus]
        order += [name for name in self._active if name != self._focus]
        for topic, rules in [(name, within), *((of, self._topics[of].rules) for of in order)]:
            if topic in self._active:
                yield from ((self._topics[topic], rule) for rule in rules if self._is_on(topic, rule.tags))

    def _is_on(self, topic: str, tags: tuple[str, ...]) -> bool:
        return not any((topic, tag) in self._blocked for tag in tags)

    def _holds(self, rule: Rule) -> bool:
        return all(str(self._value(name)) == value for name, value in rule.conditions)

    def _value(self, name: str) -> Any:
        try:
            return self._memory.get(name)
        except NaoHilError:
            return ""

    def _input(self, said: str) -> Future[Any] | None:
        """Answer an utterance; done at the end of the answer."""
        self._raise("LastInput", said)
        steps, concepts = Steps(), {name: self.concepts.of(self._topics[name]) for name in self._active}
        for topic, rule in self._rules():
            kept = captures(rule.pattern, said, concepts[topic.name], steps) if rule.pattern else None
            if kept is not None and self._holds(rule):
                self._raise("MatchedInput", said)
                self._raise("MatchedTopic", topic.name)
                return self._answer(topic, rule, kept)
        self._raise("NotUnderstood", said)
        return None

    def _answer(self, topic: Topic, rule: Rule, kept: tuple[str, ...]) -> Future[Any] | None:
        self._answers = True
        try:
            if rule.within or not any(rule is other for other in self._within[1]):
                self._within = topic.name, rule.within
            self._go_to(topic.name)
            if not self._is_on(topic.name, tuple(re.findall(r"%(\w+)", rule.answer))):
                return None
            answer, later = self._produced(topic, rule.answer, kept)
            for tag in re.findall(r"%(\w+)", rule.answer):
                self._raise("Tag", tag)
            if not answer:
                return None
            spoken = self._speak(answer)
            spoken.add_done_callback(lambda _: self._set(later))
            plain = _spaced(_FUNCTION.sub(" ", answer))
            self._raise("LastAnswer", plain)
            self._raise("Answered", plain)
            return spoken
        except NaoHilError as error:
            logger.warning("ALDialog: an answer is left out: %s", error)
            return None
        finally:
            self._answers = False

    def _set(self, values: dict[str, Any]) -> None:
        """Set variables; rules do not answer the events that they are."""
        answers, self._answers = self._answers, True
        for name, value in values.items():
            self._events.raise_event(name, value)
        self._answers = answers

    def _produced(self, topic: Topic, answer: str, kept: tuple[str, ...]) -> tuple[str, dict[str, Any]]:
        """Text of an answer, and variables to set after it: those behind a word (assumed); sets the others."""
        for _ in range(_MAX_JUMPS):
            jump = _JUMP.search(answer[:MAX_ANSWER])
            if jump is None:
                break
            goal = self._goal(topic, jump)
            answer = answer.replace(jump[0], goal.answer if goal else "", 1)
            if goal and goal.within:
                self._within = topic.name, goal.within
        answer = answer[:MAX_ANSWER]
        while found := _CHOICE.search(answer):
            options = [quoted or word for quoted, word in _OPTION.findall(found[2])] or [""]
            turn = 0 if found[1] == "^first" else self._turn(topic.name, found[2])
            answer = answer[: found.start()] + options[turn % len(options)] + answer[found.end() :]
        values: dict[str, Any] = {}
        now: dict[str, Any] = {}
        for setting in _SETS.finditer(answer):
            name, quoted, plain = setting.groups("")
            values[name] = _typed(with_kept(quoted or plain, kept))
            if not _SILENT.sub(" ", _SETS.sub(" ", answer[: setting.start()])).strip(' "'):
                now[name] = values[name]
        answer = with_kept(_SILENT.sub(" ", _SETS.sub(" ", answer)), kept)
        self._set(now)
        answer = re.sub(r"\$([A-Za-z_][\w/]*)", lambda m: str(values.get(m[1], self._value(m[1]))), answer)
        answer = re.sub(r"~(\w+)", lambda m: self._one_of(topic, m[1]), answer)
        answer = _spaced(answer.replace('"', " "))
        if not answer:
            self._set(values)
        return answer, {name: value for name, value in values.items() if name not in now}

    def _goal(self, topic: Topic, jump: re.Match[str]) -> Rule | None:
        """The rule or the proposal that a function of an answer leads to."""
        if jump["move"]:
            place = self._turns["proposal", topic.name] + _MOVES[jump["move"]]
            proposals = self._proposals(topic)
            goal = proposals[place] if 0 <= place < len(proposals) else None
        else:
            goals = self._tagged(topic, jump["tag"])
            turn = self._turn(topic.name, jump[0]) if jump["random"] else 0
            goal = goals[turn % len(goals)] if goals else None
        self._pass(topic, goal)
        return goal

    def _proposals(self, topic: Topic) -> list[Rule]:
        return [p for p in topic.proposals if self._is_on(topic.name, p.tags)]

    def _pass(self, topic: Topic, goal: Rule | None) -> None:
        """The proposal behind this one is the next one."""
        places = (i for i, proposal in enumerate(self._proposals(topic)) if proposal is goal)
        self._turns["proposal", topic.name] = next(places, self._turns["proposal", topic.name] - 1) + 1

    def _turn(self, *key: str) -> int:
        if len(self._turns) > MAX_CONCEPTS:
            self._turns.clear()
        self._turns[key] += 1
        return self._turns[key] - 1

    def _one_of(self, topic: Topic, concept: str) -> str:
        """A word of a concept, the next one each time."""
        found = self.concepts.of(topic).get(concept.casefold())
        if found is None or not found.parts:
            return ""
        parts = found.parts[0].parts if found.kind == "sequence" and len(found.parts) == 1 else found.parts
        return " ".join(words_of(parts[self._turn(topic.name, f"~{concept}") % len(parts)])) if parts else ""

    def _tagged(self, topic: Topic, tag: str) -> list[Rule]:
        rules = [*topic.proposals, *topic.rules]
        return [rule for rule in rules if tag in rule.tags or re.search(rf"%{tag}\b", rule.answer)]

    def _raise(self, event: str, value: Any) -> None:
        self._events.raise_event(f"Dialog/{event}", value)

    def _go_to(self, topic: str) -> None:
        if topic != self._focus:
            self._focus = topic
            self._raise("Focus", topic)

    @offers("ALDialog.forceInput")
    def _force_input(self, said: str) -> Future[Any] | None:
        if not self._subscribers:
            logger.warning("ALDialog.forceInput: ALDialog has no subscriber, and nothing is answered")
            return None
        return self._input(said[:MAX_TOPIC])

    @offers("ALDialog.forceOutput")
    def _force_output(self) -> Future[Any] | None:
        """Speak the next proposal of the focused topic."""
        topic = self._topics.get(self._focus) if self._focus in self._active else None
        proposals = self._proposals(topic) if topic else []
        turn = self._turns["proposal", self._focus]
        if topic is None or turn >= len(proposals):
            self._raise("NothingToSay", 1)
            return None
        self._turn("proposal", self._focus)
        return self._answer(topic, proposals[turn], ())

    @offers("ALDialog.setFocus")
    def _set_focus(self, name: Any) -> None:
        self._go_to(self._loaded(name))

    @offers("ALDialog.gotoTopic")
    def _go_to_topic(self, name: Any) -> Future[Any] | None:
        self._set_focus(name)
        return self._force_output()

    @offers("ALDialog.gotoTag")
    def _go_to_tag(self, tag: str, name: Any) -> Future[Any] | None:
        topic = self._topics[self._loaded(name)]
        goals = self._tagged(topic, re.sub(r"\W", "", tag))
        if not goals:
            raise NaoqiRefused(f"ALDialog.gotoTag: {topic.name} has no tag {tag!r:.60}.")
        self._pass(topic, goals[0])
        return self._answer(topic, goals[0], ())

    @offers("ALDialog.enableTag", enabled=True)
    @offers("ALDialog.disableTag", enabled=False)
    def _enable_tag(self, tag: str, topic: Any, *, enabled: bool) -> None:
        key = self._loaded(topic), tag
        if enabled:
            self._blocked.discard(key)
        elif len(self._blocked) < MAX_CONCEPTS:
            self._blocked.add(key)

    @offers("ALDialog.loadTopic")
    def _load_file(self, path: RobotFile) -> Future[str]:
        def read(path: Path) -> Topic:
            return parse(read_limited(path, MAX_TOPIC, "give a topic of QiChat").decode("utf-8", "replace"))

        return self.files.load(path, read, self._store)

    @offers("ALDialog.loadTopicContent")
    def _load(self, content: str) -> Future[str]:
        if len(content) > MAX_TOPIC:
            raise NaoqiRefused(f"ALDialog: the topic is longer than {MAX_TOPIC} letters.")
        return self.files.load(content, parse, self._store)

    def _store(self, topic: Topic) -> str:
        if len(self._topics) >= MAX_TOPICS and topic.name not in self._topics:
            raise NaoqiRefused(f"ALDialog: {MAX_TOPICS} topics are loaded already; unload some.")
        self._topics[topic.name] = topic
        self._turns["proposal", topic.name] = 0
        return topic.name

    def _loaded(self, name: Any) -> str:
        topic = text(name, "ALDialog: topic")
        if topic not in self._topics:
            raise NaoqiRefused(f"ALDialog: {unknown_name('topic', topic, self._topics)}.")
        return topic

    @offers("ALDialog.activateTopic")
    def _activate(self, name: Any) -> None:
        if self._loaded(name) not in self._active:
            self._active.append(name)
            self._raise("ActivateTopic", name)

    @offers("ALDialog.deactivateTopic")
    def _deactivate(self, name: Any) -> None:
        if self._loaded(name) in self._active:
            self._active.remove(name)
            self._raise("DeactivateTopic", name)

    @offers("ALDialog.unloadTopic")
    def _unload(self, name: Any) -> None:
        self._deactivate(name)
        del self._topics[name]

    @offers("ALDialog.subscribe")
    def _subscribe(self, name: str) -> None:
        if len(self._subscribers) >= MAX_TOPICS:
            raise NaoqiRefused(f"ALDialog.subscribe: {MAX_TOPICS} have subscribed already.")
        self._subscribers.add(name)
        self._raise("IsStarted", 1)

    @offers("ALDialog.unsubscribe")
    def _unsubscribe(self, name: str) -> None:
        self._subscribers.discard(name)
        if not self._subscribers:
            self._within = ("", [])
            self._raise("IsStarted", 0)

    @offers("ALDialog.setLanguage")
    def _set_language(self, language: str) -> None:
        if language not in LANGUAGES:
            raise NaoqiRefused(f"ALDialog.setLanguage: {unknown_name('language', language, LANGUAGES)}.")
        self._language = language

    @offers("ALDialog.setASRConfidenceThreshold")
    def _set_threshold(self, value: Annotated[float, Range(0.0, 1.0)], *_: Any) -> None:
        self._threshold = value

    @offers("ALDialog.resetAll")
    def _reset(self) -> None:
        self._within, self._focus = ("", []), ""
        self._blocked.clear()
        self._turns.clear()

    @offers("ALDialog.getLoadedTopics")
    def _get_loaded_topics(self, of: Any) -> Any:
        names = codes(text(of, "ALDialog.getLoadedTopics: language"))
        return [t.name for t in self._topics.values() if t.language in names]

    _get_all_loaded_topics = offers("ALDialog.getAllLoadedTopics")(lambda self: list(self._topics))
    _get_activated_topics = offers("ALDialog.getActivatedTopics")(lambda self: list(self._active))
    _get_focus = offers("ALDialog.getFocus")(lambda self: self._focus)
    _get_asr_confidence_threshold = offers("ALDialog.getASRConfidenceThreshold")(lambda self: self._threshold)


def _spaced(answer: str) -> str:
    """A sentence with single spaces, and none before its signs."""
    return re.sub(r"\s+([.,!?])", r"\1", " ".join(answer.split()))


def _typed(value: str) -> Any:
    """A variable's value: a number if it is one."""
    if re.fullmatch(r"-?\d+", value):
        return int(value[:18])
    return float(value) if re.fullmatch(r"-?\d+\.\d+", value) else value
