"""The timed-command buffer against an independent one in fractions, under any history of requests."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import given, settings
from hypothesis import strategies as st

from bridge.body import load_body
from bridge.body.postures import POSTURES
from bridge.dcm import Dcm
from bridge.dcm.requests import set_request
from bridge.errors import DcmRefused

BODY = load_body("nao-v3")
LED = "ChestBoard/Led/Red/Actuator/Value"
LIMIT = 12
ROUNDING = Fraction(1, 2) + Fraction(1, 10**6)
"""Counts by which a sent integer may lie off the exact line: its rounding, and that of floats."""

commands = st.lists(st.tuples(st.integers(0, 256), st.integers(-120, 400)), max_size=6)
"""Brightness in counts, time from now in ms."""
updates = st.sampled_from(["Merge", "ClearAll", "ClearAfter", "ClearBefore"])
histories = st.lists(st.tuples(updates, commands, st.integers(0, 12)), max_size=8)
"""Requests, each followed by so many cycles."""


def new_dcm() -> Dcm:
    return Dcm(BODY, POSTURES["Stand"], limit=LIMIT)


def put(dcm: Dcm, update: str, new: list[tuple[int, int]]) -> None:
    dcm.set(set_request([LED, update, [[counts / 256, dcm.clock.shown(later)] for counts, later in new]]))


def sent(dcm: Dcm) -> Fraction:
    """Counts sent in the cycle that is run now."""
    dcm.run_cycle()
    return Fraction(dcm.read([LED], (0.0,) * 25)[0]) * 256


class Reference:
    """The vendor's algorithm, with a set of commands in place of an ordered buffer and exact arithmetic."""

    def __init__(self) -> None:
        self.waiting: set[tuple[int, int, int]] = set()  # time, order of arrival, counts
        self.arrivals = 0
        self.now, self.value = 0, Fraction(0)

    def put(self, update: str, new: list[tuple[int, int]]) -> bool:
        """False, and nothing changed, when the buffer would be too full."""
        added = {(self.now + later, self.arrivals + i, counts) for i, (counts, later) in enumerate(new)}
        times = [time for time, _, _ in added]
        kept = set(self.waiting)
        if update == "ClearAll":
            kept = set()
        elif update == "ClearAfter":
            kept -= {old for old in kept if times and old[0] > min(times)}
        elif update == "ClearBefore":
            kept -= {old for old in kept if times and old[0] < max(times)}
        if len(kept | added) > LIMIT:
            return False
        self.waiting = kept | added
        self.arrivals += len(new)
        return True

    def cycle(self) -> Fraction:
        before, at, value = self.now - 10, self.now - 10, self.value
        for command in sorted(self.waiting):
            if command[0] <= self.now:
                at, value = max(before, command[0]), Fraction(command[2])
                self.waiting.remove(command)
        if self.waiting:
            time, counts = min((command[0], command[1:]) for command in self.waiting)
            share = Fraction(self.now - at, time - at)
            value = (1 - share) * value + share * counts[1]
        self.now += 10
        self.value = value
        return value


@given(histories)
@settings(max_examples=150)
def test_any_history_is_sent_as_by_an_independent_implementation(
    history: list[tuple[str, list[tuple[int, int]], int]],
) -> None:
    dcm, reference = new_dcm(), Reference()
    for update, new, cycles in [*history, ("Merge", [], 20)]:
        taken = True
        try:
            put(dcm, update, new)
        except DcmRefused:
            taken = False
        assert taken == reference.put(update, new)
        assert len(dcm.waiting(LED)) == len(reference.waiting) <= LIMIT
        for _ in range(cycles):
            assert abs(sent(dcm) - reference.cycle()) <= ROUNDING


@given(histories)
@settings(max_examples=150)
def test_what_is_sent_lies_between_where_it_was_and_what_is_due(
    history: list[tuple[str, list[tuple[int, int]], int]],
) -> None:
    dcm, last = new_dcm(), Fraction(0)
    for update, new, cycles in history:
        try:
            put(dcm, update, new)
        except DcmRefused:
            continue
        for _ in range(cycles):
            now = dcm.clock.now
            due = [command.value for command in dcm.waiting(LED) if command.time <= now]
            future = [command.value for command in dcm.waiting(LED) if command.time > now]
            start = Fraction(due[-1]) if due else last
            ends = sorted([start, Fraction(future[0]) if future else start])
            last = sent(dcm)
            assert ends[0] <= last <= ends[1]


distinct_times = st.lists(
    st.tuples(st.integers(0, 256), st.integers(-120, 400)), max_size=LIMIT, unique_by=lambda pair: pair[1]
)


@given(distinct_times, st.data())
def test_the_order_of_merged_commands_does_not_matter(new: list[tuple[int, int]], data: st.DataObject) -> None:
    shuffled = data.draw(st.permutations(new))
    cut = data.draw(st.integers(0, len(new)))
    together, apart = new_dcm(), new_dcm()
    put(together, "Merge", new)
    put(apart, "Merge", shuffled[:cut])
    put(apart, "Merge", shuffled[cut:])
    assert together.waiting(LED) == apart.waiting(LED)
    assert [sent(together) for _ in range(45)] == [sent(apart) for _ in range(45)]


@given(st.integers(-(2**31), 2**31 - 1), st.integers(-400, 400), st.integers(0, 30))
def test_the_clock_may_start_anywhere(start: int, later: int, cycles: int) -> None:
    """A command given by the shown time means the same whatever the clock shows."""
    dcm, plain = Dcm(BODY, POSTURES["Stand"], start=start), new_dcm()
    for one in (dcm, plain):
        for _ in range(cycles):
            one.run_cycle()
        put(one, "ClearAll", [(0, 0), (200, later)])
    assert -(2**31) <= dcm.clock.shown() < 2**31
    assert dcm.waiting(LED) == plain.waiting(LED)
    assert [sent(dcm) for _ in range(45)] == [sent(plain) for _ in range(45)]
