"""The controller: a pure function of its state and a sensor frame.

One tick: estimate, let the state answer, one actuator frame. No clock, no I/O: the same object runs in a test,
in lockstep, in real time and on a robot. Orders (walk, stop, other controllers) arrive between two ticks; their
effect depends on the frame before which they arrive, and on nothing else.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from bridge.body import Body
from bridge.body.kinematics import FloatingBase
from bridge.histogram import Percentiles
from bridge.messages import ActuatorFrame, SensorFrame, WalkTelemetry
from bridge.motion import GetUp, Lying, MotionPlayer, lying
from bridge.planar import Pose2D
from bridge.types import Vec3
from walker.estimation.ground import Corrections
from walker.estimator import Estimator
from walker.gaits import Gait, Plan
from walker.gaits.learned.gait import LearnedGait
from walker.gaits.order import Steering, WalkEnd, WalkOrder, WalkPlanner
from walker.monitor import Estimate, Monitor
from walker.parameters import ControllerParameters, controller_parameters
from walker.states.down import Fallen, Moving, Recovery, Resting
from walker.states.setup import WalkSetup, set_up_walk
from walker.states.state import State, StateName, UpperBodyOrders
from walker.states.upright import Approaching, Standing, Walking
from walker.transitions import ENDINGS, TRANSITIONS, WALKING, Situation, Transition, Verb

__all__ = ["Controller", "WalkOrder"]


class Controller:
    """Walks by a gait.

    Args:
        body: data sheet of the robot.
        gait: to walk by.
        order: bounds of the walk; None: stand, and wait for `begin`.
        cycle: of the robot, s.
        parameters: of the controllers; None: the gait's shipped ones.
        recover: get up after a fall and resume the order, where the body has motions for that. A robot that
            sits, or rests where an ordered motion ended, gets up in any case.

    Raises:
        ConfigurationError: no torso controller can be designed to the parameters.
        UnreachableError: the gait's stand is out of the legs' reach.
    """

    def __init__(
        self,
        body: Body,
        gait: Gait[Any],
        order: WalkOrder | None,
        cycle: float,
        parameters: ControllerParameters | None = None,
        *,
        recover: bool = False,
    ) -> None:
        p = parameters or controller_parameters(gait.name)
        walk = self._walk = set_up_walk(body, gait, order or WalkOrder(), cycle, p)
        self._body, self._cycle, self._waits_for_orders = body, cycle, order is None
        self._planner = WalkPlanner(gait, walk.order)
        self._walking = Walking(self._planner, walk.support_machine(), walk.stabilizer)
        after = self._walking if order is not None else Standing(walk.goal, walk.stabilizer, Corrections())
        self._state: State = Approaching(walk.goal, after, walk.stabilizer.holding)
        self._next: WalkSetup | None = None
        self._hold = math.inf
        self._fell = False
        """Since the last walk began."""
        self._recovery = Recovery(body, after_falls=recover)
        self._resumes = False
        """The robot fell out of a walk: its order is resumed once it stands."""
        self._player: MotionPlayer | GetUp | None = None
        """Player of an ordered motion that has not begun."""
        self._began = self.plan
        self.upper_body = UpperBodyOrders()
        self.interruptions = 0
        """Number of walks resumed from a stand, after a gap too long for resuming in stride."""
        self.fall_cause = ""
        """Reason of the last detected or predicted fall."""
        self.failure = ""
        """Why the last walk ended before its order was carried out; empty: it did not."""
        self._kinematics = FloatingBase(body)
        self._estimator = Estimator(self._kinematics, p)
        self._walk_end = WalkEnd(p.latency, cycle)
        self._steering: Steering | None = None
        """To the order's target, once the walk has begun."""
        self._monitor = self._make_monitor()
        self._estimate = Estimate(self._estimator.state)
        self._seq: int | None = None
        self.lying_side: Lying = "upright"
        """Side on which the robot lies."""
        self._verbs: Mapping[Verb, Callable[[SensorFrame], None]] = {
            "get up": self._get_up,
            "stop": lambda _: self.stop(),
            "fall": self._fall,
            "resume": self._resume,
            "stand up": self._stand_up,
            "lie": self._lie,
            "rest": self._rest,
            "interrupt": self._interrupt,
            "fail": self._fail,
            "capture step": self._begin_capture_step,
            "play": self._play,
            "begin": self._begin,
            "steer": self._steer_to_target,
            "arrive": self._arrive,
            "stand": self._stand,
        }

    @property
    def motion_waits(self) -> bool:
        """An ordered motion has not begun yet."""
        return self._player is not None

    @property
    def state(self) -> StateName:
        """Name of the state in force."""
        return self._state.name

    @property
    def done(self) -> bool:
        """The order is carried out (standing again, settled), or the robot fell and rests.

        Never, while the controller waits for orders.
        """
        state = self._state
        if self._waits_for_orders or state.name not in ("stand", "fallen") or self._recovery.pending(state):
            return False
        return state.settled >= self._planner.order.settle

    @property
    def recoveries(self) -> int:
        """Number of times that the robot got up from lying."""
        return self._recovery.count

    @property
    def plan(self) -> Plan:
        """Plan of the last tick."""
        return self._planner.plan

    @property
    def walk(self) -> WalkSetup:
        """The walk under way, or the last one."""
        return self._walk

    @property
    def lies(self) -> bool:
        """The robot fell, and has not been put on its feet."""
        return self._state.name == "fallen" and bool(self._estimate.fall)

    @property
    def inference(self) -> Percentiles | None:
        """Wall time of the calls of a learned gait's network; None: the gait has none."""
        gait = self._walk.gait
        return gait.network.times.percentiles() if isinstance(gait, LearnedGait) else None

    @property
    def airborne(self) -> bool:
        """No foot touches the ground."""
        return self._estimate.contacts.none

    @property
    def delay(self) -> float:
        """Mean lateness of answers at the robot over about half a second, s."""
        return self._estimate.delay

    @property
    def odometry_pose(self) -> Pose2D:
        """Middle between the feet by the odometry since the first tick."""
        return self._estimator.state.middle

    @property
    def planned_pose(self) -> Pose2D:
        """Middle between the planned feet since the first tick: the origin of plans, not of the world."""
        return self.plan.middle

    @property
    def walked(self) -> float:
        """Way of this walk, or the last one, by the plan, m."""
        return math.dist(self.plan.middle[:2], self._began.middle[:2])

    def begin(self, walk: WalkSetup, hold: float = math.inf) -> None:
        """Walk: from a stand at once, in stride where the gait can, otherwise after closing the feet.

        A walk with bounds of its own begins at a stand. After a fall it begins once the robot is upright again.

        Args:
            walk: new.
            hold: time after which the walk ends unless `begin` is called again, s.
        """
        self._hold, self._player = hold, None
        if isinstance(self._state, Walking) and self._in_stride(walk):
            self.adjust(walk)
            self._planner.order, self._steering = walk.order, None
        else:
            self._next = walk
            self._walking.stop()  # also a walk that waits behind an approach

    def extend_hold(self, hold: float) -> None:
        """Let the walk under way end this long from now, s, unless it is extended again."""
        self._hold = hold

    def adjust(self, walk: WalkSetup) -> None:
        """Apply the parts of a walk that change in stride: controllers, and the velocity if the gait can.

        Without effect at rest: `begin` describes the next walk.
        """
        state, now = self._state, self._walk
        if not isinstance(state, Walking) or walk.gait.name != now.gait.name:
            return
        if walk.parameters != now.parameters:
            state.switch(walk.stabilizer, walk.support_machine())
            now = replace(now, parameters=walk.parameters, stabilizer=walk.stabilizer)
        self._walk = now
        if walk.step is not None and now.gait.adjustable:
            self._walk = replace(now, step=walk.step)
            self.steer(walk.velocity)

    def steer(self, velocity: Vec3) -> None:
        """Change to another velocity from the next step on, by a gait that is `adjustable`.

        Args:
            velocity: forward and to the left, m/s, and turn, rad/s.
        """
        self._planner.velocity = velocity
        self._walk = replace(self._walk, velocity=velocity)

    def _steer_to_target(self, _: SensorFrame) -> None:
        """The velocity towards the order's target; at the target the feet close."""
        order, limits = self._planner.order, self._walk.gait.limits
        if order.target is None or limits is None:
            return
        if self._steering is None:
            x, y, turn = order.target
            goal = self.odometry_pose.pose(Pose2D(x, y, turn))
            self._steering = Steering(limits, goal, order.share)
            self._walk_end = WalkEnd(self._walk.parameters.latency, self._cycle)
        stop_poses = self._walk_end.update(self.odometry_pose, self.plan)
        if stop_poses and self._steering.arrived(*stop_poses):
            self._walking.stop()
        elif stop_poses:
            self.steer(self._steering.velocity(stop_poses[1]))

    def stop(self) -> None:
        """Close the feet and stand; drops a walk or a motion that has not begun."""
        self._next = self._player = None
        self._walking.stop()  # also a walk that waits behind an approach

    def play(self, player: MotionPlayer | GetUp) -> None:
        """Play a motion: at once from rest or lying, after closing the feet from a walk.

        Afterwards the robot stands if the motion ended standing and stiff; otherwise it rests where it ended.

        Args:
            player: at the beginning of its motion.
        """
        self.stop()
        self._player, self._resumes = player, False

    def tick(self, frame: SensorFrame) -> ActuatorFrame:
        """One cycle.

        Args:
            frame: newest sensor frame; the plan's time makes up for lost frames. After more than
                `ControllerParameters.max_gap` without a new answer at the robot, the walk resumes from a stand.
        """
        first, dt = self._seq is None, self._elapsed(frame.seq)
        self.lying_side = lying(frame.angle)
        base = self._estimator.update(frame, dt, self.plan.middle.yaw)
        walking = self._state.name in WALKING
        # The corrections are those of the last cycle, from before a transition.
        self._estimate = self._monitor.update(
            frame, base, dt, self.plan, self._state.corrections, walking=walking
        )
        if walking:
            self._hold -= dt
        if self._change_state(TRANSITIONS, frame, first=first):
            self._state.advance(frame, self._estimate, dt)
            self._change_state(ENDINGS, frame)
        # Last: an order for head and arms overrides the state's angles.
        position, stiffness = self.upper_body.merged(self._state, dt)
        return ActuatorFrame(reply_to=frame.seq, position=position, stiffness=stiffness)

    def _change_state(self, table: Sequence[Transition], frame: SensorFrame, *, first: bool = False) -> bool:
        """Carry out the rows that hold; whether the state is to answer this frame."""
        situation = self._situation(frame, first=first)
        for row in table:
            if situation.state.name in row.states and row.condition(situation):
                self._verbs[row.next](frame)
                if row.last:
                    return False
                situation = self._situation(frame, first=first)
        return True

    def _situation(self, frame: SensorFrame, *, first: bool) -> Situation:
        return Situation(
            state=self._state,
            frame=frame,
            estimate=self._estimate,
            parameters=self._walk.parameters,
            recovery=self._recovery,
            lying_side=self.lying_side,
            first=first,
            hold_over=self._hold <= 0.0,
            motion_ordered=self._player is not None,
            walk_ordered=self._next is not None,
            target_ordered=self._planner.order.target is not None,
            goes_on=self._next is None and (self._resumes or not self._waits_for_orders),
            waits_for_orders=self._waits_for_orders,
            fell=self._fell,
        )

    def _make_monitor(self) -> Monitor:
        """A monitor without history; a robot that can get up predicts its falls."""
        falls = self._recovery.after_falls
        return Monitor(self._kinematics, self._walk.parameters, self._cycle, predicts_falls=falls)

    @property
    def _is_down(self) -> bool:
        return isinstance(self._state, Fallen) or self.lying_side != "upright"

    def _get_up(self, frame: SensorFrame) -> None:
        self._state = self._recovery.get_up(frame, from_lying=self._is_down)

    def _fall(self, frame: SensorFrame) -> None:
        """Yield, and drop all orders; a walk under way may be resumed later."""
        state, self._next, self._player = self._state, None, None
        self.fall_cause = self._estimate.fall
        self._resumes = state.name == "walk" or (isinstance(state, Approaching) and not state.to_stand)
        self._state = Fallen(frame, self._walk.parameters.fall, braces=self._recovery.after_falls)

    def _lie(self, frame: SensorFrame) -> None:
        self._state = Fallen(frame, self._walk.parameters.fall, gave_up=True)

    def _rest(self, _: SensorFrame) -> None:
        self._state = Resting(self._state.position)

    def _play(self, frame: SensorFrame) -> None:
        assert self._player is not None
        self._state, self._player = Moving(self._player, frame.position, from_lying=self._is_down), None

    def _arrive(self, _: SensorFrame) -> None:
        assert isinstance(self._state, Approaching)
        self._state = self._state.successor

    def _stand(self, _: SensorFrame) -> None:
        assert isinstance(self._state, Walking)
        self._state = self._state.standing()

    def _elapsed(self, seq: int) -> float:
        """Time since the last frame, s."""
        cycles = seq - self._seq if self._seq is not None else 0
        self._seq = seq
        return min(max(cycles, 0) * self._cycle, max(self._walk.parameters.max_gap, self._cycle))

    def _in_stride(self, walk: WalkSetup) -> bool:
        """Whether the walk under way can turn into this one without a stand."""
        now = self._walk
        return (
            self._state.name == "walk"
            and walk.gait.name == now.gait.name
            and not walk.order.bounded
            and (walk.step == now.step or now.gait.adjustable)
        )

    def _restart_walk(
        self,
        planner: WalkPlanner,
        approach: Callable[[SensorFrame], tuple[float, ...]] | None,
        *,
        to_stand: bool = False,
        blend: State | None = None,
        walked: float = 0.0,
        forget: bool = False,
    ) -> None:
        """Begin at a plan: the one entry to a walk or a stand.

        Args:
            planner: at the beginning of its walk.
            approach: first joint angles of a slow transfer to the stand; None: no transfer, walk at once.
            to_stand: stand afterwards; otherwise walk.
            blend: state from whose joint angles the walk is blended in; None: begin at the plan.
            walked: time already spent on the order, s.
            forget: drop the history of all estimates.
        """
        walk, self._planner = self._walk, planner
        successor: Walking | Standing
        if to_stand:
            successor = Standing(walk.goal, walk.stabilizer, Corrections())
        else:
            machine = walk.support_machine()
            successor = self._walking = Walking(planner, machine, walk.stabilizer, blend, walked)
        self._state = successor if approach is None else Approaching(walk.goal, successor, approach)
        if forget:
            self._estimator.restart(walk.parameters)
            self._monitor = self._make_monitor()

    def _stand_up(self, _: SensorFrame) -> None:
        """Move from any joint angles to the stand, without the history of the walk that ended in a fall."""
        self._recovery.note_end(self._state)
        walk, self._fell = self._walk, True
        planner = WalkPlanner(walk.gait, walk.order, self.planned_pose, self.plan.step)
        self._restart_walk(planner, walk.stabilizer.holding, to_stand=True, forget=True)

    def _resume(self, _: SensorFrame) -> None:
        """Move from any joint angles to the stand, and from there walk to the end of the order."""
        self._recovery.note_end(self._state)
        walk = self._walk = self._walk.with_fresh_controllers()
        now, before, stops = self._planner, self._walking, self._walking.name == "stopping"
        planner = WalkPlanner(walk.gait, now.order, self.planned_pose, self.plan.step, now.velocity)
        self._restart_walk(planner, walk.stabilizer.holding, walked=before.walked, forget=True)
        if stops:
            self._walking.stop()

    def _interrupt(self, frame: SensorFrame) -> None:
        """Resume from a stand after a gap that is too long for resuming in stride."""
        self._resume(frame)
        self._estimate = self._estimate._replace(delay=0.0)  # so does the mean of the new monitor
        self.interruptions += 1

    def _fail(self, _: SensorFrame) -> None:
        """Hold the last joint angles, and move slowly from them to the stand; the order is given up."""
        assert isinstance(self._state, Walking)
        held, walk = self._state.position, self._walk
        self.failure = self._state.failure
        planner = WalkPlanner(walk.gait, walk.order, self.planned_pose, self.plan.step)
        self._restart_walk(planner, lambda _: held, to_stand=True)

    def _begin(self, _: SensorFrame) -> None:
        """Begin the ordered walk where the robot is: from its stand, or through the new gait's."""
        assert self._next is not None
        walk, before, state = self._next, self._walk, self._state
        failed, self._next, self._steering, self.failure = self.failure, None, None, ""
        lies = state.name == "fallen"
        fell, self._fell = lies or self._fell, False
        same = walk.parameters == before.parameters and walk.goal == before.goal and not fell
        same = same and walk.gait.name == before.gait.name and not failed
        if same:  # the corrections found for this ground stay
            walk = replace(walk, stabilizer=before.stabilizer)
        self._walk = walk
        planner, held = WalkPlanner(walk.gait, walk.order, self.planned_pose), state.position
        self._began = planner.plan
        if same:
            self._restart_walk(planner, None, blend=state)
        else:
            approach = walk.stabilizer.holding if lies else lambda _: held
            # estimates are made with the numbers of their gait
            self._restart_walk(planner, approach, forget=fell or walk.parameters != before.parameters)

    def _begin_capture_step(self, _: SensorFrame) -> None:
        """Make a capture step, then stand again."""
        planner = WalkPlanner(self._walk.gait, self._planner.order, self.planned_pose, self.plan.step)
        self._restart_walk(planner, None, blend=self._state)
        self._walking.stop()

    @property
    def telemetry(self) -> WalkTelemetry:
        """Plan, estimates and corrections of the last tick."""
        p, e, c = self.plan, self._estimate, self._state.corrections
        return WalkTelemetry(
            seq=self._seq or 0,
            state=self._state.name,
            place=self.odometry_pose,
            phase=p.phase,
            step=p.step,
            steps=self._planner.order.steps,
            zmp=p.zmp,
            com=p.com,
            left=p.left,
            right=p.right,
            angle=e.base.angle,
            zmp_measured=e.zmp,
            contact=e.contacts,
            foot_lift=c.lift,
            ankle_roll=c.ankle_roll,
            ankle_pitch=c.ankle_pitch,
            torso_control=c.torso,
            fall_cause=self.fall_cause,
            failure=self.failure,
        )
