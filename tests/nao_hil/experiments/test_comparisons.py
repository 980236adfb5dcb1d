"""Verdicts of the comparing experiments: from made-up conditions, and one small campaign."""

import json
import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.sole import foot_centre, sole_hull
from nao_hil.analysis.report.render import Claim
from nao_hil.analysis.statistics import mean_of, share_of, wilson
from nao_hil.experiments import mechanisms, obstacle
from nao_hil.experiments.catalogue import EXPERIMENTS
from nao_hil.experiments.conditions import Condition, pairs
from nao_hil.experiments.context import Context, Task
from nao_hil.experiments.experiment import Measured, bounded
from nao_hil.experiments.obstacle import HEIGHT, board, heights, landing_force, steps_down
from nao_hil.experiments.torso_control import drift_claims, torso_claims
from nao_hil.runs.campaign import Campaign, Interrupted
from nao_hil.runs.config import RunConfig
from nao_hil.runs.walk import Walk, WalkEnd, WalkOutcome
from tests.made_walks import NO_TRACK, MadeCampaign, made_context, made_track, walk_end
from walker.parameters import controller_parameters
from walker.switches import differing


def ended(
    seed: int, time: float, *, fell: bool, roll: float = 0.0, pitch: float = 0.0, tilt: float = 0.05
) -> WalkOutcome:
    end = walk_end(
        "fell" if fell else "walked",
        time,
        roll=roll,
        pitch=pitch,
        steps=int(time),
        distance=0.2 * time,
        tilt_max=tilt,
    )
    task = Walk(name="made up", config=RunConfig(seed=seed), duration=60.0)
    return WalkOutcome(task, end, NO_TRACK)


def condition_of(n: int, survived: int, speed: float = 0.2, tilt: float = 3.0) -> Condition:
    return Condition(
        n=n,
        survived=survived,
        interval=wilson(survived, n),
        fall_times=(),
        tilt_max_deg=(tilt, tilt),
        speed=speed,
    )


def test_conditions_are_paired_by_seed_whatever_their_order() -> None:
    with_ = [ended(seed, 60.0, fell=False) for seed in (0, 1, 2)]
    without = [ended(seed, 5.0, fell=seed != 1) for seed in (2, 1)]
    found = pairs(with_, without)
    assert (found.n, found.only_with, found.both) == (2, 1, 1)


@pytest.mark.parametrize(
    ("claims", "walks_on", "falls", "growth", "speed", "holds"),
    [
        # Wilson's lower bound of 18 of 20 is 0.699, of 17 of 20 0.640; two thirds are asked
        (torso_claims, 18, 18, (0.0, 0.0), 0.2, [True, True, True]),
        (torso_claims, 17, 17, (0.0, 0.0), 0.2, [False, False, True]),
        (torso_claims, 20, 20, (0.0, 0.0), 0.149, [True, True, False]),
        (drift_claims, 20, 20, (0.01, 0.8), 0.2, [True, True, True]),
        (drift_claims, 17, 17, (0.5, 0.1), 0.2, [False, False, False]),
    ],
)
def test_the_bound_of_the_interval_decides(
    claims: Callable[[Any], Sequence[Claim]],
    walks_on: int,
    falls: int,
    growth: tuple[float, float],
    speed: float,
    holds: list[bool],
    tmp_path: Path,
) -> None:
    """R5 asks for falls without, survival and speed with torso control; R2 for growth, falls and survival."""
    figures = {
        "with": condition_of(20, walks_on, speed),
        "without": condition_of(20, 20 - falls),
        "growth_with_deg": growth[0],
        "growth_without_deg": growth[1],
    }
    measured = Measured(made_context(MadeCampaign(), tmp_path, (0,)), None, figures)
    assert [claim.holds for claim in claims(measured)] == holds


@pytest.mark.parametrize(
    ("value", "low", "high", "holds"),
    [
        (0.7, 0.7, 1.0, True),
        (0.69, 0.7, 1.0, False),
        (math.nan, 0.0, 1.0, False),
        (mean_of([1.0, 1.01, 1.02]), 0.9, 1.1, True),
        (mean_of([0.9, 1.0, 1.1]), 0.9, 1.1, False),
        (mean_of([1.0]), 0.9, 1.1, False),
        (share_of([True] * 20), 0.8, 1.0, True),
        (share_of([True] * 19 + [False]), 0.8, 1.0, False),
    ],
)
def test_a_claim_is_judged_by_the_whole_interval(value: Any, low: float, high: float, holds: bool) -> None:
    assert bounded("within bounds", value, low, high).holds is holds


