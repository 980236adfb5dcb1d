"""A motion that identifies the drives: slow triangles across the load's change of sign, then steps.

One joint of a limb moves at a time, the same one on both sides; limbs move together. A triangle shows backlash
and friction as hysteresis, and stiffness by the slope of the lag over the load; steps show delay and the
motor's speed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Final, NamedTuple

import msgspec
import numpy as np

from bridge.body import Body, body_of
from bridge.body.joints import INDEX, JOINTS
from bridge.body.quantities import absent_joints, joint_no_load_speed, limits
from bridge.errors import ConfigurationError
from bridge.guard import Guard
from bridge.recording.recorder import Recorder
from bridge.types import Array
from bridge.validation import unknown_name
from emulator.start import STAND
from nao_hil.arguments import actuator_frame
from nao_hil.connection import Connection
from nao_hil.identification.comparison_run import HANG
from nao_hil.runs.build import build_robot
from nao_hil.runs.capture import described
from nao_hil.runs.config import RunConfig

SHORTEST: Final = 60.0
"""Duration of the shortest motion, s."""
_BLOCK: Final = 20.0
"""Time that a joint is given at a stretch, about, s."""
_CHANGE: Final = 2.5
"""Time between two poses, s; the longest way is 1.6 rad."""
_STEPS: Final = 0.3
"""Share of a joint's time in steps."""
_HEIGHT: Final = (0.04, 0.8)
"""Half height of a step at most, rad, and as a fraction of the way without load in a cycle: the guard lets
through steps of twice that way."""
_HOLD: Final = (0.25, 0.4, 0.6, 0.3, 0.5)
"""Times between steps, s, again and again."""
_SPEED: Final = 0.25
"""Speed of a triangle with more than one period, at most, rad/s."""
Progress = Callable[[float], None]


class _Part(NamedTuple):
    """One joint's turn in a limb."""

    joint: str
    """Without its side."""
    lower: float
    """Ends of the triangle, rad; of the left side."""
    upper: float
    pose: Mapping[str, float] = {}
    """Pose of the limb meanwhile, rad, left side; the rest as in `_REST`."""


_REST: Final = {"ShoulderPitch": 1.5, "ShoulderRoll": 0.25, "ElbowRoll": -0.3, "HipRoll": 0.08}
"""Arms down, legs apart; all other joints at 0. Left side."""
_AHEAD: Final = {"ShoulderPitch": 0.0, "ShoulderRoll": 0.3}
"""Arms ahead: the axes of ShoulderRoll and ElbowRoll are upright, and friction is the only load."""
_LEG: Final = (
    _Part("HipPitch", -1.0, 0.35),
    # the thigh ahead, so that the shank hangs plumb in the middle of the way
    _Part("KneePitch", 0.05, 1.2, {"HipPitch": -0.6}),
    _Part("AnklePitch", -0.45, 0.45),
    _Part("AnkleRoll", -0.3, 0.3),
    _Part("HipRoll", -0.2, 0.36),
    _Part("HipYawPitch", -0.5, 0.2, {"HipRoll": 0.15}),
)
_ARM: Final = (
    _Part("ShoulderPitch", 0.7, 1.9),
    _Part("ShoulderRoll", 0.15, 0.9, _AHEAD),
    _Part("ElbowRoll", -1.1, -0.2, _AHEAD),
    _Part("ElbowYaw", -0.6, 0.6),
    _Part("WristYaw", -0.6, 0.6),
)
_HEAD: Final = (_Part("HeadPitch", -0.55, 0.4), _Part("HeadYaw", -0.6, 0.6))
_MIRRORED: Final = ("ShoulderRoll", "ElbowYaw", "ElbowRoll", "WristYaw", "HipRoll", "AnkleRoll")
"""Joints whose right side has the opposite sign. Their triangles have not: the legs swing to the same side, so
that they keep their distance."""


