"""Step responses of the torso on one leg to the stance ankle's pitch, and the fit of a plant to them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Final

import msgspec
import numpy as np
from scipy.optimize import least_squares

from bridge.body import Body
from bridge.body.joints import INDEX
from bridge.body.kinematics import CentreOfMass
from bridge.body.postures import POSTURES
from bridge.errors import ConfigurationError
from bridge.messages import ActuatorFrame
from bridge.rotations import pitch
from bridge.types import Array
from emulator.robot import EmulatedRobot
from emulator.scenarios import FLAT, Scenario
from emulator.wear import WearProfile
from walker.mechanisms.torso_control import ankle_pitch_from_lean

DRAWN_UP: Final = {"RHipRoll": -0.3, "RHipPitch": -0.8, "RKneePitch": 1.6, "RAnklePitch": -0.8}
"""The right leg, rad: its sole is 6 cm over the ground, and the foot clear of the standing leg."""
TOLERANCE: Final = 1e-4
"""Largest distance of the centre of mass from the foot's middle, m."""
STARTS: Final = ((5.0, 0.02), (7.0, 0.1), (9.0, 0.05))
"""Natural frequencies and zeros from which the fit is started; the best end counts."""
PERIOD: Final = 8.0
"""Period of the square wave, s."""
PERIODS: Final = 2
SPREAD: Final = math.radians(0.1)
"""Standard deviation of the leg joints' operating points between seeds, rad."""


def _posture(lean: float, tilt: float) -> list[float]:
    """The posture with the standing leg leaning forward and outward by two angles, torso upright."""
    angles = list(POSTURES["StandInit"])
    legs = dict.fromkeys((name for name in INDEX if name[1:].startswith(("Hip", "Knee", "Ankle"))), 0.0)
    legs |= DRAWN_UP
    legs |= {"LAnklePitch": -lean, "LHipPitch": lean, "LAnkleRoll": tilt, "LHipRoll": -tilt}
    for name, angle in legs.items():
        angles[INDEX[name]] = angle
    return angles


def one_leg_stance(body: Body) -> tuple[float, ...]:
    """25 joint angles in frame order, rad: torso upright, centre of mass over the middle of the left foot.

    Raises:
        ConfigurationError: the body cannot stand so within its joint ranges.
    """
    com = CentreOfMass(body)
    middle = np.array(body.foot.centre)

    def miss(leans: Array) -> Array:
        angles = _posture(*leans.tolist())
        foot = com.tree.link_frames(angles)["LAnkleRoll"]
        in_foot = np.linalg.solve(foot, np.append(com(angles), 1.0))
        off: Array = in_foot[:2] - middle
        return off

    leans = least_squares(miss, (0.0, 0.2)).x
    angles = _posture(*leans.tolist())
    inside = all(
        sheet.lower <= angles[INDEX[n]] <= sheet.upper for n, sheet in body.joints.items() if n in INDEX
    )
    if not inside or float(np.linalg.norm(miss(leans))) > TOLERANCE:
        raise ConfigurationError(f"{body.name} cannot stand on its left leg with the right one drawn up.")
    return tuple(angles)


class Plant(msgspec.Struct, frozen=True, kw_only=True):
    """gain (1 - zero_time s) / (s^2 / w^2 + 2 damping s / w + 1), w the natural frequency."""

    gain: float
    natural_frequency_rad_s: float
    damping: float
    zero_time_s: float
    """Positive: a right-half-plane zero at 1 / zero_time."""

    def step(self, time: Array) -> Array:
        """Response to a unit step at time 0, in closed form."""
        w, d = self.natural_frequency_rad_s, self.damping
        t = np.maximum(time, 0.0)
        ring = w * np.sqrt(1.0 - d * d)
        decay = np.exp(-d * w * t)
        rest = decay * (np.cos(ring * t) + d * w / ring * np.sin(ring * t))
        impulse = w * w / ring * decay * np.sin(ring * t)
        return np.asarray(np.where(time > 0.0, self.gain * (1.0 - rest - self.zero_time_s * impulse), 0.0))


