"""Forward kinematics of all links and the centre of mass, against the thesis' chain and against other sums."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bridge.body import BODIES, TORSO, joint_tree, load_body
from bridge.body.joints import INDEX, JOINTS, LEG_SLOTS, N_JOINTS
from tests.walker.thesis_leg import leg_chain
from walker.model.com import CentreOfMass
from walker.model.tree import BodyTree

LEG_FRAMES = {3: "HipYawPitch", 4: "HipRoll", 5: "HipPitch", 6: "KneePitch", 7: "AnklePitch", 8: "AnkleRoll"}


def random_positions(body, n, seed):
    low = [body.joints[j].lower if j in body.joints else 0.0 for j in JOINTS]
    high = [body.joints[j].upper if j in body.joints else 0.0 for j in JOINTS]
    return np.random.default_rng(seed).uniform(low, high, (n, N_JOINTS))


def recursive_frame(tree, name, position):
    """Rotation and origin of one link in the Torso frame, joint by joint with scipy's rotations."""
    if name == TORSO:
        return Rotation.identity(), np.zeros(3)
    joint = tree[name]
    parent, origin = recursive_frame(tree, joint.parent, position)
    angle = position[INDEX["LHipYawPitch" if name == "RHipYawPitch" else name]]
    turned = parent * Rotation.from_rotvec(angle * np.array(joint.axis))
    return turned, origin + parent.apply(joint.offset)


@pytest.mark.parametrize("name", BODIES)
def test_legs_of_the_tree_are_the_chain(name):
    body = load_body(name)
    tree = BodyTree(body)
    for position in random_positions(body, 200, seed=21):
        frames = tree.link_frames(position)
        for side in ("L", "R"):
            chain = leg_chain(body, side, position[list(LEG_SLOTS[side])].tolist())
            for frame, joint in LEG_FRAMES.items():
                assert frames[side + joint] == pytest.approx(chain[frame], abs=1e-14)


@pytest.mark.parametrize("name", BODIES)
def test_all_links_are_where_the_joints_put_them(name):
    body = load_body(name)
    joints = joint_tree(body)
    tree = BodyTree(body)
    for position in random_positions(body, 20, seed=22):
        frames = tree.link_frames(position)
        assert set(frames) == {TORSO, *joints}
        for link in frames:
            turned, origin = recursive_frame(joints, link, position)
            assert frames[link][:3, :3] == pytest.approx(turned.as_matrix(), abs=1e-14)
            assert frames[link][:3, 3] == pytest.approx(origin, abs=1e-14)


def test_arms_hang_down_when_the_shoulders_pitch():
    # Closed form: ShoulderPitch 90 degrees turns the arm (upper arm, then lower arm to the wrist) to -z.
    body = load_body("nao-v6")
    position = [0.0] * N_JOINTS
    position[INDEX["LShoulderPitch"]] = position[INDEX["RShoulderPitch"]] = math.pi / 2
    frames, length = BodyTree(body).link_frames(position), body.lengths
    for side, sign in (("L", 1.0), ("R", -1.0)):
        hand_down = length.ShoulderOffsetZ - length.UpperArmLength - length.LowerArmLength
        wrist = [0.0, sign * (length.ShoulderOffsetY + length.ElbowOffsetY), hand_down]
        assert frames[f"{side}WristYaw"][:3, 3] == pytest.approx(wrist, abs=1e-15)


def test_slots_of_joints_that_a_body_lacks_are_not_read():
    body = load_body("nao-v3")
    position = random_positions(body, 1, seed=23)[0]
    spoilt = position.copy()
    for joint in ("LWristYaw", "RWristYaw", "LHand", "RHand"):
        spoilt[INDEX[joint]] = math.nan
    assert np.array_equal(BodyTree(body).frames(position), BodyTree(body).frames(spoilt))


# Zero pose, Torso frame: the fact sheet's totals, computed there from the vendor's tables.
ZERO_POSE = {
    "nao-v3.2": (0.01529, 0.0, -0.05042),
    "nao-v3.3": (0.02020, 0.0, -0.04314),
    "nao-v4": (0.02158, 0.0, -0.03478),
    "nao-v5": (0.02118, 0.0, -0.03555),
    "nao-v6": (0.02122, 0.00018, -0.03281),
}


@pytest.mark.parametrize("name", ZERO_POSE)
def test_com_of_the_zero_pose_is_the_published_one(name):
    com = CentreOfMass(load_body(name))([0.0] * N_JOINTS)
    assert com == pytest.approx(ZERO_POSE[name], abs=0.6e-5)


@pytest.mark.parametrize("name", BODIES)
def test_com_is_the_weighted_sum_of_the_bodies(name):
    body = load_body(name)
    joints, com = joint_tree(body), CentreOfMass(body)
    for position in random_positions(body, 20, seed=24):
        moment, mass = np.zeros(3), 0.0
        for link, sheet in body.links.items():
            turned, origin = recursive_frame(joints, link, position)
            moment += sheet.mass * (origin + turned.apply(sheet.com))
            mass += sheet.mass
        assert com.mass == pytest.approx(mass, rel=1e-14)
        assert com(position) == pytest.approx(moment / mass, abs=1e-14)


def test_com_of_moved_frames_moves_along():
    body = load_body("nao-v3")
    com = CentreOfMass(body)
    position = random_positions(body, 1, seed=25)[0]
    torso_in_world = np.eye(4)
    torso_in_world[:3, :3] = Rotation.from_euler("xyz", [0.1, -0.2, 0.7]).as_matrix()
    torso_in_world[:3, 3] = [1.0, 2.0, 0.3]
    moved = com.of_frames(torso_in_world @ com.tree.frames(position))
    assert moved == pytest.approx((torso_in_world @ [*com(position), 1.0])[:3], abs=1e-14)
