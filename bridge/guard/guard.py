"""The guard of one robot: checks the commands to the motors, and rests a robot without a controller.

One object for emulated and real robots. It counts cycles and reads no clock: the same cycles give the same
answers, in process and in lockstep.
"""

from __future__ import annotations

import queue
import threading
from typing import Final, Literal

import msgspec

from bridge.body import Body
from bridge.body.fall import tilt
from bridge.body.joints import N_JOINTS
from bridge.body.postures import POSTURES
from bridge.errors import FrameError
from bridge.guard.config import GuardSettings
from bridge.guard.motions import Approach, CloseStance, CommandStream, Descent, SitDown, Watchdog
from bridge.guard.output import JointOutput
from bridge.guard.readings import SensorMonitor
from bridge.guard.status import FallMonitor, StatusLog, SupplyMonitor
from bridge.messages import ActuatorFrame, Notice, SensorFrame
from bridge.messages.guard import GuardStatus, Reason, State
from bridge.motion import motion_for
from bridge.stance import legs_stiff, stands

_WEAK_STIFFNESS: Final = 0.2
"""A motion of a joint with less stiffness begins at its measured angle, not at its last command."""
STAND_UP_HOLD: Final = 0.15
"""s for which a robot put on its feet is held, until its controller notices; short, because the controller
continues meanwhile."""
_DEFAULTS: Final = GuardSettings()
_Request = tuple[Literal["crouch", "limp", "arm"], str, threading.Event]