def test_the_landing_force_is_that_of_the_swing_foot_in_the_ssl_of_the_plate() -> None:
    n = 400
    phase, fsr = np.full(n, "DSR"), np.zeros((n, 8))
    phase[:150] = phase[300:] = "SSL"
    fsr[50, 4] = 40.0  # before the plate
    fsr[120, 4:] = 3.0  # the landing: four cells of 3 N
    fsr[130, 0] = 45.0  # the other foot
    fsr[200, 4] = 30.0  # loading in double support
    fsr[310, 4] = 50.0  # the next single support
    time = 16.0 + 0.01 * np.arange(n)
    found = made_track({"time": time, "walk/telemetry.phase": phase, "sensors.fsr": fsr})
    result = ended(0, 45.0, fell=False)
    assert landing_force(WalkOutcome(result.walk, result.end, found)) == pytest.approx(12.0)
    assert landing_force(result) is None


def test_a_foot_steps_down_after_two_steps_on_the_board() -> None:
    """The torso is raised by as much as the right foot, at angles of 0 in all joints."""
    body = load_body("nao-v3")
    legs = body.lengths
    straight = legs.HipOffsetZ + legs.ThighLength + legs.TibiaLength + legs.FootHeight
    torso, phase = np.zeros((600, 3)), ["SSR" if k // 100 % 2 else "SSL" for k in range(600)]
    columns = {"time": 16.0 + 0.05 * np.arange(600), "walk/telemetry.phase": phase}
    for down in (400, 200):
        raised = np.where(np.arange(600) < down, HEIGHT, 0.0)
        torso[:, 2] = straight + raised
        walked = made_track(columns | {"world/truth.torso_position": torso})
        result = ended(0, 45.0, fell=False)
        found = heights(WalkOutcome(result.walk, result.end, walked), body)
        assert found == pytest.approx([HEIGHT if 100 * k < down else 0.0 for k in (1, 3, 5)], abs=1e-6)
        assert steps_down(found) is (down == 400)
    assert not steps_down(found[:2])


def test_a_small_campaign_gives_the_fixed_keys_and_the_figures(tmp_path: Path) -> None:
    changes = RunConfig(engine="mujoco", wear="nominal", controller={"switches": {"torso": "none"}})
    with Campaign(cluster="inline") as campaign:
        context = Context(campaign, tmp_path, (0,), changes)
        outcome = obstacle.obstacle(duration=3.6, time=3.0).run("obstacle", context)
    data = json.loads(msgspec.json.encode(outcome.result))
    assert data["name"] == "obstacle" and data["passed"] is outcome.page.passed is False
    for key in ("with", "without"):
        assert data[key]["n"] == data[key]["survived"] == 1
        assert data[key]["interval"] == list(wilson(1, 1))
    assert data["force_with"] > 0.0
    assert {p.file.name for p in outcome.page.pictures} == {f"obstacle-{n}.png" for n in ("4.1", "4.2", "4.8")}
    assert all(p.file.stat().st_size > 5000 for p in outcome.page.pictures)


@pytest.mark.parametrize("name", ["obstacle", "torso-drift", "dynamic-torso"])
def test_an_experiment_is_titled_by_the_switch_in_which_its_conditions_differ(
    name: str, tmp_path: Path
) -> None:
    campaign = MadeCampaign(most=0)
    declared = EXPERIMENTS[name].load()
    with pytest.raises(Interrupted):
        declared.run(name, made_context(campaign, tmp_path, (7,)))
    switches = [controller_parameters(w.config.gait, w.config.controller).switches for w in campaign.asked]
    differ = {switch for one, other in pairwise(switches) for switch in differing(one, other)}
    assert len(differ) == 1
    assert isinstance(declared.title, str) and differ.pop().replace("_", " ") in declared.title


@pytest.mark.parametrize(("task", "switch"), mechanisms.CREDITED.items())
def test_each_condition_of_the_ablation_differs_from_its_own_in_one_switch(task: str, switch: str) -> None:
    shipped = controller_parameters(mechanisms.ABLATION_TASKS[task].gait).switches
    found = mechanisms.ablation_conditions(switch, shipped)
    compared = [each for each in found.values() if each.compared]
    assert len(compared) == len(found) - 3  # as shipped, the thesis' and none are compared with nothing
    for each in compared:
        assert len(differing(each.switches, found[each.compared].switches)) == 1


def test_each_condition_of_feedback_differs_from_the_shipped_one_in_one_switch_alone(tmp_path: Path) -> None:
    campaign, changes = MadeCampaign(most=0), RunConfig(robot="nao-v6", engine="mujoco")
    with pytest.raises(Interrupted):
        mechanisms.FEEDBACK.run("feedback", made_context(campaign, tmp_path, (7,), changes))
    by_task: dict[str, dict[str, Walk]] = {}
    for walk in campaign.asked:
        _, task, condition = walk.name.split(", ")
        by_task.setdefault(task, {})[condition] = walk
    assert set(by_task) == {"push", "push in a stand", "plates", "slope", "worn", "straight"}
    for conditions in by_task.values():
        shipped = conditions.pop(mechanisms.SHIPPED)
        for name, walk in conditions.items():
            pair = (controller_parameters("omni", each.config.controller).switches for each in (shipped, walk))
            assert [f"without {switch}" for switch in differing(*pair)] == [name]
            config = msgspec.structs.replace(walk.config, controller=shipped.config.controller)
            assert msgspec.structs.replace(walk, name=shipped.name, config=config) == shipped


@pytest.mark.parametrize("seed", range(200, 220))
def test_the_board_carries_two_steps_and_no_third(seed: int) -> None:
    """Right sole's outline about its middle, landed 24, 133 and 241 mm ahead of its place at 17 s (walks on the
    bare floor with the leg admittance, seeds 2000 to 2003); the board is clear of the other foot."""
    body = load_body("nao-v3")
    outline = sole_hull(body, "R") - foot_centre(body, "R")
    walk = Walk(name="", config=RunConfig(seed=seed), duration=45.0)
    ((time, plate),) = board(walk)["world_events"]
    low, high = (np.array(plate.shift) + sign * 0.5 * np.array(plate.size[:2]) for sign in (-1.0, 1.0))
    landed = outline + np.array([0.024, 0.0])
    assert time == 17.0 and plate.size[2] == 0.01
    assert (low <= landed).all() and (landed <= high).all()
    heel = outline[:, 0].min()
    assert low[0] < heel + 0.133 and 0.133 < high[0] < heel + 0.241
    assert high[1] <= 0.045 + 1e-9
    other = msgspec.structs.replace(walk, config=RunConfig(seed=seed + 1))
    assert board(walk) == board(walk) != board(other)


def falling_from_the_eighth_seed(task: Walk) -> WalkEnd:
    return walk_end("fell" if task.name == "falls" and task.config.seed >= 7 else "walked")


def test_a_condition_ends_when_further_seeds_cannot_change_its_verdict(tmp_path: Path) -> None:
    """Lower bound of 19 of 20: 0.764, of 20: 0.839 (Wilson 1927). One fall decides against 0.8."""
    context = made_context(MadeCampaign(falling_from_the_eighth_seed), tmp_path, range(20))
    conditions = {name: Task("static", 60.0).walks(context, name) for name in ("stands", "falls")}
    stands, falls = context.run_until_certain(0.8, conditions).values()
    assert [result.seed for result in stands] == list(range(20))
    assert [result.seed for result in falls] == list(range(10))  # two blocks of five


def test_seeds_too_few_for_any_verdict_are_all_walked(tmp_path: Path) -> None:
    """Lower bound of 2 of 2: 0.342, which never reaches 0.8."""
    context = made_context(MadeCampaign(falling_from_the_eighth_seed), tmp_path, (0, 1))
    walks = Task("static", 60.0).walks(context, "stands")
    assert [result.seed for result in context.run_until_certain(0.8, {"": walks})[""]] == [0, 1]


def test_conditions_differ_in_their_switches_and_changes_hold_for_their_own_gait(tmp_path: Path) -> None:
    changes = RunConfig(
        gait="dynamic", controller={"switches": {"torso": "thesis"}, "leg": {"D": 99.0}}, parameters={"z": 0.24}
    )
    context = made_context(MadeCampaign(most=3), tmp_path, (3,), changes)
    off = {"controller.switches.torso": "none"}
    (static,), (dynamic,) = (Task(gait, 1.0).walks(context, "off", off) for gait in ("static", "dynamic"))
    assert (static.config.controller, static.config.parameters) == ({"switches": {"torso": "none"}}, {})
    assert dynamic.config.controller == {"switches": {"torso": "none"}, "leg": {"D": 99.0}}
    assert (dynamic.config.parameters, dynamic.config.seed) == ({"z": 0.24}, 3)
    assert context.on(wear="ideal").wear == "ideal"
