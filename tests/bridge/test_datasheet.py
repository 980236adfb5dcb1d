"""Data sheets against the published tables (values in the tests are typed from the sources)."""

from __future__ import annotations

import math
import re
from pathlib import Path

import msgspec
import numpy as np
import pytest

from bridge.adapters.naoqi.core.robot_facts import RobotConfig
from bridge.body import BODIES, TORSO, Body, body_of, joint_tree, load, load_body
from bridge.body.cameras import cameras
from bridge.body.load import check_body, is_possible_inertia
from bridge.errors import ConfigurationError
from bridge.host import robot_info
from bridge.messages import Info, decode, encode
from bridge.motion import get_up_motions
from bridge.recording.foxglove import RobotScene
from bridge.recording.playback import recorded_body
from bridge.recording.recorder import Recorder

V3X = ("nao-v3", "nao-v3.2", "nao-v3.3")
DUMMY_LINKS = 1e-4
"""The URDF totals count some 25 massless sensor links of 2e-6 kg each; the sheets leave them out."""


def _zero_pose_com(body: Body) -> np.ndarray:
    origin = {TORSO: np.zeros(3)}
    for joint, place in joint_tree(body).items():
        origin[joint] = origin[place.parent] + place.offset
    mass = sum(link.mass for link in body.links.values())
    return sum(link.mass * (origin[name] + link.com) for name, link in body.links.items()) / mass


@pytest.mark.parametrize(
    ("name", "mass"),
    [
        ("nao-v3", 4.70299),
        ("nao-v3.2", 4.836142),
        ("nao-v3.3", 5.005962),
        ("nao-v4", 5.195402),
        ("nao-v5", 5.305402),
        ("nao-v6", 5.35975),
    ],
)
def test_total_mass(name: str, mass: float) -> None:
    total = sum(link.mass for link in load_body(name).links.values())
    assert mass - DUMMY_LINKS < total <= mass + 1e-9


@pytest.mark.parametrize(
    ("name", "com"),
    [
        ("nao-v3.2", (0.01529, 0.0, -0.05042)),
        ("nao-v3.3", (0.02020, 0.0, -0.04314)),
        ("nao-v4", (0.02158, 0.0, -0.03478)),
        ("nao-v5", (0.02118, 0.0, -0.03555)),
        ("nao-v6", (0.02122, 0.00018, -0.03281)),
    ],
)
def test_zero_pose_centre_of_mass(name: str, com: tuple[float, float, float]) -> None:
    np.testing.assert_allclose(_zero_pose_com(load_body(name)), com, atol=1e-5)


@pytest.mark.parametrize(
    ("name", "millimetres"), [("nao-v4", 333.09), ("nao-v3.2", 333.01), ("nao-v3", 332.85)]
)
def test_sole_to_torso_height(name: str, millimetres: float) -> None:
    length = load_body(name).lengths
    height = length.HipOffsetZ + length.ThighLength + length.TibiaLength + length.FootHeight
    assert height * 1000 == pytest.approx(millimetres, abs=1e-9)


def test_lengths_of_the_thesis() -> None:
    """Table 1.1."""
    length = load_body("nao-v3").lengths
    printed = {
        "ShoulderOffsetY": 98.00,
        "ShoulderOffsetZ": 100.00,
        "NeckOffsetZ": 126.50,
        "HipOffsetY": 50.00,
        "HipOffsetZ": 85.00,
        "ThighLength": 100.00,
        "TibiaLength": 102.74,
        "FootHeight": 45.11,
        "UpperArmLength": 90.00,
        "LowerArmLength": 50.55,
    }
    for name, millimetres in printed.items():
        assert getattr(length, name) * 1000 == pytest.approx(millimetres, abs=1e-9), name