class Guard:
    """Each cycle: `check` a received command, then `cycle` with it or with None; the result goes to the motors.

    Args:
        body: data sheet: ranges, couplings, speeds.
        settings: bounds and times.
        armed: commands are taken from the start; False for real robots, until `arm`.
        dry_run: for the status; the motors get no commands.
    """

    def __init__(
        self, body: Body, settings: GuardSettings = _DEFAULTS, *, armed: bool = True, dry_run: bool = False
    ) -> None:
        self._body, self._s = body, settings
        self._motion = motion_for("sit-down", body) if settings.sit.enabled else None
        self._log = StatusLog(armed=armed, dry_run=dry_run)
        self._requests: queue.SimpleQueue[_Request] = queue.SimpleQueue()
        self._revoke = False
        self.reset()

    def reset(self) -> None:
        """Reset all but `armed` after a restart of the robot (`seq` 0)."""
        self._output = JointOutput(self._body, self._s.speed_ratio)
        self._crouch = self._output.ranges.clip(POSTURES[self._s.crouch.posture])
        self._fall = FallMonitor(self._body, self._s.fall, self._s.stance)
        self._sensors = SensorMonitor(self._s.sensors)
        self._sensed: SensorFrame | None = None
        """Frame of the present cycle, as `sense` gave it."""
        self._supplies = SupplyMonitor(self._body, self._s.temperature, self._s.battery)
        self._watchdog = Watchdog(self._s.watchdog)
        self._approach = Approach(self._s.approach, self._body.cycle)
        self._stream = CommandStream(self._body.cycle)
        self._guard_motion: Descent | SitDown | CloseStance | None = None
        """Motion without a command."""
        self._crouched: int | None = None
        """Cycles of rest in the crouch; None: it does not rest there."""
        self._lease: int | None = None
        self._blocked = 0
        """Cycles in which no command is taken."""
        self._reply_to = 0
        self._log.reset()

    @property
    def status(self) -> GuardStatus:
        """Answer to the query `guard`."""
        return self._log.status

    @property
    def state(self) -> State:
        """Its present state."""
        return self.status.state

    @property
    def armed(self) -> bool:
        """Commands are taken."""
        return self._log.armed

    @property
    def clipped(self) -> str:
        """One sentence on the clipped joint of the last `check`; empty: none."""
        return self._output.ranges.clipped

    @property
    def busy(self) -> bool:
        """It acts without a command; a robot in lockstep must not wait for answers meanwhile."""
        return self._guard_motion is not None or not self._requests.empty()

    @property
    def moves(self) -> bool:
        """The joints are under command, or on the way down."""
        return self.state in ("approach", "active", "hold", "crouch", "sit")

    @property
    def position(self) -> tuple[float, ...] | None:
        """25 positions put out last, rad; None: the joints are left alone."""
        return self._output.position

    @property
    def stiffness(self) -> tuple[float, ...] | None:
        """25 stiffnesses put out last; None: the joints are left alone."""
        return self._output.stiffness

    def stood_up(self, seq: int, posture: tuple[float, ...]) -> None:
        """End a fall or a rest of a robot put on its feet, stiff.

        No command is taken for `STAND_UP_HOLD`: the newest may still be for the fallen robot.

        Args:
            seq: of the present sensor frame.
            posture: 25 positions to hold, rad.
        """
        self._guard_motion = None
        self._watchdog.reset()
        self._output.set_position(self._output.ranges.clip(posture))
        self._output.stiffness = (1.0,) * N_JOINTS
        self._blocked = round(STAND_UP_HOLD / self._body.cycle)
        self._log.enter(seq, "idle", "", "The robot was put on its feet.")

    def laid_down(self, seq: int) -> None:
        """End the present motion of a robot put down limp, and leave it alone.

        No command is taken for `STAND_UP_HOLD`: the newest may still be for the standing robot.

        Args:
            seq: of the present sensor frame.
        """
        self._guard_motion = None
        self._watchdog.reset()
        self._output.stiffness = None
        self._blocked = round(STAND_UP_HOLD / self._body.cycle)
        self._log.enter(seq, "idle", "", "The robot was laid down.")

    def stop(self, how: Literal["crouch", "limp"], who: str = "") -> threading.Event:
        """Emergency stop at the next cycle; any thread may call this.

        Args:
            how: `crouch`: crouch, then release the joints; `limp`: release them at once.
            who: sender, for the notice.

        Returns:
            Set when the stop has begun.
        """
        return self._request(how, who)

    def arm(self, who: str = "") -> threading.Event:
        """Take commands from the next cycle on; any thread may call this. The event is set when it is done."""
        return self._request("arm", who)

    def _request(self, request: Literal["crouch", "limp", "arm"], who: str) -> threading.Event:
        done = threading.Event()
        self._requests.put((request, who, done))
        return done

    def take_notices(self) -> list[Notice]:
        """The notices since the last call: one per change of state, and warnings."""
        return self._log.take_notices()

    def take_revocation(self) -> bool:
        """Whether the lease is to be withdrawn since the last call: after silence or a stop."""
        revoke, self._revoke = self._revoke, False
        return revoke

    def sense(self, frame: SensorFrame) -> SensorFrame:
        """A new cycle's frame with the last good numbers in place of those that are not finite.

        `cycle` does this itself to a frame that is not from here.

        Args:
            frame: as read; an unreadable number is NaN.
        """
        if frame is not self._sensed:
            self._sensed = self._sensors.update(frame)
            for code, text in self._sensors.take_reports():
                self._log.add_notice(frame.seq, code, text, "info" if code == "sensor-readable" else "warning")
        return self._sensed

    def check(self, frame: ActuatorFrame, seq: int) -> ActuatorFrame:
        """The frame with its angles inside their ranges; the slots of absent joints become 0.

        Args:
            frame: as received.
            seq: of the robot's present sensor frame.

        Raises:
            FrameError: the robot is not armed; an element that is not finite, a stiffness outside -1..1, or an
                answer to a future frame.
        """
        if not self.armed:
            raise FrameError(f"ActuatorFrame refused: {self.status.text}")
        return self._output.ranges.check(frame, seq)

    def cycle(
        self,
        frame: SensorFrame,
        command: ActuatorFrame | None,
        *,
        supervised: bool = False,
        direct: bool = False,
    ) -> ActuatorFrame | None:
        """One cycle.

        Args:
            frame: of the present boundary; unreadable numbers may be NaN.
            command: newest one, as `check` returns it; None: none.
            supervised: the watchdog counts cycles without a command: a controller holds the robot, or died
                holding it.
            direct: the holder serves another robot's protocol, and an emulated robot follows it as that
                robot does: without an approach, a limit of the speed or a reaction to falls.

        Returns:
            The command put in force now; None: the one in force stays.
        """
        frame = self.sense(frame)
        self._handle_requests(frame)
        for text in self._supplies.update(frame):
            self._log.add_notice(frame.seq, "guard-warning", text)
        if self._fall.update(frame) and not direct and self.state not in ("idle", "rest"):
            self._release_joints(frame)
        elif self._fault and self.state in ("approach", "active", "hold"):
            self._revoke = self._revoke or self._fault == "sensors"
            self._descend(frame, self._fault)
        if command is None:
            self._stream.update(None)
        self._supervise(frame, command, supervised)
        self._blocked = max(self._blocked - 1, 0)
        if command is not None:
            self._reply_to = command.reply_to
            if self._takes_commands:
                return self._follow(frame, command, direct)
        self._sit_down_when_idle(frame)
        return self._advance_own_motion(frame)

    def accept_timed(self, seq: int) -> None:
        """Count a timed command (a DCM's), which is not in a frame, as a sign of life.

        Args:
            seq: of the newest sensor frame.

        Raises:
            FrameError: no command is taken now; gives the reason.
        """
        if not self._takes_commands:
            raise FrameError(f"A timed command was refused: {self.status.text}")
        self._watchdog.keepalive()
        self._guard_motion, self._output.stiffness = None, None
        if self.state != "active":
            self._log.enter(seq, "active", "")

    def timed_waiting(self) -> None:
        """Have the watchdog count from the end of the waiting timed commands."""
        self._watchdog.keepalive()

    def released(self, seq: int) -> None:
        """Hold the joints after a release of the lease.

        Args:
            seq: of the newest sensor frame.
        """
        if self.state in ("approach", "active"):
            if self._stream.in_quick_step:
                self._close(seq, "The controller gave the robot back in a quick step.")
            self._log.enter(seq, "hold", "", "The controller gave the robot back.")

    @property
    def _fault(self) -> Reason:
        """Fault of the robot for which no command is taken; empty: none."""
        return "sensors" if self._sensors.lost else self._supplies.fault

    @property
    def _takes_commands(self) -> bool:
        return self.armed and not self._fault and self._blocked == 0 and self.state != "sit"

    def _handle_requests(self, frame: SensorFrame) -> None:
        while not self._requests.empty():
            request, who, done = self._requests.get()
            by = f" by {who}" if who else ""
            self._log.armed = request == "arm"
            if request == "arm":
                event = f"The robot was armed{by}."
                self._log.enter(frame.seq, self.state, self.status.reason, event, "guard-armed")
            else:
                self._revoke = True
                self._log.add_notice(frame.seq, "guard-stop", f"Emergency stop ({request}){by}.")
                self._descend(frame, "stop", limp=request == "limp")
            done.set()

    def _supervise(self, frame: SensorFrame, command: ActuatorFrame | None, supervised: bool) -> None:
        """Carry out the watchdog's decision."""
        demand = self._watchdog.update(received=command is not None, supervised=supervised)
        if demand == "close" and self.state == "active" and self._stream.in_quick_step:
            self._close(frame.seq, "Commands broke off in a quick step.")
        elif demand in ("hold", "descend") and self.state in ("approach", "active"):
            self._log.enter(frame.seq, "hold", "silence")
        if demand == "descend" and (self.state == "hold" or (self.state == "fallen" and self._blocked == 0)):
            self._revoke = True
            self._descend(frame, "silence")

    def _close(self, seq: int, why: str) -> None:
        """End a quick step with the feet side by side."""
        output = self._output
        if output.position is not None and output.stiffness is not None:
            self._stream.reset()
            self._guard_motion = CloseStance(output.position, output.stiffness, self._body.cycle)
            self._log.add_notice(seq, "guard-close", f"{why} The feet are brought side by side.")

    def _descend(self, frame: SensorFrame, reason: Reason, *, limp: bool = False) -> None:
        """Crouch if the legs support the robot; otherwise release the joints."""
        if not limp and self.state == "active" and self._stream.in_quick_step:
            self._close(frame.seq, "The robot was in a quick step.")
            self._log.enter(frame.seq, "crouch", reason)
        else:
            self._log.enter(frame.seq, self._begin_descent(frame, limp=limp), reason)

    def _begin_descent(self, frame: SensorFrame, *, limp: bool = False) -> State:
        """Begin the descent from the present pose; the state during it."""
        settings, limp = self._s.crouch, limp or not self._sensors.pose_known
        if limp:
            settings = msgspec.structs.replace(settings, release_time=0.0)
        stiffness = self._output.stiffness or frame.stiffness
        standing = not limp and self.state != "fallen" and stands(self._body, frame, self._s.stance)
        start = self._output.start(frame, _WEAK_STIFFNESS)
        moving = standing and legs_stiff(stiffness)
        self._guard_motion = Descent(
            start, stiffness, self._crouch, settings, self._body.cycle, moving=moving, standing=standing
        )
        self._output.set_position(start)
        return "crouch" if moving else "rest"

    def _sit_down_when_idle(self, frame: SensorFrame) -> None:
        """Sit down after an idle time in the crouch; after a stop stay there."""
        if self.state != "rest" or self.status.reason not in ("silence", "battery"):
            self._crouched = 0 if self.state == "crouch" else None
        elif self._crouched is not None and self._motion is not None:
            self._crouched += 1
            if self._crouched * self._body.cycle >= self._s.sit.after and stands(
                self._body, frame, self._s.stance
            ):
                self._guard_motion = SitDown(self._motion, self._body, self._s.crouch)
                self._output.set_position(self._output.start(frame, _WEAK_STIFFNESS))
                self._log.enter(frame.seq, "sit", self.status.reason)

    def _release_joints(self, frame: SensorFrame) -> None:
        self._guard_motion = None
        self._output.set_position(self._output.ranges.clip(frame.position))
        self._output.stiffness = (self._s.fall.stiffness,) * N_JOINTS
        self._blocked = max(round(self._s.fall.rest_time / self._body.cycle), 1)
        self._log.enter(frame.seq, "fallen", "fall")

    def _follow(self, frame: SensorFrame, command: ActuatorFrame, direct: bool) -> ActuatorFrame:
        """Put a command in force, from the robot's present pose."""
        output, approach = self._output, self._approach
        begins = self.state not in ("approach", "active") or command.lease != self._lease
        start = output.start(frame, _WEAK_STIFFNESS if begins else 0.0)
        self._lease, self._guard_motion = command.lease, None
        if begins or direct:
            approach.clear()
        if not direct:
            stiffened = output.stiffened(command)
            travel = output.joint_travel(start, command)
            approach.begin(travel if begins else {slot: travel[slot] for slot in stiffened})
        output.set_position(command.position if direct else start)
        position = output.move_towards(command.position, approach.slots, self._s.approach.speed)
        self._report_approach(frame, begins)
        approach.advance(output.joint_travel(position, command))
        self._report_approach(frame)
        output.stiffness = command.stiffness
        upright = tilt(frame.angle) < self._s.fall.angle
        self._stream.update(position if upright else None)
        if position == command.position:
            return command
        return msgspec.structs.replace(command, position=position)

    def _report_approach(self, frame: SensorFrame, begins: bool = False) -> None:
        """Enter the state `approach` or `active`, if it is new or `begins`."""
        state: State = "approach" if self._approach.slots else "active"
        if begins or state != self.state:
            self._log.enter(frame.seq, state, "")

    def _advance_own_motion(self, frame: SensorFrame) -> ActuatorFrame | None:
        """The guard's own command to the joints, if any."""
        output = self._output
        if self._guard_motion is not None:
            position, output.stiffness = self._guard_motion.advance(frame)
            output.move_towards(output.ranges.clip(position))
            if self._guard_motion.done:
                closed, self._guard_motion = isinstance(self._guard_motion, CloseStance), None
                if closed and self.state == "crouch":
                    state = self._begin_descent(frame)
                else:
                    state = self.state if closed else "rest"
                if state != self.state:
                    self._log.enter(frame.seq, state, self.status.reason)
        elif output.stiffness is None or self._blocked == 0 or self.state not in ("fallen", "idle"):
            return None
        assert output.position is not None and output.stiffness is not None
        return ActuatorFrame(reply_to=self._reply_to, position=output.position, stiffness=output.stiffness)
