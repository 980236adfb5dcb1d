"""The controller: a pure function of its state and a sensor frame.

One tick: estimate, let the state of the walk answer, one actuator frame. No clock, no I/O: the same object runs
in a test, in lockstep, in real time and on a robot.
"""

from __future__ import annotations

from bridge.datasheet import Body
from bridge.joints import N_JOINTS
from bridge.messages import ActuatorFrame, SensorFrame, WalkTelemetry
from walker.estimation import Contacts, Estimate, Estimator
from walker.footing import FootingMachine
from walker.gait import Foot, Gait, Reference
from walker.order import WalkOrder
from walker.parameters import ControllerParameters, controller_parameters
from walker.pose import PoseMaker
from walker.stabiliser import Stabiliser
from walker.states import Approaching, Fallen, State, StateName, Walking, WalkPlan

__all__ = ["Controller", "WalkOrder"]


class Controller:
    """Walks by a gait.

    Args:
        body: data sheet of the robot.
        gait: phase machine in its initial stand.
        order: how far to walk.
        cycle: of the robot, s.
        parameters: of the controllers; None: the gait's shipped ones.

    Raises:
        ConfigurationError: no torso controller can be designed to the parameters.
        UnreachableError: the gait's stand is out of the legs' reach.
    """

    def __init__(
        self,
        body: Body,
        gait: Gait,
        order: WalkOrder,
        cycle: float,
        parameters: ControllerParameters | None = None,
    ) -> None:
        p = self._p = parameters or controller_parameters(gait.name)
        self._cycle = cycle
        self._plan = WalkPlan(gait, order, gait.stand())
        pose = PoseMaker(body, self._plan.reference, by_pose=gait.quasi_static)
        self._stabiliser = Stabiliser(body, p, pose, cycle)
        footing = FootingMachine(p.touch_down if p.admittance else None)
        walking = Walking(self._plan, footing, self._stabiliser)
        self._state: State = Approaching(pose.angles(self._plan.reference), walking)
        self._estimator = Estimator(body, p)
        self._estimate = Estimate(Contacts(False, False), None, (0.0, 0.0), False)
        self._seq: int | None = None

    @property
    def state(self) -> StateName:
        """What the controller is doing."""
        return self._state.name

    @property
    def done(self) -> bool:
        """The order is carried out (standing again, settled), or the robot fell and lies still."""
        return self._state.name in ("stand", "fallen") and self._state.settled >= self._plan.order.settle

    @property
    def reference(self) -> Reference:
        """The plan of the last tick."""
        return self._plan.reference

    def tick(self, frame: SensorFrame) -> ActuatorFrame:
        """One cycle.

        Args:
            frame: newest sensor frame; frames that were lost in between are made up for in the plan's time, up
                to `ControllerParameters.longest_gap`.
        """
        dt = self._elapsed(frame.seq)
        walking = self._state.name in ("walk", "stopping")
        self._estimate = self._estimator.update(frame, dt, self._plan.reference, walking=walking)
        if self._estimate.falling and self._state.name != "fallen":
            self._state = Fallen(frame.position, self._p.fall.stiffness)
        else:
            self._state = self._state.advance(frame, self._estimate, dt)
        return ActuatorFrame(
            reply_to=frame.seq,
            position=self._state.position,
            stiffness=(self._state.stiffness,) * N_JOINTS,
        )

    def _elapsed(self, seq: int) -> float:
        """Time since the last frame, s."""
        cycles = seq - self._seq if self._seq is not None else 0
        self._seq = seq
        return min(max(cycles, 0) * self._cycle, max(self._p.longest_gap, self._cycle))

    @property
    def telemetry(self) -> WalkTelemetry:
        """Plan, estimates and corrections of the last tick."""
        r, e, c = self._plan.reference, self._estimate, self._stabiliser.corrections
        return WalkTelemetry(
            seq=self._seq or 0,
            state=self._state.name,
            phase=r.phase,
            step=r.step,
            steps=self._plan.order.steps,
            zmp=r.zmp,
            com=r.com,
            left=_place(r.left),
            right=_place(r.right),
            angle=e.angle,
            zmp_measured=e.zmp,
            contact=e.contacts,
            foot_lift=c.lift,
            ankle_roll=c.ankle_roll,
            ankle_pitch=c.ankle_pitch,
            torso_control=c.torso,
        )


def _place(foot: Foot) -> tuple[float, float, float]:
    return foot.x, foot.y, foot.z
