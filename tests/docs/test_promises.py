"""Every test that a page of the documentation names exists, and each of a promise has a mutant."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.mutants import NAMED_TEST, mutants, places_of_tests, promises

ROOT = Path(__file__).parents[2]
PAGES = ("promises.md", "security.md")


@pytest.mark.parametrize("page", PAGES)
def test_the_tests_that_a_page_names_exist(page: str) -> None:
    named = set(NAMED_TEST.findall((ROOT / "docs" / page).read_text(encoding="utf-8")))
    assert len(named) >= 10
    assert named <= set(places_of_tests())


def test_every_test_of_a_promise_has_a_mutant_and_every_mutant_still_fits() -> None:
    assert {test for promise in promises() for test in promise.tests} == {mutant.test for mutant in mutants()}
    assert [str(mutant) for mutant in mutants() if not mutant.fits] == []
