"""Joint compliance compensation: torques by virtual work, the rest against a robot of springs."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest
from scipy.optimize import root

from bridge.body import Body, load_body
from bridge.body.joints import INDEX, LEG_SLOTS, N_JOINTS
from bridge.body.kinematics import CentreOfMass, foot_in_torso
from bridge.body.quantities import GRAVITY
from emulator.scenarios import Scenario
from nao_hil.runs.build import build_robot
from nao_hil.runs.config import RunConfig
from walker.gaits import gait_parameters, make_gait, standing_plan
from walker.gaits.pose import PoseMaker
from walker.mechanisms.compliance import JointCompliance, JointComplianceParameters

CYCLE = 0.01


@pytest.fixture(scope="module", params=["nao-v3", "nao-v6"])
def body(request: pytest.FixtureRequest) -> Body:
    return load_body(request.param)


def compensation(body: Body, **changes: float) -> JointCompliance:
    return JointCompliance(JointComplianceParameters(ramp_time=CYCLE, **changes), body, CYCLE, 0.04)  # type: ignore[arg-type]


def balanced(body: Body, com: CentreOfMass) -> list[float]:
    """Joint angles at which the centre of mass is over the left foot's middle, the torso upright."""
    angles = [0.0] * N_JOINTS
    for joint, value in (
        ("LHipRoll", -0.2),
        ("LHipPitch", -0.4),
        ("LKneePitch", 0.8),
        ("LAnklePitch", -0.35),
        ("LAnkleRoll", 0.15),
        ("LHipYawPitch", -0.1),
        ("RHipPitch", -0.6),
        ("RKneePitch", 1.2),
        ("RHipRoll", 0.1),
        ("LShoulderPitch", 1.4),
        ("RShoulderPitch", 1.5),
    ):
        angles[INDEX[joint]] = value

    def off(x: np.ndarray) -> np.ndarray:
        angles[INDEX["LHipRoll"]], angles[INDEX["LHipPitch"]] = x
        foot = foot_in_torso(body, "L", [angles[i] for i in LEG_SLOTS["L"]])
        middle = foot[:3, :3] @ [*body.foot.centre, -body.lengths.FootHeight] + foot[:3, 3]
        return np.asarray(com(angles)[:2] - middle[:2])

    found = root(off, [-0.2, -0.4], tol=1e-13)
    assert found.success
    off(found.x)
    return angles


def test_the_command_that_holds_a_standing_robot_is_found_from_its_sensors(body: Body) -> None:
    """The emulated robot knows what it was asked for; its encoders show what came of that."""
    config = RunConfig(robot=body.name, engine="mujoco", mode="in-process")
    with build_robot(config, Scenario()) as robot:
        frame, asked = robot.frame, np.array(robot.posture)
    pitch = [INDEX[f"{side}{joint}Pitch"] for side in "LR" for joint in ("Hip", "Knee", "Ankle")]
    held = compensation(body).holding(frame)
    off_measured, off_held = (np.abs(np.subtract(q, asked)[pitch]).max() for q in (frame.position, held))
    assert off_measured > np.radians(0.5)
    assert off_held < 0.5 * off_measured
    lying = msgspec.structs.replace(frame, fsr=(0.0,) * 8)
    assert compensation(body).holding(lying) == frame.position


def test_torques_of_the_stance_leg_are_the_gradient_of_the_potential_energy(body: Body) -> None:
    """Virtual work: the foot held, a joint's torque is what lifts the mass per angle."""
    com = CentreOfMass(body)
    angles = balanced(body, com)

    def foot(q: list[float]) -> np.ndarray:
        return foot_in_torso(body, "L", [q[i] for i in LEG_SLOTS["L"]])

    up = foot(angles)[:3, :3].T @ [0.0, 0.0, 1.0]  # in the held foot

    def energy(q: list[float]) -> float:
        pose = foot(q)
        return float(com.mass * GRAVITY * up @ (pose[:3, :3].T @ (com(q) - pose[:3, 3])))

    torques = compensation(body).torques(angles, left_fraction=1.0)
    for i, slot in enumerate(LEG_SLOTS["L"]):
        if i == 0:
            continue  # its motor turns the other leg as well: tested as the sum below
        lifted, lowered = list(angles), list(angles)
        lifted[slot] += 1e-5
        lowered[slot] -= 1e-5
        assert torques[0, i] == pytest.approx((energy(lifted) - energy(lowered)) / 2e-5, abs=1e-6)
    slot = LEG_SLOTS["L"][0]
    lifted, lowered = list(angles), list(angles)
    lifted[slot] += 1e-5
    lowered[slot] -= 1e-5
    assert torques[:, 0].sum() == pytest.approx((energy(lifted) - energy(lowered)) / 2e-5, abs=1e-6)


def test_a_robot_of_springs_stands_as_planned(body: Body) -> None:
    """Joints that give way as modelled end where the plan wants them; the ranges do not bind here."""
    gait = make_gait("static", gait_parameters("static"), body)
    reference = standing_plan(gait)
    planned = list(PoseMaker(body, reference, by_pose=True).angles(reference))
    spring = compensation(body)
    asked = list(planned)
    spring.compensate(asked, reference)
    torques = spring.torques(planned, 0.5)
    torques[:, 0] = torques[:, 0].sum()
    p = JointComplianceParameters()
    give = p.coefficient * torques + p.half_backlash * np.tanh(torques / p.backlash_torque)
    for side, row in zip("LR", give, strict=True):
        for i, slot in enumerate(LEG_SLOTS[side]):  # type: ignore[index]
            assert asked[slot] - row[i] == pytest.approx(planned[slot], abs=1e-12)


@pytest.mark.parametrize("true_ratio", [0.0, 0.5, 1.0, 1.8])
def test_the_ratio_is_learned_from_the_encoders(body: Body, true_ratio: float) -> None:
    """Encoders that lag the commands by the drives' sag, half or nearly twice as soft: learned in 30 s."""
    reference = standing_plan(make_gait("static", gait_parameters("static"), body))
    planned = list(PoseMaker(body, reference, by_pose=True).angles(reference))
    spring = compensation(body)
    measured = list(planned)
    for _ in range(3000):
        spring.adapt(measured, CYCLE)
        asked = list(planned)
        spring.compensate(asked, reference)
        spring.sent(asked)
        torques = spring.torques(planned, 0.5)
        torques[:, 0] = torques[:, 0].sum()
        p = JointComplianceParameters()
        give = true_ratio * (p.coefficient * torques + p.half_backlash * np.tanh(torques / p.backlash_torque))
        measured = list(asked)
        for side, row in zip("LR", give, strict=True):
            for i, slot in enumerate(LEG_SLOTS[side]):  # type: ignore[index]
                measured[slot] = asked[slot] - row[i]
    # The joints that bear something while standing; what bears nothing tells nothing.
    loaded = np.abs(spring.torques(planned, 0.5)).max(axis=0) > 0.25
    assert loaded.any()
    assert spring.ratio[loaded] == pytest.approx(true_ratio, abs=0.3)
