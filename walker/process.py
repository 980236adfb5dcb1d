"""The walker's process: everything around the controller that touches the link or the clock."""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable

import msgspec

from bridge.body import Body, body_of, load_body
from bridge.errors import ConfigurationError, FrameError, LeaseRefused, LinkError, RobotSilent
from bridge.guard import GuardSettings
from bridge.histogram import DurationHistogram
from bridge.link import ControllerLink, keys
from bridge.messages import ActuatorFrame, Info, SensorFrame, decode
from bridge.messages.guard import GuardStatus
from bridge.realtime import quiet_process
from bridge.types import Vec3
from walker.controller import Controller
from walker.gaits.catalogue import gait_kind
from walker.service import WalkService

logger = logging.getLogger(__name__)

SILENCE = 0.5
"""s without a sensor frame after which the walker looks whether the robot is still there."""
PATIENCE = 5.0
"""s without a robot after which the log says what is missing."""
_STANDBY = 1.0
"""s between two looks of a walker that stands by whether the robot is there and still the same."""
_RETRY = 0.2
"""s between two looks whether a robot was armed, or is free."""
GUARDED = GuardSettings().watchdog.silence_cycles + GuardSettings().watchdog.hold_cycles
"""Cycles without an answer after which a guard has the robot, whether or not its notice came through."""
MakeController = Callable[[Body, float], Controller]
"""Body and cycle time (s) to a controller at the beginning of its order."""


class WalkResult(msgspec.Struct, frozen=True, kw_only=True):
    """What the walker knows of its walk; the JSON of `nao-hil walk`."""

    body: str
    """Of the robot that was walked; empty: none was there."""
    state: str
    done: bool
    """The order was carried out to its end."""
    steps: int
    displacement: Vec3
    """By the odometry since the robot was taken: forward and to the left, m, and turn, rad."""
    fell: bool
    """By the fused torso angle."""
    fall_cause: str
    """Why the walker took the robot for falling, the last time; empty: never."""
    late: bool
    """Stopped because answers came later than the gait bears, see `walker.estimator`."""
    interruptions: int
    """How often the walk went on from a stand, or began anew, because the robot had no answer for too long."""
    ticks: int
    skipped: int
    """Sensor frames that came too fast to be answered, real time only."""
    tick_p50: float
    """s"""
    tick_p99: float
    """s"""


