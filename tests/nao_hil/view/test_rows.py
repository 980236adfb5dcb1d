"""The page's data: rows, states, events and packed runs."""

from __future__ import annotations

import base64
import math
import re
from pathlib import Path
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import JOINTS
from bridge.messages import ActuatorFrame, Notice, WalkTelemetry
from bridge.messages.frames import ORDER
from bridge.messages.guard import GuardStatus
from bridge.rotations import matrix
from emulator.robot import EmulatedRobot
from emulator.scenarios import load_scenario
from nao_hil.analysis.diagnosis import BalanceEstimator, Diagnosis, Symptom, explain
from nao_hil.analysis.diagnosis.symptoms import MEANING, Symptoms
from nao_hil.runs.run import Cycle
from nao_hil.view.live_run import LiveRun
from nao_hil.view.page import world_page, world_recordings
from nao_hil.view.rows import RunRows, events_json
from nao_hil.view.signals import SIGNALS
from nao_hil.view.state import describe
from nao_hil.view.surroundings import initial_world, terrain_meshes
from tests.frames import truth_frame, walk_telemetry
from tests.made_worlds import record_world
from tests.nao_hil.test_export_run import unpacked
from tests.nao_hil.view.conftest import BODY, REPLY, STATUS


def test_a_row_holds_the_true_pose_the_forces_and_every_signal(standing: list[Cycle]) -> None:
    cycle = standing[-1]
    asked = ActuatorFrame(position=tuple(0.01 * i for i in range(25)), stiffness=(1.0,) * 25, reply_to=1)
    rows = RunRows(BODY)
    row = rows.row(BalanceEstimator(BODY).update(cycle._replace(asked=asked)), 1.5)
    _, tables = unpacked(rows.pack(np.array([row]), []))
    assert cycle.truth is not None
    torso = 3 * rows.links.index("Torso")
    np.testing.assert_allclose(tables["position"][0, torso : torso + 3], cycle.truth.torso_position, atol=1e-4)
    w, x, y, z = tables["attitude"][0, :4]
    np.testing.assert_allclose(matrix((x, y, z, w)), matrix(cycle.truth.torso_orientation), atol=1e-3)
    np.testing.assert_allclose(tables["loads"][0], cycle.sensors.fsr, atol=0.06)
    signals = dict(zip(SIGNALS, tables["signals"][0], strict=True))
    knee = JOINTS.index("LKneePitch")
    expected = {
        "torso pitch": math.degrees(cycle.sensors.angle[1]),
        "force left foot": sum(cycle.sensors.fsr[:4]),
        "cycle late": 1.5,
        "accelerometer z": cycle.sensors.accelerometer[2],
        "angle LKneePitch": math.degrees(cycle.sensors.position[knee]),
        "command LKneePitch": math.degrees(0.01 * knee),
        "current LKneePitch": cycle.sensors.current[knee],
        "temperature LKneePitch": cycle.sensors.temperature[knee],
    }
    assert {name: signals[name] for name in expected} == pytest.approx(expected, abs=0.006)
    assert math.isnan(signals["ZMP margin planned"])  # no walker has said anything


def test_a_row_holds_the_pose_of_each_other_robot_of_the_world_by_its_name(standing: list[Cycle]) -> None:
    bodies = {"blue": load_body("nao-v6"), "green": BODY, "white": BODY}
    turn = (0.0, 0.0, math.sin(0.4), math.cos(0.4))
    joints = tuple(0.01 * i for i in range(len(JOINTS)))
    blue = truth_frame(torso_position=(1.0, -0.5, 0.3), torso_orientation=turn, joints=joints)
    rows = RunRows(BODY, None, bodies)
    balance = BalanceEstimator(BODY).update(standing[-1])
    row = rows.row(balance, others={"blue": blue, "green": standing[-1].truth, "white": None})
    header, tables = unpacked(rows.pack(np.array([row]), []))
    assert [other["name"] for other in header["others"]] == ["blue", "green", "white"]  # type: ignore[index, attr-defined]
    poses = tables["others"].reshape(3, 32)
    w, x, y, z = poses[0, 3:7]
    np.testing.assert_allclose(poses[0], [1.0, -0.5, 0.3, w, x, y, z, *joints], atol=1e-4)
    np.testing.assert_allclose(matrix((x, y, z, w)), matrix(turn), atol=1e-3)
    assert standing[-1].truth is not None
    np.testing.assert_allclose(poses[1, :3], standing[-1].truth.torso_position, atol=1e-4)
    assert np.isnan(poses[2]).all()
    # own body with the ground, and the other one; each piece of a link of its body
    bodies_ = header["bodies"]
    assert len(bodies_) == 2 and [o["body"] for o in header["others"]] == [1, 0, 0]  # type: ignore[arg-type, index, attr-defined]


