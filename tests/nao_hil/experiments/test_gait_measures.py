"""Quantities that experiments measure, from made-up walks and frames with known answers."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bridge.body import TORSO, load_body
from bridge.messages.world import Push
from nao_hil.experiments.conditions import growth_per_step, soles_in_world, zmp_margin
from nao_hil.experiments.push_map import ThresholdSearch
from nao_hil.experiments.terrain import ground_tasks
from nao_hil.experiments.velocity import heading_velocity, straight
from nao_hil.runs.config import RunConfig
from nao_hil.runs.events import StridePush, TorsoLoad, WalkEvents
from nao_hil.runs.walk import Walk, WalkOutcome
from tests.frames import walk_telemetry
from tests.made_walks import made_track, walk_end
from tests.measure.soak import punctuality

V3 = load_body("nao-v3")


def on_an_arc(velocity, duration=12.0, heading=0.7, odometry=1.0) -> WalkOutcome:
    """A walk at a constant velocity in the torso's heading, and an odometry that tells a part of the way."""
    time = np.arange(0.0, duration, 0.01)
    yaw = heading + velocity[2] * time
    x, y = np.zeros_like(time), np.zeros_like(time)
    for i in range(1, len(time)):
        middle = 0.5 * (yaw[i] + yaw[i - 1])
        x[i] = x[i - 1] + 0.01 * (math.cos(middle) * velocity[0] - math.sin(middle) * velocity[1])
        y[i] = y[i - 1] + 0.01 * (math.sin(middle) * velocity[0] + math.cos(middle) * velocity[1])
    zero = np.zeros_like(time)
    track = made_track(
        {
            "time": time,
            "world/truth.torso_position": np.column_stack([x, y, zero]),
            "world/truth.torso_orientation": np.column_stack([zero, zero, np.sin(yaw / 2), np.cos(yaw / 2)]),
            "walk/telemetry.place": np.column_stack([odometry * x, odometry * y, yaw]),
        }
    )
    return WalkOutcome(Walk(name="", config=RunConfig(), duration=duration), walk_end(time=duration), track)


def test_the_velocity_is_that_in_the_torsos_heading():
    track = on_an_arc((0.2, -0.05, 0.9)).track
    assert heading_velocity(track) == pytest.approx((0.2, -0.05, 0.9), abs=1e-4)
    assert heading_velocity(track.until(2.5)) is None


def test_odometry_that_tells_less_of_the_way_is_off_by_as_much():
    found = straight([on_an_arc((0.25, 0.0, 0.0), odometry=0.96)] * 2)
    assert found.odometry.value == pytest.approx(0.04, abs=1e-4)
    assert found.heading_deg.value == pytest.approx(0.0, abs=1e-3)
    turned = straight([on_an_arc((0.25, 0.0, math.radians(1.0)))] * 2)
    assert turned.heading_deg.value == pytest.approx(12.0, abs=0.1)
    assert turned.odometry.value == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize("true", [0.5, 1.5, 4.0])
def test_a_threshold_is_found_by_few_trials(true):
    """Of 40 observers with a spread of 0.15, nine in ten and more have the truth in their interval."""
    random, hits, found = np.random.default_rng(1), 0, []
    for _ in range(40):
        search = ThresholdSearch(0.2, 8.0)
        for _ in range(12):
            strength = search.threshold.value
            search.add_trial(strength, bool(math.log(strength / true) > random.normal(0.0, 0.15)))
        low, high = search.threshold.interval
        hits += low <= true <= high
        found.append(search.threshold.value)
    assert hits >= 36
    assert float(np.median(found)) == pytest.approx(true, rel=0.1)


def test_the_margin_is_the_distance_to_the_nearest_edge_of_the_stance_sole() -> None:
    outline = np.array(V3.foot.sole)
    low, high = outline.min(axis=0), outline.max(axis=0)
    yaw = Rotation.from_euler("z", 0.7)
    columns = {
        "walk/telemetry.phase": ["SSL", "SSR", "DSL"],
        "world/truth.torso_orientation": np.tile(yaw.as_quat(), (3, 1)),
        "world/truth.torso_position": np.tile([1.0, 2.0, 0.3], (3, 1)),
    }
    places = []
    for side, off in (("L", (high[0] - 0.02, 0.0)), ("R", (0.0, -(high[1] + 0.005)))):
        sole = soles_in_world(V3, side, made_track(columns))[0]
        places.append((sole @ np.array([*off, 0.0, 1.0]))[:2])
    margin = zmp_margin(made_track(columns | {"world/truth.zmp": [*places, (0.0, 0.0)]}), V3)
    assert margin[0] == pytest.approx(0.02, abs=1e-5)
    assert margin[1] == pytest.approx(-0.005, abs=1e-5)
    assert math.isnan(margin[2])
    assert low[0] < 0.0 < high[0]


