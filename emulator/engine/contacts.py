"""Laws of contact that both engines share: mean forces on the feet, and the joints' mechanical stops.

Forces are means over the physics steps of a cycle. A servo that gets a new request every cycle makes the
contact forces swing within the cycle, by tens of newtons when it is stiff. A sample of the last step would be
wrong in the mean, the centre of pressure by centimetres; force sensors have filters that see the average.

The engines' own joint limits act one step late: a joint at 20 rad/s is then 1.1 degrees
beyond. So a joint that would pass its stop within the next step is braked to arrive at it. The braking
uses the inertia of the joint's own link and rotor, the least that can be moving: it takes away speed, never
turns it round, and leaves the rest to the engine.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np

from bridge.body import Body, joint_tree
from bridge.body.quantities import tensor_matrix
from bridge.types import SIDES, Array, Side, Vec3
from emulator.compiled import compilable, compiled
from emulator.engine.values import FootLoad, GroundContacts
from emulator.vectors import add, rotate_back, scaled

RIM_COSINE: Final = 0.5
"""Cosine to the sole's normal below which a contact pushes on the rim of the foot, not on the sole."""


def ground_contacts(
    sums: Array,
    rim: Sequence[tuple[int, Vec3]],
    frames: Array,
    steps: int,
    normal: Vec3,
    touching: frozenset[str],
) -> GroundContacts:
    """All contacts of a cycle.

    Args:
        sums: Of each foot over its contact points and the steps, (2, 7): force on it, world frame, N; its part
            along the sole's normal, N; place of the contact times that part, world frame, N m.
        rim: Foot and place, world frame, m, of each contact on the rim.
        frames: AnkleRoll frames now, (2, 12): origin in the world, m; rotation matrix to the world, row by row.
        steps: Of the cycle, at least 1.
        normal: Of the floor, world frame.
        touching: Other links on the ground.
    """
    means = np.zeros((len(SIDES), 6))
    total, x, y = _means(sums, frames, steps, normal, means)
    loads: dict[Side, FootLoad] = {}
    for i, (fx, fy, fz, pressing, *cop) in enumerate(means.tolist()):
        points = tuple(_local(place, frames[i]) for foot, place in rim if foot == i)
        loads[SIDES[i]] = FootLoad((fx, fy, fz), pressing, (cop[0], cop[1]) if pressing > 0.0 else None, points)
    return GroundContacts(loads, (x / total, y / total) if total > 0.0 else None, touching)


@compiled
def _means(sums: Array, frames: Array, steps: int, normal: Vec3, means: Array) -> Vec3:
    """Mean force, normal force and centre of pressure in the sole frame of each foot, (2, 6), written.

    Returns:
        Sum of the feet's weights, and of their centres of pressure, x and y in the world, times these.
    """
    total = x = y = 0.0
    for i in range(len(sums)):
        for axis in range(3):
            means[i, axis] = sums[i, axis] * (1.0 / steps)
        pressing = sums[i, 3]
        means[i, 3] = pressing / steps
        if pressing > 0.0:
            cop = (sums[i, 4] / pressing, sums[i, 5] / pressing, sums[i, 6] / pressing)
            means[i, 4], means[i, 5], _ = _local(cop, frames[i])
            weight = means[i, 0] * normal[0] + means[i, 1] * normal[1] + means[i, 2] * normal[2]
            total, x, y = total + weight, x + weight * cop[0], y + weight * cop[1]
    return total, x, y


@compilable
def _local(place: Vec3, f: Array) -> Vec3:
    """A place of the world in a frame (12,)."""
    way = add(place, scaled((f[0], f[1], f[2]), -1.0))
    return rotate_back((f[3], f[4], f[5], f[6], f[7], f[8], f[9], f[10], f[11]), way)


def own_inertia(body: Body, joint: str) -> float:
    """Inertia of the link that a joint moves about the joint's axis, kg m^2.

    Args:
        body: Data sheet.
        joint: Name.
    """
    link, axis = body.links[joint], np.array(joint_tree(body)[joint].axis)
    arm = np.cross(axis, link.com)
    return float(axis @ tensor_matrix(link.inertia) @ axis + link.mass * arm @ arm)


class Stops:
    """Stops of all joints.

    Args:
        body: Data sheet.
        joints: Mechanical joints in the order of every vector here.
        rotor_inertia: Of each motor at its joint, kg m^2.
        step: Physics step, s.
    """

    def __init__(self, body: Body, joints: Sequence[str], rotor_inertia: Array, step: float) -> None:
        self._lower = np.array([body.joints[name].lower for name in joints])
        self._upper = np.array([body.joints[name].upper for name in joints])
        inertia = rotor_inertia + [own_inertia(body, name) for name in joints]
        self._step, self._torque_per_way = step, inertia / step**2

    @property
    def constants(self) -> tuple[Array, Array, Array, float]:
        """The first arguments of `brake_joints`."""
        return self._lower, self._upper, self._torque_per_way, self._step

    def brake(self, position: Array, velocity: Array, torque: Array) -> None:
        """Add the braking of a step to the torques, in place.

        Args:
            position: Joint angles, (n,), rad.
            velocity: Joint velocities, (n,), rad/s.
            torque: Of the drives, (n,), N m; changed.
        """
        brake_joints(*self.constants, position, velocity, torque)


@compiled
def brake_joints(
    lower: Array,
    upper: Array,
    torque_per_way: Array,
    step: float,
    position: Array,
    velocity: Array,
    torque: Array,
) -> None:
    """`Stops.brake` as machine code.

    Args:
        lower: Ends of the joints' ranges, (n,), rad.
        upper: Likewise.
        torque_per_way: Torque that takes away a way in a step, (n,), N m/rad.
        step: Physics step, s.
        position: Joint angles, (n,), rad.
        velocity: Joint velocities, (n,), rad/s.
        torque: Of the drives, (n,), N m; changed.
    """
    for i in range(len(position)):
        # `way`: angle after the step, q + qd dt. `goal`: the same, but no farther than the upper stop, or than
        # q if that is beyond. The torque I (way - goal) / dt^2 takes the excess away. Then the lower stop.
        way = velocity[i] * step + position[i]
        goal = min(way, max(position[i], upper[i]))
        torque[i] -= (way - goal) * torque_per_way[i]
        goal = max(way, min(position[i], lower[i]))
        torque[i] -= (way - goal) * torque_per_way[i]
