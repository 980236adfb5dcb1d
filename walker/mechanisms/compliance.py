"""Joint compliance compensation: add to each joint angle the deflection that the load will cause.

Reads: planned joint angles and ZMP, encoders, commands of the last latency; at rest the force sensors.
Gives: joint angles with the deflections.

Not in the thesis. A position-controlled drive is a spring: a loop of finite gain behind a gear with backlash.
On one leg a NAO in good order yields by 3 degrees at the hip, leans towards its swing foot and lands early. The
plan gives the deflection: the weights beyond a joint and the ground's reaction under the feet are its torque,
and the drive's compliance turns torque into angle. This is feed-forward and cannot oscillate.

Compliance differs from robot to robot. A command less the encoder's reading is the true deflection, whatever
the command contains. Its ratio to the modelled deflection is estimated in slow walks, for each kind of
joint, both sides together.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Final

import msgspec
import numpy as np

from bridge.body import Body, joint_tree
from bridge.body.joints import INDEX_WITH_MIRROR, LEG_JOINTS
from bridge.body.kinematics import CentreOfMass
from bridge.body.quantities import GRAVITY, limits
from bridge.messages import SensorFrame
from bridge.planar import Pose2D
from bridge.rotations import rotation
from bridge.types import SIDES, Array, Fraction, NotNegative, Positive, Side
from walker.gaits.plan import Plan

_HELD_BY_FRICTION: Final = [0, 1, 5]
"""HipYawPitch, HipRoll and AnkleRoll, which do not yield in a double support with feet side by side."""

_FROM_JOINT_TO_FOOT: Final = np.triu(np.ones((6, 6)))
"""Sums over the links of a leg from each joint on."""


class JointComplianceParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Compliance of the legs' drives, and how it is adapted."""

    gain: Fraction = 1.0
    """Fraction of the deflection that is compensated."""
    coefficient: NotNegative = 0.0094
    """Compliance of a joint, loop and gear together, rad/(N m)."""
    half_backlash: NotNegative = 0.0107
    """Half the backlash of a joint, rad."""
    backlash_torque: Positive = 0.15
    """Torque over which a joint passes from one side of its backlash to the other, N m."""
    adaptation_time: NotNegative = 10.0
    """Time constant of the ratio's estimate, s; 0: the ratio stays 1."""
    max_ratio: Positive = 2.5
    """Bound of the ratio."""
    ramp_time: Positive = 0.5
    """Time over which the compensation rises when a walk begins, s."""