def test_growth_is_the_slope_of_the_means_over_steps() -> None:
    steps = np.repeat([0, 1, 2, 3], 50)
    ripple = np.tile([1.0, -1.0], 100)
    found = made_track({"walk/telemetry.step": steps})
    assert growth_per_step(found, 0.7 * steps + ripple) == pytest.approx(0.7)
    assert growth_per_step(made_track({"walk/telemetry.step": [0, 0, 1]}), np.zeros(3)) is None


class Stage:
    """Notes the commands."""

    def __init__(self) -> None:
        self.did: list[Push] = []

    def execute(self, command: Push) -> None:
        self.did.append(command)


@pytest.mark.parametrize("phase", [0.0, 0.25, 0.5])
def test_a_push_comes_at_its_phase_of_the_stride(phase):
    """Strides of 0.8 s from t = 0.1 s on; the first that begins at 2 s or later begins at 2.5 s."""
    stage = Stage()
    push = StridePush(time=2.0, phase=phase, impulse=2.0, direction=math.pi / 2)
    events, at = WalkEvents((), (push,), (), stage), math.nan  # type: ignore[arg-type]
    for i in range(500):
        time = 0.01 * i
        left = (time - 0.1) % 0.8 < 0.4 - 1e-9 if time >= 0.1 else False
        events.follow(walk_telemetry(phase="SSL" if left else "SSR"), time)
        events.happen(time, None)  # type: ignore[arg-type]
        if stage.did and math.isnan(at):
            at = time
    assert at == pytest.approx(2.5 + 0.8 * phase, abs=0.0101)
    assert len(stage.did) == 1
    assert stage.did[0].impulse == pytest.approx((0.0, 2.0, 0.0))


def test_a_load_moves_the_centre_of_mass_and_adds_the_inertia_of_two_points():
    """About the common centre, two bodies have the reduced mass times the square of their distance."""
    body, load = load_body("nao-v6"), TorsoLoad(mass=0.5, at=(-0.08, 0.0, 0.05))
    before, after = body.links[TORSO], load.on(body).links[TORSO]
    assert after.mass == pytest.approx(before.mass + 0.5)
    moment = np.array(before.com) * before.mass + np.array(load.at) * load.mass
    assert np.array(after.com) * after.mass == pytest.approx(moment)
    way = np.array(load.at) - np.array(before.com)
    reduced = before.mass * load.mass / after.mass
    expected = np.trace(tensor(before.inertia)) + 2.0 * reduced * float(way @ way)
    assert np.trace(tensor(after.inertia)) == pytest.approx(expected)
    # a rotation about the line that joins both is not hindered
    assert way @ (tensor(after.inertia) - tensor(before.inertia)) @ way == pytest.approx(0.0, abs=1e-12)


def tensor(inertia) -> np.ndarray:
    xx, yy, zz, xy, xz, yz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def test_worlds_follow_the_seed_alone():
    """Slopes are 5 degrees whatever their direction; plates have edges of 4 to 20 cm and are 10 mm high."""
    tasks = ground_tasks("omni")
    for seed in range(5):
        task = Walk(name="", config=RunConfig(seed=seed), duration=20.0)
        floor = tasks["slope"].by_seed(task)["scenario"].floor
        roll, pitch = math.radians(floor.roll), math.radians(floor.pitch)
        steepness = math.acos(math.cos(roll) * math.cos(pitch))
        assert math.degrees(steepness) == pytest.approx(5.0, abs=0.01)
        plates = tasks["plates"].by_seed(task)["world_events"]
        assert plates == tasks["plates"].by_seed(task)["world_events"]
        assert len(plates) == 5
        for time, plate in plates:
            assert 0.0 < time < 20.0
            assert plate.size[2] == 0.01 and all(0.04 <= edge <= 0.20 for edge in plate.size[:2])
        assert len({msgspec.structs.astuple(plate) for _, plate in plates}) == 5


CYCLE = 0.01
N = 6000


def test_punctuality_is_the_ordinary_windows_and_not_a_bursts() -> None:
    late = np.full(N, 1e-4)
    late[N // 2 :] = 3e-4
    assert punctuality(late, CYCLE) == pytest.approx((1e-4, 3e-4))
    late[100:400] = late[-1000:-500] = 0.1  # other work on the machine for some seconds
    assert punctuality(late, CYCLE) == pytest.approx((1e-4, 3e-4))


def test_punctuality_sees_one_cycle_in_fifty() -> None:
    late = np.full(N, 1e-4)
    late[N // 2 :: 50] = 0.02
    first, last = punctuality(late, CYCLE)
    assert first == pytest.approx(1e-4)
    assert last > 0.01