def excitation(body: Body, start: Sequence[float], duration: float, *, hanging: bool) -> Array:
    """Commands of the motion, one row per cycle.

    Args:
        body: Data sheet.
        start: Measured angles, (25,), rad; the motion begins and ends there.
        duration: s, at least `SHORTEST`.
        hanging: The legs move too; otherwise they stay as they are.

    Returns:
        (n, 25), rad, within the joints' ranges.
    """
    limbs = [_limb(_HEAD, ""), *(_limb(_ARM, side) for side in "LR")]
    if hanging:
        limbs += [_limb(_LEG, side) for side in "LR"]
    absent = absent_joints(body)
    count = round(duration / body.cycle)
    commands = np.tile(np.asarray(start, dtype=np.float64), (count, 1))
    for parts in limbs:
        _fill(commands, [part for part in parts if part.joint not in absent], body)
    for number, joint in enumerate(JOINTS):
        if joint not in absent:
            lower, upper = limits(body, joint)
            commands[:, number] = np.clip(commands[:, number], lower, upper)
    return commands


def _limb(parts: Sequence[_Part], side: str) -> list[_Part]:
    """The parts of one side, each with the whole pose of the limb."""
    rest = {part.joint: _REST.get(part.joint, 0.0) for part in parts}
    turned = []
    for part in parts:
        lower, upper = part.lower, part.upper
        if side == "R" and part.joint in _MIRRORED:
            lower, upper = -upper, -lower
        pose = {
            side + name: -value if side == "R" and name in _MIRRORED else value
            for name, value in (rest | dict(part.pose)).items()
        }
        turned.append(_Part(side + part.joint, lower, upper, pose))
    return turned


def _fill(commands: Array, parts: Sequence[_Part], body: Body) -> None:
    """Write a limb's motion into its columns; the turn of a joint without one is a pause."""
    joints = [part.joint for part in parts if part.joint in INDEX]
    columns = [INDEX[joint] for joint in joints]
    cycle = body.cycle
    count, change = len(commands), round(_CHANGE / cycle)
    turns = len(parts) * max(1, round(count * cycle / (_BLOCK * len(parts))))
    block = (count - change) // turns
    start, now = commands[0, columns].copy(), commands[0, columns].copy()
    for turn in range(turns):
        part, row = parts[turn % len(parts)], turn * block
        # every second time the other way round: no joint always begins on the same side of its backlash
        low, high = (part.lower, part.upper) if turn // len(parts) % 2 == 0 else (part.upper, part.lower)
        goal = np.array([part.pose[joint] for joint in joints])
        if part.joint in joints:
            goal[joints.index(part.joint)] = 0.5 * (low + high)
        commands[row : row + change, columns] = _blend(now, goal, change)
        commands[row + change : row + block, columns] = goal
        if part.joint in joints:
            height = min(_HEIGHT[0], _HEIGHT[1] * joint_no_load_speed(body, part.joint) * cycle)
            way = _way(low, high, block - change, height, cycle)
            commands[row + change : row + block, INDEX[part.joint]] = way
        now = commands[row + block - 1, columns].copy()
    commands[turns * block :, columns] = start
    commands[turns * block : turns * block + change, columns] = _blend(now, start, change)


def _blend(begin: Array, end: Array, count: int) -> Array:
    """From one pose to another, at rest at both, (count, joints)."""
    share = 0.5 - 0.5 * np.cos(np.pi * np.arange(1, count + 1) / count)
    return np.asarray(begin + share[:, None] * (end - begin))


def _way(low: float, high: float, count: int, height: float, cycle: float) -> Array:
    """Triangle from the middle to both ends and back, then steps about the middle and a place under load."""
    steps = round(_STEPS * count)
    slow = count - steps
    periods = max(1, math.floor(slow * cycle * _SPEED / (2.0 * abs(high - low))))
    phase = np.arange(1, slow + 1) / slow * min(periods, 3)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    triangle = middle + half * (2.0 / np.pi) * np.arcsin(np.sin(2.0 * np.pi * phase))
    return np.concatenate([triangle, _steps(middle, half, steps, height, cycle)])


