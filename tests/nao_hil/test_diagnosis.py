"""Odometry against the ground truth, and what went wrong first against what was done to the robot."""

from __future__ import annotations

import math
from collections.abc import Collection
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX, JOINTS
from bridge.body.kinematics import FloatingBase
from bridge.body.quantities import total_mass
from bridge.guard import Guard
from bridge.messages import ActuatorFrame, SensorFrame, WalkTelemetry
from bridge.planar import Pose2D
from bridge.recording.recorder import Recorder
from bridge.rotations import rotation
from emulator.robot import EmulatedRobot
from emulator.scenarios.events import FrictionEvent, PushEvent
from emulator.scenarios.model import Scenario
from emulator.wear import load_wear
from nao_hil.analysis.diagnosis import (
    BalanceEstimator,
    Symptom,
    Symptoms,
    diagnose,
    explain,
    symptoms_of,
)
from nao_hil.analysis.diagnosis.symptoms import Kind
from nao_hil.runs.build import controller_maker
from nao_hil.runs.config import RunConfig
from nao_hil.runs.in_process import run
from nao_hil.runs.run import Cycle, RunObserver, load
from walker.controller import Controller
from walker.estimation.odometry import GroundPlane, Odometry

BODY = load_body("nao-v3")


def walk(gait: str, scenario: Scenario, seconds: float, path: Path | None = None) -> list[Cycle]:
    """A walk in process; recorded, if there is a path."""
    settings = RunConfig(gait=gait, steps=6)
    keeper = RunObserver(BODY)
    with EmulatedRobot(BODY, seed=0, engine="mujoco", scenario=scenario) as robot:
        controller = controller_maker(settings)(BODY, BODY.cycle)
        observers = [keeper]
        if path is None:
            run(robot, Guard(BODY), controller, observers, round(seconds / BODY.cycle))
        else:
            with Recorder(path, settings) as recorder:
                run(robot, Guard(BODY), controller, [*observers, recorder], round(seconds / BODY.cycle))
    return list(keeper.run.cycles())


@pytest.fixture(scope="module")
def quiet() -> list[Cycle]:
    return walk("dynamic", Scenario(), 6.0)


@pytest.fixture(scope="module")
def pushed(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[Cycle], Path]:
    path = tmp_path_factory.mktemp("pushed") / "frames.mcap"
    scenario = Scenario(pushes=(PushEvent(time=4.0, impulse=4.0, direction=90.0),))
    return walk("static", scenario, 8.0, path), path


def test_the_sensors_alone_follow_a_static_walk_to_a_centimetre() -> None:
    cycles = walk("static", Scenario(), 9.0)
    observer = BalanceEstimator(BODY)
    balances = [observer.update(cycle) for cycle in cycles]
    errors, places = [], []
    for balance in balances:
        assert balance.true is not None
        true, sensed = (stand.robot.frames[0][:3, 3] for stand in (balance.true, balance.sensed))
        errors.append(np.linalg.norm(true - sensed))
        places.append(true)
    assert np.linalg.norm(places[-1] - places[0]) > 0.05  # it walked
    assert max(errors) < 0.01


def test_the_measured_and_the_true_zmp_of_a_standing_robot_agree(quiet: list[Cycle]) -> None:
    observer = BalanceEstimator(BODY)
    for cycle in quiet[:100]:
        balance = observer.update(cycle)
    assert balance.true is not None and balance.true.zmp is not None and balance.felt is not None
    assert math.dist(balance.true.zmp, balance.felt) < 0.005
    # At rest the capture point is the projected centre of mass, and so is the ZMP.
    assert math.dist(balance.true.capture, balance.true.robot.com[:2]) < 0.01
    assert sum(cycle.sensors.fsr) == pytest.approx(9.81 * total_mass(BODY), rel=0.1)


@pytest.mark.parametrize(("roll", "pitch"), [(0.0, 0.1), (0.1, 0.0), (-0.08, 0.12)])
def test_a_robot_on_a_slope_stands_on_it(quiet: list[Cycle], roll: float, pitch: float) -> None:
    """With the fused angle of a robot whose left sole lies in a slope, odometry puts that sole on it."""
    kinematics = FloatingBase(BODY)
    frame = quiet[0].sensors
    floor = GroundPlane(roll, pitch, 0.02)
    upright = kinematics.place(kinematics.in_torso(frame.position), np.eye(4)).feet["L"]
    torso = rotation(roll, pitch, 0.0) @ np.linalg.inv(upright)[:3, :3]
    angle = (math.atan2(torso[2, 1], torso[2, 2]), -math.asin(torso[2, 0]))
    placed = Odometry(kinematics, Pose2D(0.3, -0.2, 0.0)).update(
        msgspec.structs.replace(frame, angle=angle, fsr=(10.0,) * 8), floor
    )
    for x, y, z in kinematics.sole_in_world("L", placed.feet["L"]):
        assert z == pytest.approx(floor.at(x, y), abs=2e-3)


