"""A gait whose joint angles a network gives: its plan has the command, the clock of steps, and where it leads.

`walker.policy` calls the network. The planned soles are side by side where the command has led so far.
"""

from __future__ import annotations

from pathlib import Path
from typing import Final, NamedTuple

from bridge.body import Body
from bridge.body.joints import INDEX_WITH_MIRROR, JOINTS, LEG_SLOTS
from bridge.body.kinematics import CentreOfMass, sole_in_torso
from bridge.errors import ConfigurationError
from bridge.planar import Pose2D
from bridge.types import SIDES, Vec3
from walker.functions import clip
from walker.gaits.gait import GaitCommand
from walker.gaits.learned.network import Network
from walker.gaits.learned.parameters import LearnedParameters
from walker.gaits.plan import Phase, Plan, PolicyCommand, SolePose

_EPSILON: Final = 1e-9
"""s"""
_REST: Final[Vec3] = (0.0, 0.0, 0.0)


class LearnedState(NamedTuple):
    """State of the gait."""

    phase: Phase = "stand"
    time: float = 0.0
    """In the phase, s."""
    turns: float = 0.0
    """Turns of the clock since its phase 0."""
    amplitude: float = 0.0
    """Amplitude of sine and cosine, 0..1."""
    step: int = 0
    velocity: Vec3 = _REST
    """The command as the network gets it, m/s, m/s, rad/s."""
    place: Pose2D = Pose2D()
    """Where the command has led to."""


class LearnedGait:
    """A policy's gait.

    Args:
        parameters: the sheet; the path of its network is absolute.
        body: data sheet.
        name: `onnx:SHEET`.

    Raises:
        ConfigurationError: the network cannot be loaded or does not fit the sheet, or the default pose is
            beyond a joint's range.
    """

    quasi_static: Final = False
    adjustable: Final = True

    def __init__(self, parameters: LearnedParameters, body: Body, name: str) -> None:
        self.name, self.parameters, self.limits = name, parameters, parameters.command
        self.default_pose = parameters.pose
        """25 angles in frame order, rad."""
        for joint in parameters.default_pose:
            slot = INDEX_WITH_MIRROR[joint]
            sheet, angle = body.joints.get(JOINTS[slot]), self.default_pose[slot]
            if sheet is not None and not sheet.lower <= angle <= sheet.upper:
                raise ConfigurationError(
                    f"gait {name}: default_pose.{joint} is {angle:g} rad; a {body.name} reaches "
                    f"{sheet.lower:.3f} to {sheet.upper:.3f}."
                )
        self.network = self.load()
        """Gives the outputs."""
        soles = [sole_in_torso(body, side, [self.default_pose[s] for s in LEG_SLOTS[side]]) for side in SIDES]
        com = CentreOfMass(body)(self.default_pose)
        self._half = 0.5 * float(soles[0][1, 3] - soles[1][1, 3])
        self._com = float(com[0] - 0.5 * (soles[0][0, 3] + soles[1][0, 3]))
        self._hip_height = -float(soles[0][2, 3]) - body.lengths.HipOffsetZ

    def load(self) -> Network:
        """The network of the sheet."""
        p = self.parameters
        return Network(Path(p.model), p.inputs, len(p.outputs))

    def initial(self) -> LearnedState:
        """At rest."""
        return LearnedState()

    def step(self, state: LearnedState, dt: float, command: GaitCommand) -> tuple[Plan, LearnedState]:
        """The plan and the state `dt` seconds later; see `Gait.step`."""
        state = self._advanced(state, dt, command)
        return self._plan(state), state

    def _advanced(self, x: LearnedState, dt: float, u: GaitCommand) -> LearnedState:
        p = self.parameters.phase
        if x.phase == "stand":
            if not u.walk:
                return x
            return x._replace(phase="DSL", time=0.0, turns=p.start, amplitude=0.0 if p.ramp else 1.0)
        stops = x.phase == "stop"
        if stops and x.time + dt >= p.stop_time - _EPSILON:
            return x._replace(phase="stand", time=0.0, amplitude=0.0, step=x.step + 1, velocity=_REST)
        wanted = _REST if stops else self.limits.clipped(u.velocity or self.limits.default)
        rates = self.limits.acceleration
        v_x, v_y, w = (
            v + clip(g - v, -a * dt, a * dt) for v, g, a in zip(x.velocity, wanted, rates, strict=True)
        )
        place = x.place.pose(Pose2D(v_x * dt, v_y * dt, w * dt))
        shrinks = stops and p.standing == "zero"
        amplitude = clip(x.amplitude + (-1.0 if shrinks else 1.0) * (dt / p.ramp if p.ramp else 1.0), 0.0, 1.0)
        turns = x.turns + dt / p.period
        x = x._replace(time=x.time + dt, turns=turns, amplitude=amplitude, velocity=(v_x, v_y, w), place=place)
        steps = int(2.0 * (turns - p.start) + _EPSILON)
        if stops or steps == x.step:
            return x
        if not u.walk or 0 < u.last_step <= steps + 1:  # the stop counts as the closing step
            return x._replace(phase="stop", time=0.0, step=steps)
        return x._replace(phase="DSR" if steps % 2 else "DSL", step=steps)

    def _plan(self, x: LearnedState) -> Plan:
        (c_x, c_y), half = x.place.point(self._com, 0.0), self._half
        left, right = (x.place.pose(Pose2D(0.0, y)) for y in (half, -half))
        length = self.parameters.phase.stop_time if x.phase == "stop" else 0.5 * self.parameters.phase.period
        since = x.time if x.phase == "stop" else (2.0 * (x.turns - self.parameters.phase.start) % 1.0) * length
        return Plan(
            phase=x.phase,
            support="both",
            progress=0.0 if x.phase == "stand" else min(since / length, 1.0),
            step=x.step,
            left=SolePose(left.x, left.y, yaw=left.yaw),
            right=SolePose(right.x, right.y, yaw=right.yaw),
            com=(c_x, c_y),
            zmp=(c_x, c_y),
            hip_height=self._hip_height,
            policy=PolicyCommand(x.velocity, x.turns, x.amplitude),
        )