THESIS: Final = Plant(
    gain=1.0, natural_frequency_rad_s=0.02041**-0.5, damping=0.5 * 0.02857 * 0.02041**-0.5, zero_time_s=0.125
)
"""(4.12)"""


class Shape(msgspec.Struct, frozen=True, kw_only=True):
    """Features of a step response, as shares of its final value."""

    final: float
    """Mean of the last second."""
    peak: float
    undershoot: float
    """Lowest value before the rise, negative."""
    rise_time_s: float
    """From 10 to 90 % of the final value."""


def fit_plant(time: Array, response: Array) -> tuple[Plant, float]:
    """The plant with the least squared error, and the root mean square of its residual.

    Args:
        time: After the step, s, shape (n,).
        response: To a step of size 1, shape (n,).
    """

    def plant(values: Array) -> Plant:
        gain, frequency, damping, zero = values.tolist()
        return Plant(gain=gain, natural_frequency_rad_s=frequency, damping=damping, zero_time_s=zero)

    fits = [
        least_squares(
            lambda values: plant(values).step(time) - response,
            (response[-1], frequency, 0.15, zero),
            bounds=((-10.0, 1.0, 0.005, -1.0), (10.0, 30.0, 0.95, 1.0)),
        )
        for frequency, zero in STARTS
    ]
    best = min(fits, key=lambda fit: float(fit.cost))
    return plant(best.x), float(np.sqrt(np.mean(best.fun**2)))


def read_shape(time: Array, response: Array) -> Shape:
    """Peak, undershoot and rise of a step response; arguments as in `fit_plant`."""
    final = float(response[time > time[-1] - 1.0].mean())
    share = response / final
    low = int(np.argmax(share >= 0.1))
    high = int(np.argmax(share >= 0.9))

    def crossing(level: float, k: int) -> float:
        if k == 0:
            return float(time[0])
        return float(np.interp(level, share[k - 1 : k + 1], time[k - 1 : k + 1]))

    return Shape(
        final=final,
        peak=float(share.max()),
        undershoot=min(0.0, float(share[: low + 1].min())),
        rise_time_s=crossing(0.9, high) - crossing(0.1, low),
    )


class Responses(msgspec.Struct, frozen=True, kw_only=True):
    """Step responses of one run, one row per step, to a step of size 1."""

    fused: Any
    """Shape (steps, samples)."""
    true: Any
    request: Any
    """The whole run: request of the AnklePitch about its operating point, as a lean, rad, shape (cycles,)."""
    angle: Any
    """The fused pitch of the same, rad."""


class TorsoStepTask(msgspec.Struct, frozen=True, kw_only=True):
    """One robot, one square wave, for a worker."""

    body: Body
    wear: WearProfile
    seed: int
    engine: str
    amplitude: float
    """Amplitude of the square wave, rad."""
    floor: Scenario = FLAT


def run_once(task: TorsoStepTask) -> Responses | None:
    """The responses; the first half period, which starts from rest, is left out. None: the robot fell."""
    body, amplitude = task.body, task.amplitude
    random = np.random.default_rng(task.seed)
    stance = np.array(one_leg_stance(body))
    legs = [i for name, i in INDEX.items() if name[1:].startswith(("Hip", "Knee", "Ankle"))]
    stance[legs] += random.normal(0.0, SPREAD, len(legs))
    half = round(0.5 * PERIOD / body.cycle)
    fused, true, leans = [], [], []
    with EmulatedRobot(
        body,
        seed=task.seed,
        posture=stance.tolist(),
        wear=task.wear,
        settle=2.0,
        engine=task.engine,
        scenario=task.floor,
    ) as robot:
        for k in range(2 * PERIODS * half):
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


def part_between(track: Sequence[float], half: int, amplitude: float) -> Array:
    """Responses to the steps after the first, each from where it started, over the size of its step."""
    angle = np.array(track)
    rows = []
    for k in range(half, len(angle), half):
        step = -2.0 * amplitude if (k // half) % 2 else 2.0 * amplitude
        rows.append((angle[k : k + half] - angle[k - 50 : k].mean()) / step)
    return np.array(rows)
