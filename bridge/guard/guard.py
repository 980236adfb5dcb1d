"""The guard of one robot: what a command must be, and what becomes of the robot without one.

One object for emulated and real robots. It reads no clock: it is told of each cycle, and counts them. The same
cycles give the same answers, so runs in process and in lockstep stay the same.
"""

from __future__ import annotations

import queue
import threading
from typing import Final, Literal

import msgspec

from bridge.datasheet import Body
from bridge.datasheet.postures import POSTURES
from bridge.datasheet.quantities import HANDS, absent_joints
from bridge.errors import FrameError
from bridge.guard.config import GuardSettings
from bridge.guard.descent import Descent
from bridge.guard.messages import GuardStatus, Reason, State
from bridge.guard.ranges import Ranges
from bridge.guard.speed import SpeedLimiter
from bridge.guard.stance import stands
from bridge.guard.vigilance import FallWatch, Supplies, legs_stiff
from bridge.guard.words import sentence
from bridge.joints import JOINTS, N_JOINTS
from bridge.messages import ActuatorFrame, Notice, SensorFrame

REACHED: Final = 0.01
"""rad; an approach this close to the command has arrived."""
_WEAK: Final = 0.2
"""A joint with less stiffness is where it is measured, not where it was last asked to be."""
STOOD_UP: Final = 0.15
"""s in which a robot that was put on its feet is held there, for its controller to notice; short, because the
controller moves on meanwhile."""
_DEFAULT: Final = GuardSettings()
_Request = tuple[Literal["crouch", "limp", "arm"], str, threading.Event]


