"""The table of both engines: intervals and verdicts from known numbers, rows from a made-up campaign."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from nao_hil.analysis.statistics import mean_of
from nao_hil.experiments.engines import (
    ENGINES_COMPARED,
    compared_walks,
    count_row,
    paired_row,
    row_claims,
)
from nao_hil.experiments.get_up import Course, Drop
from nao_hil.experiments.obstacle import board
from nao_hil.experiments.servo_bench import Drive
from nao_hil.experiments.torso_responses import THESIS, Responses
from nao_hil.runs.config import RunConfig
from nao_hil.runs.walk import Walk, WalkEnd
from tests.made_walks import MadeCampaign, made_context, walk_end
from walker.switches import NAMED


def by_seed(values: Sequence[float]) -> dict[int, float]:
    return dict(enumerate(values))


def test_a_ratio_agrees_by_the_bounds_of_its_interval() -> None:
    one = by_seed([1.0, 2.0, 4.0])
    near = paired_row("speed", one, by_seed([1.02, 2.04, 4.08]), 0.05)
    assert near.agree and near.ratio is not None and near.ratio.value == pytest.approx(1.02)
    scattered = paired_row("speed", one, by_seed([1.02, 2.2, 3.76]), 0.05)  # mean ratio 1.02, to 0.78 and 1.25
    assert scattered.agree is False
    assert paired_row("speed", one, by_seed([1.02, 2.2, 3.76])).agree is None


def test_a_mean_is_over_the_seeds_of_both_engines_and_one_of_them_decides_nothing() -> None:
    row = paired_row("speed", {0: 1.0, 1: 9.0}, {0: 1.0, 2: 9.0}, 0.1)
    assert (row.pybullet, row.mujoco, row.agree) == (mean_of([1.0]), mean_of([1.0]), False)
    nobody = paired_row("speed", {}, {0: 1.0}, 0.1)
    assert (nobody.ratio, nobody.agree, nobody.pybullet.words()) == (None, False, "none")


@pytest.mark.parametrize(("stood", "agree"), [(15, True), (11, False)])
def test_counts_agree_when_wilsons_intervals_overlap(stood: int, agree: bool) -> None:
    """20 of 20: from 83.9 % on; 15 of 20: to 88.8 %, 11 of 20: to 74.2 %."""
    row = count_row("walk on", [True] * 20, [True] * stood + [False] * (20 - stood))
    assert row.agree is agree
    assert row_claims([row])[0].holds is agree


def end_on_an_engine(task: Walk) -> WalkEnd:
    falls = task.name.startswith("R2, without") and task.config.engine == "mujoco"
    return walk_end(
        "fell" if falls else "walked", task.duration, distance=task.duration * (0.1 + 0.001 * task.config.seed)
    )


class MadeUp(MadeCampaign):
    """A campaign in which walks of R2 without torso control fall on MuJoCo, and no other does.

    Torso steps are the thesis' plant on both engines; MuJoCo's drives are 1 % faster, the last one 3 %.
    """

    def map(self, name: str, function: Callable[[Any], Any], arguments: Sequence[Any]) -> list[Any]:
        make = {"torso-step": self._response, "drives": self._drives, "get-up": self._course}[name]
        return [make(argument) for argument in arguments]

    def _response(self, task: Any) -> Responses:
        response = THESIS.step(np.arange(0.01, 4.005, 0.01))[None, :]
        return Responses(fused=response, true=response, request=None, angle=None)

    def _drives(self, task: tuple[str, str, str]) -> list[Drive]:
        faster = (1.0, 1.0) if task[2] == "pybullet" else (1.01, 1.03)
        fields = {name: 0.5 for name in Drive.__struct_fields__}
        return [
            Drive(**fields | {"joint": joint, "no_load_speed": 5.0 * f})  # type: ignore[arg-type]
            for joint, f in zip(("LKneePitch", "RKneePitch"), faster, strict=True)
        ]

    def _course(self, config: RunConfig) -> Course:
        drop = Drop(
            seed=config.seed,
            began="back" if config.seed % 2 else "front",
            tries=1,
            stands=True,
            time=6.0,
            temperature=30.0,
            current=0.5,
            overlap=0.0,
        )
        return Course(drop, *np.zeros((3, 1)))


def test_the_result_is_one_table_of_figures_on_both_engines(tmp_path: Path) -> None:
    pytest.importorskip("pybullet")
    context = made_context(MadeUp(end_on_an_engine), tmp_path, range(20))
    outcome = ENGINES_COMPARED.run("engines", context)
    written = json.loads(msgspec.json.encode(outcome.result))
    assert set(written) == {"name", "passed", "rows"}
    rows = {row["figure"]: row for row in written["rows"]}
    assert all({"pybullet", "mujoco"} <= set(row) for row in rows.values())
    differ = [figure for figure, row in rows.items() if row["agree"] is False]
    assert differ == ["R2, without torso control, 60 s: walk on"]
    assert not written["passed"] and [claim.holds for claim in outcome.page.claims].count(False) == 1
    assert (rows[differ[0]]["pybullet"]["survived"], rows[differ[0]]["mujoco"]["survived"]) == (20, 0)
    speed = rows["static gait, 20 s: speed over ground, m/s"]
    assert speed["pybullet"] == speed["mujoco"] and speed["pybullet"]["value"] == pytest.approx(0.1095)
    assert rows["torso step: natural frequency, rad/s"]["mujoco"]["value"] == pytest.approx(7.0, rel=0.02)
    assert (
        rows["leg drives: no-load speed, rad/s, of RKneePitch, which differs most"]["mujoco"]["value"] == 5.15
    )
    assert rows["get-up from the front: median time, s"]["pybullet"] == {
        "value": 6.0,
        "interval": [6.0, 6.0],
        "n": 10,
    }
    table = outcome.page.tables[0]
    assert len(table.rows) == len(rows) and all(len(row) == len(table.head) for row in table.rows)


def test_both_engines_walk_the_conditions_of_the_experiments() -> None:
    """R1 with its board, R2 and R5, each with its own switches."""
    walks = compared_walks()
    assert [walk.name.split(",")[0] for walk in walks[3:]] == ["omni gait"] + 2 * ["R1"] + 2 * ["R2"] + 2 * [
        "R5"
    ]
    assert [walk.task.by_seed for walk in walks[4:6]] == [board, board]
    thesis = msgspec.to_builtins(NAMED["thesis"])
    assert all(walk.changes == {"controller.switches": thesis} for walk in (walks[6], walks[8]))