def test_leg_limits_of_the_thesis() -> None:
    """Table 1.2; its AnkleRoll is in the opposite sign of every other source (see the sheet's repairs)."""
    printed = {
        "LHipYawPitch": (-65.62, 42.44),
        "LHipRoll": (-21.74, 45.29),
        "LHipPitch": (-101.63, 27.73),
        "LKneePitch": (-5.29, 121.04),
        "LAnklePitch": (-68.15, 52.86),
        "LAnkleRoll": (-44.06, 22.79),
        "RHipYawPitch": (-65.62, 42.44),
        "RHipRoll": (-42.30, 23.76),
        "RHipPitch": (-101.54, 27.82),
        "RKneePitch": (-5.90, 121.47),
        "RAnklePitch": (-67.97, 53.40),
        "RAnkleRoll": (-22.27, 45.03),
    }
    joints = load_body("nao-v3").joints
    for name, (lower, upper) in printed.items():
        if name.endswith("AnkleRoll"):
            lower, upper = -upper, -lower
        assert math.degrees(joints[name].lower) == pytest.approx(lower, abs=1e-4), name
        assert math.degrees(joints[name].upper) == pytest.approx(upper, abs=1e-4), name
    # The vendor's older table (up to 1.14): same ranges, same sign as here.
    assert (joints["RAnkleRoll"].lower, joints["RAnkleRoll"].upper) == pytest.approx(
        (-0.7859, 0.3886), abs=2e-4
    )
    assert (joints["LAnkleRoll"].lower, joints["LAnkleRoll"].upper) == pytest.approx(
        (-0.3978, 0.7690), abs=2e-4
    )


def test_limits_that_differ_between_versions() -> None:
    def limits(name: str, joint: str) -> tuple[float, float]:
        sheet = load_body(name).joints[joint]
        return sheet.lower, sheet.upper

    assert limits("nao-v3.2", "LShoulderRoll") == (0.0087, 1.6494)
    assert limits("nao-v3", "RElbowRoll") == (0.0087, 1.5621)
    assert limits("nao-v3.3", "LShoulderRoll") == (-0.3142, 1.3265)
    assert limits("nao-v6", "RElbowRoll") == (0.0349, 1.5446)
    for name in BODIES[1:]:
        assert limits(name, "LHipPitch") == (-1.535889, 0.484090)
        assert limits(name, "RKneePitch") == (-0.103083, 2.120198)


@pytest.mark.parametrize("name", BODIES)
def test_every_tensor_is_one_of_a_body(name: str) -> None:
    for joint, link in load_body(name).links.items():
        ixx, iyy, izz, ixy, ixz, iyz = link.inertia
        tensor = np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])
        # The density's second moments: positive exactly if the tensor belongs to a body.
        second_moments = 0.5 * np.trace(tensor) * np.eye(3) - tensor
        assert np.linalg.eigvalsh(second_moments)[0] > 0.0, joint


def _mirrored(inertia: tuple[float, ...]) -> tuple[float, ...]:
    ixx, iyy, izz, ixy, ixz, iyz = inertia
    return ixx, iyy, izz, -ixy, ixz, -iyz


@pytest.mark.parametrize("name", BODIES)
def test_left_and_right_are_mirror_images(name: str) -> None:
    links = load_body(name).links
    for joint in (j for j in links if j.startswith("L")):
        left, right = links[joint], links["R" + joint[1:]]
        assert left.mass == right.mass
        np.testing.assert_allclose(right.com, (left.com[0], -left.com[1], left.com[2]), atol=3e-7)
        # V3.x tensors are published as mirror images, but for one sign at the V3.2's biceps; V4 and later
        # are not, and the V3.x hips carry the V4's two slightly different repairs.
        if name == "nao-v3" or (name in V3X and joint != "LShoulderRoll"):
            np.testing.assert_allclose(right.inertia, _mirrored(left.inertia), rtol=1e-4)


def test_published_repairs() -> None:
    v32, v33, v4 = (load_body(n) for n in ("nao-v3.2", "nao-v3.3", "nao-v4"))
    for body in (v32, v33):
        for joint in ("LHipRoll", "RHipRoll"):
            izz = v4.links[joint].inertia[2]
            assert izz == pytest.approx(5.677e-5, rel=1e-3)
            assert body.links[joint].inertia[2] == izz
            published = (*body.links[joint].inertia[:2], 2.55291e-4, *body.links[joint].inertia[3:])
            assert not is_possible_inertia(published)
    foot = v32.links["RAnkleRoll"].inertia
    assert foot[4] == 7.11645e-6
    assert not is_possible_inertia((*foot[:4], -1.16453e-4, foot[5]))
    noted = {name: " ".join(load_body(name).repairs) for name in BODIES}
    for name, words in {
        "nao-v3": ("LHipRoll and RHipRoll", "HeadPitch", "LAnkleRoll and RAnkleRoll"),
        "nao-v3.2": ("LHipRoll", "RHipRoll", "RAnkleRoll", "HeadPitch"),
        "nao-v3.3": ("LHipRoll", "RHipRoll"),
    }.items():
        assert all(word in noted[name] for word in words)
    assert load_body("nao-v4").repairs == load_body("nao-v5").repairs == load_body("nao-v6").repairs == ()