class Guard:
    """Between whoever commands and the motors.

    Each cycle: `check` what came, then `cycle` with it or with None; what comes out goes to the motors.

    Args:
        body: data sheet: ranges, couplings, speeds.
        settings: bounds and times.
        armed: commands are taken from the start; False for real robots, until `arm`.
        dry_run: said in the status; whoever has the motors then sends them nothing.
    """

    def __init__(
        self, body: Body, settings: GuardSettings = _DEFAULT, *, armed: bool = True, dry_run: bool = False
    ) -> None:
        self._body, self._s, self._dry_run = body, settings, dry_run
        self._crouch = Ranges(body).clip(POSTURES[settings.crouch.posture])
        absent = absent_joints(body)
        self._turning = [i for i, j in enumerate(JOINTS) if j not in absent and j not in HANDS]
        self._requests: queue.SimpleQueue[_Request] = queue.SimpleQueue()
        self._notices: list[Notice] = []
        self._revoke = False
        self.armed = armed
        """Commands are taken."""
        self.reset()

    def reset(self) -> None:
        """The robot began anew (`seq` 0): all is forgotten but whether it is armed."""
        self._ranges = Ranges(self._body)
        self._limiter = SpeedLimiter(self._body, self._s.speed)
        self._fall = FallWatch(self._s.fall)
        self._supplies = Supplies(self._body, self._s.temperature, self._s.battery)
        self._descent: Descent | None = None
        self._stiffness: tuple[float, ...] | None = None
        self._lease: int | None = None
        self._silent: int | None = None
        self._down = 0
        self._reply_to = 0
        self.status = GuardStatus(
            seq=0, state="idle", armed=self.armed, dry_run=self._dry_run, text=sentence("idle", "", self.armed)
        )
        """As `guard` answers it."""

    @property
    def state(self) -> State:
        """What it is doing."""
        return self.status.state

    @property
    def clipped(self) -> str:
        """One sentence on what the last `check` had to clip; empty when nothing."""
        return self._ranges.clipped

    @property
    def busy(self) -> bool:
        """It has something to do without a command; a robot that waits for answers goes on meanwhile."""
        return self._descent is not None or not self._requests.empty()

    @property
    def moves(self) -> bool:
        """The joints are under command, or on the way down."""
        return self.state in ("approach", "active", "hold", "crouch")

    def stood_up(self, seq: int, posture: tuple[float, ...]) -> None:
        """Somebody put the robot on its feet, stiff: what was done about its fall or its rest is over.

        No command is taken for `STOOD_UP`: the newest may still be a fallen robot's.

        Args:
            seq: of the present sensor frame.
            posture: 25 positions it is held in, rad.
        """
        self._descent, self._silent = None, None
        self._limiter.last, self._stiffness = self._ranges_of(posture), (1.0,) * N_JOINTS
        self._down = round(STOOD_UP / self._body.cycle)
        self._enter(seq, "idle", "", "The robot was put on its feet.")

    @property
    def position(self) -> tuple[float, ...] | None:
        """25 positions put out last, rad; None: the joints are left alone."""
        return self._limiter.last if self._stiffness is not None else None

    @property
    def stiffness(self) -> tuple[float, ...] | None:
        """25 stiffnesses put out last."""
        return self._stiffness

    def stop(self, how: Literal["crouch", "limp"], who: str = "") -> threading.Event:
        """Emergency stop, at the next cycle; any thread may call this. The event is set when it has begun."""
        return self._ask(how, who)

    def arm(self, who: str = "") -> threading.Event:
        """Take commands from the next cycle on; any thread may call this. The event is set when it is done."""
        return self._ask("arm", who)

    def _ask(self, what: Literal["crouch", "limp", "arm"], who: str) -> threading.Event:
        done = threading.Event()
        self._requests.put((what, who, done))
        return done

    def take_notices(self) -> list[Notice]:
        """What has been said since the last call: one notice per change of state, and warnings."""
        notices, self._notices = self._notices, []
        return notices

    def take_revocation(self) -> bool:
        """Whether the lease is to be withdrawn since the last call: its holder was silent, or a stop came."""
        revoke, self._revoke = self._revoke, False
        return revoke

    def check(self, frame: ActuatorFrame, seq: int) -> ActuatorFrame:
        """The frame with its angles inside their ranges; the slots of absent joints become 0.

        Args:
            frame: as received.
            seq: of the robot's present sensor frame.

        Raises:
            FrameError: the robot is not armed; an element that is not finite, a stiffness outside -1..1, or an
                answer to a frame that was not sent yet.
        """
        if not self.armed:
            raise FrameError(f"ActuatorFrame refused: {self.status.text}")
        return self._ranges.check(frame, seq)

    def cycle(
        self, frame: SensorFrame, command: ActuatorFrame | None, *, owed: bool = False
    ) -> ActuatorFrame | None:
        """One cycle.

        Args:
            frame: of the present boundary.
            command: newest one, as `check` gave it; None: none has come.
            owed: the watchdog counts when none has come: somebody holds the robot, or died holding it.

        Returns:
            What is put in force now; None: what is in force stays.
        """
        self._heed_requests(frame)
        for text in self._supplies.update(frame):
            self._say(frame.seq, "guard-warning", text)
        if self._fall.update(frame) and self.state not in ("idle", "rest"):
            self._fall_down(frame)
        elif (self._supplies.hot or self._supplies.empty) and self.state in ("approach", "active", "hold"):
            self._go_down(frame, "temperature" if self._supplies.hot else "battery")
        self._watch(frame, command, owed)
        self._down = max(self._down - 1, 0)
        if command is not None:
            self._reply_to = command.reply_to
            if self._takes:
                return self._take(frame, command)
        return self._own(frame)

    def timed(self, seq: int) -> None:
        """Commands with times of their own (a DCM's) come beside the frames; the watchdog does not count them.

        Args:
            seq: of the newest sensor frame.

        Raises:
            FrameError: no command is taken now; says why.
        """
        if not self._takes:
            raise FrameError(f"A timed command was refused: {self.status.text}")
        self._silent, self._descent, self._stiffness = None, None, None
        if self.state != "active":
            self._enter(seq, "active", "")

    @property
    def _takes(self) -> bool:
        return self.armed and not self._supplies.hot and not self._supplies.empty and self._down == 0

    def _heed_requests(self, frame: SensorFrame) -> None:
        while not self._requests.empty():
            request, who, done = self._requests.get()
            by = f" by {who}" if who else ""
            self.armed = request == "arm"
            if request == "arm":
                self._enter(frame.seq, self.state, self.status.reason, f"The robot was armed{by}.")
            else:
                self._revoke = True
                self._say(frame.seq, "guard-stop", f"Emergency stop ({request}){by}.")
                self._go_down(frame, "stop", limp=request == "limp")
            done.set()

    def _watch(self, frame: SensorFrame, command: ActuatorFrame | None, owed: bool) -> None:
        """The watchdog."""
        if command is not None:
            self._silent = 0
        elif not owed:
            self._silent = None
        elif self._silent is not None:
            self._silent += 1
        dog = self._s.watchdog
        silent = self._silent or 0
        if not dog.enabled or silent < dog.silence:
            return
        if self.state in ("approach", "active"):
            self._enter(frame.seq, "hold", "silence")
        if silent >= dog.silence + dog.hold and (
            self.state == "hold" or (self.state == "fallen" and self._down == 0)
        ):
            self._revoke = True
            self._go_down(frame, "silence")

    def _go_down(self, frame: SensorFrame, reason: Reason, *, limp: bool = False) -> None:
        """Crouch if the robot stands by its legs; else let go where it is, of a crouched one not quite."""
        s = self._s.crouch
        stiffness = self._stiffness or frame.stiffness
        standing = not limp and self.state != "fallen" and stands(self._body, frame, self._s.stance)
        start = self._start_from(frame, _WEAK)
        moving = standing and legs_stiff(stiffness)
        if limp:
            s = msgspec.structs.replace(s, fade=0.0)
        self._descent = Descent(
            start, stiffness, self._crouch, s, self._body.cycle, moving=moving, standing=standing
        )
        self._limiter.last = start
        self._enter(frame.seq, "crouch" if moving else "rest", reason)

    def _fall_down(self, frame: SensorFrame) -> None:
        self._descent = None
        self._limiter.last = self._ranges_of(frame.position)
        self._stiffness = (self._s.fall.stiffness,) * N_JOINTS
        self._down = max(round(self._s.fall.rest / self._body.cycle), 1)
        self._enter(frame.seq, "fallen", "fall")

    def _take(self, frame: SensorFrame, command: ActuatorFrame) -> ActuatorFrame:
        """Put a command in force, from where the robot is."""
        begins = self.state not in ("approach", "active") or command.lease != self._lease
        start = self._start_from(frame, _WEAK if begins else 0.0)
        self._limiter.last, self._lease, self._descent = start, command.lease, None
        if begins or self._stiffens(command):
            far = self._distance(start, command) > self._s.approach.tolerance
            if begins or far:
                self._enter(frame.seq, "approach" if far else "active", "")
        slow = self._s.approach.speed if self.state == "approach" else None
        position = self._limiter.follow(command.position, slow)
        if self.state == "approach" and self._distance(position, command) <= REACHED:
            self._enter(frame.seq, "active", "")
        self._stiffness = command.stiffness
        if position == command.position:
            return command
        return msgspec.structs.replace(command, position=position)

    def _own(self, frame: SensorFrame) -> ActuatorFrame | None:
        """What the guard itself asks of the joints, if anything."""
        if self._descent is not None:
            position, self._stiffness = self._descent.advance()
            self._limiter.follow(self._ranges_of(position))
            if self._descent.done:
                self._descent = None
                if self.state != "rest":
                    self._enter(frame.seq, "rest", self.status.reason)
        elif self._down == 0 or self.state not in ("fallen", "idle"):
            return None
        assert self._limiter.last is not None and self._stiffness is not None
        return ActuatorFrame(reply_to=self._reply_to, position=self._limiter.last, stiffness=self._stiffness)

    def _start_from(self, frame: SensorFrame, weak: float) -> tuple[float, ...]:
        """25 positions a motion begins from: put out last, or measured for joints not stiffer than `weak`."""
        last, stiffness = self._limiter.last, self._stiffness
        if last is None or stiffness is None:
            return self._ranges_of(frame.position)
        free = [i for i in self._turning if stiffness[i] <= weak]
        if not free:
            return last
        start = list(last)
        for i in free:
            start[i] = frame.position[i]
        return self._ranges_of(start)

    def _stiffens(self, command: ActuatorFrame) -> bool:
        """Whether a joint that was free is not to be free any more."""
        old = self._stiffness or command.stiffness
        return any(old[i] <= 0.0 < command.stiffness[i] for i in self._turning)

    def _distance(self, start: tuple[float, ...], command: ActuatorFrame) -> float:
        """Farthest way of a joint that is not free, rad."""
        ways = (abs(start[i] - command.position[i]) for i in self._turning if command.stiffness[i] > 0.0)
        return max(ways, default=0.0)

    def _ranges_of(self, position: tuple[float, ...] | list[float]) -> tuple[float, ...]:
        said = self._ranges.clipped
        inside = self._ranges.clip(position)
        self._ranges.clipped = said
        return inside

    def _enter(self, seq: int, state: State, reason: Reason, why: str = "") -> None:
        text = " ".join(filter(None, (why, sentence(state, reason, self.armed))))
        self.status = GuardStatus(
            seq=seq, state=state, reason=reason, armed=self.armed, dry_run=self._dry_run, text=text
        )
        self._say(seq, f"guard-{state}", text, "info" if reason == "" else "warning")

    def _say(self, seq: int, code: str, text: str, level: str = "warning") -> None:
        self._notices.append(Notice(seq=seq, level=level, code=code, text=text))
