"""Mechanical stops at high speed, where the engines' own joint limits act too late.

Such a limit acts from the step after it was passed: a joint at 20 rad/s is then 1.1 degrees beyond it.
So a joint that would pass its stop within the coming step is braked to arrive at it. The braking uses the
inertia of the joint's own link and rotor, the least that can be moving: it takes away speed, never turns it
round, and leaves the rest to the engine.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bridge.body import Body, joint_tree
from bridge.body.quantities import tensor_matrix
from bridge.types import Array
from emulator.compiled import compiled


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
