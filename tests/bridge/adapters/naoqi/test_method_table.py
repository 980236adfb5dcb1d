"""The table of the vendor's methods in the documentation is that of the code."""

from __future__ import annotations

from bridge.adapters.naoqi.declared import REFUSED
from nao_hil.naoqi_programs import method_table

ANEW = "write it anew: python -m nao_hil.naoqi_programs.method_table"


def test_the_page_has_the_table_of_the_code() -> None:
    assert method_table.PAGE.read_text() == method_table.page(), ANEW


def test_the_services_have_the_breadth_that_programs_need() -> None:
    found = method_table.answers()
    offered = {name: [m for m, answer in of.items() if answer != "no"] for name, of in found.items()}
    assert sum(bool(methods) for methods in offered.values()) >= 18
    assert sum(map(len, offered.values())) >= 120


def test_a_reason_belongs_to_a_method_that_is_refused() -> None:
    for service, refused in REFUSED.items():
        assert refused.no.keys() - {"*"} <= set(refused.methods), service
