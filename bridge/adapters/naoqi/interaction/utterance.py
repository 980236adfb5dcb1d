r"""A text of ALTextToSpeech: its words with their times, and the functions between them.

Marks: `\\pau=500\\` (ms), `\\rspd=80\\` (per cent), `\\mrk=1\\`; functions of animated speech: `^start(name)`,
`^wait(name)`, `^run(name)`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

LETTERS_PER_SECOND: Final = 14.0
"""Rate of speech at speed 100 (assumed: 150 words a minute)."""
SENTENCE_PAUSE: Final = 0.3
"""s after a full stop (assumed)."""
SPEEDS: Final = (50.0, 400.0)
"""Range of the speed, per cent (confirmed: vendor's page)."""
_MARK: Final = re.compile(r"\\+(\w+)=([^\\]*)\\+|\\+\w+\\+|\^(\w+)(?:\(\s*([^)]*?)\s*\))?")


@dataclass(frozen=True)
class Word:
    """One word of an utterance."""

    text: str
    begin: float
    """Its time from the beginning of the utterance, s."""
    place: int
    """Index of its first letter in the text without marks."""
    bookmark: int | None = None
    """Number of the bookmark before it."""


@dataclass(frozen=True)
class Function:
    """A function of animated speech, as `^start(name)`."""

    name: str
    argument: str
    place: int
    """Number of words before it."""


@dataclass(frozen=True)
class Utterance:
    """A text and the times of its words."""

    plain: str
    """The text without marks and functions."""
    words: tuple[Word, ...]
    seconds: float
    functions: tuple[Function, ...] = ()


def utterance(text: str, speed: float = 100.0) -> Utterance:
    """Read the marks of a text and time its words.

    Args:
        speed: unless a mark changes it, per cent.
    """
    now, place, pieces, bookmark = 0.0, 0, [], None
    words: list[Word] = []
    functions: list[Function] = []
    percent = speed
    cut = 0
    for mark in [*_MARK.finditer(text), None]:
        piece = text[cut : mark.start() if mark else len(text)]
        for found in re.finditer(r"\S+", piece):
            words.append(Word(found[0], now, place + found.start(), bookmark))
            bookmark = None
            now += (len(found[0]) + 1) / (LETTERS_PER_SECOND * percent / 100.0)
            now += SENTENCE_PAUSE if found[0][-1] in ".!?" else 0.0
        pieces.append(piece)
        place += len(piece)
        if mark is None:
            break
        cut = mark.end()
        if mark[3]:
            functions.append(Function(mark[3], mark[4] or "", len(words)))
        value = _number(mark[2])
        if mark[1] == "pau":
            now += min(max(value, 0.0), 60_000.0) / 1000.0
        elif mark[1] == "rspd":
            percent = min(max(value, SPEEDS[0]), SPEEDS[1])
        elif mark[1] == "mrk":
            bookmark = int(value)
    return Utterance("".join(pieces).strip(), tuple(words), now, tuple(functions))


def _number(text: str | None) -> float:
    try:
        return min(max(float(text or ""), -1e9), 1e9)
    except ValueError:
        return 0.0
