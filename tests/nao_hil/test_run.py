"""A run as tables: the same live and from its recording, and its questions against what was put in."""

from __future__ import annotations

from pathlib import Path

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import N_JOINTS
from bridge.errors import ConfigurationError
from bridge.messages import ActuatorFrame, Notice
from bridge.messages.frames import N_LEDS
from bridge.messages.world_state import WorldObject
from bridge.recording.recorder import Recorder
from nao_hil.runs.run import Run, RunObserver, load
from tests.frames import standing_frame, truth_frame, walk_telemetry

BODY = load_body("nao-v6")


@pytest.fixture(scope="module")
def live_and_recorded(tmp_path_factory: pytest.TempPathFactory) -> tuple[Run, Run]:
    """Twenty cycles; every third one has telemetry and a command, the fall is in the sixteenth."""
    file = tmp_path_factory.mktemp("run") / "run.mcap"
    observer = RunObserver(BODY)
    at, turn = (0.1, 0.2, 0.05), (0.0, 0.0, 0.0, 1.0)
    ball = WorldObject(name="b", shape="ball", size=(0.1,) * 3, position=at, orientation=turn, mass=0.044)
    with Recorder(file, {"robot": "nao-v6", "wear": "/a/worn.toml", "seed": 3}) as recorder:
        for k in range(20):
            truth = msgspec.structs.replace(
                truth_frame(k),
                time=k * BODY.cycle,
                zmp=(0.01 * k, 0.0) if k % 2 else None,
                leds=(k,) * N_LEDS if k > 10 else (),
                fell=k >= 15,
                objects=(ball,) if k > 4 else (),
            )
            for each in (observer, recorder):
                each.sensors(standing_frame(k, time=k * BODY.cycle), truth)
                if k % 3 == 0:
                    each.message(walk_telemetry(k, phase="SSL" if k < 9 else "SSR"))
                    each.command(ActuatorFrame(reply_to=k, position=(0.1,) * 25, stiffness=(1.0,) * N_JOINTS))
                if k == 7:
                    each.message(Notice(seq=k, level="info", code="push", text="A push."))
    return observer.run, load(file)


def test_a_run_is_the_same_live_and_recorded(live_and_recorded: tuple[Run, Run]) -> None:
    live, recorded = live_and_recorded
    assert list(live) == list(recorded)
    for topic, table in live.items():
        assert table.rows and list(table) == list(recorded[topic])
        for name, values in table.items():
            if name == "time":  # a file has whole nanoseconds
                np.testing.assert_allclose(values, recorded[topic][name], atol=1e-9)
            else:
                np.testing.assert_array_equal(values, recorded[topic][name])
    assert list(live.cycles()) == list(recorded.cycles())


def test_a_row_for_each_frame_has_the_newest_message_of_other_topics(
    live_and_recorded: tuple[Run, Run],
) -> None:
    table = live_and_recorded[1].aligned("actuators", ["actuators.reply_to", "sensors.seq", "notices.code"])
    assert table["actuators.reply_to"].tolist() == [9, 12, 15, 18]  # none before the first notice
    assert table["sensors.seq"].tolist() == [9, 12, 15, 18]
    every = live_and_recorded[1].aligned("sensors", ["walk/telemetry.phase", "world/truth.com"])
    assert every.rows == 20 and every["world/truth.com"].shape == (20, 3)
    assert every["walk/telemetry.phase"].tolist() == ["SSL"] * 9 + ["SSR"] * 11
    assert every.columns["world/truth.com"].frame == "world"
    assert every.until(every["time"][3]).rows == 3
    with pytest.raises(ConfigurationError, match=r"a list is expected, as \['world/truth.com'\]"):
        live_and_recorded[1].aligned("sensors", "world/truth.com")
    with pytest.raises(ConfigurationError, match="rows are not in the table"):
        every.where([True])


def test_a_stretch_has_its_tables_and_its_cycles(live_and_recorded: tuple[Run, Run]) -> None:
    run = live_and_recorded[1]
    part = run.between(5 * BODY.cycle, 8 * BODY.cycle)
    assert part["sensors"]["seq"].tolist() == [5, 6, 7, 8] == [c.sensors.seq for c in part.cycles()]
    assert part["notices"]["text"].tolist() == ["A push."] and part.fell is None
    assert run.fell == pytest.approx(15 * BODY.cycle)
    assert part.title == "nao-v6, wear worn.toml, seed 3" and part.body.name == "nao-v6"


def test_a_run_of_an_unknown_body_has_tables_all_the_same(tmp_path: Path) -> None:
    with Recorder(tmp_path / "run.mcap", {}) as recorder:
        recorder.write(standing_frame(0))
    run = load(tmp_path / "run.mcap")
    assert run["sensors"].rows == 1 and run["world/truth"].rows == 0 == len(run["world/truth"]["fell"])
    assert run["world/truth"]["com"].shape == (0, 3)
    with pytest.raises(ConfigurationError, match="--robot"):
        print(run.body)
    assert load(tmp_path / "run.mcap", "nao-v5").body.name == "nao-v5"
