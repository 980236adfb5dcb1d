"""Messages between a served robot and its cameras: what one end cannot read the other does not send."""

from __future__ import annotations

import socket
import struct

import pytest

from bridge.adapters.naoqi.core.cameras import MAX_MESSAGE, Pipe, Unsendable


def nested(depth: int) -> list[object]:
    value: list[object] = []
    for _ in range(depth):
        value = [value]
    return value


@pytest.mark.parametrize("argument", ["x" * MAX_MESSAGE, nested(100_000), object(), 1 << 70])
def test_what_cannot_be_read_is_not_sent_and_the_next_message_arrives(argument: object) -> None:
    ours, theirs = socket.socketpair()
    here, there = Pipe(ours), Pipe(theirs)
    with pytest.raises(Unsendable):
        here.send([1, "ALMemory", "insertData", ["key", argument]])
    here.send([2, "ALMemory", "ping", []])
    assert there.receive() == [2, "ALMemory", "ping", []]
    here.close()
    assert there.receive() is None
    there.close()


def test_a_message_that_is_none_is_passed_over() -> None:
    ours, theirs = socket.socketpair()
    here, there = Pipe(ours), Pipe(theirs)
    for payload in (b"\xc1", b"\xa1\xff", b"\x91" * 100_000):
        ours.sendall(struct.pack("!I", len(payload)) + payload)
    here.send([3])
    assert there.receive() == [3]
    here.close()
    there.close()
