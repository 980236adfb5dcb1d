"""Members of the shipped ensembles, and the ranges they are drawn from."""

import functools
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from bridge.errors import ConfigurationError
from emulator.wear import ensemble, load_wear, wear_of_seed
from emulator.wear.ensemble import RobotEnsemble, load_ensemble, unknowns
from tests.unknowns import share

SHIPPED = sorted(file.stem for file in (Path(ensemble.__file__).parent / "ensembles").glob("*.toml"))
NOMINAL = load_wear("nominal")


def value_at(profile: Any, path: str) -> float:
    return float(functools.reduce(getattr, path.split("."), profile))


@pytest.mark.parametrize("name", unknowns())
def test_the_nominal_robot_lies_in_each_range(name: str) -> None:
    unknown = unknowns()[name]
    for path in unknown.paths:
        assert unknown.low <= value_at(NOMINAL, path) <= unknown.high
    assert unknown.at(0.0) == pytest.approx(unknown.low) and unknown.at(1.0) == pytest.approx(unknown.high)
    assert share(unknown, unknown.at(0.3)) == pytest.approx(0.3)
    assert unknown.reason and unknown.source


@pytest.mark.parametrize("robot", SHIPPED)
def test_members_lie_in_the_ranges_and_have_the_figures_of_the_thesis(robot: str) -> None:
    drawn, body = load_ensemble(robot), load_body(robot)
    assert drawn.robot == robot and drawn.unknowns == tuple(unknowns()) and drawn.members
    for k, member in enumerate(drawn.members):
        profile = load_wear(f"ensemble:{k}", body)
        for name, value in zip(drawn.unknowns, member.values, strict=True):
            unknown = unknowns()[name]
            assert unknown.low <= value <= unknown.high
            assert {value_at(profile, path) for path in unknown.paths} == {value}
        # (4.12): 7.0 rad/s within 15 %, damping 0.07 to 0.15, zero 8 rad/s within 25 %, peak and undershoot
        figures = member.figures
        assert 5.95 <= figures["natural_frequency_rad_s"] <= 8.05 and 0.07 <= figures["damping"] <= 0.15
        assert 6.0 <= figures["zero_rad_s"] <= 10.0 and 1.80 <= figures["peak"] <= 2.10
        assert -0.38 <= figures["undershoot"] <= -0.22


@pytest.mark.parametrize("robot", SHIPPED)
def test_nominal_is_nearer_to_the_median_than_eight_of_ten_members(robot: str) -> None:
    drawn = load_ensemble(robot)
    places = [unknowns()[name] for name in drawn.unknowns]
    shares = np.array([[share(u, v) for u, v in zip(places, m.values, strict=True)] for m in drawn.members])
    nominal = np.array([share(u, value_at(NOMINAL, u.paths[0])) for u in places])

    def distance(point: np.ndarray) -> float:
        return float(np.linalg.norm((point - np.median(shares, axis=0)) / shares.std(axis=0)))

    nearer = sum(distance(member) < distance(nominal) for member in shares)
    assert nearer <= 0.2 * len(shares)


@pytest.fixture
def made_up(monkeypatch: pytest.MonkeyPatch) -> RobotEnsemble:
    middle = tuple(unknown.at(0.5) for unknown in unknowns().values())
    members = tuple(ensemble.Member(values=middle, figures={}) for _ in range(3))
    drawn = RobotEnsemble(
        command="",
        robot="nao-v3",
        engine="mujoco",
        seed=0,
        drawn=3,
        tried=3,
        unknowns=tuple(unknowns()),
        members=members,
    )
    monkeypatch.setattr(ensemble, "load_ensemble", lambda _: drawn)
    return drawn


@pytest.mark.parametrize(
    "name", ["ensemble:3", "ensemble:-1", "ensemble:x", "ensemble:", "ensemble", "ensemble:²"]
)
def test_a_bad_number_is_refused_in_a_sentence(made_up: RobotEnsemble, name: str) -> None:
    with pytest.raises(
        ConfigurationError, match=r"^wear profile .*must be ensemble:0 to ensemble:2 for nao-v3\.$"
    ):
        load_wear(name, load_body("nao-v3"))


def test_a_member_needs_a_robot() -> None:
    with pytest.raises(ConfigurationError, match="name a robot"):
        load_wear("ensemble:0")


def test_all_members_take_turns_by_the_seed(made_up: RobotEnsemble) -> None:
    body = load_body("nao-v3")
    assert [wear_of_seed("ensemble", body, seed) for seed in (0, 2, 3)] == [
        "ensemble:0",
        "ensemble:2",
        "ensemble:0",
    ]
    assert wear_of_seed("worn", body, 1) == "worn"


def test_what_is_not_unknown_stays_nominal(made_up: RobotEnsemble) -> None:
    profile = load_wear("ensemble:1", load_body("nao-v3"))
    assert profile.name == "ensemble:1"
    assert profile.sensors.battery == NOMINAL.sensors.battery and profile.servo.supply_voltage == 21.6
    assert msgspec.structs.replace(profile.servo, backlash=NOMINAL.servo.backlash) != NOMINAL.servo
