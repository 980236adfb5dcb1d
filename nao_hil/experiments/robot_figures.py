"""Measurements of real robots that the emulated one can repeat, each with the real figure.

A figure counts only measured as its source did: the same robot generation, the same floor, the same
definition. The bounds are tolerances, stated before the robot is calibrated: the source's own scatter where it
gives one, else an allowance for its conditions (another team's walk, another floor).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final, NamedTuple

import msgspec
import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX
from bridge.body.postures import POSTURES
from bridge.body.quantities import total_mass
from bridge.messages import ActuatorFrame, SensorFrame
from bridge.types import Array
from emulator.poses import quaternion
from emulator.robot import EmulatedRobot
from emulator.scenarios import Scenario
from emulator.scenarios.ground import ScenarioFloor
from emulator.wear import WearProfile
from nao_hil.identification.measures import vertex
from nao_hil.runs.config import run_config
from nao_hil.runs.walk import Walk, walk

STANDARD_GRAVITY: Final = 9.81


class Figure(NamedTuple):
    """A figure of a real robot."""

    words: str
    unit: str
    real: float
    low: float
    high: float
    source: str
    """Who measured it, how, on which robot."""

    def holds(self, value: float) -> bool:
        """The value counts as the real robot's."""
        return self.low <= value <= self.high


_TRACKING: Final = (
    "B-Human's reference for a good robot: mean of |measured - requested 3 frames before| in a walk at 0.20 to "
    "0.25 m/s, V6, 12 ms; another team's walk, hence within 30 %"
)
_KNEE: Final = (
    "nine holds of a seated V5's knee, thigh level, torso 0.5 rad back, raised from 68 deg to -5.3 deg; within "
    "two standard deviations"
)
_CELLS: Final = "recording of a V5 or V6 that stands and walks; both feet"
_GENERATION_3: Final = "recording of a V3 of 2009 that stands; both legs, one posture"
FIGURES: Final = {
    "tracking.hip_pitch": Figure("Tracking error, hip pitch", "deg", 1.4, 0.98, 1.82, _TRACKING),
    "tracking.knee_pitch": Figure("Tracking error, knee pitch", "deg", 1.4, 0.98, 1.82, _TRACKING),
    "tracking.ankle_pitch": Figure("Tracking error, ankle pitch", "deg", 1.0, 0.70, 1.30, _TRACKING),
    "tracking.shift": Figure("Shift of least tracking error", "frames", 3.0, 2.5, 3.5, _TRACKING),
    "knee_hold.knee_pitch": Figure("Knee held out, error", "deg", 0.76, 0.48, 1.04, _KNEE),
    "imu_noise.gyroscope": Figure(
        "Gyroscope noise at rest", "rad/s", 0.0033, 0.0027, 0.0040, "recordings of an H25 and a V6 at rest"
    ),
    "imu_noise.accelerometer": Figure(
        "Accelerometer noise at rest", "m/s^2", 0.05, 0.04, 0.06, "recording of an H25 at rest"
    ),
    "imu_noise.encoders": Figure(
        "Leg and condition joints whose reading changes at rest", "", 0.92, 0.60, 1.0, "V6, 22 of 24 joints"
    ),
    "force_cells.noise": Figure("Noise of one foot's force sum", "N", 0.46, 0.30, 0.62, _CELLS),
    "force_cells.sum": Figure("Force sum standing over weight", "", 0.83, 0.70, 1.30, _CELLS),
    "force_cells.walking_sd": Figure("Force sum walking, standard deviation", "N", 13.5, 9.0, 18.0, _CELLS),
    "currents.knee": Figure("Knee current standing", "mA", 250.0, 150.0, 375.0, _GENERATION_3),
    "currents.ankle": Figure("Ankle pitch current standing", "mA", 312.0, 150.0, 470.0, _GENERATION_3),
}
"""By experiment and quantity."""
JOINTS: Final = ("HipPitch", "KneePitch", "AnklePitch")
SHIFTS: Final = range(8)
"""Frames by which requests are compared with later measurements."""
FRAMES: Final = 3
"""The shift of B-Human's reference."""


class Tracking(NamedTuple):
    """Tracking errors of a walk."""

    error: dict[str, float]
    """By joint of `JOINTS`, at the reference's shift, mean of both legs, rad."""
    best: dict[str, float]
    """Shift of the least error, frames; between whole ones by a parabola."""

    def figures(self) -> dict[str, float]:
        """By the names of `FIGURES`."""
        names = ("hip_pitch", "knee_pitch", "ankle_pitch")
        degrees = {
            f"tracking.{name}": math.degrees(self.error[joint])
            for name, joint in zip(names, JOINTS, strict=True)
        }
        return degrees | {"tracking.shift": float(np.mean(list(self.best.values())))}


def tracking(
    body: Body,
    wear: WearProfile,
    seed: int,
    engine: str,
    surface: str = "turf",
    velocity: float = 0.22,
    duration: float = 8.0,
) -> Tracking | None:
    """Errors of the pitch joints in a walk of `omni`; None: it fell.

    Args:
        body: Of the robot; the reference's is a V6.
        wear: Of its drives and sensors.
        seed: Of the run.
        engine: Name of the physics engine.
        surface: Of the floor; teams walk on turf.
        velocity: Ahead, m/s.
        duration: Of the walk, s.
    """
    config = run_config(None, robot=body.name, gait="omni", seed=seed, engine=engine)
    config = msgspec.structs.replace(config, velocity=(velocity, 0.0, 0.0))
    floor = Scenario(floor=ScenarioFloor(surface=surface))  # type: ignore[arg-type]
    outcome = walk(
        Walk(name="tracking", config=config, duration=duration, scenario=floor, body=body, wear=wear)
    )
    if not outcome.end.survived:
        return None
    track = outcome.track
    walking = track["time"] > 2.0
    request, joints = track["actuators.position"][walking], track["world/truth.joints"][walking]
    return tracking_errors({n: [INDEX[s + n] for s in "LR"] for n in JOINTS}, request, joints, len(SHIFTS))


