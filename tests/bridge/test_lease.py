from __future__ import annotations

from bridge.link.lease import SILENCE, LeaseBook

FIRST = 1000


def test_the_first_who_asks_gets_it_and_the_second_hears_who_has_it() -> None:
    book = LeaseBook(FIRST)
    assert book.acquire("anna", 1, now=0.0).granted
    reply = book.acquire("bert", 2, now=0.1)
    assert not reply.granted
    assert reply.lease == 0
    assert reply.holder == "anna"
    assert "anna" in reply.message


def test_a_name_alone_does_not_make_a_holder() -> None:
    book = LeaseBook(FIRST)
    book.acquire("walker", 1, now=0.0)
    reply = book.acquire("walker", 2, now=0.1)
    assert not reply.granted
    book.release(2)
    assert not book.gone(2)
    assert book.holder is not None
    assert book.holder.ticket == 1


def test_asking_again_grants_the_same_number() -> None:
    book = LeaseBook(FIRST)
    first = book.acquire("anna", 1, now=0.0)
    assert book.acquire("anna", 1, now=1.0).lease == first.lease


def test_every_grant_has_a_number_of_its_own_and_none_is_zero() -> None:
    book = LeaseBook(0)
    numbers = []
    for _ in range(5):
        numbers.append(book.acquire("anna", 1, now=0.0).lease)
        book.release(1)
    assert len(set(numbers)) == 5
    assert 0 not in numbers


def test_a_number_from_before_a_restart_is_not_obeyed() -> None:
    old = LeaseBook(FIRST).acquire("anna", 1, now=0.0).lease
    restarted = LeaseBook(FIRST + 12345)
    assert not restarted.heard(old, now=0.0)
    restarted.acquire("bert", 2, now=0.0)
    assert not restarted.heard(old, now=0.0)


def test_only_the_holders_number_is_obeyed() -> None:
    book = LeaseBook(FIRST)
    assert not book.heard(0, now=0.0)
    lease = book.acquire("anna", 1, now=0.0).lease
    assert book.heard(lease, now=0.0)
    assert not book.heard(lease + 1, now=0.0)
    assert not book.heard(0, now=0.0)


def test_giving_back_frees_it() -> None:
    book = LeaseBook(FIRST)
    lease = book.acquire("anna", 1, now=0.0).lease
    assert book.release(1).holder == ""
    assert not book.heard(lease, now=0.0)
    assert book.acquire("bert", 2, now=0.0).granted


def test_another_cannot_give_it_back() -> None:
    book = LeaseBook(FIRST)
    lease = book.acquire("anna", 1, now=0.0).lease
    assert book.release(2).holder == "anna"
    assert book.heard(lease, now=0.0)


def test_it_ends_with_its_holder() -> None:
    book = LeaseBook(FIRST)
    lease = book.acquire("anna", 1, now=0.0).lease
    assert not book.gone(2)
    assert book.gone(1)
    assert not book.heard(lease, now=0.0)
    assert book.acquire("bert", 2, now=0.0).granted


def test_a_silent_holder_keeps_it_until_another_asks() -> None:
    book = LeaseBook(FIRST)
    lease = book.acquire("anna", 1, now=0.0).lease
    assert not book.acquire("bert", 2, now=SILENCE).granted
    assert book.heard(lease, now=100.0)
    assert not book.acquire("bert", 2, now=100.0 + SILENCE).granted
    taken = book.acquire("bert", 2, now=100.0 + SILENCE + 0.01)
    assert taken.granted
    assert taken.lease != lease
    assert not book.heard(lease, now=104.0)


def test_asking_again_is_a_sign_of_life() -> None:
    book = LeaseBook(FIRST)
    book.acquire("anna", 1, now=0.0)
    book.acquire("anna", 1, now=2.0)
    assert not book.acquire("bert", 2, now=SILENCE + 1.0).granted


def test_the_status_names_the_holder_and_changes_nothing() -> None:
    book = LeaseBook(FIRST)
    assert book.status().holder == ""
    lease = book.acquire("anna", 1, now=0.0).lease
    status = book.status()
    assert (status.granted, status.lease, status.holder) == (False, 0, "anna")
    assert book.heard(lease, now=0.0)


def test_a_holder_whose_session_broke_off_gets_the_same_lease_back() -> None:
    book = LeaseBook(FIRST)
    first = book.acquire("anna", 1, now=0.0)
    assert book.gone(1)
    assert book.acquire("anna", 1, now=40.0).lease == first.lease
    assert not book.abandoned


def test_a_holder_gets_another_lease_after_a_stop_or_another_controller() -> None:
    for other in (LeaseBook.revoke, lambda book: book.acquire("bert", 2, now=1.0)):
        book = LeaseBook(FIRST)
        first = book.acquire("anna", 1, now=0.0)
        assert book.gone(1)
        other(book)
        book.gone(2)
        assert book.acquire("anna", 1, now=2.0).lease not in (first.lease, 0)
