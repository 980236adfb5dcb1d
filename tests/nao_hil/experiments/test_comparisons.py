"""Verdicts of the comparing experiments: from made-up conditions, and one small campaign."""

import json
import math
import threading
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from bridge.body import load_body
from bridge.body.sole import foot_centre, sole_hull
from nao_hil.analysis.statistics import wilson
from nao_hil.campaigns.results import ask
from nao_hil.experiments import ablation, huang_margin, obstacle, torso_control
from nao_hil.experiments.catalogue import EXPERIMENTS
from nao_hil.experiments.conditions import Condition, condition, direction, falls_finding, pairs
from nao_hil.experiments.context import Context
from nao_hil.experiments.obstacle import HEIGHT, board, heights, landing_force, steps_down
from nao_hil.runs.campaign import Campaign, Interrupted
from nao_hil.runs.config import RunConfig
from nao_hil.runs.track import CHANNELS, PHASES, WIDTH, Track
from nao_hil.runs.walk import Walk, WalkEnd, WalkOutcome
from tests.made_walks import NO_TRACK, MadeCampaign, made_context, walk_end
from walker.parameters import controller_parameters
from walker.switches import Switches, differing

NOMINAL = RunConfig(wear="nominal")


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


def test_an_condition_counts_who_stands_at_a_time() -> None:
    results = [ended(0, 60.0, fell=False), ended(1, 20.0, fell=True, tilt=0.8), ended(2, 10.0, fell=True)]
    whole, by_15 = condition(results), condition(results, by=15.0)
    assert (whole.n, whole.survived, by_15.survived) == (3, 1, 2)
    assert whole.interval == wilson(1, 3)
    assert whole.fall_times == (10.0, 20.0)
    assert whole.tilt_max_deg[1] == pytest.approx(math.degrees(0.8))
    assert whole.speed == pytest.approx(0.2)


def test_conditions_are_paired_by_seed_whatever_their_order() -> None:
    with_ = [ended(seed, 60.0, fell=False) for seed in (0, 1, 2)]
    without = [ended(seed, 5.0, fell=seed != 1) for seed in (2, 1)]
    found = pairs(with_, without)
    assert (found.n, found.only_with, found.both) == (2, 1, 1)


def test_falls_are_told_by_their_way() -> None:
    assert direction(ended(0, 1.0, fell=True, roll=0.8).end) == "to the right"
    assert direction(ended(0, 1.0, fell=True, roll=0.1, pitch=-0.8).end) == "backward"
    results = [ended(seed, 10.0 + seed, fell=seed < 3, pitch=0.8) for seed in range(5)]
    text = falls_finding("With", results, None)
    assert "3 of 5 fall, at 10.0 / 11.0 / 12.0 s (first / median / last), 3 forward" in text


@pytest.mark.parametrize(("survived", "holds"), [(18, True), (17, False)])
def test_the_bound_of_the_interval_decides(survived: int, holds: bool) -> None:
    """Wilson's lower bound of 18 of 20 is 0.699, of 17 of 20 0.640; two thirds are asked."""
    claims = torso_control.torso_claims(condition_of(20, survived), condition_of(20, 20 - survived))
    assert [claim.holds for claim in claims] == [holds, holds, True]


def test_dynamic_torso_asks_for_speed() -> None:
    slow = condition_of(20, 20, speed=0.149)
    claims = torso_control.torso_claims(slow, condition_of(20, 0))
    assert [claim.holds for claim in claims] == [True, True, False]


def test_torso_drift_asks_for_growth_falls_and_survival() -> None:
    good = torso_control.drift_claims((condition_of(20, 20), condition_of(20, 0)), (0.01, 0.8))
    assert all(claim.holds for claim in good)
    bad = torso_control.drift_claims((condition_of(20, 17), condition_of(20, 3)), (0.5, 0.1))
    assert not any(claim.holds for claim in bad)


def test_the_landing_force_is_that_of_the_swing_foot_in_the_ssl_of_the_plate() -> None:
    n = 400
    rows = np.zeros((n, WIDTH), dtype=np.float32)
    starts = dict(zip(CHANNELS, np.cumsum([0, *CHANNELS.values()]), strict=False))
    rows[:, starts["time"]] = 16.0 + 0.01 * np.arange(n)
    rows[:, starts["phase"]] = PHASES.index("DSR")
    rows[0:150, starts["phase"]] = PHASES.index("SSL")
    rows[300:, starts["phase"]] = PHASES.index("SSL")
    rows[:, starts["orientation"] + 3] = 1.0
    force = starts["fsr"]
    rows[50, force + 4] = 40.0  # before the plate
    rows[120, force + 4 : force + 8] = 3.0  # the landing: four cells of 3 N
    rows[130, force] = 45.0  # the other foot
    rows[200, force + 4] = 30.0  # loading in double support
    rows[310, force + 4] = 50.0  # the next single support
    result = ended(0, 45.0, fell=False)
    assert landing_force(WalkOutcome(result.walk, result.end, Track(rows))) == pytest.approx(12.0)
    assert landing_force(result) is None


