"""ALMotion's joint methods: angles, interpolations, stiffness, limits.

Every motion becomes timed commands of the DCM, so that between ALMotion and DCM programs the last command is in
force, as on the robot. Semantics: vendor's pages on joint control and stiffness control.
"""

from __future__ import annotations

import logging
from collections.abc import Iterable, Sequence
from concurrent.futures import Future
from typing import Any, Final, TypeVar

import numpy as np
from scipy.interpolate import CubicHermiteSpline

from bridge.adapters.naoqi.core.joints import CHAINS, Joints
from bridge.adapters.naoqi.core.motion_tasks import MotionTask, MotionTasks, RunningTask
from bridge.adapters.naoqi.core.robot_facts import RobotConfig
from bridge.adapters.naoqi.core.sensor_keys import TOUCH_KEYS
from bridge.adapters.naoqi.declared import (
    Fraction,
    clipped,
    fraction,
    lists_each,
    offers,
    one_each,
    require_times,
)
from bridge.body.joints import degrees_warning
from bridge.body.quantities import HANDS
from bridge.errors import NaoqiRefused

POINT_INTERVAL: Final = 0.020
"""s between two points: the cycle of ALMotion, which writes through the DCM (confirmed: vendor's pages)."""
MAX_POINTS: Final = 400
"""Most points of one path; a DCM buffer takes 512."""


def smooth(start: float, values: Sequence[float], times: Sequence[float]) -> list[tuple[float, float]]:
    """Points of a smooth path through each value at its time, at rest at both ends, without overshoot.

    Cubic between the values; slopes at inner values are the harmonic mean of both sides, or 0 at a turn
    (Fritsch and Carlson 1980). ALMotion's curve is not published (assumed).

    Args:
        start: value at time 0.
        times: s, increasing, the first one above 0.

    Returns:
        Pairs of time (s) and value, the last one exactly the last value.
    """
    t = np.array([0.0, *times])
    y = np.array([start, *values])
    chord = np.diff(y) / np.diff(t)
    slope = np.zeros_like(y)
    left, right = chord[:-1], chord[1:]
    same = left * right > 0.0
    slope[1:-1][same] = 2.0 * left[same] * right[same] / (left[same] + right[same])
    curve = CubicHermiteSpline(t, y, slope)
    count = max(1, min(MAX_POINTS, round(t[-1] / POINT_INTERVAL)))
    at = np.linspace(0.0, t[-1], count + 1)[1:]
    points = [(float(moment), float(value)) for moment, value in zip(at, curve(at), strict=True)]
    points[-1] = (float(t[-1]), float(y[-1]))
    return points


logger = logging.getLogger(__name__)

A = TypeVar("A")
B = TypeVar("B")

CYCLE: Final = 20
"""ms; ALMotion's cycle (confirmed: vendor's pages)."""


