"""Joint angles by a network: observations of the measured state in, targets held between two calls out.

Takes the place of the stabilizer in a walk by a learned gait. The time that the network takes on this machine
changes nothing here: in lockstep and in process the robot waits for the answer, and equal seeds give equal
frames. A network that takes longer on the robot is described by `delay` of its sheet, in every mode.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from typing import Final

import numpy as np

from bridge.body import Body
from bridge.body.joints import INDEX, INDEX_WITH_MIRROR, JOINTS
from bridge.body.leg_limits import AnkleRange
from bridge.errors import ConfigurationError
from bridge.messages import SensorFrame
from bridge.rotations import heading, rotation
from bridge.types import SIDES, Array
from walker.estimation.contact import SupportState
from walker.estimation.ground import Corrections
from walker.gaits.learned.gait import LearnedGait
from walker.gaits.learned.parameters import ObservationTerm
from walker.gaits.plan import Plan, PolicyCommand
from walker.mechanisms.compliance import JointCompliance
from walker.monitor import Estimate
from walker.parameters import ControllerParameters

_EPSILON: Final = 1e-9
"""s; a call is due in spite of rounding."""


class PolicyRunner:
    """Calls a network, and turns its outputs into joint angles.

    Args:
        body: data sheet.
        gait: the learned gait.
        parameters: of the controllers; `compliance` and `latency` count.
        cycle: of the robot, s.
    """

    def __init__(self, body: Body, gait: LearnedGait, parameters: ControllerParameters, cycle: float) -> None:
        self._p, self._network, self._rest = gait.parameters, gait.network, np.array(gait.default_pose)
        self.stiffness = self._p.stiffness
        """Stiffness of all joints in the walk."""
        self._compliance = JointCompliance(parameters.compliance, body, cycle, parameters.latency)
        ranges = [body.joints.get(joint) for joint in JOINTS]
        self._low = np.array([-math.inf if sheet is None else sheet.lower for sheet in ranges])
        self._high = np.array([math.inf if sheet is None else sheet.upper for sheet in ranges])
        self._ankles = {side: AnkleRange(body, side) for side in SIDES}
        self._slots = {each: _slots(self._p.joints(each)) for each in self._p.observation}
        # RHipYawPitch has no motor of its own: its output is but an observation of the next call
        self._kept = [i for i, joint in enumerate(self._p.outputs) if joint in INDEX]
        self._turned = _slots([self._p.outputs[i] for i in self._kept])
        parts = [(each, np.ones(len(each.joints))) for each in self._p.action]
        self._scale = np.concatenate([np.asarray(each.scale) * ones for each, ones in parts])
        self._offset = np.concatenate(
            [
                np.asarray(each.offset) * ones + (self._rest[_slots(each.joints)] if each.relative else 0.0)
                for each, ones in parts
            ]
        )
        self._restart()

    def _restart(self) -> None:
        self.failure = ""
        """Why the policy cannot go on; empty: it can."""
        self._since: float | None = None
        self._target: Array = self._rest
        self._clock = 0.0
        self._due: deque[tuple[float, Array]] = deque()
        self._action: Array = np.zeros(len(self._p.outputs))
        self._before: tuple[float, Array] | None = None
        """Time and joint angles of the last call."""
        self._joint_velocity: Array = np.zeros(len(JOINTS))
        """Angular velocity of the joints, rad/s."""
        self._pasts: dict[int, deque[Array]] = {}
        self._observations: deque[Array] = deque(maxlen=self._p.history)

    def holding(self, frame: SensorFrame) -> tuple[float, ...]:
        """See `JointCompliance.holding`."""
        return self._compliance.holding(frame)

    def settle(self, estimate: Estimate) -> None:
        """One cycle before a walk, which begins without a history."""
        self._restart()

    def update(
        self, plan: Plan, support_state: SupportState, estimate: Estimate, frame: SensorFrame, dt: float
    ) -> tuple[tuple[float, ...], Corrections]:
        """One cycle, once per received frame; arguments and result as of `Stabilizer.update`."""
        assert plan.policy is not None
        self._clock += dt
        self._since = self._since + dt if self._since is not None else self._p.cycle
        if self._since >= self._p.cycle - _EPSILON and not self.failure:
            # the mean time between two calls is right; there are no two in one cycle
            self._since = min(self._since - self._p.cycle, self._p.cycle)
            self._call(plan.policy, estimate, frame)
        while self._due and self._due[0][0] <= self._clock + _EPSILON:
            self._target = self._due.popleft()[1]
        return self._within_ranges(), Corrections()

    def _call(self, command: PolicyCommand, estimate: Estimate, frame: SensorFrame) -> None:
        position = np.array(frame.position)
        if self._before is not None and self._clock > self._before[0]:
            self._joint_velocity = (position - self._before[1]) / (self._clock - self._before[0])
        self._before = self._clock, position
        parts: list[Array] = []
        for i, each in enumerate(self._p.observation):
            found = np.asarray(_VALUES[each.term](self, each, command, estimate, frame), dtype=np.float64)
            value = np.asarray(each.scale) * (found + np.asarray(each.offset))
            past = self._pasts.setdefault(i, deque([value] * each.history, maxlen=each.history))
            past.append(value)
            parts.extend(past)
        observation = np.concatenate(parts)
        if not self._observations:
            self._observations.extend([observation] * self._p.history)
        self._observations.append(observation)
        try:
            action = self._network(np.concatenate(self._observations))
        except ConfigurationError as error:
            self.failure = str(error).rstrip(".")
            return
        if not np.isfinite(action).all():
            pairs = zip(self._p.outputs, action, strict=True)
            names = [joint for joint, value in pairs if not math.isfinite(value)]
            self.failure = f"the policy gave a number that is not finite for {', '.join(names)}"
            return
        self._action = action if self._p.clip is None else np.clip(action, *self._p.clip)
        target = self._rest.copy()
        target[self._turned] = (self._scale * self._action + self._offset)[self._kept]
        self._due.append((self._clock + self._p.delay, target))

    def _within_ranges(self) -> tuple[float, ...]:
        angles = np.clip(self._target, self._low, self._high).tolist()
        for side, ankle in self._ankles.items():
            pitch, roll = INDEX[f"{side}AnklePitch"], INDEX[f"{side}AnkleRoll"]
            angles[roll] = ankle.clip_roll(angles[roll], angles[pitch])
        return tuple(angles)

    def _angular_velocity(self, term: ObservationTerm, estimate: Estimate, frame: SensorFrame) -> Array:
        rates = np.array(estimate.base.angular_velocity)
        return rates if term.frame == "torso" else rotation(*estimate.base.lean, 0.0) @ rates

    def _linear_velocity(self, term: ObservationTerm, estimate: Estimate) -> Array:
        turn = estimate.base.pose.frames[0, :3, :3]
        if term.frame == "heading":
            turn = rotation(0.0, 0.0, heading(turn))
        return np.asarray(turn.T @ estimate.base.velocity)

    def _positions(self, term: ObservationTerm, frame: SensorFrame) -> Array:
        slots = self._slots[term]
        return np.array(frame.position)[slots] - (self._rest[slots] if term.relative else 0.0)


def _slots(joints: tuple[str, ...] | list[str]) -> list[int]:
    return [INDEX_WITH_MIRROR[joint] for joint in joints]


_Value = Callable[[PolicyRunner, ObservationTerm, PolicyCommand, Estimate, SensorFrame], object]
_VALUES: Final[dict[str, _Value]] = {
    "base_angular_velocity": lambda runner, term, u, e, f: runner._angular_velocity(term, e, f),
    "base_linear_velocity": lambda runner, term, u, e, f: runner._linear_velocity(term, e),
    "projected_gravity": lambda runner, term, u, e, f: -rotation(*e.base.lean, 0.0)[2],
    "fused_angle": lambda runner, term, u, e, f: f.angle,
    "velocity_command": lambda runner, term, u, e, f: u.velocity,
    "joint_position": lambda runner, term, u, e, f: runner._positions(term, f),
    "joint_velocity": lambda runner, term, u, e, f: runner._joint_velocity[runner._slots[term]],
    "previous_action": lambda runner, term, u, e, f: runner._action,
    "gait_phase_sin": lambda runner, term, u, e, f: [u.amplitude * math.sin(math.tau * u.turns)],
    "gait_phase_cos": lambda runner, term, u, e, f: [u.amplitude * math.cos(math.tau * u.turns)],
    "foot_contact": lambda runner, term, u, e, f: [float(e.contacts.left), float(e.contacts.right)],
    "foot_force": lambda runner, term, u, e, f: [sum(f.fsr[:4]), sum(f.fsr[4:])],
}
"""Values of the terms, before offset and scale."""
