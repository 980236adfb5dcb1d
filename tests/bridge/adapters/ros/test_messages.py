"""ROS messages of a robot: against the walker's kinematics, scipy's rotations and rosbags' reader."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

from bridge.adapters.ros.messages import MESSAGE_CYCLES, RosMessages, write_bag
from bridge.body import load_body
from bridge.body.joints import INDEX
from bridge.body.kinematics import BodyTree
from bridge.errors import ConfigurationError
from bridge.messages import SensorFrame, WalkTelemetry
from bridge.recording.recorder import Recorder
from bridge.rotations import matrix
from tests.frames import standing_frame

BODY = load_body("nao-v6")
STORE = get_typestore(Stores.ROS2_JAZZY)
BENT = tuple(np.random.default_rng(45).uniform(-0.3, 0.3, 25).tolist())
TELEMETRY = WalkTelemetry(
    seq=0, state="walk", phase="DSL", step=1, steps=0, place=(1.0, 2.0, 0.5), zmp=(0.0, 0.0), com=(0.0, 0.0),
    left=(0.0,) * 6, right=(0.0,) * 6,
)  # fmt: skip


def messages(*frames: SensorFrame) -> dict[str, Any]:
    """The last message of each topic."""
    made = RosMessages(BODY, STORE)
    made.telemetry(TELEMETRY)
    return {one.topic: one.message for frame in frames for one in made.of_frame(frame, 1_500_000_000)}


def placed(transforms: Any) -> dict[str, np.ndarray[Any, Any]]:
    """Each frame in the root's, shape (4, 4)."""
    found: dict[str, np.ndarray[Any, Any]] = {"odom": np.eye(4)}
    for one in transforms:
        local = np.eye(4)
        turn, way = one.transform.rotation, one.transform.translation
        local[:3, :3] = matrix([turn.x, turn.y, turn.z, turn.w])
        local[:3, 3] = way.x, way.y, way.z
        found[one.child_frame_id] = found[one.header.frame_id] @ local
    return found


def test_transforms_put_each_link_where_the_kinematics_have_it() -> None:
    frames = placed(messages(standing_frame(position=BENT, angle=(0.1, -0.2)))["tf"].transforms)
    torso = np.linalg.inv(frames["Torso"])
    for link, expected in BodyTree(BODY).link_frames(BENT).items():
        assert torso @ frames[link] == pytest.approx(expected, abs=1e-9), link


def test_a_camera_looks_along_z_of_its_optical_frame() -> None:
    frames = placed(messages(standing_frame(position=(0.0,) * 25))["tf"].transforms)
    axis = (np.linalg.inv(frames["Torso"]) @ frames["CameraBottom_optical_frame"])[:3, 2]
    assert axis == pytest.approx([math.cos(0.6929), 0.0, -math.sin(0.6929)])


def test_orientation_and_vectors_of_the_inertial_unit() -> None:
    imu = messages(standing_frame(angle=(0.3, -0.2), gyroscope=(0.1, 0.2, 0.3)))["imu"]
    turn = imu.orientation
    expected = Rotation.from_euler("ZYX", [0.0, -0.2, 0.3]).as_quat()
    assert [turn.x, turn.y, turn.z, turn.w] == pytest.approx(expected.tolist())
    assert [imu.angular_velocity.x, imu.angular_velocity.y, imu.angular_velocity.z] == [0.1, 0.2, 0.3]
    assert imu.linear_acceleration.z == pytest.approx(9.81)


def test_joint_states_have_both_hips_and_speeds() -> None:
    moved = list(standing_frame().position)
    moved[INDEX["HeadYaw"]] += 0.02
    states = messages(standing_frame(0), standing_frame(1, position=tuple(moved)))["joint_states"]
    assert states.velocity[states.name.index("HeadYaw")] == pytest.approx(2.0)
    hips = [states.position[states.name.index(f"{side}HipYawPitch")] for side in "LR"]
    assert hips[0] == hips[1]
    assert (states.header.stamp.sec, states.header.stamp.nanosec) == (1, 500_000_000)


def test_a_recording_becomes_a_bag_that_rosbags_reads(tmp_path: Path) -> None:
    with Recorder(tmp_path / "frames.mcap", {}) as recorder:
        recorder.write(TELEMETRY)
        for seq in range(100):
            recorder.write(standing_frame(seq))
    counts = write_bag(tmp_path / "frames.mcap", tmp_path / "bag", BODY, "<robot/>")
    with Reader(tmp_path / "bag") as bag:
        read = {c.topic.strip("/"): c.msgcount for c in bag.connections}
        # a node that subscribes after the first message gets the description too, as from robot_state_publisher
        latched = {c.topic for c in bag.connections if c.ext.offered_qos_profiles[0].durability.value == 1}
        states = [
            (time, STORE.deserialize_cdr(data, c.msgtype))
            for c, time, data in bag.messages()
            if c.topic == "/joint_states"
        ]
    assert read == counts
    assert latched == {"/robot_description"}
    assert counts == {"robot_description": 1} | {topic: 100 // every for topic, every in MESSAGE_CYCLES.items()}
    assert states[50][0] == 500_000_000
    assert states[50][1].position[0] == standing_frame().position[0]
    with pytest.raises(ConfigurationError, match="give a new folder"):
        write_bag(tmp_path / "frames.mcap", tmp_path / "bag", BODY, "<robot/>")
