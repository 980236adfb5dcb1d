"""Members of the shipped ensembles, and the ranges they are drawn from."""

import functools
from typing import Any

import pytest

from bridge.body import load_body
from bridge.errors import ConfigurationError
from emulator.wear import ensemble, load_wear
from emulator.wear.ensemble import RobotEnsemble, load_ensemble, unknowns


def value_at(profile: Any, path: str) -> float:
    return float(functools.reduce(getattr, path.split("."), profile))


@pytest.mark.parametrize("name", unknowns())
def test_the_nominal_robot_lies_in_each_range(name: str) -> None:
    unknown = unknowns()[name]
    nominal = load_wear("nominal", load_body("nao-v3" if unknown.generation else "nao-v6"))
    for path in unknown.paths:
        assert unknown.low <= value_at(nominal, path) <= unknown.high
    assert unknown.at(0.0) == pytest.approx(unknown.low) and unknown.at(1.0) == pytest.approx(unknown.high)
    assert unknown.share(unknown.at(0.3)) == pytest.approx(0.3)
    assert unknown.reason and unknown.source


def test_members_lie_in_the_ranges_and_have_the_figures_of_the_sources() -> None:
    drawn, body = load_ensemble(), load_body("nao-v6")
    assert drawn.unknowns == tuple(unknowns()) and drawn.members
    for k, member in enumerate(drawn.members):
        profile = load_wear(f"ensemble:{k}", body)
        for name, value in zip(drawn.unknowns, member.values, strict=True):
            unknown = unknowns()[name]
            assert unknown.low <= value <= unknown.high
            if body.name.startswith(unknown.generation):
                assert {value_at(profile, path) for path in unknown.paths} <= {value}
        # (4.12): 7.0 rad/s within 15 %, damping 0.07 to 0.15, zero 8 rad/s within 25 %, gain 1.25 at most
        figures = member.figures
        assert 5.95 <= figures["natural_frequency_rad_s"] <= 8.05 and 0.07 <= figures["damping"] <= 0.15
        assert 6.0 <= figures["zero_rad_s"] <= 10.0 and 1.80 <= figures["peak"] <= 2.20
        assert -0.38 <= figures["undershoot"] <= -0.22 and 0.75 <= figures["gain"] <= 1.25
        # B-Human's good robot: 1.4, 1.4 and 1.0 deg at 3 frames; a knee held out: 0.76 +- 0.14 deg
        assert 0.98 <= figures["tracking.hip_pitch"] <= 1.82 and 0.98 <= figures["tracking.knee_pitch"] <= 1.82
        assert 0.70 <= figures["tracking.ankle_pitch"] <= 1.30 and 2.5 <= figures["tracking.shift"] <= 3.5
        assert 0.48 <= figures["knee_hold.knee_pitch"] <= 1.04


def test_generations_differ_in_the_delay_and_the_gyroscope() -> None:
    member = dict(zip(load_ensemble().unknowns, load_ensemble().members[0].values, strict=True))
    v3, v6 = (load_wear("ensemble:0", load_body(name)) for name in ("nao-v3", "nao-v6"))
    assert v3.servo.delay == member["delay_v3"] and v6.servo.delay == member["delay"]
    assert v6.sensors.gyroscope.bias == 1.8e-4 and v3.sensors.gyroscope.bias == 0.01


@pytest.fixture
def made_up(monkeypatch: pytest.MonkeyPatch) -> RobotEnsemble:
    middle = tuple(unknown.at(0.5) for unknown in unknowns().values())
    members = tuple(ensemble.Member(values=middle, figures={}) for _ in range(3))
    drawn = RobotEnsemble(
        command="", engine="mujoco", seed=0, tried=3, accepted=3, unknowns=tuple(unknowns()), members=members
    )
    monkeypatch.setattr(ensemble, "load_ensemble", lambda: drawn)
    return drawn


@pytest.mark.parametrize(
    "name", ["ensemble:3", "ensemble:-1", "ensemble:x", "ensemble:", "ensemble", "ensemble:²"]
)
def test_a_bad_number_is_refused_in_a_sentence(made_up: RobotEnsemble, name: str) -> None:
    with pytest.raises(ConfigurationError, match=r"^wear profile .*must be ensemble:0 to ensemble:2\.$"):
        load_wear(name, load_body("nao-v3"))