def _steps(middle: float, half: float, count: int, height: float, cycle: float) -> Array:
    """A square wave of uneven periods: about the middle, then under load, with a ramp between."""
    ends = np.cumsum(np.tile(_HOLD, 1 + count)[: count + 1])
    time = np.arange(count) * cycle
    wave = np.where(np.searchsorted(ends, time, side="right") % 2 == 0, height, -height)
    ramp = np.clip((time - 0.45 * time[-1]) / (0.1 * time[-1]), 0.0, 1.0)
    wave = np.where((ramp > 0.0) & (ramp < 1.0), 0.0, wave)
    wave[-round(0.3 / cycle) :] = 0.0
    return np.asarray(middle + 0.5 * half * ramp + wave)


class ExcitationResult(msgspec.Struct, frozen=True, kw_only=True):
    """The JSON of `nao-hil excite`."""

    recording: str
    robot: str
    seconds: float
    cycles: int
    cycles_left_out: int
    """Unanswered cycles of a robot in real time."""
    clipped: int | None
    """Commands that the guard had to change: none; None: not known of a robot on the link."""
    seed: int | None
    """Seed of the emulated robot; None: a robot on the link."""


def check_start(start: str, duration: float) -> None:
    """Whether there is a motion of this kind.

    Raises:
        ConfigurationError: another start, or too short for every joint to move.
    """
    if start not in (HANG, STAND):
        raise ConfigurationError(unknown_name("start", start, (HANG, STAND)))
    if not (math.isfinite(duration) and duration >= SHORTEST):
        raise ConfigurationError(f"--duration {duration:g}: the motion takes {SHORTEST:g} s at least.")


def excite_emulated(
    settings: RunConfig, duration: float, file: Path, progress: Progress = lambda _: None
) -> ExcitationResult:
    """Move an emulated robot in this process, behind its guard.

    Args:
        settings: Body, wear, engine, scenario, start and seed.
        duration: s
        file: Recording to write.
        progress: Called with the share that is done.

    Raises:
        ConfigurationError: no such body, wear profile, scenario or start, or too short a duration.
    """
    check_start(settings.start, duration)
    clipped = 0
    with build_robot(settings) as robot, Recorder(file, settings) as recorder:
        guard = Guard(robot.body, settings.guard)
        hanging = settings.start == HANG
        commands = excitation(robot.body, robot.frame.position, duration, hanging=hanging)
        for number, position in enumerate(commands):
            recorder.sensors(robot.frame, robot.truth())
            wanted = actuator_frame(robot.seq, position, 1.0)
            command = guard.cycle(robot.frame, guard.check(wanted, robot.seq))
            if command is None or command.position != wanted.position:
                clipped += 1
            for notice in guard.take_notices():
                recorder.message(notice)
            if command is not None:
                recorder.command(command)
            robot.advance(command)
            progress((number + 1) / len(commands))
        recorder.sensors(robot.frame, robot.truth())
    return ExcitationResult(
        recording=str(file),
        robot=robot.body.name,
        seconds=robot.time,
        cycles=len(commands),
        cycles_left_out=0,
        clipped=clipped,
        seed=settings.seed,
    )


def excite_linked(
    connection: Connection, start: str, duration: float, file: Path, progress: Progress = lambda _: None
) -> ExcitationResult:
    """Move a robot on the link from its present posture; changes by its guard are not recorded.

    Args:
        connection: To the robot; holds the lease.
        start: `hang`: the legs move too.
        duration: s
        file: Recording to write.
        progress: Called with the share that is done.

    Raises:
        ConfigurationError: too short a duration.
        LinkError: the robot went away, or its guard took it.
    """
    check_start(start, duration)
    body, frame = body_of(connection.info.body, connection.info.sheet), connection.frame
    commands = excitation(body, frame.position, duration, hanging=start == HANG)
    first, answered = frame.seq, 0
    with Recorder(file, described(connection.info) | {"start": start}) as recorder:
        while frame.seq - first < len(commands):
            recorder.write(frame)
            position = commands[frame.seq - first]
            recorder.write(actuator_frame(frame.seq, position, 1.0))
            frame = connection.step(position, 1.0)
            answered += 1
            progress((frame.seq - first) / len(commands))
        recorder.write(frame)
    return ExcitationResult(
        recording=str(file),
        robot=body.name,
        seconds=(frame.seq - first) * body.cycle,
        cycles=len(commands),
        cycles_left_out=len(commands) - answered,
        clipped=None,
        seed=None,
    )