def test_fsr_places() -> None:
    left = ((0.07025, 0.0299), (0.07025, -0.0231), (-0.03025, 0.0299), (-0.02965, -0.0191))
    right = ((0.07025, 0.0231), (0.07025, -0.0299), (-0.03025, 0.0191), (-0.02965, -0.0299))
    for name in BODIES:
        body = load_body(name)
        assert tuple(p[:2] for p in body.fsr.L) == left
        rear_right = (-0.03025, -0.0299) if name == "nao-v3" else right[3]
        assert tuple(p[:2] for p in body.fsr.R) == (*right[:3], rear_right)
        assert {p[2] for p in (*body.fsr.L, *body.fsr.R)} == {-body.lengths.FootHeight}


def test_inertial_unit_and_cycle() -> None:
    for name in BODIES:
        body = load_body(name)
        unit = body.inertial_unit
        assert unit.gyroscope_axes == (3 if name in ("nao-v5", "nao-v6") else 2)
        assert body.cycle == (0.012 if name == "nao-v6" else 0.010)
        assert unit.accelerometer == (-0.008, 0.00606, 0.027)
        assert unit.gyroscope == (-0.008, 0.006, 0.029)
        assert unit.accelerometer_range == pytest.approx(2 * 9.81)
        assert unit.gyroscope_range == pytest.approx(math.radians(500))
        assert unit.accelerometer_step == pytest.approx(0.0175 * 9.81 if name in V3X else 9.81 / 1024)
        # grids of AngleX and AngleY in recordings of a V3 and of an H25 of NAOqi 2; none is known of a V6
        steps = {**dict.fromkeys(V3X, math.radians(0.1)), "nao-v6": 0.0}
        assert unit.angle_step == pytest.approx(steps.get(name, 2.0 * math.pi / 32768))
        old_gyroscope = name in (*V3X, "nao-v4")
        assert unit.gyroscope_step == pytest.approx(12 / 1600 if old_gyroscope else 2.66316e-4, rel=1e-5)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("nao-v33", "did you mean 'nao-v3.3'?"),
        ("NAO-V6", "did you mean 'nao-v6'?"),
        ("atlas", "known: nao-v3, nao-v3.2, nao-v3.3, nao-v4, nao-v5, nao-v6"),
        ("mine.toml", "mine.toml: cannot be read"),
        ("", "unknown robot body ''"),
    ],
)
def test_unknown_body(name: str, words: str) -> None:
    with pytest.raises(ConfigurationError, match=re.escape(words)):
        load_body(name)


def _changed(**changes: object) -> Body:
    return msgspec.structs.replace(load_body("nao-v3"), **changes)


def test_impossible_sheets_are_refused() -> None:
    body = load_body("nao-v3")
    knee, thigh, coupling = body.joints["LKneePitch"], body.links["LHipPitch"], body.coupling
    replace = msgspec.structs.replace
    swapped = replace(knee, lower=knee.upper, upper=knee.lower)
    other_motor = replace(knee, motor="RE-Max-42")
    rod = replace(thigh, inertia=(1e-4, 1e-4, 2.1e-4, 0.0, 0.0, 0.0))
    negative = replace(thigh, inertia=(1e-4, 1e-4, 1e-4, 2e-4, 0.0, 0.0))
    bow_tie = replace(body.foot, sole=((0.0, 0.0), (0.1, 0.1), (0.1, 0.0), (0.0, 0.1)))
    line = replace(body.foot, sole=((0.0, 0.0), (0.1, 0.1)))
    without_knee = {j: s for j, s in body.joints.items() if j != "LKneePitch"}
    upside_down = replace(coupling, RAnkleRoll=coupling.RAnkleRoll[::-1])
    crossed = replace(coupling.HeadPitch[0], lower=1.0, upper=-1.0)
    cases = [
        ({"joints": body.joints | {"LKneePitch": swapped}}, "joint LKneePitch: lower 2.11"),
        ({"joints": body.joints | {"LKneePitch": other_motor}}, "motor 'RE-Max-42' is not in the table"),
        ({"joints": without_knee}, "joints: LKneePitch missing"),
        ({"joints": body.joints | {"LWristYaw": knee}}, "joints: LWristYaw must go; an H21 has none"),
        ({"links": body.links | {"LWristYaw": thigh}}, "links: LWristYaw must go"),
        ({"links": body.links | {"LHipPitch": rod}}, "link LHipPitch: no body has the principal moments"),
        ({"links": body.links | {"LHipPitch": negative}}, "link LHipPitch: no body has the principal moments"),
        ({"coupling": upside_down}, "coupling RAnkleRoll: rows must be sorted"),
        (
            {"coupling": replace(coupling, HeadPitch=(crossed, *coupling.HeadPitch[1:]))},
            "coupling HeadPitch: at 0.0",
        ),
        ({"coupling": replace(coupling, LAnkleRoll=coupling.LAnkleRoll[:1])}, "coupling LAnkleRoll: 1 rows"),
        ({"foot": bow_tie}, "foot.sole: the outline crosses itself"),
        ({"foot": line}, "foot.sole: 2 points"),
        ({"encoder_steps": 1024}, "encoder_steps: 1024 must be 4096"),
        ({"inertial_unit": replace(body.inertial_unit, gyroscope_axes=1)}, "gyroscope_axes 1 must be 2 or 3"),
        ({"sources": {"masses": "someone said so"}}, "sources.masses: must begin with"),
    ]
    for changes, words in cases:
        with pytest.raises(ConfigurationError, match=r"^robot body nao-v3: .*" + re.escape(words)):
            check_body(_changed(**changes))