class JointMotion:
    """Joint methods of `ALMotion`; not thread-safe, the caller locks."""

    def __init__(self, joints: Joints, tasks: MotionTasks, config: RobotConfig) -> None:
        self._joints, self._tasks, self._config = joints, tasks, config
        self._warned = False

    @offers("ALMotion.getAngles")
    def get_angles(self, names: Any, use_sensors: bool) -> list[float]:
        """Measured or commanded angles."""
        joints = self._joints
        read = joints.measured if use_sensors else joints.commanded
        return [read(joint) for joint in joints.names.resolve(names)]

    @offers("ALMotion.setAngles", kind="joints")
    def set_angles(self, names: Any, angles: Any, speed: Any) -> None:
        """Move to angles, each joint at its fraction of its largest speed; does not wait."""
        resolved = self._joints.names.resolve(names)
        targets = one_each(angles, len(resolved), "ALMotion.setAngles: angles")
        self._move(resolved, targets, _fractions(speed, len(resolved)))

    @offers("ALMotion.changeAngles", kind="joints")
    def change_angles(self, names: Any, changes: Any, speed: Any) -> None:
        """As `set_angles`, relative to the commanded angles."""
        resolved = self._joints.names.resolve(names)
        by = one_each(changes, len(resolved), "ALMotion.changeAngles: changes")
        targets = [self._joints.commanded(j) + change for j, change in zip(resolved, by, strict=True)]
        self._move(resolved, targets, _fractions(speed, len(resolved)))

    def _move(self, joints: Sequence[str], targets: Sequence[float], fractions: Sequence[float]) -> None:
        for joint, wanted, speed_fraction in _left_hip_last(zip(joints, targets, fractions, strict=True)):
            target = self._clipped(joint, wanted)
            seconds = abs(target - self._joints.commanded(joint)) / (speed_fraction * self._joints.speed(joint))
            self._joints.put_position(joint, [(seconds, target)])
            self._joints.guarded.add(joint)

    def _clipped(self, joint: str, angle: float) -> float:
        if not self._warned and (why := degrees_warning(joint, angle)):
            self._warned = True
            logger.warning("ALMotion: the angle of %s", why)
        lower, upper, *_ = self._joints.limits(joint)
        return min(max(angle, lower), upper)

    @offers("ALMotion.angleInterpolation", kind="joints")
    def angle_interpolation(self, names: Any, angles: Any, times: Any, absolute: bool) -> Future[Any]:
        """Move smoothly through angles at times; waits for the end."""
        method = "ALMotion.angleInterpolation"
        joints = self._joints.names.resolve(names)
        targets = lists_each(angles, len(joints), f"{method}: angleLists")
        moments = lists_each(times, len(joints), f"{method}: timeLists")
        require_times(moments, targets, method)

        def task() -> MotionTask:
            froms = [0.0 if absolute else self._joints.commanded(joint) for joint in joints]
            goals = [[start + value for value in values] for start, values in zip(froms, targets, strict=True)]
            yield from self.interpolate(joints, goals, moments)

        return self._tasks.begin(task(), "angleInterpolation", joints, locks=True)

    @offers("ALMotion.angleInterpolationWithSpeed", kind="joints")
    def interpolation_with_speed(self, names: Any, angles: Any, speed: Fraction) -> Future[Any]:
        """Move to one angle each, all joints in the time of the slowest; waits for the end."""
        method = "ALMotion.angleInterpolationWithSpeed"
        joints = self._joints.names.resolve(names)
        targets = one_each(angles, len(joints), f"{method}: targetAngles")

        def task() -> MotionTask:
            every = [[self.time_to(joints, targets, speed)]] * len(joints)
            yield from self.interpolate(joints, [[target] for target in targets], every)

        return self._tasks.begin(task(), "angleInterpolationWithSpeed", joints, locks=True)

    def time_to(self, joints: Sequence[str], targets: Sequence[float], speed_fraction: float) -> float:
        """Shortest time of a motion of joints to their targets, s, at a fraction of their largest speed."""
        durations = (
            abs(self._clipped(joint, target) - self._joints.commanded(joint)) / self._joints.speed(joint)
            for joint, target in zip(joints, targets, strict=True)
        )
        return max(max(durations, default=0.0) / speed_fraction, 0.001 * CYCLE)

    def interpolate(
        self, joints: Sequence[str], targets: Sequence[Sequence[float]], times: Sequence[Sequence[float]]
    ) -> MotionTask:
        """The task of an interpolation: targets (rad) and times (s) for each joint."""
        for joint, values, moments in _left_hip_last(zip(joints, targets, times, strict=True)):
            angles = [self._clipped(joint, value) for value in values]
            self._joints.put_position(joint, smooth(self._joints.commanded(joint), angles, moments))
            self._joints.guarded.add(joint)
        last = max((moments[-1] for moments in times), default=0.0)
        yield self._joints.now + round(1000.0 * last)

    @offers("ALMotion.getStiffnesses")
    def get_stiffnesses(self, names: Any) -> list[float]:
        """Commanded stiffness of each joint."""
        return [self._joints.stiffness(joint) for joint in self._joints.names.resolve(names)]

    @offers("ALMotion.setStiffnesses", kind="joints")
    def set_stiffnesses(self, names: Any, stiffnesses: Any) -> None:
        """Stiffness of each joint from now on, 0 to 1; negative: free."""
        joints = self._joints.names.resolve(names)
        values = one_each(stiffnesses, len(joints), "ALMotion.setStiffnesses: stiffnesses")
        for joint, value in zip(joints, values, strict=True):
            self._joints.put_stiffness(joint, [(0.0, clipped(value, f"stiffness of {joint}", -1.0, 1.0))])

    @offers("ALMotion.stiffnessInterpolation", kind="joints")
    def stiffness_interpolation(self, names: Any, stiffnesses: Any, times: Any) -> Future[Any]:
        """Move stiffnesses linearly through values at times; waits for the end."""
        method = "ALMotion.stiffnessInterpolation"
        joints = self._joints.names.resolve(names)
        targets = lists_each(stiffnesses, len(joints), f"{method}: stiffnessLists")
        moments = lists_each(times, len(joints), f"{method}: timeLists")
        require_times(moments, targets, method)
        return self._tasks.begin(self.stiffen(joints, targets, moments), "stiffnessInterpolation", joints)

    def stiffen(
        self, joints: Sequence[str], targets: Sequence[Sequence[float]], times: Sequence[Sequence[float]]
    ) -> MotionTask:
        """The task of a change of stiffness: targets and times (s) for each joint."""
        for joint, values, moments in zip(joints, targets, times, strict=True):
            self._joints.put_stiffness(joint, list(zip(moments, values, strict=True)))
        yield self._joints.now + round(1000.0 * max((moments[-1] for moments in times), default=0.0))

    @offers("ALMotion.openHand", kind="joints", opening=1.0)
    @offers("ALMotion.closeHand", kind="joints", opening=0.0)
    def move_hand(self, name: Any, *, opening: float) -> Future[Any]:
        """Open (1) or close (0) a hand; waits for the end."""
        if name not in HANDS or name not in self._joints.names.all:
            raise NaoqiRefused(f"{name!r:.40} is no hand of {self._joints.body.name}.")
        self._joints.put_stiffness(name, [(0.0, 1.0)])
        return self.interpolation_with_speed(name, opening, 0.25)

    @offers("ALMotion.killAll", "ALRobotPosture.stopMove", kind="posture")
    def end_all(self) -> None:
        """Stop every motion; calls that wait for one return."""
        self._joints.stop(self._joints.names.all)
        self._tasks.end()

    @offers("ALMotion.getTaskList")
    def task_list(self) -> list[list[Any]]:
        """`[name, number, [joint, ...]]` of each running motion."""
        return [[task.name, task.number, list(task.joints)] for task in self._tasks.motions]

    @offers("ALMotion.areResourcesAvailable")
    def available(self, names: Any) -> bool:
        """Whether no motion uses any of the joints."""
        wanted = set(self._joints.names.resolve(names))
        return not any(wanted & set(task.joints) for task in self._tasks.motions)

    @offers("ALMotion.killTasksUsingResources", kind="posture")
    def end_using(self, names: Any) -> None:
        """Stop the motions that use any of the joints, and other commands to them."""
        wanted = set(self._joints.names.resolve(names))
        self._end([task for task in self._tasks.motions if wanted & set(task.joints)], wanted)

    @offers("ALMotion.killTask")
    def end_task(self, number: Any) -> bool:
        """Stop the motion of a number; False: there is none."""
        ended = [task for task in self._tasks.motions if task.number == number]
        self._end(ended, set())
        return bool(ended)

    def _end(self, tasks: Sequence[RunningTask], joints: set[str]) -> None:
        self._joints.stop(sorted(joints.union(*(task.joints for task in tasks))))
        self._tasks.stop_tasks(tasks)

    @offers("ALMotion.getLimits")
    def get_limits(self, name: Any) -> list[list[float]]:
        """Smallest and largest angle, largest speed and torque of each joint."""
        return [self._joints.limits(joint) for joint in self._joints.names.resolve(name)]

    @offers("ALMotion.getBodyNames", "ALMotion.getJointNames")
    def get_body_names(self, name: str) -> list[str]:
        """Joints of a chain; the chains themselves for `Chains`."""
        if name == "Chains":
            return list(CHAINS)
        return list(self._joints.names.group(name))

    @offers("ALMotion.getSummary")
    def get_summary(self) -> str:
        """A table of all joints: stiffness, command and sensor."""
        head = f"{'Joint':16}{'Stiffness':>12}{'Command':>12}{'Sensor':>12}"
        rows = [
            f"{joint:16}{self._joints.stiffness(joint):12.6f}{self._joints.commanded(joint):12.6f}"
            f"{self._joints.measured(joint):12.6f}"
            for joint in self._joints.names.all
        ]
        return "\n".join([f"Model: {self._config.table()[1][0]}", head, *rows]) + "\n"

    @offers("ALMotion.angleInterpolationBezier", kind="joints")
    def _bezier(self, names: Any, times: Any, control_points: list[list[Any]]) -> Future[Any]:
        """Move through the control points' angles at their times, without their handles."""
        angles = [[p[0] if isinstance(p, list) and p else p for p in row] for row in control_points]
        return self.angle_interpolation(names, angles, times, True)

    _get_sensor_names = offers("ALMotion.getSensorNames")(
        lambda self: [key.removesuffix("/Sensor/Value") for key in TOUCH_KEYS]
    )
    _get_robot_config = offers("ALMotion.getRobotConfig")(lambda self: self._config.table())


def _left_hip_last(rows: Iterable[tuple[str, A, B]]) -> list[tuple[str, A, B]]:
    """Rows by joint, the right hip's first: of both hips' commands the left one counts (vendor's page)."""
    return sorted(rows, key=lambda row: row[0] != "RHipYawPitch")


def _fractions(speed: Any, count: int) -> list[float]:
    return [fraction(one, "fractionMaxSpeed") for one in one_each(speed, count, "fractionMaxSpeed")]
