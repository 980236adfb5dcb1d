"""Step responses of the torso to the stance ankle's pitch, measured on the emulated robot."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import msgspec
import numpy as np
from numpy.typing import NDArray

from bridge.body import Body
from bridge.body.joints import INDEX
from bridge.messages import ActuatorFrame
from bridge.rotations import pitch
from emulator.robot import EmulatedRobot
from emulator.scenarios import FLAT, Scenario
from emulator.wear import WearProfile
from nao_hil.experiments.one_leg import one_leg_stance
from walker.mechanisms.torso_control import ankle_pitch_from_lean

Vector = NDArray[np.float64]


PERIOD: Final = 8.0
"""s"""


PERIODS: Final = 2


SPREAD: Final = math.radians(0.1)
"""Standard deviation of the leg joints' operating points between seeds, rad: nobody stands twice the same."""


class Responses(msgspec.Struct, frozen=True, kw_only=True):
    """Step responses of one run, one row per step, to a step of size 1."""

    fused: Any
    """Shape (steps, samples)."""
    true: Any
    request: Any
    """The whole run: request of the AnklePitch about its operating point, as a lean, rad, shape (cycles,)."""
    angle: Any
    """The fused pitch of the same, rad."""


def run_once(
    body: Body,
    wear: WearProfile,
    seed: int,
    amplitude: float,
    engine: str = "auto",
    periods: int = PERIODS,
    floor: Scenario = FLAT,
) -> Responses | None:
    """One robot, one square wave; the first half period, which starts from rest, is left out. None: it fell."""
    random = np.random.default_rng(seed)
    stance = np.array(one_leg_stance(body))
    legs = [i for name, i in INDEX.items() if name[1:].startswith(("Hip", "Knee", "Ankle"))]
    stance[legs] += random.normal(0.0, SPREAD, len(legs))
    half = round(0.5 * PERIOD / body.cycle)
    fused, true, leans = [], [], []
    with EmulatedRobot(
        body, seed=seed, posture=stance.tolist(), wear=wear, settle=2.0, engine=engine, scenario=floor
    ) as robot:
        for k in range(2 * periods * half):
            request = stance.copy()
            lean = amplitude if (k // half) % 2 == 0 else -amplitude
            request[INDEX["LAnklePitch"]] += ankle_pitch_from_lean(lean)
            frame = robot.advance(
                ActuatorFrame(reply_to=k, position=tuple(request.tolist()), stiffness=(1.0,) * len(request))
            )
            truth = robot.truth()
            leans.append(lean)
            fused.append(frame.angle[1])
            true.append(float(pitch(truth.torso_orientation)))
            if truth.fell:
                return None
    return Responses(
        fused=part_between(fused, half, amplitude),
        true=part_between(true, half, amplitude),
        request=np.array(leans),
        angle=np.array(fused),
    )


class TorsoStepTask(msgspec.Struct, frozen=True):
    """A call of `run_once` for a worker."""

    body: Body
    wear: WearProfile
    seed: int
    amplitude: float
    engine: str


def run_task(task: TorsoStepTask) -> Responses | None:
    """One run of a task, for a worker."""
    return run_once(task.body, task.wear, task.seed, task.amplitude, task.engine)


def part_between(track: Sequence[float], half: int, amplitude: float) -> Vector:
    """Responses to the steps after the first, each from where it started, over the size of its step."""
    angle = np.array(track)
    rows = []
    for k in range(half, len(angle), half):
        step = -2.0 * amplitude if (k // half) % 2 else 2.0 * amplitude
        rows.append((angle[k : k + half] - angle[k - 50 : k].mean()) / step)
    return np.array(rows)
