"""Scenarios: files people write, repeatability, and a reset that restores everything."""

import math
from pathlib import Path

import msgspec
import pytest

from bridge.body import load_body
from bridge.config import parse_toml
from bridge.errors import ConfigurationError
from bridge.messages import SensorFrame, TruthFrame
from bridge.messages.faults import JointWeak
from bridge.messages.world import PlaceObject, Push, SetFriction, StartFault, TiltFloor
from emulator.queries import carry_out
from emulator.robot import EmulatedRobot
from emulator.scenarios import SCENARIOS, Scenario, load_scenario
from emulator.start import timeline

BODY = load_body("nao-v3")

BUSY = """
[floor]
pitch = -2.0
friction = 0.7
[tiles]
area = [0.4, 0.4]
height = 0.004
[[boxes]]
name = "box"
size = [0.1, 0.1, 0.1]
at = [0.4, 0.3]
mass = 0.2
[[pushes]]
time = 0.1
impulse = 0.3
direction = 90.0
[[tilts]]
time = 0.2
roll = 1.0
duration = 0.3
[[faults]]
time = 0.1
duration = 0.3
fault = { kind = "sensor-noisy", sensor = "gyroscope", deviation = 0.1 }
"""


def cycles(robot: EmulatedRobot, n: int) -> list[tuple[SensorFrame, TruthFrame]]:
    return [(robot.advance(None), robot.truth()) for _ in range(n)]


def test_the_same_seed_and_scenario_give_the_same_frames_and_another_seed_others() -> None:
    scenario = parse_toml(BUSY, "busy", Scenario)
    with (
        EmulatedRobot(BODY, seed=3, engine="mujoco", scenario=scenario) as a,
        EmulatedRobot(BODY, seed=3, engine="mujoco", scenario=scenario) as b,
        EmulatedRobot(BODY, seed=4, engine="mujoco", scenario=scenario) as c,
    ):
        first = cycles(a, 60)
        assert cycles(b, 60) == first
        assert cycles(c, 60) != first
        assert a.take_notices() == b.take_notices() != []


def test_a_reset_restores_everything() -> None:
    scenario = parse_toml(BUSY, "busy", Scenario)
    with EmulatedRobot(BODY, seed=3, engine="mujoco", scenario=scenario) as robot:
        first = cycles(robot, 60)
        said = robot.take_notices()
        for command in (
            SetFriction(friction=0.1),
            Push(impulse=(3.0, 0.0, 0.0)),
            PlaceObject(name="more", size=(0.1, 0.1, 0.1), at=(0.5, -0.3)),
            TiltFloor(pitch=0.1, duration=1.0),
            StartFault(fault=JointWeak(joint="LKneePitch")),
        ):
            carry_out(robot, command)
        cycles(robot, 20)
        robot.reset()
        assert robot.faults.names == ()
        assert [box.name for box in robot.world.object_states()] == ["box"]
        assert cycles(robot, 60) == first
        assert robot.take_notices() == said


@pytest.mark.parametrize("name", SCENARIOS)
def test_every_shipped_scenario_loads_and_the_robot_stands_at_its_start(name: str) -> None:
    scenario = load_scenario(name)
    assert scenario.title
    with EmulatedRobot(BODY, seed=0, engine="mujoco", scenario=scenario) as robot:
        cycles(robot, 5)
        assert not robot.truth().fell


def test_a_scenario_written_out_reads_back_the_same() -> None:
    for name in SCENARIOS:
        scenario = load_scenario(name)
        assert parse_toml(msgspec.toml.encode(scenario).decode(), name, Scenario) == scenario


def test_angles_typed_in_degrees_are_radians_inside() -> None:
    scenario = parse_toml(
        "[[tilts]]\ntime = 1.0\npitch = -3.0\n[[pushes]]\ntime = 2.0\nimpulse = 0.5\ndirection = 90.0",
        "t",
        Scenario,
    )
    (_, tilt), (_, push) = timeline(scenario, ("",))
    assert isinstance(tilt, TiltFloor) and tilt.pitch == pytest.approx(-math.pi / 60.0)
    assert isinstance(push, Push) and push.impulse == pytest.approx((0.0, 0.5, 0.0))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[flor]\npitch = 1.0", "did you mean 'floor'"),
        ("[floor]\npich = 1.0", "did you mean 'pitch'"),
        ("[floor]\npitch = 50.0", "floor.pitch"),
        ("[start]\nx = 1e300", "start.x"),
        (
            '[[boxes]]\nname = "b"\nshape = "ball"\nsize = [0.1, 0.1, 0.1]\nat = [1, 0]',
            r"boxes\[0\]: a ball rolls",
        ),
        (
            '[[boxes]]\nname = "b"\nshape = "pole"\nsize = [0.1, 0.2, 0.5]\nat = [1, 0]',
            r"boxes\[0\]: the size of",
        ),
        ('[[faults]]\ntime = 1.0\nfault = { kind = "hal-error", joint = "LKneePitch" }', "known keys: none"),
        ('[[faults]]\ntime = 1.0\nfault = { kind = "sensor-ded", sensor = "fsr" }', "sensor-dead"),
        (
            '[[faults]]\ntime = 1.0\nfault = { kind = "sensor-dead", sensor = "gyro" }',
            "did you mean 'gyroscope'",
        ),
        (
            '[[faults]]\ntime = 1.0\nfault = { kind = "joint-weak", joint = "LKnee" }',
            "did you mean 'LKneePitch'",
        ),
        ("[[pushes]]\ntime = 1.0", "impulse"),
        ("[[pushes]]\ntime = 1.0\nimpulse = 1e9", r"pushes\[0\].impulse: expected a number <= 100"),
        ("[[pushes]]\ntime = 1.0\nvector = [0.0, -1e9, 0.0]", "vector.*expected a number >= -100"),
        ('[[pushes]]\ntime = 1.0\nimpulse = 1.0\ntarget = "LKnee"', "did you mean 'LKneePitch'"),
        ('[[faults]]\ntime = 1.0\nfault = { kind = "dcm-pause" }', "duration"),
        ("[[tilts]]\ntime = 1.0\npitch = 20.0", "1.57 s or more"),
        (2 * '[[boxes]]\nname = "a"\nsize = [0.1, 0.1, 0.1]\nat = [1, 0]\n', "same name"),
        ("[heightfield]\nspacing = 0.1", "roughness"),
    ],
)
def test_a_mistake_in_a_scenario_is_named(text: str, says: str) -> None:
    with pytest.raises(ConfigurationError, match=says):
        parse_toml(text, "mine.toml", Scenario)


def test_a_heightfield_comes_from_a_csv_file_beside_the_scenario(tmp_path: Path) -> None:
    (tmp_path / "hills.csv").write_text("0, 0.01, 0\n0.002, 0.02, 0\n")
    file = tmp_path / "hills.toml"
    file.write_text('[heightfield]\nspacing = 0.2\nfile = "hills.csv"\n')
    field = load_scenario(str(file)).heightfield
    assert field is not None
    assert field.heights == ((0.0, 0.01, 0.0), (0.002, 0.02, 0.0))
    (tmp_path / "hills.csv").write_text("0, high\n1, 2\n")
    with pytest.raises(ConfigurationError, match=r"hills\.csv"):
        load_scenario(str(file))
