"""QiChat, the language of the vendor's dialogue topics: its common part.

Rules of the user (`u:`, `u1:` to `u9:` within another one) with words, `[choices]`, `{optional parts}`, `*`,
`_` before a captured word, `~concepts`, `$variable==value` and `e:events`; proposals; answers with captured
words `$1`, `$variables`, choices, concepts, `%tags` and functions (`^goto`). Options before a rule's brackets
(`u:^private(...)`) are read and have no effect. Syntax: the vendor's pages on QiChat.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Final

from bridge.adapters.naoqi.interaction.speech import LANGUAGES
from bridge.errors import NaoqiRefused

MAX_RULES: Final = 1000
"""Rules and proposals of a topic."""
MAX_WORDS: Final = 60
"""Words of a sentence that are matched."""
MAX_STEPS: Final = 20_000
"""Parts of patterns tried for one sentence."""
_MAX_DEPTH: Final = 12
"""Brackets and concepts within each other."""
_HEAD: Final = re.compile(r"\s*(u|proposal|concept|dynamic|topic|language|include)([1-9]?)\s*:(.*)", re.DOTALL)
_PIECE: Final = re.compile(
    r"""\s*(?:
        (?P<open>[\[{(])|(?P<close>[\]})])|"(?P<quoted>[^"]*)"|(?P<keep>_(?=[*~\[{("\w]))|(?P<any>\*)
        |~(?P<concept>\w+)|%(?P<tag>\w+)|e:(?P<event>[\w/]+)(?:==(?P<equals>[\w.]+))?
        |\$(?P<variable>[\w/]+)==(?P<value>[\w.]+)|(?P<word>[\w'-]+)|(?P<other>\S)
    )""",
    re.VERBOSE,
)
_WORD: Final = r"[\w']+"
Ends = dict[int, tuple[tuple[int, int], ...]]
"""Possible ends of a match, each with beginning and end of its captured words."""


@dataclass(frozen=True)
class Pattern:
    """A part of an utterance."""

    kind: str
    """`word`, `any`, `never` (a negation), `concept`, `choice`, `optional`, `sequence` or `keep`."""
    text: str = ""
    parts: tuple[Pattern, ...] = ()


@dataclass(frozen=True)
class Rule:
    """An utterance or an event with its answer; or a proposal, an answer alone."""

    answer: str
    pattern: Pattern | None = None
    events: tuple[tuple[str, str], ...] = ()
    """Event and its required value; empty: any except 0."""
    conditions: tuple[tuple[str, str], ...] = ()
    """Variable and its required value."""
    tags: tuple[str, ...] = ()
    within: list[Rule] = field(default_factory=list)
    """Rules with priority after this one."""


@dataclass(frozen=True)
class Topic:
    """A parsed topic."""

    name: str
    language: str
    rules: list[Rule]
    proposals: list[Rule]
    concepts: dict[str, Pattern]


def parse(source: str) -> Topic:
    """Read a topic."""
    name, language = "", "enu"
    rules: list[Rule] = []
    proposals: list[Rule] = []
    concepts: dict[str, Pattern] = {}
    above: dict[int, Rule] = {}
    count = 0
    for number, statement in _statements(source):
        head = _HEAD.match(statement)
        if head is None:
            raise NaoqiRefused(f"ALDialog: line {number}, {statement.strip()!r:.60}, is no rule of a topic.")
        kind, level, rest = head[1], int(head[2] or 0), head[3].strip()
        count += kind in ("u", "proposal")
        if count > MAX_RULES:
            raise NaoqiRefused(f"ALDialog: the topic has more than {MAX_RULES} rules.")
        if kind == "topic":
            name = _topic_name(rest)
        elif kind == "language":
            language = rest or "enu"
        elif kind in ("concept", "dynamic"):
            key, words = _bracketed(rest, number)
            concepts[key.strip().casefold()] = _pattern(words, number)[0]
        elif kind == "proposal":
            above = {0: Rule(rest, tags=tuple(re.findall(r"%(\w+)", rest)))}
            proposals.append(above[0])
        elif kind == "u":
            rule = _rule(rest, number)
            if level and level - 1 not in above:
                raise NaoqiRefused(f"ALDialog: line {number}: u{level} has no rule above it.")
            (above[level - 1].within if level else rules).append(rule)
            above = {n: kept for n, kept in above.items() if n < level} | {level: rule}
    if not name:
        raise NaoqiRefused("ALDialog: this is no topic; `topic: ~name()` is expected in it.")
    return Topic(name, language, rules, proposals, concepts)


def _topic_name(rest: str) -> str:
    found = re.match(r"~(\w+)\s*(\(|$)", rest)
    return found[1] if found else ""


def _statements(source: str) -> Iterator[tuple[int, str]]:
    """Statements with the numbers of their first lines; lines that begin none continue one."""
    number, statement = 0, ""
    for i, line in enumerate(source.splitlines(), 1):
        plain = re.sub(r"(?<!\S)#.*", "", line)
        if _HEAD.match(plain) or not statement:
            if statement.strip():
                yield number, statement
            number, statement = i, plain
        else:
            statement += " " + plain
    if statement.strip():
        yield number, statement


def _bracketed(rest: str, number: int) -> tuple[str, str]:
    """Content of a statement's leading round brackets, and the rest."""
    depth, quoted = 0, False
    for i, letter in enumerate(rest):
        quoted ^= letter == '"'
        depth += 0 if quoted else (letter == "(") - (letter == ")")
        if depth == 0:
            if i:
                return rest[1:i], rest[i + 1 :].strip()
            break
    raise NaoqiRefused(f"ALDialog: line {number}: (...) is expected after the colon.")


def _rule(rest: str, number: int) -> Rule:
    said, answer = _bracketed(re.sub(r"^(\^\w+\s*)+(?=\()", "", rest), number)
    pattern, events, conditions, tags = _pattern(said, number)
    empty = pattern.kind == "sequence" and not pattern.parts
    return Rule(answer, None if empty and events else pattern, tuple(events), tuple(conditions), tuple(tags))


def _pattern(
    source: str, number: int
) -> tuple[Pattern, list[tuple[str, str]], list[tuple[str, str]], list[str]]:
    """A pattern, and the events, conditions and tags in it."""
    events: list[tuple[str, str]] = []
    conditions: list[tuple[str, str]] = []
    tags: list[str] = []
    levels: list[tuple[str, list[Pattern], bool]] = [("", [], False)]
    keeps = False

    def add(part: Pattern, kept: bool) -> None:
        levels[-1][1].append(Pattern("keep", parts=(part,)) if kept else part)

    for piece in _PIECE.finditer(source):
        kept, keeps = keeps, False
        kind = piece.lastgroup or ""
        value = piece[kind] if kind else ""
        if kind == "keep":
            keeps = True
        elif kind == "open":
            levels.append((value, [], kept))
            if len(levels) > _MAX_DEPTH:
                raise NaoqiRefused(f"ALDialog: line {number}: the brackets are too deep.")
        elif kind == "close":
            opened, parts, was_kept = levels.pop()
            if {"[": "]", "{": "}", "(": ")"}.get(opened) != value:
                raise NaoqiRefused(f"ALDialog: line {number}: {value!r} closes no bracket.")
            if parts:
                group = {"[": "choice", "{": "optional"}.get(opened, "sequence")
                add(Pattern(group, parts=tuple(parts)), was_kept)
        elif kind in ("quoted", "word"):
            words = tuple(Pattern("word", word) for word in plain_words(value))
            add(words[0] if len(words) == 1 else Pattern("sequence", parts=words), kept)
        elif value == "!":
            add(Pattern("never"), False)
        elif kind == "any":
            add(Pattern("any"), kept)
        elif kind == "concept":
            add(Pattern("concept", value.casefold()), kept)
        elif kind == "tag":
            tags.append(value)
        elif piece["event"]:
            events.append((piece["event"], piece["equals"] or ""))
        elif piece["variable"]:
            conditions.append((piece["variable"], piece["value"]))
    if len(levels) != 1:
        raise NaoqiRefused(f"ALDialog: line {number}: a bracket is not closed.")
    return Pattern("sequence", parts=tuple(levels[0][1])), events, conditions, tags


def plain_words(said: str) -> list[str]:
    """Words of a sentence without capitals and signs, for comparison."""
    return [word.casefold() for word in re.findall(_WORD, said)]


class Steps:
    """Remaining steps of the matching of one sentence, so that no topic delays the robot."""

    def __init__(self, left: int = MAX_STEPS) -> None:
        self.left = left


def captures(
    pattern: Pattern, said: str, concepts: Mapping[str, Pattern], steps: Steps
) -> tuple[str, ...] | None:
    """The words that a pattern captures of a whole sentence; None: no match.

    Args:
        steps: of the sentence, with all rules; without steps nothing matches.
    """
    words = plain_words(said)[:MAX_WORDS]
    spans = _ends(pattern, words, 0, concepts, 0, steps).get(len(words))
    if spans is None:
        return None
    spoken = re.findall(_WORD, said)
    return tuple(" ".join(spoken[start:end]) for start, end in spans)


def _ends(
    pattern: Pattern, words: list[str], start: int, concepts: Mapping[str, Pattern], depth: int, steps: Steps
) -> Ends:
    """All ends of a match from one word on, each with its first captures."""
    steps.left -= 1
    if depth > 2 * _MAX_DEPTH or steps.left < 0:
        return {}
    parts = pattern.parts
    if pattern.kind == "word":
        return {start + 1: ()} if words[start : start + 1] == [pattern.text] else {}
    if pattern.kind == "never":
        return {}
    if pattern.kind == "any":
        return {end: () for end in range(start, len(words) + 1)}
    if pattern.kind == "concept":
        concept = concepts.get(pattern.text)
        return _ends(concept, words, start, concepts, depth + 1, steps) if concept else {}
    if pattern.kind == "choice":
        found: Ends = {}
        for part in parts:
            found = _ends(part, words, start, concepts, depth + 1, steps) | found
        return found
    reached: Ends = {start: ()}
    for part in parts:
        onward: Ends = {}
        for end, kept in reached.items():
            for further, more in _ends(part, words, end, concepts, depth + 1, steps).items():
                onward.setdefault(further, kept + more)
        reached = onward
    if pattern.kind == "keep":
        return {end: ((start, end), *kept) for end, kept in reached.items()}
    return {start: ()} | reached if pattern.kind == "optional" else reached


def of_words(words: str) -> Pattern:
    """The pattern of a sentence of plain words."""
    return Pattern("sequence", parts=tuple(Pattern("word", word) for word in plain_words(words)))


def words_of(pattern: Pattern) -> list[str]:
    """Words of a pattern, with the first of each choice."""
    parts = pattern.parts[:1] if pattern.kind == "choice" else pattern.parts
    return [pattern.text] if pattern.kind == "word" else [word for part in parts for word in words_of(part)]


def with_kept(answer: str, kept: tuple[str, ...]) -> str:
    """An answer with the captured words in place of `$1`, `$2`, ..."""
    return re.sub(r"\$(\d)", lambda m: kept[int(m[1]) - 1] if 0 < int(m[1]) <= len(kept) else "", answer)


def codes(language: str) -> set[str]:
    """Names of a language in topics: its name, or a code."""
    return {language, LANGUAGES[language].code if language in LANGUAGES else language}
