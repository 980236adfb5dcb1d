"""Walks of a campaign: the same wherever they run, ended by falls, not walked twice."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from bridge.messages import SensorFrame, TruthFrame
from bridge.messages.world import PlaceObject
from emulator.scenarios import Scenario
from emulator.scenarios.ground import ScenarioFloor
from nao_hil.runs import campaign as campaign_module
from nao_hil.runs import store
from nao_hil.runs.campaign import Campaign
from nao_hil.runs.config import RunConfig
from nao_hil.runs.dataset import Dataset
from nao_hil.runs.events import StridePush
from nao_hil.runs.executors import RunFailed
from nao_hil.runs.neighbours import Neighbour
from nao_hil.runs.walk import Walk, WalkOutcome, _WalkObserver, walk
from walker.switches import switch_changes

BARE = switch_changes("none")


def bare(seed: int = 0, duration: float = 0.5, name: str = "test") -> Walk:
    config = RunConfig(engine="mujoco", wear="nominal", gait="static", seed=seed, controller=BARE)
    return Walk(name=name, config=config, duration=duration)


def same(a: WalkOutcome, b: WalkOutcome) -> bool:
    return a.end == b.end and all(
        np.array_equal(values, b.track[name], equal_nan=values.dtype.kind == "f")
        for name, values in a.track.items()
    )


class Told:
    """Progress that remembers."""

    def __init__(self) -> None:
        self.notes: list[str] = []

    def expect(self, runs: int) -> None:
        pass

    def done(self, name: str, note: str) -> None:
        self.notes.append(note)

    def say(self, text: str) -> None:
        raise AssertionError(text)


@pytest.mark.usefixtures("connections_left_open")
def test_results_do_not_depend_on_workers_or_on_the_store(tmp_path: Path) -> None:
    walks = [bare(0), bare(1)]
    here = walk(walks[0])
    with Campaign(tmp_path, cluster="inline") as campaign:
        one = campaign.walk(walks)
    with Campaign(cluster="local:1") as campaign:
        two = campaign.walk(walks)
    told = Told()
    with Campaign(tmp_path, cluster="inline", progress=told) as campaign:
        kept = campaign.walk([*walks, *walks])
    assert [note.endswith("walked before") for note in told.notes] == [True] * 4
    assert here.end.survived and here.track.rows == 50
    assert same(here, one[0])
    for a, b, c in zip(one, two, kept, strict=False):
        assert same(a, b) and same(a, c)
    assert not same(one[0], one[1])


def test_a_fall_ends_the_run() -> None:
    steep = Scenario(floor=ScenarioFloor(pitch=15.0))
    result = walk(
        Walk(
            name="steep",
            config=RunConfig(engine="mujoco", gait="static", controller=BARE),
            duration=60.0,
            scenario=steep,
        )
    )
    assert result.end.ending == "fell"
    assert not result.end.survived
    assert result.end.time < 10.0
    assert result.end.pitch > 0.2  # downhill: forward


def test_no_box_is_placed_into_a_robot_that_lies() -> None:
    push = StridePush(time=0.5, phase=None, impulse=8.0, direction=0.0)
    fall = Walk(name="pushed", config=RunConfig(engine="mujoco"), duration=5.0, pushes=(push,))
    fell = walk(fall).end
    box = PlaceObject(name="box", size=(0.3, 0.3, 0.3), at=(0.0, 0.0), frame="robot")
    assert walk(msgspec.structs.replace(fall, world_events=((fell.time + 0.2, box),))).end == fell


def test_a_fall_before_the_walk_begins_ends_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    cliff = Scenario(floor=ScenarioFloor(pitch=35.0))  # tan 35 degrees: the centre of mass is ahead of the toes
    frames: list[float] = []
    seen = _WalkObserver.sensors

    def sensors(self: _WalkObserver, frame: SensorFrame, truth: TruthFrame) -> None:
        frames.append(truth.time)
        seen(self, frame, truth)

    monkeypatch.setattr(_WalkObserver, "sensors", sensors)
    result = walk(Walk(name="cliff", config=RunConfig(engine="mujoco"), duration=5.0, scenario=cliff))
    assert result.end.ending == "fell" and result.end.time == 0.0
    assert frames[-1] < 3.0


def test_a_walk_that_fails_names_its_configuration_and_ends_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def breaks(task: Walk) -> WalkOutcome:
        if task.config.seed == 1:
            raise ZeroDivisionError
        return walk(task)

    monkeypatch.setattr(campaign_module, "walk", breaks)
    walks = [bare(seed, 0.1) for seed in range(3)]
    with (
        Campaign(tmp_path, cluster="inline") as campaign,
        pytest.raises(
            RunFailed, match=r"(?s)seed 1\) failed: ZeroDivisionError.*configuration of test: .*\"seed\":1"
        ),
    ):
        campaign.walk(walks)
    assert len(Dataset(tmp_path).find({store.key(task): task for task in walks})) == 2


@pytest.mark.parametrize(("at", "passes"), [((0.3, 2.0), True), ((0.4, 0.0), False)])
def test_a_neighbour_is_as_solid_as_a_wall_and_only_where_it_stands(
    at: tuple[float, float], passes: bool
) -> None:
    config = RunConfig(engine="mujoco", robot="nao-v6", velocity=(0.2, 0.0, 0.0), seed=1)
    task = Walk(name="beside", config=config, duration=4.0, keep_track=False, neighbours=(Neighbour(at=at),))
    assert (walk(task).end.distance > 0.4) is passes


def test_a_neighbour_walks_as_ordered_with_a_seed_of_its_own() -> None:
    neighbour = Neighbour(at=(0.0, 0.6), velocity=(0.0, -0.1, 0.0))  # towards the one that stands
    stands = RunConfig(engine="mujoco", robot="nao-v6", gait="omni")
    pushed = Walk(
        name="stands", config=stands, duration=6.0, keep_track=False, stand=True, neighbours=(neighbour,)
    )
    alone = msgspec.structs.replace(pushed, neighbours=())
    assert (
        walk(pushed).end.tilt_max > 1.5 * walk(alone).end.tilt_max
    )  # 2.5 to 10 times on nine seeds and places
    assert store.key(pushed) != store.key(alone)
