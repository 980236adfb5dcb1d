"""Recordings in Foxglove's 3-D panel: its published schemas, and where the ground truth has the robot."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader
from scipy.spatial.transform import Rotation

from bridge.body import load_body
from bridge.body.kinematics import BodyTree
from bridge.messages import Contact, SensorFrame, TruthFrame
from bridge.recording.foxglove import MESSAGE_CYCLES, RobotScene
from bridge.recording.recorder import Recorder
from tests.frames import standing_frame, truth_frame

BODY = load_body("nao-v6")
REQUIRED = {
    "foxglove.FrameTransforms": {"transforms"},
    "foxglove.JointStates": {"timestamp", "joints"},
    "foxglove.SceneUpdate": {"deletions", "entities"},
    "foxglove.RobotDescription": {"url", "format", "data"},
}
"""Schema -> its required fields (foxglove-sdk, schemas/jsonschema)."""
ENTITY = {
    *("timestamp", "frame_id", "id", "lifetime", "frame_locked", "metadata", "arrows", "cubes", "spheres"),
    *("cylinders", "lines", "triangles", "texts", "models"),
}


def truth(frame: SensorFrame, x: float, yaw: float) -> TruthFrame:
    on, turn = Contact(force=(0.0, 0.0, 26.0), cop=None), (0.0, 0.0, math.sin(0.5 * yaw), math.cos(0.5 * yaw))
    place = {"torso_position": (x, 0.1, 0.3), "torso_orientation": turn, "com": (x, 0.1, 0.25)}
    return truth_frame(frame.seq, joints=frame.position, left=on, right=on, **place)


def record(file: Path, *, with_truth: bool = True) -> dict[str, list[dict[str, Any]]]:
    """A robot that slides 1 cm a cycle, with the right foot in the air; the messages by topic."""
    with Recorder(file, {}, lambda: RobotScene(BODY, "<robot/>")) as recorder:
        for seq in range(10 * MESSAGE_CYCLES + 1):
            frame = standing_frame(seq, fsr=(5.0,) * 4 + (0.0,) * 4)
            recorder.write(frame)
            if with_truth:
                recorder.write(truth(frame, 0.01 * seq, 0.5))
    found: dict[str, list[dict[str, Any]]] = {}
    with file.open("rb") as stream:
        for schema, channel, message in make_reader(stream).iter_messages():
            assert schema is not None
            data = json.loads(message.data)
            found.setdefault(channel.topic, []).append(data)
            if schema.name in REQUIRED:
                fields = json.loads(schema.data)
                assert set(fields["properties"]) == REQUIRED[schema.name]
                assert set(data) == REQUIRED[schema.name]
    return found


def test_the_links_are_where_ground_truth_and_kinematics_have_them(tmp_path: Path) -> None:
    sent = record(tmp_path / "frames.mcap")["3d/transforms"]
    assert len(sent) == 10
    frames = {"world": np.eye(4)}
    for one in sent[5]["transforms"]:
        local = np.eye(4)
        local[:3, :3] = Rotation.from_quat([one["rotation"][k] for k in "xyzw"]).as_matrix()
        local[:3, 3] = [one["translation"][k] for k in "xyz"]
        frames[one["child_frame_id"]] = frames[one["parent_frame_id"]] @ local
    assert frames["Torso"][:3, 3] == pytest.approx([0.01 * 5 * MESSAGE_CYCLES, 0.1, 0.3])
    for link, expected in BodyTree(BODY).link_frames(standing_frame().position).items():
        assert frames[link] == pytest.approx(frames["Torso"] @ expected, abs=1e-9), link


def test_a_footstep_lies_under_each_new_place_of_a_loaded_foot(tmp_path: Path) -> None:
    """50 cm in 10 messages: each is a new place; the foot stands from the second message on."""
    updates = record(tmp_path / "frames.mcap")["3d/scene"]
    steps = [entity for update in updates for entity in update["entities"]]
    assert len(steps) == 9
    assert all(set(step) == ENTITY and step["id"].startswith("L") for step in steps)
    assert len({step["id"] for step in steps}) == 9
    cube = steps[0]["cubes"][0]
    size = np.ptp(np.array(BODY.foot.sole), axis=0)
    assert [cube["size"]["x"], cube["size"]["y"]] == pytest.approx(size.tolist())
    xs = [step["cubes"][0]["pose"]["position"]["x"] for step in steps]
    assert np.diff(xs) == pytest.approx([0.01 * MESSAGE_CYCLES] * 8)
