"""The lease: one controller at a time, how the lease ends, and who gets it next."""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from typing import Any

import pytest

from bridge.link.lease import SILENCE_LIMIT, LeaseBook
from bridge.link.seal import Seal

ONE, TWO = (Seal(key, b"secret of " + key.encode(), count(1)) for key in ("anna's", "bert's"))


@pytest.fixture
def book() -> LeaseBook:
    return LeaseBook(first=1000)


def test_one_controller_holds_it_by_its_key_and_others_hear_who(book: LeaseBook) -> None:
    assert book.status().holder == "" and not book.keepalive(0, now=0.0)
    lease = book.acquire("walker", ONE, now=0.0).lease
    assert book.acquire("walker", ONE, now=1.0).lease == lease  # asked again
    for name in ("walker", "bert"):  # a name alone makes no holder
        reply = book.acquire(name, TWO, now=1.1)
        assert (reply.granted, reply.lease, reply.holder) == (False, 0, "walker")
        assert "walker" in reply.message
    status = book.status()
    assert (status.granted, status.lease, status.holder) == (False, 0, "walker")
    assert book.release(TWO).holder == "walker" and not book.on_token_lost(TWO.peer)
    assert [book.keepalive(number, now=1.2) for number in (lease, lease + 1, 0)] == [True, False, False]


@pytest.mark.parametrize("end", [lambda book: book.release(ONE), lambda book: book.on_token_lost(ONE.peer)])
def test_it_ends_when_it_is_given_back_and_with_its_holder(
    book: LeaseBook, end: Callable[[LeaseBook], Any]
) -> None:
    lease = book.acquire("anna", ONE, now=0.0).lease
    end(book)
    assert book.holder is None and not book.keepalive(lease, now=0.0)
    assert book.acquire("bert", TWO, now=0.0).granted


def test_every_grant_has_a_number_of_its_own_also_after_a_restart() -> None:
    book, numbers = LeaseBook(0), []
    for _ in range(5):
        numbers.append(book.acquire("anna", ONE, now=0.0).lease)
        book.release(ONE)
    assert len(set(numbers)) == 5 and 0 not in numbers
    restarted = LeaseBook(12345)
    assert not restarted.keepalive(numbers[-1], now=0.0)
    restarted.acquire("bert", TWO, now=0.0)
    assert not restarted.keepalive(numbers[-1], now=0.0)


def test_a_silent_holder_keeps_it_until_another_asks(book: LeaseBook) -> None:
    """Commands are signs of life, and so is asking again."""
    lease = book.acquire("anna", ONE, now=0.0).lease
    assert not book.acquire("bert", TWO, now=SILENCE_LIMIT).granted
    assert book.keepalive(lease, now=100.0)
    assert not book.acquire("bert", TWO, now=100.0 + SILENCE_LIMIT).granted
    book.acquire("anna", ONE, now=102.0)
    assert not book.acquire("bert", TWO, now=102.0 + SILENCE_LIMIT).granted
    taken = book.acquire("bert", TWO, now=102.0 + SILENCE_LIMIT + 0.01)
    assert taken.granted and taken.lease != lease
    assert not book.keepalive(lease, now=106.0)


def test_a_holder_whose_session_broke_off_gets_the_same_lease_back(book: LeaseBook) -> None:
    first = book.acquire("anna", ONE, now=0.0)
    assert book.on_token_lost(ONE.peer)
    assert book.acquire("anna", ONE, now=40.0).lease == first.lease
    assert not book.abandoned


@pytest.mark.parametrize("other", [LeaseBook.revoke, lambda book: book.acquire("bert", TWO, now=1.0)])
def test_a_holder_gets_another_lease_after_a_stop_or_another_controller(
    book: LeaseBook, other: Callable[[LeaseBook], Any]
) -> None:
    first = book.acquire("anna", ONE, now=0.0)
    assert book.on_token_lost(ONE.peer)
    other(book)
    book.on_token_lost(TWO.peer)
    assert book.acquire("anna", ONE, now=2.0).lease not in (first.lease, 0)
