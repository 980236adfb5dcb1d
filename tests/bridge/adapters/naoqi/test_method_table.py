"""The table of the vendor's methods in the documentation is that of the code."""

from __future__ import annotations

from bridge.adapters.naoqi.methods import VENDOR
from nao_hil.naoqi_programs import method_table

ANEW = "write it anew: python -m nao_hil.naoqi_programs.method_table"


def test_the_page_has_the_table_of_the_code() -> None:
    assert method_table.PAGE.read_text() == method_table.page(), ANEW


def test_what_is_said_of_methods_is_said_of_methods_that_are_there() -> None:
    """`partly` of offered ones, `no` of refused ones; and the breadth that programs need."""
    found = method_table.answers()
    for service, vendor in VENDOR.items():
        assert {method for method in vendor.partly if found[service].get(method) != "partly"} == set(), service
        assert {method for method in vendor.no.keys() - {"*"} if found[service].get(method) != "no"} == set(), (
            service
        )
    offered = {name: [m for m, answer in of.items() if answer != "no"] for name, of in found.items()}
    assert sum(bool(methods) for methods in offered.values()) >= 18
    assert sum(map(len, offered.values())) >= 120
