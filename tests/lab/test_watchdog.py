from __future__ import annotations

import msgspec
import pytest

pytest.importorskip("pybullet")

from bridge.datasheet import load_body
from bridge.guard import GuardSettings
from emulator.wear import load_wear
from lab.experiments.watchdog import LONGEST, Cut, judge, run_once

BODY = load_body("nao-v3")
CUT = Cut(
    gait="dynamic",
    seed=0,
    cycle=500,
    phase="SSL",
    step=5,
    fell_before=False,
    fell=False,
    rest=3.0,
    taken_over=True,
)


def test_a_dynamic_walk_cut_in_mid_step_ends_at_rest_and_goes_on_with_another_controller() -> None:
    settings = GuardSettings()
    cut = run_once(BODY, load_wear("ideal"), "dynamic", 0, 0.4, settings)
    assert cut.phase in ("SSL", "SSR", "DSL", "DSR") and 2 < cut.step < 18
    assert not cut.fell and cut.taken_over
    silent = (settings.watchdog.silence + settings.watchdog.hold) * BODY.cycle
    assert silent < cut.rest < silent + 5.0


def test_the_verdict_wants_every_robot_at_rest_and_taken_over_and_lets_it_fall() -> None:
    fallen = msgspec.structs.replace(CUT, fell=True, phase="SSR")
    restless = msgspec.structs.replace(CUT, rest=LONGEST)
    left = msgspec.structs.replace(CUT, taken_over=False)
    assert judge([CUT, fallen], "dynamic").passed
    assert judge([CUT, fallen], "dynamic").stood_by_phase == {"SSL": (1, 1), "SSR": (0, 1)}
    assert not judge([CUT, restless], "dynamic").passed
    assert not judge([CUT, left], "dynamic").passed
    assert not judge([], "dynamic").passed
