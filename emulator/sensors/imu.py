"""The inertial unit in the torso: accelerometer, gyroscope, and the angle fused from the two."""

from __future__ import annotations

import math
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bridge.body.model import InertialUnit
from bridge.types import Array, Vec2, Vec3
from emulator.compiled import compilable, compiled
from emulator.engine.values import BodyState
from emulator.sensors.fusion import FusedAngle, fuse
from emulator.sensors.parameters import NormalRows, SensorParameters, TriaxialParameters
from emulator.vectors import Rotation, add, cross, rotate, rotate_back, scaled

Constants = tuple[Array, float, float]
ALL_AXES: Final = 3
_QUIET: Final = np.zeros(0)
REST_BEFORE_START: Final = 1.0
"""Time for which the unit has been on and at rest before the first sample, s."""


class TriaxialSensor:
    """Gain, bias, noise, range; quantised when reported.

    The board that fuses the angle is taken to see the samples before they are rounded for the bus: it samples
    faster than the DCM and averages (assumed; its vendor publishes nothing).

    Args:
        max_value: Range (data sheet).
        step: Of the reported values (data sheet).
        axes: 3, or 2 without a Z axis.
        parameters: Imperfections.
        random: A generator of its own.
    """

    def __init__(
        self,
        max_value: float,
        step: float,
        axes: int,
        parameters: TriaxialParameters,
        random: np.random.Generator,
    ) -> None:
        constants, noise = random.spawn(2)
        p = parameters
        present = np.array([1.0, 1.0, 1.0 if axes == ALL_AXES else 0.0])
        self.gain: Array = (1.0 + p.gain * constants.standard_normal(3)) * present
        """Reading per true value; 0 for an axis that is not there."""
        self.bias: Array = p.bias * constants.standard_normal(3) * present
        """In the sensor's unit."""
        self._rows = NormalRows(noise, 3) if p.noise > 0.0 else None
        top = max_value if p.saturation else math.inf
        step = step if p.quantisation else 0.0
        self.constants: Constants = (np.array([self.gain, self.bias, p.noise * present]), top, step)
        """For `measured`; the step, the last, for `reported`."""

    def noise(self) -> Array:
        """Noise of the next sample, for `measured`."""
        return _QUIET if self._rows is None else self._rows.next()

    def measure(self, true: Vec3) -> Vec3:
        """One sample of a true vector, not yet rounded."""
        return measured(true, self.constants, self.noise())


@compilable
def measured(true: Vec3, constants: Constants, noise: Array) -> Vec3:
    """One sample of a true vector, not yet rounded.

    Args:
        true: In the sensor's unit.
        constants: `TriaxialSensor.constants`: rows of gain, bias and deviation of the noise; range; step.
        noise: Standard normal, (3,); none: (0,).
    """
    axes, top, _ = constants
    x, y, z = true[0] * axes[0, 0], true[1] * axes[0, 1], true[2] * axes[0, 2]
    x, y, z = x + axes[1, 0], y + axes[1, 1], z + axes[1, 2]
    if len(noise) > 0:
        x, y, z = x + axes[2, 0] * noise[0], y + axes[2, 1] * noise[1], z + axes[2, 2] * noise[2]
    return max(-top, min(x, top)), max(-top, min(y, top)), max(-top, min(z, top))


@compilable
def reported(sample: Vec3, step: float) -> Vec3:
    """A sample in whole steps.

    Args:
        sample: In the sensor's unit.
        step: 0: as it is.
    """
    if step == 0.0:
        return sample
    return round(sample[0] / step) * step, round(sample[1] / step) * step, round(sample[2] / step) * step


class InertialSample(NamedTuple):
    """One sample of the unit, Torso frame."""

    acceleration: Vec3
    """Specific force, m/s^2."""
    rate: Vec3
    """Angular velocity, rad/s; 0 about an axis the unit does not have."""
    angle: Vec2
    """Fused AngleX and AngleY, rad."""


@compilable
def mean_rate(before: Rotation, after: Rotation, time: float) -> Vec3:
    """Mean angular velocity between two orientations less than 90 degrees apart, body frame, rad/s.

    Args:
        before: Body to world.
        after: Body to world, `time` seconds later.
        time: s.
    """
    # columns of before^T after; its skew part is sin(angle) times the axis
    x = rotate_back(before, (after[0], after[3], after[6]))
    y = rotate_back(before, (after[1], after[4], after[7]))
    z = rotate_back(before, (after[2], after[5], after[8]))
    a, b, c = 0.5 * (y[2] - z[1]), 0.5 * (z[0] - x[2]), 0.5 * (x[1] - y[0])
    sine = math.sqrt(a * a + b * b + c * c)
    factor = (math.asin(min(sine, 1.0)) / sine if sine > 0.0 else 1.0) / time
    return a * factor, b * factor, c * factor


@compilable
def _velocity_of(place: Vec3, rotation: Rotation, velocity: Vec3, angular_velocity: Vec3) -> Vec3:
    """Velocity of a place in the torso, world frame, m/s."""
    return add(velocity, cross(angular_velocity, rotate(rotation, place)))


