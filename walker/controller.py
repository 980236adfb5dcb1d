"""The controller: a pure function of its state and a sensor frame.

One tick: estimate, let the state of the walk answer, one actuator frame. No clock, no I/O: the same object runs
in a test, in lockstep, in real time and on a robot. Between two ticks it may be told to walk, to stop, or to
change its controllers; what comes of it depends on the frame before which it was told, and on nothing else.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from bridge.body import Body
from bridge.messages import ActuatorFrame, SensorFrame, WalkTelemetry
from bridge.motion import GetUp, Lying, MotionPlayer, lying
from bridge.types import Vec3
from walker.estimation import Contacts, Corrections, Estimate, Estimator
from walker.estimation.heading import GyroscopeHeading
from walker.estimation.odometry import Odometry, middle_of_soles
from walker.estimation.walk_end import WalkEnd
from walker.model.floating_base import FloatingBase
from walker.planning import Foothold, Gait, Plan
from walker.planning.order import WalkOrder
from walker.planning.planner import WalkPlanner
from walker.planning.steering import Steering
from walker.stabilization.parameters import ControllerParameters, controller_parameters
from walker.states import Approaching, Fallen, Moving, Resting, Standing, State, StateName, Walking
from walker.states.ready import ReadyWalk, ready_walk
from walker.states.recovery import Recovery
from walker.states.upper_body import UpperBodyOrders

__all__ = ["Controller", "WalkOrder"]


class Controller:
    """Walks by a gait.

    Args:
        body: data sheet of the robot.
        gait: to walk by.
        order: how far to walk; None: stand, and wait for `begin`.
        cycle: of the robot, s.
        parameters: of the controllers; None: the gait's shipped ones.
        recover: get up after a fall and go on with the order, where the body has motions for that. A robot that
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
        walk = self._walk = ready_walk(body, gait, order or WalkOrder(), cycle, p)
        self._body, self._cycle, self._serves = body, cycle, order is None
        self._planner = WalkPlanner(gait, walk.order)
        self._walking = Walking(self._planner, walk.support_machine(), walk.stabilizer)
        after = self._walking if order is not None else Standing(walk.goal, walk.stabilizer, Corrections())
        self._state: State = Approaching(walk.goal, after, walk.stabilizer.holding)
        self._next: ReadyWalk | None = None
        self._hold = math.inf
        self._fell = False
        """Since the last walk began."""
        self._recovery = Recovery(body, after_falls=recover)
        self._player: MotionPlayer | GetUp | None = None
        """Of an ordered motion that has not begun."""
        self._began = self.plan
        self.upper_body = UpperBodyOrders()
        self.interruptions = 0
        """How often the walk went on from a stand, after a gap that was too long to go on in stride."""
        self._kinematics = FloatingBase(body)
        self._odometry = Odometry(self._kinematics, gyroscope=GyroscopeHeading.of(body))
        self._walk_end = WalkEnd(p.deviation.latency, cycle)
        self._steering: Steering | None = None
        """To the order's target, once the walk has begun."""
        self.here = Foothold()
        """Middle between the feet by the odometry since the first tick."""
        self._estimator = self._make_estimator()
        self._estimate = Estimate(Contacts(False, False), None, (0.0, 0.0), False)
        self._seq: int | None = None
        self.below: Lying = "upright"
        """What of the robot is below."""

    @property
    def motion_waits(self) -> bool:
        """An ordered motion has not begun yet."""
        return self._player is not None

    @property
    def state(self) -> StateName:
        """What the controller is doing."""
        return self._state.name

    @property
    def done(self) -> bool:
        """The order is carried out (standing again, settled), or the robot fell and lies still.

        Never, while the controller waits for orders.
        """
        state = self._state
        if self._serves or state.name not in ("stand", "fallen") or self._recovery.pending(state):
            return False
        return state.settled >= self._planner.order.settle

    @property
    def recoveries(self) -> int:
        """How often the robot got up from lying."""
        return self._recovery.count

    @property
    def plan(self) -> Plan:
        """Of the last tick."""
        return self._planner.plan

    @property
    def walk(self) -> ReadyWalk:
        """The walk under way, or the last one."""
        return self._walk

    @property
    def lies(self) -> bool:
        """The robot fell, and has not been put on its feet."""
        return self._state.name == "fallen" and self._estimate.falling

    @property
    def delay(self) -> float:
        """By which answers are late at the robot, in the mean of about half a second, s."""
        return self._estimate.delay

    @property
    def place(self) -> Foothold:
        """Middle between the planned feet since the first tick: the origin of plans, not of the world."""
        return self.plan.middle

    @property
    def walked(self) -> float:
        """Way of this walk, or the last one, by the plan, m."""
        return math.dist(self.plan.middle[:2], self._began.middle[:2])

    def begin(self, walk: ReadyWalk, hold: float = math.inf) -> None:
        """Walk: from a stand at once, in stride where the gait can, otherwise after closing the feet.

        A walk with bounds of its own begins at a stand. A robot that fell begins once it is upright again.

        Args:
            walk: new.
            hold: time after which the walk ends unless `begin` came again, s.
        """
        self._hold, self._player = hold, None
        if isinstance(self._state, Walking) and self._in_stride(walk):
            self.adjust(walk)
            self._planner.order, self._steering = walk.order, None
        else:
            self._next = walk
            self._walking.stop()  # also one that is yet to begin, behind an approach

    def adjust(self, walk: ReadyWalk) -> None:
        """Take over what of a walk can be had in stride: controllers, and the velocity if the gait can.

        At rest this does nothing: what the next walk is like is said when it begins.
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
        """Go on at another velocity from the next step on, by a gait that is `adjustable`.

        Args:
            velocity: forward and to the left, m/s, and turn, rad/s.
        """
        self._planner.velocity = velocity
        self._walk = replace(self._walk, velocity=velocity)

    def _steer_to_target(self) -> None:
        """The velocity towards the order's target; at the target the feet close."""
        order, limits = self._planner.order, self._walk.gait.limits
        if order.target is None or limits is None:
            return
        if self._steering is None:
            x, y, turn = order.target
            goal = Foothold(*self.here.point(x, y), self.here.yaw + turn)
            self._steering = Steering(limits, goal, order.share)
            self._walk_end = WalkEnd(self._walk.parameters.deviation.latency, self._cycle)
        ends = self._walk_end.update(self.here, self.plan)
        if ends and self._steering.arrived(*ends):
            self._walking.stop()
        elif ends:
            self.steer(self._steering.velocity(ends[1]))

    def stop(self) -> None:
        """Close the feet and stand; drops a walk or a motion that has not begun."""
        self._next = self._player = None
        self._walking.stop()  # also one that is yet to begin, behind an approach

    def play(self, player: MotionPlayer | GetUp) -> None:
        """Play a motion: from where the robot rests or lies at once, from a walk after closing the feet.

        The robot stands afterwards if the motion ended so, stiff; otherwise it rests where it ended.

        Args:
            player: at the beginning of its motion.
        """
        self.stop()
        self._player, self._recovery.resume = player, False

    def tick(self, frame: SensorFrame) -> ActuatorFrame:
        """One cycle.

        Args:
            frame: newest sensor frame; frames that were lost in between are made up for in the plan's time.
                Where the robot had no new answer for longer than `ControllerParameters.max_gap`, the walk
                goes on from a stand.
        """
        self.below = lying(frame.angle)
        if self._seq is None and self._recovery.begins_down(frame, self.below):
            self._state = self._recovery.get_up(self._state, frame, self.below)
        dt = self._elapsed(frame.seq)
        self.here = middle_of_soles(self._kinematics, self._odometry.update(frame))
        walking = isinstance(self._state, Walking)
        self._estimate = self._estimator.update(
            frame, dt, self.plan, self._state.corrections, self.here, walking=walking
        )
        if walking:
            self._hold -= dt
            if self._hold <= 0.0:
                self.stop()
        if self._estimate.falling and self._state.name not in ("fallen", "motion", "rest"):
            self._next = self._player = None
            self._recovery.fell(walked=self._is_under_way())
            self._state = self._fallen(frame, braces=self._recovery.after_falls)
        else:
            self._recover(frame)
            if self._serves and self._recovery.put_up(self._state, frame, self._walk.parameters.fall.angle):
                self._stand_again()
            if isinstance(self._state, Walking) and self._estimate.gap > self._walk.parameters.max_gap:
                self._interrupt(self._state)
            if self._state.name == "stand" and self._estimate.feedback.capture_step is not None:
                self._begin_capture_step(self._state)
            if self._player is not None and self._state.name in ("stand", "rest", "fallen"):
                self._state, self._player = Moving(self._player, frame.position), None
            elif self._next is not None and self._may_begin():
                self._start(self._next)
            if self._state.name == "walk":
                self._steer_to_target()
            self._state = self._state.advance(frame, self._estimate, dt)
        position, stiffness = self.upper_body.merged(self._state, dt)
        return ActuatorFrame(reply_to=frame.seq, position=position, stiffness=stiffness)

    def _make_estimator(self) -> Estimator:
        """One that remembers nothing; a robot that can get up foresees its falls."""
        p = self._walk.parameters
        return Estimator(self._kinematics, p, self._cycle, p.switches, foresees=self._recovery.after_falls)

    def _is_under_way(self) -> bool:
        """Whether the robot walks, or approaches the stand before its walk."""
        state = self._state
        to_stand = isinstance(state, Approaching) and isinstance(state.successor, Standing)
        return state.name in ("walk", "approach") and not to_stand

    def _fallen(self, frame: SensorFrame, *, braces: bool = False) -> Fallen:
        return Fallen(frame, self._walk.parameters.fall, braces=braces)

    def _recover(self, frame: SensorFrame) -> None:
        """Begin to get up, or go on after a motion."""
        state, recovery = self._state, self._recovery
        if isinstance(state, Moving) and state.player.done:
            end = recovery.end(state, frame)
            if end == "on its feet":
                self._go_on()
            elif end == "stands":
                self._stand_again()
            else:
                self._state = self._fallen(frame) if end == "lies" else Resting(state.position)
        elif recovery.due(state, ordered=self._next is not None):
            self._state = recovery.get_up(state, frame, self.below)

    def _go_on(self) -> None:
        """On its feet again: to the end of the order, or stand and wait."""
        if self._next is None and (self._recovery.resume or not self._serves):
            self._begin_anew(self._walking)
        else:
            self._stand_again()

    def _elapsed(self, seq: int) -> float:
        """Time since the last frame, s."""
        cycles = seq - self._seq if self._seq is not None else 0
        self._seq = seq
        return min(max(cycles, 0) * self._cycle, max(self._walk.parameters.max_gap, self._cycle))

    def _in_stride(self, walk: ReadyWalk) -> bool:
        """Whether the walk under way can turn into this one without a stand."""
        now = self._walk
        return (
            self._state.name == "walk"
            and walk.gait.name == now.gait.name
            and not walk.order.bounded
            and (walk.step == now.step or now.gait.adjustable)
        )

    def _may_begin(self) -> bool:
        state = self._state
        if isinstance(state, Approaching) and isinstance(state.successor, Standing):
            return self._serves and not self._fell and state.near
        return state.name == "stand" or (state.name == "fallen" and not self._estimate.falling)

    def _stand_again(self) -> None:
        """From wherever the joints are into the stand, with nothing left of the walk that ended in a fall."""
        self._estimator = self._make_estimator()
        self._planner = WalkPlanner(self._walk.gait, self._walk.order, self.place, self.plan.step)
        walk = self._walk
        standing = Standing(walk.goal, walk.stabilizer, Corrections())
        self._state, self._fell = Approaching(walk.goal, standing, walk.stabilizer.holding), True

    def _interrupt(self, walking: Walking) -> None:
        """A gap that was too long to go on in stride."""
        self._begin_anew(walking)
        self._estimate = self._estimate._replace(delay=0.0)  # the mean begins anew
        self.interruptions += 1

    def _begin_anew(self, walking: Walking) -> None:
        """From wherever the joints are into the stand, and from there walk on to the end of the order."""
        walk = self._walk = self._walk.anew(self._body, self._cycle)
        before = self._planner
        self._planner = WalkPlanner(walk.gait, before.order, self.place, self.plan.step, before.velocity)
        self._walking = Walking(self._planner, walk.support_machine(), walk.stabilizer, walked=walking.walked)
        if walking.name == "stopping":
            self._walking.stop()
        self._state = Approaching(walk.goal, self._walking, walk.stabilizer.holding)
        self._estimator = self._make_estimator()

    def _start(self, walk: ReadyWalk) -> None:
        """Begin a walk where the robot is: from its stand, or by way of the new gait's."""
        self._next = self._steering = None
        before, lay = self._walk, self._state.name == "fallen"
        fell, self._fell = lay or self._fell, False
        same = walk.parameters == before.parameters and walk.goal == before.goal and not fell
        if same:  # the corrections that were found for this ground stay
            walk = replace(walk, stabilizer=before.stabilizer)
        self._walk = walk
        self._planner = WalkPlanner(walk.gait, walk.order, self.place)
        self._began = self.plan
        state = self._state
        self._walking = Walking(self._planner, walk.support_machine(), walk.stabilizer, state if same else None)
        self._state = self._walking
        if not same:
            held = state.position
            begin = walk.stabilizer.holding if lay else lambda _: held
            self._state = Approaching(walk.goal, self._walking, begin)
        if fell:
            self._estimator = self._make_estimator()

    def _begin_capture_step(self, state: State) -> None:
        """Make a capture step, and stand again."""
        walk = self._walk
        self._planner = WalkPlanner(walk.gait, self._planner.order, self.place, self.plan.step)
        self._walking = Walking(self._planner, walk.support_machine(), walk.stabilizer, state)
        self._walking.stop()
        self._state = self._walking

    @property
    def telemetry(self) -> WalkTelemetry:
        """Plan, estimates and corrections of the last tick."""
        p, e, c = self.plan, self._estimate, self._state.corrections
        return WalkTelemetry(
            seq=self._seq or 0,
            state=self._state.name,
            place=self.here,
            phase=p.phase,
            step=p.step,
            steps=self._planner.order.steps,
            zmp=p.zmp,
            com=p.com,
            left=p.left,
            right=p.right,
            angle=e.angle,
            zmp_measured=e.zmp,
            contact=e.contacts,
            foot_lift=c.lift,
            ankle_roll=c.ankle_roll,
            ankle_pitch=c.ankle_pitch,
            torso_control=c.torso,
        )
