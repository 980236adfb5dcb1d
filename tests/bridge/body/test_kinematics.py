"""Forward kinematics: legs, all links and the centre of mass, against the thesis and other sums."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bridge import rotations
from bridge.body import BODIES, TORSO, joint_tree, load_body
from bridge.body.joints import INDEX, JOINTS, LEG_JOINTS, LEG_SLOTS, N_JOINTS
from bridge.body.kinematics import BodyTree, CentreOfMass, foot_in_torso
from bridge.rotations import rotation
from tests.bridge.body.thesis_leg import leg_chain, leg_steps

SIDES = ("L", "R")
CASES = [(name, 10_000 if name == "nao-v3" else 500) for name in BODIES]


def random_angles(body, side, n, seed):
    joints = [body.joints[name] for name in LEG_JOINTS[side]]
    low, high = [j.lower for j in joints], [j.upper for j in joints]
    return np.random.default_rng(seed).uniform(low, high, (n, 6))


def product_of_exponentials(body, side, angles):
    """Poses of the six links, shape (6, n, 4, 4), from screw axes through zero-pose points in the Torso."""
    sign, length = (1.0 if side == "L" else -1.0), body.lengths
    hip = np.array([0.0, sign * length.HipOffsetY, -length.HipOffsetZ])
    knee = hip - [0.0, 0.0, length.ThighLength]
    ankle = knee - [0.0, 0.0, length.TibiaLength]
    roll, pitch, slanted = [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, -sign]
    screws = [(slanted, hip), (roll, hip), (pitch, hip), (pitch, knee), (pitch, ankle), (roll, ankle)]
    total = np.broadcast_to(np.eye(4), (len(angles), 4, 4))
    links = []
    for (axis, point), q in zip(screws, angles.T, strict=True):
        unit = np.array(axis) / np.linalg.norm(axis)
        x, y, z = unit
        hat = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
        s, c = np.sin(q)[:, None, None], np.cos(q)[:, None, None]
        screw = np.zeros((len(q), 4, 4))
        screw[:, :3, :3] = np.eye(3) + s * hat + (1.0 - c) * (hat @ hat)
        screw[:, :3, 3] = point - screw[:, :3, :3] @ point
        screw[:, 3, 3] = 1.0
        total = total @ screw
        zero_pose = np.eye(4)
        zero_pose[:3, 3] = point
        links.append(total @ zero_pose)
    return np.array(links)


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize(("name", "n"), CASES)
def test_chain_is_the_product_of_exponentials(name, n, side):
    body = load_body(name)
    angles = random_angles(body, side, n, seed=1)
    expected = product_of_exponentials(body, side, angles)
    for i, q in enumerate(angles.tolist()):
        chain = leg_chain(body, side, q)
        got = np.array([chain[frame] for frame in (3, 4, 5, 6, 7, 8)])
        assert np.abs(got - expected[:, i]).max() < 1e-12


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize(("name", "n"), CASES)
def test_foot_multiplied_out_is_the_product_of_exponentials(name, n, side):
    body = load_body(name)
    angles = random_angles(body, side, n, seed=2)
    expected = product_of_exponentials(body, side, angles)[5]
    got = np.array([foot_in_torso(body, side, q) for q in angles.tolist()])
    assert np.abs(got - expected).max() < 1e-12


def test_hip_rotation_is_the_printed_matrix():
    # (2.22), right leg, written out with psi_k = -45 degrees.
    c, s = math.cos(-math.pi / 4), math.sin(-math.pi / 4)
    for phi in (-1.1, -0.3, 0.0, 0.7):
        cp, sp = math.cos(phi), math.sin(phi)
        printed = np.array(
            [
                [cp, -c * sp, -s * sp],
                [c * sp, c * c * cp + s * s, c * cp * s - s * c],
                [s * sp, s * cp * c - c * s, s * s * cp + c * c],
            ]
        )
        steps = leg_steps(load_body("nao-v3"), "R", [phi, 0.0, 0.0, 0.0, 0.0, 0.0])
        assert (steps[1] @ steps[2] @ steps[3])[:3, :3] == pytest.approx(printed, abs=1e-15)


def test_left_leg_swaps_the_slants_of_the_right():
    # Text after (2.12): H_L0^L1 = H_R2^R3, H_L2^L3 = H_R0^R1, H_L1^L2(phi) = H_R1^R2(-phi).
    body, phi = load_body("nao-v3"), 0.4
    left = leg_steps(body, "L", [phi, 0.0, 0.0, 0.0, 0.0, 0.0])
    right = leg_steps(body, "R", [-phi, 0.0, 0.0, 0.0, 0.0, 0.0])
    for of_left, of_right in ((1, 3), (2, 2), (3, 1)):
        assert np.array_equal(left[of_left], right[of_right])


def test_rotation_order_is_roll_then_pitch_then_yaw():
    # (2.4): roll first, about fixed axes; scipy's lower-case letters are the fixed axes.
    for roll, pitch, yaw in np.random.default_rng(4).uniform(-3.0, 3.0, (50, 3)):
        expected = Rotation.from_euler("xyz", [roll, pitch, yaw]).as_matrix()
        assert rotation(roll, pitch, yaw) == pytest.approx(expected, abs=1e-14)


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


TURNS = Rotation.random(200, random_state=1)


def test_matrices_and_angles_of_quaternions() -> None:
    q = TURNS.as_quat()
    np.testing.assert_allclose(rotations.matrix(q), TURNS.as_matrix(), atol=1e-12)
    angles = np.column_stack([rotations.yaw(q), rotations.pitch(q), rotations.roll(q)])
    np.testing.assert_allclose(angles, TURNS.as_euler("ZYX"), atol=1e-9)
    np.testing.assert_allclose(np.cos(rotations.tilt(q)), TURNS.as_matrix()[:, 2, 2], atol=1e-12)
