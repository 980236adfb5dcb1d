from __future__ import annotations

import itertools
import random
import socket
from pathlib import Path

import pytest

from bridge.adapters.lola.address import Address, connect, listen, parse_address, remove
from bridge.adapters.lola.server import LATE_FRAME_WAIT, PERIOD, SEND_DELAY, PacketTimer
from bridge.errors import ConfigurationError, LinkError
from tests.loops import repeat_while
from tests.ports import free_port

MS = 1_000_000


class Clock:
    def __init__(self) -> None:
        self.now = 0

    def __call__(self) -> int:
        return self.now


def packets(timer: PacketTimer, clock: Clock, frames: list[int], end: int) -> list[tuple[int, int]]:
    """Times of the packets and the frames in them, with frames that come at given times; a step is 0.1 ms."""
    sent, newest, left = [], -1, list(enumerate(frames))
    for _ in range(0, end, MS // 10):
        clock.now += MS // 10
        for _ in repeat_while(lambda: left and left[0][1] <= clock.now):
            newest, arrived = left.pop(0)
            timer.frame(arrived)
        if timer.due():
            sent.append((clock.now, newest))
    return sent


def test_packets_follow_frames_and_do_not_pass_their_jitter_on() -> None:
    """Frames every 12 ms, up to 0.8 ms early or late: the packets' gaps stay within 0.3 ms of 12."""
    clock, random_ = Clock(), random.Random(1)
    frames = [5 * MS + k * PERIOD + round(random_.uniform(-0.8, 0.8) * MS) for k in range(500)]
    timer = PacketTimer(0.012, clock)
    sent = packets(timer, clock, frames, frames[-1])[20:]
    gaps = [b[0] - a[0] for a, b in itertools.pairwise(sent)]
    assert max(gaps) <= PERIOD + 0.3 * MS and min(gaps) >= PERIOD - 0.3 * MS
    assert [frame for _, frame in sent] == list(range(sent[0][1], sent[0][1] + len(sent)))  # each frame once
    assert timer.skipped == 0


def test_a_robot_whose_clock_runs_otherwise_is_followed() -> None:
    """200 ppm off for five minutes is five cycles; no packet repeats a frame."""
    clock = Clock()
    frames = [round(k * PERIOD * 1.0002) for k in range(1, 5000)]
    timer = PacketTimer(0.012, clock)
    sent = packets(timer, clock, frames, frames[-1])
    late = [at - frames[frame] for at, frame in sent[20:]]
    assert min(late) > 0.5 * SEND_DELAY and max(late) < 2.0 * SEND_DELAY
    assert timer.repeated <= 1


def test_a_late_frame_is_waited_for_and_a_missing_one_is_not() -> None:
    clock = Clock()
    frames = [k * PERIOD for k in range(1, 40)]
    frames[20] += SEND_DELAY + LATE_FRAME_WAIT // 2  # late, in time for the grace
    del frames[30]
    timer = PacketTimer(0.012, clock)
    sent = packets(timer, clock, frames, frames[-1])
    assert timer.repeated == 1
    gaps = [b[0] - a[0] for a, b in itertools.pairwise(sent[2:])]
    assert max(gaps) < PERIOD + LATE_FRAME_WAIT + 0.3 * MS


@pytest.mark.parametrize("cycle", [0.010, 0.020])
def test_for_another_cycle_the_clock_alone_sets_the_beat(cycle: float) -> None:
    clock = Clock()
    frames = [round(k * cycle * 1e9) for k in range(1, 400)]
    timer = PacketTimer(cycle, clock)
    sent = packets(timer, clock, frames, frames[-1])
    assert {b[0] - a[0] for a, b in itertools.pairwise(sent)} == {PERIOD}


def test_a_loop_that_was_held_up_sends_no_burst() -> None:
    clock = Clock()
    timer = PacketTimer(0.010, clock)
    clock.now = 10 * PERIOD + 1
    assert timer.due() and not timer.due()
    assert timer.skipped == 9


@pytest.mark.parametrize("text", ["robocup", "10.0.0.1", "10.0.0.1:0", "host:", ":10000", "host:99999"])
def test_anything_else_is_refused_in_one_sentence(text: str) -> None:
    with pytest.raises(ConfigurationError, match=r"must be a path with a `/`.*or HOST:PORT"):
        parse_address(text)


def test_a_socket_that_a_dead_server_left_is_replaced(tmp_path: Path) -> None:
    address = Address(path=str(tmp_path / "robocup"))
    with listen(address):
        pass
    assert (tmp_path / "robocup").exists()
    with listen(address) as listener, connect(address, 1.0) as peer, listener.accept()[0] as other:
        peer.sendall(b"x")
        assert other.recv(1) == b"x"
    remove(address)
    assert not (tmp_path / "robocup").exists()


def test_the_path_is_there_once_a_client_can_connect(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, seen, begin = tmp_path / "robocup", [], socket.socket.listen

    def watched(listener: socket.socket) -> None:
        seen.append(path.exists())
        begin(listener)

    monkeypatch.setattr(socket.socket, "listen", watched)
    address = Address(path=str(path))
    with listen(address), connect(address, 1.0):
        assert seen == [False]
    assert [each.name for each in tmp_path.iterdir()] == ["robocup"]


def test_where_somebody_listens_or_a_file_is_nobody_else_listens(tmp_path: Path) -> None:
    address = Address(path=str(tmp_path / "robocup"))
    with listen(address), pytest.raises(LinkError, match="another server does"):
        listen(address)
    (tmp_path / "file").write_text("mine")
    with pytest.raises(LinkError, match="no socket; name another path"):
        listen(Address(path=str(tmp_path / "file")))
    assert (tmp_path / "file").read_text() == "mine"
    with pytest.raises(LinkError, match="Cannot listen on"):
        listen(Address(path=str(tmp_path / "nowhere" / "robocup")))


def test_over_tcp_small_packets_go_out_at_once() -> None:
    address = Address(host="127.0.0.1", port=free_port())
    with listen(address), connect(address, 1.0) as peer:
        assert peer.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)
        with pytest.raises(LinkError, match="in use"):
            listen(address)
