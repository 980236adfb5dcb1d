"""Key-frame motions: the format, the way between frames, mirrors and gates."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import pytest

from bridge.body import load_body
from bridge.body.joints import INDEX, JOINTS, N_JOINTS
from bridge.body.postures import POSTURES
from bridge.errors import ConfigurationError
from bridge.messages import SensorFrame
from bridge.motion import GetUp, Motion, MotionPlayer, get_up_motions, load_motion, lying, motion_names
from bridge.motion.keyframes import Frame, Gate, Phase, targets
from tests.frames import standing_frame

BODY = load_body("nao-v6")
DT = 0.01


def motion(*phases: Phase) -> Motion:
    return Motion(title="", source="", phases=phases)


def frame(angle: tuple[float, float] = (0.0, 0.0)) -> SensorFrame:
    return standing_frame(position=(0.0,) * N_JOINTS, angle=angle)


@pytest.mark.parametrize(
    ("roll", "pitch", "below"),
    [
        (0.0, 0.2, "upright"),
        (0.0, -math.pi / 2, "back"),
        (3.0, -1.5, "back"),  # roll means nothing at a pitch of 90 degrees
        (0.0, math.pi / 2, "front"),
        (-math.pi / 2, 0.0, "left"),  # Rx(-90 deg) turns the left arm down
        (math.pi / 2, 0.0, "right"),
    ],
)
def test_what_is_below(roll: float, pitch: float, below: str) -> None:
    assert lying((roll, pitch)) == below


def test_straight_lines_in_their_time() -> None:
    first = Frame(duration=0.2, joints={"HeadYaw": 0.2}, stiffness=0.5)
    player = MotionPlayer(motion(Phase(frames=(first, Frame(duration=0.4, joints={"HeadYaw": -0.2})))), BODY)
    at = INDEX["HeadYaw"]
    ways = [player.advance(frame(), DT)[at] for _ in range(61)]
    assert ways[0] == 0.0  # from where the joints are
    assert ways[10] == pytest.approx(0.1)  # half of the way to 0.2
    assert ways[40] == pytest.approx(0.0, abs=1e-9)  # half of the way from 0.2 to -0.2
    assert ways[60] == pytest.approx(-0.2)
    assert player.stiffness == 0.5


def test_the_first_frame_is_approached_no_faster_than_allowed() -> None:
    player = MotionPlayer(motion(Phase(frames=(Frame(duration=0.0, joints={"LShoulderPitch": 1.5708}),))), BODY)
    ways = [player.advance(frame(), DT)[INDEX["LShoulderPitch"]] for _ in range(150)]
    assert max(b - a for a, b in itertools.pairwise(ways)) == pytest.approx(1.5708 * DT)
    assert player.done


@pytest.mark.parametrize("present", [None, tuple(0.01 * i for i in range(N_JOINTS))])
def test_joints_that_no_frame_has_named_stay_at_the_present_targets(
    present: tuple[float, ...] | None,
) -> None:
    """Else at the measured angles."""
    frames = Frame(duration=0.1, joints={"HeadYaw": 0.2}), Frame(duration=0.1, joints={"HeadPitch": 0.1})
    player = MotionPlayer(motion(Phase(frames=frames)), BODY, present)
    measured = standing_frame(position=(0.05,) * N_JOINTS)
    ways = [player.advance(measured, DT) for _ in range(60)]
    for joint, slot in INDEX.items():
        stays = present[slot] if present else 0.05
        goal = {"HeadYaw": 0.2, "HeadPitch": 0.1}.get(joint, stays)
        assert ways[-1][slot] == pytest.approx(goal), joint


def test_a_mirrored_phase_is_the_mirror_image() -> None:
    angles = {
        "HeadYaw": 0.3,
        "HeadPitch": 0.2,
        "LShoulderPitch": 1.0,
        "RShoulderRoll": -0.4,
        "LHipYawPitch": -0.5,
    }
    (target,) = targets(motion(Phase(frames=(Frame(duration=1.0, joints=angles),), mirrored=True)), BODY)
    found = {JOINTS[slot]: angle for slot, angle in target.position.items()}
    # a mirror at the plane y = 0 turns rotations about x and z round, and leaves those about y
    assert found == {
        "HeadYaw": -0.3,
        "HeadPitch": 0.2,
        "RShoulderPitch": 1.0,
        "LShoulderRoll": 0.4,
        "LHipYawPitch": -0.5,
    }


def test_a_gate_waits_and_then_fails() -> None:
    gate = Gate(pitch=(-0.2, 0.2), wait=0.1)
    phases = Phase(frames=(Frame(duration=0.1),), gate=gate), Phase(frames=(Frame(duration=0.1),))
    shut = MotionPlayer(motion(*phases), BODY)
    for _ in range(15):
        shut.advance(frame((0.0, 1.0)), DT)
    assert not shut.done
    for _ in range(10):
        shut.advance(frame((0.0, 1.0)), DT)
    assert shut.done and shut.failed
    opened = MotionPlayer(motion(*phases), BODY)
    for k in range(70):
        opened.advance(frame((0.0, 1.0 if k < 15 else 0.0)), DT)
    assert opened.done and not opened.failed


def test_getting_up_waits_for_rest_plays_what_fits_and_tries_again() -> None:
    nod = motion(Phase(frames=(Frame(duration=0.1, joints={"HeadYaw": 0.2}),)))
    player = GetUp({"back": nod, "front": nod}, BODY, tries=2)
    back, front = (frame((0.0, pitch)) for pitch in (-1.5, 1.5))
    seat = standing_frame(position=POSTURES["SitRelax"])
    turning = standing_frame(position=(0.0,) * N_JOINTS, angle=back.angle, gyroscope=(0.0, 1.0, 0.0))
    for _ in range(100):
        player.advance(turning, DT)
    assert not player.began  # it still rolls
    for _ in range(45):
        player.advance(back, DT)
    assert player.began == ["back"]
    for _ in range(20):
        player.advance(front, DT)
    assert player.began == ["back", "front"] and not player.done
    for _ in range(60):
        player.advance(seat, DT)  # the torso is upright, and the feet are ahead of it
    assert player.done and player.failed and len(player.began) == 2


def test_a_try_begins_when_the_robot_obeys_and_ends_when_it_is_released() -> None:
    """As under a guard that takes no command after a fall."""
    nod = motion(Phase(frames=(Frame(duration=0.5, joints={"HeadYaw": 0.2}),)))
    player = GetUp({"back": nod}, BODY)
    lies = {"position": (0.0,) * N_JOINTS, "angle": (0.0, -1.5)}
    released = standing_frame(stiffness=(0.1,) * N_JOINTS, **lies)
    asked = [player.advance(released, DT)[INDEX["HeadYaw"]] for _ in range(150)]
    assert not player.began and not any(asked) and player.stiffness > 0.2
    asked = [player.advance(standing_frame(**lies), DT)[INDEX["HeadYaw"]] for _ in range(26)]
    assert asked[25] == pytest.approx(0.1)  # half of the way in half of the time
    for _ in range(20):
        player.advance(released, DT)
    player.advance(standing_frame(**lies), DT)
    assert player.began == ["back", "back"]


@pytest.mark.parametrize("body", ["nao-v3", "nao-v3.3", "nao-v4", "nao-v5", "nao-v6"])
def test_every_way_to_lie_has_a_motion(body: str) -> None:
    motions = get_up_motions(load_body(body))
    assert sorted(motions) == ["back", "front", "left", "right", "upright"]
    left, right = (targets(motions[side], load_body(body))[0].position for side in ("left", "right"))
    assert [left[INDEX[j]] for j in ("LShoulderRoll", "LHipPitch")] == [
        sign * right[INDEX[j]] for j, sign in (("RShoulderRoll", -1.0), ("RHipPitch", 1.0))
    ]


@pytest.mark.parametrize("name", motion_names())
def test_shipped_motions_load_and_name_their_licence(name: str) -> None:
    found = load_motion(name)
    assert "Apache License 2.0" in found.source or found.source.startswith("this project")
    assert targets(found, load_body("nao-v3")) and targets(found, BODY)


@pytest.mark.parametrize("written", ["{}", "\ufeff{}", "# made by hand\n\n{}\n", "windows"])
def test_a_table_as_spreadsheets_and_people_write_it_is_read(tmp_path: Path, written: str) -> None:
    file = tmp_path / "nod.csv"
    text = "duration_s, stiffness, HeadYaw \n1.0, 1.0, 0.2\n 1.0,,"
    text = text.replace("\n", "\r\n") if written == "windows" else written.format(text)
    file.write_bytes(text.encode())
    first, second = load_motion(str(file)).phases[0].frames
    assert (first.joints, first.stiffness) == ({"HeadYaw": 0.2}, 1.0)
    assert (second.joints, second.stiffness) == ({}, None)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("duration_s,stiffness,HeadYaww\n1,1,0\n", "HeadYaw"),
        ("duration_s,HeadYaw\n1,0\n", "no column stiffness"),
        ("duration_s;stiffness\n1;1\n", "separated by commas"),
        ("duration_s,stiffness\n1,1,5\n", "line 2: has 3 cells"),
        ("duration_s,stiffness\nsoon,1\n", "wrong.csv, line 2, column duration_s: 'soon' is no number"),
        ("duration_s,stiffness\n,1\n", "line 2, column duration_s: '' is no number"),
        ("duration_s,stiffness\n1,1\n-1,1\n", "line 3, column duration_s: expected a number >= 0"),
        ("duration_s,stiffness\n1,1.5\n", "line 2, column stiffness: expected a number <= 1"),
        ("duration_s,stiffness,HeadYaw,HeadYaw\n1,1,0,1\n", "HeadYaw is there twice"),
        ("duration_s,stiffness,HeadYaw\n1,1,20\n", "HeadYaw.*degrees"),
        ("", "duration_s"),
        (
            "duration_s,stiffness,HeadYaw\n1.0,0.5,nan\n",
            "line 2, column HeadYaw: is nan, but must be a finite number",
        ),
        ("duration_s,stiffness\n", "no key frames"),
    ],
)
def test_a_wrong_table_is_refused_by_name(tmp_path: Path, text: str, says: str) -> None:
    file = tmp_path / "wrong.csv"
    file.write_text(text)
    with pytest.raises(ConfigurationError, match=says):
        load_motion(str(file))


HEAD = 'title = "a"\nsource = "b"\n'
KNEE = "[[phases]]\n[[phases.frames]]\nduration = 1.0\n[phases.frames.joints]\nLKnee = 1.0\n"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (HEAD + KNEE, "LKnee"),
        (HEAD + KNEE.replace("LKnee = 1.0", "LKneePitch = 120.0"), "LKneePitch.*degrees"),
        (HEAD + "phases = []\n", "no key frames"),
        (HEAD + "phases = []\nbegin = 1\n", "begin"),
        (HEAD + "phases = []\nbegins = []\n", "begins"),
        (HEAD + "[[phases]]\nframes = []\ngate = {pitch = [1.0, -1.0]}\n", "gate.pitch"),
    ],
)
def test_a_wrong_file_is_refused_by_name(tmp_path: Path, text: str, says: str) -> None:
    file = tmp_path / "wrong.toml"
    file.write_text(text)
    with pytest.raises(ConfigurationError, match=says):
        load_motion(str(file))
    with pytest.raises(ConfigurationError, match="get-up-back"):
        load_motion("get-up-bak")
