r"""A text to be spoken: its words, pauses and speed, as the marks in it say, and how long it takes.

Marks: `\\pau=500\\` (ms), `\\rspd=80\\` (per cent), `\\mrk=1\\`, and those of animated speech,
as `^start(...)`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

LETTERS_PER_SECOND: Final = 14.0
"""Of speech at speed 100 (assumed: a hundred and fifty words a minute)."""
SENTENCE_PAUSE: Final = 0.3
"""s after a full stop (assumed)."""
SPEEDS: Final = (50.0, 400.0)
"""Range of the speed, per cent (confirmed: vendor's page)."""
_MARK: Final = re.compile(r"\\+(\w+)=([^\\]*)\\+|\\+\w+\\+")
_ANIMATION: Final = re.compile(r"\^\w+(?:\([^)]*\))?")


@dataclass(frozen=True)
class Word:
    """One word of an utterance."""

    text: str
    begin: float
    """s after the begin of the utterance at which it is spoken."""
    place: int
    """Of its first letter in the text without marks."""
    bookmark: int | None = None
    """Number of a bookmark right before it."""


@dataclass(frozen=True)
class Utterance:
    """What is spoken, and when."""

    plain: str
    """The text without marks."""
    words: tuple[Word, ...]
    seconds: float


def utterance(text: str, speed: float = 100.0) -> Utterance:
    """Read the marks of a text and time its words.

    Args:
        text: with marks.
        speed: where no mark says another, per cent.
    """
    now, place, pieces, bookmark = 0.0, 0, [], None
    words: list[Word] = []
    percent = speed
    cut = 0
    text = _ANIMATION.sub("", text)
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
        value = _number(mark[2])
        if mark[1] == "pau":
            now += min(max(value, 0.0), 60_000.0) / 1000.0
        elif mark[1] == "rspd":
            percent = min(max(value, SPEEDS[0]), SPEEDS[1])
        elif mark[1] == "mrk":
            bookmark = int(value)
    return Utterance("".join(pieces).strip(), tuple(words), now)


def _number(text: str | None) -> float:
    try:
        return min(max(float(text or ""), -1e9), 1e9)
    except ValueError:
        return 0.0