class JointCompliance:
    """Adds to joint angles the deflections of the drives under the planned load.

    Args:
        parameters: compliance and its adaptation.
        body: data sheet.
        cycle: of the robot, s.
        latency: from a command to the motion that the encoders report, s.
    """

    ratio: Array
    """Deflection over its model for the joints of a leg in chain order, both sides together, shape (6,)."""

    def __init__(self, parameters: JointComplianceParameters, body: Body, cycle: float, latency: float) -> None:
        self._p = parameters
        self._legs = {side: _Leg(body, side) for side in SIDES}
        self._com = CentreOfMass(body)
        names = self._com.tree.links
        weights = GRAVITY * np.array([body.links[name].mass for name in names])
        self._weight = float(weights.sum())
        self._weighted_centres = weights[:, None] * np.array([(*body.links[name].com, 1.0) for name in names])
        self._rows = np.array([[names.index(j) for j in LEG_JOINTS[s]] for s in SIDES])
        self._axes = np.array([leg.axes for leg in self._legs.values()])[..., None]
        self._feet = np.array([leg.foot for leg in self._legs.values()])
        self._below = weights[self._rows] @ _FROM_JOINT_TO_FOOT.T
        self._limits = {s: np.array([limits(body, j) for j in LEG_JOINTS[s]]).T for s in SIDES}
        self._cells = [np.array(places)[:, :2] for places in (body.fsr.L, body.fsr.R)]
        self._sent: deque[Sequence[float]] = deque(maxlen=1 + round(latency / cycle))
        self.ratio = np.ones(6)
        self._cycle = cycle
        self._ramp = 0.0
        self._known = np.full(6, 1e-3)  # rad^2 s: one degree of deflection for 3 s
        self._explained = self._known.copy()
        self._model: Array | None = None

    def adapt(self, measured: Sequence[float], dt: float) -> None:
        """Estimate the ratio from the encoders and the commands; valid in slow motion only.

        Args:
            measured: joint angles, 25 slots, rad.
            dt: time since the last cycle, s.
        """
        if self._model is None or not self._p.adaptation_time or not self._sent:
            return
        command = self._sent[0]
        deflection = np.array(
            [[command[slot] - measured[slot] for slot in self._legs[side].slots] for side in SIDES]
        )
        # Least squares over an exponential window, drawn towards a ratio of 1.
        keep = 1.0 - dt / self._p.adaptation_time
        self._known = keep * self._known + dt * (self._model**2).sum(axis=0) + (1.0 - keep) * 1e-3
        self._explained = (
            keep * self._explained + dt * (self._model * deflection).sum(axis=0) + (1.0 - keep) * 1e-3
        )
        self.ratio = np.clip(self._explained / self._known, 0.0, self._p.max_ratio)

    def sent(self, angles: Sequence[float]) -> None:
        """Take note of the command of this cycle, 25 slots, rad."""
        self._sent.append(angles)

    def compensate(self, angles: list[float], plan: Plan) -> None:
        """Add the deflections to the joint angles of a plan, in place, within the joints' ranges.

        Args:
            angles: 25 slots, rad.
            plan: the plan; its ZMP divides the weight between the feet.
        """
        self._model = self.deflections(self.torques(angles, self._left_fraction(plan)))
        p = self._p
        self._ramp = min(self._ramp + self._cycle / p.ramp_time, 1.0)
        self._add(angles, self._ramp * p.gain * self.ratio * self._model)

    def _add(self, angles: list[float], deflections: Array) -> None:
        for side, deflection in zip(SIDES, deflections, strict=True):
            lower, upper = self._limits[side]
            for i, slot in enumerate(self._legs[side].slots):
                if side == "L" or i:  # RHipYawPitch shares its slot
                    angles[slot] = float(min(max(angles[slot] + deflection[i], lower[i]), upper[i]))

    def holding(self, frame: SensorFrame) -> tuple[float, ...]:
        """Joint angles to ask for so that a robot at rest stays as it is: those measured and the deflections.

        Asked for the measured angles themselves, a standing robot would yield as much again.

        Args:
            frame: newest sensor frame. Where the feet bear less than half the weight, the measured angles.

        Returns:
            25 joint angles within their ranges, rad.
        """
        cells = np.maximum(frame.fsr, 0.0).reshape(2, 4)
        forces = cells.sum(axis=1)
        angles = list(frame.position)
        if (total := float(forces.sum())) > 0.5 * self._weight:
            points = self._feet.copy()
            for i, places in enumerate(self._cells):
                if forces[i] > 0.0:
                    points[i, :2] = cells[i] @ places / forces[i]
            frames = rotation(*frame.angle, 0.0) @ self._com.tree.frames(angles)[:, :3]
            torques = self._torques(frames, forces / total, points)
            deflections = self.deflections(torques)
            deflections[:, _HELD_BY_FRICTION] = 0.0
            self._add(angles, deflections)
        return tuple(angles)

    def deflections(self, torques: Array) -> Array:
        """Deflections of the joints under torques, the shape of the torques, rad.

        Args:
            torques: As `torques` gives them; one motor bears both HipYawPitch torques.
        """
        p, torques = self._p, torques.copy()
        torques[:, 0] = torques[:, 0].sum()
        return p.coefficient * torques + p.half_backlash * np.tanh(torques / p.backlash_torque)

    def torques(self, angles: Sequence[float], left_fraction: float) -> Array:
        """Torques that the legs' joints bear at rest, shape (2, 6): left and right, in chain order, N m.

        Each foot bears its fraction of the weight at its middle, straight up; the torso is upright.

        Args:
            angles: 25 slots, rad.
            left_fraction: of the weight, on the left foot, 0..1.
        """
        frames = self._com.tree.frames(angles)[:, :3]
        return self._torques(frames, np.array([left_fraction, 1.0 - left_fraction]), self._feet)

    def _torques(self, frames: Array, fractions: Array, points: Array) -> Array:
        """The same, with link frames in axes with z up, and points of support in the AnkleRoll frames."""
        moments: Array = (frames[:, :2] @ self._weighted_centres[:, :, None])[:, :, 0]
        chains = frames[self._rows, :2]
        turns, places = chains[..., :3], chains[..., 3]
        feet = (turns[:, -1] @ points[:, :, None])[:, :, 0] + places[:, -1]
        load = self._weight * fractions[:, None]
        # The load beyond a joint: the ground's reaction less the weights from the joint to the foot.
        force = (load - self._below)[:, :, None]
        moment = (load * feet)[:, None] - _FROM_JOINT_TO_FOOT @ moments[self._rows] - places * force
        axes = (turns @ self._axes)[..., 0]
        torques: Array = axes[..., 1] * moment[..., 0] - axes[..., 0] * moment[..., 1]
        return torques

    def _left_fraction(self, plan: Plan) -> float:
        """Fraction of the weight that the plan puts on the left foot: the ZMP's lever between the feet."""
        if plan.support != "both":
            return 1.0 if plan.support == "L" else 0.0
        places = []
        for side, foot in (("L", plan.left), ("R", plan.right)):
            x, y, _ = self._legs[side].foot.tolist()  # type: ignore[index]
            places.append(Pose2D(foot.x, foot.y, foot.yaw).point(x, y))
        left, right = places
        across = left[0] - right[0], left[1] - right[1]
        along = (plan.zmp[0] - right[0]) * across[0] + (plan.zmp[1] - right[1]) * across[1]
        return min(max(along / (across[0] ** 2 + across[1] ** 2), 0.0), 1.0)


class _Leg:
    """Data-sheet values of one leg."""

    def __init__(self, body: Body, side: Side) -> None:
        tree = joint_tree(body)
        x, y = body.foot.centre
        self.axes = np.array([tree[j].axis for j in LEG_JOINTS[side]])
        self.slots = [INDEX_WITH_MIRROR[j] for j in LEG_JOINTS[side]]
        self.foot = np.array([x, y if side == "L" else -y, -body.lengths.FootHeight])
        """Middle of the sole in the AnkleRoll frame, m."""