def tracking_errors(
    columns: dict[str, list[int]], request: Array, joints: Array, shifts: int = len(SHIFTS)
) -> Tracking:
    """Mean absolute differences of measurement and earlier request.

    Args:
        columns: Of each joint, both sides.
        request: Requested in answer to each frame, (n, joints), rad.
        joints: Measured in each frame, (n, joints), rad.
        shifts: Frames of the longest shift, plus one.
    """
    error, best = {}, {}
    for name, both in columns.items():
        by_shift = np.array(
            [
                np.mean(np.abs(joints[shifts:, both] - request[shifts - k : len(request) - k, both]))
                for k in range(shifts)
            ]
        )
        error[name] = float(by_shift[FRAMES])
        best[name] = vertex(by_shift, int(by_shift.argmin()))
    return Tracking(error, best)


def knee_hold(body: Body, wear: WearProfile, engine: str, seed: int = 0) -> float:
    """Steady error of a knee that holds its leg out, mean of both legs, rad.

    The torso is fixed, 0.5 rad back; the thighs are level, the shanks hang at 68 degrees and are raised to
    -5.3.
    """
    lean, out, bent = 0.5, math.radians(-5.3), math.radians(68.0)
    posture = list(POSTURES["StandZero"])
    for side in "LR":
        posture[INDEX[f"{side}HipPitch"]] = -(0.5 * math.pi - lean)
        posture[INDEX[f"{side}KneePitch"]] = bent
    held = list(posture)
    for side in "LR":
        held[INDEX[f"{side}KneePitch"]] = out
    orientation = quaternion(0.0, -lean, 0.0)
    with EmulatedRobot(
        body, seed=seed, posture=posture, wear=wear, engine=engine, settle=0.5, lift=1.0, held=True,
        orientation=orientation,
    ) as robot:  # fmt: skip
        frames = play(robot, [held] * round(2.0 / body.cycle))
    tail = frames[-round(0.5 / body.cycle) :]
    errors = [
        held[INDEX[f"{side}KneePitch"]] - frame.position[INDEX[f"{side}KneePitch"]]
        for side in "LR"
        for frame in tail
    ]
    return abs(float(np.mean(errors)))


def play(robot: EmulatedRobot, requests: Sequence[Sequence[float]]) -> list[SensorFrame]:
    """Frames of a robot that is asked for postures, one a cycle, with full stiffness."""
    return [
        robot.advance(ActuatorFrame(reply_to=k, position=tuple(request), stiffness=(1.0,) * len(request)))
        for k, request in enumerate(requests)
    ]


STANDING: Final = {"HipPitch": -0.308, "KneePitch": 0.864, "AnklePitch": -0.549}
"""Standing posture of the V3 of 2009, rad."""


def standing(body: Body, wear: WearProfile, seed: int, engine: str, duration: float = 5.0) -> dict[str, float]:
    """Forces and currents of a robot at rest, by the names of `FIGURES`."""
    posture = list(POSTURES["StandInit"])
    for side in "LR":
        for joint, angle in STANDING.items():
            posture[INDEX[f"{side}{joint}"]] = angle
        for joint in ("HipRoll", "AnkleRoll"):
            posture[INDEX[f"{side}{joint}"]] = 0.0
    with EmulatedRobot(body, seed=seed, posture=posture, wear=wear, engine=engine, settle=1.0) as robot:
        frames = play(robot, [posture] * round(duration / body.cycle))
        weight = STANDARD_GRAVITY * total_mass(body)
    forces = np.array([frame.fsr for frame in frames])
    feet = forces[:, :4].sum(axis=1), forces[:, 4:].sum(axis=1)
    current = np.mean([frame.current for frame in frames], axis=0)
    both = {joint: 500.0 * (current[INDEX[f"L{joint}"]] + current[INDEX[f"R{joint}"]]) for joint in JOINTS}
    return {
        "force_cells.noise": float(np.mean([np.diff(foot).std() / math.sqrt(2.0) for foot in feet])),
        "force_cells.sum": float(forces.sum(axis=1).mean() / weight),
        "currents.knee": float(both["KneePitch"]),
        "currents.ankle": float(both["AnklePitch"]),
    }


def noise_at_rest(
    body: Body, wear: WearProfile, seed: int, engine: str, duration: float = 5.0
) -> dict[str, float]:
    """Noise of the sensors of a robot whose torso is held, by the names of `FIGURES`."""
    posture = POSTURES["StandInit"]
    with EmulatedRobot(
        body, seed=seed, posture=posture, wear=wear, engine=engine, settle=1.0, lift=1.0, held=True
    ) as robot:
        frames = play(robot, [posture] * round(duration / body.cycle))
    gyroscope = np.array([frame.gyroscope[:2] for frame in frames])
    accelerometer = np.array([frame.accelerometer for frame in frames])
    angles = np.array([frame.position for frame in frames])
    joints = [INDEX[name] for name in body.joints if name in INDEX and "Hand" not in name]
    return {
        "imu_noise.gyroscope": float(gyroscope.std(axis=0).mean()),
        "imu_noise.accelerometer": float(accelerometer.std(axis=0).mean()),
        "imu_noise.encoders": float(np.mean(np.ptp(angles[:, joints], axis=0) > 0.0)),
    }