def test_the_plan_is_drawn_where_the_robot_stands_however_far_its_own_odometry_is_off(
    quiet: list[Cycle],
) -> None:
    observer, off = BalanceEstimator(BODY), Pose2D(1.0, -2.0, 0.5)

    def moved(walk: WalkTelemetry) -> WalkTelemetry:
        feet = {s: getattr(walk, s) for s in ("left", "right")}
        there = {s: (*off.point(*p[:2]), *p[2:5], p[5] + off.yaw) for s, p in feet.items()}
        return msgspec.structs.replace(walk, zmp=off.point(*walk.zmp), **there)

    checked = 0
    for i, cycle in enumerate(quiet):
        if i > len(quiet) // 2 and cycle.walk is not None:
            cycle = cycle._replace(walk=moved(cycle.walk))
        balance = observer.update(cycle)
        standing = [s for s, lift in balance.plan.lift.items() if lift < 1e-4] if balance.plan else []
        if i > 0.8 * len(quiet) and len(standing) == 1 and balance.plan and balance.true:
            sole, foot = balance.plan.soles[standing[0]], balance.true.robot.feet[standing[0]]
            assert math.hypot(sole.x - foot[0, 3], sole.y - foot[1, 3]) < 0.01
            checked += 1
    assert checked > 20


def test_an_untroubled_walk_has_no_symptom(quiet: list[Cycle]) -> None:
    assert symptoms_of(quiet, BODY) == []
    without_truth = [cycle._replace(truth=None) for cycle in quiet]
    assert symptoms_of(without_truth, BODY) == []


def test_a_push_that_fells_is_named_before_the_zmp(pushed: tuple[list[Cycle], Path]) -> None:
    cycles, path = pushed
    diagnosis = explain(symptoms_of(cycles, BODY))
    assert diagnosis is not None
    truth_fell = next(m.sensors.time for m in cycles if m.truth is not None and m.truth.fell)
    assert diagnosis.fell == truth_fell
    assert diagnosis.before is not None and diagnosis.before.kind == "world"
    assert diagnosis.before.time == pytest.approx(4.0, abs=0.05)
    assert diagnosis.first is not None and diagnosis.first.kind in ("zmp", "slip", "tilt")
    assert 4.0 < diagnosis.first.time < diagnosis.fell
    assert [s.time for s in diagnosis.chain] == sorted(s.time for s in diagnosis.chain)
    assert diagnosis.sentence.startswith(f"The robot fell at {truth_fell:.2f} s; first, at ")
    assert "pushed with 4 N s" in diagnosis.sentence
    assert diagnose(load(path)) == diagnosis  # from the file as from the frames


def test_a_floor_that_turns_to_ice_makes_feet_slip() -> None:
    cycles = walk("dynamic", Scenario(frictions=(FrictionEvent(time=3.5, friction=0.03),)), 6.0)
    kinds = [s for s in symptoms_of(cycles, BODY) if s.kind == "slip"]
    assert kinds and all(s.time > 3.4 for s in kinds)


def test_cycles_without_an_answer_are_told(quiet: list[Cycle]) -> None:
    late = [
        m._replace(sensors=msgspec.structs.replace(m.sensors, missed=max(0, min(20, m.sensors.seq - 300))))
        for m in quiet
    ]
    (missed, *_) = [s for s in symptoms_of(late, BODY) if s.kind == "missed"]
    assert missed.time == pytest.approx(3.0, abs=0.21)


def edited(cycles: list[Cycle], begin: int, **fields: object) -> list[Cycle]:
    """The cycles with other fields in the sensor frames from one on."""
    return [
        c if c.sensors.seq < begin else c._replace(sensors=msgspec.structs.replace(c.sensors, **fields))
        for c in cycles
    ]


def test_a_leg_joint_that_alone_has_no_stiffness_is_named(quiet: list[Cycle]) -> None:
    def stiffness(limp: Collection[str]) -> tuple[float, ...]:
        return tuple(0.0 if joint in limp else 1.0 for joint in JOINTS)

    (limp,) = symptoms_of(edited(quiet, 300, stiffness=stiffness(("LKneePitch",))), BODY)
    assert (limp.kind, limp.time) == ("limp", pytest.approx(300 * BODY.cycle)) and "LKneePitch" in limp.text
    assert symptoms_of(edited(quiet, 300, stiffness=stiffness(("HeadYaw", "LHand"))), BODY) == []
    assert symptoms_of(edited(quiet, 300, stiffness=stiffness(JOINTS)), BODY) == []  # by order, as at rest


