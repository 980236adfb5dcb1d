"""Places for processes on this machine."""

from __future__ import annotations

from nao_hil.runs.supervisor import free_endpoint
from tests.ports import EPHEMERAL


def test_no_outgoing_connection_of_this_machine_can_take_a_free_endpoint() -> None:
    """The system gives these the ports from EPHEMERAL on, also between an endpoint's choice and its use."""
    for _ in range(50):
        assert int(free_endpoint().rpartition(":")[2]) < EPHEMERAL
