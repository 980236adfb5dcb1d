"""What the legs give way by under the body's weight, and commands that make up for it; not in the thesis.

A drive is a spring: a loop of finite gain behind a gear with play. On one leg a NAO in good order gives way
by 3 degrees at the hip, leans towards its swing foot and lands early. How much follows from the plan: the
weights beyond a joint and the ground's reaction under the feet give the torque, the drive's compliance gives
the angle, and the joint is asked for so much more. It is feed-forward: nothing in it can ring.

How soft the drives are differs from robot to robot. The difference between what a joint was asked for and
what its encoder says is the sag itself, whatever was added to the command, so its ratio to the modelled sag
is learned while the robot walks slowly, for each kind of joint, both sides together.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import Annotated, Final

import msgspec
import numpy as np

from bridge.datasheet import Body, joint_tree
from bridge.datasheet.model import Side
from bridge.datasheet.quantities import limits
from bridge.joints import INDEX_WITH_MIRROR, LEG_JOINTS
from walker.gait.reference import Reference
from walker.gravity import GRAVITY
from walker.kinematics.com import CentreOfMass
from walker.kinematics.transforms import Array

_Positive = Annotated[float, msgspec.Meta(gt=0.0)]
_NotNegative = Annotated[float, msgspec.Meta(ge=0.0)]
_Share = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
_SIDES: Final[tuple[Side, Side]] = ("L", "R")


class SagParameters(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Compliance of the legs' drives, and how it is learned."""

    share: _Share = 1.0
    """Of the sag that is made up for; 0 leaves it out."""
    compliance: _NotNegative = 0.018
    """Of a joint, loop and gear together, rad/(N m)."""
    play: _NotNegative = 0.011
    """Half the play of a joint, rad."""
    play_torque: _Positive = 0.15
    """Torque over which a joint passes from one side of its play to the other, N m."""
    memory: _NotNegative = 10.0
    """Time over which the ratio to this model is learned, s; 0: the model is believed."""
    most: _Positive = 2.5
    """Largest ratio that is believed."""
    fade_in: _Positive = 0.5
    """Time over which the compensation comes in when a walk begins, s."""
    latency: _NotNegative = 0.04
    """From a command to the motion that the encoder reports, s."""


class Sag:
    """Adds to joint angles what the drives will give way by.

    Args:
        parameters: compliance.
        body: data sheet.
        cycle: of the robot, s.
    """

    ratio: Array
    """Sag over its model for the joints of a leg in chain order, both sides together, shape (6,)."""

    def __init__(self, parameters: SagParameters, body: Body, cycle: float) -> None:
        self._p = parameters
        self._legs = {side: _Leg(body, side) for side in _SIDES}
        self._com = CentreOfMass(body)
        names = self._com.tree.links
        self._mass = np.array([body.links[name].mass for name in names])
        self._centre = np.array([(*body.links[name].com, 1.0) for name in names])
        self._weight = float(self._mass.sum()) * GRAVITY
        self._rows = {s: np.array([names.index(j) for j in LEG_JOINTS[s]]) for s in _SIDES}
        self._limits = {s: np.array([limits(body, j) for j in LEG_JOINTS[s]]).T for s in _SIDES}
        self._sent: deque[Sequence[float]] = deque(maxlen=1 + round(parameters.latency / cycle))
        self.ratio = np.ones(6)
        self._cycle = cycle
        self._faded_in = 0.0
        self._known = np.full(6, 1e-3)  # rad^2 s: one degree of sag for 3 s
        self._explained = self._known.copy()
        self._model: Array | None = None

    def learn(self, measured: Sequence[float], dt: float) -> None:
        """Compare the encoders with what was asked for; in slow motion only.

        Args:
            measured: joint angles, 25 slots, rad.
            dt: time since the last cycle, s.
        """
        if self._model is None or not self._p.memory or not self._sent:
            return
        asked = self._sent[0]
        sag = np.array([[asked[slot] - measured[slot] for slot in self._legs[side].slots] for side in _SIDES])
        keep = 1.0 - dt / self._p.memory
        self._known = keep * self._known + dt * (self._model**2).sum(axis=0) + (1.0 - keep) * 1e-3
        self._explained = keep * self._explained + dt * (self._model * sag).sum(axis=0) + (1.0 - keep) * 1e-3
        self.ratio = np.clip(self._explained / self._known, 0.0, self._p.most)

    def sent(self, angles: Sequence[float]) -> None:
        """Take note of the command of this cycle, 25 slots, rad."""
        self._sent.append(angles)

    def compensate(self, angles: list[float], reference: Reference) -> None:
        """Add the sag to the joint angles of a plan, in place, within the joints' ranges.

        Args:
            angles: 25 slots, rad.
            reference: the plan, which says how the feet share the weight.
        """
        torques = self.torques(angles, self._left_share(reference))
        torques[:, 0] = torques[:, 0].sum()  # one motor for both hips
        p = self._p
        self._model = p.compliance * torques + p.play * np.tanh(torques / p.play_torque)
        self._faded_in = min(self._faded_in + self._cycle / p.fade_in, 1.0)
        gives = self._faded_in * p.share * self.ratio * self._model
        for side, give in zip(_SIDES, gives, strict=True):
            lower, upper = self._limits[side]
            for i, slot in enumerate(self._legs[side].slots):
                if side == "L" or i:  # RHipYawPitch shares its slot
                    angles[slot] = float(min(max(angles[slot] + give[i], lower[i]), upper[i]))

    def torques(self, angles: Sequence[float], left_share: float) -> Array:
        """Torques that the legs' joints bear at rest, shape (2, 6): left and right, in chain order, N m.

        Each foot bears its share of the weight at its middle, straight up; the torso is upright.

        Args:
            angles: 25 slots, rad.
            left_share: of the weight on the left foot, 0..1.
        """
        frames = self._com.tree.frames(angles)
        moments = (np.einsum("nij,nj->ni", frames[:, :2], self._centre) * self._mass[:, None]) * GRAVITY
        result = np.empty((2, 6))
        for i, (side, share) in enumerate(zip(_SIDES, (left_share, 1.0 - left_share), strict=True)):
            rows, leg = self._rows[side], self._legs[side]
            chain = frames[rows]
            foot = chain[-1][:2, :3] @ leg.foot + chain[-1][:2, 3]
            load = share * self._weight
            # What is borne beyond a joint: the ground's reaction less the weights from the joint to the foot.
            force = load - GRAVITY * np.cumsum(self._mass[rows][::-1])[::-1]
            moment = (
                load * foot - np.cumsum(moments[rows][::-1], axis=0)[::-1] - chain[:, :2, 3] * force[:, None]
            )
            axes = np.einsum("nij,nj->ni", chain[:, :2, :3], leg.axes)
            result[i] = axes[:, 1] * moment[:, 0] - axes[:, 0] * moment[:, 1]
        return result

    def _left_share(self, reference: Reference) -> float:
        """Share of the weight that the plan puts on the left foot: the ZMP's lever between the feet."""
        if reference.support != "both":
            return 1.0 if reference.support == "L" else 0.0
        places = []
        for side, foot in (("L", reference.left), ("R", reference.right)):
            centre = self._legs[side].foot  # type: ignore[index]
            places.append((foot.x + float(centre[0]), foot.y + float(centre[1])))
        left, right = places
        across = left[0] - right[0], left[1] - right[1]
        along = (reference.zmp[0] - right[0]) * across[0] + (reference.zmp[1] - right[1]) * across[1]
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
