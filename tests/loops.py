"""Loops of tests: each ends by a count or by the clock, and says for what it waited in vain.

`tests/test_loops.py` allows no other loop of unknown length in a test.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any, Final

TIMEOUT: Final = 300.0
"""s for what takes well under a second on an idle machine."""


def repeat_while(condition: Callable[[], Any], limit: int = 20_000) -> Iterator[int]:
    """Count rounds from 0 while a condition holds before each of them.

    Args:
        condition: to be true for one more round.
        limit: rounds after which it must be false; 20,000 cycles are 200 s of robot time.

    Raises:
        AssertionError: It still holds after so many rounds.
    """
    for count in range(limit):
        if not condition():
            return
        yield count
    assert not condition(), f"the loop has not ended within {limit} rounds"


def until(
    condition: Callable[[], Any], what: str = "a condition", seconds: float = TIMEOUT, pause: float = 0.005
) -> Any:
    """Wait by the clock until something is true.

    Args:
        condition: asked again and again.
        what: it is, for the message.
        seconds: to wait at most, s.
        pause: between two questions, s.

    Returns:
        What the condition gave.

    Raises:
        AssertionError: It has not become true in time.
    """
    deadline = time.monotonic() + seconds
    for _ in repeat_while(lambda: time.monotonic() < deadline, limit=1 << 30):
        if value := condition():
            return value
        time.sleep(pause)
    raise AssertionError(f"waited {seconds:g} s in vain for {what}")