@pytest.mark.parametrize("kind", ["limp", "missed", "world"])
def test_a_cause_is_named_before_the_slip_that_follows(kind: Kind) -> None:
    cause, slip = Symptom(4.0, kind, "the cause"), Symptom(5.8, "slip", "the left foot slipped")
    fall = Symptom(6.3, "fall", "the robot fell")
    diagnosis = explain([cause, slip, fall])
    assert diagnosis is not None and (diagnosis.before, diagnosis.first) == (cause, slip)
    assert diagnosis.sentence.index(cause.text) < diagnosis.sentence.index(slip.text)


@pytest.mark.parametrize("off", [False, True])
def test_a_robot_that_lies_there_gives_no_signs_and_torso_control_is_known_to_be_off(
    pushed: tuple[list[Cycle], Path], off: bool
) -> None:
    observer = BalanceEstimator(BODY)
    watch = Symptoms(observer)
    found: list[Symptom] = []
    for cycle in pushed[0]:
        if off and cycle.walk is not None:
            walk = msgspec.structs.replace(cycle.walk, torso_control=(0.0, 0.0))
            cycle = cycle._replace(walk=walk)
        found += watch.update(observer.update(cycle))
    fell = next(s.time for s in found if s.kind == "fall")
    assert [s for s in found if s.time > fell and s.kind != "world"] == []
    assert watch.torso_off == off


def test_symptoms_that_were_overcome_are_not_in_the_chain() -> None:
    early = Symptom(1.0, "slip", "the left foot slipped")
    later = Symptom(5.0, "zmp", "the ZMP left the support polygon")
    fall = Symptom(5.6, "fall", "the robot fell")
    diagnosis = explain([fall, early, later])
    assert diagnosis is not None
    assert (diagnosis.first, diagnosis.chain, diagnosis.before) == (later, (later, fall), None)
    assert explain([early, later]) is None
    alone = explain([fall])
    assert alone is not None and alone.sentence == "The robot fell at 5.60 s, without a sign before."


class Troubled:
    """A controller of which, for a time (s), a joint has no stiffness, or without one frames have no answer."""

    def __init__(self, controller: Controller, joint: str, begin: float, end: float) -> None:
        self._controller, self._joint, self._begin, self._end = controller, joint, begin, end
        self._last: ActuatorFrame | None = None

    def __getattr__(self, name: str) -> object:
        return getattr(self._controller, name)

    def tick(self, frame: SensorFrame) -> ActuatorFrame:
        command = self._controller.tick(frame)
        if self._begin <= frame.time < self._end:
            if not self._joint:
                return self._last or command
            stiffness = list(command.stiffness)
            stiffness[INDEX[self._joint]] = 0.0
            command = msgspec.structs.replace(command, stiffness=tuple(stiffness))
        self._last = command
        return command


@pytest.mark.parametrize(
    ("joint", "lasting", "impulse", "kind"),
    [("LKneePitch", 9.0, 0.0, "limp"), ("", 0.6, 0.0, "missed"), ("", 0.0, 7.0, "world")],
    ids=["limp", "pause", "push"],
)
def test_a_fall_is_blamed_on_what_came_before_it_and_not_on_its_first_sign(
    joint: str, lasting: float, impulse: float, kind: str
) -> None:
    """Nominal robots until two fell; the cause comes in another phase of each step, and some bear a pause."""
    body, blamed = load_body("nao-v6"), []
    for seed in range(21, 33):
        begin, settings = 4.1 + 0.13 * (seed % 3), RunConfig(gait="omni", velocity=(0.4, 0.0, 0.0), steps=0)
        pushes = (PushEvent(time=begin, impulse=impulse, direction=90.0),) if impulse else ()
        keeper = RunObserver(body)
        scenario, wear = Scenario(pushes=pushes), load_wear("nominal")
        with EmulatedRobot(body, seed=seed, engine="mujoco", wear=wear, scenario=scenario) as robot:
            controller: Any = Troubled(
                controller_maker(settings)(body, body.cycle), joint, begin, begin + lasting
            )
            run(robot, Guard(body), controller, [keeper], 550, ended=lambda: robot.truth().fell)
        if (diagnosis := diagnose(keeper.run)) is not None:
            assert diagnosis.before is not None, diagnosis.sentence
            blamed.append((diagnosis.before.kind, diagnosis.before.time - begin))
        if len(blamed) == 2:
            break
    assert len(blamed) == 2
    assert all(named == kind and abs(late) < 0.05 for named, late in blamed), blamed