@compiled
def _move(
    place: Vec3,
    before: Rotation,
    after: Rotation,
    velocity: Vec3,
    torso_velocity: Vec3,
    torso_rate: Vec3,
    up: Vec3,
    cycle: float,
) -> tuple[Vec3, Vec3, Vec3]:
    """Velocity of the accelerometer's place after a cycle, and the means of `_means`."""
    later = _velocity_of(place, after, torso_velocity, torso_rate)
    return later, *_means(before, after, velocity, later, up, cycle)


@compiled
def _take(
    acceleration: Vec3,
    rate: Vec3,
    accelerometer: Constants,
    gyroscope: Constants,
    noises: tuple[Array, Array],
    state: NDArray[Any],
    cycle: float,
    fusion: tuple[float, float, float, float],
) -> tuple[Vec3, Vec3]:
    """Sample true means of a cycle, fuse them, and return the reports of both sensors."""
    seen, turned = measured(acceleration, accelerometer, noises[0]), measured(rate, gyroscope, noises[1])
    fuse(state, seen, turned, cycle, *fusion)
    return reported(seen, accelerometer[2]), reported(turned, gyroscope[2])


@compilable
def _means(
    before: Rotation, after: Rotation, velocity: Vec3, later: Vec3, up: Vec3, cycle: float
) -> tuple[Vec3, Vec3]:
    """Mean specific force (m/s^2) and mean rate (rad/s) of a cycle, Torso frame.

    Args:
        before: Torso to world at its beginning.
        after: And at its end.
        velocity: Of the accelerometer's place at its beginning, world frame, m/s.
        later: And at its end.
        up: Acceleration against gravity, world frame, m/s^2.
        cycle: s.
    """
    change = add(later, scaled(velocity, -1.0))
    specific = add(scaled(change, 1.0 / cycle), up)
    seen = add(rotate_back(before, specific), rotate_back(after, specific))
    return scaled(seen, 0.5), mean_rate(before, after, cycle)


class InertialSensors:
    """The unit of a body, sampled once per cycle.

    Both sensors give means over the cycle, as low-pass filters before the sampling do: specific force at the
    accelerometer's place from the change of velocity, rate from the change of orientation. Sampling the last
    instant instead would be wrong in the mean, because servos that get a new request every cycle shake the
    torso in step with the sampling.

    Args:
        unit: Places, axes, ranges and steps (data sheet).
        parameters: Imperfections.
        random: A generator of its own.
        gravity: m/s^2.
        cycle: s.
        torso: The torso at the first sample, taken to have been at rest.
    """

    def __init__(
        self,
        unit: InertialUnit,
        parameters: SensorParameters,
        random: np.random.Generator,
        gravity: float,
        cycle: float,
        torso: BodyState,
    ) -> None:
        for_accelerometer, for_gyroscope = random.spawn(2)
        self.accelerometer = TriaxialSensor(
            unit.accelerometer_range,
            unit.accelerometer_step,
            ALL_AXES,
            parameters.accelerometer,
            for_accelerometer,
        )
        self.gyroscope = TriaxialSensor(
            unit.gyroscope_range, unit.gyroscope_step, unit.gyroscope_axes, parameters.gyroscope, for_gyroscope
        )
        self._place = unit.accelerometer
        self._gravity, self._up = gravity, (0.0, 0.0, gravity)
        self._cycle = cycle
        self._filter, self._angle_step = parameters.fused_angle, unit.angle_step
        self.start(torso)

    def start(self, torso: BodyState) -> None:
        """Begin at a torso at rest: at the start, and after being moved by hand."""
        self._rotation = torso.rotation
        self._velocity = _velocity_of(self._place, torso.rotation, torso.velocity, torso.angular_velocity)
        at_rest = rotate_back(torso.rotation, self._up)
        self._fusion = self._fused(self.accelerometer.measure(at_rest))
        for _ in range(round(REST_BEFORE_START / self._cycle)):
            self._take(at_rest, (0.0, 0.0, 0.0))

    def _take(self, acceleration: Vec3, rate: Vec3) -> None:
        accelerometer, gyroscope, fusion = self.accelerometer, self.gyroscope, self._fusion
        seen, turned = _take(
            acceleration,
            rate,
            accelerometer.constants,
            gyroscope.constants,
            (accelerometer.noise(), gyroscope.noise()),
            fusion.state,
            self._cycle,
            fusion.constants,
        )
        self.sample = InertialSample(seen, turned, fusion.angle)
        """The latest sample."""

    def update(self, torso: BodyState) -> None:
        """Sample at the end of a cycle."""
        self._velocity, seen, rate = _move(
            self._place,
            self._rotation,
            torso.rotation,
            self._velocity,
            torso.velocity,
            torso.angular_velocity,
            self._up,
            self._cycle,
        )
        self._rotation = torso.rotation
        self._take(seen, rate)

    def rezero(self) -> None:
        """Restart the unit, as after a loss of power: the angle starts at zero."""
        self._fusion = self._fused(self._up)

    def _fused(self, acceleration: Vec3) -> FusedAngle:
        return FusedAngle(self._gravity, acceleration, self._filter, self._angle_step)