def test_a_live_run_gives_a_late_browser_what_the_others_have(standing: list[Cycle]) -> None:
    info = SimpleNamespace(body=BODY.name, sheet="", side="emulator", mode="real-time")
    run = LiveRun(info, "robot nao", REPLY)  # type: ignore[arg-type]
    assert len(unpacked(run.packed(emulated=True))[1]["time"]) == 0  # of one before the first frame
    messages = [message for cycle in standing for message in run.take(cycle)]
    sent = np.array([np.frombuffer(m, "<f4") for m in messages if isinstance(m, bytes)])
    header, tables = unpacked(run.packed(emulated=True))
    assert sent.shape == (len(tables["time"]), run.rows.width)
    np.testing.assert_allclose(sent[:, 0], tables["time"][:, 0], atol=1e-3)
    prints = [p for m in messages if isinstance(m, dict) for p in m.get("prints", [])]
    assert len(prints) == len(tables["footprints"]) == 2
    assert header["live"] == {"emulated": True}


def test_the_fall_says_its_first_sign_and_when_it_was_over() -> None:
    first = Symptom(4.2, "zmp", "the ZMP left the support polygon")
    push = Symptom(4.0, "world", "Torso is pushed with 1 N s over 0.1 s")
    fall = Symptom(4.9, "fall", "the robot fell")
    diagnosis = Diagnosis(fell=4.9, chain=(push, first, fall), first=first, before=push, torso_off=True)
    told = events_json([push, first, fall], diagnosis, 9.5)
    assert told["fall"]["time"] == 4.9 and told["fall"]["until"] == 9.5 and told["fall"]["first"] == 4.0
    assert told["fall"]["text"] == f"{push.text}, then {first.text}"
    assert told["fall"]["meaning"].startswith(MEANING["zmp"])
    assert told["fall"]["meaning"].endswith("torso control was off.")
    assert [event["time"] for event in told["events"]] == [4.0, 4.2, 4.9]
    assert events_json([], None) == {"events": [], "fall": None}


def telemetry(seq: int, state: str = "walk") -> WalkTelemetry:
    return walk_telemetry(seq, state=state, phase="SSL", step=3)


@pytest.mark.parametrize(
    ("guard", "angle", "words", "alarm"),
    [
        ({"state": "active", "holder": "walker"}, (0.0, 0.0), "walks", False),
        ({"state": "active", "holder": "mine"}, (0.0, 0.0), "held by mine", False),
        ({"state": "crouch", "reason": "stop"}, (0.0, 0.0), "crouching, emergency stop", True),
        ({"state": "rest", "reason": "stop"}, (0.0, 0.0), "limp, emergency stop", True),
        ({"state": "fallen", "reason": "fall"}, (0.0, -1.5), "limp, lies on its back", True),
        ({"state": "fallen", "reason": "fall"}, (0.0, 1.5), "limp, lies on its front", True),
        ({"state": "fallen", "reason": "fall"}, (1.5, 0.0), "limp, lies on its side", True),
        ({"state": "hold", "reason": "silence"}, (0.0, 0.0), "holds its pose: its controller is silent", False),
        ({"state": "idle"}, (0.0, 0.0), "free, joints left alone", False),
        ({"state": "idle", "holder": "mine"}, (0.0, 0.0), "held by mine", False),
    ],
)
def test_the_state_is_the_robots_own_report_not_the_walkers_last_word(
    standing: list[Cycle], guard: dict[str, str], angle: tuple[float, float], words: str, alarm: bool
) -> None:
    frame = msgspec.structs.replace(standing[-1].sensors, angle=angle)
    walks = guard.get("holder") == "walker"
    cycle = Cycle(frame, walk=telemetry(frame.seq if walks else max(frame.seq - 100, 0)))
    report = GuardStatus(seq=1, armed=True, text="", **guard)  # type: ignore[arg-type]
    state = describe(cycle, report, STATUS, REPLY, 0.0)
    assert (state["words"], state["alarm"]) == (words, alarm)
    assert state["velocity"] == ([0.05, 0.0, 0.0] if walks else [0.0, 0.0, 0.0])