def test_a_foot_steps_down_after_two_steps_on_the_board() -> None:
    """The torso is raised by as much as the right foot, at angles of 0 in all joints."""
    body = load_body("nao-v3")
    rows = np.zeros((600, WIDTH), dtype=np.float32)
    starts = dict(zip(CHANNELS, np.cumsum([0, *CHANNELS.values()]), strict=False))
    legs = body.lengths
    straight = legs.HipOffsetZ + legs.ThighLength + legs.TibiaLength + legs.FootHeight
    rows[:, starts["time"]] = 16.0 + 0.05 * np.arange(600)
    rows[:, starts["orientation"] + 3] = 1.0
    rows[:, starts["phase"]] = [PHASES.index("SSR" if k // 100 % 2 else "SSL") for k in range(600)]
    for down in (400, 200):
        raised = np.where(np.arange(600) < down, HEIGHT, 0.0)
        rows[:, starts["torso"] + 2] = straight + raised
        result = ended(0, 45.0, fell=False)
        found = heights(WalkOutcome(result.walk, result.end, Track(rows)), body)
        assert found == pytest.approx([HEIGHT if 100 * k < down else 0.0 for k in (1, 3, 5)], abs=1e-6)
        assert steps_down(found) is (down == 400)
    assert not steps_down(found[:2])


def test_a_small_campaign_gives_the_fixed_keys_and_the_figures(tmp_path: Path) -> None:
    changes = RunConfig(engine="mujoco", wear="nominal", controller={"switches": {"torso": "none"}})
    with Campaign(cluster="inline") as campaign:
        outcome = obstacle.experiment(Context(campaign, tmp_path, (0,), changes), 3.6, 3.0)
    data = json.loads(msgspec.json.encode(outcome.result))
    assert data["name"] == "obstacle" and data["passed"] is outcome.page.passed is False
    for key in ("with", "without"):
        assert data[key]["n"] == data[key]["survived"] == 1
        assert data[key]["interval"] == list(wilson(1, 1))
    assert data["force_with"] > 0.0
    assert {p.file.name for p in outcome.page.pictures} == {f"obstacle-{n}.png" for n in ("4.1", "4.2", "4.8")}
    assert all(p.file.stat().st_size > 5000 for p in outcome.page.pictures)


def test_the_walks_of_huangs_experiment_are_kept(tmp_path: Path) -> None:
    setup = huang_margin.HuangMarginSetup(duration=0.5, step_duration=0.5)
    with Campaign(tmp_path / "walks", cluster="inline") as campaign:
        outcome = huang_margin.experiment(
            Context(campaign, tmp_path, (0,), RunConfig(engine="mujoco", wear="nominal")), setup
        )
    assert outcome.figures["margin"] > outcome.figures["margin_bad"]
    assert ask("SELECT name, count(*) FROM walks GROUP BY name ORDER BY name", tmp_path).rows == [
        (f"huang, {name}", 1) for name in ("badly chosen", "searched", "step, planned", "step, unknown")
    ]


def test_a_stop_before_each_condition_has_a_run_leaves_nothing_to_judge(tmp_path: Path) -> None:
    stop = threading.Event()
    stop.set()
    with Campaign(cluster="inline", stop=stop) as campaign, pytest.raises(Interrupted):
        obstacle.experiment(Context(campaign, tmp_path, (0,), NOMINAL))


def switches_of(conditions: dict[str, dict[str, Any]], gait: str) -> list[Switches]:
    return [controller_parameters(gait, {"switches": changes}).switches for changes in conditions.values()]


def test_compared_conditions_of_every_experiment_differ_in_one_switch() -> None:
    chains = {obstacle: ("static",), torso_control: ("static", "dynamic")}
    modules = {entry.module.partition(":")[0] for entry in EXPERIMENTS.values()}
    found_in = [import_module(f"nao_hil.experiments.{name}") for name in modules]
    assert {module for module in found_in if hasattr(module, "SWITCHES")} == set(chains)
    for module, gaits in chains.items():
        for gait in gaits:
            for one, other in pairwise(switches_of(module.SWITCHES, gait)):
                assert len(differing(one, other)) == 1, (module, gait)
    for task in ablation.TASKS:
        found = ablation.conditions(task, controller_parameters(task.gait).switches)
        by_name = {each.name: each.switches for each in found}
        assert len(by_name) == len(found)
        for each in found:
            if each.compared:
                assert len(differing(each.switches, by_name[each.compared])) == 1, each.name
        assert {task.switch, *task.suspects} <= set(Switches.__struct_fields__)


def test_conditions_that_differ_in_two_switches_are_refused(tmp_path: Path) -> None:
    context = made_context(MadeCampaign(most=3), tmp_path, (5, 6, 7))
    off = {"torso": "none", "ground_tilt": False}
    with pytest.raises(ValueError, match="differ in 2 switches: torso, ground_tilt"):
        context.run(context.walks("one", "static", 1.0), context.walks("two", "static", 1.0, off))


def test_gaits_are_compared_with_all_that_is_their_own_and_nothing_else(tmp_path: Path) -> None:
    context = made_context(MadeCampaign(most=3), tmp_path, (5,))
    one, other = context.walks("one", "omni", 1.0), context.walks("two", "huang", 1.0)
    context.run(one, other)
    with pytest.raises(ValueError, match="differ in the gait and in the controller"):
        context.run(one, context.walks("two", "huang", 1.0, {"torso": "none"}))


@pytest.mark.parametrize("seed", range(200, 220))
def test_the_board_carries_two_steps_and_no_third(seed: int) -> None:
    """Right sole's outline about its middle, landed 24, 133 and 241 mm ahead of its place at 17 s (walks on the
    bare floor with the leg admittance, seeds 2000 to 2003); the board is clear of the other foot."""
    body = load_body("nao-v3")
    outline = sole_hull(body, "R") - foot_centre(body, "R")
    ((time, plate),) = board(seed)
    low, high = (np.array(plate.shift) + sign * 0.5 * np.array(plate.size[:2]) for sign in (-1.0, 1.0))
    landed = outline + np.array([0.024, 0.0])
    assert time == 17.0 and plate.size[2] == 0.01
    assert (low <= landed).all() and (landed <= high).all()
    heel = outline[:, 0].min()
    assert low[0] < heel + 0.133 and 0.133 < high[0] < heel + 0.241
    assert high[1] <= 0.045 + 1e-9
    assert board(seed) == board(seed) != board(seed + 1)


def test_a_stop_leaves_about_as_many_runs_of_each_condition(tmp_path: Path) -> None:
    context = made_context(MadeCampaign(most=3), tmp_path, (5, 6, 7))
    one, two = context.run(*(context.walks(name, "static", 60.0) for name in ("one", "two")))
    assert ([result.seed for result in one], [result.seed for result in two]) == ([5, 6], [5])


def falling_from_the_eighth_seed(task: Walk) -> WalkEnd:
    return walk_end("fell" if task.name == "falls" and task.config.seed >= 7 else "walked")


def test_a_condition_ends_when_further_seeds_cannot_change_its_verdict(tmp_path: Path) -> None:
    """Lower bound of 19 of 20: 0.764, of 20: 0.839 (Wilson 1927). One fall decides against 0.8."""
    context = made_context(MadeCampaign(falling_from_the_eighth_seed), tmp_path, range(20))
    conditions = [context.walks(name, "static", 60.0) for name in ("stands", "falls")]
    stands, falls = context.run_until_certain(0.8, *conditions)
    assert [result.seed for result in stands] == list(range(20))
    assert [result.seed for result in falls] == list(range(10))  # two blocks of five


def test_seeds_too_few_for_any_verdict_are_all_walked(tmp_path: Path) -> None:
    """Lower bound of 2 of 2: 0.342, which never reaches 0.8."""
    context = made_context(MadeCampaign(falling_from_the_eighth_seed), tmp_path, (0, 1))
    (stands,) = context.run_until_certain(0.8, context.walks("stands", "static", 60.0))
    assert [result.seed for result in stands] == [0, 1]


def test_conditions_differ_in_their_switches_and_changes_hold_for_their_own_gait(tmp_path: Path) -> None:
    changes = RunConfig(
        gait="dynamic", controller={"switches": {"torso": "thesis"}, "leg": {"D": 99.0}}, parameters={"z": 0.24}
    )
    context = made_context(MadeCampaign(most=3), tmp_path, (0,), changes)
    static, dynamic = (
        context.config("static", 3, {"torso": "none"}),
        context.config("dynamic", 3, {"torso": "none"}),
    )
    assert (static.controller, static.parameters) == ({"switches": {"torso": "none"}}, {})
    assert dynamic.controller == {"switches": {"torso": "none"}, "leg": {"D": 99.0}}
    assert dynamic.parameters == {"z": 0.24}
    assert context.on("ideal").wear == "ideal"
