"""A campaign of walks in real time that was stopped goes on where it was; walks of other code are made anew."""

from __future__ import annotations

import threading
import time
from pathlib import Path

import msgspec
import pytest

from nao_hil.runs.campaign import Campaign, Interrupted
from nao_hil.runs.store import stored


class Found(msgspec.Struct, frozen=True):
    n: int


def test_a_result_is_made_once_for_each_key_and_a_broken_file_is_made_anew(tmp_path: Path) -> None:
    file, made = tmp_path / "walks" / "one" / "result.json", []

    def make() -> Found:
        made.append(1)
        return Found(len(made))

    assert stored(file, "a", Found, make) == stored(file, "a", Found, make) == Found(1)
    assert stored(file, "b", Found, make) == Found(2)
    file.write_bytes(file.read_bytes()[:-2])
    assert stored(file, "b", Found, make) == Found(3)


def test_a_stopped_walk_leaves_nothing_behind(tmp_path: Path) -> None:
    def make() -> Found:
        raise Interrupted

    with pytest.raises(Interrupted):
        stored(tmp_path / "result.json", "a", Found, make)
    assert not list(tmp_path.iterdir())


def test_watched_calls_come_in_order_and_as_many_at_once_as_there_are_workers() -> None:
    at_once, most, lock = 0, 0, threading.Lock()

    def call(seconds: float) -> float:
        nonlocal at_once, most
        with lock:
            at_once += 1
            most = max(most, at_once)
        time.sleep(seconds)
        with lock:
            at_once -= 1
        return seconds

    pauses = [0.05, 0.01, 0.03, 0.02, 0.04]
    with Campaign(cluster="local:2") as campaign:
        assert campaign.watch(call, pauses, lambda s, _: (f"{s}", "done")) == pauses
    assert most == 2


def test_after_a_stop_and_after_an_error_no_further_call_is_made() -> None:
    stop, made = threading.Event(), []

    def stops(n: int) -> int:
        made.append(n)
        if n == 1:
            stop.set()
            raise Interrupted
        return n

    with Campaign(cluster="local:1", stop=stop) as campaign:
        assert campaign.watch(stops, range(4), lambda n, _: (f"{n}", "done")) == [0, None, None, None]
    assert made == [0, 1]
    made.clear()

    def fails(n: int) -> int:
        made.append(n)
        if n == 1:
            raise ValueError(n)
        return n

    with Campaign(cluster="local:1") as campaign, pytest.raises(ValueError, match="1"):
        campaign.watch(fails, range(4), lambda n, _: (f"{n}", "done"))
    assert made == [0, 1]