def test_a_body_of_ones_own_has_the_cameras_motions_and_facts_of_its_base(tmp_path: Path) -> None:
    sheet = (Path(load.__file__).parent / "bodies" / "nao-v6.toml").read_text()
    file = tmp_path / "rucksack.toml"
    file.write_text(sheet.replace('name = "nao-v6"', 'name = "rucksack"', 1))
    own, shipped = load_body(file), load_body("nao-v6")
    assert own.name == "rucksack" and cameras(own) == cameras(shipped)
    assert "back" in get_up_motions(own) and get_up_motions(own) == get_up_motions(shipped)
    assert RobotConfig(own, "nao").base_version == "V60"
    file.write_text(sheet.replace('base = "nao-v6"', 'base = "nao-v7"', 1))
    with pytest.raises(ConfigurationError, match=r"rucksack\.toml: base: .*nao-v7"):
        load_body(file)


def rucksack(tmp_path: Path) -> Body:
    """A V6 that carries 0.3 kg."""
    sheet = (Path(load.__file__).parent / "bodies/nao-v6.toml").read_text()
    file = tmp_path / "rucksack.toml"
    file.write_text(
        sheet.replace('name = "nao-v6"', 'name = "rucksack"').replace("mass = 1.04956", "mass = 1.34956")
    )
    return load_body(file)


def test_clients_and_recordings_have_the_body_of_a_robot_with_a_sheet_of_its_own(tmp_path: Path) -> None:
    body = rucksack(tmp_path)
    assert body.links[TORSO].mass == pytest.approx(load_body("nao-v6").links[TORSO].mass + 0.3)
    info = robot_info(body, robot="nao", side="emulator", mode="real-time", software="test")
    (tmp_path / "rucksack.toml").unlink()  # the client is on another machine
    told = decode(encode(info), Info)
    assert body_of(told.body, told.sheet) == body
    with Recorder(tmp_path / "run.mcap", {"robot": "rucksack.toml"}, lambda: RobotScene(body, None)):
        pass
    assert recorded_body(tmp_path / "run.mcap") == body
    assert robot_info(load_body("nao-v6"), robot="nao", side="lola", mode="real-time", software="").sheet == ""


@pytest.mark.parametrize("name", BODIES)
def test_the_description_of_a_robot_fits_the_buffer_that_a_page_names(name: str) -> None:
    """docs/how-to/another-language.md: zenoh-pico's fragments together."""
    info = robot_info(load_body(name), robot="n" * 64, side="emulator", mode="real-time", software="s" * 64)
    assert len(encode(info)) < 8192 - 512


@pytest.mark.parametrize("sheet", ["{", "[]", '{"name": "x"}', "[" * 100_000])
def test_a_sheet_that_is_none_is_refused_in_one_sentence(sheet: str) -> None:
    with pytest.raises(ConfigurationError, match="data sheet of x") as refused:
        body_of("x", sheet)
    assert "\n" not in str(refused.value)
