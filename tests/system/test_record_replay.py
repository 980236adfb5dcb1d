"""Recordings from the wire and back onto it, whole and cut off."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import msgspec
import pytest

from bridge.body import load_body
from bridge.errors import ConfigurationError, LeaseRefused
from bridge.guard import Guard
from bridge.link import ControllerLink
from bridge.messages import SensorFrame, TruthFrame
from bridge.recording.playback import Recorded, read_recording
from bridge.recording.recorder import Recorder
from emulator.robot import EmulatedRobot
from nao_hil.cli.main import run as nao_hil
from nao_hil.runs import in_process as inprocess
from nao_hil.runs.capture import Capture, described
from nao_hil.runs.replay import Replay
from tests.loops import TIMEOUT, repeat_while, until
from walker.controller import Controller, WalkOrder
from walker.gaits import gait_parameters, make_gait
from walker.parameters import controller_parameters

BODY = load_body("nao-v3")


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four seconds of a dynamic walk."""
    path = tmp_path_factory.mktemp("recording") / "walk.mcap"
    gait = make_gait("dynamic", gait_parameters("dynamic"), BODY)
    bare = controller_parameters("dynamic", {"switches": {"torso": "none"}})
    controller = Controller(BODY, gait, WalkOrder(), BODY.cycle, bare)
    with EmulatedRobot(BODY, seed=2, engine="mujoco") as robot, Recorder(path, {"robot": "nao-v3"}) as recorder:
        inprocess.run(robot, Guard(BODY), controller, [recorder], 400)
    return path


@contextmanager
def playing(path: Path, endpoint: str, speed: float) -> Iterator[Replay]:
    """A recording that is played once, as soon as somebody listens."""
    end = threading.Event()

    def wait(seconds: float) -> bool:
        return end.wait(seconds) if seconds > 0.0 else end.is_set()

    def heard() -> bool:
        return end.is_set() or bool(player._publishers["sensors"].matching_status.matching)

    def run() -> None:
        until(heard, "a listener")
        player.play(wait, speed=speed)

    with Replay(path, "film", endpoint) as player:
        thread = threading.Thread(target=run)
        thread.start()
        try:
            yield player
        finally:
            end.set()
            thread.join()


def of_kind(items: list[Recorded], kind: type[Any]) -> dict[int, Any]:
    return {item.message.seq: item.message for item in items if isinstance(item.message, kind)}


def test_what_is_replayed_and_recorded_again_is_the_same(
    recording: Path, endpoint: str, tmp_path: Path
) -> None:
    """Pose and every other number of a frame, bit for bit: msgpack and JSON carry floats whole."""
    again = tmp_path / "again.mcap"
    with playing(recording, endpoint, speed=4.0) as player, Capture("film", endpoint) as capture:
        info = capture.wait_robot(lambda: False)
        assert info is not None
        assert (info.body, info.side) == ("nao-v3", "replay")
        with Recorder(again, described(info)) as recorder:
            for _ in repeat_while(lambda: player.position < 3.98, 5000):
                capture.record(recorder, 0.1)
            capture.record(recorder, 1.0)
    before, after = list(read_recording(recording)), list(read_recording(again))
    for kind in (SensorFrame, TruthFrame):
        old, new = of_kind(before, kind), of_kind(after, kind)
        assert len(new) > 350
        for seq, message in new.items():
            assert msgspec.structs.replace(message, **({"wall": 0} if kind is SensorFrame else {})) == old[seq]
    assert capture.refused == 0


def test_a_recording_takes_no_commands(recording: Path, endpoint: str) -> None:
    with playing(recording, endpoint, speed=1.0), ControllerLink("film", endpoint, "stranger") as link:
        assert link.wait_robot(timeout=TIMEOUT) is not None
        with pytest.raises(LeaseRefused, match="A recording is played back here"):
            link.acquire()


def on_disk(recording: Path) -> int:
    """Sensor frames of a recording that is being written; 0 before it has begun."""
    try:
        return len(of_kind(list(read_recording(recording)), SensorFrame))
    except ConfigurationError:
        return 0


def test_a_recording_cut_off_by_kill_9_opens(
    recording: Path, endpoint: str, tmp_path: Path, start: Callable[..., Any]
) -> None:
    cut = tmp_path / "cut.mcap"
    command = start("record", "--name", "film", "--connect", endpoint, "--out", str(cut))
    with playing(recording, endpoint, speed=0.5):
        until(lambda: on_disk(cut) > 50, "half a second on the disk")
        command.process.send_signal(signal.SIGKILL)
        assert command.wait() == -signal.SIGKILL
    assert not cut.read_bytes().endswith(b"\x89MCAP0\r\n")  # the mark at the end of a whole file
    old, new = (of_kind(list(read_recording(path)), SensorFrame) for path in (recording, cut))
    assert len(new) > 50
    assert all(new[seq].position == old[seq].position for seq in new)
    assert sorted(new) == list(range(min(new), max(new) + 1))
    cut.write_bytes(cut.read_bytes()[:-3])  # within a record, wherever the kill came
    assert set(of_kind(list(read_recording(cut)), SensorFrame)) <= set(new)


def test_a_recording_that_is_there_is_not_written_over(recording: Path, endpoint: str) -> None:
    before = recording.read_bytes()
    assert nao_hil(["record", "--out", str(recording), "--connect", endpoint]) == 2
    assert recording.read_bytes() == before
