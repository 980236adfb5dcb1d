"""Learned gaits: their clock and way, what the network sees, what becomes of its outputs, and faults."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.postures import POSTURES
from bridge.errors import ConfigurationError
from bridge.guard import Guard
from bridge.types import Vec2, Vec3
from emulator.robot import EmulatedRobot
from emulator.wear import load_wear
from tests.frames import standing_frame
from tests.policies import LEGS, sheet, write_policy
from tests.states import rigid_state
from walker.controller import Controller, WalkOrder
from walker.estimation.contact import Contacts, SupportState
from walker.gaits import dry_walk, gait_parameters, make_gait
from walker.gaits.catalogue import gait_file
from walker.gaits.gait import GaitCommand
from walker.gaits.learned import POLICIES
from walker.gaits.learned.gait import LearnedGait
from walker.monitor import Estimate
from walker.parameters import controller_parameters
from walker.policy import PolicyRunner

BODY = load_body("nao-v3")
CYCLE = BODY.cycle


def gait_of(folder: Path, table: dict[str, Any], **network: Any) -> LearnedGait:
    name = write_policy(folder, table, **network)
    gait = make_gait(name, gait_parameters(name), BODY)
    assert isinstance(gait, LearnedGait)
    return gait


def runner_of(gait: LearnedGait, cycle: float = CYCLE) -> PolicyRunner:
    return PolicyRunner(BODY, gait, controller_parameters(gait.name), cycle)


def estimate(lean: Vec2 = (0.0, 0.0), rate: Vec3 = (0.0, 0.0, 0.0)) -> Estimate:
    return Estimate(rigid_state(BODY, POSTURES["StandInit"], lean, rate), Contacts(True, False))


class Spy:
    """In place of a network: keeps what it sees, and gives what it is told."""

    def __init__(self, *answers: np.ndarray) -> None:
        self.seen: list[np.ndarray] = []
        self._answers = answers

    def __call__(self, observation: np.ndarray) -> np.ndarray:
        self.seen.append(observation)
        return self._answers[min(len(self.seen), len(self._answers)) - 1]


def test_the_way_is_the_integral_of_a_command_that_changes_at_a_bounded_rate(tmp_path: Path) -> None:
    gait = gait_of(
        tmp_path,
        sheet(command=sheet()["command"] | {"default": [0.1, 0.0, 0.0], "acceleration": [0.2, 1.0, 1.0]}),
    )
    state, plan = gait.initial(), None
    for _ in range(301):  # the first call begins the walk
        plan, state = gait.step(state, CYCLE, GaitCommand(walk=True))
    assert plan is not None and plan.policy is not None
    assert plan.policy.velocity[0] == pytest.approx(0.1)
    # half a second from rest to 0.1 m/s at 0.2 m/s^2, then 2.5 s
    assert plan.middle.x == pytest.approx(0.5 * 0.1 * 0.5 + 0.1 * 2.5, abs=0.1 * CYCLE)
    assert plan.step == 12  # of 0.25 s


def test_a_walk_of_some_steps_counts_the_closing_one_and_ends_in_a_stand(tmp_path: Path) -> None:
    plans = [plan for plan, _ in dry_walk(gait_of(tmp_path, sheet()), CYCLE, steps=4)]
    assert [plans[0].phase, plans[-1].phase, plans[-1].step] == ["DSL", "stand", 4]
    assert {plan.phase for plan in plans} == {"DSL", "DSR", "stop", "stand"}
    assert len(plans) * CYCLE == pytest.approx(3 * 0.25 + 1.0, abs=3 * CYCLE)


def test_the_terms_are_the_measured_state_in_order_scaled_after_the_offset(tmp_path: Path) -> None:
    table = sheet(
        observation=[
            {"term": "projected_gravity"},
            {"term": "base_angular_velocity", "scale": 0.5},
            {"term": "base_angular_velocity", "frame": "heading"},
            {"term": "velocity_command", "scale": [1.0, 2.0, 3.0]},
            {"term": "joint_position", "joints": ["LKneePitch", "RHipYawPitch"], "offset": 0.1, "scale": 10.0},
            {"term": "joint_position", "joints": ["LKneePitch"], "relative": False},
            {"term": "gait_phase_sin"},
            {"term": "gait_phase_cos"},
            {"term": "foot_contact"},
            {"term": "foot_force"},
            {"term": "fused_angle"},
        ],
        phase={"period": 0.5, "start": 0.25},
    )
    gait = gait_of(tmp_path, table, weights=np.zeros((23, len(LEGS))))
    spy = Spy(np.zeros(len(LEGS)))
    gait.network = spy  # type: ignore[assignment]
    roll, pitch = 0.2, -0.1
    knee = POSTURES["StandInit"][INDEX["LKneePitch"]]
    position = list(POSTURES["StandInit"])
    position[INDEX["LKneePitch"]] += 0.03
    frame = standing_frame(
        position=tuple(position), gyroscope=(0.0, 0.0, 1.0), fsr=(1.0,) * 4 + (2.0,) * 4, angle=(0.01, 0.02)
    )
    plan, _ = gait.step(gait.initial(), 0.0, GaitCommand(walk=True, velocity=(0.1, 0.1, 0.5)))
    runner_of(gait).update(plan, SupportState("both"), estimate((roll, pitch), frame.gyroscope), frame, CYCLE)
    # R = R_pitch R_roll; gravity in the torso is R^T (0, 0, -1), a turn about the torso's z is R (0, 0, 1)
    down = (math.sin(pitch), -math.sin(roll) * math.cos(pitch), -math.cos(roll) * math.cos(pitch))
    turned = (math.sin(pitch) * math.cos(roll), -math.sin(roll), math.cos(pitch) * math.cos(roll))
    expected = [
        *down,
        0.0,
        0.0,
        0.5,
        *turned,
        0.0,
        0.0,
        0.0,
        1.3,
        1.0,
        knee + 0.03,
        1.0,
        0.0,
        1.0,
        0.0,
        4.0,
        8.0,
    ]
    np.testing.assert_allclose(spy.seen[0], [*expected, 0.01, 0.02], atol=1e-9)


def test_histories_begin_with_the_first_value_and_have_the_oldest_first(tmp_path: Path) -> None:
    table = sheet(observation=[{"term": "fused_angle", "history": 2}, {"term": "previous_action"}], history=2)
    inputs = 2 * (2 * 2 + len(LEGS))
    gait = gait_of(tmp_path, table, weights=np.zeros((inputs, len(LEGS))))
    spy = Spy(np.full(len(LEGS), 0.3), np.zeros(len(LEGS)))
    gait.network = spy  # type: ignore[assignment]
    runner, plan = runner_of(gait), gait.step(gait.initial(), 0.0, GaitCommand(walk=True))[0]
    for seq, angle in enumerate((0.1, 0.2)):
        frame = standing_frame(seq, angle=(angle, 0.0))
        runner.update(plan, SupportState("both"), estimate(), frame, CYCLE)
    zeros, actions = [0.0] * len(LEGS), [0.3] * len(LEGS)
    np.testing.assert_allclose(spy.seen[0], [0.1, 0.0, 0.1, 0.0, *zeros] * 2)
    np.testing.assert_allclose(spy.seen[1], [0.1, 0.0, 0.1, 0.0, *zeros, 0.1, 0.0, 0.2, 0.0, *actions])


@pytest.mark.parametrize(
    ("policy", "cycle", "calls"), [(0.02, 0.01, 60), (0.02, 0.012, 60), (0.01, 0.012, 100)]
)
def test_a_policy_of_another_cycle_is_called_as_often_in_the_mean_and_held_between(
    tmp_path: Path, policy: float, cycle: float, calls: int
) -> None:
    gait = gait_of(tmp_path, sheet(cycle=policy))
    spy = Spy(*(np.full(len(LEGS), 0.001 * k) for k in range(200)))
    gait.network = spy  # type: ignore[assignment]
    runner, plan = runner_of(gait, cycle), gait.step(gait.initial(), 0.0, GaitCommand(walk=True))[0]
    targets = [
        runner.update(plan, SupportState("both"), estimate(), standing_frame(seq), cycle)[0]
        for seq in range(round(1.2 / cycle))
    ]
    assert len(spy.seen) == pytest.approx(calls, abs=1)
    assert len(set(targets)) == len(spy.seen)


def test_outputs_count_after_the_declared_delay_within_clip_and_range(tmp_path: Path) -> None:
    table = sheet(
        delay=0.025, clip=[-1.0, 1.0], action=[{"joints": ["LHipRoll", "HeadYaw"], "scale": [0.1, 9.0]}]
    )
    gait = gait_of(tmp_path, table, weights=np.zeros((3, 2)), bias=np.array([5.0, 1.0]))
    runner, plan = runner_of(gait), gait.step(gait.initial(), 0.0, GaitCommand(walk=True))[0]
    angles = [
        runner.update(plan, SupportState("both"), estimate(), standing_frame(seq), CYCLE)[0] for seq in range(6)
    ]
    rest = POSTURES["StandInit"][INDEX["LHipRoll"]]
    assert [a[INDEX["LHipRoll"]] - rest for a in angles] == pytest.approx([0.0] * 3 + [0.1] * 3)
    assert angles[-1][INDEX["HeadYaw"]] == BODY.joints["HeadYaw"].upper


BAD: dict[str, tuple[dict[str, Any], str]] = {
    "term": ({"observation": [{"term": "gravity"}]}, "projected_gravity"),
    "joint": ({"action": [{"joints": ["LKnee"]}]}, "LKneePitch"),
    "key": ({"stifness": 0.5}, "stiffness"),
    "numbers": ({"observation": [{"term": "fused_angle", "scale": [1.0, 1.0, 1.0]}]}, "fused_angle"),
    "inputs": ({"observation": [{"term": "fused_angle"}]}, "2"),
    "outputs": ({"action": [{"joints": ["LKneePitch"]}]}, "11"),
    "twice": ({"action": [{"joints": [*LEGS, "LKneePitch"]}]}, "LKneePitch"),
    "file": ({"model": "other.onnx"}, "other.onnx"),
    "pose": ({"default_pose": {"LKneePitch": 3.0}}, "LKneePitch"),
    "range": ({"command": sheet()["command"] | {"forward": [0.1, 0.2]}}, "forward"),
}


@pytest.mark.parametrize("fault", BAD)
def test_a_fault_of_a_sheet_is_named(tmp_path: Path, fault: str) -> None:
    changes, named = BAD[fault]
    with pytest.raises(ConfigurationError) as error:
        gait_of(tmp_path, sheet(**changes))
    assert named in str(error.value)


def test_what_is_no_network_and_a_missing_runtime_are_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name = write_policy(tmp_path, sheet())
    (tmp_path / "policy.onnx").write_text("no network")
    with pytest.raises(ConfigurationError, match=r"policy\.onnx"):
        make_gait(name, gait_parameters(name), BODY)
    (tmp_path / "policy.onnx").write_text("no network either")
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    with pytest.raises(ConfigurationError, match=r"nao-hil\[onnx\]"):
        make_gait(name, gait_parameters(name), BODY)


@pytest.mark.parametrize(("name", "inputs", "outputs"), [("b-human", 47, 12), ("nao-project", 77, 21)])
def test_sheets_of_others_have_the_sizes_of_their_sources(name: str, inputs: int, outputs: int) -> None:
    """47 and 12: rlWalkingEngine.cfg of B-Human; 77 and 21: nao.py of nao_project."""
    parameters: Any = gait_parameters(f"onnx:{name}")
    assert (parameters.inputs, len(parameters.outputs)) == (inputs, outputs)
    assert gait_file(f"onnx:{name}", "gait.toml").parent == POLICIES


def walk(gait: LearnedGait, seconds: float, *, break_at: float = math.inf) -> tuple[Controller, bool]:
    """A walk in process; from `break_at` on the network gives NaN. Whether the robot fell."""
    order = WalkOrder(duration=seconds)
    controller, guard = Controller(BODY, gait, order, CYCLE), Guard(BODY)
    network = gait.network
    with EmulatedRobot(BODY, seed=3, engine="mujoco", wear=load_wear("nominal")) as robot:
        for _ in range(round((seconds + 12.0) / CYCLE)):
            if controller.state == "walk" and controller._walking.walked > break_at:
                gait.network = Spy(np.full(len(LEGS), math.nan))  # type: ignore[assignment]
                controller.walk.stabilizer._network = gait.network  # type: ignore[union-attr]
            robot.advance(guard.cycle(robot.frame, guard.check(controller.tick(robot.frame), robot.frame.seq)))
            if controller.done:
                break
        gait.network = network
        return controller, robot.truth().fell


def test_a_policy_that_stands_carries_its_order_out(tmp_path: Path) -> None:
    controller, fell = walk(gait_of(tmp_path, sheet(stiffness=0.9)), 2.0)
    assert controller.done and not fell
    assert (controller.state, controller.failure) == ("stand", "")
    assert controller.inference is not None and controller.inference.count == pytest.approx(300, abs=10)


def test_a_network_that_fails_in_the_walk_is_a_failure_of_the_policy(tmp_path: Path) -> None:
    """As an index that the observation makes: onnxruntime raises one of its own exceptions."""

    class Broken:
        def run(self, *_: Any) -> None:
            raise RuntimeError("Gather: index 9 is out of bounds\nmore")

    gait = gait_of(tmp_path, sheet())
    gait.network._session = Broken()
    runner, plan = runner_of(gait), gait.step(gait.initial(), 0.0, GaitCommand(walk=True))[0]
    for seq in range(3):
        angles, _ = runner.update(plan, SupportState("both"), estimate(), standing_frame(seq), CYCLE)
    assert "Gather: index 9" in runner.failure and "\n" not in runner.failure
    assert angles == pytest.approx(gait.default_pose)


def test_the_default_pose_names_the_hip_joint_of_either_leg(tmp_path: Path) -> None:
    """Both are one motor."""
    poses = [
        gait_of(tmp_path, sheet(default_pose={f"{side}HipYawPitch": -0.1})).default_pose for side in ("L", "R")
    ]
    assert poses[0] == poses[1] and poses[0][INDEX["LHipYawPitch"]] == -0.1
    with pytest.raises(ConfigurationError, match="RHipYawPitch"):
        gait_of(tmp_path, sheet(default_pose={"RHipYawPitch": 3.0}))


def test_nan_ends_the_walk_in_a_stand(tmp_path: Path) -> None:
    controller, fell = walk(gait_of(tmp_path, sheet()), 5.0, break_at=1.0)
    assert controller.done and not fell
    assert controller.state == "stand"
    assert "LHipYawPitch" in controller.failure and not controller.fall_cause
    assert controller._walking.walked < 1.1