def test_a_silent_robot_is_not_said_to_walk(standing: list[Cycle]) -> None:
    frame = standing[-1].sensors
    cycle = Cycle(frame, walk=telemetry(frame.seq))
    report = GuardStatus(seq=1, state="active", armed=True, holder="walker", text="")
    assert describe(cycle, report, STATUS, REPLY, 4.2)["words"] == "no word from the robot for 4 s"
    paused = msgspec.structs.replace(REPLY, paused=True)
    assert describe(cycle, report, STATUS, paused, 4.2)["words"] == "paused"
    assert describe(None, None, None, None, 0.0)["words"] == "waits for the robot"


def test_stops_arming_and_orders_are_events_also_of_a_robot_that_lies_and_no_sign_of_trouble(
    standing: list[Cycle],
) -> None:
    notices = tuple(
        Notice(seq=1, level="info", code=code, text=f"{code}.")
        for code in ("guard-stop", "guard-armed", ORDER, "guard-active", "clipped")
    )
    watch = Symptoms(observer := BalanceEstimator(BODY))
    watch.update(observer.update(standing[-2]))
    watch._lies = True
    found = watch.update(observer.update(standing[-1]._replace(notices=notices)))
    assert [(s.kind, s.text) for s in found] == [("order", c) for c in ("guard-stop", "guard-armed", ORDER)]
    fall = Symptom(found[0].time + 1.0, "fall", "the robot fell")
    diagnosis = explain([*found, fall])
    assert diagnosis is not None and diagnosis.first is None and diagnosis.before is None


def test_a_recorded_world_holds_a_run_of_each_robot_with_the_others_in_it(tmp_path: Path) -> None:
    last = record_world(tmp_path, 30)
    assert list(world_recordings(tmp_path)) == ["blue", "red"]
    html, _ = world_page(world_recordings(tmp_path), "blue")
    texts = re.findall(r'<script type="application/octet-stream">(.*?)</script>', html)
    runs = [unpacked(base64.b64decode(text)) for text in texts]
    assert [header["name"] for header, _ in runs] == ["blue", "red"]  # the chosen one is shown first
    for (header, tables), other in zip(runs, ("red", "blue"), strict=True):
        assert header["names"] == ["blue", "red"]
        (drawn,) = header["others"]  # type: ignore[misc, attr-defined]
        assert drawn["name"] == other
        np.testing.assert_allclose(tables["others"][-1, :3], last[other].torso_position, atol=2e-3)
        np.testing.assert_allclose(tables["others"][-1, 7:], last[other].joints, atol=5e-3)
        assert len(header["objects"]) == 6 and header["field"]["size"] == [7.4, 5.4]  # type: ignore[index, arg-type]


@pytest.mark.parametrize("name", ["tiles", "rough"])
def test_the_terrain_of_a_recording_is_the_one_the_robot_walked(name: str) -> None:
    scenario = load_scenario(name)
    terrain = initial_world(scenario, 3).terrain
    assert terrain is not None
    with EmulatedRobot(BODY, seed=3, scenario=scenario) as robot:
        assert robot.world.terrain == terrain
        (mesh,) = terrain_meshes(terrain)
        # over the middle of each upward face the ground is as high as the face, where no other tile is near
        corners = mesh[0][mesh[1]]
        upward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, 2] > 1e-9
        middles = corners[upward].mean(axis=1)
        inside = middles[np.abs(middles[:, :2]).max(axis=1) < 0.4]
        heights = robot.world.ground([(float(x), float(y)) for x, y, _ in inside])
    assert len(inside) > 50
    np.testing.assert_allclose(heights, inside[:, 2], atol=1e-4)