class WalkerProcess:
    """Runs a controller against whatever robot is at the other end of the link.

    Args:
        link: open link, controller side.
        make_controller: called anew for each start of the robot.
        body: name the robot must have; None takes the robot's word.
        stop: becomes true when the process is to end; a walk under way closes its feet first.
        priority: SCHED_FIFO priority to ask for against a robot in real time; None: none.
        service: hands over what the controller is told to do while it runs; None: nobody tells it.
    """

    def __init__(
        self,
        link: ControllerLink,
        make_controller: MakeController,
        body: str | None,
        stop: Callable[[], bool],
        priority: int | None = None,
        service: WalkService | None = None,
    ) -> None:
        self._priority = priority
        self._service = service
        self._link, self._make, self._body, self._stop = link, make_controller, body, stop
        self._controller: Controller | None = None
        self._ticks = DurationHistogram()
        self._skipped = self._interruptions = 0
        self._seq = -1
        self._late = self._dry_run = self._walked = self._closes = False
        self._boot: int | None = None
        self._found_boot: int | None = None
        """Of the robot that the log names."""
        self._walks = ""
        """Name of the robot's body."""
        self._taken = False
        """The guard, or another controller, took the robot from the walk."""
        self._last: ActuatorFrame | None = None
        self._warned_at = -math.inf
        self._gone: float | None = None
        """Since when the robot is gone; monotonic, s."""
        self._refusal = ""
        """Why the lease was refused last."""

    def run(self) -> WalkResult:
        """Walk until the order is done or the process is stopped.

        Raises:
            ConfigurationError: the robot is another body, or cannot walk the gait.
            LeaseRefused: another controller holds the robot; a walker that serves waits until it is free.
            FrameError: the robot speaks another version of the contract.
            LinkError: the robot was stopped in the walk.
        """
        logger.info("waiting for robot `%s` at %s", self._link.robot, self._link.endpoint)
        while not self._stop():
            info = self._found()
            if info is None:
                break
            if info.boot != self._boot:
                self._boot = info.boot
                self._controller = self._make(self._check_body(info), info.cycle)
                self._seq = -1
            if not self._taken and self._found_boot != info.boot:
                self._found_boot = info.boot
                logger.info("robot `%s` found: %s, %s", info.robot, info.body, info.mode)
            if info.mode == "real-time":
                quiet_process(
                    self._priority
                )  # it takes some cycles, which would be missed with the lease in hand
            if not self._wanted() or not self._armed():
                continue
            if self._taken:
                logger.warning("the robot had been taken from the walk, which begins anew")
                self._taken = False
            if not self._acquire():
                continue
            if self._gone is not None:
                logger.warning("the robot is back after %.1f s", time.monotonic() - self._gone)
                self._gone = None
            if self._serve(lockstep=info.mode == "lockstep"):
                self._link.release()
                break
        return self._result()

    def _found(self) -> Info | None:
        """The robot's `Info`; says after a while what it waits for. None when the process was stopped."""
        try:
            return self._link.wait_robot(self._stop, PATIENCE)
        except LinkError as error:
            logger.warning("%s Waiting for it.", error)
            return self._link.wait_robot(self._stop)

    def _wanted(self) -> bool:
        """Whether to hold the robot; a walker that stands by waits for that."""
        return self._service is None or self._service.wait_wanted(_STANDBY)

    def _armed(self) -> bool:
        """Wait until the robot takes commands; False when the process was stopped meanwhile.

        Raises:
            LinkError: it was stopped in the walk. Who arms it again does not ask for that walk to go on.
        """
        warned = False
        while not self._stop():
            try:
                status = decode(self._link.query(keys.GUARD), GuardStatus)
            except LinkError:
                return True  # no guard that could be asked
            self._dry_run = status.dry_run
            if status.dry_run:
                logger.warning(
                    "the robot's side only watches (--dry-run); what is asked of the joints is not done"
                )
            if status.armed:
                return True
            if self._walked and self._service is None:
                raise LinkError(f"{status.text} The walk has ended; arm the robot and walk again.")
            if not warned:
                logger.warning("%s Waiting for that.", status.text)
            warned = True
            time.sleep(_RETRY)
        return False

    def _acquire(self) -> bool:
        """Ask for the lease; False when the robot went away meanwhile.

        A walker that serves also says False, after a moment, when another controller has the robot.
        """
        try:
            self._link.acquire()
        except RobotSilent:
            return False
        except LeaseRefused as error:
            if self._service is None:
                raise
            if str(error) != self._refusal:
                logger.warning("%s The walker takes the robot when it is free.", error)
                self._refusal = str(error)
            self._service.lose_robot(self._refusal)
            time.sleep(_RETRY)
            return False
        self._refusal = ""
        return True

    def _serve(self, *, lockstep: bool) -> bool:
        """Answer frames until the order is done (True), or the robot is gone or the process stopped (False)."""
        controller = self._controller
        assert controller is not None
        receive = self._link.next if lockstep else self._link.latest
        while not self._ends():
            if self._service is not None and not self._service.wanted:
                self._link.release()
                self._boot = None
                self._service.note_left()
                return False
            if self._process_notices():
                self._interruptions += 1
                self._boot, self._taken = None, True
                return False
            try:
                asked = time.monotonic()
                frame = receive(SILENCE)
                if (stalled := time.monotonic() - asked - SILENCE) > SILENCE:
                    self._warn(
                        f"this process stood still for {stalled:.1f} s (suspended, or starved by other work)"
                    )
            except FrameError as error:
                self._warn(str(error))  # a stranger on the robot's key; the robot's own version was checked
                continue
            if not self._link.lease:
                if not self._stop():
                    logger.warning("the robot is gone; waiting for it to come back")
                    self._gone = time.monotonic()
                return False
            if frame is None:
                # a sign of life, so that a robot that pauses does not give the lease away
                if not self._acquire() and self._closes:
                    return False
            elif not lockstep and 0 <= self._seq < frame.seq - GUARDED:
                logger.warning(
                    "nothing was heard of the robot for %d cycles, in which its guard took it over; the walk "
                    "begins anew",
                    frame.seq - self._seq,
                )
                self._interruptions += 1
                self._boot = None
                return False
            elif frame.seq > self._seq:
                self._answer(controller, frame, lockstep)
                if controller.done:
                    return True
            elif frame.seq < self._seq:
                logger.warning("the robot began anew; so does the walk")
                self._boot = None
                return False
            elif lockstep and self._last is not None:
                self._link.send(self._last)  # the robot asks again: the answer was lost with an old lease
        return False

    def _ends(self) -> bool:
        """Whether to leave the robot now: the process was asked to end, and the feet are closed."""
        controller = self._controller
        if not self._stop():
            return False
        if controller is None or controller.state not in ("walk", "stopping"):
            return True
        if not self._closes:
            logger.info("closing the feet; a second Ctrl-C leaves the robot at once")
            controller.stop()
            self._closes = True
        return False

    def _answer(self, controller: Controller, frame: SensorFrame, lockstep: bool) -> None:
        if self._seq >= 0:
            self._skipped += frame.seq - self._seq - 1
        self._seq, self._walked = frame.seq, True
        if self._service is not None and not self._closes:
            self._service.before(controller, frame.seq)
        self._take_upper_body(controller)
        before, state = controller.interruptions, controller.state
        began = time.perf_counter()
        self._last = controller.tick(frame)
        tick = time.perf_counter() - began
        self._ticks.add(tick)
        if controller.state == "fallen" != state:
            logger.warning("the robot falls: %s", controller.fall_cause)
        if controller.interruptions > before:
            self._interruptions += 1
            logger.warning(
                "no answer reached the robot for over %.0f ms, more than the walk bears in mid-step: it goes "
                "on from a stand",
                1e3 * controller.walk.parameters.max_gap,
            )
        if not lockstep:
            self._check_delay(controller)
        if self._service is not None:
            self._service.after(controller, frame.seq)
        telemetry = controller.telemetry
        if lockstep:
            # First, so that it is there when the robot acts on the answer.
            self._link.publish(telemetry)
            self._link.send(self._last)
        else:
            self._link.send(self._last)
            self._link.publish(msgspec.structs.replace(telemetry, tick=tick))

    def _take_upper_body(self, controller: Controller) -> None:
        try:
            order = self._link.upper_body()
        except FrameError as error:
            self._warn(str(error))
            return
        if order is not None:
            controller.upper_body.take(order)

    def _check_delay(self, controller: Controller) -> None:
        """Close the feet on a link that is worse than a walk bears."""
        max_delay = gait_kind(controller.walk.gait.name).max_delay
        if not self._dry_run and controller.delay > max_delay and controller.state in ("approach", "walk"):
            self._late = True
            controller.stop()
            self._warn(
                f"answers reach the robot {1e3 * controller.delay:.0f} ms late, a walk bears "
                f"{1e3 * max_delay:.0f} ms: the feet are closed"
            )

    def _warn(self, sentence: str) -> None:
        now = time.monotonic()
        if now - self._warned_at >= 1.0:
            self._warned_at = now
            logger.warning("%s", sentence)

    def _process_notices(self) -> bool:
        """Pass on what the robot says; True when the walk cannot go on: its guard or another has the robot."""
        taken = False
        for notice in self._link.notices():
            logger.log(logging.DEBUG if notice.routine else logging.WARNING, "the robot says: %s", notice.text)
            taken = taken or notice.code in ("guard-crouch", "guard-sit", "guard-rest")
            if notice.code == "no-lease" and not taken:
                # ours may have been given to another while this process stood still
                taken = not self._acquire()
        return taken

    def _check_body(self, info: Info) -> Body:
        body = load_body(self._body) if self._body else body_of(info.body, info.sheet)
        self._walks = info.body
        if body.name != info.body:
            raise ConfigurationError(
                f"The robot at {self._link.endpoint} is a {info.body}, not a {body.name}; leave --robot out to "
                "walk whatever is there."
            )
        return body

    def _result(self) -> WalkResult:
        ticks = self._ticks.percentiles()
        controller = self._controller
        return WalkResult(
            body=self._walks,
            state=controller.state if controller else "waiting",
            steps=controller.telemetry.step if controller else 0,
            displacement=controller.odometry_pose if controller else (0.0, 0.0, 0.0),
            late=self._late,
            fell=controller is not None and controller.state == "fallen",
            fall_cause=controller.fall_cause if controller else "",
            done=controller is not None and controller.done and not self._late,
            ticks=ticks.count,
            interruptions=self._interruptions,
            skipped=self._skipped,
            tick_p50=ticks.p50,
            tick_p99=ticks.p99,
        )
