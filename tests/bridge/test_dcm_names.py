"""Actuators and aliases of the DCM, against the vendor's list of actuator names."""

from __future__ import annotations

from pathlib import Path

import pytest

from bridge.body import BODIES, load_body
from bridge.body.postures import POSTURES
from bridge.dcm import Dcm
from bridge.dcm.requests import alias_request, set_alias_request, set_request
from bridge.dcm.unit import MAX_ALIASES
from bridge.errors import DcmRefused

LONG = "Device/SubDeviceList/"
RIGHT_HIP = "RHipYawPitch/Position/Actuator/Value"
LED = "ChestBoard/Led/Red/Actuator/Value"
OTHER_LED = "LFoot/Led/Blue/Actuator/Value"
PUBLISHED = {
    line
    for line in (Path(__file__).parent / "data" / "actuators_h25.txt").read_text().splitlines()
    if not line.startswith("#")
}
H21_LACKS = {
    f"{joint}/{kind}/Actuator/Value"
    for joint in ("LWristYaw", "RWristYaw", "LHand", "RHand")
    for kind in ("Position", "Hardness")
}


def dcm_of(body: str) -> Dcm:
    return Dcm(load_body(body), POSTURES["Stand"])


def read(dcm: Dcm, name: str) -> float:
    return dcm.read([name], (0.0,) * 25)[0]


@pytest.mark.parametrize("body", BODIES)
def test_an_h21_has_no_wrists_and_hands(body: str) -> None:
    lacks = H21_LACKS if load_body(body).model == "H21" else set()
    assert {actuator.name for actuator in dcm_of(body).table} == PUBLISHED - lacks
    names = [*sorted(H21_LACKS), LED]
    expected = ["" if name in lacks else name for name in names]
    assert dcm_of(body).create_alias(alias_request(["all", names])) == ["all", expected]


@pytest.mark.parametrize("prefix", ["", LONG])
def test_names_with_and_without_the_prefix(prefix: str) -> None:
    dcm = dcm_of("nao-v3")
    assert dcm.create_alias(alias_request(["leds", [prefix + LED]])) == ["leds", [prefix + LED]]
    dcm.set(set_request([prefix + LED, "ClearAll", [[0.5, 0]]]))
    dcm.run_cycle()
    assert read(dcm, LED) == read(dcm, LONG + LED) == 0.5
    dcm.set_alias(set_alias_request(["leds", "ClearAll", "time-mixed", [[[0.25, 0]]]]))
    dcm.run_cycle()
    assert read(dcm, LED) == 0.25


def test_unknown_actuators_of_an_alias_come_back_empty_and_are_ignored() -> None:
    dcm = dcm_of("nao-v3")
    names = [LED, "Tail/Position/Actuator/Value", OTHER_LED]
    assert dcm.create_alias(alias_request(["mine", names])) == ["mine", [LED, "", OTHER_LED]]
    assert dcm.create_alias(alias_request(["outer", ["mine"]])) == ["outer", [""]]
    dcm.set_alias(set_alias_request(["mine", "ClearAll", "time-separate", 0, [0], [[0.25], [9.0], [0.75]]]))
    dcm.run_cycle()
    assert (read(dcm, LED), read(dcm, OTHER_LED)) == (0.25, 0.75)


def test_the_right_hip_yaw_pitch_is_accepted_and_ignored() -> None:
    dcm = dcm_of("nao-v3")
    left = "LHipYawPitch/Position/Actuator/Value"
    before = read(dcm, left)
    for name in (RIGHT_HIP, LONG + RIGHT_HIP):
        assert dcm.create_alias(alias_request(["legs", [name, LED]])) == ["legs", [name, LED]]
        dcm.set(set_request([name, "ClearAll", [[-0.5, 0]]]))
    dcm.set_alias(set_alias_request(["legs", "ClearAll", "time-mixed", [[[-0.5, 0]], [[0.5, 0]]]]))
    dcm.run_cycle()
    assert read(dcm, LED) == 0.5
    assert read(dcm, left) == before


def test_an_alias_can_be_remade() -> None:
    dcm = dcm_of("nao-v3")
    dcm.create_alias(alias_request(["mine", [LED]]))
    dcm.create_alias(alias_request(["mine", [OTHER_LED]]))
    dcm.set(set_request(["mine", "ClearAll", [[0.5, 0]]]))
    dcm.run_cycle()
    assert (read(dcm, LED), read(dcm, OTHER_LED)) == (0.0, 0.5)


def test_the_number_of_aliases_is_bounded() -> None:
    dcm = dcm_of("nao-v3")
    for i in range(MAX_ALIASES):
        dcm.create_alias(alias_request([f"a{i}", [LED]]))
    with pytest.raises(DcmRefused, match="aliases already"):
        dcm.create_alias(alias_request(["one more", [LED]]))
    dcm.create_alias(alias_request(["a0", [OTHER_LED]]))


def test_a_name_nobody_knows_is_refused() -> None:
    dcm = dcm_of("nao-v3")
    with pytest.raises(DcmRefused, match="'nothing' is neither an actuator of this body nor an alias"):
        dcm.set(set_request(["nothing", "Merge", []]))
    with pytest.raises(DcmRefused, match="'nothing' is no alias"):
        dcm.set_alias(set_alias_request(["nothing", 0, []]))
    with pytest.raises(DcmRefused, match="'LWristYaw/Position/Actuator/Value' is neither"):
        dcm.set(set_request(["LWristYaw/Position/Actuator/Value", "Merge", [[0.0, 0]]]))
