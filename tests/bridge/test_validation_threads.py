"""Threads that read a type for the first time at once: msgspec alone crashes the process."""

import pytest

from tests.processes import python

SCRIPT = """
import threading, time
from typing import Literal

import msgspec

from bridge.messages.codec import decode, encode
from bridge.messages.frames import SCHEMA_VERSION
from bridge.validation import convert

alias = type(Literal["a"])
quick = alias.__hash__

def slow(self):
    time.sleep(0.01)  # another thread's turn, in the midst of a type
    return quick(self)

alias.__hash__ = slow

class Inner(msgspec.Struct, frozen=True):
    a: Literal["x", "y"] = "x"

class Outer(msgspec.Struct, frozen=True, kw_only=True):
    version: int = SCHEMA_VERSION
    inner: Inner = Inner()
    b: Literal["x", "z"] = "x"

wanted = Outer(inner=Inner("y"), b="z")
payload, table = encode(wanted), msgspec.to_builtins(wanted)
found = []
threads = [threading.Thread(target=lambda: found.append(READ)) for _ in range(4)]
for thread in threads:
    thread.start()
for thread in threads:
    thread.join()
assert found == [wanted] * 4
"""


@pytest.mark.parametrize("read", ["convert(table, Outer)", "decode(payload, Outer)"])
def test_threads_read_a_new_type_at_once(read: str) -> None:
    done = python("-c", SCRIPT.replace("READ", read))
    assert done.returncode == 0, done.stderr
