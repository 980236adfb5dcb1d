"""Finding, reading and refusing data sheets."""

from __future__ import annotations

import re
from pathlib import Path

import msgspec
import pytest

import bridge.body
from bridge.adapters.naoqi.core.robot_facts import RobotConfig
from bridge.body import Body, load, load_body
from bridge.body.cameras import cameras
from bridge.body.load import check_body, is_possible_inertia, principal_moments
from bridge.errors import ConfigurationError
from bridge.motion import get_up_motions


def test_loading_twice_gives_the_same_object_and_a_path_the_same_body() -> None:
    assert load_body("nao-v4") is load_body("nao-v4")
    file = Path(bridge.body.__file__).parent / "bodies" / "nao-v4.toml"
    assert load_body(file) == load_body("nao-v4")


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


def test_misspelt_key_in_a_sheet(tmp_path: Path) -> None:
    text = (Path(bridge.body.__file__).parent / "bodies" / "nao-v3.toml").read_text("utf-8")
    sheet = tmp_path / "mine.toml"
    sheet.write_text(text.replace("TibiaLength", "TibiaLenght"), "utf-8")
    with pytest.raises(ConfigurationError) as info:
        load_body(sheet)
    assert str(info.value) == f"{sheet}: unknown key 'lengths.TibiaLenght' (did you mean 'TibiaLength'?)"


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("ThighLength", "-0.1", "lengths.ThighLength: -0.1 m must be above 0"),
        ("TibiaLength", "0.0", "lengths.TibiaLength: 0.0 m must be above 0"),
        ("torso_top", "-0.2", "shapes: torso_bottom .* must be below torso_top -0.2"),
    ],
)
def test_an_impossible_length_is_told_with_the_file(tmp_path: Path, key: str, value: str, words: str) -> None:
    text = (Path(bridge.body.__file__).parent / "bodies" / "nao-v6.toml").read_text("utf-8")
    sheet = tmp_path / "mine.toml"
    sheet.write_text(re.sub(rf"^{key} = [^ \n]+", f"{key} = {value}", text, flags=re.MULTILINE), "utf-8")
    with pytest.raises(ConfigurationError, match=f"^{re.escape(str(sheet))}: robot body nao-v6: {words}$"):
        load_body(sheet)


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


def test_inertia_test_knows_the_border() -> None:
    assert is_possible_inertia((1.0, 1.0, 2.0, 0.0, 0.0, 0.0))  # a flat disc
    assert not is_possible_inertia((1.0, 1.0, 2.001, 0.0, 0.0, 0.0))
    assert not is_possible_inertia((0.0, 1.0, 1.0, 0.0, 0.0, 0.0))
    assert principal_moments((2.0, 2.0, 5.0, 1.0, 0.0, 0.0)) == pytest.approx((1.0, 3.0, 5.0))


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
