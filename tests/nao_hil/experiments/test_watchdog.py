from __future__ import annotations

import msgspec

from bridge.body import load_body
from bridge.guard import GuardSettings
from emulator.wear import load_wear
from nao_hil.experiments.watchdog import LONGEST, Outage, judge, run_once

BODY = load_body("nao-v3")
OUTAGE = Outage(
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
    outage = run_once(BODY, load_wear("ideal"), "dynamic", 0, 0.4, settings, "mujoco")
    assert outage.phase in ("SSL", "SSR", "DSL", "DSR") and 2 < outage.step < 18
    assert not outage.fell and outage.taken_over
    silent = (settings.watchdog.silence_cycles + settings.watchdog.hold_cycles) * BODY.cycle
    assert silent < outage.rest < silent + 5.0


def test_the_verdict_wants_every_robot_at_rest_and_taken_over_and_lets_it_fall() -> None:
    fallen = msgspec.structs.replace(OUTAGE, fell=True, phase="SSR")
    restless = msgspec.structs.replace(OUTAGE, rest=LONGEST)
    left = msgspec.structs.replace(OUTAGE, taken_over=False)
    assert judge([OUTAGE, fallen], "dynamic").passed
    assert judge([OUTAGE, fallen], "dynamic").stood_by_phase == {"SSL": (1, 1), "SSR": (0, 1)}
    assert not judge([OUTAGE, restless], "dynamic").passed
    assert not judge([OUTAGE, left], "dynamic").passed
    assert not judge([], "dynamic").passed
