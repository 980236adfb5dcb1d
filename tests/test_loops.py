"""No loop of a test runs for ever."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest

from tests.loops import repeat_while, until

TESTS = Path(__file__).parent
TOOLS = {
    *(file for name in ("bench", "chaos", "imitation", "measure") for file in (TESTS / name).glob("*.py")),
    TESTS / "fuzz" / "campaign.py", TESTS / "proxy.py", TESTS / "emulator" / "abuse.py", Path(__file__),
}  # fmt: skip
"""No tests: benchmarks, measurements, the training of the shipped policy,
chaos and campaign run for as long as they are told to, the proxy as long as its connections; this
file holds examples."""


def endless(source: str) -> list[int]:
    """Lines of loops without a bound: `while`, `itertools.count`, and `iter` of a function."""
    lines = []
    for node in ast.walk(ast.parse(source)):
        call = node.func if isinstance(node, ast.Call) else None
        counts = (
            isinstance(call, ast.Attribute) and call.attr == "count" and ast.unparse(call.value) == "itertools"
        )
        asks = isinstance(call, ast.Name) and call.id == "iter" and len(node.args) == 2
        if isinstance(node, ast.While) or counts or asks:
            lines.append(node.lineno)
    return lines


def test_every_loop_of_a_test_has_a_bound() -> None:
    """`repeat_while` and `until` of `tests/loops.py` are the loops of unknown length."""
    found = {
        f"{file.relative_to(TESTS)}:{line}"
        for file in TESTS.rglob("*.py")
        if file not in TOOLS
        for line in endless(file.read_text())
    }
    assert found == set()


@pytest.mark.parametrize(
    "source", ["while True:\n    pass", "for n in itertools.count():\n    n", "for n in iter(next, 1):\n    n"]
)
def test_a_loop_without_a_bound_is_found(source: str) -> None:
    assert endless(source) == [1]


def test_a_bounded_loop_counts_and_ends_with_its_condition() -> None:
    seen: list[int] = []
    for n in repeat_while(lambda: len(seen) < 3):
        seen.append(n)
    assert seen == [0, 1, 2]


def test_a_bounded_loop_fails_at_its_bound() -> None:
    with pytest.raises(AssertionError, match="within 7 rounds"):
        assert sum(1 for _ in repeat_while(lambda: True, 7)) < 0


def test_a_wait_gives_what_came_and_ends_by_the_clock() -> None:
    answers = iter([None, 0, "here"])
    assert until(lambda: next(answers), "an answer") == "here"
    with pytest.raises(AssertionError, match="in vain for rain"):
        until(lambda: False, "rain", seconds=0.02)
