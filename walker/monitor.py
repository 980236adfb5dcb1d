"""Consequences of the robot's state for its plan: contacts, ground, falls, feedback; and the answers' delay.

The delay is estimated from the frames alone. Sensor frame k names the frame whose answer was in force in the
cycle before it (`command`); on a good link that is k - 1. The difference to k - 1 is the delay of the whole
loop in cycles: way to the walker, tick, way back, wait for the boundary. No clocks are compared.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from bridge.body.kinematics import FloatingBase, Transform, homogeneous
from bridge.messages import SensorFrame
from bridge.rotations import R_yaw
from bridge.types import Side, Vec2
from walker.estimation.contact import ContactEstimator, Contacts, FootForces
from walker.estimation.fall import FallDetector, FallPredictor
from walker.estimation.ground import Corrections, GroundTilt
from walker.estimation.state import BaseState
from walker.gaits.plan import NO_FEEDBACK, Feedback, Plan, SolePose
from walker.mechanisms.capture_step import CaptureEstimator, landed_foot
from walker.mechanisms.foothold_feedback import DeviationEstimator
from walker.mechanisms.hold import HeadingError, VelocityHold
from walker.mechanisms.tipping import TippingDetector
from walker.parameters import ControllerParameters

DELAY_TIME_CONSTANT: Final = 0.5
"""s; of the mean: it ignores a single late answer, and gaps that the guard handles."""
RESTART_GAP: Final = 0.25
"""s without a frame after which the mean restarts: meanwhile the guard's commands are in force."""
MAX_DELAY: Final = 0.040
"""s; a delay counts as no more, so that one gap that the guard bridges does not end a walk."""


class DelayEstimator:
    """Mean delay of the answers; for one boot of a robot.

    Args:
        cycle: of the robot, s.
    """

    def __init__(self, cycle: float) -> None:
        self._cycle = cycle
        self._first: int | None = None
        self._seq = 0
        self.mean = 0.0
        """s; weighted with exp(-age / `DELAY_TIME_CONSTANT`), each delay at most `MAX_DELAY`."""
        self.gap = 0.0
        """Age of the last answer in force beyond the mean, s; 0 before the first one."""

    def update(self, frame: SensorFrame) -> None:
        """The next frame that is answered."""
        cycles = frame.seq - self._seq
        self._seq = frame.seq
        self.gap = 0.0
        if self._first is None:
            self._first = frame.seq
            return
        # The answer in force before this controller's first one is not its own.
        late = frame.seq - 1 - max(frame.command, self._first - 1)
        if frame.command >= self._first:
            self.gap = max(0.0, late * self._cycle - self.mean)
        if cycles * self._cycle > RESTART_GAP:
            self._first = frame.seq
            return
        weight = min(1.0, cycles * self._cycle / DELAY_TIME_CONSTANT)
        self.mean += weight * (min(late * self._cycle, MAX_DELAY) - self.mean)


class Estimate(NamedTuple):
    """The measured state, and what follows from it in one cycle."""

    base: BaseState
    contacts: Contacts = Contacts(False, False)
    zmp: Vec2 | None = None
    """Measured zero moment point in the walk frame, m; None without load."""
    fall: str = ""
    """Why the robot falls; empty: it does not."""
    ground: Vec2 = (0.0, 0.0)
    """Roll and pitch of the ground under the standing feet, rad."""
    delay: float = 0.0
    """Mean lateness of answers at the robot, s."""
    gap: float = 0.0
    """Age of the answer in force beyond that, s."""
    feedback: Feedback = NO_FEEDBACK
    """For the gait, in the walk frame."""


class Monitor:
    """Compares the measured state with the plan, once per received frame.

    Args:
        base: kinematics of the body.
        parameters: which estimates are made, and their numbers.
        cycle: of the robot, s.
        predicts_falls: a predicted fall (`FallPredictor`) counts as one.
    """

    def __init__(
        self,
        base: FloatingBase,
        parameters: ControllerParameters,
        cycle: float,
        *,
        predicts_falls: bool = False,
    ) -> None:
        body, on, latency = base.body, parameters.switches, parameters.latency
        self._contact = ContactEstimator(parameters.contact)
        self._fall = FallDetector(parameters.fall)
        self._fall_predictor = FallPredictor(parameters.foresight) if predicts_falls else None
        self._forces = FootForces(body)
        self._ground = GroundTilt(parameters.ground, body, cycle)
        self._height = body.lengths.FootHeight
        self._delay = DelayEstimator(cycle)
        self._deviation = DeviationEstimator(
            parameters.deviation,
            base,
            cycle,
            latency,
            deviation=on.foothold_feedback,
            placement=on.foot_placement,
        )
        self._capture = CaptureEstimator(parameters.capture, base, latency) if on.capture_step else None
        self._base, self._latency = base, latency
        self._heading_error = HeadingError(latency, cycle) if on.heading_hold else None
        self._velocity_hold = VelocityHold(parameters.velocity_hold) if on.velocity_hold else None
        self._tipping = TippingDetector(parameters.tipping) if on.step_hold else None

    def update(
        self,
        frame: SensorFrame,
        base: BaseState,
        dt: float,
        plan: Plan,
        corrections: Corrections,
        *,
        walking: bool,
    ) -> Estimate:
        """One cycle.

        Args:
            frame: newest sensor frame.
            base: state of the robot by that frame.
            dt: time since the last frame, s.
            plan: the plan in force: feet in contact are taken as fixed and level where it put them.
            corrections: of the last cycle.
            walking: as in `FallDetector.update`.
        """
        contacts = self._contact.update(frame.fsr)
        angle, here = base.angle, base.middle
        zmp = self._zmp(frame, contacts, plan)
        capturing = plan.capture is not None
        fall = self._fall.update(angle, contacts, dt, walking=walking, capturing=capturing)
        moves = plan.phase != "stand"
        ground = self._ground.update(frame, angle, corrections, dt, walking=moves, capturing=capturing)
        self._delay.update(frame)
        if self._fall_predictor is not None:
            predicted = self._fall_predictor.update(frame, base, plan, dt)
            fall = fall or (predicted if not contacts.none else "")
        feedback = self._deviation.update(base.com, plan, dt)
        if self._capture is not None:
            measured = self._capture.update(base, sum(frame.fsr), plan, dt)
            landed = landed_foot(base, plan, self._base, self._latency)
            feedback = feedback._replace(capture_step=measured, landed=landed)
        if self._heading_error is not None:
            feedback = feedback._replace(heading=self._heading_error.update(here.yaw, plan))
        if self._velocity_hold is not None:
            feedback = feedback._replace(velocity=self._velocity_hold.update(here, plan, dt))
        if self._tipping is not None:
            feedback = self._tipping.update(feedback, plan, dt)
        return Estimate(base, contacts, zmp, fall, ground, self._delay.mean, self._delay.gap, feedback)

    def _zmp(self, frame: SensorFrame, contacts: Contacts, plan: Plan) -> Vec2 | None:
        feet: dict[Side, Transform] = {}
        if contacts.left:
            feet["L"] = self._pose(plan.left)
        if contacts.right:
            feet["R"] = self._pose(plan.right)
        point = self._forces.zmp(frame.fsr, feet)
        return None if point is None else (float(point[0]), float(point[1]))

    def _pose(self, foot: SolePose) -> Transform:
        return homogeneous(R_yaw(foot.yaw), (foot.x, foot.y, self._height))
